"""The time at which a rigid wall must release a contact, because its force would have to pull."""

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.chain.state import omega_at
from chain_impact.kernel.events.kinds import RELEASE
from chain_impact.kernel.events.marks import drop_events, mark
from chain_impact.kernel.events.sampling import bisection, first_passage
from chain_impact.kernel.integration.dense import interpolate
from chain_impact.kernel.integration.trial import NOT_LOCATED, refuse
from chain_impact.kernel.model.equations import state_rate
from chain_impact.kernel.model.holding import least_impulse, project_state
from chain_impact.kernel.work_limit import count_evaluations

# Relative to the chain's mass times (gravity + one link length per s²): a smaller pull is round-off.
PULL = 1e-11
# Samples of a step in which a stage has shown a pull: a force that is negative for less than an eighth of a
# step can be missed, and the point is held for that time.
SAMPLES = 8
SHORT = 1e-9  # s. A shorter step is not refused for the sake of a release.


def find_release(d, touch):
    """θ of the event at ``touch`` (−1: none) or of an earlier release; marks the contacts that would pull.

    The stages of the step show whether a force has become negative. The step is refused, and the result is
    −1, if a stage has passed a configuration where forces go to infinity.
    """
    least = 0.0
    for k in range(d.touch.compliant_count, d.touch.active_count):
        least = min(least, d.rigid.least_force[d.touch.active_index[k]])
    if not least < -pull_limit(d):
        return touch
    if least < -strongest(d) and d.step.size > SHORT:
        refuse(d, NOT_LOCATED)
        return -1.0
    theta = _when_pulled(d, -1, touch if touch >= 0.0 else 1.0)
    if theta < 0.0:
        return touch
    mark_pulling(d, theta)
    return theta


def pull_limit(d):
    """The force [N] with which a held contact may pull, because it is round-off."""
    return PULL * d.model.energy / (d.model.size * d.model.size) * (d.model.gravity_size + d.model.size)


def strongest(d):
    """The largest plausible force [N], from gravity and the motion at the start of the last step.

    A stage in which a wall pulls by more has passed a toggle position, where forces go to infinity: the step
    is wrong, and so is its time of release.
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
    # stiff joints would turn the constraint error of the interpolant into a force
    locate_points(d, d.work.y)
    project_state(d, d.work.y)
    state_rate(d, d.work.y, d.work.rate)
    count_evaluations(d, 1)
    return least_impulse(d) < -pull_limit(d)


def mark_pulling(d, theta):
    """Mark the held contacts that pull at θ as RELEASE, and drop all other events."""
    pulls(d, -1, theta)
    drop_events(d)
    for k in range(d.touch.compliant_count, d.touch.active_count):
        if d.rigid.impulse[k] < -pull_limit(d):
            mark(d, d.touch.active_index[k], RELEASE)


_when_pulled = first_passage(pulls, SAMPLES, bisection(pulls))
