"""What a shell completes after options that take names: those of a scene or an FMU, and values of choices."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

DEFAULT_SCENE = "four_link_box"


class Offer(NamedTuple):
    """What can stand at a place.

    Attributes:
        names: that can stand there.
        choices: name → values that it can have, of those that have few.
    """

    names: Iterable[str]
    choices: Mapping[str, Sequence[str]] = MappingProxyType({})


Offers = Callable[[str], Offer]
"""Source → what can stand there."""


def complete(
    argument: argparse.Action, offers: Offers, *, listed: bool = False, valued: bool = False
) -> None:
    """Let a shell complete names after an option (cli/completion.py).

    Args:
        argument: the option.
        offers: what there is.
        listed: whether names stand in a list with commas.
        valued: whether a name has a value behind ``=``.
    """

    def completer(prefix: str, parsed_args: Any = None, **_: object) -> list[str]:
        source = getattr(parsed_args, "source", None) or DEFAULT_SCENE
        try:
            names, choices = offers(source)
        except (ValueError, OSError):  # no scene is there yet
            return []
        name, equals, value = prefix.partition("=")
        if valued and equals:
            done = value[: value.rfind(",") + 1]
            return [f"{name}={done}{one}" for one in choices.get(name, [])]
        done = prefix[: prefix.rfind(",") + 1] if listed else ""
        return [f"{done}{one}{'=' if valued else ''}" for one in names]

    vars(argument)["completer"] = completer  # where argcomplete looks for it


def is_fmu(source: str) -> bool:
    """Return whether the source is meant to be an FMU."""
    return source.lower().endswith(".fmu")


def settings(source: str) -> Offer:
    """What ``--set`` takes."""
    if is_fmu(source):
        return _of_fmu(source, "parameter")
    from chain_impact.scene.scene import load_scene

    scene = load_scene(source)
    return Offer([name for name in scene.values if "." in name], _choices(source))


def parameters(source: str) -> Offer:
    """What ``--vary`` takes."""
    from chain_impact.scene.scene import load_scene
    from chain_impact.studies.sweep.variation import sweepable

    return Offer(sweepable(load_scene(source)), _choices(source))


def differentiable(source: str) -> Offer:
    """What ``--sensitivity`` and ``--free`` take."""
    return Offer([one.name for one in _model(source).varied_by(["*"])])


def outputs(source: str) -> Offer:
    """Return outputs, those of an FMU too."""
    if is_fmu(source):
        return _of_fmu(source, "output")
    return Offer(_model(source).outputs_by_name)


def rankable(source: str) -> Offer:
    """What ``--rank`` takes."""
    from chain_impact.results.ranking import JOINT_FORCE, LARGEST

    return Offer([*LARGEST, JOINT_FORCE, *outputs(source).names])


def laws(source: str) -> Offer:
    """Return the contact laws that a scene can have."""
    from chain_impact.scene.scene import load_scene

    return Offer(load_scene(source).law_names)


def _of_fmu(source: str, causality: str) -> Offer:
    """Return the variables of an FMU with a causality."""
    from chain_impact.fmu.importer import read_fmu

    return Offer([one.name for one in read_fmu(Path(source)).modelVariables if one.causality == causality])


def _model(source: str) -> Any:
    from chain_impact.scene.scene import load_scene
    from chain_impact.variables.model import Model

    return Model(load_scene(source))


def _choices(source: str) -> dict[str, list[str]]:
    """Return parameter → its choices."""
    return {one.name: [item.name for item in one.items] for one in _model(source).parameters if one.items}
