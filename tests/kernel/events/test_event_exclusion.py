"""Bounds on clearances without a search: never larger than the true clearances."""

import math

import numpy as np
import pytest
from scipy.interpolate import BPoly

from chain_impact.kernel.chain.kinematics import accelerate_points, locate_points
from chain_impact.kernel.constraints.geometry import clearance_and_rate, length_bound
from chain_impact.kernel.events import event_exclusion
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.ode.sundman import root_rate
from chain_impact.kernel.record.constants import CURVATURES_KNOWN, DISTANCE_KNOWN, NOTHING_KNOWN, VALUES_KNOWN
from chain_impact.kernel.record.state import sundman_u_at, time_at
from chain_impact.kernel.status import OK
from chain_impact.scene.scene import scene_from_dict
from chain_impact.variables.prepared import PreparedScene
from tests.helpers.kernel.plain import Plain, make_rigid
from tests.kernel.chains import chain, mark_touching, random_state
from tests.kernel.steps import free_motion, gaps_of, set_step, translation, wall_at, walls_away

SAMPLES = np.linspace(0.0, 1.0, 1001)


def stepped(seed, *, size=0.1, near=0.3, count=3, base="free", touching=0, **more):
    """Return a step whose points start about ``near`` [m] from their walls, or in the walls if in contact."""
    rng = np.random.default_rng(seed)
    _, d = chain(rng, count, base, **more)
    motion = free_motion(rng, d)
    walls_away(d)
    set_step(d, motion, size, start=2.0)
    for c in range(d.candidate_count):
        wall_at(d, c, motion.at(0.0), near * rng.uniform(0.5, 1.5) * (1.0 if c >= touching else -1.0))
    mark_touching(d, range(touching))
    d.contacts.latched_speed[:] = 1e3
    d.contacts.kink_crossed[:] = d.contacts.penetration_rate[:] = 0
    d.solver.tolerance = 1e-6
    return d, motion


def phi_all(d, motion):
    """Return φ of all candidates on a fine grid of the step, shape (T, C)."""
    signs = np.where(d.contacts.active == 1, -1.0, 1.0)
    return gaps_of(d, motion.at(SAMPLES * d.step.size).T) * signs


@pytest.mark.full("more cases", but=30)
@pytest.mark.parametrize("touching", [0, 2])
@pytest.mark.parametrize("near", [0.02, 0.2, 2.0])
@pytest.mark.parametrize("seed", range(6))
def test_exclusion_keeps_every_event_and_skips_far_walls(seed, near, touching):
    d, motion = stepped([seed, touching], near=near, touching=touching)
    values = phi_all(d, motion)
    happens = (values.min(axis=0) < 0.0).any()
    excluded = event_exclusion.excludes_events(d)
    assert not (excluded and happens)
    if values.min() > 0.3 * near and near >= 0.2:
        assert excluded
    # φ and φ′ of all candidates at both ends, and φ″
    assert event_exclusion.known_clearances(d) == CURVATURES_KNOWN
    np.testing.assert_allclose(d.search.phi_start, values[0], rtol=0, atol=1e-11)
    np.testing.assert_allclose(d.search.phi_end, values[-1], rtol=0, atol=1e-11)
    h = d.step.size / 1000
    for rates, part in ((d.search.phi_start_rate, values[:3]), (d.search.phi_end_rate, values[:-4:-1])):
        sign = 1.0 if part is not values and rates is d.search.phi_start_rate else -1.0
        slope = sign * (-1.5 * part[0] + 2.0 * part[1] - 0.5 * part[2]) / h
        np.testing.assert_allclose(rates, slope, rtol=0, atol=1e-4)
    for rates, part in (
        (d.search.phi_start_curvature, values[:3]),
        (d.search.phi_end_curvature, values[-3:]),
    ):
        np.testing.assert_allclose(rates, (part[0] - 2 * part[1] + part[2]) / h**2, rtol=0, atol=2e-2)


def test_contacts_that_cross_their_kink_or_are_pushed_in_are_looked_at():
    for change in ("kink_crossed", "penetration_rate"):
        d, _ = stepped(0, near=2.0, touching=2)
        assert event_exclusion.excludes_events(d)
        d, _ = stepped(0, near=2.0, touching=2)
        d.contacts[change][1] = 1e6
        assert not event_exclusion.excludes_events(d)


def test_a_step_in_which_links_turn_far_or_inputs_change_fast_is_looked_at():
    for field in ("turn", "input_rate", "fade"):
        d, _motion = stepped(0, near=2.0)
        # one large quantity is enough, although all walls are far
        if field == "turn":
            d.scratch.rate_end[d.link_count + 4] = 2.0 / d.step.size**2 * 1.1
        elif field == "input_rate":
            d.search.input_rate = 1.1 / d.step.size
        else:
            d.chain.joint_rate_bound = 20.0 / d.step.size
        assert not event_exclusion.excludes_events(d)
        if field != "fade":
            assert d.search.suspect_index.tolist() == list(range(d.candidate_count))
        assert event_exclusion.excludes_events(stepped(0, near=2.0)[0])


@pytest.mark.parametrize("held", [False, True])
def test_the_search_follows_free_candidates_but_no_held_ones(held):
    _, d = chain(np.random.default_rng(0), 2)
    motion = translation(d, [0.0], [0.0, -1.0])
    walls_away(d)
    set_step(d, motion, 0.5, start=2.0)
    near, resting = (
        c for c in range(d.candidate_count) if d.candidate.wall[c] == 2 and d.candidate.point[c] < 2
    )
    for c in (near, resting):
        wall_at(d, c, motion.at(0.0), 0.4)
    if held:
        d.law.rigid[resting] = 1
        mark_touching(d, [resting])
    assert not event_exclusion.excludes_events(d)
    suspects = d.search.suspect_index[: d.search.suspect_count].tolist()
    assert suspects == ([near] if held else [near, resting])


@pytest.mark.parametrize("active", [False, True])
@pytest.mark.parametrize(("turn", "fade"), [(0.0, 0.0), (0.9, 0.0), (0.5, 2.0), (0.9, 3.0)])
def test_clearances_are_clear_by_more_than_their_interpolants_can_be_off(turn, fade, active):
    """The margin is ten times h⁶ φ⁽⁶⁾/46080 of a stretched chain that rotates and decays: reach ω² ρ⁴.

    Without contact the tolerance of a position is added; nothing moves in this step.
    """
    _, d = chain(np.random.default_rng(0), 2)
    off = 10.0 / 46080.0 * d.chain.length.sum() * turn**2 * max(turn, fade) ** 4
    off += 0.0 if active else d.solver.tolerance * d.chain.length.sum()
    for clear in (0.999, 1.001) if off > 0.0 else (-1e-3, 1e-3):
        motion = translation(d, [0.0], [0.0])
        walls_away(d)
        set_step(d, motion, 0.5, start=2.0)
        d.search.input_rate, d.chain.joint_rate_bound = turn / 0.5, fade / 0.5
        mark_touching(d, range(d.candidate_count) if active else [])
        d.contacts.latched_speed[:], d.contacts.penetration_rate[:] = 1.0, 0.0
        gap = (clear * off if off > 0.0 else clear) - d.law.harmless_depth[0]
        for c in range(d.candidate_count):
            wall_at(d, c, motion.at(0.0), -gap if active else gap)
        assert event_exclusion.excludes_events(d) == (clear > 1.0 or (off == 0.0 and clear > 0.0))


@pytest.mark.parametrize("active", [False, True])
@pytest.mark.parametrize("seed", range(10))
def test_a_clearance_is_above_its_least_bernstein_coefficient(seed, active):
    """The interpolant is the Hermite interpolant of order 6, by SciPy; a margin is subtracted."""
    rng = np.random.default_rng(seed)
    _, d = chain(rng, 1)
    search, c, h = d.search, 3, 0.7
    d.step.size, d.step.regularized_candidate, d.contacts.active[c] = h, -1, active
    ends = rng.normal(size=(2, 3))
    names = [[f"phi_{end}{part}" for part in ("", "_rate", "_curvature")] for end in ("start", "end")]
    for row, values in zip(names, ends, strict=True):
        for name, value in zip(row, values, strict=True):
            search[name][c] = value
    inner = BPoly.from_derivatives([0.0, h], ends).c[1:, 0]
    limit = (
        inner.min() - event_exclusion.BERNSTEIN_MARGIN * (inner.max() - inner.min()) + d.law.harmless_depth[c]
    )
    assert event_exclusion.stays_positive(d, c, limit - 1e-9)
    assert not event_exclusion.stays_positive(d, c, limit + 1e-9)


@pytest.mark.parametrize(("end", "expected"), [(0.1, True), (0.0, False), (-0.1, False)])
def test_the_root_of_the_regularized_contact_decides_by_its_end(end, expected):
    _, d = chain(np.random.default_rng(0), 1)
    d.step.regularized_candidate, d.search.phi_end[2] = 2, end
    d.search.phi_start[2] = -9.0
    assert event_exclusion.stays_in_contact(d, 2, 1e9) == expected


@pytest.mark.parametrize("known_values", [VALUES_KNOWN, CURVATURES_KNOWN, DISTANCE_KNOWN])
def test_bounds_are_kept_until_the_steps_break(known_values):
    _, d = chain(np.random.default_rng(0), 1)
    d.step.break_count = 3
    event_exclusion.remember_clearances(d, known_values)
    assert event_exclusion.known_clearances(d) == known_values
    d.step.break_count = 4
    assert event_exclusion.known_clearances(d) == NOTHING_KNOWN


@pytest.mark.parametrize("seed", range(8))
def test_walls_are_far_as_long_as_no_point_can_have_come_near(seed):
    """The stored distance is never larger than the true distance, and stays valid for some steps."""
    d, motion = stepped(seed, size=0.01, near=1.0)
    assert event_exclusion.excludes_events(d)
    least = phi_all(d, motion)[-1].min()
    assert d.search.safe_distance == pytest.approx(least, rel=1e-9)
    d.search.speed_bound = length_bound(d, d.scratch.velocity)
    d.search.acceleration_bound = length_bound(d, d.scratch.acceleration)
    lasted = 0
    for k in range(1, 40):
        y = motion.at(0.01 * (k + 1))
        d.step.state[:], d.step.state_end[:] = motion.at(0.01 * k), y
        d.step.start, d.step.end = 0.01 * k, 0.01 * (k + 1)
        locate_points(d, y)
        accelerate_points(d, y, motion.at(0.01 * (k + 1), 1))
        far = event_exclusion.remains_far(d)
        room = gaps_of(d, y).min()
        assert d.search.safe_distance <= room
        assert far == (d.search.safe_distance > event_exclusion.allowed_position_error(d))
        if not far:
            break
        assert event_exclusion.known_clearances(d) == DISTANCE_KNOWN
        lasted += 1
    assert lasted >= 2
    # no point moves further than its speed and acceleration permit, so no point or wall is inspected
    assert d.search.speed_bound == length_bound(d, d.scratch.velocity)
    assert d.search.acceleration_bound == length_bound(d, d.scratch.acceleration)


@pytest.mark.parametrize("channels", [0, 2])
def test_the_way_of_a_step_counts_the_acceleration_at_its_start(monkeypatch, channels):
    """way = h (v + h a), with the larger acceleration of both ends; nothing moves at the end."""
    d, _ = stepped(0, size=0.01, near=1.0)
    assert event_exclusion.excludes_events(d)
    d.channel_count, (safe, lasted) = channels, (d.search.safe_distance, d.step.end - d.step.start)
    monkeypatch.setattr(event_exclusion, "fastest_wall", lambda d: (0.0, 0.0))
    for vectors in (d.scratch.velocity, d.scratch.acceleration):
        vectors.x[:], vectors.y[:] = 0.0, 0.0
    d.search.speed_bound, d.search.acceleration_bound = 0.0, 100.0
    event_exclusion.remains_far(d)
    assert d.search.safe_distance == pytest.approx(safe - 100.0 * lasted * lasted)


def quiet_start(regularized=-1):
    d, _ = stepped(0, size=0.01, near=1.0)
    d.search.safe_distance, d.search.speed_bound, d.search.acceleration_bound = 5.0, 0.0, 0.0
    d.step.regularized_candidate = regularized
    event_exclusion.remember_clearances(d, CURVATURES_KNOWN)
    return d


def test_a_touching_point_is_near_unless_its_contact_is_regularized():
    d = quiet_start()
    assert event_exclusion.remains_far(d)
    for known_values in (NOTHING_KNOWN, VALUES_KNOWN):
        d = quiet_start()
        event_exclusion.remember_clearances(d, known_values)
        assert not event_exclusion.remains_far(d)
    d = quiet_start()
    mark_touching(d, [2])
    assert not event_exclusion.remains_far(d)
    for u, crossed, expected in ((0.5, 0, True), (0.0, 0, False), (-0.1, 0, False), (0.5, 1, False)):
        d = quiet_start(regularized=2)
        mark_touching(d, [2])
        d.step.state_end[sundman_u_at(d.link_count)], d.contacts.kink_crossed[2] = u, crossed
        assert event_exclusion.remains_far(d) == expected
        assert event_exclusion.known_clearances(d) == (DISTANCE_KNOWN if expected else CURVATURES_KNOWN)


@pytest.mark.parametrize("speed", [0.0, 1.4, 1.6])
@pytest.mark.parametrize("end", [0.0, 1.4, 1.6])
def test_a_contact_is_nearly_fast_at_three_quarters_of_the_relatch_speed(speed, end):
    """The check is at either end of the step."""
    d, _ = stepped(0, touching=1)
    d.contacts.latched_speed[0], d.contacts.penetration_rate[0] = 3.0, 3.0 * speed
    point = d.candidate.point[0]
    d.scratch.velocity.x[point] = -3.0 * end * d.candidate.normal_x[0]
    d.scratch.velocity.y[point] = -3.0 * end * d.candidate.normal_y[0]
    expected = max(speed, end) > event_exclusion.NEARLY_FAST * event_exclusion.RELATCH_RATIO
    assert event_exclusion.may_relatch(d, 0) == expected
    d.contacts.kink_crossed[0] = 0
    assert event_exclusion.force_stays_smooth(d, 0) == (not expected)
    d.contacts.kink_crossed[0] = 1
    assert not event_exclusion.force_stays_smooth(d, 0)


@pytest.mark.parametrize("rigid", [0, 1])
@pytest.mark.parametrize("regularized", [-1, 2])
def test_clearances_and_their_rates_are_those_in_the_variable_of_the_step(regularized, rigid):
    """φ′ = p φ̇ with p = u/(1 + u²); the regularized contact uses u and u′.

    A held point cannot touch again.
    """
    rng = np.random.default_rng(5)
    _, d = chain(rng, 2)
    y, u = random_state(rng, d), 0.6
    y[sundman_u_at(2)] = u
    locate_points(d, y)
    d.step.regularized_candidate = regularized
    make_rigid(d, rigid)
    d.contacts.expected_penetration[:] = 0.3
    mark_touching(d, [2, 4])
    pace = 1.0 if regularized < 0 else u / (1.0 + u * u)
    result = event_exclusion.sundman_u_now(d, y)
    slope = 0.0 if regularized < 0 else -0.5 * clearance_and_rate(d, 2)[1] / (0.3 * (1.0 + u * u))
    assert result == pytest.approx((1.0, 0.0) if regularized < 0 else (u, slope), rel=1e-12)
    assert event_exclusion.set_clearances(d, y) == result[1]
    for c in range(d.candidate_count):
        gap, rate = clearance_and_rate(d, c)
        sign = -1.0 if c in (2, 4) else 1.0
        expected = sign * gap, sign * pace * rate
        if c in (2, 4) and rigid:
            expected = math.inf, 0.0
        if c == regularized:
            expected = result
        assert (d.search.phi_end[c], d.search.phi_end_rate[c]) == pytest.approx(expected, rel=1e-12)
        d.search.phi_end[c] = 7.0
        event_exclusion.set_clearance(d, c, *result)
        assert d.search.phi_end[c] == pytest.approx(expected[0], rel=1e-12)
    event_exclusion.begin_next_interval(d)
    np.testing.assert_array_equal(d.search.phi_start, d.search.phi_end)
    np.testing.assert_array_equal(d.search.phi_start_rate, d.search.phi_end_rate)


@pytest.mark.parametrize("regularized", [-1, 2])
def test_second_derivatives_are_those_in_the_variable_of_the_step(regularized):
    """φ″ by differences of φ′ along dy/ds = p dy/dt."""
    rng = np.random.default_rng(6)
    _, d = chain(rng, 2)
    motion = free_motion(rng, d)
    mark_touching(d, [2, 4])
    d.contacts.expected_penetration[:], d.step.regularized_candidate = 0.3, regularized
    u, h, rates = 0.6, 1e-5, []
    y, rate = motion.at(0.0), motion.at(0.0, 1)
    y[sundman_u_at(2)] = u
    locate_points(d, y)
    pace = 1.0 if regularized < 0 else u / (1.0 + u * u)
    change = 0.0 if regularized < 0 else root_rate(d, u)
    for side in (h, -h):
        moved = motion.at(side * pace)
        moved[sundman_u_at(2)] = u + side * change
        locate_points(d, moved)
        event_exclusion.set_clearances(d, moved)
        rates.append(d.search.phi_end_rate.copy())
    locate_points(d, y)
    accelerate_points(d, y, rate)
    event_exclusion.measure_all_candidates(d, y)
    np.testing.assert_allclose(
        d.search.phi_end_curvature, (rates[0] - rates[1]) / (2 * h), rtol=1e-6, atol=1e-6
    )
    apart = [c for c in range(d.candidate_count) if c not in (2, 4)]
    assert d.search.safe_distance == d.search.phi_end[apart].min()
    assert time_at(2) == len(y) - 1


@pytest.mark.parametrize("lengths", [(2.0, 0.01), (0.01, 2.0, 0.02), (1.0, 1.0, 0.5), (2.0,)])
def test_the_error_near_a_stop_is_that_of_both_links(lengths):
    """Each angle may have an error of the tolerance; one link is far longer than the others."""
    tolerance, last = 1e-3, len(lengths)
    links = [{"length": length, "mass": 1.0} for length in lengths]
    links[-1]["joint_max"] = 0.5
    allowed = tolerance * (2.0 * max(lengths) if last > 1 else max(lengths))
    for share, excluded in ((0.9, False), (1.1, sum(lengths) <= 1.1 * allowed / tolerance)):
        angles = [0.0] * (last - 1) + [0.5 - share * allowed / max(lengths)]
        scene = scene_from_dict(
            {
                "name": "Still",
                "gravity": [0.0, 0.0],
                "chain": {"base": "pinned", "links": links},
                "solver": {"tolerance": tolerance},
                "initial": {"angles": angles},
            },
            "still",
        )
        d = Plain(PreparedScene(scene).new_instance()[0])
        assert initialize(d, 0.0) == OK
        d.step.end, d.scratch.rate_start[:] = 0.01, 0.0
        locate_points(d, d.step.state_end)
        accelerate_points(d, d.step.state_end, d.scratch.rate_start)
        assert event_exclusion.excludes_events(d) == excluded
