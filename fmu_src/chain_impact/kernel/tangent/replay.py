"""Derivatives of a run: each step of the primal instance d is repeated by the tangent instance t.

t has the same layout as d, with dual numbers in place of reals: the values of d, and the derivatives in some
directions, by parameters or inputs. After each step that d has accepted, t makes the same step with the same
functions, and so differentiates the step. Rejected steps and the search for events are not repeated: t takes
the size of the step, the method and the events from d, and these choices have no derivatives.

An event ends a step where a function φ of the state passes through zero. The time of the event depends on the
parameters, too. With φ′ the derivatives of φ where the step of d ends, the time has the derivatives −φ′/φ̇;
−ẏ φ′/φ̇ is added to the derivatives of the state at the event. Time is part of the state, and the change of
the state at an event is differentiated like a step of the run. At the kink of a force the rate is
continuous, so the derivative of the event time affects a peak or the end of a contact there, but not the
motion. The dense output of a step is computed before the end of the step moves, so the derivatives of the
dense output are those at fixed times. The search for peaks in a step covers exactly the time between the
events with which the step begins and ends: a force that jumps with a signal may be largest at such an event.

In an implicit step, t repeats the iteration, started from the stages that d has found. The result does not
depend on the approximate Jacobian A, so the linear systems of d, in the scratch memory of d, give the
derivatives in each direction. The stages' derivatives are first extrapolated from the last step, and converge
at another rate than the stages' values: if d does not move, the values converge at once, however long the
step is, but the derivatives do not. So the iteration goes on until the last correction of the derivatives in
each direction is small, relative to the state's derivatives in this direction.

Source: for sensitivities through events, e.g. Galán, Feehery & Barton 1999, Appl Numer Math 31:17.
"""

import math

from chain_impact.kernel.advance import apply_pending_events, apply_pending_inputs, set_first_stage
from chain_impact.kernel.chain.drives import drive_count
from chain_impact.kernel.chain.inputs import apply_inputs
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.chain.signals import derive_signals
from chain_impact.kernel.constraints.constraint_response import mean_mass
from chain_impact.kernel.constraints.geometry import has_sticking
from chain_impact.kernel.events.marks import copy_marks
from chain_impact.kernel.events.segments import begin_segments
from chain_impact.kernel.forces.active_contacts import clear_applied_forces
from chain_impact.kernel.forces.candidate_laws import start_laws
from chain_impact.kernel.initialize import clear_run, derive_chain, derive_drives, set_run_start
from chain_impact.kernel.ode import explicit
from chain_impact.kernel.ode.collocation import (
    LAST_STAGE,
    correct_stages,
    extrapolate_stages,
    find_residuals,
    set_residual,
    set_step_end,
    solve_systems,
)
from chain_impact.kernel.ode.extended_state import (
    clearance_count,
    extend_start,
    extended_length,
    factorize_real,
    project_clearances,
)
from chain_impact.kernel.ode.last_step import (
    choose_variable,
    count_break,
    make_last_step,
    reset_step,
    set_start_delay,
    truncate_step,
)
from chain_impact.kernel.ode.methods import begin_explicit
from chain_impact.kernel.ode.quadratures import correct_falling_quadratures
from chain_impact.kernel.ode.radau import REAL_EIGENVALUE
from chain_impact.kernel.ode.step_control import begin_trial
from chain_impact.kernel.record.constants import CONTACT_ENDS, RADAU_STAGES
from chain_impact.kernel.record.fields import AT_ANY_TIME, AT_START
from chain_impact.kernel.record.method import is_implicit, is_regularized
from chain_impact.kernel.record.state import dissipated_at, velocity_at
from chain_impact.kernel.tangent.duals import (
    DIRECTIONS,
    copy_given,
    copy_values,
    dual_with_slope,
    has_slope,
    replace_slope,
    slope,
    value,
)
from chain_impact.kernel.tangent.friction import check_coefficients
from chain_impact.kernel.tangent.rises import check_rises, delay_jumps
from chain_impact.kernel.tangent.step_ends import (
    ends_at_limit,
    ends_with_segment,
    fix_start,
    move_end,
    move_to_segment,
)
from chain_impact.kernel.tangent.trust import (
    NO_IMPACT,
    NOT_CONVERGED,
    TRUSTED,
    begin_trust,
    check_turns,
    mark_trusted,
    mark_untrusted,
)


def start_tangent(d, t):
    """Initialize t as d has been initialized; t already contains the derivatives of the parameters."""
    copy_given(d, t, AT_START)
    derive_chain(t)
    clear_run(t, d.step.communication_point)
    if d.signal_count > 0:
        derive_signals(t, d.step.communication_point)
    copy_given_and_modes(d, t)
    apply_inputs(t)
    derive_drives(t)
    # each constant of a law is derived again: its derivatives may have changed where its value has not
    for c in range(t.candidate_count):
        t.law.number[c] = 0
    start_laws(t)
    begin_trust(t)
    set_run_start(t, d.step.communication_point)
    check_rises(t)
    check_coefficients(t)
    begin_explicit(t)


def restart_tangent(d, t):
    """Restart t at the communication point, as d was; ``truncate_tangent`` has cut t's step there."""
    reset_step(t, t.step.end, t.step.state_end)
    set_start_delay(t, dual_with_slope(0.0, 0.0, t.step.end))
    # derivatives that have ended only after this point are valid again, because that part of the run is
    # dropped
    if t.trust.time > value(t.step.end):
        mark_trusted(t)
    copy_given_and_modes(d, t)
    apply_pending_inputs(t)
    check_coefficients(t)
    clear_applied_forces(t)


def copy_given_and_modes(d, t):
    """Copy the values of given data, prescribed motions and modes of d to t; derivatives in t stay.

    The derivatives with respect to a prescribed motion are those with respect to constants that are added to
    its position, velocity and acceleration.
    """
    copy_given(d, t, AT_ANY_TIME)
    if d.channel_count > 0:
        copy_values(d.channel, t.channel)
    for j in range(d.channel_count):
        t.channel.added_position[j] = dual_with_slope(0.0, 1.0, t.given_channel.position[j])
        t.channel.added_velocity[j] = dual_with_slope(0.0, 1.0, t.given_channel.velocity[j])
        t.channel.added_acceleration[j] = dual_with_slope(0.0, 1.0, t.given_channel.acceleration[j])
    copy_modes(d, t)


def copy_modes(d, t):
    """Store the modes of friction and drives of d in ``chosen_mode`` of t; t does not choose modes."""
    for e in range(d.friction_element_count):
        t.friction_element.chosen_mode[e] = d.friction_element.mode[e]
    if d.chain.has_drive_limits:
        for i in range(drive_count(d)):
            t.drive.chosen_mode[i] = d.drive.mode[i]


# The iteration of derivatives has converged if the last correction, relative to the derivatives, is at most
# CONVERGED_SLOPES times the tolerance.
CONVERGED_SLOPES = 0.01
# An iteration of derivatives stops if the least correction so far has not fallen by the factor
# LARGEST_FALL_FACTOR within STALLED_ITERATIONS iterations; corrections may rise in between. A last correction
# ≤ SLOPE_ROUND_OFF, relative to the derivatives, is then round-off and accepted; after a larger correction
# the iteration has failed.
LARGEST_FALL_FACTOR, STALLED_ITERATIONS, SLOPE_ROUND_OFF = 0.7, 10, 1e-6
MOST_SLOPE_ITERATIONS = 400  # largest number of iterations: if each leaves 0.95 of the error, 1e-9 remains
# Derivatives may be round-off if they are below LEAST_SLOPE times the result of ``speed_by_friction``, the
# derivative of a speed that friction at its limits could cause: a correction is then relative to this
# product.
LEAST_SLOPE = 1e-3
# Derivatives may be round-off if the state changes by less than LEAST_STATE_CHANGE, relative to its error
# scale, when the parameter changes by its size: a correction is then relative to LEAST_STATE_CHANGE. An
# example is a derivative by a mass in free flight, which is 0. With a much smaller number, derivatives would
# end there.
LEAST_STATE_CHANGE = 1e-8
# result of ``last_correction`` for "not converged": a correction or a derivative is not finite
UNLIMITED_CORRECTION = 1e300


def make_implicit(d, t, h):
    """Make the last step of d, an implicit step of size h, in t; ``trial`` of t gets the state at the end."""
    extend_start(t)
    component_count = extended_length(t)
    extrapolate_stages(t, h, component_count)
    copy_stages(d, t, component_count)
    copy_jacobian_data(d, t)
    factorize_real(t, h * REAL_EIGENVALUE)
    # derivatives that have already ended are not iterated
    if t.trust.reason == TRUSTED and not iterate_slopes(d, t, h, component_count):
        mark_untrusted(t, NOT_CONVERGED, NO_IMPACT, d.step.start)
    set_step_end(t, h)
    if clearance_count(t) > 0:
        project_clearances(t, t.implicit.z_scratch, t.trial.state)


def copy_stages(d, t, component_count):
    """Set the values of the components of t's stages to those of d; derivatives in t stay."""
    for i in range(RADAU_STAGES):
        for j in range(component_count):
            t.implicit.stages[i, j] = dual_with_slope(
                d.implicit.last_stages[i, j], 1.0, t.implicit.stages[i, j]
            )


def copy_jacobian_data(d, t):
    """Copy the data of A, d's Jacobian, to t: link vectors; stiffness and damping of contacts and drives."""
    source, implicit = d.implicit, t.implicit
    for i in range(d.link_count):
        implicit.link_vector.x[i] = source.link_vector.x[i]
        implicit.link_vector.y[i] = source.link_vector.y[i]
    for k in range(d.contacts.active_count):
        implicit.contact_stiffness[k] = source.contact_stiffness[k]
        implicit.contact_damping[k] = source.contact_damping[k]
    for i in range(drive_count(d)):
        implicit.drive_stiffness[i] = source.drive_stiffness[i]
        implicit.drive_damping[i] = source.drive_damping[i]


def iterate_slopes(d, t, h, component_count):
    """Iterate the derivatives of the stages of a step of size h; return whether the iteration has converged.

    ``component_count`` is the length of the extended state z, here and in ``solve_slopes`` and
    ``last_correction``.
    """
    least_correction, stalled_count = math.inf, 0
    for _ in range(MOST_SLOPE_ITERATIONS):
        find_residuals(t, h, component_count)
        solve_slopes(d, t, h, component_count)
        correct_stages(t, h, component_count)
        copy_stages(d, t, component_count)
        correction = last_correction(d, t, component_count)
        if correction <= CONVERGED_SLOPES * d.solver.tolerance:
            return True
        stalled_count += 1
        if correction < LARGEST_FALL_FACTOR * least_correction:
            least_correction, stalled_count = correction, 0
        if stalled_count == STALLED_ITERATIONS:
            return correction <= SLOPE_ROUND_OFF
    return False


def solve_slopes(d, t, h, component_count):
    """Replace the derivatives of the right-hand sides in t by the solutions of the step's linear systems.

    The systems are solved for one direction of derivatives at a time, in the scratch memory of d.
    """
    rows = t.implicit.right_hand_sides
    for k in range(DIRECTIONS):
        for i in range(RADAU_STAGES):
            for j in range(component_count):
                set_residual(d, i, j, slope(rows[i, j], k))
        solve_systems(d, h, component_count)
        for i in range(RADAU_STAGES):
            for j in range(component_count):
                rows[i, j] = replace_slope(rows[i, j], k, d.implicit.right_hand_sides[i, j])


def last_correction(d, t, component_count):
    """Return the largest correction of derivatives in the last iteration, relative to the derivatives.

    Correction and derivatives belong to the same direction, a parameter or input.
    """
    implicit, weight, correction = t.implicit, d.implicit.error_weight, 0.0
    for k in range(DIRECTIONS):
        largest, total = 0.0, 0.0
        least_change = LEAST_STATE_CHANGE / (d.solver.tolerance * t.trust.size[k])
        slope_scale = max(least_change, LEAST_SLOPE * speed_by_friction(d, t, k))
        for j in range(component_count):
            slope_scale = max(
                slope_scale, weight[j] * abs(slope(implicit.z_start[j] + implicit.stages[LAST_STAGE, j], k))
            )
            for i in range(RADAU_STAGES):
                part = weight[j] * abs(slope(implicit.right_hand_sides[i, j], k))
                largest = max(largest, part)
                total += part  # max() can lose a NaN; this sum, which is tested below, cannot
        if not math.isfinite(total + slope_scale):
            return UNLIMITED_CORRECTION
        correction = max(correction, largest / slope_scale)
    return correction


def speed_by_friction(d, t, direction):
    """Return the |slope| of the speed that friction at its limits could cause in the step, times a weight.

    The slope is the derivative in the ``direction``, an index from 0. The weight is the largest error
    weight of a speed. If no element sticks, the result is 0.
    """
    force, weight = 0.0, 0.0
    if d.friction.stuck_count == 0:
        return 0.0
    for i in range(d.friction.stuck_count):
        force = max(
            force, abs(slope(t.friction_element.friction_limit[d.friction_element.stuck_index[i]], direction))
        )
    for j in range(velocity_at(d.link_count), dissipated_at(d.link_count)):
        weight = max(weight, d.implicit.error_weight[j])
    return force * d.step.size * weight / mean_mass(d)


def replay(d, t):
    """Repeat in t, with dual numbers, the events at the start of d's last step, and then this step."""
    copy_modes(d, t)
    limit_ends_step, segment_ends_step = ends_at_limit(t), ends_with_segment(t)
    apply_pending_events(t)
    set_start_delay(t, dual_with_slope(0.0, 0.0, t.step.end))
    if limit_ends_step:
        fix_start(t)
    # only values are copied: the derivatives in t are those with respect to constants that are added to the
    # inputs
    copy_values(d.inputs, t.inputs)
    if d.channel_count > 0:
        copy_values(d.channel, t.channel)
    if d.signal_count > 0:
        if d.statistics.steps == 1:
            delay_jumps(t)
        begin_segments(t)
    if segment_ends_step and has_slope(t.step.end):
        fix_start(t)
    t.step.method = d.step.last_method
    choose_variable(t, True)
    set_first_stage(t)
    lands_on_event = ends_regularized(d)
    repeat_step(d, t, d.step.size * d.step.end_fraction if lands_on_event else d.step.size)
    check_turns(t)
    if lands_on_event:
        copy_end_values(d, t)
        count_break(t)
    else:
        if d.step.end_fraction != 1.0:
            truncate_step(t, d.step.end_fraction)
        copy_end_values(d, t)
    correct_falling_quadratures(t)
    copy_marks(d, t)
    move_end(t)
    if d.signal_count > 0:
        move_to_segment(t)


def repeat_step(d, t, h):
    """Make a step of size h in t with the method ``step.method`` of t, without error control."""
    begin_trial(t, h)
    if is_implicit(t):
        make_implicit(d, t, h)
    else:
        explicit.make_step(t, h)
        if t.contacts.active_count > 0 or has_sticking(t):
            locate_points(t, t.trial.state)
    make_last_step(t)


def ends_regularized(d):
    """Return whether d has cut its last step where the regularized contact ends.

    The force has a kink there. d has computed the step beyond the kink, and has not repeated the step to end
    there. t makes only the part of the step up to the kink.
    """
    return is_regularized(d) and d.contacts.event[d.step.regularized_candidate] == CONTACT_ENDS


def copy_end_values(d, t):
    """Set the values of t at the end of the last step to the values of d, which differ by round-off only.

    The rate at the end is the first stage of the next explicit step. If t kept its own rate, long steps of a
    chain without motion would multiply the round-off of this rate from step to step, although the motion
    itself is stable.
    """
    for j in range(len(d.step.state_end)):
        t.step.state_end[j] = dual_with_slope(d.step.state_end[j], 1.0, t.step.state_end[j])
        t.scratch.rate_end[j] = dual_with_slope(d.scratch.rate_end[j], 1.0, t.scratch.rate_end[j])
    t.step.end = dual_with_slope(d.step.end, 1.0, t.step.end)
