"""Names of paths; test_scene.py and variables/test_table.py compare them with the FMU's names."""

# Tests: scene/texts/similar_names.py

import re

import pytest

from chain_impact import load_scene
from chain_impact.scene.texts.input_table import input_key
from chain_impact.scene.texts.names import grouped_by_owner, name_of, name_parts, path_text
from chain_impact.scene.texts.parameter_hints import parameter_hint
from chain_impact.scene.texts.similar_names import longer_name, name_with_one_typo, nearest_name
from chain_impact.study_data.sweep.variation import variations_of
from tests.helpers.tools.refusal import refusal


@pytest.mark.parametrize(
    ("path", "name", "text"),
    [
        (("gravity", 0), "gravity.x", "gravity[1]"),
        (("gravity",), "gravity", "gravity"),
        (("chain", "links", 9), "link[10]", "chain.links[10]"),
        (
            ("chain", "links", 0, "points", 1, "x"),
            "link[1].point[2].x",
            "chain.links[1].points[2].x",
        ),
        (("chain", "links", 0, "mass"), "link[1].mass", "chain.links[1].mass"),
        (("walls", 1, "point", 1), "wall.stop.y", "walls[2].point[2]"),
        (("walls", 1, "angle"), "wall.stop.angle", "walls[2].angle"),
        (("walls", 1, "name"), "walls[2].name", "walls[2].name"),
        (("walls", 0, "normal", 1), "walls[1].normal[2]", "walls[1].normal[2]"),
        (("walls",), "walls", "walls"),
        (("initial", "position", 1), "initial.y", "initial.position[2]"),
        (("initial", "velocity", 0), "initial.vx", "initial.velocity[1]"),
        (("initial", "angles", 2), "initial.angle[3]", "initial.angles[3]"),
        (
            ("initial", "angular_velocities", 0),
            "initial.angular_velocity[1]",
            "initial.angular_velocities[1]",
        ),
        (("contact", "points", 0), "contact.points[1]", "contact.points[1]"),
        (("simulation", "stop_time"), "simulation.stop_time", "simulation.stop_time"),
    ],
)
def test_a_path_has_a_name_and_a_text(path, name, text):
    assert name_of(path, [None, "stop"]) == name
    assert path_text(path) == text


def test_only_similar_names_are_proposed():
    names = ["contact.stiffness", "contact.restitution"]
    assert nearest_name("contact.stifness", names) == "contact.stiffness"
    assert nearest_name("mass", names) is None
    assert nearest_name("mass", names, at_least=0.0) in names


def test_a_name_of_one_part_is_nearest_to_a_name_with_such_a_last_part():
    names = ["link[1].mass", "link[1].length", "link[2].length"]
    assert nearest_name("lenght", names) == "link[1].length"
    stops = [*names, "stop.stiffness", "contact.stiffness"]
    assert nearest_name("stifness", stops) == nearest_name("stiffness", stops) == "contact.stiffness"
    assert nearest_name("mass", names) == "link[1].mass"
    assert nearest_name("force", names) is None


def test_a_name_without_its_number_is_nearest_to_the_first_entry():
    names = ["chain.slider.angle", "initial.angle[1]", "initial.angle[2]", "link[1].mass", "link[1].inertia"]
    assert nearest_name("initial.angle", names) == "initial.angle[1]"
    assert nearest_name("initial.angle[]", names) == "initial.angle[1]"
    assert nearest_name("link.mass", names) == "link[1].mass"
    assert nearest_name("link[7].mass", names) == "link[1].mass"
    assert nearest_name("contact[3].force", ["contact.force", "contact[5].force"]) == "contact[5].force"


def test_a_name_that_is_part_of_another_one():
    names = ["clattering_rod", "rod_drop", "rodent"]
    assert longer_name("rod", names) == "rod_drop"
    assert [longer_name(name, names) for name in ("ro", "", "drop_rod")] == [None] * 3
    assert longer_name("mass", ["link[1].mass", "link[1].center_of_mass"]) == "link[1].mass"


def test_the_key_that_makes_an_input():
    assert input_key("joint[12].torque") == "joint_torques"
    assert input_key("tip.force.y") == "tip_force"
    assert [input_key(name) for name in ("tip.force.z", "joint[1].torques", "joint.torque")] == [None] * 3


def test_a_link_that_there_is_needs_no_hint():
    assert [parameter_hint(f"link[{i}].massa", 3, ()) for i in (1, 3)] == [None, None]
    assert [parameter_hint(f"link[{i}].mass", 3, ()) for i in (0, 4)] == ["links count from 1 to 3"] * 2


@pytest.mark.parametrize(
    ("name", "key"),
    [
        ("slider.velocity", "initial.slider_velocity"),
        ("slider.position", "initial.x and initial.y"),
        ("link[3].angle", r"initial.angle\[3\]"),
        ("link[1].angular_velocity", r"initial.angular_velocity\[1\]"),
        ("joint[2].angle", r"initial.angle\[2\] sets the absolute angle of link 2"),
        ("joint[2].velocity", r"initial.angular_velocity\[2\]"),
        ("base.vx", "initial.vx"),
        ("base.position", "initial.x and initial.y"),
        ("point[0].y", "initial.y"),
        ("point[2].y", r"initial.y and initial.angle\[1\]"),
    ],
)
def test_a_quantity_of_the_motion_proposes_its_value_at_the_start(name, key):
    assert re.search(rf"{key} .*at the start$", parameter_hint(name, 3, ()))


def test_a_value_of_a_slider_that_a_scene_lacks_is_not_proposed():
    scene = load_scene("pinned_arm")
    for name in ("slider.mass", "chain.slider.mass", "slider.position"):
        assert refusal(scene.with_values, {name: 1.0}).endswith(
            f'{name} is not a parameter; only a base on a slider has it: chain.base = "slider"'
        )
        assert 'has it: chain.base = "slider"' in refusal(variations_of, scene, {name: [1.0, 2.0]})
    assert load_scene("cart_pole").with_values({"slider.mass": 3.0}).chain.slider.mass == 3.0


def test_a_name_with_the_same_last_part_is_nearer():
    names = ["point[1].y", "contact[1].y_min.force", "contact[1].y_min.friction_force"]
    assert nearest_name("joint[1].force", names) == "contact[1].y_min.force"
    assert nearest_name("point[1].force", ["point[1].y"]) == "point[1].y"


@pytest.mark.parametrize(
    ("name", "parts"),
    [
        ("contact[2].y_min.force", ("contact", 2, "y_min", "force")),
        ("joint[3].force.x", ("joint", 3, "", "force.x")),
        ("wall.ramp.load.x", ("wall", 0, "ramp", "load.x")),
        ("wall.ramp.friction", ("wall", 0, "ramp", "friction")),
        ("contact.friction", ("contact", 0, "", "friction")),
        ("signal.push.time[2]", ("signal", 0, "push", "time[2]")),
        ("link[1].point[2].x", ("link", 1, "", "point[2].x")),
        ("energy.total", ("energy", 0, "", "total")),
        ("impact.count", ("impact", 0, "", "count")),
        ("a table's column [m]", ("", 0, "", "a table's column [m]")),
    ],
)
def test_the_parts_of_a_name(name, parts):
    assert name_parts(name) == parts
    assert grouped_by_owner({name: 1.0}) == {parts[:3]: {parts[3]: 1.0}}


def test_a_longer_name_of_the_same_owner_is_nearest():
    names = ["joint[1].peak_force", "joint[2].force.x", "joint[2].peak_force", "contact[2].x_max.force"]
    assert nearest_name("joint[2].peak", names) == "joint[2].peak_force"
    assert nearest_name("joint[2].force", names[2:]) == "joint[2].peak_force"
    assert nearest_name("joint[3].force", [*names[:1], names[3]]) == "contact[2].x_max.force"


def test_one_typo_is_one_letter_more_less_other_or_swapped():
    names = ["vx", "box", "walls"]
    assert [name_with_one_typo(name, names) for name in ("bax", "bx", "boxx", "bxo", "xbox")] == ["box"] * 5
    assert name_with_one_typo("wall", names) == "walls"
    assert [name_with_one_typo(name, names) for name in ("vy", "oxb", "boxes", "")] == [None] * 4
