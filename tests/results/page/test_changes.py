"""Parameters are refused on the page, or by its kernel, where a scene refuses them."""

import json

import pytest

from chain_impact import SceneError, SimulationError, load_scene, simulate
from chain_impact.kernel import status
from chain_impact.results.page.description import description
from tests.derived_scenes import FINGER, edited, finger
from tests.results.page.conftest import packed_module
from tests.tiers import needs_browser

pytestmark = needs_browser


def begun(worker, scene, changes):
    """The sentence with which the page refuses changes of a scene; else the status of the run's start."""
    given = json.loads(json.dumps(description(scene, [])))
    return worker.evaluate(
        """async ([text, scene, changes]) => {
          const kernel = await Kernel.load(await compiled(text), scene);
          let values;
          try {
            values = new Changes(scene).with(changes);
          } catch (error) {
            if (!(error instanceof RangeError)) throw error;
            return error.message;
          }
          return runThrough(kernel.run(values, [0, 0.01], [])).status;
        }""",
        [packed_module(), given, changes],
    )


@pytest.mark.parametrize(
    ("model", "changes", "expected"),
    [
        ("four_link_box", {"box.x_max": 0.0}, "box.x_max = 0 must be > "),
        ("four_link_box", {"box.y_max": 0.02, "box.y_min": 0.01}, status.STARTS_INSIDE_WALL),
        ("four_link_box", {"contact.radius": 1.6}, "box.x_max = 3 must be > 3.2 [m]"),
        (
            "four_link_box",
            {"contact.model": "flores", "contact.restitution": 0.0},
            status.RESTITUTION_NOT_ALLOWED,
        ),
        ("four_link_box", {"contact.model": "tsuji", "contact.exponent": 1.2}, status.EXPONENT_NOT_ALLOWED),
        ("four_link_box", {"initial.x": 0.1, "initial.angle[1]": 3.0}, status.STARTS_INSIDE_WALL),
        ("four_link_box", {f"link[{k}].inertia": 0.0 for k in range(1, 5)}, status.MASS_MATRIX_SINGULAR),
        ("kneed_leg", {"link[3].joint_max": -3.0}, "link[3].joint_max = -3 must be > "),
        ("kneed_leg", {"initial.angle[3]": 3.0}, status.STARTS_INSIDE_WALL),
        ("sliding_rod", {"wall.y_min.static_friction": 0.01}, "static_friction = 0.01 must be >= 0.3"),
        ("sliding_rod", {"contact.model": "newton_impact"}, status.FRICTION_WITH_RIGID_WALLS),
        ("ramp", {"wall.ramp.y": 5.0}, status.STARTS_INSIDE_WALL),
    ],
)
def test_parameters_that_do_not_go_together_are_refused_as_by_a_scene(worker, model, changes, expected):
    """By the page, before it simulates, or else by the kernel, with a status."""
    scene = load_scene(model)
    if model == "kneed_leg":
        scene = scene.with_values({"link[3].joint_min": -2.9})
    with pytest.raises((SceneError, SimulationError)):
        simulate(scene.with_values(changes))
    found = begun(worker, scene, changes)
    assert expected in found if isinstance(expected, str) else expected == found


def test_a_value_is_not_set_back_where_it_does_not_go_with_another(worker):
    given = json.loads(json.dumps(description(load_scene("four_link_box"), [])))
    fault, values = worker.evaluate(
        """(scene) => {
          const changes = new Changes(scene);
          changes.set({ "box.x_min": -5, "box.x_max": -1 });
          try {
            changes.reset("box.x_min");
          } catch (error) {
            return [error.message, changes.values];
          }
        }""",
        given,
    )
    assert fault == "box.x_max = -1 must be > 0 [m], which is x_min + 2 contact.radius"
    assert values == {"box.x_min": -5, "box.x_max": -1}


@pytest.mark.parametrize(
    "changes",
    [
        {"link[1].length": 0.6, "link[2].mass": 0.2},
        {"contact.restitution": 0.45, "contact.exponent": 1.25},
        {"link[1].length": 0.6, "link[1].inertia": 0.02, "stop.restitution": 0.9, "contact.restitution": 0.4},
        {"link[1].length": 0.6, "link[1].center_of_mass": 0.25},  # as it would be in the scene
    ],
    ids=str,
)
def test_what_follows_from_others_is_shown_as_in_the_edited_file(worker, changes):
    """And follows them again once it is set back."""
    scene, expected = finger(), edited(FINGER, changes)
    given = json.loads(json.dumps(description(scene, [])))
    shown, text, back = worker.evaluate(
        """([scene, given]) => {
          const changes = new Changes(scene);
          changes.set(given);
          const names = scene.parameters.map(({ name }) => name);
          const all = () => Object.fromEntries(names.map((name) => [name, changes.valueOf(name)]));
          const [shown, text] = [all(), changes.texts().map(([name]) => name)];
          for (const name of Object.keys(given)) changes.reset(name);
          return [shown, text, all()];
        }""",
        [given, changes],
    )
    for name in ("center_of_mass", "inertia"):
        for link in (1, 2, 3):
            assert shown[f"link[{link}].{name}"] == expected.values[f"link[{link}].{name}"]
    for name in ("stop.restitution", "stop.exponent"):
        assert shown[name] == expected.values[name]
    assert set(text) == set(changes)
    assert back == {one["name"]: one["start"] for one in given["parameters"]}
