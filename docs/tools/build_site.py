"""Build the site in ``site/``: ``python -m docs.tools.build_site``. ``--serve`` shows it while you write.

Zensical reads ``mkdocs.yml``. Zensical cannot read notebooks, so this script first runs the notebooks and
converts them into pages. ``try_it.py`` writes the pages that simulate.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

from docs.tools import DOCS, try_it

SITE = DOCS.parent / "site"
SHIM = "https://unpkg.com/iframe-worker/shim"
GITHUB = "https://github.com/"
GLOSSARY, WORDS = DOCS / "glossary.md", DOCS / "words.txt"
# words of the glossary that many pages have; the site does not explain them, because this would disturb
COMMON = {"base", "chain", "contact", "end", "event", "FMU", "impact", "input", "kernel", "link", "model"}
COMMON |= {"parameter", "point", "scene", "stop", "tip", "tolerance"}
NOTEBOOKS = sorted((DOCS / "notebooks").glob("*.ipynb"))


def make_pages(notebooks: list[Path], folder: Path) -> None:
    """Run notebooks, and write each as a page with its pictures; raise a RuntimeError if a cell fails."""
    convert = [sys.executable, "-W", "ignore", "-m", "nbconvert", "--log-level", "ERROR"]
    convert += ["--execute", "--to", "markdown", "--output-dir", str(folder)]
    process = subprocess.run([*convert, *map(str, notebooks)], check=False, capture_output=True, text=True)
    # without an error, stderr has only warnings about the connection to the process that runs the notebook
    if process.returncode != 0:
        raise RuntimeError(f"a notebook does not run:\n{process.stderr}")


def write_words() -> None:
    """Write the meanings of the glossary's words, except COMMON, for the extension that explains words."""
    explained = re.findall(r"^- \*\*(.+?)\*\*: (.+)$", GLOSSARY.read_text(encoding="utf-8"), re.M)
    lines = []
    for words, meaning in explained:
        # a link in a meaning leads to further reading, and is left out
        text = re.sub(r"(: )?\[([^]]+)\]\([^)]*\)", "", meaning)
        text = re.sub(r"[*`]|\\\(.*?\\\)", "", text).strip(" :;")
        lines += [f"*[{word}]: {text}" for word in words.split(", ") if word not in COMMON]
    WORDS.write_text("\n".join(lines) + "\n", encoding="utf-8")


def repository() -> str:
    """Return the name of the repository on GitHub, owner/name; empty if the repository has no address."""
    project = tomllib.loads((DOCS.parent / "pyproject.toml").read_text(encoding="utf-8"))
    return str(project["project"]["urls"].get("Source", "")).removeprefix(GITHUB)


def add_links(folder: Path, address: str) -> None:
    """Add links from notebook pages to a service that runs notebooks, if the repository has an address."""
    for notebook in NOTEBOOKS if address else ():
        page = folder / f"{notebook.stem}.md"
        link = f"https://colab.research.google.com/github/{address}/blob/main/docs/notebooks/{notebook.name}"
        title, rest = page.read_text(encoding="utf-8").split("\n", 1)
        install = f"%pip install 'chain-impact @ git+{GITHUB}{address}'"
        invitation = f"[Open this notebook in Colab]({link}), and run there first: `{install}`"
        page.write_text(f"{title}\n\n{invitation}\n{rest}", encoding="utf-8")


def finish() -> None:
    """Make the pages that Zensical has written independent of the network and of the repository.

    The process ends if a page would still load a script or a style from the network.
    """
    shutil.rmtree(SITE / "tools")  # Zensical copies every file of docs/
    (SITE / WORDS.name).unlink()
    for page in SITE.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        # in the repository, links lead to the file of a notebook; in the site, they must lead to its page
        text = text.replace('.ipynb"', '.html"')
        # without a server the search needs this script, in docs/javascripts
        top = "../" * (len(page.relative_to(SITE).parts) - 1)
        text = text.replace(SHIM, f"{top}javascripts/iframe-worker/shim.js")
        if remote := re.search(r'<(?:script|link)\b[^>]+(?:src|href)="(https?://[^"]*)', text):
            sys.exit(f"{page.relative_to(SITE)} would load {remote[1]} from the network")
        page.write_text(text, encoding="utf-8")


def main() -> int:
    """Make the pages of the notebooks, then the site; return the exit code of Zensical."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--serve", action="store_true", help="serve the site, and update it after changes")
    command = ["serve"] if parser.parse_args().serve else ["build", "--clean", "--strict"]
    make_pages(NOTEBOOKS, DOCS / "notebooks")
    add_links(DOCS / "notebooks", repository())
    try_it.write_page()
    write_words()
    zensical = [sys.executable, "-m", "zensical", *command]
    code = subprocess.run(zensical, cwd=DOCS.parent, check=False).returncode
    if code == 0:
        finish()
    if code == 0 and command[0] == "build":
        try_it.finish(SITE)
        print(f"{SITE.relative_to(DOCS.parent)}/index.html")
    return code


if __name__ == "__main__":
    sys.exit(main())
