"""What the page says where something cannot be, and the page within another one."""

import functools
import threading
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer

import pytest

from chain_impact import explore
from tests.tiers import needs_browser

pytestmark = needs_browser
STATUS = "document.getElementById('status').textContent.includes({!r})"


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    """A server of a folder with the page, within another page: its address."""
    folder = tmp_path_factory.mktemp("server")
    explore("rod_drop", folder / "rod.html")
    (folder / "lesson.html").write_text('<iframe src="rod.html" width="900" height="700"></iframe>')

    class Handler(SimpleHTTPRequestHandler):
        def end_headers(self):
            if "?strict" in self.path:
                self.send_header("Content-Security-Policy", "worker-src 'self'")
            super().end_headers()

        def log_message(self, *_):
            """Be quiet."""

    started = ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Handler, directory=folder))
    threading.Thread(target=started.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{started.server_port}"
    started.shutdown()
    started.server_close()


def test_a_lesson_calls_the_page_that_it_holds(browser, server):
    page = browser.new_page()
    page.goto(f"{server}/lesson.html")
    page.frame_locator("iframe").get_by_text("impacts in").wait_for()
    height = page.evaluate("""async () => {
      const { chainImpact } = document.querySelector("iframe").contentWindow;
      return (await chainImpact.simulate({ "initial.y": 1.5 })).columns["point[0].y"][0]; }""")
    assert height == 1.5
    page.close()


def test_a_worker_that_may_not_begin_is_told(browser, server):
    page = browser.new_page()
    page.goto(f"{server}/rod.html?strict")
    page.wait_for_function(STATUS.format("The solver cannot work in this browser: "))
    assert not page.evaluate("document.body.classList.contains('computing')")
    page.close()


def test_an_old_browser_is_told_what_it_needs(browser, server):
    page = browser.new_page()
    page.add_init_script("delete window.DecompressionStream")
    page.goto(f"{server}/rod.html")
    page.get_by_text("It needs JavaScript and a browser of 2023 or later").wait_for()
    page.close()


def test_keys_and_buttons_do_nothing_while_there_is_no_motion(show):
    page = show(hash_="#initial.y=-3", begins=False)
    page.wait_for_function(STATUS.format("cannot start"))
    for key in ("Space", "ArrowRight", "Home", "End", "Shift+ArrowRight"):
        page.keyboard.press(key)
    page.get_by_role("button", name="Play").click()
    assert page.get_by_label("Speed").input_value() == "1"
    page.evaluate("chainImpact.show({'initial.y': 1.4})")
    page.wait_for_function("document.getElementById('subtitle').textContent.includes('impacts in')")


def test_a_table_that_is_too_large_or_not_complete_is_told_where_it_is_asked_for(show):
    page = show(hash_="#simulation.step_size=1e-9")
    page.get_by_role("button", name="Export…").click()
    page.get_by_role("button", name="Outputs as CSV").click()
    said = page.locator("#export-text")
    said.get_by_text("the table would be too large").wait_for()
    page.get_by_role("button", name="Close").click()
    page.evaluate("chainImpact.show({'simulation.step_size': 0.001, 'solver.work_limit': 2000})")
    page.wait_for_function(STATUS.format("stopped at"))
    page.get_by_role("button", name="Export…").click()
    with page.expect_download():
        page.get_by_role("button", name="Outputs as CSV").click()
    said.get_by_text("The simulation stopped at t = 1.62152 s").wait_for()


def test_an_output_that_is_no_list_is_refused(show):
    asked = "chainImpact.simulate({}, { output: 'point[4].x' }).catch((error) => error.message)"
    assert show().evaluate(asked) == "output must be a list of names"


def test_inputs_are_told_to_be_zero(browser, tmp_path):
    page = browser.new_page()
    for model, text in (("controlled_arm", "Inputs are zero here: joint[1].torque"), ("rod_drop", "")):
        explore(model, tmp_path / f"{model}.html")
        page.goto((tmp_path / f"{model}.html").as_uri())
        page.wait_for_function("performance.getEntriesByName('first-frame').length === 1")
        assert text in page.locator("#inputs").inner_text()
        assert page.locator("#inputs").is_visible() == bool(text)
    page.close()
