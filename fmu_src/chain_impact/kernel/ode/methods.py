"""The choice of the method for the next step, which is then prepared and tried by it.

The explicit method is better as long as accuracy limits its step: in flight and in impacts. In sustained
contact its stability limits the step, or its loss of order. The fastest motion of a contact has the rate
ρ = max(c/m, √(k/m)), with m the effective mass at its onset; the explicit method is stable for about hρ < 6.
Impacts are resolved with hρ below 1, so explicit steps beyond STIFF show, at no cost, that the contact is
sustained. A sustained contact may still oscillate, with shorter steps; implicit steps may be cheaper for it
as well. An implicit step costs two or three explicit ones, so it must be longer than the last explicit step
by the same factor. Its size is taken as the size of the next step, because the first implicit steps after an
event grow fast.

A joint with a damper or a spring has a rate of its own, in flight and in contact (chain/joints.py). A
spring oscillates rather than decays. If the oscillation matters at the tolerance, the explicit steps have hρ
below STIFF; if they are longer, the oscillation is so small that implicit steps may damp it.
Rigid walls cause no stiffness: with them only joints do.

The functions of a try take the size h of a step, in its integration variable.
"""

import math

from chain_impact.kernel.chain.joints import joint_rate
from chain_impact.kernel.forces.contact import clear_loads, contact_slopes
from chain_impact.kernel.ode import collocation, explicit
from chain_impact.kernel.ode.control import (
    AUTO,
    EXPLICIT,
    IMPLICIT,
    at_onset,
    begin_trial,
    chosen,
    limit,
    propose,
)

# The hρ of explicit steps beyond which implicit ones could replace them. Impacts are resolved with less than
# 1, and DOP853 is stable up to about 6.
STIFF = 2.0
# The hρ of explicit steps in sustained contacts beyond which implicit ones could replace them; and the
# duration, in time scales of the contact, after which a contact counts as sustained: an impact takes three to
# ten.
RINGS, LASTS = 0.1, 20.0
# The size of implicit steps over that of explicit ones, below which explicit ones advance farther for the
# same work; and the hρ of implicit steps below which this holds, if the size of explicit ones is not known.
LONGER, NOT_STIFF = 2.5, 5.0
# The largest hρ of explicit steps in contact, and of the first one in flight: two thirds of what is stable. A
# longer step amplifies motions that are too small for the error control.
STABLE = 4.0
# The part of the explicit method's first step in an impact with which joints are compared. Explicit steps of
# an impact cost so much less than implicit ones that only joints far stiffer than the contact favour implicit
# steps.
IMPACT = 0.1
# The number of steps in a row that must favour the other method: with fewer the method would change in the
# compression of an impact.
MIN_SWITCH_STEPS = 3


def choose_method(d):
    """Choose the method of the next step, with the points located at its start."""
    step = d.step
    touching = d.touch.active_count > 0
    if d.contact.any_rigid and not (d.contact.any_force or d.model.resisting):
        begin_explicit(d)  # constraints by rigid walls are not stiff
    elif d.solver.method != AUTO:
        step.method = chosen(d.solver.method)
        if touching and step.method == EXPLICIT:
            keep_stable(d)
    elif not (touching or d.model.resisting):
        begin_explicit(d)  # nothing is stiff
    elif step.end > step.start:  # not just re-initialized
        step.stiff_count = step.stiff_count + 1 if suggests_switch(d) else 0
        if step.stiff_count >= step.switch_hysteresis:
            step.stiff_count = 0
            if step.method == IMPLICIT:
                # the switch did not pay: require more steps before the next one
                step.switch_hysteresis *= 2
                step.method = EXPLICIT
                keep_stable(d)
            else:
                # the size of a step that an event or an input has truncated is no evidence
                step.explicit_size = step.end - step.start if step.kept == 1.0 else 0.0
                step.method = IMPLICIT
        elif step.stiff_count > 0 and step.method == EXPLICIT:
            keep_stable(d)


def suggests_switch(d):
    """Return whether the next implicit step's size, or the last explicit one's, favours the other method."""
    step = d.step
    if step.method == IMPLICIT:
        if step.explicit_size > 0.0:
            return step.next_size < LONGER * step.explicit_size
        return stiffness_number(d, step.next_size) < NOT_STIFF
    z = stiffness_number(d, step.end - step.start)
    return z > STIFF or (z > RINGS and contacts_last(d))


def keep_stable(d):
    """Limit the next explicit step beside contacts or stiff joints to a stable one.

    At rest the errors do not show that a step is too long: the end state is kept, but derivatives grow.
    """
    z = stiffness_number(d, d.step.end - d.step.start)
    if z > 0.0:  # which is in proportion to the part of the last step that was kept
        limit(d, d.step.size * d.step.kept * STABLE / z)


def contacts_last(d):
    """Return whether there are active contacts with a force law, and all of them are sustained."""
    if d.touch.compliant_count == 0:
        return False
    for k in range(d.touch.compliant_count):
        c = d.touch.active_index[k]
        scale = d.touch.depth_scale[c] / d.touch.impact_speed[c]
        if d.step.end - d.touch.onset[c] < LASTS * scale:
            return False
    return True


def begin_impact(d, c):
    """Begin a new phase at the onset of candidate c, with the explicit method and the proposed step size.

    The size comes from ``at_onset`` for the explicit method. If steps were implicit, and joints make the
    steps of the impact stiff as well, the method is kept.
    """
    if joints_over(d, IMPACT * d.step.next_size) <= STIFF:
        d.step.method = EXPLICIT
    elif d.step.method != EXPLICIT:
        limit(d, at_onset(d, c, d.step.method))
    reset_stiff_count(d)


def begin_flight(d):
    """Begin a new phase after the last contact or an impact on a rigid wall, as in ``begin_impact``."""
    z = joints_over(d, d.step.next_size)
    if z <= STIFF:
        d.step.method = EXPLICIT
    if d.step.method == EXPLICIT:
        propose(d, stable(d, d.step.next_size))
    reset_stiff_count(d)


def stable(d, h):
    """Return a size [s] for the first explicit step: h, or less if stiff joints require it for stability.

    At rest the errors do not show this: a step that is far too long keeps the end state, but not the dense
    output.
    """
    return h * min(1.0, STABLE / max(STABLE, joints_over(d, h)))


def begin_explicit(d):
    """Begin a new phase with the explicit method."""
    d.step.method = EXPLICIT
    reset_stiff_count(d)


def reset_stiff_count(d):
    """Reset the counts that lead to a change of the method."""
    step = d.step
    step.stiff_count, step.explicit_size = 0, 0.0
    step.switch_hysteresis = MIN_SWITCH_STEPS


def stiffness_number(d, h):
    """Return hρ of a step [s], with the fastest rate of active contacts and of joints that resist."""
    z = h * fastest_contact(d)
    return max(z, joints_over(d, h)) if d.model.resisting else z


def joints_over(d, h):
    """Return hρ of a step [s] for joints with dampers or springs; an upper bound if they are not stiff."""
    z = h * d.model.joint_bound
    if z > STIFF:
        z = h * joint_rate(d, d.step.state_end)
        clear_loads(d)
    return z


def fastest_contact(d):
    """Return the largest max(c/m, √(k/m)) [1/s] of active contacts with a force law, for located points."""
    fastest = 0.0
    for k in range(d.touch.compliant_count):
        c = d.touch.active_index[k]
        stiffness, damping = contact_slopes(d, c)
        mass = d.touch.effective_mass[c]
        fastest = max(fastest, damping / mass, math.sqrt(stiffness / mass))
    return fastest


def prepare(d, h):
    """Prepare a step at its start by the current method; return the size h to try first."""
    if d.step.method == IMPLICIT:
        return collocation.prepare(d, h)
    return explicit.toward_end(d, h)


def attempt(d, h):
    """Try a step of size h from ``step.state_end`` by the current method.

    The outcome is in ``trial``: the state at the step's end, and the error relative to the tolerance, which
        is not finite if f was not.
    """
    begin_trial(d, h)
    if d.step.method == IMPLICIT:
        collocation.attempt(d, h)
    else:
        explicit.attempt(d, h)
