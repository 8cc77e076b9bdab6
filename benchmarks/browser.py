"""The kernel in a browser: ``python benchmarks/browser.py``; needs playwright and Debian's chromium.

The size of the page that simulates, the time to its first picture, the time from a slider to the picture that
it gives, and the time of a run beside the native kernel's, in turn. Both run from the start to the end with a
row of all outputs at each communication point; then the browser also copies them into columns. A map of the
page is compared with the same sweep. Times are those on the clock, as a browser has several processes: the
least of a round's runs is taken, the median over the rounds.
"""

from __future__ import annotations

import common  # isort: skip

import shutil
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from playwright.sync_api import Browser, Page, sync_playwright

from chain_impact import explore, load_scene, sweep
from chain_impact.compilation.library import browser_module
from chain_impact.results.page.description import description, packed
from chain_impact.results.page.explore import WORKER, program
from chain_impact.scene.scene import Scene
from chain_impact.simulation.instance import Instance
from chain_impact.system import cores

MODELS = ("four_link_box", "rod_drop", "pinned_arm", "steel_bar")
ROUNDS = 9
RUNS = 20  # in a round
PREPARE = """async ([module, scene]) => {
  window.kernel = await Kernel.load(await WebAssembly.compile(await unpacked(module)), scene);
  window.places = { kernel: [], columns: scene.columns };
}"""
RUN = """([times, runs, what]) => {
  const wanted = Float64Array.from(times);
  let least = Infinity;
  for (let k = 0; k < runs; k += 1) {
    const began = performance.now();
    runThrough(kernel.run({}, wanted, places[what]));
    least = Math.min(least, performance.now() - began);
  }
  return least;
}"""

# From the event of a slider, which a browser gives at the beginning of a frame, to the change of the picture,
# which it then paints. The slider goes to and fro around the value of the scene.
SLIDE = """async (changes) => {
  const changed = (id) => new Promise((done) => {
    const observer = new MutationObserver(() => {
      observer.disconnect();
      done(performance.now());
    });
    observer.observe(document.getElementById(id), { childList: true, subtree: true, attributes: true });
  });
  const slider = document.querySelector("input[type=range][aria-label^='Restitution']");
  const found = [];
  const own = Number(slider.value);
  for (let k = 1; k <= changes; k += 1) {
    await new Promise((go) => setTimeout(go, 100 + (k % 16)));
    await new Promise((go) => requestAnimationFrame(go));
    slider.value = String(own + (k % 2 ? 1 : -1) * (1 + (k % 10)));
    const [said, drawn, began] = [changed("subtitle"), changed("scene"), performance.now()];
    slider.dispatchEvent(new Event("input", { bubbles: true }));
    await said;
    found.push((await drawn) - began);
  }
  return found;
}"""
SLIDES = 60
MAP = "four_link_box"
POINTS = 41  # of a map, in each direction
MAP_ROUNDS = 5
WORKERS = 8  # that a page takes at most


def native(scene: Scene, times: np.ndarray) -> Callable[[], float]:
    """The least time of some runs of the native kernel [ms]."""
    instance = Instance(scene)
    rows = np.zeros(len(times), instance.record.dtype["output"])

    def once() -> float:
        began, done = time.perf_counter(), 0
        instance.initialize()
        while done < len(times):
            done += instance.trajectory(times[done:], rows[done:])
            instance.collect()
        return 1e3 * (time.perf_counter() - began)

    return lambda: min(once() for _ in range(RUNS))


def compared(page: Page, scene: Scene, rounds: int) -> dict[str, Any]:
    """The times of a run, and their ratio."""
    stop, step = scene.simulation.stop_time, scene.simulation.step_size
    times = np.arange(round(stop / step) + 1) * step
    page.evaluate(PREPARE, [packed(browser_module().read_bytes()), description(scene, [])])
    here, given = native(scene, times), [times.tolist(), RUNS]
    calls = {
        "native": here,
        "browser": lambda: page.evaluate(RUN, [*given, "kernel"]),
        "browser_columns": lambda: page.evaluate(RUN, [*given, "columns"]),
    }
    for call in calls.values():
        call()
    found = [{name: call() for name, call in calls.items()} for _ in range(rounds)]
    return {
        "rows": len(times),
        **{f"{name}_ms": common.median([one[name] for one in found]) for name in calls},
        "ratio": common.spread([one["browser"] / one["native"] for one in found]),
        "ratio_with_columns": common.spread([one["browser_columns"] / one["native"] for one in found]),
    }


def first_picture(browser: Browser, address: str) -> float:
    """The time from the opening of the page to its first picture [ms]."""
    page = browser.new_page()
    page.goto(address)
    page.wait_for_function("performance.getEntriesByName('first-frame').length === 1")
    found = float(page.evaluate("performance.getEntriesByName('first-frame')[0].startTime"))
    page.close()
    return found


def from_slider_to_picture(browser: Browser, address: str) -> dict[str, float]:
    """The time in which a page answers to a slider [ms]."""
    page = opened(browser, address)
    page.evaluate(SLIDE, SLIDES // 3)
    found = sorted(page.evaluate(SLIDE, SLIDES))
    page.close()
    named = {"median": found, "least": found[:1], "of 9 in 10": [found[int(0.9 * SLIDES)]]}
    return {name: common.median(times) for name, times in named.items()}


def opened(browser: Browser, address: str) -> Page:
    """A page that has its first picture, which stands still."""
    page = browser.new_page(viewport={"width": 1366, "height": 768}, reduced_motion="reduce")
    page.goto(address)
    page.wait_for_function("performance.getEntriesByName('first-frame').length === 1")
    return page


def maps(browser: Browser, address: str, rounds: int) -> dict[str, Any]:
    """The time of a map, and of the same runs by ``sweep``, in turn [s]."""
    page = opened(browser, address)
    page.click("#map-open")
    ends = {name: [float(page.input_value(f"#map-{axis}-{end}")) for end in ("from", "to")]
            for axis in "xy" for name in [page.input_value(f"#map-{axis}-name")]}  # fmt: skip
    varied = {name: np.linspace(*two, POINTS) for name, two in ends.items()}
    found: dict[str, list[float]] = {"browser": [], "sweep": []}
    for _ in range(rounds):
        began = time.perf_counter()
        page.click("#map-run")
        page.wait_for_function("document.getElementById('map-text').textContent.includes(' runs in ')")
        found["browser"].append(time.perf_counter() - began)
        began = time.perf_counter()
        sweep(MAP, varied, outputs=["impact.count"], threads=min(cores(), WORKERS))
        found["sweep"].append(time.perf_counter() - began)
    page.close()
    ratios = [one / other for one, other in zip(*found.values(), strict=True)]
    return {
        "varied": ends,
        "runs": POINTS**2,
        **{f"{name}_s": common.median(times) for name, times in found.items()},
        "ratio": common.spread(ratios),
    }


def main() -> None:
    """Measure, print and save."""
    started, rounds = common.environment(("playwright",)), common.rounds(__doc__, ROUNDS)
    results: dict[str, Any] = {"module_bytes": browser_module().stat().st_size, "models": {}}
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        results["browser"] = browser.version
        page = browser.new_page()
        page.set_content(f"<script>{program(WORKER[:-1])}</script>")
        for model in MODELS:
            file = Path(folder, f"{model}.html")
            explore(model, file)
            pictures = [first_picture(browser, file.as_uri()) for _ in range(rounds)]
            found = compared(page, load_scene(model), rounds)
            found |= {"page_bytes": file.stat().st_size, "first_picture_ms": common.median(pictures)}
            found["slider_ms"] = from_slider_to_picture(browser, file.as_uri())
            results["models"][model] = found
            print(f"{model:16}", found)
        results["map"] = maps(browser, Path(folder, f"{MAP}.html").as_uri(), MAP_ROUNDS)
        print("map", results["map"])
        browser.close()
    common.save("browser", started, {"rounds": rounds, "runs": RUNS}, results)


if __name__ == "__main__":
    main()
