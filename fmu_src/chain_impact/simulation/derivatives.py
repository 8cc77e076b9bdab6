"""Runs that also compute derivatives of their results with respect to parameters and inputs.

In memory, tangent instances come after the instance: records of dual numbers, each with derivatives in a
few directions (kernel/tangent/). A derivative is a partial derivative: all other parameters of the FMU are
constant. Its unit is the unit of the quantity divided by the unit of the parameter. A derivative that does
not exist, or cannot be trusted, is NaN.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from chain_impact.kernel.record.fields import WORD
from chain_impact.kernel.status import OK
from chain_impact.kernel.tangent.duals import DIRECTIONS
from chain_impact.kernel.tangent.trust import JOINT, NO_IMPACT, TRUSTED
from chain_impact.recording.equality import have_equal_fields
from chain_impact.recording.impact_texts import touching_part_name
from chain_impact.recording.impacts import LOG_DTYPE, POSITION, sorted_impacts
from chain_impact.recording.joint_stops import is_scene_joint_stop
from chain_impact.scene.errors import SceneError
from chain_impact.scene.scene import SceneSource, scene_of
from chain_impact.scene.texts.names import DataPath
from chain_impact.simulation.bends_at_start import bends_at_start
from chain_impact.simulation.derivative_limits import (
    LEFT_OPEN,
    NO_LESS,
    NO_RISE,
    ONE_SIDED,
    REASONS,
    REASONS_AT_STOPS,
    REASONS_OF_FRICTION,
)
from chain_impact.simulation.errors import SimulationError
from chain_impact.simulation.given_inputs import GivenInputs, Interpolation, named_inputs
from chain_impact.simulation.input_schedule import InputSchedule, input_schedule
from chain_impact.simulation.instance import Instance
from chain_impact.simulation.output_rows import WordRows
from chain_impact.variables.indices import first_word, word_index
from chain_impact.variables.prepared import PreparedScene
from chain_impact.variables.scene_variables import TANGENTS
from chain_impact.variables.selection import columns_named, differentiable_named
from chain_impact.variables.variable import Variable

DIFFERENTIABLE_COLUMNS = tuple(
    name for name in LOG_DTYPE.names or () if name not in ("point", "wall", "joint")
)
"""The columns of ``Result.impacts`` that have derivatives."""
LEAST_REPORTED_SHARE = 1e-5
"""[1] An error of derivatives that dry friction causes is told to users if it is larger than this, relative
to the largest derivative of a position; the solver's tolerance allows smaller errors anyway."""
# quantities of an impact that are known when it begins; all others are known at its end
ONSET_QUANTITIES = ("onset", "impact_speed", "effective_mass", *POSITION)


class DifferentiatedInstance(Instance):
    """An initialized instance with tangent instances, which have its derivatives.

    Attributes:
        variables: the P parameters and inputs with respect to which there are derivatives.
        parameters: the names of ``variables``.
    """

    def __init__(
        self,
        prepared_scene: PreparedScene,
        parameters: Sequence[Variable],
        schedule: InputSchedule | None = None,
    ) -> None:
        """Make the instance as ``Instance`` does, with derivatives with respect to P parameters and inputs.

        Raises:
            SceneError: when ``parameters`` is empty.
            SimulationError: when the scene cannot start.
        """
        if not parameters:
            raise SceneError(f"{prepared_scene.scene.name}: name at least one parameter for the derivatives")
        self.variables = parameters
        self.parameters = tuple(variable.name for variable in parameters)
        self._impact_slopes: list[np.ndarray] = []
        self._impact_layout = np.dtype(
            [(name, np.float64, (len(self.parameters),)) for name in DIFFERENTIABLE_COLUMNS]
        )
        super().__init__(prepared_scene, schedule, parameters)

    def initialize(self) -> None:
        """Set the instance and its tangent instances to the start of the run.

        Raises:
            SimulationError: when the scene cannot start.
        """
        self._impact_slopes = []
        self._tangents["trust"]["reason"] = TRUSTED
        super().initialize()

    def restart(self, paths: Sequence[DataPath], values: np.ndarray) -> None:
        """Set the instance and its tangent instances to the start, with new values of parameters and inputs.

        ``paths[k]`` leads, in the record, to the number that ``values[k]`` replaces.

        Raises:
            SimulationError: when the scene cannot start.
        """
        for path, value in zip(paths, values, strict=True):
            self.words[word_index(self._memory.dtype, path)] = value
        self.initialize()

    def slope_words(self, words: np.ndarray) -> np.ndarray:
        """Return the indices of the derivatives of outputs, in the record with its tangent instances.

        Args:
            words: the indices of the W outputs in the record.

        Returns:
            Indices of shape (W · P,): the P derivatives of the first output, then those of the second, and so
                on.
        """
        layout, tangent = self._memory.dtype, self._tangents.dtype
        tangents, directions = np.divmod(np.arange(len(self.parameters)), DIRECTIONS)
        first = (
            first_word(layout, TANGENTS)
            + tangents * (tangent.itemsize // WORD)
            + first_word(tangent, "output")
        )
        index = np.array(words, int) - first_word(layout, "output")
        indices: np.ndarray = 1 + first + directions + index[:, np.newaxis] * (1 + DIRECTIONS)
        return indices.ravel()

    def rows(self, count: int, words: np.ndarray) -> WordRows:
        """Return a buffer of ``count`` rows: the outputs at the indices ``words``, then their derivatives."""
        return WordRows(count, np.concatenate([words, self.slope_words(words)]))

    @property
    def _directions(self) -> int:
        """The number of derivatives of each number: that of parameters or more, a multiple of DIRECTIONS."""
        return len(self._tangents) * DIRECTIONS

    @property
    def _tangents(self) -> np.ndarray:
        """The tangent instances: records of dual numbers, each with derivatives in DIRECTIONS directions."""
        tangents: np.ndarray = self.record[TANGENTS]
        return tangents

    def collect(self) -> np.ndarray:
        """Return the contacts that have ended since the last call, and store their derivatives."""
        slots = self._ended_contacts % self._log_at.room
        rows = super().collect()
        if len(rows):
            last = int(self.record["contact_log"]["count"])
            # In a step that failed, a contact may have ended in the instance, but not in the tangent
            # instances: the derivatives of this contact are then NaN.
            self._keep_slopes(rows, slots, np.arange(last - len(rows), last) < self._log["count"][0])
        return rows

    def open_contacts(self) -> np.ndarray:
        """Return the contacts that still last, as ``Instance`` does, and store their derivatives."""
        rows = super().open_contacts()
        if len(rows):
            log, slots = self._log, self._lasting_contacts % self._log_at.room
            # after a fault, the tangent instances may have another contact in this row of the log:
            # derivatives are then NaN
            is_same = (log["point"][:, slots] == rows["point"]) & (log["wall"][:, slots] == rows["wall"])
            self._keep_slopes(rows, slots, is_same.all(axis=0) & (self.status == OK))
        return rows

    @property
    def _log(self) -> np.ndarray:
        """The logs of contacts of all tangent instances."""
        log: np.ndarray = self._tangents["contact_log"]
        return log

    def _keep_slopes(self, rows: np.ndarray, slots: Any, valid: np.ndarray) -> None:
        """Store the derivatives of the impacts in ``rows``; ``slots``: the impacts' indices in the logs.

        A derivative is NaN if the impact is not ``valid``, if the quantity is not finite, if the quantity
        becomes known when derivatives cannot be trusted, or for a parameter in ``_is_missing``.
        """
        kept_slopes = np.zeros(len(rows), self._impact_layout)
        trust = self._tangents["trust"][0]
        distrusted = np.inf if trust["reason"] == TRUSTED else trust["time"]
        for name in DIFFERENTIABLE_COLUMNS:
            slopes = self._log[name]["slope"][:, slots].transpose(1, 0, 2)
            kept_slopes[name] = slopes.reshape(len(rows), self._directions)[:, : len(self.parameters)]
            end_rows = (
                rows["onset"]
                if name in ONSET_QUANTITIES
                else np.where(np.isnan(rows["end"]), self.time, rows["end"])
            )
            kept_slopes[name][~valid | (end_rows >= distrusted) | ~np.isfinite(rows[name])] = np.nan
            kept_slopes[name][:, self._is_missing] = np.nan
        self._impact_slopes.append(kept_slopes)

    def slopes_of_impacts(self, order: np.ndarray) -> dict[str, np.ndarray]:
        """Return quantity → derivatives, shape (I, P), in the order that ``sorted_impacts`` returned."""
        all_slopes = np.concatenate([np.zeros(0, self._impact_layout), *self._impact_slopes])[order]
        return {name: all_slopes[name] for name in DIFFERENTIABLE_COLUMNS}

    @property
    def _is_missing(self) -> np.ndarray:
        """Whether derivatives by each parameter are missing from some time up to the present, shape (P,)."""
        is_missing: np.ndarray = self._tangents["trust"]["missing"].ravel()[: len(self.parameters)] != 0
        return is_missing

    @property
    def _one_sided(self) -> list[str]:
        """The names of parameters with one-sided derivatives: they shift a knot in ``bends_at_start``."""
        signals = self.prepared_scene.structure.signals
        if not signals:
            return []
        slopes = self._tangents["knot"]["time"]["slope"][:, bends_at_start(self.record, signals)]
        has_slope = (slopes != 0.0).any(axis=1).ravel()
        return [name for name, is_moving in zip(self.parameters, has_slope, strict=False) if is_moving]

    @property
    def limits(self) -> tuple[str, ...]:
        """Sentences for users: which derivatives are NaN, one-sided or, by dry friction, inexact, and why."""
        trust, share = self._tangents["trust"][0], float(self._tangents["trust"]["neglected"].max())
        missing_parameters = [
            parameter
            for parameter, is_missing in zip(self.variables, self._is_missing, strict=True)
            if is_missing
        ]
        sentences = [
            *([LEFT_OPEN.format(share=share)] if share > LEAST_REPORTED_SHARE else []),
            *(
                (NO_RISE if is_rise(parameter) else NO_LESS).format(parameter=parameter.name)
                for parameter in missing_parameters
            ),
            *(ONE_SIDED.format(parameter=name) for name in self._one_sided),
        ]
        if trust["reason"] == TRUSTED:
            return tuple(sentences)
        location_text, reasons, cause = "", REASONS, "impact"
        if trust["reason"] in REASONS_OF_FRICTION:
            reasons, cause = REASONS_OF_FRICTION, "dry friction"
        if trust["point"] != NO_IMPACT and trust["wall"] == JOINT:
            location_text = f", the {cause} of joint {trust['point']}"
        elif trust["point"] != NO_IMPACT:
            scene, wall = self.prepared_scene.scene, trust["wall"]
            touching_part = touching_part_name(int(trust["point"]), scene.stop_name(wall), scene.point_names)
            location_text = f", the {cause} of {touching_part} at {scene.wall_names[wall]}"
            reasons = REASONS_AT_STOPS if is_scene_joint_stop(scene, wall) else reasons
        reason = reasons[int(trust["reason"])]
        end_text = f"there are no derivatives from t = {trust['time']:.9g} s on{location_text}: {reason}"
        return end_text, *sentences


def is_rise(parameter: Variable) -> bool:
    """Return whether a parameter is the rise of a signal.

    A parameter with respect to which derivatives are missing (``_is_missing``) is a rise of 0 or a friction
    of 0; this function tells which of the two it is.
    """
    return parameter.record_path[:2] == ("signal", "rise")


@dataclass(frozen=True, eq=False)
class Differentiated:
    """The outputs of a run, with derivatives with respect to its P parameters.

    Attributes:
        values: the W outputs at T times, shape (T, W); NaN after a fault.
        slopes: the derivatives of the outputs, shape (T, W, P); NaN after a fault, and as ``limits`` tells.
        impacts: I rows, one for each contact in order of onset, as ``Result.impacts``.
        impact_slopes: quantity of an impact → its derivatives, shape (I, P).
        status: 0 if there is no fault, see ``chain_impact.kernel.status``.
        limits: sentences on derivatives that are NaN, and why; on one-sided derivatives; and on errors that
            dry friction causes.
    """

    __eq__ = have_equal_fields
    __hash__ = None  # type: ignore[assignment]

    values: np.ndarray
    slopes: np.ndarray
    impacts: np.ndarray
    impact_slopes: dict[str, np.ndarray]
    status: int
    limits: tuple[str, ...]


class DifferentiatedRun:
    """Runs of one scene with derivatives; each run has its own values of the parameters."""

    def __init__(
        self,
        scene: SceneSource,
        parameters: Sequence[str],
        outputs: Sequence[str],
        inputs: GivenInputs | None = None,
        interpolation: Interpolation = "follow",
    ) -> None:
        """Prepare runs with derivatives of outputs with respect to parameters; both are given by name.

        Args:
            scene: a scene, or an argument of ``load_scene``.
            parameters: P real parameters and inputs of the FMU.
            outputs: W outputs of the FMU that change continuously, without ``*`` in the names.
            inputs: name of an input → its signal over time, or a table, as ``simulate`` takes them.
            interpolation: the interpolation of the inputs, as for ``simulate``.

        Raises:
            UnknownNameError: when a name does not exist.
            SceneError: when the scene or a table of inputs is invalid, or ``parameters`` is empty.
            SimulationError: when the scene cannot start.
        """
        self._prepared_scene = PreparedScene(scene_of(scene))
        self._inputs = named_inputs(inputs, interpolation, self._prepared_scene.scene)
        variables = differentiable_named(self._prepared_scene, parameters)
        self._paths = [variable.set_path for variable in variables]
        columns = columns_named(self._prepared_scene, outputs)
        self._words = self._prepared_scene.output_words[[columns[name] for name in outputs]]
        self._instance = DifferentiatedInstance(self._prepared_scene, variables)

    def run(self, values: np.ndarray, times: np.ndarray) -> Differentiated:
        """Run from the start with some values of the parameters.

        If the run cannot start, all outputs and their derivatives are NaN, and there are no impacts. If the
        run fails later, the outputs and derivatives after the fault are NaN.

        Args:
            values: the values of the parameters, shape (P,); the value for an input is not used if
                ``inputs`` has a signal for it.
            times: the increasing times of the wanted outputs, shape (T,) [s].

        Raises:
            SceneError: when an input is invalid.
        """
        instance = self._instance
        times = np.ascontiguousarray(times, float)
        schedule = input_schedule(self._prepared_scene, self._inputs, times)
        rows = instance.rows(len(schedule.times), self._words)
        asked_rows = np.searchsorted(schedule.times, times)
        schedule.set(instance.record, 0)
        try:
            instance.restart(self._paths, values)
        except SimulationError:
            rows.numbers[:] = np.nan
            return self._differentiated(rows.numbers[asked_rows], [])
        finished_rows, impacts = instance.run(schedule, rows)
        rows.numbers[finished_rows:] = np.nan
        impacts.append(instance.open_contacts())
        return self._differentiated(rows.numbers[asked_rows], impacts)

    def _differentiated(self, slopes: np.ndarray, impacts: list[np.ndarray]) -> Differentiated:
        width, count = len(self._words), len(self._paths)
        order, rows = sorted_impacts(
            [np.zeros(0, LOG_DTYPE), *impacts], self._instance.prepared_scene.scene.wall_names
        )
        return Differentiated(
            values=slopes[:, :width],
            slopes=slopes[:, width:].reshape(len(slopes), width, count),
            impacts=rows,
            impact_slopes=self._instance.slopes_of_impacts(order),
            status=self._instance.status,
            limits=self._instance.limits,
        )
