"""A Chromium for the tests of the pages, with a page or with the kernel alone, and what tests do in pages."""

import base64
import io
import json
from functools import cache
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from PIL import Image

from chain_impact import explore, load_scene, simulate
from chain_impact.compilation.library import browser_module
from chain_impact.pages.explore import TOML, contents, packed
from chain_impact.pages.recorded import program, text_of
from chain_impact.results.animate import animate
from chain_impact.studies.animate import record_slowly
from tests.pages.javascript import Script
from tests.tiers import CHROMIUM

DESK, PHONE, ON_ITS_SIDE = (
    {"width": width, "height": height} for width, height in ((1366, 768), (390, 844), (844, 390))
)

RUN = """async ({ module, file, kit, values, stop, step }) => {
  const scene = sceneOf({ file, kit });
  const kernel = await Kernel.load(await compiled(module), scene);
  const times = rowTimes(stop, step);
  const run = runThrough(kernel.run(values, times, scene.columns));
  const text = (arrays) => arrays.map((array) => {
    const bytes = new Uint8Array(array.buffer);
    let signs = "";
    for (let k = 0; k < bytes.length; k += 4096) signs += String.fromCharCode(...bytes.subarray(k, k + 4096));
    return btoa(signs);
  });
  const impacts = run.impacts.map((impact) =>
    Object.fromEntries(Object.entries(impact).map(([name, value]) => [name, String(value)])));
  return { ...run, impacts, time: text([run.time]), columns: text(run.columns), names: scene.columns,
    reasons: scene.reasons };
}"""


SCENE = ("scene/changes.js", "scene/changed_file.js", "scene/model.js")
"""The modules that read, change and write a scene file."""
RECORDING = (
    "solver/motion.js",
    "player/packed_recording.js",
    "drawing/arrow_scale.js",
    "charts/curve_charts.js",
    "base/ticks.js",
)
"""Further modules that need no browser to be run."""
MODULES = ("solver/motion.js", "base/base64.js", *SCENE)
"""The modules that read a scene file, and compute a motion."""
SCENE_OF = "const sceneOf = ({ file, kit }) => describe(kit, complete(file, kit), []);"
COMPILED = f"""{SCENE_OF}
const modules = new Map();
async function compiled(text) {{
  if (!modules.has(text)) modules.set(text, await WebAssembly.compile(await decompressed(text)));
  return modules.get(text);
}}"""
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
SUBTITLE = "document.getElementById('subtitle').textContent"
TIME_TEXT = "document.getElementById('time').textContent"
LIGHT_CHAIN, DARK_CHAIN = "#2b4a9f", "#9db4ff"


@pytest.fixture(scope="module")
def browser():
    from playwright.sync_api import sync_playwright  # the quick tier does not need playwright

    with sync_playwright() as playwright:
        # In a container root has no sandbox; the page is our own. Without the other switches, Chromium always
        # reports 10 MB of memory.
        told = ["--enable-precise-memory-info", "--js-flags=--expose-gc"]
        started = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox", *told])
        yield started
        started.close()


@pytest.fixture(scope="session")
def address(tmp_path_factory):
    path = tmp_path_factory.mktemp("explore") / "box.html"
    explore("four_link_box", path)
    return path.as_uri()


@pytest.fixture
def open_page(browser):
    """Open a page, which must not report errors or load files; its clock may be ``stopped``."""
    said, opened, local = [], [], ["data:", "blob:"]

    def open_page(address, begins=True, stopped=False, **options):
        page = browser.new_page(**{"viewport": DESK, "reduced_motion": "reduce", **options})
        opened.append(page)
        local.append(address.split("#")[0])
        if stopped:
            page.clock.install(time=0)
        page.on("console", lambda message: said.append(message.text))
        page.on("pageerror", lambda error: said.append(str(error)))
        page.on("request", lambda request: said.append(request.url))
        page.goto(address)
        if stopped:
            page.clock.pause_at(60)
        elif begins:
            page.wait_for_function("performance.getEntriesByName('first-frame').length === 1")
        return page

    yield open_page
    for page in opened:
        page.close()
    assert [text for text in said if not text.startswith(tuple(local))] == []


@pytest.fixture
def show(open_page, address, tmp_path):
    """Open the simulating page with the four-link box, or with other values."""

    def show(model="", changes=None, hash_="", **options):
        if not model:
            return open_page(address + hash_, **options)
        path = tmp_path / f"{model}.html"
        explore(load_scene(model).with_values(changes or {}), path)
        return open_page(path.as_uri() + hash_, **options)

    return show


def until(page, condition):
    """Wait for a condition that the page evaluates."""
    page.wait_for_function(condition)


def until_told(page, text, where="subtitle"):
    """Wait for a text in an element of the page."""
    until(page, f"document.getElementById({where!r}).textContent.includes({json.dumps(text)})")


@pytest.fixture(scope="session")
def script():
    """Return the modules of the pages that need no browser, with ``sceneOf``."""
    modules = Script(*SCENE, *RECORDING)
    modules.context.eval(SCENE_OF)
    return modules


@pytest.fixture(scope="module")
def worker(browser):
    """Return a page with the worker's program without a worker; ``compiled`` makes a module of a text."""
    page = browser.new_page()
    toml = f"const TOML = {{}}; (function (exports) {{ {text_of(TOML)} }})(TOML);"
    page.set_content(f"<script>{program(*MODULES)}{COMPILED}{toml}</script>")
    yield page
    page.close()


@pytest.fixture(scope="module")
def kernel(worker):
    """Run a scene in a browser: its columns by name, its impacts, and the other results of the kernel."""

    def run(scene, values=None):
        times = {"stop": scene.simulation.stop_time, "step": scene.simulation.step_size}
        module = packed_module(scene.contact.law_file)
        given = {"module": module, "values": values or {}, **page_contents(scene), **times}
        result = worker.evaluate(RUN, given)
        columns = {}
        for one, text in zip(result.pop("names"), result["columns"], strict=True):
            numbers = bits(text)
            columns[one["name"]] = numbers.view(np.float64).astype(int) if one["integer"] else numbers
        return {**result, "time": bits(result["time"][0]), "columns": columns}

    return run


def page_contents(scene):
    """Return a page's data of a scene: the contents of its file, and the data for all scenes."""
    return json.loads(json.dumps(contents(scene, [])))


@cache
def packed_module(law_file=""):
    """Return the module for a browser, as the page holds the module."""
    return packed(browser_module(law_file=law_file).read_bytes())


def bits(text):
    """Return the bits of the numbers of a typed array, as whole numbers."""
    return np.frombuffer(base64.b64decode(text), np.int64)


@pytest.fixture(scope="module")
def recording():
    return record_slowly(load_scene("four_link_box"))


@pytest.fixture(scope="module")
def recorded_address(recording, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "box.html"
    animate(recording, path)
    return path.as_uri()


@pytest.fixture
def show_recording(open_page, recorded_address, tmp_path):
    """Open the page of the box with four links, or of another recording."""

    def show(recording=None, address=recorded_address, **options):
        if recording is not None:
            animate(recording, tmp_path / "page.html")
            address = (tmp_path / "page.html").as_uri()
        return open_page(address, **options)

    return show


def impacts_of(changes):
    return f"{len(simulate(load_scene('four_link_box').with_values(changes)).impacts)} impacts"


def enter(page, name, text):
    field = page.get_by_role("textbox", name=name).first
    field.fill(text)
    field.press("Enter")
    return field


def saved(page, button):
    """Return the file that a button gives."""
    with page.expect_download() as download:
        page.get_by_role("button", name=button).click()
    return Path(download.value.path())


def time_of(page):
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    return float(page.evaluate(TIME_TEXT).removesuffix(" s"))


def press(page, key):
    """Return the simulated time that is shown after a key."""
    page.keyboard.press(key)
    return time_of(page)


def go_to(page, time):
    """Return the simulated time that is shown after a move of the slider."""
    page.locator("#scrub").evaluate(
        "(e, t) => { e.value = t; e.dispatchEvent(new Event('input', { bubbles: true })); }", time
    )
    return time_of(page)


def pixels(page):
    return np.asarray(Image.open(io.BytesIO(page.screenshot())).convert("RGB")).astype(float)


def count_of(picture, colour):
    return int((abs(picture - 255 * np.array(mpl.colors.to_rgb(colour))).max(axis=-1) < 6).sum())
