"""A start that the solver refuses: the sentence, its place in the drawing, and the names in refusals."""

# Tests: pages/browser/explore/refused_start.js, pages/browser/explore/parameters/main_parameters.js
# Tests: pages/browser/explore/stopped_run.js

import numpy as np
import pytest

from chain_impact import SceneError, load_scene, simulate
from tests.pages.in_pages import DESK, PHONE, enter, go_to, impacts_of, page_contents, until, until_text
from tests.pages.javascript import function_of
from tests.tiers import needs_browser

MIDDLE = """(element) => { const box = element.getBoundingClientRect();
  return [box.x + box.width / 2, box.y + box.height / 2]; }"""


DEPTHS = function_of("refused_start", "depths")
"""Each wall that a point may touch, and the distance [m] of the point beyond it at the start."""
START_TEXT = function_of("refused_start", "startTextOf")


def starts_of(model):
    """Return the coordinates [x, y] of base and link ends of a model at the start."""
    run = simulate(load_scene(model).with_values({"simulation.stop_time": 1e-3}))
    return np.array(
        [[run[f"point[{k}].{axis}"][0] for axis in "xy"] for k in range(len(run.scene.chain.links) + 1)]
    )


@needs_browser
@pytest.mark.parametrize("size", [DESK, PHONE], ids=["desk", "phone"])
def test_the_wall_is_dashed_and_the_point_beyond_it_has_a_ring(show, size):
    page = show(viewport=size)
    go_to(page, 0.3)
    wall = starts_of("four_link_box")[4, 0] - 0.012
    page.evaluate("x => chainImpact.show({'box.x_max': x})", wall)
    message = "The simulation cannot start: point 4 starts 12\u202fmm beyond the right wall."
    until_text(page, message, "status")
    refused = page.locator("#scene .refused")
    assert refused.count() == 2
    line, ring = (refused.nth(k).evaluate(MIDDLE) for k in (0, 1))
    tip = page.locator("#scene .pose").evaluate("element => element.points[4].x - element.points[3].x")
    assert tip > 0.0
    scale = tip / (starts_of("four_link_box")[4, 0] - starts_of("four_link_box")[3, 0])
    assert ring[0] - line[0] == pytest.approx(0.012 * scale, abs=1.0)
    assert refused.first.evaluate("element => getComputedStyle(element).strokeDasharray") != "none"
    pale = "element => Number(getComputedStyle(element.parentNode).opacity)"
    assert page.locator("#scene .pose").evaluate(pale) == 1.0
    assert page.locator("#scene .link").first.evaluate(pale) == 0.45
    assert page.inner_text("#time") == "0.00000 s"
    assert page.locator("#csv").evaluate("element => element.disabled")
    page.evaluate("chainImpact.show({'initial.y': -30})")
    until(page, "document.getElementById('status').textContent.includes('30')")
    pose, view = page.locator("#scene .pose").bounding_box(), page.locator("#view").bounding_box()
    for at, length in (("x", "width"), ("y", "height")):
        assert view[at] < pose[at] < pose[at] + pose[length] < view[at] + view[length]
    for label in ("Position of the right wall", "Initial height"):
        page.get_by_role("button", name=f"Undo the change of {label}", exact=True).click()
    until(page, "document.querySelectorAll('#scene .refused').length === 0")
    assert page.inner_text("#time") == "0.30000 s"
    assert not page.locator("#csv").evaluate("element => element.disabled")


@needs_browser
def test_refusals_have_the_words_of_controls_and_take_a_decimal_comma(show):
    page = show()
    field = enter(page, "contact.restitution", "2")
    refusal = page.locator(".main-parameter .refusal").filter(has_text="Not taken")
    assert refusal.inner_text().startswith("Not taken: Restitution = 2 must be a finite number")
    enter(page, "contact.restitution", "0,5")
    until_text(page, impacts_of({"contact.restitution": 0.5}))
    field.blur()
    assert (field.input_value(), refusal.count()) == ("0.5", 0)
    enter(page, "simulation.stop_time", "1,500")
    assert "; the decimal sign is a point. It must be" in refusal.inner_text()
    page.evaluate("chainImpact.show({'solver.work_limit': 2000})")
    until_text(page, "Raise Work limit of solver, loosen Solver tolerance, or lower Stiffness", "status")
    page.get_by_role("button", name="Undo the change of Work limit of solver", exact=True).click()
    until(page, "document.getElementById('status').hidden")
    page.evaluate("chainImpact.show({'contact.stiffness': 1e32})")
    until_text(page, "With Stiffness = 1e32\u202fN/m¹·⁵, the simulation stopped at t = 0.49", "status")
    until_text(page, "Loosen Solver tolerance, or lower Stiffness.", "status")
    page.get_by_role("button", name="Undo the change of Stiffness", exact=True).wait_for()


ADVICE = """([name, tolerance, moved, values]) => {
  const parameters = new Map(Object.entries({ "solver.tolerance": tolerance, ...values }));
  const status = Number(Object.keys(SHARED.kernel.STATUS_TEXT).find((key) =>
    SHARED.kernel.STATUS_TEXT[key].startsWith(name)));
  const scene = { partsInWords: ["link 1"], moved };
  return faultWords({ status, part: 1 }, { scene, parameters, valueOf: (name) => parameters.get(name) });
}"""


def test_advice_on_a_fault_names_only_what_the_scene_has(script):
    walls = {"contact.minimum_impact_speed": 1e-3, "contact.restitution": 0.5, "contact.stiffness": 1e6}
    stops = {"stop.minimum_impact_speed": 1e-3, "stop.restitution": 0.5, "stop.stiffness": 1e6}
    of_walls = "raise contact.minimum_impact_speed or lower contact.restitution"
    of_stops = "raise stop.minimum_impact_speed or lower stop.restitution"
    of_work = "raise solver.work_limit, loosen solver.tolerance, or lower contact.stiffness"
    storm, energy, work = "too many contacts", "the energy drifts", "a second of simulated time"
    for start, tolerance, moving_walls, values, advice in (
        (storm, 1e-8, [], walls, of_walls),
        (storm, 1e-8, [], stops, of_stops),
        (storm, 1e-8, [], walls | stops, f"for points at walls, {of_walls}; for joints at stops, {of_stops}"),
        (storm, 1e-8, [1], walls, f"for points at walls, {of_walls}; for walls that move, leave more room"),
        (energy, 1e-6, [], walls, "lower solver.tolerance, which makes errors of steps smaller"),
        (energy, 1e-9, [], walls, "raise solver.tolerance, because round-off is too large for it"),
        (work, 1e-8, [], walls | {"solver.work_limit": 1.0, "link[1].joint_stiffness": 0.0},
         of_work),
        (work, 1e-8, [], walls | {"solver.work_limit": 1.0, "link[1].joint_stiffness": 5.0},
         f"{of_work} or the joint_stiffness of links"),
    ):  # fmt: skip
        reason, advice_in_page, part = script.evaluate(ADVICE, [start, tolerance, moving_walls, values])
        assert reason.startswith(start)
        assert advice_in_page.startswith(advice)
        assert moving_walls or advice_in_page == advice
        assert part == "link 1"


@pytest.mark.parametrize(
    ("model", "key", "slope"),
    [("hopper", "box.y_min", 1.0), ("thrown_pole", "box.y_min", 1.0), ("thrown_brick", "box.y_min", 1.0),
     ("ramp", "wall.ramp.y", 0.8)],
)  # fmt: skip
def test_a_wall_may_be_moved_to_the_nearest_point_and_not_further(script, model, key, slope):
    scene = load_scene(model)
    name = key.split(".")[1]
    start = scene.values[key]

    def deepest(value):
        arguments = {"contents": page_contents(scene), "values": {key: value}}
        return max(depth for wall, depth in script.evaluate(DEPTHS, arguments) if wall == name)

    room = -deepest(start) / slope
    assert room > 0.0
    assert deepest(start + room) == pytest.approx(0.0, abs=1e-12)
    scene.with_values({key: start + room - 1e-6})
    with pytest.raises(SceneError, match=f"deep in the wall {name}"):
        scene.with_values({key: start + room + 1e-6})


@pytest.mark.parametrize(
    ("model", "part", "expected"),
    [
        ("kneed_leg", "joint 3 at its joint_max", "joint 3 starts beyond its joint_max"),
        ("cart_pole", "the slider at its slider_min", "the slider starts beyond its slider_min"),
        ("cart_pole", "joint 1", "joint 1"),
    ],
)
def test_stops_are_named_without_a_distance(script, model, part, expected):
    arguments = {"contents": page_contents(load_scene(model)), "part": part}
    assert script.evaluate(START_TEXT, arguments) == expected
