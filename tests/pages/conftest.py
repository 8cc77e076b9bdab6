"""Fixtures of the tests of pages: a Chromium with a page or with the kernel alone, and scripts without it."""

import numpy as np
import pytest

from chain_impact import explore, load_scene, simulate
from chain_impact.pages.assembly import browser_text, program_text
from chain_impact.pages.explore import TOML
from chain_impact.results.animation import write_animation
from chain_impact.studies.animate import record_slowly
from tests.pages.in_pages import DESK, TEXTS, bits, packed_module, page_contents
from tests.pages.javascript import Script, function_of
from tests.tiers import CHROMIUM

RUN = function_of("conftest", "runInPage")


SCENE = ("scene/changes.js", "scene/changed_file.js", "scene/page_scene.js")
"""The modules that read, change and write a scene file."""
RECORDING = (
    "solver/motion.js",
    "player/packed_recording.js",
    "drawing/arrow_scale.js",
    "drawing/label_positions.js",
    "drawing/rings.js",
    "drawing/trace.js",
    "charts/contact_course.js",
    "charts/curve_charts.js",
    "charts/energy_zero.js",
    "base/similar_names.js",
    "base/ticks.js",
    "explore/edited_scene.js",
    "explore/map/map_colours.js",
    "explore/map/map_contour.js",
    "explore/map/map_rows.js",
    "explore/refused_start.js",
    "explore/stopped_run.js",
    "player/impact_list.js",
    "scene/words.js",
)
"""Further modules that need no browser to be run."""
MODULES = ("solver/motion.js", "base/base64.js", *SCENE)
"""The modules that read a scene file, and compute a motion."""
SCENE_OF = "const sceneOf = ({ file, kit }) => pageScene(kit, completedFile(file, kit), []);"
COMPILED = f"""{SCENE_OF}
const textsOf = {TEXTS};
const modules = new Map();
async function compiled(text) {{
  if (!modules.has(text)) modules.set(text, await WebAssembly.compile(await decompressed(text)));
  return modules.get(text);
}}"""

FIRST_FRAME = """new Promise((resolve) => new PerformanceObserver((marks, observer) => {
  if (marks.getEntriesByName("first-frame").length) { observer.disconnect(); resolve(true); }
}).observe({ type: "mark", buffered: true }))"""
"""Waits for the first motion; a condition that is polled would request frames."""

DEFAULTS = {"viewport": DESK, "reduced_motion": "reduce", "color_scheme": "light"}
"""Usual values of the options that an open page can change."""


@pytest.fixture(scope="package")
def browser():
    """Return a Chromium.

    It ends after the tests of this folder, because other tests cannot start playwright while it runs.
    """
    from playwright.sync_api import sync_playwright  # the quick tier does not need playwright

    with sync_playwright() as playwright:
        # In a container root has no sandbox; the page is our own. Without the next switches, Chromium always
        # reports 10 MB of memory.
        memory_switches = ["--enable-precise-memory-info", "--js-flags=--expose-gc"]
        started = playwright.chromium.launch(
            executable_path=CHROMIUM, args=["--no-sandbox", *memory_switches]
        )
        yield started
        started.close()


@pytest.fixture(scope="session")
def address(tmp_path_factory):
    path = tmp_path_factory.mktemp("explore") / "box.html"
    explore("four_link_box", path)
    return path.as_uri()


@pytest.fixture(scope="package")
def idle(browser):
    """Return a list for pages that tests have left: (options that an open page cannot change, page).

    A test that uses one of these pages need not start a process.
    """
    return []


@pytest.fixture
def open_page(browser, idle):
    """Return a function that opens a page; its clock may be ``stopped``.

    The test fails if a page writes to the console, raises an error or loads another file.
    """
    messages, opened, local = [], [], ["data:", "blob:"]
    listeners = {
        "console": lambda message: messages.append(message.text),
        "pageerror": lambda error: messages.append(str(error)),
        "request": lambda request: messages.append(request.url),
    }

    def empty_page(options, fixed_options):
        place = next(
            (k for k, (options_of_page, _) in enumerate(idle) if options_of_page == fixed_options), None
        )
        if place is None:
            return browser.new_page(**options)
        _, page = idle.pop(place)
        page.set_viewport_size(options["viewport"])
        page.emulate_media(color_scheme=options["color_scheme"], reduced_motion=options["reduced_motion"])
        return page

    def open_page(address, begins=True, stopped=False, **options):
        options = {**DEFAULTS, **options}
        fixed_options = {name: value for name, value in options.items() if name not in DEFAULTS}
        page = browser.new_page(**options) if stopped else empty_page(options, fixed_options)
        opened.append((fixed_options, page, stopped))
        local.append(address.split("#")[0])
        if stopped:
            page.clock.install(time=0)
        if "#" in address and page.url.split("#")[0] == address.split("#")[0]:
            page.goto("about:blank")  # else the browser would keep the page, and change its address only
        for event, listener in listeners.items():
            page.on(event, listener)
        page.goto(address)
        if stopped:
            page.clock.pause_at(60)
        elif begins:
            page.wait_for_function(FIRST_FRAME)
        return page

    yield open_page
    for fixed_options, page, stopped in opened:
        for event, listener in listeners.items():
            page.remove_listener(event, listener)
        if stopped:
            page.close()
        else:
            page.mouse.move(0, 0)
            idle.append((fixed_options, page))
    assert [text for text in messages if not text.startswith(tuple(local))] == []


@pytest.fixture
def show(open_page, address, tmp_path):
    """Return a function that opens the simulating page of four_link_box or of ``model`` with ``changes``."""

    def show(model="", changes=None, hash_="", **options):
        if not model:
            return open_page(address + hash_, **options)
        path = tmp_path / f"{model}.html"
        explore(load_scene(model).with_values(changes or {}), path)
        return open_page(path.as_uri() + hash_, **options)

    return show


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
    toml = f"const TOML = {{}}; (function (exports) {{ {browser_text(TOML)} }})(TOML);"
    page.set_content(f"<script>{program_text(*MODULES)}{COMPILED}{toml}</script>")
    yield page
    page.close()


@pytest.fixture(scope="module")
def kernel(worker):
    """Return a function that runs a scene in a browser.

    It returns time and columns by name, with the bits of real numbers as int64, impacts and the other
    results of the kernel.
    """

    def run(scene, values=None):
        times = {"stop": scene.simulation.stop_time, "step": scene.simulation.step_size}
        module = packed_module(scene.contact.law_file)
        arguments = {"module": module, "values": values or {}, **page_contents(scene), **times}
        result = worker.evaluate(RUN, arguments)
        columns = {}
        for column, text in zip(result.pop("names"), result["columns"], strict=True):
            numbers = bits(text)
            columns[column["name"]] = numbers.view(np.float64).astype(int) if column["integer"] else numbers
        return {**result, "time": bits(result["time"][0]), "columns": columns}

    return run


@pytest.fixture(scope="session")
def result():
    """The motion of the default scene of the pages, as Python simulates it."""
    return simulate("four_link_box")


@pytest.fixture(scope="session")
def recording():
    return record_slowly(load_scene("four_link_box"))


@pytest.fixture(scope="session")
def recorded_address(recording, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "box.html"
    write_animation(recording, path)
    return path.as_uri()


@pytest.fixture
def show_recording(open_page, recorded_address, tmp_path):
    """Return a function that opens the page of four_link_box, of another recording, or an ``address``."""

    def show(recording=None, address=recorded_address, **options):
        if recording is not None:
            write_animation(recording, tmp_path / "page.html")
            address = (tmp_path / "page.html").as_uri()
        return open_page(address, **options)

    return show
