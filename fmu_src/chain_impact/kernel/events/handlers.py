"""The handlers of events, and the size of the step after an event.

The events ONSET and CONTACT_ENDS are zeros of a clearance or a penetration. The search for such zeros uses
bounds (crossing.py). All other events of contacts, friction and drives are found by samples of a step,
because locating them late does little harm; force_events.py lists them. The points must be located when a
handler applies an event. ``handle_rigid_impacts`` handles all simultaneous events at rigid walls together
(rigid_impacts.py). If a point arrives at a rigid wall, a contact with a force law that begins at the same
time begins after the impulses.
"""

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.constraints.geometry import clearance_and_rate
from chain_impact.kernel.constraints.impulses import any_point_held
from chain_impact.kernel.cost import count_evaluations
from chain_impact.kernel.equations import rate_from_points
from chain_impact.kernel.events.contact_log import end_contact
from chain_impact.kernel.events.event_exclusion import RELATCH_RATIO
from chain_impact.kernel.events.friction_modes import choose_friction_modes, restart_friction_modes
from chain_impact.kernel.events.marks import count_mode_changes, mark_contact_event
from chain_impact.kernel.events.rigid_impacts import (
    end_changed_contacts,
    handle_rigid_impacts,
    has_rigid_onset,
    update_active_set,
)
from chain_impact.kernel.events.saturation import choose_saturation
from chain_impact.kernel.forces.active_contacts import (
    begin_force_law_contact,
    clear_applied_forces,
    cross_kink,
    expect_peaks,
    list_active_contacts,
    relatch_speed,
    set_kink_sides,
)
from chain_impact.kernel.forces.force_formula import force_may_jump
from chain_impact.kernel.ode import step_control
from chain_impact.kernel.ode.last_step import reset_step
from chain_impact.kernel.ode.methods import begin_flight, begin_impact
from chain_impact.kernel.record.constants import (
    CONTACT_ENDS,
    EXPLICIT,
    KINK,
    NO_EVENT,
    ONSET,
    RELATCH,
)
from chain_impact.kernel.record.method import is_implicit, is_regularized

# A contact ends already before its point is outside, if the point needs at most LEAVING_TIME times the
# contact's time scale to get out. Otherwise an impact would take one step more: a tenth of the impact's cost,
# at a tolerance of 1e-4.
LEAVING_TIME = 0.01


def end_if_point_left(d, c):
    """End the contact of candidate c if its point does not move inward, and is outside or nearly so.

    Nearly so means that the point will be outside within a short time (LEAVING_TIME). The located end of a
    contact has an error within the tolerance, so the point may still move inward or need a long time to get
    out. In these cases the contact does not end.
    """
    contacts = d.contacts
    clearance, clearance_rate = clearance_and_rate(d, c)
    # the time to get out, −g/ġ for the clearance g, is at most LEAVING_TIME times the contact's time scale,
    # expected penetration over latched speed
    if (
        clearance_rate >= 0.0
        and -clearance * contacts.latched_speed[c]
        <= LEAVING_TIME * contacts.expected_penetration[c] * clearance_rate
    ):
        end_contact(d, c, False)


def apply_event(d, c, kind):
    """Apply an event of candidate c, which has a force law; return whether the force may have jumped.

    ``kind`` is the kind of event: ONSET, CONTACT_ENDS, RELATCH or KINK; with NO_EVENT nothing happens.
    """
    if kind == ONSET:
        begin_force_law_contact(d, c)
    elif kind == CONTACT_ENDS:
        end_if_point_left(d, c)
    elif kind == RELATCH:
        relatch_speed(d, c, RELATCH_RATIO)
    elif kind == KINK:
        cross_kink(d, c)
    return kind in (RELATCH, KINK) or (kind in (ONSET, CONTACT_ENDS) and force_may_jump(d, c))


def apply_events(d):
    """Apply the events at the end of the last step, and choose size and method of the next step.

    Returns:
        Whether a force may have jumped. The result is true in each of these cases:

        - A contact crosses its kink, or gets a new latched speed.
        - A contact begins or ends whose force may jump then (``force_may_jump``).
        - A rigid wall holds a point or has an event.
        - The scene has dry friction or a drive with a limit.
    """
    # ``last_onset``: the last candidate with a force law whose contact this function begins; −1: none begins
    contacts, last_onset, may_have_jumped = d.contacts, -1, False
    # whether the step size that was proposed before these events may be kept, if a contact goes on and none
    # begins: true after the end of a mode of friction or of a drive and, from the loop below on, after a kink
    # or a new latched speed
    keeps_size = count_mode_changes(d) + d.drive.event > 0
    # ``any_rigid_event``: a rigid wall holds a point or has an event
    any_rigid_event, hits_rigid_wall = any_point_held(d), has_rigid_onset(d)
    locate_points(d, d.step.state_end)
    if d.friction.active_count > 0:
        # The forces decide whether elements stick. All forces are computed again for the end of the step,
        # because the stored forces may belong to another time, at which outputs were computed.
        rate_from_points(d, d.step.state_end, d.scratch.rate)
        count_evaluations(d, 1)
    had_forces = contacts.force_law_count > 0
    if not had_forces:
        step_control.store_flight_size(d)
    for c in range(d.candidate_count):
        kind = contacts.event[c]
        if d.law.rigid[c]:
            any_rigid_event = any_rigid_event or kind != NO_EVENT
            continue
        if hits_rigid_wall and kind == ONSET:
            # ``handle_rigid_impacts`` begins this contact after the impulses, because the impulses change the
            # impact speed
            continue
        may_have_jumped = apply_event(d, c, kind) or may_have_jumped
        keeps_size = keeps_size or kind in (RELATCH, KINK)
        last_onset = c if kind == ONSET else last_onset
        mark_contact_event(d, c, NO_EVENT)
    if any_rigid_event:
        begun_candidate = handle_rigid_impacts(d)
        last_onset = begun_candidate if begun_candidate >= 0 else last_onset
    list_active_contacts(d)
    choose_saturation(d)
    if d.friction.may_act:
        choose_friction_modes(d, False)
    if any_rigid_event and contacts.force_law_count == 0:
        if had_forces:
            # the proposed size suits the contact with a force that has just ended, but not the flight after
            # the contact
            step_control.propose_flight_size(d)
        begin_flight(d)
    else:
        choose_next_size(d, last_onset, keeps_size)
    has_modes = d.friction.may_act != 0 or d.chain.has_drive_limits != 0
    if has_modes:
        expect_peaks(d)
    return may_have_jumped or any_rigid_event or has_modes


def restart_contacts_and_modes(d, speeds_may_jump):
    """Choose again what laws and inputs decide, because laws or inputs may have changed.

    Chosen are the contacts with rigid walls that go on, the modes of drives and of friction, and the sides of
    kinks. ``speeds_may_jump`` tells whether speeds may have jumped, such as the speed of a belt. If no speed
    has jumped, an element that stuck counts as at rest in spite of a small speed.
    """
    recompute_active_set(d)
    choose_saturation(d)
    restart_friction_modes(d, speeds_may_jump)
    set_kink_sides(d)
    expect_peaks(d)


def recompute_active_set(d):
    """End the held contacts that do not go on under changed laws or inputs.

    If a rigid wall has held any point up to the call, the last step is then reset to zero length.
    """
    if not any_point_held(d):
        return
    end_changed_contacts(d)
    if any_point_held(d):
        update_active_set(d)
    reset_step(d, d.step.end, d.step.state_end)


def choose_next_size(d, onset, keeps_size):
    """Choose the size and the method of the step that follows after events.

    Args:
        d: the instance.
        onset: the candidate with a force law whose contact has begun at these events; the last of several, −1
            if none has.
        keeps_size: whether the size that was proposed before the events may be kept; used only if a contact
            goes on and none begins.
    """
    if d.contacts.active_count == 0:
        clear_applied_forces(d)
        step_control.propose_flight_size(d)
        step_control.limit_to_flight_size(d)
        begin_flight(d)
    elif onset >= 0 or not (keeps_size or is_implicit(d)):
        c = onset if onset >= 0 else d.contacts.active_index[0]
        step_control.propose_size(d, step_control.size_at_onset(d, c, EXPLICIT))
    if onset >= 0:
        begin_impact(d, onset)
        if not is_implicit(d) and d.contacts.active_count > 1:
            step_control.limit_next_size(d, step_control.size_at_second_onset(d, onset))


def force_has_kink(d):
    """Return whether the force of a contact has a kink at a marked event, so that the step must be repeated.

    KINK and CONTACT_ENDS are such events; but if the regularized contact ends, the result is False.
    """
    if is_regularized(d) and d.contacts.event[d.step.regularized_candidate] == CONTACT_ENDS:
        return False
    for c in range(d.candidate_count):
        if d.contacts.event[c] in (CONTACT_ENDS, KINK):
            return True
    return False
