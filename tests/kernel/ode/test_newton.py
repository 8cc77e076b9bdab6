"""The collocation step on generic right-hand sides: its order, its error estimates, and stiffness."""

# Tests: kernel/ode/collocation.py

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from chain_impact.kernel.ode import collocation, radau, step_control
from chain_impact.kernel.record.constants import IMPLICIT, RADAU_STAGES
from tests.helpers.kernel.plain import Plain

ORDER = 9  # of Radau IIA with 5 stages
SCALARS = ("relative_correction", "convergence_rate")


def record(start, weight=1e14):
    """Return the fields of an instance that the iteration reads; ``weight`` scales the corrections."""
    size = len(start)
    implicit = np.dtype(
        [(name, float, (RADAU_STAGES, size)) for name in ("stages", "rates", "right_hand_sides")]
        + [(name, float, (size,)) for name in ("z_start", "rate_start", "z_scratch", "error_weight")]
        + [(name, float) for name in SCALARS]
        + [("iterations", int)]
    )
    counts = [("contacts", "active_count"), ("contacts", "force_law_count"), ("friction", "stuck_count")]
    parts = {part: [(name, int) for of, name in counts if of == part] for part, _ in counts}
    block = np.zeros(1, [("implicit", implicit), *parts.items()])
    d = Plain(block[0])
    d.implicit.z_start[:], d.implicit.error_weight[:] = start, weight
    return d


@cache
def problem(rate, jacobian):
    """Return a step (d, h) for y' = f(y) with an approximate Jacobian A(y); the step returns its convergence.

    The second function (d, h) makes a fixed number of iterations for any A.
    """

    def fill(_d, y, _elapsed, out):
        out[: len(y)] = rate(y)

    def solve(d, h, _size):
        parts, matrix = d.implicit.right_hand_sides, h * jacobian(d.implicit.z_start)
        unity = np.eye(len(matrix))
        parts[0] = np.linalg.solve(unity - radau.REAL_EIGENVALUE * matrix, parts[0])
        for pair, (real, imaginary) in enumerate(radau.COMPLEX_EIGENVALUES):
            at = 1 + 2 * pair
            x = np.linalg.solve(unity - complex(real, imaginary) * matrix, parts[at] + 1j * parts[at + 1])
            parts[at], parts[at + 1] = x.real, x.imag

    find_residuals, correct_stages, converge = radau.simplified_newton(
        lambda _d: None, fill, lambda _d, _stage: None, lambda _d, _z: None, lambda _d, _h: None, solve
    )

    def step(d, h):
        d.implicit.stages[:] = 0.0
        return converge(d, h, len(d.implicit.z_start))

    def patient(d, h):
        d.implicit.stages[:] = 0.0
        for _ in range(60):
            find_residuals(d, h, len(d.implicit.z_start))
            solve(d, h, len(d.implicit.z_start))
            correct_stages(d, h, len(d.implicit.z_start))

    return step, patient


@pytest.fixture
def estimated(monkeypatch):
    """Return a function of f and A that returns a function (d, h): the error of a completed step."""

    def of(rate, jacobian):
        def solve(d, shift, x):
            matrix = jacobian(d.implicit.z_start)
            x[:] = np.linalg.solve(np.eye(len(matrix)) - shift * matrix, x)

        def estimate_error(d, h):
            d.implicit.rate_start[:] = rate(d.implicit.z_start)
            return collocation.error_estimate(d, h, len(d.implicit.z_start))

        monkeypatch.setattr(collocation, "solve_real", solve)
        return estimate_error

    return of


def integrate(step, start, end, steps):
    d = record(start)
    for _ in range(steps):
        step(d, end / steps)
        d.implicit.z_start[:] += d.implicit.stages[-1]
    return d.implicit.z_start.copy()


def oscillator(y):
    """Return the rate of a forced van der Pol oscillator; y[2] is the time."""
    return np.array([y[1], (1.0 - y[0] ** 2) * y[1] - y[0] + np.sin(y[2]), 1.0])


JACOBIANS = {
    "exact": lambda y: np.array(
        [[0.0, 1.0, 0.0], [-2.0 * y[0] * y[1] - 1.0, 1.0 - y[0] ** 2, np.cos(y[2])], [0.0, 0.0, 0.0]]
    ),
    "wrong": lambda y: np.array([[0.0, 1.0, 0.0], [-2.0, -0.7, 0.2], [0.1, 0.0, 0.0]]),
    "none": lambda y: np.zeros((3, 3)),
}


@pytest.mark.full("more cases", but="exact")
@pytest.mark.parametrize("kind", JACOBIANS)
def test_order_is_nine_with_any_jacobian(kind):
    start = np.array([1.0, 0.5, 0.0])
    exact = solve_ivp(lambda _, y: oscillator(y), (0, 2), start, method="DOP853", rtol=1e-13, atol=1e-15)
    _, step = problem(oscillator, JACOBIANS[kind])
    errors = [np.abs(integrate(step, start, 2.0, n) - exact.y[:, -1]).max() for n in (5, 7, 10)]
    slope = np.log(errors[0] / errors[-1]) / np.log(2.0)
    assert slope == pytest.approx(ORDER, abs=0.7)


@pytest.mark.parametrize("kind", JACOBIANS)
def test_error_estimates_have_orders_five_and_six_and_combine_to_seven(kind, estimated):
    """f is interpolated by five values in E, with an error of h⁵, and by four in E′; both are times h."""
    _, step = problem(oscillator, JACOBIANS[kind])
    error_of, sizes, errors_of_sizes = estimated(oscillator, JACOBIANS[kind]), (0.05, 0.025, 0.0125), []
    for h in sizes:
        d = record(np.array([1.5, -1.0, 0.3]), 1.0)
        step(d, h)
        error = error_of(d, h)
        errors_of_sizes.append([*np.abs(d.implicit.right_hand_sides[:2]).max(1), error])
    slopes = np.diff(np.log(errors_of_sizes), axis=0) / np.diff(np.log(sizes))[:, None]
    expected = [RADAU_STAGES + 1, RADAU_STAGES, step_control.ERROR_ORDER[IMPLICIT]]
    np.testing.assert_allclose(slopes, [expected] * 2, rtol=0, atol=0.15)


def test_a_linear_problem_is_solved_in_two_iterations():
    matrix = np.array([[-2.0, 1.0], [0.5, -3.0]])
    step, _ = problem(lambda y: matrix @ y, lambda y: matrix)
    start = np.array([1.0, -2.0])
    d = record(start)
    assert step(d, 0.3)
    assert d.implicit.iterations == 2
    # Z = 1 ⊗ y + (Q ⊗ h A) Z
    stages = np.linalg.solve(
        np.eye(2 * RADAU_STAGES) - np.kron(radau.Q, 0.3 * matrix),
        np.kron(np.ones(RADAU_STAGES), start),
    )
    np.testing.assert_allclose(start + d.implicit.stages, stages.reshape(RADAU_STAGES, 2), rtol=1e-13)


def decay(y):
    """Return the rate y' = −λ y; y[1] is λ."""
    return np.array([-y[1] * y[0], 0.0])


@pytest.mark.parametrize("rate", [1e3, 1e6, 1e9, 1e12])
def test_infinitely_stiff_component_is_damped_at_once(rate):
    step, _ = problem(decay, lambda y: np.array([[-y[1], 0.0], [0.0, 0.0]]))
    d = record(np.array([1.0, rate]), 1e9)
    assert step(d, 1.0)
    # L-stable: R(∞) = 0, approached as 1/z
    assert abs(1.0 + d.implicit.stages[-1, 0]) < max(10.0 / rate, 1e-9)


def test_an_iteration_without_convergence_is_given_up():
    """Without a Jacobian, h λ = 100 makes the corrections grow."""
    step, _ = problem(decay, lambda y: np.zeros((2, 2)))
    d = record(np.array([1.0, 1e2]))
    assert not step(d, 1.0)
    assert d.implicit.iterations < radau.MOST_ITERATIONS
    assert d.implicit.convergence_rate > 1.0
    step, _ = problem(lambda y: np.array([np.nan, 0.0]), lambda y: np.zeros((2, 2)))
    assert not step(record(np.array([1.0, 1.0])), 1.0)
