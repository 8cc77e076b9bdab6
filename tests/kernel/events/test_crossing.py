"""Crossings of clearances over a step, against dense sampling of motions in closed form."""

# Tests: kernel/chain/prescribed_motion.py

import math

import numpy as np
import pytest

from chain_impact.kernel.constraints.geometry import clearance_and_rate
from chain_impact.kernel.events import crossing
from chain_impact.kernel.events.event_exclusion import begin_next_interval, suspect_all_candidates
from chain_impact.kernel.record.constants import CONTACT_ENDS, IMPLICIT, NO_EVENT, ONSET
from chain_impact.kernel.record.state import sundman_u_at, time_at
from tests.kernel.chains import chain, mark_touching
from tests.kernel.events.motions import SAMPLES, first_fall, moving, phi, prepare
from tests.kernel.steps import Motion, free_motion, gaps_of, set_step, translation, wall_at, walls_away


@pytest.mark.full("more cases", but=34)
@pytest.mark.parametrize("base", ["free", "pinned"])
@pytest.mark.parametrize(("near", "touching"), [(1, 0), (3, 0), (0, 1), (2, 2)])
@pytest.mark.parametrize("seed", range(8))
def test_the_first_crossing_is_the_first_fall_through_zero(seed, near, touching, base):
    d, motion = moving([seed, near, touching], near=near, touching=touching, base=base)
    d.contacts.event[:] = 7
    theta, whose = first_fall(d, motion)
    result = crossing.find_crossing(d)
    if theta < 0.0:
        assert result == -1.0
        return
    assert result * d.step.size == pytest.approx(theta * d.step.size, abs=1e-13)
    assert d.contacts.event[whose] == (CONTACT_ENDS if d.contacts.active[whose] else ONSET)
    assert not np.delete(d.contacts.event, whose).any()
    # the candidates' clearances are measured at the time of the crossing
    np.testing.assert_allclose(d.search.phi_end, phi(d, motion, result)[0], rtol=0, atol=1e-12)


@pytest.mark.parametrize("depth", [1e-2, 1e-6, 1e-9])
@pytest.mark.parametrize("falling", [1.0, -1.0])
def test_a_dip_between_the_ends_of_a_step_is_found(falling, depth):
    """g = a (t − ½)² ∓ depth: a point of a chain without rotation dips into the wall, or turns before it."""
    _, d = chain(np.random.default_rng(1), 1)
    motion = free_motion(np.random.default_rng(2), d, speed=0.0, bend=0.0)
    c = 1  # the base at the floor
    a = 2.0
    half = 3
    motion.coefficients[:, 1] = 0.25 * a, -a, a
    motion.coefficients[:2, half + 1] = -a, 2.0 * a
    walls_away(d)
    set_step(d, motion, 1.0)
    wall_at(d, c, motion.at(0.5), -falling * depth)
    prepare(d)
    result = crossing.find_crossing(d)
    if falling < 0.0:
        assert result == -1.0
    else:
        expected = 0.5 - math.sqrt(depth / a)
        assert result == pytest.approx(expected, abs=1e-12 + 1e-16 / depth)
        assert d.contacts.event.tolist() == [int(k == c) * ONSET for k in range(d.candidate_count)]


@pytest.mark.parametrize("seed", range(4))
def test_only_suspects_are_followed(seed):
    d, motion = moving(seed, size=1.0)
    crossing_ones = np.flatnonzero((phi(d, motion, SAMPLES) < 0.0).any(axis=0))
    result = crossing.find_crossing(d)
    assert result >= 0.0
    (first,) = np.flatnonzero(d.contacts.event)
    for suspects in (crossing_ones, np.setdiff1d(crossing_ones, [first])):
        d.contacts.event[:] = NO_EVENT
        suspect_all_candidates(d)
        crossing.measure_clearances(d, 0.0)
        begin_next_interval(d)
        d.search.suspect_count = len(suspects)
        d.search.suspect_index[: len(suspects)] = suspects
        others = np.setdiff1d(np.arange(d.candidate_count), suspects)
        for field in ("phi_start", "phi_start_rate", "phi_end", "phi_end_rate", "curvature"):
            d.search[field][others] = math.nan
        again = crossing.find_crossing(d)
        if first in suspects:
            assert again == pytest.approx(result, abs=1e-14)
        else:
            assert again == -1.0 or again > result
        assert set(np.flatnonzero(d.contacts.event)) <= set(suspects)


@pytest.mark.parametrize(("clock", "counted"), [(0.0, False), (1e4, True)])
def test_points_that_arrive_at_one_moment_are_one_event(clock, counted):
    """Arrivals within 1e-12 s, or within the resolution of time, are one event."""
    _, d = chain(np.random.default_rng(1), 4)
    motion = translation(d, [0.3], [0.5, -2.0])
    walls_away(d)
    set_step(d, motion, 1.0, start=clock)
    floor = [c for c in range(d.candidate_count) if d.candidate.wall[c] == 2]
    for c, late in zip(floor, (0.0, 1e-9, 1e-13, 0.3, 3e-12), strict=True):
        wall_at(d, c, motion.at(0.0), 2.0 * (0.4 + late))
    prepare(d)
    assert crossing.find_crossing(d) == pytest.approx(0.4, abs=1e-11)
    assert d.contacts.event[floor].tolist() == [
        ONSET,
        NO_EVENT,
        ONSET,
        NO_EVENT,
        ONSET if counted else NO_EVENT,
    ]


def test_a_search_ends_when_its_cost_is_used_up():
    d, _ = moving(0, near=1)
    d.solver.work_limit, d.statistics.rhs_evaluations = 10.0, 1000
    before = d.budget.other_cost
    assert crossing.find_crossing(d) == -1.0
    assert d.budget.other_cost == before


@pytest.mark.parametrize("base", ["free", "pinned"])
@pytest.mark.parametrize("seed", range(5))
def test_the_curvature_of_a_clearance_is_bounded_and_not_by_too_much(seed, base):
    """The reference is |g̈| over the step, by second differences, for walls along an axis and at an angle."""
    d, motion = moving(seed, count=3, size=0.2, base=base)
    h = 1e-4
    for t in np.linspace(h, 0.2 - h, 9):
        parts = [gaps_of(d, motion.at(t + k * h)) for k in (-1, 0, 1)]
        second = np.abs(parts[0] - 2.0 * parts[1] + parts[2]) / h**2
        assert (second <= d.search.curvature + 1e-4).all()  # round-off of differences
    # L (|α| + ω²) of all preceding links and the base's acceleration; both bounds are sharp at the ends
    n = d.link_count
    turns = [np.abs(motion.at(t)[n + 4 : 2 * n + 4]).max(axis=0) for t in (0.0, 0.2)]
    bends = np.abs(motion.at(0.0, 1)[n + 2 : 2 * n + 4]).sum()
    most = bends * (1.0 + d.chain.length.max()) + d.chain.reach * np.max(turns) ** 2 * 4.0
    assert (d.search.curvature < 3.0 * most + 1.0).all()


def test_contacts_in_an_implicit_step_have_their_own_bound():
    d, _ = moving(3, touching=2)
    held = d.contacts.active_index[:2]
    before = d.search.curvature.copy()
    mark_touching(d, [])
    crossing.bound_curvature(d)
    np.testing.assert_array_equal(d.search.curvature, before)
    mark_touching(d, held)
    d.step.last_method = IMPLICIT
    crossing.bound_curvature(d)
    assert (d.search.curvature[held] != before[held]).all()
    np.testing.assert_array_equal(np.delete(d.search.curvature, held), np.delete(before, held))


@pytest.mark.parametrize(("rate", "curvature"), [(-1.0, 0.0), (-1.0, 1e9), (1.0, 0.0)])
def test_an_overdue_event_is_where_the_clearance_falls(rate, curvature):
    """The event is at the start of a bracket of falling φ, otherwise at the end of the bracket."""
    d, motion = moving(0, near=1)
    c = 0
    crossing.measure_clearances(d, 0.75)
    d.search.phi_start[c], d.search.phi_start_rate[c], d.search.curvature[c] = -1e-3, rate, curvature
    expected = 0.25 if rate < 0.0 else 0.75
    assert crossing.find_root(d, c, 0.25, 0.75) == expected
    np.testing.assert_allclose(d.search.phi_end, phi(d, motion, expected)[0], rtol=0, atol=1e-12)


@pytest.mark.parametrize("seed", [28, 53])
def test_the_search_ends_where_newtons_method_stays(seed, monkeypatch):
    """An end of the bracket may be the root, which bisection would approach in fifty evaluations."""
    d, _ = moving(seed)
    places, locate_at = [], crossing.locate_at_fraction
    monkeypatch.setattr(
        crossing, "locate_at_fraction", lambda d, theta: (places.append(theta), locate_at(d, theta))
    )
    assert crossing.find_crossing(d) > 0.0
    assert len(places) < 25


def test_a_regularized_contact_ends_at_the_root_of_u():
    rng = np.random.default_rng(4)
    _, d = chain(rng, 2)
    motion = free_motion(rng, d)
    motion.coefficients[:, sundman_u_at(2)] = 0.6, -1.0, 0.2
    motion.coefficients[:, time_at(2)] = 0.0, 0.3, 0.0
    walls_away(d)
    set_step(d, motion, 1.0)
    rates = [clearance_and_rate(d, c)[1] for c in range(d.candidate_count)]
    c = int(np.argmax(rates))
    d.step.regularized_candidate = c
    mark_touching(d, [c])
    # u′ is close to the rate of the motion: the point leaves where u falls to zero
    d.contacts.expected_penetration[c], d.contacts.latched_speed[c] = 0.5 * rates[c] / 0.7, 1.0
    prepare(d)
    assert crossing.find_crossing(d) == pytest.approx((1.0 - math.sqrt(1.0 - 0.8 * 0.6)) / 0.4, abs=1e-12)
    assert d.contacts.event[c] == CONTACT_ENDS


@pytest.mark.parametrize("seed", range(4))
def test_clearances_bend_in_a_regularized_step_by_no_more_than_its_bound(seed):
    """d²g/ds² = p d(ġ)/ds + p′ ġ, p = u/(1 + u²), with dy/ds = p dy/dt in a step of s."""
    rng = np.random.default_rng(seed)
    _, d = chain(rng, 2)
    fine, h = np.linspace(0.0, 0.5, 2001), 0.5 / 2000
    u = 0.8 - 0.6 * fine
    p = u / (1.0 + u * u)
    time = np.concatenate([[0.0], np.cumsum(0.5 * h * (p[1:] + p[:-1]))])
    free = free_motion(rng, d)
    states = free.at(time).T
    states[:, sundman_u_at(2)], states[:, time_at(2)] = u, time
    parts = np.polynomial.polynomial.polyfit(fine, states, 7)
    walls_away(d)
    set_step(d, Motion(parts), 0.5, regularized=0)
    d.contacts.expected_penetration[:] = d.contacts.latched_speed[:] = 1.0
    suspect_all_candidates(d)
    crossing.bound_curvature(d)
    gaps = gaps_of(d, states[::20])
    second = np.abs(gaps[2:] - 2.0 * gaps[1:-1] + gaps[:-2]) / (20 * h) ** 2
    assert (second <= d.search.curvature + 1e-4).all()
    assert (d.search.curvature < 1e3).all()
