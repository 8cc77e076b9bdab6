"""Derivatives by explicit rules, where the computation of a value does not give its derivative."""

import importlib
import inspect
import math
import pkgutil
from types import SimpleNamespace

import mpmath
import numpy as np
import pytest

import chain_impact.kernel
from chain_impact.kernel.chain import kinematics, mass_matrix_solver
from chain_impact.kernel.forces import force_formula, user_law
from chain_impact.kernel.ode import dense_output, sundman_rate
from chain_impact.kernel.record.state import sundman_u_at, time_at
from chain_impact.kernel.tangent import rules
from tests.kernel.tangent.dual import Dual

RULES = {"has_dual_rule": rules.DUAL_RULES, "has_complex_rule": mass_matrix_solver.COMPLEX_RULES}
DEPTH, EXPONENT = [0.3, -1.0, 2.0], [0.7, 0.2, 0.0]  # slopes


@pytest.mark.parametrize("function", rules.DUAL_RULES, ids=lambda function: function.__name__)
def test_a_rule_is_called_as_the_function_that_it_stands_for(function):
    rule = rules.DUAL_RULES[function]
    assert rule.__name__ == function.__name__
    assert len(inspect.signature(rule).parameters) == len(inspect.signature(function).parameters)


@pytest.mark.parametrize("mark", RULES)
def test_the_functions_with_a_rule_are_marked_and_no_others(mark):
    package = chain_impact.kernel
    names = [module.name for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}.")]
    values = {
        member
        for name in names
        for member in vars(importlib.import_module(name)).values()
        if callable(member)
    }
    assert {value for value in values if getattr(value, mark, False)} == set(RULES[mark])


@pytest.mark.parametrize("varies", [EXPONENT, [0.0, 0.0, 0.0]])
@pytest.mark.parametrize("exponent", [0.25, 0.5, 1.0, 1.5, 1.7, 3.0])
@pytest.mark.parametrize("depth", [1e-9, 2e-3, 0.7])
def test_a_power_varies_with_both(depth, exponent, varies):
    """Most exponents are constant: then the rule needs no logarithm."""
    result = rules.power_of_penetration(Dual(depth, DEPTH), Dual(exponent, varies))
    assert result.value == force_formula.power_of_penetration(depth, exponent)
    by_depth = mpmath.diff(lambda x: mpmath.power(x, exponent), depth, h=1e-9 * depth)
    by_exponent = mpmath.diff(lambda n: mpmath.power(depth, n), exponent)
    expected = float(by_depth) * np.array(DEPTH) + float(by_exponent) * np.array(varies)
    np.testing.assert_allclose(result.slope, expected, rtol=1e-7)


@pytest.mark.parametrize(("exponent", "slope"), [(0.5, 0.0), (1.0, 1.0), (1.5, 0.0)])
def test_at_no_depth_a_power_is_finite(exponent, slope):
    result = rules.power_of_penetration(Dual(0.0, DEPTH), Dual(exponent, EXPONENT))
    assert result.value == 0.0
    assert result.slope.tolist() == (slope * np.array(DEPTH)).tolist()


@pytest.mark.parametrize("size", [3.0, 10.0 * kinematics.LARGEST_ANGLE])
def test_points_of_a_circle(size):
    random = np.random.default_rng(2)
    angles, slopes = random.uniform(-size, size, 5), random.normal(size=(2, 5))
    radii = np.array([1.0, 0.5, 2.0, 0.0, 3.0])
    x, y = [None] * 5, [None] * 5
    duals = [Dual(v, [0.0, s]) for v, s in zip([9.9, *angles], [0.0, *slopes[0]], strict=True)]
    rules.set_polar([Dual(r, [s, 0.0]) for r, s in zip(radii, slopes[1], strict=True)], duals, 1, x, y)
    horizontal, vertical = np.empty(5), np.empty(5)
    kinematics.set_polar(radii, angles, 0, horizontal, vertical)
    np.testing.assert_array_equal([number.value for number in x], horizontal)
    np.testing.assert_array_equal([number.value for number in y], vertical)
    cosine, sine = np.cos(angles), np.sin(angles)
    np.testing.assert_allclose([number.slope[0] for number in x], cosine * slopes[1], atol=1e-14)
    np.testing.assert_allclose([number.slope[0] for number in y], sine * slopes[1], atol=1e-14)
    np.testing.assert_allclose([number.slope[1] for number in x], -radii * sine * slopes[0], atol=1e-14)
    np.testing.assert_allclose([number.slope[1] for number in y], radii * cosine * slopes[0], atol=1e-14)


def test_the_force_of_a_user(monkeypatch):
    def force(depth, rate, speed, mass, stiffness, exponent, restitution):  # noqa: PLR0917
        damped = 1.0 + (1.0 - restitution) * rate / speed
        return stiffness * depth**exponent * damped + 1e3 * mass * depth * rate

    at = (2e-3, 0.8, 1.3, 0.4, 1e6, 1.4, 0.6)
    monkeypatch.setattr(user_law, "force", force)
    result = rules.user_force(*(Dual(number, np.eye(7)[k]) for k, number in enumerate(at)))
    assert result.value == force(*at)
    with mpmath.workdps(30):
        expected = [float(mpmath.diff(force, at, tuple(np.eye(7, dtype=int)[k]))) for k in range(7)]
    np.testing.assert_allclose(result.slope, expected, rtol=1e-9)


def test_the_force_of_a_user_at_no_depth(monkeypatch):
    monkeypatch.setattr(user_law, "force", lambda depth, *_: 5.0 + math.sqrt(depth))
    result = rules.user_force(
        Dual(0.0, [1.0]), *(Dual(number, [0.0]) for number in (0.8, 1.0, 1.0, 1.0, 1.5, 0.5))
    )
    assert result.value == 5.0
    assert result.slope.tolist() == [0.0]


def test_a_constant_of_a_joint_that_is_zero_may_vary():
    assert not rules.has_effect(Dual(0.0, [0.0, 0.0]))
    assert rules.has_effect(Dual(0.0, [0.0, 1.0]))
    assert rules.has_effect(Dual(0.1, [0.0, 0.0]))


COUNT = 10  # length of the state of a chain of one link


def step_of(numbers, regularized, make=lambda number, _: number):
    """Return an instance of one link whose last step has these numbers: dense output, state, start, size."""
    parts_made = [make(number, k) for k, number in enumerate(numbers)]
    table = {(m, j): parts_made[COUNT * m + j] for m in range(7) for j in range(COUNT)}
    start, size = parts_made[-2:]
    step = SimpleNamespace(state=parts_made[-2 - COUNT : -2], dense=table, start=start, size=size)
    step.regularized_candidate = regularized
    return SimpleNamespace(link_count=1, step=step)


@pytest.mark.parametrize("regularized", [-1, 0])
def test_the_fraction_of_a_step_varies_with_the_step_and_the_time(regularized):
    """The reference is the difference of the function of plain numbers.

    The time within the regularized step is not that of the differential equation.
    """
    clock, root = time_at(1), sundman_u_at(1)
    size, depth_root, elapsed = 0.5, 0.6, 0.09
    numbers = np.concatenate([np.random.default_rng(5).normal(size=8 * COUNT), [0.25, size]])
    coefficients, state = numbers[: 7 * COUNT].reshape(7, COUNT), numbers[7 * COUNT : 8 * COUNT]
    coefficients[:, root] = 0.0
    coefficients[1:, clock] *= 0.02
    coefficients[0, clock] = size * sundman_rate.regularized_time_rate(depth_root)
    state[clock], state[root] = 0.0, depth_root

    def plain(changed):
        return dense_output.fraction_at_time(step_of(changed, regularized), 0.25 + elapsed)

    t = step_of(numbers, regularized, lambda number, k: Dual(number, np.eye(numbers.size)[k]))
    result = rules.fraction_at_time(t, 0.25 + elapsed)
    assert result.value == pytest.approx(plain(numbers), abs=1e-15)
    steps = 1e-5 * np.eye(numbers.size)
    expected = np.array([(plain(numbers + step) - plain(numbers - step)) / 2e-5 for step in steps])
    assert np.abs(expected).max() > 0.3
    np.testing.assert_allclose(result.slope, expected, atol=1e-8)
