"""Cosines and sines of the kernel, against mpmath."""

import mpmath
import numpy as np
import pytest

from chain_impact.kernel.chain.sincos import LARGEST, polar
from chain_impact.kernel.status import NOT_FINITE
from chain_impact.simulation.instance import Instance
from tests.kernel_calls import initialize
from tests.problems import ball


def kernel(angles):
    cosine, sine = np.empty_like(angles), np.empty_like(angles)
    polar(np.ones(len(angles)), angles, 0, cosine, sine)
    return cosine, sine


@pytest.mark.parametrize("size", [1.0, 10.0, 1e3, LARGEST])
def test_errors_are_below_two_parts_in_1e16(size):
    angles = np.random.default_rng(4).uniform(-size, size, 4000)
    with mpmath.workdps(40):
        for angle in angles:
            cosine, sine = kernel(np.array([angle]))  # one at a time: their sum decides who computes them
            exact = mpmath.mpf(float(angle))
            assert abs(mpmath.cos(exact) - float(cosine[0])) < 2e-16
            assert abs(mpmath.sin(exact) - float(sine[0])) < 2e-16


def test_quarter_turns_keep_their_place():
    quarters = np.arange(-9, 10)
    cosine, sine = kernel(quarters * (np.pi / 2))
    turned = 1j ** (quarters % 4)
    # k π/2 is itself off by up to 1e-15
    np.testing.assert_allclose(cosine, turned.real, rtol=0, atol=2e-15)
    np.testing.assert_allclose(sine, turned.imag, rtol=0, atol=2e-15)
    assert kernel(np.zeros(3))[1].tolist() == [0.0, 0.0, 0.0]


def test_each_angle_alone_gives_what_all_give():
    angles = np.linspace(-7.0, 7.0, 23)
    together = kernel(angles)
    for i in range(len(angles)):
        assert kernel(angles[i : i + 1]) == (together[0][i], together[1][i])


def test_larger_angles_are_left_to_the_c_library():
    angles = np.array([0.3, 2.0 * LARGEST, -1e15])
    cosine, sine = kernel(angles)
    np.testing.assert_array_equal(cosine, np.cos(angles))
    np.testing.assert_array_equal(sine, np.sin(angles))


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_not_finite_is_refused(bad):
    instance = Instance(ball())
    instance.record["initial"]["angle"] = bad
    assert initialize(instance) == NOT_FINITE
