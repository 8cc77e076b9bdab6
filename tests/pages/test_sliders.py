"""The sliders: the values that they give, their labels, signals, inputs and parameters without effect."""

# Tests: pages/browser/explore/parameters/sliders.js, pages/browser/explore/parameters/signal_part.js

import re
import shlex

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from chain_impact.scene.texts.laws import LAW_GROUPS
from chain_impact.variables.prepared import PreparedScene
from tests.pages.in_pages import ON_ITS_SIDE, PIXELS, SUBTITLE, enter, impacts_of, until, until_text
from tests.tiers import needs_browser

pytestmark = needs_browser


def test_a_slider_and_a_law_give_another_motion_and_reset_the_first_one(show):
    page = show()
    subtitle = page.evaluate(SUBTITLE)
    slider = page.get_by_role("slider", name="Restitution")
    slider.focus()
    slider.press("Home")
    for _ in range(4):
        slider.press("PageUp")
    value = float(page.get_by_role("textbox", name="contact.restitution").first.input_value())
    assert 0.2 < value < 0.7
    until_text(page, impacts_of({"contact.restitution": value}))
    page.get_by_role("button", name="Reset contact.restitution").first.click()
    until(page, f"{SUBTITLE} === '{subtitle}'")
    groups = page.locator("#main-parameters optgroup").evaluate_all(
        "all => all.map((element) => element.label)"
    )
    assert groups == list(LAW_GROUPS)
    page.get_by_role("combobox", name="contact.model").first.select_option(label="Flores et al. (2011)")
    until_text(page, impacts_of({"contact.model": "flores"}))
    assert "Flores, Machado, Silva & Martins 2011" in page.locator(".sentence:not(.outcome)").inner_text()


def test_the_name_of_a_field_for_speech_has_the_words_beside_it(show):
    page = show("sliding_rod")
    for label in page.locator(".main-parameter-label").all():
        words = label.evaluate("label => label.firstChild.textContent.trim()")
        assert words in label.evaluate("label => label.control.ariaLabel")


def test_a_logarithmic_slider_has_its_start_in_the_middle_of_the_decades(show):
    page = show()
    slider = page.get_by_role("slider", name="Stiffness")
    unit = page.locator("label[for='main-contact.stiffness'] small")
    for exponent, unit_text in ((1, "N/m"), (1.5, "N/m¹·⁵")):
        page.evaluate(f"chainImpact.show({{'contact.exponent': {exponent}}})")
        assert unit.inner_text() == unit_text
    assert slider.evaluate("slider => slider.valueAsNumber / slider.max") == 0.5
    for key, value in (("Home", 1e5), ("End", 1e11)):
        slider.press(key)
        assert float(page.evaluate("chainImpact.parameters['contact.stiffness']")) == value


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
    if size is ON_ITS_SIDE:
        page.get_by_role("button", name="Parameters").click()
    label = page.locator("label[for='main-contact.restitution']")
    line = label.evaluate("label => parseFloat(getComputedStyle(label).lineHeight)")
    assert label.bounding_box()["height"] < 1.6 * line


def test_a_slider_that_was_refused_is_right_again_after_the_next_change(show):
    page = show("sliding_rod")
    slider = page.get_by_role("slider", name="Friction at the floor", exact=True)
    slider.press("End")
    message = slider.evaluate("slider => slider.validationMessage")
    assert message.startswith("Static friction at the floor = ")
    page.get_by_role("slider", name="Static friction at the floor").press("End")
    assert slider.evaluate("slider => slider.validationMessage") == ""
    slider.press("End")
    assert page.evaluate("chainImpact.parameters['wall.y_min.friction']") == "1.5"


def test_a_label_calls_a_wall_the_floor_only_while_gravity_points_down(show):
    page = show("sliding_rod")
    label = page.locator("label[for='main-wall.y_min.friction']")
    assert label.inner_text() == "Friction at the floor"
    page.get_by_role("slider", name="Gravity, y").press("End")
    assert label.inner_text() == "Friction at the lower wall"


def test_motions_of_the_base_and_of_walls_are_told_to_stay(show):
    assert show("rod_drop").locator("#inputs").is_hidden()
    note = show("shaken_pendulum").locator("#inputs")
    assert "These inputs keep their start values here: Position of the base, x" in note.inner_text()


def test_signals_drive_the_page_with_a_slider_for_each_number_and_a_chart(show):
    page = show("bouncing_table", {"simulation.stop_time": 1.0})
    assert page.locator("#inputs-over-time dt.of-curve").all_inner_texts() == ["Displacement of the floor"]
    assert page.evaluate(PIXELS, ["inputs-over-time", "input-1"]) > 200
    scene = load_scene("bouncing_table").with_values({"simulation.stop_time": 1.0})
    changes = {"signal.table.amplitude": 0.004, "signal.table.phase": 1.0}
    knob = page.get_by_role("slider", name=re.compile("table.*amplitude"))
    assert knob.is_visible()
    knob.press("ArrowRight")
    until(page, "chainImpact.parameters['signal.table.amplitude'] > 0.00323038")
    page.evaluate("(changed) => chainImpact.show(changed)", changes)
    until_text(page, f"{len(simulate(scene.with_values(changes)).impacts)} impacts")
    page.locator("#scrub").fill("0.5")
    displacement = 0.004 * np.sin(1.0 + 2.0 * np.pi * 10.0 * 0.5)
    shown_texts = page.locator("#inputs-over-time dd").inner_text().split("\u202f")
    assert float(shown_texts[0]) == pytest.approx(1e3 * displacement, rel=1e-2)
    assert shown_texts[1] == "mm"
    assert page.evaluate("chainImpact.scene") == "BouncingTable"
    names = {
        name for name in page.evaluate("Object.keys(chainImpact.parameters)") if name.startswith("signal")
    }
    assert names == {name for name in PreparedScene(scene).parameter_paths if name.startswith("signal")}


def test_a_step_of_a_signal_has_a_row_and_a_point_that_the_reader_drags(show):
    page = show("cart_pole")
    assert page.locator(".signal .step").count() == 3
    enter(page, "push: value 2 at time 2", "-0.3")
    until(page, "document.querySelector('.signal small').textContent.startsWith('−0.3')")
    box = page.locator(".signal-drawing").bounding_box()
    point = page.locator(".signal-point").nth(1)
    spot = point.bounding_box()
    page.mouse.move(spot["x"] + 12, spot["y"] + 12)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] / 3, box["y"] + box["height"] / 2, steps=3)
    page.mouse.up()
    parameters = page.evaluate("chainImpact.parameters")
    time, value = (float(parameters[f"signal.push.{key}[2]"]) for key in ("time", "value"))
    assert time == pytest.approx(1.0, abs=0.02)
    assert -0.3 < value < 0.0
    assert page.locator(".signal").get_attribute("open") is not None, "a drag does not fold the signal"
    spot = point.bounding_box()
    page.mouse.move(spot["x"] + 12, spot["y"] + 12)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"], box["y"], steps=3)
    page.mouse.up()
    assert float(page.evaluate("chainImpact.parameters['signal.push.time[2]']")) < 2.1, "before the next step"
    assert page.locator("#parameters .refusal:not(:empty)").count() == 0


def test_only_the_first_signal_is_open_and_each_has_its_drawing(show):
    page = show("stick_slip_belt")
    parts = page.locator(".signal")
    assert parts.evaluate_all("all => all.map(({ open }) => open)") == [True, False]
    courses = "all => all.map((element) => element.querySelector('.course').getAttribute('d').length > 99)"
    assert parts.evaluate_all(courses) == [True, True]


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
    until_text(page, f"{len(result.impacts)} impact")
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
    page.locator(".inputs summary").click()
    for quantity in ("position", "velocity"):
        page.get_by_role("slider", name=f"Target {quantity} of the slider").press("End")
        assert float(page.evaluate("chainImpact.parameters")[f"slider.target_{quantity}"]) > 0.0


def test_a_stiffness_without_effect_is_pale_and_the_chart_has_impulses(show):
    page = show("bouncing_ball", {"simulation.stop_time": 2.0})
    row = page.locator(".main-parameter").filter(has=page.get_by_role("slider", name="Stiffness"))
    assert row.locator(".no-effect").inner_text() == "No effect with Newton (1687)."
    opacity = "element => Number(getComputedStyle(element).opacity)"
    assert row.locator("input[type=range]").evaluate(opacity) < 0.6
    assert page.inner_text("#contact-quantity") == "Impulses"
    page.evaluate("chainImpact.show({ 'contact.model': 'flores' })")
    until_text(page, "Contact force", "contact-quantity")
    assert row.locator("input[type=range]").evaluate(opacity) == 1.0
    assert not row.locator(".no-effect").is_visible()


def test_a_stiffness_of_stops_is_pale_without_effect(show):
    for values, pale in ({}, 1), ({"stops.model": "hunt_crossley", "stops.restitution": 0.5}, 0):
        page = show("kneed_leg", values)
        page.get_by_role("slider", name="Stiffness of stops").wait_for()
        assert page.locator(".main-parameter.idle").count() == pale


def test_the_law_of_stops_is_told_before_their_parameters(show):
    page = show("kneed_leg")
    note = page.locator("#main-parameters .note")
    assert note.inner_text() == "Contact law of stops: Newton (1687)"
    assert "Stiffness of stops" in note.evaluate("note => note.nextElementSibling.textContent")
    page = show("arm_at_stop", {"stops.model": "hertz"})
    assert page.locator("#main-parameters .note").inner_text() == "Contact law of stops: Hertz (1881)"
    assert show().locator("#main-parameters .note").count() == 0


def test_a_law_without_losses_makes_the_restitution_pale(show):
    page = show(hash_="#contact.model=hertz")
    pale = page.locator(".main-parameter.idle .main-parameter-label")
    assert pale.all_inner_texts() == ["Restitution"]
    assert page.locator(".no-effect:visible").all_inner_texts() == ["No effect with Hertz (1881)."]
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
    start = float(page.evaluate(f"chainImpact.parameters['{name}']"))
    slider.press("PageUp")
    assert float(page.evaluate(f"chainImpact.parameters['{name}']")) > start
    texts = page.locator("input[type=range]").evaluate_all(
        "all => all.map((element) => element.ariaValueText ?? '')"
    )
    assert [text for text in texts if text != text.strip()] == []
