"""A robot as its file has it: a tree of bodies in space, before it is made a planar chain."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from chain_impact.conversion.differences import Difference


def identifier(name: str, prefix: str) -> str:
    """A name of letters, digits and _ that does not begin with a digit, but with a prefix if it would."""
    plain = re.sub(r"\W+", "_", name, flags=re.ASCII)
    return plain if re.match(r"[A-Za-z_]", plain) else f"{prefix}_{plain}"


@dataclass(frozen=True, kw_only=True)
class Joint:
    """What a body can do relative to the one before it. Angles count from the pose that the file gives.

    Attributes:
        name: as in the file.
        kind: ``hinge``, ``slide`` or another that no scene has.
        axis: its direction, in the axes of the body.
        anchor: a point on it [m], likewise.
        low: least angle [rad] or position [m], −∞ if there is none.
        high: largest one.
        damping: [N·m·s/rad], of a slide [N·s/m], and so on.
        stiffness: [N·m/rad].
        rest: angle at which the spring is slack [rad].
        friction: dry friction [N·m].
        armature: [kg·m²].
        torque_limit: [N·m], None if there is none.
        start: angle [rad] or position [m] at the start.
        speed: its rate at the start.
        turn: of a joint that is neither hinge nor slide: its rotation at the start, shape (3, 3).
        inputs: what of ``[inputs]`` its drives ask for.
        drives: their names.
    """

    name: str
    kind: str
    axis: np.ndarray
    anchor: np.ndarray
    low: float = -math.inf
    high: float = math.inf
    damping: float = 0.0
    stiffness: float = 0.0
    rest: float = 0.0
    friction: float = 0.0
    armature: float = 0.0
    torque_limit: float | None = None
    start: float = 0.0
    speed: float = 0.0
    turn: np.ndarray | None = None
    inputs: frozenset[str] = frozenset()
    drives: Sequence[str] = ()


@dataclass(frozen=True, kw_only=True)
class Shape:
    """A shape of a body, which touches or is only seen.

    Attributes:
        kind: as ``capsule``.
        touches: whether it can touch anything.
        name: of letters, digits and _, or empty.
        walls: whether it can touch a plane that does not move.
        corners: points of the body [m], shape (n, 3); the shape is the hull of balls about them.
        radius: of the balls [m].
        disc: of a hull of discs in place of balls: the axis of the discs, as long as their radius [m].
    """

    kind: str
    touches: bool
    name: str = ""
    walls: bool = False
    corners: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    radius: float = 0.0
    disc: np.ndarray | None = None


@dataclass(frozen=True, kw_only=True)
class Body:
    """A rigid body.

    Attributes:
        name: as in the file.
        parent: position of the body before it in ``Robot.bodies``, −1 for the world.
        rotation: of its axes relative to those of its parent, shape (3, 3).
        position: of its origin in its parent [m].
        mass: [kg].
        center: centre of mass, in its own axes [m].
        inertia: about the centre of mass, in its own axes, shape (3, 3) [kg·m²].
        joints: in the order in which they act.
        frames: named points [m] in its own axes, of which one may be the tip.
        shapes: what of it can touch or be seen.
        borne: part of its weight that something else than the joints bears.
    """

    name: str
    parent: int
    rotation: np.ndarray
    position: np.ndarray
    mass: float = 0.0
    center: np.ndarray
    inertia: np.ndarray
    joints: Sequence[Joint] = ()
    frames: Sequence[tuple[str, np.ndarray]] = ()
    shapes: Sequence[Shape] = ()
    borne: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Plane:
    """A plane that does not move: its free side is where its normal points.

    Attributes:
        name: as in the file.
        point: on it [m].
        normal: of length 1.
        friction: with whatever touches it.
        touching: positions of the bodies that can touch it, and the friction with each; None: all can.
    """

    name: str
    point: np.ndarray
    normal: np.ndarray
    friction: float = 0.0
    touching: Sequence[tuple[int, float]] | None = None


@dataclass(frozen=True, kw_only=True)
class Robot:
    """A tree of bodies, parents first.

    Attributes:
        name: of the model.
        bodies: see above.
        gravity: [m/s²].
        planes: walls.
        tables: tables of a scene that the file carries.
        first_link: what link 1 has as a joint, which has no effect where the base is free.
        link_tables: what the file carries of the points and the shape of each link, as a scene file has it.
        notes: how the file was read, a sentence each.
        differences: what of the file no scene can hold.
    """

    name: str
    bodies: Sequence[Body]
    gravity: np.ndarray
    planes: Sequence[Plane] = ()
    tables: dict[str, Any] = field(default_factory=dict)
    first_link: dict[str, float] = field(default_factory=dict)
    link_tables: Sequence[dict[str, Any]] = ()
    notes: Sequence[str] = ()
    differences: Sequence[Difference] = ()
