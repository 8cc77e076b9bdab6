"""The modes of dry friction after an event, against all combinations of modes by dense algebra."""

import itertools

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from chain_impact.kernel.chain.kinematics import largest_component, locate_points
from chain_impact.kernel.constraints.geometry import tangential_position, tangential_rate
from chain_impact.kernel.constraints.impulses import SOLVED
from chain_impact.kernel.events import friction_modes
from chain_impact.kernel.events.friction_modes import (
    ACCELERATION_ERROR,
    choose_friction_modes,
    count_inconsistent,
    first_mode,
    is_inconsistent,
    make_modes_consistent,
    set_slack,
    widen_slack,
)
from chain_impact.kernel.events.marks import count_mode_changes
from chain_impact.kernel.events.mode_changes import friction_round_off, rest_speed
from chain_impact.kernel.forces.active_contacts import list_active_contacts
from chain_impact.kernel.forces.friction import list_sticking, sliding_sign
from chain_impact.kernel.record.constants import NO_EVENT, NO_FRICTION, SLIDING_ENDS, STICKING_ENDS, STICKS
from tests.kernel.rubbing import AtRest, Doubled, rubbing_chain

CASES = [("free", 2, True), ("free", 3, False), ("pinned", 1, True), ("pinned", 0, True), ("free", 0, True)]
SEEDS = range(6)


def assert_laws_hold(chain):
    """Assert that force and acceleration of each element at rest fulfil Coulomb's law."""
    d, reached = chain.d, chain.accelerations()
    scale = largest_component(d, d.scratch.acceleration)
    held, sliding = chain.limits()
    for k, e in enumerate(chain.elements):
        force, mode = d.friction_element.force[e], chain.modes[k]
        if mode == STICKS:
            assert abs(force) <= held[k] + friction_round_off(d, e)
            assert abs(reached[k]) <= 1e-11 * scale
        else:
            assert force == pytest.approx(-mode * sliding[k], rel=1e-12)
            assert mode * reached[k] >= -ACCELERATION_ERROR * scale


@pytest.mark.full("more cases", but=20)
@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(("jumped", "holding"), [(True, 1.0), (False, 1.0), (True, 1.7)])
def test_the_modes_of_elements_at_rest_are_those_that_dense_algebra_finds(seed, jumped, holding, case):
    """For µ_s = µ all consistent combinations have the same accelerations, and the kernel has these.

    With more static friction there may be several answers; the kernel has one of them.
    """
    chain = AtRest(seed, *case, holding)
    solutions = chain.consistent()
    assert solutions
    choose_friction_modes(chain.d, jumped)
    assert chain.modes in solutions
    assert_laws_hold(chain)
    for reached in solutions.values() if holding == 1.0 else ():
        np.testing.assert_allclose(chain.accelerations(), reached, atol=1e-6 * np.abs(chain.bias).max())


@pytest.mark.parametrize("seed", SEEDS)
def test_a_mode_that_is_consistent_is_kept_and_costs_one_evaluation(seed):
    chain = AtRest(seed, "free", 2, True, holding=1.7)
    d = chain.d
    choose_friction_modes(d, True)
    modes, before, logged = chain.modes, int(d.statistics.rhs_evaluations), int(d.friction_changes.count)
    choose_friction_modes(d, False)
    assert (chain.modes, int(d.statistics.rhs_evaluations) - before) == (modes, 1)
    assert d.friction_changes.count == logged


@pytest.mark.parametrize("jumped", [True, False])
def test_moving_elements_slide_in_the_direction_of_their_motion(jumped):
    """A sticking element moves by errors only, unless a speed has jumped."""
    rng = np.random.default_rng(8)
    _, d, y = rubbing_chain(rng, "free", 3, True)
    d.step.state_end[:] = y
    elements = [int(e) for e in d.friction_element.index[: d.friction.active_count]]
    signs = [int(np.sign(tangential_rate(d, e))) for e in elements]
    assert set(signs) == {1, -1}
    d.friction_element.mode[elements] = STICKS if jumped else [-sign for sign in signs]
    choose_friction_modes(d, jumped)
    assert d.friction_element.mode[elements].tolist() == signs
    assert not d.friction_element.decided_by_forces[elements].any()
    assert not d.friction_element.slack[elements].any()
    assert d.friction_element.mode[list(set(range(d.friction_element_count)) - set(elements))].tolist() == [
        NO_FRICTION
    ] * (d.friction_element_count - len(elements))


def test_anchors_are_kept_by_what_stuck_before_and_otherwise_set():
    chain = AtRest(0, "free", 2, True)
    d = chain.d
    d.law.static_friction[:], d.drive.friction[:] = 1e9, 1e9
    d.friction_element.mode[chain.elements] = STICKS
    first, *others = chain.elements
    d.friction_element.mode[others[0]] = 1
    here = d.friction_element.anchor[chain.elements].copy()
    moved = here + 1e-9
    d.friction_element.anchor[chain.elements] = moved
    choose_friction_modes(d, False)
    assert chain.modes == (STICKS,) * len(chain.elements)
    assert d.friction_element.anchor[first] == moved[0]
    assert d.friction_element.anchor[others[0]] == pytest.approx(here[1], abs=1e-13)
    # the state is projected onto all anchors
    locate_points(d, d.step.state_end)
    for e in chain.elements:
        assert tangential_position(d, e) == pytest.approx(d.friction_element.anchor[e], abs=1e-12)
        assert abs(tangential_rate(d, e)) < 1e-12
    d.friction_element.anchor[chain.elements] = moved + 1e-3
    choose_friction_modes(d, True)
    assert d.friction_element.anchor[chain.elements] == pytest.approx(moved, abs=1e-8)


@pytest.mark.parametrize("seed", SEEDS)
def test_an_element_at_its_limit_slides_against_its_force(seed):
    chain = AtRest(seed, "free", 2, True)
    d = chain.d
    d.law.static_friction[:], d.drive.friction[:] = 1e9, 1e9
    d.friction_element.mode[chain.elements] = STICKS
    choose_friction_modes(d, True)
    assert not any(chain.modes)
    e = chain.elements[-1]
    force = float(d.friction_element.force[e])
    d.drive.friction[e - d.candidate_count] = 0.9 * abs(force) * d.chain.longest_link
    d.friction_element.event[e] = STICKING_ENDS
    assert count_mode_changes(d) == 1
    choose_friction_modes(d, False)
    assert d.friction_element.mode[e] == sliding_sign(force) == -np.sign(force)
    assert count_mode_changes(d) == 0
    assert chain.modes in chain.consistent()


def test_joints_of_a_chain_without_friction_have_no_mode():
    chain = AtRest(0, "free", 2, True)
    d = chain.d
    d.drive.friction[:] = 0.0
    choose_friction_modes(d, True)
    assert (d.friction_element.mode[d.candidate_count :] == NO_FRICTION).all()
    assert d.friction.active_count == 2
    list_sticking(d)
    assert d.friction.stuck_joints == 0


def test_no_mark_of_a_change_outlives_the_choice_of_modes():
    """The mark of an element whose contact has ended must not count when its point touches again."""
    _, d, _ = rubbing_chain(np.random.default_rng(5), "free", 2, True)
    d.friction_element.event[:] = STICKING_ENDS
    d.contacts.active[d.contacts.active_index[0]] = 0
    list_active_contacts(d)
    choose_friction_modes(d, False)
    assert d.friction.active_count < d.friction_element_count
    assert not d.friction_element.event.any()


@pytest.fixture
def record_and_element():
    """Return a chain whose contact is its only element with friction, and the candidate in contact."""
    _, d, _ = rubbing_chain(np.random.default_rng(3), "free", 1, False)
    return d, int(d.contacts.active_index[0])


def move_at(d, c, speed):
    """Give the point of candidate c a tangential speed."""
    there = d.candidate.place[c]
    d.scratch.velocity.x[there] = speed * d.candidate.normal_y[c]
    d.scratch.velocity.y[there] = -speed * d.candidate.normal_x[c]


@pytest.mark.full("more cases", but=23)
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(
    "case",  # event, mode before, speed, whether speeds have jumped; mode, whether undecided
    [
        (NO_EVENT, 1, 0.5, False, 1, 0),
        (NO_EVENT, -1, 0.5, False, 1, 0),
        (NO_EVENT, NO_FRICTION, 0.5, True, 1, 0),
        (NO_EVENT, STICKS, 0.5, True, 1, 0),
        (NO_EVENT, STICKS, 1e-7, False, STICKS, 1),
        (NO_EVENT, STICKS, 0.5, False, 1, 0),
        (NO_EVENT, 1, 0.0, True, 1, 1),
        (NO_EVENT, -1, 0.0, False, -1, 1),
        (NO_EVENT, NO_FRICTION, 0.0, True, STICKS, 1),
        (SLIDING_ENDS, 1, 1e-7, False, STICKS, 1),
        (SLIDING_ENDS, 1, 0.5, False, 1, 0),
        (SLIDING_ENDS, -1, 0.0, True, STICKS, 1),
        (STICKING_ENDS, STICKS, 0.0, False, -1, 1),
        (STICKING_ENDS, STICKS, 0.5, True, -1, 1),
    ],
)
def test_the_first_guess_is_by_the_motion_the_event_or_what_was_before(record_and_element, sign, case):
    """All signs reverse with the sign of the motion and of the force."""
    (d, c), (event, before, speed, jumped, expected, undecided) = record_and_element, case
    move_at(d, c, sign * speed)
    d.friction_element.mode_before[c] = sign * before if abs(before) == 1 else before
    d.friction_element.event[c], d.friction_element.force[c] = event, sign * 4.0
    assert first_mode(d, c, jumped) == sign * expected
    assert d.friction_element.decided_by_forces[c] == undecided


@pytest.mark.parametrize(("part", "undecided"), [(0.9, 1), (1.1, 0)])
def test_rest_has_a_speed_of_round_off(record_and_element, part, undecided):
    d, c = record_and_element
    move_at(d, c, part * rest_speed(d))
    d.friction_element.mode_before[c] = STICKS
    first_mode(d, c, True)
    assert d.friction_element.decided_by_forces[c] == undecided


@pytest.mark.parametrize(("part", "wrong"), [(-0.6, False), (0.4, False), (0.6, True)])
def test_a_static_force_may_exceed_its_limit_by_half_of_what_is_round_off(record_and_element, part, wrong):
    """The other half of the round-off belongs to the search, so that a new mode does not end at once."""
    d, c = record_and_element
    (
        d.friction_element.mode[c],
        d.friction_element.decided_by_forces[c],
        d.friction_element.friction_limit[c],
    ) = STICKS, 1, 7.0
    for sign in (1.0, -1.0):
        d.friction_element.force[c] = sign * (7.0 + part * friction_round_off(d, c))
        assert is_inconsistent(d, c) == wrong
        assert count_inconsistent(d) == wrong
        d.friction_element.decided_by_forces[c] = 0
        assert not is_inconsistent(d, c)
        d.friction_element.decided_by_forces[c] = 1


@pytest.mark.parametrize(("part", "wrong"), [(-1.0, False), (0.9, False), (1.1, True)])
def test_sliding_at_rest_may_accelerate_backward_by_round_off(record_and_element, part, wrong):
    d, c = record_and_element
    d.scratch.acceleration.x[:], d.scratch.acceleration.y[:] = 0.0, 0.0
    d.scratch.acceleration.x[1 - d.candidate.place[c]] = 50.0
    for sign in (1, -1):
        d.friction_element.mode[c], d.friction_element.decided_by_forces[c] = sign, 1
        backward = (
            -sign * part * ACCELERATION_ERROR * (50.0 + d.chain.gravity_magnitude + d.chain.longest_link)
        )
        place = d.candidate.place[c]
        d.scratch.acceleration.x[place] = backward * d.candidate.normal_y[c]
        d.scratch.acceleration.y[place] = -backward * d.candidate.normal_x[c]
        assert is_inconsistent(d, c) == wrong


@pytest.mark.parametrize(("part", "wrong"), [(1.9, False), (2.1, True)])
def test_sliding_at_rest_may_accelerate_backward_as_what_sticks_does(record_and_element, part, wrong):
    """The error of a holding force accelerates a sticking element; twice this acceleration is allowed."""
    d, c = record_and_element
    other = d.candidate_count - 1
    assert d.candidate.place[other] != d.candidate.place[c]
    d.scratch.acceleration.x[:], d.scratch.acceleration.y[:] = 0.0, 0.0
    d.friction.stuck_count, d.friction_element.stuck_index[0] = 1, other
    d.friction_element.mode[c], d.friction_element.decided_by_forces[c] = 1, 1
    for e, along in ((other, 1e-3), (c, -part * 1e-3)):
        d.scratch.acceleration.x[d.candidate.place[e]] = along * d.candidate.normal_y[e]
        d.scratch.acceleration.y[d.candidate.place[e]] = -along * d.candidate.normal_x[e]
    assert is_inconsistent(d, c) == wrong


def test_a_choice_ends_even_where_no_mode_is_right(monkeypatch):
    """First all wrong modes change at once; after the permitted failures, fewer and fewer elements stick."""
    chain = AtRest(0, "free", 2, True)
    d, rounds = chain.d, []
    d.friction_element.decided_by_forces[chain.elements] = 1
    d.friction_element.mode[chain.elements] = STICKS
    monkeypatch.setattr(friction_modes, "is_inconsistent", lambda _d, _e: True)
    monkeypatch.setattr(
        friction_modes, "list_sticking", lambda d: (rounds.append(chain.modes), list_sticking(d))
    )
    make_modes_consistent(d)
    changes = [sum(np.array(a) != np.array(b)) for a, b in itertools.pairwise(rounds)]
    many = friction_modes.MAX_STALLED_PIVOTS + 1
    assert changes[:many] == [len(chain.elements)] * many
    assert many < len(changes) <= many + 1 + len(chain.elements)
    assert all(chain.modes)
    assert d.constraints.outcome == SOLVED


def convex_accelerations(chain):
    """Return t·a of all elements from a dense solver of the convex problem of Coulomb's law."""
    limits, (size, vectors) = chain.limits()[1], np.linalg.eigh(chain.mobility)
    kept = size > 1e-12 * size[-1]
    root = np.sqrt(size[kept])[:, None] * vectors[:, kept].T
    right_side = -(vectors[:, kept].T @ chain.bias) / np.sqrt(size[kept])
    forces = lsq_linear(root, right_side, (-limits, limits), method="bvls", tol=1e-14).x
    return chain.bias + chain.mobility @ forces


@pytest.mark.full("more cases", but=8)
@pytest.mark.parametrize("holding", [1.0, 1.3])
@pytest.mark.parametrize("part", [1e-4, 1e-3, 0.9])
@pytest.mark.parametrize("seed", range(8))
def test_dependent_constraints_are_held_if_any_share_of_the_load_allows_it(seed, part, holding):
    """Of two contacts in one place, one carries a small part of the load, and the other the rest."""
    chain = Doubled(seed)
    d = chain.d
    d.law.friction[:], d.drive.friction[:] = 1e9, 1e9
    d.law.static_friction[:] = d.law.friction
    d.friction_element.mode[chain.elements] = STICKS
    choose_friction_modes(d, True)
    weak, strong = chain.twins
    needed = abs(d.friction_element.force[weak] + d.friction_element.force[strong])
    for e, share in ((weak, part), (strong, 1.0)):
        d.law.friction[e] = share * needed / d.contacts.force[e]
        d.law.static_friction[e] = holding * d.law.friction[e]
    choose_friction_modes(d, True)
    reached, scale = chain.accelerations(), np.abs(chain.bias).max()
    np.testing.assert_allclose(reached, 0.0, atol=1e-9 * scale)
    assert chain.modes[chain.elements.index(strong)] == STICKS
    held = chain.limits()[0]
    assert (np.abs(d.friction_element.force[chain.elements]) <= held * (1.0 + 1e-9)).all()
    # below the load of both contacts, some elements slide, with the accelerations of the unique solution
    d.law.friction[strong] *= 0.9 * (1.0 - part)
    d.law.static_friction[:] = d.law.friction
    choose_friction_modes(d, True)
    expected = convex_accelerations(chain)
    assert np.abs(expected).max() > 1e-6 * scale
    np.testing.assert_allclose(chain.accelerations(), expected, atol=1e-6 * scale)


@pytest.mark.parametrize("sign", [1, -1])
def test_sliding_may_go_on_backward_as_it_does_when_it_begins(record_and_element, sign):
    """A backward speed is an error; if forces have decided the mode, twice this speed is allowed."""
    d, c = record_and_element
    d.friction_element.mode[c], d.friction_element.decided_by_forces[c] = sign, 1
    d.scratch.acceleration.x[:], d.scratch.acceleration.y[:] = 0.0, 0.0
    for speed, slack in ((-3e-13, 6e-13), (3e-13, 0.0), (0.0, 0.0)):
        move_at(d, c, sign * speed)
        set_slack(d, c)
        widen_slack(d, c)
        assert d.friction_element.slack[c] == pytest.approx(slack, rel=1e-10, abs=1e-25)
    move_at(d, c, -sign * 3e-13)
    d.friction_element.decided_by_forces[c] = 0
    set_slack(d, c)
    widen_slack(d, c)
    assert d.friction_element.slack[c] == 0.0


@pytest.mark.parametrize("sign", [1, -1])
def test_an_undecided_element_may_move_backward_by_the_tolerance(record_and_element, sign):
    """The limit is the larger of the tolerance and twice the present speed; the force is at its limit."""
    d, c = record_and_element
    d.friction_element.mode[c], d.friction_element.decided_by_forces[c] = sign, 1
    place = d.candidate.place[c]
    d.scratch.acceleration.x[:], d.scratch.acceleration.y[:] = 0.0, 0.0
    d.scratch.acceleration.x[place] = -sign * d.candidate.normal_y[c]
    d.scratch.acceleration.y[place] = sign * d.candidate.normal_x[c]
    allowed = d.solver.tolerance * d.chain.longest_link
    for speed, slack in ((-allowed, 2.0 * allowed), (-0.1 * allowed, allowed), (allowed, allowed)):
        move_at(d, c, sign * speed)
        set_slack(d, c)
        widen_slack(d, c)
        assert d.friction_element.slack[c] == pytest.approx(slack, rel=1e-10)
