"""The search of a step for its earliest event.

For most steps a test on their ends excludes an onset or end of a contact (exclusion.py); then no dense output
is needed. In the other steps the first crossing, where φ of a candidate falls through zero, is located. Then
the other kinds of event are searched for up to it. table.py lists all kinds of event.

A check for a sign change between the ends of a step alone misses a point that dips into a wall and returns.
So a bound excludes that: with |φ̈| ≤ A over an interval of width w, φ stays above its chord minus A w²/8,
and φ̇ keeps its sign if it has the same sign at both ends and |φ̇_a| + |φ̇_b| > A w. An interval for which
neither condition decides is halved.
"""

import math

from chain_impact.kernel.chain.kinematics import accelerate_points, locate_points
from chain_impact.kernel.chain.state import omega_at, sundman_u_at, time_at, velocity_at
from chain_impact.kernel.events.exclusion import excludes_events, keep_start, set_clearance, sundman_u_now
from chain_impact.kernel.events.marks import END, NONE, ONSET, drop_events, ends_in_onset, mark
from chain_impact.kernel.events.sampled import find_force_event, find_mode_change, find_release
from chain_impact.kernel.events.sampling import SIMULTANEOUS, locate_at, locator
from chain_impact.kernel.integration.control import FAR_OFF, accepted, refuse
from chain_impact.kernel.integration.dense import interpolate_component, rate_bounds, rate_bounds_along
from chain_impact.kernel.integration.last_step import SOLVER, ensure_dense
from chain_impact.kernel.integration.method import IMPLICIT
from chain_impact.kernel.integration.methods import bound_curvatures
from chain_impact.kernel.integration.sundman import NO_CONTACT
from chain_impact.kernel.model.constraints import any_point_held
from chain_impact.kernel.model.geometry import clearance, gap_acceleration, normal
from chain_impact.kernel.work_limit import work_exceeded

RESOLUTION = 1e-15  # of a link length: if φ bends less, the bend is round-off, and no interval is halved
ROUND_OFF = 4e-16  # of the time: an onset is located no better
# Of a link length: an onset is located to round-off, some 1e-15. One found deeper than this is an error of
# the step; at K = 1e12 N/m^1.5 it would add 1e-11 J.
DEEP = 1e-9
# Fraction of a step: a crossing so early has to agree with the Taylor polynomial at the start of the step,
# whose third-order remainder is relatively 1e-9 there. The interpolant of a stiff step can err by more.
EARLY = 1e-3
# Fraction of a step: the largest distance from an onset to the end of the step repeated to land on it.
LANDED = 1e-2
# Of the time: ten times the shortest step that time resolves, as a try may be a tenth of the last one.
RESOLVED = 4e-15
QUIET, SPLIT, CROSSES = 0, 1, 2


def find_event(d):
    """Search the last step for the earliest event.

    Returns:
        The fraction θ ∈ [0, 1] of the step at which it happens, or −1. ``touch.event`` then holds the kind of
        event of each candidate. A step that is too inaccurate to locate it is refused.
    """
    theta, held = -1.0, any_point_held(d)
    excluded = d.candidates == 0 or excludes_events(d)
    if d.step.last_method != IMPLICIT and (held or not excluded):
        ensure_dense(d, SOLVER)  # `update_held_extremes` needs it, too
    if not excluded:
        theta = find_crossing(d)
        if theta >= 0.0 and not credible(d, theta):
            if not is_short(d):
                refuse(d, FAR_OFF)
                return -1.0
            # the next step begins with it if it is none of round-off
            drop_events(d)
            theta = -1.0
            measure(d, 1.0)
    if held:
        theta = find_release(d, theta)
        locate_at(d, theta if theta >= 0.0 else 1.0)
    if d.touch.compliant_count > 0 and not excluded and accepted(d):
        theta = find_force_event(d, theta)
    if d.friction.count > 0 and accepted(d):
        theta = find_mode_change(d, theta)
    # the time in a regularized step is not under error control
    if theta > 0.0 and interpolate_component(d.step, theta, time_at(d.links)) < 0.0:
        refuse(d, FAR_OFF)
    return theta


def is_short(d):
    """Whether time hardly resolves the last step: events in it count as simultaneous."""
    return d.step.end - d.step.start <= SIMULTANEOUS + RESOLVED * abs(d.step.end)


# ---- crossings --------------------------------------------------------------------------------------------


def find_crossing(d):
    """θ of the first onset or end of a suspect's contact in the last step, or −1; marks these candidates.

    φ and φ′ of the suspects are set there, or at the end of the step.
    """
    bound_curvature(d)
    if d.step.last_method == IMPLICIT:
        measure(d, 0.0)
        keep_start(d)
    a, b = 0.0, 1.0
    while not work_exceeded(d):
        measure(d, b)
        verdict = check_interval(d, a, b)
        if verdict == SPLIT:
            b = 0.5 * (a + b)
        elif verdict == CROSSES:
            return locate_first(d, a, b)
        elif b == 1.0:
            return -1.0
        else:
            keep_start(d)
            # the next interval is the widest that begins at b in the tree of the bisection
            a, width = b, b - a
            while a + width < 1.0 and a % (2.0 * width) == 0.0:
                width *= 2.0
            b = min(1.0, a + width)
    return -1.0  # too much work: the caller will end the run


def check_interval(d, a, b):
    """QUIET if no suspect can have an event in (a, b], CROSSES if one has, SPLIT if undecided; marks them."""
    verdict = QUIET
    for k in range(d.search.suspect_count):
        c = d.search.suspect[k]
        outcome = check_candidate(d, c, a, b)
        if outcome == SPLIT:
            return SPLIT
        crosses = END if d.touch.active[c] else ONSET
        mark(d, c, crosses if outcome == CROSSES else NONE)
        verdict = max(verdict, outcome)
    return verdict


def check_candidate(d, c, a, b):
    """The verdict on one candidate over an interval of the step."""
    width = (b - a) * d.step.size
    start, end = d.search.clear_start[c], d.search.clear_end[c]
    if c == d.step.regularized:
        # δ̇ would have to change its sign twice for u to fall to zero and rise again
        return CROSSES if end < 0.0 else QUIET
    rate_start, rate_end = d.search.clear_start_rate[c], d.search.clear_end_rate[c]
    curvature = d.search.curvature[c]
    sag, harmless = curvature * width * width / 8.0, d.law.harmless_depth[c]
    # a point so shallow at the end of the step, or one that leaves, may never penetrate further
    near = b == 1.0 or d.touch.active[c]
    falls = end < (-harmless if near else 0.0) and rate_end < 0.0
    if start > sag - harmless and end > sag - harmless and not falls:
        return QUIET
    settled = rate_start * rate_end > 0.0 and abs(rate_start) + abs(rate_end) > curvature * width
    # `sag < …` would halve without end for a curvature that is not finite
    if settled or not sag >= RESOLUTION * d.model.size:
        # at a loose tolerance the interpolant can put a point deep inside although its rate is not inward; a
        # point in contact that moves inward has not left, wherever the interpolant of a stiff step puts it
        return CROSSES if falls or (end < -harmless <= start and not d.touch.active[c]) else QUIET
    return SPLIT


def locate_first(d, a, b):
    """The earliest crossing in (a, b], with φ known at both; drops the marks of later ones."""
    search, first, found = d.search, b, -1
    for k in range(search.suspect_count):
        c = search.suspect[k]
        # φ is that at `first`: a candidate with φ ≥ 0 there has its event later
        if d.touch.event[c] and search.clear_end[c] < 0.0:
            first, found = locate_fall(d, c, a, first), c
            measure(d, first)
    within = SIMULTANEOUS + ROUND_OFF * abs(d.step.end)
    for k in range(search.suspect_count):
        c = search.suspect[k]
        # `found` is always kept, as round-off may exceed this limit for a slow point
        if c != found and search.clear_end[c] > within * abs(search.clear_end_rate[c]):
            mark(d, c, NONE)
    return first


def locate_fall(d, c, a, b):
    """θ in [a, b] at which φ of candidate c, negative at b, falls through zero.

    If φ is not positive at a either, the event is overdue: it is at the first end at which φ falls.
    """
    start, rate = d.search.clear_start[c], d.search.clear_start_rate[c]
    if start <= 0.0:
        return a if rate <= 0.0 else b
    return _locate_crossing(d, c, a, b, start, d.search.clear_end[c], ROUND_OFF * abs(d.step.end))


def clearance_at(d, c, theta):
    """Φ of candidate c at the fraction θ of the last step; sets φ and φ′ as those at the interval's end."""
    locate_at(d, theta)
    u, slope = sundman_u_now(d, d.work.y)
    set_clearance(d, c, u, slope)
    return d.search.clear_end[c]


_locate_crossing = locator(clearance_at)


def measure(d, theta):
    """Set φ and φ′ of every suspect at the fraction θ of the step, as the end of the interval."""
    locate_at(d, theta)
    u, slope = sundman_u_now(d, d.work.y)
    for k in range(d.search.suspect_count):
        set_clearance(d, d.search.suspect[k], u, slope)


def bound_curvature(d):
    """Bound |g̈| of every suspect over the last step.

    |n·a_k| ≤ |n·a_0| + Σ_{i≤k} L_i (|α_i| + ω_i²) holds for any point k. This bound is far from sharp for a
    point that rests on a stiff wall; but there the implicit step integrates the clearance itself.
    """
    n = d.links
    # d²g/ds² = p d(ġ)/ds + p′ ġ, with p ≤ u and |p′| ≤ |u′|
    p, change = 1.0, 0.0
    if d.step.regularized != NO_CONTACT:
        p, change = rate_bounds(d.step, sundman_u_at(n))
    vx, ax = rate_bounds(d.step, velocity_at(n))
    vy, ay = rate_bounds(d.step, velocity_at(n) + 1)
    links = d.work.reach
    links[0] = 0.0
    for i in range(n):
        omega, alpha = rate_bounds(d.step, omega_at(n) + i)
        # the contribution of link i, in any direction
        links[i + 1] = links[i] + d.model.length[i] * (p * (alpha + p * omega * omega) + change * omega)
    for k in range(d.search.suspect_count):
        c = d.search.suspect[k]
        point = d.candidate.point[c]
        if d.candidate.stop[c] != 0:
            # the link after the joint turns relative to the one before it
            before = -1.0 if point > 1 else 0.0
            v, a = rate_bounds_along(d.step, omega_at(n) + point - 2, before, 1.0)
            d.search.curvature[c] = d.model.size * (p * a + change * v)
        else:
            _, nx, ny = normal(d, c)
            v, a = abs(nx) * vx + abs(ny) * vy, abs(nx) * ax + abs(ny) * ay
            d.search.curvature[c] = p * a + change * v + links[point]
    bound_curvatures(d)


# ---- whether they are of the motion -----------------------------------------------------------------------


def credible(d, theta):
    """Whether the crossings found at θ, for which φ and φ′ are set there, are of points that arrive or leave.

    Positions and rates of the interpolant may be inconsistent within the tolerance. An onset deep inside a
    wall, or of a point that moves away, is an error of a step that is too long; so is a crossing right after
    the start of the step by a point that cannot have reached the wall yet.
    """
    if theta <= EARLY and starts_clear(d, theta * d.step.size):
        return False
    if theta == 0.0:
        return True  # a point inside a wall at the start is so in a shorter step as well
    for c in range(d.candidates):
        if d.touch.event[c] == ONSET:
            deep = d.search.clear_end[c] < -DEEP * d.model.size
            if deep or d.search.clear_end_rate[c] > 0.0:
                return False
    return True


def starts_clear(d, lasted):
    """Whether a candidate with an event within ``lasted`` [s] has φ > 0 there by its motion at the start.

    Near its start, the interpolant of a step over a stiff motion may err by as much as the tolerance allows.
    """
    locate_points(d, d.step.state)
    accelerate_points(d, d.step.state, d.work.rate_start)
    clear = False
    for c in range(d.candidates):
        if d.touch.event[c] in (ONSET, END) and c != d.step.regularized:
            sign = -1.0 if d.touch.active[c] else 1.0
            gap, gap_rate = clearance(d, c)
            # φ + φ̇ t + ½ φ̈ t²
            move = lasted * (gap_rate + 0.5 * lasted * gap_acceleration(d, c))
            clear = clear or (sign * gap >= 0.0 and sign * (0.5 * gap + move) > 0.0)
    locate_points(d, d.work.y)
    return clear


# ---- steps repeated to end at an onset --------------------------------------------------------------------


def onset_fraction(d):
    """The fraction θ at which the onsets are, in the last step, repeated to end at its events; or −1.

    θ is 1 up to the error of the interpolant with which the events were found. Two Newton iterations correct
    it; it may come to lie a little beyond the end. The step is refused if points are then deep inside a wall
    or far from an onset. θ is −1, the end, without an onset or in a step that time hardly resolves.
    """
    if is_short(d) or not ends_in_onset(d):
        return -1.0
    theta = 1.0
    late, deepest = onset_lateness(d, theta)
    for _ in range(2):
        if abs(late) <= LANDED:
            theta -= late
            late, deepest = onset_lateness(d, theta)
    if not (abs(late) <= LANDED and deepest <= DEEP * d.model.size):
        refuse(d, FAR_OFF)
    return theta


def onset_lateness(d, theta):
    """The time from the onsets to θ in the last step, over the step size; locates the points.

    Returns:
        The time since the earliest onset; ∞ if a point does not arrive, or is far from its onset. And the
        largest depth [m] of the arriving points inside their walls.
    """
    locate_at(d, theta)
    latest, deepest = -math.inf, 0.0
    for c in range(d.candidates):
        if d.touch.event[c] == ONSET:
            gap, gap_rate = clearance(d, c)
            late = gap / (gap_rate * d.step.size)
            latest = max(latest, late if gap_rate < 0.0 and abs(late) <= LANDED else math.inf)
            deepest = max(deepest, -gap)
    return latest, deepest
