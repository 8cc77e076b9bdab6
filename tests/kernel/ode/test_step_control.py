"""The result of a trial step, and step sizes that a prediction replaces."""

import math

import numpy as np
import pytest

from chain_impact.kernel.advance import begin_step
from chain_impact.kernel.forces.force_formula import damping_over_elastic
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.ode import methods, step_control
from chain_impact.kernel.ode.step_control import ONSET_SIZE, SAFETY_FACTOR
from chain_impact.kernel.record.constants import CHECK_FAILED, EXPLICIT, IMPLICIT, INFINITE
from chain_impact.kernel.record.state import omega_at, time_at
from chain_impact.kernel.status import OK
from chain_impact.scene.scene import load_scene, with_values
from chain_impact.simulation.simulate import simulate
from tests.kernel.chains import chain, locate_touching_state


@pytest.mark.parametrize("restitution", [0.3, 0.7, 0.95])
@pytest.mark.parametrize("stiffness", [1e5, 1e8, 1e11])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
def test_few_steps_of_an_impact_are_rejected(tolerance, stiffness, restitution):
    """Without predictions six steps are rejected at the onset, three in flight, and more toward the end."""
    changes = {("contact", "stiffness"): stiffness, ("contact", "restitution"): restitution}
    scene = with_values(load_scene("rod_drop"), changes | {("solver", "tolerance"): tolerance})
    before = simulate(scene, stop_time=0.3)
    result = simulate(scene, stop_time=0.45)
    assert len(before.impacts) == 0
    impacts = int((result.impacts["onset"] < 0.45).sum())
    assert 3 <= impacts <= 5
    rejected = result.statistics["rejected_steps"] - before.statistics["rejected_steps"]
    assert rejected <= 5 * impacts


@pytest.mark.parametrize("power", [0.0, 0.25, 1.5])
@pytest.mark.parametrize("restitution", [1.0, 0.3])
def test_the_rise_time_of_a_force_is_that_of_depth_or_damping(power, restitution):
    """δ*/v₀ (1 + damping over elastic force)^(−1/(p+1))."""
    rng = np.random.default_rng(7)
    _, d = chain(rng, 1)
    locate_touching_state(rng, d, [0])
    d.contacts.expected_penetration[0], d.contacts.latched_speed[0] = 2e-3, 0.5
    d.contacts.damping[0], d.law.rate_exponent[0] = 0.0 if restitution == 1.0 else 1e9, power
    share = damping_over_elastic(d, 0)
    assert (share > 0.1) == (restitution < 1.0)
    time = 4e-3 * (1.0 + share) ** (-1.0 / (1.0 + power))
    assert step_control.contact_time_scale(d, 0) == pytest.approx(time, rel=1e-13)
    d.solver.tolerance = 1e-6
    for method in (EXPLICIT, IMPLICIT):
        expected = ONSET_SIZE[method] * time * 1e-6 ** step_control.ONSET_EXPONENT[method]
        assert step_control.size_at_onset(d, 0, method) == pytest.approx(expected, rel=1e-13)
    # 15 tolerance^(1/3)
    assert step_control.size_at_second_onset(d, 0) == pytest.approx(0.15 * time, rel=1e-13)


def test_a_size_follows_from_the_error_and_from_the_cost():
    _, d = chain(np.random.default_rng(7), 1)
    for method in (EXPLICIT, IMPLICIT):
        d.step.method = method
        for error in (5.0, 1e-5):
            step_control.set_outcome(d, error, 0.7)
            expected = SAFETY_FACTOR[method] * 0.7 * error ** step_control.SIZE_EXPONENT[method]
            assert step_control.next_size_factor(d) == pytest.approx(expected, rel=1e-13)
        for error in (1e12, math.inf, math.nan):
            step_control.set_outcome(d, error, 0.7)
            assert step_control.next_size_factor(d) == 0.1  # at least step_control.LEAST_RATIO
        step_control.set_outcome(d, 0.0, 0.7)
        assert 6.0 < step_control.next_size_factor(d) < math.inf
        step_control.set_outcome(d, 1e-5, 1.0)
        step_control.reject_step(d, CHECK_FAILED)
        assert 1 / 8.5 < step_control.next_size_factor(d) < 1 / 7


def test_in_flight_the_fastest_turn_decides():
    _, d = chain(np.random.default_rng(7), 3)
    d.solver.tolerance = 1e-8
    turn = 2.8 * 1e-8 ** (1.0 / 8.0)
    y, rate = np.zeros(len(d.step.state)), np.zeros(len(d.step.state))
    assert step_control.size_in_flight(d, y, rate) == 1.0
    y[omega_at(3) + 1] = -5.0
    assert step_control.size_in_flight(d, y, rate) == pytest.approx(turn / 5.0, rel=1e-13)
    rate[omega_at(3) + 2] = -49.0  # rad/s²
    assert step_control.size_in_flight(d, y, rate) == pytest.approx(turn / 7.0, rel=1e-13)
    y[omega_at(3)] = 0.5 * turn
    y[omega_at(3) + 1] = rate[omega_at(3) + 2] = 0.0
    assert step_control.size_in_flight(d, y, rate) == 1.0


def test_a_proposed_size_is_limited_rescaled_and_kept_for_the_next_flight():
    _, d = chain(np.random.default_rng(7), 1)
    step_control.propose_size(d, 0.5)
    step_control.limit_next_size(d, 0.7)
    assert d.step.next_size == 0.5
    step_control.limit_next_size(d, 0.25)
    assert d.step.next_size == 0.25
    step_control.store_flight_size(d)
    step_control.scale_next_size(d, 3.0)
    assert (d.step.next_size, d.step.flight_size) == (0.75, 0.25)
    step_control.propose_flight_size(d)
    assert d.step.next_size == 0.25


@pytest.mark.parametrize("error", [0.0, 1.0, np.nextafter(1.0, 2.0), 1e300, math.inf, math.nan])
def test_a_step_is_accepted_up_to_the_tolerance(error):
    _, d = chain(np.random.default_rng(1), 2)
    step_control.set_outcome(d, error, 0.7)
    assert step_control.is_accepted(d) == (error <= 1.0)
    np.testing.assert_array_equal([d.trial.error, d.trial.cost_factor], [error, 0.7])
    assert (d.trial.outcome == INFINITE) == (not math.isfinite(error))
    step_control.set_outcome(d, 0.5, 0.7)
    step_control.reject_step(d, CHECK_FAILED)
    assert not step_control.is_accepted(d)
    assert (d.trial.error, d.trial.cost_factor) == (0.5, 0.7)


def test_a_new_run_forgets_the_error_of_the_last_step():
    _, d = chain(np.random.default_rng(1), 2)
    begin_step(d)
    methods.integrate_trial(d, 1e-3)
    assert d.trial.size == 1e-3
    assert d.trial.state[time_at(2)] == pytest.approx(1e-3, rel=1e-14)
    step_control.reject_step(d, CHECK_FAILED)
    assert initialize(d, 0.0) == OK
    assert step_control.is_accepted(d)
