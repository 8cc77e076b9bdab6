"""Dual numbers compiled by numba: derivatives against SymPy, and values against plain numbers."""

import ctypes
import math
from functools import cache

import numpy as np
import pytest
import sympy
from numba import cfunc, float64, njit, types

from chain_impact.compilation import functions  # noqa: F401 - lets numba compile the kernel's functions
from chain_impact.compilation.dual_numbers import DUAL
from chain_impact.kernel.mathematics import angles, exponentials, logarithms, powers
from chain_impact.kernel.tangent.duals import DIRECTIONS, dual_dtype, dual_with_slope, has_slope, value
from tests.tiers import needs_compilers

pytestmark = needs_compilers

X, Y = sympy.symbols("x y", positive=True)
HALF = sympy.Rational(1, 2)
WORDS = 1 + DIRECTIONS
SLOPES = np.random.default_rng(3).normal(size=(2, DIRECTIONS))
AT = (1.7, 0.6)
COMPILED_FUNCTIONS = []  # compiled functions; numba frees the code of a function with the function
# name → function for numba, function for SymPy
FUNCTIONS = {
    "sum": (lambda x, y: x + y, X + Y),
    "difference": (lambda x, y: x - y, X - Y),
    "product": (lambda x, y: x * y, X * Y),
    "quotient": (lambda x, y: x / y, X / Y),
    "power": (lambda x, y: powers.power(y, x), Y**X),
    "power of a number": (
        lambda x, y: powers.power(x, 2.5) * powers.power(y, -1.5),
        X ** (5 * HALF) / Y ** (3 * HALF),
    ),
    "negated": (lambda x, y: -x + y, Y - X),
    "root": (lambda x, y: math.sqrt(x + y), sympy.sqrt(X + Y)),
    "logarithm": (lambda x, y: logarithms.log(x * y), sympy.log(X * Y)),
    "exponential": (
        lambda x, y: exponentials.exp(x * y) - exponentials.expm1(y - x),
        sympy.exp(X * Y) - sympy.exp(Y - X) + 1,
    ),
    "logarithm of more than 1": (lambda x, y: logarithms.log1p(x * y), sympy.log(1 + X * Y)),
    "cosine": (lambda x, y: angles.cosine(x - y), sympy.cos(X - Y)),
    "sine": (lambda x, y: angles.sine(x * y), sympy.sin(X * Y)),
    "hypotenuse": (lambda x, y: math.hypot(y, x), sympy.sqrt(X**2 + Y**2)),
    "size": (lambda x, y: abs(y - x), X - Y),
    "largest": (lambda x, y: max(y, x, y * y), X),
    "least": (lambda x, y: min(x, y, x * x), Y),
    "number first": (lambda x, y: (2.0 - x) * (3.0 / y) + 4.0 * x, (2 - X) * 3 / Y + 4 * X),
    "number second": (lambda x, y: (x - 2.0) / 3.0 + y * 5 + 1, (X - 2) / 3 + 5 * Y + 1),
}


def in_place(x, y):
    """Compute with operations for which numba has separate functions; ``total`` is real first, then dual."""
    total = 1.0
    for _ in range(3):
        total += x
        total *= y
        total -= 0.5 * x
        total /= x + y
    return total


TOTAL = sympy.Integer(1)
for _ in range(3):
    TOTAL = ((TOTAL + X) * Y - X / 2) / (X + Y)
FUNCTIONS["in place"] = (in_place, TOTAL)


@cache
def compiled(function, kind=DUAL, result=None):
    """Return a compiled function that reads two numbers of a kind from memory and writes its result there."""
    compiled_function = njit(function)

    def call(inputs, outputs):
        outputs[0] = compiled_function(inputs[0], inputs[1])

    compiled_call = cfunc(types.void(types.CPointer(kind), types.CPointer(result or kind)))(call)
    COMPILED_FUNCTIONS.append(compiled_call)
    return ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(compiled_call.address)


def of_duals(function, x=AT[0], y=AT[1], slopes=SLOPES, result=None):
    """Return value and slopes, shape (WORDS,); a result of another type fills the first words."""
    inputs = np.hstack([[[x], [y]], slopes]).ravel()
    outputs = np.full(WORDS, np.nan)
    compiled(function, DUAL, result)(inputs.ctypes.data, outputs.ctypes.data)
    return outputs


def of_numbers(function, x=AT[0], y=AT[1]):
    inputs, outputs = np.array([x, y]), np.full(1, np.nan)
    compiled(function, float64)(inputs.ctypes.data, outputs.ctypes.data)
    return outputs[0]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_derivatives_are_those_of_sympy_and_values_those_of_plain_numbers(name):
    assert dual_dtype(np.dtype(np.float64)).itemsize == 8 * WORDS
    function, expression = FUNCTIONS[name]
    result = of_duals(function)
    at = {X: sympy.Float(AT[0], 30), Y: sympy.Float(AT[1], 30)}
    partial = np.array([float(expression.diff(symbol).evalf(30, subs=at)) for symbol in (X, Y)])
    np.testing.assert_allclose(result[1:], partial @ SLOPES, rtol=1e-14, atol=1e-15)
    assert result[0] == pytest.approx(float(expression.evalf(30, subs=at)), rel=1e-15)
    for x, y in np.random.default_rng(7).uniform(0.1, 3.0, (50, 2)):
        assert of_duals(function, x, y)[0] == of_numbers(function, x, y)  # bit by bit


def test_comparisons_look_at_values_alone():
    def compared(x, y):
        strict = 1.0 * (x < y) + 2.0 * (x <= y) + 4.0 * (x > y)
        return strict + 8.0 * (x >= y) + 16.0 * (x == y) + 32.0 * (x != y)

    for x, y in ((1.0, 2.0), (2.0, 1.0), (1.0, 1.0), (math.nan, 1.0)):
        assert of_duals(compared, x, y, result=float64)[0] == of_numbers(compared, x, y)


def test_the_first_of_equal_dual_numbers_is_kept():
    """Of equal values, min and max return the first, as Python does."""
    for function in (lambda x, y: max(x, y, x), lambda x, y: min(x, y, y)):
        assert np.array_equal(of_duals(function, 1.0, 1.0)[1:], SLOPES[0])


def test_the_root_of_zero_has_no_slope():
    """A gap that stays zero must not cause NaN in later results."""
    assert not of_duals(lambda x, y: math.sqrt(x) + 0.0 * y, 0.0, 1.0)[1:].any()


def test_truth_and_finiteness_look_at_the_value():
    def judged(x, y):
        return 1.0 * bool(x) + 2.0 * math.isfinite(y)

    steep = np.full((2, DIRECTIONS), np.inf)
    cases = {(0.0, 1.0): 2.0, (1.0, math.nan): 1.0, (2.0, 1.0): 3.0, (0.0, math.inf): 0.0}
    for (x, y), expected in cases.items():
        assert of_duals(judged, x, y, steep, float64)[0] == expected


def test_a_branch_may_give_a_plain_number():
    def either(x, y):
        if x > y:
            return 0.0
        return x

    assert not of_duals(either, 2.0, 1.0).any()
    assert np.array_equal(of_duals(either, 1.0, 2.0), [1.0, *SLOPES[0]])


def test_a_dual_number_answers_the_questions_of_the_kernel():
    assert of_duals(lambda x, y: value(x) * value(y), result=float64)[0] == AT[0] * AT[1]
    dual_number = of_duals(lambda x, y: dual_with_slope(5.0, 3.0, x))
    assert np.array_equal(dual_number, [5.0, *(3.0 * SLOPES[0])])


def test_whether_a_number_varies():
    def vary(x, y):
        return 1.0 * has_slope(x) + 2.0 * has_slope(y)

    for direction in range(DIRECTIONS):
        slopes = np.zeros((2, DIRECTIONS))
        slopes[0, direction] = 1e-300
        assert of_duals(vary, slopes=slopes, result=float64)[0] == 1.0
    assert of_duals(vary, slopes=np.full((2, DIRECTIONS), np.nan), result=float64)[0] == 3.0
