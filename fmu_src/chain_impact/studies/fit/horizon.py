"""The search with a growing horizon: first early data, at last all.

After some impacts the motion depends so strongly on the parameters that the sum of squares of all data has
many minima; that of early data has one. So the horizon grows, as far as the model already follows the data,
and each search starts where the last one ended.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from chain_impact.progress import Progress, silent
from chain_impact.scene.reading import SceneError
from chain_impact.studies.fit.least_squares import Search, minimize
from chain_impact.studies.fit.problem import Evaluation, Problem

ROWS = 3  # values in the first horizon, for each parameter, but no more than a third of all if that is enough
FAR = (0.01, 0.0025)  # of the size of a column: a model so far away is not followed; first and second trial
WORSE, EXACT = 1.2, 1e-6  # growth of the mean square that asks for a second trial, unless it is as small
MANY = 20  # values, from which on a mean square says something
GROWTH = 1.1  # of the horizon, at least
ROUGH, FINE = 1e-2, 1e-9  # relative change of the sum of squares that is small enough
ROUGH_STEPS, FINE_STEPS = 10, 100
LEAST_SIGMA = 1e-8  # of the size of a column: less is no noise, but the tolerance of the solver
NO_FREEDOM = 1e-9  # degrees: less is round-off; a little is enough, as a column with a larger σ has more
SETTLED, ROUNDS = 0.01, 20  # relative change of an estimated standard deviation


@dataclass(frozen=True)
class Found:
    """Where the search ended.

    Attributes:
        search: the last one, with all data.
        sigma: standard deviation of each value, given or estimated, shape (M,).
        horizons: until when [s] data were used, one after the other.
        worse: mean square of the residuals, over the least of those with fewer data.
    """

    search: Search
    sigma: np.ndarray
    horizons: tuple[float, ...]
    worse: float


def search(problem: Problem, progress: Progress = silent) -> Found:
    """Fit the free parameters.

    Raises:
        SceneError: when the model has nothing to compare with the data.
    """
    start = problem.evaluate(problem.start)
    _check(problem, start)
    first = _search(problem, start, FAR[0], progress)
    if first.search.converged and first.worse < WORSE:
        return first
    second = _search(problem, start, FAR[1], progress)
    return min(first, second, key=lambda found: _squares(found.search.best, first.sigma))


def _search(problem: Problem, start: Evaluation, far: float, progress: Progress) -> Found:
    """Return the search with horizons that end where the model is as far from the data as this."""
    whole, sigma = start, _first_sigma(problem)
    last = float(np.nanmax(problem.order, initial=0.0))
    horizons = [_first_horizon(problem, whole, far)]
    best = math.inf
    while horizons[-1] < math.inf:
        found, sigma = _one(problem, whole, sigma, horizons[-1], enough=ROUGH, most=ROUGH_STEPS)
        if found.best.usable.sum() >= MANY:
            best = min(best, _squares(found.best, sigma))
        whole = problem.evaluate(found.best.place)
        horizons.append(_next_horizon(problem, whole, horizons[-1], far))
        progress(min(1.0, horizons[-2] / last))
    early = sigma
    for _ in range(ROUNDS):
        present = sigma
        found, sigma = _one(problem, whole, present, math.inf, enough=FINE, most=FINE_STEPS)
        whole = found.best
        if len(problem.names) == 1 or np.allclose(sigma, present, rtol=SETTLED, atol=0.0):
            break
    worse = _squares(whole, early) / max(best, EXACT)
    return Found(found, sigma, (*horizons[:-1], last), worse)


def _squares(at: Evaluation, sigma: np.ndarray) -> float:
    """Return the mean square of the residuals in standard deviations; infinite if there is none."""
    rows = at.usable
    return float(np.mean((at.residuals[rows] / sigma[rows]) ** 2)) if rows.any() else math.inf


def _one(
    problem: Problem, whole: Evaluation, sigma: np.ndarray, horizon: float, *, enough: float, most: int
) -> tuple[Search, np.ndarray]:
    """Return the search with the data until a horizon, and the standard deviations that follow."""
    found = minimize(
        lambda place: problem.evaluate(place, horizon),
        problem.until(whole, horizon),
        sigma,
        bounds=(problem.low, problem.high),
        enough=enough,
        most=most,
    )
    return found, estimate_sigma(problem, found.best, sigma)


def estimate_sigma(problem: Problem, at: Evaluation, sigma: np.ndarray) -> np.ndarray:
    """Return standard deviations, of columns for which none is given from their residuals, shape (M,).

    A column of n residuals r with ν degrees of freedom has σ² = Σ r²/ν. One with none, as its values are no
    more than the parameters that they determine, tells no σ: it keeps the present one.
    """
    found, rows = sigma.copy(), at.usable
    free = freedom_of_columns(problem, at, sigma)
    for group, least in _estimated(problem):
        mine = problem.group == group
        if free[group] > NO_FREEDOM:
            squares = (at.residuals[rows & mine] ** 2).sum()
            found[mine] = max(least, math.sqrt(squares / free[group]))
    return found


def freedom_of_columns(problem: Problem, at: Evaluation, sigma: np.ndarray) -> dict[int, float]:
    """Return degrees of freedom of each column of which the standard deviation is estimated: its number → ν.

    A column of n values has ν = n − h, with h the part of the parameters that it determines: the sum of its
    leverages.
    """
    rows = np.flatnonzero(at.usable)
    left, singular, _ = np.linalg.svd(at.slopes[rows] / sigma[rows, None], full_matrices=False)
    rank = singular > 1e-12 * max(singular.max(initial=0.0), 1e-300)
    leverage = (left[:, rank] ** 2).sum(axis=1)
    mine = {group: problem.group[rows] == group for group, _ in _estimated(problem)}
    return {group: float(own.sum() - leverage[own].sum()) for group, own in mine.items()}


def _first_sigma(problem: Problem) -> np.ndarray:
    """What is given, and a hundredth of the size of the columns for which nothing is given."""
    sigma = problem.sigma.copy()
    for group, least in _estimated(problem):
        sigma[problem.group == group] = 0.01 / LEAST_SIGMA * least
    return sigma


def _estimated(problem: Problem) -> list[tuple[int, float]]:
    """Return number and least standard deviation of the columns for which none is given."""
    groups = [problem.names.index(name) for name in problem.estimated]
    return [(group, LEAST_SIGMA * float(problem.size[problem.group == group][0])) for group in groups]


def _check(problem: Problem, whole: Evaluation) -> None:
    """Refuse data with which nothing can be done."""
    for name in problem.estimated:
        mine = problem.group == problem.names.index(name)
        sources = ", ".join(one.source for one in problem.data)
        if not np.isnan(problem.sigma[mine]).all():
            raise SceneError(
                f"{sources}: some values of {name} have a sigma and others none; give all or none"
            )
        if mine.sum() < 2:  # noqa: PLR2004
            raise SceneError(
                f"{sources}: {name} has one value only, from which its sigma cannot be estimated: give it, "
                f"sigma of {name} = 2% for example, or add a column sigma({name})"
            )
    if not whole.there.any():
        fault = problem.fault(whole) or "none of the measured impacts is there"
        raise SceneError(f"{problem.scenes[0].name}: no value of the model to compare with the data: {fault}")


def _first_horizon(problem: Problem, whole: Evaluation, far: float) -> float:
    """Until when [s] the first data reach that can determine the parameters; infinite for all data."""
    times = np.sort(problem.order[np.isfinite(problem.order)])
    least = len(problem.parameters)
    rows = max(least, min(ROWS * least, len(times) // ROWS))
    return (
        _next_horizon(problem, whole, float(times[rows - 1]) / GROWTH, far)
        if rows <= len(times)
        else math.inf
    )


def _next_horizon(problem: Problem, whole: Evaluation, horizon: float, far: float) -> float:
    """As far as the model follows the data roughly, and farther than before; infinite for all data.

    It follows them as long as outputs over time are near, or times of impacts if no outputs were measured.
    """
    away = problem.followed & ~(np.abs(whole.residuals) <= far * problem.size)
    order = problem.order
    last = float(np.nanmax(order))
    reached = float(np.min(order[away], initial=math.inf, where=np.isfinite(order[away])))
    found = max(GROWTH * horizon, reached)
    return found if found < last else math.inf
