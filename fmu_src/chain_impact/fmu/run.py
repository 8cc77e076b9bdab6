"""The run of an FMU of a chain, with parameters set by name; the result is a recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from numbers import Integral, Real
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from chain_impact.fmu.importer import read_fmu, run_with_fmpy
from chain_impact.fmu.inputs import input_rows_for
from chain_impact.fmu.scene_data import SceneData, read_scene_data
from chain_impact.kernel.record.constants import WALLS
from chain_impact.progress import Progress, no_progress
from chain_impact.recording.impacts import shown_impacts
from chain_impact.recording.joint_stops import ranges_of
from chain_impact.recording.recording import Recording, StoredRecording
from chain_impact.recording.stick_slip import phases_from
from chain_impact.scene.errors import SceneError, UnknownNameError
from chain_impact.scene.half_planes import HalfPlane, half_planes
from chain_impact.scene.settings import parsed_value
from chain_impact.scene.texts.angles import or_degrees, radians_of
from chain_impact.scene.texts.input_table import input_key
from chain_impact.scene.texts.names import SLIDER_STOPS, STOPS, fmu_name, grouped_by_owner
from chain_impact.scene.texts.parameter_hints import input_hint, signal_hint, start_hint
from chain_impact.scene.texts.similar_names import nearest_text
from chain_impact.simulation.errors import RunError
from chain_impact.simulation.simulate import check_result_size
from chain_impact.variables.parameters import SIMULATION_KINDS

EXPERIMENT_SETTINGS = tuple(kind.name for kind in SIMULATION_KINDS)
"""Names of the values of an FMU's default experiment that can be set like parameters: stop time, step
size."""


def record_fmu(
    path: str | Path,
    settings: Mapping[str, Any] = MappingProxyType({}),
    progress: Progress | None = None,
    inputs: tuple[Path, str | None] | None = None,
) -> Recording:
    """Simulate an FMU with fmpy, with parameters set by name.

    Args:
        path: the FMU.
        settings: name → value, or the text of a value. A name is a parameter, or ``simulation.stop_time`` or
            ``simulation.step_size``, which replace the values of the FMU's default experiment. A contact law
            or a solver method is given by its name or its number.
        progress: called with the finished fraction, 0 to 1, if given.
        inputs: the file of a table of inputs, and the interpolation of its rows: ``hold``, ``linear`` or
            ``spline``, or None for the usual interpolation of each input. Derivatives and integrals of
            inputs are computed from the table as in a scene. An FMU gets its inputs at communication points
            only.

    Raises:
        SceneError: when the file is not an FMU of a chain, a name is unknown, a value is not allowed, or the
            table cannot drive the FMU.
        RunError: when the FMU has no binary for this machine, or reports a fault; if this comes after the
            first step, the error has the recording up to the fault.
        OSError: when a file cannot be read.
    """
    path, show = Path(path), progress or no_progress
    description, data = _checked_description(path), read_scene_data(path)
    parameters, outputs = _parameters(description), _outputs(description)
    experiment, start_values = _settings(path, description.defaultExperiment, parameters, settings)
    stop_time, step_size = experiment
    check_result_size(str(path), stop_time, step_size, len(outputs))
    values = {name: float(start_values.get(name, variable.start)) for name, variable in parameters.items()}
    used_description, input_rows = description, None
    if inputs:
        used_description, input_rows = input_rows_for(description, *inputs, experiment, values)
    recording = partial(_recording, description, data, variables=parameters, outputs=outputs, values=values)
    # holds fmpy's recorder after the first step, so that the rows up to a fault can be returned
    recorders: list[Any] = []

    def step_finished(time: float, recorder: Any) -> bool:
        recorders[:] = [recorder]
        show(time / stop_time)
        return True

    try:
        rows = run_with_fmpy(
            path,
            used_description,
            start_values=start_values,
            output=[*outputs, *data.rules],
            stop_time=stop_time,
            output_interval=step_size,
            input=input_rows,
            step_finished=step_finished,
        )
    except RunError as error:
        raise RunError(str(error), recording(recorders[0].result()) if recorders else None) from None
    return recording(rows)


def _checked_description(path: Path) -> Any:
    """Return the model description of an FMU of a chain that has the outputs of points and of energies.

    Any other FMU is refused.
    """
    description = read_fmu(path)
    names = {variable.name for variable in description.modelVariables}
    if "link[1].length" not in names:
        raise SceneError(f"{path}: not the FMU of a chain: it has no variable link[1].length")
    for name, kind in (("point[0].x", "points"), ("energy.total", "energies")):
        if name not in names:
            raise SceneError(f"{path}: has no variable {name}: its scene has outputs.{kind} = false")
    return description


def _parameters(description: Any) -> dict[str, Any]:
    return {
        variable.name: variable
        for variable in description.modelVariables
        if variable.causality == "parameter"
    }


def _outputs(description: Any) -> list[str]:
    """Return the names of the outputs that are scalars; the arrays of FMI 3.0 repeat their values."""
    variables = description.modelVariables
    return [v.name for v in variables if v.causality == "output" and not v.dimensions]


def _settings(
    path: Path, default: Any, parameters: Mapping[str, Any], settings: Mapping[str, Any]
) -> tuple[tuple[float, float], dict[str, float]]:
    """Return stop time and step size [s], and name → start value of each parameter that is set."""
    given_settings = dict(zip(EXPERIMENT_SETTINGS, (default.stopTime, default.stepSize), strict=True)) | dict(
        settings
    )
    values: dict[str, float] = {}
    for typed_name, text in given_settings.items():
        name, value = fmu_name(typed_name), parsed_value(text)
        try:
            is_time = name in EXPERIMENT_SETTINGS
            values[name] = (
                _positive_number(value)
                if is_time
                else _start_value(_known_parameter(name, parameters), value)
            )
        except SceneError as error:
            error.source, error.name = str(path), typed_name
            raise
    stop_time, step_size = (values.pop(name) for name in EXPERIMENT_SETTINGS)
    return (stop_time, step_size), values


def _recording(
    description: Any,
    data: SceneData,
    rows: np.ndarray,
    *,
    variables: Mapping[str, Any],
    outputs: Sequence[str],
    values: Mapping[str, float],
) -> Recording:
    """Return the recording of a run from fmpy's rows of outputs.

    Args:
        description: the model description, in fmpy's form.
        data: the data on the scene beside the variables.
        rows: the rows over time.
        variables: name of a parameter → the parameter in fmpy's form.
        outputs: names of the outputs in ``rows``.
        values: name of a parameter → its value in the run.
    """
    walls, stops = _walls(values), ranges_of(values)
    ends = [stop for stop in SLIDER_STOPS if stop.replace("_", ".") in values]
    names = (*dict.fromkeys((*WALLS, *walls)), *(STOPS if stops else ()), *ends)
    parameters = {name: _named_value(variable, values[name]) for name, variable in variables.items()}
    stored_recording = StoredRecording(
        name=description.modelName,
        time=np.asarray(rows["time"]),
        columns={name: rows[name] for name in outputs},
        impacts=shown_impacts(rows, names),
        walls=walls,
        wall_names=names,
        parameters=parameters | {name: float(rows[name][0]) for name in data.rules},
        stops=stops,
        point_names=data.point_names,
        inputs=tuple(v.name for v in description.modelVariables if v.causality == "input"),
    )
    return replace(
        stored_recording, stick_slip=phases_from(stored_recording.time, stored_recording.interactions, names)
    )


def _walls(values: Mapping[str, float]) -> dict[str, HalfPlane]:
    """Return the walls of an FMU, by name, from the values of its parameters."""
    box = {wall: values[f"box.{wall}"] for wall in WALLS if f"box.{wall}" in values}
    lines = {
        name: (wall["x"], wall["y"], wall["angle"])
        for (owner, _, name), wall in grouped_by_owner(values).items()
        if owner == "wall" and "angle" in wall
    }
    return half_planes(box, lines)


def _named_value(variable: Any, value: float) -> float | str:
    """Return the value of an FMU's parameter; for an enumeration, the name of the choice.

    If no choice has the value, the result is the value as text.
    """
    if variable.type != "Enumeration":
        return value
    return next((item.name for item in variable.declaredType.items if float(item.value) == value), str(value))


def _known_parameter(name: str, parameters: Mapping[str, Any]) -> Any:
    if name not in parameters:
        advice = input_hint(name, "in a table, --inputs FILE")
        signals = {label for owner, _, label in grouped_by_owner(parameters) if owner == "signal"}
        hint = advice if input_key(name) else start_hint(name) or signal_hint(name, signals)
        raise UnknownNameError("", name, [*parameters, *EXPERIMENT_SETTINGS], "not a parameter", hint)
    return parameters[name]


def _positive_number(value: Any) -> float:
    if not _is_number(value) or not 0.0 < value < float("inf"):
        raise SceneError("must be a finite number > 0 [s]", value=str(value))
    return float(value)


def _is_number(value: Any) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def _start_value(variable: Any, value: Any) -> float | int:
    """Return the checked value of a parameter, as fmpy needs it.

    A text such as "30 deg" becomes a number in radians, the name of a choice its number.
    """
    if variable.type == "Enumeration":
        numbers = {item.name: int(item.value) for item in variable.declaredType.items}
        number = numbers.get(value) if isinstance(value, str) else value
        if isinstance(number, Integral) and number in numbers.values() and not isinstance(number, bool):
            return int(number)
        meant_text = nearest_text(value, numbers)
        raise SceneError(f"must be one of {', '.join(numbers)}{meant_text}", value=str(value))
    number = radians_of(value, variable.unit or "")
    if not _is_number(number):
        needed_text = f"a number{or_degrees(variable.unit or '')}"
        raise SceneError(f"must be {needed_text}", value=str(value))
    return float(number)
