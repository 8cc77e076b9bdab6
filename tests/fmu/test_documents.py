"""The documentation in an FMU, without a build: its page, its drawing, its terminals."""

# Tests: pictures/chain_at_start.py

from collections import Counter
from html import escape
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import matplotlib as mpl
import pytest
from lxml import etree

from chain_impact import load_scene, model_names
from chain_impact.fmu.documents import TERMINALS_FILE, documentation_page, documents, terminals_and_icons
from chain_impact.pictures.chain_at_start import icon
from chain_impact.variables.prepared import PreparedScene

SCHEMA = Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd"
WITH_INPUTS = {"inputs.joint_torques": True, "inputs.joint_targets": True, "inputs.base_motion": True}
WITH_INPUTS |= {"inputs.tip_force": True, "inputs.wall_motion": True, "outputs.loads": True}


SVG = "{http://www.w3.org/2000/svg}"


def drawing_of(scene):
    text = documentation_page(PreparedScene(scene), 3)
    return ElementTree.fromstring(text[text.index("<svg") : text.index("</svg>") + len("</svg>")])


def labels(picture):
    return [element.text for element in picture.iter(f"{SVG}text")]


def points(picture):
    """Return the coordinates of the largest group of marks: the chain's marks, in units of the drawing."""
    marks = [
        [(float(mark.get("x")), float(mark.get("y"))) for mark in group.iter(f"{SVG}use")]
        for group in picture.iter(f"{SVG}g")
    ]
    return max((group for group in marks if group), key=len)


@pytest.mark.full("more cases", but=8)
@pytest.mark.parametrize("model", model_names())
def test_the_drawing_names_points_walls_and_the_first_angle(model):
    scene, picture = load_scene(model), drawing_of(load_scene(model))
    texts = labels(picture)
    assert {"x", "y", "+", "point 0", str(len(scene.chain.links))} | set(scene.half_planes) <= set(texts)
    assert texts.count("n") == len(scene.half_planes)
    assert sum(label.startswith("θ1 = ") for label in texts) == 1


def test_an_arm_is_drawn_as_it_hangs():
    scene = load_scene("pinned_arm").with_values({"initial.angles": ["-90 deg", "180 deg"]})
    picture = drawing_of(scene)
    (x0, y0), (x1, y1), (x2, y2) = points(picture)
    assert x0 == pytest.approx(x1)
    assert y0 < y1 == pytest.approx(y2)
    assert x2 < x1
    assert {"θ1 = −90°", "θ2 = 180°"} <= set(labels(picture))


def test_settings_of_matplotlib_change_no_picture_of_a_scene():
    prepared_scene = PreparedScene(load_scene("ramp"))
    pictures = documentation_page(prepared_scene, 2), icon(prepared_scene.scene)
    with mpl.rc_context({"font.size": 20.0, "savefig.facecolor": "black", "lines.linewidth": 9.0}):
        assert (
            documentation_page(PreparedScene(load_scene("ramp")), 2),
            icon(prepared_scene.scene),
        ) == pictures


def test_the_documentation_page_has_the_author_and_a_row_for_each_kind():
    values = {"author": "Jane <Doe>", "version": "1.2", "copyright": "2026 Jane Doe", "license": "MIT"}
    prepared_scene = PreparedScene(load_scene("four_link_box").with_values(values))
    text = documentation_page(prepared_scene, 2)
    table = text[text.index("Variables by kind") : text.index("<details>")]
    assert "Author: Jane &lt;Doe&gt;; Version: 1.2; Copyright: 2026 Jane Doe; License: MIT" in text
    assert "Author" not in documentation_page(PreparedScene(load_scene("four_link_box")), 2)
    for kind, count in Counter(variable.kind.pattern for variable in prepared_scene.variables).items():
        assert table.count(f"<tr><td>{escape(kind)}</td><td>{count}</td>") == 1


@pytest.mark.parametrize(("model", "changes"), [("four_link_box", {}), ("pinned_arm", WITH_INPUTS)])
def test_terminals_are_valid_and_group_variables_of_owners(model, changes):
    variables = PreparedScene(load_scene(model).with_values(changes)).variables
    content = terminals_and_icons(variables)
    schema = etree.XMLSchema(etree.parse(str(SCHEMA)))
    schema.assertValid(etree.fromstring(content))
    causality = {variable.name: variable.causality for variable in variables}
    members_of_terminals, member_names = {}, []

    def read(parent, path):
        names = [terminal.get("name") for terminal in parent.findall("Terminal")]
        assert len(names) == len(set(names))
        for terminal in parent.findall("Terminal"):
            name = ".".join([*path, terminal.get("name")])
            for member in terminal.findall("TerminalMemberVariable"):
                member_names.append(member.get("variableName"))
                assert member_names[-1] == f"{name}.{member.get('memberName')}"
                members_of_terminals.setdefault(name, set()).add(member.get("memberName"))
            read(terminal, [*path, terminal.get("name")])

    read(ElementTree.fromstring(content).find("Terminals"), [])
    assert len(member_names) == len(set(member_names))
    assert {causality[name] for name in member_names} <= {"input", "output"}
    assert {"angle", "angular_velocity"} <= members_of_terminals["joint[2]"]
    assert members_of_terminals["point[2]"] == {"x", "y", "vx", "vy", "ax", "ay"}
    if changes:
        assert {"torque", "target_angle", "target_velocity", "moment", "force.x"} <= members_of_terminals[
            "joint[2]"
        ]
        assert {"x", "vx", "ax"} <= members_of_terminals["base"]
        assert members_of_terminals["tip"] == {"force.x", "force.y"}
        assert {"displacement", "belt_speed", "load.x"} <= members_of_terminals["wall.x_max"]


def test_only_fmi3_has_terminals():
    prepared_scene = PreparedScene(load_scene("rod_drop"))
    assert TERMINALS_FILE in documents(prepared_scene, 3)
    assert TERMINALS_FILE not in documents(prepared_scene, 2)
