"""Pages that simulate for the site: one for each model, a page with all of them, and links from the models.

``build_site.py`` calls this module; the pages are not committed, because they contain the compiled kernel.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from html import escape
from pathlib import Path

from chain_impact import explore, load_scene, model_names
from chain_impact.scene.files.models import models_folder
from docs.tools import DOCS

PAGE = DOCS / "try_it.md"
GALLERY = DOCS / "models" / "index.md"
FOLDER = "try"  # folder of the simulating pages in the site
FIRST_MODEL = "four_link_box"
_SOURCE = f"{FOLDER}/{FIRST_MODEL}.html"
FRAME = f'<iframe class="try" name="try" src="{_SOURCE}" title="A page that simulates"></iframe>'
HEAD = f"""---
hide: [toc]
---

# Try it

The browser simulates this scene with the compiled solver, as Python does. Move a slider,
drag the chain at its start, or choose another scene below.
[What the page can do](pictures.md#a-page-that-simulates). Your own scene:
`chain-impact explore my_scene.toml`.

{FRAME}

"""
LINK = '<p class="try-link"><a href="../{folder}/{model}.html">Open it in the browser, and change it</a></p>'
SCENE = "<details><summary>Its scene file</summary><pre><code>{}</code></pre></details>"


def write_page() -> None:
    """Write the page that lists all models, in the groups of the gallery, before the site is built."""
    groups = [
        f"## {title}\n\n" + '<ul class="try-list">\n' + "\n".join(map(row, names)) + "\n</ul>\n"
        for title, names in gallery()
    ]
    PAGE.write_text(HEAD + "\n".join(groups), encoding="utf-8")


def gallery() -> Iterator[tuple[str, list[str]]]:
    """Yield each heading of the gallery, the page of all models, with the names of the models below it."""
    for section in GALLERY.read_text(encoding="utf-8").split("\n## ")[1:]:
        title, _, rest = section.partition("\n")
        if names := re.findall(r"\[`(\w+)`\]\(", rest):
            yield title, names


def row(model: str) -> str:
    """Return the list entry of a model."""
    show = f'<a href="{FOLDER}/{model}.html" target="try">{model}</a>'
    link = f'<a href="models/{model}.html">more</a>'
    return f"<li>{show} <span>{escape(load_scene(model).description)}; {link}</span></li>"


def lead_to_simulations(gallery: str) -> str:
    """Return the gallery, with links from its pictures to the simulating pages.

    Raises:
        RuntimeError: when a picture has no link.
    """
    led, count = re.subn(r'<a href="(\w+\.html)">(?=<img )', rf'<a href="../{FOLDER}/\1">', gallery)
    if count != len(model_names()):
        raise RuntimeError(f"{count} pictures of {len(model_names())} models have a link")
    return led


def begin_with_page(start: str) -> str:
    """Return the start page with a simulation in place of its film; without it, raise a RuntimeError."""
    begun, count = re.subn(r'<p><img [^>]*four_link_box\.gif"[^>]*></p>', FRAME, start)
    if count != 1:
        raise RuntimeError(f"the start page has {count} films of four links")
    return begun


def scene_file(model: str) -> str:
    """Return the folded text of a model's scene file, for the page of the model."""
    return SCENE.format(escape((models_folder() / model / "scene.toml").read_text(encoding="utf-8")))


def finish(site: Path) -> None:
    """Write the simulating pages into the built site, and change its pages.

    A simulation replaces the film of the start page, the pictures of the gallery get links to the simulating
    pages, and each model's page gets such a link and its scene file.

    Raises:
        RuntimeError: when a page of the site has no place for one of these.
    """
    start = site / "index.html"
    start.write_text(begin_with_page(start.read_text(encoding="utf-8")), encoding="utf-8")
    gallery = site / "models" / "index.html"
    gallery.write_text(lead_to_simulations(gallery.read_text(encoding="utf-8")), encoding="utf-8")
    (site / FOLDER).mkdir(exist_ok=True)
    for model in model_names():
        explore(model, site / FOLDER / f"{model}.html")
        page = site / "models" / f"{model}.html"
        link = LINK.format(folder=FOLDER, model=model) + scene_file(model)
        head, end, text = page.read_text(encoding="utf-8").partition("</h1>")
        if not end:
            raise RuntimeError(f"{page} has no headline")
        page.write_text(f"{head}{end}\n{link}{text}", encoding="utf-8")
