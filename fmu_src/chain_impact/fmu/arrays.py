"""The outputs as arrays, which FMI 3.0 has beside the scalars of FMI 2.0."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from chain_impact.variables.model import Model
from chain_impact.variables.outputs import LABELS, OWNERS
from chain_impact.variables.variable import Variable

NAMES = {field: f"{owner}.{LABELS[field]}" for field, owner in OWNERS.items()}
"""Field of the output record → the array. Of the latest impacts it is impact.time and so on."""


class Array(NamedTuple):
    """An array whose elements are scalar variables, too.

    Attributes:
        variable: the array as a variable; its place is that of its first element.
        shape: one size for each dimension; the elements are one after the other in the record, the last
            index changing first.
    """

    variable: Variable
    shape: tuple[int, ...]

    @property
    def length(self) -> int:
        """The number of elements."""
        return math.prod(self.shape)


def array_variables(model: Model) -> list[Array]:
    """The arrays of the outputs that the scene asks for, in the order of their value references."""
    groups: dict[tuple[str | int, str], list[Variable]] = {}
    for variable in model.outputs:
        # stops have other units than contacts, and joints without a stop or dry friction no element
        of_joint = variable.name.startswith("joint[")
        if variable.index and not of_joint and (variable.place[0] == "latest" or variable.field in NAMES):
            groups.setdefault((variable.place[0], variable.field), []).append(variable)
    return [_array(elements) for elements in groups.values()]


def _array(elements: Sequence[Variable]) -> Array:
    record, field = elements[0].place[0], elements[0].field
    indices = [variable.index for variable in elements]
    shape = tuple(1 + max(index[axis] for index in indices) for axis in range(len(indices[0])))
    name = f"impact.{field}" if record == "latest" else NAMES[field]
    text = f"{elements[0].name} to {elements[-1].name}" if len(elements) > 1 else elements[0].name
    return Array(replace(elements[0], name=name, description=f"array of {text}", held=False), shape)
