"""The distance of the model from the data, and its derivatives."""

import math

import numpy as np
import pytest

from chain_impact.kernel.status import MASS_MATRIX_SINGULAR
from chain_impact.simulation.errors import SimulationError
from chain_impact.studies.fit import problem as module
from chain_impact.studies.fit.measured_tables import read_measurements
from chain_impact.studies.fit.parameters import fitted_parameters
from chain_impact.studies.fit.problem import Problem
from tests.helpers.tools.differences import slope
from tests.helpers.tools.measurements import FREE, TRUE, impacts, motion, scene
from tests.helpers.tools.refusal import refusal

QUANTITIES = ("onset", "peak_force", "duration", "separation_speed")


def problem(tables, scenes, names=FREE, names_of_each=()):
    data = [read_measurements(table, scenes[0], {}) for table in tables]
    return Problem(scenes, data, fitted_parameters(scenes, names, names_of_each, {}))


@pytest.fixture(scope="module")
def fit_problem():
    """Return motion without noise, and all impacts, of 0.9 s with three impacts."""
    columns, result = motion(0.9, count=30, noise=0.0)
    assert len(result.impacts) == 3
    return problem([[columns, impacts(result, QUANTITIES)]], [scene()])


def test_the_true_parameters_leave_nothing(fit_problem):
    evaluation = fit_problem.evaluate(fit_problem.start)
    assert fit_problem.values(fit_problem.start) == pytest.approx(TRUE)
    assert evaluation.is_usable.all()
    assert (
        np.abs(evaluation.residuals / fit_problem.size).max() < 1e-6
    )  # integration errors of the measured run


def test_slopes_are_those_of_the_residuals(fit_problem):
    place = fit_problem.start + np.array([0.1, -0.02, 0.01])
    evaluation = fit_problem.evaluate(place)
    for p, h in enumerate((1e-4, 1e-5, 1e-5)):
        axis = np.eye(3)[p]
        expected = slope(lambda step, axis=axis: fit_problem.evaluate(place + step * axis).residuals, 0.0, h)
        scale = np.abs(expected[evaluation.is_usable]).max()
        np.testing.assert_allclose(evaluation.slopes[:, p], expected, rtol=1e-3, atol=1e-4 * scale)


def test_beyond_the_horizon_nothing_is_compared(fit_problem):
    evaluation = fit_problem.evaluate(fit_problem.start, 0.52)
    np.testing.assert_array_equal(evaluation.exists, fit_problem.value_times <= 0.52)
    cut_evaluation = fit_problem.cut_at_horizon(fit_problem.evaluate(fit_problem.start), 0.52)
    np.testing.assert_array_equal(cut_evaluation.exists, evaluation.exists)
    np.testing.assert_allclose(
        cut_evaluation.residuals[evaluation.exists], evaluation.residuals[evaluation.exists], atol=1e-7
    )


def test_an_impact_that_is_not_there_is_left_out():
    columns, result = motion(0.9, count=10, noise=0.0)
    table = impacts(result, ["onset"])
    table["wall"][1] = "x_max"
    table["impact"][2] = 9
    evaluation = problem([[columns, table]], [scene()]).evaluate(np.array([math.log(1e8), 0.7, 1.5]))
    assert evaluation.exists[-3:].tolist() == [True, False, False]
    assert evaluation.exists[:-3].all()


def test_each_data_set_has_its_own_parameters():
    columns, _ = motion(0.3, count=5, noise=0.0)
    scenes = [scene(), scene().with_values({"initial.vx": 1.0})]
    fit_problem = problem([columns, columns], scenes, ["contact.stiffness"], ["initial.vx"])
    evaluation = fit_problem.evaluate(fit_problem.start)
    assert fit_problem.start[1:].tolist() == [1.5, 1.0]
    first, second = evaluation.slopes[:10], evaluation.slopes[10:]
    # x = x₀ + v t depends on the data set, y does not
    np.testing.assert_allclose(first[::2, 1], columns["time"], rtol=1e-5)
    np.testing.assert_allclose(second[::2, 2], columns["time"], rtol=1e-5)
    assert not first[:, 2].any()
    assert not second[:, 1].any()
    np.testing.assert_allclose(evaluation.residuals[10::2], -0.5 * columns["time"], atol=1e-6)


@pytest.mark.full("takes long")
def test_a_contact_that_lasts_has_no_peak_yet():
    columns, _ = motion(0.5005, count=5, noise=0.0)  # the first impact lasts from 0.4994 to 0.5016 s
    table = {"impact": [1, 1], "onset": [0.5, None], "peak_force": [None, 1e4]}
    fit_problem = problem([[columns, table]], [scene().with_values({"simulation.stop_time": 0.5005})])
    run = fit_problem.evaluate(fit_problem.start)
    assert np.isfinite(run.residuals[-2])
    early = fit_problem.evaluate(fit_problem.start, 0.4004)  # the run goes on to 1.25 × 0.4004 s
    assert math.isnan(early.residuals[-1])


def test_a_run_that_fails_says_why():
    columns, _ = motion(0.9, count=5)
    failing = problem([columns], [scene().with_values({"solver.work_limit": 1.0})])
    evaluation = failing.evaluate(failing.start)
    assert not evaluation.exists.all()
    assert "data: the simulation stopped:" in failing.fault(evaluation)


def test_a_run_leaves_nothing_behind(fit_problem):
    """A shorter run and a refused one do not change the next run."""
    first = fit_problem.evaluate(fit_problem.start)
    fit_problem.evaluate(fit_problem.start, 0.5)
    fit_problem.evaluate(fit_problem.start * [1.0, 3.0, 1.0])  # e = 2.1 is refused
    repeated = fit_problem.evaluate(fit_problem.start)
    np.testing.assert_array_equal(repeated.residuals, first.residuals)
    np.testing.assert_array_equal(repeated.slopes, first.slopes)


def test_a_scene_that_cannot_start_is_refused(monkeypatch):
    def refuse(*_, **__):
        raise SimulationError(MASS_MATRIX_SINGULAR, 0.0, None)

    monkeypatch.setattr(module, "DifferentiatedRun", refuse)
    columns, _ = motion(0.3, count=5)
    assert refusal(problem, [columns], [scene()]).startswith(
        "FourLinkBox: the simulation stopped at t = 0 s:"
    )


def test_bounds_that_are_reached():
    """A bound is reached within 1 % of a standard error and of the range, or within round-off."""
    columns, _ = motion(0.3, count=5)
    fit_problem = problem([columns], [scene()], ["contact.restitution", "link[1].joint_damping", "initial.x"])
    place = np.array([0.7, 1e-7, 0.5])
    assert fit_problem.bounds_reached(place, np.array([0.01, 1e-8, np.inf])) == {}
    assert fit_problem.bounds_reached(place, np.array([0.01, 1e-4, np.inf])) == {1: "lower"}
    assert fit_problem.bounds_reached(place, np.array([1e17, np.inf, 1.0])) == {}, "nothing is known of it"
    near_bound = np.array([1e-3, 1e-7, 0.5])
    assert fit_problem.bounds_reached(near_bound, np.array([100.0, np.inf, 1.0])) == {0: "lower"}
    assert fit_problem.bounds_reached(np.array([1.0 - 1e-12, 1e-7, 0.5]), np.full(3, 1e-20)) == {0: "upper"}
