"""The kink of a contact's force: where it is cut off at 0 or, for a law that damps on approach only, δ̇ = 0.

The force is continuous there and its slopes are not, so that a step across would lose its order. A step is
computed with the force of one side, continued smoothly beyond the kink. Its stages and its end show whether
the kink has been crossed; then the kink is located, the step is repeated so as to end there, and the next
step uses the force of the other side. A point without force that is still inside the wall moves as in flight
until it leaves, or until it moves inward so fast that the wall pushes again.
"""

from chain_impact.kernel.events.crossing import SIMULTANEOUS
from chain_impact.kernel.events.kinds import KINK, NONE
from chain_impact.kernel.events.marks import drop_events, mark
from chain_impact.kernel.events.sampling import first_contact, first_passage, locate_at
from chain_impact.kernel.integration.bracket import TRIES, next_guess
from chain_impact.kernel.model.contact import kink_height
from chain_impact.kernel.model.contact_force import note_crossing

SAMPLES = 8  # samples of a step
RESOLUTION = 1e-15  # fraction of a step, to which a kink is located


def find_kink(d, touch):
    """θ of the event at ``touch`` (−1: none) or of an earlier kink; marks the candidates of a kink.

    The points are located at that event, or at the end of the step.
    """
    end = touch if touch >= 0.0 else 1.0
    found, first = _first_kink(d, end)
    if found < 0:
        return touch
    drop_events(d)
    # a symmetric chain crosses several kinks at the same time, up to round-off
    locate_at(d, min(end, first + SIMULTANEOUS / d.step.size))
    for k in range(d.touch.compliant_count):
        c = d.touch.active_index[k]
        mark(d, c, KINK if c == found or crossed(d, c) else NONE)
    locate_at(d, first)
    return first


def crossed(d, c):
    """Whether contact c, for the located points, is not on the side of its kink that the step assumes."""
    height = kink_height(d, c)
    return height > 0.0 if d.touch.beyond_kink[c] else height < 0.0


def has_crossed(d, c):
    """Whether a stage of the last step, or its end, has been on the other side of the kink."""
    note_crossing(d, c, kink_height(d, c))
    return d.touch.kink_crossed[c] != 0


def crossed_at(d, c, theta):
    """Whether contact c is on the other side at the fraction θ of the last step."""
    locate_at(d, theta)
    return crossed(d, c)


def find_kink_root(d, c, low, high):
    """θ at which contact c, located beyond its kink at ``high``, crosses it; ``low`` if that was earlier.

    The rule of false position in its Illinois form (Dowell & Jarratt 1971, BIT 11:168).
    """
    at_high = kink_height(d, c)
    locate_at(d, low)
    at_low = kink_height(d, c)
    if crossed(d, c) or at_low == at_high:
        return low
    last = 0
    for tries in range(TRIES):
        theta = next_guess(low, high, high - at_high * (high - low) / (at_high - at_low), tries)
        locate_at(d, theta)
        height = kink_height(d, c)
        if crossed(d, c):
            high, at_high = theta, height
            at_low *= 0.5 if last > 0 else 1.0
            last = 1
        else:
            low, at_low = theta, height
            at_high *= 0.5 if last < 0 else 1.0
            last = -1
        if height == 0.0 or high - low <= RESOLUTION:
            return theta
    return high


first_crossing = first_passage(crossed_at, SAMPLES, find_kink_root)
_first_kink = first_contact(has_crossed, first_crossing)
