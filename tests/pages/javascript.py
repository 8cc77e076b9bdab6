"""The JavaScript of the pages without a browser: QuickJS runs the modules that need no page."""

import base64
import json
import re
from functools import cache
from pathlib import Path

import quickjs

from chain_impact.pages.assembly import browser_text, program_text
from chain_impact.pages.explore import TOML

BROWSER = f"""
const structuredClone = (value) => JSON.parse(JSON.stringify(value));
const TOML = {{}};
(function (exports) {{ {browser_text(TOML)} }})(TOML);
"""
"""The parts of a page that the modules need: a function of browsers, and the reader of scene files."""

FUNCTIONS = Path(__file__).with_name("functions")
"""The folder of the functions that tests run in pages; oxlint checks these files, too."""


@cache
def function_of(file, name):
    """Return the text of a function of a file in FUNCTIONS; a page has what the file imports."""
    text = (FUNCTIONS / f"{file}.js").read_text("utf-8")
    (function,) = re.findall(rf"^export const {name} = (.*?);\n(?=\n|\Z)", text, re.MULTILINE | re.DOTALL)
    return function


class Script:
    """Modules of the pages, and all modules that they import, as one program."""

    def __init__(self, *names):
        self.context = quickjs.Context()
        self.context.add_callable("atob", lambda text: base64.b64decode(text).decode("latin-1"))
        self.context.eval(BROWSER + program_text(*names))

    def evaluate(self, function, argument=None):
        """Return the value of a function, as a page of a browser does; values go over as JSON.

        Raises:
            quickjs.JSException: when the function throws an error.
        """
        call = self.context.eval(f"(text) => JSON.stringify(({function})(JSON.parse(text)))")
        return json.loads(call(json.dumps(argument)) or "null")
