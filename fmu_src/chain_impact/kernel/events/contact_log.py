"""The peak force and largest penetration of each contact, updated for every step, and the log of contacts."""

import math

from chain_impact.kernel import hooks
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.constraints.geometry import (
    clearance_acceleration,
    clearance_and_rate,
    is_at_joint_stop,
    lever_of_candidate,
)
from chain_impact.kernel.constraints.impulses import any_point_held
from chain_impact.kernel.cost import count_evaluations, read_cost_counts, restore_cost_counts
from chain_impact.kernel.equations import rate_from_state
from chain_impact.kernel.events.marks import drop_mode_marks, mark_contact_event
from chain_impact.kernel.forces.active_contacts import (
    contact_force,
    contact_slopes,
    deactivate_candidate,
    set_contact_extremes,
    set_start_rates,
)
from chain_impact.kernel.ode.dense_output import event_fraction, fraction_at_time, interpolate_state
from chain_impact.kernel.ode.falls import correct_falls
from chain_impact.kernel.ode.folds import correct_near_fold
from chain_impact.kernel.ode.last_step import (
    ensure_dense,
    ensure_points,
    ensure_rate,
    truncate_to_communication_point,
)
from chain_impact.kernel.ode.maximum import maximum_of
from chain_impact.kernel.ode.quadratures import commit_quadratures
from chain_impact.kernel.record.constants import KINK, NO_EVENT, ONSET, OUTPUT_READER, SOLVER_READER
from chain_impact.kernel.transmitted_forces import raise_joint_force_peaks

# number of samples of a constraint force over a step; the two ends of the step are among the samples
HELD_SAMPLES = 5


def update_peaks(d):
    """Update the peaks of active contacts and, if requested, of joint forces for the last step."""
    if d.contacts.active_count > 0:
        update_extremes(d)
    if d.transmitted_row_count > 0:
        raise_joint_force_peaks(d)


def update_extremes(d):
    """Update the peak force and the largest penetration of every active contact for the last step.

    A contact at a rigid wall has no penetration. The rate ẏ at the end of the step must be known; afterwards
    the points are located and accelerated there.
    """
    contacts = d.contacts
    if any_point_held(d):
        update_held_extremes(d)
    for k in range(contacts.force_law_count):
        # the search for another contact's peaks may have located the points at a time before the end of the
        # step
        ensure_points(d)
        c = contacts.active_index[k]
        _, clearance_rate = clearance_and_rate(d, c)
        force_rate = rate_of_force(d, c)
        peak_force, max_penetration, _ = find_peaks(d, c, force_rate, d.step.end, SOLVER_READER)
        set_contact_extremes(d, c, peak_force, max_penetration)
        set_start_rates(d, c, -clearance_rate, force_rate)
    ensure_points(d)


def find_peaks(d, c, force_rate, time, reader):
    """Return the peak force [N] and the largest penetration [m] of contact c from the onset to ``time`` [s].

    c has a force law, and ``time`` is in the last step. The points must be located and accelerated at
    ``time``. A third result is true if afterwards the points may be located at another time. ``force_rate``
    [N/s] is dF/dt at ``time``; ``reader`` tells for whom the peaks are, OUTPUT_READER or SOLVER_READER.
    """
    contacts = d.contacts
    clearance, clearance_rate = clearance_and_rate(d, c)
    force = contact_force(d, c, clearance, clearance_rate)
    peak_force = max(contacts.peak_force[c], force)
    max_penetration = max(contacts.max_penetration[c], -clearance)
    # force and penetration have a maximum inside the step if their rates fall through zero
    has_force_peaked = contacts.force_rate[c] > 0.0 and force_rate <= 0.0
    has_penetration_peaked = (
        contacts.penetration_rate[c] > 0.0 and clearance_rate >= 0.0 and not penetration_turns_at_end(d, c)
    )
    if has_force_peaked or has_penetration_peaked:
        ensure_dense(d, reader)
    first = event_fraction(d)
    reach = 0.5 * (fraction_at_time(d, time) - first) if has_force_peaked or has_penetration_peaked else 0.0
    middle = first + reach
    if has_force_peaked:
        peak_force = max(peak_force, find_largest_force(d, c, middle, reach, middle + reach))
    if has_penetration_peaked:
        max_penetration = max(max_penetration, find_largest_penetration(d, c, middle, reach, middle + reach))
    return peak_force, max_penetration, has_force_peaked or has_penetration_peaked


def penetration_turns_at_end(d, c):
    """Return whether candidate c's law damps on approach only and the last step ends at this law's kink.

    At the kink the rate of the penetration is 0. If the point has approached until then, the penetration is
    largest there, so no search for the largest penetration is needed.
    """
    return d.law.approach_only[c] and d.contacts.event[c] == KINK


def update_held_extremes(d):
    """Update peak forces at rigid walls with the last step, by parabolas through samples of the forces."""
    step, samples = d.step, d.constraints.sampled_force
    ensure_dense(d, SOLVER_READER)
    first = event_fraction(d)
    length = fraction_at_time(d, step.end) - first
    for j in range(HELD_SAMPLES):
        theta = first + length * j / (HELD_SAMPLES - 1)
        interpolate_state(step, theta, d.scratch.state)
        rate_from_state(d, d.scratch.state, d.scratch.rate)
        correct_near_fold(d, theta, d.scratch.state, d.scratch.rate)
        for k in range(d.contacts.force_law_count, d.contacts.active_count):
            c = d.contacts.active_index[k]
            left, top, right = samples[0, k], samples[1, k], d.constraints.impulse[k]
            peak, second_difference = right, left - 2.0 * top + right
            if j >= 2 and top > max(left, right):
                peak = top - (right - left) * (right - left) / (8.0 * second_difference)
            set_contact_extremes(d, c, max(d.contacts.peak_force[c], peak), d.contacts.max_penetration[c])
            samples[0, k], samples[1, k] = top, right
    count_evaluations(d, HELD_SAMPLES)


def update_to_communication_point(d):
    """Cut the last step at the communication point, log active contacts there, and call ``on_truncate``."""
    update_instance_to_communication_point(d)
    hooks.on_truncate(d)


def update_instance_to_communication_point(d):
    """Do what ``update_to_communication_point`` does, but do not call ``on_truncate`` (kernel/hooks.py).

    The cost does not count, because the caller, not the motion, chooses the communication point.
    """
    counts = read_cost_counts(d)
    end_at_communication_point(d)
    ensure_rate(d)
    update_peaks(d)
    commit_quadratures(d)
    log_active_contacts(d)
    restore_cost_counts(d, counts)


def end_at_communication_point(d):
    """Cut the last step at the communication point, and drop the marks of its events.

    The next step finds the events again. If the step ends at the communication point without a cut, onsets
    and changes of modes stay marked, because the next step would not find them, for example the arrival of a
    point that is already at the wall.
    """
    ends_here = d.step.end == d.step.communication_point
    truncate_to_communication_point(d)
    correct_falls(d)
    for c in range(d.candidate_count):
        if not (ends_here and d.contacts.event[c] == ONSET):
            mark_contact_event(d, c, NO_EVENT)
    if not ends_here:
        drop_mode_marks(d)


def list_latest(d):
    """Write the latest impacts to the outputs ``latest``, from the log and the active contacts.

    A contact that still lasts gets its values up to the communication point. The points must be located and
    accelerated at this time, and the outputs must already contain the forces and impulses.
    """
    latest, log, rows = d.latest, d.contact_log, d.contact_log.count
    if latest.requested_count == 0 or (d.contacts.active_count == 0 and latest.listed_count == rows):
        return
    latest.listed_count = rows if d.contacts.active_count == 0 else -1
    theta, time = fraction_at_time(d, d.step.communication_point), d.step.communication_point
    for k in range(d.contacts.active_count):
        c = d.contacts.active_index[k]
        _, clearance_rate = clearance_and_rate(d, c)
        peak_force, max_penetration = max(d.contacts.peak_force[c], d.output.force[c]), 0.0
        if not d.law.rigid[c]:
            peak_force, max_penetration, points_moved = find_peaks(
                d, c, rate_of_force(d, c), time, OUTPUT_READER
            )
            if points_moved:
                interpolate_state(d.step, theta, d.scratch.state)
                locate_points(d, d.scratch.state)
        log_contact(d, c, rows, time, clearance_rate, peak_force, max_penetration, d.output.impulse[c])
        rows += 1
    for row in range(min(rows, len(log.point))):
        entry = d.impact.count - log.impact_number[row]
        if 0 <= entry < latest.requested_count:
            latest.point[entry], latest.wall[entry] = log.point[row], log.wall[row] + 1
            latest.onset[entry], latest.end[entry] = log.onset[row], log.end[row]
            latest.impact_speed[entry] = log.impact_speed[row]
            latest.separation_speed[entry] = log.separation_speed[row]
            latest.peak_force[entry] = log.peak_force[row]
            latest.max_penetration[entry] = log.max_penetration[row]
            latest.impulse[entry] = log.impulse[row]


def rate_of_force(d, c):
    """Return dF/dt [N/s] of the force F of contact c, which has a force law, for the accelerated points."""
    stiffness, damping = contact_slopes(d, c)
    # F is a function of the penetration δ and its rate: Ḟ = ∂F/∂δ δ̇ + ∂F/∂δ̇ δ̈
    _, clearance_rate = clearance_and_rate(d, c)
    return -(stiffness * clearance_rate + damping * clearance_acceleration(d, c))


def force_at_fraction(d, c, theta):
    """Return the normal force [N] of contact c, which has a force law, at the fraction θ of the last step."""
    clearance, clearance_rate = clearance_at_fraction(d, c, theta)
    return contact_force(d, c, clearance, clearance_rate)


def penetration_at_fraction(d, c, theta):
    """Return the penetration [m] of candidate c at the fraction θ of the last step."""
    clearance, _ = clearance_at_fraction(d, c, theta)
    return -clearance


def clearance_at_fraction(d, c, theta):
    """Return the clearance [m] of candidate c, and its rate [m/s], at the fraction θ of the last step."""
    interpolate_state(d.step, theta, d.scratch.state)
    locate_points(d, d.scratch.state)
    return clearance_and_rate(d, c)


find_largest_force, find_largest_penetration = (
    maximum_of(force_at_fraction),
    maximum_of(penetration_at_fraction),
)


def clear_log(d):
    """Clear the log of contacts and the outputs ``latest`` at the start of a run."""
    latest = d.latest
    d.contact_log.count, d.contact_log.collected, latest.listed_count = 0, 0, 0
    for row in range(len(latest.onset)):
        latest.onset[row], latest.end[row] = 0.0, 0.0
        latest.point[row], latest.wall[row] = -1, 0
        latest.impact_speed[row], latest.separation_speed[row] = 0.0, 0.0
        latest.peak_force[row], latest.max_penetration[row], latest.impulse[row] = 0.0, 0.0, 0.0


def mark_collected(d):
    """Record that the caller has collected all contacts that have ended."""
    d.contact_log.collected = d.contact_log.count


def end_contact(d, c, was_rigid):
    """End the contact of candidate c, and log the contact; in a full log this overwrites the oldest entry.

    ``was_rigid`` tells whether a rigid wall held the point until now; the wall may already have got a law
    with a force. The points must be located at the end of the last step.
    """
    _, clearance_rate = clearance_and_rate(d, c)
    # a point leaves a rigid wall with a rate of 0 or more, so a negative rate is round-off
    log_with_peaks(
        d, c, d.contact_log.count, d.step.end, max(0.0, clearance_rate) if was_rigid else clearance_rate
    )
    d.contact_log.count += 1
    deactivate_candidate(d, c)


def log_active_contacts(d):
    """Log the active contacts after the ended contacts, without an end time and without counting them.

    In a full log this overwrites the oldest entries.
    """
    row = d.contact_log.count
    for c in range(d.candidate_count):
        if d.contacts.active[c]:
            log_with_peaks(d, c, row, math.nan, math.nan)
            row += 1


def log_with_peaks(d, c, row, end, separation_speed):
    """Log the contact of candidate c with the peaks in ``contacts``, and raise the run's peaks (``d.peaks``).

    The peaks in ``contacts`` belong to the time from the onset to the end of the last step. ``row``, ``end``
    and ``separation_speed`` are as for ``log_contact``.
    """
    contacts, peaks, arm = d.contacts, d.peaks, lever_of_candidate(d, c)
    peak_force, max_penetration = contacts.peak_force[c], contacts.max_penetration[c]
    log_contact(d, c, row, end, separation_speed, peak_force, max_penetration, d.quadrature.integral[c])
    if not is_at_joint_stop(d, c):
        peaks.force = max(peaks.force, peak_force)
        peaks.penetration = max(peaks.penetration, max_penetration)
    else:
        peaks.moment = max(peaks.moment, peak_force * arm)
        peaks.rotation = max(peaks.rotation, max_penetration / arm)


def log_contact(d, c, row, end, separation_speed, peak_force, max_penetration, impulse):
    """Write the contact of candidate c to a row of the log; a joint's stop has moments and angles there.

    Args:
        d: the instance.
        c: the candidate.
        row: the number of the row since the start of the run; row numbers beyond the length of the log start
            again at its beginning.
        end: the time at which the contact ends [s]; for a contact that lasts, NaN or, for the outputs
            ``latest``, the communication point.
        separation_speed: rate ġ of the clearance at ``end`` [m/s], or NaN.
        peak_force: the largest force in the contact so far [N].
        max_penetration: the largest penetration in the contact so far [m].
        impulse: ∫F dt of the candidate since the start of the run [N·s]; only the part from the onset is
            written.
    """
    contacts, log, arm = d.contacts, d.contact_log, lever_of_candidate(d, c)
    entry = row % len(log.point)
    log.impact_number[entry] = contacts.impact_number[c]
    log.point[entry] = d.candidate.point[c]
    log.wall[entry] = d.candidate.wall[c]
    log.onset[entry] = contacts.onset[c]
    log.end[entry] = end
    log.impact_speed[entry] = contacts.impact_speed[c] / arm
    log.separation_speed[entry] = separation_speed / arm
    log.peak_force[entry] = peak_force * arm
    log.max_penetration[entry] = max_penetration / arm
    log.effective_mass[entry] = contacts.effective_mass[c] * arm * arm
    log.impulse[entry] = (impulse - d.quadrature.impulse_at_onset[c]) * arm
    log.joint_force[entry] = math.sqrt(contacts.joint_square[c]) if contacts.joint_square[c] > 0.0 else 0.0
    log.joint[entry] = contacts.joint[c]
    log.x[entry], log.y[entry] = contacts.x[c], contacts.y[c]
