"""Changed parameters of the page: derived values follow, a refused change leaves all as it is."""

# Tests: pages/browser/scene/changes.js, pages/browser/explore/edited_scene.js

import numpy as np
import pytest

from chain_impact import SceneError, load_scene, model_names
from chain_impact.scene.scene import parse_scene, scene_from_dict, scene_to_dict
from chain_impact.variables.prepared import PreparedScene
from tests.helpers.campaigns import random_scenes
from tests.helpers.scenes.derived_scenes import FINGER, edited, finger
from tests.pages.in_pages import page_contents, without_advice
from tests.pages.javascript import function_of


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
    """A derived value follows its sources again after a reset."""
    expected = edited(FINGER, changes)
    shown, text, back, starts = script.evaluate(
        function_of("changes", "derivedValues"),
        [page_contents(finger()), changes],
    )
    for name in ("center_of_mass", "inertia"):
        for link in (1, 2, 3):
            assert shown[f"link[{link}].{name}"] == expected.values[f"link[{link}].{name}"]
    for name in ("stop.restitution", "stop.exponent"):
        assert shown[name] == expected.values[name]
    assert set(text) == set(changes)
    assert back == starts


@pytest.mark.parametrize("source", [*model_names(), *range(0, 20, 2)])
def test_the_saved_file_is_the_scene(script, source):
    scene = load_scene(source) if isinstance(source, str) else random_scenes.scene(source)
    kit = page_contents(scene)["kit"]
    saved = (
        "([kit, contents]) => tomlText(contentsOf(new Changes(sceneOf({ file: contents, kit }))), kit.keys)"
    )
    text = script.evaluate(saved, [kit, scene_to_dict(scene)])
    again = parse_scene(text, "saved.toml")
    assert again.values == scene.values
    assert PreparedScene(again).new_instance([]).tobytes() == PreparedScene(scene).new_instance([]).tobytes()


KEPT = function_of("changes", "keptByEdit")


def kept(script, scene, changed, edit, *at):
    """Return the contents before the changes that an edit leaves, and these changes."""
    return script.evaluate(KEPT, [page_contents(scene), changed, edit, [*at]])


def test_no_change_of_a_removed_link_goes_to_another_link(script):
    masses = {f"link[{k}].mass": float(k) for k in (1, 2, 3, 4)}
    scene = load_scene("four_link_box").with_values(masses)
    changed = {"link[2].mass": 5, "link[3].mass": 5, "initial.angle[4]": 0.5, "contact.restitution": 0.25}
    contents, values = kept(script, scene, changed, "removeLink", 1)
    assert [link["mass"] for link in contents["chain"]["links"]] == [1, 5, 4]
    assert contents["initial"]["angles"][-1] == 0.5
    assert contents["contact"]["restitution"] == scene.contact.restitution
    assert values == {"contact.restitution": 0.25}
    _, values = kept(script, scene, changed, "addLink")
    assert values == changed


def test_no_change_of_a_removed_wall_goes_to_another_wall(script):
    scene = load_scene("four_link_box")
    walls = [{"name": f"wall{k}", "point": [-1.0 - k, -9.0], "angle": 0.0} for k in (1, 2)]
    scene = scene_from_dict({**scene_to_dict(scene), "walls": walls}, "walls.toml")
    changed = {"wall.wall1.x": 0.25, "wall.wall2.x": 0.25, "link[2].mass": 5}
    contents, values = kept(script, scene, changed, "removeWall", 0)
    assert [wall["point"][0] for wall in contents["walls"]] == [0.25]
    assert values == {"link[2].mass": 5}


def test_no_change_of_a_point_goes_to_a_corner_of_a_new_box(script):
    scene = scene_to_dict(load_scene("four_link_box"))
    scene["chain"]["links"][1]["points"] = [{"x": 0.1, "y": 0.3}]
    changed = {"link[2].point[1].y": -0.05, "link[2].mass": 5}
    contents, values = kept(
        script, scene_from_dict(scene, "points.toml"), changed, "setOfLink", 1, "height", 0.1
    )
    assert [point["y"] for point in contents["chain"]["links"][1]["points"]] == [-0.05]
    assert values == {"link[2].mass": 5}


def test_a_changed_number_is_in_the_saved_file_with_all_its_digits(script):
    scene, chance = load_scene("four_link_box"), np.random.default_rng(1)
    saved = function_of("changes", "savedText")
    for _ in range(20):
        value = float(10.0 ** chance.uniform(-9.0, 12.0))
        text = script.evaluate(saved, [page_contents(scene), {"link[1].mass": value}])
        assert parse_scene(text, "saved.toml").values["link[1].mass"] == value
