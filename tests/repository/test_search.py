"""What a reader types into the search of the site leads to the page that explains it."""

import shutil
import subprocess
import sys
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread
from urllib.parse import urlsplit

import pytest

from tests.tiers import CHROMIUM, needs_browser

pytestmark = needs_browser

ROOT = Path(__file__).parents[2]
API = "python_api.md"  # has a heading for each name of Python, such as Ranking and Signal


class Quiet(SimpleHTTPRequestHandler):
    """A server of files that prints nothing."""

    def log_message(self, *_):
        """Print nothing."""


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Build the site, without the pages of notebooks, and return the address at which it is served."""
    folder = tmp_path_factory.mktemp("site")
    shutil.copytree(ROOT / "docs", folder / "docs")
    (folder / "docs" / "words.txt").touch()
    (folder / "fmu_src").symlink_to(ROOT / "fmu_src")
    settings = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    # the pages of notebooks, to which other pages link, are missing
    (folder / "mkdocs.yml").write_text(settings.replace("strict: true", "strict: false"), encoding="utf-8")
    command = [sys.executable, "-m", "zensical", "build", "--clean"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=folder / "site")) as server:
        thread = Thread(target=server.serve_forever)
        thread.start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()
        thread.join()


@pytest.fixture(scope="module")
def pages_of(site):
    """Return a function from a query to the pages that the site's search lists, the best first."""
    from playwright.sync_api import sync_playwright  # the quick tier does not need playwright

    def pages_of(query):
        page.get_by_role("combobox").fill("")
        results = page.locator("ol a")
        results.first.wait_for(state="detached")  # those of the query before
        page.get_by_role("combobox").fill(query)
        results.first.wait_for()
        addresses = results.evaluate_all("links => links.map((link) => link.href)")
        return [
            *dict.fromkeys(urlsplit(address).path.strip("/").replace(".html", ".md") for address in addresses)
        ]

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        page = browser.new_page()
        page.goto(f"{site}index.html")
        page.keyboard.press("/")
        yield pages_of
        browser.close()


@pytest.mark.parametrize(
    ("query", "page"),
    [
        ("peak force", "mount.md"),
        ("joint load", "mount.md"),
        ("material", "material.md"),
        ("ranking", "sensitivities.md"),
        ("motor", "motor.md"),
        ("bearing", "mount.md"),
        ("steel ball", "material.md"),
        ("signal", "drive.md"),
        ("cart", "models/cart_pole.md"),
        ("brick", "models/thrown_brick.md"),
        ("foot", "models/hopper.md"),
    ],
)
def test_a_search_leads_to_its_page(pages_of, query, page):
    assert next(page_found for page_found in pages_of(query) if page_found != API) == page
