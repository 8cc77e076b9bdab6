"""Sundman regularization: the integration variable of a step is time or, in an impact, a fictitious time.

A force K δⁿ with n = 3/2 is not a smooth function of time where the contact begins and where it ends: there
the penetration δ is proportional to the time since the onset or until the end, and the force to the power 3/2
of this time. An explicit method then loses its order and needs very small steps. The force is smooth in the
variable s of Sundman's transformation,

    dt = p ds,   p = u/(1 + u²),   u = √(δ/δ*),   du/ds = δ̇/(2 δ* (1 + u²)),

with δ* the expected penetration: near onset and end δ is proportional to s², and F to s³, with s counted from
there. The denominator 1 + u² makes the motion vary as slowly with s in the middle of the impact as at its
ends, so that one step size suits the whole impact. The state y contains u and t, and the variable of a step
is s [s], the fictitious time of the *regularized contact*, which must be the only active contact. Without a
regularized contact p = 1, and s is time.

Source: K. F. Sundman 1913, Mémoire sur le problème des trois corps, Acta Mathematica 36:105, where the
distance of two bodies takes the place of p.
"""

import math

from chain_impact.kernel.constraints.geometry import clearance_acceleration, clearance_and_rate
from chain_impact.kernel.equations import rate_from_state
from chain_impact.kernel.function_marks import inlined
from chain_impact.kernel.ode.sundman_rate import regularized_time_rate
from chain_impact.kernel.record.constants import NO_CONTACT
from chain_impact.kernel.record.method import is_implicit, is_regularized
from chain_impact.kernel.record.state import sundman_u_at, time_at

# The least u = √(δ/δ*) to which a regularized step may go. u is integrated, so it may become negative: then
# the step has passed the end of the contact, and time runs backwards.
LEAST_ROOT = -0.5
# A point with u + |δ̇|/v₀ ≤ RESTING_SUM counts as resting on the wall, not as hitting it; |δ̇|/v₀ is the
# point's normal speed relative to the latched speed. A step from such a state runs in time: with s as the
# variable, time would hardly advance, because p is almost 0.
RESTING_SUM = 0.1


@inlined
def regularized_rate(d, y, rate):
    """Set ``rate`` to dy/ds at the state y; s is the integration variable of the tried or last step."""
    rate_from_state(d, y, rate)
    if is_regularized(d):
        convert_to_fictitious_time(d, y, rate)


def regularize_rate(d, y, rate_in_time, rate):
    """Set ``rate`` to dy/ds in state y, from ``rate_in_time``, which is dy/dt in this state.

    y is the state at the start or at the end of a step. In a regularized step the points must be located.
    """
    for j in range(len(rate)):
        rate[j] = rate_in_time[j]
    if is_regularized(d):
        convert_to_fictitious_time(d, y, rate)


def convert_to_fictitious_time(d, y, rate):
    """Convert ``rate`` from dy/dt to dy/ds in state y, s the fictitious time; points must be located."""
    u = y[sundman_u_at(d.link_count)]
    p = regularized_time_rate(u)
    for j in range(len(rate)):
        rate[j] *= p
    rate[sundman_u_at(d.link_count)] = root_rate(d, u)


def root_rate(d, u):
    """Return u′ = du/ds = δ̇/(2 δ* (1 + u²)) of the regularized contact, the rate of u = √(δ/δ*).

    The points must be located.
    """
    _, clearance_rate = clearance_and_rate(d, d.step.regularized_candidate)
    return (
        -0.5
        * clearance_rate
        / (d.contacts.expected_penetration[d.step.regularized_candidate] * (1.0 + u * u))
    )


def root_curvature(d, u, slope):
    """Return u″ = d²u/ds² of the regularized contact; ``slope`` is the rate u′.

    The points must be located and accelerated.
    """
    quotient, c = 1.0 / (1.0 + u * u), d.step.regularized_candidate
    # u″ = p δ̈/(2 δ* (1 + u²)) − 2 u u′²/(1 + u²), with u′ = du/ds, p = dt/ds and δ̈ = d²δ/dt² of the
    # penetration δ
    curvature = (
        0.5 * regularized_time_rate(u) * -clearance_acceleration(d, c) / d.contacts.expected_penetration[c]
    )
    return quotient * (curvature - 2.0 * u * slope * slope)


def time_rate_at(d, u):
    """Return dt/ds for the integration variable s of the step: u/(1 + u²), or 1 if s is time.

    ``u`` is the root of the relative penetration of the regularized contact.
    """
    return 1.0 if not is_regularized(d) else regularized_time_rate(u)


def time_rate_for_sizes(d, y):
    """Return dt/ds in state y, but at least RESTING_SUM, to convert step sizes to and from seconds.

    Without the lower limit a size would be divided by almost 0 where the contact begins or ends.
    """
    return max(RESTING_SUM, time_rate_at(d, y[sundman_u_at(d.link_count)]))


def runs_back(d, y):
    """Return whether a regularized step to state y goes too far beyond the contact's end or back in time.

    This is so if u < LEAST_ROOT in y, or if the end of the step is not later in time than its start. For a
    step that runs in time, the result is False.
    """
    return is_regularized(d) and (
        y[sundman_u_at(d.link_count)] < LEAST_ROOT or y[time_at(d.link_count)] <= 0.0
    )


def find_lone_contact(d):
    """Return the active contact and its u if the next step can be regularized; else NO_CONTACT and u = 1.

    The contact must have a force law, must not rest (RESTING_SUM) or be at its end, and must be the only
    active contact: several contacts end at different times, and the fictitious time of one contact does not
    suit the others. An implicit step always runs in time. The points must be located at the start of the
    step.
    """
    if is_implicit(d) or not d.contacts.active_count == d.contacts.force_law_count == 1:
        return NO_CONTACT, 1.0
    c = d.contacts.active_index[0]
    clearance, clearance_rate = clearance_and_rate(d, c)
    u = math.sqrt(max(0.0, -clearance) / d.contacts.expected_penetration[c])
    is_over = u == 0.0 and clearance_rate >= 0.0
    if is_over or u + abs(clearance_rate) / d.contacts.latched_speed[c] <= RESTING_SUM:
        return NO_CONTACT, 1.0
    return c, u
