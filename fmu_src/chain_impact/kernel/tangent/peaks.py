"""Peaks at an event whose order with another event depends on the parameters: they have no derivatives.

Two signals may jump at one time. If a parameter moves one of them, a force has a third value between the
jumps, which may be larger than the values on both sides.
"""

import math

from chain_impact.kernel.forces.contact import set_extremes, set_joint_top
from chain_impact.kernel.loads import set_load_peak, square_of_force
from chain_impact.kernel.ode.last_step import delay_start
from chain_impact.kernel.tangent.duals import DIRECTIONS, slope, sloped, value


def forget_peaks(t, delay):
    """Set the derivatives of peaks at the end of the last step, and at the start of the next one, to NaN.

    This applies to the directions in which the ``delay`` [s] of an event there has derivatives.
    """
    delay_start(t, unknown(t.step.start_delay, delay))
    for i in range(t.links if t.loads > 0 else 0):
        at_end, peak = value(square_of_force(t, i)), t.transmitted.peak[i]
        if at_end >= value(peak):
            set_load_peak(t, i, unknown(peak, delay))
        for k in range(t.touch.active_count):
            c = t.touch.active_index[k]
            if at_end >= value(t.touch.joint_top[c]):
                set_joint_top(t, c, unknown(t.touch.joint_top[c], delay), t.touch.joint[c])
    for k in range(t.touch.active_count):
        c = t.touch.active_index[k]
        held, peak = k >= t.touch.compliant_count, t.touch.peak_force[c]
        rises = value(t.rigid.sample[1, k]) >= value(peak) if held else value(t.touch.force_rate[c]) > 0.0
        if rises:
            set_extremes(t, c, unknown(peak, delay), t.touch.max_penetration[c])


def unknown(number, delay):
    """Return a number with the derivative NaN in each direction in which a ``delay`` has a derivative."""
    for k in range(DIRECTIONS):
        if slope(delay, k) != 0.0:
            number = sloped(number, k, math.nan)
    return number
