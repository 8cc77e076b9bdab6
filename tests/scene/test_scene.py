"""Scene files: their meaning, numbers of links, values set by name, and unreadable files."""

# Tests: scene/plain_data.py, scene/value_paths.py

import copy
from dataclasses import is_dataclass
from fractions import Fraction

import numpy as np
import pytest

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.record.constants import SOLVER_METHODS
from chain_impact.scene.files.models import model_names, models_folder
from chain_impact.scene.keys.chain_tables import MAX_LINKS, Link
from chain_impact.scene.scene import (
    SceneError,
    fixed_hint,
    load_scene,
    parse_scene,
    scene_from_dict,
    scene_keys,
    scene_to_dict,
    with_values,
)
from chain_impact.variables.prepared import PreparedScene
from tests.helpers.tools.refusal import refusal

SOURCE = "somewhere/scene.toml"
MINIMAL = "name = 'Rod'\nchain.links = [{length = 2.0, mass = 3.0}]\ninitial.angles = [0.5]"


def test_minimal_scene_gets_the_documented_defaults():
    scene = parse_scene(MINIMAL, SOURCE)
    link = scene.chain.links[0]
    assert (link.center_of_mass, link.inertia, link.joint_damping) == (1.0, 1.0, 0.0)  # uniform: m L²/12
    assert (scene.description, scene.gravity, scene.chain.base) == ("", (0.0, -9.81), "free")
    assert [scene.box.x_min, scene.box.x_max, scene.box.y_min, scene.box.y_max] == [None] * 4
    contact = scene.contact
    assert (contact.model, contact.stiffness, contact.exponent) == ("zhang_sharf", 1e8, 1.5)
    assert (contact.restitution, contact.radius, contact.minimum_impact_speed) == (0.7, 0.0, 1e-3)
    assert contact.points == (0, 1)
    assert load_scene("pinned_arm").contact.points == (1, 2), "a pinned base cannot move"
    assert (scene.inputs.joint_torques, scene.inputs.tip_force) == (False, False)
    assert (scene.initial.position, scene.initial.velocity) == ((0.0, 0.0), (0.0, 0.0))
    assert scene.initial.angular_velocities == (0.0,)
    assert (scene.solver.method, scene.solver.tolerance) == ("auto", 1e-8)
    assert (scene.simulation.stop_time, scene.simulation.step_size) == (1.0, 1e-3)


def test_numbers_and_arrays_of_other_libraries_are_taken():
    numbers = {("chain", "links", 0, "mass"): 2, ("gravity",): [np.float32(0.5), Fraction(-39, 4)]}
    scene = with_values(load_scene("rod_drop"), numbers)
    values = (scene.chain.links[0].mass, *scene.gravity)
    assert values == (2.0, 0.5, -9.75)
    assert set(map(type, values)) == {float}
    box, angles = load_scene("four_link_box"), np.linspace(0.1, 0.4, 4)
    result = box.with_values({"initial.angles": angles, "contact.restitution": np.float64(0.5)})
    assert result == box.with_values({"initial.angles": angles.tolist(), "contact.restitution": 0.5})
    assert {with_values(box, {("contact", "points"): [4, 2, 0, 1, 3]})} == {box}


def test_models_are_found_by_name_folder_and_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rod_drop").mkdir()  # an output folder with a model's name does not hide the model
    assert {"controlled_arm", "four_link_box", "pinned_arm", "ramp", "rod_drop"} < set(model_names())
    assert model_names() == sorted(model_names())
    for name in model_names():
        folder = models_folder() / name
        assert load_scene(name) == load_scene(folder) == load_scene(folder / "scene.toml")
        # double_pendulum_wall is DoublePendulumWall, and ur5e is UR5e
        assert load_scene(name).name.lower() == name.replace("_", "")
        assert load_scene(name).name[0].isupper()


def test_four_link_box_is_the_scene_of_the_design():
    scene = load_scene("four_link_box")
    rod = Link(length=0.5, mass=1.0, center_of_mass=0.25, inertia=0.5**2 / 12, joint_damping=0.0)
    assert scene.chain.links == (rod,) * 4
    # energy at the start, with the plane as complex numbers
    velocity, omega = complex(*scene.initial.velocity), np.array(scene.initial.angular_velocities)
    links = 0.5 * np.exp(1j * np.array(scene.initial.angles))
    heights = scene.initial.position[1] + np.imag(np.cumsum(links) - links / 2)
    speeds = np.abs(velocity + np.cumsum(1j * omega * links) - 1j * omega * links / 2)
    energy = np.sum(speeds**2 / 2 + rod.inertia * omega**2 / 2 + 9.81 * heights)
    assert energy == pytest.approx(61.6630096858, abs=1e-10)


def test_every_key_says_its_unit_meaning_and_choices():
    for key, entry in scene_keys():
        if is_dataclass(entry.type):
            assert entry.type.__doc__, key
            continue
        assert entry.metadata["description"], key
        numbers = entry.type in (float, float | None) or "float" in str(entry.type)
        assert bool(entry.metadata["unit"]) == numbers, key
    choices = {key: entry.metadata.get("choices") for key, entry in scene_keys()}
    assert choices["contact.model"] == tuple(CONTACT_LAWS)
    assert choices["solver.method"] == SOLVER_METHODS


def scene_with_equal_links(*counts):
    links = [{"length": 0.1 * (i + 1), "mass": 1.0, "count": count} for i, count in enumerate(counts)]
    zeros = [0.0] * sum(counts)
    changes = {
        ("initial", "angles"): zeros,
        ("initial", "angular_velocities"): zeros,
        ("chain", "links"): links,
    }
    return with_values(load_scene("rod_drop"), {**changes, ("contact", "points"): None})


def test_a_count_stands_for_so_many_equal_links():
    scene = scene_with_equal_links(2, 1, 3)
    assert [link.length for link in scene.chain.links] == pytest.approx([0.1, 0.1, 0.2, 0.3, 0.3, 0.3])
    assert scene.contact.points == tuple(range(7))
    assert all("count" not in link for link in scene_to_dict(scene)["chain"]["links"])
    assert scene_from_dict(scene_to_dict(scene), "f") == scene
    heavier = with_values(scene, {("chain", "links", 4, "mass"): 2.0})
    assert [link.mass for link in heavier.chain.links] == [1.0, 1.0, 1.0, 1.0, 2.0, 1.0]


def test_an_error_names_the_entry_of_the_file_where_entries_are_not_links():
    text = MINIMAL.replace(
        "[{length = 2.0, mass = 3.0}]", "[{length = 2.0, mass = 3.0, count = 3}, {mass = 1.0}]"
    )
    message = refusal(parse_scene, text, "f")
    assert message.startswith(
        "f: chain.links[2].length is missing (at line 2); 1 more: initial.angles has 1 "
    )
    text = text.replace("{mass = 1.0}", "{mass = 1.0, length = 1.0, joint_min = 0.2, joint_max = 0.1}")
    text = text.replace("[0.5]", "[0.5, 0.5, 0.5, 0.5]")
    message = refusal(parse_scene, text, "f")
    assert message.startswith("f: chain.links[2].joint_max = 0.1 must be > 0.2")


def test_a_chain_has_at_most_a_thousand_links():
    def chain(count):
        links, zeros = [{"length": 1e-3, "mass": 1.0}] * count, [0.0] * count
        angles = {("initial", "angles"): zeros, ("initial", "angular_velocities"): zeros}
        return with_values(load_scene("rod_drop"), {("chain", "links"): links, **angles})

    assert len(chain(MAX_LINKS).chain.links) == MAX_LINKS
    assert refusal(chain, MAX_LINKS + 1) == "RodDrop: chain.links has 1001 entries, must have 1 to 1000"
    message = refusal(scene_with_equal_links, 400, 600, 1)
    assert message == "RodDrop: chain.links has 1001 links, must have at most 1000"


def test_with_values_changes_only_what_it_is_told():
    scene = load_scene("four_link_box")
    data = scene_to_dict(scene)
    changed_scene = with_values(scene, {("contact", "stiffness"): 1e9, ("chain", "links", 0, "mass"): 2})
    expected = copy.deepcopy(data)
    expected["contact"]["stiffness"], expected["chain"]["links"][0]["mass"] = 1e9, 2.0
    assert scene_to_dict(changed_scene) == expected
    assert scene_to_dict(scene) == data
    opened = with_values(changed_scene, {("box", "x_max"): None, ("chain", "links", 0, "inertia"): None})
    assert opened.box.x_max is None
    assert opened.chain.links[0].inertia == pytest.approx(2.0 * 0.25 / 12)


# --- by name ---------------------------------------------------------------------------------------------


def test_a_value_is_changed_by_the_name_of_its_parameter_or_by_its_key():
    scene = load_scene("four_link_box")
    changes = {
        "link[1].mass": (("chain", "links", 0, "mass"), 2),
        "gravity.y": (("gravity", 1), -1.62),
        "initial.vx": (("initial", "velocity", 0), 3.0),
        "initial.angle[4]": (("initial", "angles", 3), 0.25),
        "contact.points": (("contact", "points"), [3, 4]),
        "simulation.stop_time": (("simulation", "stop_time"), 0.5),
        "inputs.tip_force": (("inputs", "tip_force"), True),
        "box.x_min": (("box", "x_min"), None),
    }
    changed_scene = scene.with_values({name: value for name, (_, value) in changes.items()})
    assert (
        changed_scene
        == scene.with_values(dict(changes.values()))
        == with_values(scene, dict(changes.values()))
    )
    assert changed_scene != scene


def test_a_law_and_a_method_have_a_name_and_a_number():
    scene = load_scene("rod_drop")
    by_name = scene.with_values({"contact.model": "flores", "solver.method": "implicit"})
    number = CONTACT_LAWS["flores"].number
    assert scene.with_values({"contact.model": number, "solver.method": np.int64(3)}) == by_name
    for value in (0, -1, len(CONTACT_LAWS) + 1, True, 1.0):
        message = refusal(scene.with_values, {"contact.model": value})
        assert message.startswith(f"RodDrop: contact.model = {str(value).lower()} must be one of ")


def test_every_value_has_a_name_by_which_it_can_be_set():
    for scene in map(load_scene, model_names()):
        assert scene.with_values(scene.values).values == scene.values
        assert scene.values["link[1].mass"] == scene.chain.links[0].mass
        assert {
            v.name for v in PreparedScene(scene).variables if v.causality == "parameter"
        } <= scene.values.keys()


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("contact.restitutoin", "the nearest is contact.restitution"),
        ("link[5].mass", "links count from 1 to 4"),
        ("link[0].mass", "links count from 1 to 4"),
        ("joint[1].torque", "it is an input: give it over time by a signal of the scene, by --inputs FILE,"),
        ("chain.links[1].mas", "the nearest is "),
        ("initial.angle", "the nearest is initial.angle[1]"),
        ("mass", "the nearest is link[1].mass"),
        ("?", "`chain-impact info SCENE` lists the names"),
    ],
)
def test_an_unknown_name_is_refused_and_the_nearest_is_named(name, hint):
    message = refusal(load_scene("four_link_box").with_values, {name: 1.0})
    assert message.startswith(f"FourLinkBox: {name} is not a parameter; {hint}")


def test_a_part_of_a_models_name_is_told_the_model():
    assert refusal(load_scene, "rod").endswith("or a model; the nearest is rod_drop")


def test_an_unknown_name_is_a_key_that_is_missing():
    with pytest.raises(KeyError) as caught:
        load_scene("rod_drop").with_values({"contact.x": 1.0})
    assert str(caught.value) == "RodDrop: contact.x is not a parameter; the nearest is contact"


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("chain.links = [{length = 2.0, mass = -3.0}]", "chain.links[1].mass = -3.0 must"),
        ("chain.links = [{length = 2.0, massa = 3.0}]", "chain.links[1].massa is unknown"),
        ("gravity = [0.0, inf]", "gravity[2] = inf must be a finite number [m/s²]"),
        ("walls = [{name = 'a', point = [0, '1']}]", "walls[1].point[2] = '1' must be"),
        ("walls = [{point = [0, 1]}]", "walls[1].name is missing"),
        ("walls = [{name = 'a\"', x = 1}]", "walls[1].x is unknown"),
        ("contact.restitution = 2", "contact.restitution = 2 must be a finite number"),
    ],
)
def test_an_error_in_a_file_names_the_path_of_the_key(line, message):
    key = line.partition(" = ")[0]
    text = "\n".join(
        [line, *(other_line for other_line in MINIMAL.splitlines() if not other_line.startswith(f"{key} = "))]
    )
    assert refusal(parse_scene, text, SOURCE).startswith(f"{SOURCE}: {message}")


# --- files -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"name = ", "(at end of document)"),
        (b"name = 'a'\ngravity = [0,, 1]", "(at line 2, column 14)"),
        (b"\xff\xfe", "it is in UTF-16, or no text; must be text in UTF-8"),
        (b"a = " + b"[" * 100_000, "recursion"),
        (b"a = " + b"9" * 10_000, "digits"),
        (b"name = 0x" + b"f" * 10_000, "name = <int> must be letters, digits and _"),
        (b"", "name is missing"),
        (b"name = 'A'", "chain.links is missing"),
    ],
)
def test_a_bad_file_is_refused_by_name_and_reason(tmp_path, content, reason):
    file = tmp_path / "bad.toml"
    file.write_bytes(content)
    message = refusal(load_scene, file)
    assert message.startswith(f"{file}: ")
    assert reason in message


def test_a_message_is_one_line_even_for_a_file_name_of_two():
    message = refusal(parse_scene, "", "two\nlines.toml")
    assert message.startswith("two lines.toml: name is missing (model name); 1 more: chain.links is missing")


def test_only_names_that_windows_reserves_are_refused():
    def named(name):
        return parse_scene(MINIMAL.replace(MINIMAL.splitlines()[0], f'name = "{name}"'), SOURCE)

    for name in ("con", "NUL", "Aux", "prn", "com1", "LPT9"):
        message = refusal(named, name)
        assert message.startswith(f"{SOURCE}: name = '{name}' must be letters, digits and _, ")
        assert "no name that Windows reserves: con, prn, aux, nul, com1 to com9, lpt1 to lpt9" in message
    for name in ("con1", "console", "_nul", "com0", "com10", "lpt"):
        assert named(name).name == name


@pytest.mark.parametrize("name", ["no_such_model", "missing.toml", "empty", "a\0b", "x" * 5000, ""])
def test_files_that_are_no_scene_are_refused(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty").mkdir()
    with pytest.raises(SceneError, match=r"or a model; .* --list models") as caught:
        load_scene(name)
    assert str(caught.value).startswith(f"{name}: cannot be read (")


def test_only_a_value_of_the_scene_has_a_hint_how_to_change_it(tmp_path):
    (tmp_path / "push.csv").write_text("time,tip.force.y\n0,0\n0.1,1\n0.2,0\n")
    signal = "[signals.push]\ninput = 'tip.force.y'\nform = 'table'\nfile = 'push.csv'\nperiod = 0.2\n"
    (tmp_path / "rod.toml").write_text(f"{MINIMAL}\ninputs.tip_force = true\n{signal}")
    scene = load_scene(tmp_path / "rod.toml")
    for name in ("signal.push.period", "contact.points", "chain.base"):
        assert fixed_hint(scene, name)
    for name in ("signal.push.shape", "signal.pull.period", "link[1].height", "box.x_min"):
        assert fixed_hint(scene, name) is None


MISTAKEN = """
name = "Bad"
gravity = [0.0, -9.81]
[chain]
base = "pinned"
link = 3
[[chain.links]]
length = -1
mass = 1.0
masss = 2
[contact]
model = "zhang_sharf"
stiffness = -1.0
[initial]
angles = [0.1]
"""


def test_a_message_has_all_wrong_keys_and_values_with_their_lines():
    assert refusal(parse_scene, MISTAKEN, "bad.toml") == (
        "bad.toml: chain.link is unknown; the nearest key is chain.links (at line 6); 3 more: "
        "chain.links[1].masss is unknown; the nearest key is chain.links[].mass (at line 10); "
        "chain.links[1].length = -1 must be a finite number > 0 [m] (at line 8); "
        "contact.stiffness = -1.0 must be a finite number > 0 [N/m^exponent] (at line 13)"
    )


def test_a_missing_key_hides_no_fault_and_a_misspelled_key_is_told_once():
    assert refusal(parse_scene, "[[chain.links]]\nlenght = 'a'\nmass = 1.0\n", "bad.toml") == (
        "bad.toml: name is missing (model name); 3 more: "
        "chain.links[1].lenght is unknown; the nearest key is chain.links[].length (at line 2); "
        "chain.links[1].length = 'a' must be a finite number > 0 [m] (at line 1); "
        "initial.angles is missing (angle of each link, absolute, from +x)"
    )
