"""Sizes of steps: what follows from an error, and what the error control cannot know.

A step that is tried in vain costs as much as one that is taken. So the first step in flight and that of a
contact are foreseen.
"""

import math

from chain_impact.kernel.chain.state import omega_at
from chain_impact.kernel.integration.method import EXPLICIT
from chain_impact.kernel.integration.methods import EXPONENT, ONSET_EXPONENT, ONSET_SIZE, SAFETY
from chain_impact.kernel.model.contact_force import damping_share

# The factors by which the size of a step changes, at most. DOP853's authors have 1/3 and 6.
SHRINK, GROW = 0.1, 6.0
# rad that links turn in the first step of a flight at a tolerance of 1: the most for which few first steps
# are rejected (tests/kernel/integration/test_step_size.py). So is `onset_size` of the methods.
TURN = 2.8


def factor(d, error):
    """What the size of a step is to be multiplied with, for its error relative to the tolerance."""
    method = d.step.method
    return max(SHRINK, SAFETY[method] * d.step.cost_factor * error ** EXPONENT[method])


def in_flight(d, y, rate):
    """A size [s] for an explicit step from state y with its rate, as fast as the links turn; at most 1 s."""
    n, fastest = d.links, 0.0
    for i in range(n):
        fastest = max(fastest, abs(y[omega_at(n) + i]), math.sqrt(abs(rate[omega_at(n) + i])))
    turn = TURN * d.solver.tolerance ** -EXPONENT[EXPLICIT]
    return turn / max(fastest, turn)


def at_onset(d, c, method):
    """A size for the first step, by a method, of the contact of candidate c, which has just been latched."""
    return ONSET_SIZE[method] * time_scale(d, c) * d.solver.tolerance ** ONSET_EXPONENT[method]


def time_scale(d, c):
    """The time [s] in which the force of candidate c, which has just been latched, rises: δ*/v₀ or less."""
    share, power = damping_share(d, c), 1.0 / (d.contact.rate_exponent + 1.0)
    # less where damping stops the point
    return d.touch.depth_scale[c] / d.touch.impact_speed[c] * (1.0 + share) ** -power
