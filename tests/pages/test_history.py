"""Undo and redo of changes of parameters, of drags and of edits."""

# Tests: pages/browser/explore/history.js, pages/browser/explore/gestures.js

import pytest

from tests.pages.in_pages import ADVANCE_CLOCK, enter, go_to, until, until_text
from tests.tiers import needs_browser

pytestmark = needs_browser
NAMES = "all => all.map((element) => element.textContent.replaceAll('\\u200b', ''))"
OPENED = f"title => (title.click(), ({NAMES})([...document.querySelectorAll('.key')]))"
COLOUR = "element => getComputedStyle(element).color"
PRESENT = "chainImpact.parameters['contact.restitution']"


def change(page, restitution):
    page.evaluate(ADVANCE_CLOCK)  # changes at shorter intervals count as one
    page.evaluate(f"chainImpact.show({{'contact.restitution': {restitution}}})")


@pytest.mark.parametrize("modifier", ["Control", "Meta"])
def test_keys_undo_and_redo_one_change_after_the_other(show, modifier):
    page = show(hash_="#contact.restitution=0.6")
    assert page.locator("#undo").is_hidden()
    change(page, 0.5)
    change(page, 0.4)
    values = []
    for key in ("z", "z", "z", "Shift+z", "Shift+z", "Shift+z", "z"):
        page.keyboard.press(f"{modifier}+{key}")
        values.append(page.evaluate(PRESENT))
    assert values == ["0.5", "0.6", "0.6", "0.5", "0.4", "0.4", "0.5"]
    change(page, 0.3)
    page.keyboard.press(f"{modifier}+Shift+z")
    assert page.evaluate(PRESENT) == "0.3", "a new change leaves nothing to redo"
    page.get_by_role("button", name="Undo", exact=True).click()
    assert page.evaluate(PRESENT) == "0.5"
    page.get_by_role("button", name="Redo", exact=True).click()
    assert page.evaluate(PRESENT) == "0.3"


def test_a_key_that_begins_the_start_by_hand_leads_to_the_first_handle(show):
    page = show()
    by_hand = page.get_by_role("button", name="Set the start by hand")
    focused = "document.activeElement.dataset.grip"
    go_to(page, 0.5)
    by_hand.focus()
    page.keyboard.press("Enter")
    assert page.evaluate(focused) == "joint 0"
    page.keyboard.press("ArrowUp")
    until(page, "chainImpact.parameters['initial.y'] > 1.4")
    go_to(page, 0.5)
    by_hand.click()
    assert page.evaluate(focused) is None, "the arrow keys go on moving the time"


@pytest.mark.parametrize("model", ["four_link_box", "pinned_arm"])
def test_undo_takes_the_thumb_of_a_slider_with_the_focus_back(show, model):
    page = show(model)
    slider = page.get_by_role("slider", name="Restitution")
    first = slider.input_value()
    slider.click(position={"x": 70, "y": 9})
    assert slider.input_value() != first
    page.keyboard.press("Control+z")
    assert slider.input_value() == first
    value = float(page.evaluate(PRESENT))
    page.keyboard.press("ArrowRight")
    assert 0.0 < float(page.evaluate(PRESENT)) - value < 0.01


def test_each_arrow_key_moves_a_slider_with_fine_steps(show):
    page = show("rod_drop", {"initial.y": 100.0})
    slider = page.get_by_role("slider", name="Initial height")
    value = float(slider.input_value())
    for step in range(1, 7):
        slider.press("ArrowRight")
        assert float(slider.input_value()) == value + step


@pytest.mark.parametrize(("model", "walls"), [("cart_pole", False), ("four_link_box", True)])
def test_the_text_on_the_start_by_hand_names_walls_of_the_scene(show, model, walls):
    page = show(model)
    text = page.locator(".by-hand small").inner_text()
    assert text.startswith("At the start, drag joints")
    line = page.locator(".by-hand-line")
    assert ("walls" in text) is ("walls" in line.text_content()) is walls
    go_to(page, 0.5)
    assert not line.is_visible()
    page.get_by_role("button", name="Set the start by hand").click()
    line.wait_for()
    page.get_by_role("button", name="Play").click()
    line.wait_for(state="hidden")


def test_a_drag_of_a_handle_is_one_change(show):
    page = show()
    names = "Object.entries(chainImpact.parameters).filter(([name]) => name.startsWith('initial.')).join()"
    start = page.evaluate(names)
    page.get_by_role("button", name="Set the start by hand").click()
    assert page.get_by_role("button", name="Set the start by hand", pressed=True).count() == 1
    box = page.locator("[data-grip='joint 2']").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    for step in range(1, 4):
        page.mouse.move(x + 10 * step, y + 6 * step)
        page.evaluate(ADVANCE_CLOCK)
    page.mouse.up()
    assert page.evaluate(names) != start
    page.keyboard.press("End")
    page.get_by_role("button", name="Set the start by hand", pressed=False).wait_for()
    page.keyboard.press("Control+z")
    assert page.evaluate(names) == start


def test_an_edit_is_undone_with_what_it_has_removed(show):
    page = show(hash_="#link[3].mass=0.2")
    page.get_by_role("button", name="Chart…").click()
    page.get_by_text("By names").click()
    page.locator("#curves-names").fill("link[3].angle")
    page.keyboard.press("Enter")
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Edit…").click()
    page.get_by_role("button", name="Remove link 3").click()
    until_text(page, "3 links")
    page.keyboard.press("Control+z")
    until_text(page, "4 links")
    assert page.locator("#edit-links tbody tr").count() >= 4, "the editor shows the restored scene"
    page.keyboard.press("Escape")
    assert page.evaluate("chainImpact.parameters['link[3].mass']") == "0.2"
    until(page, "decodeURIComponent(location.hash).includes('curves=link[3].angle')")
    page.keyboard.press("Control+Shift+z")
    until_text(page, "3 links")


def test_a_field_undoes_what_is_typed_in_it_itself(show):
    page = show()
    change(page, 0.5)
    field = enter(page, "Restitution", "0.4")
    field.press("Control+z")
    assert page.evaluate(PRESENT) == "0.5", "each entry in a field is a change of its own"
    value = page.evaluate(PRESENT)
    field.press_sequentially("1")
    field.press("Control+z")
    assert page.evaluate(PRESENT) == value


def test_undo_and_redo_are_on_all_screens_and_take_back_a_reset(show):
    page = show()
    buttons = page.locator("#actions > button")
    visible_buttons = "all.filter((element) => element.checkVisibility())"
    tops = f"all => new Set({visible_buttons}.map((element) => element.getBoundingClientRect().top)).size"
    for width, height in ((1366, 768), (1024, 768), (768, 1024), (844, 390), (390, 844), (360, 800)):
        page.set_viewport_size({"width": width, "height": height})
        change(page, 0.5)
        page.evaluate(ADVANCE_CLOCK)
        page.locator("#reset-all").click()
        assert (page.evaluate(PRESENT), buttons.evaluate_all(tops)) == ("0.7", 1)
        page.get_by_role("button", name="Undo", exact=True).click()
        assert (page.evaluate(PRESENT), buttons.evaluate_all(tops)) == ("0.5", 1)
        page.get_by_role("button", name="Redo", exact=True).click()
        assert page.evaluate(PRESENT) == "0.7"
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_a_value_with_which_no_run_starts_is_marked_until_it_is_undone(show):
    page = show()
    enter(page, "Restitution", "0")
    row = page.locator(".main-parameter").filter(has=page.get_by_role("slider", name="Restitution"))
    row.locator(".refusal").get_by_text("Cannot start: ").wait_for()
    assert row.locator("input:invalid").count() == 1
    page.keyboard.press("Control+z")
    row.locator(".refusal").get_by_text("Cannot start: ").wait_for(state="detached")
    assert row.locator("input:invalid").count() == 0


def test_changed_parameters_are_counted_and_first_in_the_list(show):
    page = show()
    title = page.locator("summary", has_text="All parameters")
    drag = {"initial.angle[1]": 1, "link[4].mass": 2}
    page.evaluate("(changes) => chainImpact.show(changes)", drag)
    assert title.inner_text() == "All parameters · 2 changed"
    expected = "Also changed: Initial angle of link\u00a01 = 57.296\u202f°, Mass of link 4 = 2\u202fkg"
    also = page.locator("#also-changed")
    assert also.inner_text().replace("\u00a0", " ") == expected.replace("\u00a0", " ")
    assert title.locator("span").evaluate(COLOUR) == page.locator("#reset-all").evaluate(COLOUR)
    rows = page.locator(".parameter")
    names = title.evaluate(OPENED)  # the list has its rows before it is shown
    assert also.is_hidden()
    assert set(names[:2]) == set(drag)
    page.evaluate(ADVANCE_CLOCK)
    rows.nth(0).get_by_role("button").click()
    assert title.inner_text() == "All parameters · 1 changed"
    assert rows.locator(".key").evaluate_all(NAMES) == names, "a row with the focus keeps its place"
    page.keyboard.press("Control+z")
    page.locator("h1").click()
    page.evaluate("chainImpact.show({'link[3].mass': 2})")
    assert set(rows.locator(".key").evaluate_all(NAMES)[:3]) == {*drag, "link[3].mass"}
