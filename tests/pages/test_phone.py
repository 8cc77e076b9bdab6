"""The places of the parts of a page on a phone."""

# Tests: pages/browser/explore/explore.css

import pytest

from chain_impact import load_scene, simulate
from tests.pages.in_pages import ON_ITS_SIDE, PHONE, enter, impacts_of, resize, until, until_text
from tests.pages.javascript import function_of
from tests.tiers import needs_browser

pytestmark = needs_browser
OVERLAPPING_CARDS = function_of("layout", "overlappingCards")
IS_CUT_OFF = function_of("layout", "isCutOff")


def test_cards_lie_side_by_side_on_a_phone_on_its_side(show):
    """The list of impacts has the width of its table."""
    page = show(viewport=ON_ITS_SIDE, has_touch=True)
    for _ in range(2):
        for size in ((844, 390), (932, 430), (844, 500)):
            resize(page, *size)
            for scrolled in (0, 200, 400):
                page.evaluate("to => scrollTo(0, to)", scrolled)
                assert page.evaluate(OVERLAPPING_CARDS) == [], (size, scrolled)
            assert not page.evaluate(IS_CUT_OFF, "impacts"), size
        page.evaluate("document.getElementById('pin').click()")


def test_a_tap_on_an_impact_shows_the_motion(show):
    """The rows that a phone scrolls into view are not below the motion, which stays, or the controls."""
    page = show("hopper", viewport=PHONE, has_touch=True)
    for size in (PHONE, ON_ITS_SIDE):
        resize(page, **size)
        page.evaluate("scrollTo(0, 0)")
        for number in (1, 3):
            page.get_by_role("button", name=f"Go to impact {number}, ").tap(timeout=4000)
            until(page, f"document.querySelector('#impacts [aria-current]').rowIndex === {number}")
            view = page.locator("#view").bounding_box()
            assert view["y"] >= 0.0
            assert view["y"] + view["height"] <= page.locator("footer").bounding_box()["y"] + 1.0


def test_a_phone_has_links_to_the_parts_of_the_page(show):
    page = show("cart_pole", viewport=PHONE, has_touch=True)
    parts = {"Impacts": "#list", "Charts": "#inputs-card", "Parameters": "#parameters", "Motion": "h1"}
    for name, part in parts.items():
        page.locator("#jumps").get_by_role("link", name=name).tap()
        until(page, f"document.querySelector('{part}').getBoundingClientRect().top >= 0")
        stage, place = (page.locator(selector).bounding_box() for selector in ("#stage", part))
        assert place["y"] < (stage["y"] if name == "Motion" else PHONE["height"] - 200.0)
        assert name == "Motion" or place["y"] >= stage["y"] + stage["height"]
        until(page, f"document.querySelector('#jumps [aria-current]').textContent === '{name}'")


@pytest.mark.parametrize("size", [PHONE, ON_ITS_SIDE], ids=["upright", "on its side"])
def test_the_list_of_impacts_scrolls_with_the_page_of_a_phone(show, size):
    page = show(viewport=size, has_touch=True)
    rows = page.locator("#impacts tbody tr:visible")
    assert rows.count() == 10
    page.evaluate("document.querySelectorAll('#impacts tbody tr')[12].click()")
    until(page, "document.querySelector('#impacts [aria-current]').rowIndex === 13")
    assert rows.count() == 11, "the row of the present impact is shown, too"
    page.get_by_role("button", name="All 14 impacts").click()
    assert rows.count() == 14
    box = page.locator("#impacts")
    assert box.evaluate("element => element.scrollHeight <= element.clientHeight")


def test_a_phone_shows_force_and_result_beside_the_slider_that_moves(show):
    page = show(viewport=PHONE)
    tops = [page.locator(name).bounding_box()["y"] for name in ("#stage", "#contact", "#parameters", "#list")]
    assert tops == sorted(tops)
    slider = page.get_by_role("slider", name="Restitution", exact=True)
    slider.press("PageDown")
    row = page.locator(".main-parameter").filter(has=slider)
    until(page, "/largest/.test(document.querySelector('.outcome')?.textContent)")
    restitution = float(page.evaluate("chainImpact.parameters['contact.restitution']"))
    run = simulate(load_scene("four_link_box").with_values({"contact.restitution": restitution}))
    until_text(page, f"{len(run.impacts)} impact")
    peak_text = f"{run.impacts['peak_force'].max() / 1e3:.1f}\u202fkN"
    assert row.locator(".outcome").inner_text() == f"{len(run.impacts)} impacts, largest {peak_text}"


def test_a_phone_tells_the_first_step_and_marks_what_leads_to_it(show):
    page = show(viewport=PHONE, has_touch=True)
    line, parameters = page.locator("#first-steps"), page.get_by_role("link", name="Parameters")
    page.evaluate("localStorage.clear()")
    page.reload()
    until(page, "document.body.dataset.step === '0'")
    colour = "element => getComputedStyle(element).backgroundColor"
    plain = page.get_by_role("link", name="Charts").evaluate(colour)
    assert line.is_visible()
    assert parameters.evaluate(colour) != plain
    box, stage = (page.locator(name).bounding_box() for name in ("#first-steps", "#stage"))
    assert box["y"] + box["height"] <= stage["y"]
    resize(page, **ON_ITS_SIDE)
    assert line.is_hidden(), "there is no room for words"
    assert page.locator("#parameters-fold").evaluate(colour) != page.locator("#pin").evaluate(colour)
    resize(page, **PHONE)
    parameters.tap()
    page.locator("#main-parameters").get_by_role("slider").first.press("PageDown")
    until(page, "document.body.dataset.step === '1'")
    assert parameters.evaluate(colour) == plain
    page.evaluate("scrollTo(0, 0)")
    line.get_by_role("button").tap()
    assert line.is_hidden()


def test_the_status_of_a_phone_does_not_cover_the_refused_field(show):
    page = show(viewport=PHONE, has_touch=True)
    enter(page, "initial.y", "-1")
    until_text(page, "The simulation cannot start", "status")
    row = page.locator(".main-parameter", has=page.locator("input:invalid"))
    row.get_by_text("Cannot start").wait_for()
    box = row.bounding_box()
    tabs = page.locator("#jumps").bounding_box()
    assert tabs["y"] + tabs["height"] <= box["y"]
    assert box["y"] + box["height"] <= page.locator("#status").bounding_box()["y"]


@pytest.mark.parametrize("size", [PHONE, ON_ITS_SIDE], ids=["upright", "on its side"])
def test_a_phone_tells_the_whole_result_of_a_change_in_one_line(show, size):
    page = show("double_pendulum_wall", viewport=size, has_touch=True)
    page.evaluate("chainImpact.show({'contact.restitution': 0.4})")
    until_text(page, impacts_of({"contact.restitution": 0.4}, "double_pendulum_wall"))
    subtitle, title = (page.locator(name) for name in ("#subtitle", "h1"))
    assert subtitle.inner_text() == "4 impacts in 2.5 s"
    assert not page.evaluate(IS_CUT_OFF, "subtitle")
    assert subtitle.bounding_box()["y"] < title.bounding_box()["y"] + title.bounding_box()["height"]


def test_a_refused_value_on_a_phone_has_no_result_of_an_old_one(show):
    page = show(viewport=PHONE)
    page.get_by_role("slider", name="Restitution", exact=True).press("PageDown")
    outcome = page.locator(".outcome")
    until(page, "/largest/.test(document.querySelector('.outcome')?.textContent)")
    assert outcome.is_visible()
    enter(page, "contact.restitution", "2")
    assert outcome.is_hidden()


@pytest.mark.parametrize("pins", [False, True])
def test_a_phone_on_its_side_shows_force_and_motion_beside_a_slider(show, pins):
    page = show(viewport=ON_ITS_SIDE, has_touch=True)
    if pins:
        page.get_by_role("button", name="Pin").click()
    view = page.locator("#view").bounding_box()
    assert view["width"] > 560.0
    assert view["height"] > 290.0, "folded parameters leave their room to the motion"
    page.get_by_role("button", name="Parameters").click()
    names = ("#parameters", "#stage", "#contact", "footer", "#energy")
    parameters, stage, contact, foot, energy = (page.locator(name).bounding_box() for name in names)
    assert parameters["x"] < stage["x"] < contact["x"]
    for box in (stage, contact):
        assert box["y"] + box["height"] <= foot["y"] + 1.0
    name, button = (page.locator(name).bounding_box() for name in ("#contact-name", "#force-loop"))
    assert name["x"] + name["width"] <= button["x"] or name["y"] >= button["y"] + button["height"]
    chart = page.locator("#force").bounding_box()
    assert chart["y"] + chart["height"] <= contact["y"] + contact["height"]
    assert energy["width"] > 700.0, "the other charts have the whole width below"
    card = page.locator("#pins")
    assert card.evaluate("({ scrollHeight, clientHeight }) => scrollHeight === clientHeight"), (
        "all rows are seen"
    )
    page.evaluate("chainImpact.show({'simulation.stop_time': 0.2})")
    until(page, "document.querySelector('#impacts.none')")
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_phone_has_motion_pins_and_force_above_the_parameters(show, scheme):
    page = show(
        "cart_pole", hash_="#curves=energy.total", viewport=PHONE, has_touch=True, color_scheme=scheme
    )
    until(page, "document.getElementById('outputs-card').checkVisibility()")
    lower_sections = ["parameters", "outputs-card", "inputs-card", "energy-card", "list"]
    sections = function_of("layout", "sectionsDownwards")
    assert page.evaluate(sections) == ["stage", "contact", *lower_sections]
    page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'contact.restitution': 0.5})")
    until(page, "document.querySelector('#pins td small')")
    assert page.evaluate(sections) == ["stage", "pins", "contact", *lower_sections]
    sizes = "({ scrollWidth, clientWidth, scrollHeight, clientHeight }) =>"
    card = page.locator("#pins")
    assert card.evaluate(f"{sizes} [scrollWidth - clientWidth, scrollHeight - clientHeight]") == [0, 0]
    heads = card.locator("thead th").all_text_contents()[1:]
    heads_of_cells = (
        "(cells) => cells.map((element) => getComputedStyle(element, '::before').content.slice(1, -1))"
    )
    heads_of_rows = [
        row.locator("td:not(.reference)").evaluate_all(heads_of_cells)
        for row in card.locator("tbody tr").all()
    ]
    assert heads_of_rows == [heads, heads[:3]], "each number has its head above"
    displays = "(cells) => cells.map((element) => getComputedStyle(element, '::before').display)"
    assert {*card.locator("tbody td:not(.reference)").evaluate_all(displays)} == {"block"}
    cells = card.locator("tbody tr").first.locator(":is(th, td):visible").all()
    assert len(cells) == 7
    assert len({cell.bounding_box()["y"] for cell in cells}) == 3, "a name, and two lines of numbers"
    page.get_by_role("button", name="Impact by impact…").click()
    heads = page.locator("#pairs thead th")
    assert (
        heads.evaluate_all("(all) => all.map(({ scrollWidth, clientWidth }) => scrollWidth - clientWidth)")
        == [0] * 4
    )
    place = page.locator("#pairs tbody th").first.bounding_box()
    assert place["height"] < 60.0, "a place has two lines"
