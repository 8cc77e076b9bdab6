"""Weighted least squares by SciPy, for values that come and go.

What a chain with impacts gives changes from one set of parameters to another: an impact may not be there, or
a derivative not exist. So a search is for the values that can be fitted where it starts. A step that loses
one of them is refused, as one to a sum of squares that is not finite, of residuals or of a derivative that
grows without end towards a bound, and SciPy takes a shorter one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from chain_impact.studies.fit.problem import Evaluation

EXACT = 1e-14  # relative change, below which there is round-off only


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
    enough: float,
    most: int,
) -> Search:
    """Search the least sum of squares, by the trust-region method of Branch, Coleman & Li (1999).

    Args:
        evaluate: the model at a place, shape (P,).
        first: the model where the search starts.
        sigma: standard deviations of the values, shape (M,).
        bounds: the lowest and the highest place, each of shape (P,).
        enough: the search has converged when a step changes the sum of squares by a smaller part of it.
        most: steps, at most.
    """
    rows = first.usable
    moved = first.slopes[rows].any(axis=0)  # SciPy takes many steps along what has no effect
    if not moved.any():
        return Search(first, False, 0)
    kept = {first.place[moved].tobytes(): first}

    def model(place: np.ndarray) -> Evaluation:
        key = place.tobytes()
        if key not in kept:
            whole = first.place.copy()
            whole[moved] = place
            kept[key] = evaluate(whole)
        return kept[key]

    def slopes(place: np.ndarray) -> np.ndarray:
        return np.asarray(model(place).slopes[np.ix_(rows, moved)] / sigma[rows, None])

    @np.errstate(over="ignore")
    def residuals(place: np.ndarray) -> np.ndarray:
        found = model(place)
        if not found.usable[rows].all() or not np.isfinite(np.square(slopes(place)).sum()):
            return np.full(int(rows.sum()), np.inf)
        return np.asarray(found.residuals[rows] / sigma[rows])

    from scipy import optimize  # takes long

    found = optimize.least_squares(
        residuals,
        first.place[moved],
        slopes,
        bounds=[ends[moved] for ends in bounds],
        x_scale="jac",
        ftol=enough,
        xtol=EXACT,
        gtol=EXACT,
        max_nfev=most,
    )
    return Search(model(found.x), bool(found.status > 0), int(found.nfev))
