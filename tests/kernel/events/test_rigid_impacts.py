"""Impacts at rigid walls in plain Python, against Moreau's law by dense matrices."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import pytest

from chain_impact.kernel.chain.kinematics import largest_component, locate_points
from chain_impact.kernel.constraints.geometry import clearance_and_rate, largest_coordinate
from chain_impact.kernel.constraints.impulses import SIGN_TOLERANCE
from chain_impact.kernel.equations import mechanical_energy
from chain_impact.kernel.events import rigid_impacts
from chain_impact.kernel.events.handlers import apply_events
from chain_impact.kernel.forces.active_contacts import latch_onset
from chain_impact.kernel.forces.holding import LEAST_RISE
from chain_impact.kernel.record.constants import NEIGHBOUR, NO_EVENT, ONSET, RELEASE
from tests.helpers.kernel.plain import make_rigid
from tests.helpers.models.reference import complementary_impulses, mass_matrix
from tests.kernel.chains import (
    chain,
    free_coordinates,
    gradients,
    locate_touching_state,
    mark_touching,
    move_wall_to_depth,
    potential_slopes,
    stopped_chain,
    stops_of,
    vectors,
)

E, SLOWEST = 0.6, 1e-3
POINTS = [1, 6, 11, 16]  # candidates of a free chain: four points, each at another wall


class Touching(NamedTuple):
    """A chain at rigid walls: its record, the state y, the matrices J, M⁻¹ Jᵀ and W, and the candidates."""

    d: Any
    y: np.ndarray
    jacobian: np.ndarray
    response: np.ndarray
    w: np.ndarray
    candidates: Sequence[int]


def touching(seed, candidates=(1, 6, 11), *, base="free", kinds=ONSET, arrive=True):
    """Return a chain at rigid walls, at which candidates arrive or, with NO_EVENT, are in contact."""
    rng = np.random.default_rng(seed)
    scene, d = chain(rng, 4, base, model="newton_impact", restitution=E, minimum_impact_speed=SLOWEST)
    candidates = [c - (base == "pinned") for c in candidates]
    y = locate_touching_state(rng, d, candidates, 0.0)
    mark_touching(d, candidates if kinds == NO_EVENT else [])
    d.contacts.event[candidates] = kinds
    angles, free = y[2:6], free_coordinates(d)
    jacobian, response = gradients(scene, d, angles, candidates), np.zeros((6, len(candidates)))
    response[free] = np.linalg.solve(mass_matrix(scene, angles)[free, free], jacobian[:, free].T)
    w = jacobian @ response
    if arrive:  # the points arrive at given speeds
        aims = -rng.uniform(0.2, 2.0, len(candidates))
        y[6:12] += response @ np.linalg.solve(w, aims - jacobian @ y[6:12])
    d.step.state_end[:] = y
    d.step.start, d.step.end, d.step.communication_point = 1.0, 1.5, 1.2
    # values from an earlier problem
    d.constraints.target_motion[:] = 5.0
    d.constraints.in_active_set[:] = 0
    d.constraints.unforced_motion[:] = 5.0
    d.scratch.applied_force.x[:] = 9.0
    locate_points(d, y)
    return Touching(d, y, jacobian, response, w, candidates)


def kinetic(d, y):
    locate_points(d, y)
    return mechanical_energy(d, y)[0]


@pytest.mark.full("more cases", but=23)
@pytest.mark.parametrize("base", ["free", "pinned"])
@pytest.mark.parametrize("count", [1, 2, 3])
@pytest.mark.parametrize("seed", range(4))
def test_an_impact_is_moreaus(seed, count, base):
    """u⁺ = u⁻ + W p, 0 ≤ p ⟂ u⁺ + e u⁻ ≥ 0. The lost energy is dissipated, and all impacts are logged."""
    d, y, jacobian, response, w, candidates = touching([seed, count], POINTS[:count], base=base)
    before, there = jacobian @ y[6:12], kinetic(d, y)
    p = complementary_impulses(w, before, -E * before)
    d.scratch.position.x[:], d.scratch.velocity.x[:] = 9.0, 9.0  # located elsewhere
    rigid_impacts.handle_rigid_impacts(d)
    after = d.step.state_end
    np.testing.assert_allclose(after[6:12], y[6:12] + response @ p, rtol=0, atol=1e-9)
    np.testing.assert_allclose(after[:6], y[:6], rtol=0, atol=1e-12)
    assert after[12] - y[12] == pytest.approx(there - kinetic(d, after), abs=1e-9)
    np.testing.assert_allclose(d.quadrature.integral[candidates], p, rtol=1e-9, atol=1e-9)
    assert d.impact.count == count
    assert not d.contacts.event.any()
    # all points leave with a speed, and no contact lasts
    assert d.contacts.active_count == 0
    assert d.contact_log.count == count
    rows = slice(0, count)
    np.testing.assert_array_equal(d.contact_log.onset[rows], 1.5)
    np.testing.assert_array_equal(d.contact_log.end[rows], 1.5)
    assert not d.contact_log.peak_force[rows].any()
    np.testing.assert_allclose(d.contact_log.impact_speed[rows], -before, rtol=1e-9)
    np.testing.assert_allclose(d.contact_log.separation_speed[rows], before + w @ p, rtol=1e-8)
    np.testing.assert_allclose(d.contact_log.impulse[rows], p, rtol=1e-9, atol=1e-9)
    # without contacts the loads are zero
    assert not vectors(d.scratch.applied_force).any()


@pytest.mark.parametrize("seed", range(6))
def test_a_slow_arrival_comes_to_rest_and_is_held_while_the_wall_pushes(seed):
    """0 ≤ F ⟂ g̈ ≥ 0, where g̈ comes from gravity alone because all speeds are small."""
    d, y, jacobian, response, w, candidates = touching(seed)
    y[6:12] = 0.0
    y[6:12] = response @ np.linalg.solve(w, np.full(3, -0.5 * SLOWEST))
    d.step.state_end[:] = y
    d.chain.gravity[:] = -3.0 * d.chain.gravity if seed % 2 else d.chain.gravity
    rigid_impacts.handle_rigid_impacts(d)
    after = d.step.state_end
    # 0 ≤ p ⟂ u⁺ ≥ 0: a point leaves if no push can stop the point
    speeds = np.full(3, -0.5 * SLOWEST)
    reached = speeds + w @ complementary_impulses(w, speeds, np.zeros(3))
    np.testing.assert_allclose(jacobian @ after[6:12], reached, rtol=0, atol=1e-12)
    stay = np.flatnonzero(reached < rigid_impacts.LEAST_REBOUND_SPEED * SLOWEST)
    accelerations = -response.T @ potential_slopes(d, after)
    locate_points(d, after)
    force = complementary_impulses(w[np.ix_(stay, stay)], accelerations[stay], np.zeros(len(stay)))
    held = [candidates[k] for k, f in zip(stay, force, strict=True) if f > 0.0]
    assert d.contacts.active_index[: d.contacts.active_count].tolist() == held
    assert d.contact_log.count == 3 - len(held)
    for k in stay:
        gap, _ = clearance_and_rate(d, candidates[k])
        apart = 0.0 if candidates[k] in held else rigid_impacts.RELEASE_CLEARANCE * d.chain.longest_link
        assert gap == pytest.approx(apart, abs=3e-14)
    assert not d.contacts.event.any()


def test_points_that_all_but_touch_are_neighbours():
    d = touching(0, (1,)).d
    limit = rigid_impacts.NEAR_WALL_CLEARANCE * rigid_impacts.release_clearance(d, 2, largest_coordinate(d))
    for c, part_of in ((2, 0.5), (5, 0.99), (9, 1.5), (13, -3.0)):
        move_wall_to_depth(d, c, -part_of * limit)
    d.contacts.active[1] = d.contacts.active[13] = 1
    d.contacts.event[:] = NO_EVENT
    rigid_impacts.join_near_contacts(d)
    assert np.flatnonzero(d.contacts.active).tolist() == [1, 2, 5, 13]
    assert np.flatnonzero(d.contacts.event == NEIGHBOUR).tolist() == [2, 5]


@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
def test_fast_arrivals_rebound_and_slow_arrivals_rest(restitution):
    """e = 0 for a held contact, for a slow arrival, and for a rebound too slow to leave."""
    contacts = touching(1, POINTS, kinds=NO_EVENT)
    d, y, response, w, candidates = contacts.d, contacts.y, contacts.response, contacts.w, contacts.candidates
    d.contacts.event[candidates] = ONSET, NEIGHBOUR, NO_EVENT, ONSET
    speeds = np.array([-1.0, -1.0, -1.0, -0.5 * SLOWEST])
    y[6:12] = response @ np.linalg.solve(w, speeds)
    locate_points(d, y)
    d.law.restitution[:] = restitution
    lost, moved = rigid_impacts.find_impulses(d, 1.0)
    own = d.constraints
    np.testing.assert_allclose(own.unforced_motion[:4], speeds, rtol=1e-8)
    np.testing.assert_allclose(own.target_motion[:4], [restitution, restitution, 0.0, 0.0], rtol=1e-8)
    p = complementary_impulses(w, speeds, own.target_motion[:4])
    np.testing.assert_allclose(own.impulse[:4], p, rtol=0, atol=1e-8)
    after = y.copy()
    after[6:12] += response @ p
    assert lost == pytest.approx(kinetic(d, y) - kinetic(d, after), rel=1e-8)
    assert moved == pytest.approx(p @ (np.abs(speeds) + np.abs(speeds + w @ p)), rel=1e-8)


@pytest.mark.parametrize(("times", "aims"), [(0.9, 0.0), (1.1, 1.0)])
def test_rebounds_too_slow_to_leave_are_none(times, aims):
    contacts = touching(1, (1,), kinds=NO_EVENT)
    d, y, response, w = contacts.d, contacts.y, contacts.response, contacts.w
    d.contacts.event[1] = ONSET
    speed = -2.0 * SLOWEST
    y[6:12] = response @ np.linalg.solve(w, [speed])
    locate_points(d, y)
    rebound = times * rigid_impacts.LEAST_REBOUND_SPEED * SLOWEST
    d.law.restitution[:] = rebound / -speed
    rigid_impacts.find_impulses(d, 1.0)
    assert d.constraints.target_motion[0] == pytest.approx(aims * rebound, rel=1e-9)


@pytest.mark.parametrize("short", [0.0, 0.5, 2.0])
def test_impulses_fall_short_by_more_than_round_off(short):
    d = touching(1, POINTS, kinds=NO_EVENT).d
    d.constraints.target_motion[:4] = 0.5
    d.constraints.reached_motion[:4] = (
        0.5,
        0.9,
        0.5 - short * rigid_impacts.IMPACT_ROUND_OFF * largest_component(d, d.scratch.velocity),
        0.5,
    )
    assert rigid_impacts.lacks_rebound(d) == (short > 1.0)


@pytest.mark.parametrize("speed", [-0.7, 0.3])
def test_a_neighbour_takes_part_in_an_impact_and_brings_no_energy(speed):
    """A neighbour with u⁻ > 0 that is pressed in could gain energy.

    The impact is then computed with e = 0.
    """
    gains = 0
    for seed in range(12):
        d, y, _, response, w, (first, second) = touching(seed, (1, 4))
        d.law.restitution[:], d.contacts.event[second] = 1.0, NO_EVENT
        speeds = np.array([-1.0, speed])
        y[6:12] = response @ np.linalg.solve(w, speeds)
        d.step.state_end[:] = y
        there, lost = kinetic(d, y), y[12]
        p = complementary_impulses(w, speeds, np.maximum(0.0, -speeds))
        if p[1] > 1e-9 and speed > 0.0:
            gains += 1
            p = complementary_impulses(w, speeds, np.zeros(2))
        rigid_impacts.handle_rigid_impacts(d)
        np.testing.assert_allclose(d.quadrature.integral[[first, second]], p, rtol=1e-7, atol=1e-9)
        after = kinetic(d, d.step.state_end)
        assert d.step.state_end[12] - lost == pytest.approx(there - after, abs=1e-9 * there)
        assert after <= there * (1.0 + 1e-9)
        # a neighbour without an impulse has begun no contact
        assert d.impact.count == 1 + (p[1] > 1e-9)
    assert gains > 2 or speed < 0.0


def test_errors_of_held_contacts_are_corrected_without_an_impulse():
    for act in (apply_events, rigid_impacts.update_active_set):
        d, y, jacobian, response, w, candidates = touching(2, (1, 6), kinds=NO_EVENT)
        # choose errors whose correction needs pushing forces and pushing impulses
        y[6:12] = response @ np.linalg.solve(w, w @ np.array([-1e-9, -2e-9]))
        d.step.state_end[:] = y
        d.scratch.velocity.x[:], d.scratch.position.x[:] = 9.0, 9.0
        before = d.quadrature.integral[candidates].tolist()
        act(d)
        assert d.quadrature.integral[candidates].tolist() == before
        np.testing.assert_allclose(jacobian @ d.step.state_end[6:12], 0.0, atol=1e-13)
        assert set(d.contacts.active.tolist()) <= {0, 1}


def test_with_nothing_that_touches_the_loads_are_those_of_a_flight():
    d = touching(2, (), arrive=False).d
    rigid_impacts.handle_rigid_impacts(d)
    assert not vectors(d.scratch.applied_force).any()


def test_contacts_that_cannot_be_stopped_by_a_push_are_over():
    """The walls would pull by more than errors explain: the points leave with their present speeds."""
    d, y, _, response, w, (first, second) = touching(2, (1, 6), kinds=NO_EVENT)
    y[6:12] = response @ (p := np.array([-0.3, 0.7]))
    d.step.state_end[:] = y
    assert (np.linalg.solve(w, -(w @ p)) < 0.0).any()
    expected = complementary_impulses(w, w @ p, np.zeros(2))
    rigid_impacts.update_active_set(d)
    np.testing.assert_allclose(d.quadrature.integral[[first, second]], expected, rtol=0, atol=1e-9)
    over = (w @ (p + expected)) > 1e-9
    assert over.any()
    rows = d.contact_log.count
    assert rows >= over.sum()
    assert d.contact_log.separation_speed[:rows].max() == pytest.approx((w @ (p + expected)).max(), rel=1e-7)


def test_points_that_leave_by_no_more_than_can_be_told_from_rest_stay():
    """A throw has the height u²/(2 a); heights below LEAST_RISE count as rest."""
    for times, stays in ((0.9, True), (1.1, False)):
        d, _y, _, _response, _w, (c,) = touching(1, (1,), kinds=ONSET)
        latch_onset(d, c)
        d.step.end = 2.0
        mark_touching(d, [c])
        d.law.minimum_impact_speed[:] = 1e-12
        d.step.state_end[6:12] = 0.0
        d.chain.gravity[:] = 0.0, -9.81
        slow = math.sqrt(2.0 * 9.81 * LEAST_RISE * d.chain.longest_link)
        locate_points(d, d.step.state_end)
        d.constraints.impulse[0] = 1.0
        d.constraints.reached_motion[0] = times * slow
        rigid_impacts.end_rebounding_contacts(d)
        assert (d.contacts.active_count == 1) == stays
        assert d.contact_log.count == (0 if stays else 1)


@pytest.mark.parametrize(
    ("event", "impulse", "met"), [(NEIGHBOUR, 0.0, 0), (NEIGHBOUR, 1.0, 1), (ONSET, 0.0, 1)]
)
def test_a_neighbour_without_an_impulse_was_not_met(event, impulse, met):
    d = touching(1, (1,), kinds=NO_EVENT).d
    d.contacts.event[1], d.constraints.impulse[0], d.constraints.reached_motion[0] = event, impulse, 0.0
    rigid_impacts.end_rebounding_contacts(d)
    assert d.contacts.active[1] == d.contacts.active_count == met
    assert d.contact_log.count == 0


def test_contacts_end_where_they_stand_for_another_law():
    d, y = touching(1, (1, 6, 11), kinds=NO_EVENT, arrive=False)[:2]
    d.scratch.velocity.x[:] = 99.0
    rates = []
    locate_points(d, y)
    for c in (1, 6, 11):
        rates.append(max(0.0, clearance_and_rate(d, c)[1]))
    d.scratch.velocity.x[:] = 99.0
    d.law.rigid[:] = 0
    rigid_impacts.end_changed_contacts(d)
    assert d.contacts.active_count == 0
    assert not d.contacts.active.any()
    np.testing.assert_array_equal(d.contact_log.separation_speed[:3], rates)


def test_contacts_that_no_push_can_bring_to_rest_are_let_go():
    """A contact that is not pressed ends if its speed exceeds the round-off of the fastest point's speed."""
    d = touching(1, POINTS, kinds=NO_EVENT).d
    scale = largest_component(d, d.scratch.velocity)
    d.constraints.in_active_set[:4] = 0, 0, 1, 0
    d.constraints.reached_motion[:4] = 0.5 * SIGN_TOLERANCE * scale, 2.0 * SIGN_TOLERANCE * scale, 1.0, 0.0
    rigid_impacts.end_unstopped_contacts(d)
    assert d.contacts.active_index[: d.contacts.active_count].tolist() == [1, 11, 16]
    assert d.contact_log.point[0] == d.candidate.point[6]


def test_released_points_leave_the_wall_and_held_points_stay():
    d = touching(1, POINTS[:3], kinds=NO_EVENT).d
    d.constraints.in_active_set[:3] = 1, 0, 1
    rigid_impacts.release_contacts(d)
    locate_points(d, d.step.state_end)
    gaps = [clearance_and_rate(d, c)[0] for c in POINTS[:3]]
    np.testing.assert_allclose(
        gaps, [0.0, rigid_impacts.RELEASE_CLEARANCE * d.chain.longest_link, 0.0], rtol=0, atol=3e-14
    )
    assert d.contacts.active[POINTS].tolist() == [1, 0, 1, 0]
    # nothing moves when all points are held
    before = d.step.state_end.copy()
    d.constraints.in_active_set[:3] = 1
    mark_touching(d, POINTS[:1])
    rigid_impacts.release_contacts(d)
    np.testing.assert_array_equal(d.step.state_end, before)


@pytest.mark.parametrize("away", [0.0, 30.0, 1e4])
def test_a_released_point_all_but_touches_at_any_distance(away):
    d, y = touching(1, POINTS[:1], kinds=NO_EVENT)[:2]
    y[:2] += away * d.chain.longest_link
    locate_points(d, y)
    move_wall_to_depth(d, 1, 0.0)
    d.step.state_end[:] = y
    d.constraints.in_active_set[:1] = 0
    rigid_impacts.release_contacts(d)
    locate_points(d, d.step.state_end)
    gap, _ = clearance_and_rate(d, 1)
    farthest = max(np.abs(vectors(d.scratch.position)).max(), d.chain.longest_link)
    expected = max(1e-13 * d.chain.longest_link, 1e-14 * farthest)
    assert gap == pytest.approx(expected, abs=3e-16 * farthest)
    d.contacts.event[:] = NO_EVENT
    rigid_impacts.join_near_contacts(d)
    assert d.contacts.event[1] == NEIGHBOUR
    # the energy of a fall over this gap is too little to leave
    d.contacts.event[1] = ONSET
    weight = d.chain.mass.sum() * d.chain.gravity_magnitude
    d.contacts.effective_mass[1], d.contacts.impact_speed[1] = 1.0, math.sqrt(2.0 * weight * gap)
    d.law.minimum_impact_speed[:] = 0.0
    assert rigid_impacts.is_gentle(d)


def test_the_gap_of_a_joints_stop_does_not_grow_with_the_distance():
    _, d = stopped_chain(3)
    y = d.step.state_end
    y[2:5] = 0.0, 1.1, 0.0
    c = stops_of(d)[0]
    locate_points(d, y)
    near = rigid_impacts.release_clearance(d, c, largest_coordinate(d))
    y[:2] += 1e6
    locate_points(d, y)
    assert (
        rigid_impacts.release_clearance(d, c, largest_coordinate(d)) == near == 1e-13 * d.chain.longest_link
    )
    assert rigid_impacts.release_clearance(d, 0, largest_coordinate(d)) >= 1e-8
    # an angle of many turns has a larger round-off
    y[3:5] += 1e4
    assert rigid_impacts.release_clearance(d, c, largest_coordinate(d)) > 5e-11 * d.chain.longest_link


def test_a_release_is_a_first_guess_of_who_is_let_go():
    """For any first guess, the held points are those that need a force."""
    results = []
    for event in (NO_EVENT, RELEASE):
        contacts = touching(3, kinds=NO_EVENT)
        d, y, candidates = contacts.d, contacts.y, contacts.candidates
        y[6:12] = 0.0
        d.step.state_end[:] = y
        d.contacts.event[candidates] = event
        rigid_impacts.update_active_set(d)
        results.append(d.contacts.active.tolist())
        assert not d.contacts.event.any()
    assert results[0] == results[1]


def test_an_impact_updates_rates_and_kink_sides_of_force_contacts(monkeypatch):
    rng = np.random.default_rng(47)
    _, d = chain(rng, 2)
    touched, sides = [0, 5, 9], []
    y = locate_touching_state(rng, d, touched)
    make_rigid(d, np.arange(d.candidate_count) == 5)
    d.step.state_end[:] = y
    d.scratch.velocity.x[:] = 1e9  # velocities of an earlier state
    d.contacts.penetration_rate[:], d.contacts.force_rate[:] = 77.0, -5.0
    monkeypatch.setattr(rigid_impacts, "set_kink_side", lambda _, c: sides.append(int(c)))
    rigid_impacts.set_rates_after_impulses(d)
    assert sides == [0, 9]
    for c in touched:
        if c in sides:
            assert d.contacts.penetration_rate[c] == -clearance_and_rate(d, c)[1]
            assert abs(d.contacts.penetration_rate[c]) < 1e3
            assert d.contacts.force_rate[c] == 1.0
        else:
            assert (d.contacts.penetration_rate[c], d.contacts.force_rate[c]) == (77.0, -5.0)


def test_a_force_contact_begins_if_its_point_moves_inward():
    directions = set()
    for seed in range(12):
        d, y, jacobian, _, w, (rigid, soft) = touching(seed, (1, 6))
        make_rigid(d, np.arange(d.candidate_count) != soft)
        before = jacobian @ y[6:12]
        p = complementary_impulses(w[:1, :1], before[:1], -E * before[:1])
        inward = bool((before + w[:, 0] * p[0])[1] < 0.0)
        assert rigid_impacts.handle_rigid_impacts(d) == (soft if inward else -1)
        assert d.contacts.active[[rigid, soft]].tolist() == [0, inward]
        assert d.impact.count == 1 + inward
        directions.add(inward)
    assert directions == {True, False}
