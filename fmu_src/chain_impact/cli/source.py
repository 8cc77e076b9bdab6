"""The source of a command: a scene or an FMU, with the values and inputs that the options of the command set.

A command can simulate the source, rank its parameters, and compare a run with a second one at a tighter
tolerance.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path

from chain_impact.cli.completers import is_fmu
from chain_impact.cli.options import UsageError, load_scene_with, settings_of
from chain_impact.cli.printing import complain
from chain_impact.cli.progress_bar import progress
from chain_impact.fmu.importer import read_fmu
from chain_impact.fmu.inputs import InputTable
from chain_impact.fmu.run import record_fmu
from chain_impact.recording.recording import Recording
from chain_impact.results.ranking import Ranking
from chain_impact.scene.errors import SceneError, SceneWarning
from chain_impact.scene.keys.tables import Solver
from chain_impact.scene.scene import Scene, load_scene
from chain_impact.scene.settings import parsed_value, with_settings
from chain_impact.scene.texts.input_table import input_key
from chain_impact.simulation.errors import RunError, SimulationError
from chain_impact.simulation.simulate import simulate
from chain_impact.studies.accuracy import TOLERANCE_RATIO, Differences, differences
from chain_impact.variables.peaks import JOINT_FORCE

# a scene is simulated again for a picture of the motion if the first run has fewer rows
LEAST_MOTION_ROWS = 1000
TOLERANCE = "solver.tolerance"


@dataclass(frozen=True)
class Source:
    """A scene or an FMU, with settings and a table of inputs.

    Attributes:
        name: the name of a model, or the file of a scene or an FMU.
        settings: texts ``NAME=VALUE``, as of ``--set``.
        inputs: the table of inputs with its interpolation; None without a table.
    """

    name: str
    settings: Sequence[str] = ()
    inputs: InputTable | None = None

    @property
    def is_fmu(self) -> bool:
        """Whether the source is an FMU."""
        return is_fmu(self.name)

    @property
    def files(self) -> list[str | Path]:
        """The name of the source and, if there is one, the file of the table of inputs."""
        return [self.name, *([self.inputs.file] if self.inputs else [])]

    def scene(self) -> Scene:
        """Return the scene with the settings and inputs; the source must not be an FMU."""
        return load_scene_with(self.name, self.settings, self.inputs)

    def record(self, sensitivities: Sequence[str] = ()) -> Recording:
        """Simulate the source, and return the recording of the run.

        ``sensitivities`` are names or patterns of the parameters and inputs with respect to which derivatives
        are computed; by default those that the scene asks for. With an FMU, which has only the derivatives
        for which it was built, ``sensitivities`` are refused.
        """
        if sensitivities and self.is_fmu:
            raise UsageError(f"--sensitivity: {self.name} is an FMU; must be a scene")
        with progress() as advance:
            if self.is_fmu:
                return record_fmu(Path(self.name), settings_of(self.settings), advance, self.inputs)
            return simulate(self.scene(), sensitivities=sensitivities or None, progress=advance)

    def with_enough_rows(self, recording: Recording) -> Recording:
        """Return ``recording`` if it has LEAST_MOTION_ROWS rows, else the recording of a new run.

        An FMU is not simulated again: ``recording`` is returned, and a message tells that its rows are few.
        """
        rows = len(recording.time)
        if rows >= LEAST_MOTION_ROWS:
            return recording
        if self.is_fmu:
            complain(
                f"the picture has {rows} poses only, one each communication step, and cannot show "
                "the motion between them; --set simulation.step_size=… makes more"
            )
            return recording
        scene = self.scene()
        with progress() as advance:
            return simulate(
                scene, output_step=scene.simulation.stop_time / LEAST_MOTION_ROWS, progress=advance
            )

    def ranking(self, quantity: str, parameters: Sequence[str]) -> Ranking:
        """Return the ranking of ``parameters``, by default of all, by the change of ``quantity``.

        The scene is simulated with rows at the start and the end only, because the ranking needs no rows
        between, and with the forces in joints if ``quantity`` is the largest of these. The result is checked
        by runs with changed values (``Ranking.checked``). An FMU is refused.
        """
        if self.is_fmu:
            raise UsageError(f"--rank: {self.name} is an FMU; must be a scene")
        scene = self.scene()
        scene = scene.with_values({"outputs.loads": True}) if quantity == JOINT_FORCE else scene
        with progress() as advance:
            result = simulate(
                scene,
                output_step=scene.simulation.stop_time,
                sensitivities=parameters or ["*"],
                progress=advance,
            )
        return result.ranking(quantity, parameters or "*").checked(partial(_changed_run, scene))

    def units(self) -> Mapping[str, str]:
        """Return name → unit of each variable of the FMU that is the source; "" for no unit."""
        return {variable.name: variable.unit or "" for variable in read_fmu(Path(self.name)).modelVariables}

    def with_less_tolerance(self) -> Source:
        """Return this source with a tenth of its tolerance ``solver.tolerance``.

        Raises:
            UsageError: when the tenth is below the least tolerance, an FMU has no such parameter, or its
                value is set to a text that is no number.
        """
        tolerance, key = self._tolerance(), TOLERANCE.partition(".")[2]
        least_tolerance = next(field.metadata["minimum"] for field in fields(Solver) if field.name == key)
        if TOLERANCE_RATIO * tolerance < least_tolerance:
            raise UsageError(
                f"--check: {TOLERANCE} = {tolerance:g} leaves no tighter one; must be at least "
                f"{least_tolerance / TOLERANCE_RATIO:g}"
            )
        return Source(
            self.name, [*self.settings, f"{TOLERANCE}={TOLERANCE_RATIO * tolerance!r}"], self.inputs
        )

    def _tolerance(self) -> float:
        values = settings_of(self.settings)
        if not self.is_fmu:
            return with_settings(load_scene(self.name), values).solver.tolerance
        starts = {variable.name: variable.start for variable in read_fmu(Path(self.name)).modelVariables}
        if TOLERANCE not in starts:
            raise UsageError(f"--check: {self.name} has no parameter {TOLERANCE}")
        tolerance = parsed_value(values.get(TOLERANCE, starts[TOLERANCE]))
        if not isinstance(tolerance, int | float):
            raise UsageError("must be a number", source=self.name, name=TOLERANCE, value=str(tolerance))
        return float(tolerance)

    def differences(self, recording: Recording) -> Differences:
        """Simulate this source, from ``with_less_tolerance``; return how the run differs from a recording."""
        return differences(recording, self.record())


def recorded_until_fault(record: Callable[[], Recording]) -> tuple[Recording, RunError | None]:
    """Return the recording that ``record`` makes, and None.

    If a fault ends the run after its start, the recording is that of the time before the fault, and the error
    is returned with it.
    """
    try:
        return record(), None
    except RunError as error:
        if error.recording is None:
            raise
        return error.recording, error


def _changed_run(scene: Scene, name: str, value: float) -> Recording | None:
    """Return a run of a scene with another ``value`` of the parameter or input ``name``.

    An input has the value during the whole run. The result is None if the scene refuses the value, or if
    the run ends with a fault.
    """
    inputs = {name: value} if input_key(name) else {}
    try:
        with warnings.catch_warnings():
            # the user has seen the warnings of the scene, and has not chosen ``value``, of which others warn
            warnings.simplefilter("ignore", SceneWarning)
            scene = scene if inputs else scene.with_values({name: value})
            return simulate(scene, inputs=inputs, output_step=scene.simulation.stop_time)
    except (SceneError, SimulationError):
        return None
