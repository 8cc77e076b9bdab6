"""The instances and kernels of one commit for the scenes of against.py, pickled, on standard output.

The script runs in a separate process that imports the package of that commit.
"""

from __future__ import annotations

import pickle
import sys
from typing import Any

import numpy as np

from chain_impact.compilation.library import kernel_library
from chain_impact.scene.scene import Scene, load_scene, scene_from_dict, with_values

try:
    from chain_impact.compilation.signatures import SIGNATURES
except ImportError:  # an older commit
    SIGNATURES = dict.fromkeys(["initialize", "advance", "observe"])  # type: ignore
try:
    from chain_impact.variables.prepared import PreparedScene
except ImportError:  # an older commit
    from chain_impact.variables.model import Model as PreparedScene  # type: ignore

MOTION_COUNT = 60  # number of further motions of each scene, with other angles at the start


def chain(height: float) -> Scene:
    """Return ten links, folded and turning, that start at a height [m] above a floor."""
    wave = np.arange(10)
    return scene_from_dict(
        {
            "name": "Ten",
            "gravity": [0.0, -9.81],
            "chain": {"base": "free", "links": [{"length": 0.3, "mass": 1.0}] * 10},
            "box": {"x_min": 0.0, "x_max": 4.5, "y_min": 0.0, "y_max": height + 2.5},
            "contact": {"model": "flores", "stiffness": 1e8, "restitution": 0.6},
            "initial": {
                "position": [0.6, height],
                "angles": list(0.8 * np.sin(1.0 + 1.7 * wave)),
                "angular_velocities": list(1.5 * np.cos(2.3 * wave)),
            },
        },
        "ten",
    )


def scenes() -> dict[str, tuple[Scene, float]]:
    """Return name → scene and stop time [s]."""
    box = load_scene("four_link_box")

    def changed(**changes: object) -> Scene:
        tables = {name: "solver" if name in {"tolerance", "method"} else "contact" for name in changes}
        return with_values(box, {(tables[name], name): value for name, value in changes.items()})

    return {
        "box, 1e-8": (changed(tolerance=1e-8), 1.2),
        "box, 1e-4": (changed(tolerance=1e-4), 1.2),
        "flight": (changed(tolerance=1e-8), 0.45),
        "coming to rest": (changed(model="flores", restitution=0.1, tolerance=1e-6), 10.0),
        "implicit": (changed(method="implicit", tolerance=1e-5), 1.0),
        "newton_impact": (changed(model="newton_impact", restitution=0.3), 3.0),
        "rod": (load_scene("rod_drop"), 0.6),
        "heap of ten": (chain(1.5), 1.5),
        "flight of ten": (chain(51.5), 1.0),
    }


def varied(scene: Scene) -> list[Scene]:
    """Return MOTION_COUNT copies of the scene whose angles at the start differ by about 0.02 rad."""
    angles, chance = np.asarray(scene.initial.angles), np.random.default_rng(0)
    changes = 0.02 * chance.standard_normal((MOTION_COUNT, len(angles)))
    return [with_values(scene, {("initial", "angles"): tuple(angles + change)}) for change in changes]


def main() -> None:
    """Write name of a scene → stop time, kernel, new instances as bytes, and places in an instance [byte]."""
    sides = {}
    # the names of these functions differ between commits, but begin with the same verbs
    functions = [
        next(f for f in SIGNATURES if f.startswith(verb)) for verb in ("initialize", "advance", "observe")
    ]
    for name, (scene, stop) in scenes().items():
        block, *other_blocks = (PreparedScene(start).new_instance() for start in (scene, *varied(scene)))
        fields: Any = block.dtype.fields
        places = [fields[record][:2] for record in ("output", "statistics")]
        counts, offset = fields["statistics"][:2]
        sides[name] = {
            "stop": stop,
            "functions": functions,
            "library": str(kernel_library(len(scene.chain.links))),
            "instance": block.tobytes(),
            "varied": [other_block.tobytes() for other_block in other_blocks],
            "compared": [(begin, begin + kind.itemsize) for kind, begin in places],
            "evaluations": offset + counts.fields["rhs_evaluations"][1],
        }
    pickle.dump(sides, sys.stdout.buffer)


if __name__ == "__main__":
    main()
