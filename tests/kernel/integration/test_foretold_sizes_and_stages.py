"""What a collocation step begins with, its size and its stages, and what it says when it is not solved."""

import math

import numpy as np
import pytest

from chain_impact.kernel.chain.state import omega_at, velocity_at
from chain_impact.kernel.integration import collocation, control
from chain_impact.kernel.integration.collocation import (
    BEYOND,
    DIVERGED,
    FADED,
    FORETOLD,
    LATE,
    LEFT,
    attempt,
    extrapolate_stages,
    prepare,
    toward_end,
)
from chain_impact.kernel.integration.control import accepted
from chain_impact.kernel.integration.extended import extended_size, gap_at, rate_at
from chain_impact.kernel.integration.method import EXPLICIT, IMPLICIT, ORDER
from chain_impact.kernel.integration.newton import UNKNOWN
from chain_impact.kernel.integration.radau import NODES, REAL_EIGENVALUE, STAGES
from chain_impact.kernel.model.equations import state_rate
from tests.kernel.chains import chain, struck, touch
from tests.reference import mass_matrix

N = 3
STALE = -1  # of implicit.listing: other contacts are active


def at_start(tolerance=1e-8, **tables):
    """A chain that moves, at the start of an implicit step."""
    rng = np.random.default_rng(5)
    scene, d = chain(rng, N, **tables)
    d.step.state_end[:] = struck(rng, d, [])
    d.step.method, d.solver.tolerance = IMPLICIT, tolerance
    state_rate(d, d.step.state_end, d.work.rate_start)
    return scene, d


# --- the size ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("gap", "gap_rate", "size"),
    [
        (-0.5, 1.0, 0.5 * BEYOND),  # s, in which it leaves
        (-0.99, 1.0, 1.0),  # in this step, but not so long before its end
        (-2.0, 1.0, 1.0),
        (-0.5, -1.0, 1.0),  # it goes in
        (-0.9 * LEFT, 1.0, 1.0),  # it has all but left
        (-1.1 * LEFT, 1.0, 1.1 * LEFT * BEYOND),
        (0.1, 1.0, 1.0),
    ],
)
def test_a_step_goes_a_little_beyond_the_end_of_a_contact(gap, gap_rate, size):
    _, d = chain(np.random.default_rng(0), N)
    touch(d, [1, 6])
    d.implicit.start[gap_at(d, 0)], d.implicit.start[rate_at(d, 0)] = gap, gap_rate
    d.implicit.start[gap_at(d, 1)], d.implicit.start[rate_at(d, 1)] = -1.0, -1.0
    assert toward_end(d, 1.0) == pytest.approx(size, rel=1e-14)


def test_the_first_of_two_ends_counts():
    _, d = chain(np.random.default_rng(0), N)
    for gaps in ((-0.5, -0.3), (-0.3, -0.5)):
        touch(d, [1, 6])
        for k in range(2):
            d.implicit.start[gap_at(d, k)], d.implicit.start[rate_at(d, k)] = gaps[k], 1.0
        assert toward_end(d, 1.0) == pytest.approx(0.3 * BEYOND, rel=1e-14)


def stiff_joint(damping, tolerance=1e-8):
    """A chain with one damper; the rate with which it decays, and how fast it does [units of the tolerance].

    ∂v̇/∂v = −d M⁻¹ g gᵀ has the one eigenvalue ρ = d gᵀ M⁻¹ g, and M⁻¹ g is its vector.
    """
    scene, d = at_start(tolerance)
    d.model.joint_damping[:] = 0.0, damping, 0.0
    d.model.resisting, d.implicit.listing = 1, STALE
    state_rate(d, d.step.state_end, d.work.rate_start)
    across = np.zeros(N + 2)
    across[2:4] = -1.0, 1.0
    vector = np.linalg.solve(mass_matrix(scene, d.step.state_end[2 : N + 2]), across)
    rho = damping * across @ vector
    fast = vector * (across @ d.work.rate_start[velocity_at(N) : 2 * N + 4]) / (across @ vector)
    speeds = d.step.state_end[velocity_at(N) : 2 * N + 4]
    scale = np.where(np.arange(N + 2) < 2, d.model.size, 1.0) + np.abs(speeds)
    return d, rho, (np.abs(fast) / scale).max() / tolerance


@pytest.mark.parametrize("h", [1e-2, 1.0])
@pytest.mark.parametrize("damping", [1e3, 1e6])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-8])
def test_the_first_step_is_some_time_constants_of_a_fast_motion(tolerance, damping, h):
    """FADED of them at an amplitude of the tolerance, and less as the error of a step goes."""
    d, rho, fast = stiff_joint(damping, tolerance)
    taken = 1.0 - 1.0 / (1.0 + rho * h * REAL_EIGENVALUE)  # by one solution with the real shift
    expected = FADED / rho * (rho / (taken * fast)) ** (1.0 / (ORDER[IMPLICIT] - 1))
    assert prepare(d, h) == pytest.approx(expected, rel=1e-6)
    attempt(d, expected)
    assert accepted(d)


def test_a_first_step_that_meets_no_fast_motion_is_as_long_as_it_may_be():
    d, rho, _ = stiff_joint(1e3)
    assert prepare(d, 0.9 / rho) == 0.9 / rho
    assert prepare(d, 0.1) < 0.05
    d.solver.tolerance = 1e6  # does not see it
    assert prepare(d, 0.1) == 0.1
    d.solver.tolerance = 1e-8
    d.step.state_end[omega_at(N) : omega_at(N) + N] = 1.0  # as one body
    state_rate(d, d.step.state_end, d.work.rate_start)
    d.work.rate_start[velocity_at(N) :] = 0.0
    assert prepare(d, 0.1) == 0.1
    d, _, _ = stiff_joint(0.0)
    assert prepare(d, 0.1) == 0.1


def test_a_step_after_an_implicit_one_is_as_long_as_its_error_allows():
    d, _, _ = stiff_joint(1e3)
    d.implicit.slowness = 0.3
    d.implicit.listing, d.step.last_method = d.touch.listings, IMPLICIT
    assert prepare(d, 0.1) == 0.1
    assert d.implicit.slowness == 0.3
    for listing, made_by in ((STALE, IMPLICIT), (d.touch.listings, EXPLICIT)):
        d.implicit.listing, d.step.last_method, d.implicit.slowness = listing, made_by, 0.3
        assert prepare(d, 0.1) < 0.05
        assert d.implicit.slowness == UNKNOWN


# --- the stages --------------------------------------------------------------------------------------------


def last_polynomial(d, degree, end=1.0):
    """Let the last step, of 0.2 s, have followed a polynomial of θ with this degree, up to some θ."""
    rng, size = np.random.default_rng(degree), extended_size(d)
    parts = np.zeros((degree + 1, size))
    parts[1:] = rng.uniform(0.5, 1.0, (degree, size))
    polynomial = np.polynomial.Polynomial
    columns = [polynomial(column) for column in parts.T]
    for i, node in enumerate(NODES):
        d.implicit.last[i, :size] = [column(node) for column in columns]
    own = d.implicit
    own.began, own.span, own.listing = 3.0, 0.2, d.touch.listings
    d.step.end, d.step.last_method = 3.0 + 0.2 * end, IMPLICIT
    return columns


@pytest.mark.parametrize("end", [1.0, 0.4])
@pytest.mark.parametrize(("branch", "degree"), [(0, 5), (1, 4), (2, 3), (3, 1)])
def test_stages_far_beyond_the_last_step_follow_a_polynomial_of_lower_degree(branch, degree, end):
    """One that is the last one's if that is of no higher degree."""
    bounds = (0.0, *FORETOLD, 9.0)
    # as far beyond as the branch reaches, and a little further than the one before does
    for beyond in (bounds[branch] + 1e-6, min(bounds[branch + 1], 8.0) - 1e-6):
        d = at_start()[1]
        size, h = extended_size(d), 0.2 * (1.0 + beyond - end)
        columns = last_polynomial(d, degree, end)
        extrapolate_stages(d, h, size)
        at = end + h / 0.2 * np.array(NODES)
        expected = np.transpose([column(at) - column(end) for column in columns])
        np.testing.assert_allclose(d.implicit.stages[:, :size], expected, rtol=1e-9, atol=1e-13)
        if degree < STAGES:
            columns = last_polynomial(d, degree + 1, end)
            extrapolate_stages(d, h, size)
            expected = np.transpose([column(at) - column(end) for column in columns])
            assert (np.abs(d.implicit.stages[-1, :size] / expected[-1] - 1.0) > 1e-3).all()


def test_the_stages_of_a_first_step_go_with_the_rate_at_its_start():
    d = at_start()[1]
    touch(d, [1, 6])
    own, size, half = d.implicit, extended_size(d), velocity_at(N)
    own.start_rate[:] = np.random.default_rng(0).normal(size=len(own.start_rate))
    own.stages[:], own.listing = 9.0, STALE
    extrapolate_stages(d, 0.3, size)
    expected = 0.3 * np.outer(NODES, own.start_rate[:size])
    moving = np.zeros(size, bool)
    moving[:half] = moving[[gap_at(d, 0), gap_at(d, 1)]] = True
    np.testing.assert_allclose(own.stages[:, :size], np.where(moving, expected, 0.0), rtol=1e-14)


# --- what is not solved ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("contraction", "correction", "error", "share"),
    [(0.97, 1.0, LATE, 1 / 2), (1.3, 1.0, DIVERGED, 1 / 3), (1.3, math.inf, math.inf, None)],
)
def test_a_step_that_is_not_solved_says_how_much_shorter_the_next_try_is(
    monkeypatch, contraction, correction, error, share
):
    d = at_start()[1]
    prepare(d, 0.01)
    attempt(d, 0.01)
    assert accepted(d)
    assert d.implicit.slowness < UNKNOWN

    def unsolved(d, _h, _size):
        own = d.implicit
        own.contraction, own.correction, own.iterations = contraction, correction, 4
        return False

    monkeypatch.setattr(collocation, "_converge", unsolved)
    before = d.statistics.rhs_evaluations
    attempt(d, 0.01)
    assert d.trial.error == error
    assert d.implicit.slowness == UNKNOWN
    assert d.trial.cost_factor == 1.0
    assert d.statistics.rhs_evaluations == before + 4 * STAGES
    if share:
        assert control.factor(d) == pytest.approx(share, rel=0.02)


def test_the_iteration_of_a_step_that_is_far_too_long_diverges():
    d = at_start()[1]
    errors = []
    for h in np.geomspace(0.01, 10.0, 25):
        d.implicit.listing = STALE
        prepare(d, h)
        attempt(d, h)
        errors.append(float(d.trial.error))
    assert errors[0] <= 1.0
    assert LATE in errors
    assert DIVERGED in errors
    assert not any(error <= 1.0 for error in errors[errors.index(DIVERGED) :])


# --- what it costs and what it errs -------------------------------------------------------------------------


def test_the_measure_of_a_fast_motion_counts_as_three_evaluations():
    d, _, _ = stiff_joint(1e3)
    before = d.limits.other_work
    prepare(d, 0.1)
    assert d.limits.other_work == before + 3
    d.implicit.listing, d.step.last_method = d.touch.listings, IMPLICIT
    prepare(d, 0.1)
    assert d.limits.other_work == before + 3


def test_a_step_that_is_solved_counts_its_systems_and_gives_its_error(monkeypatch):
    d, _, _ = stiff_joint(1e3)
    h = prepare(d, 1e-3)
    before, evaluations = d.limits.other_work, d.statistics.rhs_evaluations
    monkeypatch.setattr(collocation, "estimate", lambda *_: 0.25)
    attempt(d, h)
    assert d.trial.error == 0.25
    iterations = d.implicit.iterations
    assert d.limits.other_work - before == 6 + 4 * iterations + 3
    assert d.statistics.rhs_evaluations - evaluations == STAGES * iterations
    monkeypatch.setattr(collocation, "estimate", lambda *_: math.nan)
    d.implicit.slowness = 0.5
    attempt(d, h)
    assert not accepted(d)
    assert d.implicit.slowness == UNKNOWN


@pytest.mark.parametrize("part", [0, 1])
def test_an_error_that_is_not_finite_is_infinite(part):
    d, _, _ = stiff_joint(1e3)
    attempt(d, prepare(d, 1e-3))
    size = extended_size(d)
    assert math.isfinite(collocation.estimate(d, 1e-3, size))
    d.implicit.start_rate[0] = math.nan if part else math.inf
    assert collocation.estimate(d, 1e-3, size) == math.inf


def test_the_error_with_a_held_point_is_worked_out_once_more(monkeypatch):
    d, _, _ = stiff_joint(1e3)
    attempt(d, prepare(d, 1e-3))
    size, before = extended_size(d), d.limits.other_work
    free = collocation.estimate(d, 1e-3, size)
    assert d.limits.other_work == before
    monkeypatch.setattr(collocation, "any_constraint", lambda _: True)
    solve, solved = collocation.solve_real, []

    def note(d, shift, x):
        given = x.tolist()
        solve(d, shift, x)
        solved.append((shift, given, x.tolist()))

    monkeypatch.setattr(collocation, "solve_real", note)
    monkeypatch.setattr(collocation, "moment_error", lambda d, row: (1e3 + row) * d.solver.tolerance)
    # e₁ min(1, e₁/e₂), with the moments in place of the other errors
    assert collocation.estimate(d, 1e-3, size) == pytest.approx(1e3 * 1e3 / 1001.0, rel=1e-9)
    assert d.limits.other_work == before + 1
    assert free < 1e3
    # the error of the start once more
    assert [shift for shift, *_ in solved] == [1e-3 * REAL_EIGENVALUE] * 3
    assert solved[2][1] == solved[0][2]
