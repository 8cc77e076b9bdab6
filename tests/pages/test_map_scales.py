"""The scales of a map: units, ticks and colours, and the numbers that are written into the map."""

# Tests: pages/browser/explore/map/map_scales.js, pages/browser/explore/map/map_marks.js
# Tests: pages/browser/explore/map/map_colours.js

import math
import re

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from tests.pages.in_pages import ANGLE_AXIS, MAP, PHONE, draw_map
from tests.tiers import needs_browser

pytestmark = needs_browser


def test_angles_in_degrees_are_taken_in_every_field(show):
    page = show("rod_drop", MAP)
    page.evaluate("chainImpact.show({ 'initial.angle[1]': '20 deg' })")
    present_angle = "chainImpact.parameters['initial.angle[1]']"
    assert float(page.evaluate(present_angle)) == pytest.approx(math.radians(20.0), rel=1e-15)
    page.locator("#list-of-parameters summary").click()
    for name, text in (("initial.angle[1]", "-30deg"), ("initial.angular_velocity[1]", "90 deg/s")):
        field = page.locator(f"#list-of-parameters input[data-parameter='{name}']")
        field.fill(text)
        field.press("Enter")
        number = math.radians(float(re.match(r"-?\d+", text)[0]))
        assert float(page.evaluate(f"chainImpact.parameters['{name}']")) == pytest.approx(number, rel=1e-15)
    field.fill("90 deg")  # a wrong unit for an angular velocity
    field.press("Enter")
    assert "must be a finite number" in page.locator(".parameter .refusal:not(:empty)").inner_text()
    page.get_by_role("button", name="Map…").click()
    limits = [page.locator(f"#map-y-{end}").input_value() for end in ("from", "to")]
    assert limits == ["-45", "-15"], "around the angle, and in degrees, as the axis"
    page.locator("#map-y-from").fill("10 deg")
    page.locator("#map-y-to").fill("50")
    draw_map(page)
    assert {"10", "50"} <= set(page.locator("#map-scales text").all_text_contents())


def test_the_runs_of_a_map_are_read_in_the_unit_of_its_colours(show):
    page = show("rod_drop", MAP)
    page.get_by_role("button", name="Map…").click()
    page.locator("#map-x-name").select_option("contact.stiffness")
    page.locator("#map-x-from").fill("10")
    page.locator("#map-x-to").fill("1e7")
    draw_map(page)
    box, units = page.locator("#map-canvas").bounding_box(), set()
    for share in np.linspace(0.01, 0.99, 9):
        page.locator("#map-canvas").hover(position={"x": share * box["width"], "y": 0.5 * box["height"]})
        number, unit = re.search(
            r"Largest force at a wall = ([\d.e-]+)\s(\w+)", page.inner_text("#map-text")
        ).groups()
        units.add((float(number) < 1.0, unit))
    assert units == {(True, "kN"), (False, "kN")}


def test_the_scale_of_a_number_of_impacts_has_whole_numbers(show):
    """An end of the rod touches before it is level only if it begins below the other one."""
    page = show("rod_drop", {"simulation.stop_time": 0.25})
    page.get_by_role("button", name="Map…").click()
    page.locator("#map-output").select_option("impact.count")
    for end, angle in (("from", "-25°"), ("to", "25 deg")):
        page.locator(f"#map-y-{end}").fill(angle)
    draw_map(page)
    texts = page.locator("#map-scales text:not(.map-value)").all_text_contents()
    assert texts[texts.index(ANGLE_AXIS) + 1 :] == ["0", "1", "Number of impacts"]


def test_outputs_beyond_the_ends_of_the_scale_have_colours_of_their_own(script):
    """Most of these outputs lie between 0 and 1, a few far beyond."""
    ask = """(outputs) => {
      const scale = colourScale(outputs, false, "");
      const colours = [-9, 0.5, 9].map((value) => colourOf({ output: {}, scale }, value));
      return colours.map((colour) => BEYOND.indexOf(colour));
    }"""
    assert script.evaluate(ask, [*np.linspace(0.0, 1.0, 200), -9.0, 9.0]) == [0, -1, 1]


@pytest.mark.parametrize(("size", "are_jumping"), [(0.0, False), (0.5, True)])
def test_runs_jump_where_single_ones_differ_from_both_neighbours(script, size, are_jumping):
    """No run of a slope with a step differs from both neighbours; a run without an output is left out."""
    points = 41
    column, row = np.meshgrid(np.arange(points), np.arange(points))
    outputs = 5.0 + column / points + (column + row > 50) + size * ((7 * column + 11 * row) % 9 == 0)
    outputs = outputs.astype(object)
    outputs[5::8, 5::8] = None
    ask = """([results, points]) =>
      areJumping({ results, points, output: {}, scale: colourScale(results, false, "linear") })"""
    assert script.evaluate(ask, [outputs.ravel().tolist(), points]) is are_jumping


def test_the_colours_of_a_wide_range_are_logarithmic(show):
    """The peak force grows by four decades with the stiffness."""
    page = show("rod_drop", MAP)
    page.get_by_role("button", name="Map…").click()
    page.locator("#map-x-name").select_option("contact.stiffness")
    page.locator("#map-x-from").fill("10")
    page.locator("#map-x-to").fill("1e10")
    draw_map(page)
    texts = page.locator("#map-scales text:not(.map-value)").all_text_contents()
    ticks = [float(text) for text in texts[texts.index(ANGLE_AXIS) + 1 : -1]]
    assert len(ticks) >= 2
    assert np.ptp(np.diff(np.log10(ticks))) < 1e-9 < np.ptp(np.diff(ticks))


def test_an_axis_of_a_stiffness_goes_by_decades(show):
    page = show("rod_drop", MAP)
    page.get_by_role("button", name="Map…").click()
    page.locator("#map-x-name").select_option("contact.stiffness")
    page.locator("#map-text").get_by_text(
        "A preview of 9 × 9 runs. Press Simulate for 41 × 41: a preview can miss jumps."
    ).wait_for()
    low, high = (float(page.locator(f"#map-x-{end}").input_value()) for end in ("from", "to"))
    present = float(page.evaluate("chainImpact.parameters['contact.stiffness']"))
    assert (low, high) == pytest.approx((present / 10, present * 10))
    page.locator("#map-canvas").press("ArrowRight")  # the run in the middle
    stiffness_text = re.search(r"Stiffness = ([\d.e]+)", page.text_content("#map-text"))[1]
    assert float(stiffness_text) == pytest.approx(present, rel=1e-4)
    numbers = page.locator("#map-scales text").all_text_contents()
    assert {f"{power:.0e}".replace("+0", "") for power in (low, present, high)} <= set(numbers)


def test_a_map_has_the_unit_of_its_own_runs(show):
    """The unit of a stiffness follows the exponent of the runs, which the present scene may have no more."""
    page = show("rod_drop", MAP)
    page.get_by_role("button", name="Map…").click()
    page.locator("#map-x-name").select_option("contact.stiffness")
    page.locator("#map-y-name").select_option("contact.exponent")
    page.locator("#map-text").get_by_text("A preview of 9 × 9 runs.").wait_for()
    assert "Stiffness, N/m^exponent" in page.locator("#map-scales text").all_text_contents()
    page.locator("#map-y-name").select_option("initial.angle[1]")
    draw_map(page)
    page.locator("#map-canvas").press("ArrowRight")
    assert re.search(r"Stiffness = \S+\sN/m¹·⁵,", page.text_content("#map-text"))
    page.keyboard.press("Escape")
    page.evaluate("chainImpact.show({ 'contact.exponent': 2 })")
    page.get_by_role("button", name="Map…").click()
    assert "Stiffness, N/m¹·⁵" in page.locator("#map-scales text").all_text_contents()


def test_a_map_tells_numbers_of_runs_the_present_run_and_the_pointers(show):
    page = show("rod_drop", MAP)
    page.get_by_role("button", name="Map…").click()
    page.locator("#map-text").get_by_text("The ring is the present run.").wait_for()
    values_in_map = {float(text) for text in page.locator(".map-value").all_text_contents()}
    low, high = (float(page.locator(f"#map-y-{end}").input_value()) for end in ("from", "to"))
    left = float(page.locator("#map-x-from").input_value())
    second = {"contact.restitution": left, "initial.angle[1]": np.deg2rad(low + (high - low) / 8)}
    corner = simulate(load_scene("rod_drop").with_values(MAP | second)).impacts["peak_force"].max() / 1e3
    assert min(abs(value / corner - 1.0) for value in values_in_map) < 5e-3, "a run at the left is told"
    present = simulate(load_scene("rod_drop").with_values(MAP)).impacts["peak_force"].max()
    number = page.text_content(".map-value.of-present")
    assert float(number) == pytest.approx(present / 1e3, rel=5e-3)
    page.locator("#map-canvas").hover(position={"x": 5, "y": 5})
    label = page.text_content(".map-label-text")
    force_text = re.search(r"Largest force at a wall = ([\d.]+)", page.inner_text("#map-text"))[1]
    assert float(label.split("\u202f")[0]) == pytest.approx(float(force_text), rel=5e-3)
    assert page.locator(".map-at").count() == 1, "the scale of colours has a mark, too"
    page.mouse.move(1, 1)
    page.locator("#map-text").get_by_text("The ring is the present run.").wait_for()
    assert page.locator(".map-label-text").count() == 0


def test_the_first_map_and_its_colours_contain_the_present_run(show):
    """The height changes the motion of a ball; the angle does not."""
    for model in ("bouncing_ball", "kneed_leg"):
        page = show(model)
        page.get_by_role("button", name="Map…").click()
        page.locator("#map-text").get_by_text("The ring is the present run.").wait_for()
        assert (page.locator("#map-y-name").input_value() == "initial.y") is (model == "bouncing_ball")
        page.locator("#map-output").select_option("impact.count")
        count = len(simulate(model).impacts)
        assert page.text_content(".map-value.of-present") == str(count)
        if model == "bouncing_ball":
            page.locator("#map-x-from").fill("0.05")
            page.locator("#map-x-from").press("Tab")
            page.locator("#map-scales").get_by_text("0.2", exact=True).wait_for()
            page.locator("#map-text").get_by_text("The ring is the present run.").wait_for()
            assert page.locator(".of-present").get_attribute("fill") == "#ffffff", (
                "runs with few impacts are dark"
            )
        scale = page.locator("#map-scales .map-number").all_text_contents()
        bins = [
            tuple(map(int, match.groups())) for text in scale if (match := re.fullmatch(r"(\d+)–(\d+)", text))
        ]
        single = [int(text) for text in scale if re.fullmatch(r"\d+", text)]
        assert any(low <= count <= high for low, high in bins) if bins else count in single


def test_the_colours_of_crowded_values_have_equally_many_runs(script):
    values = [1 + 0.001 * k for k in range(80)] + [1.2 + 0.05 * k for k in range(20)]
    shares, knots = script.evaluate(
        "(all) => (({ shareOf, knots }) => [all.map(shareOf), knots])(colourScale(all, false, 'equal'))",
        values,
    )
    assert shares == sorted(shares)
    assert (shares[0], shares[-1]) == (0.0, 1.0)
    assert shares[50] == pytest.approx(0.5, abs=0.03)
    assert len(knots) == 9
    usual_shares = "(all) => all.map(colourScale(all, false).shareOf)"
    assert script.evaluate(usual_shares, values) == shares, "crowded values take such colours by themselves"
    even = [1 + 0.01 * k for k in range(100)]
    assert np.ptp(np.diff(script.evaluate(usual_shares, even)) / np.diff(even)) < 1e-9, "others are linear"


def test_the_line_of_a_limit_goes_along_cells(script):
    results = [1.0, 1.0, 1.0, 1.0, 9.0, 1.0, 1.0, 1.0, None]
    edges = script.evaluate("(results) => contourOf(results, 3, 5)", results)
    assert sorted(sorted(edge) for edge in edges) == [
        [[0.5, 0.5], [0.5, 1.5]],
        [[0.5, 0.5], [1.5, 0.5]],
        [[0.5, 1.5], [1.5, 1.5]],
        [[1.5, 0.5], [1.5, 1.5]],
    ]
    assert script.evaluate("(results) => contourOf(results, 3, 9)", results) == []
    outer = script.evaluate("(results) => contourOf(results, 2, 5)", [1.0, 9.0, 1.0, 9.0])
    assert outer == [[[0.5, 0], [0.5, 0.5]], [[0.5, 0.5], [0.5, 1]]]


HIDDEN_NUMBERS = """() => {
  const label = document.querySelector('.map-label').getBoundingClientRect();
  return [...document.querySelectorAll('.map-value')].map((element) => element.getBoundingClientRect())
    .filter(({ left, right }) => left < label.right && right > label.left)
    .filter(({ top, bottom }) => top + 3 < label.bottom && bottom - 3 > label.top).length;
}"""
"""The number of numbers that the label of a run covers."""


def test_the_label_of_a_run_covers_no_number_and_tablets_have_all_columns(show):
    page = show("rod_drop", MAP, viewport={"width": 768, "height": 1024})
    page.get_by_role("button", name="Map…").click()
    page.locator("#map-text").get_by_text("A preview of").wait_for()
    places = page.locator(".map-value:not(.of-present)").evaluate_all(
        "all => all.map((element) => element.getAttribute('x'))"
    )
    assert len(set(places)) == 7, "all columns, except the outer ones, which have half a width"
    draw_map(page)
    box = page.locator("#map-canvas").bounding_box()
    for share in np.linspace(0.1, 0.9, 7):
        page.locator("#map-canvas").hover(position={"x": share * box["width"], "y": share * box["height"]})
        page.locator(".map-label-text").wait_for()
        assert page.evaluate(HIDDEN_NUMBERS) == 0


TEXTS = """(kind) => [...document.querySelectorAll(`#map-scales ${kind}`)].map((element) => {
  const [{ left, right, top, bottom }, frame] =
    [element, document.getElementById("map-frame")].map((part) => part.getBoundingClientRect());
  return [element.textContent, left - frame.left, right - frame.left, top, bottom, frame.width];
})"""
"""Each text of a kind in a map, its edges, and the width of the map's frame."""


@pytest.mark.parametrize("model", ["four_link_box", "pinned_arm"])
def test_the_texts_of_a_map_are_whole_on_a_phone(show, model):
    """The title of crowded colours has two lines, and names of places keep apart from each other."""
    page = show(model, {"simulation.stop_time": 0.6}, viewport=PHONE)
    page.get_by_role("button", name="Map…").click()
    page.locator("#map-text").get_by_text("A preview of").wait_for()
    page.get_by_role("button", name="Fields").click()
    for output in page.locator("#map-output option").evaluate_all("all => all.map(({ value }) => value)"):
        page.locator("#map-output").select_option(output)
        texts = page.evaluate(TEXTS, "text")
        assert [
            text for text, left_end, right_end, *_, width in texts if left_end < -1 or right_end > width + 1
        ] == []
        values = page.evaluate(TEXTS, ".map-value")
        for k, (text, left_end, right_end, top, bottom, _) in enumerate(values):
            for other_text in values[k + 1 :]:
                is_apart = (
                    right_end < other_text[1]
                    or other_text[2] < left_end
                    or bottom < other_text[3] + 3
                    or other_text[4] < top + 3
                )
                assert is_apart, (output, text, other_text[0])
    if model == "four_link_box":
        page.locator("#map-output").select_option("peak_force")
        page.locator("#map-scale").select_option("equal")
        titles = [text for text, *_ in page.evaluate(TEXTS, "text:not(.map-value)")]
        assert titles[-2:] == ["Largest force at a wall, kN", "(an equal number of runs for each colour)"]


def test_values_that_differ_by_round_off_have_one_colour(script):
    values = [0.1 + 0.2, 0.3, 0.3]
    function = """(values) => {
      const { ends, shareOf } = colourScale(values, false);
      return [ticksBetween(...ends, 3).length, new Set(values.map(shareOf)).size];
    }"""
    assert script.evaluate(function, values) == [1, 1]
    assert script.evaluate(function, [0.3, 0.31, 0.32])[1] == 3
