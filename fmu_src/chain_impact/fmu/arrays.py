"""The outputs as arrays, which FMI 3.0 has beside the scalars of FMI 2.0."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from chain_impact.variables.model import Model
from chain_impact.variables.outputs import OWNERS
from chain_impact.variables.variable import Variable

NAMES = {field: f"{owner}.{field.removeprefix('point_')}" for field, owner in OWNERS.items()}
"""Field of the output record → the array. Of the latest impacts it is impact.time and so on."""


class Array(NamedTuple):
    """An array whose elements are scalar variables, too.

    Attributes:
        variable: the array as a variable; its place is that of its first element.
        shape: one size for each dimension; the elements stand one after the other in the record, the last
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
    groups: dict[tuple[str | int, ...], list[Variable]] = {}
    for variable in model.outputs:
        record, field, *index = variable.place
        # stops have other units than contacts, and joints without a stop no element
        if index and not variable.name.startswith("joint["):
            groups.setdefault((record, field), []).append(variable)
    return [_array(elements) for elements in groups.values()]


def _array(elements: Sequence[Variable]) -> Array:
    record, field, *_ = elements[0].place
    indices = [variable.place[2:] for variable in elements]
    shape = tuple(1 + max(int(index[axis]) for index in indices) for axis in range(len(indices[0])))
    name = f"impact.{field}" if record == "latest" else NAMES[str(field)]
    text = f"{elements[0].name} to {elements[-1].name}" if len(elements) > 1 else elements[0].name
    return Array(replace(elements[0], name=name, description=f"array of {text}", held=False), shape)
