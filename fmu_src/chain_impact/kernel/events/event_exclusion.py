"""Clearances at the two ends of a step, and a test of them that excludes events without a search.

φ is the clearance of a candidate without contact, and the penetration of a candidate in contact; in contact
with a rigid wall φ is infinite. For the regularized contact φ is u, the root of the penetration over the
expected penetration (ode/sundman.py). φ′ and φ″ are the derivatives of φ in the integration variable of the
step, φ̇ and φ̈ those in time. δ is the penetration, and v₀ the latched speed in the law.
"""

import math

from chain_impact.kernel.chain.kinematics import accelerate_points, locate_points
from chain_impact.kernel.chain.prescribed_motion import fastest_wall, travel_of_piece
from chain_impact.kernel.constraints.geometry import clearance_acceleration, clearance_and_rate, length_bound
from chain_impact.kernel.ode.last_step import ensure_points, largest_turn
from chain_impact.kernel.ode.sundman import root_curvature, root_rate, time_rate_at
from chain_impact.kernel.ode.sundman_rate import regularized_time_rate_change
from chain_impact.kernel.record.constants import CURVATURES_KNOWN, DISTANCE_KNOWN, NOTHING_KNOWN
from chain_impact.kernel.record.method import is_regularized
from chain_impact.kernel.record.state import sundman_u_at

# [rad] If a link turns, or the phase of an input advances, by SMALL_TURN or more in an explicit step, the
# estimate of the interpolant's error is not valid, and the step is searched for events.
SMALL_TURN = 1.0
# In ``stays_positive``, the least Bernstein coefficient of a clearance or penetration must exceed the limit
# of the test by BERNSTEIN_MARGIN times the range of all coefficients. Without the margin, round-off or a
# wrong estimate of the interpolant's error could exclude an event that happens.
BERNSTEIN_MARGIN = 0.05
# The speed v₀ is latched at the onset of the contact. If the rate δ̇ of the penetration later exceeds
# RELATCH_RATIO times v₀, v₀ is multiplied by this ratio. In a usual impact gravity adds only a thousandth to
# δ̇, so v₀ stays. With the ratio 2, the force of a Hunt–Crossley law with the damping factor λ is at most
# about 1 + 2λ times the elastic part of the force.
RELATCH_RATIO = 2.0
# If the rate of the penetration exceeds NEARLY_FAST times the limit at an end of a step, the rate may exceed
# the limit inside the step, and the step is sampled. The limit is RELATCH_RATIO times the latched speed.
NEARLY_FAST = 0.75


def known_clearances(d):
    """Return how much is known of the clearances at the start of the searched step.

    The result is NOTHING_KNOWN if the sequence of steps has a break there (``step.break_count``), and
    `search.known_extent` otherwise.
    """
    return d.search.known_extent if d.search.known_at_break == d.step.break_count else NOTHING_KNOWN


def remember_clearances(d, extent):
    """Record the ``extent`` known of clearances at the last step's end, NOTHING_KNOWN to DISTANCE_KNOWN.

    The recorded value is valid until a break in the sequence of steps (``step.break_count``).
    """
    d.search.known_extent, d.search.known_at_break = extent, d.step.break_count


def excludes_events(d):
    """Return whether states and rates at the two ends of the last step exclude events of candidates.

    A release by rigid walls is not excluded. The test relies on an estimate of the interpolant's error, not
    on a bound. Before the call, the rate at the end of the step must be known, and the points located and
    accelerated there. If the result is false, the function has set φ and φ′ of all candidates at both ends of
    the step, and has chosen the candidates that the search examines.
    """
    # an input that changes with the angular frequency `input_rate` may change the acceleration in the step as
    # a rotating link does
    turn = max(largest_turn(d), (d.step.end - d.step.start) * d.search.input_rate)
    if turn < SMALL_TURN and remains_far(d):
        return True
    if known_clearances(d) != CURVATURES_KNOWN:
        locate_points(d, d.step.state)
        accelerate_points(d, d.step.state, d.scratch.rate_start)
        measure_all_candidates(d, d.step.state)
        ensure_points(d)
    begin_next_interval(d)
    for c in range(d.candidate_count):
        d.search.phi_start_curvature[c] = d.search.phi_end_curvature[c]
    measure_all_candidates(d, d.step.state_end)
    remember_clearances(d, CURVATURES_KNOWN)
    # The interpolant of a clearance φ has the error h⁶ φ⁽⁶⁾/46080, with the step size h. `error` is ten times
    # this for the tip of a stretched chain in uniform rotation. If the motion may decay or oscillate with a
    # rate ρ above the angular velocity of the rotation, |φ⁽⁶⁾| = ρ⁴ |φ̈| counts, with the φ̈ of the rotation.
    decay = (d.step.end - d.step.start) * d.chain.joint_rate_bound
    distance = distance_per_radian(d)
    if d.channel_count > 0:
        distance += travel_of_piece(d)
    turn_square, larger_square = turn * turn, max(turn, decay)
    larger_square *= larger_square
    error = distance * turn_square * (larger_square * larger_square) / 4608.0
    is_excluded, clearance_error = turn < SMALL_TURN, error + allowed_position_error(d)
    for c in range(d.candidate_count):
        # The loop has no branches, so that the compiler can use vector instructions: both conditions are
        # evaluated for all candidates. The second condition is true for every contact: contacts with a force
        # are tested below, and held points have no crossings.
        is_excluded = is_excluded & (stays_positive(d, c, clearance_error) | (d.contacts.active[c] != 0))
    for k in range(d.contacts.force_law_count):
        # ``error`` lacks the `allowed_position_error` of ``clearance_error``: errors of a penetration are far
        # smaller than those of a position
        c = d.contacts.active_index[k]
        is_excluded = is_excluded and stays_in_contact(d, c, error) and force_stays_smooth(d, c)
    if not is_excluded:
        if turn < SMALL_TURN:
            suspect_candidates_near(d, clearance_error, error)
        else:
            suspect_all_candidates(d)
    return is_excluded


def suspect_all_candidates(d):
    """Let the search examine all candidates."""
    d.search.suspect_count = d.candidate_count
    for c in range(d.candidate_count):
        d.search.suspect_index[c] = c


def suspect_candidates_near(d, clearance_error, penetration_error):
    """Let the search examine the candidates that the test at the step's ends does not exclude.

    Args:
        d: the instance, with φ, φ′ and φ″ at both ends.
        clearance_error: the error [m] of the clearances of candidates without contact.
        penetration_error: the error [m] of the penetrations of candidates in contact.
    """
    search, count = d.search, 0
    for c in range(d.candidate_count):
        if d.contacts.active[c]:
            is_suspect = not d.law.rigid[c] and not stays_in_contact(d, c, penetration_error)
        else:
            is_suspect = not stays_positive(d, c, clearance_error)
        if is_suspect:
            search.suspect_index[count] = c
            count += 1
    search.suspect_count = count


def allowed_position_error(d):
    """Return the largest error [m] that the tolerance allows in the position of any place.

    The dense output, which locates points for outputs and for the search, may differ by this error from the
    Hermite interpolant between the ends of the step.
    """
    return d.solver.tolerance * distance_per_radian(d)


def distance_per_radian(d):
    """Return a bound [m] of how far a place moves relative to the base, if no link turns by more than 1 rad.

    For a point or site the bound is `chain.reach`. For the place of a joint the bound is the largest change
    of the joint's angle, 2 rad, times the length of the longest link; this counts only if the scene has stops
    in joints and more than one link.
    """
    if d.chain.has_joint_stops and d.link_count > 1:
        return max(d.chain.reach, 2.0 * d.chain.longest_link)
    return d.chain.reach


def remains_far(d):
    """Return whether, by an estimate, the last step has no event that ``excludes_events`` excludes.

    The result is true only if all candidates without contact are far from touching, and no contact has a
    force law, except a regularized contact that lasts, keeps its latched speed v₀ and crosses no kink. If the
    result is true, DISTANCE_KNOWN is remembered. In any case, ``speed_bound``, ``acceleration_bound`` and
    ``safe_distance`` of ``search`` are updated.
    """
    step, search, duration = d.step, d.search, d.step.end - d.step.start
    speed, acceleration = search.speed_bound, search.acceleration_bound
    search.speed_bound = length_bound(d, d.scratch.velocity)
    search.acceleration_bound = length_bound(d, d.scratch.acceleration)
    if d.channel_count > 0:
        wall_speed, wall_acceleration = fastest_wall(d)
        search.speed_bound = search.speed_bound + wall_speed
        search.acceleration_bound = search.acceleration_bound + wall_acceleration
    # `distance` estimates how far any place moves relative to walls in the step, from the speeds and
    # accelerations at both ends; the acceleration counts double, as a margin
    distance = duration * (
        max(speed, search.speed_bound) + duration * max(acceleration, search.acceleration_bound)
    )
    search.safe_distance -= distance
    if not (known_clearances(d) >= CURVATURES_KNOWN and search.safe_distance > allowed_position_error(d)):
        return False
    if is_regularized(d):
        is_far = step.state_end[sundman_u_at(d.link_count)] > 0.0 and force_stays_smooth(
            d, step.regularized_candidate
        )
    else:
        is_far = d.contacts.force_law_count == 0
    if is_far:
        remember_clearances(d, DISTANCE_KNOWN)
    return is_far


def force_stays_smooth(d, c):
    """Return whether contact c surely keeps its latched speed v₀ and crosses no kink in the last step.

    This is an estimate (``may_relatch``). If the result is false, the step must be searched.
    """
    return not (d.contacts.kink_crossed[c] or may_relatch(d, c))


def may_relatch(d, c):
    """Return whether the penetration of contact c grows so fast that v₀ may be latched anew in the last step.

    The rate at the start of the step and the rate at the located points count.
    """
    _, clearance_rate = clearance_and_rate(d, c)
    return (
        max(d.contacts.penetration_rate[c], -clearance_rate)
        > NEARLY_FAST * RELATCH_RATIO * d.contacts.latched_speed[c]
    )


def stays_positive(d, c, error):
    """Return whether φ of candidate c surely exceeds ``error`` − ``harmless_depth`` [m] in the last step.

    φ is the clearance or, in contact, the penetration; the result has no meaning for the regularized contact.
    The value of φ at the start of the step is not tested. The test uses the quintic Hermite interpolant of φ,
    from φ, φ′ and φ″ at both ends; this interpolant is nowhere below the least Bernstein coefficient.
    """
    h = d.step.size
    b1 = d.search.phi_start[c] + h * d.search.phi_start_rate[c] / 5.0
    b2 = 2.0 * b1 - d.search.phi_start[c] + h * h * d.search.phi_start_curvature[c] / 20.0
    b4 = d.search.phi_end[c] - h * d.search.phi_end_rate[c] / 5.0
    b3 = 2.0 * b4 - d.search.phi_end[c] + h * h * d.search.phi_end_curvature[c] / 20.0
    least_b = min(b1, b2, b3, b4, d.search.phi_end[c])
    largest_b = max(b1, b2, b3, b4, d.search.phi_end[c])
    return least_b > BERNSTEIN_MARGIN * (largest_b - least_b) + error - d.law.harmless_depth[c]


def stays_in_contact(d, c, error):
    """Return whether the contact of candidate c surely lasts through the last step.

    The regularized contact lasts if u > 0 at the end of the step. Any other contact lasts if the penetration
    stays above ``error`` − ``harmless_depth`` [m] (``stays_positive``).
    """
    if c == d.step.regularized_candidate:
        # φ of a regularized contact is u. Only the end of the step is tested, because within one step with a
        # regularized contact the point cannot leave its wall and return to it.
        return d.search.phi_end[c] > 0.0
    return stays_positive(d, c, error)


def measure_all_candidates(d, y):
    """Set φ, φ′ and φ″ of every candidate for the state y, and ``search.safe_distance``.

    ``set_clearance`` describes φ; φ′ and φ″ are the derivatives of φ in the step's integration variable.
    ``search.safe_distance`` is the least clearance of the candidates without contact. The points must be
    located and accelerated for y.
    """
    slope = set_clearances(d, y)
    u = y[sundman_u_at(d.link_count)]
    p, rate_change = time_rate_at(d, u), regularized_time_rate_change(u, slope)
    least_clearance = math.inf
    for c in range(d.candidate_count):
        # derivatives of a clearance φ in the step's variable s, with p = dt/ds: φ′ = p φ̇, φ″ = p² φ̈ + p′ φ̇
        _, clearance_rate = clearance_and_rate(d, c)
        d.search.phi_end_curvature[c] = p * p * clearance_acceleration(d, c) + rate_change * clearance_rate
        least_clearance = min(least_clearance, math.inf if d.contacts.active[c] else d.search.phi_end[c])
    d.search.safe_distance = least_clearance
    for k in range(d.contacts.force_law_count):
        c = d.contacts.active_index[k]
        if c == d.step.regularized_candidate:
            d.search.phi_end_curvature[c] = root_curvature(d, d.search.phi_end[c], d.search.phi_end_rate[c])
        else:
            d.search.phi_end_curvature[c] = -d.search.phi_end_curvature[c]


def set_clearances(d, y):
    """Set φ and φ′ of every candidate for the state y; return u′ of the regularized contact, 0 without one.

    ``set_clearance`` describes φ, and ``sundman_u_now`` u′. The points must be located.
    """
    u, slope = sundman_u_now(d, y)
    p = time_rate_at(d, u)
    for c in range(d.candidate_count):
        # all candidates are first treated as without contact: a branch in this loop would cost more than
        # setting active contacts again below
        clearance, clearance_rate = clearance_and_rate(d, c)
        d.search.phi_end[c], d.search.phi_end_rate[c] = clearance, p * clearance_rate
    for k in range(d.contacts.active_count):
        set_clearance(d, d.contacts.active_index[k], u, slope)
    return slope


def sundman_u_now(d, y):
    """Return u (ode/sundman.py) of the regularized contact, and its rate u′, for the state y.

    u′ is the derivative in the step's integration variable. The points must be located for y. Without a
    regularized contact the results are 1 and 0.
    """
    if not is_regularized(d):
        return 1.0, 0.0
    u = y[sundman_u_at(d.link_count)]
    return u, root_rate(d, u)


def set_clearance(d, c, u, slope):
    """Set φ and φ′ of candidate c for the located points.

    φ is the clearance of a candidate without contact, and the penetration of a candidate in contact, with two
    exceptions: for the regularized contact φ is ``u``, and φ′ is ``slope`` = u′ (``sundman_u_now``); for a
    contact at a rigid wall φ is infinite, and φ′ is 0. φ′ is the rate in the step's integration variable.
    """
    if c == d.step.regularized_candidate:
        d.search.phi_end[c], d.search.phi_end_rate[c] = u, slope
        return
    if d.contacts.active[c] and d.law.rigid[c]:
        # φ of a held candidate must not fall to zero in the search, because its point is already at the
        # wall; an event RELEASE (record/constants.py) ends it
        d.search.phi_end[c], d.search.phi_end_rate[c] = math.inf, 0.0
        return
    clearance, clearance_rate = clearance_and_rate(d, c)
    sign = -1.0 if d.contacts.active[c] else 1.0
    d.search.phi_end[c] = sign * clearance
    d.search.phi_end_rate[c] = sign * time_rate_at(d, u) * clearance_rate


def begin_next_interval(d):
    """Copy φ and φ′ of all candidates from the end of an interval to the start of the next interval."""
    for c in range(d.candidate_count):
        d.search.phi_start[c] = d.search.phi_end[c]
        d.search.phi_start_rate[c] = d.search.phi_end_rate[c]
