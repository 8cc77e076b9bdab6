"""The simulating page shows correct values only, and reads input as its user intends."""

import itertools
import math
import re

import matplotlib as mpl
import numpy as np
import pytest

from chain_impact import simulate
from tests.pages.conftest import until, until_told
from tests.pages.test_in_browser import MAP, draw_map
from tests.tiers import needs_browser

pytestmark = needs_browser
ENERGIES = ("kinetic", "potential", "elastic", "dissipated", "friction", "supplied")


def test_angles_in_degrees_are_taken_in_every_field(show):
    page = show("rod_drop", MAP)
    page.evaluate("chainImpact.show({ 'initial.angle[1]': '20 deg' })")
    shown = "chainImpact.parameters['initial.angle[1]']"
    assert float(page.evaluate(shown)) == pytest.approx(math.radians(20.0), rel=1e-15)
    page.locator("#list-of-parameters summary").click()
    for name, text in (("initial.angle[1]", "-30deg"), ("initial.angular_velocity[1]", "90 deg/s")):
        field = page.locator(f"#list-of-parameters input[aria-label='{name}']")
        field.fill(text)
        field.press("Enter")
        number = math.radians(float(re.match(r"-?\d+", text)[0]))
        assert float(page.evaluate(f"chainImpact.parameters['{name}']")) == pytest.approx(number, rel=1e-15)
    field.fill("90 deg")  # a wrong unit for an angular velocity
    field.press("Enter")
    assert "must be a finite number" in page.locator(".parameter .refusal:not(:empty)").inner_text()
    page.get_by_role("button", name="Map…").click()
    page.locator("#map-y-from").fill("10 deg")
    page.locator("#map-y-to").fill("50 deg")
    draw_map(page)
    assert {"10", "50"} & set(page.locator("#map-scales text").all_text_contents())


def test_a_choice_that_is_none_is_answered_with_names(show):
    with pytest.raises(Exception, match=r"contact.model = foo must be one of hertz, hunt_crossley"):
        show().evaluate("chainImpact.show({ 'contact.model': 'foo' })")


def test_after_a_refusal_the_numbers_of_the_run_before_are_not_shown(show):
    page = show()
    page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({ 'box.y_min': 1.5 })")
    until_told(page, "a contact point starts beyond a wall", "status")
    assert "point 0 at the wall y_min" in page.text_content("#status")
    numbers = (
        "#impacts",
        "#energies",
        "#caption",
        "#subtitle",
        "#pin-table tbody tr:first-child td >> nth=0",
    )
    assert not any(page.locator(place).is_visible() for place in numbers)
    assert page.locator("#pin-table tbody tr:nth-child(2) td").first.is_visible()
    page.evaluate("chainImpact.show({ 'box.y_min': 0 })")
    until(page, "!document.body.classList.contains('stale')")
    assert all(page.locator(place).is_visible() for place in ("#impacts", "#energies", "#subtitle"))


def test_two_pins_leave_the_list_of_impacts_in_sight(show):
    page = show(viewport={"width": 1366, "height": 800})
    for _ in range(2):
        page.get_by_role("button", name="Pin").click()
    top = page.locator("#pins").bounding_box()["y"]
    rows = [row.bounding_box() for row in page.locator("#impacts tbody tr").all()[:3]]
    assert all(row["y"] + row["height"] < top for row in rows)
    boxes = {name: page.locator(name).bounding_box() for name in ("#energy .uplot", "#energies", "#list")}
    assert boxes["#energy .uplot"]["y"] + boxes["#energy .uplot"]["height"] <= boxes["#energies"]["y"]
    assert boxes["#list"]["y"] + boxes["#list"]["height"] < top


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_pins_have_colours_of_their_own(show, scheme):
    page = show(color_scheme=scheme)
    names = [*(f"pin-{k}" for k in range(1, 6)), *ENERGIES, "chain", "tip"]
    style = "getComputedStyle(document.documentElement)"
    found = page.evaluate(f"names => names.map((name) => {style}.getPropertyValue(`--${{name}}`))", names)
    colours = [np.array(mpl.colors.to_rgb(one.strip())) for one in found]
    for one, other in itertools.combinations(range(len(colours)), 2):
        if one < 5:
            assert abs(colours[one] - colours[other]).sum() > 0.3, (names[one], names[other])


def test_a_map_goes_by_the_keyboard(show):
    page = show("rod_drop", MAP)
    page.get_by_role("button", name="Map…").click()
    draw_map(page)
    page.locator("#map-canvas").focus()
    page.keyboard.press("ArrowRight")  # the run in the middle
    middle = page.text_content("#map-text")
    assert "impact.count = " in middle
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowUp")
    assert page.text_content("#map-text") != middle
    assert page.locator(".map-chosen").count() == 1
    told = float(re.search(r"contact\.restitution = ([\d.]+)", page.text_content("#map-text"))[1])
    page.keyboard.press("Enter")
    assert not page.locator("#map").is_visible()
    assert float(page.evaluate("chainImpact.parameters['contact.restitution']")) == pytest.approx(
        told, rel=1e-4
    )


def test_a_contact_that_lasts_is_listed_as_such(show):
    page = show("sliding_rod")
    rows = page.locator("#impacts tbody tr").all_inner_texts()
    impacts = simulate("sliding_rod").impacts
    assert [("lasts" in row) for row in rows] == np.isnan(impacts["end"]).tolist()
    assert any("lasts" in row for row in rows)
