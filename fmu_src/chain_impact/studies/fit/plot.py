"""The picture of a fit: for each measured column a panel with data and model, and the residuals below.

There are at most MOST_FIT_PANELS panels. Outputs are drawn over time, with a vertical line at each impact of
the model. Quantities of impacts are drawn over the number of the impact. If laws were ranked, the picture
instead has one panel with a dot for each contact law that could be fitted.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from chain_impact.pictures.bars import Bars, bars_size, draw_bars
from chain_impact.pictures.curve_texts import axis_unit
from chain_impact.pictures.drawing.figures import draw_figure, settle
from chain_impact.pictures.drawing.headings import MAY_BE_LOW, name_above
from chain_impact.pictures.drawing.legends import legend_above
from chain_impact.pictures.drawing.line_breaks import SEPARATOR
from chain_impact.pictures.drawing.sizes import Size
from chain_impact.pictures.drawing.style import (
    BLACK,
    BLUE,
    GREY,
    IMPACT_LINE,
    INK,
    PALE_GREY,
    PALETTE,
    PEAK_COLOUR,
    VERMILLION,
    drawing_style,
    faint_colour,
    is_narrow,
    write_headline,
)
from chain_impact.pictures.over_time.time_axis import name_time
from chain_impact.results.result import Result
from chain_impact.scene.texts.unit_text import bracketed_unit
from chain_impact.studies.fit.estimate_texts import (
    estimate_ranges,
    estimate_text,
    estimate_texts,
    strongest_correlation,
)
from chain_impact.studies.fit.estimates import Estimates
from chain_impact.studies.fit.measurements import MEASURED_OF_IMPACT, Measurements
from chain_impact.studies.fit.model_run import model_run
from chain_impact.studies.fit.remarks import alike_neighbours
from chain_impact.studies.fit.report import (
    count_of_best,
    fits_equally,
    heading,
    least_certain_of,
    misfit,
    sigma_of,
    sigma_text,
)
from chain_impact.text import count_text, number_text

MOST_FIT_PANELS = 8  # the largest number of panels; further measured columns are not drawn
FIT_PANEL_WIDTH, FIT_PANEL_HEIGHT = 5.2, 2.9  # [inch] size of a panel
# free space before the first and after the last number on an axis of impact numbers; successive numbers have
# the distance 1
AXIS_MARGIN = 0.5
# [points] the size of the dots of measured values, which are drawn above the model's curve; DATA_ABOVE: their
# matplotlib zorder
FIT_DOT, DATA_ABOVE = 3.0, 5.0
MODEL_DASH: dict[str, Any] = {"markersize": 16.0, "markeredgewidth": 1.8}  # the model's value of an impact
PANEL_PARTS = (5, 2)  # the relative heights of values and residuals
ROW_WIDTHS = [3, 3, 2]  # the relative widths of two panels over time and one of impacts in a row
MOST_DOTS = 40  # largest number of dots of a data set over time; of more values every n-th is drawn
# the colour of the model's quantities of impacts, and of the model's curve if there is a single data set; the
# curves of several data sets have the palette's colours
MODEL = VERMILLION
SUPPORT_LIMIT = 10.0  # the ΔAIC from which on the data hardly support a law (Burnham & Anderson 2004)
MEAN_PARTS = 20  # each point of the running mean of residuals is the mean of 1/MEAN_PARTS of the values
LEAST_FOR_MEAN = 100  # the least number of values for a running mean
MEAN = "_running mean"  # the label of the line of a running mean in matplotlib
MEAN_TEXT = "mean of Δ"  # the text of the key of running means
MEAN_COLOUR = BLUE  # the colour of the running mean of a single data set
TITLE_PAD = 1.0  # [points] the distance of the title of residuals from their axes
# bars, and the grey band of usual residuals, extend from −USUAL_RESIDUAL to USUAL_RESIDUAL standard
# deviations
USUAL_RESIDUAL = 2.0


@dataclass(frozen=True)
class Column:
    """The K values of a measured column in one data set.

    Attributes:
        data_set: index of the data set.
        rows: indices of these values among the values of all data sets, shape (K,).
        positions: position of each value on the horizontal axis, shape (K,): for an output the time [s]; for
            a quantity of an impact the number of the model's impact, from 1; NaN if the model lacks it.
    """

    data_set: int
    rows: np.ndarray
    positions: np.ndarray


def plot_fit(
    fit: Estimates, path: str | os.PathLike[str] | None = None, size: Size | None = None
) -> Figure | None:
    """Draw the picture of a fit, as ``Fit.plot`` describes."""
    if fit.ranking:
        return draw_figure(partial(draw_law_ranking, fit=fit), path, size, bars_size([len(fit.ranking)]))
    names = list(fit.columns)[:MOST_FIT_PANELS]
    width, rows = (1.5 if len(names) == 1 else 2.0) * FIT_PANEL_WIDTH, -(-len(names) // len(_widths(names)))
    return draw_figure(partial(draw_fit, fit=fit), path, size, (width, 0.7 + rows * FIT_PANEL_HEIGHT))


@drawing_style()
def draw_fit(figure: Figure, fit: Estimates) -> None:
    """Draw a panel for each of the first MOST_FIT_PANELS columns, and the headline, on an empty figure."""
    names = list(fit.columns)[:MOST_FIT_PANELS]
    widths = [1] if is_narrow(figure) else _widths(names)
    columns, rows = len(widths), -(-len(names) // len(widths))
    # one grid for all panels: then their axes stand exactly below each other
    shape = {"width_ratios": widths, "height_ratios": [*PANEL_PARTS] * rows}
    grid = figure.add_gridspec(len(PANEL_PARTS) * rows, columns, **shape)
    results, has_lines = [model_run(fit, k) for k in range(len(fit.data))], False
    for k, name in enumerate(names):
        row, column = divmod(k, columns)
        # the last panel is as wide as its row, but not a panel of impacts, which has few values
        is_alone = k == len(names) - 1 and not column and name not in MEASURED_OF_IMPACT
        cells = [grid[2 * row + part, slice(None) if is_alone else column] for part in (0, 1)]
        values = figure.add_subplot(cells[0])
        has_lines |= _panel(values, figure.add_subplot(cells[1], sharex=values), fit, name, results)
    residuals = figure.axes[1::2]
    lacks_key = not _add_key_of_means(figure, has_several=len(fit.data) > 1)
    for k, axes in enumerate(residuals):
        # a panel below with the same times has their numbers and name
        neighbours = residuals[k + columns : k + columns + 1]
        ends = [(panel.get_xlabel(), panel.get_position().x1) for panel in (axes, *neighbours)]
        if neighbours and ends[0] == ends[1]:
            axes.set_xlabel("")
            axes.tick_params(labelbottom=False)
    poor_text = ", ".join(alike_neighbours(fit))
    warning = f"errors are too small: neighbouring residuals of {poor_text} are correlated"
    notes = [strongest_correlation(fit)]
    if not fit.estimated:  # with an estimated σ, both are about 1 for any model
        quality_text = f"reduced χ² {number_text(fit.reduced_chi_squared, 3)}"
        notes = [f"rms residual {number_text(misfit(fit, fit), 3)} σ", quality_text, *notes]
    if len(names) < len(fit.columns):
        notes.append(f"{len(names)} of {len(fit.columns)} columns")
    marks_text = "bars and bands" if {*names} & {*MEASURED_OF_IMPACT} else "bands"
    notes.append(f"±: standard error; {marks_text}: ± {USUAL_RESIDUAL:g} σ")
    notes.append(f"Δ = model − data{f', σ {origin}' if (origin := _origin(fit)) else ''}")
    if has_lines:
        notes.append("grey lines: impacts")
    if lacks_key:
        notes.append(f"lines in panels of Δ: {MEAN_TEXT}")
    size, least_certain = heading(fit, ": ").partition(": ")[2], least_certain_of(fit)
    texts = estimate_texts(fit, omitted_label=least_certain)
    title = f"{fit.scene.name}: {estimate_text(fit, least_certain)}"
    if texts and least_certain not in fit.at_bounds:
        title += f", least certain of {len(fit.values)}"
    lines = [(warning, PEAK_COLOUR)] * bool(poor_text)
    if is_narrow(figure):
        lines, texts = lines + [(text, INK) for text in texts], []
    write_headline(figure, title, SEPARATOR.join(filter(None, [*texts, *notes, size])), *lines)
    figure.align_ylabels()
    settle(figure)


def _origin(fit: Estimates) -> str:
    """Return "given" or "estimated", if this is the origin of the σ of all columns; else ""."""
    return {0: "given", len(fit.columns): "estimated"}.get(len(fit.estimated), "")


def _widths(names: Sequence[str]) -> list[int]:
    """Return the relative widths of the columns of a wide picture with panels for the columns ``names``.

    Two panels stand in a row; a third and last panel of impacts stands beside them, and is narrower.
    """
    if len(names) == len(ROW_WIDTHS) and names[-1] in MEASURED_OF_IMPACT:
        return ROW_WIDTHS
    return [1] * min(len(names), 2)


@drawing_style()
def draw_law_ranking(figure: Figure, fit: Estimates) -> None:
    """Draw the ranking of contact laws on an empty figure: ΔAIC of each law as a dot.

    The best law is on top. A law without a fit has no dot. If a dot is beyond SUPPORT_LIMIT, the axis is
    logarithmic beyond SUPPORT_LIMIT.
    """
    excesses = [math.nan if entry.fit is None else max(0.0, entry.fit.aic - fit.aic) for entry in fit.ranking]
    largest_excess = float(np.nanmax(excesses))
    bars = Bars(
        names=[entry.law for entry in fit.ranking],
        values=excesses,
        texts=[
            "–"
            if entry.fit is None
            else number_text(round(value, 1), 2)
            if value < SUPPORT_LIMIT
            else f"{value:.0f}"
            for entry, value in zip(fit.ranking, excesses, strict=True)
        ],
        label="ΔAIC",
        heading="ΔAIC",
        dots=True,
        colours=[PALETTE[0] if fits_equally(entry, fit) else GREY for entry in fit.ranking],
    )
    tied = [entry.fit for entry in fit.ranking if entry.fit and fits_equally(entry, fit)]
    texts = estimate_ranges(fit, tied) if len(tied) > 1 else estimate_texts(fit)
    texts.append("blue: as good as the best law")
    unfinished_text = ", ".join(entry.law for entry in fit.ranking if entry.fit and not entry.fit.converged)
    texts += [f"did not converge: {unfinished_text}"] if unfinished_text else []
    if largest_excess > SUPPORT_LIMIT:
        texts.append(f"from {SUPPORT_LIMIT:g} on (dashed): hardly supported")
    other_count = count_of_best(fit) - 1
    laws_text = (
        f"{fit.law} and {count_text(other_count, 'other law')} fit equally well" if other_count else ""
    )
    write_headline(figure, heading(fit, ": ", laws_text), SEPARATOR.join(texts))
    axes = figure.subplots()
    draw_bars(axes, bars, (0.0, largest_excess or 1.0), is_small=is_narrow(figure))
    axes.axvline(SUPPORT_LIMIT, color=INK, linewidth=0.8, linestyle="--")
    if largest_excess > SUPPORT_LIMIT:
        axes.set_xscale("symlog", linthresh=SUPPORT_LIMIT)
        axes.set_xlim(0.0, 2.0 * largest_excess)
    settle(figure)


def _panel(values: Axes, residuals: Axes, fit: Estimates, name: str, results: list[Result]) -> bool:
    """Draw a measured column: data and model in the axes ``values``, and the residuals Δ divided by σ below.

    ``results``: the model's run of each data set. Returns whether the panel has lines at impacts.
    """
    parts = _columns(fit, name, results)
    is_over_impacts, has_lines = name in MEASURED_OF_IMPACT, False
    has_several = len(fit.data) > 1
    values_of_data = np.concatenate([data_set.value for data_set in fit.data])
    scale, unit = axis_unit(fit.unit(name), [values_of_data[fit.columns[name]]])
    reach = float(np.nanmax(np.abs(fit.residuals / fit.sigma)[fit.columns[name]], initial=USUAL_RESIDUAL))
    residuals.set(ylim=(-1.15 * reach, 1.15 * reach))
    residuals.axhspan(-USUAL_RESIDUAL, USUAL_RESIDUAL, color=PALE_GREY, zorder=0, linewidth=0)
    # the text below the headline tells a common origin
    sigma = sigma_text(fit, name) if _origin(fit) else sigma_of(fit, name)
    name_above(residuals, f"Δ [σ = {sigma}]", fontsize="small", pad=TITLE_PAD, gid=MAY_BE_LOW)
    for colour, part in zip(_colours(len(parts)), parts, strict=True):
        dots_label = f"data set {part.data_set + 1}" if has_several else "measured"
        mark_style: dict[str, Any] = {"linestyle": "", "marker": "o", "color": colour, "zorder": DATA_ABOVE}
        mark_style |= {"markersize": FIT_DOT, "markeredgewidth": 0, "label": dots_label}
        if is_over_impacts:
            mark_style |= {"yerr": scale * USUAL_RESIDUAL * fit.sigma[part.rows], "capsize": 2}
            values.errorbar(part.positions, scale * values_of_data[part.rows], **mark_style)
            model = scale * (values_of_data[part.rows] + fit.residuals[part.rows])
            values.plot(part.positions, model, "_", color=MODEL, **MODEL_DASH)
        else:
            look = {"color": colour} if has_several else {"color": MODEL, "label": "model"}
            run = results[part.data_set]
            has_lines |= _curve((values, residuals), run, scale * run[name], part.positions.max(), look)
            step = math.ceil(len(part.rows) / MOST_DOTS)
            mark_style |= {"markevery": step} | ({"label": f"{dots_label} (1 of {step})"} if step > 1 else {})
            values.plot(part.positions, scale * values_of_data[part.rows], **mark_style)
        ratios = fit.residuals[part.rows] / fit.sigma[part.rows]
        residuals.plot(part.positions, ratios, ".", color=colour, markersize=3)
        if not is_over_impacts and len(ratios) >= LEAST_FOR_MEAN:
            mean_line = running_means(part.positions, ratios)
            residuals.plot(
                *mean_line, color=colour if has_several else MEAN_COLOUR, linewidth=1.2, label=MEAN
            )
    values.set_ylabel(f"{name}{bracketed_unit(unit)}")
    values.tick_params(bottom=False, labelbottom=False)
    last = max((float(np.nanmax(part.positions, initial=0.0)) for part in parts), default=0.0)
    residuals.set_xlabel("number of the impact" if is_over_impacts else name_time(residuals, last))
    if is_over_impacts:
        numbers = np.concatenate([part.positions for part in parts])
        if np.isfinite(numbers).any():  # False if the model has none of the measured impacts
            residuals.set_xlim(np.nanmin(numbers) - AXIS_MARGIN, np.nanmax(numbers) + AXIS_MARGIN)
        residuals.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    if len(parts) <= len(PALETTE):
        handles = values.get_legend_handles_labels()[0]
        if is_over_impacts and not has_several:
            handles = [Line2D([], [], color=MODEL, linewidth=1.8, label="model"), *handles]
        legend_above(values, handles)
    return has_lines


def _add_key_of_means(figure: Figure, *, has_several: bool) -> bool:
    """Add an entry for running means to the first legend above them; return False if there is no legend.

    Without running means the result is True. ``has_several``: whether there are several data sets, whose
    running means have different colours, so that the entry has the colour of text.
    """
    panels = [
        (values, line)
        for values, residuals in zip(figure.axes[::2], figure.axes[1::2], strict=True)
        for line in residuals.lines
        if line.get_label() == MEAN
    ]
    for values, mean in panels:
        if values.get_legend():
            look: dict[str, Any] = {"color": INK if has_several else mean.get_color()}
            key = Line2D([], [], label=MEAN_TEXT, linewidth=mean.get_linewidth(), **look)
            legend_above(values, [*values.get_legend_handles_labels()[0], key])
            return True
    return not panels


def running_means(times: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the mean position and the mean value of each part of the values, shape (2, number of parts).

    Each part has ⌊n/MEAN_PARTS⌋ of the n values, successive ones in the order of their positions ``times``.
    Neighbouring parts share about half of their values.
    """
    order, width = np.argsort(times, kind="stable"), len(times) // MEAN_PARTS
    starts = range(0, len(times) - width + 1, max(1, width // 2))
    rows = [order[start : start + width] for start in starts]
    return np.array([[times[part].mean(), values[part].mean()] for part in rows]).T


def _curve(
    panels: Sequence[Axes], result: Result, model: np.ndarray, last: float, look: dict[str, Any]
) -> bool:
    """Draw the model's curve in the first of two panels, and a line at each impact of the model in both.

    The curve has the values ``model`` at the times of ``result``. Curve and lines end at ``last`` [s], the
    time of the last measurement. Returns whether there is a line at an impact.
    """
    onsets, is_shown = result.impacts["onset"], result.time <= last
    onsets = onsets[onsets <= last]
    for axes in panels:
        mark_style: dict[str, Any] = {"linewidth": 0.6, "zorder": 0, "transform": axes.get_xaxis_transform()}
        axes.vlines(onsets, 0.0, 1.0, faint_colour(axes, IMPACT_LINE), **mark_style)
    panels[0].plot(result.time[is_shown], model[is_shown], **{"linewidth": 1.8, "zorder": 4.0} | look)
    return len(onsets) > 0


def _columns(fit: Estimates, name: str, results: list[Result]) -> list[Column]:
    """Return the values of a measured column: an entry for each data set that has this column."""
    columns, first = [], 0
    for k, data in enumerate(fit.data):
        rows = np.flatnonzero(np.array(data.quantity) == name)
        if len(rows):
            data_rows = data.row[rows]
            positions = (
                _numbers(data, data_rows, results[k]) if name in MEASURED_OF_IMPACT else data.times[data_rows]
            )
            columns.append(Column(k, first + rows, positions))
        first += len(data)
    return columns


def _numbers(data: Measurements, rows: np.ndarray, result: Result) -> np.ndarray:
    """Return for each measured impact the number of the same impact in the model, from 1, shape (K,).

    ``rows``: the indices of the K measured impacts in ``data.impacts``; ``result``: the model's run. The
    number is NaN if the model lacks the impact.
    """
    found_rows = (data.impacts[row].find(result.impacts) for row in rows)
    return np.array([np.nan if match is None else match + 1.0 for match in found_rows])


def _colours(count: int) -> list[str]:
    """Return the colour of the data of each data set; that of a single one has the colour of text."""
    return [BLACK] if count == 1 else [PALETTE[k % len(PALETTE)] for k in range(count)]
