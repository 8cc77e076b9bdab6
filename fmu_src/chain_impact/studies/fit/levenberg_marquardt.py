"""Least squares by Levenberg and Marquardt, for rows that come and go.

The rows of a chain with impacts change from one set of parameters to another: an impact may not be there, or
a derivative not exist. So two sets are compared by the rows that can be fitted at the first of them. Scaled
as by D. W. Marquardt, J. Soc. Indust. Appl. Math. 11 (1963) 431; damping after H. B. Nielsen, report
IMM-REP-1999-05, Technical University of Denmark (1999).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from chain_impact.studies.fit.problem import Evaluation

FIRST_DAMPING, LEAST_DAMPING, MOST_DAMPING = 1e-3, 1e-10, 1e10
NEAR = 0.05  # standard errors from the least sum of squares, where round-off may hide any gain
TINY = 1e-300
ROUND_OFF = 1e-6  # the mean square of residuals in standard deviations: nothing is left to be fitted


@dataclass(frozen=True)
class Search:
    """Where a search ended.

    Attributes:
        best: the model there.
        converged: whether it is where no step within the bounds makes the sum of squares much smaller.
        steps: how many there were.
    """

    best: Evaluation
    converged: bool
    steps: int


def minimize(
    evaluate: Callable[[np.ndarray], Evaluation],
    first: Evaluation,
    sigma: np.ndarray,
    *,
    bounds: tuple[np.ndarray, np.ndarray],
    longest: np.ndarray,
    enough: float,
    most: int,
) -> Search:
    """Search the least sum of squares.

    Args:
        evaluate: the model at a place, shape (P,).
        first: the model where the search starts.
        sigma: standard deviations of the values, shape (M,).
        bounds: the lowest and the highest place, each of shape (P,).
        longest: largest change of the place in one step, shape (P,).
        enough: the search has converged when the least sum of squares is no farther than so many standard
            errors of the parameters, as the derivatives tell it.
        most: steps, at most.
    """
    best, damping, growth = first, FIRST_DAMPING, 2.0
    for steps in range(most):
        rows = best.usable
        residuals, slopes = best.residuals[rows] / sigma[rows], best.slopes[rows] / sigma[rows, None]
        gradient, curvature = slopes.T @ residuals, slopes.T @ slopes
        cost = residuals @ residuals
        held = (best.place <= bounds[0]) & (gradient > 0.0) | (best.place >= bounds[1]) & (gradient < 0.0)
        free = np.flatnonzero(~held & (np.diag(curvature) > 0.0))
        variance = cost / max(1, rows.sum() - len(free))
        undamped = _step(gradient, curvature, free, LEAST_DAMPING)
        distance = math.sqrt(max(0.0, -gradient @ undamped) / max(variance, TINY))  # in standard errors
        if len(free) and (distance <= enough or cost <= ROUND_OFF * rows.sum()):
            return Search(best, True, steps)
        while len(free):
            step = _step(gradient, curvature, free, damping)
            step *= 1.0 / max(1.0, float((np.abs(step) / longest).max()))
            step = np.clip(best.place + step, *bounds) - best.place
            promised = -(2.0 * gradient @ step + step @ curvature @ step)
            if promised > 0.0:  # it may not be where a bound cuts the step
                trial = evaluate(best.place + step)
                after = trial.residuals[rows] / sigma[rows]
                gain = (cost - after @ after) / promised  # NaN if a row is lost
            else:
                gain = math.nan
            if gain > 0.0:
                damping *= max(1.0 / 3.0, 1.0 - (2.0 * gain - 1.0) ** 3)
                growth, best = 2.0, trial
                break
            damping *= growth
            growth *= 2.0
            if damping > MOST_DAMPING:
                return Search(best, distance <= NEAR, steps)
        else:
            return Search(best, False, steps)  # nothing depends on what may move
    return Search(best, False, most)


def _step(gradient: np.ndarray, curvature: np.ndarray, free: np.ndarray, damping: float) -> np.ndarray:
    """The damped step of the free parameters."""
    step = np.zeros(len(gradient))
    if len(free):
        scale = 1.0 / np.sqrt(np.diag(curvature)[free])
        matrix = curvature[np.ix_(free, free)] * np.outer(scale, scale)
        matrix[np.diag_indices_from(matrix)] += damping
        step[free] = -scale * np.linalg.solve(matrix, scale * gradient[free])
    return step
