"""Parameters are refused on the page, or by its kernel, where a scene refuses them."""

import json

import pytest

from chain_impact import SceneError, SimulationError, load_scene, simulate
from chain_impact.results.explore.description import description
from tests.results.explore.conftest import needs_browser, packed_module

pytestmark = needs_browser


@pytest.mark.parametrize(
    ("model", "changes"),
    [
        ("four_link_box", {"box.x_max": 0.0}),
        ("four_link_box", {"box.y_max": 0.02, "box.y_min": 0.01}),
        ("four_link_box", {"contact.radius": 1.6}),
        ("four_link_box", {"contact.model": "flores", "contact.restitution": 0.0}),
        ("four_link_box", {"contact.model": "tsuji", "contact.exponent": 1.2}),
        ("four_link_box", {"initial.x": 0.1, "initial.angle[1]": 3.0}),
        ("four_link_box", {f"link[{k}].inertia": 0.0 for k in range(1, 5)}),
        ("kneed_leg", {"link[3].joint_max": -3.0}),
        ("kneed_leg", {"initial.angle[3]": 3.0}),
        ("sliding_rod", {"wall.y_min.static_friction": 0.01}),
        ("sliding_rod", {"contact.model": "newton_impact"}),
        ("ramp", {"wall.ramp.y": 5.0}),
    ],
)
def test_parameters_that_do_not_go_together_are_refused_as_by_a_scene(worker, model, changes):
    """By the page, before it simulates, or else by the kernel, with a status."""
    scene = load_scene(model)
    with pytest.raises((SceneError, SimulationError)):
        simulate(scene.with_values(changes))
    given = json.loads(json.dumps(description(scene, [])))
    fault, status = worker.evaluate(
        """async ([text, scene, changes]) => {
          const kernel = await Kernel.load(await compiled(text), scene);
          try {
            return ["", runThrough(kernel.run(new Changes(scene).with(changes), [0, 0.01], [])).status];
          } catch (error) {
            return [error.message, 0];
          }
        }""",
        [packed_module(), given, changes],
    )
    assert fault or status > 0
