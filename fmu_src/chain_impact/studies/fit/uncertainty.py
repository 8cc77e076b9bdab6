"""The uncertainty of fitted parameters, from the derivatives of the fitted model's values."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

PROBABILITY = 0.95
# Student's t is computed only between LEAST_FREEDOM and MANY_FREEDOM degrees of freedom. With fewer degrees,
# an interval is infinite anyway (TOO_FEW); with more degrees, Student's t equals the normal distribution to
# round-off. LEAST_FREEDOM is also the least ν_c of a column in ``small_sample``, which divides by ν_c.
LEAST_FREEDOM, MANY_FREEDOM = 0.05, 1e9
# with at most TOO_FEW degrees of freedom, an interval counts as infinite: Student's t would give a half width
# of 43,000 standard errors or more
TOO_FEW = 0.25
# A singular value of the matrix J (``Information``) counts as 0 if it is smaller than this, relative to the
# largest singular value. Each column of J, for one parameter, is first scaled to the norm 1.
SINGULAR_RATIO = 1e-7


@dataclass(frozen=True)
class Information:
    """The information of the data about the P parameters: the matrix JᵀJ.

    J has the derivatives of the model's values with respect to the coordinates of the parameters
    (``Parameter``), each divided by the standard deviation of the value.

    Attributes:
        matrix: JᵀJ, shape (P, P).
    """

    matrix: np.ndarray

    @property
    def covariance(self) -> np.ndarray:
        """The covariance matrix of the coordinates of the parameters, shape (P, P).

        A parameter that the values do not determine has an infinite variance, and NaN as its covariances.
        """
        size = np.sqrt(np.diag(self.matrix))
        scale = np.divide(1.0, size, out=np.zeros(len(size)), where=size > 0.0)
        values, vectors = np.linalg.eigh(self.matrix * np.outer(scale, scale))
        is_sound = values > SINGULAR_RATIO**2 * max(values.max(initial=0.0), 1.0)
        inverse: np.ndarray = (
            (vectors[:, is_sound] / values[is_sound]) @ vectors[:, is_sound].T * np.outer(scale, scale)
        )
        is_lost = (np.abs(vectors[:, ~is_sound]) > SINGULAR_RATIO**0.5).any(axis=1) | (size == 0.0)
        inverse[is_lost, :] = inverse[:, is_lost] = math.nan
        inverse[np.diag_indices_from(inverse)] = np.where(is_lost, math.inf, np.diag(inverse))
        return inverse

    @property
    def errors(self) -> np.ndarray:
        """The standard errors of the coordinates of the parameters, shape (P,).

        The error of a parameter that the values do not determine is infinite.
        """
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def alone(self) -> np.ndarray:
        """The standard error of each parameter's coordinate if all other parameters are fixed, shape (P,).

        The error is infinite for a parameter without effect on the values.
        """
        with np.errstate(divide="ignore"):
            return np.asarray(1.0 / np.sqrt(np.diag(self.matrix)))

    def with_held(self, p: int) -> Information:
        """Return the information about the P − 1 other parameters if parameter ``p`` is fixed."""
        return Information(np.delete(np.delete(self.matrix, p, 0), p, 1))


def information_of(slopes: np.ndarray, sigma: np.ndarray) -> Information:
    """Return the information about the parameters that M values hold.

    ``slopes``: derivatives of the model's values with respect to the coordinates of the parameters, shape
    (M, P). ``sigma``: standard deviations of the values, shape (M,).
    """
    whitened = slopes / sigma[:, None]
    return Information(whitened.T @ whitened)


@dataclass(frozen=True)
class SmallSample:
    """How much less certain parameters are because standard deviations are estimated from few values.

    Attributes:
        factor: the factor ≥ 1 by which the standard error of each parameter grows, shape (P,).
        freedom: degrees of freedom of each standard error, shape (P,); infinite if the standard error depends
            on no estimated standard deviation.
    """

    factor: np.ndarray
    freedom: np.ndarray


def small_sample(
    slopes: np.ndarray, sigma: np.ndarray, groups: Sequence[tuple[np.ndarray, float]]
) -> SmallSample:
    """Return the correction of Kenward & Roger (Biometrics 53 (1997) 983); each column has a σ of its own.

    C is the covariance matrix of the parameters: the variance of a parameter is its diagonal element of C. A
    column c of measurements has the information A_c (``Information``), and its residuals have ν_c degrees of
    freedom. Sums are over the columns with an estimated σ.

    The correction adds to the variance of a parameter its diagonal element of Σ 4/ν_c C (A_c − A_c C A_c) C.
    The degrees of freedom ν of its standard error follow from Satterthwaite's formula, 1/ν = Σ p_c²/ν_c. Here
    p_c is the parameter's diagonal element of C A_c C, divided by its diagonal element of C.

    Args:
        slopes: derivatives of the model's values, as for ``information_of``, shape (M, P).
        sigma: standard deviations of the values, shape (M,).
        groups: a pair for each column with an estimated standard deviation: whether each value belongs to the
            column, shape (M,), and the degrees of freedom ν_c.
    """
    covariance = np.nan_to_num(information_of(slopes, sigma).covariance, posinf=0.0)
    variance = np.diag(covariance)
    doubt, growth = np.zeros(len(variance)), np.zeros(len(variance))

    def part(matrix: np.ndarray) -> np.ndarray:
        part_of_column = np.diag(covariance @ matrix @ covariance)
        return np.divide(part_of_column, variance, out=np.zeros(len(variance)), where=variance > 0.0)

    for group_rows, degrees in groups:
        precision, least_degrees = (
            information_of(slopes[group_rows], sigma[group_rows]).matrix,
            max(degrees, LEAST_FREEDOM),
        )
        doubt += part(precision) ** 2 / least_degrees
        growth += 4.0 / least_degrees * part(precision - precision @ covariance @ precision).clip(0.0)
    freedom = np.divide(1.0, doubt, out=np.full(len(doubt), math.inf), where=doubt > 0.0)
    return SmallSample(np.sqrt(1.0 + growth), freedom)


def quantiles(freedom: np.ndarray) -> np.ndarray:
    """Return half the width of each parameter's 95 % interval, divided by its standard error, shape (P,).

    ``freedom``: the degrees of freedom of each standard error, shape (P,), for Student's t distribution. With
    infinite degrees of freedom, the normal distribution applies. With at most TOO_FEW degrees of freedom, the
    width is infinite.
    """
    from scipy import special  # imported here, because the import takes long

    tail = 0.5 * (1.0 + PROBABILITY)
    student = special.stdtrit(np.clip(freedom, LEAST_FREEDOM, MANY_FREEDOM), tail)
    values = np.where(freedom < MANY_FREEDOM, student, special.ndtri(tail))
    return np.where(freedom > TOO_FEW, values, math.inf)


def exceedance_probability(chi_squared: float, freedom: float) -> float:
    """Return the probability, 0 to 1, that the χ² of a correct model exceeds ``chi_squared``.

    ``freedom``: the degrees of freedom of χ², > 0.
    """
    from scipy import special  # this import takes long

    return float(special.chdtrc(freedom, chi_squared))
