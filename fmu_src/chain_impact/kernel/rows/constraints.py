"""Constraints: the impulses or forces that bring touching points to a target motion.

A rigid wall has no force law. The touching candidates k have normal motions u_k: positions, rates or
accelerations. Impulses p_k change these from u⁻ by the response Δ of the chain: M Δ = Jᵀ p, u = u⁻ + J Δ = u⁻
+ W p, with the mass matrix M and the mobility W = J M⁻¹ Jᵀ. There are two problems:

    equality          u_k = target_k in the active set, else p_k = 0    (``solve_equality``)
    complementarity   p ≥ 0,  u ≥ target,  p·(u − target) = 0           (``solve_lcp``)

If only one constraint is active, p = (target − u⁻)/W with a number W (``solve_single``). Otherwise W is never
formed. With an impedance D at the points of the active set the recursion solves, in O(N),

    (M + Jᵀ D J) z = Jᵀ D m,   p ← p + D (m − J z),   m = target − u,

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

from chain_impact.kernel.chain.response import FREE, HELD
from chain_impact.kernel.cost import count_other_cost, is_cost_exceeded
from chain_impact.kernel.function_marks import has_dual_rule, inlined
from chain_impact.kernel.rows.compliance import (
    STICKING_ITERATIONS,
    factorize_contacts,
    held_mobility,
    holding_impedance,
    mean_mass,
    solve_contacts,
    solve_in_space,
)
from chain_impact.kernel.rows.geometry import (
    add_along_row,
    clear_used_loads,
    constraint_count,
    constraint_row,
    dot,
    has_sticking,
)

# If an iteration at a rigid wall leaves more than SLOW_DECREASE of the residual, as near a toggle position,
# where the mobility is small, the impedance is multiplied by IMPEDANCE_GROWTH, up to LARGEST_IMPEDANCE times
# the mean mass of a link; with a larger impedance the residual would only be round-off.
LARGEST_IMPEDANCE, IMPEDANCE_GROWTH, SLOW_DECREASE = 1e12, 1e3, 0.1
FOLD_RESIDUAL = 1e-3  # at rigid walls, a fold is near if the first iteration leaves more of the residual
# The impedance D of the first iteration for sticking elements if no rigid wall holds a point, relative to the
# mean mass of a link. This iteration finds the forces up to about a thousandth. Without it, the round-off of
# the whole motion, times the large D of the other iterations, would stay in the forces against motions that
# can hardly be constrained, and steps at tight tolerances would be short.
FIRST_IMPEDANCE = 1e3
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
UNDERFLOW_SIZE = 1e-100  # [m, m/s or m/s²] the largest residual that counts as 0: its square may underflow
# If no rigid wall holds a point, motions that can hardly be constrained, and are well below NEGLIGIBLE_MOTION
# × tolerance² × the largest motion, get hardly any impulses, because impulses would end the sticking again
# and again.
NEGLIGIBLE_MOTION = 0.1
# the largest impulse or motion of the wrong sign that counts as round-off and does not change the active set,
# relative to the largest impulse or motion
SIGN_TOLERANCE = 1e-12
# The number of successive pivots that may leave the least number of violations unchanged. After one more such
# pivot, each pivot changes a single candidate until that number falls; this ends, but slowly (``solve_lcp``).
MAX_STALLED_PIVOTS = 3
# The least impedance of a sticking element, relative to that of the element with the largest limit of
# friction. With a smaller impedance, the element's residual would fall too slowly.
LEAST_STICKING_IMPEDANCE = 1e-2
# Values of d.constraints.unsolved. SOLVED: constraint forces have been found. MOVING: a held point still
# accelerates. UNSOLVED: no forces, or no modes, satisfy all conditions. SQUEEZED: a held point is too deep.
SOLVED, MOVING, UNSOLVED, SQUEEZED = 0, 1, 2, 3
# the largest number of pivots, in addition to 4 for each constraint; a search that needs more has failed
EXTRA_PIVOTS = 30


def set_impedance(d, amount):
    """Set the impedance [kg] of each constraint: ``amount`` in the active set, else ``resistance``.

    Each sticking element gets a part of ``amount`` (``scale_sticking_impedances``).
    """
    constraints = d.constraints
    for k in range(constraint_count(d)):
        constraints.impedance[k] = amount if constraints.in_active_set[k] else constraints.resistance[k]
    if amount > 0.0 and has_sticking(d):
        scale_sticking_impedances(d)


def scale_sticking_impedances(d):
    """Multiply sticking elements' impedances by max(LEAST_STICKING_IMPEDANCE, limit/largest limit) each."""
    friction, first, most = d.friction, d.contacts.active_count, 0.0
    for i in range(friction.stuck_count):
        most = max(most, d.element.limit[d.element.stuck[i]])
    for i in range(friction.stuck_count):
        ratio = d.element.limit[d.element.stuck[i]] / most if most > 0.0 else 1.0
        d.constraints.impedance[first + i] *= max(LEAST_STICKING_IMPEDANCE, ratio)


def set_single_solution_impedances(d):
    """Set impedances: at sticking elements one solution has about the effect of STICKING_ITERATIONS."""
    for k in range(d.contacts.compliant_count, constraint_count(d)):
        times = SINGLE_SOLUTION_FACTOR if k >= d.contacts.active_count else 1.0
        d.constraints.impedance[k] = times * holding_impedance(d)
    if has_sticking(d):
        scale_sticking_impedances(d)


def factorize_free(d):
    """Factorize M, with the resistances of contacts with a force law, for motions without constraints."""
    set_impedance(d, 0.0)
    factorize_contacts(d, FREE, d.constraints.impedance)


def solve_equality(d, scale):
    """Find the impulses that bring the active set from ``unforced`` to ``target``; other impulses are 0.

    Args:
        d: the instance, with the points located and the free motion factorized. ``d.constraints`` has the
            problem and, afterwards, p in ``impulse``, u in ``reached`` and Δ in ``change``.
        scale: the largest motion of any point, to which round-off is relative.

    Returns:
        The largest residual after the iteration; 0 without an iteration, or if no rigid wall holds a point.
    """
    constraints, impedance = d.constraints, holding_impedance(d)
    constraints.near_fold = 0
    only = single_active(d)
    if only >= 0 and solve_single(d, only):
        return 0.0
    clear_impulses(d)
    if not any_point_held(d):
        set_impedance(d, FIRST_IMPEDANCE * mean_mass(d))
        factorize_contacts(d, HELD, constraints.impedance)
        find_residual(d)
        correct_impulses(d)
    set_impedance(d, impedance)
    factorize_contacts(d, HELD, constraints.impedance)
    worst = iterate_impulses(d, scale, impedance)
    if any_point_held(d):
        return worst
    if worst > max(SOLVED_RESIDUAL * scale, UNDERFLOW_SIZE):
        least = NEGLIGIBLE_MOTION * d.solver.tolerance * d.solver.tolerance * scale
        reduce_free_impulses(d, least * least / (least * least + worst * worst), RESIDUAL_ROUND_OFF * scale)
    return 0.0


def iterate_impulses(d, scale, impedance):
    """Iterate until the residual is round-off, or no larger ``impedance`` [kg] reduces the residual.

    The loop always ends: each iteration except the last leaves less than SLOW_DECREASE of the residual,
    increases D, or follows an increase of D; D increases at most twice. If no rigid wall holds a point, there
    are STICKING_ITERATIONS iterations, or fewer if the residual is round-off earlier.

    Returns:
        The largest residual.
    """
    constraints, has_walls, round_off = d.constraints, any_point_held(d), SOLVED_RESIDUAL * scale
    before, worst, iterations = math.inf, find_residual(d), 0
    while worst > round_off or not iterated_enough(d, iterations):
        slow = has_walls and worst > round_off and not worst < SLOW_DECREASE * before
        if has_walls and iterations == 1 and worst > max(FOLD_RESIDUAL * before, SIGN_TOLERANCE * scale):
            constraints.near_fold = 1
        before = worst
        if slow and worst > SIGN_TOLERANCE * scale and impedance < LARGEST_IMPEDANCE * mean_mass(d):
            before = math.inf
            impedance *= IMPEDANCE_GROWTH
            set_impedance(d, impedance)
            factorize_contacts(d, HELD, constraints.impedance)
        elif (slow and iterated_enough(d, iterations)) if has_walls else iterations == STICKING_ITERATIONS:
            break
        correct_impulses(d)
        worst, iterations = find_residual(d), iterations + 1
    return worst


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
    only = -1
    for k in range(constraint_count(d)):
        if d.constraints.in_active_set[k]:
            if only >= 0:
                return -1
            only = k
    return only


def solve_single(d, only):
    """Solve the equality problem for constraint ``only``; return False if a wall's mobility is too small."""
    constraints, motion = d.constraints, d.scratch.place_change
    clear_used_loads(d, d.scratch.load)
    add_along_row(constraint_row(d, only), d.scratch.load, 1.0)
    solve_in_space(d, d.scratch.link_vector, d.scratch, FREE, constraints.change)
    mobility = dot(constraint_row(d, only), motion)
    if only >= d.contacts.active_count:
        mobility = held_mobility(d, mobility)
    elif mobility * mean_mass(d) < LEAST_SINGLE_MOBILITY:
        return False
    impulse = (constraints.target[only] - constraints.unforced[only]) / mobility
    for j in range(len(constraints.change)):
        constraints.change[j] *= impulse
    for k in range(constraint_count(d)):
        constraints.impulse[k] = impulse if k == only else 0.0
        constraints.reached[k] = constraints.unforced[k] + impulse * dot(constraint_row(d, k), motion)
    count_other_cost(d, 1)
    return True


@has_dual_rule
def iterated_enough(_d, _iterations):
    """Return True: values need no more iterations; with dual numbers a rule lets derivatives converge."""
    return True


def clear_impulses(d):
    """Set all impulses and their ``change`` to 0, and ``reached`` of each constraint to its ``unforced``."""
    constraints = d.constraints
    for j in range(len(constraints.change)):
        constraints.change[j] = 0.0
    for k in range(constraint_count(d)):
        constraints.impulse[k], constraints.reached[k] = 0.0, constraints.unforced[k]


def find_residual(d):
    """Set the residuals: target − motion in the active set, else 0; return the largest |residual|."""
    constraints, worst = d.constraints, 0.0
    for k in range(constraint_count(d)):
        left = constraints.target[k] - constraints.reached[k]
        constraints.residual[k] = left if constraints.in_active_set[k] else 0.0
        worst = max(worst, abs(constraints.residual[k]))
    return worst


@inlined
def correct_impulses(d):
    """Improve the impulses by one iteration, from the residuals; compute the motion with the new impulses."""
    constraints, motion = d.constraints, d.scratch.place_change
    # p: impulses, m: residuals (target − motion), D: impedances, J: rows of the constraints, M: mass matrix,
    # z: change of the coordinates' rates
    # (M + Jᵀ D J) z = Jᵀ D m, p ← p + D (m − J z)
    for k in range(constraint_count(d)):
        constraints.residual[k] *= constraints.impedance[k]
    solve_contacts(d, HELD, constraints.residual, constraints.change)
    for k in range(constraint_count(d)):
        if constraints.in_active_set[k]:
            back = constraints.impedance[k] * dot(constraint_row(d, k), motion)
            constraints.impulse[k] += constraints.residual[k] - back
    move_by_impulses(d)
    count_other_cost(d, 1)


def move_by_impulses(d):
    """Compute the change of the coordinates, and the motions along all constraints, due to the impulses."""
    constraints = d.constraints
    solve_contacts(d, FREE, constraints.impulse, constraints.change)
    for k in range(constraint_count(d)):
        constraints.reached[k] = constraints.unforced[k] + dot(constraint_row(d, k), d.scratch.place_change)
    count_other_cost(d, 1)


def replace_impulses(d, impulse):
    """Set the impulses to ``impulse``, and ``change`` to the response to the new minus the old impulses."""
    constraints = d.constraints
    for k in range(constraint_count(d)):
        constraints.impulse[k] = impulse[k] - constraints.impulse[k]
    move_by_impulses(d)
    for k in range(constraint_count(d)):
        constraints.impulse[k] = impulse[k]


def solve_lcp(d, scale):
    """Find impulses p ≥ 0 and motions u ≥ target with p·(u − target) = 0, at points that rigid walls hold.

    Block principal pivoting (after Júdice & Pires 1994, Comput Oper Res 21:587) begins with the active set in
    ``in_active_set``. Candidates with p < 0 leave the set, and those with u < target enter it: all at once
    or, beyond MAX_STALLED_PIVOTS, only that of highest index; this search ends if the mobility W is positive
    definite (Murty 1974, Linear Algebra Appl 9:65). If the search reaches its largest number of pivots, the
    problem is recorded as unsolved. Arguments and results are as in ``solve_equality``.
    """
    constraints, first = d.constraints, d.contacts.compliant_count
    count = d.contacts.active_count - first
    fewest, stalls_left = count + 1, MAX_STALLED_PIVOTS
    for _ in range(EXTRA_PIVOTS + 4 * count):
        solve_equality(d, scale)
        wrong = count_violations(d, scale)
        if wrong == 0 or is_cost_exceeded(d):
            return
        fewest, stalls_left = count_stalls(wrong, fewest, stalls_left)
        for i in range(count):
            k = first + count - 1 - i
            if constraints.violated[k]:
                constraints.in_active_set[k] = 1 - constraints.in_active_set[k]
                if stalls_left < 0:
                    break
    note_unsolved(d)


def clear_unsolved(d):
    """Clear the record of an unsolved problem; a tried step with such a record is rejected."""
    d.constraints.unsolved = SOLVED


def note_unsolved(d):
    """Record that forces or modes are not found: a tried step is rejected; at an event, the run ends."""
    d.constraints.unsolved = UNSOLVED


def note_moving(d, tolerated):
    """Record MOVING if a held point's acceleration is off its target by more than ``tolerated`` [m/s²]."""
    for k in range(d.contacts.compliant_count, d.contacts.active_count):
        if d.constraints.unsolved == SOLVED and abs(d.constraints.residual[k]) > tolerated:
            d.constraints.unsolved = MOVING


def note_squeezed(d, tolerated):
    """Record SQUEEZED if a held point lies deeper in its rigid wall than ``tolerated`` [m]."""
    for k in range(d.contacts.compliant_count, d.contacts.active_count):
        if d.constraints.target[k] - d.constraints.reached[k] > tolerated:
            d.constraints.unsolved = SQUEEZED


def count_stalls(wrong, fewest, stalls_left):
    """Return the least number of violations so far, and how many pivots may still fail to reduce it."""
    if wrong < fewest:
        return wrong, MAX_STALLED_PIVOTS
    return fewest, stalls_left - 1


def count_violations(d, scale):
    """Count and mark violations above round-off: impulses < 0 in the active set, motions < target outside."""
    constraints, largest, wrong = d.constraints, 0.0, 0
    for k in range(d.contacts.compliant_count, d.contacts.active_count):
        largest = max(largest, abs(constraints.impulse[k]))
    for k in range(d.contacts.compliant_count, d.contacts.active_count):
        if constraints.in_active_set[k]:
            constraints.violated[k] = constraints.impulse[k] < -SIGN_TOLERANCE * largest
        else:
            constraints.violated[k] = constraints.reached[k] < constraints.target[k] - SIGN_TOLERANCE * scale
        wrong += constraints.violated[k]
    return wrong


def any_point_held(d):
    """Return whether a rigid wall holds any point."""
    return d.contacts.active_count > d.contacts.compliant_count


def any_constraint(d):
    """Return whether a rigid wall holds any point, or any element sticks by dry friction."""
    return any_point_held(d) or has_sticking(d)


def activate_all(d):
    """Let the active set be the contacts without a force law and the sticking elements, with target 0."""
    for k in range(d.contacts.compliant_count):
        remove_from_active_set(d, k)
    for k in range(d.contacts.compliant_count, constraint_count(d)):
        add_to_active_set(d, k, 0.0)


def add_to_active_set(d, k, target):
    """Put constraint k into the active set; ``target`` is the value that its ``reached`` must have."""
    d.constraints.in_active_set[k] = 1
    d.constraints.target[k] = target


def remove_from_active_set(d, k):
    """Take constraint k out of the active set."""
    d.constraints.in_active_set[k] = 0
