"""Derivatives of a run: each step of the primal instance d is repeated by the tangent instance t.

t has the same layout as d, and its reals are dual numbers: they carry the derivatives in some directions of
the parameters. Its values are those of d. After each step that d has accepted, t makes the same step with the
same functions, which then differentiate the step. Rejected steps and the search for events are not repeated:
the size of the step, its method and its events are frozen from the primal run. They are choices of the
discretization, and have no derivatives.

An event ends a step where a function φ of the state passes through zero, at a time that depends on the
parameters, too. With φ′ the derivatives of φ where the step of d ends, that time changes by −φ′/φ̇, and the
state there by ẏ times that. Time is part of the state, so nothing else has to be known about an event: its
change of the state is differentiated like everything else. At the kink of a force the rate is continuous,
so the derivative of its time has no effect.

Source: for sensitivities through events, e.g. Galán, Feehery & Barton 1999, Appl Numer Math 31:17.
"""

from chain_impact.kernel.advance import apply_pending_events, set_first_stage
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.chain.state import sundman_u_at, time_at
from chain_impact.kernel.events.exclusion import RELATCH_RATIO
from chain_impact.kernel.events.marks import END, ONSET, RELATCH, copy_marks, pending_changes
from chain_impact.kernel.integration import explicit
from chain_impact.kernel.integration.control import begin_trial
from chain_impact.kernel.integration.last_step import (
    accept,
    choose_variable,
    ensure_points,
    ensure_rate,
    mark_jump,
    truncate_step,
)
from chain_impact.kernel.integration.method import IMPLICIT
from chain_impact.kernel.integration.quadratures import settle_impulses
from chain_impact.kernel.model.friction import any_sticking
from chain_impact.kernel.model.geometry import clearance, gap_acceleration
from chain_impact.kernel.tangent.directions import carried, value
from chain_impact.kernel.tangent.friction import check_changes, delay_of_change
from chain_impact.kernel.tangent.implicit_step import make_implicit
from chain_impact.kernel.tangent.start import copy_inputs, copy_modes
from chain_impact.kernel.tangent.trust import check_onsets, check_turns


def replay(d, t):
    """Repeat the last step of d in dual numbers."""
    copy_modes(d, t)
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
    settle_impulses(t)
    copy_marks(d, t)
    move_end(t)


def make(d, t, h):
    """Make a step of size h as d did, without its error control."""
    begin_trial(t, h)
    if t.step.method == IMPLICIT:
        make_implicit(d, t, h)
    else:
        explicit.make(t, h)
        if t.touch.active_count > 0 or any_sticking(t):
            locate_points(t, t.trial.state)
    accept(t)


def ends_regularized(d):
    """Whether the last step ends where the regularized contact does.

    d has taken that step beyond the end, where the slope of the force has a kink, and has truncated it.
    """
    return d.step.regularized >= 0 and d.touch.event[d.step.regularized] == END


def take_values(d, t):
    """Set the values of t at the end of the last step to those of d, which differ by round-off."""
    for j in range(len(d.step.state_end)):
        t.step.state_end[j] = carried(d.step.state_end[j], 1.0, t.step.state_end[j])
    t.step.end = carried(d.step.end, 1.0, t.step.end)


def move_end(t):
    """Give the end of the last step the derivatives of the time of the event that ends it."""
    for c in range(t.candidates):
        kind = t.touch.event[c]
        # at the end of a regularized contact dt/ds = 0: a change of s there does not change the state
        if kind in (ONSET, RELATCH) or (kind == END and c != t.step.regularized):
            ensure_rate(t)
            ensure_points(t)
            check_onsets(t)
            move_along(t, delay(t, c, kind))
            return
    if pending_changes(t) > 0:
        ensure_rate(t)
        ensure_points(t)
        time = delay_of_change(t)
        check_changes(t, time)
        move_along(t, time)


def delay(t, c, kind):
    """−φ′/φ̇ of an event of candidate c: the change of its time [s], a dual number of value 0."""
    gap, gap_rate = clearance(t, c)
    if kind == RELATCH:
        # φ = −ġ − 2 v₀
        change, rate = (
            -gap_rate - RELATCH_RATIO * t.touch.impact_speed[c],
            -gap_acceleration(t, c),
        )
    else:
        change, rate = gap, gap_rate
    return carried(0.0, -1.0 / value(rate), change)


def move_along(t, time):
    """Move the end of the last step along the motion by a ``time`` [s] of value 0 with derivatives."""
    y, rate = t.step.state_end, t.work.rate_end
    for j in range(sundman_u_at(t.links)):
        y[j] += value(rate[j]) * time
    y[time_at(t.links)] += time
    t.step.end += time
    own = t.quadrature
    for k in range(own.count):
        own.state_end[k] += value(own.rate_end[k]) * time
    mark_jump(t)
