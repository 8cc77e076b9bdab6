"""A Chromium for the tests of the animation's page."""

import pytest

from tests.tiers import CHROMIUM


@pytest.fixture(scope="module")
def browser():
    from playwright.sync_api import sync_playwright  # the quick tier does without it

    with sync_playwright() as playwright:
        # In a container there is no sandbox for root, and the page is our own. Without the other switches,
        # Chromium tells a script of its memory that it is 10 MB, whatever it is.
        told = ["--enable-precise-memory-info", "--js-flags=--expose-gc"]
        started = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox", *told])
        yield started
        started.close()
