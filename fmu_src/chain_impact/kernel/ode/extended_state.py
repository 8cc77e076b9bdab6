"""The equations of an implicit step: the state is integrated together with the active contacts' clearances.

As the links turn, the clearance that follows from the coordinates of a stage has an error of about ½ h² J̇ẏ,
with the step size h and the gradient J of the clearances. This error is small, but often larger than the
penetration of a stiff wall. So the clearances g of the active contacts with a force law, and their rates, are
integrated together with the state: z = (y without u and t, g, ġ, Q), with the quadratures Q. The rate of ġ is
g̈ (constraints/geometry.py). The contact forces are evaluated at the integrated g and ġ, which do not have
that error.

A rigid wall has no force law and constrains its points as in an explicit step (forces/holding.py), so z has
no entries for these points.

The linear systems of an implicit step are (1 − s A) x = r, for a real and for complex shifts s. A is the
stiff part of the Jacobian ∂ż/∂z. The coordinates of the chain are q and their rates v; x_q, x_v, x_g and x_ġ
are the parts of x that belong to q, v, g and ġ, and r_q to r_ġ those of r. A point resting on a stiff wall
makes the equations stiff: the contact's own motions are far faster than the chain's, and decay. Dampers or
springs of joints or of the slider make the equations stiff, too; their forces are −C v − S q, up to
constants, with the damping c_i and the stiffness k_i of drive i, C = Σ c_i χ_i χ_iᵀ, S = Σ k_i χ_i χ_iᵀ and
χ_i the gradient of the rate of the drive's coordinate (chain/drives.py). All other terms are left out of A;
Newton's iteration takes account of them. For z as above

    ∂v̇/∂(g, ġ, v, q) = −M⁻¹ (Jᵀk, Jᵀc, C, S),   g̈ the same with −J M⁻¹,   ∂(q̇, ġ)/∂(v, ġ) = 1,

k = ∂F/∂δ, c = ∂F/∂δ̇ of the contact force F by the penetration δ, M the mass matrix, J the gradient of the
clearances. The solution needs no linear algebra except the recursion. Let Δ = r_v − x_v. The rows of v̇ in
(1 − s A) x = r, multiplied by M, are M Δ = s (Jᵀ (k x_g + c x_ġ) + C x_v + S x_q), hence

    (M + Jᵀ D J + K) Δ = Jᵀ (D r_ġ + s k r_g) + K r_v + s S r_q,   D = s c + s² k,   K = s C + s² S,
    x_v = r_v − Δ,   x_ġ = r_ġ − J Δ,   x_q = r_q + s x_v,   x_g = r_g + s x_ġ,

Δ is the response of the chain to impulses at the touching points and along the drives. The impedance D of the
contacts adds to the articulated inertia at their points. κ_i = s (c_i + s k_i) acts as a damper of drive i,
and K r_v + s S r_q acts as an impulse on the drives (chain/mass_matrix_solver.py). A constraint is the
condition J Δ = 0 for a point at a rigid wall or a sticking element; its impedance is far larger than the
chain's mass (constraints/impulses.py).

``factorize_shift`` and ``solve_shift`` take a shift s, a scratch ``space`` and an array x: all are real, or
all are complex. ``space`` contains impedances, impulses, the resulting motion and several slots for factors;
``slot`` is the number of the slot that is used.

At the end of a step a projection changes the coordinates and their rates, such that at stiff walls the
clearances that follow from the coordinates almost equal the integrated clearances. Without the projection,
the small difference would act as an impact on a stiff wall. The difference before the projection counts as an
error of the step.
"""

from chain_impact.kernel.chain.drives import apply_drive_force, drive_component, drive_count, drive_slopes
from chain_impact.kernel.chain.inputs import set_inputs
from chain_impact.kernel.chain.kinematics import accelerate_points, locate_points, locate_points_now
from chain_impact.kernel.chain.mass_matrix_solver import SHIFTED, clear_impedance, factorize_matrix
from chain_impact.kernel.constraints.constraint_response import joints_add_terms, solve_in_space
from chain_impact.kernel.constraints.geometry import (
    add_along_row,
    add_impedance,
    add_joint_impedances,
    clear_used_forces,
    clearance_acceleration,
    clearance_and_rate,
    constraint_count,
    constraint_row,
    dot,
    has_sticking,
    normal_row,
    row_of_drive,
)
from chain_impact.kernel.constraints.impulses import any_constraint, set_single_solution_impedances
from chain_impact.kernel.equations import free_rate_from_forces
from chain_impact.kernel.forces.active_contacts import apply_contact, clear_applied_forces, set_forces_of_step
from chain_impact.kernel.forces.force_formula import law_slopes
from chain_impact.kernel.forces.friction import apply_friction
from chain_impact.kernel.forces.holding import add_constraint_forces, power_of_prescribed_motions
from chain_impact.kernel.ode.quadratures import set_quadrature_rates
from chain_impact.kernel.record.state import coordinate_count, sundman_u_at, supplied_at, velocity_at


def clearance_at(d, k):
    """Return the index in the extended state z of the clearance of contact k in z, counted from 0.

    z has no u and t, which are the last two entries of y. So in z the clearances begin at the index that u
    has in y.
    """
    return sundman_u_at(d.link_count) + k


def clearance_count(d):
    """Return the number of contacts whose clearances are in z: the active ones with a force law."""
    return d.contacts.force_law_count


def rate_at(d, k):
    """Return the index in the extended state z of the rate of the clearance of contact k in z, k from 0."""
    return clearance_at(d, clearance_count(d) + k)


def quadrature_at(d, k):
    """Return the index in the extended state z of the integrated quadrature k, counted from 0.

    If impulses are requested, the impulses of the contacts in z come first.
    """
    return clearance_at(d, 2 * clearance_count(d) + k)


def extended_length(d):
    """Return the number of entries of z: those of y except u and t, then g, ġ and the quadratures."""
    return quadrature_at(d, d.quadrature.count)


def extend_start(d):
    """Set the extended state z and its rate ż at the start of the next step, from y, ẏ and quadratures."""
    scratch, implicit, n = d.scratch, d.implicit, d.link_count
    if not scratch.located_at_end:
        locate_points(d, d.step.state_end)
    accelerate_points(d, d.step.state_end, scratch.rate_start)
    for j in range(sundman_u_at(n)):
        implicit.z_start[j], implicit.rate_start[j] = d.step.state_end[j], scratch.rate_start[j]
    for k in range(clearance_count(d)):
        implicit.z_start[clearance_at(d, k)], implicit.z_start[rate_at(d, k)] = clearance_and_rate(
            d, d.contacts.active_index[k]
        )
    for k in range(d.quadrature.count):
        implicit.z_start[quadrature_at(d, k)] = d.quadrature.state_end[k]
        implicit.rate_start[quadrature_at(d, k)] = d.quadrature.rate_end[k]
    clearance_rates(d, implicit.z_start, implicit.rate_start)
    if has_sticking(d):
        # ``set_forces_of_step`` computes the limits of friction at the start. A system that is factorized
        # before the first stage, as in ``size_for_fast_motion``, needs these limits: the impedances of
        # sticking elements depend on them.
        set_forces_of_step(d)


def clearance_rates(d, z, rate):
    """Set ġ and g̈ of contacts with a force law in ``rate``, the rate ż of z; points must be accelerated."""
    for k in range(clearance_count(d)):
        rate[clearance_at(d, k)] = z[rate_at(d, k)]
        rate[rate_at(d, k)] = clearance_acceleration(d, d.contacts.active_index[k])


def extended_rate(d, z, elapsed, rate):
    """Set ``rate`` to ż at the extended state z, a time ``elapsed`` [s] after the start of the step.

    The contact forces are evaluated at the clearances in z, not at those that follow from the coordinates.
    """
    if d.inputs.piece.degree > 0 or d.channel_count > 0 or d.signal_count > 0:
        set_inputs(d, d.step.time_origin + elapsed)
    locate_points_now(d, z)
    clear_applied_forces(d)
    dissipated = 0.0
    for k in range(clearance_count(d)):
        dissipated += apply_contact(d, d.contacts.active_index[k], z[clearance_at(d, k)], z[rate_at(d, k)])
    if d.friction.active_count > 0:
        dissipated += apply_friction(d)
    # ``free_rate_from_forces`` also writes to the indices of u and t in y; z has other components at these
    # indices, whose rates are set below
    free_rate_from_forces(d, z, dissipated, rate)
    if any_constraint(d):
        add_constraint_forces(d, z, rate)
    if d.channel_count > 0:
        rate[supplied_at(d.link_count)] += power_of_prescribed_motions(d, z, rate)
    set_quadrature_rates(d, 1.0, rate[quadrature_at(d, 0) :])
    accelerate_points(d, z, rate)
    clearance_rates(d, z, rate)


def extended_slopes(d, z):
    """Set the slopes of the forces of drives, and of contacts with a force law, at the extended state z.

    The slopes are −∂F/∂ψ and −∂F/∂ψ̇ of drives, ∂F/∂δ and ∂F/∂δ̇ of contacts. The function also stores the
    present link vectors, for the linear systems.
    """
    implicit, link = d.implicit, d.scratch.link_vector
    for i in range(d.link_count):
        implicit.link_vector.x[i], implicit.link_vector.y[i] = link.x[i], link.y[i]
    for i in range(drive_count(d)):
        implicit.drive_damping[i], implicit.drive_stiffness[i] = drive_slopes(d, i)
    for k in range(clearance_count(d)):
        c = d.contacts.active_index[k]
        penetration, rate = max(0.0, -z[clearance_at(d, k)]), -z[rate_at(d, k)]
        implicit.contact_stiffness[k], implicit.contact_damping[k] = law_slopes(d, c, penetration, rate)


def contact_impedance(d, k, s):
    """Return the impedance D = s ∂F/∂δ̇ + s² ∂F/∂δ [kg] of active contact k, which has a force law.

    s [s] is the shift, F the contact's force and δ the penetration.
    """
    return s * (d.implicit.contact_damping[k] + s * d.implicit.contact_stiffness[k])


def drive_impedance(d, i, s):
    """Return the impedance κ = s c + s² k [kg·m² or kg] of drive i for a shift s [s].

    c and k are the slopes −∂F/∂ψ̇ and −∂F/∂ψ of the drive's force F (``drive_slopes``).
    """
    return s * (d.implicit.drive_damping[i] + s * d.implicit.drive_stiffness[i])


def factorize_shift(d, s, space, slot):
    """Factorize M + Jᵀ D J + K of the linear systems for a shift s [s] into ``slot`` of ``space``."""
    clear_impedance(d, space.impedance)
    for k in range(clearance_count(d)):
        add_impedance(constraint_row(d, k), space.impedance, contact_impedance(d, k, s))
    set_single_solution_impedances(d)
    for k in range(clearance_count(d), constraint_count(d)):
        add_impedance(constraint_row(d, k), space.impedance, d.constraints.impedance[k])
    if d.chain.has_springs_or_dampers:
        for i in range(d.link_count):
            space.impedance.joint[i] = drive_impedance(d, i, s)
        if d.slides:
            add_impedance(row_of_drive(d, d.link_count), space.impedance, drive_impedance(d, d.link_count, s))
    add_joint_impedances(d, space.impedance)
    factorize_matrix(
        d, d.implicit.link_vector, space, slot, d.chain.has_springs_or_dampers != 0 or joints_add_terms(d)
    )


def solve_shift(d, s, space, slot, x):
    """Solve (1 − s A) x = r, with a shift s [s], a ``space`` and a ``slot`` that are factorized for s.

    The array x contains r at the call, and the solution afterwards.
    """
    n, implicit, change = d.link_count, d.implicit, space.change
    clear_used_forces(d, space.applied_force)
    if d.chain.has_springs_or_dampers:
        for i in range(drive_count(d)):
            # the impulse of damper and spring of drive i: its part of K r_v + s S r_q, where x contains r
            rate = drive_component(d, x, velocity_at(n), i)
            displacement = drive_component(d, x, 0, i)
            impulse = drive_impedance(d, i, s) * rate + s * implicit.drive_stiffness[i] * displacement
            apply_drive_force(d, space.applied_force, i, impulse)
    for k in range(clearance_count(d)):
        # the impulse of the contact with the impedance D and the stiffness k: D r_ġ + s k r_g, where x
        # contains r
        impulse = (
            contact_impedance(d, k, s) * x[rate_at(d, k)]
            + s * implicit.contact_stiffness[k] * x[clearance_at(d, k)]
        )
        add_along_row(constraint_row(d, k), space.applied_force, impulse)
    solve_in_space(d, implicit.link_vector, space, slot, change)
    if d.slides:
        # ``apply_drive_force`` has put the impulse of the slider's drive on point 0, the base. The impulse is
        # removed here, because in flight no other function clears the applied forces on points.
        space.applied_force.x[0], space.applied_force.y[0] = 0.0, 0.0
    for j in range(coordinate_count(n)):
        x[velocity_at(n) + j] -= change[j]
        x[j] += s * x[velocity_at(n) + j]
    for k in range(clearance_count(d)):
        x[rate_at(d, k)] -= dot(constraint_row(d, k), space.place_change)
        x[clearance_at(d, k)] += s * x[rate_at(d, k)]
    for k in range(min(d.quadrature.count, clearance_count(d))):
        x[quadrature_at(d, k)] -= s * (
            implicit.contact_stiffness[k] * x[clearance_at(d, k)]
            + implicit.contact_damping[k] * x[rate_at(d, k)]
        )


def factorize_real(d, s):
    """Factorize M + Jᵀ D J + K of the linear systems for a real shift s [s], and store s."""
    d.implicit.shift = s
    factorize_shift(d, s, d.scratch, SHIFTED)


def solve_real(d, s, x):
    """Solve (1 − s A) x = r for the real shift s [s] of the last ``factorize_real``.

    The array x contains r at the call, and the solution afterwards.
    """
    solve_shift(d, s, d.scratch, SHIFTED, x)


def factorize_complex(d, s, pair):
    """Factorize M + Jᵀ D J + K (see the head of this module) for a complex shift s [s].

    D and K depend on s. The factors are stored in slot ``pair`` of ``implicit.pairs``.
    """
    factorize_shift(d, s, d.implicit.pairs, pair)


def solve_complex(d, s, pair, x, y, component_count):
    """Solve (1 − s A) (x + iy) = r for the complex shift s [s] that is factorized in slot ``pair``.

    The arrays x and y have ``component_count`` entries each: at the call the real and imaginary parts of r,
    afterwards those of the solution.
    """
    pairs = d.implicit.pairs
    for j in range(component_count):
        pairs.x[j] = complex(x[j], y[j])
    solve_shift(d, s, pairs, pair, pairs.x)
    for j in range(component_count):
        x[j], y[j] = pairs.x[j].real, pairs.x[j].imag


# The largest allowed difference between the clearance that follows from the coordinates at the end of a step
# and the integrated clearance, relative to the larger of the contact's penetration and its expected
# penetration. With a larger limit the dense output of the state could have an error as large as this limit; a
# smaller limit shortens steps in which links turn on a stiff wall.
CLEARANCE_MISMATCH = 0.03


def project_coordinates(d, y, derivative, change):
    """Change coordinates in y to reach given clearances, or velocities to reach given rates of clearances.

    ``implicit.target_clearance`` has the clearances or rates to be reached. ``derivative`` is 0 for
    coordinates and clearances, and 1 for velocities and rates. A contact whose impedance D is far larger than
    the chain's mass almost reaches the given value; a soft contact only comes nearer to it. The points must
    have been located for y, but need not be located again after the coordinates in y have changed. The change
    of the coordinates or velocities is stored in ``change``, shape (N+2,).
    """
    implicit, first = d.implicit, derivative * velocity_at(d.link_count)
    clear_used_forces(d, d.scratch.applied_force)
    for k in range(clearance_count(d)):
        c = d.contacts.active_index[k]
        clearance, clearance_rate = clearance_and_rate(d, c)
        impulse = contact_impedance(d, k, implicit.shift) * (
            implicit.target_clearance[k] - (clearance_rate if derivative else clearance)
        )
        add_along_row(normal_row(d, c), d.scratch.applied_force, impulse)
    solve_in_space(d, implicit.link_vector, d.scratch, SHIFTED, change)
    for j in range(coordinate_count(d.link_count)):
        y[first + j] += change[j]


def project_clearances(d, z, y):
    """Move the state y, whose points are located, toward the clearances and their rates in z.

    A stiff contact almost reaches these values, a soft contact only comes nearer to them.

    Returns:
        Two numbers. The first is the largest change of a component of y, divided by the component's scale and
        by the tolerance. The second is the largest difference, before the move, between a clearance that
        follows from y and the same clearance in z, divided by the difference that CLEARANCE_MISMATCH allows.
    """
    implicit, change, error = d.implicit, d.scratch.change, 0.0
    mismatch = largest_mismatch(d, z) / CLEARANCE_MISMATCH
    for derivative in range(2):
        for k in range(clearance_count(d)):
            implicit.target_clearance[k] = z[rate_at(d, k) if derivative else clearance_at(d, k)]
        project_coordinates(d, y, derivative, change)
        for j in range(coordinate_count(d.link_count)):
            error = max(
                error, abs(change[j]) * implicit.error_weight[derivative * velocity_at(d.link_count) + j]
            )
    return error, mismatch


def largest_mismatch(d, z):
    """Return the largest difference between a clearance at the located points and the same clearance in z.

    Each difference is divided by the contact's penetration at the located points, or by its expected
    penetration δ* if this is larger.
    """
    mismatch = 0.0
    for k in range(clearance_count(d)):
        c = d.contacts.active_index[k]
        clearance, _ = clearance_and_rate(d, c)
        penetration = max(d.contacts.expected_penetration[c], -clearance)
        mismatch = max(mismatch, abs(z[clearance_at(d, k)] - clearance) / penetration)
    return mismatch
