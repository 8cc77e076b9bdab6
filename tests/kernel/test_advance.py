"""The loop of steps: how a run ends, and the events between two steps."""

import math

import numpy as np
import pytest

from chain_impact.kernel import advance as loop
from chain_impact.kernel.entry import UNLIMITED
from chain_impact.kernel.events import handlers
from chain_impact.kernel.ode import last_step
from chain_impact.kernel.ode.control import set_outcome
from chain_impact.kernel.record.constants import EXPLICIT, IMPLICIT, KINK, NONE, ONSET
from chain_impact.kernel.status import ENERGY_NOT_KEPT, LOG_FULL, NOT_FINITE, OK, PAUSED, STEP_TOO_SMALL
from chain_impact.scene.scene import load_scene
from tests.helpers.kernel.plain import begun
from tests.helpers.scenes.friction import pendulum
from tests.kernel.chains import chain, touch


def started():
    return begun(load_scene("four_link_box"))


def advance(d, time, cost_limit=UNLIMITED):
    return loop.advance(d, time, UNLIMITED, cost_limit)


@pytest.mark.parametrize(("error", "status"), [(2.0, STEP_TOO_SMALL), (math.nan, NOT_FINITE)])
def test_a_run_ends_where_no_size_of_a_step_will_do(monkeypatch, error, status):
    d = started()
    assert advance(d, 0.1) == OK
    reached, state = float(d["step"]["end"]), d["step"]["state_end"].copy()
    monkeypatch.setattr(loop, "attempt_step", lambda d, _h: set_outcome(d, error, 1.0))
    assert advance(d, 0.2) == status
    assert advance(d, 0.3) == status
    # the run stands at the last accepted time
    assert [float(d["step"][name]) for name in ("communication_point", "end")] == [reached, reached]
    np.testing.assert_array_equal(d["step"]["state_end"][:-1], state[:-1])


def test_a_run_ends_when_its_energy_drifts(monkeypatch):
    d = started()
    monkeypatch.setattr(loop, "check_balance", lambda _d: ENERGY_NOT_KEPT)
    assert advance(d, 0.5) == ENERGY_NOT_KEPT
    assert d["statistics"]["steps"] == 1


def test_a_call_pauses_after_its_cost_and_goes_on():
    whole, parts, calls = started(), started(), 0
    assert advance(whole, 0.6) == OK
    while (status := advance(parts, 0.6, cost_limit=loop.cost_so_far(parts) + 100)) == PAUSED:
        calls += 1
    assert status == OK
    assert calls > 3
    np.testing.assert_array_equal(parts["step"]["state_end"], whole["step"]["state_end"])


@pytest.mark.parametrize(("logged", "full"), [(0, False), (6, False), (7, True), (8, True), (100, True)])
def test_the_log_of_changes_is_full_without_room_for_each_element(logged, full):
    d = begun(pendulum())  # a pendulum of two elements, whose modes both change at the start
    assert (d.elements, d.changes.count, len(d.changes.time)) == (2, 2, 8)
    d.changes.count = logged
    assert loop.log_is_full(d, 10) == full
    steps = int(d.statistics.steps)
    assert loop.advance(d, 1e-3, 5, UNLIMITED) == (LOG_FULL if full else OK)
    assert (d.statistics.steps > steps) != full
    # without a caller that collects, new changes overwrite the oldest changes
    assert loop.advance(d, 2e-3, UNLIMITED, UNLIMITED) == OK
    d.changes.count = 0
    assert loop.advance(d, 3e-3, 5, UNLIMITED) == OK
    # a record without dry friction has no log of changes
    d = started()
    assert (d.elements, len(d.changes.time)) == (0, 0)
    assert not loop.log_is_full(d, 10)


def at_end_of_a_step(events=(), **more):
    _, d = chain(np.random.default_rng(2), 2, **more)
    d.contacts.event[: len(events)] = events
    return d


def test_a_call_stops_where_the_log_is_full():
    d = at_end_of_a_step()
    d.contact_log.count, d.contact_log.collected = 8, 5
    assert loop.advance(d, 0.01, 3, loop.cost_so_far(d) + 10**6) == LOG_FULL
    assert d.step.end == 0.0
    assert loop.advance(d, 0.01, 4, loop.cost_so_far(d) + 10**6) == OK
    assert d.step.end >= 0.01


def test_an_onset_is_due_at_the_end_of_the_step_only():
    d = at_end_of_a_step([NONE, ONSET])
    d.step.end = d.step.communication_point = 0.5
    assert loop.ends_in_onset(d)
    assert loop.is_onset_due(d)
    d.step.communication_point = 0.4
    assert not loop.is_onset_due(d)
    d.step.communication_point = 0.5
    d.contacts.event[1] = KINK
    assert not loop.ends_in_onset(d)
    assert not loop.is_onset_due(d)


@pytest.mark.parametrize(
    ("events", "known"),
    [
        ([], (0, False)),
        ([ONSET, NONE, ONSET], (2, False)),
        ([ONSET, KINK], (2, True)),
        ([KINK, ONSET], (2, True)),
    ],
)
def test_events_are_counted_and_kinks_are_told(monkeypatch, events, known):
    d = at_end_of_a_step(events)
    monkeypatch.setattr(loop, "apply_events", lambda _: False)
    assert loop.apply_pending_events(d) == known


@pytest.mark.parametrize("changed", [False, True])
def test_the_rate_after_events_is_worked_out_where_they_change_it(monkeypatch, changed):
    d, rates = at_end_of_a_step([ONSET]), []
    monkeypatch.setattr(loop, "apply_events", lambda _: changed)
    loop.ensure_rate(d)
    monkeypatch.setattr(last_step, "rate_from_state", lambda _d, _y, rate: rates.append(rate.copy()))
    d.scratch.rate_end[:] = np.arange(len(d.scratch.state))
    before = d.statistics.rhs_evaluations
    loop.apply_pending_events(d)
    assert d.scratch.rate_start.tolist() == list(range(len(d.scratch.state)))
    assert d.statistics.rhs_evaluations - before == len(rates) == changed


@pytest.mark.parametrize(
    ("rigid", "compliant", "events", "right"),
    [(1, 0, 1, True), (0, 0, 1, False), (1, 1, 1, False), (1, 0, 0, False)],
)
def test_a_step_after_a_rigid_impact_is_as_in_flight(monkeypatch, rigid, compliant, events, right):
    d = at_end_of_a_step()
    if compliant:
        touch(d, [0])
    d.contact_settings.any_rigid, d.step.method = rigid, EXPLICIT
    monkeypatch.setattr(loop, "apply_pending_events", lambda _: (events, True))
    monkeypatch.setattr(loop.control, "size_in_flight", lambda *_: 1e-3)
    for size in (1e-2, 1e-4):
        d.step.next_size = size
        assert loop.begin_step(d) == events
        assert d.step.next_size == (min(size, 1e-3) if right else size)
    d.step.next_size, d.step.method = 1e-2, IMPLICIT  # the implicit method measures the size itself
    loop.begin_step(d)
    assert d.step.next_size == 1e-2


def test_a_step_cut_by_a_kink_says_nothing_about_the_method(monkeypatch):
    d, chosen = at_end_of_a_step(), []
    monkeypatch.setattr(loop, "choose_method", lambda _: chosen.append(True))
    for kinked in (True, False):
        monkeypatch.setattr(loop, "apply_pending_events", lambda _, kinked=kinked: (1, kinked))
        loop.begin_step(d)
    assert len(chosen) == 1


@pytest.mark.parametrize("status", [OK, STEP_TOO_SMALL])
def test_the_status_after_the_onsets_at_a_communication_point_is_told(monkeypatch, status):
    d, due = at_end_of_a_step(), [True, True, False]
    monkeypatch.setattr(loop, "reinit_if_changed", lambda *_: OK)
    monkeypatch.setattr(loop, "is_onset_due", lambda _: due.pop(0))
    monkeypatch.setattr(loop, "advance_one_step", lambda _: status)
    assert loop.event_update(d) == status
    assert len(due) == (0 if status == OK else 2)
    # a refused change ends the run
    monkeypatch.setattr(loop, "reinit_if_changed", lambda *_: STEP_TOO_SMALL)
    assert loop.event_update(d) == STEP_TOO_SMALL


@pytest.mark.parametrize(("events", "changed"), [([], True), ([ONSET], False), ([ONSET], True)])
def test_impulses_are_stored_and_begun_anew_at_events(monkeypatch, events, changed):
    d, done = at_end_of_a_step(events), []
    loop.ensure_rate(d)
    monkeypatch.setattr(loop, "apply_events", lambda _: done.append("apply") or changed)
    for name in ("commit_quadratures", "reset_quadratures"):
        monkeypatch.setattr(loop, name, lambda _, name=name: done.append(name))
    monkeypatch.setattr(last_step, "store_end_rates", lambda _: done.append("store_end_rates"))
    loop.apply_pending_events(d)
    kept = ["store_end_rates"] if changed else []
    assert done == (["commit_quadratures", "apply", "reset_quadratures", *kept] if events else [])


@pytest.mark.parametrize(
    ("status", "given", "goes_on", "right"),
    [
        (OK, (0.5, 1), False, 77),
        (OK, (0.0, 1), False, OK),  # set back
        (OK, (0.5, 1), True, OK),
        (OK, (0.0, 0), False, OK),
        (STEP_TOO_SMALL, (0.5, 1), False, STEP_TOO_SMALL),
    ],
)
def test_a_change_that_jumps_is_applied_at_the_communication_point(
    monkeypatch, status, given, goes_on, right
):
    d = at_end_of_a_step()
    d.statistics.status, (d.given.motor[0], d.given.pending) = status, given
    monkeypatch.setattr(loop, "inputs_continue", lambda _: goes_on)
    monkeypatch.setattr(loop, "reinit", lambda _: 77)
    assert loop.reinit_if_changed(d, 0.0) == d.statistics.status == right


@pytest.mark.parametrize("held", [(False,), (True, False), (True, True)])
def test_points_held_by_rigid_walls_are_found_again_after_a_change(monkeypatch, held):
    d, done, answers = at_end_of_a_step(), [], list(held)
    d.step.end = 0.5
    monkeypatch.setattr(handlers, "any_point_held", lambda _: answers.pop(0))
    for name in ("end_changed_contacts", "update_active_set"):
        monkeypatch.setattr(handlers, name, lambda _, name=name: done.append(name))
    monkeypatch.setattr(handlers, "reset_step", lambda d, time, y: done.append((time, y is d.step.state_end)))
    handlers.recompute_active_set(d)
    found = ["end_changed_contacts", *["update_active_set"] * held[-1], (0.5, True)]
    assert done == (found if held[0] else [])
