"""The time at which a point in contact moves inward much faster than it arrived.

The cause is a second impact, or an onset so slow that gravity soon makes δ̇ much larger: with the v₀ latched
(fixed) at the onset of the contact, λ δ̇/v₀ and the force would grow without bound.
"""

from chain_impact.kernel.events.exclusion import RELATCH_RATIO, nearly_fast
from chain_impact.kernel.events.kinds import RELATCH
from chain_impact.kernel.events.marks import drop_events, mark
from chain_impact.kernel.events.sampling import bisection, first_contact, first_passage, locate_at
from chain_impact.kernel.model.geometry import clearance

SAMPLES = 4  # samples of a step besides its ends: if a short excess is missed, v₀ stays as it was


def find_relatch(d, touch):
    """θ of the event at ``touch`` (−1: none) or of an earlier re-latch of v₀; marks its candidate.

    A contact whose point is nearly fast enough at an end of the step is sampled inside the step as well.
    """
    found, first = _first_fast(d, touch if touch >= 0.0 else 1.0)  # where the points are located
    if found < 0:
        return touch
    drop_events(d)
    mark(d, found, RELATCH)
    return first


def is_fast(d, c, theta):
    """Whether δ̇ of candidate c exceeds RELATCH_RATIO times its v₀ at the fraction θ of the last step."""
    locate_at(d, theta)
    _, gap_rate = clearance(d, c)
    return -gap_rate > RELATCH_RATIO * d.touch.impact_speed[c]


_first_fast = first_contact(nearly_fast, first_passage(is_fast, SAMPLES, bisection(is_fast)))
