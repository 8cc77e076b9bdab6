"""The fields of parameters: their digits, and values that are refused and taken back."""

# Tests: pages/browser/explore/parameters/parameter_fields.js

import re

import numpy as np
import pytest

from chain_impact import load_scene
from tests.pages.in_pages import DESK, PHONE, enter, impacts_of, until, until_text
from tests.tiers import needs_browser

pytestmark = needs_browser
COLOUR = "field => getComputedStyle(field).borderTopColor"


CUT = """[...document.querySelectorAll('.main-parameter input[type=text]')]
  .filter((field) => field.scrollWidth > field.clientWidth).map((field) => field.value)"""


@pytest.mark.parametrize("model", ["sphere_on_wall", "arm_at_stop", "ur5e", "bouncing_table"])
def test_no_field_cuts_its_number(show, model):
    page = show(model, viewport=PHONE)
    for slider in page.locator(".main-parameter input[type=range]").all():
        slider.press("PageUp")
    assert page.evaluate(CUT) == []
    page.set_viewport_size(DESK)
    assert page.locator(".main-parameter input[type=text]").first.is_visible()
    assert page.evaluate(CUT) == []


def test_a_field_has_all_digits_while_it_has_the_focus(show):
    page = show("sphere_on_wall")
    stiffness = load_scene("sphere_on_wall").values["contact.stiffness"]
    field = page.get_by_role("textbox", name="contact.stiffness")
    assert float(field.input_value()) == pytest.approx(stiffness, rel=1e-4)
    assert float(field.input_value()) != stiffness
    field.focus()
    assert float(field.input_value()) == stiffness
    field.press("Enter")
    field.blur()
    assert page.locator("#reset-all").is_hidden()


def test_angles_are_round_in_degrees(show):
    page = show("hopper")
    name = "signal.knee.mean"
    field = page.get_by_role("textbox", name=name)
    assert field.input_value() == f"{np.degrees(load_scene('hopper').values[name]):.4g}"
    page.locator(f".main-parameter:has([data-parameter='{name}']) input[type=range]").press("End")
    until(page, f"Number(chainImpact.parameters['{name}']) > 0")
    assert float(field.input_value()) == pytest.approx(round(float(field.input_value()), 1), abs=1e-12)
    assert page.evaluate(f"chainImpact.parameters['{name}'].length") <= 7


def test_a_value_typed_after_a_click_replaces_the_present_one(show):
    page = show("pinned_arm")
    field = page.get_by_role("textbox", name="initial.angle[1]").first
    for clicks, degrees in ((1, -60.0), (2, -45.5)):
        page.get_by_role("textbox", name="contact.restitution").first.focus()
        field.click(click_count=clicks)
        page.keyboard.type(str(degrees))
        page.keyboard.press("Enter")
        until(
            page, f"Math.abs(chainImpact.parameters['initial.angle[1]'] * 180 / Math.PI - {degrees}) < 1e-9"
        )


def test_a_refused_value_is_marked_and_told_until_it_is_changed(show):
    page = show()
    field = page.get_by_role("textbox", name="contact.stiffness")
    usual_colour = field.evaluate(COLOUR)
    enter(page, "contact.stiffness", "-1")
    message = "Stiffness = -1 must be a finite number > 0 [N/m^exponent]"
    assert field.evaluate("field => field.validationMessage") == message
    page.get_by_role("textbox", name="gravity.y").focus()
    refused = page.get_by_role("alert").filter(has_text="Not taken")
    shown_message = message.replace("N/m^exponent", "N/m¹·⁵")
    assert (
        re.sub(r"\s", " ", refused.inner_text()) == f"Not taken: {shown_message}. The motion has 1e8 N/m¹·⁵."
    )
    assert field.evaluate(COLOUR) != usual_colour
    assert page.evaluate("chainImpact.parameters['contact.stiffness']") == "1e8"
    enter(page, "contact.stiffness", "1e6")
    assert refused.count() == 0
    assert field.evaluate(COLOUR) == usual_colour
    until_text(page, impacts_of({"contact.stiffness": 1e6}))


def test_escape_and_reset_bring_back_the_value_that_holds(show):
    page = show(hash_="#contact.restitution=0.5")
    field = enter(page, "contact.restitution", "1.5")
    field.press("Tab")
    assert field.input_value() == "1.5"
    reason = page.locator(".main-parameter .refusal").filter(has_text="Not taken")
    assert reason.is_visible()
    field.press("Escape")
    assert field.input_value() == "0.5"
    assert reason.count() == 0
    page.get_by_role("button", name="Reset contact.restitution").first.click()
    enter(page, "contact.restitution", "1.5")
    page.get_by_role("button", name="Reset contact.restitution").first.click()
    assert (field.input_value(), reason.count()) == ("0.7", 0)


def test_the_reason_of_a_refusal_is_in_sight_on_a_phone(show):
    page = show("pinned_arm", viewport=PHONE)
    enter(page, "contact.restitution", "2")
    reason = page.locator(".main-parameter .refusal").filter(has_text="Not taken")
    top_of_footer = page.locator("footer").bounding_box()["y"]
    until(page, f"{BOTTOM} <= {top_of_footer}")
    assert reason.bounding_box()["y"] >= page.locator("#stage").bounding_box()["y"]


BOTTOM = """Math.max(...[...document.querySelectorAll(".main-parameter .refusal")]
  .map((reason) => reason.getBoundingClientRect().bottom))"""


def test_an_empty_field_and_a_wrong_word_for_degrees_are_told(show):
    page = show("pinned_arm")
    page.locator("#list-of-parameters summary").click()
    for name, text, ending in (
        (
            "contact.stiffness",
            "1e8 N/cm",
            'the unit "N/cm" is not understood; write N/m¹·⁵, kN/m¹·⁵, N/mm¹·⁵',
        ),
        ("contact.restitution", "", "Restitution is empty"),
        ("contact.restitution", "1e", '1e: this value has no unit "e". It must be a finite number'),
        ("initial.angle[1]", "45 grad", "[°]; an angle in rad ends with rad"),
    ):
        field = page.locator(f"#list-of-parameters input[data-parameter='{name}']")
        field.fill(text)
        field.press("Enter")
        assert ending in page.locator(".parameter .refusal:not(:empty)").last.inner_text()


def test_the_field_of_a_value_with_which_the_run_fails_tells_why(show):
    page = show(viewport=PHONE)
    row = page.locator(".main-parameter").filter(has_text="Restitution")
    enter(page, "contact.restitution", "0")
    row.get_by_text("the contact law does not allow this restitution").wait_for()
    field = row.locator("input[type=text]")
    assert not field.evaluate("field => field.validity.valid")
    undo = page.get_by_role("button", name="Undo the change of Restitution")
    box = undo.bounding_box()
    assert box["x"] + box["width"] <= PHONE["width"]
    undo.click()
    until(page, "document.getElementById('status').hidden")
    assert field.evaluate("field => field.validity.valid")
    assert not row.locator(".refusal").is_visible()


def test_typing_after_tab_replaces_a_rounded_angle_in_degrees(show):
    page = show()
    page.locator("#list-of-parameters summary").click()
    field = page.locator("#list-of-parameters input[data-parameter='initial.angle[1]']")
    page.get_by_role("searchbox").fill("initial.angle[1]")
    for _ in range(20):
        page.keyboard.press("Tab")
        if field.evaluate("element => element === document.activeElement"):
            break
    page.keyboard.type("25")
    page.keyboard.press("Enter")
    until(page, "Math.abs(chainImpact.parameters['initial.angle[1]'] - 25 * Math.PI / 180) < 1e-9")


def test_a_ratio_takes_percents(show):
    page = show("pinned_arm")
    assert enter(page, "contact.restitution", "50 %").input_value() == "0.5"


def test_an_angle_of_many_turns_is_told(show):
    page = show("pinned_arm")
    enter(page, "initial.angle[1]", "36000")
    note = page.locator("[id='no-effect-initial.angle[1]']")
    assert note.inner_text() == "These are 100 turns."
    enter(page, "initial.angle[1]", "350")
    assert note.inner_text() == ""
