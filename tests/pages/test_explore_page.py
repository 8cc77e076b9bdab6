"""The page that simulates: runs that fail or last long, screens, other pages, and the memory."""

# Tests: pages/browser/explore/begin.js, pages/browser/explore/open_scene.js
# Tests: pages/browser/explore/simulation.js, pages/browser/explore/address.js
# Tests: pages/browser/explore/explore.js
# Tests: pages/browser/base/dom.js, pages/browser/base/storage.js, pages/browser/explore/first_steps.js

import functools
import re
import threading
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer

import numpy as np
import pytest

from chain_impact import explore, load_scene, simulate
from tests.pages.in_pages import DESK, PHONE, PIXELS, go_to, impacts_of, resize, until, until_text
from tests.pages.javascript import function_of
from tests.tiers import needs_browser

pytestmark = needs_browser
MEMORY_OF_RUNS = function_of("explore_page", "memoryOfRuns")


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


def test_a_run_that_fails_says_why_and_shows_what_came_before(show):
    page = show()
    page.evaluate("chainImpact.show({'solver.work_limit': 2000})")
    status = page.locator("#status")
    status.wait_for()
    pattern = r"^With Work limit of solver = 2000\s1/s, the simulation stopped at t = 1\.6215\d*\ss\. "
    assert re.search(pattern, status.inner_text())
    status.get_by_text("Why").click()
    reason = status.locator("details p").inner_text()
    assert reason.startswith("A second of simulated time takes more evaluations than Work limit of solver ")
    assert reason.endswith(" Raise Work limit of solver, loosen Solver tolerance, or lower Stiffness.")
    page.evaluate("chainImpact.show({'initial.y': -3})")
    until_text(page, "cannot start", "status")
    assert "The simulation cannot start: point 0 starts 3\u202fm beyond the floor." in status.inner_text()
    failed = "chainImpact.simulate({'initial.y': -3}).catch((error) => error.status)"
    assert page.evaluate(failed) == 4
    page.evaluate("chainImpact.show({'initial.y': 1.4})")
    until_text(page, "stopped", "status")
    page.get_by_role("button", name="Reset all").click()
    status.wait_for(state="hidden")


def test_keys_and_buttons_do_nothing_while_there_is_no_motion(show):
    page = show(hash_="#initial.y=-3", begins=False)
    until_text(page, "cannot start", "status")
    for key in ("Space", "ArrowRight", "Home", "End", "Shift+ArrowRight"):
        page.keyboard.press(key)
    page.get_by_role("button", name="Play").click()
    assert page.get_by_label("Speed").input_value() == "1"
    page.evaluate("chainImpact.show({'initial.y': 1.4})")
    until_text(page, "impacts in")


def test_a_change_that_cannot_start_is_undone_alone_and_nothing_plays(show):
    page = show(hash_="#contact.restitution=0.4")
    page.evaluate("chainImpact.show({ 'initial.y': -3 })")
    until_text(page, "cannot start", "status")
    page.keyboard.press("Space")
    assert page.locator("#play").get_attribute("aria-label") == "Play"
    assert page.locator("footer").evaluate("footer => footer.inert")
    page.evaluate("chainImpact.show({ 'contact.restitution': 0.5 })")
    until(page, "document.getElementById('stage').ariaBusy === 'false'")
    page.get_by_role("button", name="Undo the change of Initial height", exact=True).click()
    until(page, "document.getElementById('status').hidden")
    assert page.evaluate("chainImpact.parameters['contact.restitution']") == "0.5"
    assert page.evaluate("chainImpact.parameters['initial.y']") != "-3"
    page.keyboard.press("Space")
    page.get_by_role("button", name="Pause").wait_for()


def test_after_a_refusal_the_numbers_of_the_run_before_are_not_shown(show):
    page = show()
    page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({ 'box.y_min': 1.5 })")
    until_text(page, "point 0 starts 0.1\u202fm beyond the floor.", "status")
    page.get_by_role("button", name="Undo the change of Position of the floor").wait_for()
    numbers = (
        "#impacts",
        "#energies",
        "#caption",
        "#subtitle",
        "#pin-table tbody tr:first-child td >> nth=0",
    )
    assert not any(page.locator(place).is_visible() for place in numbers)
    assert page.locator("#pin-table tbody tr:nth-child(2) td").first.is_visible()
    page.evaluate("chainImpact.show({ 'box.y_min': 0 })")
    until(page, "!document.body.classList.contains('stale')")
    assert all(page.locator(place).is_visible() for place in ("#impacts", "#energies", "#subtitle"))


def test_a_contact_that_lasts_is_listed_as_such(show):
    page = show("sliding_rod")
    rows = page.locator("#impacts tbody tr").all_inner_texts()
    impacts = simulate("sliding_rod").impacts
    assert [("lasts" in row) for row in rows] == np.isnan(impacts["end"]).tolist()
    assert any("lasts" in row for row in rows)


def test_a_ratio_of_speeds_above_1_is_told_as_such_and_no_impulse_is_cut(show):
    """With rigid walls, the arms push a point off in many contacts whose impact speed is tiny."""
    changes = {"contact.model": "newton_impact", "contact.restitution": 0.38}
    page = show(hash_="#contact.model=newton_impact&contact.restitution=0.38")
    impacts = simulate(load_scene("four_link_box").with_values(changes)).impacts[:40]
    cells = page.locator("#impacts tbody td:nth-child(6)")
    ratios = impacts["separation_speed"] / impacts["impact_speed"]
    assert ratios.max() > 1e3
    expected = [">\u00a01" if ratio > 1 else f"{ratio:.3f}" for ratio in ratios]
    assert cells.all_inner_texts()[:40] == expected
    pushed = int(np.argmax(ratios))
    title = cells.nth(pushed).get_attribute("title")
    number, prefix = re.search(r"([\d.]+)\u202f(m?)m/s", title).groups()
    speed = float(number) * (1e-3 if prefix else 1.0)
    assert speed == pytest.approx(impacts["separation_speed"][pushed], rel=5e-3)
    box = page.locator("#impacts").bounding_box()
    last = page.locator("#impacts tbody tr:first-child td:last-child").bounding_box()
    assert last["x"] + last["width"] <= box["x"] + box["width"] + 0.5
    assert page.evaluate("impacts.scrollWidth <= impacts.clientWidth")


def test_the_list_has_room_for_units_of_stops(show):
    page = show("kneed_leg", hash_="#stop.restitution=0.5")
    page.evaluate("chainImpact.show({'stop.restitution': 0.3})")
    until_text(page, impacts_of({"stop.restitution": 0.3}, "kneed_leg"))
    for size in (PHONE, DESK):
        resize(page, **size)
        assert page.evaluate("impacts.scrollWidth <= impacts.clientWidth"), size
    peak_text = page.locator("#impacts tbody tr:first-child td:last-child").inner_text()
    units = page.locator("#impacts th").all_inner_texts()
    assert units[4] == "speed, rad/s", "one unit for all"
    assert (
        page.locator("#impacts-before").inner_text().endswith(f" → {peak_text}\u202f{units[6].split()[-1]}")
    )
    assert page.locator("#impacts tbody tr").first.get_attribute("title") == "Joint 3 at max (point 2)"


def test_the_page_within_a_lesson_without_a_worker_and_in_an_old_browser(browser, server):
    page = browser.new_page()
    page.goto(f"{server}/lesson.html")
    page.frame_locator("iframe").get_by_text("impacts in").wait_for()
    height = page.evaluate("""async () => {
      const { chainImpact } = document.querySelector("iframe").contentWindow;
      return (await chainImpact.simulate({ "initial.y": 1.5 })).columns["point[0].y"][0]; }""")
    assert height == 1.5
    page.goto(f"{server}/rod.html?strict")
    until_text(page, "The solver cannot work in this browser: ", "status")
    assert not page.evaluate("document.body.classList.contains('computing')")
    page.add_init_script("delete window.DecompressionStream")
    page.goto(f"{server}/rod.html")
    needs = page.get_by_text("It needs JavaScript and a browser of 2023 or later")
    needs.wait_for(state="attached")
    needs.evaluate(
        "(status) => status.getAnimations().forEach((animation) => animation.finish())"
    )  # which waits for 4 s
    assert needs.is_visible()
    page.close()


def test_the_page_stays_within_the_screen(show):
    page = show()
    for size in (DESK, PHONE, {"width": 320, "height": 320}):
        page.emulate_media(color_scheme="dark" if size is PHONE else "light")
        resize(page, **size)
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), size
        assert page.locator("#scene").is_visible()
        play = page.get_by_role("button", name="Play")
        view, button_box = page.locator("#view").bounding_box(), play.bounding_box()
        assert button_box["y"] + button_box["height"] <= size["height"]
        assert min(button_box["y"], view["y"] + view["height"]) - view["y"] > 100, "the motion is in sight"
        play.click()
        page.get_by_role("button", name="Pause").click()


def test_keys_move_grips_and_points_are_numbered(show):
    page = show()
    assert page.locator("#description").inner_text() == load_scene("four_link_box").description
    assert page.locator(".point-number").all_text_contents() == ["0", "1", "2", "3", "4"]
    names = {
        "Point 0: arrow keys move it": "initial.x",
        "Velocity of point 2: arrow keys change it": "initial.angular_velocity[2]",
        "Right wall: arrow keys move it": "box.x_max",
    }
    for spoken, name in names.items():
        page.get_by_role("button", name=spoken).focus()
        for _ in range(2):
            value = float(page.evaluate("chainImpact.parameters")[name])
            page.keyboard.press("ArrowRight")
            until(page, f"Number(chainImpact.parameters['{name}']) !== {value}")
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


def test_the_list_has_speed_ratios_and_the_chart_has_the_force_loop(show):
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
    assert "penetration" in page.inner_text("#contact-quantity")
    loss = first["effective_mass"] / 2 * (first["impact_speed"] ** 2 - first["separation_speed"] ** 2)
    assert page.inner_text("#contact-name").endswith(f", loss\xa0{loss:.0f}\u202fJ"), (
        "of a nearly free impact"
    )
    line = page.evaluate(function_of("explore_page", "lineOfForces"))
    assert line[-1] - line[0] > 8, "with a loss, the force on the way back is smaller"
    page.get_by_role("button", name="F(δ)").click()
    assert page.locator("#force .now").is_visible()
    line, plot = (page.locator(f"#force {name}").bounding_box() for name in (".now", ".u-over"))
    assert line["y"] - plot["y"] > 15.0, "the line does not cross the number of the peak force"
    assert "penetration" not in page.inner_text("#contact-quantity")


def test_many_runs_leave_the_memory_as_it_was(show):
    size_before, size_after, size_with_leak, is_same, _ = show().evaluate(MEMORY_OF_RUNS)
    assert is_same
    assert size_after - size_before < 0.4e6  # 1000 bytes per run
    assert size_with_leak - size_after > 5e6  # a leak of 8 MB would be detected here


def test_a_long_run_does_not_freeze_the_page_and_gives_way_to_the_next(show):
    page = show()
    page.evaluate("chainImpact.show({'simulation.stop_time': 100000, 'contact.model': 'newton_impact'})")
    until(page, "document.body.classList.contains('computing')")
    frames = page.evaluate(function_of("explore_page", "longestFrame"))
    assert frames < 400  # ms, on a busy machine
    page.get_by_role("button", name="Reset all").click()
    until(page, "!document.body.classList.contains('computing')")
    until_text(page, "14 impacts in 2 s")


def test_a_button_that_is_pressed_before_the_page_is_ready_acts_later(browser, address):
    """The presses come when the page is read, before its program begins. They pause no motion."""
    presses = "['pin', 'export-open', 'play'].forEach((id) => document.getElementById(id).click())"
    script = f"document.addEventListener('readystatechange', () => {{ {presses}; }}, {{ once: true }});"
    page = browser.new_page()
    page.add_init_script(script)
    page.goto(address)
    page.locator("#pins tbody tr").nth(1).wait_for()
    assert page.locator("#export").is_visible()
    until(page, "document.body.matches('.playing')")
    page.close()


@pytest.mark.parametrize("changes", ["", "#simulation.stop_time=0.1"])
def test_the_page_is_loaded_when_it_shows_its_first_motion(show, changes):
    page = show(hash_=changes, begins=False)
    at = page.evaluate("""[performance.getEntriesByName('first-frame')[0].startTime,
      performance.getEntriesByType('navigation')[0].loadEventStart]""")
    assert at[0] <= at[1]
    assert page.locator("iframe").count() == 0


def test_an_unknown_name_gets_the_nearest_one(show):
    page = show()
    message = page.evaluate(
        "chainImpact.simulate({'contact.restitutoin': 0.5}).catch((error) => error.message)"
    )
    assert message.endswith("has no parameter contact.restitutoin; the nearest is contact.restitution")
    message = page.evaluate(
        "chainImpact.simulate({}, {output: ['energy.totl']}).catch((error) => error.message)"
    )
    assert message == "energy.totl is not an output; the nearest is energy.total"
    page.locator("summary", has_text="All parameters").click()
    page.get_by_role("searchbox", name="Search the parameters").fill("gravty.y")
    assert page.inner_text("#list-of-parameters .nothing").endswith("; the nearest is gravity.y.")


def test_a_scene_whose_controller_is_elsewhere_tells_that_its_inputs_are_0(show):
    page = show("controlled_arm")
    assert "Here no controller sets the inputs" in page.inner_text("#description")
    assert page.inner_text(".inputs summary") == "Inputs all are 0"
    assert page.get_by_role("slider", name="Torque of joint 1").is_visible()
    page = show("four_link_box")
    assert "controller" not in page.inner_text("#description")
    assert page.locator(".inputs").count() == 0


def test_only_inputs_that_nothing_sets_are_told_to_be_0(show):
    page = show("cart_pole")
    assert "controller" not in page.inner_text("#description"), "a signal sets an input"
    rows = page.locator("#main-parameters > *")
    assert rows.first.inner_text().startswith("Contact law")
    assert page.inner_text(".signal summary") == "Force on the tip, x −0.5 … 0\u202fN"
    inputs = page.locator(".inputs summary")
    assert inputs.inner_text() == "Inputs all are 0"
    assert not page.get_by_role("slider", name="Force on the slider").is_visible()
    inputs.click()
    names = "[...document.querySelectorAll('#inputs-over-time dt.of-curve')].map((name) => name.title)"
    assert page.evaluate(names) == ["tip.force.x"]
    page.get_by_role("slider", name="Force on the slider").press("PageUp")
    assert inputs.inner_text() == "Inputs 1 of 2 not 0"
    until(page, "document.querySelectorAll('#inputs-over-time dt.of-curve').length === 2")
    assert page.evaluate(names) == ["tip.force.x", "slider.force"]
    value = float(page.evaluate("chainImpact.parameters['slider.force']"))
    assert value > 0
    shown_value = page.locator("#inputs-over-time dd").last.inner_text().split("\u202f")
    assert (float(shown_value[0]), shown_value[1]) == (value, "N")
    page.evaluate("chainImpact.show({ 'tip.force.y': 0.1 })")
    until(page, "document.querySelector('.inputs summary').textContent.trim() === 'Inputs'")
    page.get_by_role("button", name="Reset all").click()
    assert inputs.inner_text() == "Inputs all are 0"
    until(page, "document.querySelectorAll('#inputs-over-time dt.of-curve').length === 1")


def test_the_slider_of_the_restitution_ends_where_the_law_does(show):
    """A law that does not allow 0 ends at one step of the slider, any other law at 0."""
    page = show()
    slider = page.get_by_role("slider", name="Restitution")
    slider.press("Home")
    until(page, "chainImpact.parameters['contact.restitution'] === '0.0025'")
    until_text(page, impacts_of({"contact.restitution": 0.0025}))
    assert not page.locator("#status").is_visible()
    slider.press("End")
    until(page, "chainImpact.parameters['contact.restitution'] === '1'")
    page.evaluate("chainImpact.show({ 'contact.model': 'hunt_crossley' })")
    slider.press("Home")
    until(page, "chainImpact.parameters['contact.restitution'] === '0'")


def test_a_rigid_wall_has_a_chart_of_impulses_and_an_arrow(show):
    page = show("bouncing_ball", {"simulation.stop_time": 9.5})
    first = simulate(load_scene("bouncing_ball")).impacts[0]
    words = f"{first['impulse']:.2f}\u202fN·s"
    title = page.locator("#contact-name")
    assert title.inner_text().endswith(f", {words}, rigid")
    is_whole = "(text) => text.scrollWidth <= text.clientWidth && text.scrollHeight <= text.clientHeight"
    assert title.evaluate(is_whole)
    assert page.text_content(".ruler-name") == "force (cube root)", "the ball rests at the end"
    assert page.inner_text("#contact-quantity") == "Impulses"
    assert page.inner_text("#force .peak") == words
    assert page.locator("#force-loop").is_hidden()
    assert page.evaluate(PIXELS, ["force", "force"]) > 200
    assert page.locator(".arrow").count() == 0
    go_to(page, first["onset"] + 0.02)
    assert page.locator(".arrow").count() == 1
    assert page.text_content(".force-text") == words
    assert page.text_content(".ruler-name") == "impulse (cube root)"
    assert page.text_content(".ruler-text").endswith("N·s")
    go_to(page, first["onset"] + 0.4)
    assert page.locator(".arrow").count() == 0, "the arrow is seen for a moment"
    card = page.locator("#contact").bounding_box()
    box = title.bounding_box()
    assert box["y"] + box["height"] <= card["y"] + card["height"]


def test_a_row_of_an_impact_tells_where_it_is(show):
    page = show()
    first = simulate("four_link_box").impacts[0]
    position_text = page.locator("#impacts tbody tr").first.get_attribute("title").replace("−", "-")
    x, y = map(float, re.fullmatch(r"At x = (\S+)\sm, y = (\S+)\sm", position_text).groups())
    assert (x, y) == pytest.approx((first["x"], first["y"]), abs=5.1e-5)


def test_the_first_steps_are_marked_until_they_are_taken(show):
    page = show(hash_="#contact.model=newton_impact")
    page.evaluate("localStorage.clear()")
    page.reload()
    line = page.locator("#first-steps span")
    pin, open_map = (page.get_by_role("button", name=name) for name in ("Pin", "Map…"))
    slider = page.locator(".main-parameter", has=page.get_by_role("slider", name="Restitution"))
    idle = page.locator(".main-parameter", has=page.get_by_role("slider", name="Stiffness"))
    controls = [slider, pin, open_map, idle]

    def marked():
        colours = [
            control.evaluate("(element) => getComputedStyle(element).backgroundColor") for control in controls
        ]
        return [colour.startswith("color(") for colour in colours]

    until(page, "document.querySelector('.idle')")
    assert line.inner_text() == "First step: move a slider, the motion follows"
    assert marked() == [True, False, False, False], "a slider without effect is not the first step"
    slider.get_by_role("slider").press("ArrowLeft")
    assert line.inner_text() == "Next step: Pin keeps this motion to compare"
    assert marked() == [False, True, False, False]
    pin.click()
    assert line.inner_text() == "Next step: Map… shows many runs"
    page.mouse.move(0, 0)
    assert marked() == [False, False, True, False]
    open_map.click()
    assert line.is_hidden()
    assert page.evaluate("document.body.dataset.step === undefined")
    page.reload()
    until(page, "document.getElementById('time').textContent")
    assert line.is_hidden(), "the browser keeps that they are taken"
