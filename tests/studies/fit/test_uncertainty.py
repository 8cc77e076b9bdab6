"""Standard errors from derivatives."""

import math

import numpy as np
import pytest

from chain_impact.studies.fit.uncertainty import (
    exceedance_probability,
    information_of,
    quantiles,
    small_sample,
)

SLOPES = np.array([[1.0, 0.0], [1.0, 1.0], [1.0, 2.0], [1.0, 3.0]])
SIGMA = np.full(4, 0.5)


def test_a_straight_line():
    """The textbook gives standard errors of intercept and slope."""
    result, x = information_of(SLOPES, SIGMA), np.arange(4.0)
    spread = ((x - x.mean()) ** 2).sum()
    expected = 0.5 * math.sqrt(0.25 + x.mean() ** 2 / spread), 0.5 / math.sqrt(spread)
    assert result.errors == pytest.approx(expected)
    assert result.covariance[0, 1] == pytest.approx(-(0.5**2) * x.mean() / spread)


def test_scales_do_not_matter():
    scale = np.array([1e9, 1e-9])
    errors = information_of(SLOPES * scale, SIGMA).errors
    assert errors * scale == pytest.approx(information_of(SLOPES, SIGMA).errors)


def test_a_parameter_without_effect_has_an_infinite_error_others_none():
    result = information_of(np.column_stack([SLOPES, np.zeros(4)]), SIGMA)
    assert result.errors[:2] == pytest.approx(information_of(SLOPES, SIGMA).errors)
    assert result.errors[2] == math.inf


def test_parameters_that_act_only_together_have_infinite_errors():
    twins = np.column_stack([SLOPES, SLOPES[:, 1] * 3.0])
    result = information_of(twins, SIGMA)
    assert result.errors[1:].tolist() == [math.inf, math.inf]
    assert math.isfinite(result.errors[0])
    assert result.with_held(2).errors == pytest.approx(information_of(SLOPES, SIGMA).errors)


def test_quantiles_are_those_of_scipy():
    from scipy import stats  # here, because the import takes half a second

    expected = [stats.t.ppf(0.975, 2), stats.t.ppf(0.975, 5.5), stats.norm.ppf(0.975), np.inf]
    assert quantiles(np.array([2.0, 5.5, np.inf, 0.0])).tolist() == pytest.approx(expected)
    assert exceedance_probability(25.0, 10) == pytest.approx(stats.chi2.sf(25.0, 10))


def test_degrees_of_freedom_of_one_column_are_its_own():
    everything = np.ones(4, bool)
    assert small_sample(SLOPES, SIGMA, [(everything, 2.0)]).freedom.tolist() == pytest.approx([2.0, 2.0])
    assert small_sample(SLOPES, SIGMA, []).freedom.tolist() == [np.inf, np.inf]


def test_degrees_of_freedom_are_those_of_the_column_that_tells_a_parameter():
    """Three values determine the first parameter, and 100 values the second: as in two separate fits."""
    slopes = np.zeros((103, 2))
    slopes[:3, 0] = slopes[3:, 1] = 1.0
    is_in_first = np.arange(103) < 3
    columns = [(is_in_first, 2.0), (~is_in_first, 99.0)]
    result = small_sample(slopes, np.full(103, 0.5), columns)
    assert result.freedom.tolist() == pytest.approx([2.0, 99.0])
    assert result.factor.tolist() == pytest.approx([1.0, 1.0])


def test_degrees_of_freedom_of_two_means_are_those_of_welch():
    """The reference is the number in Welch's test for the difference of two means with unequal variances."""
    n, m, s, r = 4, 7, 2.0, 0.3
    slopes = np.vstack([np.repeat([[1.0, 1.0]], n, 0), np.repeat([[1.0, 0.0]], m, 0)])  # mean, difference
    is_in_first = np.arange(n + m) < n
    freedom = small_sample(
        slopes, np.where(is_in_first, s, r), [(is_in_first, n - 1.0), (~is_in_first, m - 1.0)]
    ).freedom
    a, b = s * s / n, r * r / m
    assert freedom[1] == pytest.approx((a + b) ** 2 / (a * a / (n - 1) + b * b / (m - 1)))
    assert freedom[0] == pytest.approx(m - 1.0)


def test_a_mean_that_is_weighted_by_estimates_has_a_larger_error():
    """The reference is Meier's variance of a weighted mean of two samples (Biometrics 9 (1953) 59)."""
    n, m, s, r = 4, 7, 2.0, 0.3
    is_in_first = np.arange(n + m) < n
    sigma, columns = np.where(is_in_first, s, r), [(is_in_first, n - 1.0), (~is_in_first, m - 1.0)]
    weights = np.array([n / s**2, m / r**2])
    p = weights / weights.sum()
    result = small_sample(np.ones((n + m, 1)), sigma, columns)
    assert result.factor**2 == pytest.approx(1.0 + 4.0 * (p * (1.0 - p) / [n - 1.0, m - 1.0]).sum())
    assert result.freedom == pytest.approx(1.0 / (p**2 / [n - 1.0, m - 1.0]).sum())
