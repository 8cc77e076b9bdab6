"""The motions of base, walls and belts over time, from the inputs that give them.

A channel of the kernel (kernel/chain/prescribed_motion.py) follows a position, and the velocity and
acceleration that are its derivatives. If no input gives the position, the position is the integral of the
given velocity over time, or else the double integral of the given acceleration from rest; it begins with
``Channel.start``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from chain_impact.kernel.constraints.geometry import ALLOWED_OVERLAP
from chain_impact.kernel.record.constants import INPUT_DEGREE
from chain_impact.scene.checks.checks import base_start_hint
from chain_impact.scene.errors import SceneError
from chain_impact.scene.files.table_file import jumps_of
from chain_impact.scene.signal_polynomials import spline_of_position, splines_between_jumps
from chain_impact.scene.texts.input_table import is_position
from chain_impact.scene.texts.names import AXES
from chain_impact.simulation.approximation import Approximator
from chain_impact.simulation.polynomial_pieces import Pieces, joined_points
from chain_impact.variables.kind import CHANNEL_FIELDS, GIVEN_CHANNEL
from chain_impact.variables.prepared import PreparedScene

# arguments ``accuracy`` and ``resolution`` of ``Approximator`` for motions
ACCURACY, FINELY_RESOLVED = 4e-15, 1e-15
# [1] limits for the position, the speed and the acceleration, relative to the largest value of each: two
# pieces that differ more than this where they meet make a jump. The limits are wide, because the time of a
# kink, and so the speed there, is known only up to the square root of round-off.
LEAST_JUMPS = 1e-9, 1e-6, 1e-4
# [1] a given velocity, acceleration or start contradicts the motion if the given value and that of the motion
# differ by more than this: relative to the larger of the two starts, or to the largest velocity or
# acceleration of both in the run
LEAST_CONTRADICTION = 1e-3
# [1] round-off of a position at the start, relative to the largest position; only a larger difference is a
# contradiction
START_POSITION_ROUND_OFF = 1e-12


@dataclass(frozen=True)
class ChannelMotion:
    """The motion of a channel over time.

    Attributes:
        name: the name of the input that gives the motion; "" if no input does.
        position: function from times [s] to positions [m]; of a belt to the path since t = 0 [m].
        breaks: times at which the motion may not be smooth [s].
    """

    name: str
    position: Callable[[Any], Any]
    breaks: np.ndarray


@dataclass(frozen=True)
class Channel:
    """One prescribed motion, of the base, a wall or a belt, and the names of the inputs that give it.

    Attributes:
        position: name of the input for the position; "" for a belt, which has no position.
        velocity: name of the input for the velocity.
        acceleration: name of the input for the acceleration; "" for a belt.
        start: position at t = 0 if no input gives the position [m]; 0 for a wall or belt.
    """

    position: str
    velocity: str
    acceleration: str
    start: float

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all inputs of the channel."""
        return tuple(self.orders)

    @property
    def orders(self) -> dict[str, int]:
        """Name of each input of the channel → order of the derivative of the motion that the input is."""
        return {name: k for k, name in enumerate((self.position, self.velocity, self.acceleration)) if name}


def channels_of(prepared_scene: PreparedScene) -> list[Channel]:
    """Return the channels of a moving base, of moving walls and of belts, in the order of the record."""
    names = {variable.record_path: variable.name for variable in prepared_scene.inputs}
    scene, channels = prepared_scene.scene, []
    for j in range(prepared_scene.counts.channel_count):
        position, velocity, acceleration = (
            names.get((GIVEN_CHANNEL, field, j), "") for field in CHANNEL_FIELDS
        )
        base = scene.inputs.base_motion and j < len(AXES)
        start = scene.initial.position[j] if base else 0.0
        channels.append(Channel(position, velocity, acceleration, start))
    return channels


def motion_of(
    channel: Channel,
    given_inputs: Mapping[str, Any],
    stop_time: float,
    called: Callable[[str, float], float],
    *,
    interpolation: str,
) -> ChannelMotion:
    """Return the motion of a channel: from the position if given, else from velocity or acceleration.

    If no input gives the motion, the channel stays at its start.

    Args:
        channel: the channel.
        given_inputs: name of an input → number, function, or samples (times, values).
        stop_time: end of the run [s].
        called: function of (name, time) that returns the value of a user's function.
        interpolation: ``linear`` or ``spline``: how samples are joined; else samples of a belt's speed are
            held, and all others, of a position, velocity or acceleration, are joined by a cubic spline.
    """
    given_name = next((name for name in channel.names if name in given_inputs), None)
    if given_name is None:
        return ChannelMotion("", lambda times: np.full_like(times, channel.start), np.zeros(0))
    is_belt = not channel.position
    sample_join = interpolation if interpolation in ("linear", "spline") else "held" if is_belt else "spline"
    value, breaks = as_function(
        given_name, given_inputs[given_name], called, sample_join=sample_join, stop_time=stop_time
    )
    for _ in range(channel.orders[given_name]):
        value, breaks = _integrate(value, breaks, stop_time)
    if given_name == channel.position or is_belt:
        return ChannelMotion(given_name, value, breaks)
    return ChannelMotion(given_name, lambda times: channel.start + value(times), breaks)


def as_function(
    name: str,
    given_input: Any,
    called: Callable[[str, float], float],
    *,
    sample_join: str,
    stop_time: float = math.inf,
) -> tuple[Callable[[Any], Any], np.ndarray]:
    """Return an input over time as a function of times [s], and the times [s] at which it may not be smooth.

    ``sample_join`` says how samples are joined: "linear", "held" until the next sample, or by a "spline". The
    first sample acts also before its time, the last one also after its time. ``stop_time`` is the end of the
    run [s].
    """
    if callable(given_input):
        return lambda times: np.array([called(name, time) for time in np.ravel(times).tolist()]), np.zeros(0)
    if isinstance(given_input, float):
        return lambda times: np.full(np.shape(times), given_input), np.zeros(0)
    sample_times, values = given_input
    if sample_join == "linear":
        return lambda times: np.interp(times, sample_times, values), sample_times
    if sample_join == "held" or sample_times[0] == sample_times[-1]:
        return lambda times: values[
            np.maximum(np.searchsorted(sample_times, times, side="right") - 1, 0)
        ], sample_times
    from scipy.interpolate import PPoly

    if is_position(name):
        breaks, powers = spline_of_position(sample_times, values, stop_time)
    else:
        breaks, powers = np.unique(sample_times), splines_between_jumps(sample_times, values)
    spline = PPoly(powers.T[::-1], breaks)
    return lambda times: spline(np.clip(times, sample_times[0], sample_times[-1])), breaks


def _integrate(
    value: Callable[[Any], Any], breaks: np.ndarray, stop_time: float
) -> tuple[Callable[[Any], Any], np.ndarray]:
    """Return the integral of a function over time from 0 on, as a function, and the times of its breaks.

    A break is a time at which the integral may not be smooth: the given ``breaks``, and times at which the
    function jumps or bends. The integral itself would show these only up to the square root of round-off.
    """
    inner_breaks = np.unique(breaks[(breaks > 0.0) & (breaks < stop_time)])
    grid = np.concatenate([[0.0], inner_breaks, [stop_time]])
    placeholder = joined_points(grid, np.arange(len(grid))[:, np.newaxis] * 1.0, is_linear=False)
    approximator = Approximator(
        lambda times: value(times)[:, np.newaxis], stop_time, ACCURACY, FINELY_RESOLVED
    )
    pieces = approximator.with_held(placeholder, np.array([0]))
    powers = pieces.powers[:, :, 0] / np.arange(1.0, pieces.powers.shape[1] + 1.0)

    def from_middle(times: np.ndarray, piece_numbers: np.ndarray) -> np.ndarray:
        x = (times - pieces.middle[piece_numbers]) * pieces.scale[piece_numbers]
        total = np.zeros_like(x)
        for column in powers.T[::-1]:
            total = (total + column[piece_numbers]) * x
        return np.asarray(total / pieces.scale[piece_numbers])

    all_pieces = np.arange(len(pieces.start))
    start_integrals = from_middle(pieces.start, all_pieces)
    offsets = (
        np.append(0.0, np.cumsum(from_middle(pieces.end, all_pieces) - start_integrals)[:-1])
        - start_integrals
    )

    def integral(times: Any) -> np.ndarray:
        times = np.asarray(times, float)
        piece_numbers = np.clip(np.searchsorted(pieces.start, times, side="right") - 1, 0, None)
        return np.asarray(offsets[piece_numbers] + from_middle(times, piece_numbers))

    bends = has_jumps_of_order(pieces, np.array([0]), 0) | has_jumps_of_order(pieces, np.array([0]), 1)
    return integral, np.union1d(breaks, pieces.start[bends[:, 0]])


def derivatives_of_order(pieces: Pieces, order: int) -> np.ndarray:
    """Return the derivatives of one ``order`` of M signals at start and end of P pieces, shape (2, P, M)."""
    return np.stack(
        [pieces.derivatives_at(times, slice(None), order) for times in (pieces.start, pieces.end)]
    )


def has_jumps_of_order(pieces: Pieces, columns: np.ndarray, order: int) -> np.ndarray:
    """Return whether the derivative of one ``order`` of K motions jumps at the start of P pieces.

    The shape is (P, K). The result is False for the first piece, and for all pieces if the last piece has no
    end. ``columns`` are the indices of the motions among the signals of the pieces.
    """
    jumping = np.zeros((len(pieces.start), len(columns)), bool)
    if not len(columns) or not math.isfinite(pieces.end[-1]):
        return jumping
    ends = derivatives_of_order(pieces, order)[:, :, columns]
    # bound of the derivative of order k of s = Σ c_p x^p: |s⁽ᵏ⁾| ≤ Σ p!/(p − k)! |c_p| scaleᵏ, for |x| ≤ 1
    orders = np.array([math.perm(p, order) for p in range(pieces.powers.shape[1])])
    bounds = np.einsum("p,npm,n->nm", orders, np.abs(pieces.powers), pieces.scale**order)
    largest_values = bounds[:, columns].max(axis=0, initial=0.0)
    jumping[1:] = np.abs(ends[0, 1:] - ends[1, :-1]) > LEAST_JUMPS[order] * largest_values
    return jumping


def refuse_jumps(
    source: str, motions: Sequence[ChannelMotion], belts: np.ndarray, pieces: Pieces, columns: np.ndarray
) -> None:
    """Refuse a motion of base or wall whose position or velocity jumps; the speed of a belt may jump.

    Raises:
        SceneError: when the position or velocity of a base or wall jumps.
    """
    for order, word in enumerate(("position", "velocity")):
        for k in np.flatnonzero((has_jumps_of_order(pieces, columns, order) & ~belts).any(axis=0)):
            time = pieces.start[has_jumps_of_order(pieces, columns, order)[:, k]][0]
            remedy = "give a velocity, a smooth function, or samples, which are joined smoothly"
            raise SceneError(
                f"{source}: {motions[int(k)].name}: the {word} jumps at t = {time:.9g} s, which would be an "
                f"impact of unknown strength: {remedy}"
            )


def refuse_jumping_samples(source: str, channel: Channel, given_inputs: Mapping[str, Any]) -> None:
    """Refuse two samples at one time for the position or the velocity of a base or wall."""
    for name in channel.names if channel.position else ():
        given_input = given_inputs.get(name)
        if (
            channel.orders[name] <= 1
            and isinstance(given_input, tuple)
            and len(repeated_rows := jumps_of(given_input[0]))
        ):
            time_text = f"two samples at t = {given_input[0][repeated_rows[0]]:.9g} s make it jump"
            raise SceneError(f"{source}: {name}: {time_text}, which would be an impact of unknown strength")


def made_continuous(pieces: Pieces, columns: np.ndarray) -> Pieces:
    """Return pieces of motions whose positions and velocities agree exactly where pieces meet.

    Only a jump in the speed of a belt stays. Each piece after the first gets the correction
    (1 − r)⁸ (s + (8 s + v) r), where r goes from 0 to 1 in the piece. The correction changes the position at
    the start of the piece by s, and the velocity there by v divided by the piece's duration. It changes
    neither at the end of the piece. s and v are such that the start then agrees with the end of the piece
    before. Where the speed of a belt jumps, v is 0. ``columns`` are the indices of the motions among the
    signals of the pieces.
    """
    ends = [derivatives_of_order(pieces, order)[:, :, columns] for order in range(2)]
    x0, x1 = (
        ((edges - pieces.middle) * pieces.scale)[1:, np.newaxis] for edges in (pieces.start, pieces.end)
    )
    lasted = ((x1 - x0).T / pieces.scale[1:]).T
    s = ends[0][1, :-1] - ends[0][0, 1:]
    v = np.where(has_jumps_of_order(pieces, columns, 1)[1:], 0.0, lasted * (ends[1][1, :-1] - ends[1][0, 1:]))
    # r is a linear function of the argument x of the piece: r = p x + q
    p, q = 1.0 / (x1 - x0), -x0 / (x1 - x0)
    slope = (INPUT_DEGREE - 1) * s + v
    powers = np.zeros((len(pieces.powers), INPUT_DEGREE + 1, pieces.powers.shape[2]))
    powers[:, : pieces.powers.shape[1]] = pieces.powers
    for k in range(INPUT_DEGREE):
        part = math.comb(INPUT_DEGREE - 1, k) * (1.0 - q) ** (INPUT_DEGREE - 1 - k) * (-p) ** k
        powers[1:, k, columns] += part * (s + slope * q)
        powers[1:, k + 1, columns] += part * slope * p
    return replace(pieces, powers=powers)


def contradictions(
    channels: Sequence[Channel],
    given_inputs: Mapping[str, Any],
    pieces: Pieces,
    columns: np.ndarray,
    called: Callable[[str, float], float],
) -> list[str]:
    """Return a sentence for each input that contradicts another value of the same channel.

    A velocity or acceleration can contradict the motion that another input gives, at the start of a piece; a
    position of the base can contradict the initial position in the scene.
    """
    texts = []
    for channel, column in zip(channels, columns, strict=True):
        names = [name for name in channel.names if name in given_inputs]
        if channel.position in names and channel.position.startswith("base."):
            positions = derivatives_of_order(pieces, 0)[0, :, column]
            start = positions[0]
            round_off = max(ALLOWED_OVERLAP, START_POSITION_ROUND_OFF * np.abs(positions).max())
            deviation = abs(start - channel.start)
            if deviation > max(LEAST_CONTRADICTION * max(abs(start), abs(channel.start)), round_off):
                texts.append(base_start_hint(channel.position[-1], start, channel.start))
        for name in names[1:]:
            order = channel.names.index(name)
            value, _ = as_function(name, given_inputs[name], called, sample_join="spline")
            values = derivatives_of_order(pieces, order)[0, :, column]
            data = np.asarray(value(pieces.start))
            k = int(np.abs(data - values).argmax())
            if abs(data[k] - values[k]) > LEAST_CONTRADICTION * max(np.abs(data).max(), np.abs(values).max()):
                value_text = f"{values[k]:.9g} at t = {pieces.start[k]:.9g} s, and is not used"
                texts.append(f"{name} = {data[k]:.9g} contradicts {names[0]}, which gives {value_text}")
    return texts
