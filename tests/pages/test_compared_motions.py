"""Motions beside the present motion: the motion before a change, and pinned motions with their impacts."""

# Tests: pages/browser/explore/compared_motions.js, pages/browser/explore/compared_table.js
# Tests: pages/browser/recording/partners.js, pages/browser/charts/letters.js
# Tests: pages/browser/charts/contact_course.js

import itertools
import operator
import re

import matplotlib as mpl
import numpy as np
import pytest

from chain_impact import load_scene, simulate
from tests.pages.in_pages import DESK, PHONE, PIXELS, ROWS, impacts_of, until, until_told
from tests.pages.javascript import function_of
from tests.tiers import needs_browser

pytestmark = needs_browser
LATER = "performance.now = ((now) => () => now() + 900)(performance.now.bind(performance))"  # by 900 ms
LETTERS = function_of("compared_motions", "letters")
"""The letters that are written into each chart when it has another width."""
AXES = (("x", "width"), ("y", "height"))
BELOW_PEAK = 30
"""The pixels at the top of the chart that have the number of the peak, not the curve."""
SECONDS = {"s": 1.0, "ms": 1e-3, "µs": 1e-6, "ns": 1e-9}
FIRST = operator.itemgetter(0)
ENERGIES = ("kinetic", "potential", "elastic", "dissipated", "friction", "supplied")


def test_the_motion_before_a_change_is_drawn_behind_and_pinned_ones_stay(show):
    page = show()
    assert page.locator(".compared").count() == 0
    for value in (0.4, 0.6):
        page.get_by_role("button", name="Pin").click()
        page.evaluate(f"chainImpact.show({{'contact.restitution': {value}}})")
        until_told(page, impacts_of({"contact.restitution": value}))
        page.evaluate(LATER)  # changes at shorter intervals are merged into one change
    assert page.locator("polyline.compared").count() == 2, "the motion before the last change is pinned"
    for chart in ("energy", "force"):
        assert page.evaluate(PIXELS, [chart, "pin-2"]) > 20
    assert page.evaluate(LETTERS) == {"energy": ["A", "B"], "force": ["A", "B"]}
    page.get_by_role("button", name="F(δ)").click()
    assert page.evaluate(PIXELS, ["force", "pin-2"]) > 20
    rows = page.locator("#pins tbody tr").all_inner_texts()
    for row, text in zip(rows, ("present", "as in the scene", "Restitution = 0.4"), strict=True):
        assert text in row
    end = simulate("four_link_box")["energy.total"][-1]
    assert f"{end:.2f}\u202fJ" in rows[1]
    page.locator(".unpin").first.click()
    until(page, "document.querySelectorAll('#pins tbody tr').length === 2")
    for _ in range(2):  # a motion is pinned once
        page.get_by_role("button", name="Pin").click()
    assert page.locator("#pins tbody tr").count() == 3


def test_letters_of_five_pins_beside_a_wall_stay_in_the_scene(show):
    page = show("pinned_arm")
    for value in (0.3, 0.4, 0.5, 0.7, 0.8):
        page.get_by_role("button", name="Pin").click()
        page.evaluate(LATER)
        page.evaluate(f"chainImpact.show({{'contact.restitution': {value}}})")
        until_told(page, impacts_of({"contact.restitution": value}, "pinned_arm"))
        until(page, "document.getElementById('stage').ariaBusy === 'false'")
    page.get_by_role("button", name="Go to impact 1, ").click()
    until(page, "document.getElementById('time').textContent.startsWith('0.49')")
    scene = page.locator("#scene").bounding_box()
    dots = [one.bounding_box() for one in page.locator(".compared-tip:not(.before)").all()]
    assert len(dots) == 5
    for dot in dots:
        for at, size in AXES:
            assert scene[at] - 0.5 <= dot[at] <= scene[at] + scene[size] - dot[size] + 0.5
    for one, other in itertools.combinations(dots, 2):
        assert np.hypot(one["x"] - other["x"], one["y"] - other["y"]) > 14.0


def test_after_a_refused_start_no_pin_tells_a_change_and_the_clock_no_rate(show):
    page = show()
    page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'contact.restitution': 0.45})")
    change = page.locator("#pins tbody tr:nth-child(2) td:nth-child(3) small")
    percent = re.compile(r"^[+−][\d.]+\u202f%$")
    change.filter(has_text=percent).wait_for()
    assert page.locator("#rate").is_visible()
    page.evaluate("chainImpact.show({'box.y_min': 1.5})")
    until(page, "document.body.classList.contains('stale')")
    change.filter(has_text=re.compile(r"^–$")).wait_for()
    assert not page.locator("#rate").is_visible()
    page.get_by_role("button", name="Undo the change of Position of the floor").click()
    change.filter(has_text=percent).wait_for()
    assert page.locator("#rate").is_visible()


def alike(impacts, impact):
    """Return the numbers of the impacts of one point and wall."""
    return [
        k for k in range(len(impacts)) if all(impacts[key][k] == impact[key] for key in ("point", "wall"))
    ]


def partners(present, other):
    """Return for each impact the other one of its point and wall, if time and order are near."""

    def nearest(impact, impacts):
        return min(
            alike(impacts, impact), key=lambda k: abs(impacts["onset"][k] - impact["onset"]), default=None
        )

    def is_pair(n, k):
        if k is None or nearest(other[k], present) != n:
            return False
        order = alike(present, present[n]).index(n) - alike(other, other[k]).index(k)
        onsets = sorted((present["onset"][n], other["onset"][k]))
        return abs(order) <= 1 and onsets[1] <= 1.1 * onsets[0]

    found = [nearest(impact, other) for impact in present]
    return [k if is_pair(n, k) else None for n, k in enumerate(found)]


def test_pins_tell_the_change_of_the_largest_force_and_align_impacts(show):
    page = show()
    page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'contact.restitution': 0.5})")
    scene = load_scene("four_link_box")
    runs = [simulate(scene.with_values({"contact.restitution": e})) for e in (0.5, 0.7)]
    until_told(page, f"{len(runs[0].impacts)} impact")
    rows = page.locator("#pins tbody tr").all()
    assert "present: Restitution = 0.5" in rows[0].inner_text()
    peaks = [run.impacts["peak_force"].max() for run in runs]
    largest = [f"{peak / 1e3:.1f}\u202fkN" for peak in peaks]
    told = [row.locator("td").nth(1) for row in rows]
    changes = [cell.locator("small").inner_text() for cell in told]
    assert [cell.text_content() for cell in told] == [
        force + change for force, change in zip(largest, changes, strict=True)
    ]
    assert changes[0] == ""
    percent = float(changes[1].removesuffix("\u202f%").replace("\u2212", "-"))
    assert percent == pytest.approx(100 * (peaks[0] / peaks[1] - 1), abs=0.5)
    present, pinned = (run.impacts for run in runs)
    expected = partners(present, pinned)
    assert any(k is None for k in expected)
    assert any(k not in (None, n) for n, k in enumerate(expected))
    page.get_by_role("button", name="Impact by impact…").click()
    pairs = [(present["onset"][n], n, k) for n, k in enumerate(expected)]
    pairs += [(pinned["onset"][k], None, k) for k in range(len(pinned)) if k not in expected]
    shown = sorted(pairs, key=FIRST)
    table = page.locator("#pairs tbody tr").all()
    numbers = [row.locator("td").first.inner_text() for row in table]
    assert numbers == ["" if n is None else str(n + 1) for _, n, _ in shown]
    cells = [row.locator("td").last.inner_text() for row in table]
    greys = [row.locator("td").last.get_attribute("class") == "doubtful" for row in table]
    for cell, is_grey, (_, n, k) in zip(cells, greys, shown, strict=True):
        assert cell.startswith("–") if k is None else f"{pinned['onset'][k]:.4f}" in cell
        if None in (n, k):
            continue
        gap = present["onset"][n] - pinned["onset"][k]
        change = 100 * (present["peak_force"][n] / pinned["peak_force"][k] - 1)
        time, unit, percent = re.search(
            r"→ now ([+−]?[\d.]+)\u202f(\w+), ([+−]?[\d.]+)\u202f%", cell
        ).groups()
        told = [float(text.replace("\u2212", "-")) for text in (time, percent)]
        assert told == pytest.approx([gap / SECONDS[unit], change], rel=0.05, abs=0.06)
        is_other = alike(present, present[n]).index(n) != alike(pinned, pinned[k]).index(k)
        assert is_grey == (is_other or abs(gap) > 0.03 * min(present["onset"][n], pinned["onset"][k]))
    page.keyboard.press("Escape")
    is_clear = [
        k is None
        or abs(present["onset"][n] / pinned["onset"][k] - 1) > 0.01
        or abs(present["peak_force"][n] / pinned["peak_force"][k] - 1) > 0.01
        for _, n, k in shown
        if n is not None
    ]
    assert rows[1].locator("td").nth(3).inner_text() == f"impact {is_clear.index(True) + 1}"
    heads = page.locator("#pins thead th").all_inner_texts()
    assert heads[-2:] == ["Δ time", "Δ peak"]
    assert "Δ: from pin to present" in heads[0]
    counts = f"{len(pinned)} → {len(present)}"
    assert page.inner_text("#impacts-before") == f"from A: {counts}, {largest[1]} → {largest[0]}"


def test_each_impact_of_each_pin_has_one_cell(show):
    page = show(hash_="#contact.restitution=0.7")
    for value in (0.8, 0.6, 0.75):
        page.get_by_role("button", name="Pin").click()
        page.evaluate(LATER)
        page.evaluate(f"chainImpact.show({{'contact.restitution': {value}}})")
        until_told(page, impacts_of({"contact.restitution": value}))
    page.get_by_role("button", name="Impact by impact…").click()
    rows = [row.locator("td").all_inner_texts()[1:] for row in page.locator("#pairs tbody tr").all()]
    for value, column in zip((0.75, 0.7, 0.8, 0.6), zip(*rows, strict=True), strict=True):
        run = simulate(load_scene("four_link_box").with_values({"contact.restitution": value}))
        told = [re.search(r"(\d\.\d{4})\u202fs", text)[1] for text in column if not text.startswith("–")]
        assert sorted(told) == [f"{onset:.4f}" for onset in run.impacts["onset"]]
    lacking = [[cell.startswith("–") for cell in row] for row in rows]
    assert any(one[0] and one.count(False) > 1 for one in lacking), "partners of two pins share a row"


def test_letters_of_pins_at_one_place_are_beside_each_other(show):
    page = show()
    for value in (0.4, 0.6):
        page.get_by_role("button", name="Pin").click()
        page.evaluate(f"chainImpact.show({{'contact.restitution': {value}}})")
        until_told(page, impacts_of({"contact.restitution": value}))
    until(page, "document.getElementById('stage').ariaBusy === 'false'")
    page.locator("#scrub").fill("0")
    until(page, "document.getElementById('time').textContent === '0.00000 s'")
    assert page.locator(".compared-tip ~ polyline.compared").count() == 0, "letters lie above all lines"
    dots = [one.bounding_box() for one in page.locator(".compared-tip:not(.before), #scene .tip").all()]
    assert len(dots) == 3
    for one, other in itertools.combinations(dots, 2):
        assert np.hypot(one["x"] - other["x"], one["y"] - other["y"]) > 14.0, "the letter's dot is free"
    numbers = [one.bounding_box() for one in page.locator(".point-number").all()]
    for dot, number in itertools.product(dots, numbers):
        apart = [abs(2 * dot[at] + dot[size] - 2 * number[at] - number[size]) for at, size in AXES]
        room = [dot[size] + number[size] for _, size in AXES]
        assert apart[0] > room[0] or apart[1] > room[1], "no number lies on a letter"


def test_a_carriage_has_one_size_in_all_motions(show):
    page = show("cart_pole")
    page.evaluate("chainImpact.show({'link[1].length': 0.9})")
    until(page, "document.querySelectorAll('polygon.compared').length === 1")
    widths = page.evaluate(
        "['polygon.compared', '.carriage'].map((one) => document.querySelector(one).getBBox().width)"
    )
    assert widths[0] == pytest.approx(widths[1], rel=1e-6)


def test_a_ball_has_its_size_in_all_motions(show):
    page = show("golf_ball", {"contact.radius": 0.0213, "initial.y": 0.8213})
    page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'contact.restitution': 0.7})")
    until(page, "document.querySelectorAll('circle.compared').length === 1")
    sizes = page.evaluate(
        "['.compared', '.disc'].map((one) => document.querySelector(`circle${one}`).r.baseVal.value)"
    )
    assert sizes[0] == pytest.approx(sizes[1])
    assert sizes[0] > 8.0


BESIDE_PINS = ("#list", "#pins", "footer")


def assert_beside(boxes):
    """Assert that the list of impacts is at the right of the pins, and above the controls."""
    assert boxes["#pins"]["x"] + boxes["#pins"]["width"] < boxes["#list"]["x"]
    assert boxes["#list"]["y"] + boxes["#list"]["height"] < boxes["footer"]["y"]


def test_two_pins_leave_the_list_of_impacts_in_sight(show):
    page = show(viewport={"width": 1366, "height": 768})
    for value in (0.4, 0.6):
        page.get_by_role("button", name="Pin").click()
        page.evaluate(f"chainImpact.show({{'contact.restitution': {value}}})")
        until_told(page, impacts_of({"contact.restitution": value}))
    assert page.locator("#energies dd.of-curve").all_text_contents() == ["A", "B"]
    boxes = {
        name: page.locator(name).bounding_box() for name in ("#energy .uplot", "#energies", *BESIDE_PINS)
    }
    assert boxes["#energy .uplot"]["y"] + boxes["#energy .uplot"]["height"] <= boxes["#energies"]["y"]
    assert_beside(boxes)
    bottom = page.locator("#impacts").evaluate("list => list.getBoundingClientRect().bottom")
    rows = [row.bounding_box() for row in page.locator("#impacts tbody tr").all()[:5]]
    assert all(row["y"] + row["height"] <= bottom + 0.5 < boxes["footer"]["y"] for row in rows)
    heights = "charts => charts.map((one) => one.clientHeight)"
    assert min(page.locator("aside .chart .u-over").evaluate_all(heights)) >= 110


def test_the_names_of_outputs_are_whole_beside_many_pins(show):
    page = show(hash_="#curves=contact[2].y_min.force", viewport=DESK)
    for value in (0.4, 0.5, 0.55, 0.6):
        page.get_by_role("button", name="Pin").click()
        page.evaluate(f"chainImpact.show({{'contact.restitution': {value}}})")
        until_told(page, impacts_of({"contact.restitution": value}))
    terms = page.locator("#outputs-over-time .of-curve")
    assert terms.all_inner_texts() == ["A", "B", "C", "D", "contact[2].y_min.force"]
    assert terms.last.bounding_box()["height"] < 20.0, "one line"


@pytest.mark.parametrize("height", [768, 800])
def test_five_pins_and_the_legend_of_energies_are_in_sight(show, height):
    page = show(viewport={"width": 1366, "height": height})
    for value in (0.4, 0.5, 0.55, 0.6, 0.65):
        page.get_by_role("button", name="Pin").click()
        page.evaluate(f"chainImpact.show({{'contact.restitution': {value}}})")
        until_told(page, impacts_of({"contact.restitution": value}))
    assert page.locator("#pins tbody tr").count() == 6
    assert page.locator("#pins").evaluate("list => list.scrollHeight <= list.clientHeight")
    boxes = {name: page.locator(name).bounding_box() for name in ("#energies", *BESIDE_PINS)}
    assert boxes["#energies"]["y"] + boxes["#energies"]["height"] <= boxes["#list"]["y"]
    assert_beside(boxes)


@pytest.mark.parametrize("size", [PHONE, {"width": 1000, "height": 700}], ids=["phone", "tablet"])
def test_a_pin_is_in_sight_at_once(show, size):
    page = show(viewport=size)
    page.get_by_role("button", name="Pin").click()
    box = page.locator("#pins").bounding_box()
    assert box["y"] >= 0
    assert box["y"] + box["height"] < page.locator("footer").bounding_box()["y"]


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_pins_have_colours_of_their_own(show, scheme):
    page = show(color_scheme=scheme)
    names = [*(f"pin-{k}" for k in range(1, 6)), *ENERGIES, "total", "chain", "tip"]
    style = "getComputedStyle(document.documentElement)"
    found = page.evaluate(f"names => names.map((name) => {style}.getPropertyValue(`--${{name}}`))", names)
    colours = [np.array(mpl.colors.to_rgb(one.strip())) for one in found]
    for one, other in itertools.combinations(range(len(colours)), 2):
        if one < 5:
            assert abs(colours[one] - colours[other]).sum() > 0.3, (names[one], names[other])


OUTSIDE = function_of("compared_motions", "outside")
"""Number of points of the present and of the compared motions outside of the drawing."""


def test_the_view_holds_the_motions_that_are_compared(show):
    page = show("thrown_brick")
    page.evaluate("chainImpact.show({'initial.vy': 12})")  # much higher than the motion that follows
    until_told(page, impacts_of({"initial.vy": 12}, "thrown_brick"))
    page.get_by_role("button", name="Pin").click()
    for height in (0.3, 0.25):
        page.evaluate(LATER)
        page.evaluate(f"chainImpact.show({{'initial.vy': 0, 'initial.y': {height}}})")
        until_told(page, impacts_of({"initial.vy": 0, "initial.y": height}, "thrown_brick"))
        page.locator("#scrub").fill("1.2")  # s, near the top of the flight
        page.wait_for_function("document.getElementById('time').textContent === '1.20000 s'")
        assert page.evaluate(OUTSIDE) == 0


def test_a_chart_of_force_tells_why_it_has_no_curve_of_a_pin(show):
    page, changes = show(), {"contact.restitution": 0.4}
    first, other = (simulate(load_scene("four_link_box").with_values(one)).impacts for one in ({}, changes))
    expected = [k is not None for k in partners(other, first)]
    page.get_by_role("button", name="Pin").click()
    page.evaluate("changes => chainImpact.show(changes)", changes)
    until_told(page, impacts_of(changes))
    for number in (expected.index(True) + 1, expected.index(False) + 1):
        page.get_by_role("button", name=f"Go to impact {number}, ").click()
        until(page, f"document.getElementById('contact-name').textContent.startsWith('impact {number}: ')")
        assert (page.evaluate(PIXELS, ["force", "pin-1"]) > 20) is expected[number - 1]
        assert ("; A: " not in page.text_content("#contact-name")) is expected[number - 1]
        assert page.locator("#contact-name").evaluate("one => one.scrollWidth <= one.clientWidth"), (
            "it is not cut off"
        )


def test_a_chart_with_curves_of_pins_alone_is_titled_by_their_letters(show):
    """The letters of pins without a curve at an impact stand together before their common reason."""
    page = show()
    for changes in ({"contact.restitution": 0.4}, {"contact.restitution": 0.2}):
        page.evaluate("changes => chainImpact.show(changes)", changes)
        until_told(page, impacts_of(changes))
        page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'contact.model': 'newton_impact'})")
    until_told(page, impacts_of({"contact.model": "newton_impact", "contact.restitution": 0.2}))
    assert page.inner_text("#contact-quantity") == "Contact force of A, B"
    name = page.text_content("#contact-name")
    assert "N·s, present: an impulse only" in name
    assert "no force over time is known" not in name
    names = set()
    for number in range(1, 15):
        page.get_by_role("button", name=f"Go to impact {number}, ").click()
        until(page, f"document.getElementById('contact-name').textContent.startsWith('impact {number}: ')")
        names.add(page.text_content("#contact-name").partition("; ")[2])
    assert "A, B: no such impact near" in names
    assert "A: no such impact near; B: no such impact near" not in names


def test_the_card_of_the_force_stays_at_a_stop_with_impulses_alone(show):
    page = show("kneed_leg", {"stop.restitution": 0.5})
    assert page.text_content("#contact-name").startswith(
        "impact 1: joint 3 at max (point 2), 6.35\u202fmN·m·s, "
    )
    assert page.locator("#contact").is_visible()


def test_a_stiff_pin_does_not_flatten_the_curve_of_the_present_contact(show):
    page = show("rod_drop", hash_="#contact.stiffness=1e8")
    page.get_by_role("button", name="Pin").click()
    for stiffness, is_cut in ((3e7, False), (1e6, True)):
        page.evaluate("value => chainImpact.show({'contact.stiffness': value})", stiffness)
        until_told(page, impacts_of({"contact.stiffness": stiffness}, "rod_drop"))
        rows = [row for row in page.evaluate(ROWS, ["force", "force"]) if row > BELOW_PEAK]
        height = page.evaluate("document.querySelector('#force canvas').height")
        assert max(rows) - min(rows) > 0.25 * height
        assert page.evaluate(PIXELS, ["force", "pin-1"]) > 20
        peak = simulate(load_scene("rod_drop").with_values({"contact.stiffness": 1e8})).impacts["peak_force"][
            0
        ]
        told = f"; A: up to {peak / 1e3:.2f}\u202fkN"
        assert page.text_content("#contact-name").endswith(told) is is_cut
        page.get_by_role("button", name="F(δ)").click()
        assert page.text_content("#contact-name").endswith(told) is is_cut
        page.get_by_role("button", name="F(δ)").click()


def test_an_axis_of_square_roots_holds_a_far_higher_pin(show, script):
    page = show("rod_drop", hash_="#contact.stiffness=1e8")
    page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'contact.stiffness': 1e6})")
    until_told(page, impacts_of({"contact.stiffness": 1e6}, "rod_drop"))
    assert page.inner_text("#contact-quantity") == "Contact force (square roots)"
    rows = [page.evaluate(ROWS, ["force", name]) for name in ("pin-1", "force")]
    top, peak = (min(row for row in some if row > BELOW_PEAK - 10) for some in rows)
    bottom = max(rows[1])
    scenes = [load_scene("rod_drop").with_values({"contact.stiffness": k}) for k in (1e8, 1e6)]
    peaks = [simulate(scene).impacts["peak_force"][0] for scene in scenes]
    assert (bottom - top) / (bottom - peak) == pytest.approx(np.sqrt(peaks[0] / peaks[1]), rel=0.1)
    ticks = script.evaluate("([...of]) => rootTicks(...of)", [{"height": 140}, 2100.0])
    assert ticks == [0, 100, 500, 1000, 2000]


def test_letters_stand_where_their_curve_is_far_from_others(script):
    """A leaves the present curve at the right, and B is far from it; C is nowhere."""
    box = {"left": 0, "top": 0, "width": 300, "height": 100}
    own = [[[0, 90], [300, 90]]]
    courses = {"A": [[0, 90], [200, 90], [300, 60]], "B": [[0, 50], [300, 50]], "C": [[0, 90], [300, 90]]}
    compared = [{"letter": letter, "course": course} for letter, course in courses.items()]
    find = "([...of]) => letterPositions(...of, [], {box}, 1)".replace("{box}", str(box))
    a, b, c = script.evaluate(find, [compared, own])
    assert a[0] > 250
    assert b[1] == 50
    assert abs(b[0] - 0.29 * 300) < 30, "equally good places are at different times for different letters"
    assert abs(c[0] - a[0]) > 15


def test_a_chart_of_inputs_tells_why_it_has_no_curve_of_a_pin(show):
    page = show("pinned_arm")
    page.get_by_role("button", name="Pin").click()
    page.evaluate("location.hash = '#joint[1].torque@=0.1:5'")
    page.locator("#inputs-note").get_by_text("curves of A:").wait_for()
    page.get_by_role("button", name="Pin").click()
    page.locator(".unpin").first.click()
    page.locator("#inputs-note").wait_for(state="hidden")


def test_pins_get_outputs_that_are_chosen_later_but_not_of_another_scene(show):
    page = show()
    page.get_by_role("button", name="Pin").click()
    page.evaluate("location.hash = '#curves=point[4].y&contact.restitution=0.4'")
    note = page.locator("#outputs-note")
    page.locator("#outputs-over-time canvas").wait_for()
    note.wait_for(state="hidden")
    assert page.evaluate(PIXELS, ["outputs-over-time", "pin-1"]) > 20
    page.get_by_role("button", name="Edit…").click()
    page.get_by_role("button", name="Remove link 3").click()
    until_told(page, "3 links")
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Chart…").click()
    page.locator("#curves-names").fill("link[1].angle")
    page.keyboard.press("Enter")
    page.keyboard.press("Escape")
    note.get_by_text("curves of A:").wait_for()
    page.locator(".unpin").click()
    note.wait_for(state="hidden")


def test_a_phone_has_room_for_the_change_that_names_a_pin(show):
    page = show(hash_="#contact.restitution=0.35", viewport=PHONE)
    page.get_by_role("button", name="Pin").click()
    name = page.locator(".pin-text").last
    assert name.inner_text() == "Restitution = 0.35"
    assert name.evaluate("name => name.scrollWidth <= name.clientWidth")


@pytest.mark.parametrize("size", [DESK, PHONE], ids=["desk", "phone"])
def test_pins_are_named_by_the_changes_in_which_they_differ(show, size):
    page = show(hash_="#contact.restitution=0.4&contact.stiffness=1e6&gravity.y=-9.5", viewport=size)
    page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'contact.stiffness': 1e7, 'solver.tolerance': 1e-7})")
    until(page, "document.querySelector('.pin-text').textContent.includes('1e7')")
    names = page.locator(".pin-text")
    assert names.all_inner_texts() == [
        "present: Stiffness = 1e7\u202fN/m¹·⁵, Solver tolerance = 1e-7",
        "Stiffness = 1e6\u202fN/m¹·⁵, Solver tolerance = 1e-8",
    ]
    assert names.evaluate_all("all => all.every((one) => one.scrollWidth <= one.clientWidth)")
    assert names.evaluate_all("all => all.every((one) => one.scrollHeight <= one.clientHeight + 1)")
    assert page.locator("#pins").evaluate("list => list.scrollWidth <= list.clientWidth"), "no column is cut"
    page.keyboard.press("Escape")
    page.evaluate("location.hash = '#'")
    until(page, "document.querySelector('.pin-text').textContent === 'present'")
    assert "Gravity, y = −9.5" in names.last.inner_text()


def test_what_differs_comes_first_in_the_names_of_pins(show):
    page = show()
    page.get_by_role("button", name="Pin").click()
    common = {"contact.restitution": 0.5, "contact.stiffness": 1e7, "gravity.y": -9.7}
    for mass in (1.5, 1.7):
        page.evaluate("changes => chainImpact.show(changes)", {**common, "link[1].mass": mass})
        until(page, f"document.querySelector('.pin-text').textContent.includes(' = {mass}')")
        page.get_by_role("button", name="Pin").click()
    names = page.locator(".pin-text").all_inner_texts()
    rest = ", Restitution = 0.5, Stiffness = 1e7\u202fN/m¹·⁵, Gravity, y = −9.7\u202fm/s²"
    assert names[1:] == [
        "as in the scene",
        *(f"Mass of link 1 = {mass}\u202fkg{rest}" for mass in (1.5, 1.7)),
    ]


def test_a_change_to_many_times_the_force_is_told_as_a_factor(show):
    page = show()
    page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'contact.stiffness': 1e11})")
    change = page.locator("#pins tbody tr:nth-child(2) td:nth-child(3) small")
    change.filter(has_text=re.compile(r"^×\u202f[1-9]\d(\.\d)?$")).wait_for()


def test_an_energy_of_round_off_is_0_in_the_summary(show):
    page = show("simple_pendulum")
    page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'gravity.y': -5})")
    until(page, "document.querySelector('.pin-text').textContent.includes('−5')")
    rows = [row.locator("td").all_text_contents() for row in page.locator("#pins tbody tr").all()]
    assert rows == [["0", "–", "0\u202fJ", "", "", ""], ["00", "–", "0\u202fJ0", "none", "", ""]]


def test_energies_of_the_summary_are_rounded_to_the_range_of_the_runs(show):
    """At the end the energy is −25 µJ, of 3.6 J at the start."""
    page = show("rod_drop", {"contact.restitution": 0.3})
    page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'contact.restitution': 0.8})")
    until(page, "document.querySelector('#pins tr:nth-child(2) td:nth-child(4) small').textContent !== '0'")
    cells = page.locator("#pins tbody td:nth-child(4)").all_text_contents()
    assert cells == ["0.071\u202fJ", "0.000\u202fJ+0.071\u202fJ"]


def test_forces_and_impulses_are_not_compared_and_angles_are_in_degrees(show):
    page = show()
    page.evaluate("chainImpact.show({'contact.model': 'newton_impact', 'initial.angle[2]': -2.16})")
    until(page, "/^[0-9]+ → [0-9]+$/.test(document.getElementById('impacts-before').textContent)")
    page.get_by_role("button", name="Pin").click()
    assert "Initial angle of link 2 = −123.76\u202f°" in page.locator(".pin-text").last.inner_text()


def test_a_pin_has_the_name_that_the_reader_gives_it_also_in_a_link(show):
    page = show()
    page.get_by_role("button", name="Pin").click()
    page.get_by_title("Give this pin a name").click()
    field = page.get_by_role("textbox", name="Name of this pin")
    for text, key, kept in (("hard wall: 1", "Enter", "hard wall: 1"), ("another", "Escape", "hard wall: 1")):
        field.fill(text)
        field.press(key)
        page.locator("#pins .pin-name").get_by_text(kept, exact=True).click()
    field.press("Escape")
    until(page, "location.hash.includes('hard')")
    other = show(hash_=page.evaluate("location.hash"))
    other.locator("#pins .pin-name").get_by_text("hard wall: 1", exact=True).wait_for()
    other.get_by_title("Give this pin a name").click()
    other.get_by_role("textbox", name="Name of this pin").fill("")
    other.keyboard.press("Enter")
    other.locator("#pins .pin-name").get_by_text("as in the scene").wait_for()


def test_a_motion_is_pinned_once(show):
    page = show()
    pin, told = page.get_by_role("button", name="Pin", exact=True), page.locator("#pin-equal")
    pin.click()
    until(page, "document.querySelectorAll('#pin-table tbody tr').length === 2")
    for value in (0.4, 0.7):
        page.evaluate(f"chainImpact.show({{'contact.restitution': {value}}})")
        until_told(page, impacts_of({"contact.restitution": value}))
    assert not told.is_visible()
    pin.click()
    assert "same as pin A" in told.inner_text()
    assert page.locator("#pin-table tbody tr").count() == 2
