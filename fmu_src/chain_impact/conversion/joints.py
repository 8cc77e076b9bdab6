"""The joints of a robot that make a planar chain: which they are, and where, before any of them moves."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from chain_impact.conversion.robot import Joint, Robot
from chain_impact.scene.reading import SceneError, UnknownNameError

PARALLEL = 1e-6  # rad, between axes


@dataclass(frozen=True)
class Moving:
    """A joint of the chain: the joint, its body, its place and its axis in space, before any joint moves."""

    joint: Joint
    body: int
    anchor: np.ndarray
    axis: np.ndarray


class Chosen(NamedTuple):
    """The joints of a chain.

    Attributes:
        poses: rotation and position of each body in space, with held joints at their start and all others
            at zero.
        hinges: from the base to the tip.
        slides: the two of a free base, or none.
        held: names of the joints that do not move.
    """

    poses: list[tuple[np.ndarray, np.ndarray]]
    hinges: list[Moving]
    slides: list[Moving]
    held: set[str]


def chosen_joints(robot: Robot, wanted: Sequence[str], source: str) -> Chosen:
    """The joints that move; for arguments and errors see ``planar_chain``."""
    held = _held(robot, wanted, source)
    poses = _poses(robot, held)
    moving = [_moving(poses, b, j) for b, j in _joints(robot) if j.name not in held]
    slides = [one for one in moving if one.joint.kind == "slide"]
    hinges = [one for one in moving if one.joint.kind == "hinge"]
    others = [one for one in moving if one.joint.kind not in ("slide", "hinge")]
    if others or not hinges:
        what = (
            f"joint {others[0].joint.name} is of the kind {others[0].joint.kind}"
            if others
            else "it has no hinge"
        )
        raise SceneError(
            f"{source}: {what}: the joints of a scene are hinges; --joints names those that move"
        )
    _check_parallel(hinges, source)
    free = _check_slides(slides, hinges[0], source)
    _check_serial(robot, hinges, source)
    return Chosen(poses, hinges, slides if free else [], held)


def _joints(robot: Robot) -> Iterator[tuple[int, Joint]]:
    return ((b, joint) for b, body in enumerate(robot.bodies) for joint in body.joints)


def _held(robot: Robot, wanted: Sequence[str], source: str) -> set[str]:
    names = [joint.name for _, joint in _joints(robot)]
    for name in wanted:
        if name not in names:
            raise UnknownNameError(source, name, names, "no joint", otherwise=f"joints: {', '.join(names)}")
    return {name for name in names if name not in wanted} if wanted else set()


def _poses(robot: Robot, held: set[str]) -> list[tuple[np.ndarray, np.ndarray]]:
    """Rotation and position of each body in space, with held joints at their start and all others at zero."""
    poses: list[tuple[np.ndarray, np.ndarray]] = []
    for body in robot.bodies:
        before, origin = poses[body.parent] if body.parent >= 0 else (np.eye(3), np.zeros(3))
        rotation, position = before @ body.rotation, origin + before @ body.position
        for joint in body.joints:
            if joint.name not in held:
                continue
            if joint.kind == "slide":
                position = position + rotation @ joint.axis * joint.start
            elif joint.kind == "hinge":
                turned = rotation @ _rotation(joint.axis, joint.start)
                position = position + (rotation - turned) @ joint.anchor
                rotation = turned
        poses.append((rotation, position))
    return poses


def _rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    """Of an angle about an axis of length 1 (Rodrigues)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross)


def _moving(poses: list[tuple[np.ndarray, np.ndarray]], b: int, joint: Joint) -> Moving:
    rotation, position = poses[b]
    return Moving(joint, b, position + rotation @ joint.anchor, rotation @ joint.axis)


def _check_parallel(hinges: list[Moving], source: str) -> None:
    groups: list[list[Moving]] = []
    for hinge in hinges:
        group = next((g for g in groups if _parallel(g[0].axis, hinge.axis)), None)
        if group is None:
            groups.append([hinge])
        else:
            group.append(hinge)
    if len(groups) > 1:
        most = ",".join(hinge.joint.name for hinge in max(groups, key=len))
        raise SceneError(
            f"{source}: the axes of its joints are not parallel: it is no planar chain; --joints {most} "
            "takes those that are, and holds the others"
        )


def _parallel(one: np.ndarray, other: np.ndarray) -> bool:
    return bool(np.linalg.norm(np.cross(one, other)) < PARALLEL)


def _check_slides(slides: list[Moving], first: Moving, source: str) -> bool:
    """Whether the base is free: two slides in the plane carry it."""
    if not slides:
        return False
    along = [abs(float(np.dot(slide.axis, first.axis))) for slide in slides]
    square = len(slides) == 2 and abs(float(np.dot(slides[0].axis, slides[1].axis))) < PARALLEL  # noqa: PLR2004
    if not square or max(along) > PARALLEL or any(slide.body > first.body for slide in slides):
        raise SceneError(
            f"{source}: joint {slides[0].joint.name} slides: only two slides at right angles before the "
            "first hinge, as of a free base, can be in a scene; --joints names those that move"
        )
    return True


def _check_serial(robot: Robot, hinges: list[Moving], source: str) -> None:
    bodies = [hinge.body for hinge in hinges]
    for before, hinge in pairwise(hinges):
        above = hinge.body
        while above != before.body and above >= 0:
            above = robot.bodies[above].parent
        if above != before.body or bodies.count(hinge.body) > 1:
            raise SceneError(
                f"{source}: joints {before.joint.name} and {hinge.joint.name} do not follow one another: "
                "a scene has one chain without branches; --joints names those that move"
            )
