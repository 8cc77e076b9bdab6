"""What is to be seen of a motion: where it goes, and the walls near it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from chain_impact.scene.half_planes import HalfPlane

NEAR = 0.2  # of the motion's width: a wall farther from the motion is left out
PIN = 0.08  # of the motion's width: the height of the ground mark of a pinned base
SUPPORT = np.array([[0.0, 0.0], [-0.4, 0.65], [0.4, 0.65], [0.0, 0.0]])  # in heights of the mark
GROUND = np.array([[-0.75, 0.65], [0.75, 0.65]])
HATCHES = [np.array([[x, 0.65], [x + 0.25, 1.0]]) for x in (-0.7, -0.35, 0.0, 0.35)]


def pin_mark(points: np.ndarray) -> list[np.ndarray]:
    """The lines of a pinned base's ground mark: a support on hatched ground.

    It is above the base if the chain is on the mean below it, else below.

    Args:
        points: positions, shape (T, N+1, 2) [m].

    Returns:
        The lines, each of shape (n, 2) [m]; none if the base moves.
    """
    base = points[0, 0]
    if len(points) < 2 or (points[:, 0] != base).any():  # noqa: PLR2004
        return []
    side = 1.0 if points[:, 1:, 1].mean() < base[1] else -1.0
    size = PIN * np.ptp(points, axis=(0, 1)).max()
    return [base + size * line * [1.0, side] for line in (SUPPORT, GROUND, *HATCHES)]


def seen(
    points: np.ndarray, walls: Mapping[str, HalfPlane], radius: float = 0.0
) -> tuple[np.ndarray, list[HalfPlane]]:
    """The rectangle that holds a motion, a pinned base's mark, and where the walls near them are nearest.

    Args:
        points: positions, shape (T, N+1, 2) [m].
        walls: name → free side.
        radius: of the points [m].

    Returns:
        The lower left and the upper right corner, shape (2, 2) [m], and the walls that are near.
    """
    reach = np.array([points.min(axis=(0, 1)) - radius, points.max(axis=(0, 1)) + radius])
    width = np.ptp(reach, axis=0).max()
    shown = np.concatenate([*reach[:, None], *pin_mark(points)])
    view, near = np.array([shown.min(axis=0), shown.max(axis=0)]), []
    for wall in walls.values():
        corner = np.where(np.array(wall.normal) > 0.0, *reach)  # the nearest to the wall
        gap = wall.clearance(*corner)
        if -width <= gap <= NEAR * width:
            met = corner - max(0.0, gap) * np.array(wall.normal)
            view = np.array([np.minimum(view[0], met), np.maximum(view[1], met)])
            near.append(wall)
    return view, near
