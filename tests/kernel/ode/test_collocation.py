"""The implicit step: comparison with another integrator, order, cost, and its first stages."""

import math

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.kernel import equations
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.constraints import geometry
from chain_impact.kernel.events.event_exclusion import known_clearances
from chain_impact.kernel.ode import collocation, dense_output, methods, step_control
from chain_impact.kernel.ode.extended_state import clearance_at, extended_length, rate_at
from chain_impact.kernel.ode.radau import RADAU_NODES, REAL_EIGENVALUE
from chain_impact.kernel.ode.step_control import ERROR_ORDER
from chain_impact.kernel.record.constants import (
    DIVERGED,
    EXPLICIT,
    IMPLICIT,
    INFINITE,
    NEWTON_SLOW,
    NOTHING_KNOWN,
    RADAU_STAGES,
)
from chain_impact.kernel.record.state import omega_at, sundman_u_at, velocity_at
from chain_impact.scene.scene import with_values
from chain_impact.simulation.instance import Instance
from tests.helpers.kernel.plain import Plain
from tests.helpers.models.reference import mass_matrix
from tests.kernel.chains import chain, locate_touching_state, mark_touching
from tests.kernel.ode.stiff_problems import PROBLEMS, exact, swinging, tipping
from tests.kernel.ode.touching import touching


def reached(result):
    """Return base position, angles and their rates at the end."""
    end = result.outputs[-1]
    motion = end["point_position"][0], end["angle"], end["point_velocity"][0], end["angular_velocity"]
    return np.concatenate(motion)


@pytest.mark.parametrize("method", ["implicit", "auto"])
@pytest.mark.parametrize("name", PROBLEMS)
def test_stiff_problems_are_solved_to_the_tolerance(name, method):
    for tolerance in (1e-4, 1e-6, 1e-8):
        result = simulate(PROBLEMS[name](), tolerance=tolerance, method=method)
        error = np.abs(reached(result) - exact(name)) / (1.0 + np.abs(exact(name)))
        assert error.max() < 2.0 * tolerance


@pytest.mark.parametrize(
    ("scene", "tolerance", "most"),
    [(swinging, 1e-8, 700), (tipping, 1e-8, 1800), (PROBLEMS["hanging"], 1e-8, 2500)],
)
def test_cost_of_a_tolerance(scene, tolerance, most):
    """The previous method of order 3 needed 3,000, 17,000 and 12,000 evaluations."""
    assert simulate(scene(), tolerance=tolerance, method="implicit").statistics["rhs_evaluations"] < most


def test_the_dense_output_is_as_accurate_as_the_tolerance():
    times = np.linspace(0.0, 0.1, 301)[1:]
    rows = {}
    for tolerance in (1e-8, 1e-12):
        instance = Instance(with_values(tipping(), {("solver", "tolerance"): tolerance}))
        out = np.zeros(len(times), instance.record.dtype["output"])
        assert instance.trajectory(times, out) == len(times)
        rows[tolerance] = out
    bounds = {"angle": 1e-10, "point_position": 1e-10, "angular_velocity": 3e-8, "force": 3e-6}
    for field, most in bounds.items():
        assert np.abs(rows[1e-8][field] - rows[1e-12][field]).max() < most


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4, 1e-6])
def test_the_coordinates_keep_the_clearances_that_were_integrated(tolerance):
    """The tangential error ½h²ω²L would be many penetrations, at the ends and in between."""
    instance = touching(tolerance)
    d, errors, sizes = Plain(instance.record), {0.25: [], 0.5: [], 0.8: [], 1.0: []}, {}
    y = np.zeros(len(d.scratch.state))
    for time in np.arange(0.7, 1.2, 1e-3):
        instance.advance(time)
        if d.step.last_method != IMPLICIT or known_clearances(d) == NOTHING_KNOWN or d.step.start in sizes:
            continue
        sizes[d.step.start] = d.step.size
        for theta, gap_errors in errors.items():
            dense_output.interpolate_state(d.step, theta, y)
            locate_points(d, y)
            for k in range(int(d.contacts.active_count)):
                gap, _ = geometry.clearance_and_rate(d, int(d.contacts.active_index[k]))
                gap_errors.append(
                    abs(gap / collocation.extended_component(d, sundman_u_at(d.link_count) + k, theta) - 1.0)
                )
    assert max(sizes.values()) > 1e-3
    for gap_errors in errors.values():
        assert len(gap_errors) > 60
        assert np.quantile(gap_errors, 0.9) < 0.02
        assert np.quantile(gap_errors, 0.99) < 1.0


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4])
def test_a_restart_inside_an_implicit_step_does_not_kick(tolerance):
    """Values that are given again, although unchanged, restart the solver in the middle of implicit steps."""
    balance = []
    for restarts in (0, 20):
        instance = touching(tolerance)
        for time in np.linspace(0.9, 1.1, restarts + 1):
            instance.record["given"]["pending"] = restarts > 0
            instance.advance(time)
        instance.advance(1.2)
        output = instance.record["output"]
        instance.observe()
        balance.append(float(output["total"] + output["dissipated"]))
    assert balance[1] == pytest.approx(balance[0], abs=10.0 * tolerance)


# --- what a step begins with -------------------------------------------------------------------------------

N = 3
STALE = -1  # implicit.contact_set_of_step is outdated: other contacts are active


def at_start(tolerance=1e-8, **tables):
    """Return a chain that moves, at the start of an implicit step."""
    rng = np.random.default_rng(5)
    scene, d = chain(rng, N, **tables)
    d.step.state_end[:] = locate_touching_state(rng, d, [])
    d.step.method, d.solver.tolerance = IMPLICIT, tolerance
    equations.rate_from_state(d, d.step.state_end, d.scratch.rate_start)
    return scene, d


@pytest.mark.parametrize(
    ("gap", "gap_rate", "size"),
    [
        (-0.5, 1.0, 0.5 * collocation.END_OVERSHOOT),  # the contact ends after 0.5 s
        (-0.99, 1.0, 1.0),  # the contact ends so shortly before the end of the step that the size stays
        (-2.0, 1.0, 1.0),
        (-0.5, -1.0, 1.0),  # the point moves inward
        (-0.9 * collocation.FORCELESS_PART, 1.0, 1.0),  # the point has almost left
        (
            -1.1 * collocation.FORCELESS_PART,
            1.0,
            1.1 * collocation.FORCELESS_PART * collocation.END_OVERSHOOT,
        ),
        (0.1, 1.0, 1.0),
    ],
)
def test_a_step_goes_a_little_beyond_the_first_end_of_a_contact(gap, gap_rate, size):
    _, d = chain(np.random.default_rng(0), N)
    mark_touching(d, [1, 6])
    for first in (0, 1):
        for k, (at, rate) in enumerate([(gap, gap_rate), (-0.7, 0.9 if size < 1.0 else -1.0)]):
            d.implicit.z_start[clearance_at(d, k ^ first)] = at
            d.implicit.z_start[rate_at(d, k ^ first)] = rate
        assert collocation.size_toward_end(d, 1.0) == pytest.approx(size, rel=1e-14)


def stiff_joint(damping, tolerance=1e-8):
    """Return a chain with one damper, its decay rate, and its decay speed [units of the tolerance].

    ∂v̇/∂v = −d M⁻¹ g gᵀ has the one eigenvalue ρ = d gᵀ M⁻¹ g, and M⁻¹ g is its vector.
    """
    scene, d = at_start(tolerance)
    d.inputs.drive_damping[:-1] = 0.0, damping, 0.0
    d.chain.has_springs_or_dampers, d.implicit.contact_set_of_step = 1, STALE
    equations.rate_from_state(d, d.step.state_end, d.scratch.rate_start)
    across = np.zeros(N + 2)
    across[2:4] = -1.0, 1.0
    vector = np.linalg.solve(mass_matrix(scene, d.step.state_end[2 : N + 2]), across)
    rho = damping * across @ vector
    fast = vector * (across @ d.scratch.rate_start[velocity_at(N) : 2 * N + 4]) / (across @ vector)
    speeds = d.step.state_end[velocity_at(N) : 2 * N + 4]
    scale = np.where(np.arange(N + 2) < 2, d.chain.longest_link, 1.0) + np.abs(speeds)
    return d, rho, (np.abs(fast) / scale).max() / tolerance


@pytest.mark.parametrize("h", [1e-2, 1.0])
@pytest.mark.parametrize("damping", [1e3, 1e6])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-8])
def test_the_first_step_is_some_time_constants_of_a_fast_motion(tolerance, damping, h):
    """DECAY_TIMES time constants for an error of the tolerance, and fewer for a larger error of the step."""
    d, rho, fast = stiff_joint(damping, tolerance)
    damped_share = 1.0 - 1.0 / (
        1.0 + rho * h * REAL_EIGENVALUE
    )  # the result of one linear solution with the real shift
    expected = (
        collocation.DECAY_TIMES / rho * (rho / (damped_share * fast)) ** (1.0 / (ERROR_ORDER[IMPLICIT] - 1))
    )
    assert collocation.prepare_step(d, h) == pytest.approx(expected, rel=1e-6)
    collocation.integrate_trial(d, expected)
    assert step_control.is_accepted(d)


def test_a_first_step_that_meets_no_fast_motion_is_as_long_as_it_may_be():
    d, rho, _ = stiff_joint(1e3)
    assert collocation.prepare_step(d, 0.9 / rho) == 0.9 / rho
    assert collocation.prepare_step(d, 0.1) < 0.05
    d.solver.tolerance = 1e6  # the error of the fast motion is below the tolerance
    assert collocation.prepare_step(d, 0.1) == 0.1
    d.solver.tolerance = 1e-8
    d.step.state_end[omega_at(N) : omega_at(N) + N] = 1.0  # the chain turns as one body
    equations.rate_from_state(d, d.step.state_end, d.scratch.rate_start)
    d.scratch.rate_start[velocity_at(N) :] = 0.0
    assert collocation.prepare_step(d, 0.1) == 0.1
    d, _, _ = stiff_joint(0.0)
    assert collocation.prepare_step(d, 0.1) == 0.1


def test_a_step_after_an_implicit_one_is_as_long_as_its_error_allows():
    """The estimate of a fast motion counts as three evaluations."""
    d, _, _ = stiff_joint(1e3)
    own, listed = d.implicit, d.contacts.contact_set
    for listing, made_by, measured in ((listed, IMPLICIT, 0), (STALE, IMPLICIT, 3), (listed, EXPLICIT, 3)):
        own.contact_set_of_step, d.step.last_method, before = listing, made_by, d.budget.other_cost
        h = collocation.prepare_step(d, 0.1)
        assert h < 0.05 if measured else h == 0.1
        assert d.budget.other_cost == before + measured


# --- the stages --------------------------------------------------------------------------------------------


def last_polynomial(d, degree, end=1.0):
    """Let the last step, of 0.2 s, have a polynomial of this degree in θ, up to some θ."""
    own, size = d.implicit, extended_length(d)
    parts = np.zeros((degree + 1, size))
    parts[1:] = np.random.default_rng(degree).uniform(0.5, 1.0, (degree, size))
    columns = [np.polynomial.Polynomial(column) for column in parts.T]
    own.last_stages[:, :size] = np.transpose([column(np.array(RADAU_NODES)) for column in columns])
    own.contact_set_of_step, d.step.start, d.step.size = d.contacts.contact_set, 3.0, 0.2
    d.step.end, d.step.last_method = 3.0 + 0.2 * end, IMPLICIT
    return columns


@pytest.mark.parametrize("end", [1.0, 0.4])
@pytest.mark.parametrize(("branch", "degree"), [(0, 5), (1, 4), (2, 3), (3, 1)])
def test_far_stages_follow_a_polynomial_of_lower_degree(branch, degree, end):
    """The polynomial is the last step's own if its degree is not higher."""
    bounds = (0.0, *collocation.EXTRAPOLATED_LENGTHS, 9.0)
    # at the end of the branch, and slightly beyond the end of the previous branch
    for beyond in (bounds[branch] + 1e-6, min(bounds[branch + 1], 8.0) - 1e-6):
        d = at_start()[1]
        size, h = extended_length(d), 0.2 * (1.0 + beyond - end)
        columns = last_polynomial(d, degree, end)
        collocation.extrapolate_stages(d, h, size)
        at = end + h / 0.2 * np.array(RADAU_NODES)
        expected = np.transpose([column(at) - column(end) for column in columns])
        np.testing.assert_allclose(d.implicit.stages[:, :size], expected, rtol=1e-9, atol=1e-13)
        if degree < RADAU_STAGES:
            columns = last_polynomial(d, degree + 1, end)
            collocation.extrapolate_stages(d, h, size)
            expected = np.transpose([column(at) - column(end) for column in columns])
            assert (np.abs(d.implicit.stages[-1, :size] / expected[-1] - 1.0) > 1e-3).all()


def test_the_stages_of_a_first_step_go_with_the_rate_at_its_start():
    d = at_start()[1]
    mark_touching(d, [1, 6])
    own, size, half = d.implicit, extended_length(d), velocity_at(N)
    own.rate_start[:] = np.random.default_rng(0).normal(size=len(own.rate_start))
    own.stages[:], own.contact_set_of_step = 9.0, STALE
    collocation.extrapolate_stages(d, 0.3, size)
    expected = 0.3 * np.outer(RADAU_NODES, own.rate_start[:size])
    moving = np.zeros(size, bool)
    moving[:half] = moving[[clearance_at(d, 0), clearance_at(d, 1)]] = True
    np.testing.assert_allclose(own.stages[:, :size], np.where(moving, expected, 0.0), rtol=1e-14)


# --- what is not solved ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("contraction", "correction", "outcome", "share"),
    [
        (0.97, 1.0, NEWTON_SLOW, 1 / 2),
        (1.3, 1.0, DIVERGED, 1 / 3),
        (1.3, math.inf, INFINITE, None),
    ],
)
def test_a_step_that_is_not_solved_says_how_much_shorter_the_next_try_is(
    monkeypatch, contraction, correction, outcome, share
):
    d = at_start()[1]
    collocation.prepare_step(d, 0.01)
    collocation.integrate_trial(d, 0.01)
    assert step_control.is_accepted(d)

    def unsolved(d, _h, _size):
        own = d.implicit
        own.convergence_rate, own.relative_correction, own.iterations = contraction, correction, 4
        return False

    monkeypatch.setattr(collocation, "_converge", unsolved)
    before = d.statistics.rhs_evaluations
    methods.integrate_trial(d, 0.01)
    assert d.trial.outcome == outcome
    assert d.trial.cost_factor == 1.0
    assert d.statistics.rhs_evaluations == before + 4 * RADAU_STAGES
    if share:
        assert step_control.next_size_factor(d) == pytest.approx(share, rel=0.02)


# --- what it costs and what it errs -------------------------------------------------------------------------


def test_a_step_that_is_solved_counts_its_systems_and_gives_its_error(monkeypatch):
    d, _, _ = stiff_joint(1e3)
    h = collocation.prepare_step(d, 1e-3)
    before, evaluations = d.budget.other_cost, d.statistics.rhs_evaluations
    monkeypatch.setattr(collocation, "error_estimate", lambda *_: 0.25)
    collocation.integrate_trial(d, h)
    assert d.trial.error == 0.25
    iterations = d.implicit.iterations
    assert d.budget.other_cost - before == 6 + 4 * iterations + 3
    assert d.statistics.rhs_evaluations - evaluations == RADAU_STAGES * iterations
    monkeypatch.setattr(collocation, "error_estimate", lambda *_: math.nan)
    collocation.integrate_trial(d, h)
    assert not step_control.is_accepted(d)


@pytest.mark.parametrize("bad", [math.inf, math.nan])
def test_an_error_that_is_not_finite_is_infinite(bad):
    d, _, _ = stiff_joint(1e3)
    collocation.integrate_trial(d, collocation.prepare_step(d, 1e-3))
    assert math.isfinite(collocation.error_estimate(d, 1e-3, extended_length(d)))
    d.implicit.rate_start[0] = bad
    assert collocation.error_estimate(d, 1e-3, extended_length(d)) == math.inf


def test_the_error_with_a_held_point_is_worked_out_once_more(monkeypatch):
    d, _, _ = stiff_joint(1e3)
    collocation.integrate_trial(d, collocation.prepare_step(d, 1e-3))
    size, before = extended_length(d), d.budget.other_cost
    free = collocation.error_estimate(d, 1e-3, size)
    assert d.budget.other_cost == before
    monkeypatch.setattr(collocation, "any_constraint", lambda _: True)
    solve, solved = collocation.solve_real, []

    def note(d, shift, x):
        given = x.tolist()
        solve(d, shift, x)
        solved.append((shift, given, x.tolist()))

    monkeypatch.setattr(collocation, "solve_real", note)
    errors = 1e3 * d.solver.tolerance, 1001.0 * d.solver.tolerance
    monkeypatch.setattr(collocation, "force_errors", lambda _: errors)
    # e₁ min(1, e₁/e₂), with the moments in place of the other errors
    assert collocation.error_estimate(d, 1e-3, size) == pytest.approx(1e3 * 1e3 / 1001.0, rel=1e-9)
    assert d.budget.other_cost == before + 1
    assert free < 1e3
    # the error of the start is computed again
    assert [shift for shift, *_ in solved] == [1e-3 * REAL_EIGENVALUE] * 3
    assert solved[2][1] == solved[0][2]
