"""Pictures of a sweep's samples: histograms of results, and dots of results over varied parameters."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, MaxNLocator

from chain_impact.map_colours import WIDE_COLOURS, value_ratio
from chain_impact.pictures.drawing.axis_numbers import COUNT_STEPS, give_ticks
from chain_impact.pictures.drawing.colours import BLUE, INK
from chain_impact.pictures.drawing.headings import name_above
from chain_impact.pictures.drawing.legends import legend_above, legend_at_foot
from chain_impact.pictures.sweep.colour_bars import WIDE_RANGE, number_few_decades
from chain_impact.pictures.sweep.curves import MANY_SAMPLES, RING, SMALL_DOT, mark_at_foot
from chain_impact.pictures.sweep.effects import DEGREES, TRENDING, effects_on
from chain_impact.pictures.sweep.maps import (
    NO_IMPACT,
    NO_VALUE_TEXT,
    SCENE_LINE,
    is_logarithmic,
    label_of,
    own_value,
)
from chain_impact.pictures.sweep.quantities import LOADS, Quantity
from chain_impact.scene.texts.unit_text import with_unit
from chain_impact.study_data.sweep.runs import SweepRuns
from chain_impact.study_data.sweep.variation import Variation
from chain_impact.text import count_text

QUANTILES = {0.05: ":", 0.5: "-", 0.95: ":"}
"""Quantile → matplotlib's style of the line that marks the quantile in each histogram."""
# the colour and the opacity of the bars: lines on the bars have contrast on a white and on a dark ground
BARS = (BLUE, 0.4)
FEW_COUNTS = 5  # the largest number of distances between the numbers at the axis of a histogram
MOST_SCATTERS = 3  # the largest number of parameters over which each quantity of samples is drawn
# DOTS_PART: the width of the dots of a choice, relative to the distance of two choices; GOLDEN: in this
# width, the dot of run k stands at the fractional part of k times GOLDEN, so that the dots are evenly spread
GOLDEN, DOTS_PART = 0.618034, 0.5
# BOX_WIDTH: that of the box of a choice, relative to the distance of two choices; BOX_LINE: [points]
BOX_WIDTH, BOX_LINE = 0.6, 0.9
CHOICE_NOTE = "; box: middle half and median; sideways: spread only"  # at the axis of a choice
FEWEST_PAIRS = 3  # the correlation of fewer than FEWEST_PAIRS pairs of values counts as 0
# the largest number of bars; narrower bars would show mainly random differences
MOST_BINS = 60
ONE_BAR_SPREAD = 1e-9  # [1] all values share one bar if their range is at most this times the largest |value|


def draw_histograms(panels: Sequence[Axes], runs: SweepRuns, quantities: Sequence[Quantity]) -> None:
    """Draw a histogram of each quantity in its panel: numbers of runs over values, lines at the QUANTILES.

    Runs without a finite value are left out, such as runs with impulses in a histogram of peak forces. If no
    run has a finite value, the panel has the words NO_VALUE_TEXT.
    """
    for axes, quantity in zip(panels, quantities, strict=True):
        values = quantity.values_or_nan(runs)
        values = values[np.isfinite(values)]
        axes.set(xlabel=quantity.label, ylabel="runs")
        if not values.size:
            axes.text(0.5, 0.5, NO_VALUE_TEXT, transform=axes.transAxes, ha="center", color="0.4")
            continue
        has_logarithmic_axis = value_ratio(values) >= WIDE_COLOURS and not quantity.is_count
        axes.set_xscale("log" if has_logarithmic_axis else "linear")
        if has_logarithmic_axis and values.max() < WIDE_RANGE * values.min():
            number_few_decades(axes.xaxis)
        edges = edges_of(values, logarithmic=has_logarithmic_axis, integer=quantity.is_count)
        axes.hist(values, edges.tolist(), color=BARS, edgecolor=BLUE, linewidth=0.8)
        low, middle, high = np.quantile(values, list(QUANTILES))
        range_text = with_unit(f"{low:.3g} … {high:.3g}", quantity.unit)
        labels = (
            "_",
            f"median {with_unit(f'{middle:.3g}', quantity.unit)}",
            f"90 % of the runs: {range_text}",
        )
        positions = (low, middle, high)
        for quantile, line, label in zip(positions, QUANTILES.values(), labels, strict=True):
            axes.axvline(quantile, color=INK, linestyle=line, linewidth=1.2, label=label)
        if untouched := int(quantity.is_without_touch(runs).sum()):
            axes.plot([], [], linestyle="", label=f"{NO_IMPACT}: {count_text(untouched, 'run')}, not drawn")
        legend_above(axes)
        give_ticks(axes)
        few_ticks: dict[str, Any] = {
            "nbins": FEW_COUNTS,
            "integer": True,
            "min_n_ticks": 1,
            "steps": COUNT_STEPS,
        }
        axes.yaxis.set_major_locator(MaxNLocator(**few_ticks))


def draw_samples(
    panels: Sequence[Axes], runs: SweepRuns, quantities: Sequence[Quantity], variations: Sequence[Variation]
) -> None:
    """Draw each quantity in successive panels: dots over each of ``drawn_parameters``, then a histogram.

    If a sum of effects describes the quantity well (TRENDING), the heading of each panel with dots tells the
    effect of its parameter; and in all of these panels but the first, the dots show the quantity without the
    effects of all other parameters, which would hide this effect. All panels with dots of a quantity have the
    same vertical axis. A legend at the foot of the figure explains rings.
    """
    panels_per_quantity, drawn_variations = len(panels) // len(quantities), drawn_parameters(runs, variations)
    draw_histograms(panels[panels_per_quantity - 1 :: panels_per_quantity], runs, quantities)
    for k, quantity in enumerate(quantities):
        effects = effects_on(runs, quantity, variations)
        is_fitted = effects is not None and effects.explained >= TRENDING
        choice_panels = panels[panels_per_quantity * k : panels_per_quantity * (k + 1) - 1]
        for axes, variation in zip(choice_panels, drawn_variations, strict=True):
            values, heading = quantity.values_or_nan(runs), quantity.label
            if effects is not None and is_fitted:
                if variation is not drawn_variations[0]:
                    values, heading = (
                        effects.without_others(values, variation.name),
                        f"{heading}, others equal",
                    )
                heading += f": {effects.spread_text(variation.name, quantity.unit)}"
            _scatter(axes, runs, quantity, variation, values)
            name_above(axes, heading)
        _share_vertical_axis(choice_panels)
    keys: list[Any] = []
    if any(quantity.is_without_touch(runs).any() for quantity in quantities):
        keys.append(Line2D([], [], label=NO_IMPACT, **RING))
    figure = panels[0].get_figure(root=True)
    if figure is not None and keys:
        legend_at_foot(figure, keys)


def drawn_parameters(runs: SweepRuns, variations: Sequence[Variation]) -> list[Variation]:
    """Return the parameters over which samples are drawn: at most MOST_SCATTERS, the strongest first.

    The strength of a parameter is the largest spread of its effects on one of the LOADS, relative to the
    standard deviation of the load or its logarithm; without a fit, |rank correlation|. Parameters that are
    choices come last.
    """
    loads = [Quantity(name, name) for name in LOADS if name in runs.names]
    effects_of_loads = {load.column: effects_on(runs, load, variations) for load in loads}

    def strength(variation: Variation) -> float:
        if variation.choices:
            return -1.0
        sizes = [0.0]
        for load in loads:
            effects, values = effects_of_loads[load.column], load.values_or_nan(runs)
            if effects is None:
                sizes.append(abs(rank_correlation(runs[variation.name], values)))
            else:
                sizes.append(effects.spread(variation.name) / effects.deviation)
        return max(sizes)

    return sorted(variations, key=strength, reverse=True)[:MOST_SCATTERS]


def rank_correlation(first_values: np.ndarray, second_values: np.ndarray) -> float:
    """Return Spearman's correlation of the ranks of two arrays of shape (R,).

    Pairs with a value that is not finite are left out. The result is 0 if fewer than FEWEST_PAIRS pairs are
    left, or if all values of an array in these pairs are equal.
    """
    from scipy.stats import spearmanr  # this import takes long, and only pictures of samples need it

    is_known = np.isfinite(first_values) & np.isfinite(second_values)
    first_values, second_values = first_values[is_known], second_values[is_known]
    if len(first_values) < FEWEST_PAIRS or not np.ptp(first_values) or not np.ptp(second_values):
        return 0.0
    return float(spearmanr(first_values, second_values).statistic)


def influence_text(runs: SweepRuns, quantities: Sequence[Quantity], variations: Sequence[Variation]) -> str:
    """Return words with the number of runs, on dashed lines, and on the fit of each quantity.

    The words tell what effects are relative to, and have those of the parameters without a panel; a quantity
    that the fit does not describe well (TRENDING) has only the part of its variance.
    """
    parts = [f"{len(runs)} runs"]
    if any(own_value(runs, variation) is not None for variation in drawn_parameters(runs, variations)):
        parts.append("dashed: value in the scene")
    for quantity in quantities:
        effects = effects_on(runs, quantity, variations)
        if effects is None:
            continue
        drawn_names = [variation.name for variation in drawn_parameters(runs, variations)]
        texts = [
            f"{effects.spread_text(name, quantity.unit)} by {name}"
            for name in effects.of_names
            if name not in drawn_names and effects.explained >= TRENDING
        ]
        if texts:
            parts.append(f"{quantity.name}, others equal: {', '.join(texts)}")
        subject = "effects" if len(quantities) == 1 else f"effects on {quantity.name}"
        subject += f" relative to the {'geometric ' * effects.is_factor}mean"
        fit_text = f"{subject} by a fit, {DEGREES[effects.degree]} in each number"
        parts.append(f"{fit_text}: it explains {effects.explained_text} of the variance")
    return "; ".join(parts)


def _scatter(
    axes: Axes, runs: SweepRuns, quantity: Quantity, variation: Variation, shown_values: np.ndarray
) -> None:
    """Draw a quantity over a varied parameter, with a dot for each run and a line at ``own_value``.

    ``shown_values``: the values of the quantity in the runs, shape (R,).
    """
    parameter_values = runs[variation.name]
    if variation.choices:
        names = variation.shown_values(np.unique(variation.values)).tolist()
        # the dots of a choice lie side by side, at positions that repeat in each run of the program
        sideways_shifts = (np.arange(len(runs)) * GOLDEN) % 1.0 - 0.5
        positions = np.array([names.index(name) for name in parameter_values])
        for position in range(len(names)):
            _draw_box(axes, position, shown_values[(positions == position) & np.isfinite(shown_values)])
        parameter_values = positions + DOTS_PART * sideways_shifts
        axes.set_xticks(range(len(names)), names)
        axes.set_xlim(-0.5, len(names) - 0.5)
    else:
        axes.set_xscale("log" if is_logarithmic(variation) else "linear")
    size = SMALL_DOT if len(runs) > MANY_SAMPLES else 4.0
    axes.plot(parameter_values, shown_values, ".", color=BLUE, markersize=size, rasterized=True)
    mark_at_foot(axes, np.asarray(parameter_values)[quantity.is_without_touch(runs)], RING)
    axes.set_xlabel(label_of(runs, variation) + (CHOICE_NOTE if variation.choices else ""))
    finite_values = shown_values[np.isfinite(shown_values)]
    if finite_values.size and value_ratio(finite_values) >= WIDE_COLOURS and not quantity.is_count:
        axes.set_yscale("log")
        if finite_values.max() < WIDE_RANGE * finite_values.min():
            number_few_decades(axes.yaxis)
    if (scene_value := own_value(runs, variation)) is not None:
        axes.axvline(scene_value, **SCENE_LINE)
    if not variation.choices:
        give_ticks(axes)


def _share_vertical_axis(panels: Sequence[Axes]) -> None:
    """Give panels the vertical axis of the first one, with ends that contain the values of all panels."""
    lows, highs = zip(*(axes.get_ylim() for axes in panels), strict=True)
    first = panels[0]
    for axes in panels:
        if axes.get_yscale() != first.get_yscale():
            axes.set_yscale(first.get_yscale())
            if isinstance(first.yaxis.get_major_formatter(), FuncFormatter):
                number_few_decades(axes.yaxis)
        axes.set_ylim(min(lows), max(highs))


def _draw_box(axes: Axes, position: int, values: np.ndarray) -> None:
    """Draw a box around the middle half of some values, with a line at their median, at an x position."""
    if values.size:
        low, middle, high = np.quantile(values, (0.25, 0.5, 0.75))
        look: dict[str, Any] = {"edgecolor": INK, "linewidth": BOX_LINE, "zorder": 3.0}
        axes.bar([position], [high - low], BOX_WIDTH, [low], color="none", **look)
        half = 0.5 * BOX_WIDTH
        axes.hlines([middle], position - half, position + half, INK, linewidth=2.0 * BOX_LINE, zorder=3.0)


def edges_of(values: np.ndarray, *, logarithmic: bool, integer: bool) -> np.ndarray:
    """Return the edges of the bars for some values, in ascending order.

    The edges are equally spaced, with ``logarithmic`` in the logarithm. With ``integer``, but not
    ``logarithmic``, the values must be whole numbers, and each edge is a whole number minus 0.5. Other values
    that are equal up to round-off (ONE_BAR_SPREAD) share one bar.
    """
    # 2 N^(1/3) bars for N values: Terrell & Scott, J Am Stat Assoc 80 (1985) 209
    count = min(MOST_BINS, math.ceil(2.0 * len(values) ** (1.0 / 3.0)))
    if logarithmic:
        return np.geomspace(values.min(), values.max(), count + 1)
    if integer:
        width = max(1.0, math.ceil((np.ptp(values) + 1.0) / MOST_BINS))
        return np.arange(values.min(), values.max() + width + 0.5, width) - 0.5
    low, high = values.min(), values.max()
    if high - low <= ONE_BAR_SPREAD * max(abs(low), abs(high)):
        return np.array([low, low]) + np.array([-0.5, 0.5]) * (ONE_BAR_SPREAD * abs(low) or 1.0)
    return np.linspace(low, high, count + 1)
