"""The picture of a fit: its contents from the estimates, and the model's runs with the fitted values."""

from __future__ import annotations

import math
import os
from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from chain_impact.pictures.bars import bars_size
from chain_impact.pictures.drawing.figures import draw_figure
from chain_impact.pictures.drawing.sizes import Size
from chain_impact.pictures.fit.contents import (
    FitContents,
    FittedColumn,
    FittedParameter,
    FittedSeries,
    RankedLaw,
)
from chain_impact.pictures.fit.fit_figure import draw_fit, fit_size
from chain_impact.pictures.fit.law_ranking import draw_law_ranking
from chain_impact.results.result import Result
from chain_impact.scene.texts.plain_names import plain_name
from chain_impact.studies.fit.estimate_texts import (
    MOST_ESTIMATES,
    estimate_ranges,
    estimate_text,
    strongest_correlation,
)
from chain_impact.studies.fit.estimates import Estimates
from chain_impact.studies.fit.measurements import MEASURED_OF_IMPACT, Measurements
from chain_impact.studies.fit.model_run import model_run
from chain_impact.studies.fit.parameters import Parameter
from chain_impact.studies.fit.remarks import alike_neighbours
from chain_impact.studies.fit.report import (
    count_of_best,
    fit_heading,
    fits_equally,
    is_determined,
    least_certain_of,
    misfit,
    sigma_of,
    sigma_text,
)
from chain_impact.text import count_text, number_text


def plot_fit(
    fit: Estimates, path: str | os.PathLike[str] | None = None, size: Size | None = None
) -> Figure | None:
    """Draw the picture of a fit, as ``Fit.plot`` describes."""
    if fit.ranking:
        draw_ranking = partial(draw_law_ranking, **ranking_contents(fit))
        return draw_figure(draw_ranking, path, size, bars_size([len(fit.ranking)]))
    contents = fit_contents(fit)
    return draw_figure(partial(draw_fit, contents=contents), path, size, fit_size(contents))


def ranking_contents(fit: Estimates) -> dict[str, Any]:
    """Return the arguments of ``draw_law_ranking``: headline, notes, and the laws in their order."""
    tied = [entry.fit for entry in fit.ranking if entry.fit and fits_equally(entry, fit)]
    if len(tied) > 1:
        notes = estimate_ranges(fit, tied)
    else:
        notes = [estimate_text(fit, label) for label in list(fit.values)[:MOST_ESTIMATES]]
        rest = len(fit.values) - len(notes)
        notes += [count_text(rest, "more parameter")] if rest else []
    unfinished_text = ", ".join(entry.law for entry in fit.ranking if entry.fit and not entry.fit.converged)
    notes += [f"did not converge: {unfinished_text}"] if unfinished_text else []
    other_count = count_of_best(fit) - 1
    laws_text = (
        f"{fit.law} and {count_text(other_count, 'other law')} fit equally well" if other_count else ""
    )
    ranked_laws = [
        RankedLaw(
            entry.law,
            math.nan if entry.fit is None else max(0.0, entry.fit.aic - fit.aic),
            fits_equally(entry, fit),
        )
        for entry in fit.ranking
    ]
    return {"title": fit_heading(fit, ": ", laws_text), "notes": notes, "laws": ranked_laws}


def fit_contents(fit: Estimates) -> FitContents:
    """Return the contents of the picture; the model is simulated with the fitted values."""
    results = [model_run(fit, k) for k in range(len(fit.data))]
    poor_text = ", ".join(alike_neighbours(fit))
    warning = (
        f"errors are too small: neighbouring residuals of {poor_text} are correlated" if poor_text else ""
    )
    notes = [strongest_correlation(fit)]
    if not fit.estimated:  # with an estimated σ, both are about 1 for any model
        quality_text = f"reduced χ² {number_text(fit.reduced_chi_squared, 3)}"
        notes = [f"rms residual {number_text(misfit(fit, fit), 3)} σ", quality_text, *notes]
    notes.append(f"Δ = model − data{f', σ {origin}' if (origin := _origin(fit)) else ''}")
    notes.append(fit_heading(fit, ": ").partition(": ")[2].rpartition(", ")[0])
    return FitContents(
        title=f"{fit.scene.name}: {finding_text(fit)}",
        warning=warning,
        notes=tuple(filter(None, notes)),
        columns=tuple(_column(fit, name, results) for name in fit.columns),
        parameters=tuple(_fitted_parameter(fit, parameter) for parameter in fit.parameters),
        data_sets=len(fit.data),
    )


def finding_text(fit: Estimates) -> str:
    """Return the headline's words: the only parameter with its value, or the least certain one of several."""
    label = least_certain_of(fit)
    parameter = next(parameter for parameter in fit.parameters if parameter.label == label)
    name = plain_name(parameter.name) + label.removeprefix(parameter.name)
    sentence = f"{name} is {estimate_text(fit, label).removeprefix(label).strip()}"
    if label in fit.at_bounds or len(fit.values) == 1:
        return sentence
    return f"{sentence}, the least certain of {len(fit.values)} estimates"


def _fitted_parameter(fit: Estimates, parameter: Parameter) -> FittedParameter:
    """Return a parameter with its texts and distances; without a distance if the data do not determine it."""
    label = parameter.label
    value, ends = fit.values[label], fit.intervals[label]
    is_known = value != 0.0 and label not in fit.at_bounds
    interval_distance = max(abs(end - value) for end in ends) / abs(value) if is_known else math.nan
    return FittedParameter(
        name=label,
        start_text=number_text(parameter.start, 4),
        value_text=estimate_text(fit, label).removeprefix(label).strip(),
        start_distance=abs(parameter.start - value) / abs(value) if value else math.nan,
        interval_distance=interval_distance if is_determined(parameter, ends) else math.nan,
    )


def _origin(fit: Estimates) -> str:
    """Return "given" or "estimated", if this is the origin of the σ of all columns; else ""."""
    return {0: "given", len(fit.columns): "estimated"}.get(len(fit.estimated), "")


def _column(fit: Estimates, name: str, results: list[Result]) -> FittedColumn:
    """Return a measured column; ``results``: the model's run of each data set."""
    series, first = list[FittedSeries](), 0
    for k, data in enumerate(fit.data):
        if name in data.quantity:
            series.append(_series(fit, name, k, first, results[k]))
        first += len(data)
    # the text below the headline tells a common origin
    text = sigma_text(fit, name) if _origin(fit) else sigma_of(fit, name)
    return FittedColumn(name, fit.unit(name), text, name in MEASURED_OF_IMPACT, tuple(series))


def _series(fit: Estimates, name: str, k: int, first: int, result: Result) -> FittedSeries:
    """Return the values of a measured column in data set ``k``.

    ``first``: the index of the data set's first value among the values of all data sets; ``result``: the
    model's run.
    """
    data = fit.data[k]
    own_rows = np.flatnonzero(np.array(data.quantity) == name)
    rows = first + own_rows
    course, onsets = None, np.zeros(0)
    if name in MEASURED_OF_IMPACT:
        positions = _numbers(data, data.row[own_rows], result)
    else:
        positions = data.times[data.row[own_rows]]
        last = positions.max()
        is_shown = result.time <= last
        course = np.array([result.time[is_shown], result[name][is_shown]])
        onsets = result.impacts["onset"]
        onsets = onsets[onsets <= last]
    return FittedSeries(
        k, positions, data.value[own_rows], fit.residuals[rows], fit.sigma[rows], course, onsets
    )


def _numbers(data: Measurements, rows: np.ndarray, result: Result) -> np.ndarray:
    """Return for each measured impact the number of the same impact in the model, from 1, shape (K,).

    ``rows``: the indices of the K measured impacts in ``data.impacts``; ``result``: the model's run. The
    number is NaN if the model lacks the impact.
    """
    found_rows = (data.impacts[row].find(result.impacts) for row in rows)
    return np.array([np.nan if match is None else match + 1.0 for match in found_rows])
