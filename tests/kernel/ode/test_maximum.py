"""The maximum of a quantity within a step: its value and its place."""

# Tests: kernel/ode/maximum.py

import math

import pytest

from chain_impact.kernel.ode.maximum import maximum_of, place_of_largest


@pytest.mark.parametrize("top", [0.15, 0.5, 0.83])
def test_a_smooth_maximum_is_found_with_its_place(top):
    found, place = maximum_of(lambda _d, _i, theta: math.cos(theta - top))(None, 0, 0.5, 0.5, 1.0)
    assert found == pytest.approx(1.0, abs=1e-9)
    assert place == pytest.approx(top, abs=1e-5)


@pytest.mark.parametrize(("slope", "top"), [(1.0, 1.0), (-1.0, 0.0)])
def test_without_a_maximum_inside_it_is_the_largest_sample(slope, top):
    assert maximum_of(lambda _d, _i, theta: 2.0 + slope * theta)(None, 0, 0.5, 0.5, 1.0) == (
        2.0 + slope * top,
        top,
    )


def test_of_equal_values_the_middle_one_is_taken():
    assert place_of_largest(1.0, 1.0, 1.0, 0.5, 0.1) == 0.5
    assert place_of_largest(2.0, 1.0, 1.5, 0.5, 0.1) == 0.4
    assert place_of_largest(1.0, 1.0, 1.5, 0.5, 0.1) == 0.6
