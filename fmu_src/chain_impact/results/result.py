"""The result of a simulation."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping
from dataclasses import KW_ONLY, dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from chain_impact.deprecated import OlderName
from chain_impact.recording import summary, tables
from chain_impact.recording.impact_course import RepeatableRun
from chain_impact.recording.impacts import NO_IMPACTS
from chain_impact.recording.joint_stops import JointRange, ranges_of
from chain_impact.recording.sensitivity import Sensitivities
from chain_impact.recording.stick_slip import NO_PHASES
from chain_impact.results.scene_recording import SceneRecording
from chain_impact.scene.errors import SceneError, SceneWarning, UnknownNameError, names_matching
from chain_impact.scene.facts import FACTS
from chain_impact.scene.half_planes import HalfPlane
from chain_impact.text import PrintedResult, TextTable
from chain_impact.variables.output_hints import series_hint
from chain_impact.variables.outputs import OUTPUTS
from chain_impact.variables.prepared import PreparedScene, field_at
from chain_impact.variables.selection import missing_output_hint

if TYPE_CHECKING:
    import pandas
    import xarray

# a run with more evaluations of the equations of motion than this is not repeated with other values
MOST_EVALUATIONS = 300_000
ENERGIES = {
    kind.parts.quantity: kind for block in OUTPUTS for kind in block.kinds if kind.parts.owner == "energy"
}
"""Name of an energy, such as ``kinetic`` → the row of this energy in the table of outputs."""


@dataclass(frozen=True, repr=False, eq=False)
class Result(PrintedResult, SceneRecording):
    """The result of a simulation: a recording with its scene.

    Two results are equal if all their attributes except ``stepwise`` and ``rerun`` are equal.

    ``result["point[4].x"]`` is an output over time, shape (T,), by its name in the FMU; ``result["time"]`` is
    the time. A name with ``*``, which stands for any text, gives a dict: name → output over time, for all
    matching outputs. An example is ``result["contact[2].*.force"]``. A list of names also gives a dict:
    ``result[["point[4].x", "energy.*"]]``.

    Attributes:
        prepared_scene: the prepared scene that was simulated.
        time: the communication points, shape (T,) [s].
        outputs: the outputs that change continuously, at these times, a structured array of shape (T,). Its
            fields are those of ``output_dtype`` in kernel/record/instance.py or, with
            ``simulate(output=…)``, the names of the outputs.
        impacts: one row for each contact in order of onset, see ``IMPACT_DTYPE``.
        statistics: steps, rejected_steps, rhs_evaluations, implicit_steps, status.
        sensitivities: the derivatives that ``simulate(sensitivities=…)`` requested, if any.
        stepwise: the outputs ``impact.*``, ``impact[j].*`` and ``solver.*``, which change only at events and
            steps: name → shape (T,).
        stick_slip: one row for each phase of sticking or sliding by dry friction, in order of its start, see
            ``STICK_SLIP_DTYPE``.
        input_values: the inputs that the caller gives over time: name → shape (T,). Where an input jumps, the
            row has the value before the jump, as forces and accelerations do.
        rerun: function that repeats the run: times → outputs at these times; None if the run cannot be
            repeated.
    """

    prepared_scene: PreparedScene
    # ``field()``: a dataclass would take the inherited attribute for a default
    time: np.ndarray = field()
    outputs: np.ndarray = field()
    impacts: np.ndarray = field()
    _: KW_ONLY
    statistics: dict[str, int]
    sensitivities: Sensitivities | None = None
    stepwise: Mapping[str, np.ndarray] = field(default_factory=dict, compare=False)
    stick_slip: np.ndarray = field(default_factory=lambda: NO_PHASES)
    rerun: RepeatableRun | None = field(default=None, compare=False)
    input_values: Mapping[str, np.ndarray] = field(default_factory=dict)

    @overload
    def __getitem__(self, name: str) -> np.ndarray: ...

    @overload
    def __getitem__(self, name: list[str]) -> dict[str, np.ndarray]: ...

    def __getitem__(self, name: str | list[str]) -> np.ndarray | dict[str, np.ndarray]:
        """Return an output or given input over time by its name, shape (T,), or a dict: name → values.

        A name of a column gives the array. A pattern, which is a name with ``*``, gives a dict, and so do a
        name as in the scene file and a list of names and patterns. Type checkers assume that a single text
        gives an array; for them, write a single pattern in a list.

        Raises:
            UnknownNameError: a KeyError, when no output has the name.
        """
        if isinstance(name, list):
            columns: dict[str, np.ndarray] = {}
            for item in name:
                values = self[item]
                columns |= values if isinstance(values, dict) else {item: values}
            return columns
        if name == "time":
            return self.time
        if name in self.continuous_columns:
            return self.continuous_columns[name]
        if name in self.names:
            return (self.stepwise if name in self.stepwise else self.input_values)[name]
        hint = series_hint(self.output_hint)
        matching_names = names_matching(
            self.scene.name, name, self.names, "not an output of this result", hint
        )
        return {item: self[item] for item in matching_names}

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the outputs: first the continuous ones, then ``stepwise``; given inputs come last."""
        return *self.continuous_columns, *self.stepwise, *self.input_values

    def output_hint(self, name: str) -> str | None:
        """Return a hint for a name that no output of this result has; None if no hint is known."""
        return missing_output_hint(self.prepared_scene, name)

    model = OlderName("prepared_scene")
    motion = OlderName("continuous_columns")
    prepared = OlderName("prepared_scene")

    @property
    def name(self) -> str:
        """The name of the scene."""
        return self.scene.name

    @property
    def stop_law(self) -> str:
        """The contact law of the stops if the scene gives `stops.model`; else ""."""
        return self.scene.stops.model or ""

    @cached_property
    def columns(self) -> Mapping[str, np.ndarray]:
        """Name of an output or given input → its values over time, shape (T,)."""
        return {**self.continuous_columns, **self.stepwise, **self.input_values}

    @cached_property
    def continuous_columns(self) -> dict[str, np.ndarray]:
        """Name of an output that changes continuously → its values over time, shape (T,)."""
        recorded_names = self.outputs.dtype.names or ()
        return (
            self.prepared_scene.series(self.outputs)
            if self._has_all
            else {n: self.outputs[n] for n in recorded_names}
        )

    @property
    def _has_all(self) -> bool:
        """Whether ``outputs`` has the fields of ``output_dtype``.

        Otherwise ``outputs`` has a field for each continuous output that ``simulate(output=…)`` named.
        """
        return "point_position" in (self.outputs.dtype.names or ())

    @cached_property
    def pinned(self) -> bool:
        """Whether the base is pinned, so that link 1 turns about joint 1; inputs may move such a base."""
        return self.scene.chain.base == "pinned"

    @cached_property
    def walls(self) -> Mapping[str, HalfPlane]:
        """Name of a wall → its free side, without the displacement that inputs may give."""
        return self.scene.half_planes

    @cached_property
    def wall_names(self) -> tuple[str, ...]:
        """The names of the walls and stops, in the order of their numbers, as in ``impacts``."""
        return self.prepared_scene.wall_names

    @cached_property
    def point_names(self) -> Mapping[int, str]:
        """Number of a point → its name, for the points with names."""
        return self.scene.point_names

    @cached_property
    def parameters(self) -> Mapping[str, Any]:
        """Name of a parameter → its value; for an enumeration the name of the choice."""
        values = self.scene.values
        return {name: values[name] for name in self.prepared_scene.parameter_paths}

    @cached_property
    def stops(self) -> Mapping[int, JointRange]:
        """Number of a joint with stops → the range [rad] of the joint's angle."""
        return ranges_of(self.parameters)

    @property
    def impact_count(self) -> int:
        """The number of impacts, all of which a result lists."""
        return len(self.impacts)

    @cached_property
    def link_count(self) -> int:
        """The number of links N."""
        return len(self.scene.chain.links)

    @cached_property
    def all_points(self) -> np.ndarray:
        """Positions x, y of all points in the order of their numbers, shape (T, N+1+P, 2) [m].

        Points 0…N are the ends of the links; the P points on links follow.

        Raises:
            UnknownNameError: when the result lacks one of these positions.
        """
        return self._stacked_outputs("point_position")

    @property
    def knows_points(self) -> bool:
        """Whether the result has the positions of all points."""
        outputs = {v.name for v in self.prepared_scene.continuous_outputs if v.field == "point_position"}
        return self._has_all or (bool(outputs) and outputs <= {*self.continuous_columns})

    @property
    def angles(self) -> np.ndarray:
        """Absolute angles of the links, anticlockwise from the x axis, shape (T, N) [rad].

        Raises:
            UnknownNameError: when the result lacks one of these angles.
        """
        return self._stacked_outputs("angle")

    @property
    def angular_velocities(self) -> np.ndarray:
        """Angular velocities of the links, positive anticlockwise, shape (T, N) [rad/s].

        Raises:
            UnknownNameError: when the result lacks one of these angular velocities.
        """
        return self._stacked_outputs("angular_velocity")

    @property
    def energy(self) -> np.ndarray:
        """The energies [J], a structured array of shape (T,).

        The fields are kinetic, potential, elastic, dissipated, supplied, total and friction. The field total
        is the sum kinetic + potential + elastic; total + dissipated − supplied is constant, except for errors
        of the solver. The field friction is the part of dissipated that is due to dry friction. Only this
        field can be unknown, and is then NaN: a run computes integrals over time only if the scene asks for
        an output that needs them, and a result with some of the outputs may lack this one.

        Raises:
            UnknownNameError: when the result lacks the output of another field.
        """
        energy = np.zeros(len(self.time), [(name, np.float64) for name in ENERGIES])
        numbers = self.prepared_scene.structure.numbers
        is_known = numbers["needs_impulses"] and (self._has_all or "energy.friction" in self.names)
        for name, kind in ENERGIES.items():
            # the scene has no such output, for example without friction or supply: this energy is 0
            if not all(numbers[condition] for condition in kind.when if condition in FACTS):
                continue
            if name == "friction" and not is_known:
                energy[name] = np.nan
            else:
                energy[name] = field_at(self.outputs, kind.record_path) if self._has_all else self[kind.name]
        return energy

    def row_of_other_run(self, values: Mapping[str, Any], time: float) -> Result | None:
        """Return a result with one row, at ``time`` [s], of a run with the same inputs and other ``values``.

        ``values`` is name of a parameter → value. The result has no impacts. It is None if the run cannot be
        repeated, or took more than MOST_EVALUATIONS evaluations of the right-hand side; if the scene
        cannot have the values; or if the other run cannot start, or ends before ``time``.
        """
        if self.rerun is None or self.statistics["rhs_evaluations"] > MOST_EVALUATIONS:
            return None
        try:
            with warnings.catch_warnings():
                # the user has seen the warnings of the scene, and the other values are not the user's
                warnings.simplefilter("ignore", SceneWarning)
                other_run = self.rerun.changed(values)
        except SceneError:
            return None
        outputs = other_run(np.array([time]))
        if not len(outputs):
            return None
        return replace(
            self,
            prepared_scene=other_run.prepared_scene,
            time=np.array([time]),
            outputs=outputs,
            impacts=NO_IMPACTS,
            sensitivities=None,
            stepwise={},
            stick_slip=NO_PHASES,
            rerun=other_run,
            input_values=other_run.inputs(np.array([time])),
        )

    def to_dataframe(self) -> pandas.DataFrame:
        """Return the outputs as a table of pandas, with the time as index and a column for each name.

        ``attrs["units"]`` has the unit of each column.

        Raises:
            MissingExtraError: when pandas (the extra ``pandas``) is not installed.
        """
        return tables.dataframe(self.prepared_scene, self.time, self.columns)

    def to_xarray(self) -> xarray.Dataset:
        """Return the outputs that change continuously as a dataset of xarray, with units.

        Its dimensions are time, point, axis, link and contact. Outputs that ``simulate(output=…)`` left out
        are NaN. A variable, such as ``angle``, is not in the dataset if all its outputs were left out.

        Raises:
            MissingExtraError: when xarray (the extra ``xarray``) is not installed.
        """
        return tables.dataset(self.prepared_scene, self.time, self.continuous_columns)

    def impact_table(self) -> pandas.DataFrame:
        """Return the impacts as a table of pandas: columns as in ``IMPACT_DTYPE``; ``wall`` has the name.

        The column ``wall_name`` is left out. The rows count from 1. ``attrs["units"]`` has the unit of each
        column that has one; if joints have stops, ``attrs["units_at_stops"]`` has the units for impacts at
        these stops.

        Raises:
            MissingExtraError: when pandas (the extra ``pandas``) is not installed.
        """
        return tables.impact_table(self.impacts, self.wall_names, has_stops=bool(self.stops))

    def stick_slip_table(self) -> pandas.DataFrame:
        """Return the phases of dry friction as a table of pandas, with words for wall and mode.

        The columns are those of ``STICK_SLIP_DTYPE``, with "" as the wall of a joint or slider.

        The rows count from 1. ``attrs["units"]`` has the units of start and end.

        Raises:
            MissingExtraError: when pandas (the extra ``pandas``) is not installed.
        """
        return tables.stick_slip_table(self.stick_slip, self.wall_names)

    def _lines_and_tables(self, *, in_notebook: bool) -> Iterable[str | TextTable]:
        """Return the summary of the run, with the first impacts; with more of them in a notebook."""
        listed_count = summary.LISTED_IMPACTS if in_notebook else summary.LISTED_IN_SHORT
        return summary.summary_lines(self, len(self.names), self._facts(), listed_count)

    def _facts(self) -> list[str]:
        """Return lines on the energy, on a wall or slider stop that is too soft, and on the solver's work."""
        facts = [f"note     {hint}" for hint in summary.penetration_hints(self.scene, self.impacts)]
        return [*summary.energy_lines(self.energies), *facts, *summary.solver_lines(self.statistics)]

    def _stacked_outputs(self, field: str) -> np.ndarray:
        """Return a field of ``output_dtype`` (kernel/record/instance.py) at all times, shape (T, …).

        Raises:
            UnknownNameError: when the result lacks an output of the field, or the scene has none.
        """
        if field in (self.outputs.dtype.names or ()):
            return self.outputs[field]
        parts = [v for v in self.prepared_scene.continuous_outputs if v.field == field]
        if not parts:
            raise UnknownNameError(self.scene.name, field, self.names, "not an output of the scene")
        values = np.stack([self[variable.name] for variable in parts], axis=-1)
        return values.reshape(len(self.time), *(step + 1 for step in parts[-1].index))
