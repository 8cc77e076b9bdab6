"""The modes of dry friction after an event: which elements stick, and which slide in which direction.

An element that moves along the tangent t slides in the direction of its motion. The mode of an element at
rest follows from the forces. The element sticks if the force that holds it is within the limit of static
friction. Otherwise it slides: a motion begins, and friction acts against this motion. The conditions are

    sticks    |F_t| ≤ µ_s F_n        slides with s    s t·a ≥ 0.

F_t is the friction force along t, µ_s the coefficient of static friction, F_n the normal force, s = ±1 the
direction of sliding, and t·a the tangential acceleration. In a joint or slider the given friction takes the
place of µ_s F_n. Motion, rest and t·a at a wall are relative to the wall's belt. The modes of elements at
rest are found by pivoting, as in ``solve_lcp``. In each pivot all elements that violate the condition of
their mode change their modes, and all other elements keep their modes. The pivots end when no element
violates its condition. If the number of violations stops falling before, the modes follow from forces within
the limits of friction (constraints/friction_limits.py); such forces always exist.
"""

import math

from chain_impact.kernel.chain.kinematics import accelerate_points, largest_component, locate_points
from chain_impact.kernel.constraints.complementarity import MAX_STALLED_PIVOTS, count_stalls
from chain_impact.kernel.constraints.friction_limits import find_limited_forces
from chain_impact.kernel.constraints.geometry import has_sticking, tangential_acceleration, tangential_rate
from chain_impact.kernel.cost import count_evaluations
from chain_impact.kernel.equations import rate_from_points
from chain_impact.kernel.events.marks import drop_mode_marks
from chain_impact.kernel.events.mode_changes import friction_round_off, rest_speed
from chain_impact.kernel.events.onset_modes import begins_now, decide_onsets
from chain_impact.kernel.forces.friction import (
    clear_other_forces,
    joint_number,
    list_friction,
    list_sticking,
    set_element_anchor,
    set_friction_mode,
    set_friction_used,
    sliding_sign,
)
from chain_impact.kernel.function_marks import has_dual_rule
from chain_impact.kernel.ode.falls import project_end
from chain_impact.kernel.ode.last_step import reset_step
from chain_impact.kernel.record.constants import NO_FRICTION, SLIDING_ENDS, STICKING_ENDS, STICKS

# For an element at rest with the mode "slides": the acceleration against the direction of sliding that counts
# as an error, relative to the sum of the largest acceleration, gravity and the longest link per second
# squared; ``acceleration_error`` adds a second part. A larger acceleration makes the mode inconsistent.
ACCELERATION_ERROR = 1e-9
# An element that sticks or has just stopped may have a speed up to SPEED_ERROR_AT_REST, relative to the
# longest link per second, as an error at a loose tolerance; a faster element counts as moving.
SPEED_ERROR_AT_REST = 1e-3


def choose_friction_modes(d, speeds_may_jump):
    """Choose the modes of friction at the end of the last step; if any element sticks, project this end.

    An element that begins to stick or, with ``speeds_may_jump``, any element that sticks is anchored at its
    present coordinate. The projection moves sticking elements to their anchors, and held points to their
    walls. The changes of modes are logged. The marks that say that a mode of friction or of a drive ends
    (events/marks.py) are removed.

    Args:
        d: the instance, with the points located at the end of the last step.
        speeds_may_jump: whether speeds may have jumped. If not, an element that stuck up to now counts as at
            rest in spite of a small speed, which is a numerical error.
    """
    friction = d.friction
    list_friction(d)
    for e in range(d.friction_element_count):
        d.friction_element.mode_before[e] = NO_FRICTION if begins_now(d, e) else d.friction_element.mode[e]
        set_friction_mode(d, e, NO_FRICTION)
    for i in range(friction.active_count):
        set_friction_mode(
            d, d.friction_element.index[i], first_mode(d, d.friction_element.index[i], speeds_may_jump)
        )
    drop_mode_marks(d)
    decide_onsets(d)
    make_modes_consistent(d)
    clear_other_forces(d)
    for i in range(friction.stuck_count):
        e = d.friction_element.stuck_index[i]
        if speeds_may_jump or d.friction_element.mode_before[e] != STICKS:
            set_element_anchor(d, e)
    log_changes(d)
    for i in range(friction.active_count):
        set_slack(d, d.friction_element.index[i])
    if has_sticking(d):
        project_end(d)
    for i in range(friction.active_count):
        widen_slack(d, d.friction_element.index[i])


def restart_friction_modes(d, speeds_may_jump):
    """Choose the modes anew (``choose_friction_modes``), after parameters, inputs or the state have been set.

    If the scene neither has dry friction nor had any until now, no modes are chosen; else the last step is
    reset to zero length at the end.

    Args:
        d: the instance.
        speeds_may_jump: whether speeds may have jumped, as for ``choose_friction_modes``.
    """
    set_friction_used(d)
    if d.friction.may_act or d.friction.active_count > 0:
        locate_points(d, d.step.state_end)
        choose_friction_modes(d, speeds_may_jump)
        reset_step(d, d.step.end, d.step.state_end)


def set_slack(d, e):
    """Set the slack of element e: the speed [m/s] against the direction of sliding that counts as an error.

    If forces decide e (``first_mode``), and its mode is the mode before or is inconsistent
    (``is_inconsistent``), the slack is the tolerance times the longest link per second. In any other case the
    slack is 0.
    """
    unchanged = is_inconsistent(d, e) or d.friction_element.mode[e] == d.friction_element.mode_before[e]
    d.friction_element.slack[e] = (
        d.solver.tolerance * d.chain.longest_link
        if unchanged and d.friction_element.decided_by_forces[e]
        else 0.0
    )


def widen_slack(d, e):
    """Widen the slack of e, if forces decide its mode, to twice its speed against the direction of sliding.

    A slack that is already larger is unchanged. The exact speed of e is zero; the computed speed is an error.
    """
    backward = -d.friction_element.mode[e] * tangential_rate(d, e)
    if d.friction_element.decided_by_forces[e]:
        d.friction_element.slack[e] = max(d.friction_element.slack[e], 2.0 * backward)


def first_mode(d, e, speeds_may_jump):
    """Return a first mode of element e; forces decide later if e is at rest or its sticking ends.

    At rest means that the speed is 0 up to a tolerance. The mode of a moving element is the sign of the
    motion. An element at rest keeps its mode, but sticks if its sliding ends or its contact begins. An
    element whose sticking ends slides against the friction force. ``make_modes_consistent`` may change the
    mode of an element that forces decide. ``speeds_may_jump``: whether speeds may have jumped.
    """
    speed = tangential_rate(d, e)
    mode_before, event = d.friction_element.mode_before[e], d.friction_element.event[e]
    d.friction_element.decided_by_forces[e] = 1
    if event == STICKING_ENDS:
        return sliding_sign(d.friction_element.force[e])
    is_at_rest = event == SLIDING_ENDS or (mode_before == STICKS and not speeds_may_jump)
    if is_at_rest and abs(speed) <= SPEED_ERROR_AT_REST * d.chain.longest_link:
        return STICKS
    # an element that has been sliding counts as at rest up to its slack: a speed below the slack may be an
    # error
    slides = abs(mode_before) == 1 and not speeds_may_jump
    if abs(speed) > rest_speed(d) + (d.friction_element.slack[e] if slides else 0.0):
        d.friction_element.decided_by_forces[e] = 0
        return sliding_sign(-speed)
    return STICKS if mode_before == NO_FRICTION else mode_before


@has_dual_rule
def make_modes_consistent(d):
    """Change the modes that forces decide until all are consistent with forces and accelerations.

    If the number of inconsistent modes stops falling before, the modes are chosen from forces within the
    limits of friction.
    """
    fewest, stalls_left = d.friction.active_count + 1, MAX_STALLED_PIVOTS
    while stalls_left >= 0:
        inconsistent_count = count_inconsistent_now(d)
        if inconsistent_count == 0:
            return
        fewest, stalls_left = count_stalls(inconsistent_count, fewest, stalls_left)
        for i in range(d.friction.active_count):
            e = d.friction_element.index[i]
            if is_inconsistent(d, e):
                set_friction_mode(
                    d,
                    e,
                    sliding_sign(d.friction_element.force[e])
                    if d.friction_element.mode[e] == STICKS
                    else STICKS,
                )
    choose_by_limits(d)


def count_inconsistent_now(d):
    """Compute forces and accelerations with the present modes; return the number of inconsistent modes."""
    rate = d.scratch.rate
    list_sticking(d)
    rate_from_points(d, d.step.state_end, rate)
    count_evaluations(d, 1)
    accelerate_points(d, d.step.state_end, rate)
    return count_inconsistent(d)


def choose_by_limits(d):
    """Let elements at rest stick, except those whose forces reach limits (constraints/friction_limits.py).

    An element whose force is at its limit gets the mode "slides", even if the forces of other elements hold
    this element.
    """
    for i in range(d.friction.active_count):
        if d.friction_element.decided_by_forces[d.friction_element.index[i]]:
            set_friction_mode(d, d.friction_element.index[i], STICKS)
    while count_inconsistent_now(d) > 0 and any_force_over_limit(d):
        find_limited_forces(d)
        slide_at_limits(d)


def any_force_over_limit(d):
    """Return whether any mode that forces decide sticks with a force above its limit, beyond round-off."""
    for i in range(d.friction.stuck_count):
        if is_inconsistent(d, d.friction_element.stuck_index[i]):
            return True
    return False


def slide_at_limits(d):
    """Let those sticking elements slide whose forces by ``find_limited_forces`` are at their limits.

    If no force is at its limit, all elements could stick, with other shares of the forces. In this case the
    element slides whose constraint force exceeds its limit most, and no other element.
    """
    are_all_sticking, element, largest_excess = True, -1, -math.inf
    for i in range(d.friction.stuck_count):
        e = d.friction_element.stuck_index[i]
        excess = abs(d.friction_element.force[e]) - d.friction_element.friction_limit[e]
        if d.limited_forces.at_limit[i] != 0:
            set_friction_mode(d, e, sliding_sign(float(d.limited_forces.at_limit[i])))
            are_all_sticking = False
        elif is_inconsistent(d, e) and excess > largest_excess:
            element, largest_excess = e, excess
    if are_all_sticking:
        set_friction_mode(d, element, sliding_sign(d.friction_element.force[element]))


def count_inconsistent(d):
    """Return the number of elements with friction for which ``is_inconsistent`` is true."""
    inconsistent_count = 0
    for i in range(d.friction.active_count):
        inconsistent_count += is_inconsistent(d, d.friction_element.index[i])
    return inconsistent_count


def is_inconsistent(d, e):
    """Return whether forces decide e, and its mode contradicts the present forces and accelerations."""
    if not d.friction_element.decided_by_forces[e]:
        return False
    if d.friction_element.mode[e] == STICKS:
        return abs(d.friction_element.force[e]) > (
            d.friction_element.friction_limit[e] + 0.5 * friction_round_off(d, e)
        )
    acceleration = d.friction_element.mode[e] * tangential_acceleration(d, e)
    return acceleration < -acceleration_error(d)


def acceleration_error(d):
    """Return the acceleration [m/s²] against the direction of sliding that may be an error.

    It is the sum of round-off (ACCELERATION_ERROR) and of twice the largest acceleration that the constraints
    leave to a sticking element.
    """
    residual = 0.0
    for i in range(d.friction.stuck_count):
        residual = max(residual, abs(tangential_acceleration(d, d.friction_element.stuck_index[i])))
    return (
        ACCELERATION_ERROR
        * (largest_component(d, d.scratch.acceleration) + d.chain.gravity_magnitude + d.chain.longest_link)
        + 2.0 * residual
    )


def clear_changes(d):
    """Clear the log of mode changes, at the start of a run or because nobody reads the entries."""
    d.friction_changes.count = 0


def log_changes(d):
    """Log the changes of friction modes at the last step's end; a full log loses its oldest entries."""
    log = d.friction_changes
    for e in range(d.friction_element_count):
        if d.friction_element.mode[e] != d.friction_element.mode_before[e]:
            row = log.count % len(log.time)
            is_joint_or_slider = e >= d.candidate_count
            log.time[row], log.mode[row] = d.step.end, d.friction_element.mode[e]
            log.point[row] = joint_number(d, e) if is_joint_or_slider else d.candidate.point[e]
            log.wall[row] = -1 if is_joint_or_slider else d.candidate.wall[e]
            log.count += 1
