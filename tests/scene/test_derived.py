"""Derived values stay derived until a file gives them, after any change, write or comparison."""

# Tests: scene/complete_scene.py, scene/keys/default_rules.py

import pickle
import tomllib
from dataclasses import replace

import pytest

from chain_impact.scene.derived import enclosing_paths
from chain_impact.scene.files.models import model_names
from chain_impact.scene.scene import load_scene, parse_scene, scene_from_dict, scene_to_dict
from tests.helpers.scenes.derived_scenes import FINGER, edited, finger
from tests.helpers.tools.refusal import refusal

CHANGES = [
    {"link[1].length": 0.6},
    {"link[2].mass": 0.2, "link[2].length": 0.35},
    {"link[3].length": 0.3},
    {"chain.base": "free", "link[1].joint_max": None},
    {"contact.restitution": 0.45, "contact.exponent": 1.25},
    {"contact.friction": 0.5},
    {"link[1].length": 0.6, "link[1].center_of_mass": 0.2},
    {"contact.restitution": 0.45, "stop.restitution": 0.9},
    {"contact.points": [3], "chain.base": "pinned"},
    {"initial.angular_velocity[2]": 1.5},
    {"link[1].joint_max": None, "link[2].joint_min": None, "link[2].joint_max": None},
]


@pytest.mark.parametrize("changes", CHANGES, ids=str)
def test_a_changed_scene_is_that_of_the_edited_file(changes):
    assert finger().with_values(changes) == edited(FINGER, changes)


def test_changes_one_after_the_other_are_those_at_once():
    scene, all_of_it = finger(), {}
    for changes in CHANGES:
        if None not in changes.values():
            scene, all_of_it = scene.with_values(changes), all_of_it | changes
            assert scene == finger().with_values(all_of_it)


def test_a_set_value_is_derived_again_once_it_is_removed():
    scene = finger().with_values({"link[1].inertia": 0.5})
    assert "link[1].inertia" not in scene.derived
    assert scene.with_values({"link[1].length": 2.0}).values["link[1].inertia"] == 0.5
    derived_again = scene.with_values({"link[1].inertia": None})
    assert derived_again == finger()
    assert (
        derived_again.with_values({"link[1].length": 2.0}).values["link[1].inertia"] == 0.5 * 2.0 * 2.0 / 12
    )


def test_a_value_that_is_given_as_it_would_be_derived_is_given():
    scene = finger()
    given_scene = scene.with_values({"link[1].inertia": scene.values["link[1].inertia"]})
    assert given_scene.values == scene.values
    assert given_scene != scene
    assert (
        given_scene.with_values({"link[1].mass": 9.0}).values["link[1].inertia"]
        == scene.values["link[1].inertia"]
    )


def test_a_scene_tells_what_it_derives_and_how():
    assert finger().derived == {
        "link[1].center_of_mass": "length / 2",
        "link[1].inertia": "mass * length^2 / 12",
        "link[2].center_of_mass": "length / 2",
        "contact.points": "all that move",
        "stop.exponent": "as in [contact]",
        "stop.restitution": "as in [contact]",
    }
    assert finger().with_values(finger().values).derived == {}


def test_a_written_scene_is_read_as_the_same_scene():
    for scene in map(load_scene, model_names()):
        data = scene_to_dict(scene)
        assert scene_from_dict(data, "f") == scene
        assert not scene.derived or scene_to_dict(scene, derived=True) != data
        assert scene_from_dict(scene_to_dict(scene, derived=True), "f").derived == {}


def test_equal_links_are_derived_alike():
    text = 'name = "Rope"\nchain = {links = [{length = 1, mass = 1}, {length = 2, mass = 1, count = 2}]}\n'
    rope = parse_scene(text + "initial.angles = [0, 0, 0]", "rope.toml")
    assert [name for name in rope.derived if "inertia" in name] == [f"link[{i}].inertia" for i in (1, 2, 3)]
    assert rope.with_values({"link[3].length": 4.0}).values["link[3].center_of_mass"] == 2.0


def test_a_scene_keeps_what_it_derives_when_it_is_copied():
    scene = finger()
    assert pickle.loads(pickle.dumps(scene)) == replace(scene) == scene
    assert pickle.loads(pickle.dumps(scene)).derived == scene.derived


def test_derived_values_are_no_keys():
    message = refusal(scene_from_dict, tomllib.loads(FINGER) | {"derived_paths": []}, "f")
    assert message.startswith("f: derived_paths is unknown")


def test_a_name_that_is_no_path_has_no_parent():
    assert enclosing_paths([("a", 1, "b"), 3, None, ("a", [])]) == {("a",), ("a", 1)}
