"""The panel of the motion: a few strong poses, the paths of points, faint poses, and the impacts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.lines import Line2D

from chain_impact.kernel.forces.friction import STICKS
from chain_impact.pictures.body import draw_bodies, draw_rail
from chain_impact.pictures.impact_numbers import (
    LISTED_OF_MANY,
    MOST_IN_LABEL,
    listed_or_counted,
    numbers_text,
)
from chain_impact.pictures.joint_forces import draw_loads, name_loads
from chain_impact.pictures.labels import Ink, Label, place_labels
from chain_impact.pictures.legends import legend_above
from chain_impact.pictures.message import marked_peaks
from chain_impact.pictures.moving import draw_moving
from chain_impact.pictures.rest import shown_time
from chain_impact.pictures.room import BAND, draw_walls, is_flat, seen_size, view_of
from chain_impact.pictures.style import (
    INK,
    PEAK_COLOUR,
    TIME_COLOURS,
    give_ticks,
    scale_numbers,
    tells_peak,
)
from chain_impact.recording.joint_stops import range_lines, touching_place
from chain_impact.recording.recording import Recording
from chain_impact.recording.rest import ends_at_rest, rest_word
from chain_impact.recording.stick_slip import JOINT
from chain_impact.recording.text import prefixed
from chain_impact.recording.view import ball_of

# the largest number of strong poses between start and end (``strong_times``)
MOST_STRONG_POSES = 6
CANDIDATES = 60  # largest number of impacts, the fastest ones, among whose poses strong poses are chosen
FAINT_POSES = 40  # the largest number of faint poses, from rows with equally spaced indices
# The least distance between poses, relative to the size of the motion: FAINT_APART of faint poses,
# STRONG_APART of strong ones. The pose at the fastest impact is always kept.
FAINT_APART, STRONG_APART = 0.03, 0.1
PATH_LAYER = 2.1  # matplotlib's order of drawing (zorder) for the tip's path: above walls, as a tip may slide
MOST_MARKED_POINTS = 12  # a chain with more points than this has no marks at its points
# PATH_WIDTH: [points] the usual width of the line along the tip's path; DENSE: a line that would cover more
# than this part of the area around the path is narrower; LINE_CELL, AREA_CELL: see ``density``; MOST_SAMPLES:
# the largest number of points on a path from which ``density`` computes
PATH_WIDTH, DENSE, LINE_CELL, AREA_CELL, MOST_SAMPLES = 1.5, 0.3, 0.01, 0.05, 20000
# with more paths of points than this, each path is the fainter the more paths there are
MOST_CLEAR_PATHS = 6
# RIM_WIDTH: [points] how much wider the chain at the start is drawn if the chain at the end covers it;
# COVERED_WITHIN: this is so if every point ends nearer to its start than this, relative to the size of the
# motion
RIM_WIDTH, COVERED_WITHIN = 3.0, 0.02
BALL_LINE = 0.3  # the width of the line from a ball's centre to the link's other end, relative to other links
SHORT_LENGTH = 0.1  # [m] if all |y| on the axis of a flat motion are smaller, their unit has a prefix
RING_SIZE = 6.5  # [points] the diameter of the ring at an impact
PEAK_WIDTH = 2.0  # [points] the width of the line of a ring for the largest force
SQUARE_SIZE = 4.0  # [points] the size of the mark where a contact, a joint or a slider sticks
# [1] distance within which impacts at the same wall or stop share a ring, relative to the view's larger side
RING_DISTANCE = 0.03


def draw_motion(axes: Axes, recording: Recording, shape: float | None = None, band: float = BAND) -> None:
    """Draw the motion in the plane: walls, paths, faint poses, and strong poses at start, end and impacts.

    ``shape`` is the height of the axes divided by their width, if known; ``shape`` and ``band`` are as for
    ``view_of``.
    """
    view = view_of(recording, shape, band)
    draw_walls(axes, recording, view)
    shade = colour_of_time(recording)
    draw_faint(axes, recording)
    draw_paths(axes, recording, shade)
    marks: dict[str, Any] = {"marker": "o" if recording.points.shape[1] <= MOST_MARKED_POINTS else ""}
    thick, ball = 1.0, ball_of(recording)
    if ball is not None:  # a mark shows the ball's centre, a thin line the link
        thick, marks = BALL_LINE, marks | {"markevery": [ball]}
    strong = strong_times(recording)
    draw_moving(axes, recording, view, shade, strong)
    draw_rail(axes, recording)
    for time in strong:
        draw_bodies(axes, recording, recording.row_at(time), shade(time), linewidth=0.8)
        draw_chain(
            axes, recording.pose_at(time), color=shade(time), linewidth=1.6 * thick, markersize=3.5, **marks
        )
    rests = f", {rest_word(recording)}" if ends_at_rest(recording) else ""
    for row, name in ((0, "start"), (-1, f"end{rests}")):
        colour = shade(recording.time[row])
        style = {"color": colour, "linewidth": 3.0 * thick, "markersize": 5.5, "label": name} | marks
        # a wider copy of the chain at the start is visible as a rim around the chain at the end
        if row == 0 and is_covered(recording):
            rim = {"linewidth": (3.0 + RIM_WIDTH) * thick, "markersize": 5.5 + RIM_WIDTH, "label": "_"}
            draw_chain(axes, recording.points[row], **style | rim)
        draw_bodies(axes, recording, row, colour, linewidth=1.2)
        draw_chain(axes, recording.points[row], **style)
    if recording.stops:
        hit = next((row for row in by_speed(recording).tolist() if recording.at_stops[row]), None)
        pose = recording.points[-1] if hit is None else recording.pose_at(recording.impacts["onset"][hit])
        lines = list(range_lines(pose, recording.stops))
        axes.add_collection(LineCollection(lines, colors=INK, linewidths=1.0, zorder=3.5, label="stops"))
    draw_rings(axes, recording)
    draw_sticking(axes, recording)
    draw_loads(axes, recording, view)
    flat = is_flat(recording)
    axes.set_aspect("auto" if flat else "equal")
    give_ticks(axes)
    axes.set(xlabel="x [m]", ylabel="y [m]")
    if flat:
        largest = float(np.abs(axes.get_ylim()).max())
        factor, unit = prefixed(largest, "m") if largest < SHORT_LENGTH else (1.0, "m")
        scale_numbers(axes.yaxis, factor)
        box = axes.get_window_extent()
        zoom = box.height / box.width * np.ptp(axes.get_xlim()) / np.ptp(axes.get_ylim())
        axes.set_ylabel(f"y\u00a0[{unit}], enlarged {zoom:#.2g} times".replace(". times", " times"))
    legend_above(axes)


def is_covered(recording: Recording) -> bool:
    """Return whether the chain at the end would cover the chain at the start (COVERED_WITHIN)."""
    ways = recording.points[-1] - recording.points[0]
    return bool(np.hypot(*ways.T).max() < COVERED_WITHIN * seen_size(recording))


def draw_chain(axes: Axes, points: np.ndarray, **look: Any) -> Line2D:
    """Draw the chain in one pose.

    Args:
        axes: the axes to draw into.
        points: positions of the points 0…N, shape (N+1, 2) [m].
        look: properties of the line, with matplotlib's names: color, linewidth, markersize, label, …

    Returns:
        The line; `set_data(*points.T)` moves the line to another pose.
    """
    style: dict[str, Any] = {"marker": "o", "markeredgecolor": "white", "markeredgewidth": 0.7, "zorder": 4}
    style |= {"solid_joinstyle": "round", "solid_capstyle": "round"}
    (line,) = axes.plot(*np.transpose(points), **(style | look))
    return line


def colour_of_time(recording: Recording) -> Any:
    """Return a function: time [s] → colour in TIME_COLOURS, over the shown time; constant beyond it."""
    shown = shown_time(recording)
    norm = Normalize(shown.start, shown.end if shown.end > shown.start else shown.start + 1.0, clip=True)
    return lambda time: TIME_COLOURS(norm(time))


def strong_times(recording: Recording) -> list[float]:
    """Return the times [s] of the strong poses between start and end, in order.

    These are the onsets of at most MOST_STRONG_POSES of the CANDIDATES fastest impacts. The fastest impact is
    one of them. Slower impacts follow, the faster ones first, if their pose differs (``apart``) from the
    poses at start, at end, and at all impacts that are chosen before.
    """
    onsets = recording.impacts["onset"][by_speed(recording)[:CANDIDATES]].tolist()
    if not onsets:
        return []
    ends = [recording.points[0], recording.points[-1]]
    poses = np.array([recording.pose_at(onsets[0]), *ends, *map(recording.pose_at, onsets[1:])])
    kept = apart(poses, STRONG_APART * seen_size(recording), always=3)
    times = [onsets[0], *(onsets[k - 2] for k in kept[3:])]
    return sorted(times[:MOST_STRONG_POSES])


def apart(poses: np.ndarray, least: float, always: int = 1) -> list[int]:
    """Return the indices of the poses to keep, each of which differs from all earlier poses that are kept.

    ``poses`` has the positions of the points in each pose, shape (P, N+1, 2) [m]. Two poses differ if the
    mean distance of their points is at least ``least`` [m]. The first ``always`` poses are kept in any case.
    """
    kept: list[int] = []
    for k, pose in enumerate(poses):
        ways = np.hypot(*np.moveaxis(poses[kept] - pose, -1, 0)).mean(axis=-1)
        if k < always or ways.min() >= least:
            kept.append(k)
    return kept


def by_speed(recording: Recording) -> np.ndarray:
    """Return the rows of the impacts in the order of ``recording.end_speeds``, the fastest first."""
    return np.argsort(-recording.end_speeds, kind="stable")


def draw_faint(axes: Axes, recording: Recording) -> None:
    """Draw the chain faintly in rows with equally spaced indices, without poses that look alike."""
    rows = np.unique(np.linspace(0, len(recording.time) - 1, FAINT_POSES).round().astype(int))
    poses = recording.points[rows]
    poses = poses[apart(poses, FAINT_APART * seen_size(recording))]
    axes.add_collection(LineCollection(list(poses), colors=INK, linewidths=0.6, alpha=0.13))


def draw_paths(axes: Axes, recording: Recording, shade: Any) -> None:
    """Draw the paths of points; the path of the tip, or of a ball's centre, has the colours of time.

    The other end of a ball's link has no path. ``shade`` is the function from a time [s] to its colour.
    """
    *others, tip = recording.points.transpose(1, 0, 2)
    ball, name = ball_of(recording), "tip"
    if ball is not None:
        others, tip, name = [], recording.points[:, ball], "path"
    others += [*recording.sites.transpose(1, 0, 2)]
    alpha = 0.45 * min(1.0, MOST_CLEAR_PATHS / (len(others) + 1))
    axes.add_collection(LineCollection(others, colors=INK, linewidths=0.6, alpha=alpha))
    if len(tip) == 1:
        return
    middles = 0.5 * (recording.time[1:] + recording.time[:-1])
    pieces = np.stack([tip[:-1], tip[1:]], axis=1)
    width = PATH_WIDTH * min(1.0, (DENSE / density(tip, seen_size(recording))) ** 2)
    path = LineCollection(list(pieces), colors=shade(middles), linewidths=width, capstyle="round", label=name)
    path.set_zorder(PATH_LAYER)
    axes.add_collection(path)


def density(path: np.ndarray, size: float) -> float:
    """Return which part of the area around a path is covered by a line along the path, from 0 to 1.

    The line consists of the squares with the side LINE_CELL that the path meets, the area of those with the
    side AREA_CELL; both sides are relative to ``size`` [m]. ``path`` has the shape (T, 2) [m].
    """
    way = np.append(0.0, np.hypot(*np.diff(path, axis=0).T).cumsum())
    count = min(MOST_SAMPLES, 2 + int(2.0 * way[-1] / (LINE_CELL * size)))
    places = np.stack([np.interp(np.linspace(0.0, way[-1], count), way, along) for along in path.T], axis=-1)
    areas = [
        len(np.unique(np.floor(places / (cell * size)), axis=0)) * cell**2 for cell in (LINE_CELL, AREA_CELL)
    ]
    return areas[0] / areas[1]


def draw_rings(axes: Axes, recording: Recording) -> None:
    """Draw a ring at each place where a point hit a wall, or where a joint or slider hit a stop."""
    places = rings(axes, recording)
    plot_rings(axes, recording, {row: spot for spot, rows in places.items() for row in rows}, RING_SIZE)


def plot_rings(
    axes: Axes, recording: Recording, spots: Mapping[int, tuple[float, float]], size: float
) -> None:
    """Draw a ring at the place of each impact; the ring of an impact in ``marked_peaks`` has PEAK_COLOUR.

    The first impact in ``marked_peaks`` has no entry in the legend if a line below the headline tells it
    (``tells_peak``).

    ``spots``: row of an impact → position in the axes; ``size``: the diameter of a ring [points].
    """
    look: dict[str, Any] = {"marker": "o", "markersize": size, "markerfacecolor": "none", "linestyle": ""}
    most = [peak for peak in marked_peaks(recording) if peak.row in spots]
    if places := list(dict.fromkeys(spots.values())):
        label = "impacts" if len(places) > len(most) else "_"
        axes.plot(*np.transpose(places), **look, color=INK, zorder=5, label=label)
    named = most[:1] if tells_peak(axes.get_figure(root=True)) else []
    for peak in most:
        name = "_" if peak in named else peak.words
        bold = {"color": PEAK_COLOUR, "markeredgewidth": PEAK_WIDTH, "zorder": 5.2, "label": name}
        axes.plot(*spots[peak.row], **look | bold)


def draw_sticking(axes: Axes, recording: Recording) -> None:
    """Draw a square at each contact, joint or slider that sticks at the end of the recording."""
    last, points = recording.stick_slip[np.isnan(recording.stick_slip["end"])], recording.all_points[-1]
    positions = []
    for phase in last[last["mode"] == STICKS]:
        joint = phase["wall"] == JOINT
        position = points[max(phase["point"] - 1, 0) if joint else phase["point"]]
        if not joint and recording.walls:
            wall = recording.wall_of(phase)
            position = position - wall.clearance(*position) * np.array(wall.normal)
        positions.append(position)
    if positions:
        mark_style: dict[str, Any] = {"marker": "s", "markersize": SQUARE_SIZE, "linestyle": "", "color": INK}
        axes.plot(*np.transpose(positions), **mark_style, zorder=5.5, label="sticks at the end")


def number_rings(axes: Axes, recording: Recording, ink: Ink) -> str:
    """Write the numbers of the impacts beside their rings, beyond the walls, where ``ink`` is free.

    The fastest impacts come first; the largest forces in joints (``name_loads``) come last. Returns a text
    with the numbers without room, or with the count of these numbers; "" if all numbers have room.
    """
    hits_at, labels = rings(axes, recording), []
    for spot, hits in hits_at.items():
        numbers = [hit + 1 for hit in hits]
        position, outward = _label_place(recording, recording.impacts[hits[0]], spot)
        whole = numbers_text(numbers, MOST_IN_LABEL, LISTED_OF_MANY)
        labels.append(Label(whole, position, outward, min(whole, numbers_text(numbers, 1, 1), key=len)))
    left = place_labels(axes, labels, ink, lines=True, fontsize="small", color=INK)
    name_loads(axes, recording, ink)
    missing = [hits for label, hits in zip(labels, hits_at.values(), strict=True) if label in left]
    return listed_or_counted([hit + 1 for hits in missing for hit in hits], len(recording.impacts))


def _label_place(
    recording: Recording, impact: np.void, spot: tuple[float, float]
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the position for an impact's label, and the unit vector from this position to the label.

    The position is ``spot``, the place of the impact's ring, and the vector points into the wall. At a stop
    of a joint, the vector is across the link. At a stop of a slider, the position is the end of the stop's
    mark, and the vector is along this mark.
    """
    if recording.is_stop(impact["wall"]):
        x, y = touching_place(recording.pose_at(impact["onset"]), impact["point"])[1]
        return spot, (float(y), float(-x))
    nx, ny = recording.wall_of(impact).normal
    if recording.toucher(impact) != "slider":
        return spot, (-nx, -ny)
    across = (-ny, nx) if nx >= 0.0 else (ny, -nx)
    assert recording.rail is not None
    reach = recording.rail.half
    return (spot[0] + reach * across[0], spot[1] + reach * across[1]), across


def rings(axes: Axes, recording: Recording) -> dict[tuple[float, float], list[int]]:
    """Return the rings: position of a ring → rows of its impacts in ``recording.impacts``, fastest first.

    A ring is at the ``spot`` of its fastest impact. A slower impact at the same wall or stop belongs to this
    ring if the distance of its spot from the ring is less than RING_DISTANCE × the larger side of the view.
    """
    spacing = RING_DISTANCE * max(np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim()))
    hits_at: dict[tuple[float, float], list[int]] = {}
    walls = recording.impacts["wall"]
    for row in by_speed(recording).tolist():
        x, y = recording.spot(recording.impacts[row]).tolist()
        near = (
            spot
            for spot, hits in hits_at.items()
            if walls[hits[0]] == walls[row] and np.hypot(spot[0] - x, spot[1] - y) < spacing
        )
        hits_at.setdefault(next(near, (x, y)), []).append(row)
    return hits_at
