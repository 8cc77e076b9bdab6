"""Standard errors from derivatives."""

import math

import numpy as np
import pytest
from scipy import stats

from chain_impact.studies.fit.uncertainty import information, largest_usual, quantile

SLOPES = np.array([[1.0, 0.0], [1.0, 1.0], [1.0, 2.0], [1.0, 3.0]])
SIGMA = np.full(4, 0.5)


def test_a_straight_line():
    """Standard errors of intercept and slope as in every textbook."""
    known, x = information(SLOPES, SIGMA), np.arange(4.0)
    spread = ((x - x.mean()) ** 2).sum()
    wanted = 0.5 * math.sqrt(0.25 + x.mean() ** 2 / spread), 0.5 / math.sqrt(spread)
    assert known.errors == pytest.approx(wanted)
    assert known.covariance[0, 1] == pytest.approx(-(0.5**2) * x.mean() / spread)


def test_scales_do_not_matter():
    scale = np.array([1e9, 1e-9])
    errors = information(SLOPES * scale, SIGMA).errors
    assert errors * scale == pytest.approx(information(SLOPES, SIGMA).errors)


def test_what_has_no_effect_has_an_infinite_error_and_others_none():
    known = information(np.column_stack([SLOPES, np.zeros(4)]), SIGMA)
    assert known.errors[:2] == pytest.approx(information(SLOPES, SIGMA).errors)
    assert known.errors[2] == math.inf


def test_what_acts_together_only():
    twins = np.column_stack([SLOPES, SLOPES[:, 1] * 3.0])
    known = information(twins, SIGMA)
    assert known.errors[1:].tolist() == [math.inf, math.inf]
    assert math.isfinite(known.errors[0])
    assert known.with_held(2).errors == pytest.approx(information(SLOPES, SIGMA).errors)


def test_one_more_value():
    whole, less = information(SLOPES, SIGMA), information(SLOPES[:3], SIGMA[:3])
    np.testing.assert_allclose(less.with_value(SLOPES[3], 0.5).matrix, whole.matrix)


def test_quantiles():
    assert quantile(5, estimated=False) == pytest.approx(stats.norm.ppf(0.975))
    assert quantile(5, estimated=True) == pytest.approx(stats.t.ppf(0.975, 5))
    assert largest_usual(10) == pytest.approx(stats.chi2.ppf(0.999, 10))
