"""The search with a growing time horizon."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from chain_impact.studies.fit import horizon
from chain_impact.studies.fit.horizon import estimate_sigma, search_parameters
from chain_impact.studies.fit.measured_tables import read_measurements
from chain_impact.studies.fit.parameters import fitted_parameters
from chain_impact.studies.fit.problem import Problem
from tests.helpers.tools.measurements import FREE, NOISE, TIP, TRUE, impacts, motion, scene
from tests.helpers.tools.refusal import refusal


def problem(tables, start, sigma=None, names=FREE):
    data = read_measurements(tables, start, sigma or {})
    return Problem([start], [data], fitted_parameters([start], names, (), {}))


FAR_STARTS = [{"K": 1e8 * factor, "e": 0.7 + shift, "w": 1.5 * rate}
       for factor in (1 / 3, 3.0) for shift in (-0.2, 0.2) for rate in (0.9, 1.1)]  # fmt: skip


@pytest.mark.full("more cases", but=4)
@pytest.mark.parametrize("start", FAR_STARTS)
def test_a_fit_converges_from_far_through_six_impacts(start):
    columns, result = motion(1.2)
    assert len(result.impacts) == 6
    fit_problem = problem(columns, scene(**start), dict.fromkeys(TIP, NOISE))
    search_result = search_parameters(fit_problem)
    assert search_result.last_search.converged
    assert fit_problem.values(search_result.last_search.best.coordinates) == pytest.approx(TRUE, rel=0.1)
    squares = ((search_result.last_search.best.residuals / NOISE) ** 2).sum()
    assert 300.0 < squares < 500.0
    assert list(search_result.horizons) == sorted(search_result.horizons)
    assert search_result.horizons[-1] == 1.2
    assert fit_problem.evaluations < 40


def test_standard_deviations_are_estimated_by_column():
    columns, result = motion(0.9)
    columns[TIP[1]] += 4e-3 * np.random.default_rng(5).standard_normal(200)
    fit_problem = problem(
        [columns, impacts(result, ["peak_force"], noise=0.02)], scene(), {"peak_force": "2%"}
    )
    search_result = search_parameters(fit_problem)
    sigma = {name: search_result.sigma[fit_problem.group == k] for k, name in enumerate(fit_problem.names)}
    assert sigma[TIP[0]] == pytest.approx(1e-3, rel=0.15)
    assert sigma[TIP[1]] == pytest.approx(math.hypot(1e-3, 4e-3), rel=0.15)
    assert sigma["peak_force"] == pytest.approx(0.02 * fit_problem.value[fit_problem.group == 2])
    # a further estimate hardly changes the deviations
    next_sigma = estimate_sigma(fit_problem, search_result.last_search.best, search_result.sigma)
    np.testing.assert_allclose(next_sigma, search_result.sigma, rtol=horizon.SETTLED_SIGMA)


@pytest.mark.parametrize("seed", range(8))
def test_an_exactly_fitted_column_keeps_its_deviation(seed):
    """The column has no degree of freedom: its computed variance is round-off of either sign."""
    random = np.random.default_rng(seed)
    slopes = np.zeros((12, 4))
    slopes[:2, :2], slopes[2:, 2:] = random.standard_normal((2, 2)), random.standard_normal((10, 2))
    group = np.arange(12) >= 2
    column_data = SimpleNamespace(
        names=["few", "many"], estimated=["few", "many"], group=group.astype(int), size=np.ones(12)
    )
    at = SimpleNamespace(is_usable=np.ones(12, bool), slopes=slopes, residuals=np.full(12, 0.5))
    sigma = estimate_sigma(column_data, at, np.full(12, 0.01))
    assert sigma[:2].tolist() == [0.01, 0.01]
    assert sigma[2:] == pytest.approx(math.sqrt(10 * 0.25 / 8))


def test_data_without_noise_are_met():
    columns, _ = motion(0.7, count=40, noise=0.0)
    fit_problem = problem(columns, scene(K=5e7, e=0.6))
    search_result = search_parameters(fit_problem)
    assert search_result.last_search.converged
    assert fit_problem.values(search_result.last_search.best.coordinates) == pytest.approx(TRUE, rel=1e-3)


def test_a_fit_of_impacts_alone_converges():
    _, result = motion(0.9)
    fit_problem = problem(impacts(result, ["onset", "peak_force"], noise=1e-4), scene(K=5e7, e=0.6, w=1.4))
    search_result = search_parameters(fit_problem)
    assert search_result.last_search.converged
    assert fit_problem.values(search_result.last_search.best.coordinates) == pytest.approx(TRUE, rel=0.02)


def test_data_that_differ_from_the_start_on_are_searched_once_through():
    _, result = motion(0.3, count=30)
    table = {"time": result.time, **{name: result[name] + 1.0 for name in (*TIP, "link[1].angle")}}
    assert table["time"][0] == 0.0
    result = search_parameters(problem(table, scene(), names=["contact.restitution"]))
    assert np.all(np.diff(result.horizons) > 0.0)
    assert result.horizons[-1] == pytest.approx(0.3)


def test_wrong_horizons_are_refused():
    columns, _ = motion(0.6, count=10)
    single_value = {"impact": [1], "peak_force": [2e4]}
    assert refusal(search_parameters, problem([columns, single_value], scene())) == (
        "data+data: peak_force has one value only, from which its sigma cannot be estimated: give it, "
        "for example 2% (--sigma peak_force=2%), or add a column sigma(peak_force)"
    )
    partial_table = columns | {f"sigma({TIP[0]})": [1e-3] + [None] * 9}
    assert "some values of point[4].x have a sigma and others none" in refusal(
        search_parameters, problem(partial_table, scene())
    )
    none = {"impact": [7, 8], "onset": [0.3, 0.4]}
    assert (
        "the model has no value to compare with data: the model has none of the measured impacts"
        in refusal(search_parameters, problem(none, scene()))
    )
