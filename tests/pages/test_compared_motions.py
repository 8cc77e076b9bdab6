"""Motions for comparison with the present one: the motion before a change, and pinned, named motions."""

# Tests: pages/browser/explore/compared_motions.js

import itertools
import re

import matplotlib as mpl
import numpy as np
import pytest

from chain_impact import simulate
from tests.pages.in_pages import ADVANCE_CLOCK, DESK, PHONE, PIXELS, impacts_of, resize, until, until_text
from tests.pages.javascript import function_of
from tests.tiers import needs_browser

pytestmark = needs_browser
LETTERS = function_of("compared_motions", "letters")
"""The letters that are written into each chart when it has another width."""
AXES = (("x", "width"), ("y", "height"))
ENERGIES = ("kinetic", "potential", "elastic", "dissipated", "friction", "supplied")


def test_the_motion_before_a_change_is_drawn_behind_and_pinned_ones_stay(show):
    page = show()
    assert page.locator(".compared").count() == 0
    for value in (0.4, 0.6):
        page.get_by_role("button", name="Pin").click()
        page.evaluate(f"chainImpact.show({{'contact.restitution': {value}}})")
        until_text(page, impacts_of({"contact.restitution": value}))
        page.evaluate(ADVANCE_CLOCK)  # changes at shorter intervals are merged into one change
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
        page.evaluate(ADVANCE_CLOCK)
        page.evaluate(f"chainImpact.show({{'contact.restitution': {value}}})")
        until_text(page, impacts_of({"contact.restitution": value}, "pinned_arm"))
        until(page, "document.getElementById('stage').ariaBusy === 'false'")
    page.get_by_role("button", name="Go to impact 1, ").click()
    until(page, "document.getElementById('time').textContent.startsWith('0.49')")
    scene = page.locator("#scene").bounding_box()
    dots = [dot.bounding_box() for dot in page.locator(".compared-tip:not(.before)").all()]
    assert len(dots) == 5
    for dot in dots:
        for at, size in AXES:
            assert scene[at] - 0.5 <= dot[at] <= scene[at] + scene[size] - dot[size] + 0.5
    for first, second in itertools.combinations(dots, 2):
        assert np.hypot(first["x"] - second["x"], first["y"] - second["y"]) > 14.0


def test_after_a_refused_start_no_pin_tells_a_change_and_the_clock_no_rate(show):
    page = show()
    page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'contact.restitution': 0.45})")
    change = page.locator("#pins tbody tr:nth-child(2) td:nth-child(3) small")
    page.get_by_role("radio", name="Compare with present").check()
    percent = re.compile(r"^[+−][\d.]+\u202f%$")
    change.filter(has_text=percent).wait_for()
    assert page.locator("#rate").is_visible()
    page.evaluate("chainImpact.show({'box.y_min': 1.5})")
    until(page, "document.body.classList.contains('stale')")
    change.filter(has_text=re.compile(r"^–$")).wait_for()
    assert not page.locator("#rate").is_visible()
    words = (
        "[...document.querySelectorAll('aside .chart, #impacts')].filter((part) => part.checkVisibility())"
    )
    content = "(part) => getComputedStyle(part, '::before').content"
    assert set(page.evaluate(f"{words}.map({content})")) == {'"no motion"'}
    page.get_by_role("button", name="Undo the change of Position of the floor").click()
    change.filter(has_text=percent).wait_for()
    assert page.locator("#rate").is_visible()


def test_letters_of_pins_at_one_place_are_beside_each_other(show):
    page = show()
    for value in (0.4, 0.6):
        page.get_by_role("button", name="Pin").click()
        page.evaluate(f"chainImpact.show({{'contact.restitution': {value}}})")
        until_text(page, impacts_of({"contact.restitution": value}))
    until(page, "document.getElementById('stage').ariaBusy === 'false'")
    page.locator("#scrub").fill("0")
    until(page, "document.getElementById('time').textContent === '0.00000 s'")
    assert page.locator(".compared-tip ~ polyline.compared").count() == 0, "letters lie above all lines"
    dots = [dot.bounding_box() for dot in page.locator(".compared-tip:not(.before), #scene .tip").all()]
    assert len(dots) == 3
    for first, second in itertools.combinations(dots, 2):
        assert np.hypot(first["x"] - second["x"], first["y"] - second["y"]) > 14.0, "the letter's dot is free"
    numbers = [number.bounding_box() for number in page.locator(".point-number").all()]
    for dot, number in itertools.product(dots, numbers):
        distances = [abs(2 * dot[at] + dot[size] - 2 * number[at] - number[size]) for at, size in AXES]
        room = [dot[size] + number[size] for _, size in AXES]
        assert distances[0] > room[0] or distances[1] > room[1], "no number lies on a letter"


def test_a_carriage_has_one_size_in_all_motions(show):
    page = show("cart_pole")
    page.evaluate("chainImpact.show({'link[1].length': 0.9})")
    until(page, "document.querySelectorAll('polygon.compared').length === 1")
    widths = page.evaluate(
        "['polygon.compared', '.carriage'].map((name) => document.querySelector(name).getBBox().width)"
    )
    assert widths[0] == pytest.approx(widths[1], rel=1e-6)


def test_a_ball_has_its_size_in_all_motions(show):
    page = show("golf_ball", {"contact.radius": 0.0213, "initial.y": 0.8213})
    page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'contact.restitution': 0.7})")
    until(page, "document.querySelectorAll('circle.compared').length === 1")
    sizes = page.evaluate(
        "['.compared', '.disc'].map((name) => document.querySelector(`circle${name}`).r.baseVal.value)"
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
        until_text(page, impacts_of({"contact.restitution": value}))
    assert page.locator("#energies dd.of-curve").all_text_contents() == ["A", "B"]
    boxes = {
        name: page.locator(name).bounding_box() for name in ("#energy .uplot", "#energies", *BESIDE_PINS)
    }
    assert boxes["#energy .uplot"]["y"] + boxes["#energy .uplot"]["height"] <= boxes["#energies"]["y"]
    assert_beside(boxes)
    bottom = page.locator("#impacts").evaluate("list => list.getBoundingClientRect().bottom")
    rows = [row.bounding_box() for row in page.locator("#impacts tbody tr").all()[:5]]
    assert all(row["y"] + row["height"] <= bottom + 0.5 < boxes["footer"]["y"] for row in rows)
    heights = "charts => charts.map((element) => element.clientHeight)"
    assert min(page.locator("aside .chart .u-over").evaluate_all(heights)) >= 110


def test_the_names_of_outputs_are_whole_beside_many_pins(show):
    page = show(hash_="#curves=contact[2].y_min.force", viewport=DESK)
    for value in (0.4, 0.5, 0.55, 0.6):
        page.get_by_role("button", name="Pin").click()
        page.evaluate(f"chainImpact.show({{'contact.restitution': {value}}})")
        until_text(page, impacts_of({"contact.restitution": value}))
    terms = page.locator("#outputs-over-time .of-curve")
    assert terms.all_inner_texts() == ["A", "B", "C", "D", "point 2 at the floor"]
    assert terms.last.bounding_box()["height"] < 20.0, "one line"


def test_five_pins_and_the_legend_of_energies_are_in_sight(show):
    page = show()
    for value in (0.4, 0.5, 0.55, 0.6, 0.65):
        page.get_by_role("button", name="Pin").click()
        page.evaluate(f"chainImpact.show({{'contact.restitution': {value}}})")
        until_text(page, impacts_of({"contact.restitution": value}))
    assert page.locator("#pins tbody tr").count() == 6
    for height in (768, 800):
        resize(page, 1366, height)
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


def test_pins_have_colours_of_their_own(show):
    page = show()
    names = [*(f"pin-{k}" for k in range(1, 6)), *ENERGIES, "total", "chain", "tip"]
    values = "names.map((name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`))"
    for scheme in ("light", "dark"):
        page.emulate_media(color_scheme=scheme)
        texts = page.evaluate(f"names => {values}", names)
        colours = [np.array(mpl.colors.to_rgb(text.strip())) for text in texts]
        for first, second in itertools.combinations(range(len(colours)), 2):
            if first < 5:
                assert abs(colours[first] - colours[second]).sum() > 0.3, (
                    scheme,
                    names[first],
                    names[second],
                )


OUTSIDE = function_of("compared_motions", "outside")
"""Number of points of the present and of the compared motions outside of the drawing."""


def test_the_view_holds_the_motions_that_are_compared(show):
    page = show("thrown_brick")
    page.evaluate("chainImpact.show({'initial.vy': 12})")  # much higher than the motion that follows
    until_text(page, impacts_of({"initial.vy": 12}, "thrown_brick"))
    page.get_by_role("button", name="Pin").click()
    for height in (0.3, 0.25):
        page.evaluate(ADVANCE_CLOCK)
        page.evaluate(f"chainImpact.show({{'initial.vy': 0, 'initial.y': {height}}})")
        until_text(page, impacts_of({"initial.vy": 0, "initial.y": height}, "thrown_brick"))
        page.locator("#scrub").fill("1.2")  # s, near the top of the flight
        page.wait_for_function("document.getElementById('time').textContent === '1.20000 s'")
        assert page.evaluate(OUTSIDE) == 0


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
    until_text(page, "3 links")
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Chart…").click()
    page.get_by_text("By names").click()
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


def test_pins_are_named_by_the_changes_in_which_they_differ(show):
    page = show(hash_="#contact.restitution=0.4&contact.stiffness=1e6&gravity.y=-9.5")
    page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'contact.stiffness': 1e7, 'solver.tolerance': 1e-7})")
    until(page, "document.querySelector('.pin-text').textContent.includes('1e7')")
    names = page.locator(".pin-text")
    assert names.all_inner_texts() == [
        "present: Stiffness = 1e7\u202fN/m¹·⁵, Solver tolerance = 1e-7",
        "Stiffness = 1e6\u202fN/m¹·⁵, Solver tolerance = 1e-8",
    ]
    for size in (PHONE, DESK):
        resize(page, **size)
        assert names.evaluate_all(
            "all => all.every((element) => element.scrollWidth <= element.clientWidth)"
        ), size
        assert names.evaluate_all(
            "all => all.every((element) => element.scrollHeight <= element.clientHeight + 1)"
        ), size
        assert page.locator("#pins").evaluate("list => list.scrollWidth <= list.clientWidth"), "no cut column"
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


def test_a_pin_has_the_name_that_the_reader_gives_it_also_in_a_link(show):
    page = show()
    page.get_by_role("button", name="Pin").click()
    page.get_by_title("Give this pin a name").click()
    field = page.get_by_role("textbox", name="Name of this pin")
    for text, key, expected in (
        ("hard wall: 1", "Enter", "hard wall: 1"),
        ("another", "Escape", "hard wall: 1"),
    ):
        field.fill(text)
        field.press(key)
        page.locator("#pins .pin-name").get_by_text(expected, exact=True).click()
    field.press("Escape")
    until(page, "location.hash.includes('hard')")
    second_page = show(hash_=page.evaluate("location.hash"))
    second_page.locator("#pins .pin-name").get_by_text("hard wall: 1", exact=True).wait_for()
    second_page.get_by_title("Give this pin a name").click()
    second_page.get_by_role("textbox", name="Name of this pin").fill("")
    second_page.keyboard.press("Enter")
    second_page.locator("#pins .pin-name").get_by_text("as in the scene").wait_for()


def test_a_motion_is_pinned_once(show):
    page = show()
    pin, note = page.get_by_role("button", name="Pin", exact=True), page.locator("#pin-equal")
    pin.click()
    until(page, "document.querySelectorAll('#pin-table tbody tr').length === 2")
    for value in (0.4, 0.7):
        page.evaluate(f"chainImpact.show({{'contact.restitution': {value}}})")
        until_text(page, impacts_of({"contact.restitution": value}))
    assert not note.is_visible()
    pin.click()
    assert "same as pin A" in note.inner_text()
    assert page.locator("#pin-table tbody tr").count() == 2
