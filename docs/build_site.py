"""Build the site in ``site/``: ``python docs/build_site.py``. With ``--serve`` show it while you write.

Zensical reads ``mkdocs.yml``. It knows no notebooks, so they are run and made pages before.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

DOCS = Path(__file__).parent
SITE = DOCS.parent / "site"
NOTEBOOKS = sorted((DOCS / "notebooks").glob("*.ipynb"))


def make_pages(notebooks: list[Path], folder: Path) -> None:
    """Run notebooks and write each as a page with its pictures; raises CalledProcessError if a cell fails."""
    convert = [sys.executable, "-W", "ignore", "-m", "nbconvert", "--log-level", "ERROR"]
    convert += ["--execute", "--to", "markdown", "--output-dir", str(folder)]
    subprocess.run([*convert, *map(str, notebooks)], check=True)


def main() -> int:
    """Make the pages of the notebooks, then the site; return the exit code of Zensical."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--serve", action="store_true", help="serve the site and follow changes")
    command = ["serve"] if parser.parse_args().serve else ["build", "--clean", "--strict"]
    make_pages(NOTEBOOKS, DOCS / "notebooks")
    code = subprocess.run(
        [sys.executable, "-m", "zensical", *command], cwd=DOCS.parent, check=False
    ).returncode
    for script in SITE.glob("*.py"):  # Zensical copies every file of docs/
        script.unlink()
    for page in SITE.rglob("*.html"):  # in the repository a link leads to the notebook, here to its page
        text = page.read_text(encoding="utf-8")
        page.write_text(text.replace('.ipynb"', '.html"'), encoding="utf-8")
    return code


if __name__ == "__main__":
    sys.exit(main())
