"""Dry friction at walls and in joints, for random scenes, and what a run with it must keep."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

import numpy as np

from chain_impact.scene.candidates import candidates
from chain_impact.scene.scene import Scene, with_values
from tests.draw import Draw

FORCE = 1e-9  # of the limit of friction: an excess that is round-off
ROUND_OFF = 1e-12  # of the chain's mass times a link length per second
SMALL = 1e-8  # of the weight of the chain, and of its mass times a link length per second squared


def rubbed(scene: Scene, draw: Draw, most_work: float) -> Scene:
    """The scene with friction at its walls, if they are not rigid, and in some joints.

    Args:
        scene: the scene.
        draw: random numbers.
        most_work: evaluations that the run may take, if that is less than its own limit.
    """
    contact, links = asdict(scene.contact), [asdict(link) for link in scene.chain.links]
    if contact["model"] != "newton_impact":
        contact["friction"] = draw.power(0.01, 3.0)
        contact["static_friction"] = contact["friction"] * draw.one((1.0, draw.real(1.0, 2.0)))
        for name in scene.half_planes:
            if draw.chance(0.2):
                own = {"friction": draw.power(0.01, 3.0)}
                contact["wall"][name] = {**(contact["wall"].get(name) or {}), **own}
    movable = range(0 if scene.chain.base == "pinned" else 1, len(links))
    dry = contact["model"] == "newton_impact" or draw.chance(0.4)
    for i in movable:
        if dry and draw.chance(0.6):
            links[i]["joint_friction"] = draw.power(1e-3, 10.0)
    solver = asdict(scene.solver)
    solver["work_limit"] = min(solver["work_limit"], most_work / min(1.0, scene.simulation.stop_time))
    return with_values(scene, {("chain", "links"): links, ("contact",): contact, ("solver",): solver})


def falls(scene: Scene, outputs: Any) -> Iterator[tuple[str, float, float, str]]:
    """That no impulse of a wall falls from one row to the next: kind, value, the most it may be, and what.

    It falls by no more than ten times the tolerance of its largest value, or round-off of a momentum.
    """
    mass, size = sum(link.mass for link in scene.chain.links), max(link.length for link in scene.chain.links)
    for c, (point, wall) in enumerate(candidates(scene)):
        if not scene.wall_names[wall].startswith("joint_"):  # those of a joint's two stops have signs
            impulse = outputs["impulse"][:, c]
            least = 10.0 * scene.solver.tolerance * float(np.abs(impulse).max()) + ROUND_OFF * mass * size
            fall = float((np.maximum.accumulate(impulse) - impulse).max())
            yield (
                "falls",
                fall,
                least,
                f"fall of the impulse of point {point} at {scene.wall_names[wall]} [N·s]",
            )


def friction_checks(scene: Scene, outputs: Any) -> Iterator[tuple[str, float, float, str]]:
    """What holds for friction at each row: kind, value, the most that it may be, and what that is."""
    if not scene.has_friction:
        return
    friction = outputs["friction"]
    size = max(link.length for link in scene.chain.links)
    mass = sum(link.mass for link in scene.chain.links)
    least = SMALL * mass * (np.hypot(*scene.gravity) + size) + state_errors(scene, outputs, size)
    excess = 0.0
    for c, (_, number) in enumerate(candidates(scene)):
        if number < len(scene.wall_names) and not scene.wall_names[number].startswith("joint_"):
            limit = _static(scene, scene.wall_names[number]) * np.maximum(outputs["force"][:, c], 0.0)
            excess = max(excess, float((np.abs(friction["force"][:, c]) - (1.0 + FORCE) * limit).max()))
    yield "cone", excess, least, "friction beyond its limit [N]"
    for i, link in enumerate(scene.chain.links):
        beyond = float(np.abs(friction["joint_moment"][:, i]).max()) - (1.0 + FORCE) * link.joint_friction
        yield (
            "joint friction",
            beyond,
            least * size,
            f"moment of friction in joint {i + 1} beyond its limit [N·m]",
        )
    shares = friction["sticking"] * (1.0 - friction["sticking"])
    yield "sticking", float(np.abs(shares).max(initial=0.0)), 0.0, "an output that is neither 0 nor 1"


def state_errors(scene: Scene, outputs: Any, size: float) -> float:
    """By how much forces at a row may be wrong [N], as the state that is interpolated there has errors.

    Those of positions, relative to a link length, of angles and of their rates are at most the tolerance:
    times the stiffness n F/δ of contacts, and that of springs and dampers in joints.
    """
    forces, depths = outputs["force"], outputs["penetration"]
    touching = depths > 0.0
    stiffness = (scene.contact.exponent or 1.0) * np.abs(forces[touching]) / depths[touching]
    joints = sum(link.joint_stiffness + link.joint_damping for link in scene.chain.links)
    return scene.solver.tolerance * (float(stiffness.max(initial=0.0)) * size + joints / size)


def _static(scene: Scene, name: str) -> float:
    """µ_s at a wall."""
    contact, own = scene.contact, scene.contact.wall.get(name)
    sliding, static = contact.friction, contact.static_friction
    if own is not None and own.friction is not None:
        sliding, static = own.friction, 0.0
    if own is not None and own.static_friction is not None:
        static = own.static_friction
    return max(sliding, static)
