"""Impulses of no duration: single impacts, several at once, and whole simulations under them."""

import math

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.scene.scene import SOLVER_METHODS, WALLS, with_values
from chain_impact.simulation.instance import Instance, SimulationError
from tests.newton import LAW, rigid
from tests.problems import (
    clattering_rod,
    cornered_rod,
    default_scene,
    flat_chain,
    flat_rod,
    heap,
    rod,
    struck_rod,
)
from tests.random_scenes import SLANTED, SPRUNG, scene as random_scene
from tests.reference import balance, moreau_impact, newton_impact
from tests.turned import mirrored


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


def test_an_impact_has_no_duration_no_depth_and_no_peak():
    result = simulate(rigid(struck_rod(0.5, 0.7, 1e8)[0]))
    (impact,) = result.impacts
    assert impact["end"] == impact["onset"]
    assert impact["separation_speed"] == pytest.approx(0.7 * impact["impact_speed"], rel=1e-12)
    assert impact["max_penetration"] == 0.0
    assert impact["peak_force"] == 0.0
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
    assert balance(result) < 1e-9
    assert np.diff(result.energy["total"]).max() < 1e-12
    assert result.points[:, :, 1].min() > -1e-12
    assert result.points[:, :, 1].max() < 0.999 + 1e-12


# --- any scene ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.7, 0.9])
def test_energy_never_rises(restitution):
    result = simulate(default_scene(model=LAW, restitution=restitution), stop_time=10.0, tolerance=1e-10)
    energy = result.energy
    assert np.diff(energy["total"]).max() < 1e-8 * energy["total"][0]
    assert (np.diff(energy["dissipated"]) >= 0.0).all()
    assert (result.outputs["force"] >= 0.0).all()
    assert balance(result) < 1e-7


@pytest.mark.full("takes long")
@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_a_hundred_links_fall_in_a_heap(restitution):
    result = simulate(heap(stop_time=3.0, model=LAW, restitution=restitution), output_step=1e-2)
    assert len(result.impacts) > 1000
    assert balance(result) < 1e-5
    assert (result.outputs["force"] >= 0.0).all()
    assert result.points[:, :, 1].min() > -1e-7


def test_the_record_holds_everything():
    """A copy of its bytes, taken while some points are held, goes on bit by bit as the original does."""
    instance, other = (Instance(default_scene(model=LAW, restitution=0.3)) for _ in range(2))
    assert instance.advance(1.5) == 0
    assert instance.record["touch"]["active_count"] > 0
    other.words[:] = instance.words
    for one in (instance, other):
        assert one.advance(6.0) == 0
    assert instance.words.tobytes() == other.words.tobytes()


def test_a_bounce_off_which_links_turn_far_faster_does_not_hold_up_the_solver():
    """A step as long as that before it would be of 15 turns; its errors overflow."""
    wall = 2.290016350654996
    values = {
        ("solver", "tolerance"): 1e-4,
        ("solver", "method"): "explicit",
        ("initial", "position"): (0.0, 0.0),
        ("initial", "velocity"): (3.5634856097160164, 3.942296303296642),
        ("initial", "angles"): (
            1.9217599797316,
            -2.7438948538530545,
            -3.064778828822475,
            -1.8066526540180536,
        ),
        ("initial", "angular_velocities"): (
            -0.9326127638667658,
            -0.8311383187044885,
            -0.5477486814351775,
            -0.2465287975569228,
        ),
        ("box", "x_min"): -2.3410989985259376,
        ("box", "y_min"): -wall,
        **{("box", name): wall for name in ("x_max", "y_max")},
    }
    result = simulate(with_values(default_scene(model=LAW, restitution=0.9), values), stop_time=1.0)
    assert len(result.impacts) == 2
    assert result.statistics["rejected_steps"] <= result.statistics["steps"]


def test_communication_points_change_neither_result_nor_cost():
    scene = default_scene(model=LAW, restitution=0.3)
    coarse, fine = simulate(scene, 4.0, 0.1), simulate(scene, 4.0, 1e-3)
    assert coarse.statistics == fine.statistics
    assert coarse.impacts.tobytes() == fine.impacts.tobytes()
    assert np.array_equal(coarse.outputs[-1], fine.outputs[-1])


@pytest.mark.parametrize(("seed", "tolerance"), [(307, 1e-5), (427, 1e-5), (1544, 1e-2), (3196, 1e-2)])
def test_no_point_arrives_backwards(seed, tolerance):
    """A point that lies at a wall, which the error of a step has turned round by its onset."""
    first = (0, SLANTED, SPRUNG)[seed % 3]
    scene = random_scene(first + seed)
    changes = {
        ("contact", "model"): "newton_impact",
        ("solver", "tolerance"): tolerance,
        ("solver", "method"): "auto",
        ("simulation", "stop_time"): min(2.0, scene.simulation.stop_time),
    }
    try:
        impacts = simulate(with_values(scene, changes), output_step=math.inf, output=()).impacts
    except SimulationError as fault:  # what has happened until then counts
        impacts = fault.result.impacts
    assert len(impacts) > 10
    assert (impacts["impact_speed"] >= 0.0).all()
    assert not np.signbit(impacts["impact_speed"]).any()
