"""The variables of a ``Chain`` in the record."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Self

import numpy as np

from chain_impact.variables.prepared import PreparedScene
from chain_impact.variables.variable import TableRow, Variable


class VariableInRecord(NamedTuple):
    """A variable in the record: its row of the FMU's table, the names of its choices, and its unit.

    ``is_integer`` says whether the value is stored as an integer, as are whole numbers, choices and truth
    values.
    """

    row: TableRow
    is_integer: bool
    choices: tuple[str, ...]
    unit: str

    def value(self, words: np.ndarray) -> Any:
        """Return the given value in the ``words`` of a record; for a choice its name."""
        number = words[self.row.set_word : self.row.set_word + 1]
        if not self.is_integer:
            return float(number[0])
        integer = int(number.view(np.int64)[0])
        return self.choices[integer - 1] if self.choices else integer


@dataclass(frozen=True, slots=True)
class Selection:
    """Several variables that a program reads together.

    ``words`` are the indices of their values in use, in words of the record; ``integer_positions`` are the
    positions, in ``words``, of the integers. ``observed`` says whether outputs must be computed before
    reading: this is so if a variable is an output, or its value in use and its given value have two places in
    the record.
    """

    words: np.ndarray
    integer_positions: np.ndarray
    observed: bool

    @classmethod
    def from_variables(cls, variables: Sequence[VariableInRecord]) -> Self:
        """Return the selection of these variables."""
        rows = [variable.row for variable in variables]
        return cls(
            words=np.array([row.word for row in rows], int),
            integer_positions=np.flatnonzero([variable.is_integer for variable in variables]),
            observed=any(row.role == "output" or row.word != row.set_word for row in rows),
        )


def variable_in_record(variable: Variable, row: TableRow) -> VariableInRecord:
    """Return a variable, with this row of the FMU's table."""
    choices = tuple(item.name for item in variable.items)
    return VariableInRecord(row, variable.type != "real", choices, variable.unit)


def with_present_values(
    prepared_scene: PreparedScene,
    variables: Mapping[str, VariableInRecord],
    start: np.ndarray,
    words: np.ndarray,
) -> PreparedScene:
    """Return ``prepared_scene`` with the present values of the parameters that differ between two records.

    ``start`` are the words of the record at the start of the scene, ``words`` those of the present one.
    """
    values = {}
    for name in prepared_scene.parameter_paths:
        value = variables[name].value(words)
        if value != variables[name].value(start):
            values[name] = value
    return PreparedScene(prepared_scene.scene.with_values(values)) if values else prepared_scene
