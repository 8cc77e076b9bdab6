"""Derivatives beside the run: each step of d is made once more by t, in dual numbers.

t is an instance of the same layout as d whose reals carry their derivatives in some directions of the
parameters. Its values are those of d. After each step that d has accepted, t makes the same step with the
same functions, which then differentiate the step. What d tries and rejects, and how it searches for events,
is none of t's business: the size of the step, its method and its events are those of d. They are choices of
the discretization, and have no derivatives.

An event ends a step where a function φ of the state passes through zero, at a moment that depends on the
parameters, too. With φ′ the derivatives of φ where the step ends for d, that moment moves by −φ′/φ̇, and the
state there by ẏ times that. The time of the state is part of it, so nothing else has to be known of an event:
what it changes of the state is differentiated as all else is. At the kink of a force the rate does not
change, and its moment does not matter.

Source: for sensitivities through events, e.g. Galán, Feehery & Barton 1999, Appl Numer Math 31:17.
"""

from chain_impact.kernel.advance import apply_pending_events, set_first_stage
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.chain.state import sundman_u_at, time_at
from chain_impact.kernel.dispatch import dispatch
from chain_impact.kernel.events.exclusion import RELATCH_RATIO
from chain_impact.kernel.events.kinds import END, ONSET, RELATCH
from chain_impact.kernel.integration import explicit
from chain_impact.kernel.integration.impulse import impulse_count
from chain_impact.kernel.integration.last_step import (
    accept,
    choose_variable,
    ensure_points,
    ensure_rate,
    mark_jump,
    truncate_step,
)
from chain_impact.kernel.integration.method import EXPLICIT, IMPLICIT
from chain_impact.kernel.integration.methods import METHOD_COUNT
from chain_impact.kernel.model.geometry import along_normal, clearance
from chain_impact.kernel.tangent.directions import carried, value
from chain_impact.kernel.tangent.implicit_step import make_implicit
from chain_impact.kernel.tangent.start import copy_inputs
from chain_impact.kernel.tangent.trust import check_onsets, check_turns


def replay(d, t):
    """Make the last step of d in dual numbers."""
    apply_pending_events(t)
    copy_inputs(d, t)
    t.step.method = d.step.last_method
    choose_variable(t, True)
    set_first_stage(t)
    lands = ends_regularized(d)
    make(d, t, d.step.size * d.step.kept if lands else d.step.size)
    check_turns(t)
    if lands:
        take_values(d, t)
        mark_jump(t)
    else:
        if d.step.kept != 1.0:
            truncate_step(t, d.step.kept)
        take_values(d, t)
    for c in range(d.candidates):
        t.touch.event[c] = d.touch.event[c]
    move_end(t)


def make(d, t, h):
    """Make a step of size h as d did, without its error control."""
    _make(t.step.method, d, t, h)
    accept(t, h)


def make_explicit(_d, t, h):
    """Make an explicit step of size h; the result, whose points are located, stands in ``work.y``."""
    explicit.make(t, h)
    if t.touch.active_count > 0:
        locate_points(t, t.work.y)


_MAKERS = {EXPLICIT: make_explicit, IMPLICIT: make_implicit}
_make = dispatch([_MAKERS[method] for method in range(METHOD_COUNT)])


def ends_regularized(d):
    """Whether the last step ends where the regularized contact does.

    d has taken that step beyond it, where the slope of the force has a kink, and has cut it.
    """
    return d.step.regularized >= 0 and d.touch.event[d.step.regularized] == END


def take_values(d, t):
    """Let the values of t at the end of the last step be those of d, whatever the round-off."""
    for j in range(len(d.step.state_end)):
        t.step.state_end[j] = carried(d.step.state_end[j], 1.0, t.step.state_end[j])
    t.step.end = carried(d.step.end, 1.0, t.step.end)


def move_end(t):
    """Move the end of the last step with the event that ends it."""
    for c in range(t.candidates):
        kind = t.touch.event[c]
        # where a regularized contact ends its time stands still: moving along it changes nothing
        if kind in (ONSET, RELATCH) or (kind == END and c != t.step.regularized):
            ensure_rate(t)
            ensure_points(t)
            check_onsets(t)
            move_along(t, delay(t, c, kind))
            return


def delay(t, c, kind):
    """−φ′/φ̇ of an event of candidate c: how its moment moves [s], a dual number of value 0."""
    gap, gap_rate = clearance(t, c)
    if kind == RELATCH:
        # φ = −ġ − 2 v₀
        change, rate = (
            -gap_rate - RELATCH_RATIO * t.touch.impact_speed[c],
            -along_normal(t, c, t.work.acceleration),
        )
    else:
        change, rate = gap, gap_rate
    return carried(0.0, -1.0 / value(rate), change)


def move_along(t, time):
    """Move the end of the last step along the motion by a time [s] that has derivatives alone."""
    y, rate = t.step.state_end, t.work.rate_end
    for j in range(sundman_u_at(t.links)):
        y[j] += value(rate[j]) * time
    y[time_at(t.links)] += time
    t.step.end += time
    for k in range(impulse_count(t)):
        t.impulse.state_end[k] += value(t.touch.force_end[t.touch.active_index[k]]) * time
    mark_jump(t)
