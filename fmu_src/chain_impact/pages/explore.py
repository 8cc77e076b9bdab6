"""The page that simulates a scene in the browser: one file that contains the compiled kernel."""

from __future__ import annotations

import json
import os
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from chain_impact.compilation.library import browser_module
from chain_impact.files import written_atomically
from chain_impact.pages.assembly import (
    STRIPPED_FROM_SCRIPTS,
    assemble_page,
    browser_text,
    joined_script,
    program_text,
    style_texts,
)
from chain_impact.pages.encoding import base64_text
from chain_impact.pages.inline import InlinePage
from chain_impact.pages.scene_tables import page_kit
from chain_impact.scene.files.models import model_names
from chain_impact.scene.scene import Scene, SceneSource, load_scene, scene_of, scene_to_dict

BEGIN = "explore/begin.js"  # the script that runs before the scripts of the libraries
PROGRAM = "explore/explore.js"  # the program of the page
WORKER = "solver/worker.js"  # the program of each worker that simulates
TOML = "vendor/smol-toml.cjs"
"""The library with which the page reads scene files."""
UNNAMED_FILE = "scene.toml"
"""The name, in the command that the page shows, of a ``Scene`` that is equal to no model."""


def explore(
    scene: SceneSource, path: Path | str | None = None, *, command: Sequence[str] | None = None
) -> InlinePage | None:
    """Write or return a page that simulates a scene; the reader of the page can change parameters.

    The page contains the compiled kernel, and computes the same numbers as ``simulate``. The page is one file
    that needs no other file. The reader can change all parameters, and add or remove links, points, walls and
    stops. Inputs without a signal are constant, or change when the reader moves their sliders while the
    motion plays; a base or wall with a prescribed motion, but without a signal, does not move.

    Args:
        scene: a scene, or an argument of ``load_scene``.
        path: the file to write, for a browser; without a path the page is returned, for a notebook.
        command: the words after ``chain-impact simulate`` in the page's command that repeats a motion; by
            default the source of the scene or, for a ``Scene``, the name of a model that is equal to it, or
            else ``scene.toml``.

    Raises:
        SceneError: when the scene cannot be read.
        BuildError: when the kernel for browsers must be compiled, and this fails. An installed package
            contains this kernel, except for a scene with a user's contact law.
        OSError: when the file cannot be written.
    """
    command_words = [_source(scene)] if command is None else list(command)
    text = explore_page(scene_of(scene), command_words)
    if path is None:
        return InlinePage(text)
    with written_atomically(Path(path)) as new_file:
        new_file.write_text(text, encoding="utf-8")
    return None


def explore_page(scene: Scene, command: Sequence[str]) -> str:
    """Return the page's HTML for a scene.

    ``command`` has the words after ``chain-impact simulate`` in the command that the page shows.

    Raises:
        BuildError: when the module for a browser must be compiled, and this fails.
    """
    module = browser_module(scene.contact.law_file).read_bytes()
    return assemble_page(
        browser_text("explore/explore.html"),
        scene.name,
        [*style_texts(), browser_text("explore/explore.css")],
        program_text(PROGRAM),
        data=compressed_text(json.dumps(explore_contents(scene, command), separators=(",", ":")).encode()),
        begin=joined_script(BEGIN),
        kernel=compressed_text(module),
        toml=STRIPPED_FROM_SCRIPTS.sub("", browser_text(TOML)),
        worker=compressed_text(program_text(WORKER).encode()),
    )


def explore_contents(scene: Scene, command: Sequence[str]) -> dict[str, Any]:
    """Return the data of the page: contents of the file, the result of ``page_kit``, and ``command``."""
    file = scene_to_dict(scene)
    for signal in file.get("signals", {}).values():
        # of the path only the file's name stays, because a page must not show folders of this machine
        if "file" in signal:
            signal["file"] = Path(signal["file"]).name
    return {"file": file, "kit": page_kit(scene), "command": list(command)}


def compressed_text(content: bytes) -> str:
    """Compress bytes, and return them as text in base64; the page can decompress them."""
    compressor = zlib.compressobj(9, wbits=-zlib.MAX_WBITS)
    return base64_text(compressor.compress(content) + compressor.flush())


def _source(scene: SceneSource) -> str:
    """Return the word for a scene in a command.

    For a ``Scene`` it is the name of an equal model or else UNNAMED_FILE, for any other source this source
    itself.
    """
    if not isinstance(scene, Scene):
        return os.fspath(scene)
    return next((name for name in model_names() if load_scene(name) == scene), UNNAMED_FILE)
