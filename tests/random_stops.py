"""Stops in joints and walls of different materials, for random scenes."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

from chain_impact.scene.scene import Scene, with_values
from tests.draw import Draw


def stopped(scene: Scene, draw: Draw, law: dict[str, Any], most_work: float) -> Scene:
    """The scene with stops in some joints around their start, and materials of their own for some walls.

    Args:
        scene: the scene.
        draw: random numbers.
        law: a table [contact], whose law the stops have, if not that of the walls.
        most_work: evaluations that the run may take, if that is less than its own limit.
    """
    angles, before = scene.initial.angles, (0.0, *scene.initial.angles)
    links, pinned = [asdict(link) for link in scene.chain.links], scene.chain.base == "pinned"
    every = draw.chance(0.5)
    movable = range(0 if pinned else 1, len(links))
    for i in movable:
        if every or draw.chance(0.5) or i == movable[-1]:
            _stops(draw, links[i], angles[i] - before[i])
    contact = asdict(scene.contact)
    for name in scene.half_planes:
        if draw.chance(0.4):
            changed = {"stiffness": contact["stiffness"] * draw.power(0.1, 10.0)} if draw.chance(0.7) else {}
            if not changed or draw.chance(0.5):
                changed["restitution"] = draw.real(0.01, 1.0)
            contact["wall"][name] = changed
    stops = {key: law[key] for key in ("model", "exponent", "restitution")} if draw.chance(0.7) else {}
    stops |= {"stiffness": draw.power(1e1, 1e8), "minimum_impact_speed": draw.power(1e-6, 1e-1)}
    solver = asdict(scene.solver)
    solver["work_limit"] = min(solver["work_limit"], most_work / min(1.0, scene.simulation.stop_time))
    changes = {("chain", "links"): links, ("contact",): contact, ("solver",): solver}
    return with_values(scene, changes | ({("stops",): stops} if movable else {}))


def _stops(draw: Draw, link: dict[str, Any], angle: float) -> None:
    """Give a joint one stop or two, at or around the angle at which it starts."""
    margin = draw.power(1e-3, 3.0) if draw.chance(0.8) else 0.0
    kind = draw.one(("joint_min", "joint_max", "both"), (0.25, 0.25, 0.5))
    if kind != "joint_max":
        link["joint_min"] = min(angle, max(angle - margin, -math.tau))
    if kind != "joint_min":
        link["joint_max"] = max(angle + 1e-3, min(angle + draw.power(1e-3, 3.0), math.tau))
