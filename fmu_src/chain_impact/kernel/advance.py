"""Advance an instance in time: its steps and events, ahead of the communication point.

The solver takes its own steps and runs ahead of the communication point. Outputs come from the dense output
of a step, so the communication step alone does not change the result. An event at the end of a step (a
contact begins or ends, a mode changes) takes effect at the start of the next step, which starts only when a
caller asks for a later time or calls ``event_update``. ``d`` is the instance's record (record/instance.py).
"""

from chain_impact.kernel import hooks
from chain_impact.kernel.chain.inputs import (
    REINITIALIZE,
    apply_inputs,
    are_inputs_in_use,
    belts_jump,
    inputs_continue,
    interpolate_prescribed_motions,
    limit_to_input_piece,
    withdraw_request,
)
from chain_impact.kernel.constraints.impulses import OUTCOME_FORCES_NOT_FOUND, SOLVED, clear_outcome
from chain_impact.kernel.cost import (
    UNLIMITED,
    begin_communication_step,
    check_and_renew_cost_window,
    cost_so_far,
    count_events,
    count_rejected_step,
    count_step,
    is_cost_exceeded,
)
from chain_impact.kernel.equations import clear_stage_notes
from chain_impact.kernel.events.base_at_wall import check_base_at_walls, end_where_wall_meets_base
from chain_impact.kernel.events.contact_log import update_peaks, update_to_communication_point
from chain_impact.kernel.events.handlers import apply_events, force_has_kink, restart_contacts_and_modes
from chain_impact.kernel.events.marks import count_mode_changes, drop_events, ends_in_onset
from chain_impact.kernel.events.search import find_event, onset_fraction
from chain_impact.kernel.events.segments import (
    begin_segments,
    check_segments,
    end_at_segment,
    limit_to_signal_segment,
)
from chain_impact.kernel.forces.active_contacts import clear_applied_forces, latch_penetration_and_damping
from chain_impact.kernel.forces.candidate_laws import are_laws_in_use, update_laws
from chain_impact.kernel.initialize import derive_drives, first_step_size
from chain_impact.kernel.ode import step_control
from chain_impact.kernel.ode.balance import (
    apply_next_input_piece,
    check_balance,
    check_energy,
    evaluate_balance_at_end,
    restart_balance,
    store_energy,
)
from chain_impact.kernel.ode.falls import correct_falls
from chain_impact.kernel.ode.last_step import (
    choose_variable,
    ensure_rate,
    evaluate_start,
    make_last_step,
    reset_step,
    roll_back,
    set_communication_point_in_step,
    truncate_step,
)
from chain_impact.kernel.ode.methods import choose_method, integrate_trial, prepare_step
from chain_impact.kernel.ode.quadratures import (
    commit_quadratures,
    reset_quadratures,
    set_quadrature_stage_at_end,
)
from chain_impact.kernel.ode.sundman import regularize_rate, time_rate_for_sizes
from chain_impact.kernel.record import constants
from chain_impact.kernel.record.constants import KINK, NO_EVENT
from chain_impact.kernel.record.method import is_implicit, was_implicit
from chain_impact.kernel.status import (
    FORCES_NOT_FOUND,
    LOG_FULL,
    OK,
    ONSET_DUE,
    PAUSED,
    TOO_MUCH_WORK,
    set_status,
)

# [s] the longest step: a chain in flight without spin has no errors that would limit the size of steps
LONGEST_STEP = 1.0
# [s] a run fails if a step must be shorter than this; far below the resolution of time except near t = 0
SHORTEST_STEP = 1e-18


def advance(d, time, log_capacity, cost_limit):
    """Advance the instance to ``time`` [s], not before the communication point; return a status.

    After a fault the instance stays at the last time it reached. LOG_FULL: ``log_capacity`` ended contacts
    wait for the caller, or the log of dry friction has no room for another step; after the caller has
    collected the entries, the run can continue. PAUSED: the cost since the start of the run exceeds
    ``cost_limit`` evaluations; the run can continue.
    """
    status = restart_if_changed(d, time)
    while status == OK and d.step.end < time:
        if log_is_full(d, log_capacity):
            return LOG_FULL
        if cost_so_far(d) > cost_limit:
            return PAUSED
        status = advance_one_step(d)
    if status == OK:
        set_communication_point(d, time)
    return status


def log_is_full(d, capacity):
    """Return whether ``capacity`` ended contacts wait or, if it is < UNLIMITED, friction's log lacks room."""
    if d.contact_log.count - d.contact_log.collected >= capacity:
        return True
    return (
        capacity < UNLIMITED
        and d.friction_element_count > 0
        and d.friction_changes.count > len(d.friction_changes.time) - d.friction_element_count
    )


def advance_to_onset(d, time):
    """Advance to ``time`` [s] as ``advance`` does, without limits on log and cost, or to the first onset.

    ``event_update`` or the next call applies this onset. The onset may be at the present time, as at the
    start of a run with a point at a wall, unless an earlier call has already stopped there. The result is a
    status: ONSET_DUE if contacts begin at the time that is reached.
    """
    status, has_advanced = restart_if_changed(d, time), False
    while status == OK and d.step.end < time:
        if (has_advanced or d.step.end > d.step.communication_point) and ends_in_onset(d):
            time = d.step.end
        else:
            status, has_advanced = advance_one_step(d), True
    if status == OK:
        set_communication_point(d, time)
        status = ONSET_DUE if is_onset_due(d) else OK
    return status


def event_update(d):
    """Apply the onsets at the communication point, with the present parameters; return a status.

    The next step starts in the state after the onsets.
    """
    status = restart_if_changed(d, d.step.communication_point)
    while status == OK and is_onset_due(d):
        status = advance_one_step(d)
    if status == OK:
        set_communication_point(d, d.step.communication_point)
    return status


def is_onset_due(d):
    """Return whether a contact begins at the communication point, with an onset that is not applied yet."""
    return d.step.end == d.step.communication_point and ends_in_onset(d)


def restart_if_changed(d, time):
    """Set the course of prescribed motions up to ``time`` [s], and restart if ``must_restart`` is true.

    Return the status of the run; after an earlier fault nothing is done.
    """
    if d.channel_count > 0 and d.statistics.status == OK:
        set_status(d, interpolate_prescribed_motions(d, time))
    if d.statistics.status == OK and must_restart(d):
        set_status(d, restart(d))
    return d.statistics.status


def must_restart(d):
    """Return whether an input or parameter has changed so that the solver must restart.

    If values were set and then set back, the mark ``given.pending`` is cleared. A new piece of the inputs
    that continues the present piece without a jump needs no restart: the next step applies it.
    """
    if d.given.pending == REINITIALIZE and are_inputs_in_use(d) and are_laws_in_use(d):
        withdraw_request(d)
    return d.given.pending and not inputs_continue(d)


def advance_one_step(d):
    """Take a step, and return a status; after a fault, stay at the last time that was reached."""
    set_status(d, take_accepted_step(d))
    if d.statistics.status == OK:
        hooks.on_step(d)
    else:
        commit_quadratures(d)
        reset_step(d, d.step.end, d.step.state_end)
    return d.statistics.status


def set_communication_point(d, time):
    """Set the communication point to ``time`` [s] in the last step; count the next call's cost from 0."""
    set_communication_point_in_step(d, time)
    begin_communication_step(d)


def restart(d):
    """Cut the last step at the communication point, and use new inputs and parameters; return a status."""
    update_to_communication_point(d)
    step_control.scale_next_size(d, time_rate_for_sizes(d, d.step.state_end))
    reset_step(d, d.step.communication_point, d.step.state_end)
    status = apply_pending_inputs(d)
    clear_applied_forces(d)
    restart_balance(d)
    # the proposed size may be that of a chain at rest, far too long for the motion that a new input causes
    step_control.limit_next_size(d, first_step_size(d))
    if status == OK:
        hooks.on_restart(d)
    return status


def apply_pending_inputs(d):
    """Use the given inputs and laws from now on, choose held contacts and modes again; return a status.

    After the fault that a law is invalid, or would become rigid during a contact, the old laws stay, but the
    new inputs are in use. FORCES_NOT_FOUND: no forces satisfy the new values; all new values are in use.
    """
    clear_outcome(d)
    apply_inputs(d)
    derive_drives(d)
    status = update_laws(d)
    if status == OK:
        apply_laws(d)
    return check_solved(d, status)


def latch_active_contacts(d):
    """Latch damping and expected penetration again, for contacts with a force law: laws may have changed."""
    for k in range(d.contacts.force_law_count):
        latch_penetration_and_damping(d, d.contacts.active_index[k])


def apply_laws(d):
    """Make latched values, held contacts, modes of friction and drives, and sides of kinks fit the laws."""
    latch_active_contacts(d)
    restart_contacts_and_modes(d, belts_jump(d))


def take_accepted_step(d):
    """Apply the events that wait, then take one accepted step, up to its first event; return a status."""
    clear_outcome(d)
    status = check_base_at_walls(d) if d.channel_count > 0 else OK
    if d.signal_count > 0 and status == OK:
        status = check_segments(d)
    if status == OK:
        status = check_solved(d, count_events(d, begin_step(d)))
    if status == OK:
        status = shrink_until_accepted(d)
    if status == OK:
        count_step(d, was_implicit(d))
        status = check_balance(d)
    if status == OK and d.channel_count > 0:
        end_where_wall_meets_base(d)
    if status == OK and d.signal_count > 0:
        end_at_segment(d)
    return status if status != OK else check_and_renew_cost_window(d)


def check_solved(d, status):
    """Return ``status`` or, if it is OK but forces or modes at an event were not found, FORCES_NOT_FOUND."""
    return FORCES_NOT_FOUND if status == OK and d.constraints.outcome == OUTCOME_FORCES_NOT_FOUND else status


def shrink_until_accepted(d):
    """Try smaller and smaller steps until a step, up to its first event, is accepted; return a status."""
    size = min(d.step.next_size, LONGEST_STEP)
    limit = limit_to_input_piece(d, size)
    if d.signal_count > 0:
        limit = limit_to_signal_segment(d, limit)
    h, growth = prepare_step(d, limit), step_control.LARGEST_RATIO
    if limit < size:
        # `prepare_step` may lengthen a step, but no step may pass the end of a piece of the inputs or of a
        # signal
        h = min(h, limit)
    while h >= SHORTEST_STEP and d.step.end + h != d.step.end:  # h must exceed the resolution of time
        try_to_event(d, h)
        next_size = h * min(growth, step_control.next_size_factor(d))
        if step_control.is_accepted(d):
            # a first try that is shorter because a piece or segment ends does not reduce the proposed size
            step_control.propose_size(d, max(next_size, size) if limit < size and growth > 1.0 else next_size)
            return OK
        count_rejected_step(d)
        if is_cost_exceeded(d):
            return TOO_MUCH_WORK
        h, growth = next_size, 1.0
    return step_control.no_step_status(d)


def try_to_event(d, h):
    """Try a step of size h [s] in its variable; an accepted step is the last step, cut at its first event."""
    clear_stage_notes(d)
    integrate_trial(d, h)
    if not step_control.is_accepted(d):
        return
    make_last_step(d)
    theta = find_event(d)
    if step_control.is_accepted(d) and must_repeat_to_event(d, theta):
        theta = repeat_to_event(d, theta)
    balance, available = 0.0, 0.0
    if step_control.is_accepted(d):
        balance, available = check_energy(d, theta)
    if step_control.is_accepted(d) and d.constraints.outcome != SOLVED:
        step_control.reject_step(d, constants.CHECK_FAILED)
    if not step_control.is_accepted(d):
        roll_back(d)
        drop_events(d)
        return
    store_energy(d, balance, available)
    if theta >= 0.0:
        truncate_step(d, theta)
    correct_falls(d)


def must_repeat_to_event(d, theta):
    """Return whether the last step must be repeated so that it ends at its event, at the fraction θ.

    θ = −1: there is no event. The force of a contact is not smooth at the contact's end and at its kink, so
    the dense output of a step across this point is less accurate than the step. The dense output of an
    implicit step is less accurate everywhere except at the step's ends, so such a step is repeated for every
    event within. Otherwise the error of the dense output would let a point that bounces lower and lower fall
    faster than it has risen, and bounce without end.
    """
    return theta > 0.0 and (force_has_kink(d) or (was_implicit(d) and theta < 1.0))


def repeat_to_event(d, theta):
    """Repeat the last step up to its fraction θ; return where in the repeated step contacts begin.

    The result is that of ``onset_fraction`` for the repeated step; −1 if the repeated step is rejected.
    """
    error, h = d.trial.error, theta * d.step.size
    roll_back(d)
    integrate_trial(d, h)
    if not step_control.is_accepted(d):
        step_control.reject_step(d, constants.CHECK_FAILED)
        return -1.0
    make_last_step(d)
    # the error of the whole step, not of its repetition up to an event, determines the size of the next step
    step_control.set_outcome(d, error, d.trial.cost_factor)
    return onset_fraction(d)


def begin_step(d):
    """Apply events and inputs at the last step's end, set up the next step; return the number of events."""
    events, has_kink = apply_pending_events(d)
    if d.given.pending:
        apply_next_input_piece(d)
        if d.channel_count > 0:
            evaluate_start(d)
    if d.signal_count > 0 and begin_segments(d):
        step_control.limit_to_flight_size(d)
    has_landed = events > 0 and d.contact_settings.any_rigid and d.contacts.force_law_count == 0
    if has_landed and not is_implicit(d):
        step_control.limit_to_flight_size(d)
    if events > 0 or d.balance.break_count != d.step.break_count:
        evaluate_balance_at_end(d)
    if not has_kink:
        choose_method(d)  # not at a kink or limit: a force that is 0 or constant there hides the stiffness
    choose_variable(d, events > 0)
    set_first_stage(d)
    return events


def apply_pending_events(d):
    """Update the peaks, apply the events at the last step's end, and set the rate at the next step's start.

    Return the number of events, and whether a kink of a force or the limit of a drive is among them.
    """
    events, has_kink = d.drive.event + count_mode_changes(d), d.drive.event > 0
    for c in range(d.candidate_count):
        events += d.contacts.event[c] != NO_EVENT
        has_kink = has_kink or d.contacts.event[c] == KINK

    ensure_rate(d)
    update_peaks(d)
    rate = d.scratch.rate_start
    for j in range(len(d.scratch.state)):
        rate[j] = d.scratch.rate_end[j]
    if events > 0:
        commit_quadratures(d)
        may_have_jumped = apply_events(d)
        reset_quadratures(d)
        if may_have_jumped:
            evaluate_start(d)
    return events, has_kink


def set_first_stage(d):
    """Set the first stage of a step: the rate at its start, dy/ds in the step's integration variable s."""
    regularize_rate(d, d.step.state_end, d.scratch.rate_start, d.scratch.stage[0])
    set_quadrature_stage_at_end(d, 0)
