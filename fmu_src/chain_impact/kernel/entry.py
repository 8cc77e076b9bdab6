"""What a caller can ask of an instance. The C functions for it are in compilation/entry_points.py."""

from chain_impact.kernel.advance import advance, restart
from chain_impact.kernel.observe import observe
from chain_impact.kernel.status import OK
from chain_impact.kernel.work_limit import work_done, work_of_a_call

UNLIMITED = 1 << 62


def advance_to(d, time):
    """Bring the instance to ``time`` [s]; returns a status.

    If nobody collects the finished contacts, the oldest are lost.
    """
    return advance(d, time, UNLIMITED, UNLIMITED)


def advance_awhile(d, time):
    """As ``advance_to``, but return PAUSED after less than a second's work: the caller may want to stop."""
    return advance(d, time, UNLIMITED, work_done(d) + work_of_a_call(d))


def observe_now(d):
    """Fill the outputs with what holds at the communication point; returns a status."""
    if d.statistics.status == OK and d.inputs.changed and restart(d) != OK:
        d.inputs.changed = 1  # a parameter that goes with the others may yet be set before the next step
    observe(d)
    return d.statistics.status


def trajectory(d, times, output, rows):
    """Advance to each of the times [s] in turn and fill one row of outputs for each.

    Args:
        d: the instance.
        times: shape (T,), increasing [s].
        output: the numbers of ``d.output``, shape (W,).
        rows: result, shape (T, W).

    Returns:
        The number of rows filled: fewer than asked for after a fault, when the log of finished contacts is
        about to overflow and has to be collected, or after less than a second's work.
    """
    room = len(d.finished.point) - d.candidates
    work = work_done(d) + work_of_a_call(d)
    for row in range(len(times)):
        if advance(d, times[row], room, work) != OK:
            return row
        observe(d)
        for j in range(len(output)):
            rows[row, j] = output[j]
    return len(times)
