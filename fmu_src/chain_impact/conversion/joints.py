"""The joints of a robot that form a planar chain, and their places with all joints of the chain at zero."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import compress, pairwise
from typing import NamedTuple

import numpy as np

from chain_impact.conversion.robot import Joint, Robot
from chain_impact.scene.errors import SceneError, UnknownNameError

# Joint.kind → advice for a kind that no scene has
SUBSTITUTES = dict.fromkeys(
    ("floating", "planar", "free"),
    "; for a base that is free in the plane, write two slides at right angles and a hinge in its place",
)
# [rad] axes count as parallel up to this angle between the lines along them
PARALLEL_ANGLE = 1e-6


class NoChainError(SceneError):
    """Raised when the moving joints of a robot form no planar chain.

    Attributes:
        joints: names of joints of which one may have to be held, so that the others form a chain.
        proposed: names of joints that form a chain if all others are held; () for no proposal.
    """

    def __init__(self, message: str, joints: Sequence[str] = (), proposed: Sequence[str] = ()) -> None:
        """Store the names of the joints together with the message."""
        super().__init__(message)
        self.joints, self.proposed = tuple(joints), tuple(proposed)


@dataclass(frozen=True)
class MovingJoint:
    """A joint, the index of its body, and the place of its axis in space.

    ``anchor`` is a point on the axis [m], ``axis`` the unit vector along it, both shape (3,). Both
    hold with held joints at their start and all other joints at zero or, in the result of
    ``joints_at_start``, with all joints at their start.
    """

    joint: Joint
    body: int
    anchor: np.ndarray
    axis: np.ndarray


class ChosenJoints(NamedTuple):
    """The joints that form a chain.

    Attributes:
        poses: rotation and position of each body in space, with held joints at their start and all other
            joints at zero.
        hinges: the hinges, from the base to the tip.
        sliders: the sliding joints before the hinges: two for a free base, one for a base on a slider, none
            for a pinned base.
        held_names: names of the joints that do not move.
    """

    poses: list[tuple[np.ndarray, np.ndarray]]
    hinges: list[MovingJoint]
    sliders: list[MovingJoint]
    held_names: set[str]

    @property
    def base(self) -> str:
        """The kind of the scene's base: pinned, slider or free."""
        return ("pinned", "slider", "free")[len(self.sliders)]


def chosen_joints(robot: Robot, wanted_names: Sequence[str], source: str) -> ChosenJoints:
    """Return the joints that form the chain, with the poses of the bodies and the names of held joints.

    ``wanted_names`` are the names of the joints that move, while all others are held at their start; without
    names all joints move. ``source`` is the file's name for messages.

    Raises:
        NoChainError: when the moving joints form no planar chain of hinges and slides, or the limits of a
            joint leave it no room to move.
        UnknownNameError: when the robot has no joint with a wanted name.
    """
    held_names = _held_joints(robot, wanted_names, source)
    poses, joints_that_move = moving_joints(robot, held_names)
    sliders = [moving_joint for moving_joint in joints_that_move if moving_joint.joint.kind == "slide"]
    hinges = [moving_joint for moving_joint in joints_that_move if moving_joint.joint.kind == "hinge"]
    other_joints = [
        moving_joint.joint
        for moving_joint in joints_that_move
        if moving_joint.joint.kind not in ("slide", "hinge")
    ]
    for joint in other_joints:
        fault = f"is of the kind {joint.kind}: a scene has hinges and slides only"
        advice = SUBSTITUTES.get(joint.kind, "")
        raise NoChainError(f"{source}: joint {joint.name} {fault}{advice}", [joint.name])
    if not hinges:
        raise NoChainError(f"{source}: no hinge moves: a scene needs at least one hinge")
    _check_limits(hinges, source)
    _check_parallel(hinges, source)
    _check_slides(robot, sliders, joints_that_move, source)
    _check_serial(robot, hinges, source)
    return ChosenJoints(poses, hinges, sliders, held_names)


def moving_joints(
    robot: Robot, held_names: set[str]
) -> tuple[list[tuple[np.ndarray, np.ndarray]], list[MovingJoint]]:
    """Return the pose of each body, and the joints not in ``held_names``, in the order of their bodies.

    A pose is a rotation matrix and a position [m] in space. The joints ``held_names``, by name, are at their
    start, all others at zero.
    """
    poses = _poses(robot, held_names)
    return poses, [
        moving_joint
        for moving_joint in _place_joints(robot, poses)
        if moving_joint.joint.name not in held_names
    ]


def joints_at_start(robot: Robot) -> list[MovingJoint]:
    """Return all joints of a robot with their places in space at the start."""
    return list(_place_joints(robot, _poses(robot, set(joint_names(robot)))))


def _place_joints(robot: Robot, poses: list[tuple[np.ndarray, np.ndarray]]) -> Iterator[MovingJoint]:
    for b, body in enumerate(robot.bodies):
        rotation, position = poses[b]
        for joint in body.joints:
            yield MovingJoint(joint, b, position + rotation @ joint.anchor, rotation @ joint.axis)


def joint_names(robot: Robot) -> list[str]:
    """Return the names of all joints of a robot, in the order of the robot's bodies."""
    return [joint.name for body in robot.bodies for joint in body.joints]


def _held_joints(robot: Robot, wanted_names: Sequence[str], source: str) -> set[str]:
    names = joint_names(robot)
    for name in wanted_names:
        if name not in names:
            raise UnknownNameError(
                source, name, names, "not a joint", otherwise=f"joints: {', '.join(names)}"
            )
    return {name for name in names if name not in wanted_names} if wanted_names else set()


def _poses(robot: Robot, held_names: set[str]) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the rotation matrix and the position [m] of each body in space.

    The joints ``held_names``, by name, are at their start, all others at zero.
    """
    poses: list[tuple[np.ndarray, np.ndarray]] = []
    for body in robot.bodies:
        parent_rotation, origin = poses[body.parent] if body.parent >= 0 else (np.eye(3), np.zeros(3))
        rotation, position = parent_rotation @ body.rotation, origin + parent_rotation @ body.position
        for joint in body.joints:
            if joint.name not in held_names:
                continue
            if joint.kind == "slide":
                position = position + rotation @ joint.axis * joint.start
            elif joint.kind == "hinge" or joint.turn is not None:
                turn = _rotation(joint.axis, joint.start) if joint.turn is None else joint.turn
                joint_rotation = rotation @ turn
                position = position + (rotation - joint_rotation) @ joint.anchor
                rotation = joint_rotation
        poses.append((rotation, position))
    return poses


def _rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    """Return the rotation matrix for an angle [rad] about a unit vector, by Rodrigues' formula."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross)


def _check_limits(moving_ones: list[MovingJoint], source: str) -> None:
    for joint in (moving_joint.joint for moving_joint in moving_ones):
        if joint.low >= joint.high:
            unit, hint = ("m", "") if joint.kind == "slide" else ("rad", " (a `continuous` one can)")
            limit_text = (
                f"limits are equal, {joint.low:.6g} {unit}, so it cannot move{hint}"
                if joint.low == joint.high
                else f"lower limit, {joint.low:.6g} {unit}, is above its upper limit, {joint.high:.6g} {unit}"
            )
            raise NoChainError(f"{source}: joint {joint.name}: its {limit_text}", [joint.name])


def _check_parallel(hinges: list[MovingJoint], source: str) -> None:
    if len(parallel_groups(hinges)) > 1:
        names = [hinge.joint.name for hinge in hinges]
        raise NoChainError(
            f"{source}: the axes of the joints are not parallel: the robot is not a planar chain", names
        )


def parallel_groups(hinges: Sequence[MovingJoint]) -> list[list[MovingJoint]]:
    """Return all ``hinges`` in groups; the axes in a group are parallel to that of its first hinge."""
    groups: list[list[MovingJoint]] = []
    joints_left = list(hinges)
    while joints_left:
        sines = np.linalg.norm(np.cross([hinge.axis for hinge in joints_left], joints_left[0].axis), axis=1)
        is_parallel = sines < PARALLEL_ANGLE
        groups.append(list(compress(joints_left, is_parallel)))
        joints_left = list(compress(joints_left, ~is_parallel))
    return groups


def _check_slides(robot: Robot, sliders: list[MovingJoint], order: list[MovingJoint], source: str) -> None:
    """Refuse sliding joints that a scene cannot have.

    A scene can have one slide in the plane of the motion, or two in this plane at right angles to each other,
    in both cases before the first hinge. The limits of a single slide must leave room for motion. ``order``
    are all moving joints, in the order of the bodies.
    """
    first = next(moving_joint for moving_joint in order if moving_joint.joint.kind == "hinge")
    joints_before = [
        moving_joint
        for moving_joint in order[: order.index(first)]
        if moving_joint.body in ancestors(robot, first.body)
    ]
    cosines = [abs(float(np.dot(slide.axis, first.axis))) for slide in sliders]
    is_square = len(sliders) == 2 and abs(float(np.dot(sliders[0].axis, sliders[1].axis))) < PARALLEL_ANGLE  # noqa: PLR2004
    if sliders and (
        not (is_square or len(sliders) == 1)
        or max(cosines) > PARALLEL_ANGLE
        or any(slide not in joints_before for slide in sliders)
    ):
        names = [slide.joint.name for slide in sliders]
        raise NoChainError(
            f"{source}: joint {names[0]} slides: a scene can have only one slide in the plane of the motion, "
            "before the first hinge, or two at right angles, as for a free base",
            names,
        )
    if len(sliders) == 1:
        _check_limits(sliders, source)


def _check_serial(robot: Robot, hinges: list[MovingJoint], source: str) -> None:
    for hinge_before, hinge in pairwise(hinges):
        if hinge_before.body == hinge.body or hinge_before.body not in ancestors(robot, hinge.body):
            names = [hinge_before.joint.name, hinge.joint.name]
            raise NoChainError(
                f"{source}: joints {names[0]} and {names[1]} do not follow one another: a scene has one "
                "chain without branches",
                names,
            )


def ancestors(robot: Robot, b: int) -> Iterator[int]:
    """Yield the index ``b`` of a body, then the indices of the bodies between this body and the world."""
    while b >= 0:
        yield b
        b = robot.bodies[b].parent
