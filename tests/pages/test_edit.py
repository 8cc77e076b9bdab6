"""Scenes that the page reads itself, from opened files: the record is that of Python."""

# Tests: pages/scene_tables.py, pages/signals.py, pages/browser/scene/record.js
# Tests: pages/browser/base/range.js, pages/browser/scene/geometry.js, pages/browser/scene/signals.js

import re
import tomllib
from copy import deepcopy

import numpy as np
import pytest
from quickjs import JSException

from chain_impact import SceneError, load_scene, model_names
from chain_impact.scene.asked_inputs import with_inputs
from chain_impact.scene.files.models import scene_file_path
from chain_impact.scene.scene import parse_scene, scene_from_dict, scene_to_dict
from chain_impact.variables.owners import OWNER_KINDS
from chain_impact.variables.prepared import PreparedScene
from chain_impact.variables.structure import structure_of
from tests.helpers.campaigns import random_scenes
from tests.pages.in_pages import page_contents
from tests.pages.javascript import function_of
from tests.pages.scene_texts import BODIES, WRITTEN_SCENE

RECORD = function_of("edit", "recordInPage")


STRUCTURE = function_of("edit", "structure")


def record_in_page(script, scene, text="", contents=None):
    """Return the record that the page makes of a file's text, or of its contents."""
    return script.evaluate(RECORD, [page_contents(scene)["kit"], text, contents])


def assert_as_python(result, scene):
    """Assert that the record, the parameters and the outputs are equal to those of the FMU."""
    prepared_scene = PreparedScene(scene)
    record = prepared_scene.new_instance([])
    np.testing.assert_array_equal([int(word) for word in result["words"]], record.view(np.int64))
    columns = [
        [output.name, prepared_scene.word_of(output), output.unit] for output in prepared_scene.outputs
    ]
    assert result["columns"] == columns
    inputs = [variable for variable in prepared_scene.inputs if variable.record_path[0] != "given_channel"]
    assert result["still"] == [variable.name for variable in prepared_scene.inputs if variable not in inputs]
    expected = [
        [
            parameter.name,
            prepared_scene.table_row(parameter).set_word,
            float(prepared_scene.start_text(parameter)),
        ]
        for parameter in (*prepared_scene.parameters, *inputs)
    ]
    times = [[name, -1, scene.values[name]] for name in ("simulation.stop_time", "simulation.step_size")]
    assert [[name, word, float(start)] for name, word, start in result["parameters"]] == expected + times


@pytest.mark.full("more cases", but=8)
@pytest.mark.parametrize("model", model_names())
def test_the_file_of_every_model_makes_the_record_of_its_scene(script, model):
    """The record has the right counts of links, angles in degrees and of joints, normals and defaults."""
    text = scene_file_path(model).read_text(encoding="utf-8")
    scene = load_scene(model)
    assert_as_python(record_in_page(script, scene, text), scene)


@pytest.mark.full("many random scenes", but=10)
@pytest.mark.parametrize("seed", range(30))
def test_the_contents_of_a_random_scene_make_its_record(script, seed):
    scene = random_scenes.scene(seed)
    assert_as_python(record_in_page(script, scene, contents=scene_to_dict(scene)), scene)


@pytest.mark.full("more cases", but=10)
@pytest.mark.parametrize(
    "source",
    [*model_names(), *range(10), WRITTEN_SCENE, *BODIES.values()],
    ids=lambda source: str(source)[:20],
)
def test_the_structure_of_a_scene_is_that_of_python(script, source):
    if isinstance(source, int):
        scene = random_scenes.scene(source)
    else:
        scene = parse_scene(source, "scene.toml") if "\n" in source else load_scene(source)
    contents = scene_to_dict(scene.with_values({"outputs.sensitivities": []}))
    numbers, lists, owners = script.evaluate(STRUCTURE, [page_contents(scene)["kit"], contents])
    structure = structure_of(scene_from_dict(contents, "scene.toml"))
    assert numbers == structure.numbers
    assert lists == {name: [*members] for name, members in structure.lists.items()}
    for kind, row in OWNER_KINDS.items():
        owners_of_kind = structure.owners(kind)
        expected = [
            owner.values | {name: owner.conditions[name] for name in row.conditions}
            for owner in owners_of_kind
        ]
        assert owners[kind] == expected, kind


def test_a_file_with_everything_makes_the_record_of_its_scene(script):
    scene = parse_scene(WRITTEN_SCENE, "written.toml")
    assert_as_python(record_in_page(script, scene, WRITTEN_SCENE), scene)


@pytest.mark.parametrize("seed", range(0, 40, 4))
def test_signals_of_a_random_scene_are_in_its_record(script, seed):
    scene = random_scenes.scene(random_scenes.SIGNALLED + seed)
    assert_as_python(record_in_page(script, scene, contents=scene_to_dict(scene)), scene)


def test_the_page_has_the_tables_of_its_scene_and_no_others(script, tmp_path):
    (tmp_path / "ways.csv").write_text("time,base.vx,base.y\n0.0,0,0\n0.2,0.1,0.02\n0.5,0,0.01\n")
    scene = with_inputs(load_scene("shaken_pendulum").with_values({("signals",): {}}), tmp_path / "ways.csv")
    contents = page_contents(scene)["file"]
    assert contents["signals"]["inputs"]["file"] == "ways.csv"
    assert_as_python(record_in_page(script, scene, contents=contents), scene)
    for key, value in (("file", "roads.csv"), ("interpolation", "linear"), ("period", 0.5)):
        changed_file = deepcopy(contents)
        changed_file["signals"]["inputs"][key] = value
        with pytest.raises(JSException, match=r"signals.inputs.file = .* the page does not have this table"):
            record_in_page(script, scene, contents=changed_file)


SHAKE = {"input": ["base.y"], "form": "sine", "amplitude": 0.01, "frequency": 20.0}
STEPS = {"input": "base.ax", "form": "steps", "times": [0.0], "values": [1.0]}
STRANGE_SIGNALS = [
    (SHAKE | {"value": 1.0}, 'signals.own.value must be left out: form = "sine" has amplitude'),
    ({"input": ["base.x"], "form": "ramp", "final": 1.0}, "signals.own.duration is missing"),
    (SHAKE | {"input": ["joint[1].torque"]}, "is not an input of the scene; it has base.x, "),
    (SHAKE | {"input": ["base.vy"]}, "must be driven by one signal only: signals.shake drives base.y"),
    (STEPS | {"input": ["base.ax", "base.x"]}, "inputs of one unit: base.ax is in m/s², base.x in m"),
    (STEPS | {"input": ["base.ax", "base.ax"]}, "it is listed twice"),
    (STEPS | {"times": [0.0, 0.1]}, "must have as many as values, which has 1"),
    (STEPS | {"times": [0.1, 0.1], "values": [1.0, 2.0]}, "signals.own.times[2] = 0.1 must be > 0.1"),
]


@pytest.mark.parametrize(("signal", "sentence"), STRANGE_SIGNALS, ids=lambda case: str(case)[:40])
def test_a_signal_that_cannot_be_is_refused(script, signal, sentence):
    scene = load_scene("shaken_pendulum")
    contents = scene_to_dict(scene)
    contents["signals"]["own"] = signal
    with pytest.raises(JSException, match=re.escape(sentence)):
        record_in_page(script, scene, contents=contents)


@pytest.mark.parametrize("body", BODIES)
def test_a_file_with_bodies_makes_the_record_of_its_scene(script, body):
    scene = parse_scene(BODIES[body], "bodies.toml")
    assert_as_python(record_in_page(script, scene, BODIES[body]), scene)
    assert_as_python(record_in_page(script, scene, contents=scene_to_dict(scene)), scene)


@pytest.mark.parametrize("part", ["points", "contacts", "energies", "solver"])
def test_outputs_that_are_not_asked_for_are_not_there(script, part):
    scene = load_scene("sliding_rod").with_values({f"outputs.{part}": False, "outputs.impacts": 0})
    assert_as_python(record_in_page(script, scene, contents=scene_to_dict(scene)), scene)


def changed_file(path, value, text=WRITTEN_SCENE):
    """Return the contents of a file with a changed value at a path (None removes the value)."""
    contents = tomllib.loads(text)
    *parents, last = path
    table = contents
    for step in parents:
        table = table[step]
    if value is None:
        del table[last]
    else:
        table[last] = value
    return contents


REFUSED = [
    (("chain", "links", 0, "lenght"), 1.0, "chain.links[1].lenght is unknown"),
    (("contact", "toString"), 1.0, "contact.toString is unknown"),
    (("chain", "links", 1, "mass"), -1.0, "chain.links[2].mass = -1 must be a finite number > 0 [kg]"),
    (("chain", "links", 0, "count"), 1000, "chain.links has 1001 links, must have at most 1000"),
    (("chain", "links"), [], "chain.links has 0 entries, must have 1 to 1000"),
    (("chain", "links"), None, "chain.links is missing (links from base to tip)"),
    (("chain", "base"), "free", "inputs.base_motion must be false: "),
    (
        ("chain", "links", 0, "points"),
        [{"x": 0.1, "name": "toe"}, {"x": 0.2, "name": "toe"}],
        "chain.links[1].points has two points with the name 'toe'",
    ),
    (("contact", "model"), "hert", "contact.model = 'hert' must be one of"),
    (
        ("contact", "points"),
        [3, 4],
        "contact.points holds 4, must hold only 1 to 3 with a pinned base, each at most once; "
        "points of chain.links[].points always touch",
    ),
    (("contact", "wall", "slope"), {"friction": 0.1}, "contact.wall.slope is not a wall of the scene"),
    (("contact", "law_file"), "mine.py", "this page has no compiler"),
    (("inputs", "wall_motion"), ["slope"], "inputs.wall_motion[1] = 'slope' is not a wall of the scene"),
    (("inputs", "tip_force"), "yes", "inputs.tip_force = 'yes' must be true or false"),
    (("initial", "joint_angles"), [0.0], "initial.joint_angles has 1 value, must have 3"),
    (("initial", "angles"), [0.0] * 3, "initial has both angles and joint_angles"),
    (("initial", "joint_angles"), None, "initial.angles is missing"),
    (("initial", "velocity"), [1.0, 0.0], "initial.velocity = [1, 0] must be zero for a pinned base"),
    (("walls", 1, "name"), "ramp", "walls[2].name = 'ramp' must be none of"),
    (("walls", 0, "angle"), 0.0, "walls[1] has both angle and normal"),
    (("walls", 0, "point"), [0.0], "walls[1].point has 1 value, must have 2"),
    (("gravity",), "9.81", "gravity = '9.81' must be a list"),
    (("name",), "two words", "name = 'two words' must be letters, digits and _"),
]


REFUSAL = function_of("edit", "refusalInPage")


def refusal_of(script, contents, more_walls=()):
    """Return the sentence of the page on contents, to which walls are added after the check; "" for none."""
    return script.evaluate(REFUSAL, [page_contents(load_scene("rod_drop"))["kit"], contents, [*more_walls]])


@pytest.mark.parametrize(("path", "value", "sentence"), REFUSED, ids=[sentence for *_, sentence in REFUSED])
def test_wrong_contents_are_refused_with_key_and_allowed_values(script, path, value, sentence):
    contents = changed_file(path, value)
    with pytest.raises(SceneError):
        scene_from_dict(contents, "written.toml")
    assert sentence in refusal_of(script, contents)


ON_RAIL = [
    (("contact", "points"), [0], "must be left out with its wall: no point can reach it"),
    (("initial", "velocity"), [1.0, 0.0], "must be left out for a base on a slider; initial.slider_velocity"),
]


@pytest.mark.parametrize(("path", "value", "sentence"), ON_RAIL, ids=["reach", "velocity"])
def test_keys_that_no_slider_allows_are_refused_as_by_python(script, path, value, sentence):
    contents = changed_file(path, value, BODIES["rail"])
    with pytest.raises(SceneError, match=re.escape(sentence)):
        scene_from_dict(contents, "rail.toml")
    assert sentence in refusal_of(script, contents)


def test_no_wall_is_written_beyond_its_room_in_the_record(script):
    """The record has room for as many walls as there are pairs that can touch."""
    contents = changed_file(("contact", "points"), [0], BODIES["rail"])
    first_wall, *parallel = contents["walls"]
    contents["walls"] = [{**first_wall, "angle": -np.pi / 2}]
    assert refusal_of(script, contents) == ""
    more_walls = [{"name": wall["name"], "point": wall["point"], "angle": 0.0} for wall in parallel]
    assert refusal_of(script, contents, more_walls) == "walls: the record has room for 1"
