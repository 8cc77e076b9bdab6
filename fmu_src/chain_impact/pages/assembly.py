"""A page with a player as one file: its template is filled with style sheets, libraries and modules."""

from __future__ import annotations

import html
import json
import posixpath
import re
from collections.abc import Iterable
from importlib import resources
from typing import Any

from chain_impact.pages.shared import declaration

PAGE = resources.files("chain_impact.pages") / "browser"
STYLES = ("vendor/uPlot.min.css", "player/style.css", "player/panels.css")
LIBRARIES = ("vendor/uPlot.iife.min.js", "vendor/svg.min.js")
FRAGMENTS = ("stage", "panels", "playback")
IMPORT = re.compile(r'^import [^;]+ from "([^"]+)";\n', re.MULTILINE)
EXPORT = re.compile(r"^export (?=async|class|const|function)", re.MULTILINE)
# pattern of what a script does not need: comments, // or /** … */, that take whole lines, empty lines, spaces
# at the start of a line, comments at the end of a line after one of ;,{}()[], and spaces beside signs and
# braces that no text for readers has; no module may have a template literal of several lines, or such a
# comment in a string
SIGNS = "(?:=>|[=!]==|&&|[|]{2})"
STRIPPED_FROM_SCRIPTS = re.compile(
    rf"^(?:\s+|//.*\n|/\*\*[\s\S]*?\*/\n)+|(?<=[;,{{}}()\[\]]) +// .*$| (?={SIGNS} )"
    r"|(?<= [=!]==) |(?<= (?:=>|&&)) |(?<= [|]{2}) |(?<=\{) | (?=\})|(?<=\)) (?=\{)",
    re.MULTILINE,
)
# pattern of a style sheet: its group matches what must stay, strings and comments of licences; all else that
# matches can be left out, other comments and spaces beside signs
STRIPPED_FROM_STYLES = re.compile(
    r'("[^"\n]*"|/\*!.*?\*/)|/\*.*?\*/\s*|(?<=[:;,{}])\s+|\s+(?=[{}])', re.DOTALL
)
SOURCE_MAP = re.compile(r"^//# sourceMappingURL=.*$", re.MULTILINE)


def assemble_page(template: str, title: str, styles: Iterable[str], modules: str, **parts: str) -> str:
    """Return the HTML of a page with a player, from a template and its parts.

    Args:
        template: HTML in which ``{{ name }}`` stands for a part.
        title: the title of the page.
        styles: the texts of the style sheets.
        modules: the program of the page, from ``program_text``.
        parts: name → text for the other parts of the template.
    """
    scripts_text = "\n".join(
        f"<script>\n{SOURCE_MAP.sub('', browser_text(name))}</script>" for name in LIBRARIES
    )
    parts |= {
        "title": html.escape(title, quote=False),
        "style": STRIPPED_FROM_STYLES.sub(r"\1", "\n".join(styles)),
    }
    parts |= {"libraries": scripts_text, "program": modules}
    parts |= {name: browser_text(f"player/{name}.html") for name in FRAGMENTS}
    # all parts are filled in at once, because a part may itself contain ``{{ name }}``, which is not to be
    # replaced
    return re.sub(r"\{\{ (\w+) \}\}", lambda match: parts[match[1]], template)


def style_texts() -> list[str]:
    """Return the texts of the style sheets of a page with a player."""
    return [browser_text(name) for name in STYLES]


def program_text(*names: str) -> str:
    """Return the script of some modules, after the constants that all pages share.

    ``names``: the files of the modules in pages/browser; the modules that these import are added.
    """
    return f"{declaration()}\n{joined_script(*names)}"


def joined_script(*names: str) -> str:
    """Return modules and all modules that they import, joined to one script.

    The script has no imports, and nothing that matches STRIPPED_FROM_SCRIPTS. No two of the modules may
    declare the same name at their top level.
    """
    texts = (EXPORT.sub("", IMPORT.sub("", browser_text(name))) for name in module_files(*names))
    return STRIPPED_FROM_SCRIPTS.sub("", "\n".join(texts))


def module_files(*names: str) -> list[str]:
    """Return the files ``names`` and all files that these import, imported ones first, from pages/browser.

    No file may import itself, not even through other files.
    """
    found_files: list[str] = []

    def add(name: str) -> None:
        if name in found_files:
            return
        for path in IMPORT.findall(browser_text(name)):
            add(posixpath.normpath(posixpath.join(posixpath.dirname(name), path)))
        found_files.append(name)

    for name in names:
        add(name)
    return found_files


def script_data(content: Any) -> str:
    """Return data as JSON for a script element of a page, which no "<" in the data can end."""
    return json.dumps(content, separators=(",", ":")).replace("<", "\\u003c")


def browser_text(name: str) -> str:
    """Return the text of the file ``name`` in pages/browser."""
    return PAGE.joinpath(name).read_text(encoding="utf-8")
