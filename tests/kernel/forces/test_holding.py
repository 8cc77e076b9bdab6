"""Rigid walls: accelerations of held points, the projection of a state, and stopping impulses."""

import math

import numpy as np
import pytest

from chain_impact.kernel import equations
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.constraints import constraint_response, geometry, impulses
from chain_impact.kernel.forces import friction, holding
from chain_impact.kernel.record.constants import STICKS
from tests.helpers.kernel.plain import make_rigid
from tests.helpers.models.reference import complementary_impulses
from tests.kernel.chains import mark_touching, move_wall_to_depth
from tests.kernel.forces.pressed import CANDIDATES, problem
from tests.kernel.rubbing import rubbing_chain


def test_rigid_walls_hold_what_touches_and_press_it_to_rest():
    for rigid, touching in ((0, 0), (0, 2), (1, 0), (1, 2)):
        d, *_ = problem()
        mark_touching(d, CANDIDATES[:touching])
        make_rigid(d, rigid)
        assert bool(impulses.any_point_held(d)) == (rigid == 1 and touching > 0)
    d.constraints.in_active_set[:] = d.constraints.target_motion[:] = 7
    impulses.activate_all(d)
    assert d.constraints.in_active_set[:3].tolist() == [1, 1, 7]
    assert d.constraints.target_motion[:3].tolist() == [0.0, 0.0, 7.0]


@pytest.mark.parametrize("base", ["free", "pinned"])
def test_held_points_have_no_acceleration_and_their_least_force_is_kept(base):
    """g̈ + W F = 0, where g̈ is the acceleration without forces."""
    d, y, _jacobian, response, w = problem(base)
    rate = np.zeros(len(y))
    equations.free_rate_from_inputs(d, y, rate)
    own, before = d.constraints, rate.copy()
    # g̈ by the second difference of g along the motion
    candidates = d.contacts.active_index[:4].tolist()
    gaps = []
    for t in (1e-4, 0.0, -1e-4):
        moved = y.copy()
        moved[:6] += t * y[6:12] + 0.5 * t * t * rate[6:12]
        locate_points(d, moved)
        gaps.append([geometry.clearance_and_rate(d, c)[0] for c in candidates])
    second = (np.array(gaps[0]) - 2 * np.array(gaps[1]) + np.array(gaps[2])) / 1e-8
    locate_points(d, y)
    most = holding.set_unforced_to_accelerations(d, y, rate)
    np.testing.assert_allclose(own.unforced_motion[:4], second, rtol=1e-4, atol=1e-4)
    assert most == max(np.abs(d.scratch.acceleration.x).max(), np.abs(d.scratch.acceleration.y).max())
    force = np.linalg.solve(w, -own.unforced_motion[:4])
    own.least_force[:] = np.where(np.arange(d.candidate_count) % 2, -1e9, 0.0)
    holding.add_constraint_forces(d, y, rate)
    np.testing.assert_allclose(own.impulse[:4], force, rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(rate[6:12], before[6:12] + response @ force, rtol=1e-8, atol=1e-8)
    np.testing.assert_array_equal(np.delete(rate, range(6, 12)), np.delete(before, range(6, 12)))
    for k, c in enumerate(candidates):
        assert d.contacts.force[c] == own.impulse[k]
        assert own.least_force[c] == (-1e9 if c % 2 else min(0.0, own.impulse[k]))


def test_tolerated_momentum_is_that_of_tolerance_and_a_small_fall():
    """m √(2 (g + 1/s²·size) LEAST_RISE size) + m tol (size/s + v)."""
    d, *_ = problem()
    total = d.chain.mass.sum()
    rise = math.sqrt(
        2.0 * (math.hypot(2.3, 9.81) + d.chain.longest_link) * holding.LEAST_RISE * d.chain.longest_link
    )
    for tolerance, speed in ((1e-4, 0.0), (1e-8, 7.0)):
        d.solver.tolerance = tolerance
        expected = total * (rise + tolerance * (d.chain.longest_link + speed))
        assert holding.tolerated_momentum(d, speed) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_stopping_impulses_pull_by_no_more_than_errors_explain(seed):
    d, _y, _, _, w = problem(seed=seed)
    own = d.constraints
    for size in (1.0, 1e-9):  # s, for a motion and for errors
        own.unforced_motion[:4] = size * np.array([-0.5, 0.8, -0.2, 0.3])
        impulses.activate_all(d)
        d.scratch.velocity.x[:], d.scratch.velocity.y[:] = size, 0.0
        d.solver.tolerance = 1e-7
        equal = np.linalg.solve(w, -own.unforced_motion[:4])
        holding.solve_stopping_impulses(d)
        if equal.min() < -holding.tolerated_momentum(d, size):
            expected = complementary_impulses(w, own.unforced_motion[:4], np.zeros(4))
            assert (own.reached_motion[:4] > -1e-11).all()
        else:
            expected = equal
            np.testing.assert_allclose(own.reached_motion[:4], 0.0, atol=1e-12)
        np.testing.assert_allclose(own.impulse[:4], expected, rtol=0, atol=1e-9 * np.abs(equal).max())


@pytest.mark.parametrize("tolerance", [1e-12, 1e3])
@pytest.mark.parametrize("bad", [False, True])
def test_a_projection_far_larger_than_its_residual_is_refused(bad, tolerance):
    """Where W is nearly singular a small gap needs large rotations; then separate points stay in place."""
    d, _, _, response, _ = problem(pressed=(1, 1))
    own, size = d.constraints, d.chain.longest_link
    if bad:  # one point touches two walls with an angle of 1e-3 rad
        first, second = d.contacts.active_index[:2]
        d.candidate.point[second] = d.candidate.point[first]
        d.candidate.place[second] = d.candidate.place[first]
        c, s = math.cos(1e-3), math.sin(1e-3)
        nx, ny = d.candidate.normal_x[first], d.candidate.normal_y[first]
        d.candidate.normal_x[second], d.candidate.normal_y[second] = c * nx - s * ny, s * nx + c * ny
        constraint_response.effective_mass(d, second)
        response[:, 1] = d.scratch.change  # M⁻¹ ∇g, by the recursion
    own.unforced_motion[:2] = 1e-6, -1e-6
    impulses.activate_all(d)
    d.solver.tolerance = tolerance
    holding.solve_positions(d)
    moved = np.abs(own.change / np.array([size, size, 1.0, 1.0, 1.0, 1.0])).max()
    if bad and tolerance < 1.0:
        # the point inside the wall is moved out; the other point stays, or moves away from its wall
        assert moved < 10.0 * 1e-6
        assert own.impulse[0] == 0.0
        assert own.reached_motion[1] == pytest.approx(0.0, abs=1e-14)
        np.testing.assert_allclose(own.change, response[:, 1] * own.impulse[1], rtol=1e-6)
    else:
        np.testing.assert_allclose(own.reached_motion[:2], 0.0, atol=1e-13)
        assert not bad or moved > holding.LARGEST_CORRECTION * 2e-6 / size


@pytest.mark.parametrize("base", ["free", "pinned"])
def test_the_kinetic_energy_that_walls_take_is_dissipated(base):
    d, y, jacobian, response, w = problem(base)
    for k, c in enumerate(d.contacts.active_index[:4]):
        move_wall_to_depth(d, c, 1e-9 * (k - 1.5))
    d.solver.tolerance, before = 1e3, y.copy()
    y[12] = 5.0
    holding.project_state(d, y)
    rates = jacobian @ before[6:12]
    expected_impulses = -np.linalg.solve(w, rates)
    np.testing.assert_allclose(y[6:12], before[6:12] + response @ expected_impulses, rtol=1e-5, atol=1e-5)
    assert y[12] - 5.0 == pytest.approx(0.5 * rates @ np.linalg.solve(w, rates), rel=1e-5)
    for c in d.contacts.active_index[:4]:
        assert geometry.clearance_and_rate(d, c) == pytest.approx((0.0, 0.0), abs=1e-12)


@pytest.mark.parametrize(("moved", "again"), [(0.99, False), (1.01, True)])
@pytest.mark.parametrize("turns", [False, True])
def test_a_projection_is_judged_by_residuals_and_link_lengths(monkeypatch, moved, again, turns):
    d, *_ = problem(pressed=(1, 1))
    own, size, called = d.constraints, d.chain.longest_link, []
    own.unforced_motion[:2], own.target_motion[:2] = [2e-3, 5e-3], [3e-3, 1e-3]
    d.solver.tolerance = 1e-6
    limit = holding.LARGEST_CORRECTION * (1e-6 + 4e-3 / size)

    def solve_equality(d, scale):
        called.append(scale)
        own.change[:] = 0.0
        own.change[2 if turns else 1] = -moved * limit * (1.0 if turns else size)

    monkeypatch.setattr(holding, "solve_equality", solve_equality)
    monkeypatch.setattr(holding, "solve_lcp", lambda _, scale: called.append(scale))
    holding.solve_positions(d)
    assert called == [geometry.largest_coordinate(d)] * (1 + again)


def stuck_chain(base, contacts, joints, stuck):
    """Return a chain with friction whose elements ``stuck`` stick, in the order of their list."""
    _, d, y = rubbing_chain(np.random.default_rng(8), base, contacts, joints)
    for k in stuck:
        d.friction_element.mode[d.friction_element.index[k]] = STICKS
    friction.list_sticking(d)
    return d, y


@pytest.mark.parametrize("base", ["free", "pinned"])
@pytest.mark.parametrize(("contacts", "stuck"), [(1, 0), (2, 0), (2, 1)])
def test_the_force_of_one_that_sticks_alone_is_that_of_the_iteration(base, contacts, stuck, monkeypatch):
    results = []
    for only_active in (impulses.single_active, lambda _d: -1):
        monkeypatch.setattr(impulses, "single_active", only_active)
        d, y = stuck_chain(base, contacts, True, [stuck])
        rate = np.zeros(len(y))
        equations.free_rate_from_inputs(d, y, rate)
        free = rate.copy()
        holding.add_constraint_forces(d, y, rate)
        e = d.friction_element.stuck_index[0]
        impulse = d.constraints.impulse[d.contacts.active_count]
        results.append(
            [
                *(rate - free),
                impulse,
                d.friction_element.force[e],
                d.friction_element.margin[e],
                d.friction.power,
            ]
        )
    assert np.abs(results[0]).max() > 1.0
    np.testing.assert_allclose(results[1], results[0], rtol=1e-9, atol=1e-9)
