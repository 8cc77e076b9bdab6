"""The names and values that a shell offers for an option; the command's scene or FMU determines them."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

DEFAULT_SCENE = "four_link_box"


class Offer(NamedTuple):
    """The texts that a shell offers where the user presses Tab.

    Attributes:
        names: the names to choose from.
        choices: name → the possible values, for each of the names that is an enumeration.
    """

    names: Iterable[str]
    choices: Mapping[str, Sequence[str]] = MappingProxyType({})


Offers = Callable[[str], Offer]
"""A function from the source of a command, the name of a scene or FMU, to what a shell offers."""


def complete(
    argument: argparse.Action, offers: Offers, *, is_listed: bool = False, is_valued: bool = False
) -> None:
    """Let a shell offer names for an option (see cli/completion.py).

    Args:
        argument: the option.
        offers: function that returns names and choices for the source of the command.
        is_listed: whether the option takes several names, separated by commas.
        is_valued: whether the option takes a name, ``=``, and values with commas between them.
    """

    def completer(prefix: str, parsed_args: Any = None, **_: object) -> list[str]:
        source = getattr(parsed_args, "source", None) or DEFAULT_SCENE
        try:
            names, choices = offers(source)
        except (ValueError, OSError):  # the words typed so far do not name a scene or FMU that can be read
            return []
        name, equals, value = prefix.partition("=")
        if is_valued and equals:
            beginning = value[: value.rfind(",") + 1]
            return [f"{name}={beginning}{choice}" for choice in choices.get(name, [])]
        beginning = prefix[: prefix.rfind(",") + 1] if is_listed else ""
        return [f"{beginning}{name}{'=' if is_valued else ''}" for name in names]

    # argcomplete looks for the completer of an option in this attribute
    vars(argument)["completer"] = completer


def is_fmu(source: str) -> bool:
    """Return whether the source of a command ends in .fmu, in upper or lower case."""
    return source.lower().endswith(".fmu")


def settings(source: str) -> Offer:
    """Return the names that ``--set`` takes; for a scene, also the choices of each enumeration."""
    if is_fmu(source):
        return _fmu_variable_names(source, "parameter")
    from chain_impact.scene.scene import load_scene

    scene = load_scene(source)
    return Offer([name for name in scene.values if "." in name], _choices(source))


def parameters(source: str) -> Offer:
    """Return the names of the parameters that ``--vary`` takes, and the choices of each enumeration."""
    from chain_impact.scene.scene import load_scene
    from chain_impact.study_data.sweep.variation import sweepable_variables

    return Offer(sweepable_variables(load_scene(source)), _choices(source))


def differentiable_names(source: str) -> Offer:
    """Return the names that ``--sensitivity``, ``--free`` and ``--free-each`` take; no patterns."""
    return Offer([*_model(source).differentiable])


def outputs(source: str) -> Offer:
    """Return the names of the outputs of a scene or an FMU."""
    if is_fmu(source):
        return _fmu_variable_names(source, "output")
    return Offer(_model(source).outputs_by_name)


def rankable_names(source: str) -> Offer:
    """Return the names that ``--rank`` takes, without the names of quantities of single impacts."""
    from chain_impact.variables.peaks import JOINT_FORCE, PEAKS

    return Offer([*PEAKS, JOINT_FORCE, *outputs(source).names])


def laws(source: str) -> Offer:
    """Return the names of all contact laws and, if the scene has one, of the user's law."""
    from chain_impact.scene.scene import load_scene

    return Offer(load_scene(source).law_names)


def _fmu_variable_names(source: str, causality: str) -> Offer:
    """Return the names of those variables of an FMU that have a causality, such as ``output``."""
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
    """Return name of a parameter → names of its choices, for the enumerations of the scene ``source``."""
    return {
        variable.name: [item.name for item in variable.items]
        for variable in _model(source).parameters
        if variable.items
    }
