"""The page in Debian's Firefox: bit-equal results of `simulate()`, a manual start, and a map."""

# Tests: pages/explore.py

import json
import os
import re
import socket
import warnings

import numpy as np
import pytest

from chain_impact import explore, load_scene, simulate
from chain_impact.scene.files.models import scene_file_path
from tests.tiers import FIREFOX, needs_browser

pytestmark = needs_browser
# Marionette's scripts cannot use the page's own objects: this code runs a function body inside the page.
ANSWER_CODE = """const [body, done] = arguments;
const page = window.wrappedJSObject;
page.eval(`delete window.answer; (async () => { ${body} })()
  .catch((error) => ({ error: String(error) })).then((value) => { window.answer = JSON.stringify(value); })`);
const look = () => (page.answer === undefined ? setTimeout(look, 10) : done(page.answer));
look();"""
UNTIL_CODE = "while (!({})) await new Promise((go) => setTimeout(go, 20)); return true;"


class Firefox:
    """A Firefox with the requests of the tests."""

    def __init__(self):
        from marionette_driver.marionette import Marionette

        with socket.socket() as free_socket:
            free_socket.bind(("127.0.0.1", 0))
            port = free_socket.getsockname()[1]
        address = {"host": "127.0.0.1", "port": port}
        preferences = {"ui.prefersReducedMotion": 1}
        self.driver = Marionette(
            **address, bin=FIREFOX, headless=True, gecko_log=os.devnull, prefs=preferences
        )
        self.driver.start_session()
        self.driver.timeout.script = 120
        self.driver.set_window_rect(width=1366, height=900)

    def open(self, file):
        self.driver.navigate(file.as_uri())
        self.wait("performance.getEntriesByName('first-frame').length === 1")

    def answer(self, body):
        """Return the result of a function body in the page."""
        return json.loads(self.driver.execute_async_script(ANSWER_CODE, [body]))

    def wait(self, condition):
        assert self.answer(UNTIL_CODE.format(condition)) is True

    def middle(self, selector):
        """Return the middle of an element [pixels], which the page may draw anew at any time."""
        box = f"document.querySelector({json.dumps(selector)}).getBoundingClientRect()"
        return self.answer(
            f"const {{ x, y, width, height }} = {box}; "
            "return [x + width / 2, y + height / 2].map(Math.round);"
        )

    def find(self, selector):
        return self.driver.find_element("css selector", selector)

    def close(self):
        self.driver.quit()
        self.driver.cleanup()


@pytest.fixture(scope="module")
def firefox():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the driver uses deprecated functions, and leaves sockets open
        started = Firefox()
    yield started
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        started.close()


@pytest.mark.parametrize("model", ["four_link_box", "sliding_rod"])
def test_a_run_in_firefox_has_the_bits_of_simulate(firefox, tmp_path, model):
    explore(model, tmp_path / "page.html")
    firefox.open(tmp_path / "page.html")
    changes = {"solver.tolerance": 1e-7}
    result_in_page = firefox.answer(f"""
      const run = await chainImpact.simulate({json.dumps(changes)});
      const ends = (column) => Array.from(new BigInt64Array(column.slice(-40).buffer), String);
      return {{ rows: run.time.length, impacts: run.impacts.map(({{ onset }}) => onset),
        columns: Object.entries(run.columns).map(([name, column]) => [name, ends(column)]) }};""")
    result = simulate(load_scene(model).with_values(changes))
    assert result_in_page["rows"] == len(result.time)
    assert result_in_page["impacts"] == result.impacts["onset"].tolist()
    assert [name for name, _ in result_in_page["columns"]] == list(result.columns)
    for name, ends in result_in_page["columns"]:
        expected = result[name][-40:].astype(np.float64).view(np.int64)
        assert list(map(int, ends)) == expected.tolist(), name


def test_firefox_drags_a_joint_moves_it_by_keys_and_draws_a_map(firefox, tmp_path):
    scene = load_scene("rod_drop").with_values({"simulation.stop_time": 0.6})
    explore(scene, tmp_path / "rod.html")
    firefox.open(tmp_path / "rod.html")
    pointer = firefox.driver.actions.sequence("pointer", "mouse", {"pointerType": "mouse"})
    pointer.pointer_move(*firefox.middle('[data-grip="joint 1"]')).pointer_down()
    pointer.pointer_move(0, -40, origin="pointer").pointer_up().perform()
    start = scene.values["initial.angle[1]"]
    firefox.wait(f"chainImpact.parameters['initial.angle[1]'] > {start} + 0.01")
    firefox.find("#reset-all").click()
    firefox.wait(f"Number(chainImpact.parameters['initial.angle[1]']) === {start}")
    firefox.answer("document.querySelector('[data-grip=\"joint 1\"]').focus(); return true;")
    up_arrow = "\ue013"
    for least_change in (0.005, 0.01):
        firefox.driver.actions.sequence("key", "keyboard").key_down(up_arrow).key_up(up_arrow).perform()
        firefox.wait(f"chainImpact.parameters['initial.angle[1]'] > {start} + {least_change}")
    firefox.find("#map-open").click()
    firefox.find("#map-run").click()
    firefox.wait("document.getElementById('map-text').textContent.includes('1681 runs in')")
    pointer = firefox.driver.actions.sequence("pointer", "mouse", {"pointerType": "mouse"})
    pointer.pointer_move(3, 3, origin=firefox.find("#map-canvas")).perform()
    match = re.search(
        r"Restitution = ([\d.]+), Initial angle of link 1 = ([\d.]+)\s?°: "
        r"Largest force at a wall = ([\d.]+)\s?kN",
        firefox.find("#map-text").text,
    )
    values = {"contact.restitution": float(match[1]), "initial.angle[1]": np.deg2rad(float(match[2]))}
    peaks = simulate(scene.with_values(values)).impacts["peak_force"]
    assert 1e3 * float(match[3]) == pytest.approx(peaks.max(), rel=1e-3)


def test_a_link_is_added_in_firefox_and_a_file_opens_where_it_is_dropped(firefox, tmp_path):
    explore("rod_drop", tmp_path / "rod.html")
    firefox.open(tmp_path / "rod.html")
    for button in ("edit-open", "add-link"):
        firefox.find(f"#{button}").click()
    firefox.wait("document.getElementById('subtitle').textContent.startsWith('2 links')")
    text = scene_file_path("ramp").read_text(encoding="utf-8")
    firefox.answer(
        f"""
      const data = new DataTransfer();
      data.items.add(new File([{json.dumps(text)}], "ramp.toml"));
      const options = {{ dataTransfer: data, bubbles: true, cancelable: true }};
      return document.body.dispatchEvent(new DragEvent("drop", options));""".replace("`", "")
    )
    firefox.wait("chainImpact.scene === 'Ramp'")
    onsets = firefox.answer("return (await chainImpact.simulate()).impacts.map(({ onset }) => onset);")
    assert onsets == simulate("ramp").impacts["onset"].tolist()
