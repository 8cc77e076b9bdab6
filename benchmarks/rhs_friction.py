"""Cost of one right-hand side with dry friction: ``python benchmarks/rhs_friction.py``.

A chain lies straight on a floor with its tip: without friction, while the tip slides, and while it sticks.
Each is evaluated on its record, as it is in a step of its run, in code compiled as the kernel is
(rhs_share.py).
"""

from __future__ import annotations

import common  # isort: skip

import numpy as np
from rhs_share import load

from chain_impact.scene.scene import Scene, scene_from_dict
from chain_impact.simulation.instance import Instance

SIZES = (4, 10)
COEFFICIENTS = {"no friction": 0.0, "slides": 0.01, "sticks": 5.0}
TIME = 0.1  # s, at which the tip touches the floor in all three runs
CALLS, ROUNDS = 20000, 15


def lying(links: int, friction: float) -> Scene:
    """A straight chain that is level, and whose tip may touch the floor."""
    given = {"friction": friction} if friction else {}
    return scene_from_dict(
        {
            "name": "Lying",
            "chain": {"links": [{"length": 0.5, "mass": 1.0}] * links},
            "box": {"y_min": 0.0},
            "contact": {"stiffness": 1e5, "restitution": 0.5, "points": [links]} | given,
            "initial": {"position": [0.0, 0.0], "angles": [0.0] * links},
            "solver": {"method": "explicit"},
            "simulation": {"stop_time": 2.0 * TIME, "step_size": TIME},
        },
        "lying",
    )


def measure(links: int) -> dict:
    """Time the three for a number of links."""
    instances = {name: Instance(lying(links, friction)) for name, friction in COEFFICIENTS.items()}
    for name, instance in instances.items():
        instance.trajectory(np.array([TIME]), np.zeros(1, instance.record.dtype["output"]))
        mode = instance.record["friction"]
        assert instance.record["touch"]["active_count"] == 1
        assert (mode["count"], mode["stuck_count"]) == (name != "no friction", name == "sticks")
    rates = load(links).share_rates
    timings = common.interleave(
        {name: (lambda one=one: rates(one._address, CALLS)) for name, one in instances.items()}, ROUNDS
    )
    timings = {name: [value / CALLS for value in row] for name, row in timings.items()}
    result = {"links": links, "nanoseconds": {}, "ratio": {}}
    for name, row in timings.items():
        result["nanoseconds"][name] = common.median([1e9 * value for value in row])
        result["ratio"][name] = common.ratio(timings, name, "no friction")
    print(result)
    return result


def main() -> None:
    """Measure, print and save."""
    started = common.environment()
    results = [measure(links) for links in SIZES]
    settings = {"rounds": ROUNDS, "calls in a loop": CALLS, "compiled for": common.PORTABLE_CPU}
    common.save("rhs_friction", started, settings, results)


if __name__ == "__main__":
    main()
