"""Signals that are polynomials in successive pieces of time: piecewise functions, and joined samples."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from chain_impact.kernel.chain.inputs import DEGREE

VALUE_ROUND_OFF = 4e-15  # the error of a function's values, relative to the largest value


@dataclass(frozen=True)
class Piece:
    """M polynomials of x, which goes from −1 at ``start`` to 1 at ``end`` [s].

    Attributes:
        powers: coefficients of x⁰ … x^DEGREE, shape (DEGREE + 1, M).
    """

    start: float
    end: float
    powers: np.ndarray

    def at(self, times: np.ndarray) -> np.ndarray:
        """Return the values at some times [s], shape (T, M)."""
        x = (2.0 * times - self.start - self.end) / (self.end - self.start)
        return np.asarray(np.vander(x, DEGREE + 1, increasing=True) @ self.powers)

    def series(self, time: float, unit: float) -> np.ndarray:
        """Return the coefficients of the powers of (t − ``time``)/``unit`` [s], shape (DEGREE + 1, M)."""
        scale = 2.0 / (self.end - self.start)
        x, powers, rows = (time - self.start) * scale - 1.0, self.powers, []
        for k in range(DEGREE + 1):
            rows.append(np.polynomial.polynomial.polyval(x, powers) * (unit * scale) ** k / math.factorial(k))
            powers = np.polynomial.polynomial.polyder(powers)
        return np.array(rows)


@dataclass(frozen=True)
class Pieces:
    """M signals that are polynomials of x = (t − middle) scale in each of P successive pieces.

    Attributes:
        start: where each piece begins, shape (P,) [s].
        end: where each piece ends, shape (P,) [s].
        middle: shape (P,) [s].
        scale: shape (P,) [1/s].
        powers: coefficients of x⁰, x¹, …, at most of x^DEGREE, shape (P, K, M).
        same: the largest difference between two values of a signal that does not count as a jump, shape (M,).
        moving: which of the signals are motions; the size of a motion is the distance that it covers.
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
        """Whether a signal jumps at the start of each piece; true for the first piece."""
        before = self._at(self.start[1:], slice(None, -1))
        after = self._at(self.start[1:], slice(1, None))
        return np.append(True, (np.abs(after - before) > self.same).any(axis=1))

    def _at(self, times: np.ndarray, which: slice) -> np.ndarray:
        """Return the values of the pieces ``which``, one time for each piece."""
        x = (times - self.middle[which]) * self.scale[which]
        powers_of_x = x[:, np.newaxis] ** np.arange(self.powers.shape[1])
        return np.asarray(np.einsum("pkm,pk->pm", self.powers[which], powers_of_x))

    @cached_property
    def _largest(self) -> np.ndarray:
        """An upper bound of the absolute values of each signal, shape (M,); 1 where the bound is 0.

        For a motion, the bound is without the constant terms, so it is the size of the motion.
        """
        sizes = np.abs(self.powers)
        sizes[:, 0, self.moving] = 0.0
        largest = sizes.sum(axis=1).max(axis=0, initial=0.0)
        return np.where(largest > 0.0, largest, 1.0)

    @cached_property
    def _degrees_and_rates(self) -> tuple[np.ndarray, np.ndarray]:
        """The degree of each piece, and its rate of change in x at the middle; both of shape (P,).

        The rate of change is the largest (|u⁽ᵐ⁾|/U)^(1/m) of all signals u and all orders m of derivatives; U
        is the bound ``_largest`` of u.
        """
        count = self.powers.shape[1]
        used = self.powers.any(axis=2) * np.arange(count)
        shares = (np.abs(self.powers) / self._largest).max(axis=2, initial=0.0)
        rates = [(math.factorial(m) * shares[:, m]) ** (1.0 / m) for m in range(1, count)]
        return used.max(axis=1, initial=0), np.max(rates, axis=0, initial=0.0) + np.zeros(len(used))

    def settings(self, at: int) -> dict[str, float]:
        """Return the fields of a piece for the record, except the coefficients of the powers."""
        order, rate = self._degrees_and_rates
        if order[at] == 0:
            return {"order": 0, "change_rate": 0.0}
        return {
            "order": order[at],
            "middle": self.middle[at],
            "scale": self.scale[at],
            # the piece ends a little later, because round-off could otherwise let the last step end before
            # the piece
            "until": self.end[at] + 4.0 * np.spacing(self.end[at]),
            "change_rate": self.scale[at] * rate[at],
        }


def joined_points(
    times: np.ndarray, values: np.ndarray, *, lines: bool, breaks: np.ndarray | None = None
) -> Pieces:
    """Return signals from values (T, M) at T times [s]: held until the next time, or joined by lines.

    A single value is held for the whole run. ``breaks`` are some of the times; a new piece begins at each of
    them.
    """
    if len(times) == 1:
        times, values = np.append(times, math.inf), values.repeat(2, axis=0)
    left, right = values[:-1], values[1:] if lines else values[:-1]
    powers = np.stack([left, np.zeros_like(left)], axis=1)
    if lines:
        powers = np.stack([np.where(left == right, left, 0.5 * (left + right)), 0.5 * (right - left)], axis=1)
    # successive equal constant pieces are joined into one piece
    new = (powers[1:] != powers[:-1]).any(axis=(1, 2)) | powers[1:, 1].any(axis=1)
    if breaks is not None:
        new |= np.isin(times[1:-1], breaks)
    begins = np.append(True, new)
    start = times[:-1][begins]
    end = np.append(start[1:], times[-1])
    return Pieces(
        start=start,
        end=end,
        middle=0.5 * (start + end),
        scale=2.0 / (end - start),
        powers=powers[begins] if lines else powers[begins, :1],
        same=VALUE_ROUND_OFF * np.abs(values).max(axis=0, initial=0.0),
    )
