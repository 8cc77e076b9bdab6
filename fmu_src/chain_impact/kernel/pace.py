"""The variable that a step runs in: time, or through an impact a contact's own.

A force K δⁿ with n = 3/2 is not smooth in time where its contact begins and where it ends: there δ falls to
zero as the time that is left, and the force as its power 3/2. An explicit step then loses its order, and
creeps away from one end and toward the other. It is smooth in the variable s of Sundman's transformation,

    dt = u ds,   u = √(δ/δ*),   du/ds = δ̇/(2 δ*),

with δ* the expected penetration: there δ goes as s², and F as s³. So u and t join the state y, and a step
runs in s, at the *pace* u of the contact that is nearest to its onset or end, its pacer. Without one u = 1,
and s is time.

Source: K. F. Sundman 1913, Mémoire sur le problème des trois corps, Acta Mathematica 36:105, where the
distance of two bodies stands in for u.
"""

import math

from chain_impact.kernel.contact import clearance
from chain_impact.kernel.dense import pace_at, time_at
from chain_impact.kernel.equations import state_rate
from chain_impact.kernel.jit import jit

TIME = -1  # in step.pacer: no contact sets the pace
BACK = -0.5  # u, further than which no step goes
SLOW = 0.1  # u and δ̇/v₀ below which a contact is a point that lies on a wall, and time does


@jit
def paced_rate(d, y, rate):
    """Set rate = dy/ds, for the pace of the step."""
    state_rate(d, y, rate)
    if d.step.pacer != TIME:
        slow_down(d, y, rate)


@jit
def at_pace(d, y, time_rate, rate):
    """Set rate = dy/ds for dy/dt and the located points; at the ends of a step."""
    for j in range(len(rate)):
        rate[j] = time_rate[j]
    if d.step.pacer != TIME:
        slow_down(d, y, rate)


@jit
def slow_down(d, y, rate):
    """Turn a rate in time into one in s, for the located points."""
    pace = y[pace_at(d.step)]
    for j in range(len(rate)):
        rate[j] *= pace
    rate[pace_at(d.step)] = quickening(d)


@jit
def quickening(d):
    """du/ds = δ̇/(2 δ*) of the pacer, for the located points."""
    _, gap_rate = clearance(d, d.step.pacer)
    return -0.5 * gap_rate / d.touch.depth_scale[d.step.pacer]


@jit
def set_pace(d, anew):
    """Choose what paces the step to come, for the points located at its start.

    Args:
        d: the instance.
        anew: whether the size of the step has been chosen for it, as contacts began or ended.
    """
    step, before = d.step, 1.0 if d.step.pacer == TIME else d.step.state_end[pace_at(d.step)]
    pacer, pace = slowest(d)
    if pacer != step.pacer:
        step.cleared = 0
        if not anew:
            step.next_size *= max(before, SLOW) / max(pace, SLOW)
    step.pacer = pacer
    step.state_end[pace_at(step)] = pace
    step.state_end[time_at(step)] = 0.0


@jit
def runs_back(d, y):
    """Whether a step to state y goes far beyond the end of its pacer, where u < 0 and time runs backwards."""
    return d.step.pacer != TIME and (y[pace_at(d.step)] < BACK or y[time_at(d.step)] <= 0.0)


@jit
def slowest(d):
    """The active contact with the least u, which is nearest to its onset or end, and u; or TIME and 1."""
    pacer, least = TIME, math.inf
    if d.step.implicit or d.contact.impulsive:
        return TIME, 1.0
    for k in range(d.touch.active_count):
        c = d.touch.active_index[k]
        gap, gap_rate = clearance(d, c)
        u = math.sqrt(max(0.0, -gap) / d.touch.depth_scale[c])
        lasts = u > 0.0 or gap_rate < 0.0
        if lasts and u + abs(gap_rate) / d.touch.impact_speed[c] > SLOW and u < least:
            pacer, least = c, u
    return pacer, 1.0 if pacer == TIME else least
