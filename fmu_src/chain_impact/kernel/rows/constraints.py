"""Constraints: the impulses or forces that bring touching points to a target motion.

A rigid wall has no force law. The touching candidates k have normal motions u_k, rates or accelerations, and
impulses p_k change them by the recursion's response: M Δ = Jᵀ p, u = u⁻ + J Δ = u⁻ + W p, W = J M⁻¹ Jᵀ. Two
problems come up:

    equality          u_k = target_k in the active set, else p_k = 0    (``solve_equality``)
    complementarity   p ≥ 0,  u ≥ target,  p·(u − target) = 0           (``solve_lcp``)

If only one constraint is active, p = m/W with this one number W (``solve_single``). Otherwise W is never
formed. With an impedance D at the points of the active set the recursion solves, in O(N),

    (M + Jᵀ D J) z = Jᵀ D m,   p ← p + D (m − J z),   m = target − u,

the iteration of an augmented Lagrangian: each one reduces the residual m to 1/(1 + D W) of it, down to
round-off, and the constraints may be dependent. D is a million times a link's mass: a few iterations suffice.
At rigid walls the iteration goes on until the residual is round-off, and D grows where that would be slow.

A sticking element of dry friction (friction.py) is also a constraint, of its tangential motion. It is always
in the active set: an equality. Of the possible solutions for dependent constraints the iteration finds the
one with
the least Σ p²/D. So with D in proportion to the limits of friction the sticking elements share their load in
that proportion. Motions that can hardly be constrained, such as a change in the length of a straight chain on
    a floor, are left free, because their constraint forces could have any size. A negligible motion of this
    kind gets no force from the iteration either, because the force could exceed the limits. In between, where
    D W is about 1, the forces are the result of a given number of iterations: a smooth function of the state.
    If the progress of the residual decided on the number, forces would jump within a step by a part of the
    residual.
"""

import math

from chain_impact.kernel.chain.response import FREE, HELD
from chain_impact.kernel.rows.compliance import (
    SWEEPS,
    factorize_contacts,
    held_mobility,
    holding_impedance,
    mean_mass,
    solve_contacts,
    solve_space,
)
from chain_impact.kernel.rows.geometry import (
    add_along,
    along,
    any_sticking,
    clear_loads_of,
    constraint,
    constraint_rows,
)
from chain_impact.kernel.status import count_other_work, work_exceeded

# Near a toggle position 1/W is far larger than the mass of a link. If an iteration leaves more than SLOW of
# the residual, D grows by the factor STIFFER, up to STIFFEST times that mass; beyond it the residual is only
# round-off.
STIFFEST, STIFFER, SLOW = 1e12, 1e3, 0.1
# D of the first iteration for sticking elements without a rigid wall, over the mean mass of a link. This
# iteration finds the forces to a thousandth. Without it, the round-off of the whole motion, times the large D
# of the other iterations, would remain in the forces against motions that can hardly be constrained, and
# steps at tight tolerances would be short.
GENTLE = 1e3
# The least W for which a single constraint is solved directly, over 1/(mean mass of a link). A smaller one,
# as near a toggle position, has lost digits, and the iteration is used instead.
LEAST_SINGLE = 1e-3
ROUND_OFF = 1e-15  # the largest residual that is accepted, over the largest motion
FADED = 1e-100  # [m, m/s or m/s²] a residual whose square may underflow, as in a chain that has come to rest
# The largest motion that sticking elements may keep, over the squared tolerance times the largest motion.
# Impulses against a smaller one, which can hardly be constrained, would end the sticking again and again.
NEGLIGIBLE = 0.1
# the largest value of wrong sign that does not change the active set, over the largest value
SIGN_TOLERANCE = 1e-12
# Number of pivots of all violated candidates at once that may fail to reduce their number; then only one at a
# time is changed, which terminates in every case but takes more pivots.
MAX_STALLED_PIVOTS = 3
# The least impedance of a sticking element, over the one with the largest limit. With a smaller one, the
# residual falls too slowly.
LEAST_SHARE = 1e-2
SOLVED, MOVING, UNSOLVED, SQUEEZED = 0, 1, 2, 3  # values of d.rigid.unsolved
# bound on the number of pivots, plus 4 for each candidate; far above any number that was observed
ROUNDS = 30


def set_impedance(d, amount):
    """Set the impedance of the active set to an amount [kg], and elsewhere to the resistance."""
    own = d.rigid
    for k in range(constraint_rows(d)):
        own.impedance[k] = amount if own.in_active_set[k] else own.resistance[k]
    if amount > 0.0 and any_sticking(d):
        share_impedance(d)


def share_impedance(d):
    """Scale the impedances of sticking elements by their limits of friction, over the largest limit."""
    own, first, most = d.friction, d.touch.active_count, 0.0
    for i in range(own.stuck_count):
        most = max(most, d.element.limit[d.element.stuck[i]])
    for i in range(own.stuck_count):
        share = d.element.limit[d.element.stuck[i]] / most if most > 0.0 else 1.0
        d.rigid.impedance[first + i] *= max(LEAST_SHARE, share)


def factorize_free(d):
    """Eliminate M for the motion by impulses; contacts that are not in the active set may resist it."""
    set_impedance(d, 0.0)
    factorize_contacts(d, FREE, d.rigid.impedance)


def solve_equality(d, scale):
    """Find the impulses that bring the active set from ``start`` to ``target``; other candidates have none.

    Args:
        d: the instance, with the points located and the free motion factorized; ``d.rigid`` holds the problem
            and, afterwards, p in ``impulse``, u in ``reached`` and Δ in ``change``.
        scale: the largest motion of a point, to which round-off is relative.

    Returns:
        The largest residual that rigid walls leave, or 0 if they hold no point.
    """
    own, impedance = d.rigid, holding_impedance(d)
    row = only_active(d)
    if row >= 0 and solve_single(d, row):
        return 0.0
    clear_impulses(d)
    if not any_point_held(d):
        set_impedance(d, GENTLE * mean_mass(d))
        factorize_contacts(d, HELD, own.impedance)
        find_residual(d)
        correct_impulses(d)
    set_impedance(d, impedance)
    factorize_contacts(d, HELD, own.impedance)
    worst = iterate(d, scale, impedance)
    if any_point_held(d):
        return worst
    if worst > max(ROUND_OFF * scale, FADED):
        least = NEGLIGIBLE * d.solver.tolerance * d.solver.tolerance * scale
        leave_free(d, least * least / (least * least + worst * worst))
    return 0.0


def iterate(d, scale, impedance):
    """Iterate until the residual is round-off, or no impedance [kg] reduces it, as constraints contradict.

    The iteration ends: each pass but the last leaves less than SLOW of the residual, or D grows, which
    happens twice. Sticking elements without a rigid wall get at most SWEEPS iterations.

    Returns:
        The largest residual.
    """
    own, rigid, round_off = d.rigid, any_point_held(d), ROUND_OFF * scale
    before, worst, iterations = math.inf, find_residual(d), 0
    while worst > round_off or not iterated_enough(d, iterations):
        slow = rigid and worst > round_off and not worst < SLOW * before
        if slow and worst > SIGN_TOLERANCE * scale and impedance < STIFFEST * mean_mass(d):
            impedance *= STIFFER
            set_impedance(d, impedance)
            factorize_contacts(d, HELD, own.impedance)
        elif (slow and iterated_enough(d, iterations)) or (not rigid and iterations == SWEEPS):
            break
        correct_impulses(d)
        before, worst, iterations = worst, find_residual(d), iterations + 1
    return worst


def leave_free(d, share):
    """Remove a share of the impulses against motions that are left free: D m of each iteration if D W ≪ 1."""
    own = d.rigid
    for k in range(constraint_rows(d)):
        own.impulse[k] -= share * SWEEPS * own.impedance[k] * own.residual[k]
    move_by_impulses(d)


def only_active(d):
    """Return the constraint that is the only one of the active set, or −1."""
    only = -1
    for k in range(constraint_rows(d)):
        if d.rigid.in_active_set[k]:
            if only >= 0:
                return -1
            only = k
    return only


def solve_single(d, row):
    """Solve ``solve_equality`` for an active set of one constraint: p = m/W; return whether W allows it.

    This takes one solution of the chain, and the iteration six in most cases.
    """
    own = d.rigid
    clear_loads_of(d, d.work.load)
    add_along(constraint(d, row), d.work.load, 1.0)
    solve_space(d, d.work.link, d.work, FREE, own.change)
    mobility = along(constraint(d, row), d.work.motion)
    if row >= d.touch.active_count:
        mobility = held_mobility(d, mobility)
    elif mobility * mean_mass(d) < LEAST_SINGLE:
        return False
    impulse = (own.target[row] - own.start[row]) / mobility
    for j in range(len(own.change)):
        own.change[j] *= impulse
    for k in range(constraint_rows(d)):
        own.impulse[k] = impulse if k == row else 0.0
        own.reached[k] = own.start[k] + impulse * along(constraint(d, k), d.work.motion)
    count_other_work(d, 1)
    return True


def iterated_enough(_d, _iterations):
    """Return whether so many iterations are enough if the residual is round-off."""
    return True


def clear_impulses(d):
    """Start with zero impulses and the motion without impulses."""
    own = d.rigid
    for j in range(len(own.change)):
        own.change[j] = 0.0
    for k in range(constraint_rows(d)):
        own.impulse[k], own.reached[k] = 0.0, own.start[k]


def find_residual(d):
    """Set the residuals m = target − u of the active set; return the largest |m|."""
    own, worst = d.rigid, 0.0
    for k in range(constraint_rows(d)):
        own.residual[k] = own.target[k] - own.reached[k] if own.in_active_set[k] else 0.0
        worst = max(worst, abs(own.residual[k]))
    return worst


def correct_impulses(d):
    """Correct the impulses for the residuals, and find the motion with them."""
    own, motion = d.rigid, d.work.motion
    # (M + Jᵀ D J) z = Jᵀ D m,  p ← p + D (m − J z)
    for k in range(constraint_rows(d)):
        own.residual[k] *= own.impedance[k]
    solve_contacts(d, HELD, own.residual, own.change)
    for k in range(constraint_rows(d)):
        if own.in_active_set[k]:
            back = own.impedance[k] * along(constraint(d, k), motion)
            own.impulse[k] += own.residual[k] - back
    move_by_impulses(d)
    count_other_work(d, 1)


def move_by_impulses(d):
    """Find the motion by the impulses."""
    own = d.rigid
    solve_contacts(d, FREE, own.impulse, own.change)
    for k in range(constraint_rows(d)):
        own.reached[k] = own.start[k] + along(constraint(d, k), d.work.motion)
    count_other_work(d, 1)


def solve_lcp(d, scale):
    """Find p ≥ 0, u ≥ target, p·(u − target) = 0, from the guess ``in_active_set``; see ``solve_equality``.

    Block principal pivoting (after Júdice & Pires 1994, Comput Oper Res 21:587): candidates with p < 0 leave
    the active set and those with u < target enter it. All change at once as long as their number falls,
    otherwise only the last one, which terminates if W is positive definite (Murty 1974, Linear Algebra Appl
    9:65). If it does not terminate, the problem is noted as unsolved.
    """
    own, first = d.rigid, d.touch.compliant_count
    count = d.touch.active_count - first
    fewest, stalls_left = count + 1, MAX_STALLED_PIVOTS
    for _ in range(ROUNDS + 4 * count):
        solve_equality(d, scale)
        wrong = count_violations(d, scale)
        if wrong == 0 or work_exceeded(d):
            return
        fewest, stalls_left = count_stalls(wrong, fewest, stalls_left)
        for i in range(count):
            k = first + count - 1 - i
            if own.violated[k]:
                own.in_active_set[k] = 1 - own.in_active_set[k]
                if stalls_left < 0:
                    break
    note_unsolved(d)


def clear_unsolved(d):
    """Begin to note unsolved problems; a tried step with one is refused."""
    d.rigid.unsolved = SOLVED


def note_unsolved(d):
    """Note that forces or modes have not been found: at an event the run ends."""
    d.rigid.unsolved = UNSOLVED


def note_moving(d, tolerated):
    """Note if a point that a rigid wall holds has more than the ``tolerated`` acceleration [m/s²]."""
    for k in range(d.touch.compliant_count, d.touch.active_count):
        if d.rigid.unsolved == SOLVED and abs(d.rigid.residual[k]) > tolerated:
            d.rigid.unsolved = MOVING


def note_squeezed(d, tolerated):
    """Note if a point that a rigid wall holds stays deeper in the wall than is ``tolerated`` [m]."""
    for k in range(d.touch.compliant_count, d.touch.active_count):
        if d.rigid.target[k] - d.rigid.reached[k] > tolerated:
            d.rigid.unsolved = SQUEEZED


def count_stalls(wrong, fewest, stalls_left):
    """Return the smallest number of wrong ones so far, and how many pivots may still fail to reduce it."""
    if wrong < fewest:
        return wrong, MAX_STALLED_PIVOTS
    return fewest, stalls_left - 1


def count_violations(d, scale):
    """Mark the candidates with p < 0 or u < target by more than round-off; return their number."""
    own, largest, wrong = d.rigid, 0.0, 0
    for k in range(d.touch.compliant_count, d.touch.active_count):
        largest = max(largest, abs(own.impulse[k]))
    for k in range(d.touch.compliant_count, d.touch.active_count):
        if own.in_active_set[k]:
            own.violated[k] = own.impulse[k] < -SIGN_TOLERANCE * largest
        else:
            own.violated[k] = own.reached[k] < own.target[k] - SIGN_TOLERANCE * scale
        wrong += own.violated[k]
    return wrong


def any_point_held(d):
    """Return whether rigid walls hold a point."""
    return d.touch.active_count > d.touch.compliant_count


def any_constraint(d):
    """Return whether rigid walls hold a point, or an element sticks by dry friction."""
    return any_point_held(d) or any_sticking(d)


def activate_all(d):
    """Put every contact without a force law and every sticking element into the active set, with target 0."""
    for k in range(d.touch.compliant_count):
        release(d, k)
    for k in range(d.touch.compliant_count, constraint_rows(d)):
        require(d, k, 0.0)


def require(d, k, target):
    """Put constraint k into the active set, with the least required value of its motion."""
    d.rigid.in_active_set[k] = 1
    d.rigid.target[k] = target


def release(d, k):
    """Take constraint k out of the active set."""
    d.rigid.in_active_set[k] = 0
