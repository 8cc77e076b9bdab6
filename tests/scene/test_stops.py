"""Stops in joints and materials of walls: their keys, defaults and names, and what is refused."""

import math
import tomllib
from functools import partial

import pytest

from chain_impact import load_scene
from chain_impact.kernel.laws.contact_laws import CONTACT_LAWS
from chain_impact.scene.checks import hints
from chain_impact.scene.scene import parse_scene, scene_from_dict, scene_to_dict, with_values
from tests.refusal import refusal

FILE = """
name = "Finger"
chain.base = "pinned"
initial.angles = [0.0, "45 deg"]
[[chain.links]]
length = 0.1
mass = 0.2
joint_min = "-90 deg"
[[chain.links]]
length = 0.1
mass = 0.2
joint_min = 0.0
joint_max = 2.0
[box]
x_max = 1.0
y_max = 0.5
[contact]
exponent = 2
[contact.wall.y_max]
restitution = 0.25
[stops]
stiffness = 500
"""


def finger(**changes):
    """The scene with the tables of the file changed."""
    data = tomllib.loads(FILE)
    for table, keys in changes.items():
        data[table] = data.get(table, {}) | keys
    return scene_from_dict(data, "finger.toml")


def test_keys_and_their_defaults():
    scene = parse_scene(FILE, "finger.toml")
    assert [link.joint_min for link in scene.chain.links] == [-math.pi / 2, 0.0]
    assert [link.joint_max for link in scene.chain.links] == [None, 2.0]
    assert scene.chain.stops == ((1, "joint_min"), (2, "joint_min"), (2, "joint_max"))
    stops = scene.stops
    assert (stops.model, stops.stiffness, stops.exponent) == (None, 500.0, 2.0)
    assert (stops.restitution, stops.minimum_impact_speed) == (0.7, 1e-3)
    assert list(scene.contact.wall) == ["x_max", "y_max"]
    assert scene.contact.wall["y_max"].restitution == 0.25
    assert scene.contact.wall["y_max"].stiffness is None


def test_a_scene_without_stops_and_materials_has_no_more_keys():
    scene = load_scene("four_link_box")
    assert scene.stops.stiffness is None
    assert scene.wall_names == ("x_min", "x_max", "y_min", "y_max")
    assert "stops" not in scene_to_dict(scene)
    assert "wall" not in scene_to_dict(scene)["contact"]


def test_the_scene_as_data_is_the_same_scene():
    scene = finger()
    data = scene_to_dict(scene)
    assert data["contact"]["wall"] == {"y_max": {"restitution": 0.25}}
    assert scene_from_dict(data, "again") == scene
    assert scene.with_values(scene.values).values == scene.values
    assert hash(scene) == hash(scene_from_dict(data, "again"))


def test_values_are_set_by_their_names():
    changes = {"wall.x_max.stiffness": 1e6, "stop.restitution": 0.5, "stops.model": "flores"}
    scene = finger().with_values(changes)
    assert {name: scene.values[name] for name in changes} == changes
    assert scene.with_values({"link[1].joint_max": "180 deg"}).chain.links[0].joint_max == math.pi
    by_path = {("contact", "wall", "y_max", "restitution"): 0.125, ("stops", "stiffness"): 1e3}
    assert with_values(scene, by_path).values["wall.y_max.restitution"] == 0.125
    assert with_values(scene, by_path).values["stop.stiffness"] == 1e3
    assert scene.with_values({"stops.restitution": 0.25}).stops.restitution == 0.25
    by_number = scene.with_values({"stops.model": CONTACT_LAWS["hertz"].number})
    assert by_number.stops.model == "hertz"


def test_a_stop_that_is_added_brings_the_defaults():
    box = load_scene("four_link_box").with_values({"contact.restitution": 0.5})
    scene = box.with_values({"link[2].joint_min": -2.0})
    assert (scene.stops.stiffness, scene.stops.restitution, scene.stops.exponent) == (1e5, 0.5, 1.5)
    assert scene.with_values({"link[2].joint_min": None, "stops": None}) == box


def test_equal_links_have_equal_stops():
    links = [{"length": 1.0, "mass": 1.0}, {"length": 1.0, "mass": 1.0, "count": 3, "joint_max": 1.0}]
    data = {"name": "Chain", "chain": {"links": links}, "initial": {"angles": [0.0] * 4}}
    assert scene_from_dict(data, "chain").chain.stops == (
        (2, "joint_max"),
        (3, "joint_max"),
        (4, "joint_max"),
    )


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"link[2].joint_min": 2.0},
            "link[2].joint_max = 2.0 must be > 2.0 [rad], which is link[2].joint_min",
        ),
        (
            {"link[2].joint_min": "2 rad"},
            "link[2].joint_min = '2 rad' must be a finite number [rad], or text",
        ),
        ({"link[2].joint_min": -math.inf}, "link[2].joint_min = -inf must be a finite number [rad]"),
        ({"stop.stiffness": 0.0}, "stop.stiffness = 0.0 must be a finite number > 0 [N.m/rad^exponent]"),
        ({"stop.restitution": 1.5}, "stop.restitution = 1.5 must be a finite number >= 0 and <= 1"),
        ({"stops.exponent": 0.5}, "stop.exponent = 0.5 must be a finite number >= 1 and <= 3"),
        ({"stops.model": "rubber"}, "stops.model = 'rubber' must be one of"),
        (
            {"wall.y_max.stiffness": -1.0},
            "wall.y_max.stiffness = -1.0 must be a finite number > 0 [N/m^expon",
        ),
        (
            {"stops.model": "flores", "stop.restitution": 0.0},
            "stops.restitution = 0.0 must be > 0 for the contact model flores",
        ),
        (
            {"contact.model": "flores", "wall.x_max.restitution": 0.0},
            "wall.x_max.restitution = 0.0 must be > 0 for the contact model flores",
        ),
        (
            {"stops.model": "kelvin_voigt"},
            "stops.exponent = 2.0 must be 1.0 for the contact model kelvin_voigt",
        ),
        (
            {"initial.angle[1]": -1.75},
            "initial: joint 1 at -1.75 rad is 0.179204 rad beyond its joint_min = -1.5708 rad; must be ",
        ),
        (
            {"initial.angle[2]": -6.0},
            "initial: joint 2 at -6 rad is 6 rad beyond its joint_min = 0 rad; must be within; "
            "whole turns count, and 0.283185 rad is the same direction",
        ),
        (
            {"initial.angle[1]": -1.0, "initial.angle[2]": 1.5},
            "initial: joint 2 at 2.5 rad is 0.5 rad beyond its joint_max = 2 rad; must be within",
        ),
        (
            {"chain.base": "free"},
            "link[1].joint_min = -1.5707963267948966 must be left out: a free base has no joint 1; "
            "of equal links, link 1 needs an entry of its own",
        ),
        (
            {("walls",): [{"name": "joint_max", "point": [0.0, -9.0], "angle": 0.0}]},
            "walls[1].name = 'joint_max' must be none of joint_min, joint_max, as joints have stops",
        ),
        (
            {("box", "y_max"): None},
            "contact.wall = 'y_max' is no wall of the scene; must be one of x_max",
        ),
        ({("contact", "wall"): 3.0}, "contact.wall = 3.0 must be a table of tables"),
        ({("contact", "wall"): {"y_max": 3.0}}, "contact.wall.y_max = 3.0 must be a table"),
        (
            {"link[2].joint_min": None, "link[2].joint_max": None, "link[1].joint_min": None},
            "stops.stiffness = 5",
        ),
    ],
)
def test_what_cannot_be_is_refused(changes, message):
    assert refusal(with_values, finger(), changes).startswith(f"Finger: {message}")


@pytest.mark.parametrize(
    ("table", "keys", "message"),
    [
        (
            "stops",
            {"stifness": 1.0},
            "stop.stifness (stops.stifness) is unknown; the nearest key is stops.stiffness",
        ),
        (
            "stops",
            {"stiffness": "stiff"},
            "stop.stiffness (stops.stiffness) = 'stiff' must be a finite number > 0",
        ),
        (
            "contact",
            {"wall": {"y_min": {}}},
            "contact.wall = 'y_min' is no wall of the scene; must be one of x_m",
        ),
        (
            "contact",
            {"wall": {"x_max": {"restitution": 2}}},
            "wall.x_max.restitution (contact.wall.x_max.restitution) = 2 must be a finite number >= 0 a",
        ),
        (
            "contact",
            {"wall": {"x_max": {"mass": 2}}},
            "wall.x_max.mass (contact.wall.x_max.mass) is unknown; the nearest key is chain.li",
        ),
    ],
)
def test_a_file_names_its_keys(table, keys, message):
    assert refusal(partial(finger, **{table: keys})).startswith(f"finger.toml: {message}")


def test_materials_of_a_scene_without_walls():
    message = refusal(partial(finger, box={"x_max": None, "y_max": None}))
    assert (
        message == "finger.toml: contact.wall = 'y_max' is no wall of the scene; must be empty: "
        "the scene has no walls"
    )


def test_stops_without_a_joint_that_has_one():
    message = refusal(with_values, load_scene("rod_drop"), {"stop.restitution": 0.5})
    assert (
        message == "RodDrop: stops.restitution = 0.5 must be left out: no link has a joint_min or joint_max"
    )


def test_a_start_on_a_stop_is_none_beyond_it():
    at = finger().with_values({"initial.angle[1]": "-90 deg", "initial.angle[2]": "-90 deg"})
    assert at.initial.angles == (-math.pi / 2, -math.pi / 2)


def test_a_stop_in_degrees_without_a_unit_gives_a_hint():
    scene = finger().with_values({"link[2].joint_max": 90})
    assert hints(scene) == ['link[2].joint_max = 90 rad is 14.3 turns: if degrees are meant, write "90 deg"']


def test_a_law_of_ones_own_can_be_that_of_the_stops(tmp_path):
    law = tmp_path / "rubber.py"
    law.write_text(
        "def rubber(penetration, rate, stiffness, exponent, restitution, impact_speed, effective_mass):\n"
        "    return stiffness * penetration**exponent\n"
    )
    scene = finger().with_values({"contact.law_file": str(law), "stops.model": "rubber"})
    assert (scene.stops.model, scene.contact.model) == ("rubber", "zhang_sharf")
