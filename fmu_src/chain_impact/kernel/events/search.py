"""The search of a step for its earliest event.

Most steps are far from any event, which their ends tell (exclusion.py); then there is no dense output to
look at. In the others crossings come first, and then what is looked for up to the first of them. What can
happen, table.py lists.
"""

import math

from chain_impact.kernel.chain.kinematics import accelerate_points, locate_points
from chain_impact.kernel.chain.state import time_at
from chain_impact.kernel.events.crossing import SIMULTANEOUS, bound_curvature, find_crossing, measure
from chain_impact.kernel.events.exclusion import (
    FAR,
    NOTHING,
    VALUES,
    excludes_events,
    keep_start,
    known_clearances,
    remember_clearances,
)
from chain_impact.kernel.events.kinds import END, ONSET, REFUSED
from chain_impact.kernel.events.kinks import find_kink
from chain_impact.kernel.events.relatch import find_relatch
from chain_impact.kernel.events.release import find_release
from chain_impact.kernel.integration.dense import interpolate, interpolate_component
from chain_impact.kernel.integration.last_step import SOLVER, ensure_dense
from chain_impact.kernel.integration.methods import DENSE_EVALUATIONS, RATE_AT_END
from chain_impact.kernel.model.constraints import any_point_held
from chain_impact.kernel.model.geometry import along_normal, clearance

# Of a link length: an onset is located to round-off, some 1e-15. One found deeper than this is the fault of
# the step; at K = 1e12 N/m^1.5 it would bring 1e-11 J.
DEEP = 1e-9
# Of a step: a touch so early has to agree with the Taylor polynomial at its start, whose third-order
# remainder is a part of 1e-9 there. The interpolant of a stiff step can be off by more.
EARLY = 1e-3
# Of a step: how far from an onset one may have landed that was made anew for it.
LANDED = 1e-2
RESOLVED = (
    4e-15  # of the time: ten times what a step can be told from none by, as a try may be a tenth of the last
)


def find_event(d):
    """Search the last step for the earliest event.

    Returns:
        The fraction θ ∈ [0, 1] of the step at which it happens, or −1; REFUSED when the step is too coarse to
        tell. ``touch.event`` tells whose it is.
    """
    if d.candidates == 0:
        return -1.0
    if any_point_held(d) or not RATE_AT_END[d.step.last_method]:
        if known_clearances(d) in (NOTHING, FAR):
            measure(d, 0.0)
        keep_start(d)
    elif excludes_events(d):
        return -1.0
    if DENSE_EVALUATIONS[d.step.last_method] > 0:
        ensure_dense(d, SOLVER)
    bound_curvature(d)
    theta = find_crossing(d)
    if theta >= 0.0 and not credible(d, theta):
        if d.step.end - d.step.start > SIMULTANEOUS + RESOLVED * abs(d.step.end):
            return REFUSED
        theta = drop_separating(d, theta)
        if theta < 0.0:
            measure(d, 1.0)
    if any_point_held(d):
        theta = find_release(d, theta)
    elif d.touch.active_count > 0:
        theta = find_kink(d, find_relatch(d, theta))
    remember_clearances(d, VALUES)
    # the time in a regularized step is not under error control
    if theta > 0.0 and interpolate_component(d.step, theta, time_at(d.links)) < 0.0:
        return REFUSED
    return theta


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
        if d.touch.event[c] == ONSET:
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
        if d.touch.event[c] in (ONSET, END) and c != d.step.regularized:
            sign = -1.0 if d.touch.active[c] else 1.0
            gap, gap_rate = clearance(d, c)
            # φ + φ̇ t + ½ φ̈ t²
            move = lasted * (gap_rate + 0.5 * lasted * along_normal(d, c, d.work.acceleration))
            clear = clear or (sign * gap >= 0.0 and sign * (0.5 * gap + move) > 0.0)
    locate_points(d, d.work.y)
    return clear


def onset_fraction(d):
    """The fraction θ of the last step, which has landed on events, at which onsets among them are; or −1.

    It is 1 but for what the interpolant was off where they were found. Two steps of Newton's method settle
    it, which may go a little beyond the end. REFUSED when points are deep inside then, or far from an onset.
    In a step that time hardly resolves it is the end.
    """
    if d.step.end - d.step.start <= SIMULTANEOUS + RESOLVED * abs(d.step.end):
        return -1.0
    late, _ = onset_lateness(d, d.step.state_end)
    if late == -math.inf:
        return -1.0
    theta = 1.0 - late
    if not abs(late) <= LANDED:
        return REFUSED
    ensure_dense(d, SOLVER)
    interpolate(d.step, theta, d.work.y)
    late, _ = onset_lateness(d, d.work.y)
    theta -= late
    interpolate(d.step, theta, d.work.y)
    late, deepest = onset_lateness(d, d.work.y)
    return theta if abs(late) <= LANDED and deepest <= DEEP * d.model.size else REFUSED


def onset_lateness(d, y):
    """How long before a state of the last step onsets are, over the size of the step; locates the points.

    Returns:
        That of the earliest onset; ∞ when a point does not arrive, or is far from its onset; −∞ without
        onsets. And how deep [m] the points that arrive are inside their walls.
    """
    locate_points(d, y)
    latest, deepest = -math.inf, 0.0
    for c in range(d.candidates):
        if d.touch.event[c] == ONSET:
            gap, gap_rate = clearance(d, c)
            late = gap / (gap_rate * d.step.size)
            latest = max(latest, late if gap_rate < 0.0 and abs(late) <= LANDED else math.inf)
            deepest = max(deepest, -gap)
    return latest, deepest


def drop_separating(d, theta):
    """Drop the onsets of points that move away; return the θ of what is left, or −1."""
    left = False
    for c in range(d.candidates):
        if not d.touch.active[c] and d.search.clear_end_rate[c] > 0.0:
            d.touch.event[c] = 0
        left = left or d.touch.event[c] != 0
    return theta if left else -1.0
