"""The ends of the segments of signals (chain/signals.py), where a driven input may jump or bend.

The times of these ends are known, so no search is needed: a step ends where a segment ends, and the next step
begins with the next segment. The duration of a step in the fictitious time of a contact is not known
beforehand, so such a step is truncated at the end of the segment.
"""

from chain_impact.kernel.chain.inputs import TIME_ROUND_OFF, ensure_inputs, limit_to_time
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.chain.signals import next_segment, segment_end, set_segment, signal_at
from chain_impact.kernel.equations import energy_balance
from chain_impact.kernel.events.handlers import restart_contacts_and_modes
from chain_impact.kernel.events.marks import drop_events
from chain_impact.kernel.function_marks import has_dual_rule
from chain_impact.kernel.ode.dense_output import fraction_at_time
from chain_impact.kernel.ode.falls import correct_falls
from chain_impact.kernel.ode.last_step import (
    count_supplied,
    ensure_dense,
    evaluate_start,
    reset_step,
    truncate_step,
)
from chain_impact.kernel.ode.quadratures import commit_quadratures
from chain_impact.kernel.record.constants import SOLVER_READER
from chain_impact.kernel.record.input_fields import CHANNEL
from chain_impact.kernel.record.method import is_regularized
from chain_impact.kernel.status import OK, SIGNAL_JUMPS

# The effect of the end of a signal's segment on the motion. NO_JUMP: neither speeds nor accelerations jump.
# ACCELERATION_JUMPS: an input, or the acceleration of a channel, jumps; accelerations of the chain may jump.
# SPEED_JUMPS: the speed of a belt jumps, and so do speeds of sliding on it.
NO_JUMP, ACCELERATION_JUMPS, SPEED_JUMPS = 0, 1, 2
# The values of a signal before and after the end of a segment are equal if their difference is at most
# JUMP_TOLERANCE, relative to a sum: the absolute values before and after, and a scale that the caller of
# ``equal_up_to_round_off`` gives.
JUMP_TOLERANCE = 1e-9


def limit_to_signal_segment(d, h):
    """Return a size ≤ h of the next step, with which it does not pass the first end of the segments in use.

    The step ends exactly at that time or well before it (``limit_to_time``). A step in the fictitious time of
    a contact keeps the size h; if it passes that time, ``end_at_segment`` cuts it.
    """
    return h if is_regularized(d) else limit_to_time(d, first_segment_end(d), h)


def first_segment_end(d):
    """Return the time [s] at which the first of the segments in use ends."""
    first = segment_end(d, 0)
    for j in range(1, d.signal_count):
        first = min(first, segment_end(d, j))
    return first


def end_at_segment(d):
    """End the last step where a segment ends, if the step goes beyond that time."""
    end = first_segment_end(d)
    if end < d.step.end - TIME_ROUND_OFF * abs(d.step.end):
        drop_events(d)
        ensure_dense(d, SOLVER_READER)
        truncate_step(d, fraction_at_time(d, end))
        correct_falls(d)
        locate_points(d, d.step.state_end)


def has_segment_ended(d, j):
    """Return whether the present segment of signal j ends at the end of the last step, up to round-off."""
    return segment_end(d, j) - d.step.end <= TIME_ROUND_OFF * abs(d.step.end)


def check_segments(d):
    """Return SIGNAL_JUMPS if a new segment makes the position or velocity of base or wall jump, else OK.

    The travel and the speed of a belt may jump.
    """
    for j in range(d.signal_count):
        if d.signal.input[j] == CHANNEL and has_segment_ended(d, j):
            before, rate, curvature = signal_at(d, j, d.step.end)
            k, lap = d.signal.segment[j], d.signal.lap[j]
            begin_next_segment(d, j)
            after, rate_after, curvature_after = signal_at(d, j, d.step.end)
            set_segment(d, j, k, lap)
            longest_link = d.chain.longest_link
            jumps = not equal_up_to_round_off(before, after, abs(rate) + abs(rate_after) + longest_link)
            jumps = jumps or not equal_up_to_round_off(
                rate, rate_after, abs(curvature) + abs(curvature_after) + longest_link
            )
            if jumps and not d.given_channel.belt[d.signal.index[j]]:
                return SIGNAL_JUMPS
    return OK


def equal_up_to_round_off(before, after, scale):
    """Return whether two numbers are equal up to round-off, relative to |before| + |after| + ``scale``."""
    return abs(after - before) <= JUMP_TOLERANCE * (abs(before) + abs(after) + scale)


def begin_next_segment(d, j):
    """Replace the segment of signal j, which has ended, by the segment that begins now."""
    while has_segment_ended(d, j):
        next_segment(d, j)


def begin_segments(d):
    """Begin the segments that follow the segments which end at the end of the last step.

    If the target of a drive jumps, the drive's spring gains or loses energy at once, which counts as supplied
    energy. If an acceleration or a speed jumps, held contacts and modes are chosen again, and the last step
    is reset to zero length.

    Returns:
        The largest effect of these segments on the motion, in the order NO_JUMP < ACCELERATION_JUMPS <
        SPEED_JUMPS.
    """
    last_signal = -1
    for j in range(d.signal_count):
        if has_segment_ended(d, j):
            last_signal = j
    effect = NO_JUMP
    for j in range(last_signal + 1):
        if has_segment_ended(d, j):
            delay = segment_end(d, j) - d.step.end
            shift_start(d, delay)
            effect = max(effect, begin_segment(d, j))
            if effect != NO_JUMP and j == last_signal:
                commit_quadratures(d)
                restart_contacts_and_modes(d, effect == SPEED_JUMPS)
                reset_step(d, d.step.end, d.step.state_end)
            if effect != NO_JUMP or d.channel_count > 0:
                evaluate_start(d)
            shift_start(d, -delay)
    return effect


def begin_segment(d, j):
    """Begin the next segment of signal j; return its effect on the motion, such as SPEED_JUMPS.

    If the target of a drive jumps, the drive's spring gains or loses energy at once, which counts as supplied
    energy.
    """
    y = d.step.state_end
    stores_energy = d.signal.input[j] != CHANNEL
    locate_points(d, y)
    ensure_inputs(d, y)
    energy = energy_balance(d, y) if stores_energy else 0.0
    before, rate, curvature = signal_at(d, j, d.step.end)
    begin_next_segment(d, j)
    after, rate_after, curvature_after = signal_at(d, j, d.step.end)
    locate_points(d, y)
    ensure_inputs(d, y)
    longest_link = d.chain.longest_link
    if stores_energy:
        # a signal of a channel adds no energy here: the position and velocity of base and walls never jump,
        # and a belt stores no energy
        count_supplied(d, energy_balance(d, y) - energy)
        # the energy `energy_scale` [J] serves as the natural scale of torques, forces and angles alike
        return (
            NO_JUMP
            if equal_up_to_round_off(before, after, abs(rate) + abs(rate_after) + d.chain.energy_scale)
            else ACCELERATION_JUMPS
        )
    if d.given_channel.belt[d.signal.index[j]] and not equal_up_to_round_off(
        rate, rate_after, abs(curvature) + abs(curvature_after) + longest_link
    ):
        return SPEED_JUMPS
    return (
        NO_JUMP
        if equal_up_to_round_off(curvature, curvature_after, abs(rate) + abs(rate_after) + longest_link)
        else ACCELERATION_JUMPS
    )


@has_dual_rule
def shift_start(_d, _delay):
    """Do nothing: the ``delay`` [s] of the start of the next step is only round-off.

    In a tangent instance the delay has derivatives, and a rule in tangent/rules.py shifts the start.
    """
