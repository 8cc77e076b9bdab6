"""The runs of a sweep with their results, and the columns of the table of these."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from chain_impact.kernel.status import OK, STATUS_NAME
from chain_impact.scene.scene import Scene
from chain_impact.study_data.sweep.design import Design

Columns = dict[str, np.ndarray]
END_COLUMN = "time"  # the column with the time [s] at which the run ended
STATUS = "solver.status"
STATUS_WORD = "status"  # name of the column with a word for the status of each run, such as ok
CHUNK = 2**14  # the largest number of runs whose rows are computed and written, or read, together
_STATUS_TEXTS = np.array([STATUS_NAME[code] for code in sorted(STATUS_NAME)])


class StoredRows(Protocol):
    """Rows of results that stand in files, such as those of ``Dataset`` in studies/sweep/dataset.py."""

    dtype: np.dtype

    def __len__(self) -> int:
        """Return the number of runs."""

    def chunks(self, names: Iterable[str]) -> Iterator[Columns]:
        """Yield the columns ``names`` of some successive runs at a time, up to all runs: name → values."""


def columns_of(design: Design, rows: np.ndarray, first: int, names: Iterable[str] = ()) -> Columns:
    """Return columns of a sweep's table for R successive runs: name → values, shape (R,).

    Args:
        design: the varied values of each run of the sweep.
        rows: the results of these runs, shape (R,), with the type ``Job.dtype``.
        first: the number, from 0, of the first of these runs.
        names: the names of the columns; by default all columns: varied parameters, results, status.
    """
    indices_by_name = {variation.name: k for k, variation in enumerate(design.variations)}
    columns: Columns = {}
    values = None
    for name in names or (*indices_by_name, *(rows.dtype.names or ()), STATUS_WORD):
        if name == STATUS_WORD:
            columns[name] = _STATUS_TEXTS[rows[STATUS]]
        elif name not in indices_by_name:
            columns[name] = rows[name]
        else:
            values = design.values(first, first + len(rows)) if values is None else values
            columns[name] = design.variations[indices_by_name[name]].shown_values(
                values[:, indices_by_name[name]]
            )
    return columns


@dataclass(frozen=True, eq=False, repr=False)
class SweepRuns:
    """The runs of a sweep, a row of results for each; ``Sweep`` describes the attributes."""

    scene: Scene
    design: Design
    rows: np.ndarray | StoredRows
    outputs: tuple[str, ...] = ()

    @property
    def varied(self) -> tuple[str, ...]:
        """The names of the parameters that the user varies, those with a single value included."""
        return tuple(variation.name for variation in self.design.variations)

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all columns: varied parameters, results, and the word for the status."""
        return *self.varied, *(self.rows.dtype.names or ()), STATUS_WORD

    def __len__(self) -> int:
        """Return the number of runs."""
        return len(self.rows)

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a column of the table, shape (R,); the column of a choice has names, such as ids of laws."""
        if name not in self.names:
            raise KeyError(f"{name} is not a column of the sweep; there are {', '.join(self.names)}")
        return self._columns([name])[name]

    @property
    def failed(self) -> np.ndarray:
        """Whether each run stopped at a fault, shape (R,)."""
        return np.asarray(self[STATUS] != OK)

    @functools.cached_property
    def table(self) -> np.ndarray:
        """All columns as one structured array, shape (R,)."""
        columns = self._columns(self.names)
        table = np.zeros(len(self), [(name, column.dtype) for name, column in columns.items()])
        for name, column in columns.items():
            table[name] = column
        return table

    def chunks(self, names: Sequence[str]) -> Iterator[Columns]:
        """Yield the columns ``names`` of some successive runs at a time, up to all runs: name → values."""
        if not isinstance(self.rows, np.ndarray):
            yield from self.rows.chunks(names)
            return
        for first in range(0, len(self), CHUNK):
            yield columns_of(self.design, self.rows[first : first + CHUNK], first, names)

    def _columns(self, names: Sequence[str]) -> Columns:
        """Return the columns ``names`` with the values of all runs: name → values, shape (R,)."""
        chunks = list(self.chunks(names))
        return {name: np.concatenate([chunk[name] for chunk in chunks]) for name in names}
