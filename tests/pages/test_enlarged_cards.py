"""Enlarged cards: charts that show a part of the time, and the list of impacts with more columns."""

# Tests: pages/browser/player/enlarged_cards.js

import pytest

from tests.pages.in_pages import (
    PIXELS,
    time_of,
    until,
)
from tests.tiers import needs_browser

pytestmark = needs_browser


CHARTS = ("#force", ".curve-chart", "#energy")
OUTPUTS = "#curves=point[4].y,impact.count"


def enlarge(page, chart):
    """Enlarge the first of the charts of a kind."""
    page.locator(f"section:has({chart}) .enlarge").click()
    until(page, f"document.querySelector('{chart}').clientWidth > 400")


def show_enlarged(show, chart):
    """Return a page in which the first of the charts of a kind is enlarged."""
    page = show(hash_=OUTPUTS)
    enlarge(page, chart)
    return page


def zoom_in(page, chart):
    """Drag over a fifth of an enlarged chart, which then shows this part of the time; return the box."""
    plot = page.locator(f"{chart} .u-over").first.bounding_box()
    left, width, y = plot["x"], plot["width"], plot["y"] + 20
    page.mouse.move(left + 0.2 * width, y)
    page.mouse.down()
    page.mouse.move(left + 0.4 * width, y, steps=2)
    page.mouse.up()
    until(page, f"document.querySelector('{chart}').classList.contains('zoomed')")
    return plot


def test_an_enlarged_chart_stands_below_a_smaller_motion(show):
    page = show(hash_=OUTPUTS)
    for chart in CHARTS:
        if chart == "#energy":
            page.get_by_role("button", name="Energy", exact=True).click()
        chart_box, stage = (page.locator(selector).first.bounding_box() for selector in (chart, "#stage"))
        enlarge(page, chart)
        plot, smaller_stage = (
            page.locator(selector).first.bounding_box() for selector in (f"{chart} .u-over", "#stage")
        )
        assert smaller_stage["y"] + smaller_stage["height"] < plot["y"] < stage["y"] + stage["height"], chart
        page.keyboard.press("Escape")
        until(page, f"document.querySelector('{chart}').clientWidth < 400")
        assert page.locator(chart).first.bounding_box() | {"y": 0} == chart_box | {"y": 0}, chart


def test_a_drag_and_keys_show_a_part_of_the_time(show):
    page = show(hash_=OUTPUTS)
    for chart in CHARTS:
        enlarge(page, chart)
        zoom_in(page, chart)
        page.keyboard.press("Escape")
        page.locator(f"{chart}.zoomed").first.wait_for(state="detached")
        page.locator(chart).first.focus()
        page.keyboard.press("+")
        page.locator(f"{chart}.zoomed").first.wait_for()
        page.keyboard.press("-")
        page.locator(f"{chart}.zoomed").first.wait_for(state="detached")


def test_charts_of_outputs_show_the_same_part_and_tell_the_present_values(show):
    page = show_enlarged(show, ".curve-chart")
    zoom_in(page, ".curve-chart")  # the present time, 0, is outside
    assert page.locator(".curve-chart.zoomed").count() == 2
    assert page.locator("#outputs-over-time dd").first.inner_text() == "1.591\u202fm"
    assert set(page.locator("#outputs-over-time .unit").all_inner_texts()) == {"at 0.00000\u202fs"}


def test_a_click_into_a_part_of_the_time_goes_there(show):
    page = show_enlarged(show, "#energy")
    plot, time_text = zoom_in(page, "#energy"), page.locator("#time").inner_text()
    page.mouse.click(plot["x"] + 0.5 * plot["width"], plot["y"] + 20)
    until(page, f"document.getElementById('time').textContent !== '{time_text}'")
    assert time_of(page) == pytest.approx(0.6, abs=0.01)


def test_a_click_on_a_term_hides_its_curve(show):
    page = show_enlarged(show, "#energy")
    term = page.get_by_role("button", name="dissipated")
    for is_shown in (False, True):
        term.click()
        assert (page.evaluate(PIXELS, ["energy", "dissipated"]) > 20) is is_shown


def test_an_enlarged_list_of_impacts_has_more_columns(show, result):
    page = show()
    page.locator("#list .enlarge").click()
    heads, row = page.locator("#impacts thead th"), page.locator("#impacts tbody tr").first.locator("td")
    assert heads.all_inner_texts()[-3:] == ["duration, ms", "penetration, mm", "impulse, N·s"]
    first = result.impacts[0]
    expected = [1e3 * first["duration"], 1e3 * first["max_penetration"], first["impulse"]]
    assert [float(text) for text in row.all_inner_texts()[-3:]] == pytest.approx(expected, rel=5e-3)
