"""Derivatives of a run of the instance d, in the tangent instances that follow d in memory.

The functions in HOOKS replace those of kernel/hooks.py, so that every function that advances d also advances
the tangent instances.
"""

import math

from chain_impact.kernel import hooks
from chain_impact.kernel.entry import is_record_sound
from chain_impact.kernel.events.contact_log import update_instance_to_communication_point
from chain_impact.kernel.observe import fill_outputs, refill_outputs_but_integrals
from chain_impact.kernel.ode.last_step import (
    return_to_stored_state,
    set_communication_point_in_step,
    store_output_state,
)
from chain_impact.kernel.status import OK
from chain_impact.kernel.tangent.duals import DIRECTIONS, as_words, tangent_instance
from chain_impact.kernel.tangent.replay import replay, restart_tangent, start_tangent
from chain_impact.kernel.tangent.step_ends import move_end
from chain_impact.kernel.tangent.trust import copy_reason, is_trusted


def act_on_all_tangents(act):
    """Return a function of d that calls ``act`` (d, t) for each tangent instance t of the instance d.

    If derivatives have ended in some tangent instances, those in all instances then end at the earliest of
    these times, with the reason that belongs to this time.
    """

    def act_on_all(d):
        for b in range(d.tangent_count):
            act(d, tangent_instance(d, b))
        for b in range(1, d.tangent_count):
            copy_reason(tangent_instance(d, 0), tangent_instance(d, b))
        for b in range(1, d.tangent_count):
            copy_reason(tangent_instance(d, b), tangent_instance(d, 0))

    return act_on_all


def observe_tangent(d, t):
    """Set the derivatives of the outputs at the communication point; NaN if they cannot be trusted.

    The derivatives are also NaN after a fault of the run, and in the directions of ``forget_missing``. After
    ``mark_split`` only the derivatives of the outputs of friction and of transmitted forces are NaN.
    """
    set_communication_point_in_step(t, d.step.communication_point)
    fill_outputs(t)
    if not is_trusted(t) or d.statistics.status != OK:
        forget_slopes(as_words(t.output))
    elif t.trust.split:
        forget_slopes(as_words(t.output.friction))
        forget_slopes(as_words(t.output.transmitted))
    forget_missing(t)


def observe_trial_of_tangent(_d, t):
    """Set the derivatives of those outputs that a trial of new input or parameter values changes at once."""
    return_to_stored_state(t)
    refill_outputs_but_integrals(t)
    if not is_trusted(t):
        forget_slopes(as_words(t.output))
    forget_missing(t)


def forget_missing(t):
    """Set the derivatives of the outputs to NaN in the directions in which the motion has no derivatives."""
    words = as_words(t.output)
    for k in range(DIRECTIONS):
        if t.trust.missing[k]:
            for j in range(1 + k, len(words), 1 + DIRECTIONS):
                words[j] = math.nan


def forget_slopes(words):
    """Set all derivatives in the ``words`` of dual numbers to NaN."""
    for j in range(len(words)):
        if j % (1 + DIRECTIONS) > 0:
            words[j] = math.nan


def truncate_tangent(d, t):
    """Cut the last step of t at the communication point, and log the active contacts of t up to this point.

    The state there is stored, so that each trial of new input values can return to this state.
    """
    set_communication_point_in_step(t, d.step.communication_point)
    store_output_state(t)
    update_instance_to_communication_point(t)
    move_end(t)


def are_all_tangents_sound(d):
    """Return 1 if all tangent instances have the counts of d and valid indices, else 0."""
    fits = True
    for b in range(d.tangent_count):
        t = tangent_instance(d, b)
        fits = fits and t.link_count == d.link_count and t.candidate_count == d.candidate_count
        fits = (
            fits
            and t.friction_element_count == d.friction_element_count
            and t.transmitted_row_count == d.transmitted_row_count
            and t.channel_count == d.channel_count
        )
        fits = (
            fits
            and t.site_count == d.site_count
            and t.signal_count == d.signal_count
            and t.knot_count == d.knot_count
        )
        fits = fits and is_record_sound(t)
    return 1 if fits else 0


def tangent_word_count(d):
    """Return the number of words, of 8 bytes each, of all tangent instances together."""
    return d.tangent_count * len(as_words(tangent_instance(d, 0)))


HOOKS = {
    hooks.on_start: act_on_all_tangents(start_tangent),
    hooks.on_restart: act_on_all_tangents(restart_tangent),
    hooks.on_step: act_on_all_tangents(replay),
    hooks.on_observe: act_on_all_tangents(observe_tangent),
    hooks.on_observe_trial: act_on_all_tangents(observe_trial_of_tangent),
    hooks.on_truncate: act_on_all_tangents(truncate_tangent),
    hooks.are_tangents_sound: are_all_tangents_sound,
    hooks.tangent_words: tangent_word_count,
}
"""Function of kernel/hooks.py → its replacement in a kernel that carries derivatives."""
