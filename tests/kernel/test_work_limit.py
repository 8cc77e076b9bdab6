"""Bounds on work and events: the counted work, the window of time, and the end of a run."""

# Tests: kernel/advance.py, kernel/work.py

import math

import numpy as np
import pytest

from chain_impact.kernel import work
from chain_impact.kernel.status import EVENT_STORM, OK, STEP_TOO_LONG, TOO_MUCH_WORK
from tests.helpers.kernel.plain import begun
from tests.helpers.scenes.bodies import cart
from tests.kernel.chains import chain


@pytest.fixture
def d():
    """Return a chain at 5 s with 700 evaluations at the start of the second, and 600 at the call's start."""
    _, d = chain(np.random.default_rng(0), 3)
    d.solver.work_limit = 100.0
    d.statistics.rhs_evaluations, d.limits.other_work = 500, 200
    d.limits.work_count, d.limits.call_count, d.limits.work_start, d.step.end = 700, 600, 5.0, 5.0
    return d


@pytest.mark.parametrize(("evaluations", "looks", "over"), [(100, 0, False), (0, 100, False), (60, 41, True)])
def test_the_limit_counts_all_work_in_a_second(d, evaluations, looks, over):
    d.statistics.rhs_evaluations += evaluations
    d.limits.other_work += looks
    assert work.work_done(d) == 700 + evaluations + looks
    assert work.work_exceeded(d) == over
    assert work.check_work(d) == (TOO_MUCH_WORK if over else OK)
    assert work.WORK_WINDOW == 1.0


def test_a_second_begins_where_the_last_one_has_ended(d):
    d.statistics.rhs_evaluations += 90
    for end, start, count in ((5.999, 5.0, 700), (6.0, 6.0, 790), (6.5, 6.0, 790), (7.25, 7.25, 790)):
        d.step.end = end
        assert work.check_work(d) == OK
        assert (d.limits.work_start, d.limits.work_count) == (start, count)
    d.statistics.rhs_evaluations += 101
    assert work.check_work(d) == TOO_MUCH_WORK


def test_a_communication_step_may_take_as_much_as_twenty_seconds_may(d):
    d.limits.work_count = d.limits.call_count + int(work.LONGEST_CALL) * 100
    d.statistics.rhs_evaluations, d.limits.other_work = d.limits.work_count, 0
    assert work.check_work(d) == OK
    d.limits.other_work = 1
    assert work.check_work(d) == STEP_TOO_LONG
    work.allow_any_length(d)
    assert work.check_work(d) == OK
    d.limits.other_work = 101  # no second may take more work
    assert work.check_work(d) == TOO_MUCH_WORK


@pytest.mark.parametrize("count", [1, 100])
def test_a_call_returns_after_as_much_work_of_the_points_of_a_chain(count):
    _, d = chain(np.random.default_rng(0), count)
    most = work.work_of_a_call(d)
    assert most == int(most)
    assert work.CALL_WORK - count <= most * (count + 1) <= work.CALL_WORK


def test_too_many_events_in_a_short_time_are_a_storm(d):
    limit = work.MOST_EVENTS * d.candidates
    d.limits.event_start, d.limits.event_count = 5.0, 7
    assert work.check_events(d, limit - 7) == OK
    assert d.limits.event_count == limit
    assert work.check_events(d, 0) == OK
    assert work.check_events(d, 1) == EVENT_STORM
    # a new window begins
    d.step.end = math.nextafter(5.0 + work.EVENT_WINDOW, 0.0)
    assert work.check_events(d, 0) == EVENT_STORM
    d.step.end = 5.0 + work.EVENT_WINDOW
    assert work.check_events(d, 3) == OK
    assert (d.limits.event_start, d.limits.event_count) == (d.step.end, 3)


@pytest.mark.parametrize("kind", ["friction", "limit"])
def test_each_joint_and_the_slider_may_have_their_own_events(kind):
    """A cart with a pole has two stops, which are candidates, and the drives of a joint and of a slider."""
    d = begun(cart())
    d.friction.used, d.model.has_drive_limits = kind == "friction", kind == "limit"
    limit = 4 * work.MOST_EVENTS
    assert work.check_events(d, limit) == OK
    assert work.check_events(d, 1) == EVENT_STORM


def test_work_for_outputs_is_not_counted(d):
    counted = work.counted_work(d)
    work.count_evaluations(d, 7)
    work.count_other_work(d, 11)
    assert work.counted_work(d) == (507, 211)
    work.uncount_work(d, counted)
    assert (d.statistics.rhs_evaluations, d.limits.other_work) == (500, 200)


def test_steps_are_counted_and_windows_begin_with_each_run(d):
    names = ("steps", "implicit_steps", "rejected_steps")
    before = [int(d.statistics[name]) for name in names]
    work.count_step(d, 0)
    work.count_step(d, 1)
    work.count_rejected_step(d)
    assert [int(d.statistics[name]) for name in names] == [before[0] + 2, before[1] + 1, before[2] + 1]
    work.begin_windows(d, 3.0)
    assert d.limits.work_start == d.limits.event_start == 3.0
