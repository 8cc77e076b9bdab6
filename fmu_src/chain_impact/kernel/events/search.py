"""Events: the moments at which contacts begin and end, located on the dense output.

Most steps are far from any event, which their ends tell; then there is no dense output to look at.

An event is a descent through zero: of the clearance for a candidate that is apart, of the penetration for
one in contact. Looking only for a sign change between the ends of a step misses a point that dips through
a wall and returns. So each step is cleared by a bound: with |φ̈| ≤ A over an interval of width w, φ stays
above its chord less A w²/8, and φ̇ keeps its sign if it has the same one at both ends and |φ̇_a| + |φ̇_b| > A w.
An interval for which neither settles the matter is halved.

A third event concerns a contact whose point is pushed in much faster than it arrived: a second hit, or a
touch-down so slow that gravity soon outruns it. The v₀ latched at onset would then make λ δ̇/v₀, and the
force, grow without bound; v₀ is latched anew.
"""

from chain_impact.kernel.chain.kinematics import accelerate_points, locate_points
from chain_impact.kernel.chain.state import omega_at, root_at, time_at, velocity_at
from chain_impact.kernel.events.exclusion import (
    FAR,
    NOTHING,
    RELATCH_RATIO,
    VALUES,
    excludes_events,
    keep_start,
    known,
    learn,
    nearly_fast,
    root_now,
    set_clearance,
    set_clearances,
)
from chain_impact.kernel.events.release import find_release
from chain_impact.kernel.integration.dense import (
    interpolate,
    interpolate_component,
    rate_bounds,
    rate_bounds_along,
)
from chain_impact.kernel.integration.implicit import clearance_curvature
from chain_impact.kernel.integration.last_step import SOLVER, complete
from chain_impact.kernel.integration.method import EXPLICIT, IMPLICIT
from chain_impact.kernel.integration.sundman import NO_CONTACT
from chain_impact.kernel.model.constraints import holding
from chain_impact.kernel.model.contact import drop_events
from chain_impact.kernel.model.geometry import along_normal, clearance, harmless_depth, normal
from chain_impact.kernel.work_limit import overdrawn

SIMULTANEOUS = 1e-12  # s, events closer than this are one event
RESOLUTION = 1e-15  # of a link length: curvature below it is round-off
DEEP = 1e-9  # of a link length, how deep in a wall no onset is located
EARLY = 1e-3  # of a step, in which a touch has to agree with the motion at its start
REFUSED = -2.0  # in place of θ
QUIET, SPLIT, EVENT = 0, 1, 2
# kinds of event: contact begins or ends, v₀ is latched anew
TOUCH, RELATCH = 1, 2  # … and RELEASE in release.py
SAMPLES = 4  # places in a step to look at for the latter


def find_event(d):
    """Search the last step for the earliest event.

    Returns:
        The fraction θ ∈ [0, 1] of the step at which it happens, or −1; REFUSED when the step is too coarse to
        tell. ``touch.event`` tells whose it is.
    """
    if d.candidates == 0:
        return -1.0
    if d.step.made_by == IMPLICIT or holding(d):
        if known(d) in (NOTHING, FAR):
            measure(d, 0.0)
        keep_start(d)
    elif excludes_events(d):
        return -1.0
    if d.step.made_by == EXPLICIT:
        complete(d, SOLVER)
    bound_curvature(d)
    theta = find_touch(d)
    if theta >= 0.0 and not credible(d, theta):
        if d.step.end - d.step.start > SIMULTANEOUS:
            return REFUSED
        theta = drop_leaving(d, theta)
    if holding(d):
        theta = find_release(d, theta)
    elif d.touch.active_count > 0:
        theta = find_relatch(d, theta)
    learn(d, VALUES)
    # the time in a regularized step is not under error control
    if theta > 0.0 and interpolate_component(d.step, theta, time_at(d.links)) < 0.0:
        return REFUSED
    return theta


def find_touch(d):
    """θ of the first onset or end of a contact in the last step, or −1; marks whose it is.

    The start of the step is measured.
    """
    a, b = 0.0, 1.0
    while not overdrawn(d):
        measure(d, b)
        verdict = inspect(d, a, b)
        if verdict == SPLIT:
            b = 0.5 * (a + b)
        elif verdict == EVENT:
            return locate(d, a, b)
        elif b == 1.0:
            return -1.0
        else:
            keep_start(d)
            # the next interval is as wide as its place in the bisection allows
            a, width = b, b - a
            while a + width < 1.0 and a % (2.0 * width) == 0.0:
                width *= 2.0
            b = min(1.0, a + width)
    return -1.0  # the run ends: who called looks at the work


def credible(d, theta):
    """Whether the touches found at θ, where they are measured, are of points that arrive at a wall or leave.

    The positions of a step and its speeds contradict each other by what the tolerance allows. An onset deep
    inside, or of a point that moves away, is the fault of a step that is too long; so is a touch at its very
    start, by a point that cannot be there yet.
    """
    if theta <= EARLY and starts_clear(d, theta * d.step.size):
        return False
    if theta == 0.0:
        return True  # a point that is inside at the start will be so in a shorter step, too
    for c in range(d.candidates):
        if d.touch.event[c] == TOUCH and not d.touch.active[c]:
            deep = d.search.clear_end[c] < -DEEP * d.model.size
            if deep or d.search.clear_end_rate[c] > 0.0:
                return False
    return True


def starts_clear(d, lasted):
    """Whether a candidate that touches within so short a time [s] is clear by its motion at the start.

    The interpolant of a step that passes over what is stiff is off its start by what the tolerance allows.
    """
    locate_points(d, d.step.state)
    accelerate_points(d, d.step.state, d.work.rate_start)
    clear = False
    for c in range(d.candidates):
        if d.touch.event[c] == TOUCH and c != d.step.regularized:
            sign = -1.0 if d.touch.active[c] else 1.0
            gap, gap_rate = clearance(d, c)
            # φ + φ̇ t + ½ φ̈ t²
            move = lasted * (gap_rate + 0.5 * lasted * along_normal(d, c, d.work.acceleration))
            clear = clear or (sign * gap >= 0.0 and sign * (0.5 * gap + move) > 0.0)
    locate_points(d, d.work.y)
    return clear


def drop_leaving(d, theta):
    """Drop the onsets of points that move away; return the θ of what is left, or −1."""
    left = False
    for c in range(d.candidates):
        if not d.touch.active[c] and d.search.clear_end_rate[c] > 0.0:
            d.touch.event[c] = 0
        left = left or d.touch.event[c] != 0
    return theta if left else -1.0


def find_relatch(d, touch):
    """θ of the first of the event at ``touch`` (−1: none) and a contact to latch anew; marks whose it is.

    A contact whose point is nearly fast enough at either end of the step is looked at in between, too.
    """
    first = touch if touch >= 0.0 else 1.0  # where the points are located
    found = -1
    for k in range(d.touch.active_count):
        c = d.touch.active_index[k]
        if nearly_fast(d, c):
            theta = when_fast(d, c, RELATCH_RATIO * d.touch.impact_speed[c], first)
            if theta >= 0.0:
                found, first = c, theta
            locate_at(d, first)
    if found < 0:
        return touch
    drop_events(d)
    d.touch.event[found] = RELATCH
    return first


def when_fast(d, c, fast, end):
    """θ ≤ ``end`` at which δ̇ of candidate c first exceeds a speed [m/s], or −1."""
    low = 0.0
    for sample in range(1, SAMPLES + 1):
        high = end * sample / SAMPLES
        if faster(d, c, fast, high):
            while (high - low) * d.step.size > SIMULTANEOUS:
                middle = 0.5 * (low + high)
                if faster(d, c, fast, middle):
                    high = middle
                else:
                    low = middle
            return high
        low = high
    return -1.0


def faster(d, c, fast, theta):
    """Whether δ̇ of candidate c exceeds a speed [m/s] at the fraction θ of the step."""
    locate_at(d, theta)
    _, gap_rate = clearance(d, c)
    return -gap_rate > fast


def bound_curvature(d):
    """Bound |g̈| of every candidate over the last step.

    |n·a_k| ≤ |n·a_0| + Σ_{i≤k} L_i (|α_i| + ω_i²) holds for any point k. It is far from sharp for a point
    that a stiff wall holds; but there the implicit step integrates the clearance itself.
    """
    n = d.links
    # d²g/ds² = p d(ġ)/ds + p′ ġ, with p ≤ u and |p′| ≤ |u′|
    p, change = 1.0, 0.0
    if d.step.regularized != NO_CONTACT:
        p, change = rate_bounds(d.step, root_at(n))
    vx, ax = rate_bounds(d.step, velocity_at(n))
    vy, ay = rate_bounds(d.step, velocity_at(n) + 1)
    links = d.work.motion.x
    links[0] = 0.0
    for i in range(n):
        omega, alpha = rate_bounds(d.step, omega_at(n) + i)
        # what link i adds, in any direction
        links[i + 1] = links[i] + d.model.length[i] * (p * (alpha + p * omega * omega) + change * omega)
    for c in range(d.candidates):
        nx, ny = normal(d, c)
        if nx * ny == 0.0:
            # along an axis the same bounds serve all points and walls
            v, a = abs(nx) * vx + abs(ny) * vy, abs(nx) * ax + abs(ny) * ay
        else:
            v, a = rate_bounds_along(d.step, velocity_at(n), nx, ny)
        d.search.curvature[c] = p * a + change * v + links[d.candidate.point[c]]
    if d.step.made_by == IMPLICIT:
        for k in range(d.touch.active_count):
            d.search.curvature[d.touch.active_index[k]] = clearance_curvature(d, k)


def measure(d, theta):
    """Set φ and φ′ of every candidate at the fraction θ of the step, as the end of the interval."""
    locate_at(d, theta)
    set_clearances(d, d.work.y)


def locate_at(d, theta):
    """Set ``work.y`` to the state at the fraction θ of the step, and locate its points."""
    d.limits.other_work += 1
    if 0.0 < theta < 1.0:
        complete(d, SOLVER)
        interpolate(d.step, theta, d.work.y)
    else:
        for j in range(len(d.work.y)):
            d.work.y[j] = d.step.state[j] if theta == 0.0 else d.step.state_end[j]
    locate_points(d, d.work.y)


def inspect(d, a, b):
    """QUIET if no candidate can have an event in (a, b], EVENT if one has, SPLIT if unsettled."""
    verdict = QUIET
    for c in range(d.candidates):
        judged = inspect_candidate(d, c, a, b)
        if judged == SPLIT:
            return SPLIT
        verdict = max(verdict, judged)
    return verdict


def inspect_candidate(d, c, a, b):
    """The verdict on one candidate over an interval of the step."""
    width = (b - a) * d.step.size
    start, end = d.search.clear_start[c], d.search.clear_end[c]
    if c == d.step.regularized:
        # δ̇ would have to change its sign twice for u to fall to zero and rise again
        return EVENT if end < 0.0 else QUIET
    rate_start, rate_end = d.search.clear_start_rate[c], d.search.clear_end_rate[c]
    curvature = d.search.curvature[c]
    sag, harmless = curvature * width * width / 8.0, harmless_depth(d)
    # who has come that little way by the end of the step, or leaves, may never get further
    near = b == 1.0 or d.touch.active[c]
    falls = end < (-harmless if near else 0.0) and rate_end < 0.0
    if start > sag - harmless and end > sag - harmless and not falls:
        return QUIET
    settled = rate_start * rate_end > 0.0 and abs(rate_start) + abs(rate_end) > curvature * width
    # not >=, which keeps on halving for a curvature that is not finite
    if settled or not sag >= RESOLUTION * d.model.size:
        # at a loose tolerance a point can get deep without having moved there, as far as its speed tells;
        # one in contact that moves inward has not left, wherever the interpolant of a stiff step puts it
        return EVENT if falls or (end < -harmless <= start and not d.touch.active[c]) else QUIET
    return SPLIT


def barely(d, c, part):
    """Whether φ of candidate c bends by no more than round-off over a part of the step."""
    width = part * d.step.size
    return not d.search.curvature[c] * width * width / 8.0 >= RESOLUTION * d.model.size


def locate(d, a, b):
    """Find the earliest event in (a, b], in which every candidate is settled, and mark whose it is."""
    first, found = b, -1
    for c in range(d.candidates):
        d.touch.event[c] = TOUCH if inspect_candidate(d, c, a, b) == EVENT else 0
    for c in range(d.candidates):
        # `first` is measured: whoever is still clear there comes later
        if d.touch.event[c] and d.search.clear_end[c] < 0.0:
            first = root(d, c, a, first)
            found = c
    within = SIMULTANEOUS + 4e-16 * abs(d.step.end)
    for c in range(d.candidates):
        # a slow point may be no nearer at its own root, for round-off
        if c != found and d.search.clear_end[c] > within * abs(d.search.clear_end_rate[c]):
            d.touch.event[c] = 0
    return first


def root(d, c, a, b):
    """θ in [a, b] at which φ of candidate c, negative at b, falls through zero; measured there.

    Newton's method kept inside a shrinking bracket. When φ is not positive at the start of it, either, the
    event is overdue: it is where φ falls.
    """
    if d.search.clear_start[c] <= 0.0 and (d.search.clear_start_rate[c] <= 0.0 or barely(d, c, b - a)):
        theta = a if d.search.clear_start_rate[c] <= 0.0 else b
        measure(d, theta)
        return theta
    resolution = max(4e-16 * abs(d.step.end), 1e-16) / d.step.size
    low, high, theta = a, b, b
    for _ in range(100):
        value, slope = d.search.clear_end[c], d.search.clear_end_rate[c] * d.step.size
        if value > 0.0:
            low = theta
        else:
            high = theta
        if value == 0.0 or high - low <= resolution:
            break
        guess = theta - value / slope
        if not low < guess < high:
            guess = 0.5 * (low + high)
        if abs(guess - theta) <= 0.25 * resolution:
            break
        theta = guess
        locate_at(d, theta)
        u, slope = root_now(d, d.work.y)
        set_clearance(d, c, u, slope)
    measure(d, theta)
    return theta
