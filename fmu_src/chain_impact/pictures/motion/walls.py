"""The walls in the picture of a motion, with their free sides, and the mark of a pinned base."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patches import Polygon

from chain_impact.pictures.drawing.colours import INK, OUTSIDE_COLOUR, SHORT_TIMES_COLOUR
from chain_impact.pictures.motion.view import View, view_of, wall_extremes
from chain_impact.recording.recording import Recording
from chain_impact.recording.view import free_region_within, pin_lines
from chain_impact.scene.half_planes import HalfPlane

# a corner of the room in view lies on a wall if its distance from the wall, relative to the size of the view,
# is less than this number
WALL_TOLERANCE = 1e-9


def draw_walls(axes: Axes, recording: Recording, view: View | None = None) -> None:
    """Draw the walls near the motion and the mark of a pinned base, and set the limits of the axes.

    ``view`` is by default the result of ``view_of``. This function leaves the lines of moving walls, and a
    moving base, to ``draw_moving``. The ground is white where the chain may be at all times,
    SHORT_TIMES_COLOUR where the chain may be only at some times, and OUTSIDE_COLOUR beyond walls.
    """
    corners, near_walls = view or view_of(recording)
    moving_names = moving_walls(recording, near_walls)
    at_most, at_least = ([walls[name] for name in near_walls] for walls in wall_extremes(recording))
    if moving_names:
        axes.add_patch(Polygon(_corners(at_most, corners), facecolor=SHORT_TIMES_COLOUR, zorder=0.4))
    still_walls = [wall for name, wall in zip(near_walls, at_least, strict=True) if name not in moving_names]
    draw_room(axes, corners, at_least, still_walls)
    if recording.pinned and not has_motion(recording.points[:, 0]):
        draw_pin(axes, pin_lines(recording.all_points))


def moving_walls(recording: Recording, names: Iterable[str]) -> list[str]:
    """Return the walls in ``names`` that move in the recording."""
    return [name for name in names if has_motion(recording.moved_walls.get(name, np.zeros(1)))]


def has_motion(positions: np.ndarray) -> bool:
    """Return whether ``positions``, positions over time of shape (T, …), change."""
    return bool((positions != positions[0]).any())


def _corners(walls: Sequence[HalfPlane], view: np.ndarray) -> np.ndarray:
    """Return the corners of the part of a view on the free side of all ``walls``, shape (C, 2) [m]."""
    return np.reshape(free_region_within(walls, view), (-1, 2))


def draw_pin(axes: Axes, lines: list[np.ndarray]) -> list[Artist]:
    """Draw the ground mark of a pinned base, the ``lines`` of ``pin_lines``; return the artists."""
    line_style: dict[str, Any] = {"colors": INK, "linewidths": 1.2, "capstyle": "round", "zorder": 3}
    if not lines:
        return []
    mark = LineCollection(lines, **line_style)
    axes.add_collection(mark, autolim=False)
    return [mark]


def draw_room(
    axes: Axes, view: np.ndarray, near_walls: Sequence[HalfPlane], lines: Sequence[HalfPlane] | None = None
) -> list[Artist]:
    """Draw the room between some walls in white, the area beyond in grey, and lines of walls; set the limits.

    Args:
        axes: the axes to draw into.
        view: lower left and upper right corner of the axes' view, shape (2, 2) [m].
        near_walls: the walls that bound the room.
        lines: the walls in ``near_walls`` that get a line; by default all.

    Returns:
        The artists.
    """
    axes.set_facecolor(OUTSIDE_COLOUR if near_walls else "white")
    room = Polygon(_corners(near_walls, view), facecolor="white", zorder=0.5)
    axes.add_patch(room)
    drawn_artists: list[Artist] = [room]
    for wall in near_walls if lines is None else lines:
        if len(ends := wall_line(wall, near_walls, view)):
            drawn_artists += axes.plot(*ends.T, color=INK, linewidth=2.0, zorder=2)
    axes.set(xlim=view[:, 0], ylim=view[:, 1])
    return drawn_artists


def wall_line(wall: HalfPlane, walls: Sequence[HalfPlane], view: np.ndarray) -> np.ndarray:
    """Return the two ends of the part of a wall that bounds the room between ``walls`` in a view [m].

    The shape is (2, 2), or more rows if corners of the room coincide up to round-off. A result with fewer
    rows means that no part of the wall bounds this room. ``wall`` is one of ``walls``.
    """
    corners = _corners(walls, view)
    corner_gaps = corners @ np.array(wall.normal) - wall.offset
    return np.asarray(corners[abs(corner_gaps) < WALL_TOLERANCE * np.ptp(view)])
