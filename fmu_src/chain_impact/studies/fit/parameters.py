"""The parameters to fit: start values, bounds, and whether each is searched on a logarithmic scale."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from chain_impact.scene.errors import SceneError, UnknownNameError, value_text
from chain_impact.scene.scene import Scene, fixed_hint
from chain_impact.scene.texts.angles import radians_of
from chain_impact.scene.texts.input_table import value_at_start
from chain_impact.scene.texts.names import fmu_name
from chain_impact.scene.texts.parameter_hints import start_hint
from chain_impact.scene.texts.similar_names import nearest_name
from chain_impact.variables.prepared import PreparedScene
from chain_impact.variables.scene_variables import absent_hint
from chain_impact.variables.variable import Variable

Bounds = Mapping[str, str | tuple[float | None, float | None]]
# A search on a logarithmic scale stays between the start value / LOG_SCALE_REACH and the start value ×
# LOG_SCALE_REACH.
LOG_SCALE_REACH = 1e8


@dataclass(frozen=True)
class Parameter:
    """One free parameter, whose value the fit searches.

    The search varies a coordinate: the logarithm of the value if ``logarithmic``, else the value itself.

    Attributes:
        name: the name of the FMU's parameter or input.
        unit: the unit of the value.
        start: value at the start of the search: that in the scene; of an input, that of ``value_at_start``.
        low: lower bound of the value; −infinity without a bound.
        high: upper bound of the value; infinity without a bound.
        logarithmic: whether the coordinate is the logarithm, as for every parameter that must be > 0.
        data_set: index of the data set to which the value belongs; None if all data sets share the value.
    """

    name: str
    unit: str
    start: float
    low: float
    high: float
    logarithmic: bool
    data_set: int | None = None

    @property
    def label(self) -> str:
        """The parameter's name and, if it belongs to one data set, the number of this data set, from 1."""
        return self.name if self.data_set is None else f"{self.name} of data set {self.data_set + 1}"

    @property
    def ends(self) -> tuple[float, float]:
        """The lowest and the highest coordinate that the search may use: those of ``low`` and ``high``.

        On a logarithmic scale, start / LOG_SCALE_REACH replaces a lower ``low``, and start × LOG_SCALE_REACH
        a higher ``high``.
        """
        if not self.logarithmic:
            return self.low, self.high
        return (
            self.coordinate(max(self.low, self.start / LOG_SCALE_REACH)),
            self.coordinate(min(self.high, self.start * LOG_SCALE_REACH)),
        )

    def coordinate(self, value: float) -> float:
        """Return the coordinate of a value; if it is a logarithm, the result for a value ≤ 0 is −infinity."""
        if not self.logarithmic:
            return value
        return math.log(value) if value > 0.0 else -math.inf

    def value(self, coordinate: float) -> float:
        """Return the value for a coordinate; on a logarithmic scale the value is cut off at its bounds."""
        return min(max(math.exp(coordinate), self.low), self.high) if self.logarithmic else coordinate

    def slope(self, value: float) -> float:
        """Return the derivative of the value with respect to the coordinate, at the given value."""
        return value if self.logarithmic else 1.0


def fitted_parameters(
    scenes: Sequence[Scene], free_names: Sequence[str], free_each: Sequence[str], bounds: Bounds
) -> tuple[Parameter, ...]:
    """Return the parameters to fit: those of ``free_names``, then ``free_each`` for each data set.

    Args:
        scenes: one scene for each data set, with the start values; the first scene has the start values of
            shared parameters.
        free_names: names of parameters and inputs with one value for all data sets.
        free_each: names of parameters and inputs with a value for each data set.
        bounds: name → bounds in addition to the limits of the scene's keys: text such as ``0.1:0.9``, in
            which a bound may be missing, or a pair, in which a bound may be None.

    Raises:
        SceneError: when there is no name, a name is unknown or given twice, bounds are not allowed, or a
            start value is outside of its bounds.
    """
    scene = scenes[0]
    variables = PreparedScene(scene).differentiable
    names = [*free_names, *free_each]
    if not names:
        raise SceneError(f"{scene.name}: no parameter is free; name at least one")
    free_names, free_each = [*map(fmu_name, free_names)], [*map(fmu_name, free_each)]
    bounds = {fmu_name(name): values for name, values in bounds.items()}
    for typed_name in names:
        if fmu_name(typed_name) not in variables:
            fault, hint = "not a parameter that can be fitted", absent_hint(typed_name)
            hint = hint or fixed_hint(scene, fmu_name(typed_name)) or start_hint(typed_name)
            raise UnknownNameError(scene.name, typed_name, variables, fault, hint)
    names = [*free_names, *free_each]
    for k, name in enumerate(names):
        if name in names[:k]:
            raise SceneError(f"{scene.name}: {name} is named twice among the free parameters")
    for name in bounds:
        if name not in names:
            names_text = nearest_name(name, names) or ", ".join(names)
            raise SceneError(
                f": the parameter is not free; free is {names_text}",
                source=scene.name,
                argument="bounds",
                name=name,
            )
    shared_parameters = [_parameter(variables[name], scene, bounds.get(name), None) for name in free_names]
    own_parameters = [
        _parameter(variables[name], own_scene, bounds.get(name), k)
        for name in free_each
        for k, own_scene in enumerate(scenes)
    ]
    return (*shared_parameters, *own_parameters)


def _parameter(
    variable: Variable,
    scene: Scene,
    bounds: str | tuple[float | None, float | None] | None,
    data_set: int | None,
) -> Parameter:
    start = value_at_start(scene.values, variable.name)
    is_logarithmic = variable.exclusive_minimum == 0.0
    ends = [variable.exclusive_minimum if variable.minimum is None else variable.minimum, variable.maximum]
    low, high = (sign * math.inf if end is None else end for sign, end in zip((-1, 1), ends, strict=True))
    if bounds is not None:
        given_low, given_high = _ends(variable, bounds)
        low, high = max(low, given_low), min(high, given_high)
        if not low < high:
            raise SceneError(
                f": {low:g} must be < {high:g}", source=scene.name, argument="bounds", name=variable.name
            )
        if not low <= start <= high:
            raise SceneError(
                f", where the search starts, must be within its bounds, {low:g} to {high:g}",
                source=scene.name,
                name=variable.name,
                value=f"{start:g}",
            )
    return Parameter(variable.name, variable.unit, start, low, high, is_logarithmic, data_set)


def _ends(variable: Variable, bounds: str | tuple[float | None, float | None]) -> tuple[float, float]:
    """Return the lower and the upper bound that ``bounds`` gives a variable; ± infinity for no bound."""
    refused_bounds = partial(SceneError, argument="bounds", name=variable.name, value=value_text(bounds))
    parts = bounds.split(":") if isinstance(bounds, str) else list(bounds)
    try:
        low, high = (sign * math.inf if part in ("", None) else float(radians_of(part, variable.unit))
                     for sign, part in zip((-1, 1), parts, strict=True))  # fmt: skip
    except (TypeError, ValueError):
        raise refused_bounds("must be LOW:HIGH, LOW: or :HIGH") from None
    if np.isnan([low, high]).any():
        raise refused_bounds("must be numbers")
    return low, high
