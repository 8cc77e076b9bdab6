"""A Chromium for the tests of the page that simulates, and the kernel in it without the page."""

import base64
import json

import numpy as np
import pytest

from chain_impact.compilation.library import browser_module
from chain_impact.results.animation.page import EXPORT
from chain_impact.results.explore.description import description
from chain_impact.results.explore.page import PAGE
from tests.results.animation.conftest import browser, needs_browser

__all__ = ["browser", "needs_browser"]

RUN = """async ({ module, scene, values, stop, step }) => {
  window.module ??= await WebAssembly.compile(Uint8Array.from(atob(module), (sign) => sign.charCodeAt(0)));
  const kernel = await Kernel.load(window.module, scene);
  const times = rowTimes(stop, step);
  const places = scene.columns.filter(({ place }) => place !== undefined).map(({ place }) => place);
  const words = scene.columns.filter(({ word }) => word !== undefined).map(({ word }) => word);
  const run = runThrough(kernel.run(values, times, places));
  const stepwise = runThrough(kernel.run(values, times, [], words));
  const text = (arrays) => arrays.map((array) => {
    const bytes = new Uint8Array(array.buffer);
    let signs = "";
    for (let k = 0; k < bytes.length; k += 4096) signs += String.fromCharCode(...bytes.subarray(k, k + 4096));
    return btoa(signs);
  });
  const impacts = run.impacts.map((impact) =>
    Object.fromEntries(Object.entries(impact).map(([name, value]) => [name, String(value)])));
  return { ...run, impacts, time: text([run.time]), columns: text(run.columns), words: text(stepwise.words) };
}"""


@pytest.fixture(scope="module")
def kernel(browser):
    """Run a scene in a browser: its columns by name, its impacts, and the rest of what the kernel found."""
    page = browser.new_page()
    program = EXPORT.sub("", PAGE.joinpath("kernel.js").read_text())
    page.set_content(f"<script>{program}</script>")
    module = base64.b64encode(browser_module().read_bytes()).decode()

    def run(scene, values=None):
        found = description(scene, scene.name)
        times = {"stop": scene.simulation.stop_time, "step": scene.simulation.step_size}
        # JSON knows no infinite numbers
        given = {"module": module, "scene": json.loads(json.dumps(found)), "values": values or {}, **times}
        result = page.evaluate(RUN, given)
        names = [one["name"] for one in found["columns"] if "place" in one]
        others = [one["name"] for one in found["columns"] if "word" in one]
        columns = {name: bits(text) for name, text in zip(names, result["columns"], strict=True)}
        columns |= {name: bits(text) for name, text in zip(others, result["words"], strict=True)}
        return {**result, "time": bits(result["time"][0]), "columns": columns}

    yield run
    page.close()


def bits(text):
    """The numbers of a typed array, as whole numbers: their bits."""
    return np.frombuffer(base64.b64decode(text), np.int64)
