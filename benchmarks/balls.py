"""Balls of numbers that contain the exact results: matrices with floats as middles and radii."""

from __future__ import annotations

from typing import Any

import numpy as np
from flint import ctx

ctx.prec = 90
# ROUND_OFF [1]: bound on the relative round-off of one operation; SLACK [1]: factor that covers the round-off
# of many operations; TINY: bound on the absolute round-off of numbers near 0
ROUND_OFF, SLACK, TINY = 4e-16, 1 + 1e-9, 1e-300
Row = list[Any]


class RefusalError(ArithmeticError):
    """Raised when a bound does not exist; the message is the reason."""


class Matrix:
    """A matrix of balls with floats as middles and radii, whose products have small errors in each entry."""

    def __init__(self, middle: np.ndarray, radius: np.ndarray | float = 0.0) -> None:
        """Store the middles and the radii of the entries."""
        self.middle, self.radius = middle, np.zeros_like(middle) + radius
        self.size = (np.abs(middle) + radius) * (1 + ROUND_OFF)  # bounds on the magnitudes of the entries

    @classmethod
    def of(cls, rows: list[Row]) -> Matrix:
        """Return balls of floats that contain those of Arb."""
        middle = np.array([[float(entry.mid()) for entry in row] for row in rows])
        radius = np.array([[float(entry.rad()) for entry in row] for row in rows])
        return cls(middle, (radius + ROUND_OFF * np.abs(middle)) * (1 + ROUND_OFF))

    def __matmul__(self, factor: Matrix) -> Matrix:
        """Return the product, with a bound on round-off."""
        size = np.abs(self.middle)
        spread = size @ factor.radius + self.radius @ factor.size
        spread += len(factor.middle) * ROUND_OFF * (size @ np.abs(factor.middle))
        return Matrix(self.middle @ factor.middle, spread * SLACK + TINY)

    def solve(self, right_side: Matrix) -> Matrix:
        """Return Y with A Y = R, where A is this matrix and R is ``right_side``.

        Y follows from Y = X R + (1 − X A) Y with an approximate inverse X of A.

        Raises:
            RefusalError: when this formula does not bound Y.
        """
        inverse = Matrix(np.linalg.inv(self.middle))
        first, rest = inverse @ right_side, inverse @ self
        left = np.abs(rest.middle - np.eye(len(rest.middle))) + rest.radius + ROUND_OFF
        share = float(left.sum(axis=1).max()) * SLACK
        if not share < 0.9:
            raise RefusalError("the mass matrix varies too much")
        once = left @ first.size
        spread = once + left.sum(axis=1)[:, None] * once.max(axis=0) / (1 - share)
        return Matrix(first.middle, (first.radius + spread) * SLACK)
