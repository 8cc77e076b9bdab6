"""What a shell offers for an option: names and values that depend on the scene or FMU of the command."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

DEFAULT_SCENE = "four_link_box"


class Offer(NamedTuple):
    """What a shell offers at the place of the command where the user presses Tab.

    Attributes:
        names: the names to choose from.
        choices: name → its possible values, for each name that has only a few.
    """

    names: Iterable[str]
    choices: Mapping[str, Sequence[str]] = MappingProxyType({})


Offers = Callable[[str], Offer]
"""A function that returns what a shell offers for a source, the name of a scene or FMU."""


def complete(
    argument: argparse.Action, offers: Offers, *, listed: bool = False, valued: bool = False
) -> None:
    """Let a shell offer names for an option (see cli/completion.py).

    Args:
        argument: the option.
        offers: function that returns the names for the source of the command.
        listed: whether the option takes several names, separated by commas.
        valued: whether each name is followed by ``=`` and a value.
    """

    def completer(prefix: str, parsed_args: Any = None, **_: object) -> list[str]:
        source = getattr(parsed_args, "source", None) or DEFAULT_SCENE
        try:
            names, choices = offers(source)
        except (ValueError, OSError):  # so far the command names no scene or FMU that can be read
            return []
        name, equals, value = prefix.partition("=")
        if valued and equals:
            done = value[: value.rfind(",") + 1]
            return [f"{name}={done}{choice}" for choice in choices.get(name, [])]
        done = prefix[: prefix.rfind(",") + 1] if listed else ""
        return [f"{done}{name}{'=' if valued else ''}" for name in names]

    # argcomplete looks for the completer of an option in this attribute
    vars(argument)["completer"] = completer


def is_fmu(source: str) -> bool:
    """Return whether the source of a command is the name of an FMU."""
    return source.lower().endswith(".fmu")


def settings(source: str) -> Offer:
    """Return the names that ``--set`` accepts; for a scene also the possible values of each enumeration."""
    if is_fmu(source):
        return _of_fmu(source, "parameter")
    from chain_impact.scene.scene import load_scene

    scene = load_scene(source)
    return Offer([name for name in scene.values if "." in name], _choices(source))


def parameters(source: str) -> Offer:
    """Return the parameters of a scene that ``--vary`` accepts, and the possible values of enumerations."""
    from chain_impact.scene.scene import load_scene
    from chain_impact.studies.sweep.variation import sweepable

    return Offer(sweepable(load_scene(source)), _choices(source))


def differentiable(source: str) -> Offer:
    """Return the parameters and inputs of a scene that ``--sensitivity`` and ``--free`` accept."""
    return Offer([*_model(source).differentiable])


def outputs(source: str) -> Offer:
    """Return the names of the outputs of a scene or an FMU."""
    if is_fmu(source):
        return _of_fmu(source, "output")
    return Offer(_model(source).outputs_by_name)


def rankable(source: str) -> Offer:
    """Return the names of quantities by whose change ``--rank`` can rank the parameters of a scene."""
    from chain_impact.variables.indices import JOINT_FORCE, PEAKS

    return Offer([*PEAKS, JOINT_FORCE, *outputs(source).names])


def laws(source: str) -> Offer:
    """Return the ids of all contact laws and, if the scene has one, of the user's own law."""
    from chain_impact.scene.scene import load_scene

    return Offer(load_scene(source).law_names)


def _of_fmu(source: str, causality: str) -> Offer:
    """Return the names of an FMU's variables with a causality, such as ``parameter`` or ``output``."""
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
    """Return for each parameter of a scene that is an enumeration: its name → the names of its choices."""
    return {
        variable.name: [item.name for item in variable.items]
        for variable in _model(source).parameters
        if variable.items
    }
