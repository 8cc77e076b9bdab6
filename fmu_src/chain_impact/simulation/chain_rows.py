"""The rows of a ``Chain`` that records: its outputs and inputs at the start and after each step."""

from __future__ import annotations

import zlib
from collections.abc import Iterable

import numpy as np

from chain_impact.kernel.record.fields import WORD
from chain_impact.results.result import Result
from chain_impact.simulation.instance import Instance
from chain_impact.simulation.output_rows import StepwiseColumns, chosen_columns, spans_of, structured_rows
from chain_impact.variables.prepared import PreparedScene


class ChainRows:
    """The rows of a chain since its start, or since a restored state that had no row.

    Attributes:
        times: the times of the rows [s], increasing.
        numbers: the rows, each with W numbers: outputs and inputs.
        marks: for each row a check sum of the state at the end of the solver's step.
        spans: the indices of a row's numbers in the record, see ``spans_of``.
    """

    def __init__(self, prepared_scene: PreparedScene, record: bool | str | Iterable[str]) -> None:
        """Choose the outputs and inputs of the rows: all if ``record`` is true, else by names or patterns.

        Raises:
            UnknownNameError: when a name is not that of an output or input.
        """
        self.times: list[float] = []
        self.numbers: list[np.ndarray] = []
        self.marks: list[int] = []
        inputs = [variable.name for variable in prepared_scene.inputs]
        wanted_names = None if record is True else record
        self._indices, names = chosen_columns(prepared_scene, wanted_names, inputs)  # type: ignore[arg-type]
        given_words = {v.name: prepared_scene.word_of(v) for v in prepared_scene.inputs if v.name in names}
        self._input_names = tuple(given_words)
        self._words = np.append(self._indices.words, np.array([*given_words.values()], int))
        self.spans = spans_of(self._words)

    def add(self, instance: Instance, numbers: np.ndarray | None = None) -> None:
        """Add a row at the present time of an instance; it replaces a row at the same time.

        ``numbers`` are those of the row; by default those in the record, after ``Instance.observe``.
        """
        if self.times and self.times[-1] == instance.time:
            self._keep(len(self.times) - 1)
        self.times.append(instance.time)
        self.numbers.append(instance.words[self._words] if numbers is None else numbers)
        self.marks.append(_mark(instance))

    def new_row(self) -> np.ndarray:
        """Return memory for the numbers of a row, shape (1, W)."""
        return np.empty((1, len(self._words)))

    def restore(self, instance: Instance) -> None:
        """Keep the rows up to the present state of an instance; none if this state has no row."""
        row_numbers = [k for k, time in enumerate(self.times) if time == instance.time]
        self._keep(row_numbers[0] + 1 if row_numbers and self.marks[row_numbers[0]] == _mark(instance) else 0)

    @property
    def stored_rows(self) -> tuple[list[float], list[np.ndarray], list[int]]:
        """The rows: times, numbers and marks."""
        return self.times, self.numbers, self.marks

    @stored_rows.setter
    def stored_rows(self, rows: tuple[list[float], list[np.ndarray], list[int]]) -> None:
        times, numbers, marks = rows
        self.times, self.numbers, self.marks = [*times], [*numbers], [*marks]

    def clear(self) -> None:
        """Remove all rows."""
        self._keep(0)

    def _keep(self, count: int) -> None:
        for rows in self.stored_rows:
            del rows[count:]

    def result(
        self,
        prepared_scene: PreparedScene,
        impacts: np.ndarray,
        phases: np.ndarray,
        statistics: dict[str, int],
    ) -> Result:
        """Return the rows as a result of the scene ``prepared_scene``.

        Args:
            prepared_scene: the scene, with the present values of its parameters.
            impacts: the impacts of the run; those that end before the first row are left out.
            phases: the phases of dry friction of the run; those that end before the first row are left out.
            statistics: the solver's counts and its status.
        """
        indices, numbers = self._indices, np.array(self.numbers)
        width, count = indices.row.itemsize // WORD, len(indices.words)
        inputs = zip(self._input_names, numbers.T[count:], strict=True)
        return Result(
            prepared_scene,
            np.array(self.times),
            structured_rows(numbers, indices.row),
            impacts[~(impacts["end"] < self.times[0])],
            stepwise=StepwiseColumns(numbers[:, width:count], indices.words[width:], indices.stepwise),
            stick_slip=phases[~(phases["end"] < self.times[0])],
            input_values=dict(inputs),
            statistics=statistics,
        )


def _mark(instance: Instance) -> int:
    """Return a check sum of the state at the end of the solver's step; other runs mostly have another one."""
    return zlib.crc32(instance.record["step"]["state_end"].tobytes())
