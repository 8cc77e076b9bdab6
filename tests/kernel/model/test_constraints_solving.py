"""The impulses of constraints: who is pressed, what is missing, and who is wrong."""

import itertools

import numpy as np
import pytest

from chain_impact.kernel.chain.elimination import FREE, HELD
from chain_impact.kernel.model import constraints
from chain_impact.kernel.model.compliance import (
    STIFF,
    SWEEPS,
    factorize_contacts,
    held_mobility,
    holding_impedance,
    mean_mass,
    solve_contacts,
)
from chain_impact.kernel.model.constraints import (
    MOVING,
    SIGN_TOLERANCE,
    SOLVED,
    UNSOLVED,
    clear_impulses,
    clear_unsolved,
    correct_impulses,
    count_violations,
    factorize_free,
    find_residual,
    note_moving,
    note_unsolved,
    only_active,
    set_impedance,
    solve_equality,
    solve_lcp,
)
from chain_impact.kernel.model.geometry import along, normal
from chain_impact.kernel.model.holding import (
    least_impulse,
)
from tests.kernel.chains import touch
from tests.kernel.model.pressed import CANDIDATES, problem
from tests.reference import complementary_impulses


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
        factorize_contacts(d, HELD, d.rigid.impedance)
        solve_contacts(d, HELD, np.ones(len(d.rigid.impulse)), d.rigid.change)
        moved = along(normal(d, c), d.work.motion)
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
    factorize_contacts(d, FREE, own.impedance)
    set_impedance(d, impedance)
    factorize_contacts(d, HELD, own.impedance)
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
    factorize_free(d)
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
    factorize_free(d)
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
    factorize_free(d)
    solve_equality(d, 2.0)
    assert own.impulse[1] == pytest.approx((own.target - own.start)[1] / w[1, 1], rel=1e-12)
    assert d.limits.other_work >= before + 4
    monkeypatch.setattr(constraints, "LEAST_SINGLE", 0.99 * w[1, 1] * mean_mass(d))
    before = d.limits.other_work
    factorize_free(d)
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


@pytest.mark.full("more cases", but=30)
@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("guess", [(0, 0, 0, 0), (1, 1, 1, 1), (0, 1, 1, 0)])
def test_the_complementary_impulses_do_not_depend_on_the_guess(seed, guess):
    d, _, _, _, w = problem(pressed=guess, seed=seed)
    own = d.rigid
    expected = complementary_impulses(w, own.start[:4], own.target[:4])
    factorize_free(d)
    solve_lcp(d, np.abs(own.start).max())
    np.testing.assert_allclose(own.impulse[:4], expected, rtol=0, atol=1e-9 * max(1.0, expected.max()))
    assert ((own.impulse[:4] > 0.0) <= (own.in_active_set[:4] == 1)).all()


def test_all_that_are_wrong_change_at_once_and_only_the_last_after_stalls(monkeypatch):
    """The block pivots; those that fail to reduce the number of the wrong; and one at a time from then on."""
    d, *_ = problem()
    wrong, sets, own = [4, 4, 4, 4, 4, 4, 2, 2, 0], [], d.rigid

    def told(_, __):
        sets.append(own.in_active_set[:4].copy())
        count = wrong.pop(0)
        own.violated[:4] = [k < count for k in range(4)]
        return count

    monkeypatch.setattr(constraints, "solve_equality", lambda *_: None)
    monkeypatch.setattr(constraints, "count_violations", told)
    solve_lcp(d, 1.0)
    changed = [np.flatnonzero(one != other).tolist() for one, other in itertools.pairwise(sets)]
    assert changed == [[0, 1, 2, 3]] * (1 + constraints.MAX_STALLED_PIVOTS) + [[3], [3], [0, 1], [0, 1]]


def test_a_chain_that_is_nearly_straight_is_held_by_a_smooth_force():
    """The share of a motion that sweeps leave is (1 + D W)⁻ⁿ, also that which one element alone leaves."""
    d, *_ = problem()
    amount = holding_impedance(d)
    for part in (0.0, 1e-6, 0.1, 1.0, 30.0, 1e6):
        mobility = part / amount
        left = 1.0 - mobility / held_mobility(d, mobility)
        assert left == pytest.approx((1.0 + part) ** -SWEEPS, rel=1e-9, abs=1e-15)
    assert held_mobility(d, -1e-30) == held_mobility(d, 0.0) == pytest.approx(1.0 / (SWEEPS * amount))


def test_points_that_cannot_be_held_are_told_by_what_is_left():
    """Two constraints on one motion that contradict each other: the search ends, and half of it is left."""
    d, *_ = problem(pressed=(1, 1, 0, 0))
    own = d.rigid
    d.touch.active_index[1] = d.touch.active_index[0]
    own.start[:2], own.target[:2] = 0.0, (1.0, -1.0)
    before = d.limits.other_work
    factorize_free(d)
    assert solve_equality(d, 1.0) == pytest.approx(1.0, rel=1e-6)
    assert d.limits.other_work - before <= 20
    for tolerated, noted in ((2.0, SOLVED), (0.5, MOVING)):
        clear_unsolved(d)
        note_moving(d, tolerated)
        assert d.rigid.unsolved == noted
    note_unsolved(d)
    note_moving(d, 0.5)
    assert d.rigid.unsolved == UNSOLVED


@pytest.mark.parametrize("part", [0.5, 1.0, 2.0])
def test_a_point_that_hardly_moves_is_held_in_a_few_iterations(monkeypatch, part):
    """Where D W is about 1 the residual would take 30 iterations and more to become round-off."""
    d, _, _, _, w = problem(pressed=(0, 1, 0, 0))
    monkeypatch.setattr(constraints, "LEAST_SINGLE", 1e9)
    monkeypatch.setattr(constraints, "holding_impedance", lambda _: part / w[1, 1])
    monkeypatch.setattr(constraints, "STIFFEST", 1e12 * part / w[1, 1] / mean_mass(d))
    before = d.limits.other_work
    factorize_free(d)
    assert solve_equality(d, 2.0) <= 2e-15
    assert d.limits.other_work - before <= 22
    assert d.rigid.impulse[1] == pytest.approx((d.rigid.target - d.rigid.start)[1] / w[1, 1], rel=1e-12)
