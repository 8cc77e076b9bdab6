"""The kernel's cosines and sines, against mpmath."""

import mpmath
import numpy as np
import pytest

from chain_impact.kernel.chain.kinematics import copy_entries, is_in_sine_range, set_polar
from chain_impact.kernel.mathematics.angles import LARGEST_ANGLE, cosine, cosine_and_sine, sine
from chain_impact.kernel.status import NOT_FINITE
from chain_impact.simulation.instance import Instance
from tests.helpers.kernel.kernel_calls import initialize
from tests.helpers.scenes.problems import ball


def kernel(angles):
    cosine, sine = np.empty_like(angles), np.empty_like(angles)
    set_polar(np.ones(len(angles)), angles, 0, cosine, sine)
    return cosine, sine


@pytest.mark.full("more cases", but=2)
@pytest.mark.parametrize("size", [1.0, 10.0, 1e3, LARGEST_ANGLE])
def test_errors_are_below_two_parts_in_1e16(size):
    angles = np.random.default_rng(4).uniform(-size, size, 4000)
    with mpmath.workdps(40):
        for angle in angles:
            # one angle at a time: the sum of the angles selects the algorithm
            cosine, sine = kernel(np.array([angle]))
            exact = mpmath.mpf(float(angle))
            assert abs(mpmath.cos(exact) - float(cosine[0])) < 2e-16
            assert abs(mpmath.sin(exact) - float(sine[0])) < 2e-16


def test_quarter_turns_keep_their_place():
    quarters = np.arange(-9, 10)
    cosine, sine = kernel(quarters * (np.pi / 2))
    turned = 1j ** (quarters % 4)
    # k π/2 in floating point has an error of up to 1e-15
    np.testing.assert_allclose(cosine, turned.real, rtol=0, atol=2e-15)
    np.testing.assert_allclose(sine, turned.imag, rtol=0, atol=2e-15)
    assert kernel(np.zeros(3))[1].tolist() == [0.0, 0.0, 0.0]


def test_each_angle_alone_gives_what_all_give():
    angles = np.linspace(-7.0, 7.0, 23)
    together = kernel(angles)
    for i in range(len(angles)):
        assert kernel(angles[i : i + 1]) == (together[0][i], together[1][i])


@pytest.mark.parametrize("quarter", range(-6, 7))
def test_the_cosine_and_sine_of_an_angle_are_those_of_each_quarter_turn(quarter):
    for part in (-0.49, -0.2, 0.0, 0.3, 0.49):
        angle = (quarter + part) * np.pi / 2
        np.testing.assert_allclose(cosine_and_sine(angle), (np.cos(angle), np.sin(angle)), rtol=0, atol=3e-16)


def test_angles_are_in_range_while_their_sum_is_below_the_limit():
    angles = np.array([9 * LARGEST_ANGLE, -0.6 * LARGEST_ANGLE, 0.39 * LARGEST_ANGLE, 9 * LARGEST_ANGLE])
    assert is_in_sine_range(angles, 1, 2)
    assert is_in_sine_range(angles, 1, 0)
    assert not is_in_sine_range(angles, 1, 3)
    assert not is_in_sine_range(angles, 0, 2)
    angles[2] = 0.4 * LARGEST_ANGLE
    assert not is_in_sine_range(angles, 1, 2)


@pytest.mark.parametrize("count", range(10))
@pytest.mark.parametrize("first", [0, 3])
def test_numbers_are_copied_from_where_they_begin(count, first):
    numbers, out = np.arange(20.0) + 1.0, np.full(12, -1.0)
    copy_entries(numbers, first, count, out)
    np.testing.assert_array_equal(out, [*numbers[first : first + count], *[-1.0] * (12 - count)])


@pytest.mark.parametrize("largest", [3.0, 3.0 * LARGEST_ANGLE])
def test_a_radius_scales_both_and_angles_begin_where_they_are_said_to(largest):
    angles, radius = np.array([1.0, 2.0, -largest, 0.5]), np.array([0.7, 2.5])
    across, along = np.zeros(2), np.zeros(2)
    set_polar(radius, angles, 1, across, along)
    np.testing.assert_allclose(across + 1j * along, radius * np.exp(1j * angles[1:3]), rtol=0, atol=1e-15)


def test_larger_angles_are_as_exact():
    """The last one is closer to a multiple of π/2 than any other double."""
    sizes = 2.0 ** np.random.default_rng(5).uniform(20.0, 1024.0, 200)
    with mpmath.workprec(1300):
        for angle in [*sizes, *-sizes, LARGEST_ANGLE, -1e15, 6381956970095103.0 * 2.0**797]:
            exact = mpmath.mpf(float(angle))
            assert abs(mpmath.cos(exact) - cosine(float(angle))) < 2e-16
            assert abs(mpmath.sin(exact) - sine(float(angle))) < 2e-16


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_an_angle_that_is_not_finite_is_refused(bad):
    instance = Instance(ball())
    instance.record["initial"]["angle"] = bad
    assert initialize(instance) == NOT_FINITE
