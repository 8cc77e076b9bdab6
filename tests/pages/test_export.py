"""Exports of the page: the console, the link, the command, tables, pictures and the scene file."""

# Tests: pages/browser/explore/export.js, pages/browser/explore/export_dialog.js
# Tests: pages/browser/explore/console.js, pages/browser/explore/saved_page.js
# Tests: pages/browser/explore/chart_picture.js, pages/browser/explore/svg_recorder.js

import base64
import csv
import io
import re
import shlex
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

from chain_impact import cli, load_scene, simulate
from tests.pages.in_pages import (
    LOCAL_LINK,
    MAP,
    draw_map,
    enter,
    go_to,
    impacts_of,
    press,
    saved,
    time_of,
    until,
    until_text,
)
from tests.pages.javascript import function_of
from tests.tiers import needs_browser

pytestmark = needs_browser
SVG = "{http://www.w3.org/2000/svg}"
CAPTION = 28  # pixels of the screen, height of the caption below a picture


def test_the_console_gives_the_bits_of_simulate(show):
    page = show()
    changes = {"contact.restitution": 0.5, "contact.model": "hunt_crossley", "initial.angle[1]": 0.5}
    result_in_page = page.evaluate(
        function_of("export", "simulated"),
        changes,
    )
    result = simulate(load_scene("four_link_box").with_values(changes))
    assert result_in_page["names"] == list(result.columns)
    assert list(map(int, result_in_page["time"])) == result.time.view(np.int64).tolist()
    for name, column in result_in_page["columns"]:
        expected = result[name].astype(np.float64).view(np.int64).tolist()
        assert list(map(int, column)) == expected, name
    walls = result.scene.wall_names
    expected = [[row["onset"], walls[row["wall"]], row["peak_force"]] for row in result.impacts]
    assert result_in_page["impacts"] == expected
    call = "chainImpact.simulate({}, { output: 'point[4].x' }).catch((error) => error.message)"
    assert page.evaluate(call) == "output must be a list of names"


def test_a_link_carries_the_changes(show):
    page = show(hash_="#contact.restitution=0.5&contact.model=flores")
    until_text(page, impacts_of({"contact.restitution": 0.5, "contact.model": "flores"}))
    enter(page, "contact.restitution", "0.4")
    until(page, "location.hash === '#contact.restitution=0.4&contact.model=flores'")
    page.evaluate("location.hash = '#contact.restitution=2'")
    page.get_by_role("alert").wait_for()
    sentence = "The link cannot be used: contact.restitution = 2 must be"
    assert sentence in page.get_by_role("alert").inner_text()


def saved_again(page):
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Export…").click()
    return saved(page, "This page").read_text(encoding="utf-8")


def test_a_link_and_a_saved_page_bring_back_pins_and_time(show, open_page, tmp_path):
    page = show(hash_="#contact.restitution=0.5&gravity.y=-9")
    page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'contact.restitution': 0.7, 'gravity.y': -9.81})")
    until_text(page, impacts_of({}))
    page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'contact.restitution': 0.4})")
    until_text(page, impacts_of({"contact.restitution": 0.4}))
    page.get_by_title("Take this pin away").first.click()
    page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'contact.restitution': 0.3})")
    until_text(page, impacts_of({"contact.restitution": 0.3}))
    page.get_by_label("Speed").select_option("0.25")
    page.get_by_role("button", name="F(δ)").click()
    go_to(page, 0.625)
    page.get_by_role("button", name="Export…").click()
    link = page.get_by_label("A link to this page as it is")
    until(page, "document.getElementById('link').value.includes('time=0.625')")
    assert page.inner_text("#export-text") == LOCAL_LINK
    names_of_pins = (
        "[...document.querySelectorAll('#pins th .dot, #pins td:nth-child(2)')].map((e) => e.innerText)"
    )
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Map…").click()
    page.get_by_label("Upwards").select_option("gravity.y")
    page.locator("#map-y-from").fill("-9.5")
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Export…").click()
    copy = tmp_path / "copy.html"
    copy.write_bytes(saved(page, "This page").read_bytes())
    saved_page = open_page(copy.as_uri())
    until(saved_page, "document.querySelectorAll('#pins tbody tr').length === 3")
    until(saved_page, "location.hash.includes('time=0.625')")
    assert saved_page.evaluate(names_of_pins) == page.evaluate(names_of_pins)
    saved_page.get_by_role("button", name="Map…").click()
    assert saved_page.get_by_label("Upwards").input_value() == "gravity.y"
    assert saved_page.locator("#map-y-from").input_value() == "-9.5"
    text_of_second_copy = saved_again(saved_page)
    assert (
        text_of_second_copy.count('id="saved"') == copy.read_text(encoding="utf-8").count('id="saved"') == 1
    )
    linked_page = show(hash_=f"#{link.input_value().partition('#')[2]}")
    until(linked_page, "document.querySelectorAll('#pins tbody tr').length === 3")
    until_text(linked_page, impacts_of({"contact.restitution": 0.3}))
    assert linked_page.evaluate(names_of_pins) == page.evaluate(names_of_pins)
    assert [row[:1] for row in linked_page.locator("#pins tbody .dot").all_inner_texts()] == ["", "B", "A"]
    assert time_of(linked_page) == 0.625
    until(
        linked_page,
        "location.hash.startsWith('#pins=B~!A~contact.restitution%3D0.4&time=0.625&view=force-loop%2C0.25&')",
    )
    assert linked_page.get_by_label("Speed").input_value() == "0.25"
    assert linked_page.get_by_role("button", name="F(δ)").get_attribute("aria-pressed") == "true"
    linked_page.locator(".unpin").first.click()
    until(linked_page, "location.hash.startsWith('#pins=A~contact.restitution%3D0.4&')")
    press(linked_page, "Home")
    until(linked_page, "!location.hash.includes('time')")


def test_a_saved_page_has_the_runs_of_its_map(show, open_page, tmp_path):
    page = show("rod_drop", MAP)
    page.get_by_role("button", name="Map…").click()
    draw_map(page)
    parts = ("#map-text", "#map-scales", "#map-y-unit")
    texts = [page.text_content(part) for part in parts]
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Export…").click()
    copy = tmp_path / "copy.html"
    copy.write_bytes(saved(page, "This page").read_bytes())
    saved_page = open_page(copy.as_uri())
    saved_page.evaluate(
        "void (window.begun.startEngine = () => { throw new Error('the map simulates again'); })"
    )
    saved_page.get_by_role("button", name="Map…").click()
    assert [saved_page.text_content(part) for part in parts] == texts
    saved_page.locator("#map-output").select_option("impact.count")
    saved_page.locator("#map-canvas").press("ArrowRight")
    assert "Number of impacts = " in saved_page.text_content("#map-text")


def test_a_long_link_and_pins_of_another_scene_are_told(show):
    page = show(hash_="#pins=F~gravity.y%3D-9", begins=False)
    sentence = "The link cannot be used: the pin F~gravity.y=-9 must be a letter from A to E, ~ and changes."
    until(page, f"document.getElementById('status').textContent === {sentence!r}")
    page.evaluate("chainImpact.show({'contact.restitution': 0.4})")
    until_text(page, impacts_of({"contact.restitution": 0.4}))
    page.get_by_role("button", name="Pin").click()
    page.get_by_role("button", name="Edit…").click()
    page.get_by_role("button", name="Remove link 3").click()
    until_text(page, "3 links")
    page.keyboard.press("Escape")
    masses = {f"link[{k}].{key}": 1.0 + k / 7 for k in (1, 2, 3) for key in ("mass", "inertia")}
    for k in range(5):
        page.evaluate("all => chainImpact.show(all)", {**masses, "gravity.y": -9.0 - k / 3})
        until(page, f"Number(chainImpact.parameters['gravity.y']) === {-9.0 - k / 3}")
        until(page, "document.getElementById('stage').ariaBusy === 'false'")
        page.get_by_role("button", name="Pin").click()
    page.get_by_role("button", name="Export…").click()
    page.locator("#export-text").get_by_text("some programs cut it after 2000.").wait_for()
    length = len(page.get_by_label("A link to this page as it is").input_value())
    assert page.inner_text("#export-text") == (
        f"{LOCAL_LINK} The command needs the scene file: save it first. "
        "The link has no pins of other scenes. "
        f"The link has {length} characters; some programs cut it after 2000."
    )


def test_a_link_counts_although_the_page_then_writes_its_own_address(show):
    """The page may write its address between a change of the address and the event of this change."""
    page = show(hash_="#contact.restitution=0.5")
    script = "location.hash = '#contact.restitution=0.4'; history.replaceState(null, '', '#')"
    page.evaluate(f"() => {{ {script}; }}")
    until(page, "chainImpact.parameters['contact.restitution'] === '0.4'")


def test_the_command_repeats_the_motion_and_a_picture_shows_it(show, tmp_path, monkeypatch):
    page = show(hash_="#contact.restitution=0.5&link[2].mass=1.5&gravity.y=-9.5&solver.method=explicit")
    page.get_by_role("button", name="Export…").click()
    words = shlex.split(page.get_by_label("The command that gives the same motion").input_value())
    assert words[:3] == ["chain-impact", "simulate", "four_link_box"]
    monkeypatch.chdir(tmp_path)
    assert cli.main([*words[1:], "--csv", "a.csv"]) == 0
    texts = (Path(path).read_text(encoding="utf-8") for path in (saved(page, "Outputs as CSV"), "a.csv"))
    page_rows, command_rows = (list(csv.reader(text.splitlines())) for text in texts)
    assert page_rows[0] == command_rows[0]
    assert [list(map(float, row)) for row in page_rows[1:]] == [
        list(map(float, row)) for row in command_rows[1:]
    ]
    picture = Image.open(io.BytesIO(saved(page, "Picture as PNG").read_bytes())).convert("RGB")
    box = page.locator("#scene").bounding_box()
    assert picture.size == (2 * int(box["width"]), 2 * (int(box["height"]) + 3 * CAPTION))
    caption = np.asarray(picture)[-2 * CAPTION :].astype(int)
    assert (caption.max(axis=-1) < 100).sum() > 500, "the name and the time stand below the drawing"
    chart = ElementTree.fromstring(saved(page, "Charts as SVG").read_text("utf-8"))
    head, *changes = chart.find(f"{SVG}title").text.splitlines()
    assert head == "Four link box, 0.00000 s, Zhang–Sharf (2009)"
    first_changes = ["Restitution = 0.5, Mass of link 2 = 1.5\u202fkg"]
    assert changes == [*first_changes, "Gravity, y = \u22129.5\u202fm/s², Method of solver = explicit"]
    lefts = {element.text: float(element.get("x")) for element in chart.iter(f"{SVG}text")}
    assert lefts["Contact"] == pytest.approx(lefts["impact\u00a01:"], abs=2.0), (
        "titles begin where other texts begin"
    )
    chain = np.abs(np.asarray(picture).astype(int) - [0x2B, 0x4A, 0x9F]).max(axis=-1) < 8
    assert chain.sum() > 2000


def test_pictures_of_motion_and_charts_name_the_pins(show):
    """The picture of the charts has three lines and, below them, the curves and the colours of a legend."""
    page = show(hash_="#contact.restitution=0.5")
    page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'contact.restitution': 0.6})")
    until_text(page, impacts_of({"contact.restitution": 0.6}))
    cards = [page.locator(name).bounding_box() for name in ("#contact", "#energy-card")]
    drawing = page.locator("#scene").bounding_box()
    page.get_by_role("button", name="Export…").click()
    heights = {
        "Picture as PNG": 2 * (int(drawing["height"]) + 3 * CAPTION),
        "Charts as PNG": 3 * (sum(card["height"] + 8 for card in cards) + 3 * CAPTION),
    }
    for button, height in heights.items():
        picture = np.asarray(Image.open(io.BytesIO(saved(page, button).read_bytes())).convert("RGB")).astype(
            int
        )
        assert picture.shape[0] == pytest.approx(height, abs=1.0)
        caption = picture[: 3 * 3 * CAPTION] if button == "Charts as PNG" else picture[-2 * CAPTION :]
        pin = abs(caption[:, :60] - [0xD2, 0x00, 0xB4]).max(axis=-1) < 8
        assert pin.sum() > 100, "the letter of the pin stands in a dot of its colour"
    colours = ([0xD9, 0x48, 0x0F], [0x7A, 0x3F, 0xA8], [0xD2, 0x00, 0xB4])  # force, dissipated, pin A
    for colour in colours:
        assert (abs(picture - colour).max(axis=-1) < 8).sum() > 100
    title = picture[9 * CAPTION : 9 * CAPTION + 78, 30:600].max(axis=-1)
    assert (title < 90).sum() > 150, "the titles are drawn"
    chart = saved(page, "Charts as SVG").read_text("utf-8")
    texts = [text.text for text in ElementTree.fromstring(chart).iter(f"{SVG}text")]
    assert {"Contact", "Energy", "kinetic", "A", "present: Restitution = 0.6"} <= {*texts}
    height, width = picture.shape[:2]
    address = page.evaluate(function_of("export", "rasterOf"), [chart, width, height])
    drawn_picture = Image.open(io.BytesIO(base64.b64decode(address.partition(",")[2]))).convert("RGB")
    enlarged = Image.fromarray(picture.astype(np.uint8))
    reduced_pictures = [image.reduce(6) for image in (drawn_picture, enlarged)]
    differences = abs(np.subtract(*(np.asarray(image).astype(int) for image in reduced_pictures)))
    assert differences.mean() < 4.0, "both are from the same program; letters differ by half a pixel"
    page.keyboard.press("Escape")
    page.get_by_role("region", name="Energy").get_by_role("button", name="Enlarge").click()
    page.get_by_role("button", name="Export…").click()
    enlarged_picture = Image.open(io.BytesIO(saved(page, "Charts as PNG").read_bytes()))
    large = page.locator("#energy-card").bounding_box()
    assert enlarged_picture.size == (
        pytest.approx(3 * large["width"], abs=1.0),
        pytest.approx(3 * (large["height"] + 8 + 3 * CAPTION), abs=1.0),
    )


def test_a_picture_of_the_start_has_no_handles(show):
    page = show()
    assert page.locator("#scene .velocity").count() > 0
    colour = page.evaluate("getComputedStyle(document.querySelector('#scene .velocity')).stroke")
    velocity = np.array(list(map(int, re.findall(r"\d+", colour)[:3])))
    page.get_by_role("button", name="Export…").click()
    picture = Image.open(io.BytesIO(saved(page, "Picture as PNG").read_bytes())).convert("RGB")
    assert (abs(np.asarray(picture).astype(int) - velocity).max(axis=-1) < 8).sum() == 0


@pytest.mark.parametrize("model", ["four_link_box", "kneed_leg", "simple_pendulum"])
def test_the_list_of_impacts_is_the_file_of_the_command(show, model, tmp_path):
    page = show(model)
    page.get_by_role("button", name="Export…").click()
    simulate(model).save_impacts(tmp_path / "impacts.csv")
    (head, *rows), (expected_head, *expected) = (
        list(csv.reader(path.read_text(encoding="utf-8").splitlines()))
        for path in (saved(page, "Impacts as CSV"), tmp_path / "impacts.csv")
    )
    assert head == expected_head

    def read(texts):
        return [
            [text if name == "wall" else text and float(text) for name, text in zip(head, row, strict=True)]
            for row in texts
        ]

    assert read(rows) == read(expected)


@pytest.mark.parametrize(
    ("model", "changes"),
    [
        ("four_link_box", {"contact.model": "flores", "link[2].mass": 1.5, "initial.vx": 0.25}),
        ("sliding_rod", {"wall.ramp.angle": -0.44, "wall.y_min.friction": 0.1, "wall.ramp.x": -0.01}),
        ("kneed_leg", {"stop.restitution": 0.5, "link[3].joint_max": 0.25, "simulation.stop_time": 0.5}),
        ("rod_drop", {"initial.angular_velocity[1]": 2.0, "gravity.y": -1e-8, "solver.tolerance": 1e-9}),
        ("steel_bar", {"link[20].center_of_mass": 0.01, "initial.vx": -1.0}),
    ],
)
def test_the_scene_file_of_the_page_is_the_scene_with_its_changes(show, model, changes, tmp_path):
    page = show(model)
    page.evaluate("changes => chainImpact.show(changes)", changes)
    page.get_by_role("button", name="Export…").click()
    file = tmp_path / f"{model}.toml"
    text = saved(page, "Scene file").read_text()
    assert text.count("[[chain.links]]") == len(load_scene(model).chain.links)
    assert "author" not in text  # nor any other default
    file.write_text(text)
    assert load_scene(file).values == load_scene(model).with_values(changes).values


def test_the_export_tells_a_table_that_is_too_large_or_incomplete(show):
    page = show(hash_="#simulation.step_size=1e-9")
    page.get_by_role("button", name="Export…").click()
    page.get_by_role("button", name="Outputs as CSV").click()
    note = page.locator("#export-text")
    note.get_by_text("the table would be too large").wait_for()
    page.get_by_role("button", name="Close").click()
    page.evaluate("chainImpact.show({'simulation.step_size': 0.001, 'solver.work_limit': 2000})")
    until_text(page, "stopped at", "status")
    page.get_by_role("button", name="Export…").click()
    saved(page, "Outputs as CSV")
    note.get_by_text("The simulation stopped at t = 1.6215").wait_for()
