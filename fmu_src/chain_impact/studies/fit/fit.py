"""The fit: estimate parameters of a scene from measurements."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import cast

import numpy as np

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.progress import Progress, no_progress
from chain_impact.scene.errors import SceneError
from chain_impact.scene.files.table_file import TableSource, is_table
from chain_impact.scene.scene import Scene, SceneSource, scene_of
from chain_impact.simulation.given_inputs import Interpolation
from chain_impact.studies.fit.horizon import SearchSeries, freedom_of_columns, search_parameters
from chain_impact.studies.fit.measured_tables import read_measurements
from chain_impact.studies.fit.measurements import Measurements
from chain_impact.studies.fit.parameters import Bounds, Parameter, fitted_parameters
from chain_impact.studies.fit.problem import Evaluation, Problem
from chain_impact.studies.fit.remarks import not_random, outliers, unusual_chi_squared
from chain_impact.studies.fit.result import Fit
from chain_impact.studies.fit.sigma import standard_deviation
from chain_impact.studies.fit.uncertainty import information_of, quantiles, small_sample
from chain_impact.studies.fit.undetermined import unknown_parameter_remarks
from chain_impact.text import count_text

# the logarithm of an interval's end counts as ± infinity beyond ± LARGEST_LOGARITHM; exp overflows above 709
LARGEST_LOGARITHM = 700.0
# a remark names each column whose σ is estimated from fewer than ROUGH_BELOW values, as this σ is inaccurate
ROUGH_BELOW = 10
# Data that last MOST_STOP_TIMES times the scene's stop time, or longer, are refused unless the user gives a
# stop time: the times are probably in ms instead of s.
MOST_STOP_TIMES = 100.0
FORCE_QUANTITIES = ("peak_force", "max_penetration")
"""Quantities of an impact that an impulse of a rigid wall does not have."""


def fit(
    scene: SceneSource,
    data: TableSource | Sequence[TableSource | Sequence[TableSource]],
    free: Sequence[str],
    *,
    free_each: Sequence[str] = (),
    set_each: Mapping[str, Sequence[float] | np.ndarray] | None = None,
    sigma: Mapping[str, float | str] | None = None,
    bounds: Bounds | None = None,
    columns: Sequence[str] | None = None,
    laws: bool = False,
    stop_time: float | None = None,
    interpolation: Interpolation = "follow",
    progress: Progress | None = None,
) -> Fit:
    """Estimate parameters of a scene from measurements, by weighted least squares.

    The search starts from the values of the scene, fits early data first and then more and more data, and
    uses derivatives of the motion through all impacts.

    Args:
        scene: the measured system: a scene, or an argument of ``load_scene``.
        data: a table: a CSV file, a mapping of columns, or a ``DataFrame`` of pandas. Or a list with an entry
            for each data set: a table, or a list of tables of the same run. See ``docs/fit.md``.
        free: names of parameters and inputs of the FMU that have one value for all data sets; such an input
            is constant in time.
        free_each: names of parameters and inputs that have a value for each data set.
        set_each: name → known values, one for each data set.
        sigma: column → standard deviation of the values, in the unit of the column, or in percent of each
            value: ``"2%"``. If neither ``sigma`` nor the data give the standard deviation of a column, the
            fit estimates it from the residuals.
        bounds: name → bounds in addition to the limits of the scene's keys, ``"0.1:0.9"`` or a pair.
        columns: names or patterns of the columns that are used; all columns by default.
        laws: whether to fit every contact law, and return the fit of the best law with the ranking of all
            laws.
        stop_time: time [s] up to which data are used, and stop time of the fitted scene. By default all data
            are used.
        interpolation: interpolation of inputs between the rows of the data, as in ``simulate``.
        progress: called with the finished fraction, 0 to 1, if given.

    Raises:
        SceneError: when an argument or a table cannot be used, or, without ``stop_time``, data are so long
            that their time is probably not in seconds.
        OSError: when a file cannot be read.
        BuildError: when the kernel cannot be compiled.
    """
    scene, progress = scene_of(scene), progress or no_progress
    usual_stop = scene.simulation.stop_time
    if stop_time is not None:
        scene = scene.with_values({"simulation.stop_time": stop_time})
    for name, value in (sigma or {}).items():
        standard_deviation(name, value, 1.0)
    runs = _runs(data)
    scenes = _scenes(scene, len(runs), set_each or {})
    all_data = [
        replace(read_measurements(run, scene, sigma or {}, columns), interpolation=interpolation)
        for run in runs
    ]
    data_sets = all_data if stop_time is None else [data_set.cut_at(stop_time) for data_set in all_data]
    late_count = sum(map(len, all_data)) - sum(map(len, data_sets))
    late_text = (
        [
            f"{late_count} of {sum(map(len, all_data))} values lie after the stop time, {stop_time:g} s: "
            "they were not used."
        ]
        if late_count
        else []
    )
    if stop_time is None and (long_sentences := _long_data_sentences(usual_stop, all_data)):
        raise SceneError(f"{scene.name}: {'; '.join(long_sentences)}: if it is in s, give the stop time")
    _check_sigma(scene, sigma or {}, data_sets)

    def fit_scenes(scenes: Sequence[Scene], progress: Progress) -> Fit:
        parameters = fitted_parameters(scenes, free, free_each, bounds or {})
        _check_inputs(scene, parameters, data_sets)
        try:
            result = _fit(Problem(scenes, data_sets, parameters), progress)
        except SceneError as error:
            raise SceneError("; ".join([str(error), *late_text])) from None
        return replace(result, notes=(*late_text, *result.notes))

    if laws:
        from chain_impact.studies.fit.law_ranking import fit_and_rank_laws

        return fit_and_rank_laws(fit_scenes, scenes, progress)
    return fit_scenes(scenes, progress)


def _fit(problem: Problem, progress: Progress) -> Fit:
    """Search the parameters of a problem, whose scenes have one contact law, and return the fit."""
    search_result = search_parameters(problem, progress)
    evaluation = _on_bounds(problem, search_result)
    rows = evaluation.is_usable
    _check_rigid(problem, rows)
    if rows.sum() < len(problem.parameters):
        few_text = (
            f"{problem.scenes[0].name}: {count_text(int(rows.sum()), 'value')} can be fitted, "
            f"must be at least {len(problem.parameters)}, as many as parameters are free"
        )
        raise SceneError("; ".join([few_text, *_left_out_remarks(problem, evaluation)]))
    fisher_information = information_of(evaluation.slopes[rows], search_result.sigma[rows])
    reached_bounds = problem.bounds_reached(evaluation.coordinates, fisher_information.alone)
    values, covariance = problem.values(evaluation.coordinates), fisher_information.covariance
    labels = [parameter.label for parameter in problem.parameters]
    columns = freedom_of_columns(problem, evaluation, search_result.sigma)
    groups = [(problem.group[rows] == group, column_freedom) for group, column_freedom in columns.items()]
    sample = small_sample(evaluation.slopes[rows], search_result.sigma[rows], groups)
    errors = fisher_information.errors * sample.factor
    halves = errors * quantiles(sample.freedom)
    with np.errstate(invalid="ignore"):
        correlation = covariance / np.outer(fisher_information.errors, fisher_information.errors)
    scenes = tuple(
        _fitted_scene(scene, k, problem.parameters, values) for k, scene in enumerate(problem.scenes)
    )
    result = Fit(
        scene=scenes[0],
        scenes=scenes,
        parameters=problem.parameters,
        values=dict(zip(labels, values.tolist(), strict=True)),
        standard_errors=dict(zip(labels, (errors * problem.scale(values)).tolist(), strict=True)),
        intervals={
            label: _interval(scene, coordinate, half)
            for label, scene, coordinate, half in zip(
                labels, problem.parameters, evaluation.coordinates, halves, strict=True
            )
        },
        correlation=correlation,
        data=problem.data,
        residuals=np.where(rows, evaluation.residuals, np.nan),
        sigma=search_result.sigma,
        estimated=problem.estimated,
        deviance=_deviance(problem, evaluation, rows),
        converged=search_result.last_search.converged,
        evaluations=problem.evaluations,
        horizons=search_result.horizons,
        at_bounds={labels[p]: bound for p, bound in reached_bounds.items()},
        unknown=tuple(unknown_parameter_remarks(problem, evaluation, fisher_information, reached_bounds)),
        model_runs=evaluation.runs,
    )
    return replace(result, notes=tuple(_fit_remarks(problem, result, evaluation, search_result)))


def _check_rigid(problem: Problem, is_usable: np.ndarray) -> None:
    """Refuse a column of FORCE_QUANTITIES if none of it can be fitted (``is_usable``) and walls are rigid."""
    scene = problem.scenes[0]
    law = CONTACT_LAWS.get(scene.contact.model)
    if not (law and law.rigid):
        return
    for group, name in enumerate(problem.names):
        if name in FORCE_QUANTITIES and not is_usable[problem.group == group].any():
            raise SceneError(
                f"{scene.name}: a rigid impact, contact.model = {law.id}, has no {name}: leave the column "
                "out, or choose a law with a force"
            )


def _on_bounds(problem: Problem, search_result: SearchSeries) -> Evaluation:
    """Return the model at the end of the search, with each parameter close to a bound set to this bound.

    The search approaches a bound without reaching it. If a measured value can be fitted only at the bounds,
    or only with the parameters of the search, for example because an impact is missing at the bounds, the
    model with the parameters of the search is returned.
    """
    evaluation = search_result.last_search.best
    alone_errors = information_of(
        evaluation.slopes[evaluation.is_usable], search_result.sigma[evaluation.is_usable]
    ).alone
    reached_bounds = problem.bounds_reached(evaluation.coordinates, alone_errors)
    if not reached_bounds:
        return evaluation
    coordinates = evaluation.coordinates.copy()
    for p, bound in reached_bounds.items():
        coordinates[p] = problem.low[p] if bound == "lower" else problem.high[p]
    on_bounds = problem.evaluate(coordinates)
    return on_bounds if np.array_equal(on_bounds.is_usable, evaluation.is_usable) else evaluation


def _runs(
    data: TableSource | Sequence[TableSource | Sequence[TableSource]],
) -> list[TableSource | Sequence[TableSource]]:
    """Return a list with an entry for each data set: a table, or a list of tables of the same run."""
    runs = list(cast("Iterable[TableSource | Sequence[TableSource]]", [data] if is_table(data) else data))
    if not runs:
        raise SceneError("data: must be at least one table")
    return runs


def _scenes(scene: Scene, count: int, set_each: Mapping[str, Sequence[float] | np.ndarray]) -> list[Scene]:
    """Return ``count`` scenes, one for each data set, with the values for this data set in ``set_each``.

    Refuse a list in ``set_each`` that has not ``count`` values.
    """
    for name, values in set_each.items():
        if len(values) != count:
            raise SceneError(
                f"{scene.name}: {name} has {count_text(len(values), 'value')}, must have {count}, "
                "one for each data set"
            )
    return [
        scene.with_values({name: values[k] for name, values in set_each.items()}) if set_each else scene
        for k in range(count)
    ]


def _long_data_sentences(stop_time: float, data: Sequence[Measurements]) -> list[str]:
    """Return a sentence for each data set that lasts at least MOST_STOP_TIMES × ``stop_time``.

    ``stop_time`` is the stop time of the scene [s]. The times of such data are probably in ms.
    """
    end_times = [(data_set.source, float(np.nanmax(data_set.value_times, initial=0.0))) for data_set in data]
    return [
        f"{source} lasts {last:g} s, {last / stop_time:.0f} times as long as the scene, {stop_time:g} s: "
        "its time must be in s, not in ms"
        for source, last in end_times
        if last >= MOST_STOP_TIMES * stop_time
    ]


def _check_sigma(scene: Scene, sigma: Iterable[str], data_sets: Sequence[Measurements]) -> None:
    """Refuse a name in ``sigma`` that is not a measured column."""
    names = {name for data_set in data_sets for name in data_set.quantity}
    for name in sigma:
        if name not in names:
            raise SceneError(
                f": no such column was measured, but {', '.join(sorted(names))}",
                source=scene.name,
                argument="sigma",
                name=name,
            )


def _check_inputs(scene: Scene, parameters: Sequence[Parameter], data_sets: Sequence[Measurements]) -> None:
    """Refuse a free parameter that is an input, if a data set for which it is free has this input."""
    for parameter in parameters:
        for k, data_set in enumerate(data_sets):
            if parameter.data_set in (None, k) and parameter.name in data_set.inputs:
                reason = f"is free, and is a column of {data_set.source}; must be only one of the two"
                raise SceneError(f"{scene.name}: {parameter.name} {reason}")


def _interval(parameter: Parameter, coordinate: float, half: float) -> tuple[float, float]:
    """Return both ends of a parameter's interval as values of the parameter, cut off at its bounds.

    Args:
        parameter: the parameter.
        coordinate: the fitted value on the scale of the search.
        half: half of the interval's width on the scale of the search.
    """
    ends = np.array([coordinate - half, coordinate + half])
    if parameter.logarithmic:
        ends[np.abs(ends) > LARGEST_LOGARITHM] *= math.inf
    low, high = (min(max(parameter.value(end), parameter.low), parameter.high) for end in ends.tolist())
    return low, high


def _fitted_scene(scene: Scene, k: int, parameters: Sequence[Parameter], values: np.ndarray) -> Scene:
    """Return the scene of data set ``k`` with the fitted values, except those of inputs."""
    scene_values = scene.values
    fitted_pairs = zip(parameters, values.tolist(), strict=True)
    return scene.with_values(
        {
            parameter.name: value
            for parameter, value in fitted_pairs
            if parameter.data_set in (None, k) and parameter.name in scene_values
        }
    )


def _deviance(problem: Problem, evaluation: Evaluation, rows: np.ndarray) -> float:
    """Return −2 log of the likelihood for normal errors, up to a constant that depends only on the data.

    A column of n fitted residuals r adds Σ (r/σ)² if σ is given, and n log(Σ r²/n) if σ is estimated.
    ``rows``: whether each value was fitted, shape (M,).
    """
    total = 0.0
    for group, name in enumerate(problem.names):
        is_in_group = rows & (problem.group == group)
        residuals = evaluation.residuals[is_in_group]
        if name in problem.estimated:
            mean = max(float((residuals**2).mean()), np.finfo(float).tiny) if is_in_group.any() else 1.0
            total += is_in_group.sum() * math.log(mean)
        else:
            total += float(((residuals / problem.sigma[is_in_group]) ** 2).sum())
    return float(total)


def _fit_remarks(
    problem: Problem, result: Fit, evaluation: Evaluation, search_result: SearchSeries
) -> list[str]:
    """Return the remarks on a fit: convergence, values left out, bounds, inputs, residuals, rough σ."""
    notes = []
    if not result.converged and np.isfinite(list(result.standard_errors.values())).any():
        notes.append(
            f"The search did not converge in {search_result.last_search.steps} steps: "
            "start nearer, or free fewer parameters."
        )
    notes += _left_out_remarks(problem, evaluation)
    notes += [
        f"{label} is at its {bound} bound, {result.values[label]:.6g}: "
        "its standard error and interval do not hold."
        for label, bound in result.at_bounds.items()
    ]
    for parameter in problem.parameters:
        if parameter.name not in problem.scenes[0].values:
            notes.append(f"{parameter.label} is an input: the fitted scene does not hold it.")
    notes += [*outliers(result, evaluation.slopes), *unusual_chi_squared(result)]
    return [*notes, *not_random(result), *_few_values_remarks(problem, evaluation)]


def _few_values_remarks(problem: Problem, evaluation: Evaluation) -> Iterator[str]:
    """Yield a remark for each column whose σ is estimated from 1 to ROUGH_BELOW − 1 fitted values."""
    for name in problem.estimated:
        count = int((evaluation.is_usable & (problem.group == problem.names.index(name))).sum())
        if 0 < count < ROUGH_BELOW:
            yield (
                f"{name} has {count_text(count, 'value')}: a σ that is estimated from fewer "
                f"than {ROUGH_BELOW} is rough, and so are the intervals. Give its sigma if you know it."
            )


def _left_out_remarks(problem: Problem, evaluation: Evaluation) -> list[str]:
    """Return remarks on the measured values that were not fitted, with the reasons; [] without any."""
    count, notes = len(problem.value), []
    missing_count, blind_count = (
        int((~evaluation.exists).sum()),
        int((evaluation.exists & ~evaluation.is_usable).sum()),
    )
    if missing_count:
        fault = problem.fault(evaluation)
        reason = fault or "the model has no such impact, or its contact lasts to the end"
        columns_text = ", ".join(
            problem.names[group] for group in np.unique(problem.group[~evaluation.exists])
        )
        notes.append(f"{missing_count} of {count} values were left out, of {columns_text}: {reason}.")
    if blind_count:
        limits = [limit for run in evaluation.runs for limit in run.limits] or ["a derivative does not exist"]
        notes.append(
            f"{blind_count} of {count} values were left out, for want of a derivative: {'; '.join(limits)}."
        )
    return notes
