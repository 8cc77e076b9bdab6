"""The outcome of a tried step, and the size of the next one: from its error, or where there is none yet.

A method tries a step and concludes it with its error. If that is within the tolerance, the search for events
and the energy check can still refuse the step: it is accepted if its error is at most 1 after them. A
rejected step costs as much as an accepted one. So the sizes of the first step in flight and of the first step
of a contact are estimated in advance.
"""

import math

from chain_impact.kernel.chain.state import omega_at
from chain_impact.kernel.integration.method import EXPLICIT, ONSET_ORDER, ONSET_SIZE, ORDER, SAFETY
from chain_impact.kernel.model.contact_force import damping_share

# Limits of the factor by which the size of a step changes. DOP853's authors use 1/3 and 6.
SHRINK, GROW = 0.1, 6.0
EXPONENT = tuple(-1.0 / order for order in ORDER)
ONSET_EXPONENT = tuple(1.0 / order for order in ONSET_ORDER)
# The error of a step that is refused, whatever its own: the next try is a seventh as long, or an eighth if it
# is implicit.
FAR_OFF = 1e6
LEAST = 1e-16  # a smaller error, which may be 0, counts as this one
# Rotation of the links [rad] in the first step of a flight at a tolerance of 1: the largest for which few of
# them are rejected (tests/kernel/integration/test_control.py). ONSET_SIZE of the methods is chosen likewise.
TURN = 2.8
# In the place of ONSET_SIZE and ONSET_ORDER for an explicit step in time: there the force begins as a power
# of the time since the onset, so errors are of a lower order than those of the method.
BESIDE_SIZE, BESIDE_ORDER = 15.0, 3.0


def begin_trial(d, h):
    """Begin to try a step of size h."""
    d.trial.size = h


def conclude(d, error, cost_factor):
    """Set the error of the tried step, over the tolerance, and what its cost says about the next size."""
    d.trial.error, d.trial.cost_factor = error, cost_factor


def refuse(d, error):
    """Let something else count as an error of the tried step, over the tolerance, if it is larger."""
    d.trial.error = max(d.trial.error, error)


def accepted(d):
    """Whether the tried step is accepted, as far as it has been checked."""
    return d.trial.error <= 1.0


def propose(d, size):
    """Propose a size of the next step, in its integration variable."""
    d.step.next_size = size


def limit(d, size):
    """Let the next step be no longer than a size."""
    propose(d, min(d.step.next_size, size))


def rescale(d, ratio):
    """Multiply the proposed size by a ratio, as the integration variable changes."""
    propose(d, d.step.next_size * ratio)


def keep_for_flight(d):
    """Keep the proposed size for the flight after the contacts that begin."""
    d.step.flight_size = d.step.next_size


def resume_flight(d):
    """Propose the size that was kept for flight."""
    propose(d, d.step.flight_size)


def factor(d):
    """The factor on the size of the tried step that follows from its outcome."""
    if not math.isfinite(d.trial.error):
        return SHRINK
    method, error = d.step.method, max(d.trial.error, LEAST)
    return max(SHRINK, SAFETY[method] * d.trial.cost_factor * error ** EXPONENT[method])


def in_flight(d, y, rate):
    """A size [s] ≤ 1 s for an explicit step from state y, by how fast the links turn there."""
    n, fastest = d.links, 0.0
    for i in range(n):
        fastest = max(fastest, abs(y[omega_at(n) + i]), math.sqrt(abs(rate[omega_at(n) + i])))
    turn = TURN * d.solver.tolerance ** -EXPONENT[EXPLICIT]
    return turn / max(fastest, turn)


def at_onset(d, c, method):
    """A size for a method's first step in the contact of candidate c, which has just begun."""
    return ONSET_SIZE[method] * time_scale(d, c) * d.solver.tolerance ** ONSET_EXPONENT[method]


def at_onset_beside(d, c):
    """As ``at_onset``, for a contact that begins beside others: an explicit step is then one in time."""
    return BESIDE_SIZE * time_scale(d, c) * d.solver.tolerance ** (1.0 / BESIDE_ORDER)


def time_scale(d, c):
    """The time [s] in which the force of candidate c, whose contact has just begun, rises: δ*/v₀ or less."""
    share, power = damping_share(d, c), 1.0 / (d.law.rate_exponent[c] + 1.0)
    # it is shorter where damping stops the point
    return d.touch.depth_scale[c] / d.touch.impact_speed[c] * (1.0 + share) ** -power
