"""Finds piecewise polynomials that approximate functions of time with a given accuracy.

A piece is an interval with one polynomial for each function: its Chebyshev series from values at
Chebyshev–Gauss points. The ends of a piece are not among these points, so the exact value at a jump does not
matter. An interval in which a series does not converge is halved, or divided where the functions change from
one polynomial to another. The piece before a jump lasts until the piece after it.

Source: J. P. Boyd 2001, *Chebyshev and Fourier Spectral Methods*, 2nd ed., Dover, section 2.12: the last
coefficients bound the error.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.polynomial import polynomial

from chain_impact.kernel.record.constants import INPUT_DEGREE
from chain_impact.simulation.polynomial_pieces import FUNCTION_ROUND_OFF, Piece, Pieces

Sampled = Callable[[np.ndarray], np.ndarray]
"""M functions as one: times, shape (T,) [s] → their values, shape (T, M)."""
# number of equal parts of a run at whose ends each function is called first; a shorter pulse can be missed
CHECKED_TIMES = 2000
POINTS = 16  # number of values of a function from which the polynomial of a piece is computed
# [1] an interval at most this long, relative to the run, is dropped: at a jump or kink
SHORTEST_PIECE = 4e-13
# [1] pieces count as equally long if their lengths differ by at most this, relative to one of the lengths
EQUAL_LENGTHS = 1e-6
# an interval longer than 2^HALVED_BEYOND times the length of the last piece is halved without trying a
# polynomial, which would probably fail
HALVED_BEYOND = 2
# log₂ of the largest number of pieces for which the functions are called at once; values for more pieces
# would be wasted if polynomials fail
BATCH_DOUBLINGS = 4
RETRY_PIECES = 32  # the largest number of pieces after which a failed length of intervals is tried again
# with more successive intervals that are dropped (SHORTEST_PIECE), a function counts as not smooth
MOST_FAILED_INTERVALS = 4
# [1] values of the functions for a piece shorter than this, relative to the run, count against MOST_CALLS
SHORT_PIECE = 1 / 65536
# largest number of times in a run at which the functions are evaluated for short pieces, jumps and kinks;
# with more, the search gives up with an error
MOST_CALLS = 15_000
# Each piece of ``steps`` in ``with_held`` raises the limit MOST_CALLS by CALLS_PER_PIECE, because the search
# for polynomials begins anew in each of these pieces.
CALLS_PER_PIECE = 50
MOST_DEGREE = 5  # only a polynomial of at most this degree is extrapolated to find a jump or kink
# [1] in the first round of ``_break_times``, a value belongs to the nearer of two polynomials only if the
# smaller distance is at most NEARER_RATIO × the larger one; in the second round this holds for any distance
NEARER_RATIO = 0.1
NEWTON_STEPS = 4  # number of Newton steps from 0 to a zero of a polynomial near 0
LEAST_ALLOWED = 1e-300  # replaces an allowed error of 0, because the code divides by the allowed error
# [1] round-off of a time, relative to the time, which also makes values of a function inaccurate
TIME_ERROR = 1e-14
# there is a jump if two pieces differ where they meet by more than this times the allowed error
JUMP_RATIO = 10.0
# the last coefficients of a piece are left out if they are at most this times the allowed error; beside a
# kink, a difference of values up to this limit counts as 0
DROPPED_SHARE = 0.05

_ANGLES = np.pi * (np.arange(POINTS)[::-1] + 0.5) / POINTS
_NODES = np.cos(_ANGLES)
# matrix: values at the nodes → coefficients of the Chebyshev series
_SERIES = np.cos(np.arange(POINTS)[:, np.newaxis] * _ANGLES) * 2.0 / POINTS
_SERIES[0] /= 2.0
# matrix: coefficients of the Chebyshev series → coefficients of the powers of x
_POWERS = np.eye(INPUT_DEGREE + 1)
for _m in range(2, INPUT_DEGREE + 1):
    # Chebyshev polynomials: T_m = 2 x T_{m−1} − T_{m−2}
    _POWERS[1:, _m] = 2.0 * _POWERS[:-1, _m - 1]
    _POWERS[:, _m] -= _POWERS[:, _m - 2]


class NotSmoothError(Exception):
    """Raised when a function cannot be approximated by polynomials near a time."""

    def __init__(self, time: float, function_number: int) -> None:
        """Store the time [s] and the index of the function."""
        super().__init__(time, function_number)
        self.time, self.function_number = time, function_number


class Approximator:
    """Finds the pieces that approximate M functions of time from 0 to the end of a run."""

    def __init__(self, functions: Sampled, end: float, accuracy: Any, resolution: Any = TIME_ERROR) -> None:
        """Prepare the search, and call the functions at times spread over the run.

        Args:
            functions: the functions to follow.
            end: end of the run, which begins at 0 [s].
            accuracy: allowed error of a piece, relative to each function's largest absolute value; shape
                (M,), or one number for all functions.
            resolution: round-off of a time, relative to the time, which makes the functions' values
                inaccurate; shape (M,), or one number.
        """
        self._shortest, self._short_piece = SHORTEST_PIECE * end, SHORT_PIECE * end
        self._functions, self._times = functions, np.linspace(0.0, end, CHECKED_TIMES + 1)
        self._values = functions(self._times)
        self._scale = np.abs(self._values).max(axis=0)
        self._resolution = resolution
        self._accuracy = np.maximum(accuracy, FUNCTION_ROUND_OFF)
        self._calls_left = MOST_CALLS
        # for each function, how often a polynomial has failed because of this function; an error names the
        # function with the largest number
        self._refusal_counts = np.zeros(len(self._scale), dtype=int)
        self._last: Piece | None = None
        # [s] length of the last interval for which a polynomial failed or, by ``_is_vain``, was not tried; ∞:
        # there was no such interval yet
        self._failed = math.inf
        self._count = 0  # number of pieces found so far
        # _retry_counts: binary exponent of a length → number of found pieces at which this length is tried
        # again; _patience: the same exponent → number of pieces by which the last failure has delayed the
        # next trial, or 1 after a success
        self._retry_counts: dict[int, int] = {}
        self._patience: dict[int, int] = {}
        # start and end of an interval [s] → its piece, computed in advance, or None if that failed;
        # _foreseen_until is the end [s] of the last of these intervals
        self._foreseen: dict[tuple[float, float], Piece | None] = {}
        self._foreseen_until = 0.0

    def pieces(self, start: float, end: float) -> list[Piece]:
        """Return pieces of the functions between two times [s].

        Neighbours that one polynomial fits are joined, except two that are ``_are_alike``.

        Raises:
            NotSmoothError: when a function cannot be approximated.
        """
        pieces: list[Piece] = []
        dropped_count = 0
        for piece in self._divide(start, end):
            dropped_count = dropped_count + 1 if piece is None else 0
            if dropped_count > MOST_FAILED_INTERVALS:
                raise self._not_smooth(pieces[-1].end if pieces else start)
            if piece is not None:
                self._join(pieces, piece)
        return pieces

    def with_held(self, steps: Pieces, columns: np.ndarray) -> Pieces:
        """Return ``steps``, pieces of all signals, with polynomials of the functions in their ``columns``.

        In a piece of ``steps`` all signals are constant or linear. This piece is divided where the
        functions need more than one polynomial.

        Raises:
            NotSmoothError: when a function cannot be approximated.
        """
        joins, powers = [], []
        for k, (start, end) in enumerate(zip(steps.start.tolist(), steps.end.tolist(), strict=True)):
            self._calls_left += CALLS_PER_PIECE
            pieces = self.pieces(start, end)
            starts = np.array([start, *(piece.start for piece in pieces[1:])])
            joins.append((starts, [(piece.start, piece.end) for piece in pieces]))
            for piece in pieces:
                row = np.zeros((INPUT_DEGREE + 1, steps.powers.shape[2]))
                row[0] = steps.powers[k, 0]
                if steps.powers.shape[1] > 1:  # true with the interpolation ``linear``
                    middle, half = 0.5 * (piece.start + piece.end), 0.5 * (piece.end - piece.start)
                    row[0] += steps.powers[k, 1] * (middle - steps.middle[k]) * steps.scale[k]
                    row[1] = steps.powers[k, 1] * half * steps.scale[k]
                row[:, columns] = piece.powers
                powers.append(row)
        start = np.concatenate([starts for starts, _ in joins])
        edges = np.array([ends for _, pairs in joins for ends in pairs])
        same = steps.same * JUMP_RATIO if steps.powers.shape[1] > 1 else np.zeros(steps.powers.shape[2])
        same[columns] = JUMP_RATIO * self._accuracy * self._scale
        return Pieces(
            start=start,
            end=np.append(start[1:], steps.end[-1]),
            middle=0.5 * edges.sum(axis=1),
            scale=2.0 / np.diff(edges, axis=1)[:, 0],
            powers=np.array(powers),
            same=same,
        )

    def _join(self, pieces: list[Piece], piece: Piece) -> None:
        """Append a piece, or replace the last piece by one over both if both meet and one polynomial fits.

        One polynomial for both pieces is not tried if they are ``_are_alike``.
        """
        is_joined = bool(pieces) and pieces[-1].end == piece.start
        joined_piece = (
            self._fit_piece(pieces[-1].start, piece.end)
            if is_joined and not self._are_alike(pieces[-1], piece)
            else None
        )
        if joined_piece is None:
            pieces.append(piece)
        else:
            pieces[-1] = joined_piece
        self._last = pieces[-1]

    def _are_alike(self, a: Piece, b: Piece) -> bool:
        """Return whether two pieces are each half as long as the last interval without a polynomial.

        For this interval a polynomial has failed, or was not tried (``_is_vain``). One polynomial for two
        such pieces would probably fail, too, so they are not joined. Only lengths are compared, not times.
        """
        halves = (a.end - a.start, b.end - b.start, 0.5 * self._failed)
        return max(halves) - min(halves) <= EQUAL_LENGTHS * halves[0]

    def _divide(self, start: float, end: float) -> Iterator[Piece | None]:
        """Yield the pieces of an interval in order; None stands for a part so short that it is dropped."""
        if end - start <= self._shortest:
            yield None
            return
        last, middle = self._last, 0.5 * (start + end)
        # the interval is simple if it does not follow a piece of a degree > MOST_DEGREE; in others a search
        # for a jump or kink is not worth its calls
        is_simple = last is None or last.end != start or not last.powers[MOST_DEGREE + 1 :].any()
        is_far = last is not None and end - start > 2.0**HALVED_BEYOND * (last.end - last.start)
        _, length = math.frexp(end - start)
        is_vain = not is_simple and self._is_vain(length)
        if not is_simple and (is_far or is_vain) and end > self._foreseen_until:
            self._foresee(start, end)
        piece = None if is_far or is_vain else self._fit_piece(start, end)
        if piece is not None:
            self._count += 1
            self._patience[length] = 1
            yield piece
            return
        if not is_far:
            self._failed = end - start
        if not is_far and not is_vain:
            self._patience[length] = min(2 * self._patience.get(length, 1), RETRY_PIECES)
            self._retry_counts[length] = self._count + self._patience[length]
        a, b = (self._break_times(start, end) if is_simple and not is_far else None) or (middle, middle)
        for part in itertools.pairwise((start, a, b, end)):
            if part[0] < part[1]:
                yield from self._divide(*part)

    def _is_vain(self, length: int) -> bool:
        """Return whether to try no polynomial, because one of a similar length failed a few pieces before.

        ``length`` is the binary exponent of the interval's length in [s]; similar lengths have the same one.
        """
        return self._count < self._retry_counts.get(length, 0)

    def _break_times(self, start: float, end: float) -> tuple[float, float] | None:
        """Return two times [s], just before and just after the only jump or kink of an interval.

        Both times are that of a kink if the polynomials of both sides have the functions' values at a time of
        the search. The result is None if the search does not find just one jump or kink, or if beside it no
        polynomial of a degree ≤ MOST_DEGREE is accurate.
        """
        quarter = 0.25 * (end - start)
        a, b = start + quarter, end - quarter
        # The first round extrapolates polynomials from afar, to find on which side of the jump or kink a time
        # lies. The second round uses polynomials near the jump or kink, to find its time accurately.
        for shortest in (0.125 * quarter, self._shortest):
            left_piece = self._simple_piece(a - quarter, a)
            right = self._simple_piece(b, b + quarter) if left_piece is not None else None
            if left_piece is None or right is None:
                return None
            a, b = self._narrow_gap(left_piece, right, shortest)
            if b - a > shortest:
                return None
            if a == b:
                a = b = self._kink(left_piece, right, a)
        return a, b

    def _kink(self, left: Piece, right: Piece, time: float) -> float:
        """Return the time of a kink near ``time`` [s], where two pieces of low degree are equal.

        If no such time is found, the result is ``time``.
        """
        unit = min(time - left.start, right.end - time)
        difference = right.series(time, unit)[: MOST_DEGREE + 1] - left.series(time, unit)[: MOST_DEGREE + 1]
        error = np.maximum(DROPPED_SHARE * self._accuracy, FUNCTION_ROUND_OFF) * self._scale
        column = difference[:, (np.abs(difference).sum(axis=0) / np.maximum(error, LEAST_ALLOWED)).argmax()]
        kink = 0.0
        for order in range(MOST_DEGREE):
            x = _zero(polynomial.polyder(column, order))
            if abs(x) < 1.0 and (np.abs(polynomial.polyval(x, difference)) <= error).all():
                kink = x
        return time + kink * unit

    def _simple_piece(self, start: float, end: float) -> Piece | None:
        """Return the piece between two times [s] if it is accurate and of at most MOST_DEGREE.

        The result is None for any other piece.
        """
        piece = self._fit_piece(start, end)
        return None if piece is None or piece.powers[MOST_DEGREE + 1 :].any() else piece

    def _narrow_gap(self, left: Piece, right: Piece, width: float) -> tuple[float, float]:
        """Return the last time [s] known before a jump or kink, and the first time known after it.

        The left piece has the functions' values before the jump or kink, the right piece after it. The
        interval between the two times is halved until it is at most ``width`` [s] long. In the first
        round of ``_break_times``, the search also ends at a time at which neither piece has the functions'
        values. If both pieces have the functions' values at a time, the search returns this time twice.
        """
        a, b = left.end, right.start
        scale = np.where(self._scale > 0.0, self._scale, 1.0)
        while b - a > width:
            middle = np.array([0.5 * (a + b)])
            value = self._call(middle, costly=True)
            misses = [float((np.abs(part.values_at(middle) - value) / scale).max()) for part in (left, right)]
            if max(misses) <= max(DROPPED_SHARE * float(np.min(self._accuracy)), FUNCTION_ROUND_OFF):
                return float(middle[0]), float(middle[0])
            if width > self._shortest and min(misses) > NEARER_RATIO * max(misses):
                break
            if misses[0] < misses[1]:
                a = float(middle[0])
            else:
                b = float(middle[0])
        return a, b

    def _call(self, times: np.ndarray, *, costly: bool) -> np.ndarray:
        """Return the values of the functions at times [s], shape (T, M).

        ``costly``: the times count against MOST_CALLS; raise NotSmoothError if this limit is passed.
        """
        if costly:
            self._calls_left -= len(times)
            if self._calls_left < 0:
                raise self._not_smooth(float(times[0]))
        return self._functions(times)

    def _not_smooth(self, time: float) -> NotSmoothError:
        return NotSmoothError(time, int(self._refusal_counts.argmax()))

    def _fit_piece(self, start: float, end: float) -> Piece | None:
        """Return the piece between two times [s] if it is accurate; else None."""
        if (start, end) in self._foreseen:
            return self._foreseen.pop((start, end))
        return self._fit_pieces(np.array([start, end]))[0]

    def _foresee(self, start: float, end: float) -> None:
        """Compute all pieces of an interval in one call, each about as long as the last piece.

        Nothing is done for 1 piece, for more than 2^BATCH_DOUBLINGS, or if a longer piece must be tried
        first: one of at most 2^HALVED_BEYOND times the last is tried unless ``_is_vain``, a longer one never.
        """
        last = self._last
        halvings = round(math.log2((end - start) / (last.end - last.start))) if last else 0
        lengths = [math.frexp((end - start) / 2**k)[1] for k in range(halvings)][-HALVED_BEYOND:]
        if not lengths or halvings > BATCH_DOUBLINGS or not all(map(self._is_vain, lengths)):
            return
        self._foreseen_until = end
        ends = np.array([start, end])
        for _ in range(halvings):
            ends = np.insert(ends, range(1, len(ends)), 0.5 * (ends[:-1] + ends[1:]))
        self._foreseen = dict(zip(itertools.pairwise(ends.tolist()), self._fit_pieces(ends), strict=True))

    def _fit_pieces(self, ends: np.ndarray) -> list[Piece | None]:
        """Return the P pieces between the times ``ends`` [s], shape (P + 1,).

        None stands for an inaccurate piece.
        """
        start, end = ends[:-1, np.newaxis], ends[1:, np.newaxis]
        half, middle = 0.5 * (end - start), 0.5 * (start + end)
        # two more times, one close to each end: a change of the function between an end and the nearest node
        # shows there
        inset = np.minimum(0.1 * self._shortest, 0.002 * half)
        times = np.hstack([middle + half * _NODES, start + inset, end - inset])
        called = self._call(times.ravel(), costly=bool(2.0 * half[0, 0] < self._short_piece))
        called = called.reshape(*times.shape, -1)
        values = called[:, :POINTS]
        series = _SERIES @ (values - values[:, :1])
        series[:, 0] += values[:, 0]
        low, high = values.min(axis=1), values.max(axis=1)
        self._scale = np.maximum(self._scale, np.maximum(high, -low).max(axis=0))
        bound = self._accuracy * self._scale + self._resolution * np.abs(end) / half * (high - low)
        exponents, head = np.arange(INPUT_DEGREE + 1), series[:, : INPUT_DEGREE + 1]
        is_rough = np.abs(series[:, INPUT_DEGREE + 1 :]).sum(axis=1) > bound
        counts = (np.abs(head) > DROPPED_SHARE * bound[:, np.newaxis]).any(axis=2)
        order = np.where(counts, exponents, 0).max(axis=1, keepdims=True)
        series = np.where(exponents <= order, 1.0, 0.0)[..., np.newaxis] * head
        powers = _POWERS @ series
        pieces = [
            Piece(*fields) for fields in zip(ends[:-1].tolist(), ends[1:].tolist(), powers, strict=True)
        ]
        x = (times[:, POINTS:] - middle) / half
        errors = x[..., np.newaxis] ** np.arange(INPUT_DEGREE + 1) @ powers - called[:, POINTS:]
        is_rough |= (np.abs(errors) > 2.0 * bound[:, np.newaxis]).any(axis=1)
        for k, points in enumerate(itertools.starmap(slice, self._times.searchsorted(times[:, POINTS:]))):
            if points.start < points.stop:
                errors = pieces[k].values_at(self._times[points]) - self._values[points]
                is_rough[k] |= (np.abs(errors) > 2.0 * bound[k]).any(axis=0)
        self._refusal_counts += is_rough.sum(axis=0)
        return [None if failed else piece for failed, piece in zip(is_rough.any(axis=1), pieces, strict=True)]


def _zero(powers: np.ndarray) -> float:
    """Return an estimate of a polynomial's zero near 0, by Newton's method; infinity if a slope is 0."""
    x, rates = 0.0, polynomial.polyder(powers)
    for _ in range(NEWTON_STEPS):
        rate = float(polynomial.polyval(x, rates))
        if rate == 0.0:
            return math.inf
        x -= float(polynomial.polyval(x, powers)) / rate
    return x
