"""The functions that callers of an instance use; compilation/entry_points.py makes C functions of them.

``sound`` checks that a record from outside, such as a restored state of an FMU, is safe to compute with: it
checks every number that the kernel uses as an index or as the number of iterations of a loop. Any other wrong
number leads to a fault status, never to an access outside the record.
"""

from chain_impact.kernel import hooks
from chain_impact.kernel.advance import advance, must_reinit, reinit
from chain_impact.kernel.chain.inputs import CHANNEL, input_field
from chain_impact.kernel.chain.signals import (
    CONSTANT,
    RAMP,
    SIGNAL_DEGREE,
    SINE,
    TABLE,
    TRAPEZOID,
)
from chain_impact.kernel.events.contact_log import collect, update_to_output_time
from chain_impact.kernel.events.exclusion import FAR
from chain_impact.kernel.events.friction_modes import clear_changes
from chain_impact.kernel.events.marks import NEIGHBOUR
from chain_impact.kernel.forces.friction import NO_FRICTION
from chain_impact.kernel.forces.inputs import DEGREE
from chain_impact.kernel.forces.laws import LAW_COUNT
from chain_impact.kernel.forces.user_law import present
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.observe import observe, observe_state, refill_motion
from chain_impact.kernel.ode.control import ACCEPTED, DIVERGED, EXPLICIT, IMPLICIT, SOLVER_METHODS
from chain_impact.kernel.ode.last_step import SOLVER, keep_state, return_to_kept_state
from chain_impact.kernel.ode.sundman import NO_CONTACT
from chain_impact.kernel.rows.geometry import candidate_within_bounds
from chain_impact.kernel.status import (
    LAST_STATUS,
    LOG_FULL,
    OK,
    PAUSED,
    UNLIMITED,
    allow_any_length,
    counted_work,
    uncount_work,
    work_done,
    work_of_a_call,
)


def sound(d):
    """Return 1 if all indices in the record, and in the data of the hooks, are within bounds, else 0.

    The caller must check the sizes at the start of the record, such as the number of links.
    """
    return 1 if within_bounds(d) and hooks.indices_valid(d) == 1 else 0


def within_bounds(d):
    """Return whether every index of the record is within its bounds."""
    laws = LAW_COUNT + present()
    fits = within(d.model.meeting_joint, 0, d.links)
    fits = fits and within(d.step.regularized, NO_CONTACT, d.candidates - 1)
    fits = fits and within(d.solver.method, 1, len(SOLVER_METHODS)) and d.contact_log.count >= 0
    fits = fits and within(d.step.method, EXPLICIT, IMPLICIT)
    fits = fits and within(d.step.last_method, EXPLICIT, IMPLICIT)
    fits = fits and within(d.trial.outcome, ACCEPTED, DIVERGED)
    fits = fits and within(d.search.known, 0, FAR) and within(d.step.dense_for, 0, SOLVER)
    fits = fits and within(d.statistics.status, OK, LAST_STATUS)
    fits = fits and within(d.latest.kept, 0, len(d.latest.time))
    fits = fits and within(d.given.piece.order, 0, DEGREE) and within(d.inputs.piece.order, 0, DEGREE)
    fits = fits and within(d.touch.active_count, 0, d.candidates)
    fits = fits and within(d.touch.compliant_count, 0, d.touch.active_count)
    fits = fits and friction_within_bounds(d)
    fits = fits and within(d.model.base_moves, 0, d.channels // 2)
    fits = fits and within(d.quadrature.count, 0, len(d.quadrature.index))
    for k in range(len(d.quadrature.index)):
        fits = fits and within(d.quadrature.index[k], 0, len(d.quadrature.index) - 1)
    for c in range(d.candidates):
        fits = fits and candidate_within_bounds(d, c)
        fits = fits and within(d.shift.channel[c], -1, max(-1, d.channels - 2))
        fits = fits and within(d.law.number[c], least_law(d), laws)
        fits = fits and within(d.law.same_as[c], 0, c)
        fits = fits and within(d.touch.number[c], 0, d.impact.count)
        fits = fits and within(d.touch.active_index[c], 0, d.candidates - 1)
        fits = fits and within(d.touch.active[c], 0, 1) and within(d.touch.event[c], 0, NEIGHBOUR)
    fits = fits and signals_within_bounds(d)
    for s in range(d.sites):
        fits = fits and within(d.site.link[s], 0, d.links - 1)
    for i in range(d.links + 1):
        fits = fits and within(d.model.first_site[i], 0, d.sites)
    return fits


def signals_within_bounds(d):
    """Return whether the indices of signals are within their bounds."""
    fits, signal = True, d.signal
    for j in range(d.signals):
        driven = signal.input[j]
        if not within(driven, 0, CHANNEL):
            return False
        values = d.channels if driven == CHANNEL else len(input_field(d.inputs, driven))
        fits = fits and within(signal.index[j], 0, values - 1)
        fits = fits and within(signal.source[j], 0, d.signals - 1) and within(signal.order[j], 0, 2)
        fits = fits and within(signal.integrals[j], 0, 2)
        fits = fits and within(signal.form[j], CONSTANT, TABLE) and within(signal.degree[j], 0, SIGNAL_DEGREE)
        fits = fits and within(signal.first[j], 0, signal.last[j]) and within(signal.last[j], 0, d.knots - 1)
        fits = fits and within(signal.segment[j], signal.first[j], signal.last[j])
        if fits:
            # number of given knots in the record, and number of knots that a form of signal needs
            given, needed = signal.first[signal.source[j]] + signal.last[j] - signal.first[j], 0
            if signal.form[j] == SINE or signal.form[j] == RAMP:
                needed = 4 if signal.shape[signal.source[j]] == TRAPEZOID else 2
            fits = within(given, 0, d.knots - 1) and signal.last[j] - signal.first[j] >= needed
    return fits


def friction_within_bounds(d):
    """Return whether the indices and counts of dry friction are within their bounds."""
    friction = d.friction
    fits = within(friction.used, 0, min(1, d.elements)) and within(friction.count, 0, d.elements)
    fits = fits and within(friction.contact_count, 0, min(friction.count, d.candidates))
    fits = fits and within(friction.stuck_count, 0, friction.count)
    fits = fits and within(friction.stuck_joints, 0, friction.stuck_count)
    fits = fits and d.changes.count >= 0
    for e in range(d.elements):
        fits = fits and within(d.element.index[e], 0, d.elements - 1)
        fits = fits and within(d.element.stuck[e], 0, d.elements - 1)
        fits = fits and within(d.element.mode[e], -1, NO_FRICTION)
    return fits


def least_law(d):
    """Return the least valid number of a law: 0 before the start of a run and after a start that failed."""
    started = d.model.size != 0.0 and d.statistics.status == OK
    return 1 if started or d.touch.active_count > 0 else 0


def within(number, least, most):
    """Return whether least ≤ number ≤ most."""
    return least <= number <= most


def advance_to(d, time):
    """Advance the instance to ``time`` [s], and return a status.

    New finished contacts overwrite the oldest ones that the caller has not collected.
    """
    return advance(d, time, UNLIMITED, UNLIMITED)


def advance_awhile(d, time):
    """Advance as ``advance_to`` does, but return PAUSED after about a second, so that the caller can stop."""
    return advance(d, time, UNLIMITED, work_done(d) + work_of_a_call(d))


def observe_now(d):
    """Fill the outputs with the values at the communication point.

    If new values wait that the run does not use yet, the function computes the outputs with these values. The
    instance must therefore be a copy of the running instance, so that a read of outputs does not change the
    run.

    Returns:
        The status of the run, or the fault status that the new values cause. In the second case the outputs
        do not change, and other values may still be set before the next step.
    """
    observe(d)
    status = d.statistics.status
    return observe_trial(d) if status == OK and must_reinit(d) else status


def observe_trial(d):
    """Apply the new values, and fill the outputs that change at once. Return a status.

    No run can continue from the instance afterwards. After a fault all outputs stay unchanged.
    """
    counted = counted_work(d)
    keep_state(d)
    status = reinit(d)
    if status == OK:
        # a rigid wall corrects the state at the start of a step, so return to the state before the correction
        return_to_kept_state(d)
        refill_motion(d)
        hooks.on_observe_trial(d)
    uncount_work(d, counted)
    return status


def trajectory(d, words, times, spans, rows, of_state):
    """Advance to each of the times [s] in turn, and fill a row of numbers of the record at each time.

    Args:
        d: the instance.
        words: all numbers of the record and of the records of dual numbers after it (8 bytes each), shape
            (M,).
        times: shape (T,), increasing [s].
        spans: first index and length of each span of wanted numbers, shape (S, 2); W numbers in all.
        rows: result, shape (T, W).
        of_state: 1 if all wanted numbers are outputs of STATE_OUTPUTS (record/instance.py) of this instance:
            then the other outputs, and the derivatives, are not computed.

    Returns:
        The number of rows filled. It is smaller than the number of times after a fault, when the log of
        finished contacts is full, or when a second of computing is over.
    """
    log_capacity = len(d.contact_log.point) - d.candidates
    work = work_done(d) + work_of_a_call(d)
    for row in range(len(times)):
        allow_any_length(d)
        if advance(d, times[row], log_capacity, work) != OK:
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


def run_each(d, words, indices, values, stops, output_indices, rows, continuing):
    """Run the instance from its start once for each row of parameter values.

    A run does not depend on the runs before it: no run changes a parameter, and ``initialize`` sets
    everything else.

    Args:
        d: the instance.
        words: all numbers of the record (8 bytes each), shape (W,).
        indices: indices of the words that vary, shape (K,).
        values: the values of these words in each run, shape (R, K).
        stops: the end time of each run, shape (R,) [s].
        output_indices: indices of the words to return from the end of a run, shape (L,).
        rows: result, shape (R, L): the requested words. After a fault, outputs among the words do not belong
            to the end of the run.
        continuing: 1 if an earlier call has begun the first run, which this call continues.

    Returns:
        The number of complete runs. If the number is smaller than requested, a second of computing was over,
        and the next run has begun.
    """
    work = work_of_a_call(d) + (work_done(d) if continuing else 0)
    for r in range(len(rows)):
        if r > 0 or not continuing:
            for j in range(len(indices)):
                words[indices[j]] = values[r, j]
            initialize(d, 0.0)
        if finish_run(d, stops[r], work) == PAUSED:
            return r
        work -= work_done(d)
        for j in range(len(output_indices)):
            rows[r, j] = words[output_indices[j]]
    return len(rows)


def finish_run(d, stop, work):
    """Advance to ``stop`` [s], and return a status.

    Contacts that still last at the end are logged, because the outputs of peaks come from the log.
    """
    log_capacity = len(d.contact_log.point) - d.candidates
    status = LOG_FULL
    allow_any_length(d)
    while status == LOG_FULL:
        status = advance(d, stop, log_capacity, work)
        collect(d)
        clear_changes(d)
    if status == OK:
        observe(d)
    if status != PAUSED and d.touch.active_count > 0:
        update_to_output_time(d)
    return status
