"""The runs of a sweep with their results; table.py makes them a public class, and plot.py draws them."""

from __future__ import annotations

import functools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from chain_impact.kernel.status import OK
from chain_impact.scene.scene import Scene
from chain_impact.studies.sweep.computation import CHUNK, STATUS_WORD, Columns, columns_of
from chain_impact.studies.sweep.dataset import Dataset
from chain_impact.studies.sweep.design import Design
from chain_impact.studies.sweep.job import STATUS


@dataclass(frozen=True, eq=False, repr=False)
class SweepRuns:
    """The runs of a sweep, a row of results for each; ``Sweep`` (table.py) describes the attributes."""

    scene: Scene
    design: Design
    rows: np.ndarray | Dataset
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
        if isinstance(self.rows, Dataset):
            yield from self.rows.chunks(names)
            return
        for first in range(0, len(self), CHUNK):
            yield columns_of(self.design, self.rows[first : first + CHUNK], first, names)

    def _columns(self, names: Sequence[str]) -> Columns:
        """Return the columns ``names`` with the values of all runs: name → values, shape (R,)."""
        chunks = list(self.chunks(names))
        return {name: np.concatenate([chunk[name] for chunk in chunks]) for name in names}
