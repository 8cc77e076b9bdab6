"""Derivatives by the rise time of a sine signal, where this time is 0; one-sided, as no rise time is < 0.

At the start a sine differs from its mean m by J = a sin ψ, with the amplitude a and the phase ψ. With a rise
time ρ the input is m + r J, where r grows from 0 to 1 in the time ρ. To first order in ρ the motion
lacks the effect of J for the time ∫ (1 − r) dt = ½ ρ: the input jumps from m to m + J a time ½ ρ after the
start. So the rates ẏ with the two inputs give y′ = ½ (ẏ(m) − ẏ(m + J)) ρ′, as at any other jump.

This is valid if ẏ is linear in the input. Contacts, dry friction and limits of drives may change during the
rise, so with any of these there is no derivative. A derivative is also missing where the motion with a short
rise is not near the motion without a rise: where position or velocity of the base, or the target of a servo,
jumps at the start of the sine; and where a sine starts within the run, as the value before the start is m
with a rise, but m + J without.
"""

import math

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.chain.signals import drives_base
from chain_impact.kernel.chain.sines import TAU
from chain_impact.kernel.constraints.geometry import clearance_and_rate
from chain_impact.kernel.events.segments import shift_start
from chain_impact.kernel.mathematics.angles import unit_vector
from chain_impact.kernel.ode.last_step import evaluate_start
from chain_impact.kernel.record.constants import SINE
from chain_impact.kernel.record.input_fields import CHANNEL, TARGET
from chain_impact.kernel.tangent.duals import DIRECTIONS, dual_with_slope, has_slope, slope, value

# ∫ (1 − r) dx over a rise, with x from 0 to 1 and r = 10 x³ − 15 x⁴ + 6 x⁵: the rise acts like a jump that is
# late by this part of the rise time
MISSING_RISE_PART = 0.5
# a sine or cosine of a phase counts as 0 if its absolute value is at most PHASE_ROUND_OFF
PHASE_ROUND_OFF = 1e-12


def check_rises(t):
    """Clear ``trust.missing``, then mark in it the directions in which a rise time of 0 has no derivative."""
    for k in range(DIRECTIONS):
        t.trust.missing[k] = 0
    for j in range(t.signal_count):
        if is_sudden(t, j) and not is_differentiable(t, j):
            rise = t.signal.rise[t.signal.source[j]]
            for k in range(DIRECTIONS):
                if slope(rise, k) != 0.0:
                    t.trust.missing[k] = 1


def is_sudden(t, j):
    """Return whether signal j is a sine with the rise time 0, and this time has derivatives in t."""
    rise = t.signal.rise[t.signal.source[j]]
    return t.signal.form[j] == SINE and value(rise) == 0.0 and has_slope(rise)


def is_differentiable(t, j):
    """Return whether the motion has a derivative with respect to the rise time 0 of signal j."""
    signal = t.signal
    begins = value(signal.start[signal.source[j]]) - value(t.step.end)
    if begins < 0.0:
        return True
    jump, speed = jump_at_begin(t, j)
    # `moves`: the input is a position, so the signal moves a base or a wall directly
    moves = signal.input[j] == CHANNEL and signal.integrals[j] == 0
    if jump == 0.0 and (speed == 0.0 or not moves):
        return True
    if begins > 0.0 or signal.input[j] == TARGET:
        return False
    if drives_base(t, j):
        return signal.integrals[j] == 2 and is_linear(t)
    # if the signal moves a wall, the wall starts −``jump`` farther inward with a rise than without a rise: no
    # point may lie in between
    return is_linear(t) and (not moves or nearest_clearance(t) > -jump)


def jump_at_begin(t, j):
    """Return the jump J = a sin ψ of the sine of signal j at the start, and the rate of the sine there.

    a is the amplitude of the sine, ψ the phase at the start. Both results have no derivatives.
    """
    signal, i = t.signal, t.signal.source[j]
    cosine, sine = unit_vector(signal.phase[i])
    a, omega = value(signal.amplitude[i]), TAU * value(signal.frequency[i])
    jump = a * value(sine) if abs(value(sine)) > PHASE_ROUND_OFF else 0.0
    speed = a * omega * value(cosine) if abs(value(cosine)) > PHASE_ROUND_OFF else 0.0
    return jump, speed


def is_linear(t):
    """Return whether the rates at the start of the run are linear in the inputs."""
    return t.contacts.active_count == 0 and t.friction.active_count == 0 and not t.chain.has_drive_limits


def nearest_clearance(t):
    """Return the least clearance [m] of all candidates at the end of the last step, without derivatives."""
    least_clearance = math.inf
    locate_points(t, t.step.state_end)
    for c in range(t.candidate_count):
        clearance, _ = clearance_and_rate(t, c)
        least_clearance = min(least_clearance, value(clearance))
    return least_clearance


def delay_jumps(t):
    """Give the state at the start of the run the derivatives with respect to rise times of 0.

    A sine that starts at this time, with a rise time of 0, may begin with a jump; a rise delays this jump.
    """
    for j in range(t.signal_count):
        i = t.signal.source[j]
        jump, _ = jump_at_begin(t, j)
        if is_sudden(t, j) and value(t.signal.start[i]) == value(t.step.end) and jump != 0.0:
            delay_jump(t, j, jump, dual_with_slope(0.0, MISSING_RISE_PART, t.signal.rise[i]))


def delay_jump(t, j, jump, delay):
    """Give the run the derivatives of a ``delay`` [s] of the ``jump`` with which signal j begins.

    The derivatives of the state change by the delay times (ẏ before − ẏ after the jump), unless the signal
    gives the position or velocity of a wall, which does not change ẏ without contact. If the kernel
    integrates the signal over time, the signal's first integral changes by −``jump`` times the delay.
    """
    k, m = t.signal.segment[j], t.signal.integrals[j]
    if t.signal.input[j] != CHANNEL or m == 2:
        powers = t.knot.powers[k, m]
        t.knot.powers[k, m] = powers - (jump if m == 0 else 0.5 * jump)
        evaluate_start(t)
        shift_start(t, delay)
        t.knot.powers[k, m] = powers
    if m > 0:
        t.knot.powers[k, m - 1] -= jump * delay
    evaluate_start(t)
    if t.signal.input[j] != CHANNEL or m == 2:
        shift_start(t, dual_with_slope(0.0, -1.0, delay))
