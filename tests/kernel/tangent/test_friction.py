"""Changes of friction modes in dual numbers: derivatives of their times, and undetermined cases."""

from types import SimpleNamespace

import numpy as np
import pytest

from chain_impact.kernel.record.constants import NO_EVENT, NO_FRICTION, SLIDING_ENDS, STICKING_ENDS, STICKS
from chain_impact.kernel.tangent import event_times, friction, trust
from tests.kernel.tangent.dual import dual

TOLERANCE = 1e-6


@pytest.fixture
def t():
    """Return an instance of dual numbers with friction at candidate 1 and in the joint, element 2."""
    tangent = SimpleNamespace(candidate_count=2, friction_element_count=3)
    tangent.friction = SimpleNamespace(active_count=2)
    tangent.friction_element = SimpleNamespace(
        index=[1, 2, 9], event=[NO_EVENT] * 3, mode=[1] * 3, decided_by_forces=[1] * 3
    )
    tangent.friction_element.friction_limit, tangent.friction_element.force = [dual(9.0)] * 3, [dual(0.0)] * 3
    tangent.law = SimpleNamespace(friction=[dual(0.3)] * 2, static_friction=[dual(0.3)] * 2)
    tangent.scratch = SimpleNamespace(velocity="velocity", acceleration="acceleration", rate="rate")
    tangent.step = SimpleNamespace(start=dual(1.0), end=dual(1.5))
    tangent.solver = SimpleNamespace(tolerance=dual(TOLERANCE))
    tangent.chain = SimpleNamespace(longest_link=dual(2.0))
    tangent.trust = SimpleNamespace(reason=trust.TRUSTED)
    return tangent


@pytest.fixture
def ended(monkeypatch):
    """Return the reasons for which derivatives have ended, each with its element."""
    reasons = []
    monkeypatch.setattr(friction, "mark_untrusted", lambda _t, reason, e, time: reasons.append((reason, e)))
    return reasons


@pytest.mark.parametrize(
    ("events", "delay"),
    [
        *(((SLIDING_ENDS, NO_EVENT), ("rest", 1)), ((NO_EVENT, SLIDING_ENDS), ("rest", 2))),
        *(((STICKING_ENDS, SLIDING_ENDS), ("rest", 2)), ((SLIDING_ENDS, STICKING_ENDS), ("rest", 1))),
        ((STICKING_ENDS, NO_EVENT), ("sliding", 1)),
    ],
)
def test_sliding_that_ends_goes_before_sliding_that_begins(monkeypatch, t, events, delay):
    t.friction_element.event[1:] = events
    monkeypatch.setattr(friction, "delay_of_rest", lambda _t, e: ("rest", e))
    monkeypatch.setattr(friction, "delay_of_sliding", lambda _t, e: ("sliding", e))
    assert friction.delay_of_change(t) == delay


@pytest.mark.parametrize(
    ("acceleration", "late"), [(-4.0, [0.75, -2.0]), (-5e-4, [6e3, -16e3]), (-1e-4, [0.0, 0.0])]
)
def test_rest_is_late_by_its_speed_over_its_acceleration(monkeypatch, t, acceleration, late):
    """Below 100 tolerances · 9 N/3 kg = 3e-4 m/s² the acceleration may be an error; the speed becomes 0."""
    monkeypatch.setattr(friction, "mean_mass", lambda _t: dual(3.0))
    along = {"rate": dual(1e-12, 3.0, -8.0), "acceleration": dual(acceleration, 50.0, 50.0)}
    for quantity, motion in along.items():
        monkeypatch.setattr(
            friction, f"tangential_{quantity}", lambda _t, e, motion=motion: motion if e == 2 else None
        )
    delay = friction.delay_of_rest(t, 2)
    assert (delay.value, delay.slope.tolist()) == (0.0, late)


@pytest.mark.parametrize(
    ("e", "static", "expected"), [(1, 0.3, False), (1, 0.31, True), (0, 0.5, True), (2, 0.5, False)]
)
def test_the_force_drops_at_contacts_where_sliding_has_less_friction(t, e, static, expected):
    if e < 2:
        t.law.static_friction[e] = dual(static)
    assert friction.friction_drops(t, e) == expected


def margin_of(monkeypatch, t, rate):
    """Let φ = 9 − y₀, where y₀ = 9 at the end of the step and grows at a rate.

    Return the list of y₀ − 9 at which points are located from now on.
    """
    y = [dual(9.0, 2.0, -6.0)]
    t.scratch.state, t.step.state_end, t.scratch.rate_end = [None], y, [dual(rate, 70.0, 70.0)]
    located = []
    monkeypatch.setattr(event_times, "locate_points", lambda _t, y: located.append(y[0].value - 9.0))
    monkeypatch.setattr(event_times, "ensure_points", lambda _t: None)
    monkeypatch.setattr(friction, "fastest_speed", lambda _t: 4.0)

    def rate_from_points(t, y, rate):
        t.friction_element.force[1] = t.friction_element.force[2] = -y[0]

    monkeypatch.setattr(event_times, "rate_from_points", rate_from_points)
    return located


def test_sliding_is_late_by_its_margin_over_the_rate_of_it(monkeypatch, t, ended):
    """φ = µ_s F_n − |F_t|, whose rate does not depend on the derivatives of the state's rate."""
    located = margin_of(monkeypatch, t, 0.5)
    delay = friction.delay_of_sliding(t, 2)
    assert delay.value == 0.0
    np.testing.assert_allclose(delay.slope, [-2.0 / 0.5, 6.0 / 0.5], rtol=1e-9)
    assert set(located) == {0.0}  # points and forces belong to the end again
    assert ended == []


@pytest.mark.parametrize(
    ("given", "reasons"),  # the rate of y₀, µ_s, and whether the speed is negligible
    [
        ((1e-3, 0.3, False), []),
        ((1e-3, 0.4, False), [(trust.SLOW_CHANGE, 1)]),
        ((1e-3, 0.4, True), []),
        ((-1e-3, 0.4, True), [(trust.SLOW_CHANGE, 1)]),
    ],
)
def test_an_uncertain_start_of_sliding_matters_if_the_force_drops(monkeypatch, t, ended, given, reasons):
    """A drop of 9 N (1 − 3/4) gives 3 kg a speed in a delay of −φ′/φ̇."""
    rate, static, small = given
    margin_of(monkeypatch, t, rate)  # below √tolerance · 9 N · 2 rad/s
    monkeypatch.setattr(friction, "mean_mass", lambda _t: dual(3.0))
    speeds = []
    monkeypatch.setattr(friction, "is_negligible", lambda _t, speed: speeds.append(speed.slope) or small)
    t.law.static_friction[1] = dual(static)
    delay = friction.delay_of_sliding(t, 1)
    assert (delay.value, delay.slope.tolist()) == (0.0, [0.0, 0.0])
    assert ended == reasons
    if static == 0.4 and rate > 0.0:
        np.testing.assert_allclose(speeds, [[0.75 * -2.0 / 1e-3, 0.75 * 6.0 / 1e-3]], rtol=1e-6)


def settling(monkeypatch, t, largest):
    """Set a chain of 2 m under 6 m/s², which settles in 0.5 s, with these largest place derivatives."""
    t.chain.longest_link, t.chain.gravity_magnitude, t.trust.neglected = dual(2.0), dual(6.0), 0.0
    t.scratch.position = "position"
    monkeypatch.setattr(friction, "DIRECTIONS", 2)
    monkeypatch.setattr(friction, "largest_slope", lambda _t, k: largest[k])


def test_a_speed_is_negligible_as_long_as_all_that_was_left_open_is(monkeypatch, t):
    """The sum of neglected slopes, over the largest slope, may be 8e-3, but not 12e-3."""
    settling(monkeypatch, t, (1.0, 0.1))
    small = dual(0.0, 8e-3, 8e-5)
    assert friction.is_negligible(t, small)
    assert t.trust.neglected == pytest.approx(4e-3)
    assert friction.is_negligible(t, small)
    assert not friction.is_negligible(t, small)
    assert t.trust.neglected == pytest.approx(8e-3)
    t.trust.neglected = 0.0
    assert not friction.is_negligible(t, dual(0.0, 1e-3, 4e-3))
    settling(monkeypatch, t, (1.0, 0.0))
    assert not friction.is_negligible(t, dual(0.0, 0.0, 1e-9))
    assert friction.is_negligible(t, dual(0.0, 0.0, 0.0))
    assert t.trust.neglected == 0.0


def test_a_stopped_element_has_no_derivative_of_its_speed(monkeypatch, t):
    """Element 2 begins to stick: derivatives of rates change, those of positions and all values stay."""
    t.friction.stuck_count, t.friction_element.stuck_index = 2, [1, 2]
    t.friction_element.mode_before = [STICKS, STICKS, 1]
    assert friction.any_begins_to_stick(t)
    t.friction_element.mode_before = [STICKS, NO_FRICTION, STICKS]
    assert not friction.any_begins_to_stick(t)
    # a free point: two coordinates and their rates
    t.link_count, t.step.state_end = 0, [dual(1.0 + j, 2.0, 3.0) for j in range(4)]
    located = []

    def solve_stopping_impulses(t):
        t.constraints = SimpleNamespace(change=[dual(1e-9, -2.0, 0.0), dual(1e-9, 0.0, -3.0)])

    def locate_points(_t, y):
        located[:] = [tuple(number.slope) for number in y]

    monkeypatch.setattr(friction, "activate_all", lambda _t: None)
    monkeypatch.setattr(friction, "set_unforced_to_speeds", lambda _t: None)
    monkeypatch.setattr(friction, "solve_stopping_impulses", solve_stopping_impulses)
    monkeypatch.setattr(friction, "locate_points", locate_points)
    friction.clear_sticking_speeds(t)
    slopes = [(2.0, 3.0), (2.0, 3.0), (0.0, 3.0), (2.0, 0.0)]
    assert [tuple(number.slope) for number in t.step.state_end] == slopes
    assert [number.value for number in t.step.state_end] == [1.0, 2.0, 3.0, 4.0]
    assert located == slopes


@pytest.mark.parametrize(
    ("given", "reasons"),  # the slope, and whether the speed is negligible, or stops slowly
    [
        ((-2.0, False, False), []),
        ((-2.1, False, False), [(trust.SIMULTANEOUS_CHANGES, 2)]),
        ((-2.1, True, False), []),
        ((-2.1, False, True), [(trust.SLOW_CHANGE, 2)]),
    ],
)
def test_elements_that_stop_together_do_so_for_each_parameter(monkeypatch, t, ended, given, reasons):
    """Element 2 stops too if its speed after the delay of 0.5 per unit is zero: slope + 0.5 · 4 m/s²."""
    slope, small, slow = given
    t.friction_element.event[1:] = SLIDING_ENDS, SLIDING_ENDS
    rates = {1: dual(0.0), 2: dual(0.0, slope, 0.0)}
    monkeypatch.setattr(friction, "DIRECTIONS", 2)
    monkeypatch.setattr(friction, "tangential_rate", lambda _t, e: rates[e])
    monkeypatch.setattr(friction, "tangential_acceleration", lambda _t, e: dual(4.0 * (e - 1)))
    monkeypatch.setattr(friction, "largest_component", lambda _t, _what: dual(4.0))
    for name in ("largest_slope", "largest_displacement", "fastest_speed"):
        monkeypatch.setattr(friction, name, lambda *_: 0.0)
    monkeypatch.setattr(friction, "rest_speed", lambda _t: 1e-12)
    monkeypatch.setattr(friction, "count_mode_changes", lambda _t: 1)
    monkeypatch.setattr(friction, "is_negligible", lambda *_: small)
    monkeypatch.setattr(friction, "acceleration_may_be_error", lambda *_: slow)
    friction.check_changes(t, dual(0.0, 0.5, 0.0))
    assert ended == reasons


@pytest.mark.parametrize(("margins", "together"), [((0.0, 0.0), True), ((0.0, 1e-3), False)])
def test_two_that_break_loose_at_one_moment_must_do_so_for_all_parameters(
    monkeypatch, t, ended, margins, together
):
    """Where friction drops, the slopes of both margins must be zero after the delay."""
    t.friction_element.event[1:] = STICKING_ENDS, STICKING_ENDS
    t.friction_element.mode = [STICKS] * 3
    t.law.static_friction = [dual(0.4)] * 2
    t.candidate_count, restored = 3, []
    t.law.friction, t.law.static_friction = [dual(0.3)] * 3, [dual(0.4)] * 3
    t.friction_element.force, t.friction_element.friction_limit = (
        [dual(9.0, 1.0, 0.0)] * 3,
        [dual(9.0, 1.0, 0.0)] * 3,
    )
    monkeypatch.setattr(friction, "DIRECTIONS", 2)
    monkeypatch.setattr(friction, "largest_displacement", lambda _t, _k: 0.0)
    monkeypatch.setattr(friction, "margin_after", lambda _t, e, _time: dual(0.0, margins[e - 1], 0.0))
    monkeypatch.setattr(friction, "evaluate_end", restored.append)
    friction.check_changes(t, dual(0.0, 0.5, 0.0))
    assert ended == ([] if together else [(trust.SIMULTANEOUS_CHANGES, 2)])
    assert restored == [t]


@pytest.mark.parametrize(
    ("mode_and_motion", "is_open"),
    [
        ((STICKS, -9.0 * (1.0 - 90.0 * TOLERANCE)), True),
        ((STICKS, -9.0 * (1.0 - 110.0 * TOLERANCE)), False),
        ((1, 2.9e-4), True),
        ((1, -3.1e-4), False),
    ],
)
def test_a_mode_is_open_where_the_limit_is_almost_reached(monkeypatch, t, ended, mode_and_motion, is_open):
    """The limit is reached within 100 tolerances of the holding force, or of the acceleration 9 N/3 kg."""
    mode, motion = mode_and_motion
    monkeypatch.setattr(friction, "mean_mass", lambda _t: dual(3.0))
    monkeypatch.setattr(friction, "friction_round_off", lambda _t, _e: dual(1e-9))
    monkeypatch.setattr(friction, "tangential_rate", lambda *_: dual(motion))
    monkeypatch.setattr(friction, "tangential_acceleration", lambda *_: dual(motion))
    for name in ("list_sticking", "rate_from_points", "accelerate_points", "clear_sticking_speeds"):
        monkeypatch.setattr(friction, name, lambda *_: None)
    monkeypatch.setattr(friction, "settling_time", lambda _t: 0.5)
    monkeypatch.setattr(friction, "is_negligible", lambda *_: False)
    t.friction.stuck_count = 0
    t.friction_element.mode_before, t.friction_element.mode, t.friction_element.chosen_mode = (
        [mode] * 3,
        [mode] * 3,
        [mode] * 3,
    )
    t.friction_element.decided_by_forces, t.friction_element.force[1], t.step.state_end = (
        [0, 1, 0],
        dual(motion),
        "state",
    )
    friction.make_modes_consistent(t)
    assert t.friction_element.mode == [mode] * 3
    assert ended == ([(trust.AT_FRICTION_LIMIT, 1)] if is_open else [])
