"""Curves that a reader can distinguish: dashes where curves merge, bands for grey curves or oscillations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from chain_impact.pictures.style import GREY

MOST_GREY = 2  # up to this number of grey curves are drawn as curves; more grey curves are drawn as a band
SOFT = 0.45  # the opacity of a band, from 0 to 1
# A curve is fast if it turns at least twice, which is a period, within BIN [points] in more than FAST_PART of
# the width of the axes. Turns count from LEAST_TURN on, relative to the range of all curves in the axes.
BIN, FAST_PART, LEAST_TURN = 4.0, 0.2, 0.05
# the largest distance of two curves that look like one curve, relative to the height of the panel
SAME = 0.005
# MERGED: the largest usual distance of two lines that merge, relative to the range of all lines; PIECES: the
# number of points of a line at which this distance is measured; DASH: the length of a dash, in line widths
MERGED, PIECES, DASH = 0.008, 200, 3.0
BAND_EDGE, STRIPE = 1.2, 0.7  # [points] the width of the edges of an oscillation's range, and of its stripes
FAST = "stripes: range of a fast oscillation"
# the dashes of the line in the legend that stands for stripes, relative to the line's width
STRIPED = (0.0, (0.25, 0.35))


def fill_band(
    axes: Axes, along: np.ndarray, curves: np.ndarray | Sequence[np.ndarray], label: str | None = None
) -> None:
    """Fill the area between the least and the largest of some curves, with gaps where values are missing."""
    known = np.ma.masked_invalid(curves)
    ends = known.min(axis=0).filled(np.nan), known.max(axis=0).filled(np.nan)
    axes.fill_between(along, *ends, color=GREY, alpha=SOFT, linewidth=0.0, label=label)


def plot_curves(axes: Axes, along: np.ndarray, curves: Sequence[tuple[np.ndarray, dict[str, Any]]]) -> None:
    """Draw curves, each with its properties in matplotlib's names, and a fast oscillation as its range.

    The range has stripes between its least and its largest values; stripes of several curves are side by
    side, so that no colour covers another. An entry of the legend explains the stripes.
    """
    figure = axes.get_figure(root=True)
    assert figure is not None
    bins = max(1, int(axes.get_window_extent().width * 72.0 / figure.dpi / BIN))
    ends = [(np.nanmin(values), np.nanmax(values)) for values, _ in curves if np.isfinite(values).any()]
    least = LEAST_TURN * float(np.ptp(ends)) if ends else 0.0
    fast = [k for k, (values, _) in enumerate(curves) if is_fast(along, values, bins, least)]
    for k, (values, look) in enumerate(curves):
        if k not in fast:
            axes.plot(along, values, **look)
            continue
        at, low, high = envelope(along, values, bins)
        places = np.linspace(at[0], at[-1], 2 * len(at))[fast.index(k) :: len(fast)]
        ends_there = [np.interp(places, at, edge) for edge in (low, high)]
        axes.vlines(places, *ends_there, color=look["color"], linewidth=STRIPE, zorder=1.8)
        for edge, label in ((low, "_"), (high, look["label"])):
            axes.plot(at, edge, **look | {"linewidth": BAND_EDGE, "label": label})
    if fast:
        axes.plot([], [], color=GREY, linestyle=STRIPED, linewidth=5.0, label=FAST)


def hides(curves: Sequence[np.ndarray], same: float = SAME, share: float = 1.0) -> list[int]:
    """Return, for each curve, the number of earlier curves that it would hide because they look the same.

    A curve that would hide others is dashed, so that they are seen through its gaps.

    Args:
        curves: the curves, each of shape (T,).
        same: the largest distance of curves that look the same, relative to the range of all curves.
        share: the least part of the rows in which such curves look the same.
    """
    every = [curve[np.isfinite(curve)] for curve in curves]
    whole = np.concatenate(every) if every else np.zeros(0)
    seen = same * float(np.ptp(whole)) if whole.size else 0.0
    return [
        sum(bool(np.quantile(np.abs(curve - other), share) <= seen) for other in curves[:k])
        for k, curve in enumerate(curves)
    ]


def merged_dashes(lines: Sequence[np.ndarray]) -> list[Any]:
    """Return dashes, as a style of matplotlib, for each line that merges with an earlier one.

    For any other line the result is None.

    The first of some lines that merge is without dashes, below the others. The dashes of the other lines
    follow each other along the line, with a gap through which the first line is seen.

    Args:
        lines: x and y of each line, each of shape (2, S), in the same axes.
    """
    if not lines:
        return []
    low, high = (np.array([end(line, axis=1) for line in lines]) for end in (np.min, np.max))
    span = high.max(axis=0) - low.min(axis=0)
    evenly = [_evenly(line / np.where(span > 0.0, span, 1.0)[:, None]) for line in lines]
    groups: dict[int, list[int]] = {}
    for k, line in enumerate(evenly):
        first = next((j for j in groups if _apart(evenly[j], line) <= MERGED), k)
        groups.setdefault(first, []).append(k)
    dashes: list[Any] = [None] * len(lines)
    for group in groups.values():
        others = group[1:]
        for place, k in enumerate(others):
            dashes[k] = (-DASH * place, (DASH, DASH * len(others)))
    return dashes


def _evenly(line: np.ndarray) -> np.ndarray:
    """Return PIECES points at equal distances along a line of shape (2, S), as shape (2, PIECES)."""
    way = np.concatenate([[0.0], np.hypot(*np.diff(line)).cumsum()])
    at = np.linspace(0.0, way[-1], PIECES)
    return np.array([np.interp(at, way, part) for part in line])


def _apart(first: np.ndarray, second: np.ndarray) -> float:
    """Return the usual distance of two lines: the larger median of the distances from one to the other."""
    distances = np.hypot(*(first[:, :, None] - second[:, None, :]))
    return float(max(np.median(distances.min(axis=along)) for along in (0, 1)))


def is_fast(along: np.ndarray, values: np.ndarray, bins: int, least: float) -> bool:
    """Return whether a curve turns so often that, drawn as a line, it would look like an area.

    A turn counts if the value changes by at least ``least`` until the next turn. The result is False for a
    curve with missing values, or with at most ``bins`` rows.
    """
    if not np.isfinite(values).all() or len(along) <= bins:
        return False
    steps = np.diff(values)
    turns = np.flatnonzero(steps[1:] * steps[:-1] < 0.0) + 1
    large = np.abs(np.diff(values[turns], append=np.inf)) >= least
    counts, _ = np.histogram(along[turns[large]], bins, (along[0], along[-1]))
    return bool((counts > 1).mean() > FAST_PART)


def envelope(along: np.ndarray, values: np.ndarray, bins: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Divide an axis into ``bins`` equal parts; return their middles, and their least and largest values.

    The values of a part include those of its neighbours, so that the edges do not follow the oscillation.
    """
    edges = np.linspace(along[0], along[-1], bins + 1)
    starts = np.searchsorted(along, edges)
    around = [slice(starts[max(k - 1, 0)], max(starts[min(k + 2, bins)], 1)) for k in range(bins)]
    low = np.array([values[part].min(initial=np.inf) for part in around])
    high = np.array([values[part].max(initial=-np.inf) for part in around])
    known = np.isfinite(low)
    return (0.5 * (edges[1:] + edges[:-1]))[known], low[known], high[known]
