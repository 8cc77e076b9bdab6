"""How well the data determine the parameters, from the derivatives where the search ended."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

PROBABILITY = 0.95
LEAST_FREEDOM, MANY_FREEDOM = 0.05, 1e9  # degrees, with fewer nothing is known, with more it is as with all
SINGULAR = 1e-7  # of the largest, a singular value that may be round-off of the derivatives


@dataclass(frozen=True)
class Information:
    """What the data say on the parameters: J'J, with J the derivatives in standard deviations of the values.

    Attributes:
        matrix: shape (P, P), on the scale of the search.
    """

    matrix: np.ndarray

    @property
    def covariance(self) -> np.ndarray:
        """Of the parameters on the scale of the search, shape (P, P); infinite of what is not determined."""
        size = np.sqrt(np.diag(self.matrix))
        scale = np.divide(1.0, size, out=np.zeros(len(size)), where=size > 0.0)
        values, vectors = np.linalg.eigh(self.matrix * np.outer(scale, scale))
        sound = values > SINGULAR**2 * max(values.max(initial=0.0), 1.0)
        inverse: np.ndarray = (
            (vectors[:, sound] / values[sound]) @ vectors[:, sound].T * np.outer(scale, scale)
        )
        lost = (np.abs(vectors[:, ~sound]) > SINGULAR**0.5).any(axis=1) | (size == 0.0)
        inverse[lost, :] = inverse[:, lost] = math.nan
        inverse[np.diag_indices_from(inverse)] = np.where(lost, math.inf, np.diag(inverse))
        return inverse

    @property
    def errors(self) -> np.ndarray:
        """Standard errors of the parameters on the scale of the search, shape (P,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def alone(self) -> np.ndarray:
        """Standard errors with all other parameters held, shape (P,); infinite of what has no effect."""
        with np.errstate(divide="ignore"):
            return np.asarray(1.0 / np.sqrt(np.diag(self.matrix)))

    def with_held(self, p: int) -> Information:
        """What it would be with one parameter held: of all others, shape (P − 1, P − 1)."""
        return Information(np.delete(np.delete(self.matrix, p, 0), p, 1))


def information(slopes: np.ndarray, sigma: np.ndarray) -> Information:
    """What values with some derivatives, shape (M, P), and standard deviations, shape (M,), say."""
    whitened = slopes / sigma[:, None]
    return Information(whitened.T @ whitened)


@dataclass(frozen=True)
class SmallSample:
    """What it does to the standard errors that standard deviations are estimated, from values that are few.

    Attributes:
        factor: by which a standard error is larger, as the values were weighted by estimates, shape (P,).
        freedom: its degrees of freedom, shape (P,); infinite if no standard deviation is estimated.
    """

    factor: np.ndarray
    freedom: np.ndarray


def small_sample(
    slopes: np.ndarray, sigma: np.ndarray, groups: Sequence[tuple[np.ndarray, float]]
) -> SmallSample:
    """Return the correction of Kenward & Roger (Biometrics 53 (1997) 983) for variances by columns.

    With A_c = J'J/σ² of a column with ν_c degrees of freedom, C the covariance and p_c = C A_c C over C, the
    part of a variance that comes from the column, 1/ν = Σ p_c²/ν_c, which is Satterthwaite's, and the
    variance grows by Σ 4/ν_c C (A_c − A_c C A_c) C.

    Args:
        slopes: derivatives of the values, shape (M, P).
        sigma: standard deviations of the values, shape (M,).
        groups: of each column with an estimated standard deviation, which of the values are its, shape (M,),
            and the degrees of freedom of its residuals.
    """
    covariance = np.nan_to_num(information(slopes, sigma).covariance, posinf=0.0)
    variance = np.diag(covariance)
    doubt, growth = np.zeros(len(variance)), np.zeros(len(variance))

    def part(matrix: np.ndarray) -> np.ndarray:
        own = np.diag(covariance @ matrix @ covariance)
        return np.divide(own, variance, out=np.zeros(len(own)), where=variance > 0.0)

    for mine, own in groups:
        known, free = information(slopes[mine], sigma[mine]).matrix, max(own, LEAST_FREEDOM)
        doubt += part(known) ** 2 / free
        growth += 4.0 / free * part(known - known @ covariance @ known).clip(0.0)
    freedom = np.divide(1.0, doubt, out=np.full(len(doubt), math.inf), where=doubt > 0.0)
    return SmallSample(np.sqrt(1.0 + growth), freedom)


def quantiles(freedom: np.ndarray) -> np.ndarray:
    """Return half the width of 95 % intervals in standard errors, by Student's t distribution, shape (P,).

    With infinite degrees of freedom it is the normal distribution. With hardly any the width is infinite:
    where a column has no more values than the parameters that it determines, they tell no standard deviation.
    """
    from scipy import special  # takes long

    tail = 0.5 * (1.0 + PROBABILITY)
    student = special.stdtrit(np.clip(freedom, LEAST_FREEDOM, MANY_FREEDOM), tail)
    found = np.where(freedom < MANY_FREEDOM, student, special.ndtri(tail))
    return np.where(freedom > 2.0 * LEAST_FREEDOM, found, math.inf)


def largest_usual(freedom: float) -> float:
    """Return the χ² that a right model exceeds with a probability of 0.1 % only."""
    from scipy import special  # takes long

    return float(special.chdtri(freedom, 1e-3))
