"""Decayed motions: quotients, powers and roots of tiny, even denormal numbers stay finite."""

# Tests: kernel/events/passage.py, kernel/events/search.py

from types import SimpleNamespace

import numpy as np
import pytest

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.constraints import impulses
from chain_impact.kernel.events import marks, passage, search
from chain_impact.kernel.forces import force_formula, holding
from chain_impact.kernel.forces.friction import list_sticking, set_element_anchor
from chain_impact.kernel.ode import collocation, explicit, last_step, maximum, step_control, sundman_rate
from chain_impact.kernel.record.constants import NO_EVENT, ONSET, STICKS
from chain_impact.kernel.record.state import dissipated_at, time_at, velocity_at
from chain_impact.kernel.tangent import duals, event_times, rules
from chain_impact.scene.scene import scene_from_dict
from chain_impact.simulation.simulate import simulate
from tests.kernel.chains import chain, locate_touching_state, random_state
from tests.kernel.rubbing import rubbing_chain
from tests.kernel.tangent.dual import Dual

SMALL = [0.0, 5e-324, 1e-320, 1e-308, 1e-170, 1e-162, 1e-120]
small = pytest.mark.parametrize("size", SMALL)


def finite(*numbers):
    return bool(np.isfinite(numbers).all())


# ---- steps ----------------------------------------------------------------------------------------------


@small
@pytest.mark.parametrize("other", [0.0, 1.0, -3.0])
def test_an_explicit_step_with_a_faded_error_is_accepted(size, other):
    _, d = chain(np.random.default_rng(0), 3)
    d.scratch.stage[:] = 0.0
    d.scratch.stage[6], d.scratch.stage[7] = size, other * size
    error = explicit.error_estimate(d, 0.1)
    assert 0.0 <= error < 1e-80
    step_control.set_outcome(d, error, 1.0)
    assert step_control.is_accepted(d)
    assert finite(step_control.next_size_factor(d))


@small
@pytest.mark.parametrize("other", [0.0, 5e-324, 1e-170, 1.0])
def test_an_implicit_step_with_a_faded_error_is_accepted(monkeypatch, size, other):
    d = resting()
    monkeypatch.setattr(collocation, "largest_errors", lambda *_: (size, other))
    monkeypatch.setattr(collocation, "solve_real", lambda *_: None)
    assert 0.0 <= collocation.error_estimate(d, 0.1, 1) <= size


def resting():
    """Return the record of two pinned links with one contact, at the end of a step."""
    rng = np.random.default_rng(1)
    _, d = chain(rng, 2, "pinned")
    y = random_state(rng, d)
    locate_touching_state(rng, d, [0])
    d.step.state_end[:] = y
    locate_points(d, y)
    return d


@small
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_faded_motions_are_cleared_and_others_are_kept(size, sign):
    _, d = chain(np.random.default_rng(0), 3, "pinned")
    last_step.reset_step(d, 0.0, d.step.state_end)
    d.chain.has_springs_or_dampers = 1
    d.trial.state[:] = sign * size
    d.trial.state[0], d.trial.state[velocity_at(3) + 2] = 0.25, -1e-99
    d.trial.state[time_at(3)], d.trial.size = 0.1, 0.1
    last_step.make_last_step(d)
    state = d.step.state_end
    assert (state[0], state[velocity_at(3) + 2]) == (0.25, -1e-99)
    assert np.count_nonzero(state[: dissipated_at(3)]) == 2
    assert state[dissipated_at(3)] == sign * size


def test_a_value_of_zero_keeps_its_derivatives():
    d = SimpleNamespace(link_count=1)
    y = [Dual(number, [1.0, 2.0]) for number in (0.0, 1e-170, 1.0, *[1e-200] * 3)]
    step_control.clear_faded(d, y)
    assert [getattr(component, "value", component) for component in y] == [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
    assert y[0].slope.tolist() == y[2].slope.tolist() == [1.0, 2.0]


# ---- events ---------------------------------------------------------------------------------------------


@small
@pytest.mark.parametrize("slope", SMALL)
def test_an_onset_of_a_faded_rate_is_late_by_a_number(size, slope):
    d = resting()
    c = 0
    d.contacts.event[:] = NO_EVENT
    marks.mark_contact_event(d, c, ONSET)
    d.step.size = 1e-3
    with np.errstate(all="ignore"):
        gap, rate = np.float64(size), -np.float64(slope)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(search, "clearance_and_rate", lambda *_: (gap, rate))
            late, deepest = search.onset_lateness(d, d.step.state_end)
    assert not np.isnan(late)
    assert not np.isnan(deepest)


@small
def test_a_passage_of_faded_values_is_located(size):
    find = passage.make_passage_search(
        lambda _d, _c, theta: np.float64(size) * (0.3 - theta), lambda _d: 4, 1e-12
    )
    d = SimpleNamespace(step=SimpleNamespace(size=1.0))
    with np.errstate(all="ignore"):
        theta = find(d, 0, 1.0)
    if size < 1e-300:
        assert theta == -1.0 or 0.0 <= theta <= 1.0
    else:
        assert theta == pytest.approx(0.3, abs=1e-11)


@small
def test_a_top_of_faded_values_is_found(size):
    top_of = maximum.maximum_of(lambda _d, _i, theta: np.float64(size) * (1.0 - (theta - 0.4) ** 2))
    with np.errstate(all="ignore"):
        top = top_of(None, 0, 0.5, 0.25, 1.0)
    assert finite(top)
    assert 0.9 * size <= top <= size or size < 1e-300


# ---- contacts -------------------------------------------------------------------------------------------


@small
@pytest.mark.parametrize("exponent", [0.0, 0.25, 0.5, 1.0, 1.5, 1.7])
def test_powers_and_their_derivatives_are_finite(size, exponent):
    result = rules.power_of_penetration(Dual(size, [1.0, -2.0]), Dual(exponent, [0.0, 0.0]))
    assert result.value == force_formula.power_of_penetration(size, exponent)
    assert finite(result.value, *result.slope)


@small
@pytest.mark.parametrize("speed", SMALL)
def test_forces_slopes_and_sizes_of_a_contact_are_finite(size, speed):
    d = resting()
    for rate in (speed, -speed):
        assert finite(*force_formula.law_force(d, 0, size, rate), *force_formula.law_slopes(d, 0, size, rate))
    assert finite(
        sundman_rate.regularized_time_rate(size), sundman_rate.regularized_time_rate_change(size, speed)
    )


# ---- what is held ---------------------------------------------------------------------------------------


@small
@pytest.mark.parametrize("contacts", [1, 2])
@pytest.mark.parametrize("base", ["free", "pinned"])
def test_a_sticking_element_with_a_faded_speed_is_stopped(size, contacts, base):
    _, d, y = rubbing_chain(np.random.default_rng(4), base, contacts, True)
    for e in d.friction_element.index[: d.friction.active_count]:
        d.friction_element.mode[e] = STICKS
        d.friction_element.friction_limit[e] = 1.0
        set_element_anchor(d, e)
    list_sticking(d)
    first = velocity_at(d.link_count)
    y[first : dissipated_at(d.link_count)] = size
    locate_points(d, y)
    holding.project_state(d, y)
    assert finite(*y)
    assert np.abs(y[first : dissipated_at(d.link_count)]).max() <= 10.0 * size + 1e-300


@small
@pytest.mark.parametrize("scale", [0.0, 5e-324, 1e-170, 1e-100])
def test_contradictions_that_have_faded_leave_no_force(size, scale):
    """Two constraints demand contradictory motions, and neither is a rigid wall."""
    _, d, _ = rubbing_chain(np.random.default_rng(4), "free", 0, True)
    for e in d.friction_element.index[: d.friction.active_count]:
        d.friction_element.mode[e] = STICKS
        d.friction_element.friction_limit[e] = 1.0
    list_sticking(d)
    d.friction_element.stuck_index[1] = d.friction_element.stuck_index[0]
    impulses.activate_all(d)
    own, count = d.constraints, d.friction.stuck_count
    own.unforced_motion[:count], own.target_motion[:count] = 0.0, 0.0
    own.target_motion[:2] = size, -size
    impulses.factorize_free(d)
    impulses.solve_equality(d, scale)
    assert finite(*own.impulse[:count], *own.change)


# ---- derivatives ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("rate", [*SMALL, -5e-324, -1e-170, -2.0, 0.5, -np.inf])
def test_the_time_of_an_event_has_finite_derivatives(monkeypatch, rate):
    """−φ′/φ̇; where φ̇ is 0 no derivative exists."""
    quotient = duals.reciprocal(rate)
    assert finite(quotient)
    assert quotient * rate == pytest.approx(1.0) if 1e-300 < abs(rate) < np.inf else quotient == 0.0
    gap = Dual(0.0, [3.0, 0.0])
    monkeypatch.setattr(event_times, "clearance_and_rate", lambda *_: (gap, Dual(rate, [0.0, 0.0])))
    delay = event_times.delay_of_crossing(None, 0, ONSET)
    assert delay.slope.tolist() == [-3.0 * quotient, 0.0]


# ---- runs -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["auto", "explicit", "implicit"])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8, 1e-12])
def test_a_held_joint_rests_to_the_end(method, tolerance):
    """Its friction exceeds the moment of its weight, 1.96 N·m."""
    scene = scene_from_dict(
        {
            "name": "Held",
            "chain": {"base": "pinned", "links": [{"length": 0.4, "mass": 1.0, "joint_friction": 7.0}]},
            "initial": {"angles": [-0.2], "angular_velocities": [-3.5]},
            "solver": {"method": method, "tolerance": tolerance},
            "simulation": {"stop_time": 3600.0, "step_size": 36.0},
        },
        "held",
    )
    result = simulate(scene)
    assert result.time[-1] == 3600.0
    assert np.ptp(result.angles[1:]) < 1e-14
    assert np.abs(result.angular_velocities[1:]).max() < 1e-13


@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_a_fading_motion_is_at_rest_before_its_numbers_are_denormal(method):
    """A damped rod without gravity stops as e^(−c t/I), which is 1e-1737 at the end."""
    scene = scene_from_dict(
        {
            "name": "Damped",
            "gravity": [0.0, 0.0],
            "chain": {"base": "pinned", "links": [{"length": 1.0, "mass": 3.0, "joint_damping": 4.0}]},
            "initial": {"angles": [0.0], "angular_velocities": [1.0]},
            "solver": {"method": method},
            "simulation": {"stop_time": 1000.0, "step_size": 10.0},
        },
        "damped",
    )
    result = simulate(scene)
    speeds = np.abs(result.angular_velocities[:, 0])
    assert speeds[result.time >= 500.0].max() == 0.0
    assert result.angles[-1, 0] == pytest.approx(0.25, rel=1e-6)
