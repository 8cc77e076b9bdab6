"""The choice of the method of integration for the next step, and the calls of the chosen method.

The explicit method is better as long as accuracy limits its step: in flight and in impacts. In sustained
contact the stability or the loss of order of the explicit method limits the step. The fastest motion of a
contact has the rate ρ = max(c/m, √(k/m)), with its damping c, its stiffness k and the effective mass m at its
onset; with the step size h, the explicit method is stable for about hρ < 6. Explicit steps of an impact have
hρ below 1, so an explicit step with hρ above STIFF_STEP shows that the contact is sustained. A sustained
contact that oscillates also limits hρ; implicit steps may be cheaper for such a contact, too. An implicit
step costs as much as two or three explicit steps, so the implicit method is kept only if its next step is
longer than EQUAL_COST_RATIO times the last explicit step. The comparison uses the proposed size of the next
implicit step, because the first implicit steps after an event grow fast.

A drive with a damper or a spring has a rate of its own, in flight and in contact (chain/joints.py). A spring
oscillates rather than decays. If the oscillation is larger than the tolerance, the error control keeps hρ of
explicit steps below STIFF_STEP. If explicit steps have a larger hρ, the oscillation is so small that implicit
steps may damp it. Rigid walls cause no stiffness.

The functions ``prepare_step`` and ``integrate_trial`` take the size h of a step, in the step's integration
variable.
"""

import math

from chain_impact.kernel.chain.joints import largest_joint_rate
from chain_impact.kernel.forces.active_contacts import clear_applied_forces, contact_slopes
from chain_impact.kernel.ode import collocation, explicit
from chain_impact.kernel.ode.step_control import (
    AUTOMATIC_METHOD,
    begin_trial,
    limit_next_size,
    prescribed_method,
    propose_size,
    size_at_onset,
)
from chain_impact.kernel.record.constants import EXPLICIT, IMPLICIT
from chain_impact.kernel.record.method import is_implicit

# An explicit step with hρ > STIFF_STEP suggests the implicit method; h [s] is the size of the step, and ρ
# [1/s] the fastest rate of the contacts and joints. With STIFF_STEP below 1 the method would change in
# impacts; above about 6 explicit steps are unstable.
STIFF_STEP = 2.0
# the value that replaces STIFF_STEP if there are active contacts with a force law and all these are sustained
STIFF_STEP_IN_CONTACT = 0.1
# A contact counts as sustained after SUSTAINED_AFTER times its time scale, the expected penetration divided
# by the latched speed. An impact takes three to ten time scales, so with a smaller value an impact could
# count as sustained.
SUSTAINED_AFTER = 20.0
# An implicit step costs about as much as EQUAL_COST_RATIO explicit steps. An implicit step suggests the
# explicit method if the next implicit step is shorter than EQUAL_COST_RATIO times the last explicit step.
EQUAL_COST_RATIO = 2.5
# If the size of the last explicit step is not known, an implicit step with hρ < NOT_STIFF_STEP suggests the
# explicit method, with the size h and the rate ρ as for STIFF_STEP: two stable explicit steps then cover the
# same time at a lower cost.
NOT_STIFF_STEP = 5.0
# The largest product hρ of an explicit step that is limited to a stable size, with its size h and the fastest
# rate ρ of contacts and joints: two thirds of the hρ up to which DOP853 is stable. A longer step amplifies
# motions that are too small for the error control to notice.
STABLE_STEP = 4.0
# The implicit method continues in an impact only if joints make even IMPACT_PART of the impact's first
# explicit step stiff (hρ > STIFF_STEP). With a value of 1, implicit steps would continue although explicit
# ones cost less: in an impact, implicit steps are cheaper only if joints are far stiffer than the contact.
IMPACT_PART = 0.1
# The least number of steps in a row that must suggest the other method before the method changes. With fewer
# steps the method would change in the compression of an impact.
MIN_SWITCH_STEPS = 3


def choose_method(d):
    """Choose the method of the next step: by `solver.method`, or from contacts, drives and sizes of steps.

    In any case the method is explicit if walls or stops exist and are all rigid, and no drive has a spring or
    a damper. The points must be located at the start of the next step.
    """
    step = d.step
    is_touching = d.contacts.active_count > 0
    if d.contact_settings.any_rigid and not (
        d.contact_settings.any_force_law or d.chain.has_springs_or_dampers
    ):
        begin_explicit(d)  # rigid walls are constraints, which are not stiff
    elif d.solver.method != AUTOMATIC_METHOD:
        step.method = prescribed_method(d.solver.method)
        if is_touching and not is_implicit(d):
            limit_to_stable(d)
    elif not (is_touching or d.chain.has_springs_or_dampers):
        begin_explicit(d)  # neither contacts nor joints are stiff
    elif step.end > step.start:  # a last step of zero length, as after a restart, tells nothing
        step.stiff_count = step.stiff_count + 1 if suggests_switch(d) else 0
        if step.stiff_count >= step.switch_after:
            step.stiff_count = 0
            if is_implicit(d):
                # the change to the implicit method has not saved cost, so the next changes of the method need
                # twice as many steps in a row that suggest the other method
                step.switch_after *= 2
                step.method = EXPLICIT
                limit_to_stable(d)
            else:
                # if an event or an input has truncated the step, its length is not the size that the errors
                # allow: ``other_method_size`` 0 means unknown
                step.other_method_size = step.end - step.start if step.end_fraction == 1.0 else 0.0
                step.method = IMPLICIT
        elif step.stiff_count > 0 and not is_implicit(d):
            limit_to_stable(d)


def suggests_switch(d):
    """Return whether the other method would probably cost less than the present ``step.method``.

    If the present method is implicit, the proposed size of the next step decides. If the present method is
    explicit, the length of the last step decides.
    """
    step = d.step
    if is_implicit(d):
        if step.other_method_size > 0.0:
            return step.next_size < EQUAL_COST_RATIO * step.other_method_size
        return stiffness_number(d, step.next_size) < NOT_STIFF_STEP
    z = stiffness_number(d, step.end - step.start)
    return z > STIFF_STEP or (z > STIFF_STEP_IN_CONTACT and are_contacts_sustained(d))


def limit_to_stable(d):
    """Limit the next explicit step, with active contacts or stiff joints, to a stable size.

    While the chain is at rest, the error estimate does not show that a step is unstable: the state stays
    correct, but its derivatives with respect to parameters grow.
    """
    z = stiffness_number(d, d.step.end - d.step.start)
    if z > 0.0:  # z is hρ of the last step, whose size h up to its end is ``size`` × ``end_fraction``
        limit_next_size(d, d.step.size * d.step.end_fraction * STABLE_STEP / z)


def are_contacts_sustained(d):
    """Return whether contacts with a force law are active and all of them sustained (SUSTAINED_AFTER)."""
    if d.contacts.force_law_count == 0:
        return False
    for k in range(d.contacts.force_law_count):
        c = d.contacts.active_index[k]
        scale = d.contacts.expected_penetration[c] / d.contacts.latched_speed[c]
        if d.step.end - d.contacts.onset[c] < SUSTAINED_AFTER * scale:
            return False
    return True


def begin_impact(d, c):
    """Choose the method at the onset of candidate c, and reset the counts for a change of the method.

    The proposed step size must be the result of ``size_at_onset`` for the explicit method. The explicit
    method begins, unless the present method is implicit and drives make even a part of the first step of the
    impact stiff (IMPACT_PART); then the implicit method continues, with at most its ``size_at_onset``.
    """
    if find_joint_stiffness(d, IMPACT_PART * d.step.next_size) <= STIFF_STEP:
        d.step.method = EXPLICIT
    elif is_implicit(d):
        limit_next_size(d, size_at_onset(d, c, d.step.method))
    reset_stiff_count(d)


def begin_flight(d):
    """Choose the method after events that leave no active contact with a force law.

    The implicit method continues only if drives make the proposed step stiff. If the method is explicit, the
    next step gets a stable size. The counts for a change of the method are reset.
    """
    z = find_joint_stiffness(d, d.step.next_size)
    if z <= STIFF_STEP:
        d.step.method = EXPLICIT
    if not is_implicit(d):
        propose_size(d, stable_size(d, d.step.next_size))
    reset_stiff_count(d)


def stable_size(d, h):
    """Return a stable size [s] for the first explicit step: h, or less if drives are stiff.

    While the chain is at rest, the error estimate does not show that a step is far too long: the state at the
    end of such a step is correct, but the dense output is not.
    """
    return h * min(1.0, STABLE_STEP / max(STABLE_STEP, find_joint_stiffness(d, h)))


def begin_explicit(d):
    """Choose the explicit method, and reset the counts for a change of the method."""
    d.step.method = EXPLICIT
    reset_stiff_count(d)


def reset_stiff_count(d):
    """Reset the data for a change of the method: no step has suggested the other method so far.

    The number of successive steps that must suggest the other method becomes MIN_SWITCH_STEPS, and the size
    of the other method's steps becomes unknown.
    """
    step = d.step
    step.stiff_count, step.other_method_size = 0, 0.0
    step.switch_after = MIN_SWITCH_STEPS


def stiffness_number(d, h):
    """Return the product hρ for a step of size h [s]; ρ [1/s] is the fastest rate of contacts and drives.

    The part of the drives may be an upper bound, as in ``find_joint_stiffness``. The points must be located.
    """
    z = h * fastest_contact(d)
    return max(z, find_joint_stiffness(d, h)) if d.chain.has_springs_or_dampers else z


def find_joint_stiffness(d, h):
    """Return hρ for a step of size h [s], or an upper bound of hρ if this bound is at most STIFF_STEP.

    ρ [1/s] is the largest rate that the damper or the spring of a single drive causes alone
    (chain/joints.py). The bound is the product of h and ``chain.joint_rate_bound``. If the bound exceeds
    STIFF_STEP, ρ is computed, which overwrites the applied forces; afterwards the force at the tip is the
    input force there, and all other applied forces are 0.
    """
    z = h * d.chain.joint_rate_bound
    if z > STIFF_STEP:
        z = h * largest_joint_rate(d, d.step.state_end)
        clear_applied_forces(d)
    return z


def fastest_contact(d):
    """Return the fastest rate [1/s] of the active contacts with a force law; 0 without such a contact.

    The rate of a contact is max(c/m, √(k/m)), with c = ∂F/∂δ̇, k = ∂F/∂δ and the effective mass m at the
    onset. The points must be located.
    """
    largest_rate = 0.0
    for k in range(d.contacts.force_law_count):
        c = d.contacts.active_index[k]
        stiffness, damping = contact_slopes(d, c)
        mass = d.contacts.effective_mass[c]
        largest_rate = max(largest_rate, damping / mass, math.sqrt(stiffness / mass))
    return largest_rate


def prepare_step(d, h):
    """Prepare a step of the current method at the step's start; return the size that is to be tried first.

    h is the size that the errors allow. The result also suits the predicted ends of contacts with force laws
    (``size_toward_end``) and, in an implicit step that the last step cannot predict, a fast motion.
    """
    if is_implicit(d):
        return collocation.prepare_step(d, h)
    return explicit.size_toward_end(d, h)


def integrate_trial(d, h):
    """Try a step of size h from ``step.state_end`` with the current method.

    The result is in ``trial``: the state at the step's end, the outcome, and the error relative to the
    tolerance.
    """
    begin_trial(d, h)
    if is_implicit(d):
        collocation.integrate_trial(d, h)
    else:
        explicit.integrate_trial(d, h)
