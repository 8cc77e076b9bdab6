"""Draw the pages in Chromium, ``animation.png`` and ``explore.png``: ``python -m docs.tools.screenshot``."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

from playwright.sync_api import ViewportSize, sync_playwright

from chain_impact import explore, load_scene
from chain_impact.results.animation import write_animation
from chain_impact.studies.animate import record_slowly
from docs.tools import DOCS

IMAGES = DOCS / "images"
SIZE: ViewportSize = {"width": 1280, "height": 760}
# [pixels] for the page of `explore`, which has the parameters beside the picture of the scene
WIDE_VIEWPORT: ViewportSize = {"width": 1366, "height": 760}
KEYS = ["Shift+ArrowRight"] * 5  # these keys move a page to the largest force of the fifth impact
CHANGES = "#contact.restitution=0.5"


def main() -> None:
    """Open the pages of the default scene, go to an impact, and save screenshots."""
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        animation, exploring = Path(folder, "animation.html"), Path(folder, "explore.html")
        write_animation(record_slowly(load_scene("four_link_box")), animation)
        explore("four_link_box", exploring)
        chromium = shutil.which("chromium") or shutil.which("chromium-headless-shell")
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        for address, size, name in (
            (animation.as_uri(), SIZE, "animation"),
            (exploring.as_uri() + CHANGES, WIDE_VIEWPORT, "explore"),
        ):
            page = browser.new_page(viewport=size, reduced_motion="reduce")
            page.goto(address)
            page.wait_for_function("performance.getEntriesByName('first-frame').length === 1")
            for key in KEYS:
                page.keyboard.press(key)
            page.wait_for_timeout(300)
            page.screenshot(path=IMAGES / f"{name}.png")
        browser.close()


if __name__ == "__main__":
    main()
