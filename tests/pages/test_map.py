"""The map of two parameters: preview, values, outputs, the keyboard, and runs that a click opens."""

# Tests: pages/browser/explore/map/map.js, pages/browser/explore/map/map_drawing.js
# Tests: pages/browser/explore/map/map_rows.js, pages/browser/explore/map/map_outputs.js
# Tests: pages/browser/explore/map/map_files.js, pages/browser/explore/map/ranking.js
# Tests: pages/browser/explore/map/map_contour.js, pages/browser/explore/map/map_limit.js
# Tests: pages/browser/explore/map/map_text.js

import io
import math
import re

import numpy as np
import pytest
from PIL import Image

from chain_impact import load_scene, simulate, sweep
from tests.pages.in_pages import ANGLE_AXIS, MAP, draw_map, enter, saved, until, until_text
from tests.tiers import needs_browser

pytestmark = needs_browser
EMPTY = """(() => {
  const copy = new OffscreenCanvas(80, 80).getContext('2d', { willReadFrequently: true });
  copy.drawImage(document.getElementById('map-canvas'), 0, 0);
  return [...copy.getImageData(0, 0, 80, 80).data].filter((value, k) => k % 4 === 3 && value === 0).length;
})()"""
"""The number of runs of a map without a colour."""
READ = re.compile(
    r"Restitution = ([\d.]+), Initial angle of link 1 = ([\d.]+)\u202f°: Number of impacts = (\d+), "
    r"Largest force at a wall = ([\d.]+)\u202fkN, Dissipated energy = ([\d.]+)\u202fJ"
)


@pytest.mark.parametrize(
    ("model", "second"), [("stick_slip_belt", "initial.angle[1]"), ("bouncing_ball", "initial.y")]
)
def test_a_map_varies_the_height_of_a_free_ball_only(show, model, second):
    page = show(model)
    page.get_by_role("button", name="Map…").click()
    assert page.locator("#map-y-name").input_value() == second


def test_a_map_is_drawn_read_and_opens_a_run(show):
    page = show("rod_drop", MAP)
    page.get_by_role("button", name="Map…").click()
    page.locator("#map-text").get_by_text("Simulate for 41 × 41: a preview can miss jumps.").wait_for()
    assert page.locator("#map-canvas").get_attribute("width") == "16", (
        "outer runs end at the ends of the axes"
    )
    outputs = page.locator("#map-output option").evaluate_all("options => options.map(({ value }) => value)")
    assert page.locator("#map-output").input_value() == "peak_force"
    output_texts = page.locator("#map-output option").all_inner_texts()
    assert "Largest force at a wall" in output_texts, (
        "the bar of colours has the unit, which depends on the runs"
    )
    page.locator("#map-output").select_option("impact.count")
    largest_values = ["peak_force", "max_penetration"]
    assert outputs == [
        "impact.count",
        "impact.last_time",
        *(f"impact[1].{name}" for name in ("onset", "peak_force", "place")),
        *largest_values,
        "energy.total",
        "energy.dissipated",
        "point[1].x",
        "point[1].y",
    ]
    colour = "text => getComputedStyle(text).color"
    usual_colour = page.locator("#map-text").evaluate(colour)
    for low, high in (("", "1"), ("2", "3")):
        page.locator("#map-x-from").fill(low)
        page.locator("#map-x-to").fill(high)
        page.get_by_role("button", name="Simulate 41 × 41 runs").click()
        page.get_by_text("must be a finite number ≥ 0 and ≤ 1").wait_for()
        assert page.locator("#map-text").evaluate(colour) != usual_colour, "a fault stands out"
        refused = page.locator(".map-axes input:invalid")
        assert refused.evaluate_all("all => all.map(({ id }) => id)") == ["map-x-from"]
    page.locator("#map-x-from").fill("0.2")
    page.locator("#map-x-to").fill("0.95")
    draw_map(page)
    box = page.locator("#map-canvas").bounding_box()
    titles = page.locator("#map-scales text").all_text_contents()
    assert {"Restitution", ANGLE_AXIS, "Number of impacts", "0.4", "20"} <= set(titles)
    assert page.locator(".map-present").count() == 2, "in the map and on the scale of colours"
    table = saved(page, "Map as CSV").read_text().splitlines()
    assert table[0] == "contact.restitution,initial.angle[1],impact.count"
    assert len(table) == 1 + 41 * 41
    page.mouse.move(1, 1)
    picture = Image.open(saved(page, "Map as PNG")).convert("RGB")
    screenshot = Image.open(io.BytesIO(page.locator("#map-frame").screenshot())).convert("RGB")
    differences = np.abs(np.asarray(picture.resize(screenshot.size), float) - np.asarray(screenshot))
    assert differences.mean() < 3.5, "the picture has the map's sizes of text"
    assert picture.getcolors(1 << 20) is None or len(picture.getcolors(1 << 20)) > 5
    lower_right = {"x": box["width"] - 3, "y": box["height"] - 3}
    page.locator("#map-canvas").hover(position=lower_right)
    e, angle, count, force, loss = READ.search(page.locator("#map-text").inner_text()).groups()
    values = {**MAP, "contact.restitution": float(e), "initial.angle[1]": math.radians(float(angle))}
    assert float(e) == 0.95
    run = simulate(load_scene("rod_drop").with_values(values))
    assert int(count) == len(run.impacts)
    assert [1e3 * float(force), float(loss)] == pytest.approx(
        [run.impacts["peak_force"].max(), run["energy.dissipated"][-1]], rel=1e-3
    )
    page.locator("#map-canvas").click(position=lower_right)
    until_text(page, f"{count} impact")
    assert page.evaluate("chainImpact.parameters['contact.restitution']") == "0.95"
    colours = page.evaluate("""new Set(new Uint32Array(document.getElementById('map-canvas')
      .getContext('2d').getImageData(0, 0, 80, 80).data.buffer)).size""")
    assert colours > 3


def test_the_preview_stays_below_the_rows_that_come(show):
    page = show("rod_drop", MAP)
    page.get_by_role("button", name="Map…").click()
    page.locator("#map-text").get_by_text("A preview of 9 × 9 runs.").wait_for()
    titles_in_map = page.locator("#map-scales text:not(.map-value)")
    titles = titles_in_map.all_text_contents()
    page.evaluate("document.getElementById('map-run').click()")  # at once, before any row
    assert page.locator("#map-canvas").get_attribute("width") == "80"
    assert page.evaluate(EMPTY) == 0
    assert titles_in_map.all_text_contents() == titles
    page.locator("#map-text").get_by_text("1681 runs in").wait_for()
    assert page.evaluate(EMPTY) == 0
    choices = page.locator("#map-x-name option").all_inner_texts()
    assert {"Restitution", "Stiffness", "Mass of link 1", "Gravity, x"} <= set(choices)
    assert len(choices) == len(set(choices)), "each parameter has words of its own"


def test_a_map_grows_from_coarse_to_fine_and_has_no_gaps(script):
    order = script.evaluate("rowOrder", 41)
    assert sorted(order) == list(range(41))
    assert max(np.diff(sorted(order[:6]))) <= 8, "the first rows are far apart"
    coarse = {"points": 2, "results": [1.0, 2.0, None, 4.0]}
    function = """([rows, coarse]) => {
      const results = Array(9);
      rows.forEach((row) => [0, 1, 2].forEach((column) => {
        results[3 * row + column] = 10 * row + column;
      }));
      return completed({ results, points: 3, coarse });
    }"""
    assert script.evaluate(function, [[1], coarse]) == [1.0, 2.0, 2.0, 10, 11, 12, None, 4.0, 4.0]
    assert script.evaluate(function, [[0, 1], None]) == [0, 1, 2, 10, 11, 12, 10, 11, 12]


def test_a_map_shows_the_largest_forces_of_a_sweep(show):
    values = {"outputs.loads": True, "simulation.stop_time": 0.55}
    scene, page = load_scene("pinned_arm").with_values(values), show("pinned_arm", values)
    page.get_by_role("button", name="Map…").click()
    assert page.locator("#map-output").input_value() == "joint_force"
    for axis, name in (("x", "contact.restitution"), ("y", "contact.stiffness")):
        page.locator(f"#map-{axis}-name").select_option(name)
    for output in ("peak_force", "joint_force"):
        page.locator("#map-output").select_option(output)
        draw_map(page)
        head, *rows = saved(page, "Map as CSV").read_text().splitlines()
        assert head == f"contact.restitution,contact.stiffness,{output}"
        e, stiffness, value = map(float, rows[-1].split(","))
        table = sweep(scene, {"contact.restitution": [e], "contact.stiffness": [stiffness]})
        assert table[output][0] == value


def test_another_colour_of_a_map_needs_no_runs(show):
    page = show("rod_drop", MAP)
    page.get_by_role("button", name="Map…").click()
    draw_map(page)
    page.evaluate("window.Worker = undefined")
    for output in ("max_penetration", "peak_force", "impact.count"):
        page.locator("#map-output").select_option(output)
        head, *rows = saved(page, "Map as CSV").read_text().splitlines()
        assert head == f"contact.restitution,initial.angle[1],{output}"
        e, angle, value = map(float, rows[-1].split(","))
        scene = load_scene("rod_drop").with_values(MAP)
        table = sweep(scene, {"contact.restitution": [e], "initial.angle[1]": [angle]})
        assert table[output][0] == value
    assert "1681 runs in" in page.inner_text("#map-text")


RANKED = """[...document.querySelectorAll('.effect')].map((row) =>
  [row.title.split(' ')[1], row.lastElementChild.textContent])"""
"""The parameters that a ranking lists, each with its effect as text."""


def share_by_step(ranking, *, exactly=False):
    """Return the relative effects [%] of steps of 1° (angles) or 1 % (other parameters), the largest first.

    The effects are linear, but ``exactly`` the effects on the largest force come from runs.
    """
    size = ranking.effects[0].change / ranking.share(ranking.effects[0]) / 100.0
    scene, step = load_scene("four_link_box"), math.radians(1.0)

    def change(effect):
        size = step if effect.unit == "rad" else 0.01 * effect.value
        if not exactly:
            return effect.derivative * size
        values = {effect.parameter: effect.value + size}
        return simulate(scene.with_values(values)).impacts["peak_force"].max() - peak

    peak = simulate(scene).impacts["peak_force"].max()
    effects = [effect for effect in ranking.effects if effect.value or effect.unit == "rad"]
    shares = {effect.parameter: change(effect) / size for effect in effects}
    return dict(sorted(shares.items(), key=lambda entry: -abs(entry[1])))


def test_a_ranking_has_the_effects_of_the_ranking_of_a_result(show):
    page = show()
    page.get_by_role("button", name="Map…").click()
    page.get_by_role("tab", name="Effects").click()
    page.locator("#map-ranking-text").get_by_text("Largest force at a wall = 19.10\u202fkN.").wait_for()
    assert page.inner_text("#map-title") == "Effects of single parameters"
    fields = page.locator("#map :is(select, input, button):visible").evaluate_all(
        "all => all.map((element) => element.id)"
    )
    assert not {"map-x-name", "map-scale", "map-limit", "map-run"} & {*fields}, "nothing is shown in vain"
    listed_effects = page.evaluate(RANKED)
    result = simulate("four_link_box", sensitivities=["*"])
    ranking = result.ranking("peak_force")
    shares = {name: float(text.replace("−", "-").removesuffix("\u202f%")) for name, text in listed_effects}
    angles = {effect.parameter for effect in ranking.effects if effect.unit == "rad"}
    steps = page.locator(".effect > :nth-child(2)").all_inner_texts()
    for step, is_angle in (("+ 1\u202f%", False), ("+ 1°", True)):
        group = [
            name for (name, _), step_text in zip(listed_effects, steps, strict=True) if step_text == step
        ]
        shares_of_runs = share_by_step(ranking, exactly=True)
        expected = {name: share for name, share in shares_of_runs.items() if (name in angles) == is_angle}
        assert group == list(expected)[: len(group)], "each kind of step has a group"
        assert [shares[name] for name in group] == pytest.approx(
            list(expected.values())[: len(group)], rel=0.1
        )
    assert all(step.startswith("+ 0.01") for step in steps[steps.index("+ 1°") :] if step != "+ 1°"), (
        "parameters that are 0 come last"
    )
    assert page.locator("#map-ranking h3").count() == 3
    longest = page.locator("h3 + .effect .effect-bar").evaluate_all(
        "bars => bars.map(({ style }) => [style.getPropertyValue('--from'), style.getPropertyValue('--to')])"
    )
    assert all("0%" in ends or "100%" in ends for ends in longest), "each group has a scale of its own"
    more_button = page.get_by_role("button", name="Show all ")
    count = int(more_button.inner_text().split()[-1])
    more_button.click()
    assert page.locator(".effect").count() == count > len(steps)
    assert more_button.count() == 0
    table = saved(page, "Ranking as CSV").read_text().splitlines()
    assert table[0].startswith("parameter,value,step,change of peak_force")
    assert len(table) > 1 + count
    page.locator("#map-output").select_option("max_penetration")
    page.locator("#map-ranking-text").get_by_text("Largest penetration = ").wait_for()
    deeper = list(share_by_step(result.ranking("max_penetration")))
    assert [name for name, _ in page.evaluate(RANKED)][:2] == deeper[:2]
    page.locator(".effect").first.click()
    assert page.locator("#map-x-name").input_value() == deeper[0]
    assert page.locator("#map-canvas").is_visible()
    assert not page.locator("#map-ranking").is_visible()
    page.get_by_role("tab", name="Map").press("ArrowRight")
    page.get_by_role("tab", name="Effects", selected=True).wait_for()


def test_a_ranking_of_a_count_has_whole_numbers(show):
    page = show("kneed_leg")
    page.get_by_role("button", name="Map…").click()
    page.get_by_role("tab", name="Effects").click()
    page.locator("#map-ranking-text").get_by_text("Number of impacts = 1. ").wait_for()
    changes = page.locator(".effect > :nth-child(4)").all_inner_texts()
    assert changes
    assert all(re.fullmatch(r"[+−]\d+", change) for change in changes)


def test_a_ranking_of_impulses_knows_numbers_but_no_force(show):
    page = show("bouncing_table", {"simulation.stop_time": 0.5})
    page.get_by_role("button", name="Map…").click()
    page.get_by_role("tab", name="Effects").click()
    page.locator("#map-ranking-text").get_by_text("Number of impacts = 5.").wait_for()
    page.locator("#map-output").select_option("peak_force")
    page.locator("#map-ranking-text").get_by_text("Largest force at a wall is not known").wait_for()
    assert page.evaluate(RANKED) == []
    assert page.locator("#map-canvas").is_hidden(), "the map has a tab of its own"


def test_a_map_of_rigid_stops_counts_impacts_and_has_no_force_of_0(show):
    page = show("kneed_leg", {"stops.restitution": 0.6})
    page.get_by_role("button", name="Map…").click()
    assert page.locator("#map-output").input_value() == "impact.count"
    page.locator("#map-text").get_by_text("A preview of").wait_for()
    page.locator("#map-x-to").fill("1.4")
    page.locator("#map-x-to").blur()
    page.get_by_text("must be a finite number").wait_for()
    page.locator("#map-output").select_option("stop.peak_moment")
    page.locator("#map-scales").get_by_text("Largest moment at a stop").wait_for()
    page.locator("#map-x-to").fill("0.9")
    draw_map(page)
    assert "; grey runs have only impulses." in page.locator("#map-text").inner_text()
    box = page.locator("#map-canvas").bounding_box()
    page.locator("#map-canvas").hover(position={"x": 0.6 * box["width"], "y": 0.5 * box["height"]})
    page.locator("#map-text").get_by_text("only impulses with Newton (1687)").wait_for()


def test_a_map_whose_runs_all_fail_tells_why_and_what_is_changed(show):
    page = show("bouncing_ball")
    page.evaluate("chainImpact.show({ 'initial.y': -1 })")
    page.get_by_role("button", name="Map…").click()
    page.locator("#map-y-name").select_option("initial.angle[1]")
    text = page.locator("#map-text")
    text.get_by_text("All have changed values of initial.y.").wait_for()
    assert text.inner_text().startswith("All 81 runs fail; the first one: ")


def test_a_run_that_a_scene_would_refuse_has_no_colour(show):
    page = show("sliding_rod", {"simulation.stop_time": 0.05})
    page.get_by_role("button", name="Map…").click()
    for axis, name in (("x", "wall.y_min.static_friction"), ("y", "wall.y_min.friction")):
        page.locator(f"#map-{axis}-name").select_option(name)
        for end, value in (("from", "0.1"), ("to", "0.5")):
            page.locator(f"#map-{axis}-{end}").fill(value)
    draw_map(page)
    box = page.locator("#map-canvas").bounding_box()
    assert "; grey runs fail." in page.locator("#map-text").inner_text()
    refused = re.compile(r"the run fails: Static friction at the floor = .* must be ≥\xa0")
    for place, text in ((0.9, "Largest force at a wall = "), (0.1, refused)):
        page.locator("#map-canvas").hover(position={"x": place * box["width"], "y": 0.5 * box["height"]})
        page.locator("#map-text").get_by_text(text).wait_for()


def test_a_closed_map_stops_and_a_new_one_replaces_an_incomplete_one(show):
    page = show(hash_="#simulation.stop_time=400")
    page.get_by_role("button", name="Map…").click()
    page.get_by_role("button", name="Simulate 41 × 41 runs").click()
    until_text(page, "of 41 rows", "map-text")
    while len(page.workers) == 1:
        page.wait_for_timeout(50)
    page.keyboard.press("Escape")
    until(page, "document.getElementById('map-text').textContent.startsWith('Stopped after')")
    while len(page.workers) > 1:  # all workers except the worker of the motion end
        page.wait_for_timeout(50)
    page.evaluate("chainImpact.show({ 'simulation.stop_time': 0.2 })")
    page.get_by_role("button", name="Map…").click()
    for output in ("impact.last_time", "impact.count"):
        page.get_by_label("Output", exact=True).select_option(output)
        page.get_by_role("button", name="Simulate 41 × 41 runs").click()
    page.locator("#map-text").get_by_text("1681 runs in").wait_for()
    page.locator("#map-canvas").hover()
    until_text(page, "Number of impacts = ", "map-text")


def test_a_map_goes_by_the_keyboard(show):
    page = show("rod_drop", MAP)
    page.get_by_role("button", name="Map…").click()
    draw_map(page)
    page.locator("#map-canvas").focus()
    page.keyboard.press("ArrowRight")  # the present run, in the middle
    middle = page.text_content("#map-text")
    assert "Largest force at a wall = " in middle
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowUp")
    assert page.text_content("#map-text") != middle
    assert page.locator(".map-chosen").count() == 1
    restitution = float(re.search(r"Restitution = ([\d.]+)", page.text_content("#map-text"))[1])
    page.keyboard.press("Enter")
    assert page.locator("#map-text").inner_text().startswith("Present run: ")
    assert float(page.evaluate("chainImpact.parameters['contact.restitution']")) == pytest.approx(
        restitution, rel=1e-4
    )


def test_the_map_of_a_scene_without_walls_shows_an_energy(show):
    page = show("simple_pendulum", MAP)
    page.get_by_role("button", name="Map…").click()
    assert page.locator("#map-output").input_value() == "energy.total"


def test_another_axis_of_a_whole_map_begins_a_new_preview(show):
    page = show("rod_drop", {"simulation.stop_time": 0.4})
    page.get_by_role("button", name="Map…").click()
    draw_map(page)
    frame, names = page.locator("#map-frame"), page.locator("#map-x-name")
    plain = frame.evaluate("frame => getComputedStyle(frame).opacity")
    first = names.input_value()
    assert names.is_hidden(), "fields that are set are folded"
    assert page.get_by_role("slider", name="Stiffness").is_visible(), "other parameters stay"
    page.get_by_role("button", name="Fields").click()
    names.select_option("initial.angle[1]")
    page.get_by_text("choose two parameters").wait_for()
    assert frame.evaluate("frame => getComputedStyle(frame).opacity") < plain, "it is of earlier fields"
    names.select_option(first)
    page.locator("#map-text").get_by_text("1681 runs in").wait_for()
    assert frame.evaluate("frame => getComputedStyle(frame).opacity") == plain
    page.keyboard.press("Escape")
    page.evaluate("chainImpact.show({ 'gravity.y': -5 })")
    page.get_by_role("button", name="Map…").click()
    assert "Other parameters have changed" in page.inner_text("#map-text")
    names.select_option("contact.stiffness")
    page.locator("#map-text").get_by_text("A preview of 9 × 9 runs.").wait_for()
    assert any("Stiffness" in text for text in page.locator("#map-scales text").all_text_contents())
    page.locator("#map-canvas").click(position={"x": 5, "y": 5})
    until(page, "chainImpact.parameters['contact.stiffness'] !== '1e6'")
    assert page.evaluate("chainImpact.parameters['gravity.y']") == "-5"


def test_a_map_tells_when_where_and_how_hard_the_first_impact_is(show):
    page = show("rod_drop", MAP)
    page.get_by_role("button", name="Map…").click()
    page.locator("#map-y-from").fill("-20")
    page.locator("#map-y-to").fill("20")
    draw_map(page)
    rows_of_outputs = {}
    for output in ("onset", "peak_force", "place"):
        page.locator("#map-output").select_option(f"impact[1].{output}")
        _, *rows = saved(page, "Map as CSV").read_text().splitlines()
        rows_of_outputs[output] = [row.split(",") for row in rows]
    for run in (3, 1600):
        e, angle, onset = map(float, rows_of_outputs["onset"][run])
        values = {**MAP, "contact.restitution": e, "initial.angle[1]": angle}
        first = simulate(load_scene("rod_drop").with_values(values)).impacts[0]
        force = float(rows_of_outputs["peak_force"][run][2])
        assert (onset, force) == pytest.approx((first["onset"], first["peak_force"]), rel=1e-9)
        assert rows_of_outputs["place"][run][2] == f"{first['point']} floor"
    texts = page.locator("#map-scales text:not(.map-value)").all_text_contents()
    assert texts[-3:] == ["0 floor", "1 floor", "First impact: point and wall"]
    assert page.locator(".map-swatch").count() == 2, "a colour for each class"
    assert page.locator("#map-limit").is_disabled()
    page.locator("#map-output").select_option("impact[1].peak_force")
    middle = np.median([float(row[2]) for row in rows_of_outputs["peak_force"]])
    for text in (f"{middle / 1e3:.6g}", f"{middle:.6g} N"):
        enter(page, "Limit", text)
        page.locator("#map-text").get_by_text("50\u202f% of them are within the limit").wait_for()
        assert page.locator(".map-contour").count() == 2, "in the map and on the scale of colours"
    enter(page, "Limit", "1e9")
    page.locator("#map-text").get_by_text("All of them are within the limit, so there is no line").wait_for()
    for kind in ("linear", "logarithmic"):
        page.locator("#map-scale").select_option(kind)
        titles = page.locator("#map-scales text:not(.map-value)").all_text_contents()
        assert ("(logarithmic scale)" in titles[-1]) == (kind == "logarithmic")
    page.locator("#map-output").select_option("impact[1].place")
    page.locator("#map-canvas").hover(position={"x": 5, "y": 5})
    page.locator("#map-text").get_by_text("First impact: point and wall = 0 floor").wait_for()
