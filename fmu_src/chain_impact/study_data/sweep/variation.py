"""The variation of one parameter in a sweep: a list of values, or an interval of the samples' values."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from chain_impact.scene.contents import named_point_hint, slider_hint
from chain_impact.scene.errors import SceneError, UnknownNameError
from chain_impact.scene.scene import Scene, fixed_hint
from chain_impact.scene.texts.angles import or_degrees, radians_hint, radians_of
from chain_impact.scene.texts.names import fmu_name
from chain_impact.scene.texts.parameter_hints import parameter_hint
from chain_impact.scene.texts.similar_names import nearest_text
from chain_impact.scene.warning import warn
from chain_impact.variables.owners import Owner
from chain_impact.variables.parameters import SIMULATION_KINDS
from chain_impact.variables.prepared import PreparedScene, as_prepared
from chain_impact.variables.scene_variables import absent_hint
from chain_impact.variables.variable import Variable

Values = str | float | Sequence[float | str] | np.ndarray
STOP_TIME_VARIABLE = Variable.from_kind(SIMULATION_KINDS[0], Owner(), {}, variability="fixed")
LOG = "log"
EPSILON = float(np.finfo(float).eps)
MOST_VALUES = 10**7  # the largest number of values that a text such as 0.1:0.9:9 may ask for
RANGE = re.compile(r"[\d.eE+]+\s*(?:-|–|\.\.+|to)\s*[\d.eE+]+")
"""Matches a range in a wrong form, such as 0.1-0.9; the error then tells the right form."""
FORMS = (
    "a list (0.1,0.5,0.9), a range with a number of values (0.1:0.9:9, or 1e6:1e9:4:log), "
    "or for samples an interval (0.1:0.9, or 1e6:1e9:log)"
)


@dataclass(frozen=True)
class Variation:
    """The values of one parameter in a sweep, or the interval of its samples.

    Attributes:
        variable: the parameter.
        values: the values in the unit of the parameter, or the two ends of the interval; a choice is given by
            its number, from 1.
        interval: whether ``values`` are the ends of an interval.
        logarithmic: whether the user asks for even spacing of values or samples in the logarithm.
    """

    variable: Variable
    values: np.ndarray
    interval: bool = False
    logarithmic: bool = False

    @property
    def name(self) -> str:
        """The name of the parameter."""
        return self.variable.name

    @property
    def choices(self) -> list[str]:
        """The names of an enumeration's choices, in the order of their numbers; empty for a number."""
        return [item.name for item in self.variable.items]

    def shown_values(self, values: np.ndarray) -> np.ndarray:
        """Return values as a table shows them: of an enumeration, the names of the choices."""
        return np.array(["", *self.choices])[values.astype(int)] if self.choices else values

    def values_at(self, parts: np.ndarray) -> np.ndarray:
        """Return the values at the fractions ``parts`` (0 ≤ x < 1) of the interval, or of the list of values.

        A fraction of an interval counts from the first end; in a logarithmic interval it is a fraction of the
        difference of the logarithms. From a list of n values, a fraction x selects the index ⌊n x⌋.
        """
        if not self.interval:
            return np.asarray(self.values[(parts * len(self.values)).astype(int)])
        low, high = self.values
        inner_values = low * (high / low) ** parts if self.logarithmic else low + (high - low) * parts
        return np.asarray(np.clip(inner_values, min(low, high), max(low, high)))


def sweepable_variables(source: Scene | PreparedScene) -> dict[str, Variable]:
    """Return what a sweep can vary, the parameters of the FMU and the stop time: name → variable."""
    return {variable.name: variable for variable in (*as_prepared(source).parameters, STOP_TIME_VARIABLE)}


def variations_of(source: Scene | PreparedScene, vary: Mapping[str, Values]) -> tuple[Variation, ...]:
    """Return the variation of each parameter in ``vary`` (name → values), in the order of ``vary``.

    Raises:
        UnknownNameError: when a name is unknown.
        SceneError: when ``vary`` is empty, or a value is not allowed.
    """
    prepared_scene = as_prepared(source)
    scene = prepared_scene.scene
    if not vary:
        raise SceneError(f"{scene.name}: nothing is varied; give at least one parameter")
    parameters = sweepable_variables(prepared_scene)
    variations = []
    for typed_name, values in vary.items():
        name = fmu_name(typed_name)
        if name not in parameters:
            fault = "not a parameter that can be varied"
            hint = slider_hint(scene, name) or absent_hint(name)
            hint = hint or parameter_hint(name, len(scene.chain.links), scene.signals)
            hint = hint or fixed_hint(scene, name) or named_point_hint(scene, name, parameters)
            raise UnknownNameError(scene.name, typed_name, parameters, fault, hint)
        try:
            variation = _variation(parameters[name], values)
            _check(variation)
        except SceneError as error:
            error.source, error.name = scene.name, typed_name
            raise
        radian_warning = radians_hint(name, max(variation.values, key=abs), variation.variable.unit)
        warn(scene.name, [radian_warning] if radian_warning else [])
        variations.append(variation)
    return tuple(variations)


def _variation(variable: Variable, values: Values) -> Variation:
    """Return the variation of a parameter from text, as on the command line, or from numbers or names."""
    if isinstance(values, str):
        if ":" in values:
            return _range(variable, values)
        values = [part.strip() for part in values.split(",")]
    given_values = np.atleast_1d(np.asarray(values, object))
    if given_values.ndim != 1 or not given_values.size:
        raise SceneError(f"has values of shape {given_values.shape}; must be {FORMS}")
    return Variation(variable, np.array([_number(variable, value) for value in given_values]))


def _range(variable: Variable, text: str) -> Variation:
    """Return the variation for a text a:b, a:b:n, a:b:log or a:b:n:log.

    a and b are the ends of the range, n the number of values, and log means evenly in the logarithm. Without
    n, the variation is an interval.
    """
    parts = text.split(":")
    is_logarithmic = parts[-1].strip() == LOG
    range_error = SceneError(f"must be {FORMS}", value=text)
    if variable.items:
        raise SceneError(f"must be a list of choices, {variable.allowed}", value=text)
    try:
        low, high, *count = parts[: len(parts) - is_logarithmic]
        ends = np.array([float(radians_of(end, variable.unit)) for end in (low, high)])
        numbers = [int(part) for part in count]
    except ValueError:  # a part of the range is not a number, or the second end is missing
        raise range_error from None
    if len(numbers) > 1:
        raise range_error
    if numbers and not 1 < numbers[0] <= MOST_VALUES:
        raise SceneError(f"must have 2 to {MOST_VALUES} values", value=text)
    if is_logarithmic and not (ends > 0.0).all():
        raise SceneError("must have ends > 0, to be spaced by logarithm", value=text)
    if not numbers:
        return Variation(variable, ends, interval=True, logarithmic=is_logarithmic)
    space = np.geomspace if is_logarithmic else np.linspace
    values = space(*ends, *numbers)
    scales = np.abs(values) if is_logarithmic else np.full(len(values), np.abs(ends).max())
    values[1:-1] = [_rounded(*pair) for pair in zip(values[1:-1], scales[1:-1], strict=True)]
    return Variation(variable, values, logarithmic=is_logarithmic)


def _rounded(value: float, scale: float) -> float:
    """Return a value without its round-off: 0.3 for 0.30000000000000004, the third of 0.1:1:10.

    ``scale`` is not below |value|. A value that differs from the decimal number by more than round-off of
    this scale, such as one that was given in degrees, stays.
    """
    if scale == 0.0:
        return value
    decimal = round(float(value), 14 - math.floor(math.log10(scale)))
    return decimal if abs(decimal - value) <= 4.0 * EPSILON * scale else value


def _number(variable: Variable, value: object) -> float:
    """Return a value of a parameter as a number in the parameter's unit.

    A text in degrees becomes radians, and the name of a choice its number, from 1.

    Raises:
        SceneError: when the value is neither a number, nor such a text.
    """
    names = [item.name for item in variable.items]
    if value in names:
        return float(names.index(str(value)) + 1)
    try:
        return float(radians_of(value, variable.unit))
    except (TypeError, ValueError):
        needed_text = variable.allowed + or_degrees(variable.unit) + nearest_text(value, names)
        if RANGE.fullmatch(str(value)):
            needed_text += "; a range is written 0.1:0.9:9, with the number of its values"
        raise SceneError(f"must be {needed_text}", value=str(value)) from None


def _check(variation: Variation) -> None:
    """Refuse a variation with a value, or an end of its interval, that the parameter cannot have."""
    variable, values = variation.variable, variation.values
    is_finite = np.isfinite(values)
    for limit, keeps_limit in (
        (variable.minimum, np.greater_equal),
        (variable.exclusive_minimum, np.greater),
        (variable.maximum, np.less_equal),
    ):
        is_finite &= True if limit is None else keeps_limit(values, limit)
    if variable.items:
        is_finite &= np.isin(values, np.arange(1, len(variable.items) + 1))
    for wrong_value in values[~is_finite]:
        raise SceneError(f"must be {variable.allowed}", value=f"{wrong_value:.15g}")
