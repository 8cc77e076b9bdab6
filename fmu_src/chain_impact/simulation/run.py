"""A run of the kernel with inputs over time, its result, and its repetition with other rows."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from chain_impact.deprecated import OlderName
from chain_impact.progress import Progress, no_progress
from chain_impact.recording.impacts import sorted_impacts
from chain_impact.recording.sensitivity import Sensitivities
from chain_impact.recording.stick_slip import NO_PHASES, phases_of
from chain_impact.results.result import Result
from chain_impact.scene.scene import with_values
from chain_impact.simulation.derivatives import DifferentiatedInstance
from chain_impact.simulation.errors import SimulationError
from chain_impact.simulation.held_motions import holds_motions, run_with_rows_between, shortened
from chain_impact.simulation.input_schedule import InputSchedule
from chain_impact.simulation.instance import Instance
from chain_impact.simulation.output_rows import StepwiseColumns, WordRows, structured_rows
from chain_impact.variables.indices import OutputIndices
from chain_impact.variables.prepared import PreparedScene
from chain_impact.variables.variable import Variable


class Run:
    """A run from its start to its end or fault.

    Attributes:
        instance: the instance that runs.
    """

    def __init__(
        self,
        prepared_scene: PreparedScene,
        parameters: Sequence[Variable],
        schedule: InputSchedule,
        indices: OutputIndices,
        pattern_exponents: Collection[str] = (),
    ) -> None:
        """Initialize an instance, with derivatives with respect to ``parameters``, if there are any.

        Args:
            prepared_scene: the scene.
            parameters: the parameters and inputs with derivatives.
            schedule: the inputs over time, and the times of the rows.
            indices: the chosen outputs.
            pattern_exponents: see ``Sensitivities.pattern_exponents``.

        Raises:
            SimulationError: when the scene cannot start.
        """
        self.prepared_scene, self.parameters = prepared_scene, parameters
        self.pattern_exponents = pattern_exponents
        self.schedule, self.indices = schedule, indices
        differentiated_instance = (
            DifferentiatedInstance(prepared_scene, parameters, schedule) if parameters else None
        )
        self.instance = differentiated_instance or Instance(prepared_scene, schedule, ())
        words = indices.words
        if differentiated_instance:
            words = np.append(words, differentiated_instance.slope_words(words[: indices.width]))
        of_state = indices.of_state and not differentiated_instance
        self.rows = WordRows(len(schedule.times), words, of_state=of_state)

    def execute(self, progress: Progress) -> None:
        """Run until the end or a fault, and keep the rows and the impacts."""
        self.row_count, self.impacts = self.instance.run(self.schedule, self.rows, progress)

    def result(self, input_names: Collection[str], chosen_outputs: tuple[str, ...] | None) -> Result:
        """Return the result of the run.

        Args:
            input_names: the names of the given inputs that the result has.
            chosen_outputs: the names of the chosen outputs; None for all outputs.
        """
        schedule, instance, indices = self.schedule, self.instance, self.indices
        has_all = not schedule.paths or schedule.is_requested.all()
        is_requested = schedule.is_requested[: self.row_count]
        requested_rows = slice(self.row_count) if has_all else np.flatnonzero(is_requested)
        numbers, words = self.rows.numbers[requested_rows], indices.words
        order, table = sorted_impacts(
            [*self.impacts, instance.open_contacts()], self.prepared_scene.wall_names
        )
        input_rows = np.arange(self.row_count)[requested_rows]
        return Result(
            prepared_scene=self.prepared_scene,
            time=schedule.times[requested_rows],
            outputs=structured_rows(numbers, indices.row),
            impacts=table,
            statistics=instance.statistics,
            sensitivities=self._sensitivities(numbers[:, len(words) :], order, table, chosen_outputs),
            stepwise=StepwiseColumns(numbers[:, indices.width :], words[indices.width :], indices.stepwise),
            stick_slip=phases_of(instance.all_changes) if instance.changes else NO_PHASES,
            rerun=RepeatableSceneRun(self.prepared_scene, schedule),
            input_values=schedule.values(input_rows, input_names) if input_names else {},
        )

    def _sensitivities(
        self,
        slopes: np.ndarray,
        order: np.ndarray,
        impacts: np.ndarray,
        chosen_outputs: tuple[str, ...] | None,
    ) -> Sensitivities | None:
        """Return the derivatives of a run that computes them; None for another run.

        Args:
            slopes: the derivatives of the outputs, a column for each output and parameter.
            order: the index in the instance's log of each row of ``impacts``.
            impacts: the impacts of the result.
            chosen_outputs: the names of the outputs; None for all.
        """
        if not isinstance(self.instance, DifferentiatedInstance):
            return None
        return Sensitivities(
            prepared_scene=self.prepared_scene,
            differentiated=self.parameters,
            chosen=chosen_outputs,
            slopes=slopes.reshape(len(slopes), self.indices.width, len(self.parameters)),
            impacts=impacts,
            impact_slopes=self.instance.slopes_of_impacts(order),
            limits=self.instance.limits,
            given=[
                variable.name
                for variable in self.prepared_scene.inputs
                if variable.record_path in self.schedule.paths
            ],
            pattern_exponents=self.pattern_exponents,
        )


@dataclass(frozen=True, eq=False)
class RepeatableSceneRun:
    """A function of times that repeats the run, with rows at these times."""

    prepared_scene: PreparedScene
    schedule: InputSchedule
    prepared = OlderName("prepared_scene")

    def __call__(self, times: np.ndarray, progress: Progress = no_progress) -> np.ndarray:
        """Return the outputs that change continuously at increasing ``times`` [s], shape (S,).

        The result is a structured array of shape (S,). It is shorter if the solver cannot continue, and empty
        if the run cannot start. The function ``progress`` is called with the finished fraction, 0 to 1.
        """
        is_held = holds_motions(self.schedule)
        schedule = shortened(self.schedule, times[-1]) if is_held else self.schedule.with_times(times)
        try:
            instance = Instance(self.prepared_scene, schedule, ())
        except SimulationError:
            return np.zeros(0, self.prepared_scene.output_layout)
        words, layout = self.prepared_scene.output_words, self.prepared_scene.output_layout
        rows = WordRows(len(times) if is_held else len(schedule.times), words)
        if is_held:
            finished_rows = run_with_rows_between(instance, schedule, times, rows, progress)
        else:
            finished_rows, _ = instance.run(schedule, rows, progress)
        asked_rows = slice(None) if is_held else schedule.is_requested[:finished_rows]
        outputs: np.ndarray = structured_rows(rows.numbers[:finished_rows], layout)[asked_rows]
        return outputs

    def inputs(self, times: np.ndarray) -> dict[str, np.ndarray]:
        """Return name of each input that the caller gives over time → values at increasing ``times`` [s]."""
        schedule = self.schedule.with_times(times)
        return schedule.values(np.flatnonzero(schedule.is_requested))

    def series(self, times: np.ndarray) -> dict[str, np.ndarray]:
        """Return name → values of ``inputs`` and of each output that changes continuously at ``times`` [s].

        There are fewer values than times if the solver cannot continue.
        """
        outputs = self(times)
        given_inputs = {name: values[: len(outputs)] for name, values in self.inputs(times).items()}
        return given_inputs | self.prepared_scene.series(outputs)

    def changed(self, values: Mapping[str, Any]) -> RepeatableSceneRun:
        """Return the run with the same inputs over time and with other values of parameters.

        Raises:
            SceneError: when the scene cannot have one of the values, or a name is not that of a parameter.
        """
        return RepeatableSceneRun(
            PreparedScene(with_values(self.prepared_scene.scene, values)), self.schedule
        )
