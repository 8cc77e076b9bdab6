"""The equations of motion ẏ = f(y), which combine all parts of the model, and the energy balance.

record/state.py describes y. Six functions compute ẏ, the rate. Each function needs y and the data that
the list says; earlier calls must have set these data. A "free" rate lacks the forces of constraints. In a
"true" rate every contact force is cut off at 0; in other rates the force may continue below 0, beyond its
kink.

    rate_from_state             y alone; locates the points only if forces act on them
    rate_and_points_from_state  y alone; locates the points
    rate_from_points            the located points
    true_rate_from_inputs       the located points and the inputs
    free_rate_from_inputs       the located points and the inputs
    free_rate_from_forces       the link vectors, the inputs and the applied forces
"""

from chain_impact.kernel.chain.drives import (
    armature_energy,
    first_joint,
    force_and_powers_of_drive,
    mode_margin,
    passive_spring_tension,
    spring_energy,
)
from chain_impact.kernel.chain.elimination import solve_accelerations
from chain_impact.kernel.chain.inputs import ensure_inputs
from chain_impact.kernel.chain.kinematics import locate_points, set_link_vectors
from chain_impact.kernel.chain.sites import joint_place, move_site_forces
from chain_impact.kernel.chain.slider import carriage_energy
from chain_impact.kernel.constraints.constraint_response import solve_accelerations_with_armatures
from chain_impact.kernel.constraints.geometry import clearance_and_rate
from chain_impact.kernel.constraints.impulses import any_constraint, clear_outcome
from chain_impact.kernel.forces.active_contacts import set_forces_of_step, set_true_forces
from chain_impact.kernel.forces.force_formula import clear_crossings, elastic_energy
from chain_impact.kernel.forces.friction import add_power_of_sticking, clear_friction_margins
from chain_impact.kernel.forces.holding import (
    add_constraint_forces,
    clear_least_forces,
    power_of_prescribed_motions,
)
from chain_impact.kernel.function_marks import inlined
from chain_impact.kernel.record.state import (
    coordinate_count,
    dissipated_at,
    omega_at,
    sundman_u_at,
    supplied_at,
    time_at,
    velocity_at,
)


def energy_balance(d, y):
    """Return the energy balance [J], constant in the exact motion, for the located points.

    The balance is the kinetic, potential and elastic energy, plus the dissipated energy, minus the supplied
    energy.
    """
    kinetic, potential = mechanical_energy(d, y)
    return kinetic + potential + other_energy(d, y)


def other_energy(d, y):
    """Return the energy balance [J] without kinetic and potential energy, for the located points."""
    return stored_energy(d, y) + y[dissipated_at(d.link_count)] - y[supplied_at(d.link_count)]


def stored_energy(d, y):
    """Return the elastic energy [J] of active contacts and of the springs of passive drives.

    The points must be located.
    """
    energy = spring_energy(d, y) if d.chain.has_springs else 0.0
    for k in range(d.contacts.force_law_count):
        c = d.contacts.active_index[k]
        clearance, _ = clearance_and_rate(d, c)
        if clearance < 0.0:
            energy += elastic_energy(d, c, -clearance)
    return energy


def mechanical_energy(d, y):
    """Return the kinetic and the potential energy [J] of the links, armatures and carriage.

    The points must be located for y.
    """
    n = d.link_count
    kinetic, potential = 0.0, 0.0
    for i in range(n):
        m, ratio, omega = d.chain.mass[i], d.chain.center_of_mass_ratio[i], y[omega_at(n) + i]
        # r_C = (cx, cy) leads from the proximal joint to the centre of mass: p_C = p_i + r_C,
        # v_C = v_i + ω r_C⊥. The next line sets the part of r_C along the link's line; if the centre may lie
        # beside this line, the other part is added below
        cx, cy = ratio * d.scratch.link_vector.x[i], ratio * d.scratch.link_vector.y[i]
        if d.skewed:
            beside = d.chain.offset_ratio[i]
            cx, cy = cx - beside * d.scratch.link_vector.y[i], cy + beside * d.scratch.link_vector.x[i]
        vx = d.scratch.velocity.x[i] - omega * cy
        vy = d.scratch.velocity.y[i] + omega * cx
        kinetic += 0.5 * m * (vx * vx + vy * vy) + 0.5 * d.chain.inertia[i] * omega * omega
        x = d.scratch.position.x[i] + cx
        y_ = d.scratch.position.y[i] + cy
        potential -= m * (d.chain.gravity[0] * x + d.chain.gravity[1] * y_)
    if d.slides:
        carriage_kinetic, carriage_potential = carriage_energy(d, y)
        kinetic, potential = kinetic + carriage_kinetic, potential + carriage_potential
    return kinetic + armature_energy(d, y) if d.chain.has_armatures else kinetic, potential


@inlined
def rate_from_state(d, y, rate):
    """Set ``rate`` to ẏ = f(y).

    The points are located only if a contact is active, an element has dry friction at present, or the scene
    has inputs other than motions of walls.
    """
    # in free flight no force acts at a point, so points and walls are not located
    if d.contacts.active_count > 0 or d.chain.has_inputs or d.friction.active_count > 0:
        rate_and_points_from_state(d, y, rate)
    else:
        set_link_vectors(d, y)
        free_rate_from_forces(d, y, 0.0, rate)


def rate_and_points_from_state(d, y, rate):
    """Locate the points for the state y, and set ``rate`` to ẏ = f(y), with the inputs at the time in y."""
    locate_points(d, y)
    rate_from_points(d, y, rate)


@inlined
def rate_from_points(d, y, rate):
    """Set the inputs to their values at the time of y, and rate = f(y); the points must be located."""
    ensure_inputs(d, y)
    free_rate_from_inputs(d, y, rate)
    add_constraints(d, y, rate)


def true_rate_from_inputs(d, y, rate):
    """Set rate = f(y) with contact forces that are cut off at 0.

    The forces in the stages of a step, by contrast, may continue below 0, beyond their kinks. The inputs must
    be set and the points located. Callers use only the accelerations in ``rate``, because the dissipated
    power in ``rate`` lacks the parts of contacts and of sliding friction.
    """
    set_true_forces(d)
    free_rate_from_forces(d, y, 0.0, rate)
    add_constraints(d, y, rate)


def add_constraints(d, y, rate):
    """Add the effects of constraints and of prescribed motions to ẏ, the rate without constraints.

    Constraints add accelerations and the power that they dissipate; moving base, walls and belts add the
    power that they supply.
    """
    if any_constraint(d):
        add_constraint_forces(d, y, rate)
        rate[dissipated_at(d.link_count)] += add_power_of_sticking(d)
    if d.channel_count > 0:
        rate[supplied_at(d.link_count)] += power_of_prescribed_motions(d, y, rate)


def free_rate_from_inputs(d, y, rate):
    """Set rate = f(y) for the located points and the present inputs, without the forces of constraints."""
    free_rate_from_forces(d, y, set_forces_of_step(d), rate)


def free_rate_from_forces(d, y, dissipated, rate):
    """Set rate = f(y) with the stored applied forces and the present inputs, but without constraints.

    ``dissipated`` is the power [W] that contacts and sliding friction dissipate.
    """
    n = d.link_count
    supplied = 0.0
    if d.chain.has_springs_or_dampers or d.chain.has_inputs or d.chain.has_joint_places:
        drive_dissipated, supplied = set_joint_moments(d, y)
        dissipated += drive_dissipated
    if d.slides:
        force, drive_dissipated, drive_supplied = force_and_powers_of_drive(d, y, n)
        d.scratch.thrust = force - passive_spring_tension(d, y, n)
        dissipated, supplied = dissipated + drive_dissipated, supplied + drive_supplied

    for j in range(coordinate_count(n)):
        rate[j] = y[velocity_at(n) + j]
    move_site_forces(d, d.scratch.link_vector, d.scratch.applied_force)
    if d.chain.has_armatures:
        solve_accelerations_with_armatures(d, y, rate)
    else:
        solve_accelerations(d, y, rate)
    rate[dissipated_at(n)] = dissipated
    rate[supplied_at(n)] = supplied
    rate[sundman_u_at(n)] = 0.0
    rate[time_at(n)] = 1.0


def clear_stage_notes(d):
    """Clear the records that the stages of a step add to, before a step.

    These are: unsolved constraints, crossed kinks, least forces of rigid walls, and margins of modes.
    """
    clear_outcome(d)
    clear_crossings(d)
    clear_least_forces(d)
    clear_friction_margins(d)
    d.drive.mode_margin = 0.0


def set_joint_moments(d, y):
    """Set the sum of the moments of joints on each link; return the dissipated and the supplied power [W].

    Passive drives dissipate power. Drives and the force at the tip supply power. The drive of the proximal
    joint of link i exerts the torque +τ_i on link i and −τ_i on link i − 1; a free base has no such torque.
    """
    dissipated, supplied = 0.0, 0.0
    # without inputs no force acts at the tip; the tip's velocity is not read, as in flight it is not computed
    if d.chain.has_inputs:
        force, velocity, tip = d.inputs.tip_force, d.scratch.velocity, d.link_count
        supplied = force[0] * velocity.x[tip] + force[1] * velocity.y[tip]
    for i in range(d.link_count):
        torque = 0.0
        if i >= first_joint(d):
            torque, drive_dissipated, drive_supplied = force_and_powers_of_drive(d, y, i)
            dissipated, supplied = dissipated + drive_dissipated, supplied + drive_supplied
        d.scratch.moment[i] = torque
        if i > 0:
            d.scratch.moment[i - 1] -= torque
    if d.chain.has_drive_limits:
        d.drive.mode_margin = min(d.drive.mode_margin, mode_margin(d, y))
    if d.chain.has_springs:
        add_spring_moments(d, y)
    if d.chain.has_joint_places:
        add_place_moments(d)
    return dissipated, supplied


def add_place_moments(d):
    """Add the moments of stops and dry friction in joints to the links, from the forces at joints' places."""
    for i in range(d.link_count):
        add_joint_moment(d, i, d.chain.longest_link * d.scratch.applied_force.x[joint_place(d, i)])


def add_spring_moments(d, y):
    """Add the moments of the springs of passive drives in joints to the links that the joints connect."""
    for i in range(d.link_count):
        add_joint_moment(d, i, -passive_spring_tension(d, y, i))


def add_joint_moment(d, i, torque):
    """Add a torque [N·m] in the proximal joint of link i: + on link i and, if i > 0, − on link i − 1."""
    d.scratch.moment[i] += torque
    if i > 0:
        d.scratch.moment[i - 1] -= torque
