"""Constraint forces within the limits of friction: a convex problem, which always has a solution.

Where constraints depend on each other, their forces are not unique. The forces that impulses.py finds,
with the least Σ p²/D, may exceed a limit of friction although other forces satisfy the same constraints
within all limits. With W the inverse of the mass matrix along the constraints, the forces p within the limits
that satisfy the constraints as well as possible are the solution of

    ½ pᵀ W p − pᵀ (target − start) = min,    lower limit ≤ p ≤ upper limit,

with the limits ∓ µ F_n for a sticking element, and 0 and ∞ for a point at a rigid wall. This is the dual form
of Gauss' principle of least constraint with Coulomb's law for given normal forces (Moreau 1966, SIAM J
Control 4:153): an element whose force is below its limit is held, and a moving element has a force at its
limit, against the motion.

The method of multipliers finds the solution also where W is singular (Rockafellar 1976, SIAM J Control Optim
14:877). With the impedances D, from p = 0, each iteration solves

    p⁺ = clip(p + D m⁺),    m⁺ = target − u(p⁺),

which has a unique solution, because W + D⁻¹ is positive definite. If no limit is reached, this is the
iteration in impulses.py. Let I be the constraints whose forces are inside their limits; all other forces
are at their limits. The forces of I follow from the recursion:

    (M + J_Iᵀ D J_I) z = J_Iᵀ D m + Σ_{others} Jᵀ (limit − p),    p⁺ = p + D (m − J z).

The set I is found by changes of one constraint at a time, as in bounded least squares (Stark & Parker 1995,
Comput Stat 10:129).
"""

import math

from chain_impact.kernel.chain.mass_matrix_solver import FREE, HELD
from chain_impact.kernel.constraints.complementarity import EXTRA_PIVOTS
from chain_impact.kernel.constraints.constraint_response import (
    STICKING_ITERATIONS,
    factorize_contacts,
    holding_impedance,
    solve_contacts,
)
from chain_impact.kernel.constraints.geometry import constraint_count, constraint_row, dot
from chain_impact.kernel.constraints.impulses import SIGN_TOLERANCE, SOLVED_RESIDUAL, set_impedance
from chain_impact.kernel.cost import count_other_cost, is_cost_exceeded

# Where W is nearly singular, the residual falls slowly, and a force after few iterations may be at a limit
# though the exact force is not. Iterations end when all residuals of the constraints inside their limits are
# at most SOLVED_WITHIN times the largest acceleration without constraint forces, but not before
# STICKING_ITERATIONS iterations; MOST_LIMITED_ITERATIONS bounds their number.
SOLVED_WITHIN, MOST_LIMITED_ITERATIONS = 1e-9, 100


def find_limited_forces(d):
    """Find forces within the limits of friction that satisfy the constraints as well as possible.

    ``add_constraint_forces`` of forces/holding.py must have set the constraints before. Afterwards
    ``d.limited_forces`` has the forces in ``force`` and the accelerations that they cause in ``change``;
    ``at_limit`` of a sticking element is 0 if its force is below its limit, else ±1 (``sign_at_limit``).
    """
    limited, scale = d.limited_forces, largest_unforced_acceleration(d)
    set_impedance(d, holding_impedance(d))
    for k in range(constraint_count(d)):
        limited.force_before[k], limited.force[k], limited.inside_limits[k] = 0.0, 0.0, 1
        limited.residual[k] = d.constraints.target_motion[k] - d.constraints.unforced_motion[k]
    for iteration in range(MOST_LIMITED_ITERATIONS):
        minimize_within_limits(d, scale)
        update_residuals(d)
        is_solved = (
            iteration + 1 >= STICKING_ITERATIONS and largest_residual_inside(d) <= SOLVED_WITHIN * scale
        )
        if is_solved or is_cost_exceeded(d):
            break
    for i in range(d.friction.stuck_count):
        limited.at_limit[i] = sign_at_limit(d, d.contacts.active_count + i)


def largest_residual_inside(d):
    """Return the largest |residual| [m/s²] of the constraints whose forces are inside their limits."""
    limited, largest = d.limited_forces, 0.0
    for k in range(d.contacts.force_law_count, constraint_count(d)):
        if limited.inside_limits[k]:
            largest = max(largest, abs(limited.residual[k]))
    return largest


def largest_unforced_acceleration(d):
    """Return the largest |acceleration| [m/s²] in ``unforced_motion``, to which round-off is relative.

    The accelerations are those of points at rigid walls and of sticking elements, without constraint forces.
    Contacts with a force law do not count.
    """
    scale = 0.0
    for k in range(d.contacts.force_law_count, constraint_count(d)):
        scale = max(scale, abs(d.constraints.unforced_motion[k]))
    return scale


def sign_at_limit(d, k):
    """Return the sign of the force of sticking constraint k if the force is at its limit, else 0.

    If the limit is 0, the result is the sign of the residual (target minus acceleration), or −1 for a
    residual of 0.
    """
    limited, limit = d.limited_forces, upper_limit(d, k)
    if limit == 0.0:
        return 1 if limited.residual[k] > 0.0 else -1
    return 1 if limited.force[k] >= limit else (-1 if limited.force[k] <= -limit else 0)


def lower_limit(d, k):
    """Return the lower limit [N] of the force of constraint k.

    The lower limit is 0 for a point at a rigid wall, and minus the upper limit for a sticking element.
    """
    return 0.0 if k < d.contacts.active_count else -upper_limit(d, k)


def upper_limit(d, k):
    """Return the upper limit [N] of the force of constraint k.

    For a sticking contact the limit is µ F_n, with the normal force F_n and the coefficient µ of sliding
    friction, because a contact at its limit slides. For a sticking joint or slider the limit is its largest
    friction. For a point at a rigid wall the limit is infinite.
    """
    first = d.contacts.active_count
    if k < first:
        return math.inf
    e = d.friction_element.stuck_index[k - first]
    ratio = d.law.friction[e] / d.law.static_friction[e] if e < d.candidate_count else 1.0
    return max(0.0, ratio * d.friction_element.friction_limit[e])


def clip_force(d, k, force):
    """Return the force [N] nearest to ``force`` within the limits of constraint k."""
    return min(upper_limit(d, k), max(lower_limit(d, k), force))


def minimize_within_limits(d, scale):
    """Solve one iteration of the method of multipliers, with all forces within their limits.

    An iteration minimizes a function of the forces. The forces inside their limits move toward the values
    that minimize this function while the other forces are fixed. The first force that reaches a limit stays
    at this limit. When the minimizing values are reached, the constraint whose force tends most from its
    limit to the inside is released. Each change reduces the function, so no set of constraints inside their
    limits occurs twice, and the search ends.
    """
    limited, end = d.limited_forces, constraint_count(d)
    for _ in range(EXTRA_PIVOTS + 4 * end):
        solve_inside(d)
        constraint, part = first_at_limit(d)
        for k in range(d.contacts.force_law_count, end):
            if limited.inside_limits[k]:
                limited.force[k] += part * (limited.unlimited_force[k] - limited.force[k])
        if constraint >= 0:
            limited.inside_limits[constraint] = 0
            limited.force[constraint] = clip_force(d, constraint, limited.unlimited_force[constraint])
        else:
            constraint = constraint_to_release(d, scale)
            if constraint < 0 or is_cost_exceeded(d):
                return
            limited.inside_limits[constraint] = 1


def first_at_limit(d):
    """Return whose force is first at a limit as the forces move to those in ``unlimited_force``.

    Returns:
        The constraint, or −1 if no force reaches a limit; and the fraction of the way at which its force
        reaches the limit, or 1.
    """
    limited, first, part = d.limited_forces, -1, 1.0
    for k in range(d.contacts.force_law_count, constraint_count(d)):
        limit = clip_force(d, k, limited.unlimited_force[k])
        if limited.inside_limits[k] and limit != limited.unlimited_force[k]:
            reached = (limit - limited.force[k]) / (limited.unlimited_force[k] - limited.force[k])
            if reached < part or first < 0:
                first, part = k, reached
    return first, part


def constraint_to_release(d, scale):
    """Return the constraint to release: at a limit, with the clipped ``unlimited_force`` farthest from it.

    The result is −1 if no clipped ``unlimited_force`` is farther from the limit than round-off.
    """
    limited, released, largest_force, largest_distance = d.limited_forces, -1, 0.0, 0.0
    for k in range(d.contacts.force_law_count, constraint_count(d)):
        largest_force = max(largest_force, abs(limited.force[k]))
    for k in range(d.contacts.force_law_count, constraint_count(d)):
        inward = abs(clip_force(d, k, limited.unlimited_force[k]) - limited.force[k])
        round_off = SIGN_TOLERANCE * largest_force + SOLVED_RESIDUAL * scale * d.constraints.impedance[k]
        if not limited.inside_limits[k] and inward > max(round_off, largest_distance):
            released, largest_distance = k, inward
    return released


def solve_inside(d):
    """Store in ``unlimited_force`` the forces p + D m⁺ of rigid walls and sticking; they may exceed limits.

    p are the forces before the iteration, D the impedances. m⁺ are the residuals if each constraint inside
    its limits has the force in ``unlimited_force``, and all other constraints stay at their limits.
    """
    limited, motion = d.limited_forces, d.scratch.place_change
    for k in range(constraint_count(d)):
        has_force_law = k < d.contacts.force_law_count
        limited.impedance[k] = (
            0.0 if has_force_law or not limited.inside_limits[k] else d.constraints.impedance[k]
        )
        limited.correction[k] = limited.impedance[k] * limited.residual[k]
        if not has_force_law and not limited.inside_limits[k]:
            limited.correction[k] = limited.force[k] - limited.force_before[k]
    factorize_contacts(d, HELD, limited.impedance)
    solve_contacts(d, HELD, limited.correction, limited.change)
    for k in range(d.contacts.force_law_count, constraint_count(d)):
        residual = limited.residual[k] - dot(constraint_row(d, k), motion)
        limited.unlimited_force[k] = limited.force_before[k] + d.constraints.impedance[k] * residual
    count_other_cost(d, 1)


def update_residuals(d):
    """Begin the next iteration: set p (``force_before``) to the present forces, and find their residuals."""
    limited = d.limited_forces
    solve_contacts(d, FREE, limited.force, limited.change)
    for k in range(d.contacts.force_law_count, constraint_count(d)):
        limited.force_before[k] = limited.force[k]
        reached = d.constraints.unforced_motion[k] + dot(constraint_row(d, k), d.scratch.place_change)
        limited.residual[k] = d.constraints.target_motion[k] - reached
    count_other_cost(d, 1)
