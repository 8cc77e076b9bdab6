"""The page's edit dialog: edited scenes move as in Python, and faults in a text are shown."""

# Tests: pages/browser/explore/editor.js, pages/browser/explore/file_fault.js
# Tests: pages/browser/explore/scene_text.js, pages/browser/base/tabs.js
# Tests: pages/browser/scene/edits.js

import json

import numpy as np
import pytest
import tomlkit

from chain_impact import load_scene, simulate
from chain_impact.scene.files.models import scene_file_path
from chain_impact.scene.scene import scene_to_dict
from tests.pages.in_pages import DESK, LOCAL_LINK, PHONE, TEXTS, bits, enter, until, until_text
from tests.pages.javascript import function_of
from tests.tiers import needs_browser

pytestmark = needs_browser
FILL = "field => getComputedStyle(field).backgroundColor"
COLOUR = "text => getComputedStyle(text).color"
SPRING = {"damping": 3.0, "stiffness": 40.0, "rest_position": 0.05}
"""Keys of the slider → values that the test of a slider gives."""


def downloaded(page, tmp_path, *sentences):
    """Return the scene of the file that the page saves; ``sentences`` follow the usual ones of the dialog."""
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Export…").click()
    text = " ".join([LOCAL_LINK, "The command needs the scene file: save it first.", *sentences])
    assert page.locator("#export-text").inner_text() == text
    assert page.locator("#command").input_value().startswith("chain-impact simulate FourLinkBox.toml")
    with page.expect_download() as waiting:
        page.get_by_role("button", name="Scene file", exact=True).click()
    waiting.value.save_as(tmp_path / "edited.toml")
    page.keyboard.press("Escape")
    return load_scene(tmp_path / "edited.toml")


def assert_same_motion(page, scene, changes=None):
    """Assert that the page computes, with changed values, the numbers of `simulate` for its saved scene."""
    names, columns, count = page.evaluate(
        f"""async (changed) => {{
          const {{ columns, impacts }} = await chainImpact.simulate(changed);
          return [Object.keys(columns), ({TEXTS})(Object.values(columns)), impacts.length];
        }}""",
        changes or {},
    )
    result = simulate(scene)
    assert count == len(result.impacts)
    assert names == list(result.columns)
    for text, (name, column) in zip(columns, result.columns.items(), strict=True):
        np.testing.assert_array_equal(bits(text).view(np.float64), column, name)


def edit(page, name, text):
    field = page.locator("#edit").get_by_role("textbox", name=name)
    field.fill(text)
    field.press("Enter")


def refusal(page):
    """Return the refusals that the dialog shows, below a row or next to the button that closes it."""
    texts = page.locator("#edit :is(.told .refusal span, #edit-text)").all_inner_texts()
    return "\n".join(filter(None, texts))


@pytest.mark.parametrize("model", ["four_link_box", "ur5e"])
def test_a_long_number_fits_into_its_field_and_is_whole_in_the_title(show, model):
    page = show(model)
    page.get_by_role("button", name="Edit…").click()
    fields = page.locator("#edit-links input")
    assert fields.count() > 20
    room = "fields => fields.map((field) => field.clientWidth - field.scrollWidth)"
    assert min(fields.evaluate_all(room)) >= 0
    inertia = page.locator("#edit").get_by_role("textbox", name="link[1].inertia")
    expected = load_scene(model).chain.links[0].inertia
    assert float(inertia.get_attribute("title")) == expected
    assert float(inertia.input_value()) == pytest.approx(expected, rel=1e-3)


def test_added_and_removed_parts_give_the_numbers_of_simulate(show, tmp_path):
    page = show()
    page.get_by_role("slider", name="Restitution").press("ArrowLeft")
    restitution = page.evaluate("chainImpact.parameters['contact.restitution']")
    page.get_by_role("button", name="Edit…").click()
    page.get_by_role("button", name="Add a link").click()
    until_text(page, "5 links")
    edit(page, "link[5].length", "0.2")
    edit(page, "link[3].joint_max", "80 deg")
    edit(page, "box.x_min", "")
    page.get_by_role("button", name="Add a wall").click()
    assert page.evaluate("document.activeElement.ariaLabel") == "wall.wall1.x", "it goes to the new row"
    edit(page, "wall.wall1.angle", "-0.2 rad")
    assert refusal(page) == ""
    scene = downloaded(page, tmp_path)
    assert (len(scene.chain.links), scene.chain.links[4].length) == (5, 0.2)
    assert scene.chain.links[2].joint_max == pytest.approx(np.radians(80))
    assert scene.box.x_min is None
    assert [wall.name for wall in scene.walls] == ["wall1"]
    assert scene.contact.restitution == float(restitution) != 0.7  # the change before the edit is kept
    assert_same_motion(page, scene, {"contact.restitution": restitution})
    page.get_by_role("button", name="Edit…").click()
    page.get_by_role("button", name="Remove wall wall1").click()
    page.get_by_role("button", name="Remove link 1").click()
    edit(page, "link[2].joint_max", "")
    page.get_by_role("combobox", name="Base").select_option("pinned")
    until_text(page, "4 links")
    scene = downloaded(page, tmp_path)
    assert (scene.chain.base, scene.walls, scene.stops.exponent) == ("pinned", (), None)
    assert_same_motion(page, scene, {"contact.restitution": restitution})


def test_changes_stay_changes_and_pins_are_of_the_scene_before_an_edit(show, tmp_path):
    page = show()
    page.get_by_role("button", name="Pin").click()
    changes = {"contact.restitution": 0.4, "link[2].mass": 1.5, "link[4].mass": 2.0}
    page.evaluate("values => chainImpact.show(values)", changes)
    page.get_by_role("button", name="Edit…").click()
    edit(page, "link[2].mass", "3")
    page.get_by_role("button", name="Remove link 4").click()
    until_text(page, "3 links")
    page.get_by_role("button", name="Add a wall").click()
    page.keyboard.press("Escape")
    until(page, "document.querySelectorAll('.pin-text')[1].textContent === 'another scene'")
    changed_labels = page.locator(".changed > .main-parameter-label").all_text_contents()
    assert [text.split()[0] for text in changed_labels] == ["Restitution"]
    scene = downloaded(page, tmp_path, "The link has no pins of other scenes.")
    assert scene.contact.restitution == 0.4
    assert [link.mass for link in scene.chain.links[1:]] == [3.0, 1.0]
    assert_same_motion(page, scene, {"contact.restitution": 0.4})
    page.get_by_role("button", name="Reset all").click()
    until(page, "chainImpact.parameters['contact.restitution'] === '0.7'")
    assert page.evaluate("chainImpact.parameters['link[2].mass']") == "3"
    page.get_by_role("button", name="Edit…").click()
    page.get_by_role("button", name="Back to the scene of this page").click()
    until(page, "document.querySelectorAll('.pin-text')[1].textContent === 'as in the scene'")
    page.evaluate(DROP, ["box.toml", scene_file_path("four_link_box").read_text(encoding="utf-8")])
    until_text(page, "4 links")
    assert page.locator(".pin-text").nth(1).inner_text() == "as in the scene", (
        "the same file is the same scene"
    )


def test_an_edit_keeps_the_motion_before_it_and_reset_all_undoes_it(show):
    page = show()
    page.get_by_role("button", name="Edit…").click()
    page.get_by_role("button", name="Add a link").click()
    until_text(page, "5 links")
    assert page.locator("polyline.compared.before").count() == 1
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Reset all").click()
    until_text(page, "4 links")
    assert page.locator("#reset-all").is_hidden()


def test_points_behind_a_removed_link_are_still_those_that_can_touch(show, tmp_path):
    page = show()
    contents = scene_to_dict(load_scene("four_link_box").with_values({"contact.points": [1, 2, 4]}))
    page.evaluate(DROP, ["listed.toml", tomlkit.dumps(contents)])
    page.get_by_role("button", name="Edit…").click()
    page.get_by_role("button", name="Remove link 2").click()
    until_text(page, "3 links")
    scene = downloaded(page, tmp_path)
    assert scene.contact.points == (1, 3)
    assert_same_motion(page, scene)


def test_a_value_that_cannot_be_is_told_and_changes_nothing(show):
    page = show()
    parameters = page.evaluate("chainImpact.parameters")
    page.get_by_role("button", name="Edit…").click()
    edit(page, "link[2].mass", "heavy")
    assert refusal(page) == "Not taken: Mass of link 2 = 'heavy' must be a finite number >\xa00 [kg]."
    assert page.evaluate("chainImpact.parameters") == parameters
    edit(page, "link[2].mass", "3")
    until(page, "chainImpact.parameters['link[2].mass'] === '3'")
    page.get_by_role("button", name="Back to the scene of this page").click()
    assert page.evaluate("chainImpact.parameters") == parameters


def test_an_edit_with_which_no_run_starts_is_told_in_the_dialog_and_undone(show):
    page = show()
    page.keyboard.press("e")
    edit(page, "box.y_max", "50 cm")
    refusal_text = page.locator("#edit").get_by_text("point 0 starts 0.9\u202fm beyond the ceiling")
    refusal_text.wait_for()
    page.locator("#edit").get_by_role("button", name="Undo the edit").click()
    refusal_text.wait_for(state="hidden")
    assert page.locator("#edit").get_by_role("textbox", name="box.y_max").input_value() == "2.5"
    page.keyboard.press("Escape")
    page.locator("#edit #status").wait_for(state="detached")


def refused_fields(page):
    return page.locator("#edit input:invalid").evaluate_all(
        "fields => fields.map((field) => [field.getAttribute('aria-label'), field.value])"
    )


@pytest.mark.parametrize("size", [DESK, PHONE], ids=["desk", "phone"])
def test_the_field_whose_value_the_solver_refuses_is_marked_in_sight(show, size):
    """The edit is a valid scene, whose motion cannot start: the run tells of it, and not the field."""
    page = show(viewport=size)
    page.get_by_role("button", name="Edit…").click()
    failing = page.locator("#edit td input[aria-invalid=true]")
    edit(page, "box.x_max", "0.2")
    until_text(page, "cannot start", "status")
    assert failing.get_attribute("aria-label") == "box.x_max"
    plain, red = (field.evaluate(FILL) for field in (page.get_by_label("box.x_min"), failing))
    assert plain != red
    box, foot = (place.bounding_box() for place in (failing, page.locator("#edit form")))
    assert box["y"] + box["height"] < foot["y"]
    close, status = (page.locator(name).bounding_box() for name in ("#edit form > button", "#status"))
    assert close["y"] + close["height"] <= status["y"]
    edit(page, "link[1].mass", "2")
    until(page, "chainImpact.parameters['link[1].mass'] === '2'")
    assert failing.get_attribute("aria-label") == "box.x_max", "the later edit is not the reason"
    page.get_by_role("button", name="Undo the edit").click()
    until(page, "chainImpact.parameters['link[1].mass'] !== '2'")
    page.get_by_role("button", name="Undo the edit").click()
    until(page, "!document.querySelector('#edit [aria-invalid=true]')")


def test_a_refused_text_stays_until_it_is_mended_or_given_up(show):
    page = show()
    page.get_by_role("button", name="Edit…").click()
    edit(page, "link[2].mass", "heavy")
    edit(page, "link[3].mass", "3")
    edit(page, "link[3].joint_min", "2 rad")
    edit(page, "link[3].joint_max", "1 rad")
    assert refused_fields(page) == [["link[2].mass", "heavy"], ["link[3].joint_max", "1 rad"]]
    page.get_by_role("button", name="Remove link 1").click()
    assert refused_fields(page) == [["link[1].mass", "heavy"], ["link[2].joint_max", "1 rad"]], (
        "it follows its link"
    )
    reasons = page.locator("#edit .told .refusal").all_inner_texts()
    assert ["Mass of link 1" in reasons[0], "Stop to of link 2" in reasons[1]] == [True, True]
    edit(page, "link[2].joint_min", "30°")
    assert refused_fields(page) == [["link[1].mass", "heavy"]], "what another edit allows is taken"
    until(page, "chainImpact.parameters['link[2].joint_max'] === '1'")
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Edit…").click()
    assert refused_fields(page) == [["link[1].mass", "heavy"]]
    page.locator("#edit").get_by_role("textbox", name="link[1].mass").press("Escape")
    assert page.locator("#edit").is_visible()
    assert refused_fields(page) == []
    assert page.evaluate("chainImpact.parameters['link[1].mass']") == "1"


def test_the_tab_key_goes_on_to_the_next_field_after_an_edit(show):
    page = show()
    page.get_by_role("button", name="Edit…").click()
    field = page.locator("#edit").get_by_role("textbox", name="link[2].mass")
    field.fill("3")
    field.press("Tab")
    assert page.evaluate("document.activeElement.getAttribute('aria-label')") == "link[2].height"
    assert page.evaluate("chainImpact.parameters['link[2].mass']") == "3"


DROP = function_of("edit_dialog", "dropInPage")


def test_a_dropped_file_replaces_scene_sliders_link_and_map(show, open_page, address):
    page = show()
    text = scene_file_path("sliding_rod").read_text(encoding="utf-8")
    page.evaluate(DROP, ["sliding_rod.toml", text])
    scene = load_scene("sliding_rod")
    until_text(page, f"{len(simulate(scene).impacts)} impact")
    assert page.locator("h1").inner_text() == "Sliding rod"
    assert page.evaluate("chainImpact.scene") == "SlidingRod"
    assert page.locator("#description").inner_text() == scene.description
    assert page.get_by_role("slider", name="Friction at the floor", exact=True).is_visible()
    assert page.get_by_role("button", name="Reset all").is_hidden()
    assert_same_motion(page, scene)
    page.get_by_role("button", name="Map…").click()
    names = page.locator("#map-x-name option").evaluate_all("options => options.map(({ value }) => value)")
    assert "wall.ramp.friction" in names
    assert "link[2].mass" not in names
    page.keyboard.press("Escape")
    page.get_by_role("slider", name="Gravity, y").press("ArrowRight")
    until(page, "location.hash.includes('gravity.y')")
    linked_page = open_page(address + page.evaluate("location.hash"))
    until_text(linked_page, "1 link,")
    assert linked_page.evaluate("chainImpact.parameters") == page.evaluate("chainImpact.parameters")
    linked_page.evaluate("location.hash = ''")
    until_text(linked_page, "4 links")


NO_SCENES = {
    "name = 'Rod'\nmass = ": "not valid TOML: ",
    "name = 'Rod'\n": "chain.links is missing (links from base to tip).",
    json.dumps({"links": 4}): "(at line 1).",
    "\n[[link]]\nlength = 1\n": "link is unknown; the nearest key is chain.links (line 2).",
    "name = 'Rod'\n[[chain.links]]\nlength = 1\nmass = 1\n[[chain.links]]\nmas = 2\n": (
        "chain.links[2].mas is unknown; the nearest key is chain.links.mass (line 6)."
    ),
}
"""Text of a file that is no scene → end of its refusal."""


def test_a_dropped_file_that_is_no_scene_is_told_and_changes_nothing(show):
    page = show()
    parameters = page.evaluate("chainImpact.parameters")
    for k, (text, ending) in enumerate(NO_SCENES.items()):
        page.evaluate(DROP, [f"rod_{k}.toml", text])
        until_text(page, f"rod_{k}.toml cannot be opened: ", "edit-text")
        assert ending in refusal(page)
        assert page.evaluate("chainImpact.parameters") == parameters


def test_a_valid_text_of_the_scene_acts_and_a_fault_is_told_with_its_line(show):
    page = show(hash_="#contact.restitution=0.4")
    page.get_by_role("button", name="Edit…").click()
    page.get_by_role("tab", name="Fields").press("ArrowRight")
    field = page.get_by_role("textbox", name="Scene file as text")
    text = field.input_value()
    assert "restitution = 0.4" in text, "with the changes of the reader"
    dialog, view = (page.locator(name).bounding_box() for name in ("#edit", "#view"))
    assert dialog["x"] > view["x"] + 0.9 * view["width"], "the drawing is in sight"
    field.fill(text.replace("restitution = 0.4", "restitutio = 0.4"))
    line = text.split("\n").index("restitution = 0.4") + 1
    until_text(
        page,
        f"Not taken: contact.restitutio is unknown; the nearest key is contact.restitution (line {line}).",
        "edit-toml-text",
    )
    assert page.evaluate("chainImpact.parameters['contact.restitution']") == "0.4"
    field.fill(text.replace("restitution = 0.4", "restitution = 0.6"))
    until(page, "chainImpact.parameters['contact.restitution'] === '0.6'")
    assert page.inner_text("#edit-toml-text") == ""
    page.get_by_role("tab", name="Text").press("ArrowLeft")
    assert page.get_by_role("textbox", name="link[1].mass").is_visible()
    page.keyboard.press("Control+z")
    until(page, "chainImpact.parameters['contact.restitution'] === '0.4'")


def test_an_edit_that_is_taken_back_leaves_no_trace(show):
    """Edits of the text and of a field, taken back, leave the link and the command as they were."""
    page = show(hash_="#contact.restitution=0.4")
    page.get_by_role("button", name="Edit…").click()
    mass = page.get_by_role("textbox", name="link[1].mass")
    mass_text = mass.input_value()
    for value in ("1.5", mass_text):
        enter(page, "link[1].mass", value)
    assert page.evaluate("document.getElementById('edit-first').hidden")
    page.get_by_role("tab", name="Fields").press("ArrowRight")
    field = page.get_by_role("textbox", name="Scene file as text")
    text = field.input_value()
    is_undo_disabled = "document.getElementById('undo').disabled"
    is_disabled = page.evaluate(is_undo_disabled)
    field.fill(f"{text}#")
    page.wait_for_timeout(600)  # the pause after which a text is read
    assert page.evaluate("document.getElementById('edit-first').hidden"), "a comment is no edit"
    assert page.evaluate(is_undo_disabled) == is_disabled
    field.fill(text.replace("restitution = 0.4", "restitution = 0.6"))
    until(page, "chainImpact.parameters['contact.restitution'] === '0.6'")
    assert not page.evaluate("document.getElementById('edit-first').hidden")
    field.fill(text)
    until(page, "chainImpact.parameters['contact.restitution'] === '0.4'")
    assert page.evaluate("document.getElementById('edit-first').hidden")
    until(page, "location.hash === '#contact.restitution=0.4'")
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Export…").click()
    command = page.get_by_label("The command that gives the same motion").input_value()
    assert command == "chain-impact simulate four_link_box --set contact.restitution=0.4"


def test_a_dropped_file_that_cannot_be_read_is_told(show):
    page = show()
    page.evaluate("() => { File.prototype.text = () => Promise.reject(new Error('it is a folder')); }")
    page.evaluate(DROP, ["models", ""])
    until_text(page, "models cannot be opened: it is a folder.", "edit-text")


def test_dropped_text_is_left_to_the_field_that_it_falls_on(show):
    page = show()
    is_taken = page.evaluate("""() => {
      const data = new DataTransfer();
      data.setData("text/plain", "0.5");
      const drop = new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true });
      return !document.body.dispatchEvent(drop);
    }""")
    assert not is_taken


def test_bodies_and_sliders_are_edited_and_points_are_dragged(show, tmp_path):
    page = show()
    page.get_by_role("button", name="Edit…").click()
    edit(page, "link[1].height", "0.1")
    edit(page, "link[2].center_of_mass_offset", "0.03")
    page.get_by_role("button", name="Add a point").click()
    edit(page, "point[9].name", "heel")
    edit(page, "point[9].link", "2")
    edit(page, "point[9].y", "0.08")
    edit(page, "point[9].link", "7")
    assert refusal(page) == "Not taken: the link of a point = 7 must be 1 to 4."
    words, refused = (page.locator(f"#edit {part}").evaluate(COLOUR) for part in ("label", ".told .refusal"))
    assert words != refused, "a refusal stands out"
    page.get_by_role("button", name="Undo point[9].link").click()
    scene = downloaded(page, tmp_path)
    heel = scene.chain.sites[4]
    assert [scene.chain.links[0].shape, heel[0], heel[1].y, heel[1].name] == ["box", 1, 0.08, "heel"]
    assert scene.chain.links[1].center_of_mass_offset == 0.03
    assert_same_motion(page, scene)
    grip = page.get_by_role("button", name="Point 9 (heel): arrow keys move it on its link")
    grip.press("Shift+ArrowUp")
    height = page.evaluate("chainImpact.parameters['link[2].point[1].y']")
    assert height != 0.08
    page.get_by_role("button", name="Edit…").click()
    page.get_by_role("button", name="Remove point 9").click()
    edit(page, "link[1].height", "")
    page.get_by_role("combobox", name="Base").select_option("slider")
    edit(page, "slider.max", "0.2")
    edit(page, "slider.angle", "0.5")
    for key, value in SPRING.items():
        edit(page, f"slider.{key}", str(value))
    heads = [page.locator(f"#edit-{name} th").all_inner_texts() for name in ("links", "slider")]
    assert heads[0][4:7] == ["Centre of mass along, m", "Centre of mass left, m", "Inertia, kg·m²"]
    assert heads[1][2:5] == ["Damping, N·s/m", "Stiffness, N/m", "Rest position, m"]
    scene = downloaded(page, tmp_path)
    slider = scene.chain.slider
    assert (scene.chain.base, slider.max, scene.chain.sites) == ("slider", 0.2, ())
    assert {key: getattr(slider, key) for key in SPRING} == SPRING
    assert_same_motion(page, scene)
    page.get_by_role("button", name="Edit…").click()
    page.get_by_role("combobox", name="Base").select_option("free")
    assert downloaded(page, tmp_path).chain.slider is None
