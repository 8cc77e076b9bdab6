"""What a shell can complete: scenes, and names of values of the scene that stands on the line."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path

Completer = Callable[..., list[str]]


def completed(action: argparse.Action, completer: Completer) -> None:
    """Name what completes an argument, where argcomplete looks for it."""
    vars(action)["completer"] = completer


def scenes(prefix: str, **_: object) -> list[str]:
    """Models, and files and folders that can be scenes."""
    from argcomplete.completers import FilesCompleter

    from chain_impact.scene.models import model_names

    files = FilesCompleter(("toml", "fmu", "csv"))(prefix)
    return [*(name for name in model_names() if name.startswith(prefix)), *files]


def names(of: Callable[[str], Iterable[str]], end: str = "", separator: str = "\n") -> Completer:
    """A completer for the names that a function finds in a scene, each or the last one of a list."""

    def complete(prefix: str, parsed_args: argparse.Namespace, **_: object) -> list[str]:
        before = prefix[: prefix.rfind(separator) + 1]
        with suppress(ValueError, OSError):  # of a scene that cannot be read nothing is known
            found = of(parsed_args.source or "")
            return [f"{before}{name}{end}" for name in found if name.startswith(prefix[len(before) :])]
        return []

    return complete


def settings(source: str) -> Iterable[str]:
    """What ``--set`` takes: all values of a scene, or the parameters of an FMU."""
    from chain_impact.fmu.importer import read_fmu
    from chain_impact.fmu.run import EXPERIMENT
    from chain_impact.scene.scene import load_scene

    if not source.lower().endswith(".fmu"):
        return load_scene(source).values
    variables = read_fmu(Path(source)).modelVariables
    return [*(one.name for one in variables if one.causality == "parameter"), *EXPERIMENT]


def parameters(source: str, causality: str = "parameter") -> list[str]:
    """The FMU variables of a scene of a causality."""
    from chain_impact.scene.scene import load_scene
    from chain_impact.variables.model import Model

    return [one.name for one in Model(load_scene(source)).variables if one.causality == causality]


def outputs(source: str) -> list[str]:
    """The outputs of a scene."""
    return parameters(source, "output")


def laws(_: str) -> Iterable[str]:
    """The contact laws."""
    from chain_impact.kernel.laws.contact_laws import CONTACT_LAWS

    return CONTACT_LAWS
