"""Histograms of a sweep: how its results are distributed over the samples."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from chain_impact.pictures.dark import SKY
from chain_impact.pictures.legends import legend_above
from chain_impact.pictures.style import COUNT_STEPS, INK, give_ticks
from chain_impact.recording.map_colours import spread
from chain_impact.scene.unit_text import with_unit
from chain_impact.studies.sweep.maps import NEVER, WIDE_RANGE
from chain_impact.studies.sweep.quantities import Quantity
from chain_impact.studies.sweep.runs import Runs

QUANTILES = {0.05: ":", 0.5: "-", 0.95: ":"}
"""Quantile → matplotlib's style of the line that marks it in each panel."""
# the largest number of bars; more would be so narrow that they show mainly random differences
MOST_BINS = 60
ONE_BAR_SPREAD = 1e-9  # values share one bar if their range, relative to the largest |value|, is at most this


def draw_histograms(panels: Sequence[Axes], runs: Runs, quantities: Sequence[Quantity]) -> None:
    """Draw a histogram of each quantity in its panel, with the number of runs upwards, and the QUANTILES.

    Runs without a value are left out: runs that failed and, for peaks of forces, runs with impulses.
    """
    for axes, quantity in zip(panels, quantities, strict=True):
        values = quantity.of(runs)
        values = values[np.isfinite(values)]
        axes.set(xlabel=quantity.label, ylabel="runs")
        if not values.size:
            axes.text(0.5, 0.5, NEVER, transform=axes.transAxes, ha="center", color="0.4")
            continue
        logarithmic = spread(values) >= WIDE_RANGE
        axes.set_xscale("log" if logarithmic else "linear")
        edges = edges_of(values, logarithmic=logarithmic, whole=quantity.is_count)
        axes.hist(values, edges.tolist(), color=SKY, edgecolor=INK, linewidth=0.4)
        low, middle, high = np.quantile(values, list(QUANTILES))
        between = with_unit(f"{low:.3g} … {high:.3g}", quantity.unit)
        labels = ("_", f"median {with_unit(f'{middle:.3g}', quantity.unit)}", f"90 % of the runs: {between}")
        positions = (low, middle, high)
        for quantile, line, label in zip(positions, QUANTILES.values(), labels, strict=True):
            axes.axvline(quantile, color=INK, linestyle=line, linewidth=1.2, label=label)
        legend_above(axes)
        give_ticks(axes)
        axes.yaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1, steps=COUNT_STEPS))


def edges_of(values: np.ndarray, *, logarithmic: bool, whole: bool) -> np.ndarray:
    """Return the edges of the bars for some values, in ascending order.

    They are equally spaced; with ``logarithmic`` in the logarithm. With ``whole`` alone, for values that are
    whole numbers, the edges lie in the middle between two such numbers.
    """
    # 2 N^(1/3) bars for N values: Terrell & Scott, J Am Stat Assoc 80 (1985) 209
    count = min(MOST_BINS, math.ceil(2.0 * len(values) ** (1.0 / 3.0)))
    if logarithmic:
        return np.geomspace(values.min(), values.max(), count + 1)
    if whole:
        width = max(1.0, math.ceil((np.ptp(values) + 1.0) / MOST_BINS))
        return np.arange(values.min(), values.max() + width + 0.5, width) - 0.5
    low, high = values.min(), values.max()
    if high - low <= ONE_BAR_SPREAD * max(abs(low), abs(high)):
        return np.array([low, low]) + np.array([-0.5, 0.5]) * (ONE_BAR_SPREAD * abs(low) or 1.0)
    return np.linspace(low, high, count + 1)
