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
from chain_impact.results.view import pin_mark, seen
from chain_impact.scene.half_planes import HalfPlane, half_planes

OUTSIDE_COLOUR = "0.93"
MARGIN, BAND = (
    0.04,
    0.14,
)  # of the motion's width, at the edges of the view and outside of walls; √2 BAND < NEAR
SLIMMEST = 0.3  # of the longer side of the view, the shorter one at least
PARALLEL = 1e-9  # of a length of 1 and of m, what round-off may be


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
    frame = half_planes(dict(zip(("x_min", "y_min", "x_max", "y_max"), view.ravel(), strict=True)), {})
    bounds = [*near, *frame.values()]
    edges = [_edge(wall, bounds) for wall in bounds]
    # the free side is to the left of each edge, so their directions turn as one goes round the room
    turning = sorted((np.arctan2(*(b - a)[::-1]), *a) for a, b in filter(len, edges))
    axes.set_facecolor(OUTSIDE_COLOUR if near else "white")
    room = Polygon([start for _, *start in turning], facecolor="white", zorder=0.5)
    axes.add_patch(room)
    lines = [
        axes.plot(*ends.T, color=INK, linewidth=2.0, zorder=2) for ends in filter(len, edges[: len(near)])
    ]
    axes.set(xlim=view[:, 0], ylim=view[:, 1])
    return [room, *(line for drawn in lines for line in drawn)]


def _edge(wall: HalfPlane, bounds: list[HalfPlane]) -> np.ndarray:
    """The ends of the part of a wall's line that the others leave free, shape (2, 2), or (0, 2) for none."""
    (nx, ny), start = wall.normal, wall.offset * np.array(wall.normal)
    along = np.array([ny, -nx])
    low, high = -np.inf, np.inf
    for other in bounds:
        gap, slope = other.clearance(*start), np.dot(other.normal, along)
        if abs(slope) < PARALLEL:
            high = high if gap > -PARALLEL else -np.inf
        elif slope > 0.0:
            low = max(low, -gap / slope)
        else:
            high = min(high, -gap / slope)
    return np.array([start + low * along, start + high * along]) if low < high else np.zeros((0, 2))
