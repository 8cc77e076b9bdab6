"""The search with a growing horizon: as a rule only early data are fitted first, and always all data last.

After some impacts the motion depends so strongly on the parameters that the sum of squares of all residuals
often has many local minima, while the sum over early data has few. So a series of searches is made. Each
search uses the data up to its horizon, and starts at the parameters that the previous search has found. Each
horizon is the time up to which the model with the start parameters of the search follows the data, or later.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from chain_impact.progress import Progress, no_progress
from chain_impact.scene.errors import SceneError
from chain_impact.studies.fit.least_squares import Search, minimize
from chain_impact.studies.fit.problem import Evaluation, Problem

# For P parameters and N values with a time, at least VALUES_PER_PARAMETER × P values have a time up to the
# first horizon, or N / VALUES_PER_PARAMETER values if this number is smaller, but not fewer than P values.
VALUES_PER_PARAMETER = 3
# The model follows the data as long as its difference from each value in ``Problem.is_followed`` is at most
# FOLLOWED_WITHIN × the size of the value's column: FOLLOWED_WITHIN[0] in the first series of searches,
# FOLLOWED_WITHIN[1] in the second series.
FOLLOWED_WITHIN = (0.01, 0.0025)
# A second series of searches follows if the first series does not converge; or if the mean square of the
# residuals r/σ with all data is at least SUSPICIOUS_RATIO × the smallest mean square with fewer data, which
# is a sign of a wrong minimum. The smallest mean square counts as at least LEAST_SQUARE, because smaller ones
# are only round-off.
SUSPICIOUS_RATIO, LEAST_SQUARE = 1.2, 1e-6
# a mean square of fewer residuals than MANY_VALUES is too random to be compared with other mean squares
MANY_VALUES = 20
GROWTH = 1.1  # each horizon, except the first and the last, is at least GROWTH × the preceding horizon
# A search ends when a step changes the sum of squares, relative to the sum, by less than ROUGH_CHANGE while
# the horizon grows, and by less than FINE_CHANGE with all data; or after ROUGH_STEPS or FINE_STEPS steps.
ROUGH_CHANGE, FINE_CHANGE = 1e-2, 1e-9
ROUGH_STEPS, FINE_STEPS = 10, 100
# an estimated standard deviation is at least LEAST_SIGMA × the size of its column: smaller residuals are
# errors of the solver, not of the measurement
LEAST_SIGMA = 1e-8
# A column's degrees of freedom ν count as 0 below this limit, as round-off. A larger limit is not needed: a
# small ν gives a large estimated σ, so the column has less weight in the next round, determines fewer
# parameters, and has a larger ν.
NO_FREEDOM = 1e-9
# The search with all data is repeated with newly estimated standard deviations until none of these changes,
# relatively, by more than SETTLED_SIGMA, but made at most MOST_ROUNDS times in all. With a single measured
# column the search is made once, because an estimated σ, common to all values, does not move the minimum.
SETTLED_SIGMA, MOST_ROUNDS = 0.01, 20


@dataclass(frozen=True)
class SearchSeries:
    """The result of a series of searches with growing horizons.

    Attributes:
        last_search: the result of the last search, with all data.
        sigma: standard deviation of each value, given or estimated, shape (M,).
        horizons: the horizon of each search with fewer data, the time [s] up to which the search used data;
            at the end one entry for all searches with all data: the last time of a value, 0 if none has one.
        misfit_ratio: mean square of the residuals r/σ with all data, divided by the smallest mean square (at
            least LEAST_SQUARE) of the searches with fewer data that used at least MANY_VALUES values; 0 if no
            search with fewer data used so many values.
    """

    last_search: Search
    sigma: np.ndarray
    horizons: tuple[float, ...]
    misfit_ratio: float


def search_parameters(problem: Problem, progress: Progress = no_progress) -> SearchSeries:
    """Search the values of the free parameters, and return the result of a series of searches.

    If the first series does not converge, or probably ends in a wrong minimum (see SUSPICIOUS_RATIO), a
    second series is made. Then the result with the smaller mean square of r/σ is returned, with the σ of the
    first series for both mean squares.

    Raises:
        SceneError: when the data cannot be fitted, or the model at the start has none of the measured values.
    """
    start = problem.evaluate(problem.start)
    _check(problem, start)
    first = _search_with_growing_horizon(problem, start, FOLLOWED_WITHIN[0], progress)
    if first.last_search.converged and first.misfit_ratio < SUSPICIOUS_RATIO:
        return first
    second_search = _search_with_growing_horizon(problem, start, FOLLOWED_WITHIN[1], progress)
    return min(
        first, second_search, key=lambda candidate: _mean_square(candidate.last_search.best, first.sigma)
    )


def _search_with_growing_horizon(
    problem: Problem, start: Evaluation, far_ratio: float, progress: Progress
) -> SearchSeries:
    """Return the result of a series of searches, whose horizons grow until all data are used.

    ``start`` is the model at the start values; for ``far_ratio`` and each next horizon see ``_next_horizon``.
    """
    evaluation, sigma = start, _first_sigma(problem)
    last = float(np.nanmax(problem.value_times, initial=0.0))
    horizons = [_first_horizon(problem, evaluation, far_ratio)]
    best = math.inf
    while horizons[-1] < math.inf:
        result, sigma = _search_to_horizon(
            problem, evaluation, sigma, horizons[-1], enough_decrease=ROUGH_CHANGE, most_steps=ROUGH_STEPS
        )
        if result.best.is_usable.sum() >= MANY_VALUES:
            best = min(best, _mean_square(result.best, sigma))
        evaluation = problem.evaluate(result.best.coordinates)
        horizons.append(_next_horizon(problem, evaluation, horizons[-1], far_ratio))
        progress(min(1.0, horizons[-2] / last))
    earlier_sigma = sigma
    for _ in range(MOST_ROUNDS):
        present_sigma = sigma
        result, sigma = _search_to_horizon(
            problem, evaluation, present_sigma, math.inf, enough_decrease=FINE_CHANGE, most_steps=FINE_STEPS
        )
        evaluation = result.best
        if len(problem.names) == 1 or np.allclose(sigma, present_sigma, rtol=SETTLED_SIGMA, atol=0.0):
            break
    misfit_ratio = _mean_square(evaluation, earlier_sigma) / max(best, LEAST_SQUARE)
    return SearchSeries(result, sigma, (*horizons[:-1], last), misfit_ratio)


def _mean_square(evaluation: Evaluation, sigma: np.ndarray) -> float:
    """Return the mean square of a model's usable residuals r/σ; infinity if no residual is usable."""
    rows = evaluation.is_usable
    return float(np.mean((evaluation.residuals[rows] / sigma[rows]) ** 2)) if rows.any() else math.inf


def _search_to_horizon(
    problem: Problem,
    evaluation: Evaluation,
    sigma: np.ndarray,
    horizon: float,
    *,
    enough_decrease: float,
    most_steps: int,
) -> tuple[Search, np.ndarray]:
    """Return the result of a search with the data up to a horizon [s], and new σ of all values, shape (M,).

    ``evaluation`` is the model at the start of the search, compared with all data; ``sigma`` has the σ that
    the search uses; see ``minimize`` for ``enough_decrease`` and ``most_steps``.
    """
    minimum_found = minimize(
        lambda coordinates: problem.evaluate(coordinates, horizon),
        problem.cut_at_horizon(evaluation, horizon),
        sigma,
        bounds=(problem.low, problem.high),
        enough_decrease=enough_decrease,
        most_steps=most_steps,
    )
    return minimum_found, estimate_sigma(problem, minimum_found.best, sigma)


def estimate_sigma(problem: Problem, evaluation: Evaluation, sigma: np.ndarray) -> np.ndarray:
    """Return the standard deviation σ of each value, shape (M,): the given one, or a new estimate.

    For a column without given σ, the usable residuals r with ν degrees of freedom give σ² = Σ r²/ν, but σ is
    at least LEAST_SIGMA times the size of the column. If ν (``freedom_of_columns``) is at most NO_FREEDOM, σ
    stays as in ``sigma``.
    """
    estimated_sigma, rows = sigma.copy(), evaluation.is_usable
    freedom = freedom_of_columns(problem, evaluation, sigma)
    for group, least_sigma in _columns_without_sigma(problem):
        is_in_group = problem.group == group
        if freedom[group] > NO_FREEDOM:
            squares = (evaluation.residuals[rows & is_in_group] ** 2).sum()
            estimated_sigma[is_in_group] = max(least_sigma, math.sqrt(squares / freedom[group]))
    return estimated_sigma


def freedom_of_columns(problem: Problem, evaluation: Evaluation, sigma: np.ndarray) -> dict[int, float]:
    """Return the degrees of freedom ν of the columns with an estimated σ: index of the column → ν.

    A column with n usable values has ν = n − h. Here h, the sum of the leverages of these values, is the
    number of parameters that the column determines; it need not be whole.
    """
    rows = np.flatnonzero(evaluation.is_usable)
    left_vectors, singular, _ = np.linalg.svd(
        evaluation.slopes[rows] / sigma[rows, None], full_matrices=False
    )
    is_nonzero = singular > 1e-12 * max(singular.max(initial=0.0), 1e-300)
    leverage = (left_vectors[:, is_nonzero] ** 2).sum(axis=1)
    rows_of_groups = {group: problem.group[rows] == group for group, _ in _columns_without_sigma(problem)}
    return {group: float(rows.sum() - leverage[rows].sum()) for group, rows in rows_of_groups.items()}


def _first_sigma(problem: Problem) -> np.ndarray:
    """Return the first σ of each value, shape (M,): the given one, or 0.01 × the column's ``size``."""
    sigma = problem.sigma.copy()
    for group, least_sigma in _columns_without_sigma(problem):
        sigma[problem.group == group] = 0.01 / LEAST_SIGMA * least_sigma
    return sigma


def _columns_without_sigma(problem: Problem) -> list[tuple[int, float]]:
    """Return index in ``problem.names``, and least estimate of σ, of each column without a given σ."""
    groups = [problem.names.index(name) for name in problem.estimated]
    return [(group, LEAST_SIGMA * float(problem.size[problem.group == group][0])) for group in groups]


def _check(problem: Problem, evaluation: Evaluation) -> None:
    """Refuse data that cannot be fitted, and a model (``evaluation``) that has none of the measured values.

    A column cannot be fitted if only some of its values have a σ, or if it has a single value without σ.
    """
    for name in problem.estimated:
        is_in_group = problem.group == problem.names.index(name)
        sources_text = ", ".join(data_set.source for data_set in problem.data)
        if not np.isnan(problem.sigma[is_in_group]).all():
            raise SceneError(
                f"{sources_text}: some values of {name} have a sigma and others none; give all or none"
            )
        if is_in_group.sum() <= 1:
            raise SceneError(
                f"{sources_text}: {name} has one value only, from which its sigma cannot be estimated: give "
                f"it, for example 2% (--sigma {name}=2%), or add a column sigma({name})"
            )
    if not evaluation.exists.any():
        fault = problem.fault(evaluation) or "the model has none of the measured impacts"
        raise SceneError(f"{problem.scenes[0].name}: the model has no value to compare with data: {fault}")


def _first_horizon(problem: Problem, evaluation: Evaluation, far_ratio: float) -> float:
    """Return the first horizon [s]: infinity if the first search is to use all data.

    The horizon is the time up to which as many values lie as VALUES_PER_PARAMETER demands or, if later, the
    time up to which the model follows the data. The horizon is infinite if too few values have a time, or if
    no value has a time later than the horizon. ``evaluation`` is the model at the start values; for
    ``far_ratio`` see ``_next_horizon``.
    """
    times = np.sort(problem.value_times[np.isfinite(problem.value_times)])
    least_count = len(problem.parameters)
    rows = max(least_count, min(VALUES_PER_PARAMETER * least_count, len(times) // VALUES_PER_PARAMETER))
    return (
        _next_horizon(problem, evaluation, float(times[rows - 1]) / GROWTH, far_ratio)
        if rows <= len(times)
        else math.inf
    )


def _next_horizon(problem: Problem, evaluation: Evaluation, horizon: float, far_ratio: float) -> float:
    """Return the next horizon [s], the later one of two times; infinity if no value is later than both.

    One time is GROWTH × ``horizon``. The other is the first time of a value in ``Problem.is_followed`` that
    the model lacks, or from which it differs by more than ``far_ratio`` × the size of the column; infinity if
    no value is such. If ``horizon`` and both times are 0, the next horizon is the first time > 0 of a value.
    """
    is_far = problem.is_followed & ~(np.abs(evaluation.residuals) <= far_ratio * problem.size)
    times = problem.value_times
    last = float(np.nanmax(times))
    reached_time = float(np.min(times[is_far], initial=math.inf, where=np.isfinite(times[is_far])))
    next_horizon = max(GROWTH * horizon, reached_time)
    if next_horizon == horizon:  # only if ``horizon`` is 0
        next_horizon = float(np.min(times, initial=math.inf, where=times > horizon))
    return next_horizon if next_horizon < last else math.inf
