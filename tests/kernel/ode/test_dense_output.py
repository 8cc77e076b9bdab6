"""The dense output of a step: its polynomial, bounds on its slopes, and the places θ of times."""

# Tests: kernel/mathematics/root_search.py

import math

import numpy as np
import pytest

from chain_impact.kernel.forces import user_law
from chain_impact.kernel.mathematics import root_search
from chain_impact.kernel.ode import dense_output, sundman_rate
from chain_impact.kernel.record.constants import DENSE_COEFFICIENTS
from chain_impact.kernel.record.state import dissipated_at, sundman_u_at, time_at
from tests.kernel.chains import chain
from tests.kernel.steps import POWERS, basis

LINKS = 2
ROOT, CLOCK = sundman_u_at(LINKS), time_at(LINKS)
TIMES = np.linspace(0.0, 1.0, 2001)


@pytest.fixture
def d():
    """Return a chain with a step whose coefficients are all different."""
    rng = np.random.default_rng(23)
    _, d = chain(rng, LINKS)
    for part in (d.step.state, d.step.dense):
        part[:] = rng.uniform(-1.0, 1.0, part.shape)
    d.step.size, d.step.start, d.step.regularized_candidate = 0.25, 3.0, -1
    return d


@pytest.mark.parametrize("theta", [0.0, 0.3, 0.8, 1.0])
def test_a_state_is_that_of_the_polynomial(d, theta):
    y, expected = np.zeros(len(d.step.state)), d.step.state + basis(theta) @ d.step.dense
    dense_output.interpolate_state(d.step, theta, y)
    assert y == pytest.approx(expected, abs=1e-14)
    assert dense_output.interpolate_component(d.step, theta, 3) == y[3]


@pytest.mark.parametrize("theta", [0.0, 0.3, 0.8, 1.0])
def test_the_slope_of_the_interpolant_is_the_derivative_of_the_polynomial(d, theta):
    step = 1e-6
    difference = (basis(theta + step) - basis(theta - step)) / (2.0 * step) @ d.step.dense[:, 3]
    assert dense_output.slope_of_interpolant(theta, *d.step.dense[:, 3]) == pytest.approx(
        difference, abs=1e-9
    )


@pytest.mark.parametrize(("end", "lowest", "highest"), [(0.3, 0.0, 0.3), (-0.2, -0.2, 0.0)])
def test_the_dissipated_energy_lies_between_those_of_both_ends(d, monkeypatch, end, lowest, highest):
    """A tenth of the tolerance is allowed. A user's law may supply energy: its energy is the polynomial's."""
    j = dissipated_at(LINKS)
    d.step.state[j], d.step.state_end[j] = 0.0, end
    d.step.dense[:, j] = [end, 4.0, -8.0, 0.0, 0.0, 0.0, 0.0]
    states = [d.step.state + weights @ d.step.dense for weights in basis(TIMES).T]
    polynomial = [y[j] for y in states]
    slack = 0.1 * d.solver.tolerance * (d.chain.energy_scale + abs(end))
    assert 0.0 < slack < 1e-4
    assert min(polynomial) < lowest - slack
    assert max(polynomial) > highest + slack
    result = [dense_output.dissipated_energy(d, y) for y in states]
    assert result == pytest.approx(np.clip(polynomial, lowest - slack, highest + slack), abs=1e-15)
    monkeypatch.setattr(user_law, "has_user_law", lambda: True)
    assert [dense_output.dissipated_energy(d, y) for y in states] == polynomial


def test_a_dissipated_energy_falls_by_a_tenth_of_the_tolerance_at_most(d, monkeypatch):
    """A user's law may supply energy, so there the energy may fall."""
    slack = 0.1 * d.solver.tolerance * (d.chain.energy_scale + 2.0)
    assert slack > 0.0
    for end, expected in [(2.0 - 0.9 * slack, 2.0 - 0.9 * slack), (2.0 - 1.1 * slack, 2.0), (2.5, 2.5)]:
        assert dense_output.without_fall(d, 2.0, end) == expected
    monkeypatch.setattr(user_law, "has_user_law", lambda: True)
    assert dense_output.without_fall(d, 2.0, 1.0) == 1.0


def test_the_bounds_of_the_basis_are_sharp():
    assert len(POWERS) == DENSE_COEFFICIENTS
    slopes = np.gradient(basis(TIMES), TIMES, axis=1)
    assert np.abs(basis(TIMES)).max(axis=1) == pytest.approx(dense_output.BASIS_BOUND, rel=1e-4)
    assert np.abs(slopes).max(axis=1) == pytest.approx(dense_output.SLOPE_BOUND, rel=5e-3)


@pytest.mark.parametrize("j", [0, 4, 9])
def test_a_component_and_its_rate_stay_within_their_bounds(d, j):
    """The bounds along a direction are those of the rotated vector."""
    value, slope = dense_output.rate_bounds(d.step, j)
    state, parts = d.step.state[j], d.step.dense[:, j].copy()
    assert value >= np.abs(state + basis(TIMES).T @ parts).max()
    assert slope >= np.abs(np.gradient(basis(TIMES).T, TIMES, axis=0) @ parts).max() / 0.25
    assert value == pytest.approx(abs(state) + dense_output.BASIS_BOUND @ np.abs(parts), rel=1e-12)
    assert slope == pytest.approx(dense_output.SLOPE_BOUND @ np.abs(parts) / 0.25, rel=1e-12)
    if j == 4:
        result = dense_output.rate_bounds_along(d.step, j, 0.6, -0.8)
        d.step.state[j] = 0.6 * state - 0.8 * d.step.state[j + 1]
        d.step.dense[:, j] = 0.6 * parts - 0.8 * d.step.dense[:, j + 1]
        assert result == pytest.approx(dense_output.rate_bounds(d.step, j), rel=1e-12)


def falling(d, start, end, lasts=1.0):
    """Let u vary linearly from ``start`` to ``end``, and time be ∫u, over a step of size ``lasts``.

    Return the time since the start of the step as a function of θ.
    """
    d.step.size, d.step.regularized_candidate = lasts, 0
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
    result = dense_output.regularized_fraction(d, time(theta))
    assert time(result) == pytest.approx(time(theta), rel=1e-12)
    assert result == pytest.approx(theta, rel=1e-6 if end else 1e-4)
    assert dense_output.fraction_at_time(d, 3.0 + time(theta)) == pytest.approx(result, abs=1e-7)


def test_the_first_of_two_times_on_the_dense_output_is_taken(d):
    time = falling(d, 0.3, -0.2)  # back from θ = 0.6 on
    for theta in (0.05, 0.3, 0.59):
        assert dense_output.regularized_fraction(d, time(theta)) == pytest.approx(theta, rel=1e-6)
        # the time within the step may exceed the time at the end of the step
        assert time(theta) > time(1.0) or theta < 0.1
    assert dense_output.regularized_fraction(d, 2.0 * time(0.6)) == pytest.approx(0.6, rel=1e-3)
    time = falling(d, 0.1, 0.3)
    assert (
        dense_output.regularized_fraction(d, time(1.0))
        == dense_output.regularized_fraction(d, 2.0 * time(1.0))
        == 1.0
    )
    # a step without its own contact is uniform in time
    d.step.regularized_candidate, d.step.size = -1, 0.25
    assert dense_output.fraction_at_time(d, 3.1) == pytest.approx(0.4)


def test_time_passes_fastest_where_u_is_one():
    assert sundman_rate.regularized_time_rate(1.0) == 0.5
    assert sundman_rate.regularized_time_rate(0.5) == sundman_rate.regularized_time_rate(2.0) == 0.4
    assert sundman_rate.regularized_time_rate(-0.5) == -0.4


def test_a_guess_inside_is_taken_while_the_method_may_be_fast():
    assert (
        root_search.next_guess(0.2, 0.6, 0.3, 0)
        == root_search.next_guess(0.2, 0.6, 0.3, root_search.FAST_GUESSES - 1)
        == 0.3
    )
    for guess in (0.2, 0.6, 0.1, 0.7, math.nan, math.inf):
        assert root_search.next_guess(0.2, 0.6, guess, 0) == pytest.approx(0.4)
    assert root_search.next_guess(0.2, 0.6, 0.3, root_search.FAST_GUESSES) == pytest.approx(0.4)


@pytest.mark.parametrize("root", [1e-18, 1e-9, 0.3, 1.0 - 1e-16])
@pytest.mark.parametrize("creep", [1e-12, 1e-3])
def test_guesses_that_creep_towards_a_root_end_at_it(root, creep):
    low, high = 0.0, 1.0
    for tries in range(root_search.MOST_GUESSES):
        guess = root_search.next_guess(low, high, low + creep * (high - low), tries)
        low, high = (guess, high) if guess < root else (low, guess)
    assert high - low <= max(2e-16 * root, 1e-19)
