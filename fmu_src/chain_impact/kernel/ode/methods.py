"""The choice of the method for the next step, and the calls of this method.

The explicit method is better as long as accuracy limits its step: in flight and in impacts. In sustained
contact the stability or the loss of order of the explicit method limits the step. The fastest motion of a
contact has the rate ρ = max(c/m, √(k/m)), with its damping c, its stiffness k and the effective mass m at its
onset; with the step size h, the explicit method is stable for about hρ < 6. Steps of an impact have hρ below
1, so explicit steps with hρ above STIFF_STEP show, at no cost, that the contact is sustained. A sustained
contact may still oscillate, with shorter steps; implicit steps may be cheaper for such a contact, too. An
implicit step costs two or three explicit ones, so it must be longer than the last explicit step by the same
factor. The size of an implicit step for this comparison is the size of the next step, because the first
implicit steps after an event grow fast.

A joint with a damper or a spring has a rate of its own, in flight and in contact (chain/joints.py). A
spring oscillates rather than decays. If the oscillation matters at the tolerance, the explicit steps have hρ
below STIFF_STEP; if they are longer, the oscillation is so small that implicit steps may damp it.
Rigid walls cause no stiffness.

The functions ``prepare`` and ``attempt`` take the size h of a step, in the step's integration variable.
"""

import math

from chain_impact.kernel.chain.joints import largest_joint_rate
from chain_impact.kernel.forces.active_contacts import clear_loads, contact_slopes
from chain_impact.kernel.ode import collocation, explicit
from chain_impact.kernel.ode.control import (
    AUTO,
    EXPLICIT,
    IMPLICIT,
    begin_trial,
    limit_next_size,
    prescribed_method,
    propose_size,
    size_at_onset,
)

# The product hρ of the size and the fastest rate of explicit steps above which implicit steps could be
# cheaper. Steps of an impact have less than 1, and DOP853 is stable up to about 6.
STIFF_STEP = 2.0
# the hρ of explicit steps in sustained contacts above which implicit steps could be cheaper
STIFF_STEP_IN_CONTACT = 0.1
# The duration, in time scales of the contact, after which a contact counts as sustained. An impact takes
# three to ten time scales.
SUSTAINED_AFTER = 20.0
# the ratio of implicit to explicit step size below which explicit steps advance farther in time at the same
# cost
EQUAL_COST_RATIO = 2.5
# the hρ of implicit steps below which explicit steps advance farther at the same cost, if the size of
# explicit steps is not known
NOT_STIFF_STEP = 5.0
# The largest hρ of explicit steps in contact, and of the first explicit step in flight: two thirds of the
# stable hρ. A longer step amplifies motions that are too small for the error control.
STABLE_STEP = 4.0
# This part of the first explicit step of an impact must still be stiff because of joints; otherwise the
# impact begins with explicit steps. Explicit steps of an impact cost much less than implicit steps, so
# implicit steps are cheaper only if joints are far stiffer than the contact.
IMPACT_PART = 0.1
# The number of steps in a row that must favour the other method before the method changes. With fewer steps
# the method would change in the compression of an impact.
MIN_SWITCH_STEPS = 3


def choose_method(d):
    """Choose the method of the next step, with the points located at the start of this step."""
    step = d.step
    touching = d.touch.active_count > 0
    if d.contact.any_rigid and not (d.contact.any_force or d.chain.has_springs_or_dampers):
        begin_explicit(d)  # rigid walls are constraints, which are not stiff
    elif d.solver.method != AUTO:
        step.method = prescribed_method(d.solver.method)
        if touching and step.method == EXPLICIT:
            limit_to_stable(d)
    elif not (touching or d.chain.has_springs_or_dampers):
        begin_explicit(d)  # neither contacts nor joints are stiff
    elif step.end > step.start:  # the last step has a length, so the run was not re-initialized just now
        step.stiff_count = step.stiff_count + 1 if suggests_switch(d) else 0
        if step.stiff_count >= step.switch_hysteresis:
            step.stiff_count = 0
            if step.method == IMPLICIT:
                # the last change of the method did not pay, so more steps must favour the next change
                step.switch_hysteresis *= 2
                step.method = EXPLICIT
                limit_to_stable(d)
            else:
                # the size is 0, for unknown, if an event or an input has truncated the step: the size that
                # the errors allow is not known
                step.explicit_size = step.end - step.start if step.end_fraction == 1.0 else 0.0
                step.method = IMPLICIT
        elif step.stiff_count > 0 and step.method == EXPLICIT:
            limit_to_stable(d)


def suggests_switch(d):
    """Return whether the size of a step favours the other method.

    The size is that of the next implicit or of the last explicit step.
    """
    step = d.step
    if step.method == IMPLICIT:
        if step.explicit_size > 0.0:
            return step.next_size < EQUAL_COST_RATIO * step.explicit_size
        return stiffness_number(d, step.next_size) < NOT_STIFF_STEP
    z = stiffness_number(d, step.end - step.start)
    return z > STIFF_STEP or (z > STIFF_STEP_IN_CONTACT and contacts_last(d))


def limit_to_stable(d):
    """Limit the next explicit step, with active contacts or stiff joints, to a stable size.

    At rest the errors do not show that a step is too long: the state stays correct, but derivatives grow.
    """
    z = stiffness_number(d, d.step.end - d.step.start)
    if z > 0.0:  # z = hρ is the value of the last step up to its ``end_fraction``
        limit_next_size(d, d.step.size * d.step.end_fraction * STABLE_STEP / z)


def contacts_last(d):
    """Return whether contacts with a force law are active, and all of these are sustained."""
    if d.touch.compliant_count == 0:
        return False
    for k in range(d.touch.compliant_count):
        c = d.touch.active_index[k]
        scale = d.touch.depth_scale[c] / d.touch.impact_speed[c]
        if d.step.end - d.touch.onset[c] < SUSTAINED_AFTER * scale:
            return False
    return True


def begin_impact(d, c):
    """Begin a new phase at the onset of candidate c, with the explicit method and the proposed step size.

    The proposed size is the result of ``size_at_onset`` for the explicit method. If the last steps were
    implicit, and joints make the steps of the impact stiff, too, the method stays implicit.
    """
    if find_joint_stiffness(d, IMPACT_PART * d.step.next_size) <= STIFF_STEP:
        d.step.method = EXPLICIT
    elif d.step.method != EXPLICIT:
        limit_next_size(d, size_at_onset(d, c, d.step.method))
    reset_stiff_count(d)


def begin_flight(d):
    """Begin a new phase after the last contact or an impact on a rigid wall.

    The method stays implicit only if joints make the proposed step stiff; an explicit step gets a stable
    size.
    """
    z = find_joint_stiffness(d, d.step.next_size)
    if z <= STIFF_STEP:
        d.step.method = EXPLICIT
    if d.step.method == EXPLICIT:
        propose_size(d, stable_size(d, d.step.next_size))
    reset_stiff_count(d)


def stable_size(d, h):
    """Return a stable size [s] for the first explicit step: h, or less if joints are stiff.

    At rest the errors do not show that a step is far too long: its end state is correct, but its dense output
    is not.
    """
    return h * min(1.0, STABLE_STEP / max(STABLE_STEP, find_joint_stiffness(d, h)))


def begin_explicit(d):
    """Begin a new phase with the explicit method."""
    d.step.method = EXPLICIT
    reset_stiff_count(d)


def reset_stiff_count(d):
    """Reset the counts of steps that favour a change of the method."""
    step = d.step
    step.stiff_count, step.explicit_size = 0, 0.0
    step.switch_hysteresis = MIN_SWITCH_STEPS


def stiffness_number(d, h):
    """Return the product hρ for a step of size h [s]; ρ is the fastest rate of contacts and of joints."""
    z = h * fastest_contact(d)
    return max(z, find_joint_stiffness(d, h)) if d.chain.has_springs_or_dampers else z


def find_joint_stiffness(d, h):
    """Return hρ for a step of size h [s], with the fastest rate ρ of joints with dampers or springs.

    If an upper bound of hρ is at most STIFF_STEP, the function returns this bound, and ρ is not computed.
    """
    z = h * d.chain.joint_rate_bound
    if z > STIFF_STEP:
        z = h * largest_joint_rate(d, d.step.state_end)
        clear_loads(d)
    return z


def fastest_contact(d):
    """Return the fastest rate [1/s] of active contacts with a force law, for located points.

    The rate of a contact is max(c/m, √(k/m)), with c = ∂F/∂δ̇, k = ∂F/∂δ and the effective mass m.
    """
    fastest = 0.0
    for k in range(d.touch.compliant_count):
        c = d.touch.active_index[k]
        stiffness, damping = contact_slopes(d, c)
        mass = d.touch.effective_mass[c]
        fastest = max(fastest, damping / mass, math.sqrt(stiffness / mass))
    return fastest


def prepare(d, h):
    """Prepare a step of the current method at its start; return the size h to try first."""
    if d.step.method == IMPLICIT:
        return collocation.prepare(d, h)
    return explicit.size_toward_end(d, h)


def attempt(d, h):
    """Try a step of size h from ``step.state_end`` with the current method.

    The result is in ``trial``: the state at the step's end, the outcome, and the error relative to the
    tolerance.
    """
    begin_trial(d, h)
    if d.step.method == IMPLICIT:
        collocation.attempt(d, h)
    else:
        explicit.attempt(d, h)
