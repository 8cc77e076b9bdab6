"""What a scene refuses and how: values, keys, walls, starts inside walls."""

import math

import pytest

from chain_impact.kernel.laws.contact_laws import CONTACT_LAWS
from chain_impact.scene.checks import hints
from chain_impact.scene.scene import load_scene, model_names, scene_to_dict, with_values
from tests.problems import of_law
from tests.refusal import refusal


def refused(*changes) -> str:
    """Return the message for the four-link scene with (path, value) changes; it starts with the source."""
    message = refusal(with_values, load_scene("four_link_box"), dict(changes))
    assert message.startswith("FourLinkBox: ")
    return message.removeprefix("FourLinkBox: ")


LINK_2 = ("chain", "links", 2)


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ((*LINK_2, "mass"), -1.0, "link[3].mass = -1.0 must be a finite number > 0 [kg]"),
        ((*LINK_2, "length"), 0, "link[3].length = 0 must be a finite number > 0 [m]"),
        ((*LINK_2, "mass"), True, "link[3].mass = True must be a finite number > 0 [kg]"),
        ((*LINK_2, "mass"), "1", "link[3].mass = '1' must be a finite number > 0 [kg]"),
        ((*LINK_2, "inertia"), -1.0, "link[3].inertia = -1.0 must be a finite number >= 0 [kg.m2]"),
        (
            (*LINK_2, "joint_stiffness"),
            -1.0,
            "link[3].joint_stiffness = -1.0 must be a finite number >= 0 [N.m/rad]",
        ),
        (
            (*LINK_2, "joint_rest_angle"),
            math.inf,
            "link[3].joint_rest_angle = inf must be a finite number [rad]",
        ),
        (("gravity", 1), math.nan, "gravity.y = nan must be a finite number [m/s2]"),
        (("box", "x_max"), math.inf, "box.x_max = inf must be a finite number [m]"),
        (("contact", "stiffness"), 10**400, f"contact.stiffness = 1{'0' * 59}... must be a finite number"),
        (("contact", "restitution"), 1.1, "contact.restitution = 1.1 must be a finite number >= 0 and <= 1"),
        (("solver", "tolerance"), 1, "solver.tolerance = 1 must be a finite number >= 1e-13 and <= 0.01"),
        (("chain", "base"), "hinged", 'chain.base = \'hinged\' must be one of "free", "pinned"'),
        (("solver", "method"), 1, 'solver.method = 1 must be one of "auto", "explicit"'),
        (("inputs", "tip_force"), 1, "inputs.tip_force = 1 must be true or false"),
        (("name",), "4 links", "name = '4 links' must be letters, digits and _, not beginning with a digit"),
        (("name",), "Größe", "name = 'Größe' must be letters, digits and _"),
        (("name",), None, "name is missing (model name)"),
        (("description",), "bell\a", r"description = 'bell\x07' must be text without control characters"),
        (("contact",), [], "contact = [] must be a table"),
        (("chain", "links"), [], "chain.links has 0 entries, must have 1 to 1000"),
        (("chain", "links", 1), 7, "link[2] = 7 must be a table"),
        (("initial", "angles"), [1.0], "initial.angles has 1 value, must have 4, one for each link"),
        (("initial", "angles"), 1.0, "initial.angles = 1.0 must be a list, expected length 4 "),
        (
            ("walls",),
            {"x_max": 1.0},
            "walls is one table, must be a list of tables: write [[walls]]; x_max belongs in [box]",
        ),
        (
            ("chain", "links"),
            {"mass": 1.0},
            "chain.links is one table, must be a list of tables: write [[chain.links]]",
        ),
        (("gravity",), 9.81, "gravity = 9.81 must be a list, expected length 2 (acceleration of gravity)"),
        (("contact", "points"), [1, 5], "contact.points holds 5, must hold 0 to 4 with a free base, each"),
        (("contact", "points"), [-1], "contact.points holds -1, must hold 0 to 4 with a free base, each"),
        (("contact", "points"), [2, 2], "contact.points holds 2, must hold 0 to 4 with a free base, each"),
        (("contact", "points"), [1.0], "contact.points[1] = 1.0 must be a whole number"),
        (("chain", "base"), "pinned", "contact.points holds 0, must hold 1 to 4 with a pinned base"),
        (("box", "x_max"), 0.0, "box.x_max = 0.0 must be > 0.0 [m], which is x_min + 2 contact.radius"),
        (("contact", "radius"), 1.25, "box.y_max = 2.5 must be > 2.5 [m], which is y_min + 2 contact.radius"),
        (("chain", "links", 9, "mass"), 1, "('chain', 'links', 9, 'mass') is no path to a value"),
        ((), 1, "() is no path to a value of the scene"),
        (5, 1, "5 is no path to a value of the scene"),
    ],
)
def test_a_bad_value_is_refused_by_key_value_and_what_is_allowed(path, value, message):
    assert refused((path, value)).startswith(message)


@pytest.mark.parametrize(
    ("path", "known"),
    [
        (("contact", "stifness"), "contact.stiffness"),
        (("contact", "tolerance"), "solver.tolerance"),  # right key, wrong table
        (("simulation", "gravity"), "gravity"),
        (("contcat",), "contact"),
        (("chain", "links", 3, "lenght"), "chain.links[].length"),
        (("initial", "angle"), "initial.angles"),  # not wall.angle
        (("contacts",), "contact"),  # not outputs.contacts
    ],
)
def test_an_unknown_key_names_the_nearest(path, known):
    assert refused((path, 1.0)).endswith(f"{path[-1]} is unknown; the nearest key is {known}")


def test_of_a_key_like_no_other_the_keys_of_its_table_are_named():
    message = refused((("simulation", "duration"), 1.0))
    assert message == "simulation.duration is unknown; the keys here are stop_time, step_size"


def test_no_rebound_is_refused_by_the_laws_that_divide_by_restitution():
    for law in CONTACT_LAWS.values():
        plastic = {("contact", key): value for key, value in of_law(law.id).items()}
        plastic["contact", "restitution"] = 0.0
        if law.allows_zero:
            assert with_values(load_scene("rod_drop"), plastic).contact.restitution == 0.0
        else:
            message = refused(*plastic.items())
            assert message == f"contact.restitution = 0.0 must be > 0 for the contact model {law.id}"


def test_a_pinned_base_cannot_have_a_velocity():
    message = refusal(with_values, load_scene("pinned_arm"), {("initial", "velocity"): [0.0, 1e-9]})
    assert message == "PinnedArm: initial.velocity = [0.0, 1e-09] must be zero for a pinned base"


@pytest.mark.parametrize(
    ("wall", "at", "where"),
    [
        ("x_min", 0.7, "point 0 at (0.6, 1.4) m is 0.1 m"),
        ("y_min", 1.45, "point 0 at (0.6, 1.4) m is 0.05 m"),
        ("x_max", 2.3, "point 4 at (2.34686, 1.59108) m is 0.0468643 m"),
        ("y_max", 1.6, "point 3 at (1.85683, 1.69041) m is 0.0904142 m"),
    ],
)
def test_a_start_inside_a_wall_is_refused(wall, at, where):
    message = refused((("box", wall), at))
    assert message == f"initial: {where} deep in the wall {wall}; must be outside"


def test_the_start_may_touch_a_wall_but_not_by_more_than_round_off():
    touching = {("initial", "position"): [0.0, 0.25], ("contact", "radius"): 0.25}
    rod = with_values(load_scene("rod_drop"), touching)
    with_values(rod, {("initial", "position", 1): 0.25 - 1e-13})
    message = refusal(with_values, rod, {("initial", "position", 1): 0.125})
    assert "point 0 at (0, 0.125) m is 0.125 m deep in the wall y_min; must be outside" in message
    # a point that is no candidate passes through walls, so it may be anywhere
    with_values(rod, {("initial", "position", 1): 0.125, ("contact", "points"): [1]})


# --- walls at any angle ----------------------------------------------------------------------------------

RAMP = {"name": "ramp", "point": [0.0, -2.0]}


def test_a_wall_has_an_angle_or_a_normal_and_keeps_the_angle():
    walls = [RAMP | {"normal": [3.0, 4.0]}, RAMP | {"name": "floor", "angle": 0.25}]
    scene = with_values(load_scene("four_link_box"), {("walls",): walls})
    assert [wall.angle for wall in scene.walls] == [-math.atan2(3.0, 4.0), 0.25]
    assert [wall.normal for wall in scene.walls] == [None, None]
    assert scene.wall_names == ("x_min", "x_max", "y_min", "y_max", "ramp", "floor")
    assert scene_to_dict(scene)["walls"][1] == {"name": "floor", "point": [0.0, -2.0], "angle": 0.25}
    turned = with_values(scene, {("walls", 0, "angle"): -0.5, ("walls", 1, "point", 0): 3})
    assert (turned.walls[0].angle, turned.walls[1].point) == (-0.5, (3.0, -2.0))
    again = {("walls", 0, "angle"): None, ("walls", 0, "normal"): [0, 2]}
    assert with_values(scene, again).walls[0].angle == 0.0


@pytest.mark.parametrize(
    ("walls", "message"),
    [
        ([RAMP], "wall.ramp has neither angle nor normal; must have one of them"),
        (
            [RAMP | {"angle": 0.0, "normal": [0.0, 1.0]}],
            "wall.ramp has both angle and normal; must have",
        ),
        ([RAMP | {"normal": [0.0, 0.0]}], "wall.ramp.normal = [0.0, 0.0] must not be zero"),
        ([RAMP | {"normal": [1.0]}], "wall.ramp.normal has 1 value, must have 2 ("),
        ([RAMP | {"angle": "up"}], "wall.ramp.angle = 'up' must be a finite number [rad]"),
        (
            [RAMP | {"angle": 0.0}] * 2,
            "walls[2].name = 'ramp' must be none of x_min, x_max, y_min, y_max, ramp",
        ),
        (
            [RAMP | {"angle": 0.0, "name": "y_min"}],
            "walls[1].name = 'y_min' must be none of x_min, x_max, y_",
        ),
        (
            [RAMP | {"angle": 0.0, "name": "my wall"}],
            "walls[1].name = 'my wall' must be letters, digits and _",
        ),
        ([{"point": [0.0, 0.0], "angle": 0.0}], "walls[1].name is missing"),
        ([{"name": "ramp", "angle": 0.0}], "wall.ramp.point is missing (a point on the wall)"),
        ({}, "walls is one table, must be a list of tables: write [[walls]]"),
        (7, "walls = 7 must be a list"),
        ([RAMP | {"angel": 0.0}], "wall.ramp.angel is unknown; the nearest key is"),
    ],
)
def test_a_bad_wall_is_refused(walls, message):
    assert refused((("walls",), walls)).startswith(message)


def test_a_start_inside_a_wall_at_a_slant_is_refused():
    walls = [RAMP | {"normal": [1.0, 1.0], "point": [2.0, 0.25]}]
    message = refused((("walls",), walls))
    assert message == (
        "initial: point 0 at (0.6, 1.4) m is 0.176777 m deep in the wall ramp; must be outside"
    )
    with_values(load_scene("four_link_box"), {("walls",): walls, ("contact", "points"): [2, 3, 4]})


@pytest.mark.parametrize("model", model_names())
def test_models_give_no_hints(model):
    assert hints(load_scene(model)) == []
