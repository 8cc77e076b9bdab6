"""The sliders and the list of parameters: values that are taken, refused and reset, signals and inputs."""

# Tests: pages/browser/explore/parameters/sliders.js
# Tests: pages/browser/explore/parameters/parameter_fields.js
# Tests: pages/browser/explore/parameters/parameter_list.js

import re
import shlex

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from chain_impact.variables.prepared import PreparedScene
from tests.pages.in_pages import (
    DESK,
    ON_ITS_SIDE,
    PHONE,
    PIXELS,
    SUBTITLE,
    enter,
    impacts_of,
    until,
    until_told,
)
from tests.pages.javascript import function_of
from tests.tiers import needs_browser

pytestmark = needs_browser
COLOUR = "field => getComputedStyle(field).borderTopColor"


def test_a_slider_and_a_law_give_another_motion_and_reset_the_first_one(show):
    page = show()
    before = page.evaluate(SUBTITLE)
    slider = page.get_by_role("slider", name="Restitution")
    slider.focus()
    slider.press("Home")
    for _ in range(4):
        slider.press("PageUp")
    value = float(page.get_by_role("textbox", name="contact.restitution").first.input_value())
    assert 0.2 < value < 0.7
    until_told(page, impacts_of({"contact.restitution": value}))
    page.get_by_role("button", name="Reset contact.restitution").first.click()
    until(page, f"{SUBTITLE} === '{before}'")
    page.get_by_role("combobox", name="contact.model").first.select_option(label="flores")
    until_told(page, impacts_of({"contact.model": "flores"}))
    assert "Flores, Machado, Silva & Martins 2011" in page.locator(".sentence:not(.outcome)").inner_text()


def test_the_name_of_a_field_for_speech_has_the_words_beside_it(show):
    page = show("sliding_rod")
    for label in page.locator(".main-parameter-label").all():
        words = label.evaluate("label => label.firstChild.textContent.trim()")
        assert words in label.evaluate("label => label.control.ariaLabel")


CUT = """[...document.querySelectorAll('.main-parameter input[type=text]')]
  .filter((field) => field.scrollWidth > field.clientWidth).map((field) => field.value)"""


@pytest.mark.parametrize("model", ["sphere_on_wall", "arm_at_stop", "ur5e", "bouncing_table"])
@pytest.mark.parametrize("viewport", [DESK, PHONE], ids=["desk", "phone"])
def test_no_field_cuts_its_number(show, model, viewport):
    page = show(model, viewport=viewport)
    for slider in page.locator(".main-parameter input[type=range]").all():
        slider.press("PageUp")
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


IN_SIGHT = function_of("sliders", "rowsInSight")


@pytest.mark.parametrize("viewport", [DESK, PHONE], ids=["desk", "phone"])
def test_the_list_of_all_parameters_comes_into_sight_when_it_opens(show, viewport):
    page = show(viewport=viewport)
    page.locator("summary").get_by_text("All parameters").click()
    until(page, f"({IN_SIGHT})() > 4")


def test_a_logarithmic_slider_has_its_start_in_the_middle_of_the_decades(show):
    page = show()
    slider = page.get_by_role("slider", name="Stiffness")
    unit = page.locator("label[for='main-contact.stiffness'] small")
    for exponent, shown in ((1, "N/m"), (1.5, "N/m¹·⁵")):
        page.evaluate(f"chainImpact.show({{'contact.exponent': {exponent}}})")
        assert unit.inner_text() == shown
    assert slider.evaluate("slider => slider.valueAsNumber / slider.max") == 0.5
    for key, value in (("Home", 1e5), ("End", 1e11)):
        slider.press(key)
        assert float(page.evaluate("chainImpact.parameters['contact.stiffness']")) == value


def test_a_refused_value_is_marked_and_told_until_it_is_changed(show):
    page = show()
    field = page.get_by_role("textbox", name="contact.stiffness")
    usual = field.evaluate(COLOUR)
    enter(page, "contact.stiffness", "-1")
    told = "Stiffness = -1 must be a finite number > 0 [N/m^exponent]"
    assert field.evaluate("field => field.validationMessage") == told
    page.get_by_role("textbox", name="gravity.y").focus()
    refused = page.get_by_role("alert").filter(has_text="Not taken")
    shown = told.replace("N/m^exponent", "N/m¹·⁵")
    assert refused.inner_text().replace("\xa0", " ") == f"Not taken: {shown}."
    assert field.evaluate(COLOUR) != usual
    assert page.evaluate("chainImpact.parameters['contact.stiffness']") == "1e8"
    enter(page, "contact.stiffness", "1e6")
    assert refused.count() == 0
    assert field.evaluate(COLOUR) == usual
    until_told(page, impacts_of({"contact.stiffness": 1e6}))


def test_the_row_of_a_refused_value_is_marked_in_the_list(show):
    page = show()
    page.get_by_text("All parameters").click()
    row = page.locator(".parameter", has=page.get_by_role("textbox", name="link[2].mass"))
    styles = "[row, row.querySelector('.parameter-name')].map((one) => getComputedStyle(one))"
    look = f"row => {styles}.map(({{ boxShadow, color }}, k) => (k ? color : boxShadow))"
    usual = row.evaluate(look)
    field = row.get_by_role("textbox")
    field.fill("heavy")
    field.press("Tab")
    assert all(now != before for now, before in zip(row.evaluate(look), usual, strict=True))
    field.press("Escape")
    assert row.evaluate(look) == usual


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
    below = page.locator("footer").bounding_box()["y"]
    until(page, f"{BOTTOM} <= {below}")
    assert reason.bounding_box()["y"] >= page.locator("#stage").bounding_box()["y"]


BOTTOM = """Math.max(...[...document.querySelectorAll(".main-parameter .refusal")]
  .map((reason) => reason.getBoundingClientRect().bottom))"""


def test_space_plays_and_a_question_mark_helps_beside_a_slider(show):
    page = show()
    slider = page.get_by_role("slider", name="Restitution")
    slider.press("ArrowLeft")
    slider.press("End")
    assert page.evaluate("chainImpact.parameters['contact.restitution']") == "1"
    slider.press("Space")
    page.get_by_role("button", name="Pause").wait_for()
    slider.press("?")
    assert page.get_by_role("dialog", name="Help").is_visible()


@pytest.mark.parametrize("size", [ON_ITS_SIDE, {"width": 768, "height": 1024}], ids=["side", "tablet"])
def test_no_label_is_broken_within_its_word(show, size):
    page = show(viewport=size, has_touch=True)
    label = page.locator("label[for='main-contact.restitution']")
    line = label.evaluate("label => parseFloat(getComputedStyle(label).lineHeight)")
    assert label.bounding_box()["height"] < 1.6 * line


def test_a_slider_that_was_refused_is_right_again_after_the_next_change(show):
    page = show("sliding_rod")
    slider = page.get_by_role("slider", name="Friction at the floor", exact=True)
    slider.press("End")
    told = slider.evaluate("slider => slider.validationMessage")
    assert told.startswith("Static friction at the floor = ")
    page.get_by_role("slider", name="Static friction at the floor").press("End")
    assert slider.evaluate("slider => slider.validationMessage") == ""
    slider.press("End")
    assert page.evaluate("chainImpact.parameters['wall.y_min.friction']") == "1.5"


def test_a_label_calls_a_wall_the_floor_only_while_gravity_points_down(show):
    page = show("sliding_rod")
    label = page.locator("label[for='main-wall.y_min.friction']")
    assert label.inner_text() == "Friction at the floor"
    page.get_by_role("slider", name="Gravity, y").press("End")
    assert label.inner_text() == "Friction at y_min"


def test_the_list_has_every_parameter_and_is_searched(show):
    page = show()
    page.get_by_text("All parameters").click()
    rows = page.locator(".parameter")
    rows.first.wait_for()
    assert rows.count() == page.evaluate("Object.keys(chainImpact.parameters).length") > 50
    row = rows.filter(has_text="link[2].\u200bmass").first
    row.locator("input").fill("heavy")
    row.locator("input").press("Enter")
    told = "Not taken: Mass of link 2 = heavy must be a finite number >\xa00 [kg]."
    assert row.locator(".refusal").inner_text() == told
    page.get_by_role("slider", name="Restitution").press("ArrowLeft")
    assert row.locator("input").input_value() == "1", "another change shows the value that holds"
    assert not row.locator(".refusal").is_visible()
    page.get_by_role("button", name="Reset all").click()
    page.get_by_role("searchbox").fill("link 2 mass")
    visible = [row.inner_text() for row in rows.all() if row.is_visible()]
    assert any("mass" in text for text in visible)
    assert len(visible) < 4
    enter(page, "link[2].mass", "3")
    until_told(page, impacts_of({"link[2].mass": 3.0}))
    page.get_by_role("searchbox").fill("no such thing")
    assert page.get_by_text("No parameter has such a name.").is_visible()


@pytest.mark.parametrize(
    ("typed", "found"),
    [
        ("initial height", {"initial.y"}),
        ("mass of link 2", {f"link[2].{key}" for key in ("mass", "center_of_mass", "inertia")}),
        ("link[2].mass", {"link[2].mass"}),
        ("position right wall", {"box.x_max"}),
        ("Contact LAW", {"contact.model"}),
    ],
)
def test_words_and_keys_find_a_parameter(show, typed, found):
    page = show()
    page.get_by_text("All parameters").click()
    page.get_by_role("searchbox").fill(typed)
    seen = page.locator(".parameter:visible .key")
    assert found <= {key.replace("\u200b", "") for key in seen.all_inner_texts()}
    assert seen.count() < 4


def test_the_list_has_groups_with_titles_and_the_changed_ones_first(show):
    page = show("pinned_arm", hash_="#link[2].mass=2")
    page.get_by_text("All parameters").click()
    titles = page.locator(".parameters h2:visible")
    expected = [
        "Changed",
        "Gravity",
        "Link 1",
        "Link 2",
        "Box",
        "Contact",
        "Start",
        "Solver",
        "Inputs",
        "Simulation",
    ]
    assert titles.all_inner_texts() == expected
    names = "one => [...one.parentNode.querySelectorAll('.parameter-name')].map((name) => name.textContent)"
    assert titles.first.evaluate(names) == ["Mass of link 2 link[2].\u200bmass"]
    assert titles.nth(2).evaluate(names)[:2] == ["Length link[1].\u200blength", "Mass link[1].\u200bmass"]
    page.get_by_role("searchbox").fill("radius")
    assert titles.all_inner_texts() == ["Contact"]
    page.get_by_role("searchbox").fill("radus of contact")
    nearest = "No parameter has such a name; the nearest is Radius of contact."
    assert page.locator(".nothing").first.inner_text() == nearest
    page.get_by_role("button", name="Reset all").click()
    until(page, "document.querySelector('.parameters h2').checkVisibility() === false")


def test_a_choice_that_is_none_is_answered_with_names(show):
    with pytest.raises(Exception, match=r"contact.model = foo must be one of hertz, hunt_crossley"):
        show().evaluate("chainImpact.show({ 'contact.model': 'foo' })")


def test_a_law_without_friction_offers_to_take_it_away(show):
    page = show("sliding_rod")
    page.evaluate("chainImpact.show({'contact.model': 'newton_impact'})")
    until_told(page, "newton_impact has no contact friction", "status")
    page.get_by_role("button", name="Set the friction of walls to 0").click()
    until(page, "document.getElementById('status').hidden")
    values = page.evaluate("chainImpact.parameters")
    frictions = {
        value for name, value in values.items() if name.startswith(("wall", "contact")) and "friction" in name
    }
    assert frictions == {"0"}
    assert values["contact.model"] == "newton_impact"


def test_motions_of_the_base_and_of_walls_are_told_to_stay(show):
    assert show("rod_drop").locator("#inputs").is_hidden()
    told = show("shaken_pendulum").locator("#inputs")
    assert "These inputs keep their start values here: Position of the base, x" in told.inner_text()


def test_signals_drive_the_page_with_a_slider_for_each_number_and_a_chart(show):
    page = show("bouncing_table", {"simulation.stop_time": 1.0})
    assert page.locator("#inputs-over-time dt").all_inner_texts() == ["Displacement of the floor"]
    assert page.evaluate(PIXELS, ["inputs-over-time", "input-1"]) > 200
    scene = load_scene("bouncing_table").with_values({"simulation.stop_time": 1.0})
    changed = {"signal.table.amplitude": 0.004, "signal.table.phase": 1.0}
    knob = page.get_by_role("slider", name=re.compile("table.*amplitude"))
    assert knob.is_visible()
    knob.press("ArrowRight")
    until(page, "chainImpact.parameters['signal.table.amplitude'] > 0.00323038")
    page.evaluate("(changed) => chainImpact.show(changed)", changed)
    until_told(page, f"{len(simulate(scene.with_values(changed)).impacts)} impacts")
    page.locator("#scrub").fill("0.5")
    shown = 0.004 * np.sin(1.0 + 2.0 * np.pi * 10.0 * 0.5)
    told = page.locator("#inputs-over-time dd").inner_text().split("\u202f")
    assert float(told[0]) == pytest.approx(1e3 * shown, rel=1e-2)
    assert told[1] == "mm"
    assert page.evaluate("chainImpact.scene") == "BouncingTable"
    names = {
        name for name in page.evaluate("Object.keys(chainImpact.parameters)") if name.startswith("signal")
    }
    assert names == {name for name in PreparedScene(scene).parameter_paths if name.startswith("signal")}


def test_a_torque_and_a_target_are_set_by_a_slider_as_simulate_takes_them(show):
    page = show("pinned_arm", {"inputs.joint_targets": True, "link[2].joint_stiffness": 20.0})
    for name, key in (("Torque of joint 1", "Home"), ("Target angle of joint 2", "End")):
        page.get_by_role("slider", name=name).press(key)
    values = page.evaluate("chainImpact.parameters")
    inputs = {name: float(values[name]) for name in ("joint[1].torque", "joint[2].target_angle")}
    assert inputs["joint[1].torque"] < 0.0 < inputs["joint[2].target_angle"]
    scene = load_scene("pinned_arm").with_values(
        {"inputs.joint_targets": True, "link[2].joint_stiffness": 20}
    )
    result = simulate(scene, inputs=inputs)
    until_told(page, f"{len(result.impacts)} impact")
    tip = page.evaluate(
        """async (inputs) => {
      const run = await chainImpact.simulate(inputs, { output: ["point[2].x"] });
      return Array.from(run.columns["point[2].x"]); }""",
        inputs,
    )
    assert tip == result["point[2].x"].tolist()
    page.get_by_role("button", name="Export…").click()
    command = page.get_by_label("The command that gives the same motion").input_value()
    assert shlex.split(command)[2].endswith(
        f'.with_values({{}}), inputs={{"joint[1].torque": {values["joint[1].torque"]}, '
        f'"joint[2].target_angle": {values["joint[2].target_angle"]}}}))'
    )


def test_the_targets_of_a_slider_have_sliders(show):
    page = show("cart_pole", {"inputs.joint_targets": True})
    for quantity in ("position", "velocity"):
        page.get_by_role("slider", name=f"Target {quantity} of the slider").press("End")
        assert float(page.evaluate("chainImpact.parameters")[f"slider.target_{quantity}"]) > 0.0


def test_an_empty_field_and_a_wrong_word_for_degrees_are_told(show):
    page = show("pinned_arm")
    page.locator("#list-of-parameters summary").click()
    for name, text, told in (
        ("contact.restitution", "", "Restitution is empty"),
        ("initial.angle[1]", "45 grad", '"90 deg"'),
    ):
        field = page.locator(f"#list-of-parameters input[data-parameter='{name}']")
        field.fill(text)
        field.press("Enter")
        assert told in page.locator(".parameter .refusal:not(:empty)").last.inner_text()


def test_a_stiffness_without_effect_is_pale_and_its_forces_have_no_chart(show):
    page = show("bouncing_ball", {"simulation.stop_time": 2.0})
    row = page.locator(".main-parameter").filter(has=page.get_by_role("slider", name="Stiffness"))
    assert row.locator(".no-effect").inner_text() == "No effect with newton_impact."
    opacity = "one => Number(getComputedStyle(one).opacity)"
    assert row.locator("input[type=range]").evaluate(opacity) < 0.6
    assert not page.locator("#force").is_visible()
    page.evaluate("chainImpact.show({ 'contact.model': 'flores' })")
    page.locator("#force").wait_for(state="visible")
    assert row.locator("input[type=range]").evaluate(opacity) == 1.0
    assert not row.locator(".no-effect").is_visible()


def test_a_stiffness_of_stops_is_pale_without_effect(show):
    for values, pale in ({}, 1), ({"stops.model": "hunt_crossley", "stops.restitution": 0.5}, 0):
        page = show("kneed_leg", values)
        page.get_by_role("slider", name="Stiffness of stops").wait_for()
        assert page.locator(".main-parameter.idle").count() == pale


def test_the_law_of_stops_is_told_before_their_parameters(show):
    page = show("kneed_leg")
    told = page.locator("#main-parameters .note")
    assert told.inner_text() == "Contact law of stops: newton_impact"
    assert "Stiffness of stops" in told.evaluate("told => told.nextElementSibling.textContent")
    page = show("arm_at_stop", {"stops.model": "hertz"})
    assert page.locator("#main-parameters .note").inner_text() == "Contact law of stops: hertz"
    assert show().locator("#main-parameters .note").count() == 0


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


def test_typing_after_tab_replaces_a_rounded_angle(show):
    page = show()
    page.locator("#list-of-parameters summary").click()
    field = page.locator("#list-of-parameters input[data-parameter='initial.angle[1]']")
    page.get_by_role("searchbox").fill("initial.angle[1]")
    for _ in range(20):
        page.keyboard.press("Tab")
        if field.evaluate("one => one === document.activeElement"):
            break
    page.keyboard.type("25 deg")
    page.keyboard.press("Enter")
    until(page, "Math.abs(chainImpact.parameters['initial.angle[1]'] - 25 * Math.PI / 180) < 1e-9")


def test_a_law_without_losses_makes_the_restitution_pale(show):
    page = show(hash_="#contact.model=hertz")
    pale = page.locator(".main-parameter.idle .main-parameter-label")
    assert pale.all_inner_texts() == ["Restitution"]
    assert page.locator(".no-effect:visible").all_inner_texts() == ["No effect with hertz."]
    page.evaluate("chainImpact.show({'contact.model': 'flores'})")
    assert pale.count() == 0


@pytest.mark.parametrize(
    ("model", "name"), [("four_link_box", "initial.y"), ("pinned_arm", "initial.angle[1]")]
)
def test_a_slider_changes_the_start(show, model, name):
    page = show(model)
    slider = page.locator(".main-parameter", has=page.locator(f"[data-parameter='{name}']")).locator(
        "input[type=range]"
    )
    before = float(page.evaluate(f"chainImpact.parameters['{name}']"))
    slider.press("PageUp")
    assert float(page.evaluate(f"chainImpact.parameters['{name}']")) > before
    texts = page.locator("input[type=range]").evaluate_all("all => all.map((one) => one.ariaValueText ?? '')")
    assert [text for text in texts if text != text.strip()] == []
