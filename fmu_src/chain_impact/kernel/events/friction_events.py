"""The times at which sliding stops, and at which what sticks begins to slide.

    SLIDING_ENDS    s t·v           falls through 0
    STICKING_ENDS   µ_s F_n − |F_t| falls through 0

The stages of a step record the least value of these functions (model/friction.py). Only where one has become
negative is the step sampled. To find an event late does no harm but a little energy of its error.
"""

from chain_impact.kernel.events.kinds import SLIDING_ENDS, STICKING_ENDS
from chain_impact.kernel.events.marks import drop_events, mark_change
from chain_impact.kernel.events.sampling import bisection, first_passage, locate_at
from chain_impact.kernel.model.compliance import mean_mass
from chain_impact.kernel.model.equations import state_rate
from chain_impact.kernel.model.friction import STICKS
from chain_impact.kernel.model.geometry import tangential_rate
from chain_impact.kernel.model.holding import project_state
from chain_impact.kernel.work_limit import count_evaluations

SAMPLES = 8  # samples of a step, its end included
# Of a link length per second: a tangential speed that is rest.
AT_REST = 1e-12
# Of the limit of friction, and of the weight of a link that falls and turns by 1 rad per second squared: an
# excess of the static friction that is round-off.
EXCESS = 1e-10


def find_mode_change(d, found):
    """θ of the event ``found`` (−1: none) or of an earlier change of a mode; marks its elements."""
    own = d.friction
    first, which = found if found >= 0.0 else 1.0, -1
    for i in range(own.count):
        e = d.element.index[i]
        if d.element.margin[e] < -resolution_of(d, e):
            theta = _first_change(d, e, first)
            if theta >= 0.0:
                first, which = theta, e
    if which < 0:
        return found
    drop_events(d)
    mark_changes(d, which, first)
    return first


def mark_changes(d, found, theta):
    """Mark the element found, and all others whose mode ends at θ as well: symmetric chains have such."""
    own = d.friction
    for i in range(own.count):
        e = d.element.index[i]
        if e == found or has_changed(d, e, theta):
            mark_change(d, e, STICKING_ENDS if d.element.mode[e] == STICKS else SLIDING_ENDS)


def resolution_of(d, e):
    """By how much the function of element e may be negative, because that is round-off: m/s or N."""
    return excess(d, e) if d.element.mode[e] == STICKS else rest_speed(d) + d.element.slack[e]


def rest_speed(d):
    """The tangential speed [m/s] that counts as rest."""
    return AT_REST * d.model.size


def excess(d, e):
    """The force [N] by which the friction of element e may exceed its limit."""
    return EXCESS * (d.element.limit[e] + mean_mass(d) * (d.model.gravity_size + d.model.size))


def has_changed(d, e, theta):
    """Whether the mode of element e has ended at the fraction θ of the last step."""
    locate_at(d, theta)
    if d.element.mode[e] != STICKS:
        return d.element.mode[e] * tangential_rate(d, e) < -resolution_of(d, e)
    project_state(d, d.work.y)
    state_rate(d, d.work.y, d.work.rate)
    count_evaluations(d, 1)
    return d.element.limit[e] - abs(d.element.force[e]) < -resolution_of(d, e)


_first_change = first_passage(has_changed, SAMPLES, bisection(has_changed))
