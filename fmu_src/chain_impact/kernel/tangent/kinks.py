"""Kinks of a contact's force inside a step: where it is cut off at 0, or where the damping of approach ends.

The force is continuous there and its slopes are not, so that a step across has no derivatives. t therefore
goes up to the kink with the force of one side, continued as it is, and on from there with that of the other.

φ of a contact is what changes its sign at its kink: the force before it is cut off or, for a law that damps
on approach only, δ̇. ``replay.beyond`` says on which side of it the contact is.
"""

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.events.kinds import ONSET, RELATCH
from chain_impact.kernel.integration.dense import interpolate
from chain_impact.kernel.integration.last_step import SOLVER, complete
from chain_impact.kernel.model.contact_force import uncut_force
from chain_impact.kernel.model.geometry import clearance
from chain_impact.kernel.tangent.directions import value

TRIES = 60
RESOLUTION = 1e-13  # of a step, in which a kink is found


def forget_sides(t):
    """Let the contacts that begin at the end of the last step, or are latched anew there, approach."""
    for c in range(t.candidates):
        if t.touch.event[c] in (ONSET, RELATCH):
            t.replay.beyond[c] = 0


def take_sides(t):
    """Find on which side of its kink each active contact is, for the located points."""
    for k in range(t.touch.active_count):
        c = t.touch.active_index[k]
        t.replay.beyond[c] = 0
        t.replay.beyond[c] = height(t, c) < 0.0


def first_kink(t, until):
    """Find the first kink in the last step, up to its fraction ``until``.

    Returns:
        Its fraction of the step and its contact; −1 for the contact if there is none.
    """
    first, found = until, -1
    if t.contact.impulsive:
        return first, found
    if until < 1.0:
        move_to(t, until)
    elif not t.work.at_end:
        locate_points(t, t.step.state_end)
    for k in range(t.touch.active_count):
        c = t.touch.active_index[k]
        if crossed(t, c):
            first, found = root(t, c, first), c
            move_to(t, first)
    return first, found


def move_to(t, theta):
    """Locate the points at a fraction θ of the last step."""
    complete(t, SOLVER)
    interpolate(t.step, theta, t.work.y)
    locate_points(t, t.work.y)


def crossed(t, c):
    """Whether contact c has come over its kink, for the located points."""
    phi = height(t, c)
    return phi > 0.0 if t.replay.beyond[c] else phi < 0.0


def height(t, c):
    """φ of contact c, for the located points."""
    gap, gap_rate = clearance(t, c)
    if t.contact.approach_only:
        return -value(gap_rate)
    force, _ = uncut_force(t, c, max(0.0, -gap), -gap_rate)
    return value(force)


def root(t, c, until):
    """The fraction of the last step at which φ of contact c is zero, which is crossed at ``until``.

    The rule of false position in its Illinois form (Dowell & Jarratt 1971, BIT 11:168).
    """
    high, at_high = until, height(t, c)
    move_to(t, 0.0)
    low, at_low = 0.0, height(t, c)
    if not at_low * at_high < 0.0:
        return 0.0  # at the start but for round-off
    last = 0.0
    for _ in range(TRIES):
        theta = high - at_high * (high - low) / (at_high - at_low)
        move_to(t, theta)
        phi = height(t, c)
        if phi * at_high > 0.0:
            high, at_high = theta, phi
            at_low *= 0.5 if last > 0.0 else 1.0
            last = 1.0
        else:
            low, at_low = theta, phi
            at_high *= 0.5 if last < 0.0 else 1.0
            last = -1.0
        if phi == 0.0 or high - low <= RESOLUTION:
            return theta
    return high
