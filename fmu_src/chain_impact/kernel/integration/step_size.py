"""Sizes of steps: what follows from an error, and what the error control cannot know.

A step that is tried in vain costs as much as one that is taken. So the first step in flight, that of a
contact and those toward its end are foreseen. They go as the eighth root of the tolerance, as all do that the
explicit method takes.
"""

import math

from chain_impact.kernel.chain.kinematics import accelerate_points
from chain_impact.kernel.integration import explicit, implicit
from chain_impact.kernel.integration.dense import root_at
from chain_impact.kernel.integration.sundman import NO_CONTACT, root_curve
from chain_impact.kernel.model.contact_force import damping_share

SHRINK, GROW = 0.1, 6.0  # of the size of a step, at most
TURN = 2.8  # rad, of the links in a step in flight for a tolerance of 1
FIRST = 4.5  # of the time scale of a contact, likewise
BEYOND, STRETCH = 1.04, 1.2  # of the way to the end of a contact; of a step, to get there


def factor(d, error):
    """What the size of a step is to be multiplied with, for its error relative to the tolerance."""
    if d.step.implicit:
        return max(SHRINK, implicit.SAFETY * error**implicit.EXPONENT)
    return max(SHRINK, explicit.SAFETY * error**explicit.EXPONENT)


def in_flight(d, y, rate):
    """A size [s] for an explicit step from state y with its rate, as fast as the links turn; at most 1 s."""
    n, fastest = d.links, 0.0
    for i in range(n):
        fastest = max(fastest, abs(y[n + 4 + i]), math.sqrt(abs(rate[n + 4 + i])))
    turn = TURN * d.solver.tolerance**-explicit.EXPONENT
    return turn / max(fastest, turn)


def at_onset(d, c):
    """A size for the first step of the contact of candidate c, which has just been latched."""
    share, power = damping_share(d, c), 1.0 / (d.contact.rate_exponent + 1.0)
    # δ*/v₀, or less where damping stops the point
    scale = d.touch.depth_scale[c] / d.touch.impact_speed[c] * (1.0 + share) ** -power
    return FIRST * scale * d.solver.tolerance**-explicit.EXPONENT


def toward_end(d, h):
    """The size of the step that begins, over an end that is near, if the error control allows a size h."""
    if d.step.regularized == NO_CONTACT:
        return h
    u, slope = d.step.state_end[root_at(d.step)], d.work.stage[0, root_at(d.step)]
    if u + 2.0 * slope * h >= 0.0:
        return h
    accelerate_points(d, d.step.state_end, d.work.rate_start)
    # u + u′ s + ½ u″ s² = 0
    square = slope * slope - 2.0 * u * root_curve(d, u, slope)
    left = 2.0 * u / (math.sqrt(max(0.0, square)) - slope)
    if BEYOND * left < STRETCH * h:
        return BEYOND * left
    return min(h, 0.5 * left)
