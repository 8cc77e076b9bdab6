"""Walls at any angle: their geometry, and motions between them, against closed forms and the box."""

import math

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from chain_impact.scene.half_planes import HalfPlane, direction, half_planes
from chain_impact.scene.scene import with_values
from tests.helpers.scenes.problems import GRAVITY, ball, default_scene, flat_chain, rest_depth
from tests.helpers.scenes.turned import turned

ANGLES = (0.3, math.pi / 2, 2.5, -1.1)
# unit vectors down the ramp of the model, and normal to the ramp
ALONG_RAMP, UP = np.array([0.8, -0.6]), np.array([0.6, 0.8])


# --- half-planes -----------------------------------------------------------------------------------------


def test_the_free_side_of_a_wall_is_where_clearances_are_positive():
    walls = half_planes({"y_max": 2.0, "x_min": -1.0}, {"ramp": (1.0, 3.0, math.pi / 6)})
    assert list(walls) == ["x_min", "y_max", "ramp"]
    assert walls["x_min"] == HalfPlane((1.0, 0.0), -1.0)
    assert walls["y_max"] == HalfPlane((0.0, -1.0), -2.0)
    assert walls["x_min"].clearance(0.5, 9.0) == 1.5
    assert walls["y_max"].clearance(7.0, 1.25) == 0.75
    # 2 m along the ramp, and 0.25 m to the left of the ramp
    c, s = math.cos(math.pi / 6), math.sin(math.pi / 6)
    assert walls["ramp"].clearance(1.0 + 2.0 * c - 0.25 * s, 3.0 + 2.0 * s + 0.25 * c) == pytest.approx(0.25)


@pytest.mark.parametrize("length", [1e-200, 1.0, 1e200])
@pytest.mark.parametrize("angle", np.linspace(-3.0, 3.0, 13))
def test_the_direction_of_a_wall_follows_from_its_normal(angle, length):
    normal = -length * math.sin(angle), length * math.cos(angle)
    assert direction(normal) == pytest.approx(angle, abs=1e-15)


def test_the_direction_of_a_floor_is_zero_without_a_sign():
    assert math.copysign(1.0, direction((0.0, 1.0))) == 1.0


# --- closed forms ------------------------------------------------------------------------------------------


def bounces(height, acceleration, restitution, times):
    """Return impact times, impact speeds, and heights at all times of a point that is dropped from rest."""
    speed = math.sqrt(2.0 * acceleration * height)
    onsets, speeds = [speed / acceleration], [speed]
    while onsets[-1] < times[-1] and speeds[-1] > 1e-6:
        onsets.append(onsets[-1] + 2.0 * restitution * speeds[-1] / acceleration)
        speeds.append(restitution * speeds[-1])
    before = np.searchsorted(onsets, times, side="right")
    since = times - np.array([0.0, *onsets])[before]
    start = np.where(before == 0, height, 0.0)
    launch = np.where(before == 0, 0.0, restitution * np.array([0.0, *speeds])[before])
    heights = np.maximum(0.0, start + launch * since - acceleration * since**2 / 2.0)
    return np.array(onsets), np.array(speeds), heights


def test_a_disc_on_a_ramp_bounces_as_the_closed_form_says():
    """Ramp and stop are perpendicular, so their motions are independent: two dropped points."""
    scene = with_values(load_scene("ramp"), {("contact", "model"): "newton_impact"})
    result = simulate(scene, tolerance=1e-12)
    names = [scene.wall_names[wall] for wall in result.impacts["wall"]]
    place = result.points[:, 0]
    for name, along, height, pull in (
        ("ramp", UP, 0.5, 0.8 * GRAVITY),
        ("stop", -ALONG_RAMP, 1.9, 0.6 * GRAVITY),
    ):
        onsets, speeds, heights = bounces(height, pull, 0.6, result.time)
        impacts = result.impacts[[wall_name == name for wall_name in names]]
        # the closed form replaces the last, ever smaller bounces by rest
        count = np.count_nonzero(speeds > 0.01)
        assert len(impacts) >= count
        np.testing.assert_allclose(impacts["onset"][:count], onsets[:count], rtol=0, atol=1e-11)
        np.testing.assert_allclose(impacts["impact_speed"][:count], speeds[:count], rtol=0, atol=1e-10)
        np.testing.assert_allclose(
            impacts["separation_speed"][:count], 0.6 * speeds[:count], rtol=0, atol=1e-10
        )
        np.testing.assert_allclose(place @ along, heights + 0.05, rtol=0, atol=1e-5)
    # a frictionless disc gets no rotation
    np.testing.assert_allclose(result.angular_velocities, 6.0, rtol=1e-12)


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("model", ["zhang_sharf", "newton_impact"])
def test_a_ball_that_falls_along_a_wall_arrives_at_the_next_one(model, angle):
    """The ball touches the wall during the fall, and the search must still find the next wall."""
    scene = ball(0.5, 0.0, gravity=GRAVITY, model=model, radius=0.1)
    scene = with_values(scene, {("box", "x_min"): -0.1, ("initial", "position", 1): 0.6})
    for tolerance in (1e-4, 1e-10):
        result = simulate(turned(scene, angle), stop_time=0.4, tolerance=tolerance)
        impacts = result.impacts[result.impacts["wall"] == 5]  # the wall in place of y_min
        assert impacts["onset"][0] == pytest.approx(math.sqrt(1.0 / GRAVITY), abs=1e-11)
        assert impacts["impact_speed"][0] == pytest.approx(math.sqrt(GRAVITY), rel=1e-9)
        assert result.statistics["rhs_evaluations"] < 3000


@pytest.mark.parametrize("method", ["auto", "explicit", "implicit"])
@pytest.mark.parametrize("model", ["zhang_sharf", "newton_impact"])
def test_a_ball_rests_on_two_walls_that_form_a_v(model, method):
    """N₁ n₁ + N₂ n₂ + m g = 0 for walls that descend to the right by 0.5 rad and to the left by 0.8 rad."""
    scene = ball(0.2, 0.0, gravity=GRAVITY, model=model, restitution=0.2, stiffness=1e6, radius=0.03)
    walls = [{"name": name, "point": [0.1, -0.2], "angle": a} for name, a in (("left", -0.5), ("right", 0.8))]
    scene = with_values(scene, {("box",): {}, ("walls",): walls, ("solver", "method"): method})
    last = simulate(scene, stop_time=3.0, tolerance=1e-6).outputs[-1]
    normals = np.array([[math.sin(0.5), -math.sin(0.8)], [math.cos(0.5), math.cos(0.8)]])
    forces = np.linalg.solve(normals, [0.0, GRAVITY])
    np.testing.assert_allclose(last["force"], forces, rtol=1e-4)
    depth = 0.0 if model == "newton_impact" else (forces / 1e6) ** (2 / 3)
    np.testing.assert_allclose(last["penetration"], depth, rtol=1e-4)
    gaps = normals.T @ (last["point_position"][0] - [0.1, -0.2]) - 0.03
    np.testing.assert_allclose(gaps, -depth * np.ones(2), rtol=0, atol=1e-8)


# --- the box ------------------------------------------------------------------------------------------------


def back(vectors, angle):
    """Return vectors in the plane, in the last axis, turned back."""
    c, s = math.cos(angle), math.sin(angle)
    return vectors @ np.array([[c, -s], [s, c]])


def check_turned(scene, angle, within, **options):
    """Check that a scene turned as a whole has the same motion, turned; return the results of both."""
    plain, slanted = simulate(scene, **options), simulate(turned(scene, angle), **options)
    np.testing.assert_allclose(back(slanted.points, angle), plain.points, rtol=0, atol=within)
    np.testing.assert_allclose(slanted.angles - angle, plain.angles, rtol=0, atol=within)
    assert slanted.impacts["point"].tolist() == plain.impacts["point"].tolist()
    assert slanted.impacts["wall"].tolist() == (plain.impacts["wall"] + 4).tolist()
    np.testing.assert_allclose(slanted.impacts["onset"], plain.impacts["onset"], rtol=0, atol=within)
    return plain, slanted


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("model", ["zhang_sharf", "flores", "hertz", "newton_impact"])
def test_a_scene_turned_as_a_whole_gives_the_motion_turned_as_a_whole(model, angle):
    plain, _ = check_turned(default_scene(model=model), angle, 1e-9, stop_time=1.2, tolerance=1e-12)
    assert len(plain.impacts) >= 5


@pytest.mark.parametrize("angle", ANGLES)
def test_implicit_steps_at_rest_are_those_of_the_box(angle):
    scene = flat_chain(1e-4, restitution=0.1, stiffness=1e10)
    options = {"stop_time": 0.1, "tolerance": 1e-7, "method": "implicit"}
    _, slanted = check_turned(scene, angle, 1e-9, **options)
    assert slanted.statistics["implicit_steps"] == slanted.statistics["steps"]
    depth = rest_depth(scene, 5)
    last = slanted.outputs[-1]
    assert 0.5 * depth < last["penetration"].max() < 2.0 * depth
    assert last["force"].sum() == pytest.approx(4 * GRAVITY, rel=1e-3)


@pytest.mark.parametrize("model", ["zhang_sharf", "newton_impact"])
def test_four_walls_at_right_angles_are_a_box(model):
    """The floor's normal (0, 1) is exact; the other normals have round-off in one component."""
    plain, walls = check_turned(default_scene(model=model), 0.0, 1e-11, stop_time=1.2)
    assert plain.statistics == walls.statistics


def test_a_box_and_slanted_walls_stand_side_by_side():
    """Walls of the box come first in the list of walls."""
    changes = {("box",): {"x_max": 3.0}, ("walls",): [{"name": "floor", "point": [9.0, 0.0], "angle": 0.0}]}
    mixed = with_values(default_scene(), changes)
    plain = with_values(default_scene(), {("box",): {"x_max": 3.0, "y_min": 0.0}})
    first, other = (simulate(scene, stop_time=1.2) for scene in (mixed, plain))
    assert first.outputs.tobytes() == other.outputs.tobytes()
    named = [[result.scene.wall_names[wall] for wall in result.impacts["wall"]] for result in (first, other)]
    assert named[0] == [name.replace("y_min", "floor") for name in named[1]]
    assert set(named[0]) == {"x_max", "floor"}
