"""The loop of steps: how a run ends, and the events between two steps."""

import math

import numpy as np
import pytest

from chain_impact.kernel import advance as loop
from chain_impact.kernel.constraints.geometry import normal_row
from chain_impact.kernel.entry import UNLIMITED
from chain_impact.kernel.events import handlers
from chain_impact.kernel.ode.step_control import set_outcome
from chain_impact.kernel.record.constants import EXPLICIT, IMPLICIT, KINK, NO_EVENT, ONSET
from chain_impact.kernel.status import ENERGY_NOT_KEPT, LOG_FULL, NOT_FINITE, OK, PAUSED, STEP_TOO_SMALL
from chain_impact.scene.scene import load_scene
from tests.helpers.kernel.plain import initialized
from tests.helpers.scenes.friction import pendulum
from tests.kernel.chains import chain, locate_touching_state, mark_touching


def started():
    return initialized(load_scene("four_link_box"))


def advance(d, time, cost_limit=UNLIMITED):
    return loop.advance(d, time, UNLIMITED, cost_limit)


@pytest.mark.parametrize(("error", "status"), [(2.0, STEP_TOO_SMALL), (math.nan, NOT_FINITE)])
def test_a_run_ends_where_no_size_of_a_step_will_do(monkeypatch, error, status):
    d = started()
    assert advance(d, 0.1) == OK
    reached, state = float(d["step"]["end"]), d["step"]["state_end"].copy()
    monkeypatch.setattr(loop, "integrate_trial", lambda d, _h: set_outcome(d, error, 1.0))
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
    d = initialized(pendulum())  # a pendulum of two elements, whose modes both change at the start
    assert (d.friction_element_count, d.friction_changes.count, len(d.friction_changes.time)) == (2, 2, 8)
    d.friction_changes.count = logged
    assert loop.log_is_full(d, 10) == full
    steps = int(d.statistics.steps)
    assert loop.advance(d, 1e-3, 5, UNLIMITED) == (LOG_FULL if full else OK)
    assert (d.statistics.steps > steps) != full
    # without a caller that collects, new changes overwrite the oldest changes
    assert loop.advance(d, 2e-3, UNLIMITED, UNLIMITED) == OK
    d.friction_changes.count = 0
    assert loop.advance(d, 3e-3, 5, UNLIMITED) == OK
    # a record without dry friction has no log of changes
    d = started()
    assert (d.friction_element_count, len(d.friction_changes.time)) == (0, 0)
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
    d = at_end_of_a_step([NO_EVENT, ONSET])
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
    ("events", "are_known"),
    [
        ([], (0, False)),
        ([ONSET, NO_EVENT, ONSET], (2, False)),
        ([ONSET, KINK], (2, True)),
        ([KINK, ONSET], (2, True)),
    ],
)
def test_events_are_counted_and_kinks_are_told(monkeypatch, events, are_known):
    d = at_end_of_a_step(events)
    monkeypatch.setattr(loop, "apply_events", lambda _: False)
    assert loop.apply_pending_events(d) == are_known


@pytest.mark.parametrize("changed", [False, True])
def test_the_rate_after_events_is_worked_out_where_they_change_it(monkeypatch, changed):
    d = at_end_of_a_step([ONSET])
    monkeypatch.setattr(loop, "apply_events", lambda _: changed)
    loop.ensure_rate(d)
    rate = d.scratch.rate_end.copy()
    d.scratch.rate_end[:] = old = np.arange(len(rate)) + 0.5
    before = d.statistics.rhs_evaluations
    loop.apply_pending_events(d)
    np.testing.assert_array_equal(d.scratch.rate_start, rate if changed else old)
    assert d.statistics.rhs_evaluations - before == changed


@pytest.mark.parametrize(
    ("rigid", "touching", "events", "expected"),
    [(1, 0, 1, True), (0, 0, 1, False), (1, 1, 1, False), (1, 0, 0, False)],
)
def test_a_step_after_a_rigid_impact_is_as_in_flight(monkeypatch, rigid, touching, events, expected):
    d = at_end_of_a_step()
    if touching:
        mark_touching(d, [0])
    d.contact_settings.any_rigid, d.step.method = rigid, EXPLICIT
    monkeypatch.setattr(loop, "apply_pending_events", lambda _: (events, True))
    monkeypatch.setattr(loop.step_control, "size_in_flight", lambda *_: 1e-3)
    for size in (1e-2, 1e-4):
        d.step.next_size = size
        assert loop.begin_step(d) == events
        assert d.step.next_size == (min(size, 1e-3) if expected else size)
    d.step.next_size, d.step.method = 1e-2, IMPLICIT  # the implicit method measures the size itself
    loop.begin_step(d)
    assert d.step.next_size == 1e-2


@pytest.mark.parametrize(("kinked", "method"), [(True, IMPLICIT), (False, EXPLICIT)])
def test_a_step_cut_by_a_kink_says_nothing_about_the_method(monkeypatch, kinked, method):
    """In flight without springs the choice of the method is the explicit one."""
    d = at_end_of_a_step()
    d.step.method = IMPLICIT
    monkeypatch.setattr(loop, "apply_pending_events", lambda _: (1, kinked))
    loop.begin_step(d)
    assert d.step.method == method


@pytest.mark.parametrize("status", [OK, STEP_TOO_SMALL])
def test_the_status_after_the_onsets_at_a_communication_point_is_told(monkeypatch, status):
    d = at_end_of_a_step([ONSET, ONSET])

    def apply_one_onset(d):
        d.contacts.event[list(d.contacts.event).index(ONSET)] = NO_EVENT
        return status

    monkeypatch.setattr(loop, "advance_one_step", apply_one_onset)
    assert loop.event_update(d) == status
    assert d.contacts.event[:2].tolist() == ([NO_EVENT, NO_EVENT] if status == OK else [NO_EVENT, ONSET])
    # a refused change ends the run
    d.contacts.event[:2] = ONSET
    monkeypatch.setattr(loop, "restart_if_changed", lambda *_: STEP_TOO_SMALL)
    assert loop.event_update(d) == STEP_TOO_SMALL
    assert d.contacts.event[:2].tolist() == [ONSET, ONSET]


@pytest.mark.parametrize(("events", "changed"), [([], True), ([ONSET], False), ([ONSET], True)])
def test_impulses_are_stored_and_begun_anew_at_events(monkeypatch, events, changed):
    """Events add to stored impulses; where they change the forces, the rates are evaluated again."""
    d = at_end_of_a_step(events)
    locate_touching_state(np.random.default_rng(3), d, [0])
    loop.ensure_rate(d)
    d.quadrature.count, d.quadrature.index[0] = 1, 0
    d.quadrature.state_end[0], d.quadrature.rate_end[0], d.quadrature.dense[:, 0] = 3.0, 7.0, 1.0

    def apply_events(d):
        d.quadrature.integral[0] += 2.0
        return changed

    monkeypatch.setattr(loop, "apply_events", apply_events)
    loop.apply_pending_events(d)
    assert d.quadrature.state_end[0] == (5.0 if events else 3.0)
    assert (d.quadrature.rate_end[0] == 7.0) == (not (events and changed))
    assert (d.quadrature.dense[:, 0] == (0.0 if events else 1.0)).all()


@pytest.mark.parametrize(
    ("status", "given", "goes_on", "expected"),
    [
        (OK, (0.5, 1), False, 77),
        (OK, (0.0, 1), False, OK),  # set back
        (OK, (0.5, 1), True, OK),
        (OK, (0.0, 0), False, OK),
        (STEP_TOO_SMALL, (0.5, 1), False, STEP_TOO_SMALL),
    ],
)
def test_a_change_that_jumps_is_applied_at_the_communication_point(
    monkeypatch, status, given, goes_on, expected
):
    d = at_end_of_a_step()
    d.statistics.status, (d.given.motor[0], d.given.pending) = status, given
    monkeypatch.setattr(loop, "inputs_continue", lambda _: goes_on)
    monkeypatch.setattr(loop, "restart", lambda _: 77)
    assert loop.restart_if_changed(d, 0.0) == d.statistics.status == expected


@pytest.mark.parametrize("pulled", [False, True])
@pytest.mark.parametrize("changed", [False, True])
@pytest.mark.parametrize("held", [False, True])
def test_points_held_by_rigid_walls_are_found_again_after_a_change(held, changed, pulled):
    """A contact ends if its wall has got a force law, or if the wall would have to pull the point."""
    d = at_end_of_a_step(model="newton_impact", restitution=0.5)
    y = locate_touching_state(np.random.default_rng(3), d, [0] * held, 0.0)
    y[d.link_count + 2 :] = 0.0  # at rest
    d.step.state_end[:], d.step.start, d.step.end = y, 0.4, 0.5
    d.law.rigid[0] = not changed
    normal = np.array(normal_row(d, 0)[1:])
    d.chain.gravity[:] = (9.81 if pulled else -9.81) * normal
    handlers.recompute_active_set(d)
    assert d.contacts.active[0] == (held and not changed and not pulled)
    assert d.step.start == (0.5 if held else 0.4)
