"""The chart of the force of a contact."""

# Tests: pages/browser/charts/force_chart.js

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from chain_impact.studies.animate import record_slowly
from tests.pages.in_pages import (
    go_to,
    packed_module,
    page_contents,
    until,
)
from tests.pages.javascript import function_of
from tests.tiers import needs_browser

pytestmark = needs_browser
COURSE = function_of("curves", "course")


def test_a_slow_contact_that_lasts_has_its_peak_in_the_course_of_its_force(worker):
    """The last impact is too slow for slow motion, and lasts until the end."""
    arguments = {"module": packed_module(), **page_contents(load_scene("four_link_box"))}
    courses = worker.evaluate(COURSE, {**arguments, "values": {"contact.restitution": 0.5}})
    peaks, highest = np.array(courses).T
    assert peaks[-1] < 20.0  # N
    assert highest == pytest.approx(peaks, rel=0.01)


def test_a_peak_soon_after_the_onset_of_a_long_contact_has_a_row(worker):
    arguments = {"module": packed_module(), **page_contents(load_scene("rocking_block"))}
    peaks, highest = np.array(worker.evaluate(COURSE, {**arguments, "values": {}})).T
    assert highest[0] == pytest.approx(peaks[0], rel=0.005)


def test_the_chart_of_a_force_has_the_number_of_its_peak(show, result):
    page = show()
    page.locator("#impacts tbody tr button").nth(1).click()
    peak = page.locator("#impacts tbody tr").nth(1).locator("td").last.inner_text()
    head, unit = page.locator("#impacts th").last.inner_text().split(", ")
    assert (head, float(peak)) == ("peak", pytest.approx(result.impacts["peak_force"][1] / 1e3, rel=5e-3))
    text, present = page.locator("#force .peak"), page.locator("#force .now")
    until(page, f"document.querySelector('#force .peak').textContent === '{peak}\u202f{unit}'")
    for onset in result.impacts["onset"][:3]:
        for delay in np.linspace(0.0, 2e-3, 9):  # the line at the present time passes the peak
            go_to(page, onset + delay)
            box, line = text.bounding_box(), present.bounding_box()
            assert line is None or not box["x"] < line["x"] < box["x"] + box["width"]


def test_a_contact_that_lasts_is_the_present_one(show):
    """The card shows the force of the contact around the present time: that of the arrow in the drawing."""
    page = show("pinned_arm", {"initial.angle[1]": np.pi / 3})
    name, row = page.locator("#contact-name"), page.locator("#impacts [aria-current] td")
    go_to(page, 0.438)
    assert name.text_content() == "impact\u00a07: point 1 at the right wall, 1.6\u202fs, its beginning"
    for time in (1.2, 2.0):
        assert go_to(page, time) == time
        assert name.text_content() == "impact\u00a07: point 1 at the right wall, 1.6\u202fs, around now"
        assert page.inner_text("#caption").startswith("Impact 7 of 10, in contact since 0.433\u202fs: ")
        assert row.first.inner_text() == "7"
        assert page.inner_text("#force .peak") == page.text_content("#scene .force-text")
    now = page.locator("#force .now").bounding_box()
    dot = page.locator("#force .loop-now").bounding_box()
    assert dot["x"] + dot["width"] / 2 == pytest.approx(now["x"] + now["width"] / 2, abs=0.6)
    go_to(page, 1.867)
    assert name.text_content().startswith("impact\u00a010: ")


def test_a_moment_after_an_impulse_has_the_number_of_its_largest_value(show):
    page = show("kneed_leg")
    go_to(page, simulate("kneed_leg").impacts["onset"][0])
    until(page, "document.querySelector('#force .peak').checkVisibility()")
    number, unit = page.inner_text("#force .peak").split("\u202f")
    assert float(number) > 0
    assert unit in {"N·m", "mN·m"}


def test_the_number_of_an_impulse_is_at_its_line_or_in_the_title_alone(show_recording):
    for model, time, is_seen in (("golf_ball", 1.2, True), ("clattering_rod", 1.2, False)):
        page = show_recording(record_slowly(model))
        go_to(page, time)
        number = page.locator("#force .peak")
        assert number.is_visible() is is_seen, model
        assert number.text_content() in page.inner_text("#contact-name")
