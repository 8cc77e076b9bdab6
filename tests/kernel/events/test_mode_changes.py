"""The ends of sticking and sliding, which are found by sampling a step."""

import math

import numpy as np
import pytest

from chain_impact.kernel.advance import advance_one_step
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.constraints.geometry import tangential_rate
from chain_impact.kernel.events import mode_changes
from chain_impact.kernel.events.force_events import make_search
from chain_impact.kernel.events.marks import count_mode_changes
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.record.constants import NO_EVENT, ONSET, SLIDING_ENDS, STICKING_ENDS, STICKS
from chain_impact.kernel.status import OK
from chain_impact.scene.scene import scene_from_dict
from chain_impact.variables.prepared import PreparedScene
from tests.helpers.kernel.plain import Plain
from tests.helpers.scenes.coulomb_problems import braked_link, oblique_ball
from tests.helpers.scenes.problems import GRAVITY, contact_table, scene_table
from tests.kernel.rubbing import rubbing_chain

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
        if count_mode_changes(d):
            locate_points(d, d.step.state_end)
            return {
                int(e): int(d.friction_element.event[e]) for e in np.flatnonzero(d.friction_element.event)
            }
    raise AssertionError("no mode has ended")


@pytest.mark.parametrize("method", ["explicit", "implicit"])
@pytest.mark.parametrize("speed", [3.0, -0.2])
def test_a_step_ends_where_a_link_with_a_dry_joint_stops(speed, method):
    table, exact = braked_link(speed, 0.4)
    d = started(table | {"solver": {"method": method}})
    (joint,) = range(d.candidate_count, d.friction_element_count)
    assert d.friction_element.mode[joint] == np.sign(speed)
    assert run_to_change(d, 2.0 * exact.stop) == {joint: SLIDING_ENDS}
    assert d.step.end == pytest.approx(exact.stop, abs=RESOLVED)
    assert d.step.state_end[2] == pytest.approx(exact.turned, abs=RESOLVED)
    assert abs(tangential_rate(d, joint)) < RESOLVED
    assert advance_one_step(d) == OK
    assert (d.friction_element.mode[joint], d.friction.stuck_count) == (STICKS, 1)
    assert d.step.state_end[2] == pytest.approx(exact.turned, abs=RESOLVED)


def compound_pendulum(moment):
    """Return two links in line that fall about a pin with a sticking joint, and the angle at its slip [rad].

    The rigid pendulum has θ̈ = −V′/I. The moment in the joint moves the lower link alone:
    I₂ θ̈ + m₂ c₂ (ℓ₁ θ̈ + g cos θ), with I₂ about the joint: in proportion to cos θ. The friction is the part
    ``moment`` of its largest value.
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
    joint = d.candidate_count + 1
    assert d.friction_element.mode[joint] == STICKS
    assert run_to_change(d, 2.0) == {joint: STICKING_ENDS}
    # within the error of the step at the default tolerance
    assert d.step.state_end[2] == pytest.approx(angle, abs=1e-6)
    assert d.step.state_end[3] - d.step.state_end[2] == pytest.approx(0.0, abs=1e-12)
    force, limit = float(d.friction_element.force[joint]), float(d.friction_element.friction_limit[joint])
    assert abs(force) == pytest.approx(limit, rel=1e-8)
    assert advance_one_step(d) == OK
    if d.friction_element.mode[joint] == STICKS:
        # an implicit step may end before the event by its error; then one more step follows
        assert method == "implicit"
        assert d.friction_element.event[joint] == STICKING_ENDS
        assert d.step.end - d.step.start < 1e-8
        assert advance_one_step(d) == OK
    assert d.friction_element.mode[joint] == -np.sign(force)
    assert np.sign(d.step.state_end[7] - d.step.state_end[6]) == -np.sign(force)


def test_both_joints_of_a_symmetric_chain_stop_in_one_step():
    """Three equal links fold symmetrically: both joints rotate at the same speed."""
    rod = {"length": 0.4, "mass": 0.8}
    dry = rod | {"joint_friction": 0.3}
    initial = {"angles": [-0.5, 0.0, 0.5], "angular_velocities": [-2.0, 0.0, 2.0], "velocity": [0.0, 0.0]}
    d = started(scene_table("Fold", [rod, dry, dry], initial, {}, contact_table(points=[]), stop_time=2.0))
    joints = [d.candidate_count + 1, d.candidate_count + 2]
    assert run_to_change(d, 2.0) == dict.fromkeys(joints, SLIDING_ENDS)
    for e in joints:
        assert abs(tangential_rate(d, e)) < 1e-9
    assert advance_one_step(d) == OK
    assert d.friction_element.mode[joints].tolist() == [STICKS, STICKS]
    assert d.friction_changes.count >= 4  # two changes at the start, and two now
    assert d.friction_changes.time[2] == d.friction_changes.time[3]


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
    assert d.friction_element.mode[0] == STICKS


def test_a_point_that_slides_faster_does_not_stop():
    table, exact = oblique_ball(1.0, 0.9, 0.4, stiffness=1e6)
    d = started(table)
    while d.step.end < exact.end:
        assert advance_one_step(d) == OK
        assert not d.friction_element.event.any()
    assert d.step.state_end[3] == pytest.approx(exact.sliding, abs=1e-6)


@pytest.fixture
def rubbing():
    """Return a chain with two contacts and sliding dry joints, and its elements."""
    _, d, y = rubbing_chain(np.random.default_rng(5), "free", 2, True)
    d.step.state_end[:] = d.step.state[:] = y
    return d, [int(e) for e in d.friction_element.index[: d.friction.active_count]]


@pytest.fixture
def changes(monkeypatch):
    """Return the mode changes, element → θ, the searched elements, and the search."""
    at, searches = {}, []

    def margin(_d, e, theta):
        searches.append(e)
        return -1.0 if at.get(e, 2.0) <= theta else 1.0

    monkeypatch.setattr(mode_changes, "element_margin", margin)
    return (
        at,
        searches,
        make_search(
            margin,
            mode_changes.mode_may_end,
            mode_changes.mark_changes,
            mode_changes.FRICTION_ELEMENT_MEMBERS,
        ),
    )


@pytest.mark.parametrize("contact_event", [-1.0, 0.4])
def test_only_what_a_stage_has_shown_is_searched(rubbing, changes, contact_event):
    d, elements = rubbing
    at, searches, find = changes
    at.update(dict.fromkeys(elements, 0.1))
    for e in elements:
        speed = mode_changes.sliding_speed(d, e)
        error = -0.9 * mode_changes.element_error(d, e)
        d.friction_element.margin[e] = 0.9 * speed if speed > 0.0 else error
    d.contacts.event[3] = ONSET
    assert find(d, contact_event) == contact_event
    assert searches == []
    assert d.contacts.event[3] == ONSET
    assert not d.friction_element.event.any()


def test_an_element_that_has_slowed_is_searched(rubbing, monkeypatch):
    """The least speed at a stage is compared with that at both ends of the step."""
    d, elements = rubbing
    e = next(e for e in elements if d.friction_element.mode[e] != STICKS)
    located = [1.0]
    monkeypatch.setattr(mode_changes, "locate_at_fraction", lambda _d, theta: located.append(theta))
    monkeypatch.setattr(mode_changes, "sliding_speed", lambda _d, _e: 1.0 if located[-1] == 0.0 else 0.05)
    for least, may_end in ((0.04, True), (0.49, True), (0.51, False)):
        d.friction_element.margin[e] = least
        assert mode_changes.mode_may_end(d, e, 0.8) == may_end
    assert located == [1.0, *(3 * [0.0, 0.8])]


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
    (d, elements), (contact_event, at, expected, marked) = rubbing, case
    changes[0].update({elements[k]: theta for k, theta in at.items()})
    d.friction_element.margin[elements] = -1.0
    d.friction_element.mode[elements[3]] = STICKS
    d.contacts.event[3] = ONSET
    assert changes[2](d, contact_event) == pytest.approx(expected, abs=1e-9)
    kinds = {k: STICKING_ENDS if k == 3 else SLIDING_ENDS for k in marked}
    assert {
        k: d.friction_element.event[e] for k, e in enumerate(elements) if d.friction_element.event[e]
    } == kinds
    assert d.contacts.event[3] == (NO_EVENT if marked else ONSET)


def test_an_element_that_was_found_is_marked_whatever_round_off_says(rubbing, changes, monkeypatch):
    d, elements = rubbing
    changes[0][elements[2]] = 0.5
    monkeypatch.setattr(mode_changes, "element_margin", lambda _d, _e, _theta: 1.0)
    d.friction_element.margin[elements] = -1.0
    assert changes[2](d, -1.0) == pytest.approx(0.5, abs=1e-9)
    assert np.flatnonzero(d.friction_element.event).tolist() == [elements[2]]


@pytest.mark.parametrize("sign", [1, -1])
def test_sliding_has_ended_where_it_is_backward_by_more_than_round_off(rubbing, sign):
    d, elements = rubbing
    e = elements[0]
    d.friction_element.mode[e] = sign
    speed = sign * float(tangential_rate(d, e))
    assert (mode_changes.element_margin(d, e, 1.0) < 0.0) == (speed < 0.0)
    d.friction_element.slack[e] = abs(speed) - 2.0 * mode_changes.rest_speed(d)
    assert (mode_changes.element_margin(d, e, 1.0) < 0.0) == (speed < 0.0)
    d.friction_element.slack[e] = abs(speed)
    assert mode_changes.element_margin(d, e, 1.0) > 0.0


def test_sticking_has_ended_where_the_force_is_beyond_the_limit():
    table, angle = compound_pendulum(0.8)
    d = started(table)
    joint = d.candidate_count + 1
    evaluations = int(d.statistics.rhs_evaluations)
    for offset, ended in ((1e-7, False), (-1e-7, True)):
        d.step.state[2:4] = d.step.state_end[2:4] = angle + offset
        d.friction_element.anchor[joint] = 0.0
        assert [mode_changes.element_margin(d, joint, theta) < 0.0 for theta in (1.0, 0.0)] == [ended, ended]
    assert d.statistics.rhs_evaluations == evaluations + 4


def test_round_off_is_that_of_a_speed_or_of_a_force(rubbing):
    d, elements = rubbing
    e = elements[0]
    size, mass = d.chain.longest_link, np.mean(d.chain.mass)
    d.friction_element.friction_limit[e], d.friction_element.slack[e] = 7.0, 1e-9
    assert mode_changes.rest_speed(d) == mode_changes.REST_SPEED * size
    assert mode_changes.friction_round_off(d, e) == pytest.approx(
        mode_changes.FRICTION_EXCESS * (7.0 + mass * (math.hypot(2.3, 9.81) + size)), rel=1e-12
    )
    assert mode_changes.element_error(d, e) == mode_changes.rest_speed(d) + 1e-9
    d.friction_element.mode[e] = STICKS
    assert mode_changes.element_error(d, e) == mode_changes.friction_round_off(d, e)
