"""Labels, controls and cards do not overlap, by their boxes in the browser."""

# Tests: pages/explore.py, pages/browser/player/folding.js, pages/browser/explore/folded_energies.js
# Tests: pages/browser/explore/parameters/outcome.js, pages/browser/explore/jumps.js

import pytest

from chain_impact import simulate
from tests.pages.in_pages import DESK, ON_ITS_SIDE, PHONE, go_to, impacts_of, resize, until, until_text
from tests.pages.javascript import function_of
from tests.tiers import needs_browser

pytestmark = needs_browser
SIZES = [{"width": 360, "height": 800}, PHONE, ON_ITS_SIDE, {"width": 768, "height": 1024}]
SCENES = {
    "pinned_arm": {"inputs.joint_targets": True, "outputs.loads": True},
    "bouncing_table": {"simulation.stop_time": 0.3},
}
DIALOGS = ("edit", "map", "curves", "export", "help")
CLASHES = function_of("layout", "clashes")
"""Overlapping pairs of controls and texts among elements that scroll together."""
IS_CUT_OFF = function_of("layout", "isCutOff")


@pytest.mark.parametrize("model", SCENES)
def test_no_label_runs_into_a_control(show, model):
    page = show(model, SCENES[model], viewport=SIZES[0], has_touch=True)
    page.evaluate("location.hash = '#curves=point[*].*y,impact.count&gravity.y=-9.5'")
    until(page, "document.querySelectorAll('#outputs-over-time dt.of-curve').length > 5")
    page.evaluate("document.querySelector('summary').click(), document.getElementById('pin').click()")
    for size in SIZES:
        page.set_viewport_size(size)
        until(page, f"({CLASHES})().length === 0")
        for name in DIALOGS:
            page.evaluate(f"document.getElementById('{name}-open').click()")
            until(page, f"({CLASHES})().length === 0")
            page.keyboard.press("Escape")
    page.add_style_tag(content=".main-parameter-label { white-space: nowrap; font-size: 50px; }")
    assert any("contact.stiffness" in clash for clash in page.evaluate(CLASHES)), (
        "what runs into a control is found"
    )


def test_the_forces_in_joints_are_within_the_list_of_impacts(show):
    page = show("pinned_arm", {"outputs.loads": True})
    for width, height in ((1400, 900), (1000, 700), (390, 844), (844, 390)):
        page.set_viewport_size({"width": width, "height": height})
        assert page.locator("#impacts th").count() == 8
        assert not page.evaluate(IS_CUT_OFF, "impacts")
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_the_head_of_the_page_stays_one_line(show):
    """With a long subtitle and all buttons, the first steps are cut, but not their button."""
    page = show(viewport={"width": 1366, "height": 800})
    page.evaluate("localStorage.clear()")
    page.reload()
    until(page, "document.getElementById('subtitle').textContent")
    parts = [page.locator(name) for name in ("h1", "#view")]
    heights = [part.bounding_box()["height"] for part in parts]
    changes = {"contact.restitution": 0.5, "simulation.stop_time": 10.0}
    page.evaluate("changes => chainImpact.show(changes)", changes)
    until_text(page, "in 10")
    assert [part.bounding_box()["height"] for part in parts] == heights
    close, actions = (page.locator(name).bounding_box() for name in ("#first-steps button", "#actions"))
    assert close["x"] + close["width"] <= actions["x"]
    for width in (1300, 1000, 800):
        resize(page, width, 800)
        assert parts[0].bounding_box()["height"] == heights[0]
        actions = page.locator("#actions").bounding_box()
        assert actions["x"] + actions["width"] <= width


def test_no_first_step_asks_for_a_slider_that_the_map_hides(show):
    page = show(viewport={"width": 1366, "height": 800})
    page.evaluate("localStorage.clear()")
    page.reload()
    until(page, "document.getElementById('subtitle').textContent")
    first_step = page.locator("#first-steps")
    slider = page.get_by_role("slider", name="Restitution", exact=True)
    page.get_by_role("button", name="Map…").click()
    assert [first_step.is_visible(), slider.is_visible()] == [False, False]
    page.locator("#map-fold").click()
    assert [first_step.is_visible(), slider.is_visible()] == [True, True]


def test_the_number_of_a_joint_is_whole_in_the_list_of_impacts(show):
    page = show("kneed_leg")
    cell = page.locator("#impacts td:nth-child(3)").first
    for viewport in (DESK, PHONE):
        page.set_viewport_size(viewport)
        assert cell.inner_text() == "joint 3"
        assert cell.evaluate("({ scrollWidth, clientWidth }) => scrollWidth <= clientWidth")


def test_cards_follow_each_other_as_keys_do_the_contact_force_first(show):
    """The list of impacts follows the contact force on a wide screen, and comes last on a phone."""
    page = show("cart_pole", hash_="#curves=point[1].y")
    until(page, "document.querySelectorAll('#outputs-over-time dt.of-curve').length > 0")
    order = ["contact-title", "outputs-title", "inputs-title", "energy-title"]
    for viewport in (DESK, PHONE):
        resize(page, **viewport)
        cards = page.locator("aside > section:not(#list)").evaluate_all(
            "cards => cards.map((card) => [card.querySelector('h2').id, card.getBoundingClientRect().top])"
        )
        assert [name for name, _ in cards] == order, viewport
        assert cards == sorted(cards, key=lambda card: card[1]), viewport


def test_the_labels_of_sliders_have_one_line_on_a_desk(show):
    heights = (
        show(viewport=DESK)
        .locator(".main-parameter-label")
        .evaluate_all("labels => labels.map((label) => [label.textContent, label.offsetHeight])")
    )
    assert len(heights) > 4
    assert [label for label in heights if label[1] > 1.5 * heights[0][1]] == []


def test_a_large_screen_leaves_no_card_empty_and_no_unit_alone(show):
    page = show("controlled_arm", viewport={"width": 1920, "height": 1080})
    until(page, "document.querySelector('#energies dd')")
    card, legend = (page.locator(name).bounding_box() for name in ("#energy-card", "#energies"))
    assert card["y"] + card["height"] - legend["y"] - legend["height"] < 20.0
    heights = page.locator(".main-parameter-label, .parameter small").evaluate_all(
        "all => all.map(({ offsetHeight }) => offsetHeight)"
    )
    assert max(heights) < 28


@pytest.mark.parametrize(("size", "is_open"), [((1920, 1080), True), ((1366, 768), False)])
def test_all_parameters_are_shown_at_once_where_they_have_room(show, size, is_open):
    page = show(viewport=dict(zip(("width", "height"), size, strict=True)))
    until(page, f"document.getElementById('list-of-parameters').open === {str(is_open).lower()}")
    assert page.locator("#main-parameters").bounding_box()["y"] > 0.0
    assert page.locator("#parameters").evaluate("element => element.scrollTop") == 0
    assert page.locator("#list-of-parameters .parameter").first.is_visible() is is_open


def test_the_help_needs_no_scrolling_on_a_desk(show):
    page = show(viewport=DESK)
    page.keyboard.press("?")
    assert page.evaluate(
        "(({ scrollHeight, clientHeight }) => scrollHeight <= clientHeight)(document.getElementById('help'))"
    )


@pytest.mark.parametrize("kind", ["inputs", "outputs", "pins"])
def test_charts_and_impacts_have_room_in_a_low_window(show, kind):
    hash_ = {
        "inputs": "#joint[2].torque@=0.5:8.64",
        "outputs": "#curves=point[*].y,contact[*].*.force",
        "pins": "",
    }
    page = show("pinned_arm" if kind == "inputs" else "four_link_box", hash_=hash_[kind])
    if kind == "pins":
        page.get_by_role("button", name="Pin").click()
    heights = "charts => charts.map((element) => element.clientHeight).filter(Boolean)"
    assert min(page.locator("aside .chart .u-over").evaluate_all(heights)) >= 90
    rows, left = page.evaluate("""(() => {
      const boxOf = (id) => document.getElementById(id).getBoundingClientRect();
      const [list, card] = [boxOf("impacts"), boxOf("list")];
      const row = document.querySelector("#impacts tbody tr").offsetHeight;
      return [Math.round((list.height - 20) / row), card.bottom - list.bottom];
    })()""")
    assert rows >= (5 if kind == "pins" else 3)
    assert page.locator("#impacts tbody tr").count() > 3
    assert left < 24 + 8, "there is room for one more row"


@pytest.mark.parametrize("card", ["inputs", "outputs"])
def test_chosen_charts_lie_beside_five_impacts_not_below_them(show, card):
    hash_ = {"inputs": "#joint[2].torque@=0.5:8.64", "outputs": "#curves=point[2].y"}
    page = show("pinned_arm" if card == "inputs" else "", hash_=hash_[card])
    if card == "outputs":
        page.get_by_role("button", name="Pin").click()
    page.locator(f"#{card}-over-time canvas").wait_for()
    names = ("aside", "#list", f"#{card}-card", "#impacts")
    column, list_, chart, rows = (page.locator(name).bounding_box() for name in names)
    row = page.locator("#impacts tbody tr").first.bounding_box()
    assert rows["height"] >= 20 + 5 * row["height"]
    page.keyboard.press("End")
    until(page, "document.querySelector('#impacts tbody tr:last-child').ariaCurrent === 'true'")
    visible_rows = page.locator("#impacts tbody tr:visible")
    assert visible_rows.count() == 5
    assert visible_rows.last.get_attribute("aria-current") == "true", (
        "the list follows the motion without scrolling"
    )
    assert page.locator("#impacts").evaluate("element => element.scrollHeight - element.clientHeight") == 0
    assert list_["y"] + list_["height"] <= chart["y"]
    assert chart["y"] + chart["height"] <= column["y"] + column["height"]
    until(page, "document.getElementById('energy-card').matches('.folded')")
    page.get_by_role("button", name="Energy", exact=True).click()
    page.locator("#energies").scroll_into_view_if_needed()
    energies, list_ = (page.locator(name).bounding_box() for name in ("#energies", "#list"))
    assert list_["y"] + list_["height"] <= energies["y"], "the column scrolls as one"
    page.get_by_role("button", name="Energy", exact=True).click()
    assert not page.locator("#energy").is_visible(), "a title folds its card"
    page.get_by_role("button", name="Energy", exact=True).click()
    assert page.locator("#energy canvas").bounding_box()["height"] > 90


@pytest.mark.parametrize("size", [(1366, 768), (1280, 720)])
def test_the_end_of_the_column_cuts_no_card_of_a_scene_with_signals(show, size):
    """The chart of the inputs is open; the energies are folded until the reader opens them."""
    page = show("hopper", viewport=dict(zip(("width", "height"), size, strict=True)))
    energy = page.get_by_role("button", name="Energy", exact=True)
    until(page, "document.getElementById('energy-card').matches('.folded')")
    assert page.locator("aside").evaluate("element => element.scrollHeight - element.clientHeight") == 0
    assert page.locator("#inputs-over-time canvas").bounding_box()["height"] > 90
    column, title = (page.locator(name).bounding_box() for name in ("aside", "#energy-title"))
    assert title["y"] + title["height"] <= column["y"] + column["height"]
    energy.click()
    assert page.locator("#energy").is_visible()
    page.reload()
    until(page, "document.getElementById('energy-card').matches('.folded')")
    page.set_viewport_size({"width": 1920, "height": 1080})
    until(page, "!document.getElementById('energy-card').matches('.folded')")


@pytest.mark.parametrize("hash_", ["", "#curves=point[4].y,contact[2].y_min.force"], ids=["", "outputs"])
def test_no_combination_of_pins_outputs_and_messages_cuts_a_card(show, hash_):
    """The runs have few impacts, many, or stop early; the column fades where parts are out of sight."""
    page, sizes = show(hash_=hash_), ((1366, 800), (1280, 720), (390, 844))
    faults = [*(function_of("layout", name) for name in ("overlappingCards", "overfullCards")), CLASHES]
    for pins in range(3):
        for restitution, stiffness in ((0.7, 1e8), (0.5, 1e8), (0.5, 1e32)):
            values = {"contact.restitution": restitution, "contact.stiffness": stiffness}
            page.evaluate("values => chainImpact.show(values)", values)
            is_status_shown = "document.getElementById('status').checkVisibility()"
            until(page, is_status_shown if stiffness > 1e8 else f"!{is_status_shown}")
            until_text(page, "1 impact in" if stiffness > 1e8 else impacts_of(values))
            for size in sizes:
                resize(page, *size)
                assert [page.evaluate(fault) for fault in faults] == [[], [], []], (pins, values, size)
        for size in sizes:
            resize(page, *size)
            column = page.locator("aside")
            column.evaluate("element => element.scrollTo(0, 0)")
            until(page, "!document.querySelector('aside').matches('.more-above')")
            is_more_below = column.evaluate(
                "element => [element.scrollHeight > element.clientHeight, element.matches('.more-below')]"
            )
            assert is_more_below[0] == is_more_below[1], (pins, size)
            if is_more_below[0]:
                column.evaluate("element => element.scrollTo(0, 1e4)")
                until(page, "document.querySelector('aside').matches('.more-above:not(.more-below)')")
        page.get_by_role("button", name="Pin").click()


CUT_CHARTS = function_of("layout", "cutCharts")


@pytest.mark.parametrize(
    ("model", "hash_"),
    [
        ("four_link_box", ""),
        ("cart_pole", ""),
        ("stick_slip_belt", ""),
        ("four_link_box", "#curves=point[*].y,contact[*].y_min.force"),
    ],
)
def test_the_list_of_impacts_covers_no_part_of_a_chart(show, model, hash_):
    page = show(model, hash_=hash_)
    for width, height in ((1366, 768), (1280, 720), (1440, 900)):
        page.set_viewport_size({"width": width, "height": height})
        until(page, f"({CUT_CHARTS})().length === 0")
        heights = page.locator("aside .chart").evaluate_all(
            "all => all.map((element) => element.clientHeight)"
        )
        assert min(height for height in heights if height) >= 90 + 26 + 8, "with the axis of the time"
        force, list_ = (page.locator(name).bounding_box() for name in ("#force", "#list"))
        assert force["y"] + force["height"] <= list_["y"], "the force is in sight, whatever else is shown"
    if page.locator("#energy-card.folded").count():
        page.get_by_role("button", name="Energy", exact=True).click()
    page.locator("aside").evaluate("column => column.scrollTo(0, 1e4)")
    until(page, "document.getElementById('energy').clientHeight >= 124")


def test_a_page_without_impacts_is_as_wide_as_the_screen(show):
    page = show(hash_="#simulation.stop_time=0.2")
    until(page, "document.querySelector('#impacts.none')")
    page.evaluate("chainImpact.show({'simulation.stop_time': 0.1})")
    until(page, "document.getElementById('impacts-before').textContent")
    for size in (*SIZES, DESK):
        resize(page, **size)
        assert page.locator("#contact").is_hidden(), size
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), size
        assert page.locator("#list").bounding_box()["width"] > 250.0, size


def test_a_title_of_three_lines_covers_no_legend(show):
    page = show()
    for changes in ({}, {"contact.restitution": 0.5}, {"contact.restitution": 0.3}):
        page.evaluate("changes => chainImpact.show(changes)", changes)
        until_text(page, impacts_of(changes))
        page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'contact.model': 'newton_impact'})")
    until_text(page, impacts_of({"contact.model": "newton_impact", "contact.restitution": 0.3}))
    page.get_by_role("button", name="Go to impact 3, ").click()
    until(page, "document.getElementById('contact-title').clientHeight > 50")
    energies, impacts = (page.locator(name).bounding_box() for name in ("#energies", "#list"))
    assert energies["y"] + energies["height"] <= impacts["y"]
    assert page.locator("#impacts tbody tr").nth(2).is_visible()


def test_the_caption_beside_the_motion_is_whole_and_has_no_gap_above(show):
    """A phone on its side has a narrow column for the clock."""
    page = show("four_link_box", viewport={"width": 667, "height": 375})
    go_to(page, 0.5)
    room, caption = (page.locator(name).bounding_box() for name in ("#caption-room", "#caption"))
    assert caption["y"] == room["y"]
    assert page.locator("#caption").evaluate("element => element.scrollHeight <= element.clientHeight + 1")


@pytest.mark.parametrize("model", ["four_link_box", "cart_pole", "hopper", "stick_slip_belt"])
def test_the_sentence_on_an_impact_stays_within_its_card(show, model):
    is_whole = "text => text.scrollWidth <= text.clientWidth && text.scrollHeight <= text.clientHeight + 1"
    page = show(model, viewport=DESK)
    go_to(page, 0.5)
    assert page.locator("#contact-name").evaluate(is_whole)
    page = show(model, viewport=PHONE, has_touch=True)
    heights = {
        page.locator("#clock").bounding_box()["height"] for time in (0.0, 0.5) if go_to(page, time) == time
    }
    assert len(heights) == 1, "the drawing does not move"
    for sentence in ("#contact-name", "#caption"):
        assert page.locator(sentence).evaluate(is_whole), f"no word of {sentence} is cut"
    stage, caption = (page.locator(name).bounding_box() for name in ("#stage", "#caption"))
    assert caption["x"] + caption["width"] <= stage["x"] + stage["width"] - 10.0


def test_the_map_is_whole_in_a_low_window(show):
    page = show(viewport=ON_ITS_SIDE)
    page.get_by_role("button", name="Map…").click()
    chart, button = (page.locator(name).bounding_box() for name in ("#map-canvas", "#map-run"))
    assert chart["height"] > 150.0
    assert chart["y"] + chart["height"] < ON_ITS_SIDE["height"]
    assert chart["x"] > button["x"] + button["width"]
    is_whole = "({ scrollHeight, clientHeight }) => scrollHeight <= clientHeight"
    assert page.locator("#map-text").evaluate(is_whole), "the text below the fields, too"
    page.keyboard.press("Escape")
    page.keyboard.press("?")
    dialog, foot = (page.locator(name).bounding_box() for name in ("#help", "#help form"))
    assert foot["y"] + foot["height"] == pytest.approx(dialog["y"] + dialog["height"], abs=1.0)


def test_the_editor_shows_all_links_and_its_refusals_in_a_low_window(show):
    page = show(viewport=ON_ITS_SIDE, has_touch=True)
    page.get_by_role("button", name="Edit…").click()
    foot, row = (page.locator(name).last.bounding_box() for name in ("#edit form", "#edit-links tbody tr"))
    assert row["y"] + row["height"] < foot["y"]
    field = page.locator("#edit").get_by_role("textbox", name="link[1].mass")
    field.fill("heavy")
    field.press("Enter")
    refusal, foot = (page.locator(name).bounding_box() for name in ("#edit .told .refusal", "#edit form"))
    assert refusal["width"] > 100.0
    assert refusal["y"] + refusal["height"] < foot["y"] + 8.0


def test_few_impacts_leave_their_room_to_the_charts(show):
    page = show("kneed_leg")
    energy, row, foot = (
        page.locator(name).bounding_box() for name in ("#energy", "#impacts tbody tr", "footer")
    )
    assert energy["height"] > 170.0
    assert row["y"] + row["height"] < foot["y"]


def test_a_narrow_list_of_impacts_has_whole_rows_and_the_present_one(show):
    page = show("cart_pole", viewport={"width": 1100, "height": 800})  # narrow, as with the bar for scrolling
    page.keyboard.press("End")
    place = "list => [list.scrollHeight - list.clientHeight, list.querySelector('thead').clientHeight]"
    assert page.locator("#impacts").evaluate(place) == [0, 20], "without a gap below the title"
    page.goto("about:blank")
    page = show(viewport=DESK)
    bottom, *bottoms = page.locator("#impacts, #impacts tbody tr").evaluate_all(
        "all => all.map((element) => element.getBoundingClientRect().bottom)"
    )
    visible_count = sum(row <= bottom + 1 for row in bottoms)
    assert visible_count < 14
    assert page.inner_text("#impacts-seen") == f"{visible_count} of 14 in view"
    page.keyboard.press("End")
    page.keyboard.press("p")  # the rows of the pin take the place of rows of the list
    page.locator("#pins tbody tr").first.wait_for()
    until(page, "document.querySelector('tr[aria-current] button').textContent === '14'")
    boxes = (page.locator(name).bounding_box() for name in ("#impacts", "tr[aria-current]"))
    list_, row = ((box["y"], box["y"] + box["height"]) for box in boxes)
    assert list_[0] <= row[0] < row[1] <= list_[1] + 1


def test_impacts_stay_in_sight_below_chosen_curves(show):
    page = show(hash_="#curves=point[*].y,link[1].angle", viewport={"width": 1366, "height": 800})
    page.get_by_role("button", name="Pin").click()
    column = page.locator("aside")
    until(page, "document.querySelector('aside').scrollHeight > document.querySelector('aside').clientHeight")
    assert column.evaluate("element => element.scrollTop") == 0
    row, pins = (page.locator(name).first.bounding_box() for name in ("#impacts tbody tr", "#pins"))
    assert row["y"] + row["height"] < pins["y"]
    page.evaluate("chainImpact.show({'contact.restitution': 0.5})")
    until(page, "/^from A: 14 → 52, /.test(document.getElementById('impacts-before').textContent)")
    page.get_by_role("button", name="All 52 impacts").wait_for()
    assert page.evaluate(CLASHES) == []


@pytest.mark.parametrize(("model", "viewport"), [("hopper", DESK), ("four_link_box", PHONE)])
def test_the_line_on_an_impact_is_whole_before_the_impact_and_in_it(show, model, viewport):
    page = show(model, viewport=viewport)
    for onset in simulate(model).impacts["onset"][:5]:
        for time_before, words in ((1e-3, "Next is impact "), (-1e-4, " m/s, ")):
            go_to(page, onset - time_before)
            assert words in page.inner_text("#caption").replace("\u202f", " ").replace("\u2060", "")
            assert not page.evaluate(IS_CUT_OFF, "caption"), page.inner_text("#caption")


def test_a_long_name_of_a_point_cuts_no_number_of_the_list(show):
    page = show("hopper")
    until(page, "document.querySelectorAll('#impacts tbody tr').length > 2")
    for width in (1280, 1366):
        resize(page, width, 800)
        page.evaluate("document.querySelector('#impacts td:nth-child(3)').textContent = '14 (left heel)'")
        is_whole = "({ scrollWidth, clientWidth }) => scrollWidth <= clientWidth"
        assert page.locator("#impacts").evaluate(is_whole), width
