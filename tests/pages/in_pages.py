"""Actions of tests in pages, and data of pages."""

import base64
import io
import json
import re
from functools import cache
from pathlib import Path

import matplotlib as mpl
import numpy as np
from PIL import Image

from chain_impact import load_scene, simulate
from chain_impact.compilation.library import browser_module
from chain_impact.pages.explore import compressed_text, explore_contents
from tests.pages.javascript import function_of

DESK, PHONE, ON_ITS_SIDE = (
    {"width": width, "height": height} for width, height in ((1366, 768), (390, 844), (844, 390))
)
ROWS = function_of("in_pages", "rowsInPage")
"""The rows of the pixels of a chart with a colour of the style sheet."""
PIXELS = f"async (asked) => (await ({ROWS})(asked)).length"
"""Number of pixels of a chart with a colour of the style sheet."""
TEXTS = function_of("in_pages", "textsOf")
"""The numbers of typed arrays as texts, which ``bits`` reads: single numbers would take far longer."""
ON_OTHERS = function_of("drawing", "onOthers")
"""Pairs of an overlapping text and object. The boxes of texts include space above the letters."""
CHART_NAMES = "[...document.querySelectorAll('#outputs-over-time dt.of-curve')].map((term) => term.title)"
"""The names of the outputs that have a chart."""
ADVANCE_CLOCK = "performance.now = ((now) => () => now() + 900)(performance.now.bind(performance))"
"""A script after which the page believes that 900 ms more have passed."""
SUBTITLE = "document.getElementById('subtitle').textContent"
TIME_TEXT = "document.getElementById('time').textContent"
LOCAL_LINK = "The link works on this computer only: to send it, save this page."
MAP = {"simulation.stop_time": 0.45}
"""Changes of the dropped rod whose map has few impacts in each run."""
ANGLE_AXIS = "Initial angle of link 1, °"
"""The title of the second axis of this map."""
LIGHT_CHAIN, DARK_CHAIN = "#2b4a9f", "#9db4ff"


def until(page, condition):
    """Wait for a condition that the page evaluates."""
    page.wait_for_function(condition)


def until_text(page, text, element="subtitle"):
    """Wait for a text in an element of the page; a number at its beginning must be a whole number there."""
    shown_text = f"document.getElementById({element!r}).textContent"
    until(page, f"new RegExp('(?<![0-9.])' + RegExp.escape({json.dumps(text)})).test({shown_text})")


def page_contents(scene):
    """Return a page's data of a scene: the contents of its file, and the data for all scenes."""
    return json.loads(json.dumps(explore_contents(scene, [])))


def without_advice(refusal):
    """Return a refusal without the advice at its end, and with one text for 1, 1.0 and 1e0.

    Python gives advice in cases in which a page gives none.
    """
    return re.sub(r"\d+(\.\d*)?(e[-+]?\d+)?", lambda at: f"{float(at[0]):g}", refusal.partition("; ")[0])


@cache
def packed_module(law_file=""):
    """Return the module for a browser, as the page holds the module."""
    return compressed_text(browser_module(law_file=law_file).read_bytes())


def bits(text):
    """Return the bits of the numbers of a typed array, as whole numbers."""
    return np.frombuffer(base64.b64decode(text), np.int64)


def impacts_of(changes, model="four_link_box"):
    return f"{len(simulate(load_scene(model).with_values(changes)).impacts)} impact"


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


def draw_map(page):
    """Request a map in its dialog, and wait for the map."""
    page.get_by_role("button", name="Simulate 41 × 41 runs").click()
    page.locator("#map-text").get_by_text("1681 runs in").wait_for()


def until_drawn(page):
    """Wait until the page has drawn what has changed."""
    page.evaluate(
        "() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)))"
    )


def resize(page, width, height):
    """Change the size of the window, and wait until the page is drawn in it."""
    page.set_viewport_size({"width": width, "height": height})
    until_drawn(page)


def time_of(page):
    until_drawn(page)
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


def alike(impacts, impact):
    """Return the numbers of the impacts of one point and wall."""
    return [
        k for k in range(len(impacts)) if all(impacts[key][k] == impact[key] for key in ("point", "wall"))
    ]


def partners(present, other_impacts):
    """Return for each impact the number of its partner (None: none), near in time and order at one wall."""

    def nearest(impact, impacts):
        return min(
            alike(impacts, impact), key=lambda k: abs(impacts["onset"][k] - impact["onset"]), default=None
        )

    def is_pair(n, k):
        if k is None or nearest(other_impacts[k], present) != n:
            return False
        order = alike(present, present[n]).index(n) - alike(other_impacts, other_impacts[k]).index(k)
        onsets = sorted((present["onset"][n], other_impacts["onset"][k]))
        return abs(order) <= 1 and onsets[1] <= 1.1 * onsets[0]

    nearest_numbers = [nearest(impact, other_impacts) for impact in present]
    return [k if is_pair(n, k) else None for n, k in enumerate(nearest_numbers)]
