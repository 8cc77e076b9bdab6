"""Moving walls and a moving base: drawn strongly at single times, faintly in between, with a trace."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from chain_impact.pictures.drawing.colours import INK
from chain_impact.pictures.motion.view import View
from chain_impact.pictures.motion.walls import has_motion, moving_walls, wall_line
from chain_impact.recording.recording import Recording
from chain_impact.recording.view import pin_lines

FAINT_WALLS = 8  # the number of faint positions of a moving wall, at equal distances in time
FAINT_MARKS = 8  # the number of faint ground marks of a moving base, from rows with equally spaced indices
# [1] the distance of the point whose path is the trace of a moving wall (``_wall_trace``) from an end of the
# wall's visible part, relative to the length of the visible part
TRACE_GAP = 0.04
# a wall whose positions differ by at most this part of the view's longer side has no trace
LEAST_TRACE = 0.02


def draw_moving(axes: Axes, recording: Recording, view: View, shade: Any, times: Sequence[float]) -> None:
    """Draw moving walls and a moving base, each with the trace of a point in the colours of time.

    Walls are drawn at start, end and ``times`` [s] in the colours of time, the base at start and end; both
    are drawn faintly in between. ``shade`` is the function from a time [s] to its colour.
    """
    (corners, near_walls), ends = view, [float(recording.time[row]) for row in (0, -1)]

    def lines(name: str, times: Sequence[float]) -> list[np.ndarray]:
        """Return the two ends of the visible part of the wall ``name`` at each of some times [s].

        The visible part is the border of the region in the view where the chain may be; a wall without a
        visible part has no ends.
        """
        rooms = (recording.walls_at(time) for time in times)
        return [
            wall_line(walls[name], [walls[wall_name] for wall_name in near_walls], corners) for walls in rooms
        ]

    has_label = False
    for name in moving_walls(recording, near_walls):
        faint_lines = lines(name, np.linspace(ends[0], ends[1], FAINT_WALLS).tolist())
        _add(axes, faint_lines, colors=INK, linewidths=0.6, alpha=0.13, zorder=1.9)
        for shown_times, width in ((times, 1.2), (ends, 2.4)):
            for time, line in zip(shown_times, lines(name, shown_times), strict=True):
                _add(axes, [line], colors=[shade(time)], linewidths=width, zorder=2.0)
        if any(map(len, faint_lines)) and not has_label:  # all walls share one entry of the legend
            axes.collections[-1].set_label("moving wall")
            has_label = True
        if np.ptp(recording.moved_walls[name]) > LEAST_TRACE * np.ptp(corners, axis=0).max():
            _draw_trace(axes, _wall_trace(recording, name, lines(name, ends)), recording.time, shade)
    if recording.pinned and has_motion(recording.points[:, 0]):
        _draw_base(axes, recording, shade)


def _draw_base(axes: Axes, recording: Recording, shade: Any) -> None:
    """Draw the ground mark of a moving base at start and end, faintly in between, and the base's trace.

    If the base moves less than the size of its mark, only the mark at the start is drawn, because several
    marks would cover each other.
    """
    bases, mark = recording.points[:, 0], pin_lines(recording.all_points)
    line_style: dict[str, Any] = {"linewidths": 1.2, "capstyle": "round", "zorder": 3}
    if np.ptp(bases, axis=0).max() < np.ptp(np.concatenate(mark), axis=0).max():
        _add(axes, mark, colors=INK, **line_style)
    else:
        rows = np.linspace(0, len(bases) - 1, FAINT_MARKS).astype(int)
        _add(axes, _move_lines(mark, bases[rows] - bases[0]), colors=INK, alpha=0.13, **line_style)
        for row in (0, -1):
            colour = shade(recording.time[row])
            _add(axes, _move_lines(mark, bases[[row]] - bases[0]), colors=[colour], **line_style)
    _draw_trace(axes, bases, recording.time, shade)


def _wall_trace(recording: Recording, name: str, lines: Sequence[np.ndarray]) -> np.ndarray:
    """Return the path of a point on a moving wall, shape (T, 2) [m].

    ``lines`` are the visible parts of the wall at the start and at the end. The point is near an end of the
    first part that is not empty: the end that is farther from the chain. If both parts are empty, the path
    is empty, too.
    """
    wall, wall_motion = recording.walls[name], recording.moved_walls[name]
    line = next((visible_line for visible_line in lines if len(visible_line) > 1), np.zeros((0, 2)))
    if not len(line):
        return line
    ends = [line[0] + share * (line[-1] - line[0]) for share in (TRACE_GAP, 1.0 - TRACE_GAP)]
    gap_sizes = [np.hypot(*(recording.all_points - end).reshape(-1, 2).T).min() for end in ends]
    end, normal = ends[int(np.argmax(gap_sizes))], np.array(wall.normal)
    foot = end - wall.clearance(*end) * normal
    return np.asarray(foot + wall_motion[:, None] * normal)


def _draw_trace(axes: Axes, path: np.ndarray, time: np.ndarray, shade: Any) -> None:
    """Draw a path, shape (T, 2) [m], in the colours of time; an empty path is not drawn."""
    if len(path) > 1:
        middles = 0.5 * (time[1:] + time[:-1])
        pieces = list(np.stack([path[:-1], path[1:]], axis=1))
        _add(axes, pieces, colors=shade(middles), linewidths=1.2, capstyle="round", zorder=3.2)


def _move_lines(lines: Sequence[np.ndarray], displacements: np.ndarray) -> list[np.ndarray]:
    """Return all lines moved by each of ``displacements``, shape (W, 2) [m]: W copies of each line."""
    return [line + way for way in displacements for line in lines]


def _add(axes: Axes, lines: Sequence[np.ndarray], **look: Any) -> None:
    axes.add_collection(LineCollection([line for line in lines if len(line)], **look), autolim=False)
