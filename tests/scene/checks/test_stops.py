"""Stops in joints and materials of walls: keys, defaults, names, and refused values."""

# Tests: scene/checks/checks.py

import math
import tomllib
from functools import partial

import pytest

from chain_impact import load_scene
from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.scene.checks.checks import scene_hints
from chain_impact.scene.scene import parse_scene, scene_from_dict, scene_to_dict, with_values
from tests.helpers.tools.refusal import refusal
from tests.scene.finger import FINGER


def finger(**changes):
    """Return the scene of FINGER with changed tables: name of a table → changed keys."""
    data = tomllib.loads(FINGER)
    for table, keys in changes.items():
        data[table] = data.get(table, {}) | keys
    return scene_from_dict(data, "finger.toml")


def test_keys_and_their_defaults():
    scene = parse_scene(FINGER, "finger.toml")
    assert [link.joint_min for link in scene.chain.links] == [-math.pi / 2, 0.0]
    assert [link.joint_max for link in scene.chain.links] == [None, 2.0]
    assert scene.chain.stops == ((1, "joint_min"), (2, "joint_min"), (2, "joint_max"))
    stops = scene.stops
    assert (stops.model, stops.stiffness, stops.exponent) == (None, 500.0, 2.0)
    assert (stops.restitution, stops.minimum_impact_speed) == (0.7, 1e-3)
    assert list(scene.contact.wall) == ["x_max", "y_max"]
    assert scene.contact.wall["y_max"].restitution == 0.25
    assert scene.contact.wall["y_max"].stiffness is None


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
    assert scene.with_values({"stop.model": "hertz"}).stops.model == "hertz"
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
    ("table", "keys", "message"),
    [
        (
            "stops",
            {"stifness": 1.0},
            "stops.stifness is unknown; the nearest key is stops.stiffness",
        ),
        (
            "stops",
            {"stiffness": "stiff"},
            "stops.stiffness = 'stiff' must be a finite number > 0",
        ),
        (
            "contact",
            {"wall": {"y_min": {}}},
            "contact.wall.y_min is not a wall of the scene; must be one of x_m",
        ),
        (
            "contact",
            {"wall": {"x_max": {"restitution": 2}}},
            "contact.wall.x_max.restitution = 2 must be a finite number >= 0 a",
        ),
        (
            "contact",
            {"wall": {"x_max": {"mass": 2}}},
            "contact.wall.x_max.mass is unknown; the nearest key is chain.sl",
        ),
    ],
)
def test_a_file_names_its_keys(table, keys, message):
    assert refusal(partial(finger, **{table: keys})).startswith(f"finger.toml: {message}")


def test_materials_of_a_scene_without_walls():
    message = refusal(partial(finger, box={"x_max": None, "y_max": None}))
    assert message == "finger.toml: contact.wall.y_max must be left out: the scene has no walls"


def test_a_start_on_a_stop_is_none_beyond_it():
    on_stops = finger().with_values({"initial.angle[1]": "-90 deg", "initial.angle[2]": "-90 deg"})
    assert on_stops.initial.angles == (-math.pi / 2, -math.pi / 2)


def test_a_stop_in_degrees_without_a_unit_gives_a_hint():
    scene = finger().with_values({"link[2].joint_max": 90})
    assert scene_hints(scene) == [
        'link[2].joint_max = 90 rad is 14.3 turns: if degrees are meant, write "90 deg"'
    ]


def test_a_law_of_ones_own_can_be_that_of_the_stops(tmp_path):
    law = tmp_path / "rubber.py"
    law.write_text(
        "def rubber(penetration, rate, stiffness, exponent, restitution, impact_speed, effective_mass):\n"
        "    return stiffness * penetration**exponent\n"
    )
    scene = finger().with_values({"contact.law_file": str(law), "stops.model": "rubber"})
    assert (scene.stops.model, scene.contact.model) == ("rubber", "zhang_sharf")
