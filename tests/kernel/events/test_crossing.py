"""Crossings of clearances over a step, against dense sampling of motions in closed form."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from chain_impact.kernel.chain.state import omega_at, sundman_u_at, time_at, velocity_at
from chain_impact.kernel.events import crossing
from chain_impact.kernel.events.crossing import CROSSES, QUIET, SPLIT
from chain_impact.kernel.events.exclusion import keep_start, suspect_all
from chain_impact.kernel.events.marks import END, NONE, ONSET
from chain_impact.kernel.ode.control import IMPLICIT
from chain_impact.kernel.ode.dense import rate_bounds
from chain_impact.kernel.ode.sundman import NO_CONTACT
from chain_impact.kernel.rows.geometry import clearance
from tests.kernel.chains import chain, stopped_chain, stops_of, touch
from tests.kernel.steps import Motion, free_motion, gaps_of, set_step, translation, wall_at, walls_away

SAMPLES = np.linspace(0.0, 1.0, 2001)


def moving(seed, *, count=2, size=0.4, near=3, touching=0, base="free"):
    """Return a step near some walls with some candidates in contact, prepared for ``find_event``."""
    rng = np.random.default_rng(seed)
    _, d = chain(rng, count, base)
    motion = free_motion(rng, d)
    walls_away(d)
    set_step(d, motion, size, start=rng.uniform(0.0, 3.0))
    chosen = rng.choice(d.candidates, near + touching, replace=False)
    for c in chosen[:near]:
        wall_at(d, c, motion.at(0.0), rng.uniform(0.05, 0.5))
    for c in chosen[near:]:
        wall_at(d, c, motion.at(0.0), -rng.uniform(0.05, 0.5))
    touch(d, chosen[near:])
    prepare(d)
    return d, motion


def prepare(d):
    suspect_all(d)
    crossing.measure(d, 0.0)
    keep_start(d)
    crossing.bound_curvature(d)


def phi(d, motion, theta):
    """Return φ of all candidates at fractions of the step: clearances, and penetrations of contacts."""
    states = motion.at(np.atleast_1d(theta) * d.step.size).T
    return gaps_of(d, states) * np.where(d.touch.active == 1, -1.0, 1.0)


def first_fall(d, motion):
    """Return the first θ at which some φ falls through zero, and its candidate, by samples and brentq."""
    values, best = phi(d, motion, SAMPLES), (-1.0, -1)
    for c in range(d.candidates):
        falls = np.flatnonzero((values[:-1, c] > 0.0) & (values[1:, c] <= 0.0))
        if len(falls):
            low, high = SAMPLES[falls[0]], SAMPLES[falls[0] + 1]
            theta = brentq(lambda t, c=c: phi(d, motion, t)[0, c], low, high, xtol=1e-15)
            if best[0] < 0.0 or theta < best[0]:
                best = (theta, c)
    return best


@pytest.mark.full("more cases", but=34)
@pytest.mark.parametrize("base", ["free", "pinned"])
@pytest.mark.parametrize(("near", "touching"), [(1, 0), (3, 0), (0, 1), (2, 2)])
@pytest.mark.parametrize("seed", range(8))
def test_the_first_crossing_is_where_the_first_clearance_or_depth_falls_through_zero(
    seed, near, touching, base
):
    d, motion = moving([seed, near, touching], near=near, touching=touching, base=base)
    d.touch.event[:] = 7
    theta, whose = first_fall(d, motion)
    found = crossing.find_crossing(d)
    if theta < 0.0:
        assert found == -1.0
        return
    assert found * d.step.size == pytest.approx(theta * d.step.size, abs=1e-13)
    assert d.touch.event[whose] == (END if d.touch.active[whose] else ONSET)
    assert not np.delete(d.touch.event, whose).any()
    # the candidates' clearances are measured at the found time
    np.testing.assert_allclose(d.search.clear_end, phi(d, motion, found)[0], rtol=0, atol=1e-12)


@pytest.mark.parametrize("depth", [1e-2, 1e-6, 1e-9])
@pytest.mark.parametrize("falling", [1.0, -1.0])
def test_a_dip_between_the_ends_of_a_step_is_found(falling, depth):
    """g = a (t − ½)² − depth: a point of a chain without rotation dips into the wall and returns."""
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
    found = crossing.find_crossing(d)
    if falling < 0.0:
        assert found == -1.0
    else:
        expected = 0.5 - math.sqrt(depth / a)
        assert found == pytest.approx(expected, abs=1e-12 + 1e-16 / depth)
        assert d.touch.event.tolist() == [int(k == c) * ONSET for k in range(d.candidates)]


@pytest.mark.parametrize("seed", range(4))
def test_only_suspects_are_followed(seed):
    d, motion = moving(seed, size=1.0)
    crossing_ones = np.flatnonzero((phi(d, motion, SAMPLES) < 0.0).any(axis=0))
    found = crossing.find_crossing(d)
    assert found >= 0.0
    (first,) = np.flatnonzero(d.touch.event)
    for suspects in (crossing_ones, np.setdiff1d(crossing_ones, [first])):
        d.touch.event[:] = NONE
        suspect_all(d)
        crossing.measure(d, 0.0)
        keep_start(d)
        d.search.suspect_count = len(suspects)
        d.search.suspect[: len(suspects)] = suspects
        others = np.setdiff1d(np.arange(d.candidates), suspects)
        for field in ("clear_start", "clear_start_rate", "clear_end", "clear_end_rate", "curvature"):
            d.search[field][others] = math.nan
        again = crossing.find_crossing(d)
        if first in suspects:
            assert again == pytest.approx(found, abs=1e-14)
        else:
            assert again == -1.0 or again > found
        assert set(np.flatnonzero(d.touch.event)) <= set(suspects)


@pytest.mark.parametrize(("clock", "counted"), [(0.0, False), (1e4, True)])
def test_points_that_arrive_at_one_moment_are_one_event(clock, counted):
    """Arrivals within 1e-12 s, or within the resolution of time, are one event."""
    _, d = chain(np.random.default_rng(1), 4)
    motion = translation(d, [0.3], [0.5, -2.0])
    walls_away(d)
    set_step(d, motion, 1.0, start=clock)
    floor = [c for c in range(d.candidates) if d.candidate.wall[c] == 2]
    for c, late in zip(floor, (0.0, 1e-9, 1e-13, 0.3, 3e-12), strict=True):
        wall_at(d, c, motion.at(0.0), 2.0 * (0.4 + late))
    prepare(d)
    assert crossing.find_crossing(d) == pytest.approx(0.4, abs=1e-11)
    assert d.touch.event[floor].tolist() == [ONSET, NONE, ONSET, NONE, ONSET if counted else NONE]


def test_a_search_ends_when_there_is_no_work_left():
    d, _ = moving(0, near=1)
    d.solver.work_limit, d.statistics.rhs_evaluations = 10.0, 1000
    work = d.limits.other_work
    assert crossing.find_crossing(d) == -1.0
    assert d.limits.other_work == work


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
    n = d.links
    turns = [np.abs(motion.at(t)[n + 4 : 2 * n + 4]).max(axis=0) for t in (0.0, 0.2)]
    bends = np.abs(motion.at(0.0, 1)[n + 2 : 2 * n + 4]).sum()
    most = bends * (1.0 + d.model.length.max()) + d.model.reach * np.max(turns) ** 2 * 4.0
    assert (d.search.curvature < 3.0 * most + 1.0).all()


def test_the_points_of_an_implicit_step_that_are_in_contact_have_their_own_bound():
    d, _ = moving(3, touching=2)
    held = d.touch.active_index[:2]
    before = d.search.curvature.copy()
    touch(d, [])
    crossing.bound_curvature(d)
    np.testing.assert_array_equal(d.search.curvature, before)
    touch(d, held)
    d.step.last_method = IMPLICIT
    crossing.bound_curvature(d)
    assert (d.search.curvature[held] != before[held]).all()
    np.testing.assert_array_equal(np.delete(d.search.curvature, held), np.delete(before, held))


@pytest.mark.parametrize(("rate", "curvature"), [(-1.0, 0.0), (-1.0, 1e9), (1.0, 0.0)])
def test_an_overdue_event_is_where_the_clearance_falls(rate, curvature):
    """The event is at the start of a bracket of falling φ, otherwise at the end of the bracket."""
    d, motion = moving(0, near=1)
    c = 0
    crossing.measure(d, 0.75)
    d.search.clear_start[c], d.search.clear_start_rate[c], d.search.curvature[c] = -1e-3, rate, curvature
    expected = 0.25 if rate < 0.0 else 0.75
    assert crossing.find_root(d, c, 0.25, 0.75) == expected
    np.testing.assert_allclose(d.search.clear_end, phi(d, motion, expected)[0], rtol=0, atol=1e-12)


@pytest.mark.parametrize("seed", [28, 53])
def test_the_search_ends_where_newtons_method_stays(seed, monkeypatch):
    """An end of the bracket may be the root, which bisection would approach in fifty evaluations."""
    d, _ = moving(seed)
    places, locate_at = [], crossing.locate_at
    monkeypatch.setattr(crossing, "locate_at", lambda d, theta: (places.append(theta), locate_at(d, theta)))
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
    rates = [clearance(d, c)[1] for c in range(d.candidates)]
    c = int(np.argmax(rates))
    d.step.regularized = c
    touch(d, [c])
    # u′ is close to the rate of the motion: the point leaves where u falls to zero
    d.touch.depth_scale[c], d.touch.impact_speed[c] = 0.5 * rates[c] / 0.7, 1.0
    prepare(d)
    assert crossing.find_crossing(d) == pytest.approx((1.0 - math.sqrt(1.0 - 0.8 * 0.6)) / 0.4, abs=1e-12)
    assert d.touch.event[c] == END


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
    d.touch.depth_scale[:] = d.touch.impact_speed[:] = 1.0
    suspect_all(d)
    crossing.bound_curvature(d)
    gaps = gaps_of(d, states[::20])
    second = np.abs(gaps[2:] - 2.0 * gaps[1:-1] + gaps[:-2]) / (20 * h) ** 2
    assert (second <= d.search.curvature + 1e-4).all()
    assert (d.search.curvature < 1e3).all()


def interval(start, end, rates, curvature, *, active=0, size=2.0):
    """Set candidate 0 with these φ and φ′ at the ends of the step, and a bound on |φ″|."""
    _, d = chain(np.random.default_rng(0), 1)
    d.step.size, d.step.regularized, d.model.size = size, -1, 1.0
    d.touch.active[0] = active
    search = d.search
    search.clear_start[:], search.clear_end[:] = 9.0, 9.0
    search.clear_start_rate[:] = search.clear_end_rate[:] = search.curvature[:] = 0.0
    search.clear_start[0], search.clear_end[0] = start, end
    search.clear_start_rate[0], search.clear_end_rate[0] = rates
    search.curvature[0] = curvature
    suspect_all(d)
    return d


@pytest.mark.parametrize(
    ("start", "end", "rates", "curvature", "verdict"),
    [
        # above its chord minus A w²/8 = 0.5 A
        (1.0, 1.0, (0.0, 0.0), 1.9, QUIET),
        (1.0, 1.0, (-1.0, 1.0), 2.1, SPLIT),
        (0.4, 1.0, (-1.0, 1.0), 1.0, SPLIT),
        (1.0, 0.4, (-1.0, 1.0), 1.0, SPLIT),
        # rates of one sign, as |φ̇_a| + |φ̇_b| > A w: φ is monotonic
        (1.0, -0.5, (-1.5, -1.0), 1.0, CROSSES),
        (1.0, 0.2, (-1.5, -1.0), 1.2, QUIET),
        (1.0, -0.5, (-1.0, -0.9), 1.0, SPLIT),
        (0.1, 0.5, (1.5, 1.0), 1.2, QUIET),
        (1.0, -0.5, (1.5, -1.0), 1.0, SPLIT),
        # the curvature is round-off
        (1.0, -0.5, (-1.0, -1.0), 0.0, CROSSES),
        (1.0, -0.5, (-1.0, 1.0), 1e-16, CROSSES),
        (-1.0, -0.5, (-1.0, 1.0), 1e-16, QUIET),
        (-1.0, -1.5, (-1.0, -1.0), 1e-16, CROSSES),
        (1.0, 1.0, (0.0, 0.0), math.nan, QUIET),
        (1.0, 1.0, (0.0, 0.0), math.inf, SPLIT),
    ],
)
def test_an_interval_is_settled_by_the_chord_or_by_the_rates(start, end, rates, curvature, verdict):
    d = interval(start, end, rates, curvature)
    assert crossing.check_candidate(d, 0, 0.0, 1.0) == verdict
    assert crossing.check_interval(d, 0.0, 1.0) == verdict
    # the interval is a part of the step, with the curvatures of that part; the rates are over s
    d.step.size = 8.0
    assert crossing.check_candidate(d, 0, 0.25, 0.5) == verdict


def test_of_several_candidates_the_one_that_is_unsettled_decides():
    d = interval(1.0, -0.5, (-1.0, -1.0), 0.0)
    assert crossing.check_interval(d, 0.0, 1.0) == CROSSES
    d.search.curvature[1], d.search.clear_end_rate[1] = 100.0, 1.0
    assert crossing.check_interval(d, 0.0, 1.0) == SPLIT
    assert crossing.check_interval(interval(1.0, 1.0, (0.0, 0.0), 0.0), 0.0, 1.0) == QUIET


@pytest.mark.parametrize("active", [0, 1])
@pytest.mark.parametrize("whole", [False, True])
def test_who_comes_a_harmless_way_by_the_end_of_the_step_may_never_get_further(whole, active):
    """A contact that ends keeps its end in this step.

    The onset of a lasting contact lies in this step or the next.
    """
    for end, harmless in ((-0.5e-12, True), (-2e-12, False)):
        d = interval(1.0, end, (-1.0, -1.0), 0.0, active=active)
        part = (0.0, 1.0) if whole else (0.0, 0.5)
        d.step.size = 1.0 if whole else 2.0
        expected = QUIET if harmless and (whole or active) else CROSSES
        assert crossing.check_candidate(d, 0, *part) == expected


@pytest.mark.parametrize("active", [0, 1])
def test_a_point_that_is_deep_without_having_moved_there_is_an_onset_but_no_end(active):
    d = interval(1e-13, -1e-9, (0.0, 1.0), 0.0, active=active)
    assert crossing.check_candidate(d, 0, 0.0, 1.0) == (QUIET if active else CROSSES)
    d.search.clear_start[0] = -1e-11  # the candidate has been at this depth before
    assert crossing.check_candidate(d, 0, 0.0, 1.0) == QUIET


@pytest.mark.parametrize(("end", "verdict"), [(-1e-3, CROSSES), (0.0, QUIET), (0.3, QUIET)])
def test_the_regularized_contact_ends_where_its_root_is_negative(end, verdict):
    d = interval(1.0, end, (1.0, 1.0), 1e9)
    d.step.regularized = 0
    assert crossing.check_candidate(d, 0, 0.0, 1.0) == verdict


@pytest.mark.parametrize("part", [1.0, 0.25])
def test_what_bends_by_round_off_barely_bends(part):
    """The curvature term A w²/8 is below 1e-15 of a link length."""
    d = interval(0.0, 0.0, (0.0, 0.0), 1.0, size=2.0)
    d.model.size = 3.0
    limit = 8.0 * 3e-15 / (2.0 * part) ** 2
    for curvature, expected in ((0.9 * limit, True), (1.1 * limit, False), (math.nan, True)):
        d.search.curvature[0] = curvature
        assert crossing.nearly_linear(d, 0, part) == expected


LINKS = 3


@pytest.fixture
def bounded():
    """Return a chain with stops, a step of random motion, and bounds of its base along the axes."""
    rng = np.random.default_rng(29)
    _, d = stopped_chain(LINKS, "pinned")
    d.step.state[:] = rng.uniform(-1.0, 1.0, d.step.state.shape)
    d.step.dense[:] = rng.uniform(-1.0, 1.0, d.step.dense.shape)
    d.step.size = 0.2
    suspect_all(d)
    first = velocity_at(LINKS)
    return d, rate_bounds(d.step, first), rate_bounds(d.step, first + 1)


def test_a_joint_is_bounded_by_the_turn_of_its_link_relative_to_the_one_before(bounded):
    d, along_x, along_y = bounded
    at, joints = omega_at(LINKS), set()
    for c in stops_of(d):
        joint = int(d.candidate.point[c])
        joints.add(joint)
        found = crossing.motion_bounds(d, c, along_x, along_y)
        values, dense = d.step.state[at + joint - 1], d.step.dense[:, at + joint - 1].copy()
        if joint > 1:
            values, dense = values - d.step.state[at + joint - 2], dense - d.step.dense[:, at + joint - 2]
        before, kept = d.step.state[0], d.step.dense[:, 0].copy()
        d.step.state[0], d.step.dense[:, 0] = values, dense
        turn, change = rate_bounds(d.step, 0)
        d.step.state[0], d.step.dense[:, 0] = before, kept
        # at the lever arm of a stop, the longest link
        assert found == pytest.approx((d.model.size * turn, d.model.size * change), rel=1e-12)
    assert joints == {1, 2, 3}


@pytest.mark.parametrize(
    ("near", "ends"),
    [
        (0.0, [1.0, 0.5, 0.25, 0.125, 0.25, 0.5, 1.0]),
        (0.3, [1.0, 0.5, 0.25, 0.5, 0.375, 0.5, 1.0]),
        (0.6, [1.0, 0.5, 1.0, 0.75, 0.625, 0.75, 1.0]),
    ],
)
def test_intervals_are_halved_where_they_must_and_as_wide_as_they_can_be_after_that(monkeypatch, near, ends):
    """The intervals of the bisection are [k/2ⁿ, (k+1)/2ⁿ], here down to 1/8 where they contain an event."""
    _, d = stopped_chain(1, "pinned")
    seen = []
    monkeypatch.setattr(crossing, "measure", lambda _, b: seen.append(b))
    monkeypatch.setattr(crossing, "keep_start", lambda _: None)
    monkeypatch.setattr(
        crossing, "check_interval", lambda _, a, b: SPLIT if a <= near < b and b - a > 0.125 else QUIET
    )
    assert crossing.find_crossing(d) == -1.0
    assert seen == ends


def test_the_curvature_of_a_stop_is_that_of_its_joint_and_of_a_point_that_of_the_links_before_it(bounded):
    d, along_x, along_y = bounded
    d.step.regularized = NO_CONTACT
    crossing.bound_curvature(d)
    reach = [0.0]
    for i in range(LINKS):
        omega, alpha = rate_bounds(d.step, omega_at(LINKS) + i)
        reach.append(reach[-1] + d.model.length[i] * (alpha + omega**2))
    for c in range(d.candidates):
        _, bend = crossing.motion_bounds(d, c, along_x, along_y)
        links = 0.0 if d.candidate.stop[c] else reach[d.candidate.point[c]]
        assert d.search.curvature[c] == pytest.approx(bend + links, rel=1e-12)
