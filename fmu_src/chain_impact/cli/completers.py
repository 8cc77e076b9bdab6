"""The names and values, of a scene or an FMU, with which a shell completes an option."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

DEFAULT_SCENE = "four_link_box"


class Offer(NamedTuple):
    """The names that a shell offers at a place of the command.

    Attributes:
        names: the names.
        choices: name → values, for each name that has only a few values.
    """

    names: Iterable[str]
    choices: Mapping[str, Sequence[str]] = MappingProxyType({})


Offers = Callable[[str], Offer]
"""A function: source → names that a shell offers."""


def complete(
    argument: argparse.Action, offers: Offers, *, listed: bool = False, valued: bool = False
) -> None:
    """Let a shell complete names after an option (cli/completion.py).

    Args:
        argument: the option.
        offers: function that returns the names for a source.
        listed: whether the option takes a list of names with commas.
        valued: whether ``=`` and a value follow a name.
    """

    def completer(prefix: str, parsed_args: Any = None, **_: object) -> list[str]:
        source = getattr(parsed_args, "source", None) or DEFAULT_SCENE
        try:
            names, choices = offers(source)
        except (ValueError, OSError):  # the command does not yet name a scene that can be read
            return []
        name, equals, value = prefix.partition("=")
        if valued and equals:
            done = value[: value.rfind(",") + 1]
            return [f"{name}={done}{choice}" for choice in choices.get(name, [])]
        done = prefix[: prefix.rfind(",") + 1] if listed else ""
        return [f"{done}{name}{'=' if valued else ''}" for name in names]

    vars(argument)["completer"] = completer  # the attribute in which argcomplete looks for the completer


def is_fmu(source: str) -> bool:
    """Return whether the source is the name of an FMU."""
    return source.lower().endswith(".fmu")


def settings(source: str) -> Offer:
    """Return the names that ``--set`` accepts."""
    if is_fmu(source):
        return _of_fmu(source, "parameter")
    from chain_impact.scene.scene import load_scene

    scene = load_scene(source)
    return Offer([name for name in scene.values if "." in name], _choices(source))


def parameters(source: str) -> Offer:
    """Return the names that ``--vary`` accepts."""
    from chain_impact.scene.scene import load_scene
    from chain_impact.studies.sweep.variation import sweepable

    return Offer(sweepable(load_scene(source)), _choices(source))


def differentiable(source: str) -> Offer:
    """Return the names that ``--sensitivity`` and ``--free`` accept."""
    return Offer([*_model(source).differentiable])


def outputs(source: str) -> Offer:
    """Return the outputs of a scene or of an FMU."""
    if is_fmu(source):
        return _of_fmu(source, "output")
    return Offer(_model(source).outputs_by_name)


def rankable(source: str) -> Offer:
    """Return the quantities that ``--rank`` accepts."""
    from chain_impact.variables.indices import JOINT_FORCE, PEAKS

    return Offer([*PEAKS, JOINT_FORCE, *outputs(source).names])


def laws(source: str) -> Offer:
    """Return the contact laws that a scene can have."""
    from chain_impact.scene.scene import load_scene

    return Offer(load_scene(source).law_names)


def _of_fmu(source: str, causality: str) -> Offer:
    """Return the variables of an FMU that have the given causality, such as ``input`` or ``output``."""
    from chain_impact.fmu.importer import read_fmu

    return Offer(
        [
            variable.name
            for variable in read_fmu(Path(source)).modelVariables
            if variable.causality == causality
        ]
    )


def _model(source: str) -> Any:
    from chain_impact.scene.scene import load_scene
    from chain_impact.variables.prepared import PreparedScene

    return PreparedScene(load_scene(source))


def _choices(source: str) -> dict[str, list[str]]:
    """Return name of a parameter → names of its choices, for each parameter that is an enumeration."""
    return {
        variable.name: [item.name for item in variable.items]
        for variable in _model(source).parameters
        if variable.items
    }
