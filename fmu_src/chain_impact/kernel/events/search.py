"""The search of a step for the earliest event.

For most steps a test of the states and rates at both ends excludes events of contacts (event_exclusion.py),
and no dense output is needed. In the other steps the first crossing of a clearance is located, and then other
kinds of events are searched for before this crossing. handlers.py and force_events.py describe the kinds of
events.
"""

import math

from chain_impact.kernel.chain.kinematics import accelerate_points, locate_points
from chain_impact.kernel.chain.signals import rate_of_signals
from chain_impact.kernel.constraints.geometry import (
    clearance_acceleration,
    clearance_and_rate,
    coordinate_sum,
)
from chain_impact.kernel.constraints.impulses import any_point_held
from chain_impact.kernel.events.crossing import (
    SIMULTANEOUS_TIME,
    bound_curvature,
    find_crossing,
    locate_at_fraction,
    measure_clearances,
)
from chain_impact.kernel.events.event_exclusion import (
    begin_next_interval,
    excludes_events,
    known_clearances,
    remember_clearances,
    suspect_all_candidates,
)
from chain_impact.kernel.events.force_events import find_kink, find_relatch, find_release, find_saturation
from chain_impact.kernel.events.marks import count_mode_changes, mark_contact_event
from chain_impact.kernel.events.mode_changes import find_mode_change, margin_is_halved
from chain_impact.kernel.ode.dense_output import interpolate_component, interpolate_state
from chain_impact.kernel.ode.last_step import ensure_dense
from chain_impact.kernel.ode.step_control import is_accepted, reject_step
from chain_impact.kernel.ode.sundman import time_rate_for_sizes
from chain_impact.kernel.record.constants import (
    CHECK_FAILED,
    CONTACT_ENDS,
    DISTANCE_KNOWN,
    NO_EVENT,
    NOTHING_KNOWN,
    ONSET,
    SOLVER_READER,
    VALUES_KNOWN,
)
from chain_impact.kernel.record.method import was_implicit
from chain_impact.kernel.record.state import time_at

# The largest depth in the wall, relative to the longest link, at which an onset may be located. Onsets are
# located up to round-off, about 1e-15. A deeper onset is an error of the step, and would add energy: 1e-11 J
# for a depth of 1e-9 m and a stiffness of 1e12 N/m^1.5. A step with such an onset is rejected.
DEEPEST_ONSET = 1e-9
# A crossing before the fraction EARLY_THETA of a step must agree with the Taylor polynomial of second order
# at the start of the step, whose relative error is then about 1e-9; the interpolant of a stiff step can have
# larger errors.
EARLY_THETA = 1e-3
# A step that was repeated to end at an onset is rejected if the onset is farther from the step's end than
# LANDING_TIME times the step's size.
LANDING_TIME = 1e-2
# A clearance at an onset up to CLEARANCE_ROUND_OFF is round-off, relative to the longest link plus the
# coordinates of the point. A slow point may need more than LANDING_TIME to move this distance; the time
# between the point's onset and the end of the step then counts as 0.
CLEARANCE_ROUND_OFF = 1e-15
# A step whose crossing or onset is not credible (``is_credible_crossing``, ``onset_fraction``) is rejected
# only if it is longer than SIMULTANEOUS_TIME plus TIME_RESOLUTION times the present time: ten times the
# resolution of time, because the next try may be a tenth as long.
TIME_RESOLUTION = 4e-15


def find_event(d):
    """Search the last step for the earliest event.

    Returns:
        The fraction θ ∈ [0, 1] of the step at which the event happens, or −1 if there is no event. The marks
        (marks.py) show which events happen at θ. A step that is too inaccurate to locate the event is
        rejected; then the result has no meaning.
    """
    d.search.input_rate = max(d.inputs.piece.change_rate, rate_of_signals(d))
    if d.candidate_count == 0:
        return find_event_without_crossing(d)
    if was_implicit(d):
        suspect_all_candidates(d)
        if known_clearances(d) in (NOTHING_KNOWN, DISTANCE_KNOWN):
            measure_clearances(d, 0.0)
        begin_next_interval(d)
    elif excludes_events(d):
        return find_event_without_crossing(d)
    if not was_implicit(d):
        ensure_dense(d, SOLVER_READER)
    bound_curvature(d)
    theta = find_crossing(d)
    if theta >= 0.0 and not is_credible_crossing(d, theta):
        if d.step.end - d.step.start > SIMULTANEOUS_TIME + TIME_RESOLUTION * abs(d.step.end):
            reject_step(d, CHECK_FAILED)
            return -1.0
        theta = drop_separating_onsets(d, theta)
        if theta < 0.0:
            measure_clearances(d, 1.0)
    theta = find_force_event(d, theta)
    # Without an event, the stored clearances are those at the end of the step. With an event they are wrong,
    # but not used: an event breaks the sequence of steps.
    remember_clearances(d, VALUES_KNOWN)
    # The state of a regularized step contains the time since the step's start. Nothing controls the error of
    # this time within the step: an event before the start is an error of the step.
    if theta > 0.0 and interpolate_component(d.step, theta, time_at(d.link_count)) < 0.0:
        reject_step(d, CHECK_FAILED)
    return theta


def find_event_without_crossing(d):
    """Return θ of the earliest event in a step in which no clearance falls through zero, or −1.

    The events are those of force_events.py and mode_changes.py. If the step is rejected, the
    result is −1, too.
    """
    if any_point_held(d):
        ensure_dense(d, SOLVER_READER)  # `update_held_extremes` needs the dense output as well
        return find_force_event(d, -1.0)
    theta = find_mode_change(d, -1.0) if d.friction.active_count > 0 else -1.0
    return find_saturation(d, theta) if d.chain.has_drive_limits else theta


def find_force_event(d, theta):
    """Return θ of the crossing at ``theta`` (−1: none), or of an earlier event of another kind.

    The result is −1 if there is no event, or if the step is rejected.
    """
    if any_point_held(d):
        theta = find_release(d, theta)
        if not is_accepted(d):
            return -1.0
        if d.contacts.force_law_count > 0:
            locate_at_fraction(d, theta if theta >= 0.0 else 1.0)
    theta = find_kink(d, find_relatch(d, theta))
    return find_saturation(d, find_mode_change(d, theta))


def is_credible_crossing(d, theta):
    """Return whether the crossings at the fraction θ of the step are real, and not errors of the step.

    The result is False in three cases, which are errors of a step that is too long:

    - An onset lies deep inside a wall.
    - At an onset the point moves away from the wall.
    - A crossing lies right after the start of the step, although the point cannot have reached the wall yet.

    Such errors occur because positions and rates of the interpolant may be inconsistent within the tolerance.
    At θ = 0 only the third case counts.

    The caller has set the state, the clearances and their rates at θ.
    """
    if theta <= EARLY_THETA and starts_clear(d, d.scratch.state[time_at(d.link_count)]):
        return False
    if theta == 0.0:
        # a point that is inside a wall at the start of the step is inside in a shorter step as well, so a
        # rejection would not help
        return True
    for c in range(d.candidate_count):
        if d.contacts.event[c] == ONSET:
            is_deep = d.search.phi_end[c] < -DEEPEST_ONSET * d.chain.longest_link
            if is_deep or d.search.phi_end_rate[c] > 0.0:
                return False
    return True


def starts_clear(d, time):
    """Return whether any candidate is far from its marked crossing, ``time`` [s] after the step's start.

    Far means that over half of the clearance at the start of the step is left; the crossing is then an error.
    The clearance (in contact, the penetration) at this time is extrapolated from the motion at the start of
    the step: the interpolant of a step over a stiff motion may have an error as large as the tolerance.
    """
    locate_points(d, d.step.state)
    accelerate_points(d, d.step.state, d.scratch.rate_start)
    is_clear = False
    for c in range(d.candidate_count):
        if d.contacts.event[c] in (ONSET, CONTACT_ENDS) and c != d.step.regularized_candidate:
            sign = -1.0 if d.contacts.active[c] else 1.0
            clearance, clearance_rate = clearance_and_rate(d, c)
            # the change of the clearance g, also of a candidate in contact: ġ t + ½ g̈ t²
            change = time * (clearance_rate + 0.5 * time * clearance_acceleration(d, c))
            is_clear = is_clear or (sign * clearance >= 0.0 and sign * (0.5 * clearance + change) > 0.0)
    locate_points(d, d.scratch.state)
    return is_clear


def onset_fraction(d):
    """Return the fraction θ of the last step at which its onsets lie; the step was repeated to end there.

    θ differs from 1 only by the error of the interpolant with which the onsets were found. Two Newton
    iterations find θ, which may be slightly above 1. The result is −1, which stands for the end of the step,
    if there is no onset, or if the step is so short (SIMULTANEOUS_TIME, TIME_RESOLUTION) that a rejection
    would not help.

    A longer step is rejected in three cases; the result then has no meaning:

    - A point with an onset is deep inside its wall at θ.
    - Such a point is far from its onset, or does not approach its wall, at the end of the step or at θ.
    - Friction modes are marked to end, but the step halves none of their margins (``margin_is_halved``).
    """
    if d.step.end - d.step.start <= SIMULTANEOUS_TIME + TIME_RESOLUTION * abs(d.step.end):
        return -1.0
    if count_mode_changes(d) and not margin_is_halved(d):
        reject_step(d, CHECK_FAILED)
        return -1.0
    lateness, _ = onset_lateness(d, d.step.state_end)
    if lateness == -math.inf:
        return -1.0
    theta = 1.0 - lateness
    if not abs(lateness) <= LANDING_TIME:
        reject_step(d, CHECK_FAILED)
        return -1.0
    ensure_dense(d, SOLVER_READER)
    interpolate_state(d.step, theta, d.scratch.state)
    lateness, _ = onset_lateness(d, d.scratch.state)
    theta -= lateness
    interpolate_state(d.step, theta, d.scratch.state)
    lateness, largest_depth = onset_lateness(d, d.scratch.state)
    if not (abs(lateness) <= LANDING_TIME and largest_depth <= DEEPEST_ONSET * d.chain.longest_link):
        reject_step(d, CHECK_FAILED)
    return theta


def onset_lateness(d, y):
    """Locate the points for a state y of the last step, and return by how much y is later than the onsets.

    The candidates that are marked with an onset count.

    Returns:
        Two values. The first is the time from the earliest onset to y, divided by the step size in seconds;
        negative if y is earlier. This value is ∞ if a candidate with an onset does not approach its wall in
        the state y, or if such an onset is farther away than LANDING_TIME, where a clearance of round-off
        counts as 0. The value is −∞ without onsets. The second value is the largest depth [m] of a candidate
        with an onset inside its wall; 0 if all are outside.
    """
    locate_points(d, y)
    latest, largest_depth = -math.inf, 0.0
    duration = d.step.size * time_rate_for_sizes(d, y)
    for c in range(d.candidate_count):
        if d.contacts.event[c] == ONSET:
            clearance, clearance_rate = clearance_and_rate(d, c)
            lateness = clearance / (clearance_rate * duration)
            if abs(lateness) > LANDING_TIME and abs(clearance) <= CLEARANCE_ROUND_OFF * (
                d.chain.longest_link + coordinate_sum(d, c, y)
            ):
                lateness = 0.0
            latest = max(
                latest, lateness if clearance_rate < 0.0 and abs(lateness) <= LANDING_TIME else math.inf
            )
            largest_depth = max(largest_depth, -clearance)
    return latest, largest_depth


def drop_separating_onsets(d, theta):
    """Remove the mark of an onset if the candidate separates at θ = ``theta``, where the crossing is.

    Return ``theta``, or −1 if no event is left.
    """
    has_event = False
    for c in range(d.candidate_count):
        if not d.contacts.active[c] and d.search.phi_end_rate[c] > 0.0:
            mark_contact_event(d, c, NO_EVENT)
        has_event = has_event or d.contacts.event[c] != NO_EVENT
    return theta if has_event else -1.0
