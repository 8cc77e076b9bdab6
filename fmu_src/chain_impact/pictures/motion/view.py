"""The part of the plane that the picture of a motion shows: the motion and the walls near it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from chain_impact.recording.recording import Recording
from chain_impact.recording.view import anchor_of, has_open_side, positions_of, view_corners
from chain_impact.scene.display.outlines import size_of_motion
from chain_impact.scene.half_planes import HalfPlane

# VIEW_MARGIN: the margin of the view around the motion; BAND: how far the view reaches beyond a wall by
# default. Both are relative to the longer side of the view without margins. √2 BAND must be less than
# WALL_DISTANCE of recording/view.py, so that the margins alone do not reach a wall farther away than
# WALL_DISTANCE.
VIEW_MARGIN, BAND = 0.04, 0.14
# the view is not extended to a position of a moving wall that is farther from the motion than this, relative
# to the size of the motion
FARTHEST_WALL = 1.0
# FLATTEST: a motion that ``is_flat`` has a height below FLATTEST × width, and a scale of its own along y;
# FLAT_MARGIN: the margin above and below such a motion, relative to the height
FLATTEST, FLAT_MARGIN = 0.03, 0.25
# the least ratio of the shorter to the longer side of a view without a given shape, unless the motion is flat
LEAST_SIDE_RATIO = 0.3
# the usual largest factor on the width, and that on the height, with which the view grows to fill axes
GROWTH_FACTORS = (1.1, 1.2)
# a wall counts as parallel to the x axis or the y axis if a |component| of its unit normal exceeds this
PARALLEL_COMPONENT = 0.99
# the left, right, lowest and highest point of a disc: x and y relative to its centre, in units of its radius
DISC_ENDS = np.array([[-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]])


class View(NamedTuple):
    """The part of the plane that a picture of a motion shows.

    Attributes:
        corners: lower left and upper right corner, shape (2, 2) [m].
        walls: the names of the walls in view.
    """

    corners: np.ndarray
    walls: list[str]


def is_flat(recording: Recording) -> bool:
    """Return whether a motion would look like a line in a picture with equal scales along x and y (FLATTEST).

    A motion with a pinned base, a slider, outlines of links, no height, or a single row is never flat.
    """
    if recording.pinned or recording.rail or recording.outlines:
        return False
    positions = drawn_positions(recording)
    width, height = np.ptp(positions, axis=(0, 1))
    return bool(len(positions) > 1 and 0.0 < height < FLATTEST * width)


def seen_size(recording: Recording) -> float:
    """Return the size [m] with which distances between poses are compared.

    The size of a motion that ``is_flat`` is the height of its points, because y is drawn enlarged; the size
    of any other motion is ``size_of_motion``.
    """
    if is_flat(recording):
        return float(np.ptp(recording.points[..., 1]))
    return size_of_motion(recording.all_points)


def view_of(
    recording: Recording,
    shape: float | None = None,
    band: float = BAND,
    growth_factors: Sequence[float] = GROWTH_FACTORS,
) -> View:
    """Return the view of a motion in the plane: the motion, with a margin, and the walls near it.

    Of a wall that comes near the motion, the view contains the position at the start and both extreme
    positions, except positions farther away than FARTHEST_WALL. The view is extended towards ``shape``, the
    wanted height of the view divided by its width, by at most the factors ``growth_factors`` on width and
    height, and not beyond walls on both sides. ``band`` is how far the view reaches beyond a wall, relative
    to the longer side of the view without margins. A motion that ``is_flat`` has a range along y of its own
    (FLAT_MARGIN).
    """
    walls_at_ends = {
        (name, end): wall
        for end, walls in enumerate((recording.walls, *wall_extremes(recording)))
        for name, wall in walls.items()
        if end == 0 or name in recording.moved_walls
    }
    everywhere, visible_positions = dict(walls_at_ends), drawn_positions(recording)
    view, near_walls = view_corners(visible_positions, walls_at_ends, is_pinned=recording.pinned)
    if recording.moved_walls:
        names = {name for name, _ in near_walls}
        walls_at_ends = {wall_key: wall for wall_key, wall in walls_at_ends.items() if wall_key[0] in names}
        view, near_walls = view_corners(
            visible_positions, walls_at_ends, near_distance=FARTHEST_WALL, is_pinned=recording.pinned
        )
    width = np.ptp(view, axis=0).max()
    margin = np.full((2, 2), VIEW_MARGIN * width)
    for wall in near_walls.values():
        bands = band * width * np.array([wall.normal, np.negative(wall.normal)])
        margin = np.maximum(margin, bands)
    view = view + margin * [[-1.0], [1.0]]
    sides = np.ptp(view, axis=0)
    least_sides = np.full(2, LEAST_SIDE_RATIO * sides.max())
    wanted_sides = least_sides if shape is None else np.array([sides[1] / shape, shape * sides[0]])
    wanted_sides = np.minimum(wanted_sides, np.array(growth_factors) * np.maximum(sides, least_sides))
    anchor, is_open = anchor_of(near_walls.values()), has_open_side(near_walls.values())
    extra_sides = np.maximum(
        0.0, np.where(is_open, wanted_sides, np.minimum(wanted_sides, least_sides)) - sides
    )
    view = view + extra_sides * np.stack([-anchor, 1.0 - anchor])
    met_walls = dict(near_walls)
    for wall_key, wall in everywhere.items():
        normal = np.array(wall.normal)
        # [m] how far the view reaches beyond the wall; negative if the wall is outside of the view
        wall_distances = -wall.clearance(*np.where(normal > 0.0, *view))
        if wall_key not in near_walls and wall_distances > 0.0:
            met_walls[wall_key] = wall
            axis = int(np.abs(normal).argmax())
            # Only the enlarged view reaches this wall. If the wall is parallel to an edge of the view, the
            # view is cut to end at most ``band`` × ``width`` beyond the wall.
            if abs(normal[axis]) > PARALLEL_COMPONENT:
                inwards = max(0.0, wall_distances - band * width)
                view[int(normal[axis] < 0.0), axis] += np.sign(normal[axis]) * inwards
    if is_flat(recording):
        low, high = visible_positions[..., 1].min(), visible_positions[..., 1].max()
        view[:, 1] = low - FLAT_MARGIN * (high - low), high + FLAT_MARGIN * (high - low)
    return View(view, list(dict.fromkeys(name for name, _ in met_walls)))


def drawn_positions(recording: Recording) -> np.ndarray:
    """Return the positions of points, corners of a carriage, and DISC_ENDS of discs, shape (T, M, 2) [m]."""
    positions, points = positions_of(recording), recording.all_points
    rims = [
        points[:, [point]] + radius * DISC_ENDS
        for point, radius in recording.touching_radii.items()
        if radius > 0.0 and point < points.shape[1]
    ]
    return np.concatenate([positions, *rims], axis=1)


def wall_extremes(recording: Recording) -> Iterator[dict[str, HalfPlane]]:
    """Yield two dicts: name → wall, at the two extreme positions of the moving walls.

    In the first dict, each moving wall leaves the chain the most room; in the second, it leaves the least
    room. Both dicts also have the walls that do not move.
    """
    for end_of in (np.min, np.max):
        walls = dict(recording.walls)
        for name, wall_motion in recording.moved_walls.items():
            walls[name] = replace(walls[name], offset=walls[name].offset + float(end_of(wall_motion)))
        yield walls
