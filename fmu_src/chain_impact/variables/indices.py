"""The indices of values in the record of an instance: of any number, of outputs, of the list of contacts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np

from chain_impact.kernel.record.counts import Counts
from chain_impact.kernel.record.fields import WORD
from chain_impact.kernel.record.instance import STATE_OUTPUTS, instance_dtype
from chain_impact.scene.texts.names import DataPath
from chain_impact.variables.scene_variables import KEPT_STRUCTURES, outputs_of
from chain_impact.variables.structure import Structure
from chain_impact.variables.variable import Variable

# layouts are cached, because computing one takes as long as the rest of making an instance
layout_of = cache(instance_dtype)
HEAD_WORDS = [kind.names is None for kind, *_ in layout_of(1, 0).fields.values()].index(False)  # type: ignore[union-attr]
"""The number of words at the start of a record: counts, two flags, and the number of tangent instances."""


def word_index(dtype: np.dtype, path: DataPath) -> int:
    """Return the index of the number at a path in a record, in words of 8 bytes from the record's start.

    ``dtype`` is the type of the record. Raises IndexError, KeyError or ValueError if the path does not lead
    to a single number of 8 bytes.
    """
    offset = 0
    for step in path:
        if isinstance(step, str):
            dtype, start = dtype[step], dtype.fields[step][1]  # type: ignore[index]
        else:
            item, (length, *inner_shape) = dtype.base, dtype.shape
            if not 0 <= step < length:
                raise IndexError(f"{path}: {step} is not below {length}")
            dtype = np.dtype((item, tuple(inner_shape)))
            start = step * dtype.itemsize
        offset += start
    if dtype.fields or dtype.itemsize != WORD:
        raise KeyError(f"{path} is not a scalar")
    return offset // WORD


def first_word(dtype: np.dtype, part: str) -> int:
    """Return the index of the first word of a part of a record, such as "output", from the record's start."""
    offset: int = dtype.fields[part][1]  # type: ignore[index]
    return offset // WORD


class LogWords(NamedTuple):
    """Where a record has a run's status and the list of contacts.

    All attributes but ``room`` are indices of words, from the start of the record.

    Attributes:
        status: word with the status of the run.
        ended: word with the number of ended contacts in the list.
        collected: word with the number of ended contacts that a reader has already collected.
        active: word with the number of contacts that last at the present time; in the list, they come after
            the ended contacts.
        friction_changes: word with the number of changes between sticking and sliding that wait to be
            collected.
        integrates: word that is 1 if steps integrate impulses, else 0.
        first: first word of the first column of the list; the columns follow each other without gaps.
        room: number of rows of each column.
    """

    status: int
    ended: int
    collected: int
    active: int
    friction_changes: int
    integrates: int
    first: int
    room: int


@cache
def log_words(counts: Counts) -> LogWords:
    """Return where a record with these counts has the run's status and the logs of contacts and friction."""
    layout = layout_of(*counts)
    paths: tuple[DataPath, ...] = (
        ("statistics", "status"),
        ("contact_log", "count"),
        ("contact_log", "collected"),
        ("contacts", "active_count"),
        ("friction_changes", "count"),
        ("quadrature", "computed"),
        ("contact_log", "point", 0),
    )
    words = [word_index(layout, path) for path in paths]
    return LogWords._make([*words, layout["contact_log"]["point"].shape[0]])


class OutputIndices(NamedTuple):
    """The indices of some outputs in the record of an instance, in words of 8 bytes from the record's start.

    Attributes:
        continuous: name → index, for outputs that change continuously.
        stepwise: name → (index, whether the output is a real number), for outputs that change only at events
            and steps.
        row: the NumPy type of a row of ``Result.outputs`` with the outputs in ``continuous``.
        words: the indices of the numbers in a row of the type ``row``, then the sorted indices of the outputs
            in ``stepwise``.
        of_state: whether the state alone determines all these outputs (``STATE_OUTPUTS`` in
            kernel/record/instance.py), so that no forces must be computed for them.
    """

    continuous: dict[str, int]
    stepwise: dict[str, tuple[int, bool]]
    row: np.dtype
    words: np.ndarray
    of_state: bool = False

    @property
    def width(self) -> int:
        """The number of values in a row of the type ``row``."""
        return self.row.itemsize // WORD


def indices_of(variables: Iterable[Variable], of_all: OutputIndices) -> OutputIndices:
    """Return the indices of the outputs ``variables``, each once; ``of_all`` has those of all outputs.

    In ``continuous`` and in ``stepwise``, they are in the order of ``variables``.
    """
    paths = {variable.name: variable.record_path for variable in variables}
    continuous_words = {name: of_all.continuous[name] for name in paths if name in of_all.continuous}
    stepwise_words = {name: of_all.stepwise[name] for name in paths if name in of_all.stepwise}
    row = np.dtype([(name, np.float64) for name in continuous_words])
    is_of_state = not stepwise_words and all(field in STATE_OUTPUTS for _, field, *_ in paths.values())
    return OutputIndices(
        continuous_words,
        stepwise_words,
        row,
        _words([*continuous_words.values()], stepwise_words),
        is_of_state,
    )


def _words(row: Sequence[int], stepwise_words: Mapping[str, tuple[int, bool]]) -> np.ndarray:
    return np.array([*row, *sorted(word for word, _ in stepwise_words.values())], np.int64)


@lru_cache(KEPT_STRUCTURES)
def output_indices(structure: Structure, counts: Counts) -> OutputIndices:
    """Return the indices of all outputs of a structure, without derivatives; ``counts`` are its counts.

    ``of_state`` is False, whatever the outputs are. The result is cached, because to compute it takes as long
    as a short simulation.
    """
    layout = layout_of(*counts)
    continuous_words: dict[str, int] = {}
    stepwise_words: dict[str, tuple[int, bool]] = {}
    for name, output in outputs_of(structure).items():
        word = word_index(layout, output.record_path)
        if output.record_path[0] == "output":
            continuous_words[name] = word
        else:
            stepwise_words[name] = word, output.type == "real"
    # with all outputs, a row is the whole part ``output`` of the record, in the record's order of fields
    row, first = layout["output"], first_word(layout, "output")
    words = _words(range(first, first + row.itemsize // WORD), stepwise_words)
    return OutputIndices(continuous_words, stepwise_words, row, words)
