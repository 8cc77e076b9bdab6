"""The page in a browser, by real events: controls, list, console, link, files, maps, and failing runs."""

import csv
import functools
import io
import re
import shlex
import threading
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from chain_impact import cli, explore, load_scene, simulate, sweep
from chain_impact.variables.prepared import PreparedScene
from tests.pages.conftest import DESK, PHONE, until, until_told
from tests.tiers import needs_browser

pytestmark = needs_browser
SUBTITLE = "document.getElementById('subtitle').textContent"
COLOUR = "field => getComputedStyle(field).borderTopColor"
MAP = {"simulation.stop_time": 0.8}
READ = re.compile(
    r"contact.restitution = ([\d.]+), initial.angle\[1\] = ([\d.]+)\u202frad \(.*°\): impact.count = (\d+)"
)


ROWS = """async ([chart, colour]) => {
  await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
  const style = getComputedStyle(document.documentElement).getPropertyValue(`--${colour}`);
  const wanted = style.match(/[0-9a-f]{2}/g).map((part) => parseInt(part, 16));
  const canvas = document.querySelector(`#${chart} canvas`);
  const context = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d");
  context.drawImage(canvas, 0, 0);
  const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
  const rows = [];
  for (let k = 0; k < data.length; k += 4) {
    const isFound = data[k + 3] > 200 && wanted.every((part, c) => Math.abs(part - data[k + c]) < 30);
    if (isFound) rows.push(Math.floor(k / 4 / canvas.width));
  }
  return rows; }"""
"""The rows of the pixels of a chart with a colour of the style sheet."""
PIXELS = f"async (asked) => (await ({ROWS})(asked)).length"
"""Number of pixels of a chart with a colour of the style sheet."""


def impacts_of(changes):
    return f"{len(simulate(load_scene('four_link_box').with_values(changes)).impacts)} impacts"


def enter(page, name, text):
    field = page.get_by_role("textbox", name=name).first
    field.fill(text)
    field.press("Enter")
    return field


# --- knobs and the list of parameters --------------------------------------------------------------------


def test_a_slider_and_a_law_give_another_motion_and_reset_the_first_one(show):
    page = show()
    before = page.evaluate(SUBTITLE)
    slider = page.get_by_role("slider", name="Restitution")
    slider.focus()
    slider.press("Home")
    for _ in range(4):
        slider.press("PageUp")
    value = float(page.get_by_role("textbox", name="contact.restitution").first.input_value())
    assert 0.2 < value < 0.7
    until_told(page, impacts_of({"contact.restitution": value}))
    page.get_by_role("button", name="Reset contact.restitution").first.click()
    until(page, f"{SUBTITLE} === '{before}'")
    page.get_by_role("combobox", name="contact.model").first.select_option(label="flores")
    until_told(page, impacts_of({"contact.model": "flores"}))
    assert "Flores, Machado, Silva & Martins 2011" in page.locator(".sentence").inner_text()


def test_a_logarithmic_slider_has_its_start_in_the_middle_of_the_decades(show):
    page = show()
    slider = page.get_by_role("slider", name="Stiffness")
    assert slider.evaluate("slider => slider.valueAsNumber / slider.max") == 0.5
    for key, value in (("Home", 1e5), ("End", 1e11)):
        slider.press(key)
        assert float(page.evaluate("chainImpact.parameters['contact.stiffness']")) == value


def test_a_refused_value_is_marked_and_told_until_it_is_changed(show):
    page = show()
    field = page.get_by_role("textbox", name="contact.stiffness")
    usual = field.evaluate(COLOUR)
    enter(page, "contact.stiffness", "-1")
    told = "contact.stiffness = -1 must be a finite number > 0 [N/m^exponent]"
    assert field.evaluate("field => field.validationMessage") == told
    page.get_by_role("textbox", name="gravity.y").focus()
    refused = page.get_by_role("alert").filter(has_text="Not taken")
    assert refused.inner_text() == f"Not taken: {told}."
    assert field.evaluate(COLOUR) != usual
    assert page.evaluate("chainImpact.parameters['contact.stiffness']") == "1e8"
    enter(page, "contact.stiffness", "1e6")
    assert refused.count() == 0
    assert field.evaluate(COLOUR) == usual
    until_told(page, impacts_of({"contact.stiffness": 1e6}))


def test_a_slider_that_was_refused_is_right_again_after_the_next_change(show):
    page = show("sliding_rod")
    slider = page.get_by_role("slider", name="Friction at y_min", exact=True)
    slider.press("End")
    assert "static_friction" in slider.evaluate("slider => slider.validationMessage")
    page.get_by_role("slider", name="Static friction at y_min").press("End")
    assert slider.evaluate("slider => slider.validationMessage") == ""
    slider.press("End")
    assert page.evaluate("chainImpact.parameters['wall.y_min.friction']") == "1.5"


def test_the_list_has_every_parameter_and_is_searched(show):
    page = show()
    page.get_by_text("All parameters").click()
    rows = page.locator(".parameter")
    rows.first.wait_for()
    assert rows.count() == page.evaluate("Object.keys(chainImpact.parameters).length") > 50
    row = rows.filter(has_text="link[2].\u200bmass").first
    row.locator("input").fill("heavy")
    row.locator("input").press("Enter")
    told = "Not taken: link[2].mass = heavy must be a finite number > 0 [kg]."
    assert row.locator(".refusal").inner_text() == told
    page.get_by_role("slider", name="Restitution").press("ArrowLeft")
    assert row.locator("input").input_value() == "1", "another change shows the value that holds"
    assert not row.locator(".refusal").is_visible()
    page.get_by_role("button", name="Reset all").click()
    page.get_by_role("searchbox").fill("link 2 mass")
    visible = [row.inner_text() for row in rows.all() if row.is_visible()]
    assert any("mass" in text for text in visible)
    assert len(visible) < 4
    enter(page, "link[2].mass", "3")
    until_told(page, impacts_of({"link[2].mass": 3.0}))
    page.get_by_role("searchbox").fill("no such thing")
    assert page.get_by_text("No parameter has such a name.").is_visible()


# --- console, link, command, files -----------------------------------------------------------------------


def test_the_console_gives_the_bits_of_simulate(show):
    page = show()
    changes = {"contact.restitution": 0.5, "contact.model": "hunt_crossley", "initial.angle[1]": 0.5}
    found = page.evaluate(
        """async (changes) => {
          const run = await window.chainImpact.simulate(changes);
          const text = (array) => Array.from(new BigInt64Array(array.buffer), String);
          const some = ["point[4].x", "contact[2].y_min.force", "energy.total", "impact.count",
            "solver.steps"];
          const names = Object.keys(run.columns);
          const impacts = run.impacts.map(({ onset, wall, peak_force }) => [onset, wall, peak_force]);
          const columns = some.map((name) => [name, text(run.columns[name])]);
          return { names, time: text(run.time), columns, impacts };
        }""",
        changes,
    )
    result = simulate(load_scene("four_link_box").with_values(changes))
    assert found["names"] == list(result.columns)
    assert list(map(int, found["time"])) == result.time.view(np.int64).tolist()
    for name, column in found["columns"]:
        expected = result[name].astype(np.float64).view(np.int64).tolist()
        assert list(map(int, column)) == expected, name
    walls = result.scene.wall_names
    expected = [[row["onset"], walls[row["wall"]], row["peak_force"]] for row in result.impacts]
    assert found["impacts"] == expected
    asked = "chainImpact.simulate({}, { output: 'point[4].x' }).catch((error) => error.message)"
    assert page.evaluate(asked) == "output must be a list of names"


def test_a_link_carries_the_changes(show):
    page = show(hash_="#contact.restitution=0.5&contact.model=flores")
    until_told(page, impacts_of({"contact.restitution": 0.5, "contact.model": "flores"}))
    enter(page, "contact.restitution", "0.4")
    until(page, "location.hash === '#contact.restitution=0.4&contact.model=flores'")
    page.evaluate("location.hash = '#contact.restitution=2'")
    page.get_by_role("alert").wait_for()
    told = "The link cannot be used: contact.restitution = 2 must be"
    assert told in page.get_by_role("alert").inner_text()


def saved(page, button):
    """Return the file that a button gives."""
    with page.expect_download() as download:
        page.get_by_role("button", name=button).click()
    return Path(download.value.path())


def test_the_command_repeats_the_motion_and_a_picture_shows_it(show, tmp_path, monkeypatch):
    page = show(hash_="#contact.restitution=0.5&link[2].mass=1.5&solver.method=explicit")
    page.get_by_role("button", name="Export…").click()
    words = shlex.split(page.get_by_label("The command that gives the same motion").input_value())
    assert words[:3] == ["chain-impact", "simulate", "four_link_box"]
    monkeypatch.chdir(tmp_path)
    assert cli.main([*words[1:], "--csv", "a.csv"]) == 0
    texts = (Path(path).read_text(encoding="utf-8") for path in (saved(page, "Outputs as CSV"), "a.csv"))
    here, there = (list(csv.reader(text.splitlines())) for text in texts)
    assert here[0] == there[0]
    assert [list(map(float, row)) for row in here[1:]] == [list(map(float, row)) for row in there[1:]]
    picture = Image.open(io.BytesIO(saved(page, "Picture as PNG").read_bytes())).convert("RGB")
    box = page.locator("#scene").bounding_box()
    assert picture.size == (2 * int(box["width"]), 2 * int(box["height"]))
    chain = np.abs(np.asarray(picture).astype(int) - [0x2B, 0x4A, 0x9F]).max(axis=-1) < 8
    assert chain.sum() > 2000


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


# --- what cannot be --------------------------------------------------------------------------------------


def test_a_run_that_fails_says_why_and_shows_what_came_before(show):
    page = show()
    page.evaluate("chainImpact.show({'solver.work_limit': 2000})")
    status = page.get_by_role("alert")
    status.wait_for()
    told = r"The simulation stopped at t = 1\.6215\d* s: a second of simulated time takes more"
    assert re.search(told, status.inner_text())
    page.evaluate("chainImpact.show({'initial.y': -3})")
    until_told(page, "cannot start", "status")
    assert "The simulation cannot start: a contact point starts beyond a wall" in status.inner_text()
    failed = "chainImpact.simulate({'initial.y': -3}).catch((error) => error.status)"
    assert page.evaluate(failed) == 4
    page.evaluate("chainImpact.show({'initial.y': 1.4})")
    until_told(page, "stopped", "status")
    page.get_by_role("button", name="Reset all").click()
    status.wait_for(state="hidden")


def test_keys_and_buttons_do_nothing_while_there_is_no_motion(show):
    page = show(hash_="#initial.y=-3", begins=False)
    until_told(page, "cannot start", "status")
    for key in ("Space", "ArrowRight", "Home", "End", "Shift+ArrowRight"):
        page.keyboard.press(key)
    page.get_by_role("button", name="Play").click()
    assert page.get_by_label("Speed").input_value() == "1"
    page.evaluate("chainImpact.show({'initial.y': 1.4})")
    until_told(page, "impacts in")


def test_a_table_that_is_too_large_or_not_complete_is_told_where_it_is_asked_for(show):
    page = show(hash_="#simulation.step_size=1e-9")
    page.get_by_role("button", name="Export…").click()
    page.get_by_role("button", name="Outputs as CSV").click()
    said = page.locator("#export-text")
    said.get_by_text("the table would be too large").wait_for()
    page.get_by_role("button", name="Close").click()
    page.evaluate("chainImpact.show({'simulation.step_size': 0.001, 'solver.work_limit': 2000})")
    until_told(page, "stopped at", "status")
    page.get_by_role("button", name="Export…").click()
    saved(page, "Outputs as CSV")
    said.get_by_text("The simulation stopped at t = 1.6215").wait_for()


def test_motions_of_the_base_and_of_walls_are_told_to_stay(show):
    assert show("rod_drop").locator("#inputs").is_hidden()
    told = show("shaken_pendulum").locator("#inputs")
    assert "These inputs keep their start values here: base.x" in told.inner_text()


def test_signals_drive_the_page_with_a_slider_for_each_number_and_a_chart(show):
    page = show("bouncing_table", {"simulation.stop_time": 1.0})
    assert page.locator("#inputs-over-time dt").all_inner_texts() == ["wall.y_min.displacement"]
    assert page.evaluate(PIXELS, ["inputs-over-time", "input-1"]) > 200
    scene = load_scene("bouncing_table").with_values({"simulation.stop_time": 1.0})
    changed = {"signal.table.amplitude": 0.004, "signal.table.phase": 1.0}
    knob = page.get_by_role("slider", name=re.compile("table.*amplitude"))
    assert knob.is_visible()
    knob.press("ArrowRight")
    until(page, "chainImpact.parameters['signal.table.amplitude'] > 0.00323038")
    page.evaluate("(changed) => chainImpact.show(changed)", changed)
    until_told(page, f"{len(simulate(scene.with_values(changed)).impacts)} impacts")
    page.locator("#scrub").fill("0.5")
    shown = 0.004 * np.sin(1.0 + 2.0 * np.pi * 10.0 * 0.5)
    told = page.locator("#inputs-over-time dd").inner_text().split("\u202f")
    assert float(told[0]) == pytest.approx(shown, rel=1e-2)
    assert told[1] == "m"
    assert page.evaluate("chainImpact.scene") == "BouncingTable"
    names = {
        name for name in page.evaluate("Object.keys(chainImpact.parameters)") if name.startswith("signal")
    }
    assert names == {name for name in PreparedScene(scene).parameter_paths if name.startswith("signal")}


def test_a_torque_and_a_target_are_set_by_a_slider_as_simulate_takes_them(show):
    page = show("pinned_arm", {"inputs.joint_targets": True, "link[2].joint_stiffness": 20.0})
    for name, key in (("joint[1].torque", "Home"), ("joint[2].target_angle", "End")):
        page.get_by_role("slider", name=name).press(key)
    values = page.evaluate("chainImpact.parameters")
    inputs = {name: float(values[name]) for name in ("joint[1].torque", "joint[2].target_angle")}
    assert inputs["joint[1].torque"] < 0.0 < inputs["joint[2].target_angle"]
    scene = load_scene("pinned_arm").with_values(
        {"inputs.joint_targets": True, "link[2].joint_stiffness": 20}
    )
    result = simulate(scene, inputs=inputs)
    until_told(page, f"{len(result.impacts)} impact")
    tip = page.evaluate(
        """async (inputs) => {
      const run = await chainImpact.simulate(inputs, { output: ["point[2].x"] });
      return Array.from(run.columns["point[2].x"]); }""",
        inputs,
    )
    assert tip == result["point[2].x"].tolist()
    page.get_by_role("button", name="Export…").click()
    command = page.get_by_label("The command that gives the same motion").input_value()
    assert shlex.split(command)[2].endswith(
        f'.with_values({{}}), inputs={{"joint[1].torque": {values["joint[1].torque"]}, '
        f'"joint[2].target_angle": {values["joint[2].target_angle"]}}}))'
    )


def test_the_targets_of_a_slider_have_knobs(show):
    page = show("cart_pole", {"inputs.joint_targets": True})
    for name in ("slider.target_position", "slider.target_velocity"):
        page.get_by_role("slider", name=name).press("End")
        assert float(page.evaluate("chainImpact.parameters")[name]) > 0.0


@pytest.fixture
def server(tmp_path):
    """Serve a folder with the page inside another page, and return the address."""
    explore("rod_drop", tmp_path / "rod.html")
    (tmp_path / "lesson.html").write_text('<iframe src="rod.html" width="900" height="700"></iframe>')

    class Handler(SimpleHTTPRequestHandler):
        def end_headers(self):
            if "?strict" in self.path:
                self.send_header("Content-Security-Policy", "worker-src 'self'")
            super().end_headers()

        def log_message(self, *_):
            """Print nothing."""

    started = ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Handler, directory=tmp_path))
    threading.Thread(target=started.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{started.server_port}"
    started.shutdown()
    started.server_close()


def test_the_page_within_a_lesson_without_a_worker_and_in_an_old_browser(browser, server):
    page = browser.new_page()
    page.goto(f"{server}/lesson.html")
    page.frame_locator("iframe").get_by_text("impacts in").wait_for()
    height = page.evaluate("""async () => {
      const { chainImpact } = document.querySelector("iframe").contentWindow;
      return (await chainImpact.simulate({ "initial.y": 1.5 })).columns["point[0].y"][0]; }""")
    assert height == 1.5
    page.goto(f"{server}/rod.html?strict")
    until_told(page, "The solver cannot work in this browser: ", "status")
    assert not page.evaluate("document.body.classList.contains('computing')")
    page.add_init_script("delete window.DecompressionStream")
    page.goto(f"{server}/rod.html")
    needs = page.get_by_text("It needs JavaScript and a browser of 2023 or later")
    needs.wait_for(state="attached")
    needs.evaluate("(status) => status.getAnimations().forEach((one) => one.finish())")  # which waits for 4 s
    assert needs.is_visible()
    page.close()


@pytest.mark.parametrize("size", [DESK, PHONE, {"width": 320, "height": 320}])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_stands_out_of_the_screen(show, size, scheme):
    page = show(viewport=size, color_scheme=scheme)
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert page.locator("#scene").is_visible()
    play = page.get_by_role("button", name="Play")
    stage, below = page.locator("#view").bounding_box(), play.bounding_box()
    assert below["y"] + below["height"] <= size["height"]
    assert min(below["y"], stage["y"] + stage["height"]) - stage["y"] > 100, "the motion is in sight"
    play.click()
    page.get_by_role("button", name="Pause").wait_for()


def test_keys_move_the_grips_and_the_scene_is_described_with_numbered_points(show):
    page = show()
    assert page.locator("#description").inner_text() == load_scene("four_link_box").description
    assert page.locator(".point-number").all_text_contents() == ["0", "1", "2", "3", "4"]
    names = {
        "Point 0: arrow keys move it": "initial.x",
        "Velocity of point 2: arrow keys change it": "initial.angular_velocity[2]",
        "Wall x_max: arrow keys move it": "box.x_max",
    }
    for spoken, name in names.items():
        page.get_by_role("button", name=spoken).focus()
        for _ in range(2):
            before = float(page.evaluate("chainImpact.parameters")[name])
            page.keyboard.press("ArrowRight")
            until(page, f"Number(chainImpact.parameters['{name}']) !== {before}")
            until(page, f"document.activeElement.getAttribute('aria-label') === '{spoken}'")


def test_a_loop_plays_again_and_a_key_fills_the_screen(show):
    page = show(hash_="#simulation.stop_time=0.2")
    page.keyboard.press("l")
    assert page.get_by_label("Loop").is_checked()
    page.keyboard.press("End")
    page.keyboard.press("Space")
    for _ in range(2):
        until(page, "Number(document.getElementById('scrub').value) > 0.1")
        until(page, "Number(document.getElementById('scrub').value) < 0.1")
    page.get_by_role("button", name="Pause").wait_for()
    page.keyboard.press("f")
    until(page, "document.fullscreenElement === document.documentElement")
    page.keyboard.press("f")
    until(page, "document.fullscreenElement === null")


def test_a_law_without_friction_offers_to_take_it_away(show):
    page = show("sliding_rod")
    page.evaluate("chainImpact.show({'contact.model': 'newton_impact'})")
    until_told(page, "newton_impact has no contact friction", "status")
    page.get_by_role("button", name="Set the friction of walls to 0").click()
    until(page, "document.getElementById('status').hidden")
    values = page.evaluate("chainImpact.parameters")
    frictions = {
        one for name, one in values.items() if name.startswith(("wall", "contact")) and "friction" in name
    }
    assert frictions == {"0"}
    assert values["contact.model"] == "newton_impact"


def test_the_list_has_what_is_left_of_each_speed_and_the_chart_has_the_loop_of_an_impact(show):
    page = show()
    first = simulate("four_link_box").impacts[0]
    page.get_by_role("button", name="Go to impact 1, ").click()
    row = page.locator("#impacts tr[aria-current]")
    assert f"{first['separation_speed'] / first['impact_speed']:.3f}" in row.inner_text()
    for _ in range(30):
        page.keyboard.press("ArrowRight")
        if page.locator(".arrow.force").count():
            break
    assert page.locator(".loop-now").is_hidden()
    page.get_by_role("button", name="F(δ)").click()
    assert page.locator(".loop-now").is_visible()
    assert page.locator("#force .now").is_hidden()
    line = page.evaluate("""() => {
      const canvas = document.querySelector("#force canvas");
      const [middle, height] = [Math.round(0.6 * canvas.width), canvas.height];
      const { data } = canvas.getContext("2d").getImageData(middle, 0, 1, height);
      const [red, green, blue] = getComputedStyle(document.querySelector(".force")).color.match(/\\d+/g);
      const far = ([r, g, b]) => Math.abs(r - red) + Math.abs(g - green) + Math.abs(b - blue);
      return Array.from({ length: height }, (_, y) => data.slice(4 * y, 4 * y + 4))
        .flatMap((pixel, y) => (pixel[3] > 200 && far(pixel) < 60 ? [y] : [])); }""")
    assert line[-1] - line[0] > 8, "with a loss, the force on the way back is smaller"
    page.get_by_role("button", name="F(δ)").click()
    assert page.locator("#force .now").is_visible()


# --- other motions, and maps -----------------------------------------------------------------------------


def test_the_motion_before_a_change_is_a_ghost_and_pinned_ones_stay(show):
    page = show()
    assert page.locator(".ghost").count() == 0
    for value in (0.4, 0.6):
        page.get_by_role("button", name="Pin").click()
        page.evaluate(f"chainImpact.show({{'contact.restitution': {value}}})")
        until_told(page, impacts_of({"contact.restitution": value}))
        page.wait_for_timeout(900)  # changes at shorter intervals are merged into one change
    assert page.locator("polyline.ghost").count() == 3
    for chart in ("energy", "force"):
        assert page.evaluate(PIXELS, [chart, "pin-2"]) > 20
    page.get_by_role("button", name="F(δ)").click()
    assert page.evaluate(PIXELS, ["force", "pin-2"]) > 20
    rows = page.locator("#pins tbody tr").all_inner_texts()
    for row, text in zip(rows, ("present", "as in the scene", "contact.restitution = 0.4"), strict=True):
        assert text in row
    first = simulate("four_link_box").impacts[0]
    assert f"{first['onset']:.4f}" in rows[1]
    page.locator(".unpin").first.click()
    until(page, "document.querySelectorAll('#pins tbody tr').length === 2")


def draw_map(page):
    """Request a map, and wait for the map."""
    page.get_by_role("button", name="Simulate 41 × 41 runs").click()
    page.locator("#map-text").get_by_text("1681 runs in").wait_for()


def test_a_map_is_drawn_read_and_opens_a_run(show):
    page = show("rod_drop", MAP)
    page.get_by_role("button", name="Map…").click()
    page.locator("#map-text").get_by_text("A preview of 9 × 9 runs. Press Simulate for 41 × 41.").wait_for()
    assert page.locator("#map-canvas").get_attribute("width") == "9"
    outputs = page.locator("#map-output option").evaluate_all("options => options.map(({ value }) => value)")
    largest = ["peak_force", "max_penetration"]
    assert outputs == [
        "impact.count",
        "impact.last_time",
        *largest,
        "energy.total",
        "point[1].x",
        "point[1].y",
    ]
    for low, high in (("", "1"), ("2", "3")):
        page.locator("#map-x-from").fill(low)
        page.locator("#map-x-to").fill(high)
        page.get_by_role("button", name="Simulate 41 × 41 runs").click()
        page.get_by_text("must be a finite number >= 0 and <= 1").wait_for()
    page.locator("#map-x-from").fill("0.2")
    page.locator("#map-x-to").fill("0.95")
    draw_map(page)
    box = page.locator("#map-canvas").bounding_box()
    titles = page.locator("#map-scales text").all_text_contents()
    assert {"Restitution", "initial.angle[1], °", "Number of impacts", "0.4", "20"} <= set(titles)
    assert page.locator(".map-present").count() == 1
    table = saved(page, "Map as CSV").read_text().splitlines()
    assert table[0] == "contact.restitution,initial.angle[1],impact.count"
    assert len(table) == 1 + 41 * 41
    picture = Image.open(saved(page, "Map as PNG")).convert("RGB")
    assert picture.getcolors(1 << 20) is None or len(picture.getcolors(1 << 20)) > 5
    lower_right = {"x": box["width"] - 5, "y": box["height"] - 5}
    page.locator("#map-canvas").hover(position=lower_right)
    e, angle, count = READ.search(page.locator("#map-text").inner_text()).groups()
    values = {**MAP, "contact.restitution": float(e), "initial.angle[1]": float(angle)}
    assert float(e) == 0.95
    assert int(count) == len(simulate(load_scene("rod_drop").with_values(values)).impacts)
    page.locator("#map-canvas").click(position=lower_right)
    until_told(page, f"{count} impact")
    assert page.evaluate("chainImpact.parameters['contact.restitution']") == "0.95"
    colours = page.evaluate("""new Set(new Uint32Array(document.getElementById('map-canvas')
      .getContext('2d').getImageData(0, 0, 41, 41).data.buffer)).size""")
    assert colours > 3


def test_a_map_shows_the_largest_forces_of_a_sweep(show):
    values = {"outputs.loads": True, "simulation.stop_time": 0.55}
    scene, page = load_scene("pinned_arm").with_values(values), show("pinned_arm", values)
    page.get_by_role("button", name="Map…").click()
    for axis, name in (("x", "contact.restitution"), ("y", "contact.stiffness")):
        page.locator(f"#map-{axis}-name").select_option(name)
    for output in ("peak_force", "joint_force"):
        page.locator("#map-output").select_option(output)
        draw_map(page)
        head, *rows = saved(page, "Map as CSV").read_text().splitlines()
        assert head == f"contact.restitution,contact.stiffness,{output}"
        e, stiffness, value = map(float, rows[-1].split(","))
        found = sweep(scene, {"contact.restitution": [e], "contact.stiffness": [stiffness]})
        assert found[output][0] == value


def test_a_run_that_a_scene_would_refuse_has_no_colour(show):
    page = show("sliding_rod", {"simulation.stop_time": 0.05})
    page.get_by_role("button", name="Map…").click()
    for axis, name in (("x", "wall.y_min.static_friction"), ("y", "wall.y_min.friction")):
        page.locator(f"#map-{axis}-name").select_option(name)
        for end, value in (("from", "0.1"), ("to", "0.5")):
            page.locator(f"#map-{axis}-{end}").fill(value)
    draw_map(page)
    box = page.locator("#map-canvas").bounding_box()
    for place, text in ((0.9, "impact.count = "), (0.1, "the run fails")):
        page.locator("#map-canvas").hover(position={"x": place * box["width"], "y": 0.5 * box["height"]})
        page.locator("#map-text").get_by_text(text).wait_for()


def test_a_map_that_is_closed_stops_and_another_takes_the_place_of_one_that_is_not_complete(show):
    page = show(hash_="#simulation.stop_time=400")
    page.get_by_role("button", name="Map…").click()
    page.get_by_role("button", name="Simulate 41 × 41 runs").click()
    until_told(page, "of 41 rows", "map-text")
    assert len(page.workers) > 1
    page.keyboard.press("Escape")
    until(page, "document.getElementById('map-text').textContent.startsWith('Stopped after')")
    while len(page.workers) > 1:  # all workers except the worker of the motion end
        page.wait_for_timeout(50)
    page.evaluate("chainImpact.show({ 'simulation.stop_time': 0.2 })")
    page.get_by_role("button", name="Map…").click()
    for output in ("impact.last_time", "impact.count"):
        page.get_by_label("Colour").select_option(output)
        page.get_by_role("button", name="Simulate 41 × 41 runs").click()
    page.locator("#map-text").get_by_text("1681 runs in").wait_for()
    page.locator("#map-canvas").hover()
    until_told(page, "impact.count = ", "map-text")


# --- what lasts ------------------------------------------------------------------------------------------

MANY = """async () => {
  const output = ["point[4].x"];
  const values = (k) => ({ "contact.restitution": 0.3 + k / 800, "simulation.stop_time": 0.3 });
  const run = (k) => chainImpact.simulate(values(k), { output });
  const whole = async (count) => { for (let k = 0; k < count; k += 1) await run(k); };
  const size = () => { gc(); gc(); return performance.memory.usedJSHeapSize; };
  await whole(100);
  const first = (await run(200)).columns["point[4].x"].at(-1);
  const before = size();
  await whole(400);
  const after = size();
  const held = Array.from({ length: 100 }, () => new Array(10000).fill(0.5));
  return [before, after, size(), first === (await run(200)).columns["point[4].x"].at(-1), held.length];
}"""


def test_many_runs_leave_the_memory_as_it_was(show):
    before, after, holding, same, _ = show().evaluate(MANY)
    assert same
    assert after - before < 0.4e6  # 1000 bytes per run
    assert holding - after > 5e6  # a leak of 8 MB would be detected here


def test_a_long_run_does_not_freeze_the_page_and_gives_way_to_the_next(show):
    page = show()
    page.evaluate("chainImpact.show({'simulation.stop_time': 100000, 'contact.model': 'newton_impact'})")
    until(page, "document.body.classList.contains('computing')")
    frames = page.evaluate("""() => new Promise((done) => {
      const began = performance.now(); let longest = 0, before = began;
      const tick = (now) => { longest = Math.max(longest, now - before); before = now;
        if (now - began > 600) done(longest); else requestAnimationFrame(tick); };
      requestAnimationFrame(tick); })""")
    assert frames < 400  # ms, on a busy machine
    page.get_by_role("button", name="Reset all").click()
    until(page, "!document.body.classList.contains('computing')")
    until_told(page, "14 impacts in 2 s")
