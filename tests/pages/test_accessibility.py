"""Accessibility of the pages: axe reports nothing, and a list is one stop of the keyboard."""

# Tests: pages/explore.py, pages/recorded.py, pages/browser/explore/handle_stops.js

from chain_impact import animate
from tests.pages.in_pages import until
from tests.tiers import needs_browser

pytestmark = needs_browser
FAULTS = {"resultTypes": ["violations"]}
ON_DARK = {**FAULTS, "runOnly": ["color-contrast", "link-in-text-block"]}
"""The rules of axe that depend on colours; other rules have one result for a light and a dark page."""


def assert_clean(page, part):
    from axe_playwright_python.sync_playwright import Axe  # the quick tier does not need axe

    for scheme, options in (("dark", ON_DARK), ("light", FAULTS)):
        page.emulate_media(color_scheme=scheme)
        violations = Axe().run(page, options=options).response["violations"]
        faults = [
            (violation["id"], [node["html"] for node in violation["nodes"]]) for violation in violations
        ]
        assert faults == [], (part, scheme)


def test_the_page_that_simulates_and_its_dialogs_are_clean(show):
    page = show("sliding_rod")
    assert_clean(page, "page")
    page.get_by_text("All parameters", exact=True).click()
    page.get_by_role("button", name="Pin").click()
    assert_clean(page, "list of parameters and a pinned motion")
    for button in ("Edit…", "Map…", "Chart…", "Export…", "Help"):
        page.get_by_role("button", name=button).click()
        assert_clean(page, button)
        for tab in page.locator("dialog[open] [role=tab][aria-selected=false]").all():
            tab.click()
            assert_clean(page, f"other part of {button}")
        page.keyboard.press("Escape")


def test_the_page_of_a_recording_is_clean(open_page, tmp_path):
    animate("four_link_box", tmp_path / "box.html")
    page = open_page((tmp_path / "box.html").as_uri())
    assert_clean(page, "recording")
    assert [page.title(), page.inner_text("h1")] == ["Four link box – chain-impact", "Four link box"]


def test_the_list_of_impacts_is_one_stop_of_the_key_tab(show):
    page = show()
    focused = "document.activeElement.textContent"
    page.get_by_role("button", name="Go to impact 1, ").focus()
    for key, number in (("ArrowDown", 2), ("ArrowDown", 3), ("ArrowUp", 2), ("Enter", 2)):
        page.keyboard.press(key)
        assert page.evaluate(focused) == str(number)
    until(page, "document.querySelector('#impacts [aria-current]')?.rowIndex === 2")
    page.keyboard.press("Tab")
    assert not page.evaluate("document.activeElement.matches('#impacts *')")
    page.keyboard.press("Shift+Tab")
    assert page.evaluate(focused) == "2"


def test_the_handles_are_one_stop_of_the_key_tab(show):
    page = show()
    focused = "document.activeElement.dataset.grip"
    page.get_by_role("button", name="Set the start by hand").press("Enter")
    assert page.evaluate(focused) == "joint 0"
    for key, grip in (("PageDown", "joint 1"), ("PageUp", "joint 0"), ("PageUp", "wall y_max")):
        page.keyboard.press(key)
        assert page.evaluate(focused) == grip
    page.keyboard.press("ArrowUp")
    assert page.evaluate("chainImpact.parameters['box.y_max']") != "2.5", "arrow keys move it"
    page.keyboard.press("Tab")
    assert page.evaluate(focused) is None
    page.keyboard.press("Shift+Tab")
    assert page.evaluate(focused) == "wall y_max"
