"""Impacts with force laws and rigid walls: exact solutions, the rigid limit, simultaneous impacts, runs."""

import math

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.kernel.record.constants import SOLVER_METHODS, WALLS
from chain_impact.scene.scene import with_values
from chain_impact.scene.texts.names import SLIDER_STOPS, STOPS
from chain_impact.simulation.errors import SimulationError
from chain_impact.simulation.instance import Instance
from tests.helpers.campaigns.random_scenes import SLANTED, SPRUNG, scene as random_scene
from tests.helpers.models.reference import (
    balance,
    exact_damping_factor,
    momenta,
    moreau_impact,
    newton_impact,
)
from tests.helpers.scenes.problems import (
    GRAVITY,
    RIGID,
    clattering_rod,
    cornered_rod,
    default_scene,
    flat_chain,
    flat_rod,
    heap,
    rigid,
    rod,
    struck_ball,
    struck_rod,
)
from tests.helpers.scenes.turned import mirrored

as_both = pytest.mark.parametrize("law", ["zhang_sharf", RIGID])
"""The parameters: with a force law, and with rigid walls."""


def with_law(law, scene):
    return rigid(scene) if law == RIGID else scene


def around_first_impact(scene):
    """Return the rows just before and just after the first impact, which is rigid."""
    onset = simulate(scene).impacts["onset"][0]
    instance = Instance(scene)
    rows = np.zeros(2, instance.record.dtype["output"])
    assert instance.trajectory(np.array([onset, np.nextafter(onset, np.inf)]), rows) == 2
    return rows


def velocities(row):
    """Return q̇ of a row of outputs: base velocity, then angular velocities."""
    return np.concatenate([row["point_velocity"][0], row["angular_velocity"]])


# --- one impact --------------------------------------------------------------------------------------------


@pytest.mark.full("more cases", but=2)
@pytest.mark.parametrize("restitution", [0.3, 1.0])
@pytest.mark.parametrize(
    ("exponent", "stiffness"), [(1.0, 1e8), (1.3, 1e8), (1.5, 1e5), (1.5, 1e11), (2.0, 1e8), (3.0, 1e8)]
)
def test_an_impact_is_exact_for_any_exponent(exponent, stiffness, restitution):
    scene, exact = struck_ball(
        damping_factor=exact_damping_factor(restitution),
        exponent=exponent,
        stiffness=stiffness,
        restitution=restitution,
    )
    result = simulate(scene)
    (impact,) = result.impacts
    assert impact["max_penetration"] == pytest.approx(exact.max_penetration, rel=1e-7)
    assert impact["peak_force"] == pytest.approx(exact.peak_force, rel=1e-7)
    assert impact["end"] - impact["onset"] == pytest.approx(exact.duration, rel=1e-7)
    assert impact["separation_speed"] == pytest.approx(exact.separation_speed, rel=1e-7)
    assert result.energy["dissipated"][-1] == pytest.approx(exact.dissipated, rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("method", SOLVER_METHODS)
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
def test_every_method_keeps_its_tolerance_in_an_impact(method, tolerance):
    scene, exact = struck_ball(damping_factor=exact_damping_factor(0.7))
    (impact,) = simulate(scene, method=method, tolerance=tolerance).impacts
    for name in ("max_penetration", "peak_force", "separation_speed"):
        assert impact[name] == pytest.approx(getattr(exact, name), rel=30 * tolerance)


@pytest.mark.parametrize("part", [0.1, 0.3, 0.7])
def test_an_unfinished_contact_tells_its_peaks_so_far(part):
    scene, exact = struck_ball(damping_factor=exact_damping_factor(0.7))
    result = simulate(scene, stop_time=1e-3 + part * exact.duration, output_step=1e-6)
    (impact,) = result.impacts
    assert math.isnan(impact["end"])
    assert math.isnan(impact["separation_speed"])
    assert impact["max_penetration"] == pytest.approx(result.outputs["penetration"].max(), rel=1e-5)
    assert impact["peak_force"] == pytest.approx(result.outputs["force"].max(), rel=1e-5)


@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.7, 1.0])
def test_a_chains_first_impact_is_newtons(restitution):
    scene = default_scene(model=RIGID, restitution=restitution)
    before, after = around_first_impact(scene)
    impact = simulate(scene, stop_time=0.51).impacts[0]
    contact = int(impact["point"]), WALLS[impact["wall"]]
    expected, effective = newton_impact(scene, before["angle"], velocities(before), contact, restitution)
    np.testing.assert_allclose(velocities(after), expected, rtol=0, atol=1e-10)
    assert impact["effective_mass"] == pytest.approx(effective, rel=1e-10)
    # ½ m (1 − e²) u²
    lost = 0.5 * effective * (1 - restitution**2) * impact["impact_speed"] ** 2
    assert before["total"] - after["total"] == pytest.approx(lost, abs=1e-12)
    assert after["dissipated"] - before["dissipated"] == pytest.approx(lost, abs=1e-12)


@pytest.mark.parametrize("model", ["four_link_box", "ramp", "hopper", "kneed_leg", "cart_pole"])
def test_an_impact_has_the_position_at_which_its_point_touches(model):
    result = simulate(model)
    for impact in result.impacts[:3]:
        row = simulate(model, stop_time=impact["onset"])
        at_joint = impact["wall_name"] in STOPS
        place = row.point_at(impact["point"] - at_joint, impact["onset"])
        if impact["wall_name"] not in (*STOPS, *SLIDER_STOPS):
            wall, reach = row.wall_of(impact), result.touching_radii[impact["point"]]
            assert wall.clearance(impact["x"], impact["y"]) == pytest.approx(0.0, abs=1e-9)
            place = place - reach * np.array(wall.normal)
        assert (impact["x"], impact["y"]) == pytest.approx(tuple(place), abs=1e-9)


def test_a_rigid_impact_has_no_duration_no_depth_and_no_peak():
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
    """The error of a stiff wall falls as K^(−2/5), and its cost does not grow with K."""
    scene, exact = struck_rod(tilt, restitution, 1e8)
    scene = rigid(with_values(scene, {("initial", "velocity"): (0.8, -1.0)}))
    before, after = around_first_impact(scene)
    spin = math.copysign(exact.spin, -tilt)  # the sign tells which end is hit
    assert after["angular_velocity"][0] == pytest.approx(spin, abs=1e-10)
    moves = [row["point_velocity"].mean(axis=0) for row in (before, after)]
    assert moves[1][1] == pytest.approx(exact.speed, abs=1e-10)
    assert moves[1][0] == pytest.approx(moves[0][0], abs=1e-14)  # the wall is frictionless
    stiffness, errors = np.array([1e6, 1e8, 1e10, 1e12]), []
    for k in stiffness:
        result = simulate(struck_rod(tilt, restitution, k)[0])
        assert result.impacts["effective_mass"][0] == pytest.approx(exact.effective_mass, rel=1e-12)
        assert result.statistics["steps"] < 60
        momentum, _ = momenta(result)
        errors.append((abs(result.angular_velocities[-1, 0] - spin), abs(momentum[-1, 1] - exact.speed)))
    for column in np.transpose(errors):
        assert np.polyfit(np.log(stiffness), np.log(column), 1)[0] == pytest.approx(-0.4, abs=0.01)


# --- several at once ---------------------------------------------------------------------------------------


@as_both
@pytest.mark.parametrize("restitution", [0.1, 0.5, 0.9])
def test_a_flat_rod_rebounds_like_a_point_and_does_not_turn(restitution, law):
    result = simulate(flat_rod(model=law, restitution=restitution))
    assert len(result.impacts) == 2
    within = 1e-12 if law == RIGID else 1e-7
    np.testing.assert_allclose(result.impacts["separation_speed"], restitution, rtol=within)
    assert np.abs(result.angular_velocities).max() < 1e-12


@as_both
@pytest.mark.parametrize("restitution", [0.1, 0.5, 0.9, 1.0])
def test_the_second_end_of_a_clattering_rod_arrives_faster(restitution, law):
    scene, speed = clattering_rod(restitution)
    impacts = simulate(with_law(law, scene)).impacts
    assert impacts["point"][:2].tolist() == [0, 1]
    assert impacts["end"][0] < impacts["onset"][1]
    assert impacts["impact_speed"][1] == pytest.approx(speed, rel=1e-6)


@as_both
@pytest.mark.parametrize("restitution", [0.1, 0.7, 1.0])
def test_a_rod_returns_from_a_corner_as_it_came(restitution, law):
    result = simulate(with_law(law, cornered_rod(restitution)))
    assert len(result.impacts) == 2
    back, within = result.outputs["point_velocity"][-1], 1e-12 if law == RIGID else 1e-7
    np.testing.assert_allclose(back, restitution * math.sqrt(0.5), rtol=within)
    assert np.abs(result.angular_velocities).max() < 1e-12


def test_five_points_with_unlike_speeds_get_moreaus_impulses():
    """The middle of the chain falls faster, so that the set of acting impulses is not obvious."""
    for spins in ((1.0, -1.0, 1.0, -1.0), (-2.0, 1.0, 1.0, 2.0), (0.5, 0.5, -0.5, -0.5)):
        scene = rigid(flat_chain(1e-3, restitution=0.4))
        velocity = {("initial", "velocity"): (0.2, -2.0), ("initial", "angular_velocities"): spins}
        instance = Instance(with_values(scene, velocity | {("gravity",): (0.0, 0.0)}))
        # all points are on the floor and moving: the start of an impact
        state = instance.record["step"]["state_end"]
        position_y, rates = 1, slice(6, 12)  # of the state: x, y and four angles, then their rates
        state[position_y] = 0.0
        before = state[rates].copy()
        floor = WALLS.index("y_min")
        arriving = [(k, "y_min") for k in range(5) if before[1] + 0.5 * sum(spins[:k]) < 0.0]
        for point, _ in arriving:
            instance.record["contacts"]["event"][instance.prepared_scene.candidates.index((point, floor))] = 1
        instance.advance(1e-15)
        after = instance.record["step"]["state"][rates]
        expected = moreau_impact(scene, [0.0] * 4, before, arriving, 0.4)
        np.testing.assert_allclose(after, expected, atol=1e-12)


@as_both
@pytest.mark.parametrize("tilts", [(0.0,) * 4, (0.3, 0.1, -0.1, -0.3)], ids=["flat", "bent"])
def test_a_symmetric_motion_stays_symmetric(law, tilts):
    result = simulate(with_law(law, flat_chain(0.05, tilts, stop_time=0.4, restitution=0.5)))
    assert len(result.impacts) > 5
    height, place = result.points[..., 1], result.points[..., 0] - result.points[:, 2:3, 0]
    np.testing.assert_allclose(height, height[:, ::-1], rtol=0, atol=1e-9)
    np.testing.assert_allclose(place, -place[:, ::-1], rtol=0, atol=1e-9)
    np.testing.assert_allclose(result.points[:, 2, 0], result.points[0, 2, 0], rtol=0, atol=1e-9)


@as_both
def test_a_mirrored_scene_has_a_mirrored_result(law):
    scene = with_values(default_scene(model=law), {("gravity",): (1.5, -9.81)})
    here, there = (simulate(thrown, 0.7, tolerance=1e-10) for thrown in (scene, mirrored(scene)))
    assert len(here.impacts) >= 2
    np.testing.assert_allclose(there.points * [-1.0, 1.0], here.points, rtol=0, atol=1e-9)
    np.testing.assert_allclose(there.impacts["onset"], here.impacts["onset"], rtol=0, atol=1e-9)
    np.testing.assert_array_equal(there.impacts["point"], here.impacts["point"])


@pytest.mark.parametrize("floor", [1e-1, 1e-3, 1e-6])
def test_a_second_hit_within_a_contact_is_no_explosion(floor):
    """One end rests, latched at a small speed; the other end falls and pushes the first into the floor."""
    scene = rod(0.3, 0.0, 0.0, gravity=GRAVITY, stop_time=1.0, restitution=0.5, minimum_impact_speed=floor)
    result = simulate(scene)
    impacts = result.impacts
    fall = impacts[impacts["point"] == 1][0]
    assert fall["impact_speed"] > 1.0
    assert (result.outputs["force"] >= 0.0).all()
    # no contact can be harder than an impact of the whole rod at the speed of the falling end
    ratio = fall["impact_speed"] ** 2 / scene.contact.stiffness
    hardest = (1 + exact_damping_factor(0.5)) * 1.1432626298 * scene.contact.stiffness * ratio**0.6
    assert impacts["peak_force"].max() < hardest
    assert np.diff(result.energy["total"]).max() < 1e-8


@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.6, 0.9])
def test_a_wedged_rod_hits_finitely_often(restitution):
    walls = {"y_min": 0.0, "y_max": 0.999}
    scene = rod(1.4, 0.004, 0.0, 2.0, box=walls, stop_time=2.0, model=RIGID, restitution=restitution)
    result = simulate(scene)
    assert result.statistics["steps"] < 1000
    assert balance(result) < 1e-9
    assert np.diff(result.energy["total"]).max() < 1e-12
    assert result.points[:, :, 1].min() > -1e-12
    assert result.points[:, :, 1].max() < 0.999 + 1e-12


# --- rigid walls in any scene ------------------------------------------------------------------------------


def test_neither_method_nor_stiffness_nor_exponent_means_anything():
    """At rigid walls nothing is stiff, so all steps are explicit for each method option."""
    plain = simulate(default_scene(model=RIGID))
    for method in SOLVER_METHODS:
        result = simulate(default_scene(model=RIGID, stiffness=1.0, exponent=3.0), method=method)
        assert result.statistics["implicit_steps"] == 0
        assert np.array_equal(result.outputs, plain.outputs)
        assert result.impacts.tobytes() == plain.impacts.tobytes()


@pytest.mark.full("takes long")
@pytest.mark.parametrize(("law", "restitution"), [("zhang_sharf", 0.7), (RIGID, 0.0), (RIGID, 0.5)])
def test_a_hundred_links_fall_in_a_heap(law, restitution):
    result = simulate(heap(stop_time=2.5, model=law, restitution=restitution), output_step=1e-2)
    assert len(result.impacts) > 1000
    assert balance(result) < 1e-5
    assert (result.outputs["force"] >= 0.0).all()
    assert result.points[:, :, 1].min() > (-1e-7 if law == RIGID else -1e-3)


def test_the_record_holds_everything():
    """A copy of the record's bytes, taken while points are held, continues bit-equal to the original."""
    instance, other = (Instance(default_scene(model=RIGID, restitution=0.3)) for _ in range(2))
    assert instance.advance(1.5) == 0
    assert instance.record["contacts"]["active_count"] > 0
    other.words[:] = instance.words
    for copy in (instance, other):
        assert copy.advance(6.0) == 0
    assert instance.words.tobytes() == other.words.tobytes()


def test_a_bounce_that_spins_links_fast_does_not_stop_the_solver():
    """A step as long as the previous step would make 15 turns; its errors overflow."""
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
    result = simulate(with_values(default_scene(model=RIGID, restitution=0.9), values), stop_time=1.0)
    assert len(result.impacts) == 2
    assert result.statistics["rejected_steps"] <= result.statistics["steps"]


@pytest.mark.parametrize(("seed", "tolerance"), [(307, 1e-5), (427, 1e-5), (1544, 1e-2), (3196, 1e-2)])
def test_no_point_arrives_backwards(seed, tolerance):
    """An error of the step has reversed the speed of a point at a wall until its onset."""
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
    except SimulationError as fault:  # the result until the failure counts
        impacts = fault.result.impacts
    assert len(impacts) > 10
    assert (impacts["impact_speed"] >= 0.0).all()
    assert not np.signbit(impacts["impact_speed"]).any()
