"""The page that simulates: one file, which needs nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import resources

from chain_impact.compilation.library import browser_module
from chain_impact.results.animation import page as player
from chain_impact.results.explore.description import description, packed
from chain_impact.scene.scene import Scene

PAGE = resources.files("chain_impact.results.explore") / "browser"
STYLES = ("explore.css",)
WORKER = ("unpacked", "kernel", "pacing", "room", "view", "motion", "worker")
"""The modules of the worker, each after those that it imports from."""
MODULES = ("unpacked", "view", "changes", "engine", "knobs", "ghosts", "handles", "outside", "map", "explore")
"""Those of the page, after the ones that show a recording."""


def page(scene: Scene, command: Sequence[str]) -> str:
    """The page's HTML.

    Args:
        scene: what it simulates at first.
        command: what comes after ``chain-impact simulate`` in the command that repeats what it shows.

    Raises:
        BuildError: when the module for a browser has to be compiled, and cannot be.
    """
    module = browser_module(scene.contact.law_file).read_bytes()
    return player.assembled(
        _text("index.html"),
        scene.name,
        [*player.styles(), *map(_text, STYLES)],
        "\n".join([player.player(), program(MODULES)]),
        data=player.script_data(description(scene, command) | {"module": packed(module)}),
        worker=program(WORKER),
    )


def program(names: tuple[str, ...]) -> str:
    """Some modules one after the other, as one."""
    return player.joined(map(source, names))


def source(name: str) -> str:
    """The text of a module of this folder, or else of the player's."""
    folder = PAGE if PAGE.joinpath(f"{name}.js").is_file() else player.PAGE
    return folder.joinpath(f"{name}.js").read_text(encoding="utf-8")


def _text(name: str) -> str:
    return PAGE.joinpath(name).read_text(encoding="utf-8")
