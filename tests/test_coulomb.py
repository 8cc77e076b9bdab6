"""The independent simulation with Coulomb friction, against closed forms and balances; without the kernel."""

import dataclasses
import math

import numpy as np
import pytest

from tests.assembled import Assembled, shared
from tests.coulomb import simulate
from tests.coulomb_problems import BALL, CHAIN, ROD, SETTLED, held, oblique_ball, pushed_flat, sliding
from tests.dry_joints import INERTIA, braked_link, driven_link, dry_pendulum, flywheels, folding_pair
from tests.places import separated
from tests.problems import contact_table, scene_table
from tests.struck import duration, extrapolated, limit, struck
from tests.tumbled import STOP_TIME, tumbled

HALT = 1e-12  # m/s, by which a velocity is beyond 0 when it is found to be


def run(table, times, inputs=None):
    """The motion of a scene as its file has it; in all of them, energy is kept."""
    scene, friction = separated(table)
    motion = simulate(scene, friction, times, inputs)
    scale = max(1.0, motion.kinetic.max(), np.ptp(motion.potential))
    assert np.ptp(motion.balance) < 1e-10 * scale
    return motion


# --- bodies that lie flat ----------------------------------------------------------------------------------


SLIDES = {
    "a ball slides back": sliding(BALL, 0.3, 2.0, 0.2),
    "a ball never stops": sliding(BALL, -0.3, 2.0, 0.2),
    "a ball never stops, although it would stick": sliding(BALL, 0.3, -2.0, 0.25, static_friction=0.35),
    "a rod sticks": sliding(ROD, 0.3, 2.0, 0.4),
    "a ball sticks, as µ_s is larger": sliding(BALL, 0.3, 2.0, 0.25, static_friction=0.32),
    "a chain sticks on a floor": sliding(CHAIN, 0.0, -1.2, 0.4, static_friction=0.5),
}


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("case", SLIDES)
def test_a_body_slides_stops_and_sticks_or_slides_back(case):
    table, exact = SLIDES[case]
    body, slope, stops = exact.body, exact.slope, exact.stop < 1.0
    end = exact.stop + 0.1 if stops else 0.4
    times = [0.0, SETTLED, end]
    motion = run(table, times)
    along = np.array([math.cos(slope), math.sin(slope)])
    way, velocity = (motion.states[:, at : at + 2] @ along for at in (0, len(body.links) + 2))
    for k in (1, 2):
        assert way[k] == pytest.approx(exact.way(times[k]), abs=1e-11)
        assert velocity[k] == pytest.approx(exact.velocity(times[k]), abs=1e-11)
    normal, tangential = (
        sum(impulse.values())[-1] for impulse in (motion.normal_impulse, motion.tangential_impulse)
    )
    assert (normal, tangential) == pytest.approx(exact.impulses(end), abs=1e-10)
    assert motion.damped[-1] + motion.rubbed[-1] == pytest.approx(exact.dissipated(end), abs=1e-10)
    for place, force in motion.friction_force.items():
        assert force[-1] == pytest.approx(exact.friction_force(end), abs=1e-7)
        assert motion.sticking[place][-1] == (stops and exact.sticks)
    found = [
        change for change in motion.changes if change.kind in ("stick", "slip") and change.time > SETTLED / 2
    ]
    assert len(found) == stops * len(body.points)
    for change in found:
        late = 1.01 * HALT / abs(exact.acceleration(exact.sign))
        assert change.time == pytest.approx(exact.stop, abs=late + 1e-13)


@pytest.mark.full("takes long")
def test_a_rod_sticks_on_a_slope():
    table, exact = held(ROD, math.radians(20.0), 0.5)
    motion = run(table, [SETTLED, SETTLED + 0.1])
    assert np.ptp(motion.states[:, :3], axis=0).max() < 1e-12
    for place in ((0, "ramp"), (1, "ramp")):
        assert motion.sticking[place].all()
        assert motion.friction_force[place] == pytest.approx([exact.tangential] * 2, abs=1e-6)
        assert motion.normal_force[place] == pytest.approx([exact.normal] * 2, abs=1e-7)


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize(
    ("make", "coordinate"), [(lambda: pushed_flat(ROD, 0.4, 0.5, count=2), 0), (lambda: driven_link(0.5), 2)]
)
def test_a_push_breaks_what_sticks_and_friction_stops_it(make, coordinate):
    table, inputs, exact = make()
    times = [0.1, *(time + 0.05 for time in exact.times[1:]), exact.times[-1] + 0.1]
    motion = run(table, times, inputs)
    ways = [exact.at(time)[0] for time in times]
    np.testing.assert_allclose(motion.states[:, coordinate], ways, rtol=0, atol=1e-12)
    (place, *_) = motion.sticking
    found = [
        one
        for one in motion.changes
        if one.place == place and one.kind in ("stick", "slip") and one.time > 0.1
    ]
    expected = exact.changes()
    assert [one.kind for one in found] == [kind for _, kind in expected]
    np.testing.assert_allclose(
        [one.time for one in found], [time for time, _ in expected], rtol=0, atol=1e-12
    )


def test_redundant_friction_is_shared_in_proportion_to_its_bounds():
    """Three parallel ones; and two of which one is alone in its direction."""
    np.testing.assert_allclose(shared(np.ones((3, 3)), np.full(3, 6.0), np.array([1.0, 2.0, 3.0])), [1, 2, 3])
    w = np.diag([2.0, 0.0]) + np.array([[0.0, 0.0], [0.0, 5.0]])
    np.testing.assert_allclose(shared(w, np.array([4.0, 5.0]), np.array([1.0, 9.0])), [2.0, 1.0])


# --- impacts -----------------------------------------------------------------------------------------------


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize(("along", "halts"), [(0.6, False), (-0.3, True)])
def test_a_ball_hits_obliquely(along, halts):
    table, exact = oblique_ball(1.0, along, 0.3)
    motion = run(table, [0.0, 1.2 * exact.end])
    assert motion.states[-1, 3:5] == pytest.approx([exact.sliding, exact.separation], abs=1e-11)
    assert motion.normal_impulse[0, "y_min"][-1] == pytest.approx(exact.normal, abs=1e-11)
    assert motion.tangential_impulse[0, "y_min"][-1] == pytest.approx(exact.tangential, abs=1e-11)
    assert motion.rubbed[-1] == pytest.approx(exact.lost_by_friction, abs=1e-11)
    assert motion.damped[-1] == pytest.approx(exact.lost_by_damping, abs=1e-11)
    assert motion.when("onset") == pytest.approx([exact.onset], abs=1e-14)
    assert motion.when("end") == pytest.approx([exact.end], abs=1e-13)
    assert bool(motion.when("stick")) == halts


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("seed", [0, 5, 7, 8, 26])
def test_an_impact_with_friction_tends_to_its_closed_form(seed):
    exact, found = limit(seed), []
    for stiffness in (1e11, 1e12):
        table, strike, _ = struck(seed, stiffness)
        motion = run(table, [0.0, duration(strike, stiffness)])
        assert len(motion.when("end")) == 1
        impulses = (motion.normal_impulse, motion.tangential_impulse)
        found.append(np.array([row[-1] for each in impulses for row in each.values()]))
    assert ("stick" in exact.phases) == bool(motion.when("stick"))
    best = extrapolated(*found, 10.0)
    np.testing.assert_allclose(best, [exact.normal, exact.tangential], rtol=0, atol=1e-6 * exact.normal)


# --- joints ------------------------------------------------------------------------------------------------


def test_a_link_is_braked_by_its_dry_joint():
    for speed in (4.0, -4.0):
        table, exact = braked_link(speed, 0.5)
        motion = run(table, [0.0, 1.2 * exact.stop])
        assert motion.when("stick") == pytest.approx([exact.stop], abs=1e-11)
        assert motion.states[-1, 2] == pytest.approx(exact.turned, abs=1e-11)
        assert motion.rubbed[-1] == pytest.approx(0.5 * INERTIA * speed**2, abs=1e-11)


def test_a_pendulum_with_a_dry_joint_comes_to_rest():
    table, exact = dry_pendulum(0.3, 1.0)
    motion = run(table, [*exact.times, exact.times[-1] + 0.2])
    angles, lost = motion.states[:, 2], motion.rubbed
    np.testing.assert_allclose(angles, [*exact.angles, exact.angles[-1]], rtol=0, atol=1e-10)
    np.testing.assert_allclose(lost, [*exact.dissipated, exact.dissipated[-1]], rtol=0, atol=1e-10)
    turns = [change.time for change in motion.changes]
    np.testing.assert_allclose(turns, exact.times, rtol=0, atol=1e-10)
    assert [change.kind for change in motion.changes] == ["slip"] * (len(turns) - 1) + ["stick"]


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("omegas", [(3.0, -5.0), (-1.0, 4.0)])
def test_flywheels_on_a_dry_axle_turn_as_one(omegas):
    table, exact = flywheels(omegas, 0.05)
    times = [0.0, 0.4 * exact.stop, 1.5 * exact.stop]
    motion = run(table, times)
    assert motion.when("stick") == pytest.approx([exact.stop], abs=1e-11)
    for time, state in zip(times, motion.states, strict=True):
        assert state[6:] == pytest.approx(exact.speeds(time), abs=1e-11)
        assert state[2:4] - [0.0, 1.0] == pytest.approx(exact.turned(time), abs=1e-11)
    impulse = exact.moment * exact.stop * math.copysign(1.0, omegas[0] - omegas[1])
    assert motion.tangential_impulse[2, "joint"][-1] == pytest.approx(impulse, abs=1e-12)


def test_a_pair_of_links_stops_to_fold():
    table, exact = folding_pair(0.5, 3.0, 0.4)
    motion = run(table, [0.0, 1.2 * exact.stop])
    assert motion.when("stick") == pytest.approx([exact.stop], abs=1e-12)
    assert motion.states[-1, 2:4] == pytest.approx([exact.angle, -exact.angle], abs=1e-12)
    assert motion.rubbed[-1] == pytest.approx(exact.energy, abs=1e-12)


# --- balances ----------------------------------------------------------------------------------------------


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("seed", [5, 23])
def test_energy_and_momentum_balance_in_many_impacts(seed):
    table = tumbled(seed)
    motion, (scene, friction) = run(table, np.linspace(0.0, STOP_TIME, 11)), separated(table)
    assert len(motion.when("onset")) >= 2
    assert motion.when("stick")
    assert np.diff(motion.rubbed).min() > -1e-12
    assert np.diff(motion.damped).min() > -1e-12
    chain = Assembled(scene, friction)
    size = chain.n + 2
    before, after = (chain.matrix(row)[:2] @ row[size:] for row in motion.states[[0, -1]])
    impulse = np.array(scene.gravity) * STOP_TIME * chain.book.total_mass
    for contact in chain.contacts:
        normal = np.array(contact.normal)
        tangent = np.array([normal[1], -normal[0]])
        place = (contact.point, contact.wall)
        impulse = impulse + normal * motion.normal_impulse[place][-1]
        impulse = impulse + tangent * motion.tangential_impulse[place][-1]
    np.testing.assert_allclose(after - before, impulse, rtol=0, atol=1e-11)


def several():
    """Three links, of which two equal ones have dry joints, between a floor and a slope."""
    links = [{"length": 0.5, "mass": 1.0, "joint_friction": 0.3}]
    links += [{"length": 0.4, "mass": 0.7, "joint_friction": 0.2, "count": 2}]
    initial = {"position": [0.0, 0.5], "angles": [0.4, -0.3, 0.2], "velocity": [2.0, -1.0]}
    contact = contact_table(friction=0.3, static_friction=0.5)
    contact["wall"] = {"slope": {"friction": 0.7, "restitution": 0.6}, "y_max": {"static_friction": 0.6}}
    walls = [{"name": "slope", "point": [1.4, 0.0], "angle": 1.0}]
    box = {"x_min": -1.0, "y_min": 0.0, "y_max": 9.0}
    return scene_table("Several", links, initial, box, contact, gravity=9.81, walls=walls)


def test_friction_is_that_of_a_wall_before_that_of_all():
    """And a free base has no first joint."""
    scene, friction = separated(several())
    both = (0.3, 0.5)
    assert friction.walls == {"x_min": both, "y_min": both, "y_max": (0.3, 0.6), "slope": (0.7, 0.7)}
    assert friction.joints == {2: 0.2, 3: 0.2}
    assert scene.contact.wall["slope"].restitution == 0.6


def test_nothing_is_said_of_a_scene_without_friction():
    scene, friction = separated(several() | {"contact": contact_table(points=[])})
    assert not any(sum(friction.walls.values(), ()))
    motion = simulate(scene, dataclasses.replace(friction, joints={}), [0.0, 0.1])
    assert motion.changes == []
    assert motion.sticking == {}
