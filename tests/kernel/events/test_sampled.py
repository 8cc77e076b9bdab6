"""Events found by sampling a step: kinks, new latches, releases and mode changes."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from chain_impact import CONTACT_LAWS, simulate
from chain_impact.kernel.advance import advance, advance_one_step
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.events import crossing, sampled
from chain_impact.kernel.events.crossing import first_passage, locate_at
from chain_impact.kernel.events.exclusion import RELATCH_RATIO
from chain_impact.kernel.events.marks import (
    END,
    KINK,
    NONE,
    ONSET,
    RELATCH,
    RELEASE,
    SLIDING_ENDS,
    STICKING_ENDS,
    pending_changes,
)
from chain_impact.kernel.events.sampled import search_for
from chain_impact.kernel.forces.contact import begin_contact, kink_height, set_kink_sides
from chain_impact.kernel.forces.contact_force import elastic_force
from chain_impact.kernel.forces.friction import STICKS
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.ode.control import accepted
from chain_impact.kernel.rows.geometry import tangential_rate
from chain_impact.kernel.status import OK
from chain_impact.scene.scene import scene_from_dict
from chain_impact.variables.prepared import PreparedScene
from tests.helpers.coulomb_problems import braked_link, oblique_ball
from tests.helpers.plain import Plain
from tests.helpers.problems import GRAVITY, contact_table, of_law, scene_table, struck_ball
from tests.kernel.chains import chain, touch
from tests.kernel.forces.test_contact_force import MASS, SPEED, STIFFNESS, scaled_impact
from tests.kernel.rubbing import rubbing_chain
from tests.kernel.steps import held_tip, set_step, translation, wall_at, walls_away

FLOOR = 2  # the number of the wall y_min
DEEP = 0.3  # m, at the start


def falling(height, law="jankowski", size=1.0, touching=(1,)):
    """Return contacts of a chain that moves to and from the floor without rotation: δ = DEEP − height(t)."""
    _, d = chain(np.random.default_rng(0), 2, **of_law(law), stiffness=4.0, restitution=0.5)
    motion = translation(d, [0.3, 0.1], height)
    walls_away(d)
    assert all(d.candidate.wall[c] == FLOOR for c in touching)
    for c in touching:
        wall_at(d, c, motion.at(0.0), -DEEP)
    locate_points(d, motion.at(0.0))
    touch(d, touching)
    for c in touching:
        begin_contact(d, c)
    d.touch.kink_margin[:] = 0.0
    set_kink_sides(d)
    set_step(d, motion, size, start=2.0)
    return d, motion


STEP = SimpleNamespace(step=SimpleNamespace(size=10.0))


def four(_d):
    return 4


def find_force_event(d, found):
    """Return θ of the event ``found``, or of an earlier event of a contact with a force."""
    return sampled.find_kink(d, sampled.find_relatch(d, found))


@pytest.mark.parametrize(("resolution", "halvings"), [(0.0, 50), (1e-12, 44)])
@pytest.mark.parametrize("shape", ["linear", "curved", "step"])
@pytest.mark.parametrize("end", [1.0, 0.6])
@pytest.mark.parametrize("place", [0.05, 0.31, 0.59])
def test_the_first_passage_is_where_a_function_falls_below_zero(place, end, shape, resolution, halvings):
    asked = []

    def function(record, c, theta):
        assert (record, c) == (STEP, 7)
        asked.append(theta)
        if shape == "step":
            return 1.0 if theta < place else -1e-9
        return place - theta if shape == "linear" else place**3 - theta**3

    found = first_passage(function, four, resolution)(STEP, 7, end)
    assert found == pytest.approx(place, abs=max(2.0 * crossing.FINEST, resolution / 10.0))
    assert max(asked) <= end
    # four samples and the start of a bracket; then the fast method, or bisection where the method fails
    assert len(asked) <= (18 if shape != "step" else 5 + 20 + halvings)


def test_what_is_below_zero_at_no_sample_is_not_found_and_the_first_that_is_is():
    def found(place, *others):
        below = (place, *others)

        def sign(_d, _c, x):
            return -1.0 if any(a < x < b for a, b in below) else 1.0

        return first_passage(sign, four, 0.0)(STEP, 0, 1.0)

    assert found((0.3, 0.4)) == -1.0
    assert found((0.2, 0.3), (0.7, 2.0)) == pytest.approx(0.2, abs=1e-14)


def test_the_ends_of_a_step_are_its_states_to_the_last_bit():
    d, _ = falling([0.0, -1.0, 0.5])
    d.step.state[0] += 1e-3
    d.step.state_end[0] -= 1e-3
    for theta, state in ((0.0, d.step.state), (1.0, d.step.state_end)):
        locate_at(d, theta)
        np.testing.assert_array_equal(d.work.y, state)


@pytest.mark.parametrize("law", ["kelvin_voigt", "tsuji"])
def test_a_force_is_cut_off_where_it_comes_to_zero(law):
    """K δⁿ = −d δᵖ δ̇ during separation; bisection finds the root."""
    d, _ = falling([0.0, -0.1, 0.05, 1.5], law=law)
    n, p = (1.0, 0.0) if law == "kelvin_voigt" else (1.5, 0.25)

    def force(t):
        depth, rate = DEEP + 0.1 * t - 0.05 * t**2 - 1.5 * t**3, 0.1 - 0.1 * t - 4.5 * t**2
        return 4.0 * depth**n + d.touch.damping[1] * depth**p * rate

    low, high = 0.0, 0.55
    assert force(low) > 0.0 > force(high)
    while high - low > 1e-15:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if force(middle) > 0.0 else (low, middle)
    assert d.touch.beyond_kink[1] == 0
    end = 0.55
    locate_at(d, end)
    found = find_force_event(d, end)
    assert found == pytest.approx(low, abs=1e-14)
    # the points are located at the found time
    height = np.polynomial.polynomial.polyval(found, [0.0, -0.1, 0.05, 1.5])
    assert d.work.position.y[0] == pytest.approx(height, abs=1e-13)
    assert d.touch.event[1] == KINK


def test_a_kink_is_crossed_first_where_a_sample_shows_it():
    """h = −t + 4 t² − 4 t³ has δ̇ < 0 from 1/6 s to ½ s; from the other side the motion returns at ½ s."""
    d, _ = falling([0.0, -1.0, 4.0, -4.0])
    first_crossing = first_passage(sampled.own_side_at, lambda _d: 8, 0.0)
    assert first_crossing(d, 1, 1.0) == pytest.approx(1.0 / 6.0, abs=1e-14)
    assert first_crossing(d, 1, 0.16) == -1.0
    d.touch.beyond_kink[1] = 1
    assert first_crossing(d, 1, 1.0) == 0.0  # the contact starts on the other side of its kink


def test_the_first_of_several_kinks_counts_and_those_at_one_moment_are_one_event():
    d, _ = falling([0.0, -1.0, 1.0], touching=(1, 5, 9))
    found = find_force_event(d, -1.0)
    assert found == pytest.approx(0.5, abs=1e-14)
    assert d.touch.event[[1, 5, 9]].tolist() == [KINK] * 3
    # a contact that stays on its side of the kink is not part of the event
    d, _ = falling([0.0, -1.0, 1.0], touching=(1, 5, 9))
    d.touch.beyond_kink[5] = 1
    d.touch.kink_crossed[:] = 0
    assert find_force_event(d, -1.0) == pytest.approx(0.5, abs=1e-14)
    assert d.touch.event[[1, 5, 9]].tolist() == [KINK, NONE, KINK]


def test_a_kink_comes_after_the_event_that_was_found_before():
    d, _ = falling([0.0, -1.0, 1.0])
    for touched, found in ((0.3, 0.3), (0.7, 0.5)):
        d.touch.event[:] = NONE
        d.touch.event[4] = END
        d.touch.kink_crossed[:] = 1  # a stage was beyond it
        locate_at(d, touched)
        assert find_force_event(d, touched) == pytest.approx(found, abs=1e-14)
        assert d.touch.event[4] == (END if found == touched else NONE)
        assert d.touch.event[1] == (NONE if found == touched else KINK)


@pytest.mark.parametrize("stage", [0, 1])
def test_a_kink_that_only_a_stage_has_shown_is_looked_for(stage):
    """δ̇ < 0 between 0.3 and 0.45 s, and inward motion at the end."""
    d, _ = falling([0.0, -0.135, 0.375, -1.0 / 3.0])
    d.touch.kink_crossed[1], d.touch.impact_speed[1] = stage, 1.0
    found = find_force_event(d, -1.0)
    if stage:
        assert found == pytest.approx(0.3, abs=1e-13)
        assert d.touch.event[1] == KINK
    else:
        assert found == -1.0
        assert d.touch.event[1] == NONE


def test_a_contact_is_latched_anew_where_it_is_pushed_in_at_twice_its_speed():
    """h = −t² reaches 2 v₀ at t = v₀."""
    d, _ = falling([0.0, 0.0, -1.0], law="zhang_sharf")
    d.touch.impact_speed[1], d.touch.event[:] = 0.37, 7
    assert sampled.slowness(d, 1, 0.369) > 0.0 > sampled.slowness(d, 1, 0.371)
    assert RELATCH_RATIO == 2.0
    locate_at(d, 1.0)
    assert find_force_event(d, -1.0) == pytest.approx(0.37, abs=2e-12)
    assert d.touch.event.tolist() == [int(c == 1) * RELATCH for c in range(d.candidates)]
    # the points are located at the found time
    assert d.work.position.y[0] == pytest.approx(-(0.37**2), abs=1e-11)


def test_the_first_of_two_contacts_that_are_fast_is_latched_anew():
    for slower, faster in ((1, 5), (5, 1)):
        d, _ = falling([0.0, 0.0, -1.0], law="zhang_sharf", touching=(1, 5))
        d.touch.impact_speed[slower], d.touch.impact_speed[faster] = 0.6, 0.25
        locate_at(d, 1.0)
        assert find_force_event(d, -1.0) == pytest.approx(0.25, abs=2e-12)
        assert d.touch.event[[slower, faster]].tolist() == [NONE, RELATCH]


def test_an_excess_between_the_ends_is_found_if_an_end_is_nearly_fast():
    """δ̇ = 1 + 4 t − 6 t² has the maximum 1.67, and the values 1 and −1 at the ends."""
    d, _ = falling([0.0, -1.0, -2.0, 2.0], law="zhang_sharf")
    d.touch.impact_speed[1], d.touch.speed[1], d.touch.damping[1] = 0.8, 1.0, 0.0
    locate_at(d, 1.0)
    assert find_force_event(d, -1.0) == -1.0
    d.touch.speed[1] = 1.21
    expected = (4.0 - math.sqrt(16.0 - 24.0 * 0.6)) / 12.0
    assert find_force_event(d, -1.0) == pytest.approx(expected, abs=2e-12)


KINKED = ("kelvin_voigt", "tsuji", "kuwabara_kono", "jankowski")
TOLERANCES = 10.0 ** -np.arange(6, 14)
# Largest error of a realised restitution over the tolerance; measured: 21
LARGEST_ERROR = 30.0


def struck(law, e):
    scene, _ = struck_ball(MASS, SPEED, **of_law(law), stiffness=STIFFNESS, restitution=e)
    return scene.with_values({"simulation.stop_time": 0.3})


@pytest.mark.full("more cases", but=8)
@pytest.mark.parametrize("law", KINKED)
@pytest.mark.parametrize("e", [0.1, 0.5, 0.8])
def test_the_realised_restitution_errs_by_the_tolerance(law, e):
    """No smaller tolerance gives a larger error."""
    right, _, _ = scaled_impact(CONTACT_LAWS[law], e)
    for tolerance in TOLERANCES:
        (impact,) = simulate(struck(law, e), tolerance=tolerance, output=(), output_step=0.3).impacts
        error = abs(impact["separation_speed"] / impact["impact_speed"] - right)
        assert error <= LARGEST_ERROR * tolerance, tolerance


@pytest.mark.full("more cases", but=2)
@pytest.mark.parametrize("law", KINKED)
def test_a_step_ends_at_the_kink(law):
    d = Plain(PreparedScene(struck(law, 0.4).with_values({"solver.tolerance": 1e-9})).new_instance()[0])
    assert initialize(d, 0.0) == OK
    kinks = []
    while d.finished.count == 0:
        assert advance(d, np.nextafter(d.step.end, 1.0), 10, 1e9) == OK
        if d.touch.event[0] == KINK:
            locate_points(d, d.step.state_end)
            off = kink_height(d, 0) / (SPEED if d.law.approach_only[0] else elastic_force(d, 0, 1e-3))
            kinks.append((d.touch.beyond_kink[0], off))
    ((beyond, off),) = kinks
    assert beyond == 0
    assert abs(off) < 1e-9


SIZE = 0.2


def released(force=(1.0, -0.5, -2.0), least=-1e-2, size=SIZE):
    """Return a step in which the force of a wall is a polynomial, of which the stages have seen the least."""
    d, c, _ = held_tip(size, force)
    d.rigid.least_force[:] = -1e9
    d.rigid.least_force[c] = least
    return d, c


FALLS = (-0.5 + np.sqrt(0.25 + 8.0)) / 4.0  # 1 − ½ x − 2 x² = 0


def test_a_point_is_released_where_its_force_falls_through_zero():
    d, c = released()
    d.touch.event[:] = 7
    evaluations = d.statistics.rhs_evaluations
    assert sampled.find_release(d, -1.0) == pytest.approx(FALLS, abs=1e-10)
    assert d.touch.event.tolist() == [int(k == c) * RELEASE for k in range(d.candidates)]
    assert d.statistics.rhs_evaluations > evaluations + 8


@pytest.mark.parametrize(("touch", "expected"), [(0.3, 0.3), (0.9, FALLS)])
def test_only_a_release_before_the_event_that_was_found_counts(touch, expected):
    d, c = released()
    other = c + 1
    d.touch.event[:] = NONE
    d.touch.event[other] = END
    assert sampled.find_release(d, touch) == pytest.approx(expected, abs=1e-10)
    stays = expected == touch
    assert (d.touch.event[other], d.touch.event[c]) == ((END, NONE) if stays else (NONE, RELEASE))


def test_what_no_stage_has_shown_is_not_looked_for():
    d, _ = released(least=-0.5 * sampled.PULL)
    evaluations = d.statistics.rhs_evaluations
    assert sampled.find_release(d, -1.0) == -1.0
    assert sampled.find_release(d, 0.4) == 0.4
    assert d.statistics.rhs_evaluations == evaluations
    # a stage shows a release, but no sample does
    d, _ = released(force=(1.0,))
    assert sampled.find_release(d, -1.0) == -1.0


@pytest.mark.parametrize(
    ("times", "size", "refused"), [(1.1, SIZE, True), (0.9, SIZE, False), (1.1, 0.5 * sampled.SHORT, False)]
)
def test_a_stage_beyond_a_place_of_infinite_forces_spoils_the_step(times, size, refused):
    d, _ = released(size=size)
    d.rigid.least_force[d.touch.active_index[0]] = -times * sampled.strongest(d)
    found = sampled.find_release(d, -1.0)
    assert accepted(d) != refused
    if not refused:
        assert found * size == pytest.approx(FALLS * size, abs=2e-12)


@pytest.mark.parametrize("gravity", [0.0, 20.0])
@pytest.mark.parametrize(("omega", "alpha"), [(0.0, 0.0), (3.0, -7.0), (-0.1, 40.0)])
def test_the_strongest_force_is_that_of_gravity_and_of_turning_links(omega, alpha, gravity):
    """m (g + Σ s (ω² + |α|)) with the chain's mass m, at least 1 rad/s²; the fraction PULL is round-off."""
    rng = np.random.default_rng(1)
    _, d = chain(rng, 3)
    d.model.gravity_size = gravity
    d.step.state[7:10], d.work.rate_start[7:10] = (0.1, omega, 0.2), (0.3, alpha, -0.2)
    mass, size = d.model.mass.sum(), d.model.length.max()
    turning = max(1.0, omega**2 + abs(alpha))
    assert sampled.strongest(d) == pytest.approx(mass * (gravity + 3 * size * turning), rel=1e-12)
    assert sampled.pull_limit(d) == pytest.approx(sampled.PULL * mass * (gravity + size), rel=1e-12)


@pytest.mark.parametrize(
    ("theta", "expected"), [(0.1, False), (FALLS - 1e-6, False), (FALLS + 1e-6, True), (1.0, True)]
)
def test_a_wall_pulls_from_there_on(theta, expected):
    d, _ = released()
    assert (sampled.least_force(d, -1, theta) < 0.0) == expected
    d, c = released()
    sampled.mark_pulling(d, 0, theta)
    assert d.touch.event[c] == (RELEASE if expected else NONE)
    assert not np.delete(d.touch.event, c).any()


def test_a_pull_by_round_off_is_none():
    for times in (0.5, 2.0):
        limit = sampled.pull_limit(released()[0])
        d, c = released(force=(-times * limit,))
        assert (sampled.least_force(d, -1, 0.5) < 0.0) == (times > 1.0)
        sampled.mark_pulling(d, 0, 0.5)
        assert d.touch.event[c] == (RELEASE if times > 1.0 else NONE)


RESOLVED = 2e-11  # resolution: s, or m/s, rad, N relative to their scales


def started(table):
    """Return the record of a scene at its start."""
    d = Plain(PreparedScene(scene_from_dict(table, "case")).new_instance()[0])
    assert initialize(d, 0.0) == OK
    return d


def run_to_change(d, until):
    """Take steps until a mode ends; return the elements whose modes end, and their events."""
    while d.step.end < until:
        assert advance_one_step(d) == OK
        if pending_changes(d):
            locate_points(d, d.step.state_end)
            return {int(e): int(d.element.event[e]) for e in np.flatnonzero(d.element.event)}
    raise AssertionError("no mode has ended")


@pytest.mark.parametrize("method", ["explicit", "implicit"])
@pytest.mark.parametrize("speed", [3.0, -0.2])
def test_a_step_ends_where_a_link_with_a_dry_joint_stops(speed, method):
    table, exact = braked_link(speed, 0.4)
    d = started(table | {"solver": {"method": method}})
    (joint,) = range(d.candidates, d.elements)
    assert d.element.mode[joint] == np.sign(speed)
    assert run_to_change(d, 2.0 * exact.stop) == {joint: SLIDING_ENDS}
    assert d.step.end == pytest.approx(exact.stop, abs=RESOLVED)
    assert d.step.state_end[2] == pytest.approx(exact.turned, abs=RESOLVED)
    assert abs(tangential_rate(d, joint)) < RESOLVED
    assert advance_one_step(d) == OK
    assert (d.element.mode[joint], d.friction.stuck_count) == (STICKS, 1)
    assert d.step.state_end[2] == pytest.approx(exact.turned, abs=RESOLVED)


def compound_pendulum(moment):
    """Return two links in line that fall about a pin with a sticking joint, and the time of its slip.

    The rigid pendulum has θ̈ = −V′/I. The moment in the joint moves the lower link alone:
    I₂ θ̈ + m₂ c₂ (ℓ₁ θ̈ + g cos θ), with I₂ about the joint: in proportion to cos θ.
    """
    length, masses = (0.4, 0.7), (1.1, 0.6)
    own = [m * b**2 / 12 for m, b in zip(masses, length, strict=True)]
    arms = length[0] / 2, length[0] + length[1] / 2
    inertia = sum(i + m * arm**2 for i, m, arm in zip(own, masses, arms, strict=True))
    slope = GRAVITY * sum(m * arm for m, arm in zip(masses, arms, strict=True))
    turning = -slope / inertia
    lower = own[1] + masses[1] * (length[1] / 2) ** 2
    amplitude = lower * turning + masses[1] * length[1] / 2 * (length[0] * turning + GRAVITY)
    links = [{"length": a, "mass": m} for a, m in zip(length, masses, strict=True)]
    links[1]["joint_friction"] = moment * abs(amplitude)
    table = scene_table(
        "Compound",
        links,
        {"angles": [1.3, 1.3]},
        {},
        contact_table(points=[]),
        base="pinned",
        gravity=GRAVITY,
        stop_time=2.0,
    )
    return table, math.acos(moment)


@pytest.mark.full("more cases", but=3)
@pytest.mark.parametrize("method", ["explicit", "implicit"])
@pytest.mark.parametrize("part", [0.5, 0.9])
def test_a_step_ends_where_a_force_reaches_its_limit(part, method):
    table, angle = compound_pendulum(part)
    d = started(table | {"solver": {"method": method}})
    joint = d.candidates + 1
    assert d.element.mode[joint] == STICKS
    assert run_to_change(d, 2.0) == {joint: STICKING_ENDS}
    # within the error of the step at the default tolerance
    assert d.step.state_end[2] == pytest.approx(angle, abs=1e-6)
    assert d.step.state_end[3] - d.step.state_end[2] == pytest.approx(0.0, abs=1e-12)
    force, limit = float(d.element.force[joint]), float(d.element.limit[joint])
    assert abs(force) == pytest.approx(limit, rel=1e-8)
    assert advance_one_step(d) == OK
    if d.element.mode[joint] == STICKS:
        # an implicit step may end before the event by its error; then one more step follows
        assert method == "implicit"
        assert d.element.event[joint] == STICKING_ENDS
        assert d.step.end - d.step.start < 1e-8
        assert advance_one_step(d) == OK
    assert d.element.mode[joint] == -np.sign(force)
    assert np.sign(d.step.state_end[7] - d.step.state_end[6]) == -np.sign(force)


def test_both_joints_of_a_symmetric_chain_stop_in_one_step():
    """Three equal links fold symmetrically: both joints rotate at the same speed."""
    rod = {"length": 0.4, "mass": 0.8}
    dry = rod | {"joint_friction": 0.3}
    initial = {"angles": [-0.5, 0.0, 0.5], "angular_velocities": [-2.0, 0.0, 2.0], "velocity": [0.0, 0.0]}
    d = started(scene_table("Fold", [rod, dry, dry], initial, {}, contact_table(points=[]), stop_time=2.0))
    joints = [d.candidates + 1, d.candidates + 2]
    assert run_to_change(d, 2.0) == dict.fromkeys(joints, SLIDING_ENDS)
    for e in joints:
        assert abs(tangential_rate(d, e)) < 1e-9
    assert advance_one_step(d) == OK
    assert d.element.mode[joints].tolist() == [STICKS, STICKS]
    assert d.changes.count >= 4  # two changes at the start, and two now
    assert d.changes.time[2] == d.changes.time[3]


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("sliding", [0.3, -0.3])
def test_a_step_ends_where_a_point_stops_on_a_wall(sliding):
    """W_nt = 0, so slip ends when the impulse of the wall reaches m v_t/µ."""
    table, exact = oblique_ball(1.0, sliding, 0.4, stiffness=1e6)
    d = started(table)
    assert run_to_change(d, exact.end) == {0: SLIDING_ENDS}
    assert exact.onset < d.step.end < exact.end
    assert abs(tangential_rate(d, 0)) < 1e-9
    assert advance_one_step(d) == OK
    assert d.element.mode[0] == STICKS


def test_a_point_that_slides_faster_does_not_stop():
    table, exact = oblique_ball(1.0, 0.9, 0.4, stiffness=1e6)
    d = started(table)
    while d.step.end < exact.end:
        assert advance_one_step(d) == OK
        assert not d.element.event.any()
    assert d.step.state_end[3] == pytest.approx(exact.sliding, abs=1e-6)


@pytest.fixture
def rubbing():
    """Return a chain with two contacts and sliding dry joints, and its elements."""
    _, d, y = rubbing_chain(np.random.default_rng(5), "free", 2, True)
    d.step.state_end[:] = d.step.state[:] = y
    return d, [int(e) for e in d.element.index[: d.friction.count]]


@pytest.fixture
def changes(monkeypatch):
    """Return the mode changes, element → θ, the searched elements, and the search."""
    at, asked = {}, []

    def margin(_d, e, theta):
        asked.append(e)
        return -1.0 if at.get(e, 2.0) <= theta else 1.0

    monkeypatch.setattr(sampled, "element_margin", margin)
    return at, asked, search_for(margin, sampled.has_changed, sampled.mark_changes, sampled.ELEMENTS)


@pytest.mark.parametrize("found", [-1.0, 0.4])
def test_only_what_a_stage_has_shown_is_searched(rubbing, changes, found):
    d, elements = rubbing
    at, asked, find = changes
    at.update(dict.fromkeys(elements, 0.1))
    for e in elements:
        d.element.margin[e] = -0.9 * sampled.resolution_of(d, e)
    d.touch.event[3] = ONSET
    assert find(d, found) == found
    assert asked == []
    assert d.touch.event[3] == ONSET
    assert not d.element.event.any()


@pytest.mark.parametrize(
    "case",  # θ of a contact event, of element changes, of the end; the marked elements
    [
        (-1.0, {1: 0.5}, 0.5, {1}),
        (-1.0, {1: 0.5, 3: 0.25}, 0.25, {3}),
        (-1.0, {1: 0.25, 3: 0.5}, 0.25, {1}),
        (-1.0, {1: 0.25, 2: 0.25, 3: 0.25}, 0.25, {1, 2, 3}),
        (0.3, {1: 0.5}, 0.3, set()),
        (0.6, {1: 0.5}, 0.5, {1}),
        (-1.0, {}, -1.0, set()),
    ],
)
def test_the_first_change_ends_the_step(rubbing, changes, case):
    """All changes at that time are part of it. Later contact events are found again in the next step."""
    (d, elements), (found, at, right, marked) = rubbing, case
    changes[0].update({elements[k]: theta for k, theta in at.items()})
    d.element.margin[elements] = -1.0
    d.element.mode[elements[3]] = STICKS
    d.touch.event[3] = ONSET
    assert changes[2](d, found) == pytest.approx(right, abs=1e-9)
    kinds = {k: STICKING_ENDS if k == 3 else SLIDING_ENDS for k in marked}
    assert {k: d.element.event[e] for k, e in enumerate(elements) if d.element.event[e]} == kinds
    assert d.touch.event[3] == (NONE if marked else ONSET)


def test_an_element_that_was_found_is_marked_whatever_round_off_says(rubbing, changes, monkeypatch):
    d, elements = rubbing
    changes[0][elements[2]] = 0.5
    monkeypatch.setattr(sampled, "element_margin", lambda _d, _e, _theta: 1.0)
    d.element.margin[elements] = -1.0
    assert changes[2](d, -1.0) == pytest.approx(0.5, abs=1e-9)
    assert np.flatnonzero(d.element.event).tolist() == [elements[2]]


@pytest.mark.parametrize("sign", [1, -1])
def test_sliding_has_ended_where_it_is_backward_by_more_than_round_off(rubbing, sign):
    d, elements = rubbing
    e = elements[0]
    d.element.mode[e] = sign
    speed = sign * float(tangential_rate(d, e))
    assert (sampled.element_margin(d, e, 1.0) < 0.0) == (speed < 0.0)
    d.element.slack[e] = abs(speed) - 2.0 * sampled.rest_speed(d)
    assert (sampled.element_margin(d, e, 1.0) < 0.0) == (speed < 0.0)
    d.element.slack[e] = abs(speed)
    assert sampled.element_margin(d, e, 1.0) > 0.0


def test_sticking_has_ended_where_the_force_is_beyond_the_limit():
    table, angle = compound_pendulum(0.8)
    d = started(table)
    joint = d.candidates + 1
    evaluations = int(d.statistics.rhs_evaluations)
    for offset, ended in ((1e-7, False), (-1e-7, True)):
        d.step.state[2:4] = d.step.state_end[2:4] = angle + offset
        d.element.anchor[joint] = 0.0
        assert [sampled.element_margin(d, joint, theta) < 0.0 for theta in (1.0, 0.0)] == [ended, ended]
    assert d.statistics.rhs_evaluations == evaluations + 4


def test_round_off_is_that_of_a_speed_or_of_a_force(rubbing):
    d, elements = rubbing
    e = elements[0]
    size, mass = d.model.size, np.mean(d.model.mass)
    d.element.limit[e], d.element.slack[e] = 7.0, 1e-9
    assert sampled.rest_speed(d) == sampled.AT_REST * size
    assert sampled.excess(d, e) == pytest.approx(
        sampled.FRICTION_EXCESS * (7.0 + mass * (math.hypot(2.3, 9.81) + size)), rel=1e-12
    )
    assert sampled.resolution_of(d, e) == sampled.rest_speed(d) + 1e-9
    d.element.mode[e] = STICKS
    assert sampled.resolution_of(d, e) == sampled.excess(d, e)
