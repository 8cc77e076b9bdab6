"""The derivatives of event times: the time at which a function φ of the motion is zero depends on parameters.

The delay of an event is a dual number [s] of the value 0, with the derivatives −φ′/φ̇. φ′ are the derivatives
of φ with respect to the parameters at a fixed time, and φ̇ is the rate of φ in time. For clearances, rates of
clearances and tangential speeds, φ̇ is known; for forces, the kinks of forces, and the margins of friction
and drives, φ̇ is the derivative with respect to a shift along the motion.
"""

import math

from chain_impact.kernel.chain.drives import mode_margin
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.chain.signals import segment_end
from chain_impact.kernel.constraints.geometry import clearance_acceleration, clearance_and_rate
from chain_impact.kernel.equations import rate_from_points
from chain_impact.kernel.events.event_exclusion import RELATCH_RATIO
from chain_impact.kernel.events.segments import has_segment_ended
from chain_impact.kernel.forces.active_contacts import kink_height
from chain_impact.kernel.ode.last_step import ensure_points
from chain_impact.kernel.record.constants import KINK, RELATCH
from chain_impact.kernel.tangent.duals import dual_with_slope, reciprocal, replace_slope, slope, value

# number of Newton iterations for a delay: each multiplies the error of the delay by the relative error of φ̇
NEWTON_ITERATIONS = 2


def step_length(t):
    """Return the length of the last step [s], without derivatives."""
    return value(t.step.end - t.step.start)


def make_motion_functions(function):
    """Return two functions, for φ and for the rate φ̇ along the motion; ``function`` is φ, of (t, c).

    φ uses located points and known forces. The state beyond the end of the last step is extrapolated by ẏ.

    Returns:
        A function of (t, c, delay) that returns φ with a ``delay`` [s], a dual number, after the end of the
        last step; and a function of (t, c) that returns φ̇ at this end, without derivatives. Both leave the
        points located at another time.
    """

    def after(t, c, delay):
        y, state, rate = t.scratch.state, t.step.state_end, t.scratch.rate_end
        for j in range(len(y)):
            y[j] = state[j] + value(rate[j]) * delay
        locate_points(t, y)
        rate_from_points(t, y, t.scratch.rate)
        return function(t, c)

    def rate_at_end(t, c):
        if not step_length(t) > 0.0:
            return 0.0
        no_delay = dual_with_slope(0.0, 0.0, t.step.end)
        # with a delay of slope 1 in a direction, the slope of φ in this direction is φ′ + φ̇
        moved = slope(after(t, c, replace_slope(no_delay, 0, 1.0)), 0)
        return moved - slope(after(t, c, no_delay), 0)

    return after, rate_at_end


def make_delay(after):
    """Return a function of (t, c, rate) for the delay [s] of the event φ = 0 at the end of the last step.

    ``after`` is the first function that ``make_motion_functions`` returns for φ, and ``rate`` is φ̇ at the
    event. When the returned function ends, points and forces are again those at the end of the last step.
    """

    def find_delay(t, c, rate):
        delay = dual_with_slope(0.0, 0.0, t.step.end)
        for _ in range(NEWTON_ITERATIONS):
            delay += dual_with_slope(0.0, -reciprocal(rate), after(t, c, delay))
        evaluate_end(t)
        return delay

    return find_delay


def evaluate_end(t):
    """Locate and accelerate the points, and evaluate the forces, at the end of the last step again."""
    locate_points(t, t.step.state_end)
    rate_from_points(t, t.step.state_end, t.scratch.rate)
    ensure_points(t)


_kink_after, _kink_rate = make_motion_functions(kink_height)
_delay_of_kink = make_delay(_kink_after)
_force_after, _force_rate = make_motion_functions(lambda t, c: t.contacts.force[c])
_delay_of_release = make_delay(_force_after)
_margin_after, _margin_rate = make_motion_functions(lambda t, _c: mode_margin(t, t.scratch.state))
_delay_of_margin = make_delay(_margin_after)


def delay_of_crossing(t, c, kind):
    """Return the delay [s], a dual number of value 0, of an event of candidate c.

    ``kind`` is ONSET, CONTACT_ENDS or RELATCH of record/constants.py; at RELATCH the speed is latched again.
    """
    clearance, clearance_rate = clearance_and_rate(t, c)
    if kind == RELATCH:
        # RELATCH: φ is the rate −ġ of the penetration minus RELATCH_RATIO v₀, with the latched speed v₀
        change = -clearance_rate - RELATCH_RATIO * t.contacts.latched_speed[c]
        rate = -clearance_acceleration(t, c)
    else:
        change, rate = clearance, clearance_rate
    return dual_with_slope(0.0, -reciprocal(value(rate)), change)


def delay_without_force_jump(t, c, kind):
    """Return the delay [s] of an event of candidate c at which the candidate's force does not jump.

    ``kind`` is KINK or RELEASE of record/constants.py.
    """
    if kind == KINK:
        rate = _kink_rate(t, c)
        return _delay_of_kink(t, c, rate if rate != 0.0 else math.inf)
    rate = _force_rate(t, c)
    return _delay_of_release(t, c, rate if rate != 0.0 else math.inf)


def delay_of_saturation(t):
    """Return the delay [s] of the time at which a drive reaches its limit or falls below the limit."""
    rate = _margin_rate(t, 0)
    return _delay_of_margin(t, 0, rate if rate != 0.0 else math.inf)


def delay_of_segment(t):
    """Return the delay [s] of the end of the segment that ends with the last step, of the first such signal.

    If no signal's segment ends there, the result is 0 without derivatives.
    """
    for j in range(t.signal_count):
        if has_segment_ended(t, j):
            return dual_with_slope(0.0, 1.0, segment_end(t, j) - t.step.end)
    return dual_with_slope(0.0, 0.0, t.step.end)
