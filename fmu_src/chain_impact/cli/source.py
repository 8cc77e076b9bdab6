"""The scene or the FMU of a command, with the values that its options set.

A command can simulate its source, rank the parameters, and compare the run with a run at a tighter tolerance.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

from chain_impact.cli.completers import is_fmu
from chain_impact.cli.options import Inputs, UsageError, scene_with, settings_of
from chain_impact.cli.progress import complain, progress
from chain_impact.fmu.importer import read_fmu
from chain_impact.fmu.run import record_fmu
from chain_impact.recording.recording import Recording
from chain_impact.results.ranking import Ranking
from chain_impact.scene.scene import Scene, load_scene
from chain_impact.scene.tables import Solver
from chain_impact.simulation.record_scene import record_scene, value_of, with_settings
from chain_impact.simulation.simulate import simulate
from chain_impact.studies.accuracy import TIGHTER, Differences, differences

LEAST_ROWS = 1000  # the least number of rows with which a picture is drawn
TOLERANCE = "solver.tolerance"


@dataclass(frozen=True)
class Source:
    """A scene or an FMU, with settings and a table of inputs.

    Attributes:
        name: the name of a scene, or the file of a scene or an FMU.
        settings: texts ``NAME=VALUE``.
        inputs: the table of inputs.
    """

    name: str
    settings: Sequence[str] = ()
    inputs: Inputs | None = None

    @property
    def is_fmu(self) -> bool:
        """Whether the source is an FMU."""
        return is_fmu(self.name)

    @property
    def files(self) -> list[str | Path]:
        """The name of the source, and the file of the table of inputs, if any."""
        return [self.name, *([self.inputs[0]] if self.inputs else [])]

    def scene(self) -> Scene:
        """Return the scene, with its settings and inputs."""
        return scene_with(self.name, self.settings, self.inputs)

    def record(self, sensitivities: Sequence[str] = ()) -> Recording:
        """Simulate; by default the ``sensitivities`` are those that the scene asks for."""
        if sensitivities and self.is_fmu:
            raise UsageError(f"--sensitivity: {self.name} is an FMU; must be a scene")
        with progress() as advance:
            if self.is_fmu:
                return record_fmu(Path(self.name), settings_of(self.settings), advance, self.inputs)
            return record_scene(self.scene(), {}, advance, sensitivities or None)

    def with_rows(self, recording: Recording) -> Recording:
        """Return the recording with enough rows for a picture; if necessary, simulate a scene again.

        The rows of an FMU cannot be changed; a message says so if they are too few.
        """
        rows = len(recording.time)
        if rows >= LEAST_ROWS:
            return recording
        if self.is_fmu:
            complain(
                f"the picture has {rows} poses only, one each communication step, and cannot show "
                "the motion between them; --set simulation.step_size=… makes more"
            )
            return recording
        scene = self.scene()
        with progress() as advance:
            return simulate(scene, output_step=scene.simulation.stop_time / LEAST_ROWS, progress=advance)

    def ranking(self, what: str, parameters: Sequence[str]) -> Ranking:
        """Return the ranking of some parameters, by default of all.

        The scene is simulated with rows at the start and the end only.
        """
        if self.is_fmu:
            raise UsageError(f"--rank: {self.name} is an FMU; must be a scene")
        scene = self.scene()
        rows = {"simulation.step_size": scene.simulation.stop_time}
        with progress() as advance:
            return record_scene(scene, rows, advance, parameters or ["*"]).ranking(what, parameters or "*")

    def units(self) -> Mapping[str, str]:
        """Return the unit of each variable of an FMU."""
        return {variable.name: variable.unit or "" for variable in read_fmu(Path(self.name)).modelVariables}

    def tighter(self) -> Source:
        """Return the source with a tenth of its tolerance.

        Raises:
            UsageError: when the tolerance is too tight to be reduced.
        """
        tolerance, key = self._tolerance(), TOLERANCE.partition(".")[2]
        least = next(field.metadata["minimum"] for field in fields(Solver) if field.name == key)
        if TIGHTER * tolerance < least:
            raise UsageError(
                f"--check: {TOLERANCE} = {tolerance:g} leaves no tighter one; must be at least "
                f"{least / TIGHTER:g}"
            )
        return Source(self.name, [*self.settings, f"{TOLERANCE}={TIGHTER * tolerance!r}"], self.inputs)

    def _tolerance(self) -> float:
        values = settings_of(self.settings)
        if not self.is_fmu:
            return with_settings(load_scene(self.name), values).solver.tolerance
        starts = {variable.name: variable.start for variable in read_fmu(Path(self.name)).modelVariables}
        if TOLERANCE not in starts:
            raise UsageError(f"--check: {self.name} has no parameter {TOLERANCE}")
        return float(value_of(values.get(TOLERANCE, starts[TOLERANCE])))

    def differences(self, recording: Recording) -> Differences:
        """Return how a recording differs from a run of this source, the source from ``tighter``."""
        return differences(recording, self.record())
