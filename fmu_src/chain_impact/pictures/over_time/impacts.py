"""The panel that shows how hard the impacts are, over time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import count
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.transforms import ScaledTranslation

from chain_impact.pictures.drawing.axis_numbers import load_unit, scale_numbers
from chain_impact.pictures.drawing.colours import GREY, INK, PEAK_COLOUR
from chain_impact.pictures.drawing.labels import Label
from chain_impact.pictures.drawing.legends import legend_above
from chain_impact.pictures.drawing.style import COLUMN, is_narrow
from chain_impact.pictures.drawing.used_pixels import UsedPixels
from chain_impact.pictures.over_time.dry_friction import MOST_ROWS, rubbing_locations
from chain_impact.pictures.over_time.time_axis import show_all_time
from chain_impact.pictures.texts.headline import impact_values, marked_peaks
from chain_impact.pictures.texts.impact_numbers import (
    NUMBER_SIGN,
    label_numbers,
    label_subsets,
    write_first_fitting,
)
from chain_impact.pictures.texts.point_names import POINT, number_of, short_names, what_touches
from chain_impact.recording.contact_times import SEEN_CONTACT, contact_ends, impacts_at_peaks
from chain_impact.recording.impact_texts import speed_unit
from chain_impact.recording.recording import Recording
from chain_impact.recording.stick_slip import element_label

# the largest number of different looks of marks, each for a point or a joint at its stops, or for all others
MOST_OWN_MARKS = 5
# Impacts have equal distances in time if there are more than REGULAR impacts, and if the largest and the
# smallest distance of successive impacts differ by at most EQUAL_DISTANCES times the mean distance.
REGULAR, EQUAL_DISTANCES = 5, 0.2
MOST_NUMBER_LABELS = 60  # the largest number of labels with numbers of impacts
# the upper end of the axis, relative to the largest value, or to 1 if all values are 0; the excess is room
# for numbers. COLUMN_HEADROOM: in a figure with a width of COLUMN or less, whose panels are low
HEADROOM, COLUMN_HEADROOM = 1.3, 1.5
MOST_WHOLE_NAMES = 3  # the largest number of points in a narrow figure whose names all have the word "point"
# [points] the size of the mark of an impact, and the distance by which a copy of this mark is shifted to the
# left for each group with marks that cover it
IMPACT_DOT, COVERED_SHIFT = 4.5, 3.0
# the width and height of a cell in which all marks of impacts count as one mark, relative to the run's
# duration and to the largest height of a mark
ONE_MARK = 0.005
STEM = 0.8  # [points] the width of the vertical line at an impact
CONTACT = 2.5  # [points] the width of the line that shows a contact
ROW = 8.5  # [points] the height of a row of contacts
ROWS_GAP = 6.5  # [points] the space above all rows of contacts
NAME_GAP = 4.0  # [points] the distance of a row's name from the axes
LANE = "lane"  # the matplotlib identifier (gid) of the name of a row of contacts
STEM_KEY = 8.0  # [points] the height of the vertical line in the legend that stands for lines at impacts
SOLID_MARK: dict[str, Any] = {"color": INK, "markeredgecolor": "white", "markeredgewidth": 0.5}
HOLLOW_MARK: dict[str, Any] = {"color": INK, "markerfacecolor": "white", "markeredgewidth": 0.8}
# Marks of points, and of joints at their stops. The marks differ in form, not in colour, because colours
# stand for energies and for time; full and hollow marks alternate, so that a reader can distinguish them.
POINT_MARKS = tuple(
    look | {"marker": form}
    for form, look in zip("os^vD", (SOLID_MARK, HOLLOW_MARK) * 2 + (SOLID_MARK,), strict=True)
)
STOP_MARKS = tuple(
    look | {"marker": form}
    for form, look in zip("DdXPh", (HOLLOW_MARK, SOLID_MARK) * 2 + (HOLLOW_MARK,), strict=True)
)
OTHERS_MARK: dict[str, Any] = SOLID_MARK | {"marker": "o", "color": GREY}
# Form of a mark → factor on its size, so that all forms look equally large.
MARK_SCALES = {"s": 0.85, "D": 0.8, "^": 1.2, "v": 1.2, "d": 1.2, "X": 1.1, "P": 1.1}


def draw_impacts(axes: Axes, recording: Recording) -> None:
    """Draw the marks of all impacts over time, at the times and heights that ``marks_of`` gives.

    A vertical line, the stem, joins the mark to the height 0. The form of a mark tells the point, or the
    joint at a stop (``point_groups``). The impacts in ``marked_peaks`` have the colour PEAK_COLOUR.

    Contacts that are long enough to be visible are thick, pale lines in a strip below the height 0, but not
    those that a panel of dry friction shows (``are_told``). Each
    group with such contacts has a row in the strip, with its name at the left; the axis of time is below the
    strip. If there are impacts both at walls and at stops of joints, the values at stops of joints have an
    axis on the right.
    """
    is_at_stop, onsets, scale = recording.is_at_joint_stop, recording.impacts["onset"], stop_scale(recording)
    times, tops = marks_of(recording)
    ends, span = contact_ends(recording), recording.duration
    groups, lanes = point_groups(recording, tops), 0
    shifts = mark_shifts(recording, times, tops, [hits for *_, hits in groups])
    strongest = {peak.row for peak in marked_peaks(recording)}
    figure = axes.get_figure(root=True)
    assert figure is not None
    lines = np.stack([times, np.zeros(len(tops)), times, tops], axis=1).reshape(-1, 2, 2)
    labels = legend_names([name for name, *_ in groups], is_narrow=is_narrow(figure))
    for (name, mark, hits), label in zip(groups, labels, strict=True):
        colour = mark["color"]
        stems = [(PEAK_COLOUR, 2.0 * STEM) if row in strongest else (colour, STEM) for row in hits]
        colours, widths = zip(*stems, strict=True)
        axes.add_collection(LineCollection([*lines[hits]], colors=colours, linewidths=widths))
        look = mark | {"linestyle": "", "clip_on": False}
        form = MARK_SCALES.get(mark["marker"], 1.0)
        axes.plot(times[hits], tops[hits], **look, markersize=form * IMPACT_DOT, label=label)
        plot_copies(axes, np.stack([times, tops, shifts])[:, hits], look | {"markersize": form * IMPACT_DOT})
        for row in strongest & {*hits.tolist()}:
            peak_style = {"color": PEAK_COLOUR, "markersize": form * IMPACT_DOT, "label": "_", "zorder": 2.1}
            axes.plot(times[row], tops[row], **look | peak_style)
        goes_on = hits[ends[hits] - onsets[hits] > SEEN_CONTACT * span]
        if len(goes_on) and not are_told(figure, recording, goes_on):
            draw_contacts(axes, np.stack([onsets, ends])[:, goes_on], lanes, name, colour)
            lanes += 1
    if lanes:
        axes.axhline(0.0, color=GREY, linewidth=STEM, zorder=0.9)
        axes.spines["bottom"].set_position(("outward", ROWS_GAP + lanes * ROW))
    has_stops, has_walls = bool(is_at_stop.any()), not is_at_stop.all() or not len(is_at_stop)
    # the names of the rows of contacts are below the axis, at its left
    name = scaled_name(axes.yaxis, *shown_values(recording, is_stop=not has_walls))
    axes.set_ylabel(name, loc="bottom" if lanes else "center")
    headroom = COLUMN_HEADROOM if figure.get_figwidth() <= COLUMN else HEADROOM
    axes.set_ylim(0.0, headroom * (tops.max(initial=0.0) or 1.0))
    if has_stops and has_walls:
        functions: Any = (lambda v: v / scale, lambda v: v * scale)
        right = axes.secondary_yaxis("right", functions=functions)
        _, unit, values = shown_values(recording, is_stop=True)
        right.set_ylabel(scaled_name(right.yaxis, "at stops", unit, values))
        axes.spines["right"].set_visible(True)
    if len(times):
        handles, _ = axes.get_legend_handles_labels()
        if lanes:
            handles.append(Line2D([], [], color=GREY, linewidth=CONTACT, label="in contact"))
        if mark_text := late_mark_text(recording):
            stem: dict[str, Any] = {"color": INK, "marker": "|", "markersize": STEM_KEY}
            handles.append(Line2D([], [], linestyle="", markeredgewidth=STEM, label=mark_text, **stem))
        legend_above(axes, handles)
    else:
        axes.text(0.5, 0.5, "no impact", transform=axes.transAxes, ha="center", color=INK)
    show_all_time(axes, recording)


def plot_copies(axes: Axes, marks: np.ndarray, look: dict[str, Any]) -> None:
    """Draw copies of the marks that other marks cover; ``marks`` has times, heights and ``mark_shifts``."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    for shift in np.unique(marks[2][marks[2] > 0.0]):
        shifted_transform = axes.transData + ScaledTranslation(-shift / 72.0, 0.0, figure.dpi_scale_trans)
        axes.plot(*marks[:2, marks[2] == shift], **look, label="_", zorder=1.9, transform=shifted_transform)


def legend_names(names: Sequence[str], *, is_narrow: bool) -> list[str]:
    """Return the labels of groups; of many in a narrow figure, only the first point has the word "point"."""
    first = next((name for name in names if name.startswith(POINT)), "")
    is_brief = is_narrow and len(names) > MOST_WHOLE_NAMES
    return [name.removeprefix(POINT) if is_brief and name != first else name for name in names]


def are_told(figure: Figure, recording: Recording, rows: np.ndarray) -> bool:
    """Return whether a panel of dry friction in the figure shows the contacts of the impacts in ``rows``."""
    if all(axes.get_label() != "friction" for axes in figure.axes):
        return False
    shown_locations = rubbing_locations(recording)[:MOST_ROWS]
    walls, names = recording.wall_names, recording.point_names
    return all(element_label(recording.impacts[row], walls, names) in shown_locations for row in rows)


def late_mark_text(recording: Recording) -> str:
    """Return words for the times at which marks stand; "" if they all stand at the onsets."""
    is_late = impacts_at_peaks(recording)["onset"] > recording.impacts["onset"]
    name, *_ = shown_values(recording, is_stop=bool(recording.is_at_joint_stop[is_late].all()))
    return f"impact, at its {name}" if is_late.any() else ""


def draw_contacts(axes: Axes, spans: np.ndarray, lane: int, name: str, colour: str) -> None:
    """Draw the contacts of a group, such as a point, a joint or "others", as lines in a row below the axes.

    ``spans`` has start and end of each contact [s], shape (2, C). ``lane`` is the number of the row; row 0 is
    next to the axes. ``name`` is the name of the group, of which ``number_of`` stands at the left.
    """
    figure = axes.get_figure(root=True)
    assert figure is not None
    depth = ROWS_GAP + (0.5 + lane) * ROW  # [points] the distance of the row below the axes' lower edge
    shift_below = ScaledTranslation(0.0, -depth / 72.0, figure.dpi_scale_trans)
    look: dict[str, Any] = {"color": colour, "linewidth": CONTACT, "alpha": 0.5, "zorder": 1.0}
    look["transform"] = axes.get_xaxis_transform() + shift_below
    # contacts with two walls at a time are one line, which is not darker there
    joined_spans: list[list[float]] = []
    for start, end in sorted(spans.T.tolist()):
        if joined_spans and start <= joined_spans[-1][1]:
            joined_spans[-1][1] = max(end, joined_spans[-1][1])
        else:
            joined_spans.append([start, end])
    lines = axes.hlines(np.zeros(len(joined_spans)), *np.transpose(joined_spans), **look)
    # the lines are below the axes; they are cut off only at the left and right edge of the axes
    lines.set_clip_path(Rectangle((0.0, -1.0), 1.0, 2.0, transform=axes.transAxes))
    lines.set_in_layout(False)
    text_style: dict[str, Any] = {"xycoords": "axes fraction", "textcoords": "offset points"}
    text_style |= {"ha": "right", "va": "center", "fontsize": "small", "annotation_clip": False, "gid": LANE}
    axes.annotate(number_of(name), (0.0, 0.0), (-NAME_GAP, -depth), **text_style)


def shown_values(recording: Recording, *, is_stop: bool) -> tuple[str, str, np.ndarray]:
    """Return what marks at walls or, if ``is_stop``, at stops of joints show: words, unit, values (I,).

    The values are those of ``impact_values`` or, if ``impact_values`` gives only zeros, impact speeds. An
    impact at a stop of a joint has the value 0 unless ``is_stop``, and any other impact has the value 0 if
    ``is_stop``.
    """
    name, unit, values = impact_values(recording, is_stop=is_stop)
    if not values.any():
        speeds = recording.impacts["impact_speed"] * (recording.is_at_joint_stop == is_stop)
        name, unit, values = "impact speed", speed_unit(is_stop), speeds
    return name, unit, values


def scaled_name(axis: Axis, name: str, unit: str, values: np.ndarray) -> str:
    """Give the numbers of an axis a unit whose prefix suits ``values``; return ``name`` with this unit."""
    factor, unit = load_unit(values.max(initial=0.0), unit)
    scale_numbers(axis, factor)
    return f"{name} [{unit}]"


def stop_scale(recording: Recording) -> float:
    """Return the factor from values at stops of joints to heights in the panel, whose axis is that of walls.

    With this factor, the largest value at walls and the largest one at stops of joints have the same height.
    The factor is 1 if one of these values is 0 or missing.
    """
    at_walls, at_stops = (
        shown_values(recording, is_stop=is_stop)[-1].max(initial=0.0) for is_stop in (False, True)
    )
    return float(at_walls / at_stops) if min(at_walls, at_stops) > 0.0 else 1.0


def marks_of(recording: Recording) -> tuple[np.ndarray, np.ndarray]:
    """Return the position of each impact's mark in the panel: times [s] and heights, each of shape (I,).

    The time is that of the largest force, or else the onset (``impacts_at_peaks``). The height, in the unit
    of the left axis, is the value by ``shown_values`` or, at stops of joints, this value times
    ``stop_scale``.
    """
    at_walls, at_stops = (shown_values(recording, is_stop=is_stop)[-1] for is_stop in (False, True))
    return impacts_at_peaks(recording)["onset"], at_walls + stop_scale(recording) * at_stops


def rows_by_height(tops: np.ndarray) -> np.ndarray:
    """Return the rows of the impacts in the order of the heights of their marks ``tops``, highest first."""
    return np.argsort(-tops, kind="stable")


def common_marks(
    recording: Recording, times: np.ndarray, tops: np.ndarray
) -> dict[tuple[int, int], list[int]]:
    """Return which impacts have marks that look like one: cell of the panel → rows of ``impacts``, ascending.

    Width and height of a cell are ONE_MARK times those of the panel. Cells without marks are left out.
    ``times`` and ``tops`` are the result of ``marks_of``.
    """
    scales = (recording.duration, float(tops.max(initial=0.0)))
    width, height = (ONE_MARK * (scale or 1.0) for scale in scales)
    marks: dict[tuple[int, int], list[int]] = {}
    for row, (time, top) in enumerate(zip(times.tolist(), tops.tolist(), strict=True)):
        marks.setdefault((round(time / width), round(top / height)), []).append(row)
    return marks


def mark_shifts(
    recording: Recording, times: np.ndarray, tops: np.ndarray, groups: Sequence[np.ndarray]
) -> np.ndarray:
    """Return how far a copy of each impact's mark is shifted to the left, shape (I,) [points]; 0 for no copy.

    If marks of several groups coincide, a mark of a group that is drawn later covers the marks of earlier
    groups. The more groups cover a mark, the farther its copy is shifted, so that the copy is visible.
    ``groups`` has the rows of the impacts in each group, in the order of drawing; ``times`` and ``tops`` are
    the result of ``marks_of``.
    """
    shifts, looks = np.zeros(len(recording.impacts)), np.zeros(len(recording.impacts), int)
    for look, hits in enumerate(groups):
        looks[hits] = look
    for rows in common_marks(recording, times, tops).values():
        shown_looks = np.unique(looks[rows])
        covering = len(shown_looks) - np.searchsorted(shown_looks, looks[rows], side="right")
        shifts[rows] += COVERED_SHIFT * covering
    return shifts


def point_groups(recording: Recording, tops: np.ndarray) -> list[tuple[str, dict[str, Any], np.ndarray]]:
    """Return the groups of impacts with a common mark: name, mark, and rows of the impacts.

    Each point with impacts, and each joint with impacts at its stops, has a group. If these would be more
    than MOST_OWN_MARKS groups, only the MOST_OWN_MARKS − 1 with the highest marks are kept, and the first
    group, "others", with a grey mark, has the impacts of all other points and joints. A mark is a dict of
    properties with matplotlib's names. ``tops``: the heights by ``marks_of``.
    """
    impacts = recording.impacts
    names = [short_names(recording, what_touches(recording, row)) for row in impacts]
    members = list(zip(recording.is_at_joint_stop.tolist(), impacts["point"].tolist(), names, strict=True))
    hit = list(dict.fromkeys(members[row] for row in rows_by_height(tops)))
    marked_members = sorted(hit if len(hit) <= MOST_OWN_MARKS else hit[: MOST_OWN_MARKS - 1])
    marks = {
        is_stop: iter(known_marks) for is_stop, known_marks in ((False, POINT_MARKS), (True, STOP_MARKS))
    }
    groups = [
        (member[-1], next(marks[member[0]]), np.array([other_member == member for other_member in members]))
        for member in marked_members
    ]
    is_unmarked = np.array([member not in marked_members for member in members], bool)
    groups = [("others", OTHERS_MARK, is_unmarked), *groups] if is_unmarked.any() else groups
    return [(name, dict(mark), np.flatnonzero(hits)) for name, mark, hits in groups]


def number_impacts(axes: Axes, recording: Recording, used_pixels: UsedPixels) -> None:
    """Write numbers of impacts at their marks, where pixels are free.

    If ``numbered_step`` is a number k > 1, every k-th impact gets a number, if these have room. Otherwise all
    impacts get one or, without room for that, those with the highest marks, as many as have room, and the
    last (``label_subsets``); impacts whose marks coincide share a label (``label_numbers``). A number that
    would be nearer to the mark of another impact has no room, except for every k-th. If an impact in
    ``marked_peaks`` has a label of its own, this label also has the force, moment or impulse, if there is
    room.
    """
    times, heights = marks_of(recording)
    if not len(times):
        return
    step, positions = numbered_step(axes, recording), list(zip(times.tolist(), heights.tolist(), strict=True))
    common_rows = {row: rows for rows in common_marks(recording, times, heights).values() for row in rows}
    strongest = {peak.row: peak.value for peak in marked_peaks(recording)}

    def label(rows: Sequence[int]) -> Label:
        """Return the label of the impacts ``rows`` at the mark of the first one."""
        (text, short), position = label_numbers(rows), positions[rows[0]]
        other_positions = [
            position for row, position in enumerate(positions) if row not in common_rows[rows[0]]
        ]
        if rows[0] in strongest and len(rows) == 1:
            long_text, look = f"{text}: {strongest[rows[0]]}", {"color": PEAK_COLOUR}
            return Label(long_text, position, short=text, look=look, other_marks=other_positions)
        return Label(text, position, short=short, other_marks=other_positions)

    # a number may be wider than the distance of marks: it only must not be nearer to another numbered mark
    kth_rows = range(step - 1, len(times), step) if step > 1 else ()
    tries = [[label([row])._replace(other_marks=()) for row in kth_rows]] if kth_rows else []
    for rows in label_subsets(rows_by_height(heights).tolist()):
        groups = {tuple(sorted(common_rows[row], key=lambda row: -heights[row])) for row in rows}
        if len(groups) <= MOST_NUMBER_LABELS:
            tries.append([label(group) for group in sorted(groups, key=lambda group: -heights[group[0]])])
    last = max(common_rows[len(times) - 1], key=lambda row: heights[row])
    write_first_fitting(axes, tries, used_pixels, spare=positions[last], fontsize="small")


def numbered_step(axes: Axes, recording: Recording) -> int:
    """Return the number k such that only every k-th impact may get a number; 1 if each impact may get one.

    k is 1, 2 or 5 times a power of ten. It exceeds 1 only if the impacts have equal distances in time
    (REGULAR, EQUAL_DISTANCES) that are too short for all numbers.
    """
    onsets = recording.impacts["onset"]
    onset_gaps = np.diff(onsets)
    if len(onset_gaps) < REGULAR or np.ptp(onset_gaps) > EQUAL_DISTANCES * onset_gaps.mean():
        return 1
    # a text of the width that a number needs: the longest number, and two spaces
    probe = axes.text(0.0, 0.0, f"{NUMBER_SIGN}{len(onsets)}  ", fontsize="small")
    width = probe.get_window_extent().width
    probe.remove()
    ends = axes.transData.transform([(onsets[0], 0.0), (onsets[-1], 0.0)])[:, 0]
    gap = float(np.ptp(ends)) / len(onset_gaps)
    steps: Iterator[int] = (step * 10**power for power in count() for step in (1, 2, 5))
    return next(step for step in steps if step * gap >= width or step >= len(onset_gaps))
