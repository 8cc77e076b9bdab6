"""The impulses of constraints: pressed contacts, missing motions, and wrong contacts.

They are compared with dense matrices and with every possible set of contacts.
"""

import numpy as np
import pytest

from chain_impact.kernel.chain.mass_matrix_solver import HELD
from chain_impact.kernel.constraints import constraint_response, geometry, impulses
from tests.kernel.chains import mark_touching
from tests.kernel.forces.pressed import CANDIDATES, problem

POINTS, FAR = 5, 10.0


@pytest.mark.parametrize("ratio", [1e-6, 1.0, 1e6])
def test_masses_that_differ_by_a_million_are_no_hindrance(ratio):
    d, *_ = problem(pressed=(1, 1, 1, 1), masses=(1.0, ratio, 1.0, 1.0))
    impulses.factorize_free(d)
    impulses.solve_equality(d, 1.0)
    np.testing.assert_allclose(d.constraints.reached_motion[:4], d.constraints.target_motion[:4], atol=1e-10)


def test_only_the_pressed_have_an_impedance_and_miss_their_aims():
    d, *_ = problem()
    own = d.constraints
    own.impedance[:] = own.residual[:] = own.impulse[:] = own.change[:] = 9.0
    impulses.clear_impulses(d)
    assert not own.change.any()
    assert not own.impulse[:4].any()
    assert (own.impulse[4:] == 9.0).all()
    np.testing.assert_array_equal(own.reached_motion[:4], own.unforced_motion[:4])
    own.target_motion[1] = 1e3  # target of a contact that is not pressed
    for amount in (0.0, 4.5):
        impulses.set_impedance(d, amount)
        assert own.impedance[:5].tolist() == [amount, 0.0, amount, amount, 9.0]
    for sign in (1.0, -1.0):
        own.reached_motion[:4] = own.target_motion[:4] - sign * np.array([0.3, 7.0, 0.5, 0.1])
        assert impulses.find_residual(d) == pytest.approx(0.5, rel=1e-9)
        np.testing.assert_allclose(own.residual[:4], sign * np.array([0.3, 0.0, 0.5, 0.1]), atol=1e-9)


@pytest.mark.parametrize("base", ["free", "pinned"])
def test_a_point_with_the_impedance_of_holding_hardly_moves(base):
    """An impulse p moves the point by W/(1 + D W) p, some millionths of W p."""
    d, _, _, _, w = problem(base)
    amount = constraint_response.holding_impedance(d)
    assert amount == pytest.approx(constraint_response.RELATIVE_IMPEDANCE * d.chain.mass.mean(), rel=1e-14)
    for k, c in enumerate(d.contacts.active_index[:4]):
        mark_touching(d, [c])
        d.constraints.impedance[0] = amount
        constraint_response.factorize_contacts(d, HELD, d.constraints.impedance)
        constraint_response.solve_contacts(d, HELD, np.ones(len(d.constraints.impulse)), d.constraints.change)
        moved = geometry.dot(geometry.normal_row(d, c), d.scratch.place_change)
        assert moved == pytest.approx(w[k, k] / (1.0 + amount * w[k, k]), rel=1e-6)
        assert moved < 1e-5 * w[k, k]
        mark_touching(d, CANDIDATES if base == "free" else [c - 1 for c in CANDIDATES])


@pytest.mark.parametrize("base", ["free", "pinned"])
@pytest.mark.parametrize(
    "pressed", [(0, 0, 0, 0), (1, 1, 1, 1), (1, 0, 0, 1), (1, 0, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)]
)
def test_all_pressed_contacts_reach_their_targets(base, pressed):
    """A single pressed contact takes one solution, and several contacts take a few sweeps."""
    d, _, _, response, w = problem(base, pressed)
    own, rows, before, alone = d.constraints, np.flatnonzero(pressed), d.budget.other_cost, sum(pressed) == 1
    assert impulses.single_active(d) == (rows[0] if alone else -1)
    impulses.factorize_free(d)
    impulses.solve_equality(d, 2.0)
    expected, off = np.zeros(4), 1e-12 if alone else 1e-9
    expected[rows] = np.linalg.solve(w[np.ix_(rows, rows)], (own.target_motion - own.unforced_motion)[rows])
    np.testing.assert_allclose(own.impulse[:4], expected, rtol=off, atol=off * (not alone))
    np.testing.assert_allclose(own.change, response @ expected, rtol=10 * off, atol=off)
    np.testing.assert_allclose(
        own.reached_motion[:4], own.unforced_motion[:4] + w @ expected, rtol=10 * off, atol=off
    )
    if alone:
        assert d.budget.other_cost == before + 1
    elif any(pressed):
        assert 2 <= d.budget.other_cost - before <= 6


def test_a_contact_that_can_hardly_move_is_found_by_the_iteration(monkeypatch):
    d, _, _, _, w = problem(pressed=[0, 1, 0, 0])
    own = d.constraints
    for part, iterates in ((1.01, True), (0.99, False)):
        monkeypatch.setattr(
            impulses, "LEAST_SINGLE_MOBILITY", part * w[1, 1] * constraint_response.mean_mass(d)
        )
        before = d.budget.other_cost
        impulses.factorize_free(d)
        impulses.solve_equality(d, 2.0)
        assert own.impulse[1] == pytest.approx(
            (own.target_motion - own.unforced_motion)[1] / w[1, 1], rel=1e-12
        )
        assert d.budget.other_cost >= before + 4 if iterates else d.budget.other_cost == before + 1


def test_a_chain_that_is_nearly_straight_is_held_by_a_smooth_force():
    """Each iteration leaves the part 1/(1 + D W) of the motion of a single element."""
    d, *_ = problem()
    amount = constraint_response.holding_impedance(d)
    for part in (0.0, 1e-6, 0.1, 1.0, 30.0, 1e6):
        mobility = part / amount
        left = 1.0 - mobility / constraint_response.held_mobility(d, mobility)
        assert left == pytest.approx(
            (1.0 + part) ** -constraint_response.STICKING_ITERATIONS, rel=1e-9, abs=1e-15
        )
    least = constraint_response.held_mobility(d, 0.0)
    assert (
        constraint_response.held_mobility(d, -1e-30)
        == least
        == pytest.approx(1.0 / (constraint_response.STICKING_ITERATIONS * amount))
    )


def test_points_that_cannot_be_held_are_told_by_what_is_left():
    """Two constraints demand contradictory motions: the search ends, and half of the motion is left."""
    d, *_ = problem(pressed=(1, 1, 0, 0))
    own = d.constraints
    d.contacts.active_index[1] = d.contacts.active_index[0]
    own.unforced_motion[:2], own.target_motion[:2] = 0.0, (1.0, -1.0)
    before = d.budget.other_cost
    impulses.factorize_free(d)
    assert impulses.solve_equality(d, 1.0) == pytest.approx(1.0, rel=1e-6)
    assert d.budget.other_cost - before <= 20
    for tolerated, noted in ((2.0, impulses.SOLVED), (0.5, impulses.MOVING)):
        impulses.clear_outcome(d)
        impulses.note_moving(d, tolerated)
        assert d.constraints.outcome == noted
    impulses.note_forces_not_found(d)
    impulses.note_moving(d, 0.5)
    assert d.constraints.outcome == impulses.OUTCOME_FORCES_NOT_FOUND


@pytest.mark.parametrize("part", [0.5, 1.0, 2.0])
def test_a_point_that_hardly_moves_is_held_in_a_few_iterations(monkeypatch, part):
    """For D W ≈ 1 plain iterations would need 30 or more until the residual is round-off."""
    d, _, _, _, w = problem(pressed=(0, 1, 0, 0))
    monkeypatch.setattr(impulses, "LEAST_SINGLE_MOBILITY", 1e9)
    monkeypatch.setattr(impulses, "holding_impedance", lambda _: part / w[1, 1])
    monkeypatch.setattr(
        impulses, "LARGEST_IMPEDANCE", 1e12 * part / w[1, 1] / constraint_response.mean_mass(d)
    )
    before = d.budget.other_cost
    impulses.factorize_free(d)
    assert impulses.solve_equality(d, 2.0) <= 2e-15
    assert d.budget.other_cost - before <= 22
    assert d.constraints.impulse[1] == pytest.approx(
        (d.constraints.target_motion - d.constraints.unforced_motion)[1] / w[1, 1], rel=1e-12
    )
