"""Rigid walls that hold what rests on them: coming to rest, waking and letting go."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from chain_impact import load_scene, simulate
from chain_impact.scene.scene import with_values
from chain_impact.simulation.instance import Instance
from tests.newton import LAW, WEIGHT, floor_forces, rigid
from tests.problems import GRAVITY, ball, default_scene, dropped_ball, rod

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
            instance.record["given"]["tip_force"] = force
            instance.record["given"]["changed"] = 1
        assert instance.trajectory(np.array([time]), out) == 1
        return out[0].copy()

    assert instance.advance(10.0) == 0
    return instance, at


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
        record["given"]["joint_torque"] = [3.0 * (-1.0) ** k + 2.0, -2.0 * (-1.0) ** (k // 2)]
        record["given"]["changed"] = 1
        record["finished"]["count"] = 0
        assert instance.trajectory(np.array([(k + 1) * 1e-3]), out[k : k + 1]) == 1
    balance = out["total"] + out["dissipated"] - out["supplied"]
    assert np.ptp(balance) < 1e-6 * out["kinetic"].max()
    assert (out["force"] >= 0.0).all()


def test_a_pinned_arm_leans_on_a_wall():
    """A torque holds it there: the wall's force has its moment about the base."""
    scene = rigid(load_scene("pinned_arm"), restitution=0.2)
    instance = Instance(scene)
    instance.record["given"]["joint_torque"] = [10.0, 0.0]
    instance.record["given"]["changed"] = 1
    out = np.zeros(1, instance.record.dtype["output"])
    assert instance.trajectory(np.array([5.0]), out) == 1
    force, position = out["force"][0], out["point_position"][0]
    assert (force > 0.0).any()
    assert out["kinetic"][0] < 1e-12
    # the wall pushes to the left: Σ F y + τ − g Σ m x_C = 0
    centres = 0.5 * (position[1:] + position[:-1])
    moment = (force * position[1:, 1]).sum() + 10.0 - GRAVITY * np.dot([1.0, 0.6], centres[:, 0])
    assert moment == pytest.approx(0.0, abs=1e-6)
