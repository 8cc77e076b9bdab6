"""The start of a tangent instance: the derivatives of all that follows from the parameters."""

from chain_impact.kernel.advance import recompute_active_set
from chain_impact.kernel.initialize import apply_given, clear_run, derive_chain, set_initial_state
from chain_impact.kernel.integration.last_step import reset_step
from chain_impact.kernel.integration.switching import begin_explicit
from chain_impact.kernel.laws.contact_laws import ANY, LAW_COUNT, RATE_EXPONENTS, damping_factor
from chain_impact.kernel.model.contact import clear_loads, set_kink_sides
from chain_impact.kernel.model.contact_force import set_damping, set_expected_depth
from chain_impact.kernel.model.geometry import place_walls
from chain_impact.kernel.tangent.blocks import copy_values
from chain_impact.kernel.tangent.directions import carried, value
from chain_impact.kernel.tangent.trust import TRUSTED


def start_tangent(d, t):
    """Initialize t from d, which is initialized; t already has the derivatives of the parameters."""
    copy_parameters(d, t)
    derive_chain(t)
    clear_run(t)
    apply_given_of(d, t)
    derive_law_of(d, t)
    place_walls(t)
    set_initial_state(t, t.work.y)
    reset_step(t, d.step.time, t.work.y)
    clear_loads(t)
    begin_explicit(t.step)
    t.impact.last_time = d.step.time
    t.trust.reason = TRUSTED


def reinit_tangent(d, t):
    """Re-initialize t at the communication point, as d has been; the contacts of t are updated to it."""
    reset_step(t, t.step.end, t.step.state_end)
    rigid = t.contact.impulsive
    apply_given_of(d, t)
    derive_law_of(d, t)
    for k in range(t.touch.active_count):
        if not t.contact.impulsive:
            set_expected_depth(t, t.touch.active_index[k])
            set_damping(t, t.touch.active_index[k])
    recompute_active_set(t, rigid)
    set_kink_sides(t)
    clear_loads(t)
    # derivatives that ended in the part of the run that is dropped may go on: the new part decides
    if t.trust.time > value(t.step.end):
        t.trust.reason = TRUSTED


def copy_parameters(d, t):
    """Copy the parameters and initial values of d to t, which keeps the derivatives that it has of them."""
    copy_values(d.model, t.model)
    copy_values(d.contact, t.contact)
    copy_values(d.initial, t.initial)
    copy_values(d.solver, t.solver)
    copy_values(d.walls, t.walls)


def apply_given_of(d, t):
    """Apply the values that were given to d to t, which keeps the derivatives that it has of them."""
    copy_values(d.given, t.given)
    apply_given(t)


def copy_inputs(d, t):
    """Copy the present inputs of d to t: a derivative is that for a constant added to an input."""
    own = t.inputs
    copy_values(d.inputs.course, own.course)
    for i in range(t.links):
        own.joint_torque[i] = own.course.joint_torque[0, i]
    for j in range(2):
        own.tip_force[j] = own.course.tip_force[0, j]


def derive_law_of(d, t):
    """Derive the constants of the law of d from the restitution of t."""
    own, contact = t.contact, d.contact
    own.impulsive, own.approach_only = contact.impulsive, contact.approach_only
    own.rate_exponent, own.damping_factor = contact.rate_exponent, contact.damping_factor
    if contact.law <= LAW_COUNT:
        if RATE_EXPONENTS[contact.law - 1] == ANY:
            own.rate_exponent = own.exponent
        factor = damping_factor(contact.law, own.restitution)
        own.damping_factor = carried(contact.damping_factor, 1.0, factor)
