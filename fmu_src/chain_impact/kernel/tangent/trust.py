"""How far derivatives can be trusted: up to an impact at which they do not exist, or are known too badly."""

import math

from chain_impact.kernel.events.kinds import ONSET
from chain_impact.kernel.model.contact_force import may_jump
from chain_impact.kernel.model.geometry import clearance
from chain_impact.kernel.tangent.directions import value

TRUSTED, GRAZING, AT_FLOOR, SIMULTANEOUS = 0, 1, 2, 3

REASONS = {
    GRAZING: "its point arrives so slowly that the tolerance leaves open whether it arrives at all",
    AT_FLOOR: "its approach speed is below contact.minimum_impact_speed, which the contact law takes instead",
    SIMULTANEOUS: "several points arrive at one moment, and what follows depends on which is first",
}
"""Why derivatives end at an impact."""


def judge_onsets(t):
    """Judge the onsets at the end of the last step, for the points located there."""
    onsets, least = 0, math.inf
    first = -1
    for c in range(t.candidates):
        if t.touch.event[c] == ONSET:
            onsets += 1
            _, gap_rate = clearance(t, c)
            if -value(gap_rate) < least:
                least, first = -value(gap_rate), c
    if onsets == 0 or t.trust.reason != TRUSTED:
        return
    if least <= math.sqrt(value(t.solver.tolerance)) * fastest(t):
        distrust(t, GRAZING, first)
    elif not t.contact.impulsive and least <= value(t.contact.minimum_impact_speed):
        distrust(t, AT_FLOOR, first)
    elif onsets > 1 and (t.contact.impulsive or may_jump(t.contact)):
        distrust(t, SIMULTANEOUS, first)


def fastest(t):
    """The speed of the fastest point [m/s]."""
    most, velocity = 0.0, t.work.velocity
    for k in range(len(velocity.x)):
        x, y = value(velocity.x[k]), value(velocity.y[k])
        most = max(most, math.sqrt(x * x + y * y))
    return most


def distrust(t, reason, c):
    """Let derivatives end at the end of the last step, where a contact of candidate c begins."""
    trust = t.trust
    trust.reason, trust.time = reason, value(t.step.end)
    trust.point, trust.wall = t.candidate.point[c], t.candidate.wall[c]


def trusted(t):
    """Whether there are derivatives at the communication point."""
    return t.trust.reason == TRUSTED or value(t.step.time) < t.trust.time
