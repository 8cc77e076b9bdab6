"""The maximum of a quantity within a step."""

# Tests: kernel/ode/maximum.py

import math

import pytest

from chain_impact.kernel.ode.maximum import maximum_of


@pytest.mark.parametrize("top", [0.15, 0.5, 0.83])
def test_a_smooth_maximum_is_found(top):
    result = maximum_of(lambda _d, _i, theta: math.cos(theta - top))(None, 0, 0.5, 0.5, 1.0)
    assert result == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("slope", [1.0, -1.0])
def test_without_a_maximum_inside_it_is_the_largest_sample(slope):
    result = maximum_of(lambda _d, _i, theta: 2.0 + slope * theta)(None, 0, 0.5, 0.5, 1.0)
    assert result == max(2.0, 2.0 + slope)
