"""The search, on functions with a known least sum of squares."""

import numpy as np
import pytest

from chain_impact.studies.fit.least_squares import minimize
from chain_impact.studies.fit.problem import Evaluation


def search(function, start, *, low=-np.inf, high=np.inf, sigma=None, most_steps=200):
    """Minimize a function that returns residuals and slopes; return result and evaluated places."""
    calls = []

    def evaluate(place):
        calls.append(place)
        residuals, slopes = function(place)
        return Evaluation(place, np.asarray(residuals, float), np.asarray(slopes, float), ())

    start = np.asarray(start, float)
    count = len(function(start)[0])
    bounds = np.broadcast_to(low, start.shape), np.broadcast_to(high, start.shape)
    sigma = np.ones(count) if sigma is None else np.asarray(sigma, float)
    result = minimize(
        evaluate, evaluate(start), sigma, bounds=bounds, enough_decrease=1e-12, most_steps=most_steps
    )
    return result, calls


def rosenbrock(place):
    x, y = place
    return [10.0 * (y - x * x), 1.0 - x], [[-20.0 * x, 10.0], [-1.0, 0.0]]


LINE = np.array([[1.0, 0.0], [1.0, 1.0], [1.0, 2.0], [1.0, 3.0]])
VALUES = np.array([1.0, 2.9, 5.2, 6.8])


def line(place):
    return LINE @ place - VALUES, LINE


def test_a_straight_line_takes_few_steps():
    result, _ = search(line, [0.0, 0.0])
    assert result.converged
    assert result.steps < 8
    np.testing.assert_allclose(result.best.coordinates, np.linalg.lstsq(LINE, VALUES)[0], atol=1e-7)


def test_weights_scale_the_residuals():
    sigma = np.array([1.0, 0.1, 1.0, 10.0])
    result, _ = search(line, [0.0, 0.0], sigma=sigma)
    expected = np.linalg.lstsq(LINE / sigma[:, None], VALUES / sigma)[0]
    np.testing.assert_allclose(result.best.coordinates, expected, atol=1e-6)


def test_the_search_finds_the_minimum_of_rosenbrock():
    result, _ = search(rosenbrock, [-1.2, 1.0], sigma=[1e-6, 1e-6])
    assert result.converged
    np.testing.assert_allclose(result.best.coordinates, [1.0, 1.0], atol=1e-6)


def test_bounds_hold_and_others_move_on():
    result, calls = search(line, [0.0, 0.0], low=[-1.0, -1.0], high=[3.0, 1.5])
    assert result.converged
    assert all((place >= -1.0).all() and (place <= [3.0, 1.5]).all() for place in calls)
    assert result.best.coordinates[1] == pytest.approx(1.5)
    assert result.best.coordinates[0] == pytest.approx((VALUES - 1.5 * LINE[:, 1]).mean())


def test_a_parameter_without_effect_stays():
    result, _ = search(lambda place: ([place[0] - 2.0], [[1.0, 0.0]]), [0.0, 5.0])
    assert result.converged
    assert result.best.coordinates == pytest.approx([2.0, 5.0])


def test_a_parameter_without_effect_costs_no_steps():
    def valley(place):
        residuals, slopes = rosenbrock(place[:2])
        return residuals, np.hstack([slopes, np.zeros((2, 1))])

    result, calls = search(valley, [-1.2, 1.0, 7.0], sigma=[1e-6, 1e-6])
    result_alone, calls_alone = search(rosenbrock, [-1.2, 1.0], sigma=[1e-6, 1e-6])
    assert result.best.coordinates.tolist() == [*result_alone.best.coordinates, 7.0]
    assert len(calls) == len(calls_alone)


def test_rows_that_are_not_there_do_not_count_and_none_may_be_lost():
    def gap(place):
        residuals, slopes = line(place)
        is_lost = place[1] > 1.0  # beyond this place an impact is missing
        return np.append(residuals, np.nan if is_lost else 0.1), np.vstack([slopes, [[0.0, 0.0]]])

    result, calls = search(gap, [0.0, 0.0])
    assert any(place[1] > 1.0 for place in calls)
    assert 0.9 < result.best.coordinates[1] <= 1.0


def test_rows_without_derivatives_are_not_fitted():
    def blind(place):
        residuals, slopes = line(place)
        return np.append(residuals, 1e3), np.vstack([slopes, [[np.nan, np.nan]]])

    result, _ = search(blind, [0.0, 0.0])
    np.testing.assert_allclose(result.best.coordinates, np.linalg.lstsq(LINE, VALUES)[0], atol=1e-6)


def test_a_search_without_parameters_does_not_converge():
    result, _ = search(lambda place: ([np.nan], [[1.0]]), [0.0])
    assert not result.converged
    result, _ = search(rosenbrock, [-1.2, 1.0], most_steps=3)
    assert (result.converged, result.steps) == (False, 3)


def test_slopes_without_bounds_near_a_bound():
    """The best value is beyond the bound 0. The slope grows as x^(−1/2) near 0 until its square overflows."""

    def root(place):
        x = max(float(place[0]), 1e-323)
        angles = np.arange(5.0)
        return np.sqrt(x) * angles + 1.0 + np.sin(angles), (0.5 / np.sqrt(x) * angles)[:, None]

    for start in (0.9, 0.3, 1e-9, 1e-200):
        result, _ = search(root, [start], low=0.0, high=1.0)
        assert 0.0 < result.best.coordinates[0] < 1.0
        assert np.isfinite(result.best.slopes).all()


def test_a_place_whose_slopes_have_no_finite_squares_is_refused():
    def steep(place):
        x = float(place[0])
        return [x - 1.0, 0.1], [[1e200 if x > 0.5 else 1.0], [0.0]]

    result, _ = search(steep, [0.0])
    assert result.best.coordinates[0] <= 0.5
