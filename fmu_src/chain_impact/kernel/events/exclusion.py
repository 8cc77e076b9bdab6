"""Clearances over a step, and a test on its ends that excludes events in it without a search.

φ is the clearance of a candidate that is apart and the penetration of one in contact, or u of the Sundman
regularization (integration/sundman.py) for the regularized one, each as a function of the integration
variable of the step; φ′ and φ″ are its derivatives.
"""

import math

from chain_impact.kernel.chain.kinematics import accelerate_points, locate_points
from chain_impact.kernel.chain.state import sundman_u_at
from chain_impact.kernel.integration.last_step import ensure_points, largest_turn
from chain_impact.kernel.integration.method import IMPLICIT
from chain_impact.kernel.integration.sundman import (
    NO_CONTACT,
    root_curve,
    root_rate,
    time_rate_change,
    time_rate_of,
)
from chain_impact.kernel.model.geometry import clearance, gap_acceleration

# rad. If a link turns more in a step, the estimated remainder of the interpolant is no bound any more.
SMALL_TURN = 1.0
# Fraction of the range of the Bernstein coefficients: a margin for round-off and the estimated remainder.
MARGIN = 0.05
# δ̇/v₀ at which v₀, latched (fixed) at the onset of the contact, is latched again. Gravity adds a thousandth
# after the onset of an impact; at 2 the usual laws have at most 1 + 2λ times their elastic force.
RELATCH_RATIO = 2.0
NEARLY = 0.75  # fraction of that speed: if exceeded at an end of a step, its inside is sampled too


def forget_clearances(d):
    """Note that φ, φ′ and φ″ at the end of the last step are not known."""
    d.search.known_for = -1


def excludes_events(d):
    """Whether φ, φ′ and φ″ at the ends of the last step show that there is no event in it.

    If the result is false, the suspects are listed: all candidates if the method does not provide the rate at
    the end of the step, or a link turns too far.
    """
    search, step = d.search, d.step
    if step.last_method == IMPLICIT:
        forget_clearances(d)
        list_suspects(d, math.inf, math.inf)
        return False
    if search.known_for != step.breaks:
        locate_points(d, step.state)
        accelerate_points(d, step.state, d.work.rate_start)
        measure_all(d, step.state)
    ensure_points(d)
    for c in range(d.candidates):
        search.clear_start_curve[c] = search.clear_end_curve[c]
    keep_start(d)
    measure_all(d, step.state_end)
    error, leeway = errors(d)
    clear, apart = error < math.inf, error + leeway
    for c in range(d.candidates):
        # Without branches the compiler can use vectors. Of a point that a rigid wall holds φ is ∞, and the
        # second term decides.
        clear = clear & (stays_positive(d, c, apart) | (d.touch.active[c] != 0))
    for k in range(d.touch.compliant_count):
        # the scale of errors in a penetration is far below that of a position
        c = d.touch.active_index[k]
        clear = clear and stays_in_contact(d, c, error) and is_quiet(d, c)
    search.known_for = step.breaks if clear else -1  # the search changes them
    if not clear:
        list_suspects(d, apart, error)
    return clear


def errors(d):
    """By how much [m] φ may differ from its Hermite interpolant over the last step, and positions from φ.

    The remainder is h⁶ φ⁽⁶⁾/46080; ten times that of the tip of a stretched chain in uniform rotation, and
    that of a motion which decays or oscillates with the rate ρ, |φ⁽⁶⁾| = ρ⁴ |φ̈|; ∞ if a link turns too far.
    The dense output, by which outputs and the search locate a point, may err by the tolerance.
    """
    lasted = d.step.end - d.step.start
    # an input may change the acceleration between the ends as much as rotation does
    turn = max(largest_turn(d), lasted * d.inputs.course.change_rate)
    # the way of a place [m] per radian of every link; a stop has a lever arm, and a joint two links
    way = max(d.model.reach, 2.0 * d.model.size) if d.model.stopped else d.model.reach
    error = way * turn**2 * max(turn, lasted * d.model.joint_bound) ** 4 / 4608.0
    return error if turn < SMALL_TURN else math.inf, d.solver.tolerance * way


def list_suspects(d, apart, error):
    """List the candidates whose φ may fall to zero, with these errors [m] where they are apart and touch."""
    search, count = d.search, 0
    for c in range(d.candidates):
        if d.touch.active[c]:
            suspected = not d.law.impulsive[c] and not stays_in_contact(d, c, error)
        else:
            suspected = not stays_positive(d, c, apart)
        if suspected:
            search.suspect[count] = c
            count += 1
    search.suspect_count = count


def is_quiet(d, c):
    """Whether contact c has not crossed its kink in the last step, and its v₀ cannot need a new value."""
    return not (d.touch.kink_crossed[c] or nearly_fast(d, c))


def nearly_fast(d, c):
    """Whether contact c is compressed so fast at an end of the last step that its v₀ may need a new value."""
    _, gap_rate = clearance(d, c)
    return max(d.touch.speed[c], -gap_rate) > NEARLY * RELATCH_RATIO * d.touch.impact_speed[c]


def stays_positive(d, c, error):
    """Whether φ of candidate c is larger than an error throughout the last step, after its start.

    The quintic Hermite interpolant of φ, from its value and first two derivatives at the ends of the step,
    stays above the least of its Bernstein coefficients.
    """
    h = d.step.size
    b1 = d.search.clear_start[c] + h * d.search.clear_start_rate[c] / 5.0
    b2 = 2.0 * b1 - d.search.clear_start[c] + h * h * d.search.clear_start_curve[c] / 20.0
    b4 = d.search.clear_end[c] - h * d.search.clear_end_rate[c] / 5.0
    b3 = 2.0 * b4 - d.search.clear_end[c] + h * h * d.search.clear_end_curve[c] / 20.0
    least = min(b1, b2, b3, b4, d.search.clear_end[c])
    most = max(b1, b2, b3, b4, d.search.clear_end[c])
    return least > MARGIN * (most - least) + error - d.law.harmless_depth[c]


def stays_in_contact(d, c, error):
    """As ``stays_positive``, for the penetration of a contact with a force law, or for u."""
    if c == d.step.regularized:
        # δ̇ would have to change its sign twice for u to fall to zero and rise again
        return d.search.clear_end[c] > 0.0
    return stays_positive(d, c, error)


def measure_all(d, y):
    """Set φ, φ′ and φ″ of every candidate for a state and its located and accelerated points."""
    u, slope = sundman_u_now(d, y)
    p, change = time_rate_of(d, u), time_rate_change(u, slope)
    for c in range(d.candidates):
        # as if all were apart: a branch in this loop would take longer than to set a few of them again
        gap, gap_rate = clearance(d, c)
        d.search.clear_end[c], d.search.clear_end_rate[c] = gap, p * gap_rate
        # φ′ = p φ̇,  φ″ = p² φ̈ + p′ φ̇
        d.search.clear_end_curve[c] = p * p * gap_acceleration(d, c) + change * gap_rate
    for k in range(d.touch.active_count):
        c = d.touch.active_index[k]
        set_clearance(d, c, u, slope)
        d.search.clear_end_curve[c] *= -1.0
        if c == d.step.regularized:
            d.search.clear_end_curve[c] = root_curve(d, u, slope)


def sundman_u_now(d, y):
    """Evaluate u and u′ of the regularized contact for a state y and its located points; without one 1, 0."""
    if d.step.regularized == NO_CONTACT:
        return 1.0, 0.0
    u = y[sundman_u_at(d.links)]
    return u, root_rate(d, u)


def set_clearance(d, c, u, slope):
    """Set φ and φ′ of candidate c for the located points, u and u′."""
    if c == d.step.regularized:
        d.search.clear_end[c], d.search.clear_end_rate[c] = u, slope
        return
    if d.touch.active[c] and d.law.impulsive[c]:
        # held at a rigid wall: it can neither touch nor cross
        d.search.clear_end[c], d.search.clear_end_rate[c] = math.inf, 0.0
        return
    gap, gap_rate = clearance(d, c)
    sign = -1.0 if d.touch.active[c] else 1.0
    d.search.clear_end[c] = sign * gap
    d.search.clear_end_rate[c] = sign * time_rate_of(d, u) * gap_rate


def keep_start(d):
    """Copy φ and φ′ at the end of the interval to the start of the next one."""
    for c in range(d.candidates):
        d.search.clear_start[c] = d.search.clear_end[c]
        d.search.clear_start_rate[c] = d.search.clear_end_rate[c]
