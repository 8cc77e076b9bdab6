"""Inputs over time that drive a simulation, from numbers, functions or samples."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from chain_impact.kernel.chain.inputs import CONTINUES, REINITIALIZE
from chain_impact.scene.asked_inputs import request_hint
from chain_impact.scene.errors import SceneError
from chain_impact.scene.texts.input_table import INPUT_KEYS, input_key
from chain_impact.scene.texts.names import DataPath
from chain_impact.scene.warning import warn
from chain_impact.simulation.approximation import TIME_ERROR, Approximator, NotSmoothError
from chain_impact.simulation.given_inputs import NamedInputs
from chain_impact.simulation.input_values import checked_input, finite_value, values_before_jumps
from chain_impact.simulation.motions import (
    ACCURACY,
    FINELY_RESOLVED,
    Channel,
    ChannelMotion,
    as_function,
    channels_of,
    contradictions,
    has_jumps_of_order,
    made_continuous,
    motion_of,
    refuse_jumping_samples,
    refuse_jumps,
)
from chain_impact.simulation.polynomial_pieces import Pieces, joined_points
from chain_impact.simulation.targets import still_dampers
from chain_impact.variables.kind import GIVEN_CHANNEL
from chain_impact.variables.prepared import PreparedScene

# [1] the allowed error of a followed input that is no motion, relative to its largest value, is
# TOLERANCE_SHARE times the solver's tolerance
TOLERANCE_SHARE = 1e-3
# [1] a sample counts as simultaneous with a communication point, or with the sample before it, if their times
# differ by at most this, relative to the end of the run
SAMPLE_ROUND_OFF = 1e-12
LISTED_NAMES = 8  # largest number of names of inputs in an error
NO_PIECES = joined_points(np.zeros(1), np.zeros((1, 0)), is_linear=False)
"""The pieces of a run without inputs."""
FIRST_ROW, NO_FLAG = np.zeros(1, int), np.zeros(1, bool)
PIECE = "piece"
"""The field, in the record's part ``given_channel``, of polynomials of motions that the solver follows."""


@dataclass(frozen=True)
class InputSchedule:
    """The inputs of a run: constants, or polynomials in time, in each of P pieces.

    Attributes:
        times: communication points: the requested times and the starts of pieces, shape (G,) [s].
        is_requested: whether the caller requested each communication point, shape (G,).
        paths: for each of the M inputs its path in the record; for a followed motion the path of its
            coefficients.
        pieces: the polynomials of the inputs.
        first_row: index of the first row in each piece, shape (P,). Row k has the inputs from
            ``times[k - 1]`` to ``times[k]``, row 0 those at the start.
        restarts: whether the solver re-initializes at the start of each piece, shape (P,).
        belt_jumps: whether the speed of a belt jumps at the start of each piece, shape (P,).
        columns: name of an input → the index of a signal of ``pieces``, and the order of the derivative of
            this signal that the input is. They are the given inputs and, of a motion that the solver follows,
            also its position, velocity and acceleration that are not given.
    """

    times: np.ndarray
    is_requested: np.ndarray
    paths: tuple[DataPath, ...]
    pieces: Pieces
    first_row: np.ndarray
    restarts: np.ndarray
    belt_jumps: np.ndarray
    columns: Mapping[str, tuple[int, int]] = field(default_factory=dict)

    def values(self, rows: np.ndarray, names: Collection[str] | None = None) -> dict[str, np.ndarray]:
        """Return name of an input → its values in some ``rows``; at a jump, the value before the jump.

        The inputs are those of ``columns`` that are among ``names``; by default all.
        """
        columns = {name: k for name, k in self.columns.items() if names is None or name in names}
        piece_numbers, times = self.first_row.searchsorted(rows, side="right") - 1, self.times[rows]
        orders = {order for _, order in columns.values()}
        signals = {order: self.pieces.derivatives_at(times, piece_numbers, order) for order in orders}
        return {name: signals[order][:, column] for name, (column, order) in columns.items()}

    def with_times(self, times: np.ndarray) -> InputSchedule:
        """Return the same inputs with other communication points: ``times`` [s], and the starts of pieces.

        Starts after the last of ``times`` are left out.
        """
        begin_times = self.times[np.maximum(self.first_row - 1, 0)]
        merged_times = np.union1d(times, begin_times[begin_times <= times[-1]])
        first = np.searchsorted(merged_times, begin_times, side="right")
        first[self.first_row == 0] = 0
        return replace(self, times=merged_times, is_requested=np.isin(merged_times, times), first_row=first)

    def set(self, record: Any, row: int) -> None:
        """Set the inputs in a record to those of a row.

        The solver will re-initialize if an input, the acceleration of a followed motion, or the speed of a
        belt jumps.
        """
        if not self.paths:
            return
        piece_number = int(self.first_row.searchsorted(row, side="right")) - 1
        powers, given_inputs, has_changed = self.pieces.powers[piece_number], record["given"], False
        piece, channels = given_inputs["piece"], record["given_channel"]
        channels["interpolates"], channels["jumps"] = 1, self.belt_jumps[piece_number]
        for m, (part, name, index) in enumerate(self.paths):
            if name == PIECE:
                channels["interpolates"] = 0
                given_powers = channels[name][: len(powers), index]
                has_changed = has_changed or (given_powers != powers[:, m]).any()
                given_powers[:] = powers[:, m]
                continue
            values = record[part][name]
            has_changed |= values[index] != powers[0, m]
            values[index] = powers[0, m]
            if part != GIVEN_CHANNEL:
                piece[name][1 : len(powers), index] = powers[1:, m]
        settings = self.pieces.settings(piece_number)
        # steady: with ``hold``, the kernel makes the polynomials of motions from the values at communication
        # points, and writes the settings of its polynomials; all other inputs are constant, without settings
        steady = channels["interpolates"] and len(channels["position"]) > 0
        if not steady and (settings["degree"] or piece["degree"]):
            has_changed = has_changed or any(piece[name] != value for name, value in settings.items())
            for name, value in settings.items():
                piece[name] = value
        if has_changed:
            anew = row != self.first_row[piece_number] or self.restarts[piece_number]
            given_inputs["pending"] = REINITIALIZE if anew else CONTINUES


def input_schedule(prepared_scene: PreparedScene, inputs: NamedInputs, times: np.ndarray) -> InputSchedule:
    """Return the inputs of a simulation over time, with given communication points.

    Args:
        prepared_scene: the scene that the inputs drive.
        inputs: the inputs that are given.
        times: communication points, increasing, shape (T,) [s]. The inputs act from t = 0 on, also if the
            first communication point is later.

    Raises:
        SceneError: when a name is not an input of the scene, or an input is invalid.
    """
    scene = prepared_scene.scene
    interpolation = inputs.interpolation
    begins_at_zero = len(times) > 0 and times[0] == 0.0
    grid_times = times if begins_at_zero else np.union1d(0.0, times)
    if not inputs.sources:
        is_requested = np.ones(len(grid_times), bool) if begins_at_zero else np.isin(grid_times, times)
        return InputSchedule(grid_times, is_requested, (), NO_PIECES, FIRST_ROW, NO_FLAG, NO_FLAG)
    given_inputs, end = _checked_inputs(prepared_scene, inputs.sources), float(grid_times[-1])
    channels = channels_of(prepared_scene) if interpolation != "hold" and end > 0.0 else []
    motion_inputs = {
        name: given_inputs.pop(name) for channel in channels for name in channel.names if name in given_inputs
    }
    for channel in channels:
        refuse_jumping_samples(scene.name, channel, motion_inputs)
    functions = {
        name: partial(finite_value, f"{scene.name}: {name}", given_input)
        for name, given_input in (given_inputs | motion_inputs).items()
    }

    def call(name: str, time: float) -> float:
        return functions[name](time)

    motions = [
        motion_of(channel, motion_inputs, end, call, interpolation=interpolation) for channel in channels
    ]
    pieces, motion_columns = _pieces_of(
        prepared_scene, given_inputs, motions, call, interpolation=interpolation, grid_times=grid_times
    )
    belts = np.array([not channel.position for channel in channels], bool)
    refuse_jumps(scene.name, motions, belts, pieces, motion_columns)
    warn(scene.name, contradictions(channels, motion_inputs, pieces, motion_columns, call))
    warn(scene.name, still_dampers(prepared_scene, list(given_inputs), pieces))
    if motions:
        pieces = made_continuous(pieces, motion_columns)
    begin = pieces.start[1:]
    all_times = np.union1d(grid_times, begin)
    belt_jumps = np.asarray(has_jumps_of_order(pieces, motion_columns[belts], 1).any(axis=1))
    bends = has_jumps_of_order(pieces, motion_columns, 2).any(axis=1)
    paths, columns = _paths_and_columns(prepared_scene, list(given_inputs), channels, motions)
    return InputSchedule(
        times=all_times,
        is_requested=np.isin(all_times, times),
        paths=paths,
        pieces=pieces,
        first_row=np.append(0, np.searchsorted(all_times, begin) + 1),
        restarts=pieces.jumps | belt_jumps | bends,
        belt_jumps=belt_jumps,
        columns=columns,
    )


def _paths_and_columns(
    prepared_scene: PreparedScene,
    names: Sequence[str],
    channels: Sequence[Channel],
    motions: Sequence[ChannelMotion],
) -> tuple[tuple[DataPath, ...], dict[str, tuple[int, int]]]:
    """Return ``paths`` and ``columns`` of ``InputSchedule``: first the inputs ``names``, then the motions."""
    paths = {variable.name: variable.record_path for variable in prepared_scene.inputs}
    columns = {name: (m, 0) for m, name in enumerate(names)}
    for j, (channel, motion) in enumerate(zip(channels, motions, strict=True)):
        if motion.name:
            columns |= {name: (len(names) + j, order) for name, order in channel.orders.items()}
    paths_of_motions = ((GIVEN_CHANNEL, PIECE, j) for j in range(len(motions)))
    return (*(paths[name] for name in names), *paths_of_motions), columns


def _checked_inputs(prepared_scene: PreparedScene, inputs: Mapping[str, Any]) -> dict[str, Any]:
    """Return name → input over time: a number, a function, or a pair of arrays (times, values).

    Refuse unknown names, and values of other types.
    """
    source, names = prepared_scene.scene.name, {variable.name for variable in prepared_scene.inputs}
    for name in inputs:
        if name not in names:
            fault = f"{name!r} is not an input of this scene"
            raise SceneError(f"{source}: {fault}; {_hint(prepared_scene, name)}")
    return {name: checked_input(f"{source}: {name}", given_input) for name, given_input in inputs.items()}


def _pieces_of(
    prepared_scene: PreparedScene,
    given_inputs: Mapping[str, Any],
    motions: Sequence[ChannelMotion],
    call: Callable[[str, float], float],
    *,
    interpolation: str,
    grid_times: np.ndarray,
) -> tuple[Pieces, np.ndarray]:
    """Return the polynomials of all given inputs and then of all motions, and the columns of the motions.

    The ``motions`` are followed; of the ``given_inputs``, functions with the interpolations ``follow`` and
    ``spline``, samples with ``spline`` only. All others are held, or with ``linear`` joined by lines,
    between the communication points ``grid_times`` and the times of samples.
    """
    scene, same = prepared_scene.scene, SAMPLE_ROUND_OFF * grid_times[-1]
    splines = {
        name: as_function(name, given_input, call, sample_join="spline")
        for name, given_input in given_inputs.items()
        if interpolation == "spline" and isinstance(given_input, tuple)
    }
    breaks = np.concatenate(
        [np.zeros(0), *(motion.breaks for motion in motions), *(knots for _, knots in splines.values())]
    )
    samples = [given_input[0] for given_input in given_inputs.values() if isinstance(given_input, tuple)]
    sample_times = np.concatenate([breaks, *samples])
    grid = _with_samples(grid_times, sample_times, same) if len(sample_times) else grid_times
    is_exact = interpolation in ("follow", "spline") and grid_times[-1] > 0.0
    functions_or_splines = {*splines, *(name for name, value in given_inputs.items() if callable(value))}
    names = [name for name in given_inputs if is_exact and name in functions_or_splines]
    values = [
        np.zeros(len(grid))
        if name in names
        else _input_values(f"{scene.name}: {name}", given_input, interpolation, grid, same)
        for name, given_input in given_inputs.items()
    ]
    values += [np.zeros(len(grid)) for _ in motions]
    starts, rights, is_linear = _on_grid(grid, breaks), np.stack(values, axis=1), interpolation == "linear"
    lefts = values_before_jumps(grid, rights, [*given_inputs.values()]) if is_linear else rights
    pieces = joined_points(grid, rights, is_linear=is_linear, breaks=starts, left_limits=lefts)
    motion_columns = len(given_inputs) + np.arange(len(motions))
    function_columns = [k for k, name in enumerate(given_inputs) if name in names]
    columns = np.append(function_columns, motion_columns).astype(int)
    if len(columns):
        functions: dict[str, Callable[[Any], Any]] = {
            name: splines[name][0] if name in splines else partial(_values_at, call, name) for name in names
        }
        functions |= {motion.name or str(m): motion.position for m, motion in enumerate(motions)}
        is_force = columns < len(given_inputs)
        accuracy = np.where(is_force, TOLERANCE_SHARE * scene.solver.tolerance, ACCURACY)
        resolutions = np.where(is_force, TIME_ERROR, FINELY_RESOLVED)
        pieces = _with_functions(scene.name, functions, columns, pieces, (accuracy, resolutions))
        pieces = replace(pieces, moving=motion_columns)
    # ``refuse_jumps`` checks the jumps of motions, so ``Pieces.jumps`` leaves them out
    pieces.same[motion_columns] = np.inf
    return pieces, motion_columns


def _hint(prepared_scene: PreparedScene, name: Any) -> str:
    """Return a hint for a name that is not an input: which signal drives it, how to add it, or all inputs."""
    if name in prepared_scene.signals_by_input:
        return f"signals.{prepared_scene.signals_by_input[name]} drives it"
    if isinstance(name, str) and input_key(name):
        return request_hint(prepared_scene.scene, name)
    return inputs_text(variable.name for variable in prepared_scene.inputs)


def _values_at(call: Callable[[str, float], float], name: str, times: np.ndarray) -> np.ndarray:
    """Return the values of a function at several times, shape (T,)."""
    return np.array([call(name, time) for time in times.tolist()])


def _on_grid(grid: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Return the points of a grid [s] that are nearest to given times [s]; none if the grid has one point."""
    next_rows = np.searchsorted(grid, times).clip(1, len(grid) - 1) if len(grid) > 1 else np.zeros(0, int)
    is_nearer = times[: len(next_rows)] - grid[next_rows - 1] < grid[next_rows] - times[: len(next_rows)]
    return np.unique(grid[next_rows - is_nearer])


def _with_functions(
    source: str,
    functions: Mapping[str, Callable[[np.ndarray], np.ndarray]],
    columns: np.ndarray,
    pieces: Pieces,
    errors: tuple[np.ndarray, np.ndarray],
) -> Pieces:
    """Return ``pieces``, those of all inputs, with polynomials of the ``functions`` in their ``columns``.

    In ``pieces`` all inputs are constant or linear; see ``Approximator.with_held``. ``errors`` are the
    arguments ``accuracy`` and ``resolution`` of ``Approximator``, each with a number for each function.
    """
    names = list(functions)

    def call(times: np.ndarray) -> np.ndarray:
        return np.stack([function(times) for function in functions.values()], axis=1)

    approximator = Approximator(call, float(pieces.end[-1]), *errors)
    try:
        return approximator.with_held(pieces, columns)
    except NotSmoothError as error:
        name = names[error.function_number]
        raise SceneError(
            f"{source}: {name}: the function cannot be followed at t = {error.time:.9g} s, as it is not "
            "smooth in pieces (noise, rounded values), or has too many jumps or kinks (a table, a switch); "
            'give samples (times, values), or take interpolation="linear" or "hold"'
        ) from None


def _with_samples(times: np.ndarray, samples: np.ndarray, same: float) -> np.ndarray:
    """Return the communication points together with the times of samples inside the run.

    A sample that is at most ``same`` [s] from a communication point is left out. Of the others, a
    sample at most ``same`` after the sample before, which may be left out itself, is left out, too.
    """
    samples = np.unique(samples)
    samples = samples[(samples > 0.0) & (samples < times[-1])]
    next_rows = np.searchsorted(times, samples)
    samples = samples[np.minimum(times[next_rows] - samples, samples - times[next_rows - 1]) > same]
    return np.union1d(times, samples[np.diff(samples, prepend=0.0) > same])


def inputs_text(inputs: Iterable[str]) -> str:
    """Return a sentence on the inputs of a scene: their names, and how to add inputs."""
    names = list(inputs)
    *keys, last = INPUT_KEYS
    advice = f"[inputs] {', '.join(keys)} and {last} in the scene"
    if not names:
        return f"it has none, {advice} make them"
    shown_names = names if len(names) <= LISTED_NAMES else [*names[: LISTED_NAMES - 2], "…", names[-1]]
    return f"it has {', '.join(shown_names)}, and {advice} make all that there can be"


def _input_values(
    noun: str, given_input: Any, interpolation: str, times: np.ndarray, same: float
) -> np.ndarray:
    """Return an input's values at several times, shape (T,); ``linear`` joins samples, else they are held.

    A held sample acts from ``same`` [s] before its time on, until the next one acts; the first sample also
    before.
    """
    if callable(given_input):
        return np.array([finite_value(noun, given_input, time) for time in times.tolist()])
    if isinstance(given_input, float):
        return np.full(len(times), given_input)
    sample_times, values = given_input
    if interpolation == "linear":
        return np.asarray(np.interp(times, sample_times, values))
    latest_rows = np.searchsorted(sample_times, times + same, side="right") - 1
    return np.asarray(values[np.maximum(latest_rows, 0)])
