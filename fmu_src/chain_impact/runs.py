"""Run a scene or an FMU with parameters set by name, into a recording."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import fmpy
import numpy as np

from chain_impact.recording import Impact, Recording, impacts_from_outputs
from chain_impact.scene import WALLS, Scene, SceneError, with_values
from chain_impact.simulate import Result, simulate
from chain_impact.variables import output_columns, parameter_paths


class RunError(RuntimeError):
    """An FMU reported a fault; what it was stands in the FMU's own message."""


def record_scene(
    scene: Scene, settings: Mapping[str, str], notify: Callable[[str], None] = lambda _: None
) -> Recording:
    """Simulate a scene with some parameters, named as in its FMU, set to values in text.

    Raises:
        SceneError: when a name is unknown or a value is out of range.
        SimulationError: when the solver cannot go on.
        BuildError: when the kernel cannot be compiled.
    """
    paths = parameter_paths(scene)
    changes = {_known(name, paths, scene.name): text for name, text in settings.items()}
    scene = with_values(scene, {paths[name]: _number(text) for name, text in changes.items()})
    return recording_of(simulate(scene, notify=notify))


def recording_of(result: Result) -> Recording:
    """The recording of a simulated scene."""
    walls = {wall: getattr(result.scene.box, wall) for wall in WALLS}
    return Recording(
        name=result.scene.name,
        time=result.time,
        columns=output_columns(result.scene, result.outputs),
        impacts=[
            Impact(float(row["onset"]), int(row["point"]), WALLS[row["wall"]], float(row["impact_speed"]))
            for row in result.impacts
        ],
        walls={wall: position for wall, position in walls.items() if position is not None},
    )


def record_fmu(path: Path, settings: Mapping[str, str]) -> Recording:
    """Simulate an FMU with fmpy, over its default experiment, with parameters set to values in text.

    Raises:
        SceneError: when the file is no FMU of a chain, a name is unknown or a value is no number.
        RunError: when the FMU reports a fault.
    """
    try:
        description = fmpy.read_model_description(str(path))
    except Exception as error:  # fmpy raises whatever zipfile, lxml and its own checks raise
        raise SceneError(f"{path}: not a readable FMU: {error}") from None
    variables = {variable.name: variable for variable in description.modelVariables}
    if "point[0].x" not in variables:
        raise SceneError(f"{path}: not the FMU of a chain: it has no variable point[0].x")
    parameters = {name: v for name, v in variables.items() if v.causality == "parameter"}
    start_values = {}
    for name, text in settings.items():
        start_values[name] = _start_value(parameters[_known(name, parameters, str(path))], text, str(path))
    outputs = [name for name, variable in variables.items() if variable.causality == "output"]
    step = float(description.defaultExperiment.stepSize)
    try:
        rows = fmpy.simulate_fmu(str(path), start_values=start_values, output=outputs, output_interval=step)
    except Exception as error:  # fmpy's exceptions have no common class
        raise RunError(f"{path}: {error}") from None
    columns = {name: rows[name] for name in outputs}
    walls = {wall: start_values.get(f"box.{wall}", _start(variables, f"box.{wall}")) for wall in WALLS}
    return Recording(
        name=description.modelName,
        time=np.asarray(rows["time"]),
        columns=columns,
        impacts=impacts_from_outputs(columns),
        walls={wall: position for wall, position in walls.items() if position is not None},
    )


def _known(name: str, names: Mapping[str, Any], source: str) -> str:
    if name not in names:
        near = get_close_matches(name, names, n=1, cutoff=0.0)
        raise SceneError(f"{source}: {name} is no parameter; the nearest is {near[0]}")
    return name


def _number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text  # a choice, or what the scene will refuse


def _start_value(variable: Any, text: str, source: str) -> float | int:
    """The value that fmpy takes for a variable: an enumeration's choice can be named."""
    if variable.type == "Enumeration":
        numbers = {item.name: int(item.value) for item in variable.declaredType.items}
        if text in numbers:
            return numbers[text]
        if text.isdecimal() and int(text) in numbers.values():
            return int(text)
        raise SceneError(f"{source}: {variable.name} = {text} must be one of {', '.join(numbers)}")
    number = _number(text)
    if isinstance(number, str):
        raise SceneError(f"{source}: {variable.name} = {text} must be a number")
    return number


def _start(variables: Mapping[str, Any], name: str) -> float | None:
    return float(variables[name].start) if name in variables else None
