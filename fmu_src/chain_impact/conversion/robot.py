"""A robot in the form of its file: a tree of bodies in space, before the conversion to a planar chain."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from chain_impact.conversion.differences import Difference


def identifier(name: str, prefix: str) -> str:
    """Return a name of letters, digits and _.

    The prefix is put before a digit at the beginning, and in place of an empty name.
    """
    plain = re.sub(r"\W+", "_", name, flags=re.ASCII)
    return plain if re.match(r"[A-Za-z_]", plain) else f"{prefix}_{plain}"


@dataclass(frozen=True, kw_only=True)
class Joint:
    """A joint between a body and its parent. Angles count from the pose that the file gives.

    Attributes:
        name: the name in the file.
        kind: ``hinge``, ``slide`` or another kind that no scene has.
        axis: direction of the joint's axis, in the body's axes.
        anchor: a point on the axis, in the body's axes [m].
        low: least angle [rad] or position [m]; −∞ without a limit.
        high: largest angle or position; ∞ without a limit.
        damping: [N·m·s/rad]; for a slide [N·s/m], and the other units in the same way.
        stiffness: [N·m/rad].
        rest: angle at which the spring has no moment [rad].
        friction: dry friction [N·m].
        armature: [kg·m²].
        torque_limit: [N·m]; None without a limit.
        start: angle [rad] or position [m] at the start.
        speed: rate of the angle or position at the start.
        turn: rotation at the start of a ball joint, shape (3, 3); None for other joints.
        inputs: keys of ``[inputs]`` that the joint's drives need.
        drives: names of the drives.
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


class JointKey(NamedTuple):
    """The names of one quantity of joints.

    Attributes:
        link: the key of a link.
        slider: the key of a slider; "" if a slider has no such key.
        attribute: the attribute of MJCF; "" if the attribute has another form.
    """

    link: str
    slider: str
    attribute: str = ""


JOINT_KEYS = {
    "damping": JointKey("joint_damping", "damping", "damping"),
    "stiffness": JointKey("joint_stiffness", "stiffness", "stiffness"),
    "rest": JointKey("joint_rest_angle", "rest_position", "springref"),
    "friction": JointKey("joint_friction", "friction", "frictionloss"),
    "armature": JointKey("joint_armature", "", "armature"),
    "torque_limit": JointKey("joint_torque_limit", "force_limit"),
    "low": JointKey("joint_min", "min"),
    "high": JointKey("joint_max", "max"),
}
"""Attribute of ``Joint`` → its names. The armature of a sliding base is part of the carriage's mass."""


def scene_values(joint: Joint, rest: float, low: float, high: float) -> dict[str, float]:
    """Return the values of a joint that a scene has: attribute of ``Joint`` → value.

    Args:
        joint: the joint.
        rest: the angle or position in the scene at which the joint's spring has no moment [rad or m].
        low: its least angle or position in the scene; −∞ without a stop.
        high: its largest angle or position in the scene; ∞ without a stop.
    """
    # 0 is replaced by None, because it is the default of a scene
    values = {key: getattr(joint, key) or None for key in JOINT_KEYS}
    values |= {"rest": rest if joint.stiffness else None, "torque_limit": joint.torque_limit}
    values |= {"low": low, "high": high}
    return {key: value for key, value in values.items() if value is not None and math.isfinite(value)}


@dataclass(frozen=True, kw_only=True)
class LinkShape:
    """A shape of a body, which may touch other shapes or is only visible.

    Attributes:
        kind: the kind of shape, such as ``capsule``.
        touches: whether the shape can touch anything.
        name: a name of letters, digits and _, or empty.
        walls: whether the shape can touch a plane that does not move.
        is_point: whether the shape is a point of a scene, also if other points lie further out.
        corners: points of the body [m], shape (n, 3); the shape is the convex hull of balls around these
            points.
        radius: radius of the balls [m].
        disc: None for balls. If discs replace the balls, as for a cylinder: a vector along the axis of the
            discs, as long as the discs' radius [m].
    """

    kind: str
    touches: bool
    name: str = ""
    walls: bool = False
    is_point: bool = False
    corners: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    radius: float = 0.0
    disc: np.ndarray | None = None


def outline(kind: str, sizes: np.ndarray) -> tuple[np.ndarray, float, np.ndarray | None]:
    """Return corners, radius and disc (see ``LinkShape``) of a shape about its own centre.

    Args:
        kind: sphere, capsule or cylinder; any other kind is replaced by a box.
        sizes: radius of a sphere; radius and half the length along z of a capsule or cylinder; half the sides
            of a box [m].
    """
    ends = np.outer([-1.0, 1.0], [0.0, 0.0, 1.0])
    if kind == "sphere":
        return np.zeros((1, 3)), float(sizes[0]), None
    if kind == "capsule":
        return sizes[1] * ends, float(sizes[0]), None
    if kind == "cylinder":
        return sizes[1] * ends, 0.0, np.array([0.0, 0.0, sizes[0]])
    signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
    return signs * sizes, 0.0, None


@dataclass(frozen=True, kw_only=True)
class Body:
    """A rigid body.

    Attributes:
        name: the name in the file.
        parent: index of the parent in ``Robot.bodies``, −1 for the world.
        rotation: rotation of the body's axes relative to the parent's axes, shape (3, 3).
        position: position of the body's origin in the parent [m].
        mass: [kg].
        center: centre of mass in the body's axes [m].
        inertia: inertia about the centre of mass in the body's axes, shape (3, 3) [kg·m²].
        joints: the joints, in the order in which they act.
        frames: named points [m] in the body's axes, of which one may be the tip.
        shapes: the shapes of the body.
        borne: part of the weight that the file compensates.
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
    shapes: Sequence[LinkShape] = ()
    borne: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Plane:
    """A plane that does not move; its normal points to the free side.

    Attributes:
        name: the name in the file.
        point: a point on the plane [m].
        normal: unit vector.
        touching: indices of the bodies that can touch the plane, with the friction of each.
    """

    name: str
    point: np.ndarray
    normal: np.ndarray
    touching: Sequence[tuple[int, float]]


@dataclass(frozen=True, kw_only=True)
class Robot:
    """A tree of bodies, parents first.

    Attributes:
        name: the name of the model.
        bodies: the bodies.
        gravity: [m/s²].
        planes: the planes that do not move.
        carried: the data of the scene from which this package wrote the file; None for other files.
        notes: sentences on how the file was read.
        differences: the parts of the file that no scene has, or only in another form.
    """

    name: str
    bodies: Sequence[Body]
    gravity: np.ndarray
    planes: Sequence[Plane] = ()
    carried: dict[str, Any] | None = None
    notes: Sequence[str] = ()
    differences: Sequence[Difference] = ()
