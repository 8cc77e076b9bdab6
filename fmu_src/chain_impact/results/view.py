"""What is to be seen of a motion: where it goes, and the walls near it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from chain_impact.walls import HalfPlane

NEAR = 0.2  # of the motion's width: a wall farther from the motion is left out


def seen(
    points: np.ndarray, walls: Mapping[str, HalfPlane], radius: float = 0.0
) -> tuple[np.ndarray, list[HalfPlane]]:
    """The rectangle that holds a motion and the places where the walls near it are nearest.

    Args:
        points: positions, shape (T, N+1, 2) [m].
        walls: name → free side.
        radius: of the points [m].

    Returns:
        The lower left and the upper right corner, shape (2, 2) [m], and the walls that are near.
    """
    reach = np.array([points.min(axis=(0, 1)) - radius, points.max(axis=(0, 1)) + radius])
    width = np.ptp(reach, axis=0).max()
    view, near = reach.copy(), []
    for wall in walls.values():
        corner = np.where(np.array(wall.normal) > 0.0, *reach)  # the nearest to the wall
        gap = wall.clearance(*corner)
        if -width <= gap <= NEAR * width:
            met = corner - max(0.0, gap) * np.array(wall.normal)
            view = np.array([np.minimum(view[0], met), np.maximum(view[1], met)])
            near.append(wall)
    return view, near
