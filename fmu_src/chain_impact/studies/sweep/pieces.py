"""Which runs are still to be done, in pieces that take about as long however long a run takes."""

from __future__ import annotations

from collections.abc import Sequence
from threading import Lock

Span = tuple[int, int]
"""The runs first … end − 1."""
LONGEST_PIECE = 4096  # runs
FIRST_PIECE = 8


class Pieces:
    """The runs that are missing, handed out piece by piece; threads may ask at the same time."""

    def __init__(self, spans: Sequence[Span], workers: int, seconds: float) -> None:
        """Take the missing runs.

        Args:
            spans: the runs, in order.
            workers: how many ask for pieces: towards the end, each gets its share.
            seconds: how long a piece shall take.
        """
        self._spans, self._workers, self._seconds = list(reversed(spans)), workers, seconds
        self._left = sum(end - first for first, end in spans)
        self._size, self._lock = FIRST_PIECE, Lock()

    def take(self) -> Span | None:
        """The next piece; None when there is none."""
        with self._lock:
            if not self._spans:
                return None
            first, end = self._spans.pop()
            size = max(1, min(self._size, self._left // (2 * self._workers)))
            middle = min(end, first + size)
            if middle < end:
                self._spans.append((middle, end))
            self._left -= middle - first
            return first, middle

    def took(self, piece: Span, seconds: float) -> None:
        """Say how long a piece took, so that the next ones are cut to size."""
        fitting = (piece[1] - piece[0]) * self._seconds / max(seconds, 1e-6)
        with self._lock:
            self._size = int(max(1, min(fitting, 2 * self._size, LONGEST_PIECE)))


def missing(done: Sequence[Span], count: int) -> list[Span]:
    """The runs of 0 … count − 1 that are in none of the spans."""
    spans, start = [], 0
    for first, end in sorted(done):
        if first > start:
            spans.append((start, first))
        start = max(start, end)
    return [*spans, (start, count)] if start < count else spans
