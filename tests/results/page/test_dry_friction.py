"""Dry friction in the page of a recording: arrows that lean, and marks of what sticks."""

import math
import re

import pytest

from chain_impact.results.animate import animate
from chain_impact.studies.animate import record_slowly
from tests.friction import SLOPE, pendulum, sled
from tests.tiers import needs_browser

SLIDES, STICKS = 0.5, 1.5  # s, of the sled
WEIGHT = 1.2 * 9.81  # N


@pytest.fixture
def show(browser, tmp_path):
    """Open the page of a scene at a time, which must not complain."""
    said, opened = [], []

    def show(scene, time):
        path = tmp_path / "page.html"
        animate(record_slowly(scene), path)
        page = browser.new_page(viewport={"width": 1280, "height": 760}, reduced_motion="reduce")
        opened.append(page)
        page.on("console", lambda message: said.append(message.text))
        page.on("pageerror", lambda error: said.append(str(error)))
        page.goto(path.as_uri())
        page.wait_for_function("performance.getEntriesByName('first-frame').length === 1")
        set_time = "(e, t) => { e.value = t; e.dispatchEvent(new Event('input', { bubbles: true })); }"
        page.locator("#scrub").evaluate(set_time, time)
        page.wait_for_function(
            f"Math.abs(parseFloat(document.getElementById('time').textContent) - {time}) < 0.02"
        )
        return page

    yield show
    for page in opened:
        page.close()
    assert said == []


def lean(page):
    """The angle [rad] from upright of the arrow of the first force, positive to the left."""
    x1, y1, x2, y2 = (
        float(page.locator("line.arrow").first.get_attribute(name)) for name in ("x1", "y1", "x2", "y2")
    )
    return math.atan2(x1 - x2, y1 - y2)


@needs_browser
def test_arrows_lean_against_the_motion_and_a_bar_shows_what_sticks(show):
    page = show(sled(), SLIDES)
    assert lean(page) == pytest.approx(math.atan(0.5) - SLOPE, abs=0.01)
    assert page.locator(".stick-bar").count() == 0
    page = show(sled(), STICKS)
    assert lean(page) == pytest.approx(0.0, abs=0.01), "it holds the weight"
    assert page.locator(".stick-bar").count() == 2
    told = [float(re.match(r"[\d.]+", text)[0]) for text in page.locator(".force-text").all_text_contents()]
    assert told == pytest.approx([0.5 * WEIGHT] * 2, abs=0.01)
    assert page.text_content("#close-what").endswith("brown: friction")
    assert "friction" in page.text_content("#energies")


@needs_browser
def test_a_full_dot_shows_a_joint_that_sticks(show):
    assert show(pendulum(), 0.2).locator(".stuck-joint").count() == 0
    assert show(pendulum(), 0.6).locator(".stuck-joint").count() == 1
    assert show(pendulum(), 3.0).locator(".stuck-joint").count() == 2
