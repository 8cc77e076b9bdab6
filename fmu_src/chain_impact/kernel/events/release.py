"""The moment at which a rigid wall need not hold a contact any more: its force would have to pull."""

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.chain.state import omega_at
from chain_impact.kernel.events.kinds import REFUSED, RELEASE
from chain_impact.kernel.events.sampling import bisection, first_passage
from chain_impact.kernel.integration.dense import interpolate
from chain_impact.kernel.model.constraints import project_state
from chain_impact.kernel.model.contact import drop_events
from chain_impact.kernel.model.equations import state_rate

# Of the chain's weight, or of its mass at one link length a second squared: a pull below it is round-off.
PULL = 1e-11
# Places in a step to look at, once a stage has shown a pull: a force that is negative for less than an eighth
# of a step can be missed, and the point is held for that long.
SAMPLES = 8
SHORT = 1e-9  # s, a step that need not be shorter for a release


def find_release(d, touch):
    """θ of the first of the event at ``touch`` (−1: none) and a held contact that would pull; marks whose.

    The stages of the step tell whether a force has come below zero. REFUSED when they have passed a place
    where forces go to infinity.
    """
    least = 0.0
    for k in range(d.touch.active_count):
        least = min(least, d.rigid.least_force[d.touch.active_index[k]])
    if not least < -pull_limit(d):
        return touch
    if least < -strongest(d) and d.step.size > SHORT:
        return REFUSED
    theta = _when_pulled(d, -1, touch if touch >= 0.0 else 1.0)
    if theta < 0.0:
        return touch
    mark_pulling(d, theta)
    return theta


def pull_limit(d):
    """The force [N] that a held contact may pull with, for round-off's sake."""
    return PULL * d.model.energy / (d.model.size * d.model.size) * (d.model.gravity_size + d.model.size)


def strongest(d):
    """The force [N] that gravity, and the motion at the start of the last step, ask of the chain's mass.

    A stage in which a wall pulls by more has passed a toggle position, where forces go to infinity: the step
    is wrong, and so is what it says of the moment.
    """
    first, turning = omega_at(d.links), 1.0
    for i in range(d.links):
        omega, alpha = d.step.state[first + i], d.work.rate_start[first + i]
        turning = max(turning, omega * omega + abs(alpha))
    size = d.model.size
    return d.model.energy / (size * size) * (d.model.gravity_size + d.links * size * turning)


def pulls(d, _c, theta):
    """Whether any held contact pulls at the fraction θ of the last step."""
    interpolate(d.step, theta, d.work.y)
    # what the interpolant is off the walls, stiff joints turn into a force
    locate_points(d, d.work.y)
    project_state(d, d.work.y)
    state_rate(d, d.work.y, d.work.rate)
    d.statistics.rhs_evaluations += 1
    least = 0.0
    for k in range(d.touch.active_count):
        least = min(least, d.rigid.impulse[k])
    return least < -pull_limit(d)


def mark_pulling(d, theta):
    """Mark the held contacts that pull at θ for release, and no other event."""
    pulls(d, -1, theta)
    drop_events(d)
    for k in range(d.touch.active_count):
        if d.rigid.impulse[k] < -pull_limit(d):
            d.touch.event[d.touch.active_index[k]] = RELEASE


_when_pulled = first_passage(pulls, SAMPLES, bisection(pulls))
