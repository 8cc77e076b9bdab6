"""The loop of steps: what makes it try again, and what ends it."""

import math

import numpy as np
import pytest

from chain_impact.kernel import advance as loop
from chain_impact.kernel.entry import UNLIMITED
from chain_impact.kernel.events.marks import ONSET
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.integration.control import FAR_OFF, conclude, refuse
from chain_impact.kernel.integration.dense import fraction, interpolate
from chain_impact.kernel.status import (
    ENERGY_NOT_KEPT,
    LOG_FULL,
    NOT_FINITE,
    OK,
    PAUSED,
    STEP_TOO_SMALL,
    TOO_MUCH_WORK,
)
from chain_impact.scene.scene import load_scene, with_values
from chain_impact.variables.model import Model
from tests.friction import pendulum
from tests.plain import Plain


def started(**solver):
    changes = {("solver", key): value for key, value in solver.items()}
    d = Plain(Model(with_values(load_scene("four_link_box"), changes)).new_instance()[0])
    assert initialize(d, 0.0) == OK
    return d


def advance(d, time, work=UNLIMITED):
    return loop.advance(d, time, UNLIMITED, work)


def refused_twice(otherwise, value):
    """A function that refuses two steps, and then does what another one does."""
    calls = []

    def refusing(d, *args):
        calls.append(True)
        if len(calls) > 2:
            return otherwise(d, *args)
        refuse(d, FAR_OFF)
        return value

    return refusing


@pytest.mark.parametrize(("name", "value"), [("find_event", -1.0), ("check_energy", (0.0, 0.0))])
def test_a_step_that_is_refused_is_tried_anew_with_a_smaller_size(monkeypatch, name, value):
    free, refused = started(), started()
    assert advance(free, 1e-9) == OK
    monkeypatch.setattr(loop, name, refused_twice(getattr(loop, name), value))
    assert advance(refused, 1e-9) == OK
    assert refused["statistics"]["rejected_steps"] == free["statistics"]["rejected_steps"] + 2
    assert refused["step"]["end"] < 0.1 * free["step"]["end"]
    # and the motion is the same
    for d in (free, refused):
        assert advance(d, 0.1) == OK
        d["step"]["time"] = 0.1
    y = np.zeros((2, len(free["work"]["y"])))
    for row, d in zip(y, (free, refused), strict=True):
        interpolate(d["step"], fraction(d, 0.1), row)
    np.testing.assert_allclose(y[0, :-1], y[1, :-1], atol=1e-7)


def test_an_event_of_a_refused_step_does_not_take_effect(monkeypatch):
    d, find, marked = started(), loop.find_event, []

    def mark_first(d):
        if marked:
            return find(d)
        marked.append(True)
        d["touch"]["event"][3] = ONSET
        refuse(d, FAR_OFF)
        return 0.5

    monkeypatch.setattr(loop, "find_event", mark_first)
    assert advance(d, 1e-9) == OK
    assert not d["touch"]["event"].any()
    assert d["impact"]["count"] == 0


@pytest.mark.parametrize(("error", "status"), [(2.0, STEP_TOO_SMALL), (math.nan, NOT_FINITE)])
def test_a_run_ends_where_no_size_of_a_step_will_do(monkeypatch, error, status):
    d = started()
    assert advance(d, 0.1) == OK
    reached, state = float(d["step"]["end"]), d["step"]["state_end"].copy()
    monkeypatch.setattr(loop, "attempt", lambda d, _h: conclude(d, error, 1.0))
    assert advance(d, 0.2) == status
    assert advance(d, 0.3) == status
    # it stands at the last time that it has reached
    assert [float(d["step"][name]) for name in ("time", "end")] == [reached, reached]
    np.testing.assert_array_equal(d["step"]["state_end"][:-1], state[:-1])


def test_a_run_ends_when_its_energy_drifts(monkeypatch):
    d = started()
    monkeypatch.setattr(loop, "check_balance", lambda _d: ENERGY_NOT_KEPT)
    assert advance(d, 0.5) == ENERGY_NOT_KEPT
    assert d["statistics"]["steps"] == 1


def test_a_search_without_end_is_work(monkeypatch):
    d = started(work_limit=500.0)

    searches = []

    def long_search(d):
        searches.append(True)
        d["limits"]["other_work"] += 1000
        refuse(d, FAR_OFF)
        return -1.0

    monkeypatch.setattr(loop, "find_event", long_search)
    assert advance(d, 0.5) == TOO_MUCH_WORK
    assert len(searches) == 1


def test_a_call_pauses_after_its_work_and_goes_on():
    whole, parts, calls = started(), started(), 0
    assert advance(whole, 0.6) == OK
    while (status := advance(parts, 0.6, work=loop.work_done(parts) + 100)) == PAUSED:
        calls += 1
    assert status == OK
    assert calls > 3
    np.testing.assert_array_equal(parts["step"]["state_end"], whole["step"]["state_end"])


# --- the log of changes of dry friction --------------------------------------------------------------------


def pendulum_of_dry_joints():
    """A double pendulum with two elements, whose modes both change at the start."""
    d = Plain(Model(pendulum()).new_instance()[0])
    assert initialize(d, 0.0) == OK
    assert (d.elements, d.changes.count, len(d.changes.time)) == (2, 2, 8)
    return d


@pytest.mark.parametrize(("logged", "full"), [(0, False), (6, False), (7, True), (8, True), (100, True)])
def test_the_log_of_changes_is_full_where_one_more_of_each_element_has_no_room(logged, full):
    d = pendulum_of_dry_joints()
    d.changes.count = logged
    assert loop.log_is_full(d, 10) == full
    steps = int(d.statistics.steps)
    assert loop.advance(d, 1e-3, 5, UNLIMITED) == (LOG_FULL if full else OK)
    assert (d.statistics.steps > steps) != full
    # for a caller that does not collect, the oldest are overwritten
    assert loop.advance(d, 2e-3, UNLIMITED, UNLIMITED) == OK
    d.changes.count = 0
    assert loop.advance(d, 3e-3, 5, UNLIMITED) == OK


def test_a_record_without_dry_friction_has_no_log_that_could_be_full():
    d = started()
    assert (d.elements, len(d.changes.time)) == (0, 0)
    assert not loop.log_is_full(d, 10)
