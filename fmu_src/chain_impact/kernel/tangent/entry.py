"""Derivatives of a run of the instance d, in the tangent instances that follow it in memory.

The functions in HOOKS replace those of kernel/hooks.py, so that every function that advances d also advances
the tangent instances.
"""

import math

from chain_impact.kernel import hooks
from chain_impact.kernel.entry import within_bounds
from chain_impact.kernel.events.contact_log import update_own_to_output_time
from chain_impact.kernel.observe import fill_outputs, refill_motion
from chain_impact.kernel.ode.last_step import keep_state, return_to_kept_state, set_own_output_time
from chain_impact.kernel.status import OK
from chain_impact.kernel.tangent.duals import DIRECTIONS, block, words
from chain_impact.kernel.tangent.replay import move_end, reinit_tangent, replay, start_tangent
from chain_impact.kernel.tangent.trust import share_reason, trusted


def start_all(d):
    """Initialize all tangent instances at the start of a run."""
    for b in range(d.tangents):
        start_tangent(d, block(d, b))
    share_reasons(d)


def reinit_all(d):
    """Re-initialize all tangent instances at the communication point."""
    for b in range(d.tangents):
        reinit_tangent(d, block(d, b))
    share_reasons(d)


def replay_all(d):
    """Repeat the last step of d in all tangent instances."""
    for b in range(d.tangents):
        replay(d, block(d, b))
    share_reasons(d)


def share_reasons(d):
    """End the derivatives in all tangent instances where they end first in any."""
    for b in range(1, d.tangents):
        share_reason(block(d, 0), block(d, b))
    for b in range(1, d.tangents):
        share_reason(block(d, b), block(d, 0))


def set_output_time_of_all(d, time):
    """Make a ``time`` [s] the communication point of all tangent instances."""
    for b in range(d.tangents):
        set_own_output_time(block(d, b), time)


def observe_all(d):
    """Set the derivatives of the outputs: NaN where they cannot be trusted, and after a fault."""
    for b in range(d.tangents):
        t = block(d, b)
        fill_outputs(t)
        if not trusted(t) or d.statistics.status != OK:
            forget_slopes(words(t.output))


def keep_states(d):
    """Keep the states of all tangent instances at the communication point."""
    for b in range(d.tangents):
        keep_state(block(d, b))


def observe_trial_of_all(d):
    """Set the derivatives of the outputs that a trial moves at once."""
    for b in range(d.tangents):
        t = block(d, b)
        return_to_kept_state(t)
        refill_motion(t)
        if not trusted(t):
            forget_slopes(words(t.output))


def forget_slopes(dual_numbers):
    """Set all derivatives among the words of dual numbers to NaN."""
    for j in range(len(dual_numbers)):
        if j % (1 + DIRECTIONS) > 0:
            dual_numbers[j] = math.nan


def truncate_all(d):
    """Update the contacts of all tangent instances to the communication point."""
    for b in range(d.tangents):
        t = block(d, b)
        update_own_to_output_time(t)
        move_end(t)
    share_reasons(d)


def all_valid(d):
    """1 if all sizes and indices of the tangent instances are valid, or 0."""
    fits = True
    for b in range(d.tangents):
        t = block(d, b)
        fits = fits and t.links == d.links and t.candidates == d.candidates
        fits = fits and t.elements == d.elements and t.loads == d.loads and t.channels == d.channels
        fits = fits and within_bounds(t)
    return 1 if fits else 0


def words_of_all(d):
    """How many numbers of 8 bytes all tangent instances have."""
    return d.tangents * len(words(block(d, 0)))


HOOKS = {
    hooks.on_start: start_all,
    hooks.on_reinit: reinit_all,
    hooks.on_step: replay_all,
    hooks.on_output_time: set_output_time_of_all,
    hooks.on_observe: observe_all,
    hooks.on_trial: keep_states,
    hooks.on_observe_trial: observe_trial_of_all,
    hooks.on_truncate: truncate_all,
    hooks.indices_valid: all_valid,
    hooks.words_behind: words_of_all,
}
"""Function of kernel/hooks.py → what it does in a kernel that carries derivatives."""
