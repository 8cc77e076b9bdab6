"""Motions of a pinned base and of walls, given as functions of time.

A channel is the motion of a base, wall or belt in one direction. In a scene with a moving base the first two
channels are the motions of the base along x and y. A moving wall has two channels: the displacement of the
wall along its normal n, toward the free side, and the travel of its belt along the direction (n_y, −n_x). The
inputs of a run are divided into pieces of time (chain/inputs.py). In each piece the position s of a channel
is a polynomial,

    s(t) = c₀ + x (c₁ + x (c₂ + …)),   x = (t − middle) scale,

with the time t, and the middle and scale of the piece. If a signal drives a channel, chain/signals.py gives
the channel's position. The velocity and the acceleration of a channel are the derivatives of its position, so
the three always agree. The state does not contain the motion of a moving base: the entries of the base in the
state are 0. The points are located with the positions and velocities of the channels at the time of the
state.
"""

import math

from chain_impact.kernel.chain.signals import signal_at, signal_bounds
from chain_impact.kernel.chain.sines import TAU
from chain_impact.kernel.record.constants import SINE
from chain_impact.kernel.record.input_fields import CHANNEL
from chain_impact.kernel.record.state import time_at


def move_channels_to_state(d, y):
    """Set the motions of all channels to those at the time that the state y contains (``move_channels``)."""
    move_channels(d, d.step.time_origin + y[time_at(d.link_count)])


def move_channels(d, time):
    """Set position [m], velocity [m/s] and acceleration [m/s²] of all channels to those at a ``time`` [s].

    The function also moves the walls and belts that channels move, for all candidates.
    """
    channel, piece = d.channel, d.inputs.piece
    x, run_time = (time - piece.middle) * piece.scale, time - channel.run_start
    for m in range(d.channel_count):
        s, v, half_a = channel.piece[piece.degree, m], 0.0 * x, 0.0 * x
        for k in range(1, piece.degree + 1):
            half_a = half_a * x + v
            v = v * x + s
            s = s * x + channel.piece[piece.degree - k, m]
        # `added_position`, `added_velocity` and `added_acceleration` are 0; in a tangent instance they have
        # the derivatives of the given position, velocity and acceleration of the channel
        channel.position[m] = (
            s
            + channel.added_position[m]
            + run_time * (channel.added_velocity[m] + 0.5 * run_time * channel.added_acceleration[m])
        )
        channel.velocity[m] = (
            v * piece.scale + channel.added_velocity[m] + run_time * channel.added_acceleration[m]
        )
        channel.acceleration[m] = 2.0 * half_a * piece.scale * piece.scale + channel.added_acceleration[m]
    for j in range(d.signal_count):
        if d.signal.input[j] == CHANNEL:
            m = d.signal.index[j]
            channel.position[m], channel.velocity[m], channel.acceleration[m] = signal_at(d, j, time)
    for c in range(d.candidate_count):
        m = d.wall_motion.first_channel[c]
        if m >= 0:
            move_wall(d, c, m)


def move_wall(d, c, m):
    """Move the wall of candidate c along its normal with channel m, and its belt with the next channel."""
    wall, channel = d.wall_motion, d.channel
    d.candidate.offset[c] = wall.unmoved_offset[c] + channel.position[m]
    wall.velocity[c], wall.acceleration[c] = channel.velocity[m], channel.acceleration[m]
    wall.travel[c], wall.belt_velocity[c] = channel.position[m + 1], channel.velocity[m + 1]
    wall.belt_acceleration[c] = channel.acceleration[m + 1]


def channel_bounds(d, m):
    """Return upper bounds of |velocity| [m/s] and |acceleration| [m/s²] of channel m over the last step."""
    piece, channel = d.inputs.piece, d.channel
    scale = piece.scale
    largest_x = max(abs(d.step.start - piece.middle), abs(d.step.end - piece.middle)) * scale
    speed, acceleration = 0.0 * largest_x, 0.0 * largest_x
    for k in range(1, piece.degree + 1):
        p = piece.degree + 1 - k
        coefficient = p * abs(channel.piece[p, m])
        speed = speed * largest_x + coefficient
        if p > 1:
            acceleration = acceleration * largest_x + (p - 1) * coefficient
    speed, acceleration = speed * scale, acceleration * scale * scale
    for j in range(d.signal_count):
        if d.signal.input[j] == CHANNEL and d.signal.index[j] == m:
            speed, acceleration = signal_bounds(d, j)
    return speed, acceleration


def fastest_wall(d):
    """Return the largest present speed [m/s] and acceleration [m/s²] of all moving walls and belts.

    A wall's motion along its normal and the motion of its belt count separately.
    """
    speed, acceleration = 0.0, 0.0
    for c in range(d.candidate_count):
        if d.wall_motion.first_channel[c] >= 0:
            speed = max(speed, abs(d.wall_motion.velocity[c]), abs(d.wall_motion.belt_velocity[c]))
            acceleration = max(
                acceleration, abs(d.wall_motion.acceleration[c]), abs(d.wall_motion.belt_acceleration[c])
            )
    return speed, acceleration


def travel_of_piece(d):
    """Return an estimate of how far [m] any channel moves from its position at the middle of the used piece.

    The estimate is the sum of two numbers: the largest sum |c₁| + |c₂| + … of the coefficients of any
    channel's polynomial, and ``travel_of_sines``, the sum of the amplitudes of all channels that sines drive.
    """
    largest_sum = 0.0
    for m in range(d.channel_count):
        coefficient_sum = 0.0
        for p in range(1, d.inputs.piece.degree + 1):
            coefficient_sum += abs(d.channel.piece[p, m])
        largest_sum = max(largest_sum, coefficient_sum)
    return largest_sum + travel_of_sines(d)


def travel_of_sines(d):
    """Return an estimate of the sum [m] of the amplitudes of all prescribed motions that sines drive.

    An amplitude is that of a position: a sine that gives a velocity is integrated once, a sine that gives an
    acceleration twice.
    """
    signal, amplitude_sum = d.signal, 0.0
    for j in range(d.signal_count):
        if signal.form[j] == SINE and signal.input[j] == CHANNEL:
            i = signal.source[j]
            amplitude = abs(signal.amplitude[i])
            # While the frequency f passes 0 at the rate ḟ, the sine turns slowly, and the integral of a sine
            # with the amplitude a changes by about a/√|ḟ|.
            least_rate = math.sqrt(abs(signal.frequency_rate[i]))
            passes_zero = signal.frequency[i] * signal.frequency_rate[i] < 0.0
            for _ in range(signal.integrals[j]):
                amplitude /= least_rate if passes_zero else max(TAU * abs(signal.frequency[i]), least_rate)
            amplitude_sum += amplitude
    return amplitude_sum
