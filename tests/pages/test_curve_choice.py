"""The choice of outputs for charts: by hand, by words, by names, by a press on a point, and by proposals."""

# Tests: pages/browser/explore/curve_choice.js

import pytest

from tests.pages.in_pages import CHART_NAMES, DESK, PHONE, until
from tests.pages.javascript import function_of
from tests.tiers import needs_browser

pytestmark = needs_browser


def test_outputs_are_chosen_by_hand_and_go_into_the_link(show):
    page = show()
    assert page.locator("#outputs-over-time").is_hidden()
    page.get_by_role("button", name="Chart…").click()
    page.get_by_role("searchbox", name="Search the outputs").fill("4 y_min force")
    page.get_by_role("checkbox", name="contact[4].y_min.force").check()
    until(page, f"{CHART_NAMES}.join() === 'contact[4].y_min.force'")
    page.get_by_text("By names").click()
    field = page.get_by_role("textbox", name="Names, with * for any text")
    for text, sentence in (
        ("nothing", "nothing is not an output."),
        ("pointt[4].x", "pointt[4].x is not an output; the nearest is point[4].x."),
        ("x*", "no output is like x*."),
        ("contact[*].force", "no output is like contact[*].force; the nearest is contact[*].x_min.force."),
        ("*", "must be at most 18."),
    ):
        field.fill(text)
        assert page.locator("#curves-text").inner_text().endswith(sentence), "it is told while one types"
        field.press("Enter")
        assert page.locator("#curves-text").inner_text().endswith(sentence)
        assert page.evaluate(CHART_NAMES) == ["contact[4].y_min.force"]
    field.fill("point[4].x, point[4].velocity_y")
    field.press("Enter")
    until(page, f"{CHART_NAMES}.join() === 'point[4].x'")
    message = page.inner_text("#curves-text")
    assert message == "point[4].velocity_y is not an output; the nearest is point[4].vy."
    assert field.input_value() == "point[4].x, point[4].velocity_y", "the wrong name can be mended"
    field.fill("energy.total, point[4].y")
    field.press("Enter")
    until(page, f"{CHART_NAMES}.join() === 'point[4].y,energy.total'")
    until(page, "decodeURIComponent(location.hash) === '#curves=energy.total,point[4].y'")
    page.keyboard.press("Escape")
    page.reload()
    until(page, f"{CHART_NAMES}.join() === 'point[4].y,energy.total'")


IN_SIGHT = function_of("curves", "inSight")


@pytest.mark.parametrize("viewport", [DESK, PHONE], ids=["desk", "phone"])
def test_chosen_outputs_are_in_sight_when_the_dialog_closes(show, viewport):
    page = show(viewport=viewport)
    page.get_by_role("button", name="Chart…").click()
    page.get_by_text("By names").click()
    field = page.get_by_role("textbox", name="Names, with * for any text")
    field.fill("energy.total")
    field.press("Enter")
    page.keyboard.press("Escape")
    until(page, f"({IN_SIGHT})()")


def test_a_group_of_outputs_is_chosen_at_once(show):
    page = show()
    page.get_by_role("button", name="Chart…").click()
    page.get_by_role("searchbox", name="Search the outputs").fill("y")
    all_button = page.get_by_role("button", name="All of point[*].y", exact=True)
    assert all_button.get_attribute("aria-pressed") == "false"
    all_button.click()
    until(page, f"{CHART_NAMES}.join() === '{','.join(f'point[{k}].y' for k in range(5))}'")
    assert all_button.get_attribute("aria-pressed") == "true"
    page.get_by_role("checkbox", name="point[2].y").uncheck()
    assert all_button.get_attribute("aria-pressed") == "false"
    page.get_by_role("searchbox", name="Search the outputs").fill("2")
    all_button.click()
    until(page, f"{CHART_NAMES}.length === 5")
    all_button.click()  # all that are shown are chosen
    until(page, f"{CHART_NAMES}.join() === '{','.join(f'point[{k}].y' for k in (0, 1, 3, 4))}'")


def test_outputs_are_found_by_the_meaning_beside_their_names(show):
    page = show()
    page.get_by_role("button", name="Chart…").click()
    search = page.get_by_role("searchbox", name="Search the outputs")
    search.fill("y acceleration of point 4")
    boxes = page.locator("#curves-list input:visible")
    label = "Acceleration of a point, y, 4, point[4].ay"
    assert boxes.evaluate_all("all => all.map((element) => element.ariaLabel)") == [label]
    page.get_by_role("button", name="Close").click()
    page.get_by_role("button", name="Chart…").click()
    assert search.input_value() == "", "a search ends with the dialog"


def test_a_press_on_a_point_proposes_its_outputs(show):
    page = show()
    page.locator("#scrub").fill("0.3")
    until(page, "document.getElementById('time').textContent === '0.30000 s'")
    tip = page.locator("#scene .tip").bounding_box()
    page.mouse.click(tip["x"] + tip["width"] / 2, tip["y"] + tip["height"] / 2)
    assert page.get_by_role("searchbox", name="Search the outputs").input_value() == "point 4"
    names = page.locator("#curves-list input:visible").evaluate_all(
        "all => all.map((element) => element.ariaLabel)"
    )
    assert all("[4]" in name for name in names)
    page.get_by_role("button", name="Close").click()
    box = page.locator("#scene .free-region").bounding_box()
    page.mouse.click(box["x"] + 20, box["y"] + 20)
    assert page.locator("#curves").is_hidden()


def test_charts_are_chosen_by_words_and_by_proposals(show):
    page = show("cart_pole")
    page.get_by_role("button", name="Chart…").click()
    proposals = page.locator("#curves-proposals button")
    walls = ["Forces at slider min", "Forces at slider max"]
    expected = ["Path of the tip", "Velocity of the tip", "Joint angles", *walls]
    assert proposals.all_inner_texts() == expected
    proposals.nth(1).click()
    until(page, f"{CHART_NAMES}.join() === 'point[1].vx,point[1].vy'")
    assert page.get_by_role("checkbox", name="Velocity of a point, x, 1, ").is_checked()
    page.get_by_role("button", name="Remove all").click()
    until(page, "document.getElementById('outputs-card').hidden")
    assert proposals.nth(1).get_attribute("aria-pressed") == "false"
