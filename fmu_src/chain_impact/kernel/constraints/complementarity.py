"""Impulses at rigid walls that only push: a search for the active set of the equality problem.

The problem, with impulses p and motions u, is p ≥ 0, u ≥ target, p·(u − target) = 0. For a given active set,
``solve_equality`` in impulses.py solves its equations.
"""

from chain_impact.kernel.constraints.impulses import (
    SIGN_TOLERANCE,
    add_to_active_set,
    note_forces_not_found,
    remove_from_active_set,
    solve_equality,
)
from chain_impact.kernel.cost import is_cost_exceeded

# The number of successive pivots that may leave the least number of violations unchanged. After one more such
# pivot, each pivot changes a single candidate until that number falls; this ends, but slowly (``solve_lcp``).
MAX_STALLED_PIVOTS = 3
# the largest number of pivots, in addition to 4 for each constraint; a search that needs more has failed
EXTRA_PIVOTS = 30


def solve_lcp(d, scale):
    """Find impulses p ≥ 0 and motions u ≥ target with p·(u − target) = 0, at points that rigid walls hold.

    Block principal pivoting (after Júdice & Pires 1994, Comput Oper Res 21:587) begins with the active set in
    ``in_active_set``. Candidates with p < 0 leave the set, and those with u < target enter it: all at once
    or, beyond MAX_STALLED_PIVOTS, only that of highest index; this search ends if the mobility W is positive
    definite (Murty 1974, Linear Algebra Appl 9:65). If the search reaches its largest number of pivots, the
    problem is recorded as unsolved; if the cost exceeds its limit, the search just ends. ``d.constraints``
    has the problem and gets the results, and ``scale`` is the scale of round-off, as in ``solve_equality``.
    """
    constraints, first = d.constraints, d.contacts.force_law_count
    count = d.contacts.active_count - first
    fewest, stalls_left = count + 1, MAX_STALLED_PIVOTS
    for _ in range(EXTRA_PIVOTS + 4 * count):
        solve_equality(d, scale)
        violation_count = count_violations(d, scale)
        if violation_count == 0 or is_cost_exceeded(d):
            return
        fewest, stalls_left = count_stalls(violation_count, fewest, stalls_left)
        for i in range(count):
            k = first + count - 1 - i
            if constraints.is_violated[k]:
                if constraints.in_active_set[k]:
                    remove_from_active_set(d, k)
                else:
                    add_to_active_set(d, k, constraints.target_motion[k])
                if stalls_left < 0:
                    break
    note_forces_not_found(d)


def count_stalls(violation_count, fewest, stalls_left):
    """Return the least number of violations so far, and how many pivots may still fail to reduce it.

    The second result is < 0 if one pivot too many has failed.
    """
    if violation_count < fewest:
        return violation_count, MAX_STALLED_PIVOTS
    return fewest, stalls_left - 1


def count_violations(d, scale):
    """Mark the violations of rigid walls in ``is_violated``, and return their number.

    A violation is an impulse < 0 in the active set, or a motion < target outside it, beyond round-off.
    ``scale`` is the largest motion of any point, to which the round-off of motions is relative.
    """
    constraints, largest, violation_count = d.constraints, 0.0, 0
    for k in range(d.contacts.force_law_count, d.contacts.active_count):
        largest = max(largest, abs(constraints.impulse[k]))
    for k in range(d.contacts.force_law_count, d.contacts.active_count):
        if constraints.in_active_set[k]:
            constraints.is_violated[k] = constraints.impulse[k] < -SIGN_TOLERANCE * largest
        else:
            constraints.is_violated[k] = (
                constraints.reached_motion[k] < constraints.target_motion[k] - SIGN_TOLERANCE * scale
            )
        violation_count += constraints.is_violated[k]
    return violation_count
