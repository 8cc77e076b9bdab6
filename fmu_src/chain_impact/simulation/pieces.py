"""Piecewise polynomials that approximate functions of time to a given accuracy.

A piece of a function is its Chebyshev series from values at Chebyshev–Gauss points. The ends of a piece are
not among these points, so the exact value at a jump does not matter. A piece whose series does not converge
is halved, or split where the function changes from one polynomial to another. A short rest around a jump or a
kink is dropped.

Source: J. P. Boyd 2001, *Chebyshev and Fourier Spectral Methods*, 2nd ed., Dover, section 2.12: the last
coefficients bound the error.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from chain_impact.kernel.forces.inputs import DEGREE

Sampled = Callable[[np.ndarray], np.ndarray]
"""Times, shape (T,) → values of M functions there, shape (T, M)."""
# number of times in a run at which each function is called; a pulse shorter than their distance can be missed
CHECKED_TIMES = 2000
POINTS = 16  # number of values of a function in a piece
SHORTEST = 4e-13  # the length below which a piece is dropped, over the length of the run
ALIKE = 1e-6  # the largest relative difference of two lengths that count as equal
FAR = 4.0  # an interval longer than FAR times the last piece is halved before a fit is tried
PATIENCE = 32  # a length for which fits have failed is tried again after at most so many pieces
NOISE = 4  # the number of successive pieces with jumps after which a function counts as smooth nowhere
# the length of a piece, over the length of the run, below which a function is hardly smooth in pieces
FINE = 1 / 65536
CALLS = 15_000  # the number of calls in a run that functions may have for fine pieces, jumps and kinks
CALLS_PER_PIECE = 50  # the number of calls in addition to CALLS for each piece of the held signals
SIMPLE = 4  # the largest degree of a polynomial that may be extrapolated in search of a jump or kink
# a value belongs to one of two polynomials if it is nearer to that one by the factor NEARER
NEARER = 0.1
ROUND_OFF = 4e-15  # the relative error of a function's values, over the largest value
RESOLVED = 1e-14  # the relative error of a time, over the time; it changes the values
# the difference of two pieces where they meet, over the allowed error, above which there is a jump
JOINED = 10.0
# the size of a last coefficient, over the allowed error, below which the coefficient is left out
DROPPED = 0.05

_ANGLES = np.pi * (np.arange(POINTS)[::-1] + 0.5) / POINTS
_NODES = np.cos(_ANGLES)
# matrix: values at the nodes → coefficients of the Chebyshev series
_SERIES = np.cos(np.arange(POINTS)[:, np.newaxis] * _ANGLES) * 2.0 / POINTS
_SERIES[0] /= 2.0
# matrix: coefficients of the Chebyshev series → coefficients of powers of x
_POWERS = np.eye(DEGREE + 1)
for _m in range(2, DEGREE + 1):
    # T_m = 2 x T_{m−1} − T_{m−2}
    _POWERS[1:, _m] = 2.0 * _POWERS[:-1, _m - 1]
    _POWERS[:, _m] -= _POWERS[:, _m - 2]


class NotSmoothError(Exception):
    """Raised when a function cannot be approximated around a time."""

    def __init__(self, time: float, which: int) -> None:
        """Store the time [s] and the number of the function."""
        super().__init__(time, which)
        self.time, self.which = time, which


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


@dataclass(frozen=True)
class Pieces:
    """M signals that are polynomials of x = (t − middle) scale in each of P successive pieces.

    Attributes:
        start: where each piece begins, shape (P,) [s].
        end: where each piece ends, shape (P,) [s].
        middle: shape (P,) [s].
        scale: shape (P,) [1/s].
        powers: coefficients of x⁰, x¹, …, at most of x^DEGREE, shape (P, K, M).
        same: largest difference between two values of each signal that does not count as a jump, shape (M,).
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
        """An upper bound of each signal's absolute values, shape (M,), not 0."""
        sizes = np.abs(self.powers)
        sizes[:, 0, self.moving] = 0.0
        largest = sizes.sum(axis=1).max(axis=0, initial=0.0)
        return np.where(largest > 0.0, largest, 1.0)

    @cached_property
    def _changes(self) -> tuple[np.ndarray, np.ndarray]:
        """The order of each piece, and its rate of change (|u⁽ᵐ⁾|/|u|)^(1/m) at the middle, shapes (P,)."""
        count = self.powers.shape[1]
        used = self.powers.any(axis=2) * np.arange(count)
        shares = (np.abs(self.powers) / self._largest).max(axis=2, initial=0.0)
        rates = [(math.factorial(m) * shares[:, m]) ** (1.0 / m) for m in range(1, count)]
        return used.max(axis=1, initial=0), np.max(rates, axis=0, initial=0.0) + np.zeros(len(used))

    def settings(self, at: int) -> dict[str, float]:
        """Return the fields of a piece for the record, without the powers."""
        order, rate = self._changes
        if order[at] == 0:
            return {"order": 0, "change_rate": 0.0}
        return {
            "order": order[at],
            "middle": self.middle[at],
            "scale": self.scale[at],
            # round-off must not make the step that ends with the piece end before the piece
            "until": self.end[at] + 4.0 * np.spacing(self.end[at]),
            "change_rate": self.scale[at] * rate[at],
        }


def joined_points(
    times: np.ndarray, values: np.ndarray, *, lines: bool, breaks: np.ndarray | None = None
) -> Pieces:
    """Return signals from values (T, M) at T times [s]: held until the next time, or joined by lines.

    A single value is held for the whole run. A new piece begins at each of the ``breaks``, which are among
    the times.
    """
    if len(times) == 1:
        times, values = np.append(times, math.inf), values.repeat(2, axis=0)
    left, right = values[:-1], values[1:] if lines else values[:-1]
    powers = np.stack([left, np.zeros_like(left)], axis=1)
    if lines:
        powers = np.stack([np.where(left == right, left, 0.5 * (left + right)), 0.5 * (right - left)], axis=1)
    # equal constant pieces are joined into one
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
        same=ROUND_OFF * np.abs(values).max(axis=0, initial=0.0),
    )


class Follower:
    """The search for the pieces of M functions in a run."""

    def __init__(self, functions: Sampled, stop: float, accuracy: Any, resolved: Any = RESOLVED) -> None:
        """Prepare the search, and call the functions at times spread over the run.

        Args:
            functions: the functions to follow.
            stop: end of the run, which begins at 0 [s].
            accuracy: allowed error of a piece, as a part of each function's largest value, shape (M,), or one
                number for all functions.
            resolved: error of the time as a part of the time, which changes the values; shape (M,), or one
                number.
        """
        self._functions, self._shortest, self._fine = functions, SHORTEST * stop, FINE * stop
        self._times = np.linspace(0.0, stop, CHECKED_TIMES + 1)
        self._values = functions(self._times)
        self._scale = np.abs(self._values).max(axis=0)
        self._resolved = resolved
        self._accuracy = np.maximum(accuracy, ROUND_OFF)
        self._calls_left = CALLS
        # number of fits that failed because of each function
        self._refused = np.zeros(len(self._scale), dtype=int)
        self._last: Piece | None = None
        # [s] length of the last interval whose fit failed, or was not tried because such fits had failed
        self._failed = math.inf
        self._count = 0  # number of pieces found so far
        # binary exponent of a length → the count below which a fit of this length is not tried, and the last
        # increase of this count
        self._again: dict[int, int] = {}
        self._patience: dict[int, int] = {}

    def pieces(self, start: float, end: float) -> list[Piece]:
        """Return pieces of the functions between two times [s]; halving and joining keep their number small.

        Raises:
            NotSmoothError: when a function cannot be approximated.
        """
        found: list[Piece] = []
        dropped = 0
        for piece in self._parted(start, end):
            dropped = dropped + 1 if piece is None else 0
            if dropped > NOISE:
                raise self._not_smooth(found[-1].end if found else start)
            if piece is not None:
                self._join(found, piece)
        return found

    def with_held(self, held: Pieces, columns: np.ndarray) -> Pieces:
        """Return pieces of all signals; ``columns`` are the functions' columns, the other signals are held.

        Raises:
            NotSmoothError: when a function cannot be approximated.
        """
        found, powers = [], []
        for k, (start, end) in enumerate(zip(held.start.tolist(), held.end.tolist(), strict=True)):
            self._calls_left += CALLS_PER_PIECE
            pieces = self.pieces(start, end)
            starts = np.array([start, *(piece.start for piece in pieces[1:])])
            found.append((starts, [(piece.start, piece.end) for piece in pieces]))
            for piece in pieces:
                row = np.zeros((DEGREE + 1, held.powers.shape[2]))
                row[0] = held.powers[k, 0]
                if held.powers.shape[1] > 1:  # a held signal may consist of lines between samples
                    middle, half = 0.5 * (piece.start + piece.end), 0.5 * (piece.end - piece.start)
                    row[0] += held.powers[k, 1] * (middle - held.middle[k]) * held.scale[k]
                    row[1] = held.powers[k, 1] * half * held.scale[k]
                row[:, columns] = piece.powers
                powers.append(row)
        start = np.concatenate([starts for starts, _ in found])
        fitted = np.array([ends for _, pairs in found for ends in pairs])
        same = held.same * JOINED if held.powers.shape[1] > 1 else np.zeros(held.powers.shape[2])
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
        """Append a piece, or join the piece with the last one if one polynomial fits both."""
        meets = bool(found) and found[-1].end == piece.start
        both = (
            self._fitted(found[-1].start, piece.end) if meets and not self._alike(found[-1], piece) else None
        )
        if both is None:
            found.append(piece)
        else:
            found[-1] = both
        self._last = found[-1]

    def _alike(self, one: Piece, other: Piece) -> bool:
        """Return whether two pieces are halves, or as long as halves, of an interval that no piece fits."""
        halves = np.array([one.end - one.start, other.end - other.start, 0.5 * self._failed])
        return bool(np.ptp(halves) <= ALIKE * halves[0])

    def _parted(self, start: float, end: float) -> Iterator[Piece | None]:
        """Yield pieces in order; yield None for an interval that is too short to matter."""
        if end - start <= self._shortest:
            yield None
            return
        last, middle = self._last, 0.5 * (start + end)
        # an interval that continues a piece of high degree is not simple, so it is not searched for a break
        simple = last is None or last.end != start or not last.powers[SIMPLE + 1 :].any()
        far = last is not None and end - start > FAR * (last.end - last.start)
        _, length = math.frexp(end - start)
        vain = not simple and self._count < self._again.get(length, 0)
        fitted = None if far or vain else self._fitted(start, end)
        if fitted is not None:
            self._count += 1
            self._patience[length] = 1
            yield fitted
            return
        if not far:
            self._failed = end - start
        if not far and not vain:
            self._patience[length] = min(2 * self._patience.get(length, 1), PATIENCE)
            self._again[length] = self._count + self._patience[length]
        before, after = (self._break(start, end) if simple and not far else None) or (middle, middle)
        for part in itertools.pairwise((start, before, after, end)):
            if part[0] < part[1]:
                yield from self._parted(*part)

    def _break(self, start: float, end: float) -> tuple[float, float] | None:
        """Return two times [s] just before and after a jump or kink, if there seems to be exactly one.

        Returns None otherwise.
        """
        quarter = 0.25 * (end - start)
        before, after = start + quarter, end - quarter
        # polynomials extrapolated from afar distinguish the sides of a break; polynomials nearby locate it
        for until in (0.125 * quarter, self._shortest):
            left = self._simple(before - quarter, before)
            right = self._simple(after, after + quarter) if left is not None else None
            if left is None or right is None:
                return None
            before, after = self._narrowed(left, right, until)
            if after - before > until:
                return None
        return before, after

    def _simple(self, start: float, end: float) -> Piece | None:
        """Return the piece between two times [s] if it is accurate and of a low degree; else None."""
        piece = self._fitted(start, end)
        return None if piece is None or piece.powers[SIMPLE + 1 :].any() else piece

    def _narrowed(self, left: Piece, right: Piece, until: float) -> tuple[float, float]:
        """Return the last time [s] with values of the left piece, and the first time of the right piece.

        The distance of the two times exceeds ``until`` if some values seem to belong to neither piece.
        """
        before, after = left.end, right.start
        scale = np.where(self._scale > 0.0, self._scale, 1.0)
        while after - before > until:
            middle = np.array([0.5 * (before + after)])
            value = self._called(middle, costly=True)
            misses = [float((np.abs(piece.at(middle) - value) / scale).max()) for piece in (left, right)]
            if max(misses) <= max(DROPPED * float(np.min(self._accuracy)), ROUND_OFF):
                return float(middle[0]), float(middle[0])
            if until > self._shortest and min(misses) > NEARER * max(misses):
                break
            if misses[0] < misses[1]:
                before = float(middle[0])
            else:
                after = float(middle[0])
        return before, after

    def _called(self, times: np.ndarray, *, costly: bool) -> np.ndarray:
        """Return the values of the functions at some times [s]; the number of additional calls is limited."""
        if costly:
            self._calls_left -= len(times)
            if self._calls_left < 0:
                raise self._not_smooth(float(times[0]))
        return self._functions(times)

    def _not_smooth(self, time: float) -> NotSmoothError:
        return NotSmoothError(time, int(self._refused.argmax()))

    def _fitted(self, start: float, end: float) -> Piece | None:
        """Return the piece between two times [s] if it is accurate; else None."""
        half, middle = 0.5 * (end - start), 0.5 * (start + end)
        # a change of the function between an end and the nearest node shows at the end
        inside = min(0.1 * self._shortest, 0.002 * half)
        ends = start + inside, end - inside
        times = np.append(middle + half * _NODES, ends)
        called = self._called(times, costly=end - start < self._fine)
        values = called[:POINTS]
        series = _SERIES @ (values - values[0])
        series[0] += values[0]
        low, high = values.min(axis=0), values.max(axis=0)
        self._scale = np.maximum(self._scale, np.maximum(high, -low))
        allowed = self._accuracy * self._scale
        round_off = self._resolved * abs(end) / half * (high - low)
        rough = np.abs(series[DEGREE + 1 :]).sum(axis=0) > allowed + round_off
        if rough.any():
            self._refused += rough
            return None
        counts = (np.abs(series[1 : DEGREE + 1]) > DROPPED * (allowed + round_off)).any(axis=1)
        order = int(np.flatnonzero(counts)[-1]) + 1 if counts.any() else 0
        powers = np.zeros((DEGREE + 1, values.shape[1]))
        powers[: order + 1] = _POWERS[: order + 1, : order + 1] @ series[: order + 1]
        piece = Piece(start, end, powers)
        seen = slice(*np.searchsorted(self._times, ends))
        checked = np.append(times[POINTS:], self._times[seen])
        missed = piece.at(checked) - np.concatenate([called[POINTS:], self._values[seen]])
        rough = (np.abs(missed) > 2.0 * (allowed + round_off)).any(axis=0)
        self._refused += rough
        return None if rough.any() else piece
