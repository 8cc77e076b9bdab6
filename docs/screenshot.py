"""Draw ``images/animation.png``, the page of an animation in Chromium: ``python docs/screenshot.py``."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

from playwright.sync_api import sync_playwright

from chain_impact import load_scene
from chain_impact.results.animation import animate
from chain_impact.studies.slow_motion import record_slowly

PICTURE = Path(__file__).parent / "images" / "animation.png"
SIZE = {"width": 1280, "height": 760}
KEYS = ["Shift+ArrowRight"] * 5 + ["ArrowRight"] * 9  # to the middle of the fifth impact


def main() -> None:
    """Open the animation of the default scene, go to an impact, and keep what is to be seen."""
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        page_file = Path(folder, "animation.html")
        animate(record_slowly(load_scene("four_link_box")), page_file)
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = browser.new_page(viewport=SIZE, reduced_motion="reduce")
        page.goto(page_file.as_uri())
        for key in KEYS:
            page.keyboard.press(key)
        page.wait_for_timeout(300)
        page.screenshot(path=PICTURE)
        browser.close()


if __name__ == "__main__":
    main()
