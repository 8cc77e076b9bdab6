"""The rows of outputs that a run fills, and the numbers of a record in them."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

# largest number of rows, and of bytes in these rows, that the kernel fills in one call; but at least one row
CHUNK_ROWS, CHUNK_BYTES = 5000, 8_000_000


class Rows(Protocol):
    """The output buffer of a run, which is filled row by row.

    Attributes:
        chunk: largest number of rows that are filled between two reports of progress.
    """

    chunk: int

    def fill(self, instance: Any, times: np.ndarray, start: int) -> int:
        """Advance an instance to each of the times [s] and fill rows from ``start`` on.

        Returns the number of filled rows; ``Instance.trajectory`` says when fewer rows than times are filled.
        """


class WordRows:
    """An output buffer with numbers of the record, one row for each communication point.

    Attributes:
        numbers: shape (T, W); rows that are not filled have arbitrary values.
        spans: the indices of the numbers in the record, see ``spans_of``.
        of_state: whether all numbers are outputs of ``STATE_OUTPUTS`` in kernel/record/instance.py.
    """

    def __init__(self, count: int, words: Sequence[int] | np.ndarray, *, of_state: bool = False) -> None:
        """Make a buffer for ``count`` rows of the W numbers whose indices in the record are ``words``."""
        self.numbers = np.empty((count, len(words)))
        self.spans, self.of_state = spans_of(words), of_state
        self.chunk = max(1, min(CHUNK_ROWS, CHUNK_BYTES // max(1, 8 * len(words))))

    def fill(self, instance: Any, times: np.ndarray, start: int) -> int:
        """Fill rows as ``Rows.fill`` describes."""
        if self.numbers.shape[1]:
            rows = self.numbers[start : start + len(times)]
            filled: int = instance.trajectory(times, rows, self.spans, of_state=self.of_state)
            return filled
        # without numbers to store, it suffices to advance to the last time: output times do not change a run
        done = instance.trajectory(times[-1:], self.numbers[:1], self.spans, of_state=True)
        return len(times) if done else int(np.searchsorted(times, instance.time, side="right"))


def spans_of(words: Sequence[int] | np.ndarray) -> np.ndarray:
    """Return indices in a short form, shape (S, 2): first index and length of each span without gaps."""
    return _spans_of(np.asarray(words, np.int64).tobytes())


@functools.lru_cache(100)
def _spans_of(indices: bytes) -> np.ndarray:
    words = np.frombuffer(indices, np.int64)
    if not len(words):
        return np.zeros((0, 2), np.int64)
    begins = np.flatnonzero(np.diff(words, prepend=words[0] - 2) != 1)
    return np.column_stack([words[begins], np.diff(begins, append=len(words))]).astype(np.int64)


def structured(numbers: np.ndarray, layout: np.dtype) -> np.ndarray:
    """Return rows of numbers, shape (T, W), as a structured array of shape (T,) over the same memory.

    The fields of ``layout`` name the first numbers of a row; further numbers are left out.
    """
    if not layout.itemsize:
        return np.zeros(len(numbers), layout)
    return np.ndarray(len(numbers), layout, numbers, strides=numbers.strides[:1])
