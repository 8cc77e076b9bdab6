"""The functions for callers of an instance; compilation/entry_points.py makes C functions of them."""

from chain_impact.kernel import hooks
from chain_impact.kernel.advance import advance, must_reinit, reinit
from chain_impact.kernel.events.contact_log import collect, update_to_output_time
from chain_impact.kernel.events.friction_modes import clear_changes
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.integration.last_step import keep_state, return_to_kept_state
from chain_impact.kernel.observe import observe, refill_motion
from chain_impact.kernel.status import LOG_FULL, OK, PAUSED
from chain_impact.kernel.work_limit import (
    UNLIMITED,
    allow_any_length,
    counted_work,
    uncount_work,
    work_done,
    work_of_a_call,
)


def advance_to(d, time):
    """Bring the instance to ``time`` [s]; returns a status.

    If the caller does not collect the finished contacts, the oldest are overwritten.
    """
    return advance(d, time, UNLIMITED, UNLIMITED)


def advance_awhile(d, time):
    """As ``advance_to``, but return PAUSED within a second of computing, so that the caller can stop."""
    return advance(d, time, UNLIMITED, work_done(d) + work_of_a_call(d))


def observe_now(d):
    """Fill the outputs with the values at the communication point.

    Where something has been set that the run does not have yet, it is tried: the instance has to be a copy of
    the one that goes on, so that outputs can be read at any time without changing the run.

    Returns:
        The status of the run or, while it can go on, why it cannot with what has been set: another value may
        still be set before the next step. The outputs are those before it then.
    """
    observe(d)
    status = d.statistics.status
    return observe_trial(d) if status == OK and must_reinit(d) else status


def observe_trial(d):
    """Apply what has been set, and fill the outputs that it moves at once; returns a status.

    No run goes on from here. After a fault all outputs stay as they are.
    """
    counted = counted_work(d)
    keep_state(d)
    hooks.on_trial(d)
    status = reinit(d)
    if status == OK:
        # a rigid wall corrects the state at the start of a step
        return_to_kept_state(d)
        refill_motion(d)
        hooks.on_observe_trial(d)
    uncount_work(d, counted)
    return status


def trajectory(d, words, times, spans, rows):
    """Advance to each of the times [s] in turn, and fill one row for each with numbers of the record.

    Args:
        d: the instance.
        words: all numbers of its record and of those of dual numbers behind it (8 bytes each), shape (M,).
        times: shape (T,), increasing [s].
        spans: the first index and the number of those that are wanted, shape (S, 2); W in all.
        rows: result, shape (T, W).

    Returns:
        The number of rows filled: fewer than requested after a fault, when the log of finished contacts is
        full and has to be collected, or to return within a second of computing.
    """
    log_capacity = len(d.finished.point) - d.candidates
    work = work_done(d) + work_of_a_call(d)
    for row in range(len(times)):
        allow_any_length(d)
        if advance(d, times[row], log_capacity, work) != OK:
            return row
        observe(d)
        column = 0
        for s in range(len(spans)):
            first, count = spans[s, 0], spans[s, 1]
            for j in range(count):
                rows[row, column + j] = words[first + j]
            column += count
    return len(times)


def run_each(d, words, places, values, stops, output_indices, rows, continuing):
    """Run the instance once for each row of parameter values, each time from its start.

    The runs before leave nothing behind: no run changes a parameter, and ``initialize`` sets all else.

    Args:
        d: the instance.
        words: all numbers of its record (8 bytes each), shape (W,).
        places: indices of the words that vary, shape (K,).
        values: their values in each run, shape (R, K).
        stops: the end time of each run, shape (R,) [s].
        output_indices: indices of the words to return from the end of a run, shape (L,).
        rows: result, shape (R, L): the words that are asked for. After a fault the outputs among them are not
            those of the end.
        continuing: 1 if an earlier call has begun the first run, which now continues.

    Returns:
        How many runs are complete: fewer than requested to return within a second of computing. The next run
        has begun then.
    """
    work = work_of_a_call(d) + (work_done(d) if continuing else 0)
    for r in range(len(rows)):
        if r > 0 or not continuing:
            for j in range(len(places)):
                words[places[j]] = values[r, j]
            initialize(d, 0.0)
        if finish_run(d, stops[r], work) == PAUSED:
            return r
        work -= work_done(d)
        for j in range(len(output_indices)):
            rows[r, j] = words[output_indices[j]]
    return len(rows)


def finish_run(d, stop, work):
    """Advance to ``stop`` [s], and log the contacts that last there, for their peaks; returns a status."""
    log_capacity = len(d.finished.point) - d.candidates
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
