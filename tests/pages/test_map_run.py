"""Maps while they run and after a run is opened: stopping, the time left, their size, the way back."""

# Tests: pages/browser/explore/map/map.js, pages/browser/explore/map/map_place.js
# Tests: pages/browser/explore/map/map_pointing.js

import re
from itertools import pairwise

from tests.pages.in_pages import DESK, draw_map, enter, until
from tests.tiers import needs_browser

pytestmark = needs_browser
LARGE = {"width": 1920, "height": 1080}
PREVIEW = "A preview of 9 × 9 runs."
NOTE_TEXTS = """() => {
  window.texts = [];
  const text = document.getElementById("map-text");
  new MutationObserver(() => texts.push(text.textContent)).observe(text, { childList: true });
}"""
"""Notes each text of the map from now on, because a text that a new preview soon replaces may not be seen."""


def open_map(page):
    page.get_by_role("button", name="Map…").click()
    page.locator("#map-text").get_by_text(PREVIEW).wait_for()


def test_a_button_stops_a_map_whose_rest_is_told_in_seconds(show):
    page = show(hash_="#simulation.stop_time=20")
    page.get_by_role("button", name="Map…").click()
    button = page.locator("#map-run")
    button.click()
    assert button.inner_text() == "Stop"
    until(page, r"/^\d+ of 41 rows, about \d+ s left$/.test(document.getElementById('map-text').textContent)")
    button.click()
    until(page, "document.getElementById('map-text').textContent.startsWith('Stopped after')")
    assert button.inner_text() == "Simulate 41 × 41 runs"
    while len(page.workers) > 1:
        page.wait_for_timeout(50)


def test_a_run_leaves_the_way_back_to_its_map(show):
    page = show("rod_drop", {"simulation.stop_time": 0.3}, viewport={"width": 1100, "height": 768})
    open_map(page)
    page.locator("#map-x-to").fill("0.9")
    page.locator("#map-x-from").fill("0.3")
    page.locator("#map-x-from").blur()
    page.locator("#map-text").get_by_text(PREVIEW).wait_for()
    fields = page.locator(".map-axes input")
    read = "fields => fields.map(({ value }) => value)"
    ranges = fields.evaluate_all(read)
    box = page.locator("#map-canvas").bounding_box()
    page.locator("#map-canvas").click(position={"x": 5, "y": 5})
    back = page.get_by_role("button", name=re.compile("Back to Map"))
    assert box["width"] > 0
    back.click()
    assert page.locator("#map").is_visible()
    assert fields.evaluate_all(read) == ranges, "the ranges are not around the run that was opened"
    page.keyboard.press("Escape")
    assert back.count() == 0


def test_the_map_stays_under_the_finger_when_its_text_grows(show):
    size = {"width": 360, "height": 800}
    page = show("four_link_box", {"simulation.stop_time": 0.5}, viewport=size, has_touch=True)
    open_map(page)
    draw_map(page)
    text, canvas = page.locator("#map-text"), page.locator("#map-canvas")
    box, height = canvas.bounding_box(), text.bounding_box()["height"]
    at = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)  # where numbers are short
    page.touchscreen.tap(*at)
    text.get_by_text("Largest force at a wall = ").wait_for()
    assert text.bounding_box()["height"] != height
    assert canvas.bounding_box() == box
    page.touchscreen.tap(*at)
    until(page, "!document.getElementById('map').open")


def test_a_map_grows_with_the_window(show):
    page, sizes, panels = show(), [], []
    canvas, dialog = page.locator("#map-canvas"), page.locator("#map")
    for size in (DESK, LARGE):
        page.set_viewport_size(size)
        open_map(page)
        panels.append(canvas.bounding_box()["height"])
        boxes = [page.locator(part).bounding_box() for part in ("#map", "#stage", "aside")]
        assert len({box["y"] + box["height"] for box in boxes}) == 1, "all columns end at one height"
        page.locator("#map-enlarge").click()
        box = canvas.bounding_box()
        sizes.append((box["width"], box["height"]))
        assert dialog.evaluate("element => element.scrollHeight <= element.clientHeight")
        page.keyboard.press("Escape")
        assert panels[-1] == canvas.bounding_box()["height"], "it stands beside the motion again"
        page.keyboard.press("Escape")
        assert dialog.is_hidden()
    assert sizes[0][1] > 250.0
    assert sizes[1][0] > 850.0
    assert sizes[1][1] > 500.0
    assert panels[0] > 200.0
    assert panels[1] > 450.0


def test_the_map_of_a_wide_screen_stays_beside_the_motion(show):
    page = show("rod_drop", {"simulation.stop_time": 0.3}, viewport=LARGE)
    open_map(page)
    boxes = [page.locator(part).bounding_box() for part in ("#parameters", "#map", "#stage", "aside")]
    for left_box, right_box in pairwise(boxes):
        assert left_box["x"] + left_box["width"] < right_box["x"], "no part covers another"
    restitution = "chainImpact.parameters['contact.restitution']"
    text, canvas, ring = page.locator("#map-text"), page.locator("#map-canvas"), page.locator(".map-present")
    opened = []
    for x in (5, 200):
        canvas.click(position={"x": x, "y": 5})
        text.get_by_text("Present run: Restitution = ").wait_for()
        opened.append(page.evaluate(restitution))
        place = canvas.bounding_box()
        page.mouse.move(5, 5)
        middle = ring.first.evaluate("element => element.getBoundingClientRect().x + 6.5")
        assert abs(middle - place["x"] - x) < place["width"] / 8, "the ring marks the opened run"
        assert text.inner_text().startswith("Present run: ")
    assert opened[0] != opened[1]
    page.keyboard.press("Space")
    until(page, "document.body.classList.contains('playing')")  # the motion can be played
    page.locator("#stage").click(position={"x": 20, "y": 60})  # where no point is
    page.evaluate(NOTE_TEXTS)
    enter(page, "Stiffness", "1e6")
    text.get_by_text("The ring is the present run.").wait_for()
    assert any("Other parameters have changed" in map_text for map_text in page.evaluate("texts"))
    page.set_viewport_size(DESK | {"width": 1100})
    until(page, "document.getElementById('map').matches(':modal')")  # without room it covers the page
