"""Constraints: the impulses or forces that bring touching points to a target motion.

A rigid wall has no force law. The touching candidates k have normal motions u_k: positions, rates or
accelerations. Impulses p_k change these from u⁻ by the response Δ of the chain: M Δ = Jᵀ p, u = u⁻ + J Δ = u⁻
+ W p, with the mass matrix M and the mobility W = J M⁻¹ Jᵀ. There are two problems:

    equality          u_k = target_k in the active set, else p_k = 0    (``solve_equality``)
    complementarity   p ≥ 0,  u ≥ target,  p·(u − target) = 0           (``solve_lcp`` in complementarity.py)

If only one constraint is active, p = (target − u⁻)/W with a number W (``solve_single``). Otherwise W is never
formed. With an impedance D at the points of the active set the recursion solves, in O(N),

    (M + Jᵀ D J) z = Jᵀ D m,   p ← p + D (m − J z),   Δ ← Δ + z,   m = target − u,

the iteration of an augmented Lagrangian. Each iteration divides the residual m by 1 + D W, down to round-off.
The constraints may be dependent. At rigid walls D is a million times the mean mass of a link. The iteration
continues until the residual is round-off, often after a few iterations; D is increased if m falls too slowly.

A sticking element of dry friction (forces/friction.py) also has a constraint, of its tangential motion, which
is always in the active set. For dependent constraints the iteration finds the solution with the least Σ p²/D.
With D in proportion to the limits of friction, the forces of sticking elements are in proportion to the
limits, too. Some motions can hardly be constrained (D W ≪ 1), such as a change in the length of a straight
chain on a floor. The iteration leaves them free, because their constraint forces could have any size. Where
D W is about 1, a fixed number of iterations makes the forces a smooth function of the state; if the number
depended on the residual, forces would jump within a step by a part of the residual.
"""

import math

from chain_impact.kernel.chain.mass_matrix_solver import FREE, HELD
from chain_impact.kernel.constraints.constraint_response import (
    RELATIVE_IMPEDANCE,
    STICKING_ITERATIONS,
    factorize_contacts,
    held_mobility,
    holding_impedance,
    mean_mass,
    solve_contacts,
    solve_in_space,
)
from chain_impact.kernel.constraints.geometry import (
    add_along_row,
    clear_used_forces,
    constraint_count,
    constraint_row,
    dot,
    has_sticking,
)
from chain_impact.kernel.cost import count_other_cost
from chain_impact.kernel.function_marks import has_dual_rule, inlined

# If an iteration at a rigid wall leaves more than SLOW_DECREASE of the residual, as near a toggle position,
# where the mobility is small, the impedance is multiplied by IMPEDANCE_GROWTH, up to LARGEST_IMPEDANCE times
# the mean mass of a link; with a larger impedance the residual would only be round-off.
LARGEST_IMPEDANCE, IMPEDANCE_GROWTH, SLOW_DECREASE = 1e12, 1e3, 0.1
FOLD_RESIDUAL = 1e-3  # at rigid walls, a fold is near if the first iteration leaves more of the residual
# The impedance D of the first iteration for sticking elements if no rigid wall holds a point, relative to the
# mean mass of a link. This iteration finds the forces up to about a thousandth. Without it, the round-off of
# the whole motion, times the large D of the other iterations, would stay in the forces against motions that
# can hardly be constrained, and steps at tight tolerances would be short. The impedance of the
# other iterations is IMPEDANCE_GROWTH times as large.
FIRST_IMPEDANCE = RELATIVE_IMPEDANCE / IMPEDANCE_GROWTH
# The force on a single held point is m/W, with the residual m and the mobility W, if W times the mean mass of
# a link is at least LEAST_SINGLE_MOBILITY. Near a toggle position the iteration finds the force.
LEAST_SINGLE_MOBILITY = 1e-3
# The factor a on sticking elements' impedance D with which one solution replaces n = STICKING_ITERATIONS.
# With the mobility W and x = D W, n iterations leave (1 + x)⁻ⁿ of a motion; one solution leaves 1/(1 + a x):
# both are equal for a = ((1 + x)ⁿ − 1)/x, which is n for small x, and 10 for x = 0.36.
SINGLE_SOLUTION_FACTOR = 10.0
SOLVED_RESIDUAL = 1e-15  # largest residual that needs no more iterations, relative to the largest motion
# A residual of a sticking element well below this, relative to the largest motion, may be round-off, so
# ``reduce_free_impulses`` hardly changes the element's impulse. With a much smaller limit, round-off times
# the impedance D would be taken from impulses, and a chain at rest would change its energy.
RESIDUAL_ROUND_OFF = 1e-13
# [m, m/s or m/s²] the largest residual that counts as 0: its square may underflow
UNDERFLOW_RESIDUAL = 1e-100
# If no rigid wall holds a point, motions that can hardly be constrained, and are well below NEGLIGIBLE_MOTION
# × tolerance² × the largest motion, get hardly any impulses, because impulses would end the sticking again
# and again.
NEGLIGIBLE_MOTION = 0.1
# the largest impulse or motion of the wrong sign that counts as round-off and does not change the active set,
# relative to the largest impulse or motion
SIGN_TOLERANCE = 1e-12
# The least impedance of a sticking element, relative to that of the element with the largest limit of
# friction. With a smaller impedance, the element's residual would fall too slowly.
LEAST_STICKING_IMPEDANCE = 1e-2
# Values of d.constraints.outcome. SOLVED: constraint forces have been found. MOVING: a held point still
# accelerates. OUTCOME_FORCES_NOT_FOUND: no forces, or no modes, satisfy all conditions. OUTCOME_NO_ROOM: a
# held point is too deep. A run that ends for such a reason has the status of the same name (status.py).
SOLVED, MOVING, OUTCOME_FORCES_NOT_FOUND, OUTCOME_NO_ROOM = 0, 1, 2, 3


def set_impedance(d, amount):
    """Set the impedance [kg] of each constraint: ``amount`` in the active set, else ``added_mass``.

    Each sticking element gets a part of ``amount`` (``scale_sticking_impedances``).
    """
    constraints = d.constraints
    for k in range(constraint_count(d)):
        constraints.impedance[k] = amount if constraints.in_active_set[k] else constraints.added_mass[k]
    if amount > 0.0 and has_sticking(d):
        scale_sticking_impedances(d)


def scale_sticking_impedances(d):
    """Multiply sticking elements' impedances by max(LEAST_STICKING_IMPEDANCE, limit/largest limit) each."""
    elements, first, largest_limit = d.friction_element, d.contacts.active_count, 0.0
    for i in range(d.friction.stuck_count):
        largest_limit = max(largest_limit, elements.friction_limit[elements.stuck_index[i]])
    for i in range(d.friction.stuck_count):
        ratio = (
            elements.friction_limit[elements.stuck_index[i]] / largest_limit if largest_limit > 0.0 else 1.0
        )
        d.constraints.impedance[first + i] *= max(LEAST_STICKING_IMPEDANCE, ratio)


def set_single_solution_impedances(d):
    """Set the impedances of rigid walls and sticking elements for one solution in place of an iteration.

    At a sticking element the solution has about the effect of STICKING_ITERATIONS iterations.
    """
    for k in range(d.contacts.force_law_count, constraint_count(d)):
        times = SINGLE_SOLUTION_FACTOR if k >= d.contacts.active_count else 1.0
        d.constraints.impedance[k] = times * holding_impedance(d)
    if has_sticking(d):
        scale_sticking_impedances(d)


def factorize_free(d):
    """Factorize M, plus ``added_mass`` of each contact, into slot FREE, for motions without constraints."""
    set_impedance(d, 0.0)
    factorize_contacts(d, FREE, d.constraints.impedance)


def solve_equality(d, scale):
    """Find the impulses that move the active set from ``unforced_motion`` to ``target_motion``; others are 0.

    Args:
        d: the instance, with the points located and the free motion factorized. ``d.constraints`` has the
            problem and, afterwards, p in ``impulse``, u in ``reached_motion``, Δ in ``change``, and
            ``near_fold``.
        scale: the largest motion of any point, to which round-off is relative.

    Returns:
        The largest residual after the iteration; 0 without an iteration, or if no rigid wall holds a point.
    """
    d.constraints.near_fold = 0
    single = single_active(d)
    if single >= 0 and solve_single(d, single):
        return 0.0
    clear_impulses(d)
    residual = iterate_impulses(d, scale)
    if any_point_held(d):
        return residual
    if residual > max(SOLVED_RESIDUAL * scale, UNDERFLOW_RESIDUAL):
        limit = NEGLIGIBLE_MOTION * d.solver.tolerance * d.solver.tolerance * scale
        reduce_free_impulses(
            d, limit * limit / (limit * limit + residual * residual), RESIDUAL_ROUND_OFF * scale
        )
    return 0.0


def iterate_impulses(d, scale):
    """Iterate until the residual is round-off, or no larger impedance reduces the residual.

    The loop always ends: each iteration except the last leaves less than SLOW_DECREASE of the residual,
    increases D, or follows an increase of D; D has a largest value. If no rigid wall holds a point, there
    are a first iteration and STICKING_ITERATIONS more, or fewer if the residual is round-off earlier.

    After the first iteration with an impedance, the motion is computed from the impulses. Its difference from
    the motion with z shows the error of z, relative to the residual. If this error of the next iterations is
    round-off, their z is enough.

    Returns:
        The largest residual.
    """
    constraints, has_walls, round_off = d.constraints, any_point_held(d), SOLVED_RESIDUAL * scale
    impedance = holding_impedance(d) if has_walls else FIRST_IMPEDANCE * mean_mass(d)
    set_impedance(d, impedance)
    factorize_contacts(d, HELD, constraints.impedance)
    residual_before, residual, relative_error, iterations = (
        math.inf,
        find_residual(d),
        math.inf,
        0 if has_walls else -1,
    )
    while residual > round_off or not iterated_enough(d, iterations):
        slow = has_walls and residual > round_off and not residual < SLOW_DECREASE * residual_before
        if has_walls and iterations == 1 and residual > max(FOLD_RESIDUAL * residual_before, round_off):
            constraints.near_fold = 1
        grows = slow and residual > SIGN_TOLERANCE * scale and impedance < LARGEST_IMPEDANCE * mean_mass(d)
        residual_before = residual
        if grows or (iterations == 0 and not has_walls):
            residual_before = relative_error = math.inf
            impedance *= IMPEDANCE_GROWTH
            set_impedance(d, impedance)
            factorize_contacts(d, HELD, constraints.impedance)
        elif (slow and iterated_enough(d, iterations)) if has_walls else iterations == STICKING_ITERATIONS:
            break
        correct_impulses(d)
        if may_exceed(relative_error * residual, round_off):
            relative_error = move_by_impulses(d) / max(residual, UNDERFLOW_RESIDUAL)
        residual, iterations = find_residual(d), iterations + 1
    return residual


def reduce_free_impulses(d, fraction, noise):
    """Take a ``fraction`` off the impulses along motions that can hardly be constrained.

    Along such a motion each of the STICKING_ITERATIONS has added D m to the impulse, with the impedance D and
    the residual m. An impulse whose m is well below ``noise``, and so may be round-off, hardly changes.
    """
    constraints = d.constraints
    for k in range(constraint_count(d)):
        residual = constraints.residual[k]
        above = residual * residual / (residual * residual + noise * noise)
        constraints.impulse[k] -= fraction * above * STICKING_ITERATIONS * constraints.impedance[k] * residual
    move_by_impulses(d)


def single_active(d):
    """Return the index of the only constraint in the active set, or −1 if the set has none or several."""
    single = -1
    for k in range(constraint_count(d)):
        if d.constraints.in_active_set[k]:
            if single >= 0:
                return -1
            single = k
    return single


def solve_single(d, single):
    """Solve the problem of ``solve_equality`` in which only constraint ``single`` is in the active set.

    Return True, with impulses, motions and ``change`` set. If the mobility of a held point is too low, the
    result is False: ``change`` then has no meaning, and impulses and motions stay as they were. A sticking
    element never gives False.
    """
    constraints, motion = d.constraints, d.scratch.place_change
    clear_used_forces(d, d.scratch.applied_force)
    add_along_row(constraint_row(d, single), d.scratch.applied_force, 1.0)
    solve_in_space(d, d.scratch.link_vector, d.scratch, FREE, constraints.change)
    mobility = dot(constraint_row(d, single), motion)
    if single >= d.contacts.active_count:
        mobility = held_mobility(d, mobility)
    elif mobility * mean_mass(d) < LEAST_SINGLE_MOBILITY:
        return False
    impulse = (constraints.target_motion[single] - constraints.unforced_motion[single]) / mobility
    for j in range(len(constraints.change)):
        constraints.change[j] *= impulse
    for k in range(constraint_count(d)):
        constraints.impulse[k] = impulse if k == single else 0.0
        constraints.reached_motion[k] = constraints.unforced_motion[k] + impulse * dot(
            constraint_row(d, k), motion
        )
    count_other_cost(d, 1)
    return True


@has_dual_rule
def may_exceed(error, round_off):
    """Return whether ``error`` exceeds ``round_off``; with dual numbers the result is True."""
    return error > round_off


@has_dual_rule
def iterated_enough(_d, _iterations):
    """Return True: values need no more iterations; with dual numbers a rule lets derivatives converge."""
    return True


def clear_impulses(d):
    """Set all impulses and their ``change`` to 0, and each ``reached_motion`` to the ``unforced_motion``."""
    constraints = d.constraints
    for j in range(len(constraints.change)):
        constraints.change[j] = 0.0
    for k in range(constraint_count(d)):
        constraints.impulse[k], constraints.reached_motion[k] = 0.0, constraints.unforced_motion[k]


def find_residual(d):
    """Set the residuals: target − motion in the active set, else 0; return the largest |residual|."""
    constraints, largest_residual = d.constraints, 0.0
    for k in range(constraint_count(d)):
        residual = constraints.target_motion[k] - constraints.reached_motion[k]
        constraints.residual[k] = residual if constraints.in_active_set[k] else 0.0
        largest_residual = max(largest_residual, abs(constraints.residual[k]))
    return largest_residual


@inlined
def correct_impulses(d):
    """Improve the impulses by one iteration, from the residuals, and the motion by the iteration's z."""
    constraints, z, motion = d.constraints, d.scratch.change, d.scratch.place_change
    # p: impulses, m: residuals (target − motion), D: impedances, J: rows of the constraints, M: mass matrix,
    # z: change of the coordinates' rates that the change of p causes, Δ: the change that p causes
    # (M + Jᵀ D J) z = Jᵀ D m, p ← p + D (m − J z), Δ ← Δ + z
    for k in range(constraint_count(d)):
        constraints.residual[k] *= constraints.impedance[k]
    solve_contacts(d, HELD, constraints.residual, z)
    for k in range(constraint_count(d)):
        change = dot(constraint_row(d, k), motion)
        constraints.reached_motion[k] += change
        if constraints.in_active_set[k]:
            constraints.impulse[k] += constraints.residual[k] - constraints.impedance[k] * change
    for j in range(len(constraints.change)):
        constraints.change[j] += z[j]
    count_other_cost(d, 1)


def move_by_impulses(d):
    """Compute the change of the coordinates, and the motions along all constraints, due to the impulses.

    Returns:
        The largest |difference| of these motions from those in ``reached_motion`` before.
    """
    constraints, largest_difference = d.constraints, 0.0
    solve_contacts(d, FREE, constraints.impulse, constraints.change)
    for k in range(constraint_count(d)):
        motion = constraints.unforced_motion[k] + dot(constraint_row(d, k), d.scratch.place_change)
        largest_difference = max(largest_difference, abs(motion - constraints.reached_motion[k]))
        constraints.reached_motion[k] = motion
    count_other_cost(d, 1)
    return largest_difference


def replace_impulses(d, impulse):
    """Set the impulses to ``impulse``, and ``change`` to the response to the new minus the old impulses.

    Afterwards ``reached_motion`` has no meaning.
    """
    constraints = d.constraints
    for k in range(constraint_count(d)):
        constraints.impulse[k] = impulse[k] - constraints.impulse[k]
    move_by_impulses(d)
    for k in range(constraint_count(d)):
        constraints.impulse[k] = impulse[k]


def clear_outcome(d):
    """Clear the record of an unsolved problem; a tried step with such a record is rejected."""
    d.constraints.outcome = SOLVED


def note_forces_not_found(d):
    """Record that forces or modes are not found: a tried step is rejected; at an event, the run ends."""
    d.constraints.outcome = OUTCOME_FORCES_NOT_FOUND


def note_moving(d, tolerated):
    """Replace the outcome SOLVED by MOVING if a held point's residual exceeds ``tolerated`` [m/s²]."""
    for k in range(d.contacts.force_law_count, d.contacts.active_count):
        if d.constraints.outcome == SOLVED and abs(d.constraints.residual[k]) > tolerated:
            d.constraints.outcome = MOVING


def note_no_room(d, tolerated):
    """Record OUTCOME_NO_ROOM if a held point lies deeper in its rigid wall than ``tolerated`` [m]."""
    for k in range(d.contacts.force_law_count, d.contacts.active_count):
        if d.constraints.target_motion[k] - d.constraints.reached_motion[k] > tolerated:
            d.constraints.outcome = OUTCOME_NO_ROOM


def any_point_held(d):
    """Return whether a rigid wall holds any point."""
    return d.contacts.active_count > d.contacts.force_law_count


def any_constraint(d):
    """Return whether a rigid wall holds any point, or any element sticks by dry friction."""
    return any_point_held(d) or has_sticking(d)


def activate_all(d):
    """Let the active set be the contacts without a force law and the sticking elements, with target 0."""
    for k in range(d.contacts.force_law_count):
        remove_from_active_set(d, k)
    for k in range(d.contacts.force_law_count, constraint_count(d)):
        add_to_active_set(d, k, 0.0)


def add_to_active_set(d, k, target):
    """Put constraint k into the active set; ``target`` is the value that its ``reached_motion`` must have."""
    d.constraints.in_active_set[k] = 1
    d.constraints.target_motion[k] = target


def remove_from_active_set(d, k):
    """Take constraint k out of the active set."""
    d.constraints.in_active_set[k] = 0
