"""The rates [1/s] of the fast motions that dampers and springs of drives (drives.py) cause.

C = Σ c_i χ_i χ_iᵀ is the damping matrix, with the damping c_i of drive i and the gradient χ_i of the rate of
its coordinate, which is ω_i − ω_{i−1} at a joint. With the mass matrix M, damped motions decay with the
eigenvalues of M⁻¹ C. The damper of drive i alone, without all other dampers, causes a motion that decays with
the rate

    ρ_i = c_i χ_iᵀ M⁻¹ χ_i.

The largest eigenvalue is at least the largest ρ_i, and at most the sum of all ρ_i. In the same way the
stiffness matrix S = Σ k_i χ_i χ_iᵀ determines the squares of the angular frequencies of springs, and the
spring of drive i alone has

    ω_i² = k_i χ_iᵀ M⁻¹ χ_i.

With I the inertias of the links, M ≥ diag(I), so no eigenvalue exceeds the largest eigenvalue of diag(I)⁻¹ C.
This does not exceed the largest row sum (Gershgorin): 2 (c_i + c_{i+1})/I_i, and for springs
2 (k_i + k_{i+1})/I_i. A carriage adds its mass m to diag(I) and only its own drive to the sums: c/m and k/m.
With damper and spring, a rate λ solves λ² + λ c + k = 0, where c and k are at most these bounds, hence
|λ| ≤ c + √k. This bound does not depend on the angles. A damper or spring at a link without inertia, or at a
carriage without mass, makes the bound infinite.
"""

import math

from chain_impact.kernel.chain.drives import (
    apply_drive_force,
    armature_of_drive,
    drive_component,
    drive_count,
    drive_slopes,
    slopes_below_limit,
)
from chain_impact.kernel.chain.kinematics import clear_joints, clear_vectors, set_link_vectors
from chain_impact.kernel.chain.mass_matrix_solver import (
    FREE,
    clear_impedance,
    factorize_matrix,
    solve_response,
)
from chain_impact.kernel.chain.sites import clear_link_moments


def joint_rate_bound(d):
    """Return an upper bound [1/s] on the rates of all motions that springs and dampers cause; it may be ∞."""
    damping, stiffness = 0.0, 0.0
    for i in range(d.link_count):
        c, k = slopes_below_limit(d, i)
        if i + 1 < d.link_count:
            outer = slopes_below_limit(d, i + 1)
            c, k = c + outer[0], k + outer[1]
        damping = max(damping, divide_by_inertia(2.0 * c, d.chain.inertia[i]))
        stiffness = max(stiffness, divide_by_inertia(2.0 * k, d.chain.inertia[i]))
    if d.slides:
        c, k = slopes_below_limit(d, d.link_count)
        damping = max(damping, divide_by_inertia(c, d.slider.mass))
        stiffness = max(stiffness, divide_by_inertia(k, d.slider.mass))
    return damping + math.sqrt(stiffness)


def divide_by_inertia(number, inertia):
    """Return ``number``/``inertia`` of two numbers ≥ 0; here 0/0 is 0, and a number > 0 divided by 0 is ∞."""
    if inertia > 0.0:
        return number / inertia
    return math.inf if number > 0.0 else 0.0


def largest_joint_rate(d, y):
    """Return the largest rate [1/s] that one damper (ρ_i) or one spring (ω_i) causes in state y.

    ρ_i = c_i χ_iᵀ M⁻¹ χ_i and ω_i² = k_i χ_iᵀ M⁻¹ χ_i are defined at the head of this module; a drive at its
    limit does not count. Afterwards the link vectors are those of y, and the applied forces, the impedances
    and the slot FREE of the factors in ``scratch`` are overwritten.
    """
    set_link_vectors(d, y)
    scratch, fastest = d.scratch, 0.0
    clear_impedance(d, scratch.impedance)
    for i in range(d.link_count):
        scratch.impedance.joint[i] = armature_of_drive(d, i)
    factorize_matrix(d, scratch.link_vector, scratch, FREE, True)
    clear_vectors(d, scratch.applied_force)
    clear_joints(scratch.applied_force)
    clear_link_moments(d, scratch.applied_force)
    for i in range(drive_count(d)):
        c, k = drive_slopes(d, i)
        if c > 0.0 or k > 0.0:
            apply_drive_force(d, scratch.applied_force, i, 1.0)
            solve_response(d, scratch.link_vector, scratch, FREE, scratch.change)
            apply_drive_force(d, scratch.applied_force, i, 0.0)
            # χ_iᵀ M⁻¹ χ_i, the change of the rate of the drive's coordinate by a unit impulse along it
            mobility = drive_component(d, scratch.change, 0, i)
            fastest = max(fastest, c * mobility, math.sqrt(k * mobility))
    return fastest
