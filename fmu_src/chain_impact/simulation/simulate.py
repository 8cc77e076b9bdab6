"""The simulation of a scene in this process, with the same kernel as in the scene's FMU.

The twin in JavaScript is pages/browser/solver/kernel.js.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from chain_impact.compilation import cache
from chain_impact.kernel.record.fields import WORD
from chain_impact.kernel.status import OK
from chain_impact.progress import Progress, no_progress
from chain_impact.recording.sensitivity import EXPONENTS
from chain_impact.recording.summary import penetration_hints, smallest_body
from chain_impact.results.result import Result
from chain_impact.scene.errors import SceneError
from chain_impact.scene.keys.tables import STEP_ROUND_OFF
from chain_impact.scene.scene import Scene, SceneSource, scene_of, with_values
from chain_impact.scene.texts.input_table import exclusive_inputs
from chain_impact.scene.warning import warn
from chain_impact.simulation.errors import SimulationError
from chain_impact.simulation.given_inputs import GivenInputs, Interpolation, NamedInputs, named_inputs
from chain_impact.simulation.input_schedule import InputSchedule, input_schedule
from chain_impact.simulation.instance import Instance
from chain_impact.simulation.output_rows import chosen_columns
from chain_impact.simulation.run import Run
from chain_impact.user_laws.law_file import LawError, parse_law, source_of
from chain_impact.variables.prepared import PreparedScene
from chain_impact.variables.selection import differentiable_named

MOST_BYTES = 2_000_000_000
"""[byte] the largest size of the outputs of a simulation; a larger result is refused before the run."""


def simulate(
    scene: SceneSource,
    stop_time: float | None = None,
    output_step: float | None = None,
    method: str | None = None,
    tolerance: float | None = None,
    *,
    output: str | Iterable[str] | None = None,
    inputs: GivenInputs | None = None,
    interpolation: Interpolation = "follow",
    sensitivities: Iterable[str] | None = None,
    progress: Progress | None = None,
) -> Result:
    """Simulate a scene from t = 0.

    The ``interpolation`` says how an input acts that is given as a function of the time or as samples.
    Communication points are the times of the rows of the result and the times of samples.

    - ``follow``: the solver follows a function with the accuracy of the solver's tolerance, also between
      communication points, and finds jumps and kinks. A pulse shorter than a two-thousandth of the run can
      be missed. A sample acts from its time until the time of the next sample, so a signal of steps is
      followed exactly.
    - ``hold``: a function is called at each communication point, and its value acts until the next
      communication point, as in an FMU. Samples act as with ``follow``.
    - ``linear``: samples, and a function's values at communication points, are joined by straight lines,
      which the solver follows.
    - ``spline``: functions act as with ``follow``; samples of any input are joined by a cubic spline.

    For a moving base or wall, the inputs are its position, velocity or acceleration. Their samples are joined
    by a cubic spline, or by straight lines with ``linear``, because the motion must not jump. The spline of a
    position is at rest at its first and last sample if these are within the run. If the position is given, it
    alone determines the motion; a given velocity or acceleration is only compared with it. With ``hold`` the
    base or wall moves as in an FMU (docs/drive.md).

    The first sample also acts before its time, and the last sample acts until the end. A row of the result
    has the accelerations and forces that the inputs before its time cause, as an importer reads them after a
    step of the FMU. Functions are called before the simulation begins, so they cannot depend on its state.
    For a controller, step a ``Chain``, or connect a controller to the FMU.

    Args:
        scene: a scene, or an argument of ``load_scene``.
        stop_time: end of the run [s]; by default the scene's stop time.
        output_step: time between the rows of the result [s]; by default the scene's communication step. The
            output step changes neither the solution nor the cost, except with functions under ``hold`` or
            ``linear``, and with motions under ``hold``. With ``math.inf`` there are two rows, the start and
            the end.
        method: solver method instead of the scene's.
        tolerance: relative tolerance instead of the scene's.
        output: the outputs of the result, by their names in the FMU, in which ``*`` stands for any text:
            ``["point[4].x", "energy.*"]``; all outputs by default, none for an empty list. All rows together
            take at most ``MOST_BYTES``. The result always has all impacts. Inputs that ``inputs`` gives are
            chosen in the same way.
        inputs: name of an input of the scene's FMU, as ``joint[2].torque`` [N·m] or ``tip.force.x`` [N] → a
            number, a function of the time [s], or a pair (times [s], values), each of shape (T,), times
            increasing. Of the inputs that are not named, a target is the spring's rest angle or position, a
            base stays at its initial position, and any other input is zero. A table of samples is allowed as
            well: a CSV or Parquet file, a table of pandas or polars, or columns, with the column ``time`` and
            one for each input.
        interpolation: how inputs act: ``follow``, ``hold``, ``linear`` or ``spline``.
        sensitivities: parameters and inputs by their names in the FMU, ``*`` as in ``output``: the result
            then has the derivatives of its outputs and impacts with respect to each of them, for
            ``Result.sensitivity``. The motion is the same, bit for bit. The derivative with respect to an
            input is the derivative with respect to a constant that is added to the input. The default is the
            scene's ``outputs.sensitivities``.
        progress: called with the finished fraction, 0 to 1, if given.

    Warns:
        SceneWarning: when a point goes farther beyond a wall than half the length of the shortest
            link, or a ball than its radius; when inputs give a motion that contradicts itself; when the
            target of a drive with damping moves and its velocity is not given; or when a table of inputs
            seems to lack rows.

    Raises:
        SceneError: when the scene or an argument is invalid, or the result would be too large.
        SimulationError: when the solver cannot continue; the error holds the result up to this time, or None
            if the scene cannot start.
        BuildError: when the kernel cannot be compiled.
    """
    is_single_interval = output_step == math.inf
    settings = {
        "simulation.stop_time": stop_time,
        "simulation.step_size": None if is_single_interval else output_step,
        "solver.method": method,
        "solver.tolerance": tolerance,
    }
    prepared_scene = _with_settings(scene, settings)
    names = prepared_scene.scene.outputs.sensitivities if sensitivities is None else sensitivities
    wanted_names = (names,) if isinstance(names, str) else tuple(names)
    parameters = differentiable_named(prepared_scene, wanted_names)
    exponents = [variable.name for variable in parameters if variable.name in EXPONENTS]
    pattern_exponents = tuple(name for name in exponents if name not in wanted_names)
    given_inputs = named_inputs(inputs, interpolation, prepared_scene.scene)
    indices, input_names = chosen_columns(
        prepared_scene, output, _possible_columns(prepared_scene, given_inputs)
    )
    column_count = len(indices.words) + indices.width * len(parameters)
    schedule = _inputs_of_run(prepared_scene, given_inputs, is_single_interval, column_count)
    run = Run(prepared_scene, parameters, schedule, indices, pattern_exponents)
    run.execute(progress or no_progress)
    result = run.result(input_names, None if output is None else tuple(indices.continuous))
    _warn(run.instance, result)
    if (status := run.instance.status) != OK:
        raise SimulationError(status, run.instance.time, result, run.instance.part, result.scene.name)
    return result


def _with_settings(scene: SceneSource, settings: Mapping[str, Any]) -> PreparedScene:
    """Return the prepared scene with the ``settings``, name → value; a value None is not set."""
    changes = {name: value for name, value in settings.items() if value is not None}
    return PreparedScene(with_values(scene, changes) if changes else scene_of(scene))


def _possible_columns(prepared_scene: PreparedScene, inputs: NamedInputs) -> list[str]:
    """Return the names of the inputs that the result can have: the given ones, and those that follow.

    Of a motion of the base or a wall, position, velocity and acceleration follow from any one of them, except
    with ``hold``.
    """
    known_names = {variable.name for variable in prepared_scene.inputs} if inputs.sources else {}
    given_names = [name for name in inputs.sources if name in known_names]
    if inputs.interpolation == "hold":
        return given_names
    return [member for name in given_names for member in exclusive_inputs(name)]


def _inputs_of_run(
    prepared_scene: PreparedScene,
    inputs: NamedInputs,
    is_single_interval: bool,
    columns: int,
) -> InputSchedule:
    """Return the inputs over time, with the times of the rows; refuse a result that would be too large.

    Args:
        prepared_scene: the scene.
        inputs: the inputs that are given.
        is_single_interval: whether the run is one interval, with rows at start and end only; else each step
            of communication gives a row.
        columns: number of outputs and derivatives.
    """
    name, stop_time = prepared_scene.scene.name, prepared_scene.scene.simulation.stop_time
    step = stop_time if is_single_interval else prepared_scene.scene.simulation.step_size
    check_result_size(name, stop_time, step, columns)
    schedule = input_schedule(prepared_scene, inputs, _row_times(stop_time, step))
    if schedule.paths and not _size_of_rows(len(schedule.times), columns) <= MOST_BYTES:
        raise _too_large(f"{name}: the simulation with its inputs has", len(schedule.times), columns)
    return schedule


def _warn(instance: Instance, result: Result) -> None:
    """Warn of a point deeper in walls than ``BodySize.deep``, and of positions that contradict velocities."""
    scene = result.scene
    # ``penetration_hints`` takes long, and is empty unless a point is deeper in a wall than ``BodySize.deep``
    if instance.record["peaks"]["penetration"] > smallest_body(scene).deep:
        warn(scene.name, penetration_hints(scene, result.impacts))
    if result.prepared_scene.counts.channel_count and instance.record["channel"]["contradiction"]:
        warn(scene.name, instance.contradictions)


def check_result_size(source: str, stop_time: float, step: float, columns: int) -> None:
    """Refuse a result whose outputs take more than ``MOST_BYTES``.

    Args:
        source: the name of the scene in an error.
        stop_time: stop time [s].
        step: time between the rows [s].
        columns: number of outputs and derivatives, without the time.

    Raises:
        SceneError: when the result would be too large.
    """
    count = stop_time / step + 1.0
    if not _size_of_rows(count, columns) <= MOST_BYTES:
        asked_text = (
            f"simulation.stop_time = {stop_time:g} [s] in steps of simulation.step_size = {step:g} [s]"
        )
        raise _too_large(f"{source}: {asked_text} gives", count, columns)


def _size_of_rows(count: float, columns: int) -> float:
    """Return the size of ``count`` rows [byte], each with the time and ``columns`` other numbers."""
    return count * WORD * (1 + columns)


def _too_large(subject: str, count: float, columns: int) -> SceneError:
    """Return the error for rows of outputs that need too much memory.

    The text ``subject`` begins the message of the error.
    """
    rows_text = f"{count:.4g} rows of {columns} outputs, {_size_of_rows(count, columns) / 1e9:.4g} GB"
    requirement = (
        f"must be at most {MOST_BYTES / 1e9:g} GB: take longer steps, an earlier end or fewer outputs"
    )
    return SceneError(f"{subject} {rows_text}; {requirement}")


def _row_times(stop_time: float, step: float) -> np.ndarray:
    """Return the times of rows [s]: multiples of the step below the stop time, and the stop time."""
    times = np.arange(math.ceil(stop_time / step * (1 - STEP_ROUND_OFF)) + 1.0)
    times *= step
    times[-1] = stop_time
    return times


def with_law(scene: SceneSource, law: Callable[..., float]) -> Scene:
    """Return the scene with a Python function as its contact law.

    Args:
        scene: a scene, or an argument of ``load_scene``.
        law: a function that returns the force [N], as in a ``contact.law_file``. Python must know its source,
            which is stored as a file in the cache folder; ``Fit.save`` copies this file to the folder of the
            scene file. The function may use its own names, ``math`` and FUNCTIONS (law_syntax.py) only.

    Raises:
        SceneError: when the function is not allowed as a law.
        BuildError: when the source cannot be stored in the cache folder.
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
    file = cache.get_or_make(f"law-{digest}", write) / f"{law.__name__}.py"
    return scene.with_values({"contact.law_file": str(file), "contact.model": law.__name__})
