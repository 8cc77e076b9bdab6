"""The room of the motion: its walls, the free side of them, and the part of it that is in view."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patches import Polygon

from chain_impact.results.plots.style import INK
from chain_impact.results.recording import Recording
from chain_impact.results.view import free_room, pin_mark, seen
from chain_impact.scene.half_planes import HalfPlane

OUTSIDE_COLOUR = "0.93"
MARGIN, BAND = (
    0.04,
    0.14,
)  # of the motion's width, at the edges of the view and outside of walls; √2 BAND < NEAR
SLIMMEST = 0.3  # of the longer side of the view, the shorter one at least
ROUND_OFF = 1e-9  # of the size of the view, between a wall and a corner on it


def view_of(recording: Recording) -> tuple[np.ndarray, list[HalfPlane]]:
    """The lower left and the upper right corner of what is to be seen, shape (2, 2) [m], and the walls in it.

    The motion fills it, with a margin. A wall far from the motion is left out; one that moves is at its end.
    """
    view, near = seen(recording.points, recording.walls_at(recording.time[-1]))
    margin = np.full((2, 2), MARGIN)
    for wall in near:
        margin = np.maximum(margin, BAND * np.array([wall.normal, np.negative(wall.normal)]))
    view = view + np.ptp(view, axis=0).max() * margin * [[-1.0], [1.0]]
    sides = np.ptp(view, axis=0)
    return view + 0.5 * np.maximum(0.0, SLIMMEST * sides.max() - sides) * [[-1.0], [1.0]], near


def draw_walls(axes: Axes, recording: Recording) -> None:
    """The room between the walls near the motion, and a pinned base's mark; sets the limits of the axes."""
    draw_room(axes, *view_of(recording))
    draw_pin(axes, pin_mark(recording.points))


def draw_pin(axes: Axes, lines: list[np.ndarray]) -> list[Artist]:
    """The ground mark of a pinned base, by the lines that ``pin_mark`` gives; returns what is drawn."""
    look: dict[str, Any] = {"colors": INK, "linewidths": 1.2, "capstyle": "round", "zorder": 3}
    if not lines:
        return []
    mark = LineCollection(lines, **look)
    axes.add_collection(mark, autolim=False)
    return [mark]


def draw_room(axes: Axes, view: np.ndarray, near: list[HalfPlane]) -> list[Artist]:
    """The room between some walls in white, all beyond them in grey; sets the limits of the axes.

    Args:
        axes: where it is drawn.
        view: lower left and upper right corner of what the axes show, shape (2, 2) [m].
        near: the walls.

    Returns:
        What is drawn.
    """
    corners, size = free_room(near, view), np.ptp(view)
    axes.set_facecolor(OUTSIDE_COLOUR if near else "white")
    room = Polygon(np.reshape(corners, (-1, 2)), facecolor="white", zorder=0.5)
    axes.add_patch(room)
    drawn: list[Artist] = [room]
    for wall in near:
        ends = [corner for corner in corners if abs(wall.clearance(*corner)) < ROUND_OFF * size]
        if ends:
            drawn += axes.plot(*np.transpose(ends), color=INK, linewidth=2.0, zorder=2)
    axes.set(xlim=view[:, 0], ylim=view[:, 1])
    return drawn
