"""Curves that a reader can distinguish: dashes for coincident curves, bands for grey and fast curves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from chain_impact.pictures.drawing.colours import GREY

MOST_GREY = 2  # the largest number of grey curves that are drawn as curves; more are drawn as one band
# the opacity of a band, from 0 to 1, and the width of the line at its edge [points]
BAND_OPACITY, BAND_EDGE = 0.45, 0.5
BIN = 4.0  # [points] the width of the parts into which the axes are divided
# a curve is fast at a part if it has at least so many turns, two in each period, in this part and the parts
# beside it
FAST_TURNS = 6
FAST_PART = 0.2  # a curve is fast if it is fast at more than this share of the parts
# a turn counts if the value changes at least by this until the next turn, relative to the range of all curves
LEAST_TURN = 0.05
# the largest distance of two curves that look like one curve, relative to the range of all compared curves
SAME_CURVE = 0.005
# lines coincide where their distance, relative to the range of all lines, is at most this
MERGING_DISTANCE = 0.008
PIECES = 600  # the number of points of a line at which the distance is measured
LEAST_DASHED = 0.05  # the least length of a part with dashes, relative to the range of all lines
DASH = 3.0  # the length of a dash, in line widths
AREA_OPACITY = 0.2  # the opacity of the area for a fast curve, from 0 to 1
FAST_ENTRY = "pale: range of an oscillation, line: mean"


def draw_band(
    axes: Axes, x_values: np.ndarray, curves: np.ndarray | Sequence[np.ndarray], label: str | None = None
) -> None:
    """Fill in grey, at each position, the range from the least to the largest value of some curves.

    The area has gaps where all curves lack a value. ``x_values``: the positions on the horizontal axis, shape
    (T,); ``curves``: values, each of shape (T,); ``label``: the text in the legend, None for no entry.
    """
    finite_curves = np.ma.masked_invalid(curves)
    ends = finite_curves.min(axis=0).filled(np.nan), finite_curves.max(axis=0).filled(np.nan)
    look: dict[str, Any] = {"facecolor": (GREY, BAND_OPACITY), "edgecolor": GREY, "linewidth": BAND_EDGE}
    axes.fill_between(x_values, *ends, **look, label=label)


def plot_curves(
    axes: Axes, x_values: np.ndarray, curves: Sequence[tuple[np.ndarray, dict[str, Any]]]
) -> None:
    """Draw curves; a fast curve (``is_fast``) is drawn as its range and its mean (``envelope``).

    The range is a pale area, the mean a line. If there is a fast curve, an entry of the legend explains both;
    the area there is grey if areas have different colours.

    Args:
        axes: the axes to draw into.
        x_values: the positions on the horizontal axis, shape (T,).
        curves: values, shape (T,), and properties with matplotlib's names, for each curve.
    """
    figure = axes.get_figure(root=True)
    assert figure is not None
    bins = max(1, int(axes.get_window_extent().width * 72.0 / figure.dpi / BIN))
    ends = [(np.nanmin(values), np.nanmax(values)) for values, _ in curves if np.isfinite(values).any()]
    least_turn = LEAST_TURN * float(np.ptp(ends)) if ends else 0.0
    fast_curves = [k for k, (values, _) in enumerate(curves) if is_fast(x_values, values, bins, least_turn)]
    for k, (values, look) in enumerate(curves):
        if k not in fast_curves:
            axes.plot(x_values, values, **look)
            continue
        low, high, mean = envelope(x_values, values, least_turn)
        axes.fill_between(
            x_values, low, high, color=look["color"], alpha=AREA_OPACITY, linewidth=0.0, zorder=1.8
        )
        axes.plot(x_values, mean, **look)
    if fast_curves:
        colour, *other_colours = {curves[k][1]["color"] for k in fast_curves}
        colour, alpha = (GREY, BAND_OPACITY) if other_colours else (colour, AREA_OPACITY)
        axes.plot([], [], color=colour, alpha=alpha, linewidth=5.0, solid_capstyle="butt", label=FAST_ENTRY)


def dash_lines(axes: Axes, lines: Sequence[Line2D]) -> None:
    """Give lines of ``axes`` dashes where they coincide, so that each of them is visible.

    A line keeps its label and its solid parts; the parts with dashes are further lines. A line with missing
    values stays as it is.
    """
    points_of = {line: np.array(line.get_data(), float) for line in lines}
    whole_lines = {line: points for line, points in points_of.items() if np.isfinite(points).all()}
    parts = parts_with_dashes([*whole_lines.values()])
    for line, own_parts in zip(whole_lines, parts, strict=True):
        styles: dict[Any, list[np.ndarray]] = {}
        for points, dashes in own_parts:
            styles.setdefault(dashes, []).append(np.append(points, [[math.nan]] * 2, axis=1))
        if len(own_parts) == 1 and None in styles:
            continue
        line.set_data(np.concatenate(styles.pop(None, [np.zeros((2, 0))]), axis=1))
        look: dict[str, Any] = {"color": line.get_color(), "linewidth": line.get_linewidth()}
        for dashes, pieces in styles.items():
            joined_part = np.concatenate(pieces, axis=1)
            axes.plot(*joined_part, **look, linestyle=dashes, zorder=line.get_zorder(), label="_")


def merged_dashes(lines: Sequence[np.ndarray]) -> list[Any]:
    """Return for each line a style of dashes if it merges with the first line of a group, else None.

    Lines merge if the median of their distances is small (MERGING_DISTANCE). A line that merges with the
    first line of no group is itself the first line of a new group. The caller draws the first line of a group
    without dashes, below the other lines of the group, whose dashes alternate (``_dashes``).

    Args:
        lines: x and y of each line, each of shape (2, S), in the same axes.

    Returns:
        The styles, as matplotlib takes them.
    """
    evenly = [_points_at(*measured_line) for measured_line in _measure_lines(lines)]
    groups: dict[int, list[int]] = {}
    for k, line in enumerate(evenly):
        distinct_dashes = {
            j: max(np.median(_distances(*pair)) for pair in ((evenly[j], line), (line, evenly[j])))
            for j in groups
        }
        groups.setdefault(next((j for j in groups if distinct_dashes[j] <= MERGING_DISTANCE), k), []).append(
            k
        )
    dashes: list[Any] = [None] * len(lines)
    for group in groups.values():
        for index, k in enumerate(group[1:]):
            dashes[k] = _dashes(index, len(group) - 1)
    return dashes


def parts_with_dashes(lines: Sequence[np.ndarray]) -> list[list[tuple[np.ndarray, Any]]]:
    """Return for each line its parts: points, shape (2, S), and a style of dashes, or None for a solid part.

    Where lines nearly coincide (MERGING_DISTANCE), the first of them is solid, and the dashes of the others,
    which are drawn above it, alternate (``_dashes``). Elsewhere, and over lengths below LEAST_DASHED, a line
    is solid. If all lines have the same x, they are compared at each x, so that narrow peaks count, too.

    Args:
        lines: x and y of each line, each of shape (2, S), in the same axes.

    Returns:
        The parts in their order along each line, with dashes as matplotlib takes them.
    """
    measured_lines, parts = _measure_lines(lines), []
    has_one_x = all(np.array_equal(line[0], lines[0][0]) for line in lines)
    if has_one_x:
        measured_lines = [(scaled_line, way, way) for scaled_line, way, _ in measured_lines]
    evenly = [_points_at(*measured_line) for measured_line in measured_lines]
    for k, (line, (_, way, lengths)) in enumerate(zip(lines, measured_lines, strict=True)):
        merged_parts = np.array(
            [
                (np.abs(evenly[k][1] - other_points[1]) if has_one_x else _distances(evenly[k], other_points))
                <= MERGING_DISTANCE
                for other_points in evenly
            ]
        )
        # the number of lines at each place that are below this line, and of all that are above the first one
        count_below, count_above = merged_parts[:k].sum(axis=0), merged_parts.sum(axis=0) - 1
        looks = np.where(count_below > 0, len(lines) * count_below + count_above, 0)
        for start, end in _runs(looks):
            looks[start:end] *= lengths[end - 1] - lengths[start] >= LEAST_DASHED
        own_parts = []
        for start, end in _runs(looks):
            first, last = lengths[start], lengths[min(end, len(lengths) - 1)]
            part_lengths = np.concatenate([[first], way[(way > first) & (way < last)], [last]])
            dashes = _dashes(int(count_below[start]) - 1, int(count_above[start])) if looks[start] else None
            own_parts.append((_points_at(line, way, part_lengths), dashes))
        parts.append(own_parts)
    return parts


def coincide(line: np.ndarray, other_line: np.ndarray) -> bool:
    """Return whether two lines in the same axes, x and y of shape (2, S), coincide everywhere.

    No distance of a point of one line from the other line is above MERGING_DISTANCE.
    """
    evenly = [_points_at(*measured_line) for measured_line in _measure_lines([line, other_line])]
    return all(_distances(*pair).max() <= MERGING_DISTANCE for pair in (evenly, evenly[::-1]))


def _dashes(index: int, count: int) -> tuple[float, tuple[float, float]]:
    """Return the dashes of one of ``count`` lines above a solid line: one dash of each line, and then a gap.

    The solid line is visible through the gap. ``index`` is the number of the line, from 0.
    """
    return -DASH * index, (DASH, DASH * count)


def _measure_lines(lines: Sequence[np.ndarray]) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Return each line relative to the range of all, the lengths of the way at its points, and PIECES places.

    The places have equal distances, from 0 to the length of the line.
    """
    if not lines:
        return []
    low, high = (np.array([end(line, axis=1) for line in lines]) for end in (np.min, np.max))
    span = high.max(axis=0) - low.min(axis=0)
    scaled_lines = [line / np.where(span > 0.0, span, 1.0)[:, None] for line in lines]
    ways = [np.append(0.0, np.hypot(*np.diff(line)).cumsum()) for line in scaled_lines]
    return [
        (line, way, np.linspace(0.0, way[-1], PIECES)) for line, way in zip(scaled_lines, ways, strict=True)
    ]


def _distances(points: np.ndarray, other_points: np.ndarray) -> np.ndarray:
    """Return the distance of each point, shape (2, P), from the nearest of ``other_points``, shape (2, Q)."""
    from scipy.spatial import KDTree  # this import takes long

    return np.asarray(KDTree(other_points.T).query(points.T)[0])


def _runs(values: np.ndarray) -> list[tuple[int, int]]:
    """Return start and stop of each range of indices over which ``values`` are equal."""
    return list(pairwise([0, *(np.flatnonzero(np.diff(values)) + 1).tolist(), len(values)]))


def _points_at(line: np.ndarray, way: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Return the points of a line at some ``lengths``, the lengths of the way along the line, shape (2, P).

    ``line`` has the shape (2, S); ``way`` has the length of the way at each of its points, shape (S,).
    """
    return np.array([np.interp(lengths, way, part) for part in line])


def is_fast(x_values: np.ndarray, values: np.ndarray, bins: int, least_turn: float) -> bool:
    """Return whether a curve turns so often that, drawn as a line, it would look like an area.

    The axis is divided into ``bins`` equal parts. The result is True if, at more than FAST_PART of the parts,
    the part and the parts beside it have at least FAST_TURNS turns. So a range (``envelope``) contains whole
    periods, and a slow curve with steep flanks is no fast curve. A turn counts only if the value changes by
    at least ``least_turn`` from this turn to the next turn; the last turn always counts. The result is False
    for a curve with missing values, or with at most ``bins`` rows. ``x_values`` and ``values`` have the shape
    (T,).
    """
    if not np.isfinite(values).all() or len(x_values) <= bins:
        return False
    steps = np.diff(values)
    turn_rows = np.flatnonzero(steps[1:] * steps[:-1] < 0.0) + 1
    is_large = np.abs(np.diff(values[turn_rows], append=np.inf)) >= least_turn
    counts, _ = np.histogram(x_values[turn_rows[is_large]], bins, (x_values[0], x_values[-1]))
    counts_of_three = np.convolve(counts, np.ones(3))[1:-1]
    return bool((counts_of_three >= FAST_TURNS).mean() > FAST_PART)


def turning_rows(values: np.ndarray, least_turn: float) -> list[int]:
    """Return the first row of a curve, and the rows at which it turns.

    A turn counts if the value has changed by at least ``least_turn`` since the turn before; the last row may
    count as a turn, too. ``values`` has the shape (T,) and no missing value.
    """
    steps = np.diff(values)
    moved_rows = np.flatnonzero(steps)  # the curve does not turn in the middle of equal values
    turn_rows = moved_rows[1:][steps[moved_rows[1:]] * steps[moved_rows[:-1]] < 0.0]
    turn_chain, way = [0], 0.0
    for row in [*turn_rows.tolist(), len(values) - 1]:
        change = float(values[row] - values[turn_chain[-1]])
        if way * change > 0.0:
            turn_chain[-1] = row
        elif abs(change) >= least_turn:
            turn_chain.append(row)
            way = change
    return turn_chain


def envelope(
    x_values: np.ndarray, values: np.ndarray, least_turn: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the least values, the largest values and the mean of a fast curve, each of shape (T,).

    The least and the largest values join the lower and the upper turns of the curve (``turning_rows``), and
    contain the curve from its first to its last row. The mean is that of each period, from one upper turn to
    the next one, at the middle of the period, and linear between these; without a whole period, it is that of
    the whole curve. ``x_values`` and ``values`` have the shape (T,).
    """
    rows = np.array(turning_rows(values, least_turn))
    ends = []
    for sign in (-1.0, 1.0):
        sizes = sign * values[rows]
        neighbour_sizes = np.concatenate([[-np.inf], sizes, [-np.inf]])
        turn_rows = rows[(sizes >= neighbour_sizes[:-2]) & (sizes >= neighbour_sizes[2:])]
        ends.append(
            sign
            * np.maximum(sign * values, sign * np.interp(x_values, x_values[turn_rows], values[turn_rows]))
        )
    areas = np.append(0.0, np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(x_values)))
    turn_rows = turn_rows[(turn_rows > 0) & (turn_rows < len(x_values) - 1)]
    if len(turn_rows) < 2:  # noqa: PLR2004 - no whole period
        turn_rows = np.array([0, len(x_values) - 1])
    mean_values = np.diff(areas[turn_rows]) / np.diff(x_values[turn_rows])
    middles = 0.5 * (x_values[turn_rows][1:] + x_values[turn_rows][:-1])
    return ends[0], ends[1], np.interp(x_values, middles, mean_values)
