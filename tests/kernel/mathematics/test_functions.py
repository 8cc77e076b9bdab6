"""Exponentials, logarithms and powers in plain Python, against mpmath and at special numbers."""

# Tests: kernel/mathematics/exponentials.py, kernel/mathematics/logarithms.py, kernel/mathematics/powers.py

import math

import mpmath
import numpy as np
import pytest

from chain_impact.kernel.mathematics import doubles, exponentials, logarithms
from chain_impact.kernel.mathematics.powers import power
from tests.helpers.kernel.own_functions import arguments, in_plain_python

EXACT = {
    "exp": lambda x, _: mpmath.exp(x),
    "expm1": lambda x, _: mpmath.expm1(x),
    "log": lambda x, _: mpmath.log(x),
    "log1p": lambda x, _: mpmath.log1p(x),
    "pow": mpmath.power,
}
NUMBERS = [0.0, -0.0, 1.0, -1.0, 2.0, -2.5, 3.0, 0.75, 5e-324, 1e300, math.inf, -math.inf, math.nan]
LEAST = 2.0**-1074


@pytest.mark.parametrize("name", EXACT)
def test_errors_are_below_one_ulp(name):
    given = arguments(name, 1000)
    with mpmath.workdps(60):
        for (x, y), result in zip(given.tolist(), in_plain_python(name, given).tolist(), strict=True):
            exact = EXACT[name](mpmath.mpf(x), mpmath.mpf(y))
            if abs(exact) < 1.7e308:
                assert abs(result - exact) <= math.ulp(float(exact)), (x, y)


@pytest.mark.parametrize("function", [exponentials.exp, exponentials.expm1, logarithms.log, logarithms.log1p])
def test_special_numbers_are_as_in_c(function):
    reference = getattr(np, function.__name__)
    with np.errstate(all="ignore"):
        for x in (*NUMBERS, 709.8, -745.2, 1e4, -1e4, LEAST, -LEAST):
            np.testing.assert_allclose(function(x), reference(x), rtol=3e-16, atol=0, err_msg=str(x))
    assert math.copysign(1.0, exponentials.expm1(-0.0)) == math.copysign(1.0, logarithms.log1p(-0.0)) == -1.0


def test_powers_of_special_numbers_are_as_in_c():
    with np.errstate(all="ignore"):
        for x in NUMBERS:
            for y in (*NUMBERS, -3.0, -0.5, 2.0**53 + 2.0, -1e300):
                result, expected = power(x, y), np.power(x, y)
                np.testing.assert_allclose(result, expected, rtol=3e-16, atol=0, err_msg=f"{x} ** {y}")
                assert math.isnan(expected) or math.copysign(1.0, result) == math.copysign(1.0, expected)


def test_the_ends_of_the_range_are_those_of_c():
    assert exponentials.exp(709.782712893384) == pytest.approx(1.797693134862e308, rel=1e-12)
    assert exponentials.exp(709.7827128933841) == math.inf
    assert exponentials.exp(-745.1332191019411) == LEAST
    assert exponentials.exp(-745.1332191019412) == 0.0
    assert power(2.0, 1023.5) == pytest.approx(2.0**1023 * math.sqrt(2.0), rel=2e-16)
    assert (power(2.0, 1024.0), power(2.0, -1074.0), power(0.5, 1075.5)) == (math.inf, LEAST, 0.0)
    assert power(LEAST, 0.5) == 2.0**-537


def test_whole_powers_of_whole_numbers_are_exact():
    assert [power(float(x), float(n)) for x in (2, 3, 7, 10) for n in range(16)] == [
        float(x**n) for x in (2, 3, 7, 10) for n in range(16)
    ]


def test_logarithms_and_exponentials_rise_where_table_entries_meet():
    patterns = [
        logarithms.FIRST_INTERVAL_BITS + (i << logarithms.WIDTH_BITS)
        for i in range(logarithms.MANTISSA_INTERVALS + 1)
    ]
    joints = [doubles.double_of_bits(pattern) for pattern in patterns]
    steps = [(j + 0.5) * math.log(2.0) / exponentials.POWER_COUNT for j in range(-200, 200)]
    for function, places in ((logarithms.log, joints), (exponentials.exp, steps)):
        for place in places:
            near = place + np.arange(-5, 6) * math.ulp(place)
            assert (np.diff([function(float(x)) for x in near]) >= 0.0).all()
