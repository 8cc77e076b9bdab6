"""The last step and its stored quantities: each is valid only for the permitted time."""

import numpy as np
import pytest

from chain_impact.kernel.chain import kinematics
from chain_impact.kernel.equations import rate_from_state
from chain_impact.kernel.events import event_exclusion
from chain_impact.kernel.ode import explicit, last_step, methods
from chain_impact.kernel.ode.dense_output import interpolate_state
from chain_impact.kernel.record import state
from chain_impact.kernel.record.constants import (
    CURVATURES_KNOWN,
    DISTANCE_KNOWN,
    EXPLICIT,
    IMPLICIT,
    NOTHING_KNOWN,
    OUTPUT_READER,
    SOLVER_READER,
)
from chain_impact.scene.scene import load_scene, scene_from_dict
from tests.helpers.kernel.plain import initialized

H = 0.01  # s


def started(method=EXPLICIT, **changes):
    scene = load_scene("four_link_box").with_values(
        {f"contact.{key}": value for key, value in changes.items()}
    )
    d = initialized(scene)
    d.step.method = method
    return d


def with_a_step(d, h=H):
    """Return the instance after one step of size h, whatever its error."""
    last_step.ensure_rate(d)
    last_step.ensure_points(d)
    d.scratch.rate_start[:] = d.scratch.stage[0] = d.scratch.rate_end
    methods.prepare_step(d, h)
    methods.integrate_trial(d, h)
    last_step.make_last_step(d)
    return d


def exact_rate(d, y):
    rate = np.zeros_like(y)
    rate_from_state(d, y.copy(), rate)
    return rate


@pytest.mark.parametrize("method", [EXPLICIT, IMPLICIT])
def test_an_accepted_step_goes_on_where_the_last_one_ended(method):
    """The rate at the end is known after an explicit step, and computed after an implicit step."""
    d = with_a_step(started(method))
    count, is_known = int(d.statistics.rhs_evaluations), int(method == EXPLICIT)
    assert d.step.rate_known == is_known
    last_step.ensure_rate(d)
    last_step.ensure_rate(d)
    assert d.statistics.rhs_evaluations - count == 1 - is_known
    np.testing.assert_allclose(d.scratch.rate_end, exact_rate(d, d.step.state_end), atol=1e-12)
    before, breaks = d.step.state_end.copy(), int(d.step.break_count)
    d.step.state_end[-1] = 0.0
    with_a_step(d)
    np.testing.assert_array_equal(d.step.state[:-1], before[:-1])
    assert (d.step.start, d.step.end) == pytest.approx((H, 2 * H), rel=1e-14)
    assert d.step.last_method == method
    assert d.step.break_count == breaks  # stored values of the end are valid for the next start


@pytest.mark.parametrize("points", [[], [4]])
def test_points_are_those_at_the_end_whoever_has_moved_them(points):
    d = started(points=points)
    for size in (H, 2 * H):
        d.step.state_end[-1] = 0.0
        with_a_step(d, size)
        last_step.ensure_points(d)
        result = np.array([d.scratch.position.x, d.scratch.velocity.y])
        kinematics.locate_points(d, d.step.state_end)
        np.testing.assert_array_equal(result, [d.scratch.position.x, d.scratch.velocity.y])
        kinematics.locate_points(d, d.step.state)
    last_step.ensure_points(d)
    np.testing.assert_array_equal(result[0], d.scratch.position.x)


@pytest.mark.parametrize("method", [EXPLICIT, IMPLICIT])
def test_a_step_can_be_cut_also_at_the_communication_point_and_taken_back(method):
    d = with_a_step(started(method))
    start, expected = d.step.state.copy(), np.zeros(len(d.step.state))
    last_step.ensure_dense(d, SOLVER_READER)
    interpolate_state(d.step, 0.3, expected)
    last_step.truncate_step(d, 0.3)
    np.testing.assert_array_equal(d.step.state_end, expected)
    assert d.step.end == pytest.approx(0.3 * H, rel=1e-15)
    assert not d.step.rate_known
    last_step.ensure_rate(d)
    np.testing.assert_allclose(d.scratch.rate_end, exact_rate(d, expected), atol=1e-12)
    d.step.communication_point = 0.25 * H
    last_step.truncate_to_communication_point(d)
    assert d.step.end == 0.25 * H
    assert d.step.state_end[-1] == pytest.approx(0.25 * H, rel=1e-14)
    last_step.roll_back(d)
    np.testing.assert_array_equal(d.step.state_end, start)
    assert d.step.end == 0.0


def sticking_and_damped():
    """Return a pinned chain: its first link sticks, and its second turns slowly against a damper."""
    links = [
        {"length": 1.0, "mass": 1.0, "joint_friction": 1.0},
        {"length": 1.0, "mass": 1.0, "joint_damping": 0.1},
    ]
    chain = {"base": "pinned", "links": links}
    initial = {"angles": [0.0, 0.0], "angular_velocities": [0.0, 2e-4]}
    return scene_from_dict(
        {"name": "Sticks", "gravity": [0.0, 0.0], "chain": chain, "initial": initial}, "sticks"
    )


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("method", [EXPLICIT, IMPLICIT])
@pytest.mark.parametrize("cut", [False, True])
def test_dissipation_below_the_last_digit_adds_up_while_an_element_sticks(method, cut):
    """Each step dissipates less than half of the last digit of 1e6 J; a refused step leaves nothing.

    A step that is cut at an event keeps its part.
    """
    scene = sticking_and_damped()
    lost, digit, losses = state.dissipated_at(2), np.spacing(1e6), []
    for before in (0.0, 1e6):
        d = initialized(scene)
        assert d.friction.stuck_count == 1
        d.step.method, d.step.state_end[lost] = method, before
        for _ in range(12):
            for size in (3.0 * H, H):
                d.step.state_end[-1] = 0.0
                with_a_step(d, size)
                if size != H:
                    last_step.roll_back(d)
                elif cut:
                    last_step.truncate_step(d, 0.6)
        losses.append(d.step.state_end[lost] - before)
        assert losses[0] / 12 < 0.5 * digit < 0.25 * losses[0]
        assert abs(d.step.remainder_end) <= 0.5 * digit
    assert losses[1] + d.step.remainder_end == pytest.approx(losses[0], rel=1e-9)


@pytest.mark.parametrize("method", [EXPLICIT, IMPLICIT])
@pytest.mark.parametrize("first", [1.0, 0.9, 0.55])
def test_a_step_that_is_cut_twice_dissipates_as_if_cut_once(method, first):
    """This includes the part below the last digit of 1e6 J, also after a step of zero length."""
    lost, ends = state.dissipated_at(2), []
    for parts in ((0.5,), (first, 0.5)):
        d = initialized(sticking_and_damped())
        d.step.method, d.step.state_end[lost] = method, 1e6
        for _ in range(3):
            d.step.state_end[-1] = 0.0
            with_a_step(d)
            for part in parts:
                last_step.truncate_step(d, part)
        last_step.reset_step(d, d.step.end, d.step.state_end.copy())
        for _ in parts:
            last_step.truncate_step(d, 0.0)
        ends.append((d.step.state_end[lost], d.step.remainder_end))
    assert ends[0][1] != 0.0
    assert ends[0] == ends[1]


@pytest.mark.parametrize("how", ["count_break", "roll_back", "truncate_step", "reset_step"])
def test_bounds_on_clearances_end_with_their_step(how):
    d = with_a_step(started())
    event_exclusion.remember_clearances(d, CURVATURES_KNOWN)
    assert event_exclusion.known_clearances(d) == CURVATURES_KNOWN
    more = {"truncate_step": (0.5,), "reset_step": (0.0, d.scratch.state)}
    getattr(last_step, how)(d, *more.get(how, ()))
    assert event_exclusion.known_clearances(d) == NOTHING_KNOWN
    event_exclusion.remember_clearances(d, DISTANCE_KNOWN)
    assert event_exclusion.known_clearances(d) == DISTANCE_KNOWN


def test_the_dense_output_is_made_once_and_counts_if_the_solver_needs_it():
    d = with_a_step(started())
    before = d.statistics.rhs_evaluations
    last_step.ensure_dense(d, OUTPUT_READER)
    assert d.statistics.rhs_evaluations == before
    dense = d.step.dense.copy()
    for _ in range(2):
        last_step.ensure_dense(d, SOLVER_READER)
        assert d.statistics.rhs_evaluations == before + explicit.DENSE_EVALUATIONS
    last_step.ensure_dense(d, OUTPUT_READER)
    np.testing.assert_array_equal(d.step.dense, dense)


def test_without_contact_a_step_runs_in_time():
    d = with_a_step(started())
    d.step.next_size, breaks = 0.5 * H, int(d.step.break_count)
    last_step.choose_variable(d, False)
    assert d.step.regularized_candidate == -1
    assert d.step.next_size == 0.5 * H
    assert d.step.break_count == breaks
    assert list(d.step.state_end[-2:]) == [1.0, 0.0]


def test_a_step_of_no_length_is_the_state_at_all_of_its_fractions():
    d = with_a_step(started())
    last_step.ensure_dense(d, OUTPUT_READER)
    there, y = d.step.state_end + 0.25, np.zeros(len(d.scratch.state))
    last_step.reset_step(d, 0.7, there)
    there[-2:] = 1.0, 0.0  # u, and the time in the step
    for theta in (0.0, 0.3, 1.0):
        interpolate_state(d.step, theta, y)
        np.testing.assert_array_equal(y, there)
    times = [float(d.step[name]) for name in ("communication_point", "start", "end", "time_origin")]
    assert times == [0.7] * 4
    assert d.step.size == 1.0


def test_a_link_can_have_turned_as_its_rates_at_the_ends_allow():
    d = started()
    first, step, scratch = state.omega_at(4), d.step, d.scratch
    step.start, step.end = 1.0, 1.5
    for vector in (step.state, step.state_end, scratch.rate_start, scratch.rate_end):
        vector[:] = 0.0
    assert last_step.largest_turn(d) == 0.0
    step.state[first + 2], step.state_end[first + 1] = -3.0, 2.0
    assert last_step.largest_turn(d) == pytest.approx(1.5)
    scratch.rate_end[first + 1] = -8.0
    assert last_step.largest_turn(d) == pytest.approx(0.5 * (2.0 + 0.25 * 8.0))
    scratch.rate_start[first + 1] = 12.0
    assert last_step.largest_turn(d) == pytest.approx(0.5 * (2.0 + 0.25 * 12.0))


@pytest.mark.parametrize("touching", [0, 1, 2])
def test_points_that_the_error_of_a_step_has_located_are_not_located_again(monkeypatch, touching):
    """The error of a step locates the points only if there are contacts, or elements that stick."""
    d, were_located = started(), []
    methods.prepare_step(d, H)
    methods.integrate_trial(d, H)
    d.contacts.active_count = touching
    monkeypatch.setattr(last_step, "find_rate", lambda _, located: were_located.append(bool(located)))
    last_step.make_last_step(d)
    assert were_located == [touching > 0]
