"""The points with which a link touches walls, from the shapes of the link's bodies."""

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
"""The kinds of shapes that points can replace, because the shape is the convex hull of balls or discs."""
# [rad] the directions of walls for which the points of a link are chosen
TURN = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
DIRECTIONS = np.stack([np.cos(TURN), np.sin(TURN)], axis=1)
# [rad] angles of the points that replace the rim of a disc; for a disc that is seen from the side, two points
# suffice
RIM = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)


class Ball(NamedTuple):
    """A ball that may touch a wall.

    Attributes:
        at: centre in the plane, shape (2,) [m].
        radius: radius [m].
        name: name of its shape.
        blur: distance [m] within which places count as equal, because directions that differ by ``PARALLEL``
            count as parallel.
        is_point: whether it is a point, also if others lie further out.
    """

    at: np.ndarray
    radius: float
    name: str
    blur: float = ZERO_LENGTH
    is_point: bool = False


def balls_of(shape: LinkShape, pose: tuple[np.ndarray, np.ndarray], plan: Plan) -> Iterator[Ball]:
    """Yield the balls whose convex hull is the projection of a shape onto the plane of the motion."""
    rotation, position = pose
    centers, radius = plan.flat(position + shape.corners @ rotation.T), shape.radius
    # a bound on the distance of any two corners: twice the largest distance from the first corner
    size = max(np.linalg.norm(shape.corners - shape.corners[:1], axis=1), default=0.0)
    blur = max(ZERO_LENGTH, 2.0 * PARALLEL * float(size))
    if shape.disc is not None:
        # the projection of `disc` onto the plane; the vector `disc` is parallel to the axis, with the radius
        # as its length
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
    """Return the extent [m] of a shape from its centre in each direction; None if balls replace it exactly.

    A disc whose axis has the angle γ to a direction reaches radius · sin γ from its centre in this direction.
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
    """Return the extent [m] of each ball in each direction, shape (directions, balls)."""
    centers = np.array([ball.at for ball in balls])
    return np.asarray(DIRECTIONS @ centers.T + np.array([ball.radius for ball in balls]))


def outermost(balls: Sequence[Ball]) -> list[Ball]:
    """Return the fewest balls with which a straight wall in any direction touches first.

    A ball is left out if every wall that the ball touches first touches other balls at the same time, up to
    round-off. Of balls at the same place, only the first one in the file is left.
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
    """Return whether a ball of a link is inside a ball of the next link, whatever the angle between them."""
    away = float(np.linalg.norm(inner.at - joint) + np.linalg.norm(outer.at - joint))
    return away + inner.radius <= outer.radius + max(inner.blur, outer.blur)


def once_at_joints(balls: Sequence[list[Ball]], places: Sequence[np.ndarray]) -> list[list[Ball]]:
    """Return the balls of each link without those that are always inside a ball of a neighbouring link.

    Args:
        balls: the balls of each link, from the base to the tip.
        places: positions of the joints and the tip [m].
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
    """Return the tables of the points of a link that begins at a joint and points along a direction."""
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
