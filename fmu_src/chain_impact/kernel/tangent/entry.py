"""What a caller can ask of an instance d and of its instances of dual numbers, ``count`` from ``first``.

The functions are those of kernel/entry.py and kernel/advance.py with derivatives beside.
"""

import math

from chain_impact.kernel.advance import go_on, look_at, renew
from chain_impact.kernel.events.contact_log import follow_to_now
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.observe import observe
from chain_impact.kernel.status import LOG_FULL, OK, PAUSED
from chain_impact.kernel.tangent.blocks import block, words
from chain_impact.kernel.tangent.directions import DIRECTIONS
from chain_impact.kernel.tangent.replay import catch_up, replay
from chain_impact.kernel.tangent.start import start, start_anew
from chain_impact.kernel.tangent.trust import trusted
from chain_impact.kernel.work_limit import work_done, work_of_a_call


def initialize_with(d, first, count, time):
    """Set d and the others to their start at ``time`` [s]; returns a status."""
    status = initialize(d, time)
    for b in range(count if status == OK else 0):
        start(d, block(first, b))
    return status


def advance_with(d, first, count, time, room, work):
    """Bring d and the others to ``time`` [s]; returns a status, as ``advance`` does."""
    changed, status = d.given.changed, renew(d)
    for b in range(count if status == OK and changed else 0):
        start_anew(d, block(first, b))
    for b in range(count if status == OK else 0):
        catch_up(d, block(first, b), time)
    while status == OK and d.step.end < time:
        if d.finished.count >= room:
            return LOG_FULL
        if work_done(d) > work:
            return PAUSED
        status = go_on(d)
        for b in range(count if status == OK else 0):
            replay(d, block(first, b), time)
    if status == OK:
        look_at(d, time)
        for b in range(count):
            look_at(block(first, b), time)
    return status


def trajectory_with(d, first, count, times, looks, values, slopes):
    """Advance to each of the times [s] in turn, and look at some outputs and their derivatives.

    Args:
        d: the instance.
        first: the first instance of dual numbers.
        count: how many there are, B.
        times: shape (T,), increasing [s].
        looks: the outputs that are wanted, as indices of numbers in ``d.output``, shape (W,).
        values: result, shape (T, W).
        slopes: result, shape (T, W · B · DIRECTIONS).

    Returns:
        The number of rows filled, as of ``trajectory``.
    """
    room = len(d.finished.point) - d.candidates
    work = work_done(d) + work_of_a_call(d)
    for row in range(len(times)):
        if advance_with(d, first, count, times[row], room, work) != OK:
            return row
        see(d, first, count, looks, values[row], slopes[row])
    return len(times)


def see(d, first, count, looks, values, slopes):
    """Fill a row of outputs and one of their derivatives with what holds at the communication point."""
    observe(d)
    for j in range(len(looks)):
        values[j] = words(d.output)[looks[j]]
    for b in range(count):
        t = block(first, b)
        observe(t)
        seen, known = words(t.output), trusted(t)
        for j in range(len(looks)):
            for k in range(DIRECTIONS):
                slope = seen[looks[j] * (1 + DIRECTIONS) + 1 + k]
                slopes[(j * count + b) * DIRECTIONS + k] = slope if known else math.nan


def follow_with(d, first, count):
    """Follow the contacts of all up to the communication point."""
    follow_to_now(d)
    for b in range(count):
        follow_to_now(block(first, b))
    return 0
