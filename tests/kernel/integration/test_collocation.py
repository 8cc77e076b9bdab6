"""The implicit step: against another integrator, its order, its cost, and that it keeps the clearances."""

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.chain.state import sundman_u_at
from chain_impact.kernel.events.exclusion import NOTHING, known_clearances
from chain_impact.kernel.integration.collocation import curvatures, interpolated
from chain_impact.kernel.integration.dense import interpolate
from chain_impact.kernel.integration.extended import gap_at
from chain_impact.kernel.integration.method import IMPLICIT, ORDER
from chain_impact.kernel.integration.radau import STAGES
from chain_impact.kernel.model.geometry import clearance
from chain_impact.scene.scene import with_values
from chain_impact.simulation.instance import Instance
from tests.kernel.integration.stiff_problems import PROBLEMS, exact, swinging, tipping
from tests.kernel.integration.touching import touching
from tests.plain import Plain


def reached(result):
    """Base, angles and their rates at the end."""
    end = result.outputs[-1]
    motion = end["point_position"][0], end["angle"], end["point_velocity"][0], end["angular_velocity"]
    return np.concatenate(motion)


@pytest.mark.parametrize("method", ["implicit", "auto"])
@pytest.mark.parametrize("name", PROBLEMS)
def test_stiff_problems_are_solved_to_the_tolerance(name, method):
    for tolerance in (1e-4, 1e-6, 1e-8):
        result = simulate(PROBLEMS[name](), tolerance=tolerance, method=method)
        error = np.abs(reached(result) - exact(name)) / (1.0 + np.abs(exact(name)))
        assert error.max() < 2.0 * tolerance


def test_what_high_accuracy_costs_goes_as_the_order_of_the_error():
    """Ten times the accuracy takes 10^(1/7) = 1.39 times the steps; a method of order 3 takes 2.15."""
    steps = [simulate(tipping(), tolerance=t, method="implicit").statistics["steps"] for t in (1e-8, 1e-11)]
    assert steps[1] / steps[0] == pytest.approx(1000.0 ** (1.0 / ORDER[IMPLICIT]), rel=0.15)


@pytest.mark.parametrize(
    ("scene", "tolerance", "most"),
    [(swinging, 1e-8, 700), (tipping, 1e-8, 1800), (PROBLEMS["hanging"], 1e-8, 2500)],
)
def test_cost_of_a_tolerance(scene, tolerance, most):
    """The method of order 3 before it took 3,000, 17,000 and 12,000."""
    assert simulate(scene(), tolerance=tolerance, method="implicit").statistics["rhs_evaluations"] < most


def implicit_phase(tolerance=1e-8):
    """An instance in the middle of implicit steps."""
    instance = Instance(with_values(tipping(), {("solver", "tolerance"): tolerance}))
    assert instance.advance(0.05) == 0
    assert instance.record["step"]["last_method"] == IMPLICIT
    return instance


def test_each_iteration_counts_its_right_hand_sides():
    instance, seen = implicit_phase(), 0
    for _ in range(40):
        before = instance.statistics
        instance.advance(np.nextafter(float(instance.record["step"]["end"]), 1.0))
        after = instance.statistics
        if after["rejected_steps"] == before["rejected_steps"]:
            spent = after["rhs_evaluations"] - before["rhs_evaluations"]
            assert spent == 1 + STAGES * int(instance.record["implicit"]["iterations"])
            seen += 1
    assert seen > 20


@pytest.mark.parametrize("elsewhere", [0.0, 0.09])
def test_a_state_saved_in_the_middle_continues_bit_by_bit(elsewhere):
    """In an instance that is at another time until it is restored, with another tolerance."""
    instance = implicit_phase()
    saved = np.frombuffer(instance.record.tobytes(), instance.record.dtype)[0]
    instance.advance(0.08)
    restored = Instance(with_values(tipping(), {("solver", "tolerance"): 1e-6}))
    restored.advance(elsewhere)
    for name in saved.dtype.names:
        restored.record[name] = saved[name]
    restored.advance(0.08)
    assert restored.record.tobytes() == instance.record.tobytes()


def test_the_dense_output_is_as_accurate_as_the_tolerance():
    times = np.linspace(0.0, 0.1, 301)[1:]
    rows = {}
    for tolerance in (1e-8, 1e-12):
        instance = Instance(with_values(tipping(), {("solver", "tolerance"): tolerance}))
        out = np.zeros(len(times), instance.record.dtype["output"])
        assert instance.trajectory(times, out) == len(times)
        rows[tolerance] = out
    bounds = {"angle": 1e-10, "point_position": 1e-10, "angular_velocity": 3e-8, "force": 3e-6}
    for field, most in bounds.items():
        assert np.abs(rows[1e-8][field] - rows[1e-12][field]).max() < most


def test_the_curvature_of_a_clearance_is_bounded():
    instance = touching(1e-6)
    d, checked = Plain(instance.record), 0
    for time in np.arange(0.7, 1.1, 5e-3):
        instance.advance(time)
        if d.step.last_method != IMPLICIT or known_clearances(d) == NOTHING:
            continue
        d.search.curvature[:] = np.nan
        curvatures(d, d.step.size)
        for k in range(int(d.touch.active_count)):
            theta = np.linspace(0.0, 1.0, 41)
            gaps = np.array([interpolated(d, gap_at(d, k), t) for t in theta])
            bends = np.diff(gaps, 2) / (d.step.size / 40) ** 2
            noise = 1e-16 * np.abs(gaps).max() / (d.step.size / 40) ** 2
            bound = d.search.curvature[d.touch.active_index[k]]
            assert np.abs(bends).max() <= bound + 4.0 * noise
            checked += 1
    assert checked > 20


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4, 1e-6])
def test_the_coordinates_keep_the_clearances_that_were_integrated(tolerance):
    """Off the tangent by ½h²ω²L, they would be wrong by many penetrations, at the ends and in between."""
    instance = touching(tolerance)
    d, errors, seen = Plain(instance.record), {0.25: [], 0.5: [], 0.8: [], 1.0: []}, {}
    y = np.zeros(len(d.work.y))
    for time in np.arange(0.7, 1.2, 1e-3):
        instance.advance(time)
        if d.step.last_method != IMPLICIT or known_clearances(d) == NOTHING or d.step.start in seen:
            continue
        seen[d.step.start] = d.step.size
        for theta, found in errors.items():
            interpolate(d.step, theta, y)
            locate_points(d, y)
            for k in range(int(d.touch.active_count)):
                gap, _ = clearance(d, int(d.touch.active_index[k]))
                found.append(abs(gap / interpolated(d, sundman_u_at(d.links) + k, theta) - 1.0))
    assert max(seen.values()) > 1e-3
    for found in errors.values():
        assert len(found) > 60
        assert np.quantile(found, 0.9) < 0.02
        assert np.quantile(found, 0.99) < 0.5


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4])
def test_a_restart_inside_an_implicit_step_does_not_kick(tolerance):
    """An input that is set to what it was starts the solver anew, in between its steps."""
    ledger = []
    for restarts in (0, 20):
        instance = touching(tolerance)
        for time in np.linspace(0.9, 1.1, restarts + 1):
            instance.record["given"]["changed"] = restarts > 0
            instance.advance(time)
        instance.advance(1.2)
        output = instance.record["output"]
        instance.observe()
        ledger.append(float(output["total"] + output["dissipated"]))
    assert ledger[1] == pytest.approx(ledger[0], abs=10.0 * tolerance)
