"""Impact at a rigid wall: instantaneous impulses, and the contacts that stay active after the impulses.

Newton's law of impact is valid for any number of contacts at once, in the form of Moreau (1988, *Unilateral
contact and dry friction in finite freedom dynamics*). The law holds for all candidates that touch: those that
arrive, and those that are held, with ġ = 0. (docs/development/terms.md explains words such as held.) It reads

    u⁺ = u⁻ + W p,   0 ≤ p ⟂ u⁺ + e u⁻ ≥ 0,

where u⁻ and u⁺ are the normal speeds before and after the impact, away from the wall, p the impulses, W the
inverse of the mass matrix along the normals, and e the restitution. a ⟂ b means that a or b is 0. A held
contact has e = 0. A point that arrives slower than the minimum impact speed of its law has e = 0, too, so
that a bouncing point comes to rest after finitely many impacts. Every impulse p > 0 does the work ½ p (u⁺ +
u⁻) = ½ p (1 − e) u⁻ ≤ 0, so no impact adds energy. (A point that almost touches a wall and moves away from
this wall has u⁻ > 0, and could gain energy. An impact that would add energy is therefore computed with e = 0
for all contacts; such an impact adds no energy.)

A contact ends if its point separates with a speed above a limit (``end_rebounding_contacts``). The points of
all other contacts do not move along the normals. Forces F hold these points as long as the forces push:

    0 ≤ F ⟂ g̈ ≥ 0.

A contact with a force law whose onset is at the moment of an impact begins after the impact, with the speed
that the impulses leave. If the impulses turn the point back, the contact does not begin.
"""

import math

from chain_impact.kernel.chain.kinematics import locate_points, locate_points_now
from chain_impact.kernel.chain.mass_matrix_solver import copy_factors
from chain_impact.kernel.constraints.complementarity import solve_lcp
from chain_impact.kernel.constraints.constraint_response import joints_add_terms, mean_mass
from chain_impact.kernel.constraints.geometry import (
    clearance_and_rate,
    coordinate_sum,
    is_at_joint_stop,
    largest_coordinate,
    largest_velocity,
)
from chain_impact.kernel.constraints.impulses import (
    SIGN_TOLERANCE,
    activate_all,
    add_to_active_set,
    any_point_held,
    factorize_free,
    remove_from_active_set,
)
from chain_impact.kernel.equations import free_rate_from_inputs
from chain_impact.kernel.events.contact_log import end_contact
from chain_impact.kernel.events.friction_modes import choose_friction_modes
from chain_impact.kernel.events.marks import drop_contact_events, mark_contact_event
from chain_impact.kernel.forces.active_contacts import (
    begin_force_law_contact,
    clear_applied_forces,
    deactivate_candidate,
    join_impact,
    latch_onset,
    list_active_contacts,
    set_kink_side,
    set_start_rates,
)
from chain_impact.kernel.forces.friction import list_sticking, set_element_anchor, suspend_sticking
from chain_impact.kernel.forces.holding import (
    LEAST_RISE,
    add_change,
    set_unforced_to_accelerations,
    set_unforced_to_positions,
    set_unforced_to_speeds,
    solve_positions,
    work_of_impulses,
)
from chain_impact.kernel.ode.falls import project_end
from chain_impact.kernel.ode.last_step import count_dissipated, count_supplied
from chain_impact.kernel.ode.quadratures import add_impulses_of_impact
from chain_impact.kernel.record.constants import NEIGHBOUR, ONSET, RELEASE
from chain_impact.kernel.record.state import velocity_at

# A point rebounds only with a speed above LEAST_REBOUND_SPEED times the minimum impact speed of the contact's
# law; a slower point does not separate. Otherwise a point whose bounces get slower and slower would bounce
# infinitely often in a finite time (Zeno behaviour).
LEAST_REBOUND_SPEED = 1e-3
# IMPACT_ROUND_OFF: the round-off of the energy of an impact, relative to Σ p (|u⁻| + |u⁺|), with the impulses
# p and the speeds u⁻ before and u⁺ after them; and the round-off of a speed, relative to the largest speed.
IMPACT_ROUND_OFF = 1e-9
# A point that is released gets a small clearance, far larger than round-off, so that round-off does not make
# the point touch again: the larger of RELEASE_CLEARANCE times the longest link and RELEASE_OF_COORDINATES
# times the size of the coordinates whose round-off enters the clearance.
RELEASE_CLEARANCE, RELEASE_OF_COORDINATES = 1e-13, 1e-14
# The distance NEAR_WALL_CLEARANCE × ``release_clearance`` has two uses, both against endless impacts. A point
# with a smaller clearance almost touches its wall (``join_near_contacts``). And in an impact whose points
# have at most the energy that weight and dry friction take over this distance, elements that stick continue
# to stick (``is_gentle``). So both uses include a point that has just been released.
NEAR_WALL_CLEARANCE = 10.0


def handle_rigid_impacts(d):
    """Apply the events at rigid walls for the located points: first the impulses, then the new active set.

    Onsets of contacts with a force law that are still marked in ``contacts.event`` are applied after the
    impulses, because the impulses change the points' speeds.

    Returns:
        The last candidate with a force law whose contact began, or −1 if none began.
    """
    contacts, onset = d.contacts, -1
    # the state may be interpolated, so that it violates the constraints a little, and is projected first
    project_end(d)
    has_hit = False
    for c in range(d.candidate_count):
        if contacts.event[c] == ONSET and d.law.rigid[c]:
            latch_onset(d, c)
            has_hit = True
    if has_hit:
        join_near_contacts(d)
    list_active_contacts(d)
    if has_hit:
        impact_is_gentle = d.friction.stuck_count > 0 and is_gentle(d)
        if not impact_is_gentle:
            suspend_sticking(d)
        apply_impulses(d)
        end_rebounding_contacts(d)
        if d.friction.may_act:
            stop_held_points(d, impact_is_gentle)
        set_rates_after_impulses(d)
        onset = begin_late_contacts(d)
        if d.friction.may_act:
            choose_friction_modes(d, True)
    update_active_set(d)
    clear_applied_forces(d)
    return onset


def has_rigid_onset(d):
    """Return whether an onset is marked at a rigid wall or a rigid stop."""
    for c in range(d.candidate_count):
        if d.contacts.event[c] == ONSET and d.law.rigid[c]:
            return True
    return False


def begin_late_contacts(d):
    """Begin contacts with a force law whose onset is marked, if their points still move inward.

    The impulses of the impact may have turned a point back. Returns the last candidate whose contact begins,
    or −1 if no contact begins.
    """
    onset, round_off = -1, SIGN_TOLERANCE * largest_velocity(d)
    for c in range(d.candidate_count):
        _, clearance_rate = clearance_and_rate(d, c)
        if d.contacts.event[c] == ONSET and not d.law.rigid[c] and clearance_rate < -round_off:
            begin_force_law_contact(d, c)
            onset = c
    list_active_contacts(d)
    return onset


def set_rates_after_impulses(d):
    """Store, for each contact with a force law, its rates after the impulses, and the side of its kink.

    The rates are those of the penetration and of the force, from which the next step starts. A force law may
    have a kink (``kink_height``).
    """
    locate_points_now(d, d.step.state_end)
    for k in range(d.contacts.force_law_count):
        c = d.contacts.active_index[k]
        _, clearance_rate = clearance_and_rate(d, c)
        # The force may have jumped to its peak, and its true rate may be negative, which would hide this peak
        # from the next search. So the rate of the force is set to a positive value, 1.0.
        set_start_rates(d, c, -clearance_rate, 1.0)
        set_kink_side(d, c)


def join_near_contacts(d):
    """Let the points that almost touch a rigid wall take part in the impact, marked as NEIGHBOUR.

    Otherwise a link wedged between two walls would hit the walls in turn, infinitely often in a finite time.
    """
    contacts, position_scale = d.contacts, largest_coordinate(d)
    for c in range(d.candidate_count):
        clearance, _ = clearance_and_rate(d, c)
        if (
            d.law.rigid[c]
            and not contacts.active[c]
            and clearance < NEAR_WALL_CLEARANCE * release_clearance(d, c, position_scale)
        ):
            join_impact(d, c)
            mark_contact_event(d, c, NEIGHBOUR)


def apply_impulses(d):
    """Apply the impulses of an impact to the velocities; count lost energy and the work of moving walls.

    A candidate marked NEIGHBOUR that gets an impulse has its onset now. Afterwards the points are located.
    """
    loss, exchange = find_impulses(d, 1.0)
    if loss < -IMPACT_ROUND_OFF * exchange or lacks_rebound(d):
        # The impulses add energy, as a NEIGHBOUR that moves away from its wall can cause, or a wedged point
        # cannot rebound. In both cases the impulses are found again with the restitution 0 of all contacts.
        loss, _ = find_impulses(d, 0.0)
    for k in range(d.contacts.active_count):
        c = d.contacts.active_index[k]
        if d.contacts.event[c] == NEIGHBOUR and d.constraints.impulse[k] > 0.0:
            latch_onset(d, c)
    add_change(d, d.step.state_end, velocity_at(d.link_count))
    count_dissipated(d, max(0.0, loss))
    if d.channel_count > 0:
        count_supplied(d, work_of_impulses(d))
    add_impulses_of_impact(d)
    locate_points_now(d, d.step.state_end)


def find_impulses(d, fraction):
    """Find the impulses of an impact, with the restitution of each contact multiplied by ``fraction``.

    Returns:
        The energy [J] that the impulses p dissipate, and Σ p (|u⁻| + |u⁺|) [J], with u⁻ and u⁺ the speeds
        before and after the impulses.
    """
    constraints, loss, exchange = d.constraints, 0.0, 0.0
    activate_all(d)
    set_unforced_to_speeds(d)
    for k in range(d.contacts.force_law_count, d.contacts.active_count):
        c = d.contacts.active_index[k]
        least_speed = d.law.minimum_impact_speed[c]
        arrives = -constraints.unforced_motion[k] >= least_speed and d.contacts.event[c] in (ONSET, NEIGHBOUR)
        # for a point that arrives with u⁻ < 0, the speed u⁺ after the impact is at least the restitution e
        # times the approach speed: u⁺ ≥ −e u⁻
        rebound_speed = -fraction * d.law.restitution[c] * constraints.unforced_motion[k] if arrives else 0.0
        add_to_active_set(d, k, rebound_speed if rebound_speed > LEAST_REBOUND_SPEED * least_speed else 0.0)
    factorize_free(d)
    solve_lcp(d, largest_velocity(d))
    for k in range(d.contacts.active_count):
        # the energy that an impulse p dissipates, −½ p (u⁻ + u⁺), with the speeds u⁻ before and u⁺ after the
        # impulse
        loss -= (
            0.5 * constraints.impulse[k] * (constraints.unforced_motion[k] + constraints.reached_motion[k])
        )
        exchange += constraints.impulse[k] * (
            abs(constraints.unforced_motion[k]) + abs(constraints.reached_motion[k])
        )
    return loss, exchange


def lacks_rebound(d):
    """Return whether any point separates more slowly after the impulses than the restitution demands.

    This happens to a wedged point, to which no impulses can give the demanded speed.
    """
    is_slow, scale = False, largest_velocity(d)
    for k in range(d.contacts.force_law_count, d.contacts.active_count):
        is_slow = (
            is_slow
            or d.constraints.reached_motion[k] < d.constraints.target_motion[k] - IMPACT_ROUND_OFF * scale
        )
    return is_slow


def end_rebounding_contacts(d):
    """End the contacts whose points separate after the impulses, with a speed above a limit.

    The limit follows from LEAST_REBOUND_SPEED and LEAST_RISE. Candidates marked NEIGHBOUR that got no impulse
    become inactive, too, without an entry in the log.
    """
    free_rate_from_inputs(d, d.step.state_end, d.scratch.rate)
    largest_acceleration = set_unforced_to_accelerations(d, d.step.state_end, d.scratch.rate)
    # A point with the speed u rises to u²/(2 a) against a, the largest component of the accelerations of all
    # places. This height must exceed LEAST_RISE times the longest link.
    limit = math.sqrt(2.0 * largest_acceleration * LEAST_RISE * d.chain.longest_link)
    for k in range(d.contacts.force_law_count, d.contacts.active_count):
        c = d.contacts.active_index[k]
        if d.contacts.event[c] == NEIGHBOUR and d.constraints.impulse[k] <= 0.0:
            deactivate_candidate(d, c)  # this point is near its wall, but takes no part in the impact
        elif d.constraints.reached_motion[k] > max(
            limit, LEAST_REBOUND_SPEED * d.law.minimum_impact_speed[c]
        ):
            end_contact(d, c, True)
    list_active_contacts(d)


def is_gentle(d):
    """Return whether an impact is gentle: the points at rigid walls are slow, or have little energy together.

    The points are those that arrive at rigid walls now. The limit of the speeds follows from
    LEAST_REBOUND_SPEED, the limit of the kinetic energy from NEAR_WALL_CLEARANCE. In a gentle impact,
    elements of dry friction that stick continue to stick. If the small impulses could make a joint slide, the
    joint's friction would lift points, these points would arrive gently again, and so on without end.
    """
    force = mean_mass(d) * d.link_count * (d.chain.gravity_magnitude + d.chain.longest_link)
    are_slow, energy, distance, position_scale = True, 0.0, 0.0, largest_coordinate(d)
    for c in range(d.candidate_count):
        if d.contacts.event[c] == ONSET and d.law.rigid[c]:
            speed = d.contacts.impact_speed[c]
            are_slow = are_slow and speed <= LEAST_REBOUND_SPEED * d.law.minimum_impact_speed[c]
            energy += 0.5 * d.contacts.effective_mass[c] * speed * speed
            distance = max(distance, NEAR_WALL_CLEARANCE * release_clearance(d, c, position_scale))
    for i in range(d.friction.stuck_count):
        force += d.friction_element.friction_limit[d.friction_element.stuck_index[i]]
    return are_slow or energy <= force * distance


def stop_held_points(d, impact_is_gentle):
    """Stop held points along their normals; after a gentle impact also stop the sticking elements."""
    if not impact_is_gentle:
        suspend_sticking(d)
    locate_points(d, d.step.state_end)
    project_end(d)


def end_changed_contacts(d):
    """End each held contact whose wall or stop has changed to a force law, so that new contacts can begin."""
    locate_points(d, d.step.state_end)
    for k in range(d.contacts.force_law_count, d.contacts.active_count):
        c = d.contacts.active_index[k]
        if not d.law.rigid[c]:
            end_contact(d, c, True)
    list_active_contacts(d)


def update_active_set(d):
    """End each contact at a rigid wall that would have to pull its point; the other contacts stay active.

    Before this choice, the state is projected onto the constraints, and contacts end whose points the
    projection does not stop. The points of contacts that end by the choice get a small clearance. Afterwards
    no candidate is marked with an event.
    """
    contacts, state = d.contacts, d.step.state_end
    if any_point_held(d):
        locate_points(d, state)
        project_end(d)
        end_unstopped_contacts(d)
        rate = d.scratch.rate
        free_rate_from_inputs(d, state, rate)
        copy_factors(d, joints_add_terms(d))
        scale = set_unforced_to_accelerations(d, state, rate)
        activate_all(d)
        for k in range(contacts.force_law_count, contacts.active_count):
            if contacts.event[contacts.active_index[k]] == RELEASE:
                remove_from_active_set(d, k)
        solve_lcp(d, scale)
        release_contacts(d)
        list_active_contacts(d)
    # only events of contacts are dropped: marked changes of friction modes are still needed, because the
    # modes are chosen later
    drop_contact_events(d)


def end_unstopped_contacts(d):
    """End the held contacts whose points the projection did not stop: only a pull could stop such a point."""
    scale = largest_velocity(d)
    for k in range(d.contacts.force_law_count, d.contacts.active_count):
        if not d.constraints.in_active_set[k] and d.constraints.reached_motion[k] > SIGN_TOLERANCE * scale:
            end_contact(d, d.contacts.active_index[k], True)
    list_active_contacts(d)


def release_clearance(d, c, position_scale):
    """Return the clearance [m] that the point of candidate c gets when its wall releases it.

    ``position_scale`` [m] is the result of ``largest_coordinate``. At a joint's stop the size of the joint's
    angles (``coordinate_sum``) is used in place of ``position_scale``, because the round-off of angles does
    not grow with the distance from the origin.
    """
    coordinate_scale = coordinate_sum(d, c, d.step.state_end) if is_at_joint_stop(d, c) else position_scale
    return max(RELEASE_CLEARANCE * d.chain.longest_link, RELEASE_OF_COORDINATES * coordinate_scale)


def release_contacts(d):
    """End held contacts outside the active set, and give their points a clearance, ``release_clearance``.

    If the function moves points, sticking elements get new anchors there.
    """
    is_any_released, position_scale = False, largest_coordinate(d)
    set_unforced_to_positions(d)
    for k in range(d.contacts.force_law_count, d.contacts.active_count):
        c, is_released = d.contacts.active_index[k], not d.constraints.in_active_set[k]
        add_to_active_set(d, k, release_clearance(d, c, position_scale) if is_released else 0.0)
        if is_released:
            end_contact(d, c, True)
            is_any_released = True
    if is_any_released:
        # no element sticks while points are moved: a sticking joint could not move away from its stop
        suspend_sticking(d)
        solve_positions(d)
        add_change(d, d.step.state_end, 0)
        if d.friction.may_act:
            locate_points(d, d.step.state_end)
            list_sticking(d)
            for i in range(d.friction.stuck_count):
                set_element_anchor(d, d.friction_element.stuck_index[i])
