"""The panel of a measured column of a fit: data and model, and the residuals below.

Outputs are drawn over time, with a vertical line at each impact of the model. Quantities of impacts are drawn
over the number of the impact.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, MultipleLocator
from matplotlib.transforms import ScaledTranslation

from chain_impact.pictures.curve_texts import axis_unit
from chain_impact.pictures.drawing.axis_numbers import give_ticks
from chain_impact.pictures.drawing.colours import (
    BLACK,
    BLUE,
    IMPACT_LINE,
    PALE_GREY,
    PALETTE,
    VERMILLION,
    faint_colour,
)
from chain_impact.pictures.drawing.headings import MAY_BE_LOW, name_above
from chain_impact.pictures.drawing.legends import legend_above
from chain_impact.pictures.fit.contents import FittedColumn, FittedSeries
from chain_impact.pictures.over_time.time_axis import name_time
from chain_impact.scene.texts.unit_text import bracketed_unit

# free space before the first and after the last number on an axis of impact numbers; successive numbers have
# the distance 1
AXIS_MARGIN = 0.5
# [points] the size of the dots of measured values, which are drawn above the model's curve; DATA_ABOVE: their
# matplotlib zorder
FIT_DOT, DATA_ABOVE = 3.0, 5.0
MODEL_DASH: dict[str, Any] = {"markersize": 16.0, "markeredgewidth": 1.8}  # the model's value of an impact
MOST_DOTS = 40  # largest number of dots of a data set over time; of more values every n-th is drawn
# the colour of the model's quantities of impacts, and of the model's curve if there is a single data set; the
# curves of several data sets have the palette's colours
MODEL = VERMILLION
MEAN_PARTS = 20  # each point of the running mean of residuals is the mean of 1/MEAN_PARTS of the values
LEAST_FOR_MEAN = 100  # the least number of values for a running mean
MEAN = "_running mean"  # the label of the line of a running mean in matplotlib
MEAN_COLOUR = BLUE  # the colour of the running mean of a single data set
NAME_OFFSET = 3.5  # [points] the distance of the word beside the numbers of impacts from the axes
TITLE_PAD = 1.0  # [points] the distance of the title of residuals from their axes
# bars, and the grey band of usual residuals, extend from −USUAL_RESIDUAL to USUAL_RESIDUAL standard
# deviations
USUAL_RESIDUAL = 2.0
# the numbers at the axis of residuals are 0 and, to both sides, the largest of these on the axis; twice this
# one is always beyond the axis
RESIDUAL_TICKS = [step * 10.0**power for power in range(16) for step in (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 8.0)]


def draw_column(values: Axes, residuals: Axes, column: FittedColumn, *, has_several: bool) -> None:
    """Draw a measured column: data and model in the axes ``values``, and the residuals Δ divided by σ below.

    ``has_several``: whether there are several data sets.
    """
    over_impacts = column.is_of_impacts
    scale, unit = axis_unit(column.unit, [np.concatenate([part.measured for part in column.series])])
    reach = max(float(np.nanmax(np.abs(part.ratios), initial=USUAL_RESIDUAL)) for part in column.series)
    residuals.set(ylim=(-1.15 * reach, 1.15 * reach))
    outer_tick = max(tick for tick in RESIDUAL_TICKS if tick <= 1.15 * reach)
    residuals.yaxis.set_major_locator(MultipleLocator(outer_tick))
    residuals.axhspan(-USUAL_RESIDUAL, USUAL_RESIDUAL, color=PALE_GREY, zorder=0, linewidth=0)
    mean_text = ", line: mean" if any(map(has_mean, column.series)) else ""
    heading = f"Δ [σ = {column.sigma_text}]{mean_text}"
    name_above(residuals, heading, fontsize="small", pad=TITLE_PAD, gid=MAY_BE_LOW)
    for colour, part in zip(_colours(len(column.series)), column.series, strict=True):
        dots_label = f"data set {part.data_set + 1}" if has_several else "measured"
        mark_style: dict[str, Any] = {"linestyle": "", "marker": "o", "color": colour, "zorder": DATA_ABOVE}
        mark_style |= {"markersize": FIT_DOT, "markeredgewidth": 0, "label": dots_label}
        if part.course is None:
            mark_style |= {"yerr": scale * USUAL_RESIDUAL * part.sigma, "capsize": 2}
            values.errorbar(part.positions, scale * part.measured, **mark_style)
            model = scale * (part.measured + part.residuals)
            values.plot(part.positions, model, "_", color=MODEL, **MODEL_DASH)
        else:
            look = {"color": colour} if has_several else {"color": MODEL, "label": "model"}
            _curve((values, residuals), part, scale, look)
            step = math.ceil(len(part.measured) / MOST_DOTS)
            mark_style |= {"markevery": step} | ({"label": f"{dots_label} (1 of {step})"} if step > 1 else {})
            values.plot(part.positions, scale * part.measured, **mark_style)
        residuals.plot(part.positions, part.ratios, ".", color=colour, markersize=3)
        if has_mean(part):
            mean_line = running_means(part.positions, part.ratios)
            residuals.plot(
                *mean_line, color=colour if has_several else MEAN_COLOUR, linewidth=1.2, label=MEAN
            )
    # a quantity of impacts has plain words, as in other pictures; an output has the name that a user writes
    name = column.name.replace("_", " ") if over_impacts else column.name
    values.set_ylabel(f"{name}{bracketed_unit(unit)}")
    give_ticks(values)
    values.tick_params(labelbottom=False)
    last = max((float(np.nanmax(part.positions, initial=0.0)) for part in column.series), default=0.0)
    if over_impacts:
        # the word stands beside the numbers, so that the name needs no line of its own
        residuals.set_xlabel("impact", ha="right", va="top", fontsize="small")
        offset = ScaledTranslation(-NAME_OFFSET / 72.0, -NAME_OFFSET / 72.0, residuals.figure.dpi_scale_trans)
        residuals.xaxis.set_label_coords(0.0, 0.0, transform=residuals.transAxes + offset)
        values.title.set_gid(MAY_BE_LOW)
        numbers = np.concatenate([part.positions for part in column.series])
        if np.isfinite(numbers).any():  # False if the model has none of the measured impacts
            residuals.set_xlim(np.nanmin(numbers) - AXIS_MARGIN, np.nanmax(numbers) + AXIS_MARGIN)
        residuals.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    else:
        residuals.set_xlabel(name_time(residuals, last))
    if len(column.series) <= len(PALETTE):
        handles = values.get_legend_handles_labels()[0]
        if over_impacts and not has_several:
            handles = [Line2D([], [], color=MODEL, linewidth=1.8, label="model"), *handles]
        legend_above(values, handles)


def has_mean(series: FittedSeries) -> bool:
    """Return whether the residuals of a series have a line with their running mean."""
    return series.course is not None and len(series.measured) >= LEAST_FOR_MEAN


def running_means(times: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the mean position and the mean value of each part of the values, shape (2, number of parts).

    Each part has ⌊n/MEAN_PARTS⌋ of the n values, successive ones in the order of their positions ``times``.
    Neighbouring parts share about half of their values.
    """
    order, width = np.argsort(times, kind="stable"), len(times) // MEAN_PARTS
    starts = range(0, len(times) - width + 1, max(1, width // 2))
    rows = [order[start : start + width] for start in starts]
    return np.array([[times[part].mean(), values[part].mean()] for part in rows]).T


def _curve(panels: Sequence[Axes], series: FittedSeries, scale: float, look: dict[str, Any]) -> None:
    """Draw the model's course in the first of two panels, and a line at each impact of the model in both.

    ``scale``: the factor of the unit.
    """
    for axes in panels:
        mark_style: dict[str, Any] = {"linewidth": 0.6, "zorder": 0, "transform": axes.get_xaxis_transform()}
        axes.vlines(series.onsets, 0.0, 1.0, faint_colour(axes, IMPACT_LINE), **mark_style)
    assert series.course is not None
    times, values = series.course
    panels[0].plot(times, scale * values, **{"linewidth": 1.8, "zorder": 4.0} | look)


def _colours(count: int) -> list[str]:
    """Return the colour of the data of each data set; that of a single one has the colour of text."""
    return [BLACK] if count == 1 else [PALETTE[k % len(PALETTE)] for k in range(count)]
