"""The dense output of a step: its polynomial, bounds on its slopes, and the moments that belong to times."""

import math

import numpy as np
import pytest

from chain_impact.kernel.chain.state import sundman_u_at, time_at
from chain_impact.kernel.integration.dense import (
    BASIS_BOUND,
    DENSE_COEFFICIENTS,
    FAST,
    SLOPE_BOUND,
    TRIES,
    fraction,
    interpolate,
    interpolate_component,
    next_guess,
    rate_bounds,
    rate_bounds_along,
    regularized_fraction,
    time_rate,
)
from tests.kernel.chains import chain
from tests.kernel.steps import POWERS

LINKS = 2
ROOT, CLOCK = sundman_u_at(LINKS), time_at(LINKS)
TIMES = np.linspace(0.0, 1.0, 2001)


@pytest.fixture
def d():
    """A chain with a step whose coefficients are all different."""
    rng = np.random.default_rng(23)
    _, d = chain(rng, LINKS)
    d.step.state[:], d.step.dense[:] = (
        rng.uniform(-1.0, 1.0, d.step.state.shape),
        rng.uniform(-1.0, 1.0, d.step.dense.shape),
    )
    d.step.size, d.step.start, d.step.regularized = 0.25, 3.0, -1
    return d


def basis(theta):
    return np.array([theta**p * (1.0 - theta) ** q for p, q in POWERS])


@pytest.mark.parametrize("theta", [0.0, 0.3, 0.8, 1.0])
def test_a_state_is_that_of_the_polynomial(d, theta):
    y, right = np.zeros(len(d.step.state)), d.step.state + basis(theta) @ d.step.dense
    interpolate(d.step, theta, y)
    assert y == pytest.approx(right, abs=1e-14)
    assert interpolate_component(d.step, theta, 3) == y[3]


def slopes():
    return np.gradient(basis(TIMES).T, TIMES, axis=0)


def test_the_bounds_of_the_basis_are_sharp():
    assert len(POWERS) == DENSE_COEFFICIENTS
    assert np.abs(basis(TIMES)).max(axis=1) == pytest.approx(BASIS_BOUND, rel=1e-4)
    assert np.abs(slopes()).max(axis=0) == pytest.approx(SLOPE_BOUND, rel=5e-3)


@pytest.mark.parametrize("j", [0, 4, 9])
def test_a_component_and_its_rate_stay_within_their_bounds(d, j):
    value, slope = rate_bounds(d.step, j)
    for m in range(DENSE_COEFFICIENTS):
        one = d.step.dense[:, j].copy()
        d.step.dense[:, j] = 0.0
        d.step.dense[m, j] = one[m]
        alone = rate_bounds(d.step, j)
        # what one coefficient adds is sharp
        assert alone[0] - abs(d.step.state[j]) == pytest.approx(abs(one[m]) * BASIS_BOUND[m], rel=1e-12)
        assert alone[1] == pytest.approx(abs(one[m]) * SLOPE_BOUND[m] / 0.25, rel=1e-12)
        d.step.dense[:, j] = one
    values = d.step.state[j] + basis(TIMES).T @ d.step.dense[:, j]
    assert value >= np.abs(values).max()
    assert slope >= np.abs(slopes() @ d.step.dense[:, j]).max() / 0.25
    sizes = np.abs(d.step.dense[:, j])
    assert value == pytest.approx(abs(d.step.state[j]) + BASIS_BOUND @ sizes, rel=1e-12)
    assert slope == pytest.approx(SLOPE_BOUND @ sizes / 0.25, rel=1e-12)


def test_those_along_a_direction_are_those_of_a_turned_vector(d):
    nx, ny, j = 0.6, -0.8, 4
    turned_value, turned = (
        nx * d.step.state[j] + ny * d.step.state[j + 1],
        nx * d.step.dense[:, j] + ny * d.step.dense[:, j + 1],
    )
    found = rate_bounds_along(d.step, j, nx, ny)
    d.step.state[j], d.step.dense[:, j] = turned_value, turned
    assert found == pytest.approx(rate_bounds(d.step, j), rel=1e-12)


def test_without_a_contact_of_its_own_a_step_is_even_in_time(d):
    assert fraction(d, 3.1) == pytest.approx(0.4)


def falling(d, start, end, lasts=1.0):
    """Let u go evenly from ``start`` to ``end``, and time as ∫u, over a step of the size 1."""
    d.step.size, d.step.regularized = lasts, 0
    d.step.state[[ROOT, CLOCK]] = start, 0.0
    d.step.dense[:, [ROOT, CLOCK]] = 0.0
    d.step.dense[0, ROOT] = end - start
    # u₀θ + (u₁−u₀)θ²/2 = θ (u₀+u₁)/2 + θ(1−θ) (u₀−u₁)/2
    d.step.dense[0, CLOCK], d.step.dense[1, CLOCK] = 0.5 * lasts * (start + end), 0.5 * lasts * (start - end)
    return lambda theta: lasts * (start * theta + 0.5 * (end - start) * theta**2)


@pytest.mark.parametrize(("start", "end"), [(0.0, 0.3), (0.3, 0.0), (0.3, 0.2), (0.02, 0.3)])
@pytest.mark.parametrize("theta", [1e-6, 0.1, 0.5, 0.9, 1.0])
def test_a_moment_of_a_step_in_another_variable_is_found(d, start, end, theta):
    time = falling(d, start, end)
    found = regularized_fraction(d, time(theta))
    assert time(found) == pytest.approx(time(theta), rel=1e-12)
    assert found == pytest.approx(theta, rel=1e-6 if end else 1e-4)
    assert fraction(d, 3.0 + time(theta)) == pytest.approx(found, abs=1e-7)


@pytest.mark.parametrize("theta", [0.05, 0.3, 0.59])
def test_of_two_moments_the_one_before_time_runs_back_is_it(d, theta):
    time = falling(d, 0.3, -0.2)  # back from θ = 0.6 on
    assert regularized_fraction(d, time(theta)) == pytest.approx(theta, rel=1e-6)
    # also where more time has passed there than at the end of the step
    assert time(theta) > time(1.0) or theta < 0.1


def test_what_comes_after_the_step_is_its_end(d):
    time = falling(d, 0.1, 0.3)
    assert regularized_fraction(d, time(1.0)) == 1.0
    assert regularized_fraction(d, 2.0 * time(1.0)) == 1.0
    # where time runs back it is the latest moment
    time = falling(d, 0.3, -0.2)
    assert regularized_fraction(d, 2.0 * time(0.6)) == pytest.approx(0.6, rel=1e-3)


def test_time_passes_fastest_where_u_is_one():
    assert time_rate(1.0) == 0.5
    assert time_rate(0.5) == time_rate(2.0) == 0.4
    assert time_rate(-0.5) == -0.4


# --- a bracket shrinks to round-off whatever the guesses are ------------------------------------------------


def test_a_guess_inside_is_taken_while_the_method_may_be_fast():
    assert next_guess(0.2, 0.6, 0.3, 0) == next_guess(0.2, 0.6, 0.3, FAST - 1) == 0.3
    for guess in (0.2, 0.6, 0.1, 0.7, math.nan, math.inf):
        assert next_guess(0.2, 0.6, guess, 0) == pytest.approx(0.4)
    assert next_guess(0.2, 0.6, 0.3, FAST) == pytest.approx(0.4)


@pytest.mark.parametrize("root", [1e-18, 1e-9, 0.3, 1.0 - 1e-16])
@pytest.mark.parametrize("creep", [1e-12, 1e-3])
def test_guesses_that_creep_towards_a_root_end_at_it(root, creep):
    low, high = 0.0, 1.0
    for tries in range(TRIES):
        guess = next_guess(low, high, low + creep * (high - low), tries)
        low, high = (guess, high) if guess < root else (low, guess)
    assert high - low <= max(2e-16 * root, 1e-19)
