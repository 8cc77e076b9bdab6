"""Random chains with dry friction at a wall and in their joints, many with slow torques: a campaign.

``python -m tests.helpers.campaigns.arches`` runs them for ten seconds of simulated time, or for the time
``--lasting``. For each kind the command prints how many runs end early, and with which status. In these
scenes the constraints of sticking elements often depend on each other: a flat arch stands on both tips, a
chain lies on all its points.
"""

from __future__ import annotations

import argparse
import math
from collections import Counter
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from chain_impact import Result, SimulationError, simulate
from chain_impact.kernel.status import STATUS_NAME
from chain_impact.scene.scene import scene_from_dict
from tests.helpers.campaigns.random_parts import Draw

KINDS = ("arch", "slope", "floor", "rod")
LAWS = ("zhang_sharf", "flores", "tsuji")
Signal = Callable[[Any], Any]


def links_of(draw: Draw, kind: str) -> list[dict[str, float]]:
    """Return links of equal lengths and masses, or of unequal ones.

    All joints of arches have dry friction, and many joints of other chains.
    """
    low, high = {"arch": (2, 4), "slope": (1, 5), "floor": (1, 5), "rod": (1, 1)}[kind]
    count, equal = draw.whole(low, high), draw.chance(0.5)
    length, mass, moment = draw.real(0.2, 0.6), draw.power(0.3, 3.0), draw.power(0.02, 8.0)
    links = []
    for i in range(count):
        link = {"length": length, "mass": mass}
        if not equal:
            link = {"length": draw.real(0.2, 0.6), "mass": draw.power(0.3, 3.0)}
        if i > 0 and (kind == "arch" or draw.chance(0.6)):
            link["joint_friction"] = moment if equal else draw.power(0.02, 8.0)
        if i > 0 and draw.chance(0.3):
            link["joint_damping"] = draw.power(0.01, 3.0)
        if i > 0 and draw.chance(0.3):
            link["joint_stiffness"] = draw.power(0.1, 30.0)
        links.append(link)
    return links


def table_of(draw: Draw, kind: str) -> dict[str, Any]:
    """Return the table of a scene: a chain falls on a rough floor or slope; arches are nearly flat.

    Some rods have a wall beside them.
    """
    links = links_of(draw, kind)
    friction, steep = draw.power(0.05, 1.6), 0.6 if kind == "arch" else 1.5
    contact: dict[str, Any] = {
        "model": draw.one(LAWS),
        "stiffness": draw.power(1e4, 1e8),
        "restitution": draw.real(0.1, 0.8),
        "friction": friction,
    }
    if draw.chance(0.3):
        contact["static_friction"] = friction * draw.real(1.0, 1.5)
    reach = sum(link["length"] for link in links)
    table = {
        "name": "Arch",
        "chain": {"links": links},
        "contact": contact,
        "initial": {
            "position": [0.0, reach + 0.2],
            "angles": [draw.real(-steep, steep) for _ in links],
            "angular_velocities": [draw.real(-3.0, 3.0) for _ in links],
        },
        "simulation": {"stop_time": 10.0, "step_size": 0.05},
        "inputs": {"joint_torques": len(links) > 1},
    }
    if kind == "slope":
        table["walls"] = [{"name": "slope", "point": [0.0, 0.0], "angle": draw.real(-0.6, 0.6)}]
        table["initial"]["position"][1] *= 1.7
    else:
        table["box"] = {"y_min": 0.0} | ({"x_min": -0.5} if kind == "rod" and draw.chance(0.5) else {})
    return table


def torques_of(draw: Draw, kind: str, count: int) -> dict[str, Signal]:
    """Return slow torques in most joints of arches, and of half of the other chains, as functions of time."""
    if not (kind == "arch" or draw.chance(0.5)):
        return {}
    return {
        f"joint[{i}].torque": partial(
            lambda t, size, rate, phase: size * np.sin(rate * t + phase),
            size=draw.power(0.05, 12.0),
            rate=draw.power(0.3, 12.0),
            phase=draw.real(0.0, math.tau),
        )
        for i in range(2, count + 1)
        if draw.chance(0.7)
    }


def run(kind: str, seed: int, **options: Any) -> Result:
    """Return the result of the scene of a kind with a seed; ``options`` are those of ``simulate``."""
    draw = Draw(seed, KINDS.index(kind))
    table = table_of(draw, kind)
    scene = scene_from_dict(table, f"{kind} {seed}")
    return simulate(scene, inputs=torques_of(draw, kind, len(table["chain"]["links"])), **options)


def main() -> None:
    """Run the campaign, and print which runs end early."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("kinds", nargs="*", default=[], help=f"of {', '.join(KINDS)}; all of them")
    parser.add_argument("--count", type=int, default=750, help="scenes of each kind")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--lasting", type=float, default=10.0, help="simulated time [s]")
    options = parser.parse_args()
    for kind in options.kinds or KINDS:
        ends, early = Counter[str](), []
        for seed in range(options.first, options.first + options.count):
            try:
                run(kind, seed, stop_time=options.lasting, output_step=math.inf, output=[])
                ends["ok"] += 1
            except SimulationError as error:
                name = STATUS_NAME[error.status]
                ends[name] += 1
                early.append(f"  {kind} {seed}: {name} at {error.time:.6g} s")
        print(f"{kind}: {dict(ends)}", *early, sep="\n", flush=True)


if __name__ == "__main__":
    main()
