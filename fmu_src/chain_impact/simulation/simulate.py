"""Simulate a scene in this process, with the compiled kernel that its FMU would carry."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Iterable, Mapping
from functools import cached_property
from pathlib import Path

import numpy as np

from chain_impact.compilation import cache
from chain_impact.compilation.law_file import LawError, parse_law, source_of
from chain_impact.compilation.work import Notify, Progress, silent
from chain_impact.kernel.status import OK
from chain_impact.results.result import Result
from chain_impact.results.sensitivity import Sensitivities
from chain_impact.results.stick_slip import NO_PHASES, phases_of
from chain_impact.results.summary import hints
from chain_impact.scene.checks import warn
from chain_impact.scene.reading import SceneError
from chain_impact.scene.scene import Scene, SceneSource, scene_of, with_values
from chain_impact.simulation.derivatives import DifferentiatedInstance, RowsWithSlopes
from chain_impact.simulation.inputs import Drive, Interpolation, Signal, drive
from chain_impact.simulation.instance import (
    CHUNK_ROWS,
    Instance,
    OutputRows,
    Rows,
    SimulationError,
    in_order,
)
from chain_impact.variables.model import Model, model_of
from chain_impact.variables.table import WORD, word_index
from chain_impact.variables.variable import Variable

MOST_BYTES = 2_000_000_000
"""Most bytes that the outputs of a simulation may take: more is refused before anything is computed."""


def simulate(
    scene: SceneSource,
    stop_time: float | None = None,
    output_step: float | None = None,
    method: str | None = None,
    tolerance: float | None = None,
    *,
    output: str | Iterable[str] | None = None,
    inputs: Mapping[str, Signal] | None = None,
    interpolation: Interpolation = "follow",
    sensitivities: Iterable[str] | None = None,
    notify: Notify | None = None,
    progress: Progress | None = None,
) -> Result:
    """Simulate a scene from t = 0.

    Inputs act by their ``interpolation``. Communication points are the rows of the result and, between them,
    the times of samples.

    - ``follow``: the solver follows a function between communication points, too, to its tolerance. It finds
      jumps and kinks; a pulse shorter than a two-thousandth of the run can be missed. A sample acts from its
      time on until the next one, so that a signal of steps is followed exactly.
    - ``hold``: a function is called at each communication point, and its value acts until the next, as an
      FMU has it that is stepped between them. Samples act as with ``follow``.
    - ``linear``: samples, and a function's values at communication points, are joined by straight lines,
      which the solver follows.

    The first sample acts before its time, too, and the last one until the end. A row of the result has the
    accelerations and forces that the inputs until then cause, as an importer sees them that reads the FMU
    after each step. Functions are called before the simulation begins: they cannot depend on its state. For
    a controller, step a ``Chain``, or connect one to the FMU.

    Args:
        scene: what to simulate: a scene, or what ``load_scene`` takes.
        stop_time: end [s]; the scene's by default.
        output_step: distance of the rows of the result [s]; the scene's communication step by default. It
            changes neither the solution nor its cost, but for functions that are not followed. With
            ``math.inf`` there are two rows, the start and the end.
        method: solver method instead of the scene's.
        tolerance: relative tolerance instead of the scene's.
        output: the outputs of the result, by their names in the FMU, in which ``*`` stands for
            any text: ``["point[4].x", "energy.*"]``; all by default, none if empty. All rows together take
            at most ``MOST_BYTES``. The impacts are always all there.
        inputs: name of an input of the scene's FMU, as ``joint[2].torque`` [N·m] or ``tip.force.x`` [N] →
            a number, a function of the time [s], or a pair (times [s], values), each of shape (T,), times
            increasing. An input that is not named is zero.
        interpolation: of inputs, ``follow``, ``hold`` or ``linear``.
        sensitivities: parameters and inputs by their names in the FMU, ``*`` as in ``output``: the result
            then has the derivatives of its outputs and impacts with respect to each of them, for
            ``Result.sensitivity``. The motion is the same, bit for bit. That with respect to an input is for
            a constant added to it. By default they are those of the scene's ``outputs.sensitivities``.
        notify: called with a sentence before a kernel is compiled; by default that is said on standard error.
        progress: called with the fraction done, if given.

    Warns:
        SceneWarning: when a point goes farther beyond a wall than the shortest link is long.

    Raises:
        SceneError: when one of the arguments is outside its range, or the result would be too large.
        SimulationError: when the solver cannot go on; it holds the result up to there.
        BuildError: when the kernel cannot be compiled.
    """
    settings = {
        "simulation.stop_time": stop_time,
        "simulation.step_size": None if output_step == math.inf else output_step,
        "solver.method": method,
        "solver.tolerance": tolerance,
    }
    changes = {name: value for name, value in settings.items() if value is not None}
    scene = with_values(scene, changes) if changes else scene_of(scene)
    stop = scene.simulation.stop_time
    step = stop if output_step == math.inf else scene.simulation.step_size
    model = Model(scene)
    varied = model.varied if sensitivities is None else model.varied_by(sensitivities)
    chosen = None if output is None else model.outputs_named(output)
    words = None
    if chosen is not None:
        observed = [one for one in chosen if one.place[0] == "output"]
        words = {one.name: word_index(model.row, one.place[1:]) for one in observed}
    columns = (model.row.itemsize // WORD if words is None else len(words)) * (1 + len(varied))
    check_size(scene.name, stop, step, columns)
    driven = drive(model, inputs or {}, interpolation, _times(stop, step))
    if inputs:
        _check_rows(f"{scene.name}: the simulation with its inputs has", len(driven.times), columns)
    stepwise = Stepwise(model, driven, chosen)  # before the run, which may take long
    outputs = OutputRows(len(driven.times), model.row, words)
    rows: Rows = outputs
    differentiated = None
    if varied:
        differentiated = DifferentiatedInstance(model, varied, outputs.words, notify, driven)
        rows = slopes = RowsWithSlopes(outputs.numbers, len(varied))
    instance = differentiated or Instance(model, notify, driven, ())
    done, impacts = instance.run(driven, rows, progress or silent)
    order, found = in_order([*impacts, instance.open_contacts()])
    asked = slice(done) if driven.asked.all() else np.flatnonzero(driven.asked[:done])
    sensitive = None
    if differentiated:
        sensitive = Sensitivities(
            model=model,
            varied=varied,
            chosen=None if words is None else tuple(words),
            slopes=slopes.slopes[asked],
            impacts=found,
            impact_slopes=differentiated.slopes_of_impacts(order),
            limits=differentiated.limits,
        )
    result = Result(
        model=model,
        time=driven.times[asked],
        outputs=outputs.kept[asked],
        impacts=found,
        statistics=instance.statistics,
        sensitivities=sensitive,
        stepwise=stepwise,
        stick_slip=phases_of(instance.all_changes) if instance.changes else NO_PHASES,
    )
    # few runs are so deep that there may be something to say
    if found["max_penetration"].max(initial=0.0) > min([link.length for link in scene.chain.links]):
        warn(scene.name, hints(result))
    if instance.status != OK:
        raise SimulationError(instance.status, instance.time, result, instance.place)
    return result


def check_size(source: str, stop: float, step: float, columns: int) -> None:
    """Refuse a result whose outputs take more than ``MOST_BYTES``.

    Args:
        source: of the error.
        stop: stop time [s].
        step: distance of the rows [s].
        columns: number of outputs.

    Raises:
        SceneError: when it would be too large.
    """
    asked = f"simulation.stop_time = {stop:g} [s] in steps of simulation.step_size = {step:g} [s]"
    _check_rows(f"{source}: {asked} gives", stop / step + 1.0, columns)


def _check_rows(what: str, count: float, columns: int) -> None:
    """Refuse so many rows of outputs if they are too large, in a sentence that begins with what has them."""
    size = count * WORD * (1 + columns)  # the time, too
    if not size <= MOST_BYTES:
        rows = f"{count:.4g} rows of {columns} outputs, {size / 1e9:.4g} GB"
        limit = f"must be at most {MOST_BYTES / 1e9:g} GB: take longer steps, an earlier end or fewer outputs"
        raise SceneError(f"{what} {rows}; {limit}")


def _times(stop: float, step: float) -> np.ndarray:
    """The multiples of the step below the stop time, and that [s]: the last step may be shorter."""
    times = np.arange(np.ceil(stop / step * (1 - 1e-12)) + 1.0)
    times *= step
    times[-1] = stop
    return times


class _StepwiseRows:
    """Words of the record at each communication point, which the kernel's own rows do not have."""

    at_once = CHUNK_ROWS

    def __init__(self, count: int, words: np.ndarray, layout: np.dtype) -> None:
        self.kept, self._words, self._scratch = np.zeros((count, len(words))), words, np.zeros(1, layout)

    def fill(self, instance: Instance, times: np.ndarray, start: int) -> int:
        """See ``Rows``."""
        record = instance.words
        for k in range(len(times)):
            if not instance.trajectory(times[k : k + 1], self._scratch):
                return k
            record.take(self._words, out=self.kept[start + k])
        return len(times)


class Stepwise:
    """The outputs that change at events and steps only, from a second run when they are asked for."""

    def __init__(self, model: Model, driven: Drive, chosen: Iterable[Variable] | None) -> None:
        """Keep what is about to be run, and the outputs that were chosen, None for all."""
        self._model, self._driven, self._chosen = model, driven, chosen
        self._law = _law_text(model.scene) if model.scene.contact.law_file else None

    @cached_property
    def _variables(self) -> list[Variable]:
        return stepwise_outputs(self._model, self._chosen)

    @property
    def names(self) -> tuple[str, ...]:
        """Of these outputs."""
        return tuple(variable.name for variable in self._variables)

    def columns(self, notify: Notify | None = None, progress: Progress = silent) -> dict[str, np.ndarray]:
        """Run once more, row by row: name → shape (T,).

        ``notify`` and ``progress`` as for ``simulate``.

        Raises:
            SceneError: when they would be too large, or the file of the contact law has changed.
            BuildError: when the kernel cannot be compiled.
        """
        if not self.names:
            return {}
        scene, driven, second = self._model.scene, self._driven, f"a second run for {self.names[0]}"
        _check_rows(f"{scene.name}: {second} has", len(driven.times), len(self.names))
        if self._law is not None and _law_text(scene) != self._law:
            raise SceneError(
                f"{scene.name}: contact.law_file = {scene.contact.law_file!r} has changed since the "
                f"simulation, so that {second} would give another motion: simulate again"
            )
        instance = Instance(self._model, notify, driven, ())
        dtype = instance.record.dtype
        words = np.array([word_index(dtype, one.place) for one in self._variables], int)
        rows = _StepwiseRows(len(driven.times), words, self._model.row)
        done, _ = instance.run(driven, rows, progress)
        kept = rows.kept[:done][driven.asked[:done]].T.copy()
        return {
            one.name: column if one.type == "real" else column.view(np.int64)
            for one, column in zip(self._variables, kept, strict=True)
        }


def stepwise_outputs(source: Scene | Model, chosen: Iterable[Variable] | None = None) -> list[Variable]:
    """Those of the chosen outputs, None for all, that only a second run knows."""
    chosen = model_of(source).outputs if chosen is None else chosen
    return [one for one in chosen if one.place[0] != "output"]


def _law_text(scene: Scene) -> bytes:
    """What is in the file of the contact law; nothing if it cannot be read."""
    try:
        return Path(scene.contact.law_file).read_bytes()
    except OSError:
        return b""


def with_law(scene: SceneSource, law: Callable[..., float]) -> Scene:
    """Return the scene with a Python function as its contact law.

    Args:
        scene: a scene, or what ``load_scene`` takes.
        law: a function that returns the force [N], as in a ``contact.law_file``. Its source, which has to be
            known, is kept as a file in the cache folder, which ``Fit.save`` copies to the scene that it
            writes. It knows the module ``math`` and nothing else that is defined outside it.

    Raises:
        SceneError: when it cannot be a law.
    """
    scene = scene_of(scene)
    try:
        source = source_of(law)
        parse_law(law.__name__, source)
    except LawError as error:
        raise SceneError(f"{scene.name}: the contact law {law!r} {error}") from None

    def write(folder: Path) -> None:
        folder.mkdir()
        (folder / f"{law.__name__}.py").write_text(source, encoding="utf-8")

    digest = hashlib.sha256(source.encode()).hexdigest()[:16]
    file = cache.made(f"law-{digest}", write) / f"{law.__name__}.py"
    return scene.with_values({"contact.law_file": str(file), "contact.model": law.__name__})
