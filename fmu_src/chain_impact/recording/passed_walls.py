"""Points that pass through walls, because the scene does not let them touch these walls."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from chain_impact.scene.display.outlines import size_of_motion
from chain_impact.scene.half_planes import HalfPlane
from chain_impact.text import names_text

# [1] A point passes through a wall if, at different times, its distances from the wall on the free side and
# on the other side are both larger than this, relative to the size of the motion.
LEAST_PASSAGE = 1e-3
NAMED_POINTS = 4  # largest number of points that a sentence names


def points_through_walls(
    positions: np.ndarray,
    walls: Mapping[int, tuple[str, HalfPlane, np.ndarray | float]],
    pairs: Collection[tuple[int, int]],
) -> list[str]:
    """Return a sentence for each wall that points pass through without touching it.

    A point passes through a wall if it is, on both sides of the wall, at some time farther from the wall than
    LEAST_PASSAGE × ``size_of_motion``.

    Args:
        positions: positions of the points, shape (T, P, 2) [m].
        walls: number of a wall → its name, its free side, and its displacement along the normal, shape (T,)
            or one number [m].
        pairs: the pairs (number of a point, number of a wall) that can touch.
    """
    sentences = []
    for number, (name, plane, wall_motion) in walls.items():
        free_points = [k for k in range(positions.shape[1]) if (k, number) not in pairs]
        if not free_points or not len(positions):
            continue
        # [m] distances from the wall of the points that cannot touch the wall, negative beyond the wall
        clearances = positions[:, free_points] @ np.array(plane.normal) - (
            plane.offset + np.reshape(wall_motion, (-1, 1))
        )
        least_passage = LEAST_PASSAGE * size_of_motion(positions)
        through = np.array(free_points)[
            (clearances.min(axis=0) < -least_passage) & (clearances.max(axis=0) > least_passage)
        ]
        if len(through):
            points = names_text([str(k) for k in through.tolist()], NAMED_POINTS)
            points_text = f"point {points} passes" if len(through) == 1 else f"points {points} pass"
            sentences.append(f"{points_text} through {name} without touching it: see contact.points")
    return sentences
