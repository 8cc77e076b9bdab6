"""Things that a reader sees: one scale in a frame, free labels, whole charts, room on all screens."""

# Tests: pages/browser/drawing/label_positions.js
# Tests: pages/browser/charts/force_chart.js, pages/browser/drawing/camera.js

import pytest

from tests.pages.in_pages import DESK, PHONE, ROWS, resize, until
from tests.pages.javascript import function_of
from tests.tiers import needs_browser

pytestmark = needs_browser
TABLET, ITS_SIDE, LOW = (
    {"width": width, "height": height} for width, height in ((820, 1180), (1024, 768), (740, 360))
)

SHARES = function_of("visibility", "shares")
"""Length of the first link over the width of the box: at first, and right after each new size is painted."""


def test_a_frame_shows_chain_and_walls_with_one_scale(show):
    shares = show().evaluate(SHARES)
    assert shares == pytest.approx([shares[0]] * 4, rel=1e-3)


def test_the_drawing_has_one_size_at_all_impacts(show):
    page = show()
    for size in (DESK, ITS_SIDE, PHONE):
        resize(page, **size)
        heights = page.evaluate(function_of("visibility", "heightsAtImpacts"))
        assert len(heights) == 1, size


def test_no_force_is_written_on_a_point_or_its_number(show):
    page = show(viewport=PHONE)
    counts = page.evaluate(function_of("visibility", "textsOnPoints"))
    assert counts["met"] == 0 < counts["texts"]


def test_the_largest_force_is_below_the_edge_of_its_chart(show):
    page = show()
    page.keyboard.press("Shift+ArrowRight")
    edge = page.evaluate("document.querySelector('#force .u-over').offsetTop")
    assert min(page.evaluate(ROWS, ["force", "force"])) > edge + 3
    page.locator("#force-loop").click()
    assert min(page.evaluate(ROWS, ["force", "force"])) > edge + 3


def test_before_its_first_motion_a_page_shows_no_chart(browser, address):
    page = browser.new_page(viewport=DESK)
    page.add_init_script("window.Worker = class { postMessage() {} terminate() {} };")
    page.goto(address)
    until(page, "document.getElementById('caption').textContent === 'Simulating…'")
    assert page.locator("#caption").is_visible()
    assert not any(section.is_visible() for section in page.locator("aside > section, #rate").all())
    page.close()


CUT = """(width) => [...document.querySelectorAll("#controls > :not([hidden])")]
  .filter((element) => !element.checkVisibility() || element.getBoundingClientRect().right > width).length"""


def test_a_bar_for_scrolling_hides_no_control(show):
    page = show(viewport=PHONE)
    page.add_style_tag(content="html { margin-right: 16px; }")
    for width in (360, 390):
        resize(page, width, 740)
        assert page.evaluate(CUT, width - 16) == 0, width


def test_a_low_phone_shows_all_controls_and_the_motion(show):
    page = show(viewport=LOW, has_touch=True)
    for size in (LOW, {"width": 844, "height": 390}):
        page.set_viewport_size(size)
        assert page.evaluate(CUT, size["width"]) == 0
        assert page.locator("#view").bounding_box()["height"] > 0.65 * size["height"]


def test_a_tablet_shows_motion_energy_force_and_impacts_at_once(show):
    page = show()
    for size in (TABLET, ITS_SIDE):
        resize(page, **size)
        top = page.locator("footer").bounding_box()["y"]
        for name in ("#view", "#energy", "#force"):
            box = page.locator(name).bounding_box()
            assert box["y"] + box["height"] <= top, (size, name)
        assert page.locator("#list-title").bounding_box()["y"] < top - 20.0, size


def test_the_list_of_impacts_takes_the_free_height_of_an_upright_tablet(show):
    page = show(viewport={"width": 900, "height": 1600})
    column, list_box = (page.locator(name).bounding_box() for name in ("aside", "#list"))
    assert list_box["y"] + list_box["height"] == pytest.approx(column["y"] + column["height"], abs=1.0)


def test_each_column_of_the_impacts_keeps_apart_and_is_in_the_list(show):
    page = show()
    for size in (DESK, ITS_SIDE, {"width": 360, "height": 740}):
        page.set_viewport_size(size)
        page.evaluate("""document.querySelector("#impacts-all:not([hidden])")?.click()""")
        gaps = page.evaluate("""[...document.querySelectorAll("#impacts tr")].flatMap((row) => {
          const boxes = [...row.cells].map((cell) => {
            const range = document.createRange();
            range.selectNodeContents(cell);
            return range.getBoundingClientRect();
          });
          return boxes.slice(1).map(({ left }, k) => left - boxes[k].right);
        })""")
        assert min(gaps) >= 4.0, size
        room = page.locator("#impacts").evaluate("(list) => list.clientWidth - list.scrollWidth")
        assert room >= 0, size


def test_runs_of_a_map_that_are_not_simulated_yet_are_paler(show):
    page = show(hash_="#simulation.stop_time=0.1")
    page.evaluate(function_of("visibility", "stopWorkers"))
    page.get_by_role("button", name="Map…").click()
    page.locator("#map-text").get_by_text("3 of 9 rows").wait_for()
    opaque = page.evaluate(function_of("visibility", "opaqueRows"))
    assert opaque.count(255) == 4, "two outer rows of one pixel, and an inner one of two"
    assert all(100 < alpha < 200 for alpha in opaque if alpha != 255)


def test_three_impacts_are_in_sight_beside_a_chart_of_inputs(show):
    page = show("cart_pole", viewport={"width": 1366, "height": 800})
    lowest = page.locator("footer").bounding_box()["y"]
    rows = [row.bounding_box() for row in page.locator("#impacts tbody tr").all()[:3]]
    assert len(rows) == 3
    assert all(row["y"] + row["height"] < lowest for row in rows)
