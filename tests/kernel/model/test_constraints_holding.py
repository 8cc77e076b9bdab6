"""The parts of the problem of rigid walls: who is pressed, what is missing, and who is wrong."""

import math

import numpy as np
import pytest

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.model import constraints
from chain_impact.kernel.model.compliance import (
    STIFF,
    effective_mass,
    factorize_contacts,
    holding_impedance,
    mean_mass,
    solve_contacts,
)
from chain_impact.kernel.model.constraints import (
    MISPLACED,
    RISE,
    SIGN_TOLERANCE,
    activate_all,
    add_constraint_forces,
    any_point_held,
    clear_impulses,
    correct_impulses,
    count_violations,
    find_residual,
    least_impulse,
    only_active,
    project_state,
    set_impedance,
    solve_equality,
    solve_lcp,
    solve_positions,
    solve_stopping_impulses,
    start_from_accelerations,
    tolerated_momentum,
)
from chain_impact.kernel.model.equations import free_rate
from chain_impact.kernel.model.geometry import along_normal, clearance
from tests.kernel.chains import chain, free_coordinates, gradients, press_in, struck, touch
from tests.plain import make_rigid
from tests.reference import complementary_impulses, mass_matrix

CANDIDATES = [1, 6, 11, 16]  # points 0 to 4 of a free chain, each at another wall


def problem(base="free", pressed=(1, 0, 1, 1), seed=0):
    """A chain whose touching candidates have motions to aims; its state, J, M⁻¹ Jᵀ and W."""
    rng = np.random.default_rng([len(base), seed])
    scene, d = chain(rng, 4, base, model="newton_impact")
    candidates = CANDIDATES[: len(pressed)]
    if base == "pinned":
        candidates = [c - 1 for c in candidates]
    y = struck(rng, d, candidates, 0.0)
    free = free_coordinates(d)
    jacobian = gradients(scene, d, y[2:6], candidates)
    response = np.zeros((6, len(candidates)))
    response[free] = np.linalg.solve(mass_matrix(scene, y[2:6])[free, free], jacobian[:, free].T)
    own, count = d.rigid, len(candidates)
    own.in_active_set[:count] = pressed
    own.start[:count], own.target[:count] = rng.normal(size=count), rng.normal(size=count)
    return d, y, jacobian, response, jacobian @ response


def test_only_the_pressed_have_an_impedance_and_miss_their_aims():
    d, *_ = problem()
    own = d.rigid
    own.impedance[:] = own.residual[:] = own.impulse[:] = own.change[:] = 9.0
    clear_impulses(d)
    assert not own.change.any()
    assert not own.impulse[:4].any()
    assert (own.impulse[4:] == 9.0).all()
    np.testing.assert_array_equal(own.reached[:4], own.start[:4])
    own.target[1] = 1e3  # of one that is not pressed
    for amount in (0.0, 4.5):
        set_impedance(d, amount)
        assert own.impedance[:5].tolist() == [amount, 0.0, amount, amount, 9.0]
    for sign in (1.0, -1.0):
        own.reached[:4] = own.target[:4] - sign * np.array([0.3, 7.0, 0.5, 0.1])
        assert find_residual(d) == pytest.approx(0.5, rel=1e-9)
        np.testing.assert_allclose(own.residual[:4], sign * np.array([0.3, 0.0, 0.5, 0.1]), atol=1e-9)


@pytest.mark.parametrize("base", ["free", "pinned"])
def test_a_point_with_the_impedance_of_holding_hardly_moves(base):
    """An impulse p moves it by W/(1 + D W) p, some millionths of W p."""
    d, _, _, _, w = problem(base)
    amount = holding_impedance(d)
    assert amount == pytest.approx(STIFF * d.model.mass.mean(), rel=1e-14)
    for k, c in enumerate(d.touch.active_index[:4]):
        touch(d, [c])
        d.rigid.impedance[0] = amount
        factorize_contacts(d, d.work.link, d.rigid.impedance, 0.0, d.rigid.factors)
        solve_contacts(d, d.work.link, d.rigid.factors, np.ones(len(d.rigid.impulse)), d.rigid.change)
        moved = along_normal(d, c, d.work.motion)
        assert moved == pytest.approx(w[k, k] / (1.0 + amount * w[k, k]), rel=1e-6)
        assert moved < 1e-5 * w[k, k]
        touch(d, CANDIDATES if base == "free" else [c - 1 for c in CANDIDATES])


@pytest.mark.parametrize("base", ["free", "pinned"])
@pytest.mark.parametrize("pressed", [(1,), (1, 0, 1), (1, 1, 1, 1)])
def test_a_sweep_is_a_step_of_the_augmented_lagrangian(base, pressed):
    """p ← p + D (m − J z), (M + Jᵀ D J) z = Jᵀ D m, and u = u⁻ + W p thereafter."""
    d, _, _, _, w = problem(base, pressed)
    own, count, impedance = d.rigid, len(pressed), 40.0
    set_impedance(d, 0.0)
    factorize_contacts(d, d.work.link, own.impedance, 0.0, d.work.factors)
    set_impedance(d, impedance)
    factorize_contacts(d, d.work.link, own.impedance, 0.0, own.factors)
    clear_impulses(d)
    p, amounts = np.zeros(count), impedance * np.array(pressed)
    for _ in range(3):
        work = d.limits.other_work
        find_residual(d)
        m = np.array(pressed) * (own.target[:count] - own.start[:count] - w @ p)
        np.testing.assert_allclose(own.residual[:count], m, rtol=0, atol=1e-10)
        # J z = W (1 + D W)⁻¹ D m
        moved = w @ np.linalg.solve(np.eye(count) + amounts[:, None] * w, amounts * m)
        p = p + amounts * (m - moved)
        correct_impulses(d)
        np.testing.assert_allclose(own.impulse[:count], p, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(own.reached[:count], own.start[:count] + w @ p, rtol=1e-9, atol=1e-9)
        assert d.limits.other_work == work + 2


@pytest.mark.parametrize("pressed", [(1, 1, 1, 1), (1, 0, 0, 1)])
def test_all_of_the_pressed_reach_their_aims_and_impulses_are_counted_as_work(pressed):
    d, _, _, response, w = problem(pressed=pressed)
    own, rows, before = d.rigid, np.flatnonzero(pressed), d.limits.other_work
    solve_equality(d, 2.0)
    expected = np.zeros(4)
    expected[rows] = np.linalg.solve(w[np.ix_(rows, rows)], (own.target - own.start)[rows])
    np.testing.assert_allclose(own.impulse[:4], expected, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(own.change, response @ expected, rtol=1e-9, atol=1e-9)
    # a few sweeps do
    assert 2 <= d.limits.other_work - before <= 12


@pytest.mark.parametrize("row", range(4))
def test_the_only_one_that_is_pressed_takes_one_solution(row):
    pressed = [int(k == row) for k in range(4)]
    d, _, _, response, w = problem(pressed=pressed)
    own, before = d.rigid, d.limits.other_work
    assert only_active(d) == row
    solve_equality(d, 2.0)
    expected = np.zeros(4)
    expected[row] = (own.target - own.start)[row] / w[row, row]
    np.testing.assert_allclose(own.impulse[:4], expected, rtol=1e-12)
    np.testing.assert_allclose(own.change, response @ expected, rtol=1e-11, atol=1e-13)
    np.testing.assert_allclose(own.reached[:4], own.start[:4] + w @ expected, rtol=1e-11, atol=1e-12)
    assert d.limits.other_work == before + 1


def test_one_that_can_hardly_move_is_found_by_the_iteration(monkeypatch):
    d, _, _, _, w = problem(pressed=[0, 1, 0, 0])
    own, before = d.rigid, d.limits.other_work
    monkeypatch.setattr(constraints, "LEAST_SINGLE", 1.01 * w[1, 1] * mean_mass(d))
    solve_equality(d, 2.0)
    assert own.impulse[1] == pytest.approx((own.target - own.start)[1] / w[1, 1], rel=1e-12)
    assert d.limits.other_work >= before + 4
    monkeypatch.setattr(constraints, "LEAST_SINGLE", 0.99 * w[1, 1] * mean_mass(d))
    before = d.limits.other_work
    solve_equality(d, 2.0)
    assert d.limits.other_work == before + 1


@pytest.mark.parametrize("pressed", [[0, 0, 0, 0], [1, 1, 0, 0], [0, 1, 1, 1]])
def test_none_or_more_are_not_the_only_one(pressed):
    assert only_active(problem(pressed=pressed)[0]) == -1


def test_who_pulls_or_falls_short_is_wrong_but_for_round_off():
    d, *_ = problem(pressed=(1, 1, 0, 0))
    own = d.rigid
    scale = 3.0
    own.target[:4] = 0.5
    for pull, short in ((2.0, 2.0), (0.5, 2.0), (2.0, 0.5), (0.5, 0.5)):
        own.violated[:] = 7
        own.impulse[:4] = 4.0, -pull * SIGN_TOLERANCE * 4.0, 0.0, 0.0
        own.reached[:4] = -9.0, 0.5, 0.7, 0.5 - short * SIGN_TOLERANCE * scale
        expected = [0, int(pull > 1.0), 0, int(short > 1.0)]
        assert count_violations(d, scale) == sum(expected)
        assert own.violated[:4].tolist() == expected
    # the largest may be one that pulls
    own.impulse[:4], own.reached[:4] = (1.0, -4.0, 0.0, 0.0), 1.0
    assert count_violations(d, scale) == 1
    assert least_impulse(d) == -4.0
    own.impulse[:4] = 1.0
    assert least_impulse(d) == 0.0


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("guess", [(0, 0, 0, 0), (1, 1, 1, 1), (0, 1, 1, 0)])
def test_the_complementary_impulses_do_not_depend_on_the_guess(seed, guess):
    d, _, _, _, w = problem(pressed=guess, seed=seed)
    own = d.rigid
    expected = complementary_impulses(w, own.start[:4], own.target[:4])
    solve_lcp(d, np.abs(own.start).max())
    np.testing.assert_allclose(own.impulse[:4], expected, rtol=0, atol=1e-9 * max(1.0, expected.max()))
    assert ((own.impulse[:4] > 0.0) <= (own.in_active_set[:4] == 1)).all()


@pytest.mark.parametrize(("impulsive", "touching"), [(0, 0), (0, 2), (1, 0), (1, 2)])
def test_rigid_walls_hold_what_touches(impulsive, touching):
    d, *_ = problem()
    touch(d, CANDIDATES[:touching])
    make_rigid(d, impulsive)
    assert bool(any_point_held(d)) == (impulsive == 1 and touching > 0)


def test_all_that_touch_are_pressed_to_rest():
    d, *_ = problem()
    d.rigid.in_active_set[:] = d.rigid.target[:] = 7
    activate_all(d)
    assert d.rigid.in_active_set[:5].tolist() == [1, 1, 1, 1, 7]
    assert d.rigid.target[:5].tolist() == [0.0, 0.0, 0.0, 0.0, 7.0]


@pytest.mark.parametrize("base", ["free", "pinned"])
def test_held_points_have_no_acceleration_and_the_least_of_each_force_is_kept(base):
    """g̈ + W F = 0, with the g̈ that is without forces."""
    d, y, _jacobian, response, w = problem(base)
    rate = np.zeros(len(y))
    free_rate(d, y, rate)
    own, before = d.rigid, rate.copy()
    # g̈ by the second difference of g along the motion
    candidates = d.touch.active_index[:4].tolist()
    gaps = []
    for t in (1e-4, 0.0, -1e-4):
        moved = y.copy()
        moved[:6] += t * y[6:12] + 0.5 * t * t * rate[6:12]
        locate_points(d, moved)
        gaps.append([clearance(d, c)[0] for c in candidates])
    second = (np.array(gaps[0]) - 2 * np.array(gaps[1]) + np.array(gaps[2])) / 1e-8
    locate_points(d, y)
    most = start_from_accelerations(d, y, rate)
    np.testing.assert_allclose(own.start[:4], second, rtol=1e-4, atol=1e-4)
    assert most == max(np.abs(d.work.acceleration.x).max(), np.abs(d.work.acceleration.y).max())
    force = np.linalg.solve(w, -own.start[:4])
    own.least_force[:] = np.where(np.arange(d.candidates) % 2, -1e9, 0.0)
    add_constraint_forces(d, y, rate)
    np.testing.assert_allclose(own.impulse[:4], force, rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(rate[6:12], before[6:12] + response @ force, rtol=1e-8, atol=1e-8)
    np.testing.assert_array_equal(np.delete(rate, range(6, 12)), np.delete(before, range(6, 12)))
    for k, c in enumerate(candidates):
        assert d.touch.force[c] == own.impulse[k]
        assert own.least_force[c] == (-1e9 if c % 2 else min(0.0, own.impulse[k]))


def test_the_momentum_that_errors_explain_is_that_of_the_tolerance_and_of_a_fall():
    """m √(2 (g + 1/s²·size) RISE size) + m tol (size/s + v)."""
    d, *_ = problem()
    total = d.model.mass.sum()
    rise = math.sqrt(2.0 * (math.hypot(2.3, 9.81) + d.model.size) * RISE * d.model.size)
    for tolerance, speed in ((1e-4, 0.0), (1e-8, 7.0)):
        d.solver.tolerance = tolerance
        expected = total * (rise + tolerance * (d.model.size + speed))
        assert tolerated_momentum(d, speed) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_walls_stop_by_impulses_unless_these_would_pull_by_more_than_errors_explain(seed):
    d, _y, _, _, w = problem(seed=seed)
    own = d.rigid
    for size in (1.0, 1e-9):  # of a motion, and of errors
        own.start[:4] = size * np.array([-0.5, 0.8, -0.2, 0.3])
        activate_all(d)
        d.work.velocity.x[:], d.work.velocity.y[:] = size, 0.0
        d.solver.tolerance = 1e-7
        equal = np.linalg.solve(w, -own.start[:4])
        solve_stopping_impulses(d)
        if equal.min() < -tolerated_momentum(d, size):
            expected = complementary_impulses(w, own.start[:4], np.zeros(4))
            assert (own.reached[:4] > -1e-11).all()
        else:
            expected = equal
            np.testing.assert_allclose(own.reached[:4], 0.0, atol=1e-12)
        np.testing.assert_allclose(own.impulse[:4], expected, rtol=0, atol=1e-9 * np.abs(equal).max())


@pytest.mark.parametrize("tolerance", [1e-12, 1e3])
@pytest.mark.parametrize("bad", [False, True])
def test_points_are_put_onto_their_walls_unless_that_takes_far_more_than_is_missing(bad, tolerance):
    """Where W is all but singular a small gap asks for large turns: then points that are apart stay."""
    d, _, _, response, _ = problem(pressed=(1, 1))
    own, size = d.rigid, d.model.size
    if bad:  # the same point, at walls of which one is turned by 1e-3
        first, second = d.touch.active_index[:2]
        d.candidate.point[second] = d.candidate.point[first]
        d.candidate.place[second] = d.candidate.place[first]
        c, s = math.cos(1e-3), math.sin(1e-3)
        nx, ny = d.candidate.normal_x[first], d.candidate.normal_y[first]
        d.candidate.normal_x[second], d.candidate.normal_y[second] = c * nx - s * ny, s * nx + c * ny
        response = np.transpose([response_of(d, k) for k in (first, second)])
    own.start[:2] = 1e-6, -1e-6
    activate_all(d)
    d.solver.tolerance = tolerance
    solve_positions(d)
    moved = np.abs(own.change / np.array([size, size, 1.0, 1.0, 1.0, 1.0])).max()
    if bad and tolerance < 1.0:
        # the point that is inside is brought out, and the other one stays where it is, or goes further off
        assert moved < 10.0 * 1e-6
        assert own.impulse[0] == 0.0
        assert own.reached[1] == pytest.approx(0.0, abs=1e-14)
        np.testing.assert_allclose(own.change, response[:, 1] * own.impulse[1], rtol=1e-6)
    else:
        np.testing.assert_allclose(own.reached[:2], 0.0, atol=1e-13)
        assert not bad or moved > MISPLACED * 2e-6 / size


def response_of(d, c):
    """M⁻¹ ∇g of a candidate, by the recursion."""
    effective_mass(d, c)
    return d.work.change.copy()


@pytest.mark.parametrize("base", ["free", "pinned"])
def test_what_meeting_the_walls_takes_of_the_kinetic_energy_is_dissipated(base):
    d, y, jacobian, response, w = problem(base)
    for k, c in enumerate(d.touch.active_index[:4]):
        press_in(d, c, 1e-9 * (k - 1.5))
    d.solver.tolerance, before = 1e3, y.copy()
    y[12] = 5.0
    project_state(d, y)
    rates = jacobian @ before[6:12]
    impulses = -np.linalg.solve(w, rates)
    np.testing.assert_allclose(y[6:12], before[6:12] + response @ impulses, rtol=1e-5, atol=1e-5)
    assert y[12] - 5.0 == pytest.approx(0.5 * rates @ np.linalg.solve(w, rates), rel=1e-5)
    for c in d.touch.active_index[:4]:
        assert clearance(d, c) == pytest.approx((0.0, 0.0), abs=1e-12)


@pytest.mark.parametrize(("moved", "again"), [(0.99, False), (1.01, True)])
@pytest.mark.parametrize("turns", [False, True])
def test_a_change_is_judged_by_the_largest_that_is_asked_for_and_by_link_lengths(
    monkeypatch, moved, again, turns
):
    d, *_ = problem(pressed=(1, 1))
    own, size, called = d.rigid, d.model.size, []
    own.start[:2], own.target[:2] = [2e-3, 5e-3], [3e-3, 1e-3]
    d.solver.tolerance = 1e-6
    limit = MISPLACED * (1e-6 + 4e-3 / size)

    def solve_equality(d, scale):
        called.append(scale)
        own.change[:] = 0.0
        own.change[2 if turns else 1] = -moved * limit * (1.0 if turns else size)

    monkeypatch.setattr(constraints, "solve_equality", solve_equality)
    monkeypatch.setattr(constraints, "solve_lcp", lambda _, scale: called.append(scale))
    solve_positions(d)
    assert called == [size] * (1 + again)
