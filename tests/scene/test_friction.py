"""Dry friction in the scene: keys, defaults, names, and refused values."""

# Tests: scene/contents.py, scene/facts.py, scene/keys/tables.py

import pytest

from chain_impact import load_scene
from chain_impact.scene.checks.rule_checks import coefficients
from chain_impact.scene.keys.tables import Material
from chain_impact.scene.scene import parse_scene, scene_to_dict, with_values
from tests.helpers.scenes.friction import pendulum, sled

BOX = load_scene("four_link_box")


def test_a_scene_has_no_friction_by_default():
    scene = load_scene("rod_drop")
    assert (scene.contact.friction, scene.contact.static_friction) == (0.0, 0.0)
    assert [link.joint_friction for link in scene.chain.links] == [0.0]
    assert (scene.has_contact_friction, scene.has_friction) == (False, False)
    assert scene.friction_joints == ()


def test_keys_of_a_file_come_back_in_the_file_that_is_written():
    text = """
        name = "Sled"
        chain.base = "pinned"
        chain.links = [{ length = 1.0, mass = 2.0, joint_friction = 0.5 }]
        box.y_min = -2.0
        box.x_max = 3.0
        contact.friction = 0.3
        contact.static_friction = 0.4
        contact.wall.y_min.friction = 0.1
        contact.wall.y_min.static_friction = 0.2
        initial.angles = [0.0]
        """
    scene = parse_scene(text, "sled")
    assert scene_to_dict(scene)["contact"]["wall"] == {"y_min": {"friction": 0.1, "static_friction": 0.2}}
    assert scene.values["wall.y_min.friction"] == 0.1
    assert scene.values["wall.x_max.friction"] is None
    assert scene.values["contact.static_friction"] == 0.4
    assert scene.values["link[1].joint_friction"] == 0.5


def test_values_by_their_names():
    changes = {"contact.friction": 0.2, "contact.static_friction": 0.25, "wall.slope.friction": 0.1}
    scene = sled(**changes)
    assert changes.items() <= scene.values.items()
    assert pendulum(**{"link[2].joint_friction": None}).friction_joints == (1,)
    assert pendulum(**{"link[2].joint_friction": 0.0}).friction_joints == (1, 2)


@pytest.mark.parametrize(
    ("material", "expected"),
    [
        ({}, (0.3, 0.4)),
        ({"friction": 0.5}, (0.5, 0.0)),
        ({"static_friction": 0.6}, (0.3, 0.6)),
        ({"friction": 0.1, "static_friction": 0.2}, (0.1, 0.2)),
        ({"friction": 0.0}, (0.0, 0.0)),
    ],
)
def test_a_wall_with_its_own_sliding_friction_has_its_own_static_one(material, expected):
    contact = sled(**{"contact.friction": 0.3, "contact.static_friction": 0.4}).contact
    assert coefficients(contact, Material(**material)) == expected


def test_parts_with_friction_are_listed():
    assert sled().has_contact_friction
    assert sled(**{"contact.friction": 0.0, "wall.slope.friction": 0.0}).has_contact_friction, "to be tuned"
    assert sled(**{"contact.friction": 0.0, "contact.static_friction": 0.1}).has_friction
    assert sled(**{"contact.friction": 0.0}).has_friction, "to be tuned"
    assert not sled(**{"contact.friction": None}).has_friction
    assert not sled(**{"contact.points": []}).has_friction
    assert not sled(**{"walls": ()}).has_friction
    assert pendulum().has_friction
    assert not pendulum().has_contact_friction


def test_a_free_base_has_no_joint_1():
    scene = with_values(BOX, {f"link[{i}].joint_friction": 0.2 for i in (1, 3)})
    assert scene.friction_joints == (3,)
    assert not with_values(BOX, {"link[1].joint_friction": 0.2}).has_friction


def test_rigid_walls_and_rigid_stops_may_have_friction_in_joints_beside():
    rigid = {"contact.model": "newton_impact", "link[2].joint_friction": 0.3, "wall.y_min.friction": 0.0}
    assert with_values(BOX, rigid).has_friction
    stops = {"contact.friction": 0.3, "link[2].joint_max": 2.0, "stops.model": "newton_impact"}
    assert with_values(BOX, stops).has_friction
