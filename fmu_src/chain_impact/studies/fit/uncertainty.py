"""How well the data determine the parameters, from the derivatives where the search ended."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from chain_impact.extras import require

PROBABILITY = 0.95
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

    def with_value(self, slopes: np.ndarray, sigma: float) -> Information:
        """What it would be with one more measured value, of some derivatives, shape (P,)."""
        return Information(self.matrix + np.outer(slopes, slopes) / sigma**2)

    def with_held(self, p: int) -> Information:
        """What it would be with one parameter held: of all others, shape (P − 1, P − 1)."""
        return Information(np.delete(np.delete(self.matrix, p, 0), p, 1))


def information(slopes: np.ndarray, sigma: np.ndarray) -> Information:
    """What values with some derivatives, shape (M, P), and standard deviations, shape (M,), say."""
    whitened = slopes / sigma[:, None]
    return Information(whitened.T @ whitened)


def quantile(freedom: float, estimated: bool) -> float:
    """Half the width of a 95 % interval in standard errors.

    Of Student's t distribution if standard deviations of the values were estimated with so many degrees of
    freedom, else of the normal distribution.

    Raises:
        MissingExtraError: when SciPy is not installed.
    """
    special = require("scipy.special", "fit")
    tail = 0.5 * (1.0 + PROBABILITY)
    return float(special.stdtrit(freedom, tail) if estimated else special.ndtri(tail))


def largest_usual(freedom: float, probability: float = 0.999) -> float:
    """The χ² that a right model exceeds with a probability of 0.1 % only."""
    return float(require("scipy.special", "fit").chdtri(freedom, 1.0 - probability))
