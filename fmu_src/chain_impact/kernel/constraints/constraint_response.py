"""The response of the chain to impulses along constraints, by the solver of chain/mass_matrix_solver.py.

J contains the rows of the constraints: normals of active contacts, tangents of sticking elements. D =
diag(D_k) contains an impedance [kg] for each constraint: a mass that resists motion along the row. K = s C +
s² S is the impedance of the drives for a time s, with their damping matrix C and stiffness matrix S. With the
mass matrix M, which contains the armatures, the module solves in O(N) the equation

    (M + Jᵀ D J + K) Δ = Jᵀ p + q,

for the response Δ, changes of the coordinates' rates; p are impulses along the constraints, q impulses in the
joints. The impedances are added to the articulated inertia at their points, and a joint with the impedance
κ_i, or with a stop that has an impedance, is one more term of the elimination. No matrix is formed.
"""

from chain_impact.kernel.chain.kinematics import move_points
from chain_impact.kernel.chain.mass_matrix_solver import (
    FREE,
    clear_impedance,
    factorize_matrix,
    solve_response,
)
from chain_impact.kernel.chain.sites import move_site_forces
from chain_impact.kernel.constraints.geometry import (
    add_along_row,
    add_forces_at_joint_places,
    add_impedance,
    add_joint_impedances,
    clear_used_forces,
    constraint_count,
    constraint_row,
    dot,
    is_at_joint_stop,
    normal_row,
)
from chain_impact.kernel.record.state import coordinate_count, omega_at, velocity_at

# A mobility (1/effective mass) of a point below LEAST_MOBILITY, relative to 1/(mass of chain, carriage and
# armatures), is raised to this value. In a toggle position of a pinned chain the mobility of a point is 0,
# and its effective mass would be infinite. A mass a million times the chain's has almost the effect of an
# infinite mass.
LEAST_MOBILITY = 1e-6
# The number of iterations (impulses.py) for sticking elements if no rigid wall holds a point. This number
# is fixed, except that the iteration ends when the residual is round-off: if the number depended on the
# residual, the forces would jump from one state to the next.
STICKING_ITERATIONS = 5
# The impedance D of a constraint, relative to the mean mass of a link. An iteration in impulses.py divides
# the residual by 1 + D W, with the mobility W: at rigid walls, two or three iterations usually suffice. A
# larger D would lose digits of the chain's inertia, a smaller D needs more iterations.
RELATIVE_IMPEDANCE = 1e6


def mean_mass(d):
    """Return the mean mass of a link [kg]: the mass of chain, carriage and armatures, divided by N.

    An armature counts as its inertia divided by the square of the longest link.
    """
    return d.chain.energy_scale / (d.chain.longest_link * d.chain.longest_link * d.link_count)


def holding_impedance(d):
    """Return an impedance D [kg] that reduces the motion of a link of mean mass to about a millionth.

    The result is RELATIVE_IMPEDANCE times the mean mass.
    """
    return RELATIVE_IMPEDANCE * mean_mass(d)


def held_mobility(d, mobility):
    """Return the mobility W′ [1/kg] of a single sticking constraint of the ``mobility`` W [1/kg].

    W′ is defined by the impulse m/W′ that the iteration gives this constraint for a residual m.
    STICKING_ITERATIONS = n iterations with the impedance D reduce m to m/(1 + D W)ⁿ, so that
    W′ = W/(1 − (1 + D W)⁻ⁿ). If D W is large, W′ equals W up to round-off. D W is small for a motion that
    can hardly be constrained: in a toggle position, where W = 0, W′ is 1/(n D).
    """
    inverse_impedance = 1.0 / holding_impedance(d)
    fraction = inverse_impedance / (inverse_impedance + max(0.0, mobility))
    total = 1.0
    for _ in range(STICKING_ITERATIONS - 1):
        total = 1.0 + fraction * total
    return (inverse_impedance + max(0.0, mobility)) / total


def factorize_contacts(d, slot, impedance):
    """Factorize M + Jᵀ D J, with the mass matrix M, into a ``slot`` of ``scratch.factors``.

    ``impedance`` contains the impedance D_k [kg] of each constraint k.
    """
    clear_impedance(d, d.scratch.impedance)
    for k in range(constraint_count(d)):
        add_impedance(constraint_row(d, k), d.scratch.impedance, impedance[k])
    add_joint_impedances(d, d.scratch.impedance)
    factorize_matrix(d, d.scratch.link_vector, d.scratch, slot, joints_add_terms(d))


def joints_add_terms(d):
    """Return whether any joint adds a term to M + Jᵀ D J: an armature, an active stop or sticking friction.

    The sticking friction of a slider counts, too.
    """
    return d.chain.has_armatures != 0 or d.contacts.joint_stop_count + d.friction.stuck_joints > 0


def solve_in_space(d, link_vectors, space, slot, change):
    """Compute the response Δ to the impulses in ``space.applied_force`` at the places and in the joints.

    The function changes ``space.applied_force``: it adds impulses at joints' places to those in joints, and
    impulses at sites to those at points and on links.

    Args:
        d: the instance.
        link_vectors: record with ``x, y``, shape (N+1,): the vectors L_i [m] (entry N is not used).
        space: record of the factors and impulses. The function stores the motion of the places in
            ``space.place_change``.
        slot: the slot of the factors.
        change: result Δ, changes of the coordinates' rates, shape (N+2,) [m/s, rad/s].
    """
    add_forces_at_joint_places(d, space.applied_force)
    move_site_forces(d, link_vectors, space.applied_force)
    solve_response(d, link_vectors, space, slot, change)
    move_points(d, link_vectors, change, space.place_change)


def solve_contacts(d, slot, impulse, change):
    """Compute the response Δ to the impulses p_k [N·s] in ``impulse``, one for each constraint k.

    ``slot`` is the index of the factors in ``scratch.factors`` (chain/mass_matrix_solver.py). The function
    stores Δ in ``change``, and the motion of the places in ``scratch.place_change``.
    """
    clear_used_forces(d, d.scratch.applied_force)
    for k in range(constraint_count(d)):
        add_along_row(constraint_row(d, k), d.scratch.applied_force, impulse[k])
    solve_in_space(d, d.scratch.link_vector, d.scratch, slot, change)


def solve_accelerations_with_armatures(d, y, rate):
    """Set the accelerations in ``rate``, ẏ at the state y, of a chain with armatures.

    The mass matrix M also contains the inertia of the rotors. The force m (g − a_C) of each link is divided
    between its two ends according to the position of its centre of mass; a_C is the acceleration that the
    centre of mass has at constant angular velocities. The applied forces at the points have their old values
    afterwards, those in joints and, with ``skewed``, on links have not; the factors of M stay in slot FREE of
    ``scratch.factors``.
    """
    scratch, n = d.scratch, d.link_count
    applied_force, link, motion = scratch.applied_force, scratch.link_vector, scratch.place_change
    for k in range(n + 1):
        motion.x[k], motion.y[k] = applied_force.x[k], applied_force.y[k]
    ax, ay, moment = 0.0, 0.0, 0.0
    if d.channel_count > 0 and d.chain.base_moves:
        ax, ay = d.channel.acceleration[0], d.channel.acceleration[1]
    for i in range(n):
        ratio, omega = d.chain.center_of_mass_ratio[i], y[omega_at(n) + i]
        w2x, w2y = omega * omega * link.x[i], omega * omega * link.y[i]
        # acceleration of the centre of mass at constant angular velocity ω, at r_C from the joint with
        # acceleration a: a_C = a − ω² r_C
        cx, cy = ax - ratio * w2x, ay - ratio * w2y
        if d.skewed:
            cx, cy = cx + d.chain.offset_ratio[i] * w2y, cy - d.chain.offset_ratio[i] * w2x
        fx = d.chain.mass[i] * (d.chain.gravity[0] - cx)
        fy = d.chain.mass[i] * (d.chain.gravity[1] - cy)
        if d.skewed:
            # The centre of mass is at the distance o to the left of the link's line. The force F there adds
            # the moment (o/ℓ) L⊥ × F, with the link vector L of length ℓ, and L⊥, which is L turned to the
            # left by 90°.
            applied_force.link[i] -= d.chain.offset_ratio[i] * (link.x[i] * fx + link.y[i] * fy)
        applied_force.x[i] += (1.0 - ratio) * fx
        applied_force.y[i] += (1.0 - ratio) * fy
        applied_force.x[i + 1] += ratio * fx
        applied_force.y[i + 1] += ratio * fy
        ax, ay = ax - w2x, ay - w2y
    for i in range(n - 1, -1, -1):
        moment += scratch.moment[i]
        applied_force.joint[i] = moment
    if d.slides:
        slider, gravity = d.slider, d.chain.gravity
        applied_force.x[0] += scratch.thrust * slider.ux + slider.mass * gravity[0]
        applied_force.y[0] += scratch.thrust * slider.uy + slider.mass * gravity[1]
    clear_impedance(d, scratch.impedance)
    add_joint_impedances(d, scratch.impedance)
    factorize_matrix(d, link, scratch, FREE, True)
    solve_response(d, link, scratch, FREE, scratch.change)
    for j in range(coordinate_count(n)):
        rate[velocity_at(n) + j] = scratch.change[j]
    for k in range(n + 1):
        applied_force.x[k], applied_force.y[k] = motion.x[k], motion.y[k]


def effective_mass(d, c):
    """Return the effective mass 1/(J M⁻¹ Jᵀ) [kg] of candidate c along its normal, for the located points.

    The result is at most the mass of chain, carriage and armatures, in which armatures count as in
    ``mean_mass``, divided by LEAST_MOBILITY. The applied forces, the impedances and the slot FREE of the
    factors in ``scratch`` are overwritten.
    """
    scratch, row = d.scratch, normal_row(d, c)
    clear_impedance(d, scratch.impedance)
    add_joint_impedances(d, scratch.impedance)
    factorize_matrix(
        d, scratch.link_vector, scratch, FREE, d.chain.has_armatures != 0 or is_at_joint_stop(d, c)
    )
    clear_used_forces(d, scratch.applied_force)
    add_along_row(row, scratch.applied_force, 1.0)
    solve_in_space(d, scratch.link_vector, scratch, FREE, scratch.change)
    # in a toggle position no impulse moves the point, so its mobility is 0; the least mobility keeps the
    # result finite
    mobility = LEAST_MOBILITY * d.chain.longest_link * d.chain.longest_link / d.chain.energy_scale
    return 1.0 / max(mobility, dot(row, scratch.place_change))
