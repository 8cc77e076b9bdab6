"""Dual numbers in plain Python for the kernel's functions, and runs whose instances tests can inspect."""

from __future__ import annotations

from functools import total_ordering
from typing import Any

import numpy as np

from chain_impact.kernel.tangent.duals import DIRECTIONS
from chain_impact.simulation.derivatives import DifferentiatedInstance
from chain_impact.simulation.given_inputs import NamedInputs
from chain_impact.simulation.input_schedule import input_schedule
from chain_impact.variables.prepared import PreparedScene
from chain_impact.variables.selection import differentiable_named
from tests.helpers.kernel.columns import Columns
from tests.helpers.scenes.derivative_scenes import Case


@total_ordering
class Dual:
    """A value and its derivatives in some directions."""

    def __init__(self, value: float, slope: Any) -> None:
        self.value, self.slope = value, np.asarray(slope, float)

    def dual_with_slope(self, number: float, slope: float) -> Dual:
        return Dual(number, slope * self.slope)

    def replace_slope(self, direction: int, slope: float) -> Dual:
        return Dual(self.value, [slope if k == direction else part for k, part in enumerate(self.slope)])

    def has_slope(self) -> bool:
        return bool((self.slope != 0.0).any())

    def __add__(self, other: Dual | float) -> Dual:
        other = self.dual(other)
        return Dual(self.value + other.value, self.slope + other.slope)

    def __mul__(self, other: Dual | float) -> Dual:
        other = self.dual(other)
        return Dual(self.value * other.value, other.value * self.slope + self.value * other.slope)

    __radd__, __rmul__ = __add__, __mul__

    def __neg__(self) -> Dual:
        return -1.0 * self

    def __sub__(self, other: Dual | float) -> Dual:
        return self + -self.dual(other)

    def __rsub__(self, other: float) -> Dual:
        return -self + other

    def __truediv__(self, other: Dual | float) -> Dual:
        other = self.dual(other)
        quotient = self.value / other.value
        return Dual(quotient, (self.slope - quotient * other.slope) / other.value)

    def __rtruediv__(self, other: float) -> Dual:
        return self.dual(other) / self

    def __float__(self) -> float:
        return float(self.value)

    def __abs__(self) -> Dual:
        return self if self.value >= 0.0 else -self

    def __eq__(self, other: object) -> bool:
        return self.value == (other.value if isinstance(other, Dual) else other)

    def __lt__(self, other: Dual | float) -> bool:
        return self.value < self.dual(other).value

    __hash__ = None  # type: ignore[assignment]

    def dual(self, number: Dual | float) -> Dual:
        """Return a number as a dual number."""
        return number if isinstance(number, Dual) else Dual(number, np.zeros_like(self.slope))


def dual(number: float, *slopes: float) -> Dual:
    """Return a dual value with these slopes, or with two slopes of zero."""
    return Dual(number, slopes or (0.0, 0.0))


class Duals(Columns):
    """A record or a table of dual numbers."""

    def clear(self) -> None:
        for own in vars(self).values():
            if isinstance(own, Duals):
                own.clear()
        vars(self).update({name: own * 0 for name, own in vars(self).items() if not isinstance(own, Duals)})

    def copy_values(self, source: Any) -> None:
        for name, own in vars(self).items():
            given = source[name]
            if isinstance(own, Duals):
                own.copy_values(given)
            elif isinstance(own, np.ndarray) and own.dtype == object:
                for place in np.ndindex(own.shape):
                    own[place] = own[place].dual_with_slope(given[place], 1.0)
            else:
                setattr(self, name, own.dual_with_slope(given, 1.0) if isinstance(own, Dual) else given)


def random_duals(rng: np.random.Generator, dtype: np.dtype, rows: tuple[int, ...] = ()) -> Duals:
    """Return a record with random dual numbers for its reals, and zeros for its integers.

    A table with rows becomes a record of arrays, one for each column.
    """

    def number() -> Dual:
        return Dual(rng.normal(), rng.normal(size=DIRECTIONS))

    own = Duals()
    for name in dtype.names or ():
        item, shape = dtype[name].base, rows + dtype[name].shape
        value: Any
        if item.names:
            value = random_duals(rng, item, shape)
        elif item != np.float64:
            value = np.zeros(shape, int) if shape else 0
        elif shape:
            value = np.empty(shape, object)
            for place in np.ndindex(shape):
                value[place] = number()
        else:
            value = number()
        setattr(own, name, value)
    return own


def started(case: Case) -> DifferentiatedInstance:
    """Return an instance at the start of a case, with derivatives of all outputs."""
    prepared = PreparedScene(case.scene)
    times = np.array([0.0, case.scene.simulation.stop_time])
    schedule = input_schedule(prepared, NamedInputs(case.inputs, "hold"), times)
    instance = DifferentiatedInstance(
        prepared, differentiable_named(prepared, case.parameters), schedule=schedule
    )
    schedule.set(instance.record, 0)
    return instance


def followed(instance: DifferentiatedInstance, times: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return values (T, W) and slopes (T, W, P) of all outputs at some times [s]."""
    times = np.array(times, float)
    words = instance.prepared_scene.output_words[list(instance.prepared_scene.output_index.values())]
    rows = instance.rows(len(times), words)
    assert rows.write(instance, times, 0) == len(times)
    values, slopes = np.split(rows.numbers, [len(words)], axis=1)
    return values, slopes.reshape(len(times), len(words), -1)
