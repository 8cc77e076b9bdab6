"""Changed parameters of the page: derived values follow, a refused change has no effect."""

# Tests: pages/browser/scene/changes.js, pages/browser/explore/edited_scene.js
# Tests: pages/browser/base/paths.js, pages/browser/scene/changed_file.js, pages/browser/scene/page_scene.js

import numpy as np
import pytest

from chain_impact import SceneError, load_scene, model_names
from chain_impact.scene.scene import parse_scene, scene_from_dict, scene_to_dict
from chain_impact.variables.prepared import PreparedScene
from tests.helpers.campaigns import random_scenes
from tests.helpers.scenes.derived_scenes import FINGER, edited, finger
from tests.pages.in_pages import page_contents, without_advice
from tests.pages.javascript import function_of
from tests.pages.scene_texts import BODIES


def test_a_value_is_not_set_back_where_it_does_not_go_with_another(script):
    fault, values = script.evaluate(
        function_of("changes", "refusedReset"),
        page_contents(load_scene("four_link_box")),
    )
    assert fault == "box.x_max = -1 must be > 0 [m], which is box.x_min + 2*contact.radius"
    assert values == {"box.x_min": -5, "box.x_max": -1}


@pytest.mark.parametrize(
    ("model", "changes"),
    [
        ("four_link_box", {"box.x_max": -0.5}),
        ("four_link_box", {"contact.radius": 2.5}),
        ("kneed_leg", {"link[3].joint_max": -3.0}),
        ("sliding_rod", {"wall.y_min.static_friction": 0.015625}),
        ("sliding_rod", {"contact.friction": 0.25, "contact.static_friction": 0.125}),
        ("cart_pole", {"slider.min": 0.5}),
        ("cart_pole", {"slider.max": -3.5}),
    ],
)
def test_contradicting_values_are_refused_with_the_sentence_of_python(script, model, changes):
    run = function_of("changes", "refusal")
    scene = load_scene(model)
    if model == "kneed_leg":
        scene = scene.with_values({"link[3].joint_min": -2.9})
    fault = script.evaluate(run, [page_contents(scene), changes])
    with pytest.raises(SceneError) as refused:
        scene.with_values(changes)
    assert without_advice(fault) == without_advice(str(refused.value).partition(": ")[2])


@pytest.mark.parametrize(
    "changes",
    [
        {"link[1].length": 0.6, "link[2].mass": 0.2},
        {"contact.restitution": 0.45, "contact.exponent": 1.25},
        {"link[1].length": 0.6, "link[1].inertia": 0.02, "stop.restitution": 0.9, "contact.restitution": 0.4},
        {"link[1].length": 0.6, "link[1].center_of_mass": 0.25},  # the value of the scene
    ],
    ids=str,
)
def test_derived_values_are_shown_as_in_the_edited_file(script, changes):
    """After a reset, derived values have their start values."""
    expected = edited(FINGER, changes)
    values_in_use, text, back, starts = script.evaluate(
        function_of("changes", "derivedValues"),
        [page_contents(finger()), changes],
    )
    for name in ("center_of_mass", "inertia"):
        for link in (1, 2, 3):
            assert values_in_use[f"link[{link}].{name}"] == expected.values[f"link[{link}].{name}"]
    for name in ("stop.restitution", "stop.exponent"):
        assert values_in_use[name] == expected.values[name]
    assert set(text) == set(changes)
    assert back == starts


def opened(source):
    """Return a model, a scene with rare keys, or a random scene by its number."""
    if source in BODIES:
        return parse_scene(BODIES[source], "bodies.toml")
    return load_scene(source) if isinstance(source, str) else random_scenes.scene(source)


@pytest.mark.full("more cases", but=10)
@pytest.mark.parametrize("source", [*model_names(), "zeros", *range(0, 20, 2)])
def test_the_saved_file_is_the_scene(script, source):
    scene = opened(source)
    kit = page_contents(scene)["kit"]
    saved = (
        "([kit, contents]) => tomlText(contentsOf(new Changes(sceneOf({ file: contents, kit }))), kit.keys)"
    )
    text = script.evaluate(saved, [kit, scene_to_dict(scene)])
    saved_scene = parse_scene(text, "saved.toml")
    assert saved_scene.values == scene.values
    assert (
        PreparedScene(saved_scene).new_instance([]).tobytes()
        == PreparedScene(scene).new_instance([]).tobytes()
    )


KEPT_BY_EDIT = function_of("changes", "keptByEdit")


def edit_result(script, scene, changes, edit, *at):
    """Return data of an edited scene: contents, changes, old name → new name, new names and removals.

    The contents are without the changes; the removals are texts: signals and inputs that the edit removes.
    """
    return script.evaluate(KEPT_BY_EDIT, [page_contents(scene), changes, edit, [*at]])


def test_changes_stay_with_their_links_when_a_link_is_removed(script):
    masses = {f"link[{k}].mass": float(k) for k in (1, 2, 3, 4)}
    scene = load_scene("four_link_box").with_values(masses)
    changes = {"link[2].mass": 5, "link[3].mass": 5, "initial.angle[4]": 0.5, "contact.restitution": 0.25}
    contents, values, *_ = edit_result(script, scene, changes, "removeLink", 1)
    assert [link["mass"] for link in contents["chain"]["links"]] == [1, 3, 4]
    assert contents["initial"]["angles"][-1] == scene.initial.angles[3]
    assert contents["contact"]["restitution"] == scene.contact.restitution
    assert values == {"link[2].mass": 5, "initial.angle[3]": 0.5, "contact.restitution": 0.25}
    _, values, *_ = edit_result(script, scene, changes, "addLink")
    assert values == changes


JOINTED = {
    "inputs.joint_torques": True,
    "outputs.loads": True,
    ("signals",): {"push": {"input": "joint[3].torque", "form": "constant", "value": 2.0}},
}
NAMES = {
    "link[1].mass": "link[1].mass",
    "link[2].mass": None,
    "link[4].angle": "link[3].angle",
    "joint[3].torque": "joint[2].torque",
    "joint[4].force.x": "joint[3].force.x",
    "point[0].x": "point[0].x",
    "point[2].x": None,
    "point[3].x": "point[2].x",
    "point[5].x": None,
    "point[6].x": "point[4].x",
    "contact[6].y_min.force": "contact[4].y_min.force",
    "link[4].point[1].x": "link[3].point[1].x",
    "wall.ramp.angle": "wall.ramp.angle",
}
"""Name in a scene with a point on links 2 and 4 → name after the removal of link 2."""


def test_names_of_variables_and_inputs_of_signals_follow_their_link(script):
    contents = scene_to_dict(load_scene("four_link_box").with_values(JOINTED))
    for link in (1, 3):
        contents["chain"]["links"][link]["points"] = [{"x": 0.1, "y": 0.05}]
    contents["walls"] = [{"name": "ramp", "point": [0.0, -9.0], "angle": 0.0}]
    scene = scene_from_dict(contents, "points.toml")
    edited_contents, values, names, new_names, _ = edit_result(
        script, scene, {"joint[4].torque": 3}, "removeLink", 1
    )
    assert {name: names.get(name) for name in NAMES} == NAMES
    assert {name for name in names.values() if name} <= set(new_names)
    assert edited_contents["signals"]["push"]["input"] == ["joint[2].torque"]
    assert values == {"joint[3].torque": 3}
    second_contents, *_ = edit_result(script, scene, {}, "removeLink", 2)
    assert second_contents["signals"] == {}


def test_changes_stay_with_their_walls_when_a_wall_is_removed(script):
    scene = load_scene("four_link_box")
    walls = [{"name": f"wall{k}", "point": [-1.0 - k, -9.0], "angle": 0.0} for k in (1, 2)]
    scene = scene_from_dict({**scene_to_dict(scene), "walls": walls}, "walls.toml")
    changes = {"wall.wall1.x": 0.25, "wall.wall2.x": 0.25, "link[2].mass": 5}
    contents, values, *_ = edit_result(script, scene, changes, "removeWall", 0)
    assert [wall["point"][0] for wall in contents["walls"]] == [-3.0]
    assert values == {"wall.wall2.x": 0.25, "link[2].mass": 5}


WITH_SIGNALS = {
    "chain": {"base": "pinned"},
    "inputs": {"base_motion": True, "wall_motion": ["ramp", "x_max"]},
    "walls": [{"name": "ramp", "point": [0.0, -9.0], "angle": 0.0}],
    "signals": {
        "ride": {"input": "base.x", "form": "ramp", "final": 0.1, "duration": 1.0},
        "lift": {"input": "wall.ramp.displacement", "form": "ramp", "final": 0.1, "duration": 1.0},
        "close": {"input": "wall.x_max.displacement", "form": "ramp", "final": 0.1, "duration": 1.0},
    },
}


@pytest.mark.parametrize(
    ("removed", "edit", "at"),
    [
        ("lift", "removeWall", [0]),
        ("close", "setBox", ["x_max"]),
        ("ride", "setBase", ["free"]),
        ("ride", "setBase", ["slider"]),
    ],
)
def test_a_signal_goes_with_the_input_that_an_edit_removes(script, removed, edit, at):
    contents = scene_to_dict(load_scene("pinned_arm"))
    contents |= {key: contents[key] | WITH_SIGNALS[key] for key in ("chain", "inputs")}
    contents |= {key: WITH_SIGNALS[key] for key in ("walls", "signals")}
    scene = scene_from_dict(contents, "driven.toml")
    edited_contents, *_, signals = edit_result(script, scene, {}, edit, *at)
    assert signals == [f"signal {removed}"]
    assert edited_contents["signals"].keys() == WITH_SIGNALS["signals"].keys() - {removed}


def test_an_edit_tells_the_inputs_of_signals_that_it_removes(script):
    contents = scene_to_dict(load_scene("pinned_arm"))
    inputs = [f"joint[{k}].torque" for k in (1, 2)]
    contents["signals"] = {"push": {"input": inputs, "form": "ramp", "final": 0.1, "duration": 1.0}}
    edited_contents, *_, removed = edit_result(
        script, scene_from_dict(contents, "driven.toml"), {}, "removeLink", 1
    )
    assert removed == ["joint[2].torque of signal push"]
    assert edited_contents["signals"]["push"]["input"] == inputs[:1]


def test_changes_stay_with_points_whose_numbers_change(script):
    contents = scene_to_dict(load_scene("four_link_box"))
    contents["chain"]["links"][1]["points"] = [{"x": 0.1, "y": 0.3}, {"x": 0.2, "y": 0.3}]
    scene = scene_from_dict(contents, "points.toml")
    changes = {"link[2].point[1].y": -0.05, "link[2].point[2].y": -0.05, "link[2].mass": 5}
    edited_contents, values, *_ = edit_result(script, scene, changes, "setOfLink", 1, "height", 0.1)
    assert [point["y"] for point in edited_contents["chain"]["links"][1]["points"]] == [0.3, 0.3]
    assert values == {"link[2].point[5].y": -0.05, "link[2].point[6].y": -0.05, "link[2].mass": 5}
    edited_contents, values, *_ = edit_result(script, scene, changes, "removePoint", 1, 0)
    assert [point["y"] for point in edited_contents["chain"]["links"][1]["points"]] == [0.3]
    assert values == {"link[2].point[1].y": -0.05, "link[2].mass": 5}


def test_a_changed_number_is_in_the_saved_file_with_all_its_digits(script):
    scene, chance = load_scene("four_link_box"), np.random.default_rng(1)
    saved = function_of("changes", "savedText")
    for _ in range(20):
        value = float(10.0 ** chance.uniform(-9.0, 12.0))
        text = script.evaluate(saved, [page_contents(scene), {"link[1].mass": value}])
        assert parse_scene(text, "saved.toml").values["link[1].mass"] == value
