"""Derivatives of dry friction: the times at which modes change, and modes that errors leave open.

The tangent instance takes the modes of the primal run. Sliding ends where the tangential speed t·v is 0.
Sticking ends where µ_s F_n − |F_t| = 0, with µ_s the coefficient of static friction, F_n the normal and F_t
the friction force. The times of these ends depend on the parameters. If the friction force does not drop at
the end of sticking, the time of this end has no effect on the motion, except through the small excess of the
force at which the end is found (events/mode_changes.py).

Derivatives do not exist where a small change of the parameters changes the order of such events, or decides
whether an event occurs, unless the effect is negligible. The effect is a small tangential speed, which
friction stops at once or a little later. This speed changes a position by the speed times the time in which
the chain settles. If the derivatives of this change are a small part of the largest derivative of a position,
the derivatives of the change are neglected: sticking sets the derivatives of the speed to zero.
``trust.neglected`` is the sum of these parts.
"""

import math

from chain_impact.kernel.chain.drives import drive_count, first_joint
from chain_impact.kernel.chain.kinematics import accelerate_points, largest_component, locate_points
from chain_impact.kernel.constraints.constraint_response import mean_mass
from chain_impact.kernel.constraints.geometry import tangential_acceleration, tangential_rate
from chain_impact.kernel.constraints.impulses import activate_all
from chain_impact.kernel.equations import rate_from_points
from chain_impact.kernel.events.marks import count_mode_changes
from chain_impact.kernel.events.mode_changes import friction_round_off, rest_speed
from chain_impact.kernel.events.onset_modes import begins_now
from chain_impact.kernel.forces.friction import list_sticking
from chain_impact.kernel.forces.holding import (
    CONTACT_ADDED_MASS,
    set_unforced_to_speeds,
    solve_stopping_impulses,
)
from chain_impact.kernel.record.constants import NO_FRICTION, SLIDING_ENDS, STICKING_ENDS, STICKS
from chain_impact.kernel.record.state import coordinate_count, velocity_at
from chain_impact.kernel.tangent.duals import DIRECTIONS, dual_with_slope, reciprocal, slope, value
from chain_impact.kernel.tangent.event_times import (
    evaluate_end,
    make_delay,
    make_motion_functions,
    step_length,
)
from chain_impact.kernel.tangent.trust import (
    AT_FRICTION_LIMIT,
    OPEN_DISTANCE,
    SIMULTANEOUS_CHANGES,
    SLIDES_FROM_REST,
    SLOW_CHANGE,
    TRUSTED,
    acceleration_scale,
    check_coefficient,
    fastest_speed,
    largest_displacement,
    largest_slope,
    mark_split,
    mark_untrusted,
)

# Two events are simultaneous also for nearby parameters if, at the time of one event for these parameters,
# the derivatives of the speed or margin that causes the other event are at most SAME_TIME_SLOPE, relative to
# a scale of these derivatives.
SAME_TIME_SLOPE = 1e-5
# The end of sticking is located where the friction force exceeds its limit by a small excess. If the limit
# itself is at most NEARLY_SLIPPING_RATIO times the excess, and the element is marked STOPPED, the located
# time is wrong, and the derivatives end there.
NEARLY_SLIPPING_RATIO = 1000.0
# The largest ``trust.neglected``, the sum of the neglected derivatives of positions in a run, each
# relative to the largest derivative of a position; the derivatives end before the sum exceeds this number.
# With a larger sum, a fit to a position at rest would be wrong by more than some percent.
MOST_NEGLECTED = 1e-2
# a third value of ``friction_element.decided_by_forces``, beside 0 and 1: the element has stuck since an
# onset at zero speed, and sticking has also set the derivatives of its speed to zero
STOPPED = 2


def delay_of_change(t):
    """Return the delay [s] of the mode changes that end the last step, a dual number of value 0.

    The points must be located at the end of the step. If several modes end there, the result belongs to one
    of these ends; ``check_changes`` compares this delay with those of the other ends.
    """
    for i in range(t.friction.active_count):
        e = t.friction_element.index[i]
        if t.friction_element.event[e] == SLIDING_ENDS:
            return delay_of_rest(t, e)
    for i in range(t.friction.active_count):
        e = t.friction_element.index[i]
        if t.friction_element.event[e] == STICKING_ENDS:
            return delay_of_sliding(t, e)
    return dual_with_slope(0.0, 0.0, t.step.end)


def delay_of_rest(t, e):
    """Return the delay [s] of the time at which element e stops sliding, a dual number of the value 0.

    With the tangential speed φ of e and the derivatives φ′ of φ, the delay has the derivatives −φ′/φ̇; but it
    has none if the acceleration φ̇ is so small that φ̇ may be an error.
    """
    rate = value(tangential_acceleration(t, e))
    return dual_with_slope(
        0.0, 0.0 if acceleration_may_be_error(t, e) else -reciprocal(rate), tangential_rate(t, e)
    )


def acceleration_may_be_error(t, e):
    """Return whether the tangential acceleration of element e, which is at rest, may be an error."""
    return abs(value(tangential_acceleration(t, e))) <= value(largest_acceleration_error(t, e))


def largest_acceleration_error(t, e):
    """Return the largest acceleration [m/s²] of element e that an error of the solver may cause.

    It is OPEN_DISTANCE times the tolerance times the acceleration that the friction limit of e could cause.
    """
    return OPEN_DISTANCE * value(t.solver.tolerance) * t.friction_element.friction_limit[e] / mean_mass(t)


# functions for φ = µ_s F_n − |F_t|, the margin of static friction, after the end of a step, and for its rate
# φ̇
margin_after, margin_rate = make_motion_functions(
    lambda t, e: t.friction_element.friction_limit[e] - abs(t.friction_element.force[e])
)
delay_of_margin = make_delay(margin_after)


def delay_of_sliding(t, e):
    """Return the delay [s] of the time at which element e begins to slide, a dual number of the value 0.

    With the margin of static friction φ = µ_s F_n − |F_t|, the delay has the derivatives −φ′/φ̇. If φ falls
    so slowly that errors decide this time, the delay has no derivatives; the derivatives of the run then end,
    too, if the friction drops at this time and the drop matters. The derivatives of the run also end if the
    located time is wrong (NEARLY_SLIPPING_RATIO).
    """
    limit = value(t.friction_element.friction_limit[e])
    turn_rate = fastest_speed(t) / value(t.chain.longest_link)
    if t.friction_element.decided_by_forces[e] == STOPPED and limit <= NEARLY_SLIPPING_RATIO * value(
        friction_round_off(t, e)
    ):
        end_derivatives(t, SLIDES_FROM_REST, e)
    rate = margin_rate(t, e)
    if not -rate > math.sqrt(value(t.solver.tolerance)) * limit * turn_rate:
        if friction_drops(t, e) and step_length(t) > 0.0:
            drop = limit * (1.0 - value(t.law.friction[e]) / value(t.law.static_friction[e]))
            # The friction drops at this time, and a delay of the drop changes the speed of the element. If
            # this change is not negligible, the derivatives end.
            if not (
                rate < 0.0 and is_negligible(t, delay_of_margin(t, e, rate) * (drop / value(mean_mass(t))))
            ):
                end_derivatives(t, SLOW_CHANGE, e)
        rate = -math.inf
    return delay_of_margin(t, e, rate)


def is_negligible(t, speed):
    """Return whether the derivatives of ``speed`` [m/s], a dual number of the value 0, may be neglected.

    The speed times the settling time is a change of a position. The share of this change is the largest ratio
    of the change's derivative to the largest derivative of any position by the same parameter. The result is
    true if ``trust.neglected`` plus the share is at most MOST_NEGLECTED. In this case the share is added to
    ``trust.neglected``; and if the share is not 0, the derivatives of friction impulses count as unknown
    (``mark_split``).
    """
    time, largest_part = settling_time(t), 0.0
    for k in range(DIRECTIONS):
        change = time * abs(slope(speed, k))
        if change != 0.0:
            largest_of_all = largest_slope(t.scratch.position, k)
            if not change <= MOST_NEGLECTED * largest_of_all:
                return False
            largest_part = max(largest_part, change / largest_of_all)
    if t.trust.neglected + largest_part > MOST_NEGLECTED:
        return False
    if largest_part > 0.0:
        t.trust.neglected += largest_part
        mark_split(t)
    return True


def settling_time(t):
    """Return a time [s] in which a chain settles: √(L/(g + L/(1 s)²)), with longest link L and gravity g."""
    return math.sqrt(value(t.chain.longest_link) / acceleration_scale(t))


def friction_drops(t, e):
    """Return whether the friction of element e drops when e begins to slide: at walls with µ < µ_s only.

    µ is the coefficient of sliding friction, µ_s that of static friction.
    """
    if e >= t.candidate_count:
        return False
    return value(t.law.static_friction[e]) > value(t.law.friction[e])


def check_changes(t, delay):
    """End the derivatives if mode changes at the last step's end have other delays than ``delay`` [s].

    A change with another delay is allowed if its effect is negligible.

    Args:
        t: the tangent instance, with the points located at the end of the last step.
        delay: the delay of one of the changes, a dual number of value 0.
    """
    stopped_count, is_any_slow = 0, False
    for i in range(t.friction.active_count):
        e = t.friction_element.index[i]
        if t.friction_element.mode[e] != STICKS:
            speed = tangential_rate(t, e)
            stops = t.friction_element.event[e] == SLIDING_ENDS or abs(value(speed)) <= value(rest_speed(t))
            stopped_count += stops
            is_any_slow = is_any_slow or (stops and acceleration_may_be_error(t, e))
            speed_after = speed + value(tangential_acceleration(t, e)) * delay
            if stops and not stays_at_rest(t, speed_after, delay) and not is_negligible(t, speed_after):
                end_derivatives(
                    t, SLOW_CHANGE if acceleration_may_be_error(t, e) else SIMULTANEOUS_CHANGES, e
                )
    # If several elements stop, or if an acceleration may be an error, the derivatives of friction impulses
    # are not known: for example, the friction at each end of a rod on a floor depends on the times at which
    # the two ends stop.
    if stopped_count > 1 or is_any_slow:
        mark_split(t)
    if count_mode_changes(t) > 1:
        for i in range(t.friction.active_count):
            e = t.friction_element.index[i]
            matters = t.friction_element.event[e] == STICKING_ENDS and (
                friction_drops(t, e) or any_stops_sliding(t)
            )
            if matters and not slips_for_nearby_parameters(t, e, delay):
                end_derivatives(t, SIMULTANEOUS_CHANGES, e)
        evaluate_end(t)


def slips_for_nearby_parameters(t, e, delay):
    """Return whether element e begins to slide at a delayed time for nearby parameters, too.

    This is so if the margin of static friction of e, whose value is zero, has no derivatives at that time.
    ``delay`` [s] is the delay, a dual number of value 0; derivatives up to SAME_TIME_SLOPE times a scale
    count as zero.
    """
    margin = margin_after(t, e, delay)
    force, limit = t.friction_element.force[e], t.friction_element.friction_limit[e]
    for k in range(DIRECTIONS):
        scale = abs(slope(force, k)) + abs(slope(limit, k)) + value(limit) * largest_displacement(t, k)
        if abs(slope(margin, k)) > SAME_TIME_SLOPE * scale:
            return False
    return True


def any_stops_sliding(t):
    """Return whether an element stops sliding at the end of the last step."""
    for i in range(t.friction.active_count):
        if t.friction_element.event[t.friction_element.index[i]] == SLIDING_ENDS:
            return True
    return False


def stays_at_rest(t, speed_after, delay):
    """Return whether an element at rest is at rest after a delay ``delay`` [s] for nearby parameters, too.

    ``speed_after`` is the element's speed after the delay, a dual number of the value 0. The result is true
    if the derivatives of ``speed_after`` are almost zero (SAME_TIME_SLOPE).
    """
    largest_acceleration = value(largest_component(t, t.scratch.acceleration))
    for k in range(DIRECTIONS):
        scale = largest_slope(t.scratch.velocity, k) + fastest_speed(t) * largest_displacement(t, k)
        if abs(slope(speed_after, k)) > SAME_TIME_SLOPE * (
            scale + largest_acceleration * abs(slope(delay, k))
        ):
            return False
    return True


def make_modes_consistent(t):
    """Set the modes of dry friction to those of the primal run.

    The derivatives end if errors of the run, not the forces, have decided one of these modes, and this choice
    matters (``is_nearly_at_limit``).
    """
    for e in range(t.friction_element_count):
        # the mode of an element whose sticking has just ended is certain
        if t.friction_element.mode_before[e] == STICKS and t.friction_element.mode[e] != STICKS:
            t.friction_element.decided_by_forces[e] = 0
        t.friction_element.mode[e] = t.friction_element.chosen_mode[e]
    list_sticking(t)
    if any_begins_to_stick(t):
        clear_sticking_speeds(t)
    check_onsets_at_rest(t)
    rate_from_points(t, t.step.state_end, t.scratch.rate)
    accelerate_points(t, t.step.state_end, t.scratch.rate)
    for i in range(t.friction.active_count):
        e = t.friction_element.index[i]
        if t.friction_element.decided_by_forces[e] and is_nearly_at_limit(t, e):
            end_derivatives(t, AT_FRICTION_LIMIT, e)


def any_begins_to_stick(t):
    """Return whether any element that has slid up to now begins to stick at this event."""
    for i in range(t.friction.stuck_count):
        mode_before = t.friction_element.mode_before[t.friction_element.stuck_index[i]]
        if mode_before not in (STICKS, NO_FRICTION):
            return True
    return False


def clear_sticking_speeds(t):
    """Set the derivatives of the speeds of sticking elements to zero, without the added mass of contacts.

    In a projection (``project_state``), contacts with a force law resist (``contact_added_mass``), so a part
    of the derivatives would stay as long as the elements stick, for example for a rod that lies almost flat.
    """
    activate_all(t)
    set_unforced_to_speeds(t)
    solve_stopping_impulses(t)
    first = velocity_at(t.link_count)
    for j in range(coordinate_count(t.link_count)):
        t.step.state_end[first + j] += dual_with_slope(0.0, 1.0, t.constraints.change[j])
    locate_points(t, t.step.state_end)


def check_onsets_at_rest(t):
    """Check elements whose friction begins now at a speed that is zero, but has derivatives.

    If such an element sticks, sticking stops the speed also for nearby parameters, and the element is marked
    STOPPED. If the element slides, friction would stop only a speed against the direction of sliding, and the
    derivatives end.
    """
    for i in range(t.friction.active_count):
        e = t.friction_element.index[i]
        if t.friction_element.decided_by_forces[e] and t.friction_element.mode_before[e] == NO_FRICTION:
            speed = tangential_rate(t, e)
            if not stays_at_rest(t, speed, dual_with_slope(0.0, 0.0, speed)):
                if t.friction_element.mode[e] == STICKS:
                    t.friction_element.decided_by_forces[e] = STOPPED
                else:
                    end_derivatives(t, SLIDES_FROM_REST, e)


def contact_added_mass(t):
    """Return the mass [kg] with which a contact resists a projection; 0 at an onset with a STOPPED element.

    At such an onset the forces of contacts are still small while friction stops the speed. Otherwise the
    result is the same as in forces/holding.py.
    """
    for i in range(t.friction.stuck_count):
        e = t.friction_element.stuck_index[i]
        if t.friction_element.decided_by_forces[e] == STOPPED and begins_now(t, e):
            return dual_with_slope(0.0, 0.0, t.step.end)
    return CONTACT_ADDED_MASS * mean_mass(t)


def check_coefficients(t):
    """Mark the parameters that change the friction of a contact, a joint or the slider if this friction is 0.

    The motion has only one-sided derivatives with respect to such parameters (``check_coefficient``).
    """
    if t.friction_element_count == 0:
        return
    for c in range(t.candidate_count):
        if t.contacts.active[c]:
            check_coefficient(t, t.law.static_friction[c])
    for i in range(first_joint(t), drive_count(t)):
        check_coefficient(t, t.drive.friction[i])


def is_nearly_at_limit(t, e):
    """Return whether errors decide if e, whose mode forces decide, sticks or slides, and this matters.

    This is so if the force that would hold e at rest nearly equals the limit of friction. If the effect of
    the choice is negligible, the result is false.
    """
    limit, errors = value(t.friction_element.friction_limit[e]), OPEN_DISTANCE * value(t.solver.tolerance)
    if limit <= value(friction_round_off(t, e)):
        return False
    mass, time = value(mean_mass(t)), settling_time(t)
    if t.friction_element.mode[e] == STICKS:
        margin = t.friction_element.friction_limit[e] - abs(t.friction_element.force[e])
        is_near = abs(value(margin)) <= errors * limit
        return is_near and (friction_drops(t, e) or not is_negligible(t, margin * (time / mass)))
    is_slow = not friction_drops(t, e) and acceleration_may_be_error(t, e)
    return is_slow and not is_negligible(t, tangential_acceleration(t, e) * time)


def end_derivatives(t, reason, e):
    """End the derivatives at the end of the last step because of element e, unless they have ended before.

    ``reason`` is one of the numbers in trust.py.
    """
    if t.trust.reason == TRUSTED:
        mark_untrusted(t, reason, e, value(t.step.end))
