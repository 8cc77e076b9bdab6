"""A robot as its file describes it: a tree of bodies in space, before the conversion to a planar chain."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from chain_impact.conversion.differences import Difference


def identifier(name: str, prefix: str) -> str:
    """Return ``name`` with one _ in place of each sequence of characters other than ASCII letters, digits, _.

    If the result begins with a digit or is empty, ``prefix`` and _ come before it.
    """
    plain = re.sub(r"\W+", "_", name, flags=re.ASCII)
    return plain if re.match(r"[A-Za-z_]", plain) else f"{prefix}_{plain}"


@dataclass(frozen=True, kw_only=True)
class Joint:
    """A joint between a body and the parent of the body.

    The angle of a hinge, or the position of a slide, is 0 in the pose of the file's elements. Where two units
    are given, the first is for a hinge, and the second for a slide.

    Attributes:
        name: the name in the file, or the number of the joint.
        kind: ``hinge``, ``slide`` or another kind that no scene has.
        axis: unit vector along the joint's axis, in the axes of the body.
        anchor: a point on the joint's axis, in the axes of the body [m].
        low: least angle or position [rad or m]; −∞ without a limit.
        high: largest angle or position [rad or m]; ∞ without a limit.
        damping: viscous damping [N·m·s/rad or N·s/m].
        stiffness: stiffness of the joint's spring [N·m/rad or N/m].
        rest: angle or position at which the spring has no moment or force [rad or m].
        friction: moment or force of dry friction [N·m or N].
        armature: inertia of the rotor, reflected to the joint [kg·m² or kg].
        torque_limit: limit of the torque or force of all drives together [N·m or N]; None without a limit.
        start: angle or position at the start [rad or m].
        speed: rate of the angle or position at the start [rad/s or m/s].
        turn: rotation matrix of a ball joint at the start, shape (3, 3); None for other joints.
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
    """The names under which one quantity of a joint is written.

    Attributes:
        link: the key in the table of a link.
        slider: the key in the table of a slider; "" if a slider has no such key.
        attribute: the attribute of a joint in MJCF; "" if MJCF has no attribute with just this number.
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
"""Attribute of ``Joint`` → the names of this quantity. A slider has no armature: the mass of the carriage
includes it."""


def scene_values(joint: Joint, rest_position: float, low: float, high: float) -> dict[str, float]:
    """Return those values of a joint that a scene must give: attribute of ``Joint`` → value.

    Values that a scene has without a key are left out: a missing spring, stop or limit, and a value of 0
    except that of a limit, a stop or a rest angle.

    Args:
        joint: the joint.
        rest_position: angle or position in the scene at which the joint's spring has no moment or force [rad
            or m].
        low: least angle or position of the joint in the scene [rad or m]; −∞ without a stop.
        high: largest angle or position of the joint in the scene [rad or m]; ∞ without a stop.
    """
    # values that are None, −∞ or ∞ are left out
    values = {key: getattr(joint, key) or None for key in JOINT_KEYS}
    values |= {"rest": rest_position if joint.stiffness else None, "torque_limit": joint.torque_limit}
    values |= {"low": low, "high": high}
    return {key: value for key, value in values.items() if value is not None and math.isfinite(value)}


@dataclass(frozen=True, kw_only=True)
class LinkShape:
    """A shape of a body, which may touch other shapes or is only seen.

    Attributes:
        kind: the kind of shape, such as ``capsule``.
        touches: whether the shape can touch any other shape, or is a point of a scene without walls; if not,
            the shape is only seen.
        name: a name of letters, digits and _; "" without a name.
        walls: whether the shape can touch a plane that is fixed to the world.
        is_point: whether the shape stands for a point of a scene, in a file of this package.
        corners: points in the body's axes, shape (n, 3) [m]. The shape is the convex hull of equal balls or,
            for a cylinder, equal discs around these points. No points if the outline is unknown.
        radius: radius of the balls [m]; 0 for discs.
        disc: for a cylinder, the vector along the axis of the discs that is as long as their radius, in the
            body's axes, shape (3,) [m]; None for balls.
    """

    kind: str
    touches: bool
    name: str = ""
    walls: bool = False
    is_point: bool = False
    corners: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    radius: float = 0.0
    disc: np.ndarray | None = None


def shape_outline(kind: str, sizes: np.ndarray) -> tuple[np.ndarray, float, np.ndarray | None]:
    """Return corners, radius and disc (see ``LinkShape``) of a shape whose centre is at the origin.

    Args:
        kind: sphere, capsule or cylinder; any other kind is replaced by a box.
        sizes: radius of a sphere; radius, and half the length along z, of a capsule (without its round ends)
            or a cylinder; half the sides along x, y and z of a box [m].
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
    """A rigid body of a robot.

    Attributes:
        name: the name in the file.
        parent: index of the parent in ``Robot.bodies``, −1 for the world.
        rotation: rotation of the body's axes relative to the parent's axes, shape (3, 3).
        position: position of the body's origin in the parent's axes [m].
        mass: [kg].
        center: centre of mass in the body's axes [m].
        inertia: inertia about the centre of mass in the body's axes, shape (3, 3) [kg·m²].
        joints: the joints between the body and its parent, in the order in which they act.
        frames: named points in the body's axes [m], at one of which the last link may end.
        shapes: the shapes of the body.
        gravity_compensation: the part of the body's weight that gravcomp of MJCF compensates [1]; 1 for the
            whole weight.
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
    gravity_compensation: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Plane:
    """A plane that is fixed to the world; bodies are on the side to which the normal points.

    Attributes:
        name: the name in the file.
        point: a point on the plane, in space [m].
        normal: unit vector at right angles to the plane, in space.
        contacts: pairs (index of a body in ``Robot.bodies``, coefficient of sliding friction), one for each
            shape that can touch the plane.
    """

    name: str
    point: np.ndarray
    normal: np.ndarray
    contacts: Sequence[tuple[int, float]]


@dataclass(frozen=True, kw_only=True)
class Robot:
    """A tree of bodies in space; each parent comes before its children.

    Attributes:
        name: the name of the model.
        bodies: the bodies.
        gravity: acceleration by gravity in the world's axes [m/s²].
        planes: the planes that are fixed to the world; empty if the file disables contacts.
        embedded_data: the data of the scene from which this package wrote the file; None for any other file.
        notes: sentences on how the file was read.
        differences: the parts of the file that no scene has, or that scenes have in another form.
    """

    name: str
    bodies: Sequence[Body]
    gravity: np.ndarray
    planes: Sequence[Plane] = ()
    embedded_data: dict[str, Any] | None = None
    notes: Sequence[str] = ()
    differences: Sequence[Difference] = ()
