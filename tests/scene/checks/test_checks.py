"""Refused scenes and their messages: values, keys, walls, starts inside walls."""

# Tests: scene/checks/rule_checks.py, scene/kernel_view.py, scene/rules/key_rules.py, scene/rules/refusals.py

import ast
import math
import re
import warnings
from pathlib import Path

import numpy as np
import pytest

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.scene.checks.checks import scene_hints
from chain_impact.scene.errors import SceneWarning
from chain_impact.scene.files.models import model_names
from chain_impact.scene.scene import load_scene, parse_scene, scene_from_dict, scene_to_dict, with_values
from tests.helpers.scenes.problems import of_law
from tests.helpers.tools.refusal import refusal
from tests.scene.finger import FINGER

HEEL = "link[2].point[1].x"


def refused(*changes) -> str:
    """Return the message for (path, value) changes of the four-link scene, without the name of the scene."""
    message = refusal(with_values, load_scene("four_link_box"), dict(changes))
    assert message.startswith("FourLinkBox: ")
    return message.removeprefix("FourLinkBox: ")


def table():
    """Yield name of a scene, changes, and the beginning of the message, from each case in refused.txt."""
    scene = None
    for line in Path(__file__).with_name("refused.txt").read_text(encoding="utf-8").splitlines():
        if line.startswith("["):
            scene = line.strip("[]")
        elif line and not line.startswith("#"):
            changes, message = line.split(" -> ")
            yield scene, dict(map(change, changes.split("; "))), message


def value_of(text):
    """Return the value of a text: a number, also nan or inf, or a text, a list or a table."""
    return float(text) if text in ("nan", "inf", "-inf") else ast.literal_eval(text)


def change(text):
    """Return the name (with dots) or the path (with slashes) of a value, and the value, from their text."""
    name, value = text.split(" = ", 1)
    path = tuple(int(part) if part.isdigit() else part for part in name.split("/"))
    return (path if "." not in name else name), value_of(value)


def test_scenes_are_refused_with_the_listed_sentences():
    scenes, mismatches = {"finger": parse_scene(FINGER, "finger.toml")}, []
    for name, changes, start in table():
        scene = scenes.setdefault(name, scenes.get(name) or load_scene(name))
        message = refusal(with_values, scene, changes)
        if not message.startswith(f"{scene.name}: {start}"):
            mismatches.append((changes, message))
    assert mismatches == []


@pytest.mark.parametrize("path", [(), 5])
def test_values_that_are_no_path_are_refused(path):
    assert refused((path, 1)).startswith(f"{path} is not a path to a value of the scene")
    number = {("contact", "stiffness"): 10**400}
    assert refused(*number.items()).startswith(f"contact.stiffness = 1{'0' * 59}... must be a finite number")


def test_no_rebound_is_refused_by_the_laws_that_divide_by_restitution():
    for law in CONTACT_LAWS.values():
        plastic = {("contact", key): value for key, value in of_law(law.id).items()}
        plastic["contact", "restitution"] = 0.0
        if law.allows_zero:
            assert with_values(load_scene("rod_drop"), plastic).contact.restitution == 0.0
        else:
            requirement = f"must be > 0 for the contact model {law.id}; newton_impact allows 0"
            assert refused(*plastic.items()) == f"contact.restitution = 0.0 {requirement}"


def test_the_start_may_touch_a_wall_but_not_by_more_than_round_off():
    touching = {("initial", "position"): [0.0, 0.25], ("contact", "radius"): 0.25}
    rod = with_values(load_scene("rod_drop"), touching)
    with_values(rod, {("initial", "position", 1): 0.25 - 1e-13})
    message = refusal(with_values, rod, {("initial", "position", 1): 0.125})
    assert "point 0 at (0, 0.125) m is 0.125 m deep in the wall y_min; must be outside" in message
    # a point that is not a candidate passes through walls, so its position is free
    with_values(rod, {("initial", "position", 1): 0.125, ("contact", "points"): [1]})


def test_a_pinned_base_beyond_a_wall_is_warned_of():
    arm = load_scene("pinned_arm")
    pattern = r"pinned base at \(0, 0\) m is 0\.1 m beyond the wall x_max"
    with pytest.warns(SceneWarning, match=pattern):
        arm.with_values({"box.x_max": -0.1})
    with warnings.catch_warnings():
        warnings.simplefilter("error", SceneWarning)
        arm.with_values({"box.x_max": 0.0})


@pytest.mark.parametrize(
    ("changes", "question"),
    [
        ({"link[1].length": 500.0}, "link[1].length = 500 m is long for link[1].mass = 1 kg: is it in mm?"),
        ({"gravity.y": -9810.0}, "m/s² is a thousand times as strong as on earth: is it in mm/s²?"),
        ({HEEL: -60.0}, "point 3 is 60 m from the joint of its link, far for a chain of 0.5 m"),
    ],
)
def test_lengths_in_millimetres_are_asked_about(changes, question):
    model, outside = ("hopper", "box.y_min") if HEEL in changes else ("pinned_arm", "box.x_max")
    with pytest.warns(SceneWarning, match=re.escape(question)):
        load_scene(model).with_values({outside: None, **changes})


# --- walls at any angle ----------------------------------------------------------------------------------

RAMP = {"name": "ramp", "point": [0.0, -2.0]}


def test_a_wall_has_an_angle_or_a_normal_and_keeps_the_angle():
    walls = [RAMP | {"normal": [3.0, 4.0]}, RAMP | {"name": "floor", "angle": 0.25}]
    scene = with_values(load_scene("four_link_box"), {("walls",): walls})
    assert [wall.angle for wall in scene.walls] == [-math.atan2(3.0, 4.0), 0.25]
    assert [wall.normal for wall in scene.walls] == [None, None]
    assert scene.wall_names == ("x_min", "x_max", "y_min", "y_max", "ramp", "floor")
    assert scene_to_dict(scene)["walls"][1] == {"name": "floor", "point": [0.0, -2.0], "angle": 0.25}
    turned_scene = with_values(scene, {("walls", 0, "angle"): -0.5, ("walls", 1, "point", 0): 3})
    assert (turned_scene.walls[0].angle, turned_scene.walls[1].point) == (-0.5, (3.0, -2.0))
    changes = {("walls", 0, "angle"): None, ("walls", 0, "normal"): [0, 2]}
    assert with_values(scene, changes).walls[0].angle == 0.0


def test_initial_angles_of_joints_take_the_place_of_those_of_links():
    data = scene_to_dict(load_scene("four_link_box"))
    joints = {"angles": None, "joint_angles": [0.35, "-45 deg", 1.3, -1.0]}
    scene = scene_from_dict(data | {"initial": data["initial"] | joints}, "here")
    angles = np.cumsum([0.35, -math.pi / 4.0, 1.3, -1.0])
    np.testing.assert_array_equal(scene.initial.angles, angles)
    # the scene stores the angles of links only
    assert scene_to_dict(scene)["initial"]["angles"] == angles.tolist()
    assert "joint_angles" not in scene_to_dict(scene)["initial"]
    assert not any("angles" in place for place in scene.derived_paths)
    changed_scene = load_scene("four_link_box").with_values({"initial.joint_angles": joints["joint_angles"]})
    assert changed_scene.initial == scene.initial
    part = {"initial.joint_angles": joints["joint_angles"], "initial.angle[1]": 0.2}
    assert "both angles and joint_angles" in refusal(load_scene("four_link_box").with_values, part)
    pattern = r"initial.angle\[1\] is set, and the absolute angles of the links behind it stay"
    with pytest.warns(SceneWarning, match=pattern):
        turned_scene = scene.with_values({"link[1].joint_damping": 0.1}).with_values(
            {"initial.angle[1]": 0.2}
        )
    assert turned_scene.initial.angles == (0.2, *scene.initial.angles[1:])
    with warnings.catch_warnings():
        warnings.simplefilter("error", SceneWarning)
        scene.with_values({"initial.angle[4]": 0.2})
        scene.with_values({"initial.angles": scene.initial.angles}).with_values({"initial.angle[1]": 0.2})
        load_scene("four_link_box").with_values({"initial.angle[1]": 0.2})
    data_with_both = data | {"initial": data["initial"] | {"joint_angles": [0.0, 0.0, 0.0, 0.0]}}
    assert "both angles and joint_angles" in refusal(scene_from_dict, data_with_both, "here")


def test_models_give_no_hints():
    assert {
        name: found_hints for name in model_names() if (found_hints := scene_hints(load_scene(name)))
    } == {}


def test_a_start_in_a_wall_asks_whether_a_length_is_in_mm():
    text = """
    name = "Rod"
    [[chain.links]]
    length = 400.0
    mass = 1.2
    [box]
    x_max = 1.0
    [initial]
    angles = [0.3]
    """
    assert refusal(parse_scene, text, "rod.toml").endswith(
        "must be outside; link[1].length = 400 m is long for link[1].mass = 1.2 kg: is it in mm?"
    )
