"""The motion of a ball along a line, drawn over time: the ball's position, the walls, and the impacts."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from chain_impact.pictures.drawing.colours import BLUE, INK, OUTSIDE_COLOUR
from chain_impact.pictures.drawing.legends import legend_above
from chain_impact.pictures.motion.impact_rings import RING_SIZE, plot_rings
from chain_impact.pictures.motion.view import PARALLEL_COMPONENT, view_of
from chain_impact.pictures.motion.walls import has_motion
from chain_impact.pictures.over_time.time_axis import show_all_time
from chain_impact.recording.recording import Recording
from chain_impact.recording.view import ball_of

# the largest width of a ball's path that counts as a line, relative to the length of this line
MOST_LINE_WIDTH = 0.01
# BALL_MARGIN: the margin at both ends of the axis of positions; WALL_BAND: the visible width of the area
# beyond a wall; both relative to the range of the ball and the walls
BALL_MARGIN, WALL_BAND = 0.06, 0.14
BALL_OPACITY = 0.25  # the opacity, from 0 to 1, of the disc of the ball around its centre
# The size of a ring at an impact [points] is RING_PART times the width of the axes divided by the number of
# rings, but at least SMALLEST_RING and at most RING_SIZE.
SMALLEST_RING, RING_PART = 3.0, 0.7


def line_of_motion(recording: Recording) -> int | None:
    """Return the axis along which a ball moves, 0 for x and 1 for y; None for any other motion.

    Along this axis, the path of the ball is longer than the ball's radius; across the axis, the ball hardly
    moves (MOST_LINE_WIDTH). All walls in view are perpendicular to the axis.
    """
    ball = ball_of(recording)
    if ball is None:
        return None
    ways = np.ptp(recording.points[:, ball], axis=0)
    axis = int(ways.argmax())
    if not ways[axis] > recording.touching_radii[ball] or ways[1 - axis] > MOST_LINE_WIDTH * ways[axis]:
        return None
    normals = [recording.walls[name].normal for name in view_of(recording).walls]
    return axis if all(abs(normal[axis]) > PARALLEL_COMPONENT for normal in normals) else None


def draw_along_line(axes: Axes, recording: Recording, axis: int) -> None:
    """Draw the position of a ball over time, with walls and impacts, for a ball that moves along one axis.

    ``axis`` is the axis of the motion: 0 for x and 1 for y.
    """
    ball = ball_of(recording)
    assert ball is not None
    time, position, radius = recording.time, recording.points[:, ball, axis], recording.touching_radii[ball]
    surfaces = wall_surfaces(recording, axis)
    all_positions = [position - radius, position + radius, *surfaces.values()]
    low, high = min(map(np.min, all_positions)), max(map(np.max, all_positions))
    span = high - low
    low, high = low - BALL_MARGIN * span, high + BALL_MARGIN * span
    for name, surface in surfaces.items():
        is_below = recording.walls[name].normal[axis] > 0.0
        low, high = (low - WALL_BAND * span, high) if is_below else (low, high + WALL_BAND * span)
        kind, width = ("moving wall", 1.2) if has_motion(surface) else ("wall", 2.0)
        axes.plot(time, surface, color=INK, linewidth=width, zorder=2.0, label=f"{kind} {name}")
    for name, surface in surfaces.items():
        wall_edge = low if recording.walls[name].normal[axis] > 0.0 else high
        axes.fill_between(time, surface, wall_edge, color=OUTSIDE_COLOUR, linewidth=0.0, zorder=0.5)
    if radius > 0.0:
        look: dict[str, Any] = {"color": BLUE, "alpha": BALL_OPACITY, "linewidth": 0.0, "zorder": 1.5}
        axes.fill_between(
            time, position - radius, position + radius, label=f"ball, radius {radius:g} m", **look
        )
    axes.plot(
        time, position, color=BLUE, linewidth=1.2, label=f"path of the {'centre' if radius else 'ball'}"
    )
    draw_hits(axes, recording, surfaces)
    axes.set_ylim(low, high)
    axes.set_ylabel(f"{'xy'[axis]} [m]")
    show_all_time(axes, recording)
    legend_above(axes)


def draw_hits(axes: Axes, recording: Recording, surfaces: dict[str, np.ndarray]) -> None:
    """Draw a ring at each impact with a wall in ``surfaces``, the result of ``wall_surfaces``.

    The ring is at the onset of the impact, on the surface of the wall.
    """
    hits = [(row["onset"], surfaces.get(recording.wall_names[row["wall"]])) for row in recording.impacts]
    spots = {
        row: (float(onset), float(np.interp(onset, recording.time, hit_position)))
        for row, (onset, hit_position) in enumerate(hits)
        if hit_position is not None
    }
    if spots:
        figure = axes.get_figure(root=True)
        assert figure is not None
        room = axes.get_window_extent().width * 72.0 / figure.dpi / len(spots)
        plot_rings(axes, recording, spots, min(max(RING_PART * room, SMALLEST_RING), RING_SIZE))


def wall_surfaces(recording: Recording, axis: int) -> dict[str, np.ndarray]:
    """Return where each wall in view meets the line of a ball: name of wall → coordinate, shape (T,) [m].

    ``axis`` is the axis along which the ball moves, and so the axis of this coordinate: 0 for x, 1 for y.
    """
    ball, no_motion, surfaces = ball_of(recording), np.zeros(len(recording.time)), {}
    for name in view_of(recording).walls:
        wall = recording.walls[name]
        offset = wall.offset + recording.moved_walls.get(name, no_motion)
        # The surface of the wall with the normal n is the line of all p with n·p = offset. The result is the
        # coordinate along the axis of that p whose coordinate across the axis equals the ball's.
        transverse_part = wall.normal[1 - axis] * recording.points[:, ball, 1 - axis]
        surfaces[name] = (offset - transverse_part) / wall.normal[axis]
    return surfaces
