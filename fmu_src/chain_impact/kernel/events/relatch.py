"""The moment at which a point in contact is pushed in much faster than it arrived.

A second hit, or a touch-down so slow that gravity soon outruns it: the v₀ latched at onset would make λ δ̇/v₀,
and the force, grow without bound.
"""

from chain_impact.kernel.events.exclusion import RELATCH_RATIO, nearly_fast
from chain_impact.kernel.events.kinds import RELATCH
from chain_impact.kernel.events.sampling import bisection, first_contact, first_passage, locate_at
from chain_impact.kernel.model.contact import drop_events
from chain_impact.kernel.model.geometry import clearance

SAMPLES = 4  # places in a step to look at, besides its ends: missing a short excess leaves the v₀ as it was


def find_relatch(d, touch):
    """θ of the first of the event at ``touch`` (−1: none) and a contact to latch anew; marks whose it is.

    A contact whose point is nearly fast enough at either end of the step is looked at in between, too.
    """
    found, first = _first_fast(d, touch if touch >= 0.0 else 1.0)  # where the points are located
    if found < 0:
        return touch
    drop_events(d)
    d.touch.event[found] = RELATCH
    return first


def is_fast(d, c, theta):
    """Whether δ̇ of candidate c exceeds RELATCH_RATIO times its v₀ at the fraction θ of the last step."""
    locate_at(d, theta)
    _, gap_rate = clearance(d, c)
    return -gap_rate > RELATCH_RATIO * d.touch.impact_speed[c]


_first_fast = first_contact(nearly_fast, first_passage(is_fast, SAMPLES, bisection(is_fast)))
