"""The page that simulates a scene in the browser: one file, with the compiled kernel in it."""

from __future__ import annotations

import base64
import os
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from chain_impact.compilation.library import browser_module
from chain_impact.results.page.inline import InlinePage
from chain_impact.results.page.kit import kit
from chain_impact.results.page.recorded import (
    PLAYER,
    assembled,
    program,
    script_data,
    styles,
    text_of,
)
from chain_impact.scene.models import model_names
from chain_impact.scene.scene import Scene, SceneSource, load_scene, scene_of, scene_to_dict
from chain_impact.system import written_whole

WORKER = ("kernel", "pacing", "room", "view", "frames", "bodies", "motion", "worker")
"""The modules of the worker, each after those that it imports from."""
MODULES = (
    *PLAYER,
    *(
        "unpacked",
        "signals",
        "scene_file",
        "model",
        "changes",
        "engine",
        "knobs",
        "ghosts",
        "handles",
        "outside",
    ),
    *("map", "edit", "explore"),
)
"""Those of the page."""
TOML = "vendor/smol-toml.cjs"
"""The library that reads scene files."""
UNNAMED = "scene.toml"
"""What a scene that was not loaded from a file is called in the page's command."""


def explore(
    scene: SceneSource, path: Path | str | None = None, *, command: Sequence[str] | None = None
) -> InlinePage | None:
    """Write a page that simulates a scene with the parameters that its reader chooses, or show it.

    The page has the compiled kernel in it, and gives the numbers of ``simulate``. It is one file, which needs
    nothing else. Its reader can change all parameters, and add or remove links, points, walls and stops.
    Inputs that no signal drives are constant; a base and walls that no signal drives keep their places.

    Args:
        scene: a scene, or what ``load_scene`` takes.
        path: the file to write, for a browser; without it the page is returned, which a notebook shows.
        command: what comes after ``chain-impact simulate`` in the command that the page gives to repeat a
            motion; by default the source of the scene, or the name of the model that it is.

    Raises:
        SceneError: when the scene cannot be read.
        BuildError: when the kernel for browsers has to be compiled, and cannot be: that of an installed
            package is there, but for a scene with a contact law of your own.
        OSError: when the file cannot be written.
    """
    known = [_source(scene)] if command is None else list(command)
    text = page(scene_of(scene), known)
    if path is None:
        return InlinePage(text)
    with written_whole(Path(path)) as fresh:
        fresh.write_text(text, encoding="utf-8")
    return None


def page(scene: Scene, command: Sequence[str]) -> str:
    """Return the page's HTML, for a scene, and what comes after ``chain-impact simulate`` in its command.

    Raises:
        BuildError: when the module for a browser has to be compiled, and cannot be.
    """
    module = browser_module(scene.contact.law_file).read_bytes()
    return assembled(
        text_of("explore.html"),
        scene.name,
        [*styles(), text_of("explore.css")],
        program(MODULES),
        data=script_data(contents(scene, command) | {"module": packed(module)}),
        toml=text_of(TOML),
        worker=program(WORKER),
    )


def contents(scene: Scene, command: Sequence[str]) -> dict[str, Any]:
    """What the page makes its scene of: the contents of its file, and what it needs to know of all scenes."""
    file = scene_to_dict(scene)
    for signal in file.get("signals", {}).values():
        if "file" in signal:  # without the folders of this machine
            signal["file"] = Path(signal["file"]).name
    return {"file": file, "kit": kit(scene), "command": list(command)}


def packed(content: bytes) -> str:
    """Return bytes as text for a page: compressed, as a browser can undo it."""
    compressor = zlib.compressobj(9, wbits=-zlib.MAX_WBITS)
    return base64.b64encode(compressor.compress(content) + compressor.flush()).decode("ascii")


def _source(scene: SceneSource) -> str:
    """What the command line calls a scene."""
    if not isinstance(scene, Scene):
        return os.fspath(scene)
    return next((name for name in model_names() if load_scene(name) == scene), UNNAMED)
