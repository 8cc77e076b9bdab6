"""What the method of the complex step needs: its step, and a Runge–Kutta method for complex numbers.

A parameter has the imaginary part ``TINY``, whose square is lost to round-off, so the imaginary part of any
analytic function is ``TINY`` times its derivative (W. Squire & G. Trapp 1998, *SIAM Rev* 40:110).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import DOP853

TINY = 1e-30


def runge_kutta(
    rate: Callable[[np.ndarray], np.ndarray], y: np.ndarray, h: Any, first: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """One step of DOP853: the state after it and the stages, for the rate ``first`` at its start."""
    stages = np.empty((13, *y.shape), y.dtype)
    stages[0] = first
    for i in range(1, 12):
        stages[i] = rate(y + h * combine(DOP853.A[i, :i], stages))
    return y + h * combine(DOP853.B, stages), stages


def combine(weights: np.ndarray, stages: np.ndarray) -> np.ndarray:
    """Σ w_i k_i, without BLAS: its threads would wait for each other longer than they work."""
    return np.einsum("i,i...->...", weights, stages[: len(weights)])


def power(base: np.ndarray, exponent: np.ndarray) -> np.ndarray:
    """Base^exponent in each lane; for an exponent that is not whole as if the base were positive."""
    if exponent[0].real == round(exponent[0].real) and not exponent.imag.any():
        return base ** round(exponent[0].real)
    none = base == 0.0
    positive = np.where(none, 1.0, np.where(base.real < 0.0, -base, base))
    return np.where(none, 0.0, np.exp(exponent * np.log(positive)))
