"""Signals that are polynomials in successive pieces of time: from functions, or from joined samples."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from chain_impact.kernel.record.constants import INPUT_DEGREE

FUNCTION_ROUND_OFF = 4e-15  # [1] error of a function's values, relative to its largest value


@dataclass(frozen=True)
class Piece:
    """M polynomials of x, which is −1 at ``start`` and 1 at ``end`` [s].

    Attributes:
        powers: coefficients of x⁰ … x^INPUT_DEGREE, shape (INPUT_DEGREE + 1, M).
    """

    start: float
    end: float
    powers: np.ndarray

    def values_at(self, times: np.ndarray) -> np.ndarray:
        """Return the values of the polynomials at times [s], shape (T, M)."""
        x = (2.0 * times - self.start - self.end) / (self.end - self.start)
        return np.asarray(np.vander(x, INPUT_DEGREE + 1, increasing=True) @ self.powers)

    def series(self, time: float, unit: float) -> np.ndarray:
        """Return the coefficients for powers of (t − ``time``)/``unit``, shape (INPUT_DEGREE + 1, M).

        ``time`` and ``unit`` are in [s].
        """
        scale = 2.0 / (self.end - self.start)
        x, powers, rows = (time - self.start) * scale - 1.0, self.powers, []
        for k in range(INPUT_DEGREE + 1):
            rows.append(np.polynomial.polynomial.polyval(x, powers) * (unit * scale) ** k / math.factorial(k))
            powers = np.polynomial.polynomial.polyder(powers)
        return np.array(rows)


@dataclass(frozen=True)
class Pieces:
    """M signals that are polynomials of x = (t − middle) · scale in each of P successive pieces.

    Attributes:
        start: start of each piece, shape (P,) [s].
        end: end of each piece, shape (P,) [s].
        middle: the time at which x is 0, shape (P,) [s].
        scale: how fast x grows, shape (P,) [1/s].
        powers: coefficients of x⁰, x¹, …, at most of x^INPUT_DEGREE, shape (P, K, M).
        same: for each signal, the largest difference between two values that is no jump, shape (M,).
        moving: indices of the signals that are motions; the size of a motion is the distance that it covers.
    """

    start: np.ndarray
    end: np.ndarray
    middle: np.ndarray
    scale: np.ndarray
    powers: np.ndarray
    same: np.ndarray
    moving: np.ndarray = field(default_factory=lambda: np.zeros(0, int))

    @cached_property
    def jumps(self) -> np.ndarray:
        """Whether any signal jumps at the start of each piece, shape (P,); true for the first piece."""
        left_values = self._values_at(self.start[1:], slice(None, -1))
        right_values = self._values_at(self.start[1:], slice(1, None))
        return np.append(True, (np.abs(right_values - left_values) > self.same).any(axis=1))

    def _values_at(self, times: np.ndarray, k: slice) -> np.ndarray:
        """Return the values of the signals in the P pieces ``k``, one time [s] in each, shape (P, M)."""
        x = (times - self.middle[k]) * self.scale[k]
        powers_of_x = x[:, np.newaxis] ** np.arange(self.powers.shape[1])
        return np.asarray(np.einsum("pkm,pk->pm", self.powers[k], powers_of_x))

    def derivatives_at(self, times: np.ndarray, piece_numbers: Any, order: int = 0) -> np.ndarray:
        """Return the derivatives of one ``order`` of the signals, shape (P, M).

        There is one of the ``times`` [s] for each of the P pieces ``piece_numbers``.
        """
        x, powers = (
            ((times - self.middle[piece_numbers]) * self.scale[piece_numbers])[:, np.newaxis],
            self.powers[piece_numbers],
        )
        last = powers.shape[1] - 1
        total = math.perm(last, order) * powers[:, last]
        for p in range(last - 1, order - 1, -1):
            total = total * x + math.perm(p, order) * powers[:, p]
        return np.asarray(total * self.scale[piece_numbers][:, np.newaxis] ** order)

    @cached_property
    def _largest_values(self) -> np.ndarray:
        """An upper bound of each signal's absolute values in all pieces, shape (M,); 1 where the bound is 0.

        For a motion, the bound is without the constant terms, so it is the size of the motion.
        """
        sizes = np.abs(self.powers)
        sizes[:, 0, self.moving] = 0.0
        largest_values = sizes.sum(axis=1).max(axis=0, initial=0.0)
        return np.where(largest_values > 0.0, largest_values, 1.0)

    @cached_property
    def _degrees_and_rates(self) -> tuple[np.ndarray, np.ndarray]:
        """The degree of each piece, and how fast its signals change in x at the middle; both of shape (P,).

        The second number is the largest (|u⁽ᵐ⁾|/U)^(1/m) of all signals u and all orders m of derivatives in
        x; U is the bound ``_largest_values`` of u.
        """
        count = self.powers.shape[1]
        used_degrees = self.powers.any(axis=2) * np.arange(count)
        shares = (np.abs(self.powers) / self._largest_values).max(axis=2, initial=0.0)
        rates = [(math.factorial(m) * shares[:, m]) ** (1.0 / m) for m in range(1, count)]
        return used_degrees.max(axis=1, initial=0), np.max(rates, axis=0, initial=0.0) + np.zeros(
            len(used_degrees)
        )

    def settings(self, k: int) -> dict[str, float]:
        """Return the fields of the record for the piece ``k``, except the coefficients of its polynomials.

        For a piece in which all signals are constant, the fields are only ``degree`` and ``change_rate``: 0.
        """
        degree, rate = self._degrees_and_rates
        if degree[k] == 0:
            return {"degree": 0, "change_rate": 0.0}
        return {
            "degree": degree[k],
            "middle": self.middle[k],
            "scale": self.scale[k],
            # the record's piece ends a little later, because round-off could let a step end after ``end``
            "end": self.end[k] + 4.0 * np.spacing(self.end[k]),
            "change_rate": self.scale[k] * rate[k],
        }


def joined_points(
    times: np.ndarray,
    values: np.ndarray,
    *,
    is_linear: bool,
    breaks: np.ndarray | None = None,
    left_limits: np.ndarray | None = None,
) -> Pieces:
    """Return signals from values (T, M) at T times [s], held until the next time or joined by lines.

    Lines end at the values ``left_limits`` (T, M), which differ from ``values`` at jumps; by default at
    these.

    A single value is held for the whole run. A new piece begins at each of ``breaks``, which are some of the
    times, and where a polynomial is not the constant of the interval before.
    """
    if len(times) == 1:
        times, values, left_limits = np.append(times, math.inf), values.repeat(2, axis=0), None
    left_values, right = (
        values[:-1],
        (values if left_limits is None else left_limits)[1:] if is_linear else values[:-1],
    )
    powers = np.stack([left_values, np.zeros_like(left_values)], axis=1)
    if is_linear:
        powers = np.stack(
            [
                np.where(left_values == right, left_values, 0.5 * (left_values + right)),
                0.5 * (right - left_values),
            ],
            axis=1,
        )
    # successive constant pieces with equal values become one piece
    is_new = (powers[1:] != powers[:-1]).any(axis=(1, 2)) | powers[1:, 1].any(axis=1)
    if breaks is not None:
        is_new |= np.isin(times[1:-1], breaks)
    is_begin = np.append(True, is_new)
    start = times[:-1][is_begin]
    end = np.append(start[1:], times[-1])
    return Pieces(
        start=start,
        end=end,
        middle=0.5 * (start + end),
        scale=2.0 / (end - start),
        powers=powers[is_begin] if is_linear else powers[is_begin, :1],
        same=FUNCTION_ROUND_OFF * np.abs(values).max(axis=0, initial=0.0),
    )
