"""The variable that a step runs in: time, or through an impact a contact's own.

A force K δⁿ with n = 3/2 is not smooth in time where its contact begins and where it ends: there δ falls to
zero as the time that is left, and the force as its power 3/2. An explicit step then loses its order, and
creeps away from one end and toward the other. It is smooth in the variable s of Sundman's transformation,

    dt = p ds,   p = u/(1 + u²),   u = √(δ/δ*),   du/ds = δ̇/(2 δ* (1 + u²)),

with δ* the expected penetration: there δ goes as s², and F as s³. The denominator makes an impact as even in
its middle as at its ends, so that steps of one size suit all of it. So u and t join the state y, and a step
runs in s, at the *pace* p of its pacer, the one contact that there is. Without a pacer p = 1, and s is time.

Source: K. F. Sundman 1913, Mémoire sur le problème des trois corps, Acta Mathematica 36:105, where the
distance of two bodies stands in for p.
"""

import math

from chain_impact.kernel.integration.dense import NOTHING, pace, root_at, time_at
from chain_impact.kernel.model.equations import state_rate
from chain_impact.kernel.model.geometry import along_normal, clearance

TIME = -1  # in step.pacer: no contact sets the pace
BACK = -0.5  # u, further than which no step goes
SLOW = 0.1  # u and δ̇/v₀ below which a contact is a point that lies on a wall, and time does


def paced_rate(d, y, rate):
    """Set rate = dy/ds, for the pace of the step."""
    state_rate(d, y, rate)
    if d.step.pacer != TIME:
        slow_down(d, y, rate)


def at_pace(d, y, time_rate, rate):
    """Set rate = dy/ds for dy/dt and the located points; at the ends of a step."""
    for j in range(len(rate)):
        rate[j] = time_rate[j]
    if d.step.pacer != TIME:
        slow_down(d, y, rate)


def slow_down(d, y, rate):
    """Turn a rate in time into one in s, for the located points."""
    u = y[root_at(d.step)]
    p = pace(u)
    for j in range(len(rate)):
        rate[j] *= p
    rate[root_at(d.step)] = root_rate(d, u)


def root_rate(d, u):
    """u′ = du/ds = δ̇/(2 δ* (1 + u²)) of the pacer, for the located points."""
    _, gap_rate = clearance(d, d.step.pacer)
    return -0.5 * gap_rate / (d.touch.depth_scale[d.step.pacer] * (1.0 + u * u))


def root_curve(d, u, slope):
    """u″ of the pacer, for the located and accelerated points and u′."""
    quotient = 1.0 / (1.0 + u * u)
    acceleration = -along_normal(d, d.step.pacer, d.work.acceleration)
    # u″ = p δ̈/(2 δ* (1 + u²)) − 2 u u′²/(1 + u²)
    curve = 0.5 * pace(u) * acceleration / d.touch.depth_scale[d.step.pacer]
    return quotient * (curve - 2.0 * u * slope * slope)


def pace_change(u, slope):
    """The change p′ = u′ (1 − u²)/(1 + u²)²."""
    quotient = 1.0 / (1.0 + u * u)
    return slope * (1.0 - u * u) * quotient * quotient


def pace_of(d, u):
    """The pace; 1 without a pacer."""
    return 1.0 if d.step.pacer == TIME else pace(u)


def pace_now(d, y):
    """The pace in state y; not less than SLOW, as it serves to turn the size of a step into seconds."""
    return max(SLOW, pace_of(d, y[root_at(d.step)]))


def set_pace(d, anew):
    """Choose what paces the step to come, for the points located at its start.

    Args:
        d: the instance.
        anew: whether the size of the step has been chosen for it, as contacts began or ended.
    """
    step = d.step
    before, (pacer, u) = pace_now(d, step.state_end), lone_contact(d)
    changed = pacer != step.pacer
    step.pacer = pacer
    step.state_end[root_at(step)] = u
    step.state_end[time_at(step)] = 0.0
    if changed:
        step.cleared = NOTHING
        if not anew:
            step.next_size *= before / pace_now(d, step.state_end)


def runs_back(d, y):
    """Whether a step to state y goes far beyond the end of its pacer, where u < 0 and time runs backwards."""
    return d.step.pacer != TIME and (y[root_at(d.step)] < BACK or y[time_at(d.step)] <= 0.0)


def lone_contact(d):
    """The active contact and its u, if it is alone and not a point that lies on a wall; else TIME and 1.

    Others would have their ends at other moments, and what paces one of them suits none of the rest.
    """
    if d.step.implicit or d.contact.impulsive or d.touch.active_count != 1:
        return TIME, 1.0
    c = d.touch.active_index[0]
    gap, gap_rate = clearance(d, c)
    u = math.sqrt(max(0.0, -gap) / d.touch.depth_scale[c])
    over = u == 0.0 and gap_rate >= 0.0
    if over or u + abs(gap_rate) / d.touch.impact_speed[c] <= SLOW:
        return TIME, 1.0
    return c, u
