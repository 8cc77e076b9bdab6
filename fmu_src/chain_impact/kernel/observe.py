"""The outputs at the communication point.

A value that an importer sets at this point changes the outputs of accelerations, forces, sticking and elastic
energy at once. It changes the outputs of positions, of velocities, and of integrals such as impulses, only
after the next step or ``event_update``.
"""

from chain_impact.kernel import hooks
from chain_impact.kernel.chain.drives import drive_component, length_per_coordinate
from chain_impact.kernel.chain.inputs import ensure_inputs
from chain_impact.kernel.chain.kinematics import accelerate_points, locate_points
from chain_impact.kernel.chain.signals import signal_at
from chain_impact.kernel.chain.sites import point_of_site, site_place
from chain_impact.kernel.chain.slider import slider_position
from chain_impact.kernel.constraints.geometry import (
    clearance_and_rate,
    first_stop,
    is_at_joint_stop,
    joint_stop_moment,
    lever_of_candidate,
)
from chain_impact.kernel.constraints.impulses import any_constraint
from chain_impact.kernel.cost import read_cost_counts, restore_cost_counts
from chain_impact.kernel.equations import mechanical_energy, stored_energy, true_rate_from_inputs
from chain_impact.kernel.events.contact_log import list_latest
from chain_impact.kernel.forces.active_contacts import set_true_forces
from chain_impact.kernel.forces.friction import drive_of_element
from chain_impact.kernel.forces.holding import project_state
from chain_impact.kernel.ode.dense_output import dissipated_energy, fraction_at_time, interpolate_state
from chain_impact.kernel.ode.folds import correct_near_fold
from chain_impact.kernel.ode.quadratures import quadrature_within
from chain_impact.kernel.record.constants import STICKS
from chain_impact.kernel.record.state import (
    FIRST_ANGLE,
    omega_at,
    relative_to_previous,
    supplied_at,
    time_at,
    velocity_at,
)
from chain_impact.kernel.transmitted_forces import (
    fill_joint_force_peaks,
    fill_joint_impulses,
    fill_transmitted_forces,
    store_tip_impulse,
)


def observe(d):
    """Fill the outputs with the values at the communication point; call ``on_observe`` (kernel/hooks.py).

    In a kernel with tangent instances, ``on_observe`` sets the derivatives of the outputs.
    """
    fill_outputs(d)
    hooks.on_observe(d)


def observe_state(d):
    """Fill the STATE_OUTPUTS of record/instance.py at the communication point; others are then invalid."""
    counts = read_cost_counts(d)
    fill_state(d, fraction_at_time(d, d.step.communication_point))
    restore_cost_counts(d, counts)


def fill_outputs(d):
    """Fill the outputs with the values at the communication point.

    The active contacts are those of the step that contains this time. An event at the end of this step, which
    the solver has already found, is not visible yet.
    """
    counts, theta = read_cost_counts(d), fraction_at_time(d, d.step.communication_point)
    fill_outputs_but_integrals(d, theta)
    fill_quadratures(d, theta)
    if d.transmitted_row_count > 0:
        fill_joint_impulses(d)
    list_latest(d)
    if d.chain.has_joint_stops:
        combine_forces(d)
        combine_impulses(d)
    if d.transmitted_row_count > 0:
        fill_joint_force_peaks(d)
    restore_cost_counts(d, counts)


def refill_outputs_but_integrals(d):
    """Fill the outputs of motion, forces and energies again, at the communication point.

    Impulses, peaks, the list of impacts and the energy of friction do not change.
    """
    counts = read_cost_counts(d)
    fill_outputs_but_integrals(d, fraction_at_time(d, d.step.communication_point))
    if d.chain.has_joint_stops:
        combine_forces(d)
    restore_cost_counts(d, counts)


def fill_outputs_but_integrals(d, theta):
    """Fill the outputs of motion, forces and energies at the fraction θ of the last step.

    If requested, the transmitted forces of joints and walls are filled, too, but not their impulses and
    peaks.
    """
    n, out, scratch, y, rate = d.link_count, d.output, d.scratch, d.scratch.state, d.scratch.rate
    fill_state(d, theta)
    true_rate_from_inputs(d, y, rate)
    correct_near_fold(d, theta, y, rate)
    accelerate_points(d, y, rate)
    fill_points(d, scratch.acceleration, out.point_acceleration)
    for i in range(n):
        out.angular_acceleration[i] = rate[omega_at(n) + i]
    if d.slides:
        out.slider_acceleration = drive_component(d, rate, velocity_at(n), n)
    fill_forces(d)
    if d.friction_element_count > 0:
        fill_friction(d)
    if d.transmitted_row_count > 0:
        fill_transmitted_forces(d, y, rate)


def fill_points(d, vectors, out):
    """Copy the ``vectors`` of points 0…N and of sites to ``out``, whose row k has the vector of point k."""
    for k in range(d.link_count + 1):
        out[k, 0], out[k, 1] = vectors.x[k], vectors.y[k]
    for s in range(d.site_count):
        k, place = point_of_site(d, s), site_place(d, s)
        out[k, 0], out[k, 1] = vectors.x[place], vectors.y[place]


def fill_state(d, theta):
    """Fill the outputs of STATE_OUTPUTS at the fraction θ of the last step.

    Afterwards the points are located there.
    """
    n, out, y = d.link_count, d.output, d.scratch.state
    interpolate_state(d.step, theta, y)
    locate_points(d, y)
    if d.channel_count > 0 and any_constraint(d):
        # The dense output satisfies constraints and prescribed motions only up to its error, so the state y
        # is projected. For the projection, ``set_true_forces`` sets the limits of friction: dependent
        # sticking elements share the force in proportion to these limits.
        set_true_forces(d)
        project_state(d, y)
    ensure_inputs(d, y)
    scratch = d.scratch
    fill_points(d, scratch.position, out.point_position)
    fill_points(d, scratch.velocity, out.point_velocity)
    for i in range(n):
        out.angle[i], out.joint_angle[i] = y[FIRST_ANGLE + i], relative_to_previous(y, FIRST_ANGLE, i)
        out.angular_velocity[i] = y[omega_at(n) + i]
        out.joint_angular_velocity[i] = relative_to_previous(y, omega_at(n), i)
    if d.slides:
        out.slider_position = slider_position(d, y)
        out.slider_velocity = drive_component(d, y, velocity_at(n), n)
    for m in range(d.channel_count):
        out.channel[m] = d.channel.position[m]
    for j in range(d.signal_count):
        value, rate, curvature = signal_at(d, j, d.step.time_origin + y[time_at(n)])
        out.signal[j, 0], out.signal[j, 1], out.signal[j, 2] = value, rate, curvature
    out.kinetic, out.potential = mechanical_energy(d, y)
    out.elastic = stored_energy(d, y)
    out.dissipated = dissipated_energy(d, y)
    out.supplied = y[supplied_at(n)]
    out.total = out.kinetic + out.potential + out.elastic


def fill_forces(d):
    """Fill force, penetration and its rate of each candidate, from located points and the last evaluated ẏ.

    Without contact they are 0. ``fill_friction`` and ``fill_quadratures`` fill the other outputs of contacts.
    """
    out = d.output
    for c in range(d.candidate_count):
        out.force[c], out.penetration[c], out.penetration_rate[c] = 0.0, 0.0, 0.0
    for k in range(d.contacts.active_count):
        c = d.contacts.active_index[k]
        clearance, clearance_rate = clearance_and_rate(d, c)
        if d.law.rigid[c]:
            out.force[c] = max(0.0, d.constraints.impulse[k])
        elif clearance < 0.0:
            out.force[c] = d.contacts.force[c]
            out.penetration[c], out.penetration_rate[c] = -clearance, -clearance_rate


def fill_friction(d):
    """Fill the outputs of dry friction, except impulses and energy, after ``fill_forces``."""
    friction, out = d.friction, d.output.friction
    for e in range(d.friction_element_count):
        out.force[e], out.sticking[e] = 0.0, 0.0
        out.drive_friction[e], out.drive_sticking[e] = 0.0, 0.0
    for i in range(friction.active_count):
        e = d.friction_element.index[i]
        mode = d.friction_element.mode[e]
        sticks = 1.0 if mode == STICKS else 0.0
        if e >= d.candidate_count:
            k = drive_of_element(d, e)
            out.drive_friction[k] = length_per_coordinate(d, k) * d.friction_element.force[e]
            out.drive_sticking[k] = sticks
        else:
            out.sticking[e] = sticks
            # the friction force of a sliding element along t is −s µ F_n, with the mode s = ±1, the
            # coefficient µ of sliding and the true normal force F_n, which is never negative
            sliding = -mode * d.law.friction[e] * d.output.force[e]
            out.force[e] = d.friction_element.force[e] if mode == STICKS else sliding


def fill_quadratures(d, theta):
    """Fill the outputs of impulses and of the energy of dry friction, at the fraction θ of the last step."""
    quadrature = d.quadrature
    for i in range(len(quadrature.integral)):
        fill_quadrature(d, i, quadrature.integral[i])
    for k in range(quadrature.count):
        fill_quadrature(d, quadrature.index[k], quadrature_within(d, theta, k))


def fill_quadrature(d, i, value):
    """Store the ``value`` of quadrature i in its output.

    The last two quadratures, the components of the impulse of the force at the tip, have no output; the
    impulses in the joints are computed from them.
    """
    e = i - d.candidate_count
    if e < 0:
        d.output.impulse[i] = value
    elif e < d.friction_element_count:
        d.output.friction.impulse[e] = value
    elif e == d.friction_element_count:
        d.output.friction.dissipated = value
    else:
        store_tip_impulse(d, e - d.friction_element_count - 1, value)


def combine_forces(d):
    """Convert forces and penetrations of joints' stops to moments [N·m] and angles [rad].

    The results of both stops of a joint stand in the entry of its first stop. A joint can touch only one of
    its two stops at a time; moments at joint_max are negative.
    """
    out = d.output
    for c in range(d.candidate_count):
        arm = lever_of_candidate(d, c)
        if is_at_joint_stop(d, c):
            moment = joint_stop_moment(d, c, out.force[c])
            penetration, rate = out.penetration[c] / arm, out.penetration_rate[c] / arm
            out.force[c], out.penetration[c], out.penetration_rate[c] = 0.0, 0.0, 0.0
            first = first_stop(d, c)
            out.force[first] += moment
            out.penetration[first] += penetration
            out.penetration_rate[first] += rate


def combine_impulses(d):
    """Convert impulses [N·s] of joints' stops to angular impulses [N·m·s].

    The sum over both stops of a joint stands in the entry of its first stop; impulses at joint_max are
    negative.
    """
    out = d.output
    for c in range(d.candidate_count):
        if is_at_joint_stop(d, c):
            impulse = joint_stop_moment(d, c, out.impulse[c])
            out.impulse[c] = 0.0
            out.impulse[first_stop(d, c)] += impulse
