"""The first time in a step at which a function of the motion falls through zero, by bounds or by samples.

The search by bounds is for a function φ of each candidate. Without contact, φ is the clearance g. In contact,
φ is the penetration, u (record/state.py) of the regularized contact, or infinite at a rigid wall. φ′ and φ″
are derivatives of φ in the integration variable of the step, and θ is a fraction of the step. The zero of φ
is located on the dense output of the step. A suspect is a candidate that the search examines: after an
implicit step each candidate, else a candidate of which the test in event_exclusion.py does not exclude an
event.

If only the signs of φ at both ends of a step were compared, a point that dips into a wall and returns would
be missed. So a bound |φ″| ≤ A over an interval of width w is used. By this bound, φ stays above its chord
minus A w²/8. And φ′ does not change sign in the interval from a to b if φ′_a and φ′_b have the same sign and
|φ′_a| + |φ′_b| > A w. If neither condition decides whether an interval has an event, the interval is halved,
unless φ is linear up to round-off there.
"""

import math

from chain_impact.kernel.chain import prescribed_motion
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.chain.sites import site_of_point
from chain_impact.kernel.constraints.geometry import is_at_joint_stop, is_at_wall, normal_row
from chain_impact.kernel.cost import count_other_cost, is_cost_exceeded
from chain_impact.kernel.events.event_exclusion import begin_next_interval, set_clearance, sundman_u_now
from chain_impact.kernel.events.marks import mark_contact_event
from chain_impact.kernel.mathematics.root_search import MOST_GUESSES, next_guess
from chain_impact.kernel.ode.collocation import bound_curvatures
from chain_impact.kernel.ode.dense_output import interpolate_state, rate_bounds, rate_bounds_along
from chain_impact.kernel.ode.last_step import ensure_dense
from chain_impact.kernel.record.constants import (
    CONTACT_ENDS,
    NO_EVENT,
    ONSET,
    SOLVER_READER,
)
from chain_impact.kernel.record.method import is_regularized, was_implicit
from chain_impact.kernel.record.state import omega_at, sundman_u_at, velocity_at


def locate_at_fraction(d, theta):
    """Set ``scratch.state`` to the state at θ of the last step, 0 ≤ θ ≤ 1, and locate the points there."""
    count_other_cost(d, 1)
    if 0.0 < theta < 1.0:
        ensure_dense(d, SOLVER_READER)
        interpolate_state(d.step, theta, d.scratch.state)
    else:
        for j in range(len(d.scratch.state)):
            d.scratch.state[j] = d.step.state[j] if theta == 0.0 else d.step.state_end[j]
    locate_points(d, d.scratch.state)


# An interval in which the clearance or penetration φ can deviate from its chord by less than
# CROSSING_RESOLUTION, relative to the longest link, is not halved: such a deviation is round-off.
CROSSING_RESOLUTION = 1e-15
# A point skims a wall, that is, it moves along the wall, if its clearance φ and the change of φ in an
# interval are below SKIMMING_CLEARANCE, relative to the longest link. Example: a point of a link that lies
# along a wall.
SKIMMING_CLEARANCE = 1e-13
# For a point that skims a wall, an interval of at most FINE_INTERVAL times the step is not halved.
FINE_INTERVAL = 2.0**-8
# [s] Events within SIMULTANEOUS_TIME count as simultaneous: symmetric chains touch at several points at once,
# up to round-off.
SIMULTANEOUS_TIME = 1e-12
QUIET, SPLIT, CROSSES = 0, 1, 2  # results of ``check_candidate``


def find_crossing(d):
    """Return the fraction θ of the last step at which a suspect's contact first begins or ends, or −1.

    The result is −1 if no suspect's contact begins or ends, or if the cost exceeds the limit. The candidates
    with an event at θ are marked. Before the call no candidate may be marked, and φ and φ′ at the step's
    start must be set.
    """
    a, b = 0.0, 1.0
    while not is_cost_exceeded(d):
        measure_clearances(d, b)
        verdict = check_interval(d, a, b)
        if verdict == SPLIT:
            b = 0.5 * (a + b)
        elif verdict == CROSSES:
            return locate_crossing(d, a, b)
        elif b == 1.0:
            return -1.0
        else:
            begin_next_interval(d)
            # the next interval begins at b: the widest interval that repeated halving of the step gives there
            a, width = b, b - a
            while a + width < 1.0 and math.floor(0.5 * a / width) == 0.5 * a / width:
                width *= 2.0
            b = min(1.0, a + width)
    return -1.0  # the cost exceeds the limit, which ends the run after this step


def check_interval(d, a, b):
    """Return SPLIT if any suspect needs a shorter interval than (a, b], else CROSSES or QUIET.

    CROSSES: a suspect has an event in the interval; QUIET: no suspect has an event there.
    """
    verdict = QUIET
    for k in range(d.search.suspect_count):
        outcome = check_candidate(d, d.search.suspect_index[k], a, b)
        if outcome == SPLIT:
            return SPLIT
        verdict = max(verdict, outcome)
    return verdict


def check_candidate(d, c, a, b):
    """Return whether candidate c has an event in the interval (a, b] of the step; a and b are fractions.

    Returns:
        QUIET: there is no event; CROSSES: the clearance or, in contact, the penetration falls through zero;
        SPLIT: the interval is too long to decide.
    """
    width = (b - a) * d.step.size
    start, end = d.search.phi_start[c], d.search.phi_end[c]
    if c == d.step.regularized_candidate:
        # the sign of u at the end decides: within one step of a regularized contact, a point does not leave
        # its wall and return to this wall
        return CROSSES if end < 0.0 else QUIET
    rate_start, rate_end = d.search.phi_start_rate[c], d.search.phi_end_rate[c]
    curvature = d.search.curvature[c]
    sag, harmless = curvature * width * width / 8.0, d.law.harmless_depth[c]
    # An event needs a clearance or, in contact, a penetration φ < 0 at the end b of the interval. If b is the
    # end of the step, or if the point is in contact, an event needs φ < −`harmless`, because a point that is
    # beyond zero by less than `harmless` may turn back.
    near = b == 1.0 or d.contacts.active[c]
    falls = end < (-harmless if near else 0.0) and rate_end < 0.0
    if start > sag - harmless and end > sag - harmless and not falls:
        return QUIET
    is_monotonic = rate_start * rate_end > 0.0 and abs(rate_start) + abs(rate_end) > curvature * width
    # `not sag >= …` is true for a NaN; with `sag < …` the interval would be halved until the cost exceeds its
    # limit
    if (
        is_monotonic
        or not sag >= CROSSING_RESOLUTION * d.chain.longest_link
        or (b - a <= FINE_INTERVAL and skims_wall(d, c, width))
    ):
        # A point without contact has an onset if its clearance φ begins at −`harmless` or above and ends
        # below −`harmless`, even if φ does not fall at the end: at a loose tolerance the interpolant can
        # put a point deep inside a wall although the point does not move inward. A point in contact has an
        # event only if φ, here its penetration, falls: a point that moves inward has not left the wall,
        # even where the interpolant of a stiff step puts it outside.
        return CROSSES if falls or (end < -harmless <= start and not d.contacts.active[c]) else QUIET
    return SPLIT


def skims_wall(d, c, width):
    """Return whether the point of candidate c moves along the wall in an interval of the ``width`` [s].

    This is so if the clearance and its change are below SKIMMING_CLEARANCE, relative to the longest link.
    """
    search = d.search
    distance = width * max(abs(search.phi_start_rate[c]), abs(search.phi_end_rate[c]))
    return (
        max(abs(search.phi_start[c]), abs(search.phi_end[c]), distance)
        < SKIMMING_CLEARANCE * d.chain.longest_link
    )


def is_nearly_linear(d, c, part):
    """Return whether φ of candidate c is linear, up to round-off, in an interval of the step.

    ``part`` is the length of the interval, as a fraction of the step.
    """
    width = part * d.step.size
    return not d.search.curvature[c] * width * width / 8.0 >= CROSSING_RESOLUTION * d.chain.longest_link


def locate_crossing(d, a, b):
    """Return θ in [a, b] of the earliest event, and mark the candidates that have an event at this time.

    ``check_interval`` must have returned CROSSES for this interval. Events count as simultaneous up to
    SIMULTANEOUS_TIME and round-off.
    """
    first, candidate = b, -1
    for k in range(d.search.suspect_count):
        c = d.search.suspect_index[k]
        kind = CONTACT_ENDS if d.contacts.active[c] else ONSET
        mark_contact_event(d, c, kind if check_candidate(d, c, a, b) == CROSSES else NO_EVENT)
    for k in range(d.search.suspect_count):
        c = d.search.suspect_index[k]
        # `first` is the earliest event so far; φ of all suspects (set_clearance) is known there, and a
        # candidate with φ ≥ 0 there has its event later
        if d.contacts.event[c] and d.search.phi_end[c] < 0.0:
            first = find_root(d, c, a, first)
            candidate = c
    simultaneous_time = SIMULTANEOUS_TIME + 4e-16 * abs(d.step.end)
    for k in range(d.search.suspect_count):
        c = d.search.suspect_index[k]
        # The last ``candidate`` whose φ was located stays marked, because round-off alone may put the φ of a
        # slow point above the limit.
        if c != candidate and d.search.phi_end[c] > simultaneous_time * abs(d.search.phi_end_rate[c]):
            mark_contact_event(d, c, NO_EVENT)
    return first


def find_root(d, c, a, b):
    """Return θ in [a, b] at which φ of candidate c falls through zero; φ must be negative at b.

    φ is the clearance; in contact the penetration, or u of the regularized contact. φ and φ′ must be set at a
    and b. The function also sets φ and φ′ of all suspects at the resulting θ.

    θ is found by Newton's method inside a shrinking interval around the root. If φ ≤ 0 at a, two cases need
    no iteration. If φ does not rise at a, the result is a. If φ rises at a and is linear in [a, b] up to
    round-off, the result is b.
    """
    if d.search.phi_start[c] <= 0.0 and (d.search.phi_start_rate[c] <= 0.0 or is_nearly_linear(d, c, b - a)):
        theta = a if d.search.phi_start_rate[c] <= 0.0 else b
        measure_clearances(d, theta)
        return theta
    resolution = max(4e-16 * abs(d.step.end), 1e-16) / d.step.size
    low, high, theta = a, b, b
    for tries in range(MOST_GUESSES):
        value, slope = d.search.phi_end[c], d.search.phi_end_rate[c] * d.step.size
        if value > 0.0:
            low = theta
        else:
            high = theta
        if value == 0.0 or high - low <= resolution:
            break
        guess = theta - value / slope
        if abs(guess - theta) <= 0.25 * resolution:
            # the guess is close enough; if the guess is an end of the interval, ``next_guess`` would approach
            # this end by halving only
            break
        theta = next_guess(low, high, guess, tries)
        locate_at_fraction(d, theta)
        u, slope = sundman_u_now(d, d.scratch.state)
        set_clearance(d, c, u, slope)
    measure_suspects(d)
    return theta


def bound_curvature(d):
    """Set a bound on |φ″| of every suspect over the last step; φ is the clearance or penetration.

    The bound follows from a bound on point k's acceleration along the normal n: |n·a_0| + Σ_{i≤k} L_i (|α_i|
    + ω_i²), with the acceleration a_0 of the base and the lengths L_i of the links. For a point that rests on
    a stiff wall this bound is far too large. After an implicit step, which integrates the clearances of such
    points, ``bound_curvatures`` sets smaller bounds.
    """
    n = d.link_count
    # the second derivative of the clearance g in the step's variable s is d²g/ds² = p d(ġ)/ds + p′ ġ, with
    # p = dt/ds; `p` and `change` are bounds, by p ≤ u and |p′| ≤ |u′| (sundman.py)
    p, change = 1.0, 0.0
    if is_regularized(d):
        p, change = rate_bounds(d.step, sundman_u_at(n))
    along_x = rate_bounds(d.step, velocity_at(n))
    along_y = rate_bounds(d.step, velocity_at(n) + 1)
    curvature = d.scratch.curvature
    curvature[0] = 0.0
    for i in range(n):
        omega, alpha = rate_bounds(d.step, omega_at(n) + i)
        # the contribution of link i to the bound, in any direction
        curvature[i + 1] = curvature[i] + d.chain.length[i] * (
            p * (alpha + p * omega * omega) + change * omega
        )
    for k in range(d.search.suspect_count):
        c = d.search.suspect_index[k]
        v, a = base_motion_bounds(d, c, along_x, along_y)
        if d.channel_count > 0 and is_at_wall(d, c):
            speed, acceleration = prescribed_bounds(d, c)
            # v and a are bounds on |ġ| and |dġ/ds|. A channel is a function of time t, so its acceleration
            # times the bound p on dt/ds adds to the bound on |dġ/ds|.
            v, a = v + speed, a + p * acceleration
        curvature_by_links = links_curvature(d, c) if not is_at_joint_stop(d, c) else 0.0
        d.search.curvature[c] = p * a + change * v + curvature_by_links
    if was_implicit(d):
        bound_curvatures(d, d.step.size)


def links_curvature(d, c):
    """Return the contribution of the links to the curvature bound of candidate c, from ``scratch.curvature``.

    A site at the distance r from the proximal joint of a link of the length ℓ gets r/ℓ of this link's part.
    The candidate must not be a joint's stop.
    """
    curvature, point = d.scratch.curvature, d.candidate.point[c]
    if point <= d.link_count:
        return curvature[point]
    s = site_of_point(d, point)
    i, along, beside = d.site.link[s], d.site.along[s], d.site.beside[s]
    return curvature[i] + math.sqrt(along * along + beside * beside) * (curvature[i + 1] - curvature[i])


def base_motion_bounds(d, c, along_x, along_y):
    """Return bounds on |ġ| and |dġ/ds| of candidate c's clearance g, for the part of the base's motion in g.

    The motions of links and all prescribed motions are not part of the bounds. At a joint's stop, however,
    the bounds are complete: they follow from the motion of the joint's angle. s is the step's integration
    variable.

    ``along_x`` and ``along_y`` belong to the components x and y of the base's velocity. Each is a pair of
    bounds: on the absolute value of the component, and on that of the component's derivative in s.
    """
    if is_at_joint_stop(d, c):
        link = d.candidate.point[c] - 1
        first, arm = omega_at(d.link_count) + link, d.chain.longest_link
        if link == 0:
            v, a = rate_bounds(d.step, first)
        else:
            v, a = rate_bounds_along(d.step, first - 1, -1.0, 1.0)
        return arm * v, arm * a
    _, nx, ny = normal_row(d, c)
    if nx * ny == 0.0:
        # the normal n is along x or y, so one of the two terms is 0
        return abs(nx) * along_x[0] + abs(ny) * along_y[0], abs(nx) * along_x[1] + abs(ny) * along_y[1]
    return rate_bounds_along(d.step, velocity_at(d.link_count), nx, ny)


def prescribed_bounds(d, c):
    """Return what prescribed motions of base and wall add to bounds on |ġ| and |g̈| of c over the last step.

    g is the clearance.
    """
    speed, acceleration = 0.0, 0.0
    if d.chain.base_moves:
        for j in range(2):
            v, a = prescribed_motion.channel_bounds(d, j)
            component = abs(d.candidate.normal_x[c] if j == 0 else d.candidate.normal_y[c])
            speed, acceleration = speed + component * v, acceleration + component * a
    if d.wall_motion.first_channel[c] >= 0:
        v, a = prescribed_motion.channel_bounds(d, d.wall_motion.first_channel[c])
        speed, acceleration = speed + v, acceleration + a
    return speed, acceleration


def measure_clearances(d, theta):
    """Set φ and φ′ of all suspects (``measure_suspects``) at θ of the last step, where an interval ends."""
    locate_at_fraction(d, theta)
    measure_suspects(d)


def measure_suspects(d):
    """Set φ and φ′ (``set_clearance``) of every suspect, a candidate that the search examines.

    ``locate_at_fraction`` must have located the points.
    """
    u, slope = sundman_u_now(d, d.scratch.state)
    for k in range(d.search.suspect_count):
        set_clearance(d, d.search.suspect_index[k], u, slope)
