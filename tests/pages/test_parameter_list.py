"""The list of all parameters: its groups, its search, and choices."""

# Tests: pages/browser/explore/parameters/parameter_list.js

import pytest

from tests.pages.in_pages import DESK, PHONE, enter, impacts_of, until, until_text
from tests.pages.javascript import function_of
from tests.tiers import needs_browser

pytestmark = needs_browser


BOX_OF = "((element) => element.getBoundingClientRect())"
IN_SIGHT = function_of("parameter_list", "rowsInSight")


@pytest.mark.parametrize("viewport", [DESK, PHONE], ids=["desk", "phone"])
def test_the_list_of_all_parameters_comes_into_sight_when_it_opens(show, viewport):
    page = show(viewport=viewport)
    page.locator("summary", has_text="All parameters").click()
    until(page, f"({IN_SIGHT})() > 4")


def test_the_row_of_a_refused_value_is_marked_in_the_list(show):
    page = show()
    page.locator("summary", has_text="All parameters").click()
    row = page.locator(".parameter", has=page.get_by_role("textbox", name="link[2].mass"))
    styles = "[row, row.querySelector('.parameter-name')].map((element) => getComputedStyle(element))"
    look = f"row => {styles}.map(({{ boxShadow, color }}, k) => (k ? color : boxShadow))"
    usual_look = row.evaluate(look)
    field = row.get_by_role("textbox")
    field.fill("heavy")
    field.press("Tab")
    assert all(
        look_now != look_before for look_now, look_before in zip(row.evaluate(look), usual_look, strict=True)
    )
    field.press("Escape")
    assert row.evaluate(look) == usual_look


def test_the_fields_of_the_list_have_room_for_their_numbers(show):
    page = show("triple_pendulum")
    fields = page.locator(".parameter input")
    fields.first.wait_for()
    assert {"1.0004e-4", "-9.80834"} <= {field.input_value() for field in fields.all()}
    assert (
        fields.evaluate_all(
            "all => all.filter((element) => element.scrollWidth > element.clientWidth).length"
        )
        == 0
    )


def test_the_list_has_every_parameter_and_is_searched(show):
    page = show()
    page.locator("summary", has_text="All parameters").click()
    rows = page.locator(".parameter")
    rows.first.wait_for()
    assert rows.count() == page.evaluate("Object.keys(chainImpact.parameters).length") > 50
    row = rows.filter(has_text="link[2].\u200bmass").first
    row.locator("input").fill("heavy")
    row.locator("input").press("Enter")
    refusal_text = (
        "Not taken: Mass of link 2 = heavy must be a finite number >\xa00 [kg]. The motion has 1\u202fkg."
    )
    assert row.locator(".refusal").inner_text() == refusal_text
    page.get_by_role("slider", name="Restitution").press("ArrowLeft")
    assert row.locator("input").input_value() == "1", "another change shows the value that holds"
    assert not row.locator(".refusal").is_visible()
    page.get_by_role("button", name="Reset all").click()
    page.get_by_role("searchbox").fill("link 2 mass")
    visible = [row.inner_text() for row in rows.all() if row.is_visible()]
    assert any("mass" in text for text in visible)
    assert len(visible) < 4
    enter(page, "link[2].mass", "3")
    until_text(page, impacts_of({"link[2].mass": 3.0}))
    page.get_by_role("searchbox").fill("no such thing")
    assert page.get_by_text("No parameter has such a name.").is_visible()


def test_words_and_keys_find_a_parameter(show):
    page = show()
    page.locator("summary", has_text="All parameters").click()
    visible_keys = page.locator(".parameter:visible .key")
    for search_text, expected in {
        "initial height": {"initial.y"},
        "mass of link 2": {f"link[2].{key}" for key in ("mass", "center_of_mass", "inertia")},
        "link[2].mass": {"link[2].mass"},
        "position right wall": {"box.x_max"},
        "Contact LAW": {"contact.model"},
    }.items():
        page.get_by_role("searchbox").fill(search_text)
        assert expected <= {key.replace("\u200b", "") for key in visible_keys.all_inner_texts()}, search_text
        assert visible_keys.count() < 4, search_text


def test_the_list_has_groups_with_titles_and_the_changed_ones_first(show):
    page = show("pinned_arm", hash_="#link[2].mass=2")
    page.locator("summary", has_text="All parameters").click()
    titles = page.locator(".parameters h2:visible")
    expected = [
        "Changed",
        "Gravity",
        "Link 1",
        "Link 2",
        "Box",
        "Contact",
        "Start",
        "Solver",
        "Inputs",
        "Simulation",
    ]
    assert titles.all_inner_texts() == expected
    names = (
        "title => [...title.parentNode.querySelectorAll('.parameter-name')].map((name) => name.textContent)"
    )
    assert titles.first.evaluate(names) == ["Mass of link 2 link[2].\u200bmass"]
    assert titles.nth(2).evaluate(names)[:2] == ["Length link[1].\u200blength", "Mass link[1].\u200bmass"]
    page.get_by_role("searchbox").fill("radius")
    assert titles.all_inner_texts() == ["Contact"]
    page.get_by_role("searchbox").fill("radus of contact")
    sentence = "No parameter has such a name; the nearest is Radius of contact."
    assert page.locator(".nothing").first.inner_text() == sentence
    page.get_by_role("button", name="Radius of contact").click()
    assert titles.all_inner_texts() == ["Contact"], "the nearest name is searched"
    page.get_by_role("searchbox").fill("friction")
    lacking = "The scene has no such parameter; a scene file may have contact.friction, "
    assert page.locator(".nothing").first.inner_text().startswith(lacking)
    page.get_by_role("button", name="Reset all").click()
    until(page, "document.querySelector('.parameters h2').checkVisibility() === false")


def test_a_choice_that_is_none_is_answered_with_names(show):
    with pytest.raises(Exception, match=r"contact.model = foo must be one of hertz, hunt_crossley"):
        show().evaluate("chainImpact.show({ 'contact.model': 'foo' })")


def test_a_law_without_friction_offers_to_take_it_away(show):
    page = show("sliding_rod")
    page.evaluate("chainImpact.show({'contact.model': 'newton_impact'})")
    until_text(page, "newton_impact has no contact friction", "status")
    page.get_by_role("button", name="Set the friction of walls to 0").click()
    until(page, "document.getElementById('status').hidden")
    values = page.evaluate("chainImpact.parameters")
    frictions = {
        value for name, value in values.items() if name.startswith(("wall", "contact")) and "friction" in name
    }
    assert frictions == {"0"}
    assert values["contact.model"] == "newton_impact"


def test_a_field_with_the_focus_is_above_the_fade_of_the_panel(show):
    page = show()
    page.locator("#list-of-parameters summary").click()
    search = page.get_by_role("searchbox")
    panel = page.locator("#parameters").bounding_box()
    page.locator("#parameters").evaluate("panel => panel.scrollTo(0, 0)")
    search.fill("link")
    until(page, f"{BOX_OF}(document.querySelector('[type=search]')).top < {panel['y']} + 80")
    rows = page.locator(".parameter:visible")
    bottoms = rows.evaluate_all(f"rows => rows.map((row) => {BOX_OF}(row).bottom)")
    fade = panel["y"] + panel["height"] - 22
    place = next(k for k, bottom in enumerate(bottoms) if bottom > fade)
    field = rows.nth(place).locator("input, select")
    field.evaluate("field => field.focus()")
    row = rows.nth(place).bounding_box()
    assert row["y"] + row["height"] <= fade
