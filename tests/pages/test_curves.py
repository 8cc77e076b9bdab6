"""The chart of outputs: chosen outputs are drawn with the numbers of `simulate()`, and stored in the link."""

# Tests: pages/browser/charts/curve_charts.js
# Tests: pages/browser/scene/output_words.js
# Tests: pages/browser/charts/chart.js, pages/browser/charts/time_chart.js

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from tests.pages.in_pages import (
    CHART_NAMES,
    DESK,
    PIXELS,
    ROWS,
    impacts_of,
    packed_module,
    page_contents,
    time_of,
    until,
    until_text,
)
from tests.pages.javascript import function_of
from tests.tiers import needs_browser

pytestmark = needs_browser
NOW = function_of("curves", "now")
"""The place of the line at the present time, over the width of the chart."""
TEXTS = function_of("curves", "texts")
"""The texts of the first chart at another width, and their places over the width of its curves."""
MOTION = function_of("curves", "motionInPage")


def shown_value(page, name):
    """Return the shown value of an output, without its unit."""
    row = page.locator("#outputs-over-time div").filter(has=page.locator(f'dt[title="{name}"]'))
    return float(row.locator("dd").inner_text().split("\u202f")[0].replace("\u2212", "-"))


def test_outputs_of_a_link_are_drawn_and_told_at_each_time(show, result):
    page = show(hash_="#curves=point[4].*y,impact.count")
    names = ["point[4].y", "point[4].vy", "point[4].ay", "impact.count"]
    assert page.evaluate(CHART_NAMES) == names
    assert page.locator("#outputs-over-time canvas").count() == 4, "a chart for each unit"
    page.locator("#scrub").fill("0.9")
    until(page, "document.getElementById('time').textContent === '0.90000 s'")
    for name in names:
        expected = np.interp(0.9, result.time, result[name])
        assert shown_value(page, name) == pytest.approx(expected, abs=1e-3 * np.ptp(result[name]))


CURVE_WORDS = {
    "contact[2].y_min.force": "point 2 at the floor",
    "contact[2].y_min.penetration": "point 2 at the floor, penetration",
    "contact[0].slider_min.force": "point 0 at slider min",
    "joint[2].angle": "joint 2",
    "joint[2].force.x": "joint 2, x",
    "point[4].vy": "point 4, velocity y",
    "energy.kinetic": "kinetic",
    "slider.position": "slider, position",
    "impact.count": "impacts so far, count",
}


def test_a_curve_is_called_by_words_and_its_name_is_a_tooltip(script, show):
    quantities = {"force": "force", "angle": "angle", "energy": "energy"}
    pairs = [[name, next((quantities[key] for key in quantities if key in name), "")] for name in CURVE_WORDS]
    ask = """(all) => all.map(([name, quantity]) => outputCurveText(name, quantity,
      (parameter) => ({ "gravity.x": 0, "gravity.y": -9.8 })[parameter]))"""
    assert script.evaluate(ask, pairs) == list(CURVE_WORDS.values())
    page = show(hash_="#curves=contact[2].y_min.force")
    term = page.locator("#outputs-over-time dt.of-curve")
    assert term.inner_text() == "point 2 at the floor"
    assert term.get_attribute("title") == "contact[2].y_min.force"


def test_an_angle_is_drawn_in_degrees(show, result):
    page = show(hash_="#curves=joint[2].angle")
    page.locator("#scrub").fill("0.9")
    until(page, "document.getElementById('time').textContent === '0.90000 s'")
    value, unit = page.locator("#outputs-over-time dd").inner_text().split("\u202f")
    assert unit == "°"
    assert page.locator("#outputs-over-time .curve-unit").inner_text() == "angle, °"
    expected = np.degrees(np.interp(0.9, result.time, result["joint[2].angle"]))
    assert float(value.replace("\u2212", "-")) == pytest.approx(expected, rel=5e-3)


def test_the_values_of_one_quantity_have_the_same_decimals(show):
    page = show(hash_="#curves=point[*].y,impact.count")
    page.locator("#scrub").fill("1.99")
    until(page, "document.getElementById('time').textContent === '1.99000 s'")
    *heights, count = page.locator("#outputs-over-time dd").all_inner_texts()
    assert {len(text.split("\u202f")[0].split(".")[1]) for text in heights} == {3}
    assert count.isdigit()
    assert not any(text.startswith("\u22120.000\u202f") for text in heights)


VALUE_TEXTS = {
    "point[1].y": ([2.1, 0.5], "0.500"),
    "point[2].y": ([0.03, -0.02], "\u22120.020"),
    "contact[2].y_min.penetration": ([4e-4, 3.217e-4], "0.0003217"),
    "contact[4].y_min.penetration": ([1e-5, 2e-6], "0.0000020"),
    "contact[2].x_max.penetration": ([2e-10, 1.2346e-10], "1.235e-10"),
    "contact[4].x_max.penetration": ([0.0, 0.0], "0"),
}


def test_each_quantity_has_the_decimals_of_its_largest_value(script):
    """The curves of one output of several points are one quantity."""
    curves = [{"name": name, "values": values} for name, (values, _) in VALUE_TEXTS.items()]
    ask = "(curves) => writersOf(curves).map((written, k) => written(curves[k].values[1]))"
    assert script.evaluate(ask, curves) == [text for _, text in VALUE_TEXTS.values()]


@pytest.mark.parametrize(
    ("onset", "ends", "step", "expected"),
    [
        (None, (0.0, 1.02), 0.5, {"0 s": 0.0, "0.5 s": 0.5, "1.0 s": 1.0}),
        (0.4007, (0.3985, 0.404), 2e-3, {"\u22122 ms": 0.3987, "0 ms": 0.4007, "2 ms": 0.4027}),
    ],
)
def test_a_view_of_one_impact_counts_the_time_from_its_onset(script, onset, ends, step, expected):
    ask = "([onset, [low, high], step]) => timeTicks(low, high, step, onset ?? undefined)"
    ticks = script.evaluate(ask, [onset, ends, step])
    texts = script.evaluate("([ticks, onset]) => timeTexts(ticks, onset ?? undefined)", [ticks, onset])
    assert dict(zip(texts, ticks, strict=True)) == pytest.approx(expected)


def test_small_lengths_are_in_millimetres(show):
    page = show("bouncing_table", {"simulation.stop_time": 0.3})
    assert page.inner_text("#inputs-over-time .curve-unit") == "length, mm"
    page.locator("#scrub").fill("0.125")
    until(page, "document.getElementById('time').textContent === '0.12500 s'")
    amplitude = 1e3 * float(page.evaluate("chainImpact.parameters['signal.table.amplitude']"))
    value, unit = page.inner_text("#inputs-over-time dd").split("\u202f")
    assert (float(value), unit) == (pytest.approx(amplitude, abs=0.01), "mm")


def test_a_view_of_one_impact_has_its_peak_and_a_pinned_curve(show, result):
    page = show(hash_="#curves=contact[2].y_min.force")
    page.get_by_role("button", name="Go to impact 1, ").click()
    assert page.get_by_role("button", name="At impact").get_attribute("aria-pressed") == "false"
    page.get_by_role("button", name="At impact").click()
    impact = result.impacts[0]
    unit = page.locator("#outputs-over-time .curve-unit")
    assert unit.inner_text() == "force, kN", "as in the chart of the contact"
    share = 1e3 * shown_value(page, "contact[2].y_min.force") / impact["peak_force"]
    assert share == pytest.approx(1.0, abs=0.01), "the largest force"
    assert page.text_content("#outputs-impact") == page.text_content("#contact-name").split(",")[0]
    charts = page.locator("#outputs-over-time .u-over").first
    box = charts.bounding_box()
    page.mouse.click(box["x"] + 0.5 * box["width"], box["y"] + 10)
    middle = (impact["onset"] + impact["end"]) / 2
    until(
        page, f"Math.abs(Number(document.getElementById('time').textContent.slice(0, 7)) - {middle}) < 5e-5"
    )
    assert page.evaluate(NOW) == pytest.approx(0.5, abs=0.01)
    assert 0.5 < 1e3 * shown_value(page, "contact[2].y_min.force") / impact["peak_force"] < 1.0
    page.get_by_role("button", name="Pin").click()
    soft = {"contact.stiffness": 1e7}
    lower = simulate(load_scene("four_link_box").with_values(soft)).impacts
    page.evaluate("values => chainImpact.show(values)", soft)
    until_text(page, f"{len(lower)} impacts")
    rows = [page.evaluate(ROWS, ["outputs-over-time", colour]) for colour in ("pin-1", "input-1")]
    heights = [
        max(rows[1]) - min(rows_of_curve) for rows_of_curve in rows
    ]  # above 0, on which the letter of a pin stands
    assert heights[0] / heights[1] == pytest.approx(impact["peak_force"] / lower[0]["peak_force"], rel=0.1)


def test_the_time_counts_from_the_impact_where_two_have_the_same_view(show):
    """Both ends of the rod touch, each for most of the simulated time."""
    flat = {"contact.stiffness": 3e3, "initial.angle[1]": 0.02, "initial.y": 0.01, "initial.vy": -2.0}
    changes = {**flat, "simulation.stop_time": 0.08}
    first, second = simulate(load_scene("rod_drop").with_values(changes)).impacts["onset"]
    assert second - first > 5e-3
    page = show("rod_drop", changes, hash_="#curves=point[1].y")
    for number in (1, 2):
        page.get_by_role("button", name=f"Go to impact {number}, ").click()
        if number == 1:
            page.get_by_role("button", name="At impact").click()
        until(
            page, f"document.getElementById('outputs-impact').textContent.startsWith('impact\u00a0{number}')"
        )
    assert dict(page.evaluate(TEXTS))["0 ms"] == pytest.approx(second / 0.08, abs=0.01)


def test_the_axis_of_a_count_has_whole_numbers(show):
    page = show("rod_drop", {"simulation.stop_time": 0.33}, hash_="#curves=impact.count")
    until(page, f"{CHART_NAMES}.join() === 'impact.count'")
    numbers = [text for text, place in page.evaluate(TEXTS) if place < 0.0]
    assert numbers == ["0", "1"]


def test_an_output_that_stays_0_is_told_and_has_the_tick_0_alone(show):
    changes = {"simulation.stop_time": 0.2}
    assert not simulate(load_scene("rod_drop").with_values(changes))["contact[0].y_min.force"].any()
    page = show("rod_drop", changes, hash_="#curves=contact[0].y_min.force")
    until(page, f"{CHART_NAMES}.join() === 'contact[0].y_min.force'")
    assert page.locator("#outputs-over-time dd").inner_text() == "always 0\u202fN"
    assert [text for text, place in page.evaluate(TEXTS) if place < 0.0] == ["0"]
    page.evaluate("chainImpact.show({'initial.y': 0.05})")
    until(page, "!document.querySelector('#outputs-over-time dd').textContent.startsWith('always')")


def test_the_kernel_gives_only_chosen_outputs_with_the_peaks_of_impacts(worker, result):
    arguments = {"module": packed_module(), **page_contents(load_scene("four_link_box"))}
    assert worker.evaluate(MOTION, {**arguments, "curves": []})["names"] == []
    names = [f"contact[{point}].y_min.force" for point in range(5)]
    motion = worker.evaluate(MOTION, {**arguments, "curves": names})
    assert motion["names"] == names
    floor = result.impacts[result.impacts["wall"] == result.scene.wall_names.index("y_min")]
    peaks = [floor["peak_force"][floor["point"] == point].max(initial=0.0) for point in range(5)]
    assert motion["largest"] == pytest.approx(peaks, rel=2e-3)
    assert motion["rows"] > motion["frames"]
    assert motion["gap"] < 1.001 * result.scene.simulation.stop_time / 1000, "two rows for a pixel of a chart"


@pytest.mark.parametrize(
    ("names", "marks"),
    [
        ("joint[2].angle joint[3].angle", "2 3"),
        ("point[4].x point[4].vy", "x y"),
        ("joint[2].force.x joint[2].force.y joint[3].force.x", "2\u200ax 2\u200ay 3\u200ax"),
        ("energy.kinetic energy.total", "kinetic total"),
    ],
)
def test_a_letter_of_a_pin_stands_beside_what_tells_its_curve_from_others(script, names, marks):
    curves = [{"name": name, "words": name.split(".")[1]} for name in names.split()]
    assert script.evaluate("(curves) => marksOf(curves)", curves) == marks.split(" ")


def test_curves_of_a_pin_are_pale_unless_each_output_has_a_chart(show):
    page = show()
    page.get_by_role("button", name="Chart…").click()
    page.get_by_role("button", name="Forces at the floor").click()
    until(page, f"{CHART_NAMES}.length === 5")
    at_impact = page.get_by_role("button", name="At impact", include_hidden=True)
    assert at_impact.get_attribute("aria-pressed") == "true", "forces alone show one impact"
    page.get_by_role("button", name="Remove all").click()
    until(page, "document.getElementById('outputs-card').hidden")
    page.get_by_role("button", name="Joint angles").click()
    until(page, f"{CHART_NAMES}.length === 3")
    assert at_impact.get_attribute("aria-pressed") == "false"
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'contact.restitution': 0.4})")
    until_text(page, impacts_of({"contact.restitution": 0.4}))
    badges = page.evaluate(PIXELS, ["outputs-over-time", "pin-1"])
    assert badges > 100
    note = page.locator("#outputs-note")
    assert note.inner_text() == "Pale curves are those of pins."
    page.get_by_role("button", name="Chart…").click()
    page.get_by_role("checkbox", name="A chart for each").check()
    assert page.locator("#outputs-over-time canvas").count() == 3
    assert note.text_content() == ""


def test_each_curve_of_a_chart_has_dashes_of_its_own(show):
    page = show(hash_="#curves=point[*].y,link[1].angle")
    lines = page.locator("#outputs-over-time dt.of-curve").evaluate_all(
        "terms => terms.map((term) => term.style.getPropertyValue('--pattern').replace(/var[^)]*./g, ''))"
    )
    assert len(lines) == 6
    assert len(set(lines)) == 5, "the only curve in another unit has a line without dashes, as the first one"


def test_charts_are_high_enough_for_their_numbers(show, script):
    page = show("cart_pole", hash_="#curves=point[1].y,link[1].angle", viewport=DESK)
    page.get_by_role("button", name="Pin").click()
    heights = page.locator(".curve-chart .u-over").evaluate_all(
        "all => all.filter((chart) => chart.checkVisibility()).map((chart) => chart.clientHeight)"
    )
    assert len(heights) == 3  # the inputs and both curves; the card of energies is folded
    assert min(heights) >= 70
    for low, high in ((-5000, 15000), (-0.1, 1.7), (-12.0, 7.0)):
        for height in (92, 104, 178):
            ticks = script.evaluate("([...of]) => ticksUpwards(...of)", [{"height": height}, low, high])
            distances = np.diff(ticks) * (height - 34) / (high - low)
            assert len(ticks) > 1
            assert distances.min() > 11, "the numbers have letters of 11 pixels"


@pytest.mark.parametrize(
    ("model", "visible", "faint"),
    [("bouncing_table", ["dissipated", "supplied"], []), ("shaken_pendulum", [], ["kinetic", "total"])],
)
def test_no_energy_hides_another(show, model, visible, faint):
    """A curve on another has gaps, and a curve that fills an area is faint."""
    page = show(model)
    count = {name: page.evaluate(PIXELS, ["energy", name]) for name in [*visible, *faint]}
    assert all(count[name] > 100 for name in visible), count
    assert all(count[name] < 100 for name in faint), count


@pytest.mark.parametrize(("model", "faint"), [("four_link_box", False), ("shaken_pendulum", True)])
def test_a_curve_is_as_strong_as_its_entry_in_the_list(show, model, faint):
    """The total energy of the box changes its direction only by round-off, which fills no area."""
    page = show(model)
    line = page.locator("#energies dt").filter(has_text="total")
    opacity = line.evaluate("term => Number(getComputedStyle(term, '::before').opacity)")
    assert (opacity < 1.0) is faint
    assert (page.evaluate(PIXELS, ["energy", "total"]) < 100) is faint


def test_a_chart_of_outputs_has_the_values_of_pins_at_the_pointer(show, result):
    page = show(hash_="#curves=point[4].y")
    page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'contact.restitution': 0.4})")
    until_text(page, impacts_of({"contact.restitution": 0.4}))
    box = page.locator("#outputs-over-time .u-over").bounding_box()
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    present, letter, _, value = page.locator("#outputs-over-time dd").all_inner_texts()
    height = np.interp(1.0, result.time, result["point[4].y"])
    assert (present, letter, float(value)) == ("present", "A", pytest.approx(height, abs=0.02))
    at = page.locator("#outputs-over-time .unit").inner_text()
    assert at.startswith("m at 1.0")
    assert page.inner_text("#energy-time") == f"J{at[1:]}", "all charts are read at one time"
    kinetic = page.locator("#energies div", has_text="kinetic").locator("dd").last.inner_text()
    assert float(kinetic) == pytest.approx(np.interp(1.0, result.time, result["energy.kinetic"]), abs=0.5)


def test_the_chosen_impact_stays_when_a_chart_is_added(show):
    """The first impact still lasts while the second one has its largest force."""
    flat = {"contact.stiffness": 3e3, "initial.angle[1]": 0.02, "initial.y": 0.01, "initial.vy": -2.0}
    page = show("rod_drop", {**flat, "simulation.stop_time": 0.08})
    for number in (1, 2):
        page.get_by_role("button", name=f"Go to impact {number}, ").click()
        page.evaluate(f"location.hash = '#curves=point[{number - 1}].y'")
        until(page, f"{CHART_NAMES}.join() === 'point[{number - 1}].y'")
        page.evaluate(
            "() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)))"
        )
        assert page.text_content("#contact-name").startswith(f"impact\u00a0{number}: ")


def test_a_chart_is_read_by_mouse_and_keys_while_the_motion_stays(show, result):
    page = show()
    time = page.inner_text("#time")
    total = page.locator("#energies div", has=page.get_by_text("total", exact=False)).locator("dd").first
    energy_text = total.inner_text()
    box = page.locator("#energy .u-over").bounding_box()
    page.mouse.move(box["x"] + 0.75 * box["width"], box["y"] + 0.5 * box["height"])
    assert page.inner_text("#energy .reading") == "1.5000 s"
    energy = np.interp(1.5, result.time, result["energy.total"])
    shift = float(energy_text) - result["energy.total"][0]
    assert float(total.inner_text().replace("−", "-")) == pytest.approx(energy + shift, abs=0.05)
    page.mouse.move(1, 1)
    assert (total.inner_text(), page.locator(".reading:visible").count()) == (energy_text, 0)
    page.locator("#force").focus()
    for _ in range(3):
        page.keyboard.press("ArrowRight")
    later_reading = page.inner_text("#force .reading")
    page.keyboard.press("ArrowLeft")
    assert page.inner_text("#force .reading") != later_reading
    assert later_reading.split(": ")[1].endswith("N")
    page.keyboard.press("Escape")
    assert page.locator(".reading:visible").count() == 0
    assert page.inner_text("#time") == time
    page.locator("#energy").focus()
    page.keyboard.press("ArrowRight")
    reading = page.inner_text("#energy .reading")
    page.keyboard.press("Enter")
    assert time_of(page) == pytest.approx(float(reading.removesuffix(" s")), abs=1e-4)
    assert page.locator(".reading:visible").count() == 0


def test_a_part_in_which_a_curve_turns_seldom_shows_the_curve(show):
    page = show("shaken_pendulum")
    faint = """[...document.querySelectorAll('#inputs-over-time .of-curve')]
      .map((element) => element.style.getPropertyValue('--opacity')).join()"""
    assert page.evaluate(faint) == "0.5"
    page.get_by_role("region", name="Inputs").get_by_role("button", name="Enlarge").click()
    page.locator("#inputs-over-time .chart").focus()
    for _ in range(3):
        page.keyboard.press("+")
    assert page.evaluate(faint) == "1"
    page.keyboard.press("Escape")
    page.keyboard.press("Escape")
    until(page, f"({faint}) === '0.5'")
