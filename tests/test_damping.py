"""Joints with stiff damping: what they do, against textbook equations, and what they cost."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from chain_impact import simulate
from chain_impact.scene.scene import with_values
from tests.problems import stiff_joint
from tests.reference import balance
from tests.textbook import Textbook

FLIGHT = 0.25  # s, before the first impact


def assembled(scene, time):
    """Base, angles, their rates and the dissipated energy by Radau's method on the assembled equations."""
    book = Textbook(scene)

    def rate(_, y):
        return np.append(book.rate(y[:-1]), book.loss(y[:-1]))

    y = np.append(book.start, 0.0)
    return solve_ivp(rate, (0.0, time), y, method="Radau", rtol=1e-10, atol=1e-12).y[:, -1]


def reached(result):
    """The same of a result, at its end."""
    end = result.outputs[-1]
    motion = end["point_position"][0], end["angle"], end["point_velocity"][0], end["angular_velocity"]
    return np.concatenate([*motion, [end["dissipated"]]])


@pytest.mark.full("takes long")
@pytest.mark.parametrize("method", ["auto", "implicit"])
@pytest.mark.parametrize("damping", [100.0, 1e4])
@pytest.mark.parametrize(("count", "base"), [(2, "free"), (3, "pinned")])
def test_the_error_in_flight_goes_with_the_tolerance_however_stiff_the_joints(count, base, damping, method):
    scene = stiff_joint(damping, count, FLIGHT, base)
    exact = assembled(scene, FLIGHT)
    for tolerance in (1e-4, 1e-6, 1e-8, 1e-9):
        result = simulate(scene, tolerance=tolerance, method=method)
        assert np.abs(reached(result) - exact).max() < 0.2 * tolerance


@pytest.mark.parametrize(
    ("damping", "most"), [(1.0, 7_000), (10.0, 12_000), (100.0, 7_000), (1e4, 4_000), (1e6, 4_000)]
)
def test_a_fall_with_impacts_costs_a_bounded_number_of_evaluations(damping, most):
    """Explicit steps alone take 34,000 for 10 N·m·s/rad, 253,000 for 100, and 25 million for 1e4."""
    result = simulate(stiff_joint(damping))
    assert len(result.impacts) >= 5
    assert result.statistics["rhs_evaluations"] < most


@pytest.mark.parametrize("damping", [100.0, 1e4])
def test_flight_costs_a_few_hundred_evaluations(damping):
    result = simulate(stiff_joint(damping, stop_time=FLIGHT))
    assert result.statistics["rhs_evaluations"] < 600


@pytest.mark.parametrize("tolerance", [1e-5, 1e-8])
@pytest.mark.parametrize("damping", [1.0, 100.0, 1e4, 1e6])
def test_the_ledger_closes_to_the_tolerance(damping, tolerance):
    result = simulate(stiff_joint(damping), tolerance=tolerance)
    assert balance(result) < 100.0 * tolerance
    assert (np.diff(result.energy["dissipated"]) > -tolerance).all()


def test_stiff_joints_turn_as_one_body():
    """The relative rate is the moment that holds the joint stiff over the damping."""
    rates = [
        np.ptp(simulate(stiff_joint(damping, stop_time=FLIGHT)).angular_velocities[-1])
        for damping in (1e3, 1e4, 1e5)
    ]
    assert rates[0] < 1e-4
    assert rates[1:] == pytest.approx([rates[0] / 10.0, rates[0] / 100.0], rel=0.05)


def test_a_rigid_wall_is_hit_and_left_with_stiff_joints():
    changes = {("contact", "model"): "newton_impact", ("contact", "restitution"): 1.0}
    result = simulate(with_values(stiff_joint(100.0), changes), stop_time=0.45)
    assert len(result.impacts) >= 2
    assert balance(result) < 1e-6
    assert result.statistics["rhs_evaluations"] < 20_000
