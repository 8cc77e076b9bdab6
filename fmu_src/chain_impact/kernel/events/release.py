"""The moment at which a rigid wall need not hold a contact any more: its force would have to pull."""

import math

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.integration.dense import interpolate
from chain_impact.kernel.model.constraints import meet_walls
from chain_impact.kernel.model.contact import drop_events
from chain_impact.kernel.model.equations import state_rate

RELEASE = 3  # in `touch.event`
RESOLUTION = 1e-12  # s
PULL, SAMPLES = 1e-11, 8  # of the chain's weight, a force that counts; places in a step to look at


def find_release(d, touch):
    """θ of the first of the event at ``touch`` (−1: none) and a held contact that would pull; marks whose.

    The stages of the step tell whether a force has come below zero.
    """
    pulling = False
    for k in range(d.touch.active_count):
        pulling |= d.rigid.least[d.touch.active_index[k]] < -pull_limit(d)
    if not pulling:
        return touch
    end = touch if touch >= 0.0 else 1.0
    low = 0.0
    for sample in range(1, SAMPLES + 1):
        high = end * sample / SAMPLES
        if pulls(d, high):
            while (high - low) * d.step.size > RESOLUTION:
                middle = 0.5 * (low + high)
                if pulls(d, middle):
                    high = middle
                else:
                    low = middle
            mark_pulling(d, high)
            return high
        low = high
    return touch


def pull_limit(d):
    """The force [N] that a held contact may pull with, for round-off's sake."""
    gravity = math.hypot(d.model.gravity[0], d.model.gravity[1])
    return PULL * d.model.energy / (d.model.size * d.model.size) * (gravity + d.model.size)


def pulls(d, theta):
    """Whether a held contact pulls at the fraction θ of the last step."""
    interpolate(d.step, theta, d.work.y)
    # what the interpolant is off the walls, stiff joints turn into a force
    locate_points(d, d.work.y)
    meet_walls(d, d.work.y)
    state_rate(d, d.work.y, d.work.error[0])
    d.statistics.rhs_evaluations += 1
    least = 0.0
    for k in range(d.touch.active_count):
        least = min(least, d.rigid.impulse[k])
    return least < -pull_limit(d)


def mark_pulling(d, theta):
    """Mark the held contacts that pull at θ for release, and no other event."""
    pulls(d, theta)
    drop_events(d)
    for k in range(d.touch.active_count):
        if d.rigid.impulse[k] < -pull_limit(d):
            d.touch.event[d.touch.active_index[k]] = RELEASE
