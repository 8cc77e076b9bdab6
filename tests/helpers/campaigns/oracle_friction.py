"""Checks of dry friction in a run, for the random search (oracle.py)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from chain_impact.scene.candidates import candidates_of
from chain_impact.scene.scene import Scene

if TYPE_CHECKING:
    from tests.helpers.campaigns.oracle import Row

FORCE = 1e-9  # largest excess of friction that is round-off, over the limit of friction
SMALL = 1e-8  # over the weight of the chain, and over its mass times one link length per second squared


def friction_checks(scene: Scene, outputs: Any) -> Iterator[Row]:
    """Yield kind, value, bound and words of each check of friction over all rows; none without friction."""
    if not scene.has_friction:
        return
    friction = outputs["friction"]
    size = max(link.length for link in scene.chain.links)
    mass = sum(link.mass for link in scene.chain.links)
    least = SMALL * mass * (np.hypot(*scene.gravity) + size) + state_errors(scene, outputs, size)
    excess = 0.0
    for c, (_, number) in enumerate(candidates_of(scene)):
        if number < len(scene.wall_names) and not scene.wall_names[number].startswith("joint_"):
            limit = _static(scene, scene.wall_names[number]) * np.maximum(outputs["force"][:, c], 0.0)
            excess = max(excess, float((np.abs(friction["force"][:, c]) - (1.0 + FORCE) * limit).max()))
    yield "cone", excess, least, "friction beyond its limit [N]"
    for i, link in enumerate(scene.chain.links):
        most = float(np.abs(friction["drive_friction"][:, i]).max())
        beyond = most - (1.0 + FORCE) * link.joint_friction
        yield (
            "joint friction",
            beyond,
            least * size,
            f"moment of friction in joint {i + 1} beyond its limit [N·m]",
        )
    shares = friction["sticking"] * (1.0 - friction["sticking"])
    yield "sticking", float(np.abs(shares).max(initial=0.0)), 0.0, "an output that is neither 0 nor 1"


def state_errors(scene: Scene, outputs: Any, size: float) -> float:
    """Return the possible errors of forces at a row [N], because the interpolated state has errors.

    The errors of positions, over a link length, of angles and of their rates are at most the tolerance. These
    errors are multiplied by the stiffness n F/δ of contacts, and by that of springs and dampers in joints.
    """
    forces, depths = outputs["force"], outputs["penetration"]
    touching = depths > 0.0
    stiffness = (scene.contact.exponent or 1.0) * np.abs(forces[touching]) / depths[touching]
    joints = sum(link.joint_stiffness + link.joint_damping for link in scene.chain.links)
    return scene.solver.tolerance * (float(stiffness.max(initial=0.0)) * size + joints / size)


def _static(scene: Scene, name: str) -> float:
    """Return µ_s at a wall."""
    contact, own = scene.contact, scene.contact.wall.get(name)
    sliding, static = contact.friction, contact.static_friction
    if own is not None and own.friction is not None:
        sliding, static = own.friction, 0.0
    if own is not None and own.static_friction is not None:
        static = own.static_friction
    return max(sliding, static)
