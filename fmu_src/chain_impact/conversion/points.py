"""The points with which a link touches walls, computed from the shapes of the link's bodies."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from chain_impact.conversion.flat import ZERO_LENGTH, Plan, near
from chain_impact.conversion.joints import PARALLEL
from chain_impact.conversion.robot import LinkShape

OUTLINED = ("sphere", "capsule", "box", "cylinder")
"""The kinds of shapes that points can replace, because each is the convex hull of some balls or discs."""
# [rad] the directions from a link to a wall for which the link's points are chosen
TURN = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
DIRECTIONS = np.stack([np.cos(TURN), np.sin(TURN)], axis=1)
# [rad] where points lie on the rim of a disc that they replace, for a disc that is not seen exactly from the
# side
RIM = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)


class Ball(NamedTuple):
    """A ball that may touch a wall; its centre and radius become those of a point.

    Attributes:
        at: centre in the plane, with the joints of the chain at zero and all others at their start, shape
            (2,) [m].
        radius: radius [m].
        name: name of the shape from which the ball comes.
        blur: distance [m] up to which places count as equal; it follows from ``PARALLEL``, the angle up to
            which directions count as parallel.
        is_point: whether the shape is a point of a scene; its ball is kept, even if every wall touches
            another ball first.
    """

    at: np.ndarray
    radius: float
    name: str
    blur: float = ZERO_LENGTH
    is_point: bool = False


def balls_of(shape: LinkShape, pose: tuple[np.ndarray, np.ndarray], plan: Plan) -> Iterator[Ball]:
    """Yield balls whose convex hull is the projection of a shape onto the plane of the motion.

    ``pose`` is rotation and position of the shape's body. The rim of an oblique disc is replaced by single
    points.
    """
    rotation, position = pose
    centers, radius = plan.flat(position + shape.corners @ rotation.T), shape.radius
    # no two corners are farther apart than twice the largest distance from the first corner
    size = max(np.linalg.norm(shape.corners - shape.corners[:1], axis=1), default=0.0)
    blur = max(ZERO_LENGTH, 2.0 * PARALLEL * float(size))
    if shape.disc is not None:
        # `disc` is parallel to the axis of the disc and as long as its radius; here it is projected onto the
        # plane
        along = plan.flat(rotation @ shape.disc)
        size, seen = float(np.linalg.norm(shape.disc)), float(np.linalg.norm(along))
        if seen < PARALLEL * size:
            radius += size
        else:
            across = np.array([-along[1], along[0]]) * size / seen
            slant = math.sqrt(max(1.0 - (seen / size) ** 2, 0.0))
            aside = along / seen * size * slant
            rim = [0.0, math.pi] if slant < PARALLEL else RIM
            edge = np.outer(np.cos(rim), across) + np.outer(np.sin(rim), aside)
            centers = (centers[:, np.newaxis] + edge).reshape(-1, 2)
    for at in centers:
        yield Ball(at, radius, shape.name, blur, shape.is_point)


def reach_of_oblique(shape: LinkShape, pose: tuple[np.ndarray, np.ndarray], plan: Plan) -> np.ndarray | None:
    """Return how far a shape extends in each of DIRECTIONS, shape (directions,) [m]; for oblique discs only.

    The result is None if the balls of ``balls_of`` are exact. A disc of radius r whose axis has the angle γ
    to a direction extends r sin γ from its centre in this direction.
    """
    if shape.disc is None:
        return None
    rotation, position = pose
    along, size = plan.flat(rotation @ shape.disc), float(np.linalg.norm(shape.disc))
    if not PARALLEL < float(np.linalg.norm(along)) / size < math.sqrt(1.0 - PARALLEL**2):
        return None
    centers = plan.flat(position + shape.corners @ rotation.T)
    beside = np.sqrt(np.maximum(size**2 - (DIRECTIONS @ along) ** 2, 0.0))
    return np.asarray((DIRECTIONS @ centers.T).max(axis=1) + beside + shape.radius)


def reach(balls: Sequence[Ball]) -> np.ndarray:
    """Return how far each ball extends from the origin in each of DIRECTIONS [m].

    The shape is (directions, balls).
    """
    centers = np.array([ball.at for ball in balls])
    return np.asarray(DIRECTIONS @ centers.T + np.array([ball.radius for ball in balls]))


def outermost(balls: Sequence[Ball]) -> list[Ball]:
    """Return few balls of a link, such that a wall in any direction first touches one of them.

    A ball is left out if each wall that touches it first touches another of these balls at the same time, up
    to round-off. Of balls at the same place, only the first one in the file stays. Balls with ``is_point``
    always stay.
    """
    if not balls:
        return []
    far = reach(balls)
    first = far >= far.max(axis=1, keepdims=True) - max(ball.blur for ball in balls)
    needed = np.array([ball.is_point for ball in balls])
    for row in first[np.argsort(first.sum(axis=1), kind="stable")]:
        if not needed[row].any():
            needed[row.argmax()] = True
    return [ball for ball, need in zip(balls, needed, strict=True) if need]


def is_within(inner: Ball, outer: Ball, joint: np.ndarray) -> bool:
    """Return whether a ball of a link lies in a ball of its neighbour for every angle of the joint between.

    ``joint`` is the position of this joint.
    """
    away = float(np.linalg.norm(inner.at - joint) + np.linalg.norm(outer.at - joint))
    return away + inner.radius <= outer.radius + max(inner.blur, outer.blur)


def once_at_joints(balls: Sequence[list[Ball]], places: Sequence[np.ndarray]) -> list[list[Ball]]:
    """Return the balls of each link, without those that always lie inside a ball of a neighbouring link.

    Balls with ``is_point`` always stay.

    Args:
        balls: the balls of each link, from the base to the tip.
        places: positions of the joints and the tip, with the joints of the chain at zero [m].
    """
    kept = [list(found) for found in balls]
    for i in range(1, len(kept)):
        joint = places[i]
        for this, other in ((i, i - 1), (i - 1, i)):
            around = kept[other]
            kept[this] = [
                ball
                for ball in kept[this]
                if ball.is_point or not any(is_within(ball, by, joint) for by in around)
            ]
    return kept


def tables_of(balls: Sequence[Ball], joint: np.ndarray, along: np.ndarray) -> list[dict[str, Any]]:
    """Return the tables of a link's points: x along the link, y to its left, radius [m], and name if any.

    ``joint`` is the position of the joint at which the link begins, and ``along`` the unit vector along the
    link, with the joints of the chain at zero.
    """
    counts, seen = Counter(ball.name for ball in balls), Counter[str]()
    tables: list[dict[str, Any]] = []
    for ball in balls:
        name = ball.name
        seen[name] += 1
        x, y = ball.at - joint
        table = {"x": near(float(along @ (x, y))), "y": near(float(along[0] * y - along[1] * x))}
        label = {"name": name if counts[name] == 1 else f"{name}_{seen[name]}"} if name else {}
        tables.append({**table, "radius": ball.radius, **label})
    return tables
