"""The rows of outputs that a run fills: their columns, and the numbers of a record in them."""

from __future__ import annotations

import functools
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from chain_impact.scene.errors import find_names
from chain_impact.variables.indices import OutputIndices
from chain_impact.variables.prepared import PreparedScene

# largest number of rows, and of bytes in these rows, that the kernel fills in one call; but at least one row
CHUNK_ROWS, CHUNK_BYTES = 5000, 8_000_000


class Rows(Protocol):
    """The output buffer of a run, which is filled row by row.

    Attributes:
        chunk: largest number of rows that are filled between two reports of progress.
    """

    chunk: int

    def write(self, instance: Any, times: np.ndarray, start: int) -> int:
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

    def write(self, instance: Any, times: np.ndarray, start: int) -> int:
        """Write rows as ``Rows.write`` describes."""
        if self.numbers.shape[1]:
            rows = self.numbers[start : start + len(times)]
            filled_count: int = instance.trajectory(times, rows, self.spans, of_state=self.of_state)
            return filled_count
        # without numbers to store, it suffices to advance to the last time: output times do not change a run
        finished_count = instance.trajectory(times[-1:], self.numbers[:1], self.spans, of_state=True)
        return len(times) if finished_count else int(np.searchsorted(times, instance.time, side="right"))


def spans_of(words: Sequence[int] | np.ndarray) -> np.ndarray:
    """Return indices in a short form, shape (S, 2): first index and length of each span without gaps."""
    return _spans_of(np.asarray(words, np.int64).tobytes())


@functools.lru_cache(100)
def _spans_of(indices: bytes) -> np.ndarray:
    words = np.frombuffer(indices, np.int64)
    if not len(words):
        return np.zeros((0, 2), np.int64)
    begin_indices = np.flatnonzero(np.diff(words, prepend=words[0] - 2) != 1)
    return np.column_stack([words[begin_indices], np.diff(begin_indices, append=len(words))]).astype(np.int64)


def structured_rows(numbers: np.ndarray, layout: np.dtype) -> np.ndarray:
    """Return rows of numbers, shape (T, W), as a structured array of shape (T,) over the same memory.

    The fields of ``layout`` name the first numbers of a row; further numbers are left out.
    """
    if not layout.itemsize:
        return np.zeros(len(numbers), layout)
    return np.ndarray(len(numbers), layout, numbers, strides=numbers.strides[:1])


def chosen_columns(
    prepared_scene: PreparedScene, wanted_names: str | Iterable[str] | None, inputs: Sequence[str]
) -> tuple[OutputIndices, Collection[str]]:
    """Return the record's indices of the outputs, and the names of the ``inputs``, that a result has.

    ``wanted_names`` has their names or patterns; None stands for all.

    Raises:
        UnknownNameError: when a name is not that of an output or of one of the ``inputs``.
    """
    if wanted_names is None:
        return prepared_scene.output_indices, inputs
    if not inputs:
        return prepared_scene.indices_named(wanted_names), ()
    names = [wanted_names] if isinstance(wanted_names, str) else [*wanted_names]
    chosen_inputs = {name: find_names(name, inputs) for name in names if isinstance(name, str)}
    other_names = [
        name
        for name in names
        if not chosen_inputs.get(name) or find_names(name, prepared_scene.outputs_without_derivatives)
    ]
    return prepared_scene.indices_named(other_names), {
        match for input_names in chosen_inputs.values() for match in input_names
    }


class StepwiseColumns(Mapping[str, np.ndarray]):
    """Name → column for the outputs that change only at events and steps.

    A column is taken from the rows of the run only when a caller reads it.
    """

    def __init__(
        self, numbers: np.ndarray, words: np.ndarray, indices: Mapping[str, tuple[int, bool]]
    ) -> None:
        self._numbers, self._words, self._indices = numbers, words, indices

    def __getitem__(self, name: str) -> np.ndarray:
        word, is_real = self._indices[name]
        columns: np.ndarray = self._numbers[:, np.searchsorted(self._words, word)]
        return columns if is_real else columns.copy().view(np.int64)

    def __iter__(self) -> Iterator[str]:
        return iter(self._indices)

    def __len__(self) -> int:
        return len(self._indices)
