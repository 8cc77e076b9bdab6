"""Which runs are still to be done, cut into pieces, and handed out to whoever does them."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from typing import Any, Protocol

import numpy as np

Span = tuple[int, int]
"""The runs first … end − 1."""
Made = np.ndarray | str
"""The rows of a piece, or the name of the file that has them."""
FIRST_PIECE, LONGEST_PIECE = 8, 2**18  # runs
SHORTEST, LONGEST = 0.5, 60.0  # s
SHARE = 0.2  # of the time so far: the most that is lost of a sweep that dies
ALIKE = 16  # times as long as the last pieces, and at the end as short
AHEAD = 2  # pieces for each worker, so that none waits for who listens


class Pieces:
    """The runs that are missing, handed out piece by piece.

    A piece takes a part of the time so far, so that an hour of a core has some hundred of them.
    """

    def __init__(self, spans: Sequence[Span], workers: int) -> None:
        """Take the missing runs, in order, and how many ask for pieces."""
        self._spans, self._workers = list(reversed(spans)), workers
        self._left = sum(end - first for first, end in spans)
        self._size, self._least, self._elapsed = FIRST_PIECE, 1, 0.0

    def take(self) -> Span | None:
        """The next piece; None when there is none. Towards the end, each worker gets its share."""
        if not self._spans:
            return None
        first, end = self._spans.pop()
        size = min(self._size, max(self._left // (2 * self._workers), self._least))
        middle = min(end, first + size)
        if middle < end:
            self._spans.append((middle, end))
        self._left -= middle - first
        return first, middle

    def took(self, piece: Span, seconds: float) -> None:
        """Say how long a piece took, so that the next ones are cut to size."""
        self._elapsed += seconds / self._workers
        a_second = (piece[1] - piece[0]) / max(seconds, 1e-6)
        wanted = min(max(SHORTEST, SHARE * self._elapsed), LONGEST)
        self._size = max(1, min(int(wanted * a_second), ALIKE * self._size, LONGEST_PIECE))
        self._least = max(1, int(wanted / ALIKE * a_second))


class Workers(Protocol):
    """Who does the pieces: the threads of this machine, or a cluster's."""

    count: int

    def submit(self, piece: Span) -> Any:
        """A future for a piece."""

    def finished(self, futures: list[Any]) -> Sequence[Any]:
        """Those that are done, after some time at the latest."""

    def result(self, future: Any, piece: Span) -> tuple[Made, float]:
        """What came of a piece, and how long it took [s]."""

    def stop(self, futures: list[Any]) -> None:
        """Let go of what is not done."""


def hand_out(workers: Workers, spans: Sequence[Span]) -> Generator[tuple[Span, Made]]:
    """Yield what comes of the runs in some spans, piece by piece as they are done."""
    pieces = Pieces(spans, workers.count)
    at_work: dict[Any, Span] = {}

    def submit() -> None:
        if piece := pieces.take():
            at_work[workers.submit(piece)] = piece

    try:
        for _ in range(AHEAD * workers.count):
            submit()
        while at_work:
            for future in workers.finished(list(at_work)):
                piece = at_work.pop(future)
                made, seconds = workers.result(future, piece)
                pieces.took(piece, seconds)
                submit()
                yield piece, made
    finally:
        workers.stop(list(at_work))


def missing(done: Sequence[Span], count: int) -> list[Span]:
    """The runs of 0 … count − 1 that are in none of the spans."""
    spans, start = [], 0
    for first, end in sorted(done):
        if first > start:
            spans.append((start, first))
        start = max(start, end)
    return [*spans, (start, count)] if start < count else spans
