"""Dry friction in joints against closed forms, and chains at walls against an independent simulation."""

from __future__ import annotations

import math

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.scene.scene import scene_from_dict
from tests import coulomb
from tests.dry_joints import braked_link, driven_link, dry_pendulum, flywheels, folding_pair
from tests.places import separated
from tests.problems import contact_table, scene_table


def run(table, **options):
    return simulate(scene_from_dict(table, "friction"), **{"tolerance": 1e-12, "output_step": 0.01} | options)


def stops(result):
    """When anything begins to stick [s]."""
    return [float(phase["start"]) for phase in result.stick_slip if phase["mode"] == 0]


def test_dry_friction_brakes_a_link():
    table, exact = braked_link(3.0, 0.4)
    result = run(table)
    assert stops(result) == pytest.approx([exact.stop], abs=1e-9)
    assert result["link[1].angle"][-1] == pytest.approx(exact.turned, abs=1e-11)
    assert result["energy.friction"][-1] == pytest.approx(result["energy.kinetic"][0], rel=1e-12)
    assert result["joint[1].friction_moment"][3] == pytest.approx(-0.4, rel=1e-14)


def test_a_motor_breaks_a_joint_loose_and_friction_holds_it():
    table, inputs, exact = driven_link(0.5)
    result = run(table, inputs=inputs)
    for time in (0.25, 0.9, 1.7, 2.4):
        row = np.searchsorted(result.time, time - 1e-9)
        assert result["link[1].angle"][row] == pytest.approx(exact.at(result.time[row])[0], abs=1e-10)
    # the last torque, below the limit, is held
    assert result["joint[1].sticking"][-1] == 1.0
    assert result["joint[1].friction_moment"][-1] == pytest.approx(-exact.pushes[-1], rel=1e-9)


def test_a_dry_pendulum_loses_the_same_moment_in_each_half_swing():
    table, exact = dry_pendulum(0.3, 0.8)
    result = run(table)
    starts = [float(phase["start"]) for phase in result.stick_slip]
    assert starts[1:] == pytest.approx(exact.times[1:], abs=1e-8)
    assert result["link[1].angle"][-1] == pytest.approx(exact.angles[-1], abs=1e-9)
    assert result["energy.friction"][-1] == pytest.approx(exact.dissipated[-1], rel=1e-9)


@pytest.mark.parametrize(("law", "off"), [("newton_impact", 1e-12), ("zhang_sharf", 1e-4)])
def test_two_links_that_lean_on_each_other_stop_where_their_energy_is_used_up(law, off):
    """Both feet slide on a floor without friction and gravity: m ℓ² ω²/3 = 2 M (θ₀ − θ)."""
    mass, length, moment, angle, speed = 0.5, 0.4, 1.5, 0.8, 3.0
    link = {"length": length, "mass": mass, "joint_friction": moment}
    initial = {
        "position": [-length * math.cos(angle), 0.0],
        "angles": [angle, -angle],
        "velocity": [-length * speed * math.sin(angle), 0.0],
        "angular_velocities": [-speed, speed],
    }
    contact = contact_table(model=law, stiffness=1e9, restitution=0.0 if law == "newton_impact" else 0.1)
    result = run(scene_table("Lean", [link, link], initial, {"y_min": 0.0}, contact, stop_time=0.1))
    energy = mass * length**2 * speed**2 / 3.0
    assert len(stops(result)) == 1
    assert result["link[1].angle"][-1] == pytest.approx(angle - energy / (2.0 * moment), rel=off)
    assert result["energy.friction"][-1] == pytest.approx(energy, rel=off)


def test_two_flywheels_turn_as_one_at_last():
    table, exact = flywheels((2.0, -5.0), 0.05)
    result = run(table)
    assert stops(result) == pytest.approx([exact.stop], abs=1e-9)
    for i in range(2):
        turned = result[f"link[{i + 1}].angle"][-1] - result[f"link[{i + 1}].angle"][0]
        assert turned == pytest.approx(exact.turned(result.time[-1])[i], abs=1e-9)


def test_a_pair_of_links_folds_until_its_joint_sticks():
    table, exact = folding_pair(0.9, -2.0, 0.15)
    result = run(table)
    assert stops(result) == pytest.approx([exact.stop], abs=1e-9)
    assert result["link[1].angle"][-1] == pytest.approx(exact.angle, abs=1e-9)
    np.testing.assert_allclose(result["link[1].angle"], -result["link[2].angle"], rtol=0, atol=1e-11)


# --- chains ------------------------------------------------------------------------------------------------


def thrown(seed, *, joints=False, base="free"):
    """A chain of three uneven links that hits a floor and a slope, with friction of two materials."""
    rng = np.random.default_rng(seed)
    links = [
        {
            "length": float(rng.uniform(0.3, 0.7)),
            "mass": float(rng.uniform(0.5, 2.0)),
            "joint_friction": float(rng.uniform(0.1, 0.6)) if joints and (i > 0 or base == "pinned") else 0.0,
        }
        for i in range(3)
    ]
    mu = float(rng.uniform(0.1, 0.8))
    return {
        "name": "Thrown",
        "chain": {"base": base, "links": links},
        "box": {"y_min": 0.0},
        "walls": [{"name": "slope", "point": [2.4, 0.0], "angle": 1.9}],
        "contact": {
            "stiffness": 1e6,
            "restitution": 0.6,
            "friction": mu,
            "static_friction": 1.25 * mu,
            "wall": {"slope": {"friction": 0.3}},
        },
        "initial": {
            "position": [0.2, 0.75],
            "angles": list(rng.uniform(-0.6, 0.6, 3)),
            "velocity": [0.0, 0.0] if base == "pinned" else list(rng.uniform(-1.0, 1.0, 2)),
            "angular_velocities": list(rng.uniform(-3.0, 3.0, 3)),
        },
        "simulation": {"stop_time": 0.6},
    }


@pytest.mark.full("takes long")
@pytest.mark.parametrize("joints", [False, True], ids=["walls", "walls and joints"])
@pytest.mark.parametrize(("seed", "base"), [(1, "free"), (2, "free"), (3, "pinned"), (4, "free")])
def test_a_thrown_chain_moves_as_an_independent_model_says(seed, base, joints):
    table = thrown(seed, joints=joints, base=base)
    result = run(table, output_step=0.02)
    scene, friction = separated(table)
    motion = coulomb.simulate(scene, friction, result.time[1:])
    states = np.column_stack([result[f"point[0].{axis}"] for axis in "xy"])[1:]
    angles = np.column_stack([result[f"link[{i + 1}].angle"] for i in range(3)])[1:]
    np.testing.assert_allclose(states, motion.states[:, :2], rtol=0, atol=1e-8)
    np.testing.assert_allclose(angles, motion.states[:, 2:5], rtol=0, atol=1e-8)
    onsets = [float(impact["onset"]) for impact in result.impacts]
    assert len(onsets) > 0
    assert sorted(onsets) == pytest.approx(motion.when("onset"), abs=1e-9)
    assert result["energy.friction"][-1] == pytest.approx(motion.rubbed[-1], abs=1e-8)
    for (point, wall), impulse in motion.tangential_impulse.items():
        if wall != "joint":
            name = f"contact[{point}].{wall}.friction_impulse"
            assert result[name][-1] == pytest.approx(impulse[-1], abs=1e-8)


@pytest.mark.parametrize("seed", [1, 4])
def test_normal_and_tangential_impulses_make_the_momentum(seed):
    """Of the whole chain: weight, and each wall's impulses along n and t = (n_y, −n_x)."""
    table = thrown(seed)
    result = run(table, output_step=0.02)
    scene = scene_from_dict(table, "friction")
    masses = [link["mass"] for link in table["chain"]["links"]]
    momentum = sum(
        0.5
        * mass
        * np.column_stack([result[f"point[{i}].v{a}"] + result[f"point[{i + 1}].v{a}"] for a in "xy"])
        for i, mass in enumerate(masses)
    )
    gained = momentum - momentum[0] - np.outer(result.time, [0.0, -9.81 * sum(masses)])
    given = np.zeros_like(gained)
    normals = {"y_min": np.array([0.0, 1.0]), "slope": np.array([-math.sin(1.9), math.cos(1.9)])}
    for name in (name for name in result.motion if name.endswith("impulse")):
        wall = name.split(".")[1]
        nx, ny = normals[wall]
        given += np.outer(result[name], (ny, -nx) if "friction" in name else (nx, ny))
    assert scene.has_contact_friction
    np.testing.assert_allclose(gained, given, rtol=0, atol=1e-9)


def test_an_arm_at_a_rigid_stop_leans_on_a_rough_floor_from_the_start():
    """Link 1 rests at its stop, and the tip of link 2 comes to rest on the floor, where μ is tan 27°."""
    length, mass, start = 0.5, 1.0, -1.0
    table = {
        "name": "Leaning",
        "chain": {
            "base": "pinned",
            "links": [{"length": length, "mass": mass, "joint_min": 0.1}, {"length": length, "mass": mass}],
        },
        "box": {"y_min": 0.0},
        "contact": {"stiffness": 1e6, "restitution": 0.1, "friction": 0.5},
        "stops": {"model": "newton_impact"},
        "initial": {
            "position": [0.3, -length * (math.sin(0.1) + math.sin(start))],
            "angles": [0.1, start],
        },
        "simulation": {"stop_time": 2.0, "step_size": 1e-2},
    }
    result = run(table)
    assert result["link[1].angle"] == pytest.approx(0.1, abs=1e-14)
    tip, angle = result.points[:, 2], result["link[2].angle"][-1]
    assert np.abs(tip - tip[0]).max() < 1e-3
    normal, tangential = (result[f"contact[2].y_min.{name}"][-1] for name in ("force", "friction_force"))
    assert tangential == pytest.approx(0.5 * normal, rel=1e-12)
    assert 1e6 * (-tip[-1, 1]) ** 1.5 == pytest.approx(normal, rel=1e-5)  # it still creeps
    # the moments about joint 2
    weight = mass * 9.81 * math.cos(angle) / 2.0
    assert normal * math.cos(angle) - tangential * math.sin(angle) == pytest.approx(weight, rel=1e-6)
