"""The panel of the motion: a few strong poses, the paths of points, faint poses, and the impacts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.lines import Line2D

from chain_impact.pictures.drawing.axis_numbers import force_text, give_ticks, scale_numbers
from chain_impact.pictures.drawing.colours import INK, PEAK_COLOUR, TIME_COLOURS
from chain_impact.pictures.drawing.legends import legend_above
from chain_impact.pictures.drawing.style import is_narrow
from chain_impact.pictures.motion.bodies import draw_bodies, draw_rail
from chain_impact.pictures.motion.impact_rings import draw_rings, draw_sticking, rows_by_speed
from chain_impact.pictures.motion.joint_forces import draw_loads
from chain_impact.pictures.motion.moving_walls import draw_moving
from chain_impact.pictures.motion.poses import RIM_WIDTH, draw_chain, draw_faint, is_covered, strong_rows
from chain_impact.pictures.motion.view import View, is_flat, seen_size, view_of
from chain_impact.pictures.motion.walls import draw_walls, has_motion
from chain_impact.pictures.over_time.rests import shown_time
from chain_impact.pictures.texts.headline import time_unit
from chain_impact.recording.joint_stops import range_lines
from chain_impact.recording.recording import Recording
from chain_impact.recording.rest import ends_at_rest, rest_word
from chain_impact.recording.view import ball_of
from chain_impact.text import prefixed_unit

# matplotlib's order of drawing (zorder) for the tip's path: above walls, because a tip may slide along a wall
PATH_LAYER = 2.1
MOST_MARKED_POINTS = 12  # a chain with more points than this has no marks at its points
PATH_WIDTH = 1.5  # [points] the usual width of the line along the tip's path
DENSE = 0.3  # a line that would cover more than this part of the area around the path is narrower
LINE_CELL, AREA_CELL = 0.01, 0.05  # see ``density``
MOST_SAMPLES = 20000  # the largest number of points on a path from which ``density`` computes
# If the last part of a tip's path, shorter than HIDING × the duration of the run, covers the earlier part,
# the legend tells this; REVISITED: see ``duration_of_visible_part``.
HIDING, REVISITED = 0.5, 0.05
HIDDEN_REACH = 0.02  # see ``small_reach``
# with more paths of points than this, only every second one, or every third one, and so on, is drawn
MOST_CLEAR_PATHS = 6
PATH_OPACITY = 0.45  # the opacity of the path of a point, from 0 to 1
BALL_LINE = 0.3  # the width of the line of a ball's link, relative to the line of a link that is no ball
SHORT_LENGTH = 0.1  # [m] if all |y| on the axis of a flat motion are smaller, their unit has a prefix


def draw_motion(axes: Axes, recording: Recording, view: View | None = None) -> None:
    """Draw the motion in the plane: walls, paths, faint poses, and strong poses at start, end and impacts.

    ``view`` is the part of the plane to show; by default the result of ``view_of``.
    """
    view = view_of(recording) if view is None else view
    draw_walls(axes, recording, view)
    shade = colour_of_time(recording)
    draw_faint(axes, recording)
    draw_paths(axes, recording, shade)
    rows = strong_rows(recording)
    strong_times = [float(time) for time in recording.impacts["onset"][rows]]
    draw_moving(axes, recording, view, shade, strong_times)
    draw_rail(axes, recording)
    label = "at impacts" if len(rows) > 1 else f"at impact {sum(rows) + 1}"
    # if the motion is small, start and end cover the chain at the impact
    label = "_" if small_reach(recording, view.corners) else label
    draw_strong_poses(axes, recording, shade, strong_times, label)
    if recording.stops:
        draw_joint_ranges(axes, recording)
    draw_rings(axes, recording)
    draw_sticking(axes, recording)
    shown_poses = [recording.points[0], recording.points[-1], *map(recording.pose_at, strong_times)]
    draw_loads(axes, recording, view, shown_poses)
    is_flat_motion = is_flat(recording)
    axes.set_aspect("auto" if is_flat_motion else "equal")
    give_ticks(axes)
    axes.set(xlabel="x [m]", ylabel="y [m]")
    if is_flat_motion:
        name_enlarged_axis(axes)
    legend_above(axes)


def draw_strong_poses(
    axes: Axes, recording: Recording, shade: Any, strong_times: Sequence[float], label: str
) -> None:
    """Draw the chain strongly at ``strong_times`` [s], at the start and at the end.

    ``shade`` is a function from a time to its colour, ``label`` the name of the first pose in the legend.
    """
    marks: dict[str, Any] = {"marker": "o" if recording.points.shape[1] <= MOST_MARKED_POINTS else ""}
    thickness, ball = 1.0, ball_of(recording)
    if ball is not None:  # a mark shows the ball's centre, a thin line the link
        thickness, marks = BALL_LINE, marks | {"markevery": [ball]}
    for time in strong_times:
        look = {"color": shade(time), "linewidth": 1.6 * thickness, "markersize": 3.5} | marks
        draw_bodies(axes, recording, recording.row_at(time), shade(time), linewidth=0.8)
        draw_chain(axes, recording.pose_at(time), label="_" if time > strong_times[0] else label, **look)
    rest_text = f", {rest_word(recording)}" if ends_at_rest(recording) else ""
    for row, name in ((0, "start"), (-1, f"end{rest_text}")):
        colour = shade(recording.time[row])
        style = {"color": colour, "linewidth": 3.0 * thickness, "markersize": 5.5, "label": name} | marks
        # a wider copy of the chain at the start is visible as a rim around the chain at the end
        if row == 0 and is_covered(recording):
            rim = {"linewidth": (3.0 + RIM_WIDTH) * thickness, "markersize": 5.5 + RIM_WIDTH, "label": "_"}
            draw_chain(axes, recording.points[row], **style | rim)
        draw_bodies(axes, recording, row, colour, linewidth=1.2)
        draw_chain(axes, recording.points[row], **style)


def draw_joint_ranges(axes: Axes, recording: Recording) -> None:
    """Draw the ranges of joints with stops, at the end or at the fastest impact at a stop of a joint."""
    hit = next((row for row in rows_by_speed(recording).tolist() if recording.is_at_joint_stop[row]), None)
    pose = recording.points[-1] if hit is None else recording.pose_at(recording.impacts["onset"][hit])
    lines = list(range_lines(pose, recording.stops))
    axes.add_collection(LineCollection(lines, colors=INK, linewidths=1.0, zorder=3.5, label="stops"))


def name_enlarged_axis(axes: Axes) -> None:
    """Name the axis y of a flat motion, with the factor by which y is enlarged."""
    largest_height = float(np.abs(axes.get_ylim()).max())
    factor, unit = prefixed_unit(largest_height, "m") if largest_height < SHORT_LENGTH else (1.0, "m")
    scale_numbers(axes.yaxis, factor)
    box = axes.get_window_extent()
    zoom = box.height / box.width * np.ptp(axes.get_xlim()) / np.ptp(axes.get_ylim())
    axes.set_ylabel(f"y\u00a0[{unit}], enlarged {zoom:#.2g} times".replace(". times", " times"))


def all_entries(axes: Axes) -> list[Any]:
    """Return the artists for the legend of a motion.

    In a narrow figure, the first artist in PEAK_COLOUR is left out if a text of the figure in this colour
    tells the impact with the largest force.
    """
    kept_handles, _ = axes.get_legend_handles_labels()
    figure = axes.get_figure(root=True)
    if (
        figure is not None
        and is_narrow(figure)
        and any(text.get_color() == PEAK_COLOUR for text in figure.texts)
    ):
        rings = [
            line for line in kept_handles if isinstance(line, Line2D) and line.get_color() == PEAK_COLOUR
        ]
        kept_handles = [handle for handle in kept_handles if handle not in rings[:1]]
    return kept_handles


def colour_of_time(recording: Recording) -> Any:
    """Return a function from time [s] to colour: the shown time (``shown_time``) takes all of TIME_COLOURS.

    Times before and after the shown time have the first and the last colour.
    """
    time_span = shown_time(recording)
    norm = Normalize(
        time_span.start,
        time_span.end if time_span.end > time_span.start else time_span.start + 1.0,
        clip=True,
    )
    return lambda time: TIME_COLOURS(norm(time))


def draw_paths(axes: Axes, recording: Recording, shade: Any) -> None:
    """Draw the paths of points; the path of the tip, or of a ball's centre, has the colours of time.

    If the chain is a ball (``ball_of``), the end of its link that is not the centre has no path. ``shade`` is
    the function from a time [s] to its colour.
    """
    *other_paths, tip = recording.points.transpose(1, 0, 2)
    ball, name = ball_of(recording), "tip"
    if ball is not None:
        other_paths, tip, name = [], recording.points[:, ball], "path"
    other_paths += [*recording.sites.transpose(1, 0, 2)]
    step = max(1, math.ceil(len(other_paths) / MOST_CLEAR_PATHS))
    label_text = "other points" if step == 1 else f"other points (1 of {step})"
    label = label_text if any(map(has_motion, other_paths)) else "_"
    look: dict[str, Any] = {"colors": INK, "linewidths": 0.6, "alpha": PATH_OPACITY, "label": label}
    axes.add_collection(LineCollection(other_paths[::step], **look))
    if len(tip) == 1:
        return
    middles = 0.5 * (recording.time[1:] + recording.time[:-1])
    pieces = np.stack([tip[:-1], tip[1:]], axis=1)
    width = PATH_WIDTH * min(1.0, (DENSE / density(tip, seen_size(recording))) ** 2)
    on_top = duration_of_visible_part(tip, recording.time, seen_size(recording))
    factor, unit = time_unit(on_top)
    label_text = f"{name}, last {factor * on_top:.2g} {unit} on top"
    entry = label_text if 0.0 < on_top < HIDING * np.ptp(recording.time) else name
    if small_reach(recording, np.transpose([axes.get_xlim(), axes.get_ylim()])):
        entry = "_"
    path = LineCollection(
        list(pieces), colors=shade(middles), linewidths=width, capstyle="round", label=entry
    )
    path.set_zorder(PATH_LAYER)
    axes.add_collection(path)


def small_reach(recording: Recording, corners: np.ndarray) -> str:
    """Return words for the reach of a motion that the marks of the chain hide, else "".

    For example "no point moves more than 2 mm along x or y". The motion is hidden if no point, named points
    of bodies included, moves as far along x or y as HIDDEN_REACH, relative to the larger side of the view
    with the ``corners`` [m]. A flat motion, whose y is enlarged, is not.
    """
    reach = float(np.ptp(recording.all_points, axis=0).max())
    if is_flat(recording) or not 0.0 < reach < HIDDEN_REACH * np.ptp(corners, axis=0).max():
        return ""
    return f"no point moves more than {force_text(reach, 'm')} along x or y"


def duration_of_visible_part(path: np.ndarray, time: np.ndarray, size: float) -> float:
    """Return the duration [s] of the last part of a path, which covers the part before it.

    The last part visits all squares that the whole path visits, except the share REVISITED of them. The side
    of a square is AREA_CELL × ``size`` [m]. ``path`` has the shape (T, 2) [m], ``time`` the shape (T,) [s].
    """
    cells = np.floor(path / (AREA_CELL * size))
    _, ages = np.unique(cells[::-1], axis=0, return_index=True)
    first = len(path) - 1 - int(np.quantile(ages, 1.0 - REVISITED))
    return float(time[-1] - time[first])


def density(path: np.ndarray, size: float) -> float:
    """Return which part of the area around a path is covered by a line along the path, from 0 to 1.

    The line consists of the squares with the side LINE_CELL that the path meets, the area of those with the
    side AREA_CELL; both sides are relative to ``size`` [m]. ``path`` has the shape (T, 2) [m].
    """
    way = np.append(0.0, np.hypot(*np.diff(path, axis=0).T).cumsum())
    count = min(MOST_SAMPLES, 2 + int(2.0 * way[-1] / (LINE_CELL * size)))
    positions = np.stack(
        [np.interp(np.linspace(0.0, way[-1], count), way, coordinate) for coordinate in path.T], axis=-1
    )
    areas = [
        len(np.unique(np.floor(positions / (cell * size)), axis=0)) * cell**2
        for cell in (LINE_CELL, AREA_CELL)
    ]
    return areas[0] / areas[1]
