"""Reference results in an FMU: a table of correct outputs with tolerances, by which an importer is checked.

The file is CSV. Its first row has names: ``time``, the inputs, the outputs. The second row begins with the
word ``tolerance`` and gives the tolerance of each output. Each further row belongs to a communication point.
The value of an input acts from its row to the next row. An empty cell tells that the output is not compared
at this time.
"""

from __future__ import annotations

import csv
import io
import math
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from chain_impact.fmu.importer import read_fmu, run_with_fmpy
from chain_impact.progress import log
from chain_impact.scene.keys.tables import STEP_ROUND_OFF
from chain_impact.scene.scene import Scene
from chain_impact.simulation.chain import Chain
from chain_impact.simulation.errors import RunError, SimulationError
from chain_impact.variables.kind import GIVEN_CHANNEL
from chain_impact.variables.nominal_values import nominal_values
from chain_impact.variables.prepared import PreparedScene

REFERENCE_FILE = "resources/chain_impact_reference.csv"
REFERENCE_TOLERANCE = 1e-12  # the solver's tolerance in the run whose outputs are the reference results
# approximate number of communication steps of the table, if it covers the whole simulated time of the scene;
# fewer if the scene has fewer
REFERENCE_ROWS = 100
# if not more than REFERENCE_ROWS / SHORTENING rows are reliable, a table of a SHORTENING-th of the simulated
# time, with communication steps that are shorter by the same ratio, is made instead; but no communication
# step is shorter than the scene's own
SHORTENING = 10
# A chain amplifies each error at every impact, so results are reliable only for some time. A second run, at
# the scene's own tolerance, tells for how long: the table ends before an output of the second run deviates
# from the reference results by more than the scene's tolerance or LARGEST_DEVIATION, whichever is larger, and
# before an onset deviates (``_agreed_until``). The table allows each output of an importer TOLERANCE_FACTOR ×
# the largest deviation of this output in the second run before the table's end, and at least LEAST_TOLERANCE.
# The scene's tolerance, LARGEST_DEVIATION and LEAST_TOLERANCE are relative to the largest absolute value of
# all outputs with the same unit. Outputs that are whole numbers may not deviate.
LARGEST_DEVIATION = 1e-5
TOLERANCE_FACTOR = 10.0
LEAST_TOLERANCE = 1e-9
# Outputs are not compared closer to the onset or the end of a contact than EVENT_DISTANCE × the communication
# step, because they change too fast there.
EVENT_DISTANCE = 1e-4
# a run ends when its number of evaluations of the equations of motion × links reaches MOST_WORK, after about
# 0.2 s of computing
MOST_WORK = 2_000_000
# amplitude of the torques that are given as inputs, relative to the inertial moment of `nominal_values` per
# link; a slider's force, targets and their velocities have the same number as amplitude, in their own units;
# the amplitude of a tip force is that of a torque divided by the length of the longest link
TORQUE_AMPLITUDE = 0.1
# amplitude of a motion of base or wall that is given as input, relative to the length of the longest link
MOTION_AMPLITUDE = 0.01
# FEWEST_REFERENCE_ROWS: least number of rows of a table, because a row at the start alone tests no step;
# REFERENCE_DIGITS: number of digits of each value in the file
FEWEST_REFERENCE_ROWS, REFERENCE_DIGITS = 2, 12


class Reference(NamedTuple):
    """The reference results of an FMU.

    Attributes:
        inputs: name of an input → its values, each from one communication point to the next, shape (T,).
        outputs: the names of the M compared outputs.
        tolerances: the allowed errors of these outputs, shape (M,), in their units.
        times: communication points, equally spaced, shape (T,) [s].
        values: the outputs, shape (T, M); a row of NaN is not compared.
    """

    inputs: dict[str, np.ndarray]
    outputs: Sequence[str]
    tolerances: np.ndarray
    times: np.ndarray
    values: np.ndarray


def reference_files(prepared_scene: PreparedScene) -> dict[str, bytes]:
    """Return the file with the reference results, as path in the FMU → content.

    The result is empty if no results are reliable, or if the chain cannot start or take its first step.
    """
    try:
        solution = reference_results(prepared_scene)
    except SimulationError as error:
        log.info("no reference results in the FMU: %s", error)
        return {}
    if len(solution.times) < FEWEST_REFERENCE_ROWS:
        log.info("no reference results in the FMU: they depend too much on the solver's tolerance")
        return {}
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["time", *solution.inputs, *solution.outputs])
    writer.writerow(["tolerance", *("" for _ in solution.inputs), *(f"{x:.2g}" for x in solution.tolerances)])
    rows = np.column_stack([*solution.inputs.values(), solution.values])
    for time, row in zip(solution.times, rows, strict=True):
        writer.writerow(
            [repr(float(time)), *("" if np.isnan(x) else f"{x:.{REFERENCE_DIGITS}g}" for x in row)]
        )
    return {REFERENCE_FILE: text.getvalue().encode()}


def reference_results(prepared_scene: PreparedScene) -> Reference:
    """Return some outputs of a scene at REFERENCE_TOLERANCE, up to the time until which they are reliable.

    Outputs are reliable until a run at the scene's own tolerance deviates from them (LARGEST_DEVIATION). If
    at most REFERENCE_ROWS / SHORTENING rows are reliable, the first 1/SHORTENING of the simulated time is
    computed anew with shorter communication steps, and so on; but no communication step is shorter than the
    scene's own.

    Raises:
        SimulationError: when the chain cannot start, or cannot take the first step.
    """
    stop_time, shortest = prepared_scene.scene.simulation.stop_time, prepared_scene.scene.simulation.step_size
    while True:
        step = shortest * max(1, round(stop_time / shortest / REFERENCE_ROWS))
        count = max(1, math.floor(stop_time / step * (1 + STEP_ROUND_OFF)))
        solution = _reference_results(
            prepared_scene, np.minimum(np.arange(count + 1) * min(step, stop_time), stop_time)
        )
        if np.isfinite(solution.values[:, 0]).sum() > REFERENCE_ROWS / SHORTENING or step == shortest:
            return solution
        stop_time /= SHORTENING


def _reference_results(prepared_scene: PreparedScene, times: np.ndarray) -> Reference:
    """Return the reference results at ``times``, equally spaced from 0 [s]; NaN near onsets and ends.

    The results end where runs with two tolerances begin to differ, or where the shorter of these runs ends.
    """
    ends = {f"point[{k}].{axis}" for k in (0, prepared_scene.counts.link_count) for axis in "xy"}
    ends |= {f"link[{i}].angle" for i in (1, prepared_scene.counts.link_count)}
    # outputs of the whole chain: the energies, the number of impacts, and the data of the last impact
    whole_chain = [v for v in prepared_scene.outputs if v.kind.owner_kind == "one"]
    ends |= {v.name for v in whole_chain if v.kind.parts.owner in ("energy", "impact")}
    chosen_outputs = [v for v in prepared_scene.outputs if v.name in ends]
    names, is_discrete = (
        [v.name for v in chosen_outputs],
        np.array([v.type != "real" for v in chosen_outputs]),
    )
    units = np.array([v.unit for v in chosen_outputs])
    inputs, tolerance = _inputs(prepared_scene, times), prepared_scene.scene.solver.tolerance
    (exact_rows, exact_contacts), (usual_rows, usual_contacts) = (
        _run(
            prepared_scene.scene.with_values({"solver.tolerance": t, "outputs.solver": True}),
            times,
            inputs,
            names,
        )
        for t in (REFERENCE_TOLERANCE, tolerance)
    )
    count = min(len(exact_rows), len(usual_rows))
    # a contact that lasts at the end of the run has NaN as its end, which is left out here
    edges = np.concatenate(
        [table[end] for table in (exact_contacts, usual_contacts) for end in ("onset", "end")]
    )
    edges = np.append(edges[~np.isnan(edges)], math.inf)
    is_far = np.abs(times[:count, None] - edges).min(axis=1) > EVENT_DISTANCE * times[1]
    agreed_time = _agreed_until(
        exact_contacts["onset"], usual_contacts["onset"], EVENT_DISTANCE * times[1] / TOLERANCE_FACTOR
    )
    rows = np.flatnonzero(is_far & (times[:count] < agreed_time))
    largest_values = np.abs(exact_rows[rows]).max(axis=0, initial=0.0)
    scale = np.array([largest_values[units == unit].max() for unit in units]) + REFERENCE_TOLERANCE
    deviation = np.abs(usual_rows[rows] - exact_rows[rows])
    is_astray = (deviation > np.where(is_discrete, 0.0, max(LARGEST_DEVIATION, tolerance) * scale)).any(
        axis=1
    )
    rows = rows[: np.argmax(is_astray)] if is_astray.any() else rows
    worst = deviation[: len(rows)].max(axis=0, initial=0.0)
    length = rows[-1] + 1 if len(rows) else 1
    values = np.full((length, len(names)), np.nan)
    values[rows] = exact_rows[rows]
    return Reference(
        inputs={name: column[:length] for name, column in inputs.items()},
        outputs=names,
        tolerances=np.where(is_discrete, 0.0, np.maximum(TOLERANCE_FACTOR * worst, LEAST_TOLERANCE * scale)),
        times=times[:length],
        values=values,
    )


def _run(
    scene: Scene, times: np.ndarray, inputs: dict[str, np.ndarray], names: Sequence[str]
) -> tuple[np.ndarray, np.ndarray]:
    """Return two arrays of a run: the outputs ``names``, with a row for each of ``times`` [s]; the impacts.

    The run ends early after a fault, or when its work reaches MOST_WORK.

    Raises:
        SimulationError: when the chain cannot start, or cannot take the first step.
    """
    chain, rows, links = Chain(scene), [], len(scene.chain.links)
    for row, time in enumerate(times):
        try:
            chain.set({name: values[max(row - 1, 0)] for name, values in inputs.items()})
            chain.step_to(time)
            rows.append(chain.get(names))
        except SimulationError:
            if len(rows) < FEWEST_REFERENCE_ROWS:
                raise
            break
        if chain.get("solver.rhs_evaluations") * links >= MOST_WORK:
            break
    return np.array(rows), chain.impacts


def _inputs(prepared_scene: PreparedScene, times: np.ndarray) -> dict[str, np.ndarray]:
    """Return the values of each input at ``times``: sines and cosines of different frequencies.

    Any two forces, torques or targets have different frequencies, and so have any two prescribed motions: an
    importer that exchanges such a pair is noticed. But if there are more inputs than half the number of
    ``times``, some pairs may have the same values at these times. Velocity and acceleration of a motion are
    the derivatives of the motion's position. Values are rounded as in the file, so that the reference run
    gets exactly the values that an importer will read.
    """
    nominal, count = nominal_values(prepared_scene.scene), len(times)
    turn = 2.0 * math.pi * np.arange(count) / count
    rate = turn[1] / times[1]
    # The amplitude of a torque is divided by the number of links, so that all torques together move chains of
    # few and of many links about equally.
    torque = TORQUE_AMPLITUDE * nominal["inertial_moment"] / prepared_scene.counts.link_count
    size = {"joint": torque, "tip": torque / nominal["size"]}
    signals = {}
    for i, variable in enumerate(prepared_scene.inputs):
        if variable.record_path[0] == GIVEN_CHANNEL:
            _, field, channel = variable.record_path
            k, start = (
                1 + int(channel),
                float(prepared_scene.start[0][GIVEN_CHANNEL]["position"][channel]),
            )
            move = MOTION_AMPLITUDE * nominal["size"]
            signals[variable.name] = {
                "position": start + move * (1.0 - np.cos(k * turn)),
                "velocity": move * k * rate * np.sin(k * turn),
                "acceleration": move * (k * rate) ** 2 * np.cos(k * turn),
            }[str(field)]
        else:
            signals[variable.name] = size["tip" if variable.name.startswith("tip") else "joint"] * np.cos(
                (1 + i) * turn
            )
    return {
        name: np.array([float(f"{x:.{REFERENCE_DIGITS}g}") for x in values])
        for name, values in signals.items()
    }


def _agreed_until(exact_onsets: np.ndarray, usual_onsets: np.ndarray, time_tolerance: float) -> float:
    """Return the time [s] of the first onset that differs by more than ``time_tolerance`` [s] in two runs.

    ``exact_onsets`` and ``usual_onsets`` are the runs' onsets [s] in order of time; an onset that one run
    lacks differs, too. The result is ∞ if no onset differs.
    """
    count = min(len(exact_onsets), len(usual_onsets))
    first = int(
        np.argmax(np.append(np.abs(exact_onsets[:count] - usual_onsets[:count]) > time_tolerance, True))
    )
    return float(min([math.inf, *exact_onsets[first:], *usual_onsets[first:]]))


# --- the check -------------------------------------------------------------------------------------------


class _Table(NamedTuple):
    """The reference results, as they are read from an FMU.

    Attributes:
        time: communication points, shape (T,) [s].
        columns: name of an input or output → its values, shape (T,); NaN where an output is not compared.
        tolerances: name → allowed error, in the unit of the output; NaN for an input and for the time.
    """

    time: np.ndarray
    columns: dict[str, np.ndarray]
    tolerances: dict[str, float]


def check_references(path: Path) -> tuple[bool, str] | None:
    """Simulate an FMU with fmpy, and compare its outputs with the reference results in the FMU.

    Returns whether the FMU passed, and a line of text; None if the FMU has no reference results.
    """
    with zipfile.ZipFile(path) as fmu:
        if REFERENCE_FILE not in fmu.namelist():
            return None
        text = fmu.read(REFERENCE_FILE).decode(errors="replace")
    try:
        table = _table_in(text)
    except (ValueError, IndexError, csv.Error) as error:
        return (False, f"must be a table of numbers with a row of tolerances: {error}")
    description = read_fmu(path)
    kinds = {variable.name: variable.causality for variable in description.modelVariables}
    unknown_names = [name for name in table.columns if name not in kinds]
    if unknown_names:
        return (False, f"the FMU has no variable {unknown_names[0]}")
    inputs = [name for name in table.columns if kinds[name] == "input"]
    outputs = [name for name in table.columns if kinds[name] != "input"]
    given_inputs = {"time": table.time, **{name: table.columns[name] for name in inputs}}
    rows = np.rec.fromarrays([*given_inputs.values()], dtype=[(name, float) for name in given_inputs])
    try:
        results = run_with_fmpy(
            path,
            description,
            output=outputs,
            start_time=table.time[0],
            stop_time=table.time[-1],
            output_interval=table.time[1] - table.time[0],
            input=rows if inputs else None,
        )
    except RunError as error:
        return (False, f"cannot be simulated: {error}")
    return _verdict(table, {name: np.interp(table.time, results["time"], results[name]) for name in outputs})


def _table_in(text: str) -> _Table:
    """Return the table in the text of a reference file.

    Raises:
        ValueError, IndexError, csv.Error: when the text is not such a table.
    """
    head, *rows = csv.reader(io.StringIO(text))
    if head[0] != "time":
        raise ValueError("its first column must be time")
    numbers = np.array([[cell or "nan" for cell in row] for row in rows[1:]], float)
    tolerances = dict(zip(head, [float(cell or "nan") for cell in ["nan", *rows[0][1:]]], strict=True))
    time, columns = numbers[:, 0], dict(zip(head[1:], numbers.T[1:], strict=True))
    if len(time) < FEWEST_REFERENCE_ROWS or not (np.diff(time) > 0.0).all():
        raise ValueError("it must have two times or more, and the times must increase")
    return _Table(time, columns, tolerances)


def _verdict(table: _Table, results: dict[str, np.ndarray]) -> tuple[bool, str]:
    """Return whether ``results`` agree with the reference results, and a line of text.

    ``results`` has each output's values at the times of ``table``.
    """
    errors = {name: np.abs(values - table.columns[name]) for name, values in results.items()}
    # written with `~(... <= ...)`, so that a NaN of the FMU counts as a deviation
    deviations = {
        name: np.flatnonzero(~(error <= table.tolerances[name]) & ~np.isnan(table.columns[name]))
        for name, error in errors.items()
    }
    deviating = {name: rows[0] for name, rows in deviations.items() if rows.size}
    if not deviating:
        end_text = f"until {table.time[-1]:.9g} s"
        return (True, f"passed, outputs: {len(results)}, times: {len(table.time)}, {end_text}")
    name = min(deviating, key=lambda name: deviating[name])
    row = deviating[name]
    return (
        False,
        f"{name} is not {table.columns[name][row]:.9g} at t = {table.time[row]:.9g} s: "
        f"{errors[name][row]:.2g} off, {table.tolerances[name]:.2g} allowed; "
        f"of {len(results)} outputs {len(deviating)} deviate",
    )
