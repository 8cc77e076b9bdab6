"""The derivatives of the time at which a step ends with an event, and the next step begins.

The time of an event depends on the parameters (event_times.py). The end of the last step gets the derivatives
of this time, and the state there gets the derivatives of a shift along the motion. So the search for peaks
ends exactly at the event: a force that jumps there may have its largest value before the jump.
"""

from chain_impact.kernel.events.marks import count_mode_changes
from chain_impact.kernel.events.segments import has_segment_ended
from chain_impact.kernel.ode.last_step import (
    count_break,
    ensure_dense,
    ensure_points,
    ensure_rate,
    evaluate_start,
    set_start_delay,
)
from chain_impact.kernel.record.constants import CONTACT_ENDS, KINK, ONSET, RELATCH, RELEASE, SOLVER_READER
from chain_impact.kernel.record.state import sundman_u_at, time_at
from chain_impact.kernel.tangent.duals import dual_with_slope, has_slope, value
from chain_impact.kernel.tangent.event_times import (
    delay_of_crossing,
    delay_of_saturation,
    delay_of_segment,
    delay_without_force_jump,
    step_length,
)
from chain_impact.kernel.tangent.friction import check_changes, delay_of_change
from chain_impact.kernel.tangent.trust import check_onsets


def move_end(t):
    """Give the end of the last step the derivatives of the time of the event that ends the step.

    The dense output does not change, and its derivatives stay those at fixed times. If a force only has a
    kink at the event, the time of the event affects a peak or the end of a contact, but not the motion.
    """
    for c in range(t.candidate_count):
        if is_crossing(t, c):
            prepare_end(t)
            check_onsets(t)
            move_along(t, delay_of_crossing(t, c, t.contacts.event[c]))
            return
    if count_mode_changes(t) > 0:
        prepare_end(t)
        delay = delay_of_change(t)
        check_changes(t, delay)
        move_along(t, delay)
        return
    # if the step has no length, its event is caused by a jump at its start, and has no delay of its own
    if not step_length(t) > 0.0:
        return
    for c in range(t.candidate_count):
        if t.contacts.event[c] in (KINK, RELEASE):
            prepare_end(t)
            move_along(t, delay_without_force_jump(t, c, t.contacts.event[c]))
            return
    if t.drive.event:
        prepare_end(t)
        move_along(t, delay_of_saturation(t))


def move_to_segment(t):
    """Give the end of the last step the derivatives of the time at which a signal's segment ends there.

    If no segment ends there, or another event happens there, nothing changes.
    """
    delay = delay_of_segment(t)
    if ends_with_segment(t) and has_slope(delay):
        prepare_end(t)
        move_along(t, delay)


def is_crossing(t, c):
    """Return whether the time of candidate c's event at the end of the last step affects the motion.

    The result is False without an event of c there, for RELEASE and KINK, for CONTACT_ENDS of the
    regularized contact, and for RELATCH at the end of a step without duration.
    """
    kind = t.contacts.event[c]
    # at the end of a regularized contact dt/ds = 0, with the step's variable s, so a shift of the end in s
    # changes nothing
    if kind == CONTACT_ENDS:
        return c != t.step.regularized_candidate
    return kind == ONSET or (kind == RELATCH and step_length(t) > 0.0)


def prepare_end(t):
    """Compute the rate and the points at the end of the last step, and the step's dense output.

    All these must be known before the end gets the derivatives of the event's time (``move_along``).
    """
    ensure_rate(t)
    ensure_dense(t, SOLVER_READER)
    ensure_points(t)


def move_along(t, delay):
    """Give the state and time at the end of the last step the derivatives of a shift along the motion.

    ``delay`` [s] is the shift, a dual number of the value 0, so no value changes. The function counts a
    break.
    """
    y, rate = t.step.state_end, t.scratch.rate_end
    for j in range(sundman_u_at(t.link_count)):
        y[j] += value(rate[j]) * delay
    y[time_at(t.link_count)] += delay
    t.step.end += delay
    quadrature = t.quadrature
    for k in range(quadrature.count):
        quadrature.state_end[k] += value(quadrature.rate_end[k]) * delay
    count_break(t)


def ends_at_limit(t):
    """Return whether the last step ends where a drive reaches its limit or falls below the limit.

    The result is false if an event of a contact or of dry friction ends the step, too.
    """
    return t.drive.event != 0 and not ends_with_contact(t)


def ends_with_segment(t):
    """Return whether the last step ends where a segment of a signal ends, and no other event happens."""
    if t.drive.event != 0 or ends_with_contact(t):
        return False
    for j in range(t.signal_count):
        if has_segment_ended(t, j):
            return True
    return False


def ends_with_contact(t):
    """Return whether the last step ends with an event of a contact or of dry friction."""
    for c in range(t.candidate_count):
        if t.contacts.event[c]:
            return True
    return count_mode_changes(t) > 0


def fix_start(t):
    """Move the start of the next step, after an event, along the motion to a time without derivatives.

    Without this move, until the next event, the derivatives at a fixed time would contain the error of the
    dense output's slope times the derivatives of the start time. The time of the event keeps its derivatives,
    in ``start_delay``: the search for peaks in the next step begins at the event.
    """
    delay = t.step.start_delay + dual_with_slope(0.0, 1.0, t.step.end)
    count_break(t)
    ensure_rate(t)
    move_along(t, dual_with_slope(0.0, -1.0, t.step.end))
    set_start_delay(t, delay)
    evaluate_start(t)
