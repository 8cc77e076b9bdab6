"""Build the site in ``site/``: ``python docs/build_site.py``. With ``--serve`` show it while you write.

Zensical reads ``mkdocs.yml``. It knows no notebooks, so they are run and made pages before.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

DOCS = Path(__file__).parent
NOTEBOOKS = sorted((DOCS / "notebooks").glob("*.ipynb"))


def make_pages(notebooks: list[Path], folder: Path) -> None:
    """Run notebooks and write each as a page with its pictures; raises CalledProcessError if a cell fails."""
    convert = [sys.executable, "-W", "ignore", "-m", "nbconvert", "--log-level", "ERROR"]
    convert += ["--execute", "--to", "markdown", "--output-dir", str(folder)]
    subprocess.run([*convert, *map(str, notebooks)], check=True)
    for notebook in notebooks:
        page = folder / f"{notebook.stem}.md"
        text = page.read_text(encoding="utf-8").replace(".ipynb)", ".md)")  # links between notebooks
        page.write_text(text, encoding="utf-8")


def main() -> int:
    """Make the pages of the notebooks, then the site; return the exit code of Zensical."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--serve", action="store_true", help="serve the site and follow changes")
    command = ["serve"] if parser.parse_args().serve else ["build", "--clean", "--strict"]
    make_pages(NOTEBOOKS, DOCS / "notebooks")
    code = subprocess.run(
        [sys.executable, "-m", "zensical", *command], cwd=DOCS.parent, check=False
    ).returncode
    for script in (DOCS.parent / "site").glob("*.py"):  # Zensical copies every file of docs/
        script.unlink()
    return code


if __name__ == "__main__":
    sys.exit(main())
