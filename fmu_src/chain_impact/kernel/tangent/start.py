"""The start of a tangent instance: the derivatives of all that follows from the parameters."""

from chain_impact.kernel.advance import apply_laws
from chain_impact.kernel.initialize import clear_run, derive_chain, set_start
from chain_impact.kernel.integration.last_step import reset_step
from chain_impact.kernel.integration.switching import begin_explicit
from chain_impact.kernel.laws.contact_laws import ANY, LAW_COUNT, RATE_EXPONENTS, damping_factor
from chain_impact.kernel.model.contact import clear_loads
from chain_impact.kernel.model.contact_law import copy_law, set_parameters
from chain_impact.kernel.model.inputs import apply_inputs
from chain_impact.kernel.record.fields import AT_ANY_TIME, AT_START
from chain_impact.kernel.tangent.blocks import copy_given, copy_values
from chain_impact.kernel.tangent.directions import carried, value
from chain_impact.kernel.tangent.friction import check_coefficients
from chain_impact.kernel.tangent.trust import trust


def start_tangent(d, t):
    """Initialize t from d, which is initialized; t already has the derivatives of the parameters."""
    copy_given(d, t, AT_START)
    derive_chain(t)
    clear_run(t, d.step.time)
    apply_given_of(d, t)
    trust(t)
    copy_modes(d, t)
    set_start(t, d.step.time)
    check_coefficients(t)
    begin_explicit(t)


def reinit_tangent(d, t):
    """Re-initialize t at the communication point, as d has been; the contacts of t are updated to it."""
    reset_step(t, t.step.end, t.step.state_end)
    # derivatives that ended in the part of the run that is dropped may go on: the new part decides
    if t.trust.time > value(t.step.end):
        trust(t)
    apply_given_of(d, t)
    copy_modes(d, t)
    apply_laws(t)
    check_coefficients(t)
    clear_loads(t)


def apply_given_of(d, t):
    """Apply the values that were given to d to t, which keeps the derivatives that it has of them."""
    copy_given(d, t, AT_ANY_TIME)
    apply_inputs(t)
    derive_laws_of(d, t)


def copy_modes(d, t):
    """Copy the modes of dry friction of d to t, which takes them where it would choose (rules.py)."""
    for e in range(d.elements):
        t.element.chosen[e] = d.element.mode[e]


def copy_inputs(d, t):
    """Copy the present inputs of d to t: a derivative is that for a constant added to an input."""
    own = t.inputs
    copy_values(d.inputs.course, own.course)
    for i in range(t.links):
        own.joint_torque[i] = own.course.joint_torque[0, i]
    for j in range(2):
        own.tip_force[j] = own.course.tip_force[0, j]


def derive_laws_of(d, t):
    """Derive the constants of the laws of d from the parameters of t."""
    own, law = t.law, d.law
    t.contact.any_force, t.contact.any_rigid = d.contact.any_force, d.contact.any_rigid
    t.contact.any_friction = d.contact.any_friction
    for c in range(t.candidates):
        own.same_as[c] = law.same_as[c]
        if law.same_as[c] == c:
            set_parameters(t, c)
            derive_law_of(d, t, c)
        else:
            copy_law(own, law.same_as[c], c)


def derive_law_of(d, t, c):
    """Derive the constants of the law of candidate c of d from the parameters of t."""
    own, law, number = t.law, d.law, d.law.number[c]
    own.impulsive[c], own.approach_only[c] = law.impulsive[c], law.approach_only[c]
    own.rate_exponent[c], own.damping_factor[c] = law.rate_exponent[c], law.damping_factor[c]
    if number <= LAW_COUNT:
        if RATE_EXPONENTS[number - 1] == ANY:
            own.rate_exponent[c] = own.exponent[c]
        factor = damping_factor(number, own.restitution[c])
        own.damping_factor[c] = carried(law.damping_factor[c], 1.0, factor)
