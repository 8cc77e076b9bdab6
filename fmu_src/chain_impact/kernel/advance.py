"""Advance an instance in time: phases, step control, and the run-ahead to the communication point.

The solver takes its own steps and runs ahead of the communication point, which is answered from the dense
output; so the result does not depend on the communication step. What happens at the end of a step
(a contact begins or ends, a peak is passed) takes effect at the start of the next one, hence not before
the communication point has passed it.
"""

import math

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.events.contact_log import finish, follow_contacts
from chain_impact.kernel.events.exclusion import RELATCH_RATIO
from chain_impact.kernel.events.impulses import collide, end_contacts, judge
from chain_impact.kernel.events.search import REFUSED, RELATCH, TOUCH, find_event
from chain_impact.kernel.initialize import derive_law, first_size
from chain_impact.kernel.integration import step_size
from chain_impact.kernel.integration.balance import check_balance, keeps_balance, take_stock
from chain_impact.kernel.integration.dense import fraction, interpolate
from chain_impact.kernel.integration.last_step import (
    OUTPUTS,
    accept,
    choose_variable,
    complete,
    cut,
    see_points,
    see_rate,
    stand,
    take_back,
)
from chain_impact.kernel.integration.method import IMPLICIT
from chain_impact.kernel.integration.methods import attempt, prepare
from chain_impact.kernel.integration.sundman import NO_CONTACT, regularize, time_rate_now
from chain_impact.kernel.integration.switching import (
    begin_explicit,
    begin_flight,
    begin_impact,
    choose_method,
)
from chain_impact.kernel.model.contact import clear_loads, drop_events, latch, list_touching
from chain_impact.kernel.model.contact_force import elastic_depth, latch_damping, may_jump
from chain_impact.kernel.model.equations import state_rate
from chain_impact.kernel.model.geometry import clearance
from chain_impact.kernel.status import (
    LOG_FULL,
    NOT_FINITE,
    OK,
    PAUSED,
    RIGID_WHILE_TOUCHING,
    STEP_TOO_SMALL,
    TOO_MUCH_WORK,
)
from chain_impact.kernel.work_limit import check_events, check_work, overdrawn, work_done

LONGEST_STEP = 1.0  # s; a chain in flight without spin has no other limit
SHORTEST_STEP = 1e-18  # s
COARSE = 1e6  # the error of a step that is too coarse to locate an event in it: a fifth is tried next


def advance(d, time, room, work):
    """Bring the instance to ``time`` [s], not before its present time.

    Returns:
        A status. After a fault the instance stays at the last time it reached. It can go on after LOG_FULL,
        once the ``room`` finished contacts that wait are collected, and after PAUSED, which comes when all
        work exceeds ``work`` evaluations.
    """
    if d.statistics.status == OK and d.inputs.changed:
        d.statistics.status = restart(d)
    if d.statistics.status != OK:
        return d.statistics.status
    while d.step.end < time:
        if d.finished.count >= room:
            return LOG_FULL
        if work_done(d) > work:
            return PAUSED
        d.statistics.status = take_step(d)
        if d.statistics.status != OK:
            stand(d, d.step.end, d.step.state_end)
            return d.statistics.status
    d.step.time = time
    complete(d, OUTPUTS)
    return OK


def restart(d):
    """Drop what lies beyond the communication point, as an input or parameter changed; returns a status."""
    d.inputs.changed = 0
    interpolate(d.step, fraction(d, d.step.time), d.work.y)
    d.step.next_size *= time_rate_now(d, d.work.y)  # in seconds
    stand(d, d.step.time, d.work.y)
    drop_events(d)
    status = change_law(d)
    clear_loads(d)
    # a chain at rest takes steps far too long for what an input may do to it
    d.step.next_size = min(d.step.next_size, first_size(d))
    return status


def change_law(d):
    """Take over the parameters of the contact law as they are now, and judge anew who is held.

    Returns:
        A status: a point inside a wall has no place under a law without depth.
    """
    rigid = d.contact.impulsive
    status = derive_law(d)
    if status == OK and d.touch.active_count > 0 and d.contact.impulsive and not rigid:
        status = RIGID_WHILE_TOUCHING
    if status != OK:
        d.contact.impulsive = rigid  # of the contacts that last, until a law is found for them
    elif d.touch.active_count > 0 and rigid:
        if d.contact.impulsive:
            judge(d)
        else:
            end_contacts(d)
        stand(d, d.step.time, d.step.state_end)
    return status


def take_step(d):
    """Take one accepted step, up to the first event in it; returns a status."""
    for c in range(d.candidates):
        d.rigid.least[c] = 0.0  # of the stages to come
    status = check_events(d, begin(d))
    if status == OK:
        status = find_step(d)
    if status == OK:
        d.statistics.steps += 1
        d.statistics.implicit_steps += d.step.made_by == IMPLICIT
        status = check_balance(d)
    return status if status != OK else check_work(d)


def find_step(d):
    """Try steps of ever smaller size until one is accepted, up to its first event; returns a status."""
    step, grow, error = d.step, step_size.GROW, 0.0
    h = prepare(d, min(step.next_size, LONGEST_STEP))
    while True:
        if h < SHORTEST_STEP or step.end + h == step.end:
            return STEP_TOO_SMALL if math.isfinite(error) else NOT_FINITE
        error = attempt(d, h)
        if error <= 1.0:
            accept(d, h)
            if ends_well(d, find_event(d)):
                step.next_size = h * min(grow, step_size.factor(d, max(error, 1e-16)))
                return OK
            take_back(d)
            drop_events(d)
            error = COARSE
        d.statistics.rejected_steps += 1
        h *= step_size.factor(d, error) if math.isfinite(error) else 0.1
        grow = 1.0
        if overdrawn(d):
            return TOO_MUCH_WORK


def ends_well(d, theta):
    """End the last step at its fraction θ, if it is not −1; returns whether it keeps the ledger up to there.

    The end of a contact is landed on by a step anew: the force is not smooth there, and the interpolant of a
    step across it less accurate than the step.
    """
    if theta == REFUSED:
        return False
    if theta > 0.0 and ends_contact(d):
        h = theta * d.step.size
        take_back(d)
        if not attempt(d, h) <= 1.0:
            return False
        accept(d, h)
        theta = -1.0
    if not keeps_balance(d, theta):
        return False
    if theta >= 0.0:
        cut(d, theta)
    return True


def ends_contact(d):
    """Whether a contact ends in the event that was found, where the step is not smooth for it."""
    if d.step.regularized != NO_CONTACT and d.touch.event[d.step.regularized] == TOUCH:
        return False
    for c in range(d.candidates):
        if d.touch.event[c] == TOUCH and d.touch.active[c]:
            return True
    return False


def begin(d):
    """Let what happened at the end of the last step take effect; returns the number of events."""
    events = 0
    for c in range(d.candidates):
        events += d.touch.event[c] != 0

    see_rate(d)
    if d.touch.active_count > 0:
        see_points(d)
        follow_contacts(d)

    rate = d.work.rate_start
    for j in range(len(d.work.y)):
        rate[j] = d.work.rate_end[j]
    if events > 0 and apply_events(d):
        state_rate(d, d.step.state_end, rate)
        d.statistics.rhs_evaluations += 1
    if events > 0 and d.contact.impulsive:
        d.step.next_size = min(d.step.next_size, step_size.in_flight(d, d.step.state_end, rate))
    if events > 0 or d.balance.breaks != d.step.breaks:
        take_stock(d)
        d.balance.breaks = d.step.breaks
    choose_method(d)
    choose_variable(d, events > 0)
    regularize(d, d.step.state_end, rate, d.work.stage[0])
    return events


def apply_events(d):
    """End and begin the contacts that the last step found, and choose the step that follows.

    Returns:
        Whether a force has jumped, where a contact begins or ends or as a v₀ was latched anew.
    """
    if d.contact.impulsive:
        collide(d)
        begin_explicit(d.step)  # blows move what damping slows down
        return True
    jumped, latched_anew = False, False
    touch = d.touch
    locate_points(d, d.step.state_end)
    if touch.active_count == 0:
        d.step.flight_size = d.step.next_size
    onset = -1
    for c in range(d.candidates):
        if touch.event[c] == RELATCH:
            touch.impact_speed[c] *= RELATCH_RATIO
            touch.depth_scale[c] = elastic_depth(d.contact, touch.effective_mass[c], touch.impact_speed[c])
            latch_damping(d, c)
            jumped, latched_anew = True, True
        elif touch.event[c] == TOUCH and touch.active[c]:
            _, gap_rate = clearance(d, c)
            if gap_rate >= 0.0:  # else it has not left: the tolerance allows its position to be that wrong
                finish(d, c)
                touch.active[c] = 0
            jumped = jumped or may_jump(d.contact)
        elif touch.event[c] == TOUCH:
            latch(d, c)
            touch.active[c] = 1
            onset = c
            jumped = jumped or may_jump(d.contact)
        touch.event[c] = 0

    list_touching(d)
    if touch.active_count == 0:
        clear_loads(d)
        d.step.next_size = min(
            d.step.flight_size, step_size.in_flight(d, d.step.state_end, d.work.rate_start)
        )
        begin_flight(d)
    elif onset >= 0 or not (d.step.method == IMPLICIT or latched_anew):
        d.step.next_size = step_size.at_onset(d, onset if onset >= 0 else touch.active_index[0])
    if onset >= 0:
        begin_impact(d)
    return jumped
