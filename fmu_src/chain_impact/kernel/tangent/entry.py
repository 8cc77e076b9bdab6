"""Derivatives beside a run of an instance d: by the instances of dual numbers behind it in memory.

What is in HOOKS takes the place of the functions of kernel/beside.py, so that whatever advances d advances
those instances, too.
"""

import math

from chain_impact.kernel import beside
from chain_impact.kernel.advance import advance, set_present
from chain_impact.kernel.events.contact_log import follow_to_present
from chain_impact.kernel.observe import fill_outputs, observe
from chain_impact.kernel.soundness import within_bounds
from chain_impact.kernel.status import OK
from chain_impact.kernel.tangent.blocks import block, words
from chain_impact.kernel.tangent.directions import DIRECTIONS
from chain_impact.kernel.tangent.replay import move_end, replay
from chain_impact.kernel.tangent.start import start, start_anew
from chain_impact.kernel.tangent.trust import share_distrust, trusted
from chain_impact.kernel.work_limit import allow_any_length, work_done, work_of_a_call


def begin_all(d):
    """Set all to their start."""
    for b in range(d.tangents):
        start(d, block(d, b))


def start_all_anew(d):
    """Start all anew from the communication point."""
    for b in range(d.tangents):
        start_anew(d, block(d, b))


def replay_step(d):
    """Make the last step of d."""
    for b in range(d.tangents):
        replay(d, block(d, b))
    for b in range(d.tangents):
        for other in range(d.tangents):
            share_distrust(block(d, b), block(d, other))


def look_at_all(d, time):
    """Make a ``time`` [s] the communication point of all."""
    for b in range(d.tangents):
        set_present(block(d, b), time)


def observe_all(d):
    """Fill the outputs with derivatives, NaN where these cannot be trusted and after a fault."""
    for b in range(d.tangents):
        t = block(d, b)
        fill_outputs(t)
        if not trusted(t) or d.statistics.status != OK:
            forget_slopes(words(t.output))


def forget_slopes(dual_numbers):
    """Set all derivatives among the words of dual numbers to NaN."""
    for j in range(len(dual_numbers)):
        if j % (1 + DIRECTIONS) > 0:
            dual_numbers[j] = math.nan


def follow_all(d):
    """Follow the contacts of all to the communication point."""
    for b in range(d.tangents):
        t = block(d, b)
        follow_to_present(t)
        move_end(t)


def all_sound(d):
    """Whether all sizes and indices are such."""
    fits = True
    for b in range(d.tangents):
        t = block(d, b)
        fits = fits and t.links == d.links and t.candidates == d.candidates and within_bounds(t)
    return fits


HOOKS = {
    beside.begin: begin_all,
    beside.anew: start_all_anew,
    beside.step: replay_step,
    beside.look: look_at_all,
    beside.observe: observe_all,
    beside.follow: follow_all,
    beside.sound: all_sound,
}
"""Function of kernel/beside.py → what it does in a kernel that carries derivatives."""


def trajectory_with(d, times, looks, values, slopes):
    """Advance to each of the times [s] in turn, and look at some outputs and their derivatives.

    Args:
        d: the instance, with B of dual numbers behind it.
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
        allow_any_length(d)
        if advance(d, times[row], room, work) != OK:
            return row
        observe(d)
        see(d, looks, values[row], slopes[row])
    return len(times)


def see(d, looks, values, slopes):
    """Fill a row of outputs and one of their derivatives with what has been observed."""
    count = d.tangents
    for j in range(len(looks)):
        values[j] = words(d.output)[looks[j]]
    for b in range(count):
        seen = words(block(d, b).output)
        for j in range(len(looks)):
            for k in range(DIRECTIONS):
                slopes[(j * count + b) * DIRECTIONS + k] = seen[looks[j] * (1 + DIRECTIONS) + 1 + k]
