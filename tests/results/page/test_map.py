"""The map of two parameters: its runs are those of `sweep()`, bit by bit; a click opens one."""

import json
import re

import numpy as np
import pytest

from chain_impact import explore, load_scene, simulate, sweep
from chain_impact.results.page.description import description
from tests.results.page.conftest import bits, packed_module
from tests.tiers import needs_browser

pytestmark = needs_browser
RUN = """async ([module, scene, names, grid, stops, words]) => {
  const kernel = await Kernel.load(await compiled(module), scene);
  const given = [Float64Array.from(grid), Float64Array.from(stops), words];
  const found = runThrough(kernel.runEach({ "link[2].mass": 1.2 }, names, ...given));
  const after = runThrough(kernel.run({}, rowTimes(0.1, 0.01), scene.columns.slice(0, 1))).columns[0].length;
  return [btoa(String.fromCharCode(...new Uint8Array(found.buffer))), after];
}"""


def test_the_runs_of_a_map_have_the_bits_of_a_sweep(worker):
    scene = load_scene("four_link_box").with_values({"simulation.stop_time": 1.2})
    varied = {"contact.restitution": np.linspace(0.2, 0.9, 9), "initial.angle[1]": np.linspace(0.1, 0.7, 9)}
    outputs = ["energy.total", "impact.last_time", "point[4].x", "impact.count"]
    known = sweep(scene.with_values({"link[2].mass": 1.2}), varied, outputs=outputs).table
    data = json.loads(json.dumps(description(scene, [])))
    words = {one["name"]: one["word"] for one in data["columns"]}
    grid = np.column_stack([known[name] for name in varied])
    stops, asked = [1.2] * len(grid), [words[name] for name in outputs]
    given = [packed_module(), data, list(varied), grid.ravel().tolist(), stops, asked]
    text, rows_after = worker.evaluate(RUN, given)
    found = bits(text).reshape(len(grid), len(outputs))
    for place, name in enumerate(outputs):
        column = np.ascontiguousarray(known[name])
        np.testing.assert_array_equal(found[:, place], column.view(np.int64), name)
    assert rows_after == 11  # the memory has grown, and other runs go on as before


def test_a_map_is_drawn_read_and_opens_a_run(browser, tmp_path):
    scene = load_scene("rod_drop").with_values({"simulation.stop_time": 0.8})
    explore(scene, tmp_path / "rod.html")
    page = browser.new_page(viewport={"width": 1366, "height": 768}, reduced_motion="reduce")
    page.goto((tmp_path / "rod.html").as_uri())
    page.get_by_role("button", name="Map…").click()
    page.get_by_role("button", name="Simulate 41 × 41 runs").click()
    text = page.locator("#map-text")
    text.get_by_text("1681 runs in").wait_for()
    box = page.locator("#map-canvas").bounding_box()
    lower_right = {"x": box["width"] - 5, "y": box["height"] - 5}
    page.locator("#map-canvas").hover(position=lower_right)
    said = re.search(
        r"contact.restitution = ([\d.]+), initial.angle\[1\] = ([\d.]+): impact.count = (\d+)",
        text.inner_text(),
    )
    values = {"contact.restitution": float(said[1]), "initial.angle[1]": float(said[2])}
    assert values["contact.restitution"] == 0.95
    assert int(said[3]) == len(simulate(scene.with_values(values)).impacts)
    page.locator("#map-canvas").click(position=lower_right)
    page.wait_for_function(f"document.getElementById('subtitle').textContent.includes('{said[3]} impact')")
    assert page.evaluate("chainImpact.parameters['contact.restitution']") == "0.95"
    colours = page.evaluate("""new Set(new Uint32Array(document.getElementById('map-canvas')
      .getContext('2d').getImageData(0, 0, 41, 41).data.buffer)).size""")
    assert colours > 3
    page.close()


@pytest.mark.parametrize(("low", "high"), [("", "1"), ("2", "3")])
def test_a_map_that_cannot_be_says_why(browser, tmp_path, low, high):
    explore("rod_drop", tmp_path / "rod.html")
    page = browser.new_page()
    page.goto((tmp_path / "rod.html").as_uri())
    page.get_by_role("button", name="Map…").click()
    page.locator("#map-x-from").fill(low)
    page.locator("#map-x-to").fill(high)
    page.get_by_role("button", name="Simulate 41 × 41 runs").click()
    page.get_by_text("must be a finite number >= 0 and <= 1").wait_for()
    page.close()


def test_a_run_that_a_scene_would_refuse_has_no_colour(browser, tmp_path):
    explore(load_scene("sliding_rod").with_values({"simulation.stop_time": 0.05}), tmp_path / "rod.html")
    page = browser.new_page()
    page.goto((tmp_path / "rod.html").as_uri())
    page.get_by_role("button", name="Map…").click()
    for axis, name in (("x", "wall.y_min.static_friction"), ("y", "wall.y_min.friction")):
        page.locator(f"#map-{axis}-name").select_option(name)
        for end, value in (("from", "0.1"), ("to", "0.5")):
            page.locator(f"#map-{axis}-{end}").fill(value)
    page.get_by_role("button", name="Simulate 41 × 41 runs").click()
    page.locator("#map-text").get_by_text("1681 runs in").wait_for()
    box = page.locator("#map-canvas").bounding_box()
    for place, text in ((0.9, "impact.count = "), (0.1, "the run fails")):
        page.locator("#map-canvas").hover(position={"x": place * box["width"], "y": 0.5 * box["height"]})
        page.locator("#map-text").get_by_text(text).wait_for()
    page.close()
