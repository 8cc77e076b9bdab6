"""The derivatives of a result's outputs and impacts with respect to parameters and inputs."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from chain_impact.deprecated import OlderName
from chain_impact.recording.equality import have_equal_fields
from chain_impact.scene.errors import UnknownNameError
from chain_impact.scene.texts.input_table import value_at_start
from chain_impact.scene.texts.names import sensitivity_name
from chain_impact.scene.texts.unit_text import bracketed_unit, scene_unit, with_unit
from chain_impact.text import TextTable, as_html, count_text
from chain_impact.variables.prepared import PreparedScene
from chain_impact.variables.scene_variables import derivatives_of
from chain_impact.variables.variable import Variable

RELATIVE_STEP = 0.01
"""The change of a parameter for which pictures and tables show changes of results: RELATIVE_STEP times the
value of the parameter or, if the value is 0, RELATIVE_STEP times the unit of the parameter."""
EXPONENTS = ("contact.exponent", "stop.exponent")
"""The parameters that change the unit, and so the meaning, of a stiffness."""
EXPONENT_NOTE = "is left out: it changes the unit of the stiffness"  # after the name of one of EXPONENTS

# [1] largest difference between a change to first order and the change in a run with the new value, relative
# to the larger |change| of these two; if the difference is larger, texts give both changes
FIRST_ORDER_ERROR = 0.25


def is_different(first_order: float, simulated: float) -> bool:
    """Return whether a change to first order and a simulated one differ by more than FIRST_ORDER_ERROR.

    The result is also True if a change is NaN.
    """
    # a comparison with NaN is False, so NaN counts as different
    return not abs(simulated - first_order) <= FIRST_ORDER_ERROR * max(abs(simulated), abs(first_order))


def step_of(value: float) -> float:
    """Return a small change of a parameter: 1 % of ``value``, with the same sign; 0.01 if ``value`` is 0."""
    return RELATIVE_STEP * (value or 1.0)


@dataclass(frozen=True, repr=False, eq=False)
class Sensitivities:
    """Derivatives of outputs and of impacts with respect to P parameters or inputs.

    Attributes:
        prepared_scene: the prepared scene.
        differentiated: the P parameters and inputs.
        chosen: the names of the W outputs; None stands for all outputs that change continuously.
        slopes: the derivatives of the W outputs at each of the T times, shape (T, W, P).
        impacts: one row for each contact, shape (I,), as ``Result.impacts``.
        impact_slopes: name of a quantity of impacts → its derivatives for each impact, shape (I, P).
        limits: sentences for the user: from which time on there are no derivatives, which derivatives do not
            exist or are one-sided, and why; and how large the errors are that dry friction causes in
            derivatives.
        given: the names of the inputs whose values over time the user gives.
        step_factors: name of a parameter with the value 0 → factor of its ``step``; 1 for all others.
        pattern_exponents: the EXPONENTS among the parameters that the user names by a pattern only.
    """

    __eq__ = have_equal_fields
    __hash__ = None  # type: ignore[assignment]

    prepared_scene: PreparedScene
    differentiated: Sequence[Variable]
    chosen: Sequence[str] | None
    slopes: np.ndarray
    impacts: np.ndarray
    impact_slopes: Mapping[str, np.ndarray]
    limits: tuple[str, ...]
    given: Collection[str] = ()
    step_factors: Mapping[str, float] = field(default_factory=dict)
    pattern_exponents: Collection[str] = ()
    parts = OlderName("step_factors")
    prepared = OlderName("prepared_scene")
    varied = OlderName("differentiated")

    @property
    def source(self) -> str:
        """The name of the scene, for texts and errors."""
        return self.prepared_scene.scene.name

    @cached_property
    def parameters(self) -> dict[str, float]:
        """Name of a parameter or input in ``differentiated`` → its value, that of an input at the start.

        The value is 0 for an input whose values the user gives.
        """
        values, names = self.prepared_scene.scene.values, [variable.name for variable in self.differentiated]
        return {name: 0.0 if name in self.given else value_at_start(values, name) for name in names}

    @cached_property
    def units(self) -> dict[str, str]:
        """Name of a parameter, an input, an output, or a derivative of an output → its unit."""
        prepared_scene = self.prepared_scene
        added = derivatives_of(prepared_scene.continuous_outputs, self.differentiated)
        variables = (*prepared_scene.parameters, *prepared_scene.inputs, *prepared_scene.outputs, *added)
        return {variable.name: scene_unit(variable.unit, prepared_scene.scene) for variable in variables}

    @cached_property
    def columns(self) -> dict[str, int]:
        """Name of an output → its index on the second axis of ``slopes``."""
        if self.chosen is None:
            return self.prepared_scene.output_index
        return {name: column for column, name in enumerate(self.chosen)}

    def __repr__(self) -> str:
        """Return the numbers of outputs, rows and impacts with derivatives, and the parameters."""
        rows, outputs, _ = self.slopes.shape
        return (
            f"Sensitivities({self.source}) of {count_text(outputs, 'output')} in {count_text(rows, 'row')} "
            f"and of {count_text(len(self.impacts), 'impact')}, with respect to {', '.join(self.parameters)}"
        )

    def _repr_html_(self) -> str:
        """Return the text of ``repr`` for a notebook, followed by a table and by ``limits``.

        The table has, for each parameter, the changes of the tip's position and of the total energy at the
        end of the run, as far as these outputs have derivatives.
        """
        outputs = [name for name in self._usual if name in self.columns]
        ends = [self.changes(name)[-1:] for name in outputs]
        head = (
            "parameter",
            "value",
            "change",
            *(f"{name}{bracketed_unit(self.units[name])}" for name in outputs),
        )
        rows = [
            (
                *(name, with_unit(f"{value:.6g}", self.units[name]), f"+ {self.step_text(name)}"),
                *(f"{change:+.3g}" for end in ends for change in end[:, k]),
            )
            for k, (name, value) in enumerate(self.parameters.items())
        ]
        title = ["Changes of outputs at the end, to first order"] if outputs else []
        return as_html([repr(self), *title, TextTable(head, rows), *self.limits])

    of_output = OlderName("output_derivatives")
    of_impacts = OlderName("impact_derivatives")

    def output_derivatives(self, quantity: str, parameter: str) -> np.ndarray:
        """Return the derivative of an output with respect to a parameter, at all times, shape (T,).

        Raises UnknownNameError if there is no such derivative.
        """
        return self.slopes[:, self.columns[self._output(quantity)], self._number(parameter)]

    def impact_derivatives(self, quantity: str, parameter: str) -> np.ndarray:
        """Return the derivative of a quantity of impacts with respect to a parameter, shape (I,).

        Raises UnknownNameError if there is no such derivative.
        """
        if quantity not in self.impact_slopes:
            fault = "not a quantity of impacts with derivatives"
            hint = f"must be one of {', '.join(self.impact_slopes)}"
            raise UnknownNameError(self.source, quantity, self.impact_slopes, fault, hint)
        return self.impact_slopes[quantity][:, self._number(parameter)]

    def without_exponents(self) -> Sensitivities:
        """Return the derivatives without those for ``pattern_exponents``, or all if there are no others."""
        rows = [k for k, name in enumerate(self.parameters) if name not in self.pattern_exponents]
        if not rows or len(rows) == len(self.differentiated):
            return self
        return replace(
            self,
            differentiated=[self.differentiated[k] for k in rows],
            slopes=self.slopes[..., rows],
            impact_slopes={name: slopes[:, rows] for name, slopes in self.impact_slopes.items()},
        )

    def drawn(self, outputs: Sequence[str]) -> list[str]:
        """Return the names of the outputs that a picture draws; refuse a name without derivatives.

        Without ``outputs``, these are the position of the tip and the total energy.
        """
        return [self._output(name) for name in outputs or self._usual]

    @property
    def _usual(self) -> tuple[str, ...]:
        last = len(self.prepared_scene.scene.chain.links)
        return f"point[{last}].x", f"point[{last}].y", "energy.total"

    def _output(self, name: str) -> str:
        if name not in self.columns:
            outputs = {output.name for output in self.prepared_scene.outputs}
            is_stepwise = name in outputs - {output.name for output in self.prepared_scene.continuous_outputs}
            fault = "an output without derivatives" if is_stepwise else "not an output of this result"
            hint = "impact_sensitivity(…) has those of impacts" if name.startswith("impact[") else None
            raise UnknownNameError(self.source, name, self.columns, fault, hint)
        return name

    def _number(self, parameter: str) -> int:
        if parameter not in self.parameters:
            fault = "not among simulate(sensitivities=[…])"
            hint = f"must be one of {', '.join(self.parameters)}"
            raise UnknownNameError(self.source, parameter, self.parameters, fault, hint)
        return list(self.parameters).index(parameter)

    @property
    def named(self) -> dict[str, np.ndarray]:
        """Name of a derivative in the FMU → its values over time, shape (T,)."""
        return {
            sensitivity_name(output, parameter): self.slopes[:, column, k]
            for k, parameter in enumerate(self.parameters)
            for output, column in self.columns.items()
        }

    def step(self, parameter: str) -> float:
        """Return a small change of a parameter, in its unit: ``step_of`` its value, times its step factor."""
        return step_of(self.parameters[parameter]) * self.step_factors.get(parameter, 1.0)

    def step_text(self, parameter: str) -> str:
        """Return the change that ``step`` gives, in words: "1 %", or "0.01 m/s"."""
        return (
            f"{100.0 * RELATIVE_STEP:g} %"
            if self.parameters[parameter]
            else with_unit(f"{self.step(parameter):g}", self.units[parameter])
        )

    def changes(self, output: str) -> np.ndarray:
        """Return the changes of an output, to first order, for a ``step`` of each parameter, shape (T, P).

        A change is the derivative times the step.
        """
        changes: np.ndarray = self.slopes[:, self.columns[output]] * self._steps
        return changes

    def impact_changes(self, quantity: str) -> np.ndarray:
        """Return the changes of a quantity of impacts, to first order, for a ``step`` of each parameter.

        A change is the derivative times the step; the shape is (I, P).
        """
        changes: np.ndarray = slopes_of_impacts(self, quantity) * self._steps
        return changes

    def relative(self, quantity: str) -> np.ndarray:
        """Return ``impact_changes`` divided by the quantity's value, shape (I, P).

        The result is NaN for a value that is unknown or not positive.
        """
        values = self.impacts[quantity]
        is_valid = np.isfinite(values) & (values > 0.0)
        shares: np.ndarray = self.impact_changes(quantity) / np.where(is_valid, values, np.nan)[:, np.newaxis]
        return shares

    @property
    def _steps(self) -> np.ndarray:
        return np.array([self.step(name) for name in self.parameters])


def slopes_of_impacts(sensitivities: Sensitivities, quantity: str) -> np.ndarray:
    """Return the derivatives of a quantity of impacts or of their duration, shape (I, P)."""
    slopes = sensitivities.impact_slopes
    return slopes["end"] - slopes["onset"] if quantity == "duration" else slopes[quantity]
