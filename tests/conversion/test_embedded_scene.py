"""MJCF files of this package that a user has changed, or converts with other axes or joints."""

import json
import re

import numpy as np
import pytest

from chain_impact import SceneError
from chain_impact.conversion.convert import scene_of_robot
from chain_impact.conversion.mjcf_writing import mjcf_of
from chain_impact.conversion.planar import ConversionChoices
from chain_impact.scene.scene import parse_scene, scene_of
from tests.tiers import needs_interop

pytestmark = needs_interop
KNOB = """
<geom name="knob" type="sphere" size=".01" pos=".1 0 -.03" friction="0 0 0" contype="2" conaffinity="1"/>
"""
SOLE = '<site name="sole" pos="0.25 0 0.15"/>'
TOE = """
<body name="toe" pos=".25 0 0"><joint name="toe" axis="0 -1 0"/><site name="end" pos=".1 0 0"/>
<inertial pos=".05 0 0" mass=".1" diaginertia="1e-4 1e-4 1e-4"/></body>
"""
HOPPER = [(0.296, -0.02, 0.005, "heel"), (0.226, 0.102, 0.005, "toe")]


def converted(tmp_path, model, change=lambda text: text, **choices):
    (tmp_path / "model.xml").write_text(change(mjcf_of(scene_of(model))[0]), encoding="utf-8")
    return scene_of_robot(tmp_path / "model.xml", ConversionChoices(**choices))


def element(text, name):
    return next(tag for tag in re.findall(r"<[^>]*>", text) if f'name="{name}"' in tag)


def changed(name, attribute, value):
    """Return a change of an attribute of the element with a name."""

    def change(text):
        tag = element(text, name)
        return text.replace(tag, re.sub(rf'\b{attribute}="[^"]*"', f'{attribute}="{value}"', tag))

    return change


def extended(name, elements):
    """Return a change that adds elements behind the element with a name, or, without elements, removes it."""
    return lambda text: text.replace(element(text, name), element(text, name) + elements if elements else "")


def points_of(link):
    return [(point.x, point.y, point.radius, point.name) for point in link.points]


@pytest.mark.parametrize(("removed", "left"), [("ramp", "stop"), ("stop", "ramp")])
def test_a_wall_whose_plane_is_removed_is_no_wall(tmp_path, removed, left):
    scene, result = converted(tmp_path, "ramp", extended(removed, ""))
    assert [wall.name for wall in scene.walls] == [left]
    assert scene.walls[0] == next(wall for wall in scene_of("ramp").walls if wall.name == left)
    assert f"walls.{removed}" in result.notes[0]


SHAKEN = """
name = "Shaken"
walls = [{ name = "ramp", point = [0, -2], angle = 0.1 }]
chain = { base = "pinned", links = [{ length = 0.5, mass = 1 }, { length = 0.4, mass = 0.5 }] }
box = { x_max = 3 }
inputs = { wall_motion = ["ramp", "x_max"], joint_torques = true }
initial = { angles = [-1.0, 0.5] }
outputs = { sensitivities = ["link[1].mass", "wall.ramp.angle", "signal.shake.amplitude"] }
[signals.shake]
input = ["wall.ramp.displacement", "wall.x_max.displacement"]
form = "sine"
amplitude = 0.01
frequency = 2
rise = 0.1
[signals.push]
input = "joint[2].torque"
form = "constant"
value = 0.3
"""


def test_what_needs_a_removed_wall_or_motor_is_left_out_and_told(tmp_path):
    shaken = parse_scene(SHAKEN, "shaken.toml")
    scene, result = converted(tmp_path, shaken, extended("ramp", ""))
    assert (scene.inputs.wall_motion, scene.signals["push"]) == (("x_max",), shaken.signals["push"])
    assert scene.signals["shake"].input == ("wall.x_max.displacement",)
    assert scene.outputs.sensitivities == ("link[1].mass", "signal.shake.amplitude")
    message = "inputs.wall_motion ramp, signals.shake, outputs.sensitivities: left out or shortened"
    assert any(warning.startswith(message) for warning in result.warnings)
    scene_without_motors, result = converted(tmp_path, shaken, lambda text: re.sub(r"<motor[^>]*>", "", text))
    assert ([*scene_without_motors.signals], scene_without_motors.inputs.joint_torques) == (["shake"], False)
    assert any(warning.startswith("signals.push: left out") for warning in result.warnings)
    assert scene_without_motors.outputs.sensitivities == shaken.outputs.sensitivities


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (changed("point[3]", "pos", "0.3 0.0 -0.05"), [(0.3, -0.05, 0.005, "heel"), HOPPER[1]]),
        (changed("point[4]", "size", "0.02"), [HOPPER[0], (0.226, 0.102, 0.02, "toe")]),
        (extended("point[3]", ""), [HOPPER[1]]),
        (extended("point[3]", KNOB), [HOPPER[0], (0.1, -0.03, 0.01, "knob"), HOPPER[1]]),
    ],
    ids=["moved", "larger", "removed", "added"],
)
def test_a_shape_that_a_user_has_changed_is_a_changed_point(tmp_path, change, expected):
    scene, result = converted(tmp_path, "hopper", change)
    assert points_of(scene.chain.links[1]) == expected
    assert scene.contact.points == ()
    assert scene.signals == scene_of("hopper").signals
    assert [note.rpartition(": ")[2] for note in result.notes] == ["link[2].points"]


def test_a_box_with_a_moved_corner_has_points_in_place_of_its_shape(tmp_path):
    (link,) = scene_of("thrown_brick").chain.links
    scene, _ = converted(tmp_path, "thrown_brick", changed("point[2]", "pos", "0.0 0.0 -0.07"))
    (changed_link,) = scene.chain.links
    assert (link.shape, changed_link.shape, changed_link.height) == ("box", None, None)
    assert points_of(changed_link) == [(0.0, -0.07, 0.0, ""), *points_of(link)[1:]]
    assert (changed_link.mass, changed_link.inertia) == (link.mass, link.inertia)


@pytest.mark.parametrize(("number", "touching"), [(1, (2,)), (2, (1,))])
def test_a_joint_whose_shape_is_removed_does_not_touch(tmp_path, number, touching):
    scene, _ = converted(tmp_path, "pinned_arm", extended(f"point[{number}]", ""))
    assert scene.contact.points == touching
    assert not any(link.points for link in scene.chain.links)


def test_the_friction_of_a_changed_plane_holds(tmp_path):
    def friction(scene):
        return scene.contact.friction, scene.contact.wall["y_min"].friction

    converted_scene, result = converted(tmp_path, "hopper", changed("y_min", "friction", "0.5 0 0"))
    assert friction(converted_scene) == (0.9, 0.5)
    assert len(result.notes) == 1
    converted_scene, _ = converted(tmp_path, "hopper", changed("y_min", "condim", "1"))
    assert friction(converted_scene) == (0.9, 0.0)


@pytest.mark.parametrize(
    ("change", "name", "value"),
    [
        (changed("y_min", "pos", "0 0 -0.1"), "box.y_min", -0.1),
        (extended("y_min", ""), "box.y_min", None),
        (changed('slider" type="slide', "damping", "2.5"), "slider.damping", 2.5),
        (changed("joint[1]", "stiffness", "33"), "link[1].joint_stiffness", 33.0),
        (changed("start", "qvel", "0.5 0 0"), "initial.slider_velocity", 0.5),
    ],
)
def test_a_changed_element_holds_and_all_else_is_as_before(tmp_path, change, name, value):
    scene = scene_of("hopper").with_values({"slider.damping": 1.0})
    values = scene.values
    converted_scene, result = converted(tmp_path, scene, change)
    converted_values = converted_scene.values
    assert {key for key in values if values[key] != converted_values.get(key, values[key])} == {name}
    assert converted_values[name] == value
    assert name.rpartition(".")[2] in result.notes[0]


@pytest.mark.parametrize(
    ("choices", "change", "mirror", "links"),
    [
        ({"plane": "-x,z"}, str, -1.0, 2),
        ({"tip": "sole"}, extended("point[2]", SOLE), 1.0, 2),
        ({"joints": ["joint[2]"]}, str, 1.0, 1),
        ({"joints": ["slider", "joint[1]"]}, str, 1.0, 1),
        ({}, extended("point[2]", TOE), 1.0, 3),
    ],
    ids=["plane", "tip", "joint", "slider", "body"],
)
def test_points_are_at_the_same_places_whatever_axes_and_joints_are_chosen(
    tmp_path, choices, change, mirror, links
):
    scene = scene_of("hopper")
    converted_scene, result = converted(tmp_path, scene, change, **choices)
    assert len(converted_scene.chain.links) == links
    assert not converted_scene.signals
    assert any("signals" in line for line in result.warnings)
    for name in ("heel", "toe"):
        places = [
            either_scene.start[
                len(either_scene.chain.links)
                + 1
                + [site.name for _, site in either_scene.chain.sites].index(name)
            ]
            for either_scene in (scene, converted_scene)
        ]
        assert np.multiply(places[1], [mirror, 1.0, 1.0]) == pytest.approx(places[0], abs=1e-12)


def test_files_of_older_versions_are_read_and_other_texts_are_refused(tmp_path):
    scene = scene_of("thrown_brick")
    text = mjcf_of(scene)[0]
    embedded_text = re.search(r'name="chain_impact" data="([^"]*)"', text)[1]
    data = json.loads(embedded_text.replace("&quot;", '"'))
    numbers = {key: data.pop(key) for key in ("gravity", "chain", "box", "walls", "initial")}
    del data["name"]
    parts = json.dumps({"tables": data, "numbers": numbers, "bodies": [], "first_link": {}})
    (tmp_path / "old.xml").write_text(
        text.replace(embedded_text, parts.replace('"', "&quot;")), encoding="utf-8"
    )
    assert scene_of_robot(tmp_path / "old.xml")[0].values == scene.values
    for invalid_text in ("nothing", "[]", "{}"):
        (tmp_path / "wrong.xml").write_text(text.replace(embedded_text, invalid_text), encoding="utf-8")
        with pytest.raises(SceneError):
            scene_of_robot(tmp_path / "wrong.xml")
