"""The inputs as functions of time: constants, or polynomials on intervals, called pieces.

    u(t) = u₀ + x (u₁ + x (u₂ + …)),   x = (t − middle) scale

`given.piece` is the next piece and `inputs.piece` the piece in use; each has its `middle` [s] and `scale`
[1/s]. u₀ of the next piece is the value in `given`. In a piece of degree 0 the inputs are constant.

Prescribed motions (chain/prescribed_motion.py) have the given coefficients in `given_channel.piece`, and the
coefficients in use in `channel.piece`. The caller sets the coefficients together with `given.piece`; or, if
`given_channel.interpolates` is 1, they follow from the values given at the communication points: position s,
velocity v and acceleration a, last changed at a time t₀. The motion to the next communication point, at t₁ =
t₀ + h, is a cubic. The cubic begins with the present position and velocity, and ends with the position s + v
h + ½ a h² and the velocity v + a h of a uniform acceleration. So position and velocity are continuous, and a
uniform acceleration is followed exactly. Errors do not add up, because the end follows from the given values
s, v and a only, and not from the present position. The next cubics, to later t₁, end on the same uniform
acceleration until values change again. If a velocity is given without a position, as always for a belt, the
speed changes at a uniform rate to v + a h, and the position is the integral of the speed.
"""

import math

from chain_impact.kernel.chain.prescribed_motion import move_channels
from chain_impact.kernel.chain.signals import has_signal, signal_at
from chain_impact.kernel.record.constants import INPUT_DEGREE
from chain_impact.kernel.record.input_fields import CHANNEL, TARGET, input_field, may_change_in_piece
from chain_impact.kernel.record.method import is_regularized
from chain_impact.kernel.record.state import time_at
from chain_impact.kernel.status import CANDIDATE_PART, OK, WALL_JUMPS, refuse_part

# values of given.pending beside 0. REINITIALIZE: values were set, so the solver restarts; CONTINUES:
# the next piece of the inputs continues the piece in use without a jump
REINITIALIZE, CONTINUES = 1, 2
# Velocities v and v′, given at the start and the end of a time T, explain a given displacement if a velocity
# between v and v′ gives it in T. A displacement may differ from an explained one by UNEXPLAINED_PART × T (|v|
# + |v′|). A larger difference is a contradiction, of which the user is warned. If the channel moves a wall, a
# difference beyond T (|v| + |v′|) is a jump of the position, and a fault.
UNEXPLAINED_PART = 0.05
# the displacement, relative to the longest link, that is added to both limits, that of a contradiction and
# that of a jump, because of round-off
UNEXPLAINED_DISPLACEMENT = 1e-9
# Two lengths of a cubic count as 0 up to ACCELERATION_ROUND_OFF times its size: the jump of the acceleration
# at its start times its squared duration, and its coefficient of x³. The size is the sum of the absolute
# positions at both ends and of the absolute velocities there times half the duration.
ACCELERATION_ROUND_OFF = 1e-14
# A cubic motion that lasts a time h counts as fast as a sine of the angular frequency CUBIC_CHANGE/h [rad/s],
# which is stored as `change_rate`. The value is small, because a cubic has no sixth derivative, to which the
# error of a step's interpolant is proportional (events/event_exclusion.py).
CUBIC_CHANGE = 0.5
# the largest distance, relative to the time at the end of the last step, at which this end counts as equal to
# another time: the end of a segment of a signal, or the communication point at which a piece of the inputs
# ends
TIME_ROUND_OFF = 4e-15


def apply_inputs(d):
    """Use the given inputs, prescribed motions, dampings and stiffnesses of drives from now on.

    `given.pending` is cleared.
    """
    d.given.pending = 0
    given, piece, piece_in_use = d.given, d.given.piece, d.inputs.piece
    piece_in_use.degree = piece.degree
    piece_in_use.change_rate = piece.change_rate
    piece_in_use.end = piece.end
    piece_in_use.middle, piece_in_use.scale = piece.middle, piece.scale
    for i in range(len(given.drive_damping)):
        d.inputs.drive_damping[i] = given.drive_damping[i]
        d.inputs.drive_stiffness[i] = given.drive_stiffness[i]
    for k in range(CHANNEL):
        values, powers = input_field(d.inputs, k), input_field(piece_in_use, k)
        given_values, given_powers = input_field(given, k), input_field(piece, k)
        for j in range(len(values)):
            values[j] = powers[0, j] = given_values[j]
            for m in range(1, piece_in_use.degree + 1):
                powers[m, j] = given_powers[m, j]
    for j in range(d.channel_count):
        for m in range(piece_in_use.degree + 1):
            d.channel.piece[m, j] = d.given_channel.piece[m, j]
    if d.signal_count > 0:
        set_signal_inputs(d, d.step.end)


def withdraw_request(d):
    """Clear the mark `given.pending`, because the given values are already in use."""
    d.given.pending = 0


def are_inputs_in_use(d):
    """Return whether inputs, prescribed motions, and dampings and stiffnesses of drives are as given.

    The result is False if the inputs in use, or the given ones, are not constant.
    """
    given, inputs, piece_in_use = d.given, d.inputs, d.inputs.piece
    if given.piece.degree > 0 or piece_in_use.degree > 0:
        return False
    for j in range(d.channel_count):
        if d.given_channel.piece[0, j] != d.channel.piece[0, j]:
            return False
    for i in range(len(given.drive_damping)):
        if (
            given.drive_damping[i] != inputs.drive_damping[i]
            or given.drive_stiffness[i] != inputs.drive_stiffness[i]
        ):
            return False
    for k in range(CHANNEL):
        given_values, powers = input_field(given, k), input_field(piece_in_use, k)
        for j in range(len(given_values)):
            if given_values[j] != powers[0, j]:
                return False
    return True


def ensure_inputs(d, y):
    """Set the inputs to their values at the time that the state y contains, unless they are constant.

    In a piece of a degree > 0 the prescribed motions are set, too (``set_inputs``).
    """
    if d.inputs.piece.degree > 0:
        set_inputs(d, d.step.time_origin + y[time_at(d.link_count)])
    elif d.signal_count > 0:
        set_signal_inputs(d, d.step.time_origin + y[time_at(d.link_count)])


def set_inputs(d, time):
    """Set the inputs to their values at a ``time`` [s], and the prescribed motions to those at this time."""
    piece = d.inputs.piece
    x = (time - piece.middle) * piece.scale
    for k in range(CHANNEL):
        if may_change_in_piece(d, k):
            values, powers = input_field(d.inputs, k), input_field(piece, k)
            for j in range(len(values)):
                values[j] = evaluate_polynomial(powers, piece.degree, j, x)
    if d.signal_count > 0:
        set_signal_inputs(d, time)
    if d.channel_count > 0:
        move_channels(d, time)


def set_signal_inputs(d, time):
    """Set the inputs that signals drive to their values at a ``time`` [s].

    If a signal drives the target of a drive, the signal's rate sets the target velocity. Prescribed motions
    are set by ``move_channels``.
    """
    for j in range(d.signal_count):
        k, i = d.signal.input[j], d.signal.index[j]
        if k == CHANNEL:
            continue
        u, rate, _ = signal_at(d, j, time)
        input_field(d.inputs, k)[i] = u
        if k == TARGET:
            input_field(d.inputs, k + 1)[i] = rate


def evaluate_polynomial(powers, degree, i, x):
    """Return the value at x of a polynomial of the given ``degree``, by Horner's scheme.

    Its coefficients are in column i of ``powers``: row k belongs to xᵏ.
    """
    total = powers[degree, i]
    for m in range(1, degree + 1):
        total = total * x + powers[degree - m, i]
    return total


def inputs_continue(d):
    """Return whether the next step can begin with the next piece of the inputs, without a restart.

    The result is True if only this piece has been set, if this piece continues the present one without a
    jump, and if the last step ends at the communication point.
    """
    return d.given.pending == CONTINUES and d.step.end - d.step.communication_point <= TIME_ROUND_OFF * abs(
        d.step.end
    )


def limit_to_input_piece(d, h):
    """Return a size ≤ h with which the next step does not pass the end of the present piece of the inputs.

    The step ends at the piece's end or well before (``limit_to_time``). If the inputs are constant, the
    result is h; also if the contact is regularized, although the step may then pass the end.
    """
    if d.inputs.piece.degree == 0 or is_regularized(d):
        return h
    return limit_to_time(d, d.inputs.piece.end, h)


def limit_to_time(d, time, h):
    """Return a size ≤ h [s] of the next step, with which the step does not pass the ``time`` [s].

    If h reaches ``time`` from the end of the last step, the step ends at ``time``. If h is less, but more
    than half of the time until then, the step takes half of this time, so that the following step is not
    tiny. If the last step has already reached ``time``, the size is h.
    """
    remaining_time = time - d.step.end
    if remaining_time <= 0.0 or 2.0 * h <= remaining_time:
        return h
    return remaining_time if h >= remaining_time else 0.5 * remaining_time


def belts_jump(d):
    """Return whether the speed of any belt jumps at the start of the present piece of the inputs."""
    return d.channel_count > 0 and d.given_channel.jumps != 0


def begin_prescribed_motions(d, time):
    """Begin all prescribed motions at a ``time`` [s], the start of a run.

    If ``given_channel.interpolates`` is 1, a base or wall begins with the polynomial of its given position,
    velocity and acceleration, and a belt with that of its given velocity; else the given polynomials stay.
    """
    given, channel, piece = d.given_channel, d.channel, d.given.piece
    channel.run_start, channel.cubic_end, channel.contradiction = time, time, 0
    for j in range(d.channel_count):
        channel.given_position[j], channel.given_velocity[j] = given.position[j], given.velocity[j]
        channel.given_acceleration[j] = given.acceleration[j]
        channel.given_time[j] = time
        channel.mean_velocity[j] = 0.0
        channel.start_position[j], channel.start_velocity[j] = given.position[j], given.velocity[j]
        channel.anchored[j] = 1 - given.belt[j]
    if not given.interpolates:
        return
    piece.degree, piece.middle, piece.scale, piece.end = 0, time, 1.0, math.inf
    piece.change_rate = 0.0
    given.jumps = 0
    for j in range(d.channel_count):
        for m in range(INPUT_DEGREE + 1):
            given.piece[m, j] = 0.0
        if given.belt[j]:
            given.piece[1, j] = given.velocity[j]
        else:
            given.piece[0, j], given.piece[1, j] = given.position[j], given.velocity[j]
            given.piece[2, j] = 0.5 * given.acceleration[j]
        if given.velocity[j] != 0.0 or given.acceleration[j] != 0.0:
            piece.degree = 2


def interpolate_prescribed_motions(d, time):
    """Set the cubics of prescribed motions until a ``time`` [s], the next communication point.

    Each cubic starts at the present position and velocity of its channel, and ends on the motion that the
    given values describe. A motion that a signal drives has no cubic. Nothing is done if the polynomials are
    given, if ``time`` is the communication point or before it, or if the cubics until ``time`` are already
    set. If any channel moves before or after the communication point, ``given.pending`` becomes CONTINUES; or
    REINITIALIZE if an acceleration jumps, or if this is already its value.

    Returns:
        WALL_JUMPS if the given position of a wall jumps (see UNEXPLAINED_PART); else OK.
    """
    given, channel, piece = d.given_channel, d.channel, d.given.piece
    if d.channel_count == 0 or not given.interpolates or not time > d.step.communication_point:
        return OK
    if time == channel.cubic_end and d.given.pending != REINITIALIZE:
        return OK  # the same communication step continues after a pause, so all is set
    start, h = d.step.communication_point, time - d.step.communication_point
    move_channels(d, start)
    for j in range(d.channel_count):
        if not has_signal(d, j) and not store_given_motion(d, j, start):
            return refuse_channel(d, j)
    channel.cubic_end = time
    moves, jumps = False, False
    for j in range(d.channel_count):
        if has_signal(d, j):
            continue
        is_smooth = set_cubic(d, j, time, h)
        is_moving = given.piece[1, j] != 0.0 or given.piece[2, j] != 0.0 or given.piece[3, j] != 0.0
        moves, jumps = moves or is_moving, jumps or not is_smooth
    if not moves and d.inputs.piece.degree == 0:
        return OK
    piece.degree, piece.middle, piece.scale = 3 if moves else 0, start + 0.5 * h, 2.0 / h
    piece.end = time + TIME_ROUND_OFF / 4.0 * abs(time) if moves else math.inf
    piece.change_rate = CUBIC_CHANGE / h if moves else 0.0
    given.jumps = 0
    if d.given.pending != REINITIALIZE:
        d.given.pending = REINITIALIZE if jumps else CONTINUES
    return OK


def refuse_channel(d, j):
    """Store the cause of a fault, the first candidate at the wall that channel j moves; return WALL_JUMPS."""
    first = 0
    for c in range(d.candidate_count):
        if d.wall_motion.first_channel[d.candidate_count - 1 - c] == j:
            first = d.candidate_count - 1 - c
    return refuse_part(d, CANDIDATE_PART, first, WALL_JUMPS)


def set_cubic(d, j, time, h):
    """Set the cubic of channel j from the communication point until ``time`` [s], which is ``h`` [s] later.

    Return whether the acceleration at the cubic's start equals the present acceleration of the channel.
    """
    given, channel = d.given_channel, d.channel
    s, v, duration = channel.position[j], channel.velocity[j], time - channel.given_time[j]
    speed = channel.start_velocity[j] + channel.mean_velocity[j]
    v_end = speed + duration * given.acceleration[j]
    if channel.anchored[j]:
        s_end = channel.start_position[j] + duration * (speed + 0.5 * duration * given.acceleration[j])
    else:
        s_end = s + 0.5 * h * (v + v_end)
    v, v_end = 0.5 * h * v, 0.5 * h * v_end
    term_sum = abs(s) + abs(s_end) + abs(v) + abs(v_end)
    cubic = 0.25 * (s - s_end + v + v_end)
    if not abs(cubic) > ACCELERATION_ROUND_OFF * term_sum:
        cubic = 0.0
    given.piece[3, j] = cubic
    given.piece[2, j] = 0.25 * (v_end - v)
    given.piece[1, j] = 0.5 * (s_end - s) - cubic
    given.piece[0, j] = 0.5 * (s + s_end) - given.piece[2, j]
    jump = (given.piece[2, j] - 3.0 * cubic) * 8.0 - channel.acceleration[j] * h * h
    return abs(jump) <= ACCELERATION_ROUND_OFF * term_sum


def store_given_motion(d, j, time):
    """Record the values that are given to channel j at the communication point ``time`` [s].

    Return False if the position of a wall jumps, else True. A base that is given a new position without
    velocities gets the mean velocity since its previous given position. The channel of the first
    contradiction between position and velocity, or of a jump, is stored in `channel.contradiction`, counted
    from 1.
    """
    given, channel = d.given_channel, d.channel
    s, v, a = given.position[j], given.velocity[j], given.acceleration[j]
    has_same_position = s == channel.given_position[j] and channel.mean_velocity[j] == 0.0
    if has_same_position and v == channel.given_velocity[j] and a == channel.given_acceleration[j]:
        return True
    duration = time - channel.given_time[j]
    v_before = channel.start_velocity[j]
    displacement = s - channel.start_position[j]
    is_at_rest = v == 0.0 and a == 0.0 and v_before == 0.0
    has_new_velocity = v != channel.given_velocity[j]
    channel.given_position[j], channel.given_velocity[j], channel.given_acceleration[j] = s, v, a
    channel.given_time[j] = time
    channel.mean_velocity[j] = 0.0
    channel.start_position[j] = s
    channel.start_velocity[j] = v
    channel.anchored[j] = 1
    if has_same_position:
        # no new position is given: the position continues from its present value, and so does the velocity
        # if only an acceleration is new
        channel.start_position[j], channel.anchored[j] = channel.position[j], 0
        channel.start_velocity[j] = v if has_new_velocity else channel.velocity[j]
        return True
    excess = abs(displacement - 0.5 * duration * (v_before + v)) - 0.5 * duration * abs(v - v_before)
    largest_displacement = duration * (abs(v_before) + abs(v))
    ignored_displacement = UNEXPLAINED_DISPLACEMENT * d.chain.longest_link
    if not excess > UNEXPLAINED_PART * largest_displacement + ignored_displacement:
        return True
    moves_base = d.chain.base_moves and j < 2  # a moving base has the first two channels
    is_refused = not moves_base and excess > largest_displacement + ignored_displacement
    if is_refused or channel.contradiction == 0:
        channel.contradiction, channel.contradiction_distance = j + 1, displacement
        channel.contradiction_duration, channel.contradiction_velocity = duration, v
    if is_refused:
        return False
    if is_at_rest and duration > 0.0:
        channel.mean_velocity[j] = displacement / duration
    return True
