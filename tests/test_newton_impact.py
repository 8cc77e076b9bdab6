"""The non-smooth limit: impulses of no duration, and rigid walls that hold what rests on them."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from chain_impact import SimulationError, load_scene, simulate
from chain_impact.kernel.contact_laws import CONTACT_LAWS
from chain_impact.kernel.status import RIGID_WHILE_TOUCHING
from chain_impact.scene import SOLVER_METHODS, WALLS, scene_from_dict, with_values
from chain_impact.simulate import Instance
from tests.problems import (
    GRAVITY,
    ball,
    clattering_rod,
    cornered_rod,
    default_scene,
    dropped_ball,
    flat_chain,
    flat_rod,
    mirrored,
    rod,
    struck_rod,
)
from tests.reference import moreau_impact, newton_impact

LAW = "newton_impact"
WEIGHT = 4 * GRAVITY


def rigid(scene, **contact):
    """The scene under the law of this file."""
    changes = {("contact", key): value for key, value in contact.items()}
    return with_values(scene, {("contact", "model"): LAW} | changes)


def around_first_impact(scene):
    """The rows just before and just after the first impact, and its time."""
    onset = simulate(scene).impacts["onset"][0]
    instance = Instance(scene)
    rows = np.zeros(2, instance.record.dtype["output"])
    assert instance.trajectory(np.array([onset, np.nextafter(onset, np.inf)]), rows) == 2
    return rows[0], rows[1], onset


def velocities(row):
    """q̇ of a row of outputs: of the base, then of the angles."""
    return np.concatenate([row["point_velocity"][0], row["angular_velocity"]])


def ledger(result):
    """Largest deviation of the energy balance, over the largest energy at work."""
    energy = result.energy
    balance = energy["total"] + energy["dissipated"] - energy["supplied"]
    return np.ptp(balance) / max(energy["kinetic"].max(), np.ptp(energy["potential"]))


# --- one impact --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.7, 1.0])
def test_a_chains_first_impact_is_newtons(restitution):
    scene = default_scene(model=LAW, restitution=restitution)
    before, after, _ = around_first_impact(scene)
    impact = simulate(scene, stop_time=0.51).impacts[0]
    contact = int(impact["point"]), WALLS[impact["wall"]]
    expected, effective = newton_impact(scene, before["angle"], velocities(before), contact, restitution)
    np.testing.assert_allclose(velocities(after), expected, rtol=0, atol=1e-10)
    assert impact["effective_mass"] == pytest.approx(effective, rel=1e-10)
    # ½ m (1 − e²) u²
    lost = 0.5 * effective * (1 - restitution**2) * impact["impact_speed"] ** 2
    assert before["total"] - after["total"] == pytest.approx(lost, abs=1e-12)
    assert after["dissipated"] - before["dissipated"] == pytest.approx(lost, abs=1e-12)


def test_an_impact_has_no_duration_no_depth_and_no_finite_force():
    result = simulate(rigid(struck_rod(0.5, 0.7, 1e8)[0]))
    (impact,) = result.impacts
    assert impact["end"] == impact["onset"]
    assert impact["separation_speed"] == pytest.approx(0.7 * impact["impact_speed"], rel=1e-12)
    assert impact["max_penetration"] == 0.0
    assert impact["peak_force"] == math.inf
    assert (result.outputs["penetration"] == 0.0).all()
    assert (result.outputs["force"] == 0.0).all()
    assert (result.energy["elastic"] == 0.0).all()


@pytest.mark.parametrize(("tilt", "restitution"), [(0.5, 0.7), (0.5, 0.3), (-1.1, 1.0)])
def test_a_rods_end_is_struck_as_in_the_textbook(tilt, restitution):
    scene, exact = struck_rod(tilt, restitution, 1e8)
    scene = rigid(with_values(scene, {("initial", "velocity"): (0.8, -1.0)}))
    before, after, _ = around_first_impact(scene)
    assert after["angular_velocity"][0] == pytest.approx(math.copysign(exact.spin, -tilt), abs=1e-10)
    centre = after["point_velocity"].mean(axis=0)
    assert centre[1] == pytest.approx(exact.speed, abs=1e-10)
    # the wall is frictionless
    assert centre[0] == pytest.approx(before["point_velocity"].mean(axis=0)[0], abs=1e-14)


@pytest.mark.parametrize("restitution", [0.3, 0.7])
def test_the_laws_with_a_force_tend_to_it(restitution):
    """As K^(−2/5), like the duration of a contact."""
    scene = default_scene(model=LAW, restitution=restitution)
    _, after, _ = around_first_impact(scene)
    errors, stiffness = [], np.array([1e8, 1e10, 1e12])
    for k in stiffness:
        soft = default_scene(stiffness=k, restitution=restitution)
        end = simulate(soft, stop_time=0.51, tolerance=1e-11).impacts[0]["end"]
        row = simulate(soft, end, end, tolerance=1e-11).outputs[-1]
        errors.append(np.abs(velocities(row) - velocities(after)).max())
    assert errors[-1] < 1e-3 * np.abs(velocities(after)).max()
    assert np.polyfit(np.log(stiffness), np.log(errors), 1)[0] == pytest.approx(-0.4, abs=0.03)


def test_elastic_impacts_keep_the_energy():
    result = simulate(default_scene(model=LAW, restitution=1.0), stop_time=10.0, tolerance=1e-10)
    assert len(result.impacts) > 30
    energy = result.energy
    assert (energy["dissipated"] < 1e-12).all()
    assert np.ptp(energy["total"]) < 1e-7 * energy["total"][0]


@pytest.mark.parametrize("method", SOLVER_METHODS)
def test_every_method_finds_the_same(method):
    """Nothing is stiff: the method is the explicit one, whatever the solver is told."""
    scene = default_scene(model=LAW)
    result = simulate(scene, method=method)
    assert result.statistics["implicit_steps"] == 0
    assert np.array_equal(result.outputs, simulate(scene).outputs)


def test_neither_stiffness_nor_exponent_means_anything():
    soft, hard = (
        simulate(default_scene(model=LAW, stiffness=stiffness, exponent=exponent))
        for stiffness, exponent in ((1.0, 1.0), (1e12, 3.0))
    )
    assert np.array_equal(soft.outputs, hard.outputs)
    assert np.array_equal(soft.impacts, hard.impacts)


# --- several at once ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("restitution", [0.1, 0.5, 1.0])
def test_a_flat_rod_rebounds_like_a_point_and_does_not_turn(restitution):
    result = simulate(rigid(flat_rod(restitution=restitution)))
    assert len(result.impacts) == 2
    np.testing.assert_allclose(result.impacts["separation_speed"], restitution, rtol=1e-12)
    assert np.abs(result.angular_velocities).max() < 1e-14


@pytest.mark.parametrize("restitution", [0.1, 0.5, 1.0])
def test_the_second_end_of_a_clattering_rod_arrives_faster(restitution):
    scene, speed = clattering_rod(restitution)
    impacts = simulate(rigid(scene)).impacts
    assert impacts["point"][:2].tolist() == [0, 1]
    assert impacts["impact_speed"][1] == pytest.approx(speed, rel=1e-6)


@pytest.mark.parametrize("restitution", [0.1, 0.7, 1.0])
def test_a_rod_returns_from_a_corner_as_it_came(restitution):
    result = simulate(rigid(cornered_rod(restitution)))
    assert len(result.impacts) == 2
    np.testing.assert_allclose(result.outputs["point_velocity"][-1], restitution * math.sqrt(0.5), rtol=1e-12)
    assert np.abs(result.angular_velocities).max() < 1e-12


def test_a_flat_chain_hits_with_five_points_and_stays_flat():
    result = simulate(rigid(flat_chain(0.1, stop_time=1.0, restitution=0.6)))
    first = result.impacts[:5]
    assert sorted(first["point"]) == [0, 1, 2, 3, 4]
    assert (first["onset"] == first["onset"][0]).all()
    np.testing.assert_allclose(first["separation_speed"], 0.6 * first["impact_speed"], rtol=1e-12)
    assert np.abs(result.points[:, :, 1] - result.points[:, :1, 1]).max() < 1e-9


def test_five_points_with_unlike_speeds_get_moreaus_impulses():
    """The middle of the chain falls faster: which impulses act is part of the question."""
    for spins in ((1.0, -1.0, 1.0, -1.0), (-2.0, 1.0, 1.0, 2.0), (0.5, 0.5, -0.5, -0.5)):
        scene = rigid(flat_chain(1e-3, restitution=0.4))
        velocity = {("initial", "velocity"): (0.2, -2.0), ("initial", "angular_velocities"): spins}
        instance = Instance(with_values(scene, velocity | {("gravity",): (0.0, 0.0)}))
        # all on the floor and moving: the start of an impact
        state = instance.record["step"]["state_end"]
        state[1] = 0.0
        before = state[6:12].copy()
        arriving = [(k, "y_min") for k in range(5) if before[1] + 0.5 * sum(spins[:k]) < 0.0]
        for point, _ in arriving:
            instance.record["touch"]["event"][4 * point + WALLS.index("y_min")] = 1
        instance.advance(1e-15)
        after = instance.record["step"]["state"][6:12]
        expected = moreau_impact(scene, [0.0] * 4, before, arriving, 0.4)
        np.testing.assert_allclose(after, expected, atol=1e-12)


def test_what_is_symmetric_stays_so():
    tilts = (0.3, 0.1, -0.1, -0.3)
    result = simulate(rigid(flat_chain(0.05, tilts, stop_time=0.6, restitution=0.5)))
    assert len(result.impacts) > 5
    height = result.points[:, :, 1]
    assert np.abs(height - height[:, ::-1]).max() < 1e-9


def test_a_mirror_changes_nothing():
    scene = default_scene(model=LAW)
    here, there = (simulate(s, stop_time=1.0, tolerance=1e-10) for s in (scene, mirrored(scene)))
    np.testing.assert_allclose(there.impacts["onset"], here.impacts["onset"], rtol=0, atol=1e-7)
    np.testing.assert_array_equal(there.impacts["point"], here.impacts["point"])


@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.6, 0.9])
def test_a_rod_that_wedges_between_floor_and_ceiling_does_not_hit_them_for_ever(restitution):
    walls = {"y_min": 0.0, "y_max": 0.999}
    scene = rod(1.4, 0.004, 0.0, 2.0, box=walls, stop_time=2.0, model=LAW, restitution=restitution)
    result = simulate(scene)
    assert result.statistics["steps"] < 1000
    assert ledger(result) < 1e-9
    assert np.diff(result.energy["total"]).max() < 1e-12
    assert result.points[:, :, 1].min() > -1e-12
    assert result.points[:, :, 1].max() < 0.999 + 1e-12


# --- coming to rest ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("restitution", "stop_time"), [(0.0, 1.0), (0.05, 1.0), (0.5, 2.0), (0.9, 11.0)])
def test_a_ball_bounces_in_closed_form_and_then_lies_still(restitution, stop_time):
    scene, drop = dropped_ball(stop_time=stop_time, model=LAW, restitution=restitution)
    result = simulate(scene)
    # t_k+1 = t_k + 2 v e^k/g until a bounce is slower than the floor of speeds
    onset, speed = [drop.onset], drop.speed
    while speed >= scene.contact.minimum_impact_speed and restitution > 0.0:
        speed *= restitution
        onset.append(onset[-1] + 2 * speed / GRAVITY)
    np.testing.assert_allclose(result.impacts["onset"], onset, rtol=0, atol=1e-11)
    assert (result.impacts["end"][:-1] == result.impacts["onset"][:-1]).all()
    assert math.isnan(result.impacts["end"][-1])
    still = result.outputs[result.time > onset[-1]]
    np.testing.assert_allclose(still["force"][:, 0], GRAVITY, rtol=1e-10)
    assert np.abs(still["point_position"][:, 0, 1]).max() < 1e-15
    assert result.impacts["peak_force"][-1] == pytest.approx(GRAVITY, rel=1e-10)


@pytest.mark.parametrize("speed", [0.0, 1e-8, 1e-5, 1e-3, 2e-3])
@pytest.mark.parametrize("height", [0.0, 1e-12])
def test_the_gentlest_touch_down_comes_to_rest(height, speed):
    result = simulate(ball(height, speed, gravity=GRAVITY, stop_time=1.0, model=LAW))
    assert len(result.impacts) <= 4
    assert result.outputs["force"][-1, 0] == pytest.approx(GRAVITY, rel=1e-12)
    assert result.statistics["steps"] < 50


@pytest.mark.parametrize("restitution", [0.05, 0.3, 0.5, 0.7, 0.9])
def test_the_default_chain_comes_to_rest_for_next_to_nothing(restitution):
    instance = Instance(default_scene(model=LAW, restitution=restitution))
    assert instance.advance(11.0) == 0
    before = instance.statistics
    assert before["steps"] < 2000
    # what is left is a flat chain that slides, and now and then meets a wall
    assert instance.advance(21.0) == 0
    after = instance.statistics
    assert after["steps"] - before["steps"] < 50
    assert after["rhs_evaluations"] - before["rhs_evaluations"] < 1000
    assert instance.record["touch"]["active"].reshape(5, 4)[:, 2].all()


def test_at_rest_the_floor_carries_the_weight_and_nothing_creeps():
    result = simulate(default_scene(model=LAW, restitution=0.05), stop_time=60.0, output_step=1.0)
    late = result.outputs[result.time >= 10.0]
    floor = late["force"].reshape(len(late), 5, 4)[:, :, 2]
    np.testing.assert_allclose(floor / GRAVITY, [[0.5, 1.0, 1.0, 1.0, 0.5]] * len(late), rtol=1e-8)
    assert np.abs(late["point_position"][:, :, 1]).max() < 1e-14


def test_a_tilted_rod_clatters_to_rest():
    scene = rod(0.2, 0.1, 0.0, gravity=GRAVITY, stop_time=4.0, restitution=0.3, model=LAW)
    result = simulate(scene)
    forces = np.sort(result.outputs["force"][-1])
    np.testing.assert_allclose(forces[-2:], GRAVITY / 2, rtol=1e-8)
    assert np.diff(result.energy["total"]).max() < 1e-9


# --- waking ------------------------------------------------------------------------------------------------


@pytest.fixture
def resting():
    """The default chain, with a force on its tip as input, at rest after ten seconds; and a way to look."""
    scene = with_values(default_scene(model=LAW, restitution=0.05), {("inputs", "tip_force"): True})
    instance = Instance(scene)
    out = np.zeros(1, instance.record.dtype["output"])

    def at(time, force=None):
        instance.record["finished"]["count"] = 0
        if force is not None:
            instance.record["inputs"]["tip_force"] = force
            instance.record["inputs"]["changed"] = 1
        assert instance.trajectory(np.array([time]), out) == 1
        return out[0].copy()

    assert instance.advance(10.0) == 0
    return instance, at


def floor_forces(row):
    return row["force"].reshape(5, 4)[:, 2]


def test_a_pull_that_is_too_weak_lifts_nothing(resting):
    instance, at = resting
    row = at(11.0, (0.0, 4.9))
    np.testing.assert_allclose(floor_forces(row), [4.905, 9.81, 9.81, 9.81, 0.005], rtol=1e-8)
    assert instance.record["touch"]["active_count"] == 5


def test_a_pull_wakes_the_chain_at_once(resting):
    """The last rod lifts about its inner joint: α = (f − m g/2) L/(m L²/3)."""
    _, at = resting
    row = at(10.0, (0.0, 20.0))
    assert row["angular_acceleration"][3] == pytest.approx(3 * (20.0 - GRAVITY / 2) / 0.5, rel=1e-8)
    # the other end of that rod is pressed down: m(g + a) − f = 9.81 + ½ α L − 20, and half a rod's weight
    assert floor_forces(row)[3] == pytest.approx(
        GRAVITY / 2 + GRAVITY + 0.25 * row["angular_acceleration"][3] - 20.0, rel=1e-8
    )
    later = at(10.01)
    assert later["point_position"][4, 1] == pytest.approx(
        0.5 * 0.5 * row["angular_acceleration"][3] * 1e-4, rel=1e-2
    )
    assert (floor_forces(later) >= 0.0).all()


def test_a_push_is_carried_at_once(resting):
    _, at = resting
    row = at(10.1, (0.0, -100.0))
    assert floor_forces(row).sum() == pytest.approx(WEIGHT + 100.0, rel=1e-10)


def energy_to_spin(sine, energy):
    """ω² of a rod whose foot is on the floor: ½ (I + m (½ cos θ)²) ω² + ½ m g sin θ = E, m = L = 1."""
    return 2 * (energy - GRAVITY / 2 * sine) / (1 / 12 + (1 - sine**2) / 4)


def test_a_falling_rod_is_held_at_its_foot():
    """The force is (g − ½ ω² sin θ)/(1 + 3 cos² θ) and never comes to zero."""
    scene = rod(1.2, 0.0, 0.0, gravity=GRAVITY, stop_time=0.6, model=LAW, restitution=0.0)
    result = simulate(scene, output_step=1e-3)
    falling = (result.time > 0.0) & (result.time < result.impacts["onset"][1])
    sine = np.sin(result.angles[falling, 0])
    square = energy_to_spin(sine, GRAVITY / 2 * math.sin(1.2))
    np.testing.assert_allclose(result.angular_velocities[falling, 0] ** 2, square, rtol=1e-7, atol=1e-9)
    expected = (GRAVITY - 0.5 * square * sine) / (4 - 3 * sine**2)
    np.testing.assert_allclose(result.outputs["force"][falling, 1], expected, rtol=1e-7)
    assert result.impacts["peak_force"][0] == pytest.approx(expected.max(), rel=1e-3)


def test_a_point_is_released_when_its_force_comes_to_zero():
    """A rod that gets up so fast that its foot leaves the floor, where ½ ω² sin θ = g."""
    tilt, spin = 0.2, 8.0
    scene = rod(
        tilt,
        0.0,
        -spin * math.cos(tilt) / 2,
        spin,
        gravity=GRAVITY,
        stop_time=0.2,
        model=LAW,
        restitution=0.0,
    )
    (contact,) = simulate(scene).impacts
    energy = (1 / 12 + math.cos(tilt) ** 2 / 4) * spin**2 / 2 + GRAVITY / 2 * math.sin(tilt)

    def lifting(angle):
        return energy_to_spin(math.sin(angle), energy) * math.sin(angle) / 2 - GRAVITY

    last = brentq(lifting, tilt, 1.0, xtol=1e-15)
    end, _ = quad(lambda angle: energy_to_spin(math.sin(angle), energy) ** -0.5, tilt, last, epsabs=1e-13)
    assert (contact["onset"], contact["point"]) == (0.0, 0)
    assert contact["end"] == pytest.approx(end, abs=1e-9)
    assert abs(contact["separation_speed"]) < 1e-12


def test_a_pinned_arm_under_torques_that_switch_keeps_the_ledger():
    instance = Instance(rigid(load_scene("pinned_arm")))
    record = instance.record
    out = np.zeros(2000, record.dtype["output"])
    for k in range(2000):
        record["inputs"]["joint_torque"] = [3.0 * (-1.0) ** k + 2.0, -2.0 * (-1.0) ** (k // 2)]
        record["inputs"]["changed"] = 1
        record["finished"]["count"] = 0
        assert instance.trajectory(np.array([(k + 1) * 1e-3]), out[k : k + 1]) == 1
    balance = out["total"] + out["dissipated"] - out["supplied"]
    assert np.ptp(balance) < 1e-6 * out["kinetic"].max()
    assert (out["force"] >= 0.0).all()


def test_a_pinned_arm_leans_on_a_wall():
    """A torque holds it there: the wall's force has its moment about the base."""
    scene = rigid(load_scene("pinned_arm"), restitution=0.2)
    instance = Instance(scene)
    instance.record["inputs"]["joint_torque"] = [10.0, 0.0]
    instance.record["inputs"]["changed"] = 1
    out = np.zeros(1, instance.record.dtype["output"])
    assert instance.trajectory(np.array([5.0]), out) == 1
    force, position = out["force"][0], out["point_position"][0]
    assert (force > 0.0).any()
    assert out["kinetic"][0] < 1e-12
    # the wall pushes to the left: Σ F y + τ − g Σ m x_C = 0
    centres = 0.5 * (position[1:] + position[:-1])
    moment = (force * position[1:, 1]).sum() + 10.0 - GRAVITY * np.dot([1.0, 0.6], centres[:, 0])
    assert moment == pytest.approx(0.0, abs=1e-6)


# --- any scene ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.7, 0.9])
def test_energy_never_rises(restitution):
    result = simulate(default_scene(model=LAW, restitution=restitution), stop_time=10.0, tolerance=1e-10)
    energy = result.energy
    assert np.diff(energy["total"]).max() < 1e-8 * energy["total"][0]
    assert (np.diff(energy["dissipated"]) >= 0.0).all()
    assert (result.outputs["force"] >= 0.0).all()
    assert ledger(result) < 1e-7


@pytest.mark.slow
@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_fifty_links_fall_in_a_heap(restitution):
    heap = {
        "name": "Heap",
        "chain": {"links": [{"length": 0.1, "mass": 0.1}] * 50},
        "box": {"x_min": -1.0, "x_max": 6.0, "y_min": 0.0},
        "contact": {"model": LAW, "restitution": restitution},
        "initial": {"position": [0.0, 0.5], "angles": [0.8 * math.sin(i) for i in range(50)]},
        "simulation": {"stop_time": 3.0, "step_size": 1e-2},
    }
    result = simulate(scene_from_dict(heap, "heap"), tolerance=1e-6)
    assert len(result.impacts) > 500
    assert ledger(result) < 1e-5
    assert (result.outputs["force"] >= 0.0).all()
    assert result.points[:, :, 1].min() > -1e-7


def test_the_record_holds_everything():
    """A copy of its bytes, taken while some points are held, goes on bit by bit as the original does."""
    instance, other = (Instance(default_scene(model=LAW, restitution=0.3)) for _ in range(2))
    assert instance.advance(1.5) == 0
    assert instance.record["touch"]["active_count"] > 0
    other._block[:] = instance._block
    for one in (instance, other):
        assert one.advance(6.0) == 0
    assert instance._block.tobytes() == other._block.tobytes()


def test_communication_points_change_neither_result_nor_cost():
    scene = default_scene(model=LAW, restitution=0.3)
    coarse, fine = simulate(scene, 4.0, 0.1), simulate(scene, 4.0, 1e-3)
    assert coarse.statistics == fine.statistics
    assert coarse.impacts.tobytes() == fine.impacts.tobytes()
    assert np.array_equal(coarse.outputs[-1], fine.outputs[-1])


# --- changing the law --------------------------------------------------------------------------------------


def change_law(instance, law):
    instance.record["contact"]["law"] = CONTACT_LAWS[law].number
    instance.record["inputs"]["changed"] = 1


def test_in_flight_the_law_may_change_to_it():
    instance = Instance(default_scene())
    assert instance.advance(0.4) == 0
    change_law(instance, LAW)
    assert instance.advance(2.0) == 0
    impacts = instance.collect()
    assert (impacts["end"] == impacts["onset"])[:5].all()


def test_while_a_point_is_in_a_wall_it_may_not():
    instance = Instance(default_scene(restitution=0.05))
    assert instance.advance(9.0) == 0
    change_law(instance, LAW)
    assert instance.advance(9.1) == RIGID_WHILE_TOUCHING
    assert instance.time == 9.0
    text = str(SimulationError(RIGID_WHILE_TOUCHING, 9.0, None))
    assert LAW in text


def test_held_contacts_pass_to_another_law():
    instance = Instance(default_scene(model=LAW, restitution=0.3))
    assert instance.advance(8.0) == 0
    assert instance.record["touch"]["active_count"] == 5
    change_law(instance, "zhang_sharf")
    out = np.zeros(1, instance.record.dtype["output"])
    instance.record["finished"]["count"] = 0
    assert instance.trajectory(np.array([12.0]), out) == 1
    assert floor_forces(out[0]).sum() == pytest.approx(WEIGHT, rel=1e-5)
    assert (out["penetration"][0].reshape(5, 4)[:, 2] > 0.0).all()


@pytest.mark.parametrize("look", [False, True])
def test_a_change_that_is_refused_leaves_the_contacts_rigid(look):
    """An output asked for in between, when the parameters do not yet go together, changes nothing."""

    def after(settings):
        instance = Instance(rigid(ball(height=0.01), restitution=0.0))
        assert instance.advance(1.0) == 0
        for law, restitution in settings:
            instance.record["contact"]["restitution"] = restitution
            change_law(instance, law)
            if look:
                instance._kernel.observe(instance._address)
        return instance, instance.advance(1.5)

    instance, status = after([("zhang_sharf", 0.0), ("zhang_sharf", 0.7)])
    assert status == 0
    assert instance.record["finished"]["count"] == 1
    _, status = after([("kelvin_voigt", 0.7), (LAW, 0.7)])
    assert status == 0
