"""Polynomials that follow functions of time, piece by piece, as exactly as is asked for.

A piece of a function is its Chebyshev series from values at Chebyshev–Gauss points, which leave out the ends:
what it is exactly where it jumps does not matter. A piece whose series does not converge is halved. What is
left where a function jumps or has a kink is too short to matter, and is dropped.

Source: the criterion is that of J. P. Boyd 2001, *Chebyshev and Fourier Spectral Methods*, 2nd ed., Dover,
section 2.12: the last coefficients bound the error.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from chain_impact.kernel.model.inputs import DEGREE

Sampled = Callable[[np.ndarray], np.ndarray]
"""Times, shape (T,) → values of M functions there, shape (T, M)."""
LOOKS = 2000  # times in a run at which every function is looked at: what is shorter can be missed
POINTS = 16  # values of a piece
SHORTEST = 4e-13  # of the run: a piece so short is dropped
NOISE = 4  # pieces in a row that hold jumps: a function that is nowhere smooth
MOST = 1_000_000  # pieces that are tried in a run
ROUND_OFF = 4e-15  # of a function's largest value: what its values may err …
RESOLVED = 1e-14  # … and of the time, for what round-off in the time makes of them
JOINED = 10.0  # of the error allowed: by what two pieces may differ where they meet, without a jump
DROPPED = 0.05  # of the error allowed: a last coefficient that is left out

_ANGLES = np.pi * (np.arange(POINTS)[::-1] + 0.5) / POINTS
_NODES = np.cos(_ANGLES)
# values at the nodes → coefficients of the Chebyshev series
_SERIES = np.cos(np.arange(POINTS)[:, np.newaxis] * _ANGLES) * 2.0 / POINTS
_SERIES[0] /= 2.0
# the first of them → coefficients of powers
_POWERS = np.zeros((DEGREE + 1, DEGREE + 1))
for _m in range(DEGREE + 1):
    _POWERS[: _m + 1, _m] = np.polynomial.chebyshev.cheb2poly(np.eye(DEGREE + 1)[_m])[: _m + 1]


class NotSmoothError(Exception):
    """The functions cannot be followed around a time [s]."""

    def __init__(self, time: float) -> None:
        """Around a time [s]."""
        super().__init__(time)
        self.time = time


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
        """The values at some times [s], shape (T, M)."""
        x = (2.0 * times - self.start - self.end) / (self.end - self.start)
        return np.asarray(np.polynomial.polynomial.polyval(x, self.powers)).T


@dataclass(frozen=True)
class Pieces:
    """M signals, polynomials of x = (t − middle) scale in each of P pieces, one after the other.

    Attributes:
        start: where each piece begins, shape (P,) [s].
        end: where it ends, shape (P,) [s].
        middle: shape (P,) [s].
        scale: shape (P,) [1/s].
        powers: coefficients of x⁰, x¹, …, at most of x^DEGREE, shape (P, K, M).
        same: what two values of each signal may differ by without a jump, shape (M,).
    """

    start: np.ndarray
    end: np.ndarray
    middle: np.ndarray
    scale: np.ndarray
    powers: np.ndarray
    same: np.ndarray

    @cached_property
    def jumps(self) -> np.ndarray:
        """Whether a signal jumps where each piece begins; true for the first."""
        before = self._at(self.start[1:], slice(None, -1))
        after = self._at(self.start[1:], slice(1, None))
        return np.append(True, (np.abs(after - before) > self.same).any(axis=1))

    def _at(self, times: np.ndarray, which: slice) -> np.ndarray:
        """The values of some pieces, each at one of the times."""
        x = (times - self.middle[which]) * self.scale[which]
        powers_of_x = x[:, np.newaxis] ** np.arange(self.powers.shape[1])
        return np.asarray(np.einsum("pkm,pk->pm", self.powers[which], powers_of_x))

    @cached_property
    def _largest(self) -> np.ndarray:
        """A bound on the size of each signal, shape (M,), not 0."""
        largest = np.abs(self.powers).sum(axis=1).max(axis=0, initial=0.0)
        return np.where(largest > 0.0, largest, 1.0)

    def settings(self, at: int) -> dict[str, float]:
        """What the record of a course has of a piece, but for the powers."""
        powers = self.powers[at]
        order = int(np.flatnonzero(powers.any(axis=1)).max(initial=0))
        if order == 0:
            return {"order": 0, "pace": 0.0}
        # how fast it changes: (|u⁽ᵐ⁾|/|u|)^(1/m) at the middle
        shares = (np.abs(powers) / self._largest).max(axis=1)
        pace = max((math.factorial(m) * shares[m]) ** (1.0 / m) for m in range(1, order + 1))
        return {
            "order": order,
            "middle": self.middle[at],
            "scale": self.scale[at],
            # the step that ends with the piece shall not end before it by round-off
            "until": self.end[at] + 4.0 * np.spacing(self.end[at]),
            "pace": self.scale[at] * pace,
        }


def joined_points(times: np.ndarray, values: np.ndarray, *, lines: bool) -> Pieces:
    """Signals by their values of shape (T, M) at T times [s], held until the next, or joined by lines.

    A single one is held for ever.
    """
    if len(times) == 1:
        times, values = np.append(times, math.inf), values.repeat(2, axis=0)
    left, right = values[:-1], values[1:] if lines else values[:-1]
    powers = np.stack([left, np.zeros_like(left)], axis=1)
    if lines:
        powers = np.stack([np.where(left == right, left, 0.5 * (left + right)), 0.5 * (right - left)], axis=1)
    # pieces that are constant and equal are one
    new = (powers[1:] != powers[:-1]).any(axis=(1, 2)) | powers[1:, 1].any(axis=1)
    begins = np.append(True, new)
    start = times[:-1][begins]
    end = np.append(start[1:], times[-1])
    return Pieces(
        start=start,
        end=end,
        middle=0.5 * (start + end),
        scale=2.0 / (end - start),
        powers=powers[begins] if lines else powers[begins, :1],
        same=ROUND_OFF * np.abs(values).max(axis=0, initial=0.0),
    )


class Follower:
    """Finds pieces of M functions in a run."""

    def __init__(self, functions: Sampled, stop: float, accuracy: float) -> None:
        """Look at the functions all over the run.

        Args:
            functions: what is followed.
            stop: end of the run, which begins at 0 [s].
            accuracy: error that a piece may have, in parts of a function's largest value.
        """
        self._functions, self._shortest = functions, SHORTEST * stop
        self._times = np.linspace(0.0, stop, LOOKS + 1)
        self._values = functions(self._times)
        self._scale = np.abs(self._values).max(axis=0)
        self._accuracy = max(accuracy, ROUND_OFF)

    def pieces(self, start: float, end: float) -> list[Piece]:
        """Pieces of the functions between two times [s], as few as halving and joining find.

        Raises:
            NotSmoothError: where there are none.
        """
        found: list[Piece] = []
        count, dropped = 0, 0
        for piece in self._halved(start, end):
            count, dropped = count + 1, dropped + 1 if piece is None else 0
            if dropped > NOISE or count > MOST:
                raise NotSmoothError(found[-1].end if found else start)
            if piece is not None:
                self._join(found, piece)
        return found

    def beside(self, held: Pieces, columns: np.ndarray) -> Pieces:
        """Pieces in which the functions are some of the signals; the others are held ones.

        Raises:
            NotSmoothError: where there are none.
        """
        found, powers = [], []
        for k, (start, end) in enumerate(zip(held.start.tolist(), held.end.tolist(), strict=True)):
            pieces = self.pieces(start, end)
            starts = np.array([start, *(piece.start for piece in pieces[1:])])
            found.append((starts, [(piece.start, piece.end) for piece in pieces]))
            for piece in pieces:
                row = np.zeros((DEGREE + 1, held.powers.shape[2]))
                row[0], row[:, columns] = held.powers[k, 0], piece.powers
                powers.append(row)
        start = np.concatenate([starts for starts, _ in found])
        fitted = np.array([ends for _, pairs in found for ends in pairs])
        same = np.zeros(held.powers.shape[2])
        same[columns] = JOINED * self._accuracy * self._scale
        return Pieces(
            start=start,
            end=np.append(start[1:], held.end[-1]),
            middle=0.5 * fitted.sum(axis=1),
            scale=2.0 / np.diff(fitted, axis=1)[:, 0],
            powers=np.array(powers),
            same=same,
        )

    def _join(self, found: list[Piece], piece: Piece) -> None:
        """Append a piece, as one with the last if that can be."""
        both = self._fitted(found[-1].start, piece.end) if found else None
        if both is None:
            found.append(piece)
        else:
            found[-1] = both

    def _halved(self, start: float, end: float) -> Iterator[Piece | None]:
        """Pieces in order; None for what is too short to matter."""
        if end - start <= self._shortest:
            yield None
            return
        fitted = self._fitted(start, end)
        if fitted is not None:
            yield fitted
            return
        middle = 0.5 * (start + end)
        yield from self._halved(start, middle)
        yield from self._halved(middle, end)

    def _fitted(self, start: float, end: float) -> Piece | None:
        """The piece between two times [s], if it is exact."""
        half, middle = 0.5 * (end - start), 0.5 * (start + end)
        values = self._functions(middle + half * _NODES)
        series = _SERIES @ (values - values[0])
        series[0] += values[0]
        self._scale = np.maximum(self._scale, np.abs(values).max(axis=0))
        allowed = self._accuracy * self._scale
        round_off = RESOLVED * abs(end) / half * np.ptp(values, axis=0)
        if (np.abs(series[DEGREE + 1 :]).sum(axis=0) > allowed + round_off).any():
            return None
        order = DEGREE
        while order > 0 and (np.abs(series[order]) <= DROPPED * allowed).all():
            order -= 1
        powers = np.zeros((DEGREE + 1, values.shape[1]))
        powers[: order + 1] = _POWERS[: order + 1, : order + 1] @ series[: order + 1]
        piece = Piece(start, end, powers)
        # what happens between an end and the node next to it shows at the end
        inside = min(0.1 * self._shortest, 0.002 * half)
        ends = np.array([start + inside, end - inside])
        seen = slice(*np.searchsorted(self._times, ends))
        missed = [piece.at(ends) - self._functions(ends), piece.at(self._times[seen]) - self._values[seen]]
        return None if (np.abs(np.concatenate(missed)) > 2.0 * (allowed + round_off)).any() else piece
