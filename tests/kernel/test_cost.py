"""Bounds on cost and events: the counted cost, the window of time, and the end of a run."""

# Tests: kernel/advance.py, kernel/cost.py

import math

import numpy as np
import pytest

from chain_impact.kernel import cost
from chain_impact.kernel.status import EVENT_STORM, OK, STEP_TOO_LONG, TOO_MUCH_WORK
from tests.helpers.kernel.plain import initialized
from tests.helpers.scenes.bodies import cart
from tests.kernel.chains import chain


@pytest.fixture
def d():
    """Return a chain at 5 s with 700 evaluations at the start of the second, and 600 at the call's start."""
    _, d = chain(np.random.default_rng(0), 3)
    d.solver.work_limit = 100.0
    d.statistics.rhs_evaluations, d.budget.other_cost = 500, 200
    d.budget.cost_at_window = 700
    d.budget.cost_at_communication_step = 600
    d.budget.cost_start = 5.0
    d.step.end = 5.0
    return d


@pytest.mark.parametrize(("evaluations", "looks", "over"), [(100, 0, False), (0, 100, False), (60, 41, True)])
def test_the_limit_counts_all_cost_in_a_second(d, evaluations, looks, over):
    d.statistics.rhs_evaluations += evaluations
    d.budget.other_cost += looks
    assert cost.cost_so_far(d) == 700 + evaluations + looks
    assert cost.is_cost_exceeded(d) == over
    assert cost.check_and_renew_cost_window(d) == (TOO_MUCH_WORK if over else OK)
    assert cost.COST_WINDOW == 1.0


def test_a_second_begins_where_the_last_one_has_ended(d):
    d.statistics.rhs_evaluations += 90
    for end, start, count in ((5.999, 5.0, 700), (6.0, 6.0, 790), (6.5, 6.0, 790), (7.25, 7.25, 790)):
        d.step.end = end
        assert cost.check_and_renew_cost_window(d) == OK
        assert (d.budget.cost_start, d.budget.cost_at_window) == (start, count)
    d.statistics.rhs_evaluations += 101
    assert cost.check_and_renew_cost_window(d) == TOO_MUCH_WORK


def test_a_communication_step_may_take_as_much_as_twenty_seconds_may(d):
    d.budget.cost_at_window = d.budget.cost_at_communication_step + int(cost.LONGEST_COMMUNICATION_STEP) * 100
    d.statistics.rhs_evaluations, d.budget.other_cost = d.budget.cost_at_window, 0
    assert cost.check_and_renew_cost_window(d) == OK
    d.budget.other_cost = 1
    assert cost.check_and_renew_cost_window(d) == STEP_TOO_LONG
    cost.allow_any_length(d)
    assert cost.check_and_renew_cost_window(d) == OK
    d.budget.other_cost = 101  # no second may cost more
    assert cost.check_and_renew_cost_window(d) == TOO_MUCH_WORK


@pytest.mark.parametrize("count", [1, 100])
def test_a_call_returns_after_a_cost_that_falls_with_the_points_of_a_chain(count):
    _, d = chain(np.random.default_rng(0), count)
    most = cost.cost_before_pause(d)
    assert most == int(most)
    assert cost.PAUSE_COST - count <= most * (count + 1) <= cost.PAUSE_COST


def test_too_many_events_in_a_short_time_are_a_storm(d):
    limit = cost.MOST_EVENTS * d.candidate_count
    d.budget.event_start, d.budget.event_count = 5.0, 7
    assert cost.count_events(d, limit - 7) == OK
    assert d.budget.event_count == limit
    assert cost.count_events(d, 0) == OK
    assert cost.count_events(d, 1) == EVENT_STORM
    # a new window begins
    d.step.end = math.nextafter(5.0 + cost.EVENT_WINDOW, 0.0)
    assert cost.count_events(d, 0) == EVENT_STORM
    d.step.end = 5.0 + cost.EVENT_WINDOW
    assert cost.count_events(d, 3) == OK
    assert (d.budget.event_start, d.budget.event_count) == (d.step.end, 3)


@pytest.mark.parametrize("kind", ["friction", "limit"])
def test_each_joint_and_the_slider_may_have_their_own_events(kind):
    """A cart with a pole has two stops, which are candidates, and the drives of a joint and of a slider."""
    d = initialized(cart())
    d.friction.may_act, d.chain.has_drive_limits = kind == "friction", kind == "limit"
    limit = 4 * cost.MOST_EVENTS
    assert cost.count_events(d, limit) == OK
    assert cost.count_events(d, 1) == EVENT_STORM


def test_the_cost_of_outputs_is_not_counted(d):
    counted = cost.read_cost_counts(d)
    cost.count_evaluations(d, 7)
    cost.count_other_cost(d, 11)
    assert cost.read_cost_counts(d) == (507, 211)
    cost.restore_cost_counts(d, counted)
    assert (d.statistics.rhs_evaluations, d.budget.other_cost) == (500, 200)


def test_steps_are_counted_and_windows_begin_with_each_run(d):
    names = ("steps", "implicit_steps", "rejected_steps")
    before = [int(d.statistics[name]) for name in names]
    cost.count_step(d, 0)
    cost.count_step(d, 1)
    cost.count_rejected_step(d)
    assert [int(d.statistics[name]) for name in names] == [before[0] + 2, before[1] + 1, before[2] + 1]
    cost.begin_windows(d, 3.0)
    assert d.budget.cost_start == d.budget.event_start == 3.0
