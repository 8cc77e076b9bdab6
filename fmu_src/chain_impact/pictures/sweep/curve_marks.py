"""The lines and marks of curves of a sweep: where lines break, and how marks at one place are all visible."""

# Tests: pictures/sweep/curves.py

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from chain_impact.pictures.drawing.row_names import POINTS_IN_INCH
from chain_impact.pictures.sweep.quantities import COUNT, LOADS, Quantity
from chain_impact.study_data.sweep.runs import SweepRuns
from chain_impact.variables.peaks import PEAKS

MARKS_OF_LINE = 4  # about the number of marks of each of several lines with many points
MARK_SIZE, MARK_EDGE = 3.0, 0.9  # [points] the size of a mark, and the width of the edge of a ring
# a ring is larger than the next mark in it by RING_STEP [points], or less if rings of neighbours would meet
RING_STEP = 2.8
HIDING_DISTANCE = 1.8  # [points] a mark hides another one up to this distance along both axes
# A panel has lines if at least LEAST_JOINED of the pairs of neighbours in it are joined: a few joined pairs
# among points would look like a feature.
LEAST_JOINED = 0.5
# A largest value, such as a peak force, jumps between two neighbours if the step there exceeds LARGE_STEP
# times the steps beside it in the same direction, and SMALL_STEP times the range of the line. A step back
# is no course that a step continues: a single high value has a jump on both sides. Lines of fewer than
# FEWEST_STEPS steps have too few of them to compare.
LARGE_STEP = 2.0
SMALL_STEP = 0.02
FEWEST_STEPS = 4


def is_largest_value(quantity: Quantity) -> bool:
    """Return whether a quantity is the largest value of a run, which a further impact need not change."""
    return quantity.column in (*PEAKS, *LOADS)


def joined_pairs(runs: SweepRuns, quantity: Quantity, lines: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Return for each line in a panel whether a segment joins each point with the next one, shape (R - 1,).

    Two points with values are joined if their runs have the same number of impacts; points of a largest value
    also if the value does not jump between them. If fewer than LEAST_JOINED of all pairs of successive points
    with values are joined, none is.
    ``lines``: the indices of the runs of each line, in the order of the line, shape (R,).
    """
    values, joined_lines = quantity.values_or_nan(runs), list[np.ndarray]()
    known_lines = known_pairs(runs, quantity, lines)
    for rows, are_known in zip(lines, known_lines, strict=True):
        is_joined = np.diff(runs[COUNT][rows]) == 0
        if is_largest_value(quantity):
            is_joined = is_joined | ~jumps_between(values[rows])
        joined_lines.append(is_joined & are_known)
    if pair_count(joined_lines) < LEAST_JOINED * pair_count(known_lines):
        return [np.zeros_like(joined) for joined in joined_lines]
    return joined_lines


def known_pairs(runs: SweepRuns, quantity: Quantity, lines: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Return for each line of ``joined_pairs`` whether each point and the next one have values."""
    is_known = np.isfinite(quantity.values_or_nan(runs))
    return [is_known[rows[1:]] & is_known[rows[:-1]] for rows in lines]


def pair_count(lines: Sequence[np.ndarray]) -> int:
    """Return the number of pairs in all lines; each line has True for each pair, shape (R - 1,)."""
    return sum(int(pairs.sum()) for pairs in lines)


def jumps_between(values: np.ndarray) -> np.ndarray:
    """Return whether values jump between neighbours, shape (R - 1,); True without steps to compare with."""
    steps = np.diff(values)
    if np.isfinite(steps).sum() < FEWEST_STEPS:
        return np.ones(len(steps), bool)
    known_steps, directions = np.nan_to_num(steps), np.sign(np.nan_to_num(steps))
    previous_steps, next_steps = np.append(0.0, known_steps[:-1]), np.append(known_steps[1:], 0.0)
    neighbour_steps = np.maximum(directions * previous_steps, directions * next_steps)
    small_step = SMALL_STEP * (np.nanmax(values) - np.nanmin(values))
    return np.asarray(~(np.abs(steps) <= np.maximum(LARGE_STEP * neighbour_steps, small_step)))


def broken_line(points: np.ndarray, is_joined: np.ndarray) -> np.ndarray:
    """Return the points of a line, shape (2, S), with a gap, NaN, wherever two of them are not joined.

    ``points`` has the shape (2, R), ``is_joined`` the shape (R - 1,).
    """
    return np.insert(points.astype(float), np.flatnonzero(~is_joined) + 1, np.nan, axis=1)


def has_marks(curve: np.ndarray, is_joined: np.ndarray, place: int, line_count: int) -> np.ndarray:
    """Return which points of a line with dots, shape (2, R), have marks, too, shape (R,).

    These are the points that no line joins with others and, of the line number ``place`` of several lines,
    about MARKS_OF_LINE points, which are other ones in each line, so that no mark hides another one.
    ``is_joined`` has the shape (R - 1,).
    """
    count = curve.shape[1]
    is_alone = ~(np.append(is_joined, False) | np.append(False, is_joined))
    if line_count == 1:
        return np.asarray(is_alone)
    step = max(1, round(count / (MARKS_OF_LINE * line_count))) * line_count
    return np.asarray(is_alone | (np.arange(count) % step == place * step // line_count))


def ring_hidden_marks(axes: Axes, curves: Sequence[np.ndarray], looks: Sequence[dict[str, Any]]) -> None:
    """Draw a ring for each mark that marks of later curves hide, around these, in the shape of the mark.

    The axes must have their scales and ends. ``curves``: x and y of each curve's points, shape (2, R);
    ``looks``: colour and marker of each curve, with matplotlib's names.
    """
    figure = axes.get_figure(root=True)
    assert figure is not None
    points_of = [
        axes.transData.transform(curve[:, np.isfinite(curve[1])].T) * POINTS_IN_INCH / figure.dpi
        for curve in curves
    ]
    hidden_counts = [
        sum(
            (_are_near(points, later_points) for later_points in points_of[k + 1 :]),
            np.zeros(len(points), int),
        )
        for k, points in enumerate(points_of)
    ]
    most_hiding = max((int(counts.max(initial=0)) for counts in hidden_counts), default=0)
    if not most_hiding:
        return
    positions = np.unique(np.concatenate(points_of)[:, 0].round(3))
    room = float(np.diff(positions).min()) if len(positions) > 1 else np.inf
    step = min(RING_STEP, max(0.0, room - MARK_SIZE - MARK_EDGE) / most_hiding)
    for curve, counts, look in zip(curves, hidden_counts, looks, strict=True):
        shown_points = curve[:, np.isfinite(curve[1])]
        for count in np.unique(counts[counts > 0]).tolist():
            ring: dict[str, Any] = {"markersize": MARK_SIZE + step * count, "markerfacecolor": "none"}
            ring |= {
                "markeredgewidth": MARK_EDGE,
                "linestyle": "",
                "clip_on": False,
                "zorder": 2.5,
                "label": "_",
            }
            axes.plot(*shown_points[:, counts == count], **look | ring)


def _are_near(points: np.ndarray, other_points: np.ndarray) -> np.ndarray:
    """Return 1 for each point, shape (P, 2), that one of ``other_points``, shape (Q, 2), hides, else 0."""
    distances = np.abs(points[:, None] - other_points[None]).max(axis=2)
    return np.asarray((distances <= HIDING_DISTANCE).any(axis=1), int)
