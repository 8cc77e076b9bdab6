"""The points with which a link touches walls, computed from the shapes of the link's bodies."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from chain_impact.conversion.joints import PARALLEL_ANGLE
from chain_impact.conversion.plane import ZERO_LENGTH, MotionPlane, rounded_to_zero
from chain_impact.conversion.robot import LinkShape

OUTLINED_SHAPES = ("sphere", "capsule", "box", "cylinder")
"""The kinds of shapes that points can replace, because each is the convex hull of some balls or discs."""
# TURN: [rad] the angles of the directions toward walls in which the balls of a link are compared;
# DIRECTIONS: the unit vectors in these directions, shape (directions, 2)
TURN = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
DIRECTIONS = np.stack([np.cos(TURN), np.sin(TURN)], axis=1)
# [rad] the angles of the points on the rim of a disc that replace the disc, if it is neither parallel nor at
# right angles to the plane of the motion
RIM = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)


class Ball(NamedTuple):
    """A ball that may touch a wall; its centre and radius become those of a point.

    Attributes:
        position: centre in the scene's axes, with the joints of the chain at zero and all other joints at
            their start, shape (2,) [m].
        radius: radius [m].
        name: name of the shape from which the ball comes; "" without a name.
        blur: distance up to which positions count as equal [m].
        is_point: whether the shape is a point of a scene of this package. Such a ball is kept, even if every
            wall touches another ball first.
    """

    position: np.ndarray
    radius: float
    name: str
    blur: float = ZERO_LENGTH
    is_point: bool = False


def balls_of(
    shape: LinkShape, pose: tuple[np.ndarray, np.ndarray], motion_plane: MotionPlane
) -> Iterator[Ball]:
    """Yield balls whose convex hull is the projection of a shape onto the plane of the motion.

    For an oblique disc, the hull is only near the projection, because points (RIM) replace its rim. ``pose``
    is the rotation matrix and the position [m] of the shape's body.
    """
    rotation, position = pose
    centers, radius = motion_plane.project(position + shape.corners @ rotation.T), shape.radius
    # no two corners are farther apart than twice the largest distance from the first corner
    size = max(np.linalg.norm(shape.corners - shape.corners[:1], axis=1), default=0.0)
    blur = max(ZERO_LENGTH, 2.0 * PARALLEL_ANGLE * float(size))
    if shape.disc is not None:
        # the vector `disc` is along the axis of the disc, and as long as the radius; `disc_axis` is its
        # projection onto the plane
        disc_axis = motion_plane.project(rotation @ shape.disc)
        size, seen_size = float(np.linalg.norm(shape.disc)), float(np.linalg.norm(disc_axis))
        if seen_size < PARALLEL_ANGLE * size:
            radius += size
        else:
            rim_vector = np.array([-disc_axis[1], disc_axis[0]]) * size / seen_size
            slant = math.sqrt(max(1.0 - (seen_size / size) ** 2, 0.0))
            aside = disc_axis / seen_size * size * slant
            rim = [0.0, math.pi] if slant < PARALLEL_ANGLE else RIM
            edge = np.outer(np.cos(rim), rim_vector) + np.outer(np.sin(rim), aside)
            centers = (centers[:, np.newaxis] + edge).reshape(-1, 2)
    for center in centers:
        yield Ball(center, radius, shape.name, blur, shape.is_point)


def reach_of_oblique(
    shape: LinkShape, pose: tuple[np.ndarray, np.ndarray], motion_plane: MotionPlane
) -> np.ndarray | None:
    """Return how far the oblique discs of a shape extend from the origin in each of DIRECTIONS [m].

    The result has the shape (directions,). It is None for a shape without oblique discs, of which the balls
    of ``balls_of`` are exact. A disc of radius r whose axis has the angle γ to a direction extends r sin γ
    from its centre in this direction.
    """
    if shape.disc is None:
        return None
    rotation, position = pose
    disc_axis, size = motion_plane.project(rotation @ shape.disc), float(np.linalg.norm(shape.disc))
    if not PARALLEL_ANGLE < float(np.linalg.norm(disc_axis)) / size < math.sqrt(1.0 - PARALLEL_ANGLE**2):
        return None
    centers = motion_plane.project(position + shape.corners @ rotation.T)
    rim_reach = np.sqrt(np.maximum(size**2 - (DIRECTIONS @ disc_axis) ** 2, 0.0))
    return np.asarray((DIRECTIONS @ centers.T).max(axis=1) + rim_reach + shape.radius)


def reach(balls: Sequence[Ball]) -> np.ndarray:
    """Return how far [m] each ball extends from the origin in DIRECTIONS, shape (directions, balls)."""
    centers = np.array([ball.position for ball in balls])
    return np.asarray(DIRECTIONS @ centers.T + np.array([ball.radius for ball in balls]))


def outermost_balls(balls: Sequence[Ball]) -> list[Ball]:
    """Return some of the balls of a link, so that a wall in any of DIRECTIONS touches one of these first.

    "First" holds up to the largest ``blur`` of the balls. The number of returned balls need not be the least
    one. Balls with ``is_point`` always stay; of other equal balls, only the first one can stay.
    """
    if not balls:
        return []
    reach_of_balls = reach(balls)
    is_first = reach_of_balls >= reach_of_balls.max(axis=1, keepdims=True) - max(ball.blur for ball in balls)
    is_needed = np.array([ball.is_point for ball in balls])
    for row in is_first[np.argsort(is_first.sum(axis=1), kind="stable")]:
        if not is_needed[row].any():
            is_needed[row.argmax()] = True
    return [ball for ball, need in zip(balls, is_needed, strict=True) if need]


def is_within(inner_ball: Ball, outer_ball: Ball, joint: np.ndarray) -> bool:
    """Return whether a link's ``inner_ball`` lies in a neighbour's ``outer_ball`` for all angles.

    The angles are those of the joint between both links, at the position ``joint`` [m]. ``inner_ball`` may
    reach beyond ``outer_ball`` by the larger ``blur`` of both balls.
    """
    distance = float(
        np.linalg.norm(inner_ball.position - joint) + np.linalg.norm(outer_ball.position - joint)
    )
    return distance + inner_ball.radius <= outer_ball.radius + max(inner_ball.blur, outer_ball.blur)


def without_repeated_balls(balls: Sequence[list[Ball]], positions: Sequence[np.ndarray]) -> list[list[Ball]]:
    """Return the balls of each link, without those that lie in a ball of a neighbouring link for all angles.

    Balls with ``is_point`` always stay.

    Args:
        balls: the balls of each link, from the base to the tip.
        positions: positions of the joints, then of the tip, with the joints of the chain at zero [m].
    """
    kept_balls = [list(link_balls) for link_balls in balls]
    for i in range(1, len(kept_balls)):
        joint = positions[i]
        for link, neighbour in ((i, i - 1), (i - 1, i)):
            neighbour_balls = kept_balls[neighbour]
            kept_balls[link] = [
                ball
                for ball in kept_balls[link]
                if ball.is_point
                or not any(is_within(ball, neighbour_ball, joint) for neighbour_ball in neighbour_balls)
            ]
    return kept_balls


def point_tables(balls: Sequence[Ball], joint: np.ndarray, axis: np.ndarray) -> list[dict[str, Any]]:
    """Return for each ball the table of a link's point: ``x``, ``y``, ``radius`` [m] and, if any, ``name``.

    ``joint`` is the position of the link's proximal joint [m], ``axis`` the unit vector along the link, both
    with the joints of the chain at zero. Of several equal names, each gets a number at its end.
    """
    counts, name_counts = Counter(ball.name for ball in balls), Counter[str]()
    tables: list[dict[str, Any]] = []
    for ball in balls:
        name = ball.name
        name_counts[name] += 1
        x, y = ball.position - joint
        table = {
            "x": rounded_to_zero(float(axis @ (x, y))),
            "y": rounded_to_zero(float(axis[0] * y - axis[1] * x)),
        }
        label = {"name": name if counts[name] == 1 else f"{name}_{name_counts[name]}"} if name else {}
        tables.append({**table, "radius": ball.radius, **label})
    return tables
