"""The functions that callers of an instance use; compilation/entry_points.py makes C functions of them.

``is_sound`` checks that a record from outside, such as a restored state of an FMU, is safe to compute with:
it checks every number that the kernel uses as an index or as the number of iterations of a loop. Any other
wrong number leads to a fault or to wrong results, never to an access outside the record.
"""

from chain_impact.kernel import hooks
from chain_impact.kernel.advance import advance, must_restart, restart
from chain_impact.kernel.chain.signals import knot_count
from chain_impact.kernel.constraints.geometry import is_candidate_sound
from chain_impact.kernel.cost import (
    UNLIMITED,
    allow_any_length,
    cost_before_pause,
    cost_so_far,
    read_cost_counts,
    restore_cost_counts,
)
from chain_impact.kernel.events.contact_log import mark_collected, update_to_communication_point
from chain_impact.kernel.events.friction_modes import clear_changes
from chain_impact.kernel.forces.laws import LAW_COUNT
from chain_impact.kernel.forces.user_law import has_user_law
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.observe import observe, observe_state, refill_outputs_but_integrals
from chain_impact.kernel.ode.last_step import return_to_stored_state, store_output_state
from chain_impact.kernel.record.input_fields import CHANNEL, input_field
from chain_impact.kernel.record.ranges import BOUNDED_PATHS, bounded_field, least_bound, most_bound
from chain_impact.kernel.status import LOG_FULL, OK, PAUSED


def is_sound(d):
    """Return 1 if all indices in the record, and in the tangent instances after it, are in bounds, else 0.

    The caller must check the sizes at the start of the record, such as the number of links.
    """
    return 1 if is_record_sound(d) and hooks.are_tangents_sound(d) == 1 else 0


def is_record_sound(d):
    """Return whether every index and length of a loop in the record is within its bounds."""
    return are_indices_sound(d) and are_relations_sound(d)


def are_indices_sound(d):
    """Return whether each index is within the bounds that its layout declares (record/fields.py)."""
    for k in range(len(BOUNDED_PATHS)):
        values, least, most = bounded_field(d, k), least_bound(d, k), most_bound(d, k)
        for i in range(len(values)):
            if not least <= values[i] <= most:
                return False
    return True


def are_relations_sound(d):
    """Return whether indices and counts whose bounds depend on other numbers are within these bounds."""
    laws = LAW_COUNT + has_user_law()
    fits = d.contact_log.count >= 0 and is_within(d.contacts.force_law_count, 0, d.contacts.active_count)
    fits = fits and is_within(d.chain.base_moves, 0, d.channel_count // 2)
    for c in range(d.candidate_count):
        fits = fits and is_candidate_sound(d, c)
        fits = fits and is_within(d.wall_motion.first_channel[c], -1, max(-1, d.channel_count - 2))
        fits = fits and is_within(d.law.number[c], least_law(d), laws)
        fits = fits and is_within(d.law.same_as[c], 0, c)
        fits = fits and is_within(d.contacts.impact_number[c], 0, d.impact.count)
    return fits and are_friction_counts_sound(d) and are_signals_sound(d)


def are_signals_sound(d):
    """Return whether the indices of all signals, knots and driven values are within the record."""
    signal = d.signal
    for j in range(d.signal_count):
        driven, first, last = signal.input[j], signal.first_knot[j], signal.last_knot[j]
        values = d.channel_count if driven == CHANNEL else len(input_field(d.inputs, driven))
        if not (is_within(signal.index[j], 0, values - 1) and 0 <= first <= signal.segment[j] <= last):
            return False
        # index in `knot` of the first given time of a signal of steps, which is at its source; the signal has
        # as many given times and values as knots
        given = signal.first_knot[signal.source[j]]
        knots = knot_count(signal.form[j], signal.shape[signal.source[j]])
        if not (0 <= given <= d.knot_count - 1 - (last - first) and last - first + 1 >= knots):
            return False
    return True


def are_friction_counts_sound(d):
    """Return whether the counts of elements with friction fit together; none may be below 0.

    The count of contacts with friction and the count of sticking elements are at most that of all elements
    with friction; the count of sticking joints and slider is at most that of all sticking elements.
    """
    friction = d.friction
    fits = is_within(friction.may_act, 0, min(1, d.friction_element_count)) and d.friction_changes.count >= 0
    fits = fits and is_within(friction.contact_count, 0, min(friction.active_count, d.candidate_count))
    fits = fits and is_within(friction.stuck_count, 0, friction.active_count)
    return fits and is_within(friction.stuck_joints, 0, friction.stuck_count)


def least_law(d):
    """Return the least valid value of the laws' numbers in the record: 1, or 0 if laws may be missing.

    The number 0 stands for a missing law. Laws may be missing before the first start, and after a fault while
    no contact is active.
    """
    has_started = d.chain.longest_link != 0.0 and d.statistics.status == OK
    return 1 if has_started or d.contacts.active_count > 0 else 0


def is_within(number, least, most):
    """Return whether ``number`` is at least ``least`` and at most ``most``."""
    return least <= number <= most


def advance_to(d, time):
    """Advance the instance to ``time`` [s], and return a status.

    If the log of contacts is full, ended contacts overwrite the oldest entries, also uncollected ones.
    """
    return advance(d, time, UNLIMITED, UNLIMITED)


def advance_awhile(d, time):
    """Advance as ``advance_to`` does, but return PAUSED after about a second of computing.

    The caller can then stop the run or continue it.
    """
    return advance(d, time, UNLIMITED, cost_so_far(d) + cost_before_pause(d))


def observe_now(d):
    """Fill the outputs with the values at the communication point.

    The caller may have set new values of inputs or parameters that the run does not use yet. The function
    applies these values, too, for the outputs that they change at once, and so changes the instance.
    Therefore ``d`` must be a copy of the run's instance.

    Returns:
        The status of the run or, if the new values cause a fault, the status of this fault. After such a
        fault the outputs are those without the new values. The caller may still set other values before the
        next step.
    """
    observe(d)
    status = d.statistics.status
    return observe_trial(d) if status == OK and must_restart(d) else status


def observe_trial(d):
    """Apply the new values of inputs and parameters, and fill the outputs that these values change at once.

    The result is a status; after a fault all outputs stay as they are. The function leaves ``d`` in a state
    from which no run can continue.
    """
    counts = read_cost_counts(d)
    store_output_state(d)
    status = restart(d)
    if status == OK:
        # ``restart`` lets rigid walls correct the state, as at the start of a step; the outputs show the
        # state before this correction
        return_to_stored_state(d)
        refill_outputs_but_integrals(d)
        hooks.on_observe_trial(d)
    restore_cost_counts(d, counts)
    return status


def trajectory(d, words, times, spans, rows, of_state):
    """Advance to each of the ``times`` in turn, and copy numbers of the record to a row at each time.

    Args:
        d: the instance.
        words: all numbers of the record and of its tangent instances (8 bytes each), shape (M,).
        times: shape (T,), increasing [s].
        spans: the wanted numbers, as S spans of ``words``: first index and length of each, shape (S, 2). The
            sum of the lengths is W.
        rows: result, shape (T, W): the wanted numbers at each time.
        of_state: 1 if all wanted numbers are values of STATE_OUTPUTS (record/instance.py), and none is a
            derivative. Other outputs and derivatives are then not computed.

    Returns:
        The number of rows that are filled. This number is smaller than T in three cases: after a fault, if
        the log of ended contacts or that of dry friction is full, and after about a second of computing.
    """
    log_capacity = len(d.contact_log.point) - d.candidate_count
    cost_limit = cost_so_far(d) + cost_before_pause(d)
    for row in range(len(times)):
        allow_any_length(d)
        if advance(d, times[row], log_capacity, cost_limit) != OK:
            return row
        if of_state:
            observe_state(d)
        else:
            observe(d)
        column = 0
        for s in range(len(spans)):
            first, count = spans[s, 0], spans[s, 1]
            for j in range(count):
                rows[row, column + j] = words[first + j]
            column += count
    return len(times)


def run_each(d, words, indices, values, end_times, output_indices, rows, continuing):
    """Run the instance from the time 0 once for each row of parameter values.

    A run does not depend on the runs before it: no run changes a parameter, and ``initialize`` sets
    everything else.

    Args:
        d: the instance.
        words: all numbers of the record (8 bytes each), shape (W,).
        indices: indices of the words that hold the varied parameters, shape (K,).
        values: the values of these words in each run, shape (R, K).
        end_times: the end time of each run, shape (R,) [s].
        output_indices: indices of the words to return from the end of a run, shape (L,).
        rows: result, shape (R, L): the requested words. After a fault, outputs among the words have no
            meaning.
        continuing: 1 if an earlier call has begun the first run of ``values``; this call continues it.

    Returns:
        The number of complete runs; a run with a fault counts as complete. The number is smaller than R after
        about a second of computing. The next run has then begun; a further call, with ``continuing`` 1 and
        with the values from this run on, continues it.
    """
    cost_limit = cost_before_pause(d) + (cost_so_far(d) if continuing else 0)
    for r in range(len(rows)):
        if r > 0 or not continuing:
            for j in range(len(indices)):
                words[indices[j]] = values[r, j]
            initialize(d, 0.0)
        if finish_run(d, end_times[r], cost_limit) == PAUSED:
            return r
        cost_limit -= cost_so_far(d)
        for j in range(len(output_indices)):
            rows[r, j] = words[output_indices[j]]
    return len(rows)


def finish_run(d, end_time, cost_limit):
    """Advance to ``end_time`` [s], and return a status; PAUSED if the cost exceeds ``cost_limit``.

    If ``end_time`` is reached, the outputs are filled.

    Contacts that still last at the end are logged, because the outputs of peak forces and penetrations come
    from the log.
    """
    log_capacity = len(d.contact_log.point) - d.candidate_count
    status = LOG_FULL
    allow_any_length(d)
    while status == LOG_FULL:
        status = advance(d, end_time, log_capacity, cost_limit)
        mark_collected(d)
        clear_changes(d)
    if status == OK:
        observe(d)
    if status != PAUSED and d.contacts.active_count > 0:
        update_to_communication_point(d)
    return status
