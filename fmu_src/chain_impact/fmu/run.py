"""The run of an FMU with parameters set by name, as a recording."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from numbers import Integral, Real
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from chain_impact.fmu.importer import read_fmu, simulated
from chain_impact.fmu.inputs import driven_rows
from chain_impact.kernel.rows.geometry import WALLS
from chain_impact.progress import Progress, silent
from chain_impact.recording.impacts import impacts_shown
from chain_impact.recording.joint_stops import ranges_from
from chain_impact.recording.recording import Recording, StoredRecording
from chain_impact.recording.stick_slip import phases_from
from chain_impact.scene.angles import in_radians, or_degrees
from chain_impact.scene.half_planes import HalfPlane, half_planes
from chain_impact.scene.names import SLIDER_STOPS, STOPS, fmu_name, input_key, signal_hint
from chain_impact.scene.reading import SceneError, UnknownNameError, as_typed, nearest_choice
from chain_impact.simulation.record_scene import RunError, value_of
from chain_impact.simulation.simulate import check_result_size
from chain_impact.variables.variable import UNLESS_SET

POINT_IN_TEXT = re.compile(r"point (\d+) \((\w+)(?:, link \d+)?\)")
"""Regular expression for the number and the name of a point at the start of a variable's description."""
EXPERIMENT = ("simulation.stop_time", "simulation.step_size")
"""Values, in addition to parameters, that can be set for one run of an FMU."""


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
            ``simulation.step_size`` to replace the default experiment. A contact law or a solver method is
            given by its name or number.
        progress: called with the finished fraction, 0 to 1, if given.
        inputs: the file of a table of inputs, and the interpolation of its rows: ``hold``, ``linear`` or
            ``spline``; None for the default of each input. Derivatives follow from the inputs in the table,
            as in a scene. An FMU gets its inputs at communication points only.

    Raises:
        SceneError: when the file is not an FMU of a chain, a name is unknown or a value is not a number.
        RunError: when the FMU has no binary for this machine, or reports a fault.
    """
    path, show = Path(path), progress or silent
    typed = {fmu_name(name): name for name in settings}
    settings = {fmu_name(name): value for name, value in settings.items()}
    description = read_fmu(path)
    variables = {variable.name: variable for variable in description.modelVariables}
    if "link[1].length" not in variables:
        raise SceneError(f"{path}: not the FMU of a chain: it has no variable link[1].length")
    for name, kind in (("point[0].x", "points"), ("energy.total", "energies")):
        if name not in variables:
            raise SceneError(f"{path}: has no variable {name}: its scene has outputs.{kind} = false")
    parameters = {name: v for name, v in variables.items() if v.causality == "parameter"}
    experiment = description.defaultExperiment
    stop_time, step_size = (
        _positive(name, value_of(settings.get(name, default)), str(path))
        for name, default in zip(EXPERIMENT, (experiment.stopTime, experiment.stepSize), strict=True)
    )
    with as_typed(typed.values()):
        start_values = {
            name: _start_value(_known(name, parameters, str(path)), value_of(value), str(path))
            for name, value in settings.items()
            if name not in EXPERIMENT
        }
    outputs = [
        name
        for name, variable in variables.items()
        # arrays of FMI 3.0 are left out, because they only repeat the values of scalar outputs
        if variable.causality == "output" and not variable.dimensions
    ]
    check_result_size(str(path), stop_time, step_size, len(outputs))
    values = {name: float(start_values.get(name, variable.start)) for name, variable in parameters.items()}
    driven, rows_given = description, None
    if inputs:
        driven, rows_given = driven_rows(description, *inputs, (stop_time, step_size), values)
    walls, stops = _walls(values), ranges_from(values)
    ends = [stop for stop in SLIDER_STOPS if stop.replace("_", ".") in values]
    names = [*dict.fromkeys((*WALLS, *walls)), *(STOPS if stops else ()), *ends]
    named = {name: _named(parameters[name], value) for name, value in values.items()}
    point_names = {
        int(at[1]): at[2] for v in variables.values() if (at := POINT_IN_TEXT.match(v.description or ""))
    }
    derived = [name for name, parameter in parameters.items() if UNLESS_SET in (parameter.description or "")]

    def recording(rows: np.ndarray) -> Recording:
        followed = {name: float(rows[name][0]) for name in derived}
        recorded = StoredRecording(
            name=description.modelName,
            time=np.asarray(rows["time"]),
            columns={name: rows[name] for name in outputs},
            impacts=impacts_shown(rows, names),
            walls=walls,
            wall_names=tuple(names),
            parameters=named | followed,
            stops=stops,
            point_names=point_names,
            inputs=tuple(name for name, parameter in variables.items() if parameter.causality == "input"),
        )
        return replace(recorded, stick_slip=phases_from(recorded.time, recorded.touches, names))

    recorders: list[Any] = []  # fmpy gives its recorder to the callback after the first step

    def step_finished(time: float, recorder: Any) -> bool:
        recorders[:] = [recorder]
        show(time / stop_time)
        return True

    try:
        rows = simulated(
            path,
            driven,
            start_values=start_values,
            output=outputs + derived,
            stop_time=stop_time,
            output_interval=step_size,
            input=rows_given,
            step_finished=step_finished,
        )
    except RunError as error:
        partial = recording(recorders[0].result()) if recorders else None
        raise RunError(str(error), partial) from None
    return recording(rows)


def _walls(values: Mapping[str, float]) -> dict[str, HalfPlane]:
    """Return the walls of an FMU from the values of its parameters."""
    box = {wall: values[f"box.{wall}"] for wall in WALLS if f"box.{wall}" in values}
    slopes = [name.split(".")[1] for name in values if name.startswith("wall.") and name.endswith(".angle")]
    lines = ([values[f"wall.{wall}.{key}"] for key in ("x", "y", "angle")] for wall in slopes)
    return half_planes(box, {wall: (x, y, angle) for wall, (x, y, angle) in zip(slopes, lines, strict=True)})


def _named(variable: Any, value: float) -> float | str:
    """Return the value of an FMU's parameter; for an enumeration, the name of the choice."""
    if variable.type != "Enumeration":
        return value
    return next((item.name for item in variable.declaredType.items if float(item.value) == value), str(value))


def _known(name: str, parameters: Mapping[str, Any], source: str) -> Any:
    if name not in parameters:
        given = "it is an input: give it over time in a table, --inputs FILE"
        signals = {parameter.split(".")[1] for parameter in parameters if parameter.startswith("signal.")}
        hint = given if input_key(name) else signal_hint(name, signals)
        raise UnknownNameError(source, name, [*parameters, *EXPERIMENT], "no parameter", hint)
    return parameters[name]


def _positive(name: str, value: Any, source: str) -> float:
    if not _is_number(value) or not 0.0 < value < float("inf"):
        raise SceneError(f"{source}: {name} = {value} must be a finite number > 0 [s]")
    return float(value)


def _is_number(value: Any) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def _start_value(variable: Any, value: Any, source: str) -> float | int:
    """Return a variable's value in fmpy's form; refuse other values. A choice may be given by name."""
    if variable.type == "Enumeration":
        numbers = {item.name: int(item.value) for item in variable.declaredType.items}
        number = numbers.get(value) if isinstance(value, str) else value
        if isinstance(number, Integral) and number in numbers.values() and not isinstance(number, bool):
            return int(number)
        meant = nearest_choice(value, numbers)
        raise SceneError(f"{source}: {variable.name} = {value} must be one of {', '.join(numbers)}{meant}")
    number = in_radians(value, variable.unit or "")
    if not _is_number(number):
        needed = f"a number{or_degrees(variable.unit or '')}"
        raise SceneError(f"{source}: {variable.name} = {value} must be {needed}")
    return float(number)
