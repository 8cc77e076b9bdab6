"""Peaks without derivatives: those at two events whose order depends on the parameters.

Two signals may jump at one time. If a parameter moves one of them, a force has a third value between the
jumps, which may be larger than the values on both sides.
"""

import math

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.forces.active_contacts import contact_force, set_extremes, set_joint_square
from chain_impact.kernel.loads import set_load_peak, square_of_force
from chain_impact.kernel.ode.last_step import set_start_delay
from chain_impact.kernel.rows.geometry import clearance
from chain_impact.kernel.tangent.duals import DIRECTIONS, slope, value, with_slope

# the largest difference of a contact's forces at the end of a step that counts as round-off, relative to the
# contact's peak force
FORCE_ROUND_OFF = 1e-9


def forget_peaks(t, delay):
    """Set the derivatives of peaks at the end of the last step, and at the start of the next one, to NaN.

    This applies to the directions in which the ``delay`` [s] of an event there has derivatives.
    """
    set_start_delay(t, with_unknown_slopes(t.step.start_delay, delay))
    for i in range(t.links if t.loads > 0 else 0):
        at_end, peak = value(square_of_force(t, i)), t.transmitted.peak[i]
        if at_end >= value(peak):
            set_load_peak(t, i, with_unknown_slopes(peak, delay))
        for k in range(t.touch.active_count):
            c = t.touch.active_index[k]
            if at_end >= value(t.touch.joint_square[c]):
                set_joint_square(t, c, with_unknown_slopes(t.touch.joint_square[c], delay), t.touch.joint[c])
    if t.touch.compliant_count > 0:
        locate_points(t, t.step.state_end)
    for k in range(t.touch.active_count):
        c = t.touch.active_index[k]
        peak = t.touch.peak_force[c]
        if k >= t.touch.compliant_count:
            at_end = value(t.constraints.sample[1, k])
        else:
            # the force does not jump, because the position and the velocity of the point do not
            gap, gap_rate = clearance(t, c)
            at_end = value(contact_force(t, c, gap, gap_rate)) + FORCE_ROUND_OFF * value(peak)
        if at_end >= value(peak):
            set_extremes(t, c, with_unknown_slopes(peak, delay), t.touch.max_penetration[c])


def with_unknown_slopes(number, delay):
    """Return a number whose derivatives are NaN in the directions in which ``delay`` has derivatives.

    The other derivatives stay.
    """
    for k in range(DIRECTIONS):
        if slope(delay, k) != 0.0:
            number = with_slope(number, k, math.nan)
    return number
