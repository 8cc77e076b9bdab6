"""Clearances at the two ends of a step, and a test of these that excludes events without a search.

φ is the clearance of a candidate without contact, and the penetration of a candidate in contact. For the
regularized contact φ is u, the root of the relative penetration (ode/sundman.py). φ is a function of the
integration variable of the step, with the derivatives φ′ and φ″; φ̇ and φ̈ are its derivatives in time. δ is
the penetration, and v₀ the impact speed of the law.
"""

import math

from chain_impact.kernel.chain.kinematics import accelerate_points, locate_points
from chain_impact.kernel.chain.motion import fastest_wall, travel_of_piece
from chain_impact.kernel.chain.signals import rate_of_signals
from chain_impact.kernel.chain.state import sundman_u_at
from chain_impact.kernel.ode.last_step import ensure_points, largest_turn
from chain_impact.kernel.ode.sundman import NO_CONTACT, root_curve, root_rate, time_rate_change, time_rate_of
from chain_impact.kernel.rows.geometry import clearance, gap_acceleration, length_bound

# [rad] The largest turn of a link in a step for which the estimate of the interpolant's remainder is valid.
SMALL_TURN = 1.0
# The margin for round-off and for the estimated remainder, relative to the range of the Bernstein
# coefficients of φ. Without the margin, the test could exclude an event that happens.
BERNSTEIN_MARGIN = 0.05
# The ratio of the rate δ̇ of the penetration to the impact speed v₀ at which v₀ is latched (fixed) again,
# after it was latched at the onset of the contact. In a usual impact gravity adds only a thousandth to δ̇, so
# that v₀ stays. With the ratio 2 a Hunt–Crossley law with the damping λ never has more than 1 + 2λ times its
# elastic force.
RELATCH_RATIO = 2.0
# The part of RELATCH_RATIO times the impact speed. If the rate of the penetration exceeds this part at an end
# of a step, the search also samples the inside of the step.
NEARLY_FAST = 0.75


# values of `search.known`: which data of the clearances are known at the end of the last step. NOTHING: none;
# VALUES: the clearances and their rates, φ and φ′; WITH_CURVES: also φ″; FAR: only that every candidate
# without contact has a clearance of at least `search.safe_distance`
NOTHING, VALUES, WITH_CURVES, FAR = 0, 1, 2, 3


def known_clearances(d):
    """Return which data of the clearances are known at the start of the step that is searched."""
    return d.search.known if d.search.known_for == d.step.breaks else NOTHING


def remember_clearances(d, extent):
    """Record which data of the clearances are known at the end of the last step.

    The record is valid until a break in the sequence of steps (``step.breaks``).
    """
    d.search.known, d.search.known_for = extent, d.step.breaks


def excludes_events(d):
    """Return whether the states and rates at the ends of the last step exclude events of all candidates.

    The test relies on an estimate of the interpolant's remainder, not on a bound. The step's method must
    provide the rate at the end; the points are located and accelerated at the end. If the result is false,
    the clearances φ and their rates φ′ of all candidates are known at both ends, and the suspects are chosen.
    """
    # an input with this angular frequency may change the acceleration in the step as a rotating link does
    changing = max(d.inputs.piece.change_rate, rate_of_signals(d))
    turn = max(largest_turn(d), (d.step.end - d.step.start) * changing)
    if turn < SMALL_TURN and remains_far(d):
        return True
    if known_clearances(d) != WITH_CURVES:
        locate_points(d, d.step.state)
        accelerate_points(d, d.step.state, d.scratch.rate_start)
        measure_all(d, d.step.state)
        ensure_points(d)
    begin_next_interval(d)
    for c in range(d.candidates):
        d.search.phi_start_curve[c] = d.search.phi_end_curve[c]
    measure_all(d, d.step.state_end)
    remember_clearances(d, WITH_CURVES)
    # The remainder of the interpolant of a clearance φ is h⁶ φ⁽⁶⁾/46080, with the step size h. Its estimate
    # is ten times the remainder for the tip of a stretched chain in uniform rotation or, if larger, for a
    # motion that decays or oscillates with the rate ρ: |φ⁽⁶⁾| = ρ⁴ |φ̈|, with φ̈ of the rotation.
    fade = (d.step.end - d.step.start) * d.chain.joint_rate_bound
    way = distance_per_radian(d)
    if d.channels > 0:
        way += travel_of_piece(d)
    turns, larger = turn * turn, max(turn, fade)
    larger *= larger
    error = way * turns * (larger * larger) / 4608.0
    clear, apart = turn < SMALL_TURN, error + allowed_position_error(d)
    for c in range(d.candidates):
        # Without branches the compiler can use vector instructions, so both conditions are evaluated for all
        # candidates. The second condition is true for every contact: contacts with a force are tested below,
        # and held points have no crossings.
        clear = clear & (stays_positive(d, c, apart) | (d.touch.active[c] != 0))
    for k in range(d.touch.compliant_count):
        # without `allowed_position_error`, because the errors of a penetration are far smaller than those of
        # a position
        c = d.touch.active_index[k]
        clear = clear and stays_in_contact(d, c, error) and force_stays_smooth(d, c)
    if not clear:
        if turn < SMALL_TURN:
            suspect_some(d, apart, error)
        else:
            suspect_all(d)
    return clear


def suspect_all(d):
    """Let the search examine all candidates."""
    d.search.suspect_count = d.candidates
    for c in range(d.candidates):
        d.search.suspect[c] = c


def suspect_some(d, apart, error):
    """Let the search examine the candidates for which the test at the step's ends does not exclude events.

    Args:
        d: the instance, with the clearances φ and their derivatives φ′ and φ″ at both ends.
        apart: the error [m] of the clearances of candidates without contact.
        error: the error [m] of the penetrations of candidates in contact.
    """
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


def allowed_position_error(d):
    """Return the largest error [m] that the tolerance allows in the position of any place.

    The dense output, which locates points for outputs and for the search, may differ by this error from the
    Hermite interpolant between the ends of the step.
    """
    return d.solver.tolerance * distance_per_radian(d)


def distance_per_radian(d):
    """Return the largest distance [m] that a place moves when every link turns by at most 1 rad.

    For a point this distance is the length of the stretched chain. For the place of a joint with stops this
    distance is the relative angle, at most 2 rad, times the length of the longest link; it is larger than the
    chain if this link is longer than all other links together.
    """
    if d.chain.has_joint_stops and d.links > 1:
        return max(d.chain.reach, 2.0 * d.chain.longest_link)
    return d.chain.reach


def remains_far(d):
    """Return whether no candidate can have touched, and no contact with a force can have an event.

    If a contact has a force, it must be the regularized contact.
    """
    step, search, lasted = d.step, d.search, d.step.end - d.step.start
    speed, acceleration = search.speed, search.acceleration
    search.speed = length_bound(d, d.scratch.velocity)
    search.acceleration = length_bound(d, d.scratch.acceleration)
    if d.channels > 0:
        rate, rate_change = fastest_wall(d)
        search.speed, search.acceleration = search.speed + rate, search.acceleration + rate_change
    # way: a bound on the distance that any point moves in the step; the acceleration counts double, as a
    # margin
    way = lasted * (max(speed, search.speed) + lasted * max(acceleration, search.acceleration))
    search.safe_distance -= way
    if not (known_clearances(d) >= WITH_CURVES and search.safe_distance > allowed_position_error(d)):
        return False
    if step.regularized == NO_CONTACT:
        far = d.touch.compliant_count == 0
    else:
        far = step.state_end[sundman_u_at(d.links)] > 0.0 and force_stays_smooth(d, step.regularized)
    if far:
        remember_clearances(d, FAR)
    return far


def force_stays_smooth(d, c):
    """Return whether contact c keeps its impact speed, and its force has no kink, in the whole last step."""
    return not (d.touch.kink_crossed[c] or nearly_fast(d, c))


def nearly_fast(d, c):
    """Return whether δ̇ of contact c is so large at an end of the step that v₀ may be latched again.

    δ̇ is the rate of the penetration, and v₀ the impact speed.
    """
    _, gap_rate = clearance(d, c)
    return max(d.touch.speed[c], -gap_rate) > NEARLY_FAST * RELATCH_RATIO * d.touch.impact_speed[c]


def stays_positive(d, c, error):
    """Return whether φ of candidate c surely exceeds ``error`` − ``harmless_depth`` in the last step.

    φ is the clearance, or the penetration of a contact; the value of φ at the start does not count. The
    quintic Hermite interpolant of φ, from the value and first two derivatives at the ends of the step, is at
    least the smallest Bernstein coefficient.
    """
    h = d.step.size
    b1 = d.search.phi_start[c] + h * d.search.phi_start_rate[c] / 5.0
    b2 = 2.0 * b1 - d.search.phi_start[c] + h * h * d.search.phi_start_curve[c] / 20.0
    b4 = d.search.phi_end[c] - h * d.search.phi_end_rate[c] / 5.0
    b3 = 2.0 * b4 - d.search.phi_end[c] + h * h * d.search.phi_end_curve[c] / 20.0
    least = min(b1, b2, b3, b4, d.search.phi_end[c])
    most = max(b1, b2, b3, b4, d.search.phi_end[c])
    return least > BERNSTEIN_MARGIN * (most - least) + error - d.law.harmless_depth[c]


def stays_in_contact(d, c, error):
    """Return whether a contact surely lasts through the last step.

    Its penetration stays above ``error`` (``stays_positive``) or, if it is regularized, u > 0 at the end.
    """
    if c == d.step.regularized:
        # u = √(δ/δ*) does not fall to zero and rise again in a step: the rate δ̇ of the penetration would
        # have to change its sign twice
        return d.search.phi_end[c] > 0.0
    return stays_positive(d, c, error)


def measure_all(d, y):
    """Set every candidate's clearance φ and its derivatives φ′ and φ″ for the state y.

    The points must be located and accelerated.
    """
    slope = set_clearances(d, y)
    u = y[sundman_u_at(d.links)]
    p, change = time_rate_of(d, u), time_rate_change(u, slope)
    least = math.inf
    for c in range(d.candidates):
        # derivatives in the step's variable, with p = dt/ds: φ′ = p φ̇, φ″ = p² φ̈ + p′ φ̇
        _, gap_rate = clearance(d, c)
        d.search.phi_end_curve[c] = p * p * gap_acceleration(d, c) + change * gap_rate
        least = min(least, math.inf if d.touch.active[c] else d.search.phi_end[c])
    d.search.safe_distance = least
    for k in range(d.touch.compliant_count):
        c = d.touch.active_index[k]
        if c == d.step.regularized:
            d.search.phi_end_curve[c] = root_curve(d, d.search.phi_end[c], d.search.phi_end_rate[c])
        else:
            d.search.phi_end_curve[c] = -d.search.phi_end_curve[c]


def set_clearances(d, y):
    """Set the clearance φ and its rate φ′ of every candidate for the state y; return u′.

    The points must be located. u′ belongs to the regularized contact.
    """
    u, slope = sundman_u_now(d, y)
    p = time_rate_of(d, u)
    for c in range(d.candidates):
        # first as if all candidates were without contact: a branch in this loop would cost more than to set
        # active contacts again below
        gap, gap_rate = clearance(d, c)
        d.search.phi_end[c], d.search.phi_end_rate[c] = gap, p * gap_rate
    for k in range(d.touch.active_count):
        set_clearance(d, d.touch.active_index[k], u, slope)
    return slope


def sundman_u_now(d, y):
    """Return u, the root of the penetration, and u′ of the regularized contact for the state y.

    The points must be located. Without a regularized contact the results are 1 and 0.
    """
    if d.step.regularized == NO_CONTACT:
        return 1.0, 0.0
    u = y[sundman_u_at(d.links)]
    return u, root_rate(d, u)


def set_clearance(d, c, u, slope):
    """Set the clearance φ and its rate φ′ of candidate c for the located points.

    The arguments ``u`` and ``slope`` = u′ are those of the regularized contact.
    """
    if c == d.step.regularized:
        d.search.phi_end[c], d.search.phi_end_rate[c] = u, slope
        return
    if d.touch.active[c] and d.law.impulsive[c]:
        # a held point has no crossing: it is already at the wall, and its contact ends by marks.RELEASE
        d.search.phi_end[c], d.search.phi_end_rate[c] = math.inf, 0.0
        return
    gap, gap_rate = clearance(d, c)
    sign = -1.0 if d.touch.active[c] else 1.0
    d.search.phi_end[c] = sign * gap
    d.search.phi_end_rate[c] = sign * time_rate_of(d, u) * gap_rate


def begin_next_interval(d):
    """Copy the clearances φ and their rates φ′ from the end of an interval to the start of the next one."""
    for c in range(d.candidates):
        d.search.phi_start[c] = d.search.phi_end[c]
        d.search.phi_start_rate[c] = d.search.phi_end_rate[c]
