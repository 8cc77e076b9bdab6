"""Sundman regularization: a step's integration variable is time or, in an impact, that of the contact.

A force K δⁿ with n = 3/2 is not smooth in time where its contact begins and where it ends: there δ is
proportional to the time from that end, and the force to its power 3/2. An explicit method then loses its
order and needs very small steps near both ends. The force is smooth in the variable s of Sundman's
transformation,

    dt = p ds,   p = u/(1 + u²),   u = √(δ/δ*),   du/ds = δ̇/(2 δ* (1 + u²)),

with δ* the expected penetration: at the ends δ is proportional to s², and F to s³. The denominator makes an
impact as smooth in its middle as at its ends, so that one step size suits all of it. So u and t are part of
the state y, and the variable of a step is s, the fictitious time of the *regularized contact*, which must be
the only active one. Without it p = 1, and s is time.

Source: K. F. Sundman 1913, Mémoire sur le problème des trois corps, Acta Mathematica 36:105, where the
distance of two bodies takes the place of p.
"""

import math

from chain_impact.kernel.chain.state import sundman_u_at, time_at
from chain_impact.kernel.equations import state_rate
from chain_impact.kernel.ode.control import EXPLICIT
from chain_impact.kernel.ode.dense import time_rate
from chain_impact.kernel.rows.geometry import clearance, gap_acceleration

NO_CONTACT = -1  # value of step.regularized if the variable of the step is time
# The lower limit of u in a step. If u < 0 time runs backwards: the end of the contact has been passed.
BACK = -0.5
# The u and δ̇/v₀ below which a point rests on a wall rather than hits it: in s time would stop, as p → 0.
SLOW = 0.1


def regularized_rate(d, y, rate):
    """Set rate = dy/ds, for the integration variable s of the step."""
    state_rate(d, y, rate)
    if d.step.regularized != NO_CONTACT:
        to_fictitious_time(d, y, rate)


def regularize(d, y, time_rate, rate):
    """Set rate = dy/ds at an end of a step, from dy/dt and for the located points."""
    for j in range(len(rate)):
        rate[j] = time_rate[j]
    if d.step.regularized != NO_CONTACT:
        to_fictitious_time(d, y, rate)


def to_fictitious_time(d, y, rate):
    """Convert a rate in time to one in s, for the located points."""
    u = y[sundman_u_at(d.links)]
    p = time_rate(u)
    for j in range(len(rate)):
        rate[j] *= p
    rate[sundman_u_at(d.links)] = root_rate(d, u)


def root_rate(d, u):
    """Return u′ = du/ds = δ̇/(2 δ* (1 + u²)) of the contact, for the located points."""
    _, gap_rate = clearance(d, d.step.regularized)
    return -0.5 * gap_rate / (d.touch.depth_scale[d.step.regularized] * (1.0 + u * u))


def root_curve(d, u, slope):
    """Return u″ of the contact, for the located and accelerated points and u′."""
    quotient, c = 1.0 / (1.0 + u * u), d.step.regularized
    # u″ = p δ̈/(2 δ* (1 + u²)) − 2 u u′²/(1 + u²)
    curve = 0.5 * time_rate(u) * -gap_acceleration(d, c) / d.touch.depth_scale[c]
    return quotient * (curve - 2.0 * u * slope * slope)


def time_rate_change(u, slope):
    """Return the derivative p′ = dp/ds = u′ (1 − u²)/(1 + u²)²."""
    quotient = 1.0 / (1.0 + u * u)
    return slope * (1.0 - u * u) * quotient * quotient


def time_rate_of(d, u):
    """Return dt/ds; 1 without a regularized contact."""
    return 1.0 if d.step.regularized == NO_CONTACT else time_rate(u)


def time_rate_now(d, y):
    """Return dt/ds in state y, at least SLOW, for the conversion of a step's size to seconds."""
    return max(SLOW, time_rate_of(d, y[sundman_u_at(d.links)]))


def runs_back(d, y):
    """Return whether a step to state y goes far beyond the contact's end: if u < 0, time runs backwards."""
    return d.step.regularized != NO_CONTACT and (
        y[sundman_u_at(d.links)] < BACK or y[time_at(d.links)] <= 0.0
    )


def lone_contact(d):
    """Return the active contact and its u, if it is the only one and not at rest; otherwise NO_CONTACT and 1.

    Several contacts end at different times, and the fictitious time of one does not suit the others.
    """
    if d.step.method != EXPLICIT or not d.touch.active_count == d.touch.compliant_count == 1:
        return NO_CONTACT, 1.0
    c = d.touch.active_index[0]
    gap, gap_rate = clearance(d, c)
    u = math.sqrt(max(0.0, -gap) / d.touch.depth_scale[c])
    over = u == 0.0 and gap_rate >= 0.0
    if over or u + abs(gap_rate) / d.touch.impact_speed[c] <= SLOW:
        return NO_CONTACT, 1.0
    return c, u
