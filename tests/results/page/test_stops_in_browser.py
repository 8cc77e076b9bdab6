"""The page of an arm with stops in a browser: the range of its joint, the mark at a stop, and the units."""

import pytest

from chain_impact.results.animate import animate
from chain_impact.studies.animate import record_slowly
from tests.stops import knee
from tests.tiers import needs_browser

pytestmark = needs_browser


@pytest.fixture(scope="module")
def page(browser, tmp_path_factory):
    path, said = tmp_path_factory.mktemp("page") / "knee.html", []
    animate(record_slowly(knee()), path)
    page = browser.new_page(viewport={"width": 1280, "height": 760}, reduced_motion="reduce")
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda error: said.append(str(error)))
    page.goto(path.as_uri())
    page.wait_for_function("performance.getEntriesByName('first-frame').length === 1")
    yield page
    page.close()
    assert said == []


def test_a_joint_with_stops_has_an_arc_with_a_mark_at_each(page):
    assert page.locator("polyline.range").count() == 1
    assert page.locator("polyline.range-mark").count() == 2
    assert page.locator(".stop-dot").count() == 0, "in flight"


def test_an_impact_at_a_stop_is_told_in_the_units_of_the_angle(page):
    row = page.locator("tbody tr").first.inner_text()
    assert "joint_min" in row
    assert "rad/s" in row
    assert "N\u202fm" in row
    page.get_by_role("button", name="Go to impact 1, ").click()
    for _ in range(4):
        page.keyboard.press("ArrowRight")
    page.wait_for_selector(".stop-dot")
    assert page.locator(".stop-dot").count() == 1
    assert page.locator(".force-text").text_content().endswith("N\u202fm")
    assert page.inner_text("#caption").startswith("Impact 1 of ")
    assert ": joint 2 at joint_min, " in page.inner_text("#caption")
    assert "joint 2 at joint_min" in page.text_content("#close-what")


def test_an_impact_at_a_wall_keeps_its_units(page):
    row = next(text for text in page.locator("tbody tr").all_inner_texts() if "x_max" in text)
    assert "m/s" in row
    assert "N\u202fm" not in row
