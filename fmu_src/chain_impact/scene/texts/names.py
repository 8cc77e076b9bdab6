"""The names of the values of a scene, which are the same in all commands, functions and outputs.

A parameter has the name of the FMU's variable: ``link[2].mass``, ``initial.angle[1]``, ``gravity.y``. Any
other value has the dotted key of the file as name: ``simulation.stop_time``, ``contact.points``. Links count
from 1, at the base.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

DataPath = tuple[str | int, ...]
"""A path in nested tables and lists: the keys, and the indices of lists, from 0."""
OWNER_AT = "{at}"
"""The placeholder of an index in the template of a path, such as ("chain", "links", "{at}", "mass").

The template of the name of the value has {n} there, as in link[{n}].mass, and {name} for a wall.
"""
LINK_AT, ENTRY_AT = "{link}", "{entry}"
"""The placeholders, in the template of a path, of the index of a link (LINK_AT), and of the index of a link's
point or of an entry in the list of a signal (ENTRY_AT).

The template of the name of the value has {of} for LINK_AT and {n} for ENTRY_AT: link[{of}].point[{n}].x.
"""
AXES = ("x", "y")
STOPS = ("joint_min", "joint_max")
"""The stops of a joint: the keys of a link in the file, and the names in ``wall_names``."""
SLIDER_STOPS = ("slider_min", "slider_max")
"""The names of a slider's stops in ``wall_names``."""


def point_label(number: int, names: Mapping[int, str]) -> str:
    """Return "point 5" for the point 5, or "point 5 (heel)" if ``names`` has the name "heel" for it."""
    return f"point {number} ({names[number]})" if number in names else f"point {number}"


def name_of(path: DataPath, walls: Sequence[object] = ()) -> str:
    """Return the name of the value at a path of the scene.

    For the template of a path, which has placeholders (OWNER_AT) for indices, the result is the template
    of a name. ``walls`` has the names of the entries of the scene's ``walls``, in order.
    """
    match path:
        case "gravity", int(j):
            name = f"gravity.{AXES[j]}"
        case "chain", "links", int() | "{link}" as i, "points", int() | "{entry}" as j, *following:
            name = _dotted_text(("link", i, "point", j, *following))
        case "chain", ("links" | "slider") as part, *following if following:
            name = _dotted_text((part.removesuffix("s"), *following))
        case "walls", int() | "{at}" as w, "point", int(j) if wall := _wall(w, walls):
            name = f"wall.{wall}.{AXES[j]}"
        case "walls", int() | "{at}" as w, key, *following if key != "name" and (wall := _wall(w, walls)):
            name = _dotted_text(("wall", wall, key, *following))
        case "contact", "wall", str(wall), str(key):
            name = f"wall.{wall}.{key}"
        case "stops", str(key) if key != "model":
            name = f"stop.{key}"
        case "initial", "position", int(j):
            name = f"initial.{AXES[j]}"
        case "initial", "velocity", int(j):
            name = f"initial.v{AXES[j]}"
        case "initial", "angles", int() | "{at}" as i:
            name = _dotted_text(("initial", "angle", i))
        case "initial", "angular_velocities", int() | "{at}" as i:
            name = _dotted_text(("initial", "angular_velocity", i))
        case _:
            name = _dotted_text(_signal_steps(path))
    return name


def _signal_steps(path: DataPath) -> DataPath:
    """Return the steps of the name of a value of a signal, from the path of the value.

    The steps have the word "signal" for "signals". In the path of an entry of a list, the key of the list is
    in the singular, too: ("signals", "a", "times", 0) gives ("signal", "a", "time", 0). Any other path is
    returned unchanged.
    """
    if path[:1] != ("signals",) or len(path) < 3:  # noqa: PLR2004
        return path
    _, signal, key, *entry = path
    return ("signal", signal, str(key).removesuffix("s") if entry else key, *entry)


def _wall(number: int | str, walls: Sequence[object]) -> str | None:
    """Return entry ``number`` of ``walls``, the names of the walls; None if this entry is no text.

    For the placeholder OWNER_AT in place of a number, the result is "{name}", the placeholder in names.
    """
    name = "{name}" if number == OWNER_AT else walls[int(number)]
    return name if isinstance(name, str) else None


def fmu_name(name: str) -> str:
    """Return the FMU's name of the value that ``name`` names, such as the key in the file.

    For example ``stop.stiffness`` for ``stops.stiffness``, ``link[1].mass`` for ``chain.links[1].mass``. A
    name without another form in the FMU is returned unchanged.
    """
    steps = name.replace("[", ".").replace("]", "").split(".")
    try:
        return name_of(tuple(int(step) - 1 if step.isdecimal() else step for step in steps)) or name
    # a number in the name is not that of a component of a vector, or has too many digits, or is the number of
    # an entry of ``walls``, whose name is not known here
    except (IndexError, ValueError):
        return name


def other_names(name: str) -> set[str]:
    """Return the other names that a message may have for the value that ``name`` names.

    These are the name in the FMU and, for a value of [stops], the key in the file, without ``name`` itself.
    """
    of_fmu = fmu_name(name)
    in_file = f"stops.{of_fmu.removeprefix('stop.')}" if of_fmu.startswith("stop.") else of_fmu
    return {of_fmu, in_file} - {name}


def as_typed(name: str, typed_names: Iterable[Any]) -> str:
    """Return the name of a value, or of an entry of a list, as the user typed it.

    Args:
        name: the name in the FMU or the key in the file, for an entry with its index.
        typed_names: the typed names; entries that are not texts are ignored.
    """
    for text in (candidate for candidate in typed_names if isinstance(candidate, str)):
        for other_name in other_names(text):
            if name == other_name or name.startswith(f"{other_name}["):
                return text + name.removeprefix(other_name)
    return name


def path_text(path: DataPath) -> str:
    """Return a path in a file as text, in which indices count from 1: "chain.links[1].mass", "gravity[2]"."""
    return "".join(f"[{step + 1}]" if isinstance(step, int) else f".{step}" for step in path).removeprefix(
        "."
    )


class NameParts(NamedTuple):
    """The parts of a variable's name.

    Attributes:
        owner: the word for the owner: ``contact`` in contact[2].y_min.force, ``energy`` in energy.total.
        n: the number in brackets after the owner: 2 in contact[2].y_min.force; 0 without brackets.
        name: the name of the owner's wall or signal: ``y_min`` in contact[2].y_min.force; "" without one.
        quantity: the rest of the name: ``force``, or ``load.x`` in wall.y_min.load.x.
    """

    owner: str
    n: int
    name: str
    quantity: str


_PARTS = re.compile(
    r"(?:(contact)\[(\d+)\]\.(\w+)|(wall|signal)\.(\w+)|(\w+)(?:\[(\d+)\])?)\.(.+)",
)


def name_parts(name: str) -> NameParts:
    """Return the parts of a variable's name; if it has no owner, the whole name is ``quantity``."""
    match = _PARTS.fullmatch(name)
    if not match:
        return NameParts("", 0, "", name)
    contact, point, wall, named_point, label, other_owner, number, quantity = match.groups("")
    return NameParts(
        contact or named_point or other_owner, int(point or number or 0), wall or label, quantity
    )


def grouped_by_owner(values: Mapping[str, Any]) -> dict[tuple[str, int, str], dict[str, Any]]:
    """Return (owner, n, name), as in ``NameParts``, → table of the owner: quantity → value.

    ``values`` has value by whole name of a variable.
    """
    owned: dict[tuple[str, int, str], dict[str, Any]] = {}
    for whole_name, value in values.items():
        owner, n, name, quantity = name_parts(whole_name)
        owned.setdefault((owner, n, name), {})[quantity] = value
    return owned


def is_like(name: str, template: str) -> bool:
    """Return whether a name matches a template, in which [{n}] matches any number, {name} any word."""
    steps, forms = name.split("."), template.split(".")
    return len(steps) == len(forms) and all(map(has_form, steps, forms))


def has_form(step: str, form: str) -> bool:
    """Return whether one step of a name, between dots, matches a step of a template (``is_like``)."""
    head, bracket, number = step.partition("[")
    if form.endswith("}]"):
        return head == form.partition("[")[0] and number[:-1].isdecimal() and number[-1] == "]"
    return step == form or (form == "{name}" and not bracket)


SENSITIVITY = "sensitivity."
"""The text with which the name of the derivative of an output begins."""


def sensitivity_name(output: str, parameter: str) -> str:
    """Return the name of the derivative of an output by a parameter: ``sensitivity.<parameter>.<output>``."""
    return f"{SENSITIVITY}{parameter}.{output}"


def _dotted_text(path: DataPath) -> str:
    numbers = {OWNER_AT: "[{n}]", LINK_AT: "[{of}]", ENTRY_AT: "[{n}]"}
    steps = (f"[{step + 1}]" if isinstance(step, int) else numbers.get(step, f".{step}") for step in path)
    return "".join(steps).removeprefix(".")
