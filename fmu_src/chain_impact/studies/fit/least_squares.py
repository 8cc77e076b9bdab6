"""Weighted least squares with SciPy, for a model in which values may appear and disappear.

After a small step of the parameters, an impact may be missing, or a derivative may not exist. So a search
fits the values that are usable at its start. The search refuses a step after which one of these values is not
usable, or, near a bound, the sum of the squares of their derivatives overflows; SciPy then tries a shorter
step.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from chain_impact.studies.fit.problem import Evaluation

# a step, relative to the parameters, or a gradient below this limit counts as round-off, and ends the search
SMALLEST_CHANGE = 1e-14


@dataclass(frozen=True)
class Search:
    """The result of a search for the least sum of squares.

    Attributes:
        best: the model with the parameters that the search found.
        converged: whether the search ended because a change was below ``enough_decrease`` (``minimize``) or
            below SMALLEST_CHANGE; False after too many steps, or if the search could not begin.
        steps: how many values of the parameters were tried, the start included; 0 if the search could not
            begin.
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
    enough_decrease: float,
    most_steps: int,
) -> Search:
    """Search the parameters with the least sum of squares of residuals r/σ, and return the result.

    The trust-region method is that of Branch, Coleman & Li (1999).

    Args:
        evaluate: function that returns the model for the coordinates of the parameters, shape (P,).
        first: the model at the start of the search; its usable values are fitted.
        sigma: standard deviations of the values, shape (M,).
        bounds: the lowest and the highest coordinates, each of shape (P,).
        enough_decrease: the search has converged when a step changes the sum of squares by less than
            ``enough_decrease`` × the sum.
        most_steps: the largest number of ``Search.steps``; a search that needs more has not converged.
    """
    rows = first.is_usable
    # a parameter on which no fitted value depends stays fixed, because SciPy would vary it in many steps
    is_moved = first.slopes[rows].any(axis=0)
    if not is_moved.any():
        return Search(first, False, 0)
    kept_evaluations = {first.coordinates[is_moved].tobytes(): first}

    def model(coordinates: np.ndarray) -> Evaluation:
        key = coordinates.tobytes()
        if key not in kept_evaluations:
            all_coordinates = first.coordinates.copy()
            all_coordinates[is_moved] = coordinates
            kept_evaluations[key] = evaluate(all_coordinates)
        return kept_evaluations[key]

    def slopes(coordinates: np.ndarray) -> np.ndarray:
        return np.asarray(model(coordinates).slopes[np.ix_(rows, is_moved)] / sigma[rows, None])

    @np.errstate(over="ignore")
    def residuals(coordinates: np.ndarray) -> np.ndarray:
        solution = model(coordinates)
        if not solution.is_usable[rows].all() or not np.isfinite(np.square(slopes(coordinates)).sum()):
            return np.full(int(rows.sum()), np.inf)
        return np.asarray(solution.residuals[rows] / sigma[rows])

    if not np.isfinite(residuals(first.coordinates[is_moved])).all():
        return Search(first, False, 0)

    from scipy import optimize  # imported here, because the import takes long

    solution = optimize.least_squares(
        residuals,
        first.coordinates[is_moved],
        slopes,
        bounds=[ends[is_moved] for ends in bounds],
        x_scale="jac",
        ftol=enough_decrease,
        xtol=SMALLEST_CHANGE,
        gtol=SMALLEST_CHANGE,
        max_nfev=most_steps,
    )
    return Search(model(solution.x), bool(solution.status > 0), int(solution.nfev))
