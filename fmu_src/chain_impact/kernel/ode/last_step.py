"""The last accepted step: its state at both ends, its dense output, and rate and points at its end.

Other modules change these data by the functions of this module, but explicit.py and collocation.py set the
coefficients of the dense output. Data that other modules derive from a step, such as clearances over time,
are valid until a break in the sequence of steps: the next step then does not start at the end of this step,
or has another integration variable. `step.break_count` counts the breaks. An impact changes the state at the
end of a step; the changed state belongs to the step that follows (advance.py).
"""

from chain_impact.kernel.chain.kinematics import (
    accelerate_points,
    locate_from_link_vectors,
    locate_points,
    note_points_at_end,
    note_points_elsewhere,
)
from chain_impact.kernel.chain.prescribed_motion import move_channels_to_state
from chain_impact.kernel.constraints.impulses import any_constraint
from chain_impact.kernel.cost import count_evaluations, read_cost_counts, restore_cost_counts
from chain_impact.kernel.equations import rate_from_points, rate_from_state
from chain_impact.kernel.forces.friction import move_missed_anchors
from chain_impact.kernel.forces.holding import project_state
from chain_impact.kernel.ode import collocation, explicit
from chain_impact.kernel.ode.dense_output import change_up_to, fraction_at_time, interpolate_state
from chain_impact.kernel.ode.friction_work import change_in_step, uncounted_work
from chain_impact.kernel.ode.quadratures import (
    accept_quadratures,
    reset_quadratures,
    roll_back_quadratures,
    store_end_rates,
    truncate_quadratures,
)
from chain_impact.kernel.ode.step_control import clear_faded, scale_next_size
from chain_impact.kernel.ode.sundman import find_lone_contact, time_rate_for_sizes
from chain_impact.kernel.record.constants import (
    EXPLICIT,
    NO_CONTACT,
    NO_READER,
    OUTPUT_READER,
    SOLVER_READER,
)
from chain_impact.kernel.record.method import was_implicit
from chain_impact.kernel.record.state import dissipated_at, omega_at, sundman_u_at, supplied_at, time_at


def reset_step(d, time, y):
    """Set the last step to a step without duration, at ``time`` [s] in state y, and count a break.

    The communication point is set to ``time``, too. The quadratures get their stored totals and rates.
    ``step.start_delay`` does not change: it is 0, but has derivatives in a tangent instance.
    """
    step = d.step
    for j in range(len(step.state)):
        step.state[j] = y[j]
        for m in range(len(step.dense)):
            step.dense[m, j] = 0.0
    step.state[sundman_u_at(d.link_count)], step.state[time_at(d.link_count)] = 1.0, 0.0
    for j in range(len(step.state)):
        step.state_end[j] = step.state[j]
    reset_times(d, time)
    step.size = 1.0
    step.remainder = step.remainder_whole = step.remainder_end
    step.energy_added = step.energy_added_end
    reset_quadratures(d)
    step.regularized_candidate = NO_CONTACT
    step.dense_for = SOLVER_READER
    # no implicit step may extrapolate its stages from this step, so the method is EXPLICIT
    step.last_method = EXPLICIT
    count_break(d)


def reset_times(d, time):
    """Set start, end and time origin of the last step, and the communication point, to ``time`` [s]."""
    step = d.step
    step.communication_point, step.start, step.end, step.time_origin = time, time, time, time


def set_start_delay(d, delay):
    """Set ``step.start_delay`` to a ``delay`` [s]: the shift of the event at the start of the next step.

    The delay is 0; in a tangent instance it has derivatives, because parameters shift the event.
    """
    d.step.start_delay = delay


def make_last_step(d):
    """Project the end of the tried step onto the constraints, and make the tried step the last step.

    For an explicit step the function also finds the rate at the end; for an implicit step it stores the
    stages and sets the dense output.
    """
    step, y = d.step, d.trial.state
    step.remainder, step.energy_added = step.remainder_end, step.energy_added_end
    if any_constraint(d):
        project_trial(d)
        move_missed_anchors(d)
    step.remainder_whole = step.remainder_end
    # Coordinates and rates that have faded almost to 0 are set to 0. Only contacts, friction, springs and
    # dampers make them fade, so without these no value is set to 0.
    is_resisted = (
        d.contacts.active_count > 0 or d.friction.active_count > 0 or d.chain.has_springs_or_dampers != 0
    )
    faded = clear_faded(d, y) if is_resisted else False
    for j in range(len(step.state)):
        step.state[j] = step.state_end[j]
        step.state_end[j] = y[j]
    accept_quadratures(d)
    step.start = step.end
    step.size, step.end_fraction = d.trial.size, 1.0
    step.end = step.start + y[time_at(d.link_count)]
    step.last_method = step.method
    step.dense_for = NO_READER
    step.rate_known = 0
    note_points_elsewhere(d)
    if was_implicit(d):
        collocation.store_stages(d, faded)
    else:
        # with active contacts, the points have already been located at the end of the explicit step
        find_rate(d, d.contacts.active_count > 0)


def project_trial(d):
    """Project the end of the tried step onto the constraints, and count the work of friction in this change.

    The projection moves points back to rigid walls and sticking elements back to their anchors; other
    elements move with them, and dry friction does work. In a chain at rest, this work and the energy that the
    step dissipates may be smaller than the last digit of the dissipated energy. What the rounding of the sum
    loses is therefore stored in ``remainder_end``, and added in the next step; otherwise the losses of many
    steps would add up.
    """
    step, y, index = d.step, d.trial.state, dissipated_at(d.link_count)
    if d.friction.active_count == 0:
        project_state(d, y)
        return
    y[index] = step.remainder_end + change_in_step(d, index)
    project_state(d, y)
    add_dissipated(d, y, y[index] - uncounted_work(d), step.state_end[index])


def add_dissipated(d, y, change, before):
    """Set the dissipated energy in y to ``before`` + ``change`` [J]; store the sum's error of rounding."""
    energy_index = dissipated_at(d.link_count)
    y[energy_index] = before + change
    d.step.remainder_end = change - (y[energy_index] - before)


def count_dissipated(d, energy):
    """Add an energy [J] that is lost at the end of the last step to the dissipated energy."""
    d.step.state_end[dissipated_at(d.link_count)] += energy


def correct_dissipated(d, energy):
    """Add an energy [J] to the dissipated energy at the last step's end, to correct an error.

    The checks of the energy balance leave out the sum of these energies.
    """
    count_dissipated(d, energy)
    d.step.energy_added_end += energy


def evaluate_start(d):
    """Evaluate rates at the start of the next step again, because forces or inputs have changed there."""
    rate_from_state(d, d.step.state_end, d.scratch.rate_start)
    store_end_rates(d)
    count_evaluations(d, 1)


def count_supplied(d, energy):
    """Add an energy [J] that inputs or motions supply at the last step's end to the supplied energy."""
    d.step.state_end[supplied_at(d.link_count)] += energy


def roll_back(d):
    """Undo the last step, which was rejected: set its end back to its start, and call ``count_break``."""
    step = d.step
    step.end = step.start
    for j in range(len(step.state)):
        step.state_end[j] = step.state[j]
    step.remainder_end, step.energy_added_end = step.remainder, step.energy_added
    roll_back_quadratures(d)
    count_break(d)


def truncate_step(d, theta):
    """Cut the last step at its fraction θ: the state at the end becomes that of the dense output there."""
    ensure_dense(d, SOLVER_READER)
    end_at_fraction(d, theta)
    d.step.end = d.step.start + d.step.state_end[time_at(d.link_count)]


def end_at_fraction(d, theta):
    """Set state and quadratures at the end of the last step to the dense output at its fraction θ.

    The function also sets ``step.end_fraction`` and counts a break; the caller sets ``step.end``.
    """
    step, energy_index = d.step, dissipated_at(d.link_count)
    interpolate_state(step, theta, step.state_end)
    # Rounding has made the dissipated energy too small by ``remainder`` at the start of the step, and by
    # ``remainder_whole`` at its end. At θ the interpolant is too small by ``remainder``, a number between
    # these two: ``part`` is θ or, in an explicit step, where the slopes at both ends are exact, a cubic of θ.
    part = theta if was_implicit(d) else theta * theta * (3.0 - 2.0 * theta)
    remainder = step.remainder + part * (step.remainder_whole - step.remainder)
    add_dissipated(
        d, step.state_end, change_up_to(step, theta, energy_index) + remainder, step.state[energy_index]
    )
    truncate_quadratures(d, theta)
    step.end_fraction, step.energy_added_end = theta, step.energy_added
    count_break(d)


def set_communication_point_in_step(d, time):
    """Set the communication point to a ``time`` [s] in the last step.

    The dense output of the step is computed if it does not exist yet.
    """
    d.step.communication_point = time
    ensure_dense(d, OUTPUT_READER)


def truncate_to_communication_point(d):
    """Cut the last step at the communication point: the state at the end becomes that of the dense output."""
    ensure_dense(d, OUTPUT_READER)
    end_at_fraction(d, fraction_at_time(d, d.step.communication_point))
    d.step.end = d.step.communication_point


def store_output_state(d):
    """Store the state at the communication point in ``trial.state``, which no tried step uses then."""
    interpolate_state(d.step, fraction_at_time(d, d.step.communication_point), d.trial.state)


def return_to_stored_state(d):
    """Set the last step to a step of zero length at the communication point, in the stored state.

    ``store_output_state`` has stored this state. The start delay and, in a tangent instance, the
    derivatives of this delay become 0.
    """
    reset_step(d, d.step.communication_point, d.trial.state)
    d.step.start_delay = 0.0


def count_break(d):
    """Count a break; mark rate and points at the end of the last step as unknown."""
    d.step.rate_known = 0
    note_points_elsewhere(d)
    d.step.break_count += 1


def choose_variable(d, size_chosen):
    """Choose the integration variable of the next step, time or s (sundman.py), at its located start.

    Args:
        d: the instance.
        size_chosen: whether the proposed size is already in units of the chosen variable, as after contacts
            have begun or ended; otherwise a change of the variable converts the size. A change of the
            variable counts as a break.
    """
    step, root = d.step, sundman_u_at(d.link_count)
    rate_before, (contact, u) = time_rate_for_sizes(d, step.state_end), find_lone_contact(d)
    has_changed = contact != step.regularized_candidate
    step.regularized_candidate = contact
    step.state_end[root] = u
    step.state_end[time_at(d.link_count)], step.time_origin = 0.0, step.end
    if has_changed:
        step.break_count += 1
        if not size_chosen:
            scale_next_size(d, rate_before / time_rate_for_sizes(d, step.state_end))


def ensure_rate(d):
    """Ensure that ``scratch.rate_end`` is ẏ at the end of the last step."""
    if not d.step.rate_known:
        find_rate(d, False)


def find_rate(d, are_points_located):
    """Evaluate the rates of the state and of the quadratures at the end of the last step.

    In a scene with candidates, the points are then located and accelerated there. ``are_points_located``
    tells whether they are already located at the call.
    """
    y, rate = d.step.state_end, d.scratch.rate_end
    is_touching = d.contacts.active_count > 0 or d.friction.active_count > 0
    if is_touching:
        if not are_points_located:
            locate_points(d, y)
        rate_from_points(d, y, rate)
    else:
        rate_from_state(d, y, rate)
    store_end_rates(d)
    if d.candidate_count > 0:
        if not is_touching:
            if d.channel_count > 0:
                move_channels_to_state(d, y)
            locate_from_link_vectors(d, y)
        accelerate_points(d, y, rate)
        note_points_at_end(d)
    count_evaluations(d, 1)
    d.step.rate_known = 1


def ensure_points(d):
    """Ensure that positions, velocities and accelerations of points are those at the end of the last step.

    The rate at this end must be known.
    """
    if not d.scratch.located_at_end:
        locate_points(d, d.step.state_end)
        accelerate_points(d, d.step.state_end, d.scratch.rate_end)
        note_points_at_end(d)


def largest_turn(d):
    """Return an estimate [rad] of the largest rotation of a link in the last step.

    The estimate is not below the rotation if |ω| and |α| of each link are largest at an end of the step. The
    rates at both ends must be known.
    """
    first, duration, scratch = omega_at(d.link_count), d.step.end - d.step.start, d.scratch
    turn = 0.0
    for i in range(d.link_count):
        omega = max(abs(d.step.state[first + i]), abs(d.step.state_end[first + i]))
        alpha = max(abs(scratch.rate_start[first + i]), abs(scratch.rate_end[first + i]))
        turn = max(turn, duration * (omega + 0.5 * duration * alpha))
    return turn


def ensure_dense(d, reader):
    """Ensure that the last step has its dense output; call this before any change of the step's data.

    The evaluations for a dense output that only outputs need are not counted, so that the solver's count does
    not depend on the outputs.

    Args:
        d: the instance.
        reader: the user of the dense output, OUTPUT_READER or SOLVER_READER.
    """
    step = d.step
    present_reader, step.dense_for = step.dense_for, max(step.dense_for, reader)
    if present_reader == NO_READER:
        counts = read_cost_counts(d)
        if was_implicit(d):
            collocation.match_clearances(d)
        else:
            explicit.set_dense_output(d, step.size)
        restore_cost_counts(d, counts)
    if present_reader < SOLVER_READER <= reader and not was_implicit(d):
        count_evaluations(d, explicit.DENSE_EVALUATIONS)
