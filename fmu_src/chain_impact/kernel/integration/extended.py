"""The equations of an implicit step: those of motion, together with the clearances of the active contacts.

As the links turn, the coordinates of a stage leave the wall's tangent by ½ h² J̇ẏ. That is little, but often
more than the penetration of a stiff wall. So the clearances g of the active contacts and their rates are
integrated together with y, z = (y, g, ġ, q), with g̈ the acceleration of the point along the normal and q the
quadratures. The forces are evaluated at g and ġ, in which the fast motions are linear
except for the force law.

A rigid wall has no force law and constrains its points as in all other steps (model/holding.py): z has
no entries for them.
"""

from chain_impact.kernel.chain.kinematics import accelerate_points, locate_points
from chain_impact.kernel.chain.state import sundman_u_at
from chain_impact.kernel.integration.quadratures import quadrature_rates
from chain_impact.kernel.model.constraints import any_constraint
from chain_impact.kernel.model.contact import apply_contact, clear_loads
from chain_impact.kernel.model.contact_force import law_slopes
from chain_impact.kernel.model.equations import loaded_rate
from chain_impact.kernel.model.friction import apply_friction
from chain_impact.kernel.model.geometry import (
    clearance,
    gap_acceleration,
)
from chain_impact.kernel.model.holding import add_constraint_forces
from chain_impact.kernel.model.inputs import set_inputs


def gap_at(d, k):
    """The index in z of the clearance of the k-th active contact: from that of u on, which is 1 here."""
    return sundman_u_at(d.links) + k


def compliant(d):
    """The number of contacts with clearances in z: the active ones whose law has a force."""
    return d.touch.compliant_count


def rate_at(d, k):
    """The index in z of the rate of that clearance."""
    return gap_at(d, compliant(d) + k)


def quadrature_at(d, k):
    """The index in z of the k-th quadrature: first the impulses of these contacts, if they are requested."""
    return gap_at(d, 2 * compliant(d) + k)


def extended_size(d):
    """The length of z."""
    return quadrature_at(d, d.quadrature.count)


def extend_start(d):
    """Set z and ż at the start of the next step, from the state and the rate there."""
    work, own, n = d.work, d.implicit, d.links
    if not work.at_end:
        locate_points(d, d.step.state_end)
    accelerate_points(d, d.step.state_end, work.rate_start)
    for j in range(sundman_u_at(n)):
        own.start[j], own.start_rate[j] = d.step.state_end[j], work.rate_start[j]
    for k in range(compliant(d)):
        own.start[gap_at(d, k)], own.start[rate_at(d, k)] = clearance(d, d.touch.active_index[k])
    for k in range(d.quadrature.count):
        own.start[quadrature_at(d, k)] = d.quadrature.state_end[k]
        own.start_rate[quadrature_at(d, k)] = d.quadrature.rate_end[k]
    clearance_rates(d, own.start, own.start_rate)


def clearance_rates(d, z, rate):
    """Set the rates of g and ġ, for accelerated points."""
    for k in range(compliant(d)):
        rate[gap_at(d, k)] = z[rate_at(d, k)]
        rate[rate_at(d, k)] = gap_acceleration(d, d.touch.active_index[k])


def extended_rate(d, z, elapsed, rate):
    """Set rate = ż, ``elapsed`` [s] after the start, with the contact forces at clearances and rates in z."""
    if d.inputs.course.order > 0:
        set_inputs(d, d.step.clock + elapsed)
    locate_points(d, z)
    clear_loads(d)
    dissipated = 0.0
    for k in range(compliant(d)):
        dissipated += apply_contact(d, d.touch.active_index[k], z[gap_at(d, k)], z[rate_at(d, k)])
    if d.friction.count > 0:
        dissipated += apply_friction(d)
    loaded_rate(d, z, dissipated, rate)  # also sets those of u and time, where z has other entries
    if any_constraint(d):
        add_constraint_forces(d, z, rate)
    quadrature_rates(d, 1.0, rate[quadrature_at(d, 0) :])
    accelerate_points(d, z, rate)
    clearance_rates(d, z, rate)


def extended_slopes(d, z):
    """Set ∂F/∂δ and ∂F/∂δ̇ of the active contacts for z, and store its link vectors, which are located."""
    own, link = d.implicit, d.work.link
    for i in range(d.links):
        own.link.x[i], own.link.y[i] = link.x[i], link.y[i]
    for k in range(compliant(d)):
        c = d.touch.active_index[k]
        depth, rate = max(0.0, -z[gap_at(d, k)]), -z[rate_at(d, k)]
        own.stiffness[k], own.damping[k] = law_slopes(d, c, depth, rate)
