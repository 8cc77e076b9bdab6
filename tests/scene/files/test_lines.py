"""Errors of a scene file name the line, and a correct entry."""

import re

import pytest

from chain_impact import SceneError, load_scene, parse_scene
from chain_impact.scene.files.lines import line_of

TEXT = '''name = "Ball"
description = """
[contact]
radius = -1
"""
chain.base = "free"
[[chain.links]]
length = 0.1
mass = 0.5

[[chain.links]]  # the second
length = 0.2
mass = 0.5
[[chain.links.points]]
x = 0.1
[[chain.links.points]]
x = 0.2
[box]
y_min = 0
[contact]
points = [0]
wall.y_min.restitution = 0.5
[initial]
position = [0.0, 1.0]
angles = [0.0,
  0.0]
'''


@pytest.mark.parametrize(
    ("place", "line"),
    [
        (("name",), 1),
        (("chain", "base"), 6),
        (("chain", "links", 0, "mass"), 9),
        (("chain", "links", 1, "mass"), 13),
        (("chain", "links", 1, "inertia"), 11),
        (("chain", "links", 1, "points", 1, "x"), 17),
        (("contact", "points", 0), 21),
        (("contact", "radius"), 20),
        (("contact", "wall", "y_min", "restitution"), 22),
        (("initial", "angles", 1), 25),
        (("solver", "method"), None),
        ((), None),
    ],
)
def test_the_line_of_a_key_or_of_the_table_around_it(place, line):
    assert line_of(TEXT, place) == line


@pytest.mark.parametrize(
    ("text", "replacement", "line"),
    [
        ("length = 0.2", "length = -0.2", 12),
        ("length = 0.2", "lenght = 0.2", 12),
        ("mass = 0.5\n[[chain.links.points]]", "[[chain.links.points]]", 11),
        ("angles = [0.0,\n  0.0]", "angles = [0.0, 1, 2]", 25),
        ("points = [0]", "points = 0", 21),
        ("[box]", "[walls]\nname = 'floor'\n[box]", 18),
    ],
)
def test_an_error_names_the_line(text, replacement, line):
    assert text in TEXT
    with pytest.raises(SceneError, match=rf"^ball\.toml: .* \(at line {line}\)$"):
        parse_scene(TEXT.replace(text, replacement, 1), "ball.toml")


@pytest.mark.parametrize(
    ("text", "replacement", "hint"),
    [
        (
            "[[chain.links]]",
            "[chain.links]",
            r"at line 11, .*; if there are several, each begins with \[\[chain\.links\]\]$",
        ),
        ("[0.0,\n  0.0]", "[5 deg,\n 0.0]", r'; an angle in degrees is text: "5 deg"$'),
        ("[box]", "[[walls]]\nangle = -1.5e1 deg # up\n[box]", r'at line 19.*; .* text: "-1\.5e1 deg"$'),
        ("[box]", "[[walls]]\nangle = 5°\n[box]", r'; an angle in degrees is text: "5 deg"$'),
        ("y_min = 0", "y_min = 0,5", r"; a number has a decimal point: 0\.5$"),
        ("[box]", "[contact]\nmodel = hertz # a law\n[box]", '; a text has quotes: "hertz"$'),
        ("[box]", "[outputs]\nloads = True\n[box]", "; write true$"),
    ],
)
def test_text_that_is_no_toml_is_refused_with_a_correct_entry(text, replacement, hint):
    with pytest.raises(SceneError, match=rf"^ball\.toml: not valid TOML: .*{hint}"):
        parse_scene(TEXT.replace(text, replacement), "ball.toml")


def test_an_error_names_number_and_line_of_a_boxs_point():
    box = TEXT.replace("length = 0.2", 'length = 0.2\nshape = "box"\nheight = 0.1')
    text = box.replace("x = 0.2", "x = 0.2\ny = 0.0\nradius = -1.0")
    with pytest.raises(
        SceneError, match=r"^ball\.toml: chain\.links\[2\]\.points\[2\]\.radius .* \(at line 21\)$"
    ):
        parse_scene(text, "ball.toml")


def test_two_points_of_a_link_have_different_names():
    text = TEXT.replace("x = 0.1", 'x = 0.1\nname = "heel"').replace("x = 0.2", 'x = 0.2\nname = "heel"')
    with pytest.raises(
        SceneError, match=r"^ball\.toml: chain\.links\[2\]\.points .* name 'heel' \(at line \d+\)$"
    ):
        parse_scene(text, "ball.toml")
    parse_scene(text.replace('"heel"', '"toe"', 1), "ball.toml")


def test_a_reversed_wall_is_asked_about():
    text = TEXT + "[[walls]]\nname = 'ramp'\npoint = [0.0, 0.5]\nnormal = [0.0, -1.0]\n"
    with pytest.raises(
        SceneError, match=r"in the wall ramp; must be outside; all points are inside: turn its normal\?$"
    ):
        parse_scene(text, "ball.toml")
    with pytest.raises(SceneError, match=r"in the wall x_min; must be outside$"):
        load_scene("four_link_box").with_values({"box.x_min": 2.5})
    assert parse_scene(text.replace("-1.0]", "1.0]"), "ball.toml").walls


@pytest.mark.parametrize(
    ("text", "replacement", "hint"),
    [
        ("length = 0.2", "length = 0.2\nlength = 0.3", "; length is given twice"),
        ("points = [0]", "points = [0]\nwall.y_min.restitution = 0.4", "; wall.y_min.restitution is given"),
    ],
)
def test_a_key_that_is_given_twice_is_named(text, replacement, hint):
    with pytest.raises(SceneError, match=re.escape(hint)):
        parse_scene(TEXT.replace(text, replacement), "file.toml")


def test_a_key_of_a_number_is_no_key_that_is_given_twice():
    with pytest.raises(SceneError) as refused:
        parse_scene(TEXT.replace("length = 0.2", "length = 0.2\nlength.x = 0.3"), "file.toml")
    assert "twice" not in str(refused.value)


@pytest.mark.parametrize(
    ("old_text", "replacement", "reason"),
    [
        ("points = [0]", "points = [7]", "contact.points holds 7, must hold"),
        (
            "length = 0.2",
            "length = 0.2\ninertia = 0.0\ncenter_of_mass = 0.0",
            "chain.links[2].inertia = 0.0 must be > 0",
        ),
    ],
)
def test_values_that_are_wrong_together_have_the_line_of_the_first(old_text, replacement, reason):
    text = TEXT.replace(old_text, replacement)
    with pytest.raises(SceneError, match=rf"{re.escape(reason)}.*\(at line \d+\)$") as refused:
        parse_scene(text, "file.toml")
    key = {"contact.points": "points", "chain.links[2].inertia": "inertia"}[reason.partition(" ")[0]]
    line = text.splitlines()[int(re.search(r"at line (\d+)", str(refused.value))[1]) - 1]
    assert line.strip().startswith(key)
