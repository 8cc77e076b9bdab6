"""Peaks without derivatives: peaks at two simultaneous events whose order depends on the parameters.

Two signals may jump at one time. If a parameter moves one of the jumps, a force has a third value between the
jumps, which may be larger than the values before and after both jumps.
"""

import math

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.constraints.geometry import clearance_and_rate
from chain_impact.kernel.forces.active_contacts import contact_force, set_contact_extremes, set_joint_square
from chain_impact.kernel.ode.last_step import set_start_delay
from chain_impact.kernel.tangent.duals import DIRECTIONS, replace_slope, slope, value
from chain_impact.kernel.transmitted_forces import set_joint_force_peak, square_of_force

# the force of a contact with a force law at the end of a step counts as the contact's peak if it is below the
# stored peak by at most this part of the peak
FORCE_ROUND_OFF = 1e-9


def forget_peaks(t, delay):
    """Set derivatives of peaks to NaN if the peak lies where the last step ends and the next step begins.

    Only the derivatives in directions in which the ``delay`` [s] of an event at this time has derivatives are
    set. A peak that is found later, at the start of the next step, gets NaN from ``step.start_delay``.
    """
    set_start_delay(t, replace_slopes_by_nan(t.step.start_delay, delay))
    for i in range(t.link_count if t.transmitted_row_count > 0 else 0):
        at_end, peak = value(square_of_force(t, i)), t.transmitted.peak_square[i]
        if at_end >= value(peak):
            time = replace_slopes_by_nan(t.transmitted.peak_time[i], delay)
            set_joint_force_peak(t, i, replace_slopes_by_nan(peak, delay), time)
        for k in range(t.contacts.active_count):
            c = t.contacts.active_index[k]
            if at_end >= value(t.contacts.joint_square[c]):
                set_joint_square(
                    t, c, replace_slopes_by_nan(t.contacts.joint_square[c], delay), t.contacts.joint[c]
                )
    if t.contacts.force_law_count > 0:
        locate_points(t, t.step.state_end)
    for k in range(t.contacts.active_count):
        c = t.contacts.active_index[k]
        peak = t.contacts.peak_force[c]
        if k >= t.contacts.force_law_count:
            at_end = value(t.constraints.sampled_force[1, k])
        else:
            # The force of a force law does not jump where the two steps meet, because position and velocity
            # of the point do not jump. If this value is the peak, the peak's derivatives get NaN below.
            clearance, clearance_rate = clearance_and_rate(t, c)
            at_end = value(contact_force(t, c, clearance, clearance_rate)) + FORCE_ROUND_OFF * value(peak)
        if at_end >= value(peak):
            set_contact_extremes(t, c, replace_slopes_by_nan(peak, delay), t.contacts.max_penetration[c])


def replace_slopes_by_nan(number, delay):
    """Return ``number`` with NaN as derivatives in the directions in which ``delay`` has derivatives.

    The other derivatives stay.
    """
    for k in range(DIRECTIONS):
        if slope(delay, k) != 0.0:
            number = replace_slope(number, k, math.nan)
    return number
