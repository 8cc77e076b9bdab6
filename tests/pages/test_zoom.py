"""The zoom of the drawing: by wheel, keys and fingers, and at the present contact."""

# Tests: pages/browser/player/zoom.js, pages/browser/drawing/camera.js

import re

import numpy as np
import pytest

from chain_impact import simulate
from tests.pages.in_pages import DESK, until
from tests.tiers import needs_browser

pytestmark = needs_browser
CHAIN = """() => { const [first, second] = document.querySelectorAll("#scene .link");
  return [first.points[0], second.points[1]].map(({ x, y }) => [x, y]); }"""
FRAME = "new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)))"


def chain(page):
    """Return the positions of points 0 and 2 in the drawing [pixels]."""
    page.evaluate(FRAME)
    return np.array(page.evaluate(CHAIN))


def test_the_wheel_enlarges_at_the_pointer_and_a_drag_moves_the_drawing(show):
    page = show(viewport=DESK)
    (start, end), box = chain(page), page.locator("#view").bounding_box()
    at = (box["x"] + start[0], box["y"] + start[1])
    page.mouse.move(*at)
    page.mouse.wheel(0, -400)
    until(page, f"Math.abs(document.querySelectorAll('#scene .link')[1].points[1].x - {end[0]}) > 20")
    (enlarged_start, enlarged_end) = chain(page)
    assert enlarged_start == pytest.approx(start, abs=0.5)
    assert enlarged_end[0] - enlarged_start[0] == pytest.approx(
        2.2255 * (end[0] - start[0]), rel=1e-3
    )  # e^0.8
    page.mouse.move(box["x"] + 30, box["y"] + box["height"] - 30)
    page.mouse.down()
    page.mouse.move(box["x"] + 60, box["y"] + box["height"] - 50)
    page.mouse.up()
    assert chain(page)[0] == pytest.approx(np.add(start, [30.0, -20.0]), abs=0.5)
    page.keyboard.press("0")
    assert chain(page) == pytest.approx(np.array([start, end]))
    page.keyboard.press("+")
    assert abs(chain(page)[0] - start).max() > 1.0
    page.keyboard.press("-")
    assert chain(page) == pytest.approx(np.array([start, end]))


def test_the_contact_is_enlarged_until_its_penetration_is_seen(show):
    page = show(viewport=DESK)
    page.get_by_role("button", name="Go to impact 4, ").click()
    page.keyboard.press("z")
    page.evaluate(FRAME)
    scale = float(re.match(r"([\d.]+) mm", page.locator("#scene .bar-text").text_content())[1])
    assert scale < 20.0
    impact = simulate("four_link_box").impacts[3]
    wall, point = page.evaluate("""() => [document.querySelector("#scene .wall").points[0].y,
      document.querySelectorAll("#scene .link")[2].points[1].y]""")
    pixels = page.locator("#view").bounding_box()["width"]
    assert point - wall > 0.03 * pixels
    assert impact["max_penetration"] < 0.01
    page.get_by_role("button", name="At the contact").click()
    page.evaluate(FRAME)
    assert "mm" not in page.locator("#scene .bar-text").text_content()


def test_between_contacts_and_at_the_start_the_whole_chain_is_seen(show):
    page = show(viewport=DESK)
    page.keyboard.press("Home")
    chain_positions = chain(page)
    page.keyboard.press("z")
    assert chain(page) == pytest.approx(chain_positions), "the first contact is far"
    page.get_by_role("button", name="Go to impact 4, ").click()
    assert abs(chain(page) - chain_positions).max() > 2e3
    page.locator("#scrub").fill("0.2")
    until(page, "document.getElementById('time').textContent === '0.20000 s'")
    page.evaluate(FRAME)
    assert "mm" not in page.locator("#scene .bar-text").text_content()
    assert page.locator("#at-contact").get_attribute("title") == "Show the whole chain again (Z)"
    page.keyboard.press("Home")
    assert chain(page) == pytest.approx(chain_positions)
    assert page.locator("#scene .grip").count() > 5
