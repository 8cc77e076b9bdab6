"""The names of the values of a scene, which are the same in all commands, functions and outputs.

A parameter has the name of the FMU's variable: ``link[2].mass``, ``initial.angle[1]``, ``gravity.y``. Any
other value has the dotted key of the file as name: ``simulation.stop_time``, ``contact.points``. Links count
from 1, at the base.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
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


INPUTS_OF: dict[str, dict[str, str]] = {
    "joint_torques": {"joint[{n}].torque": "N.m"},
    "joint_targets": {
        **{"joint[{n}].target_angle": "rad", "joint[{n}].target_velocity": "rad/s"},
        **{"slider.target_position": "m", "slider.target_velocity": "m/s"},
    },
    "slider_force": {"slider.force": "N"},
    "tip_force": {f"tip.force.{axis}": "N" for axis in AXES},
    "base_motion": {
        f"base.{prefix}{axis}": unit
        for prefix, unit in (("", "m"), ("v", "m/s"), ("a", "m/s2"))
        for axis in AXES
    },
    "wall_motion": {
        **{"wall.{name}.displacement": "m", "wall.{name}.velocity": "m/s"},
        **{"wall.{name}.acceleration": "m/s2", "wall.{name}.belt_speed": "m/s"},
    },
}
"""Key of `[inputs]` → the inputs that the key adds, as template of the name → unit. {n} stands for the number
of a joint, {name} for the name of a wall."""


def is_like(name: str, template: str) -> bool:
    """Return whether a name matches a template, in which [{n}] matches any number, {name} any word."""
    steps, forms = name.split("."), template.split(".")
    return len(steps) == len(forms) and all(map(_has_form, steps, forms))


def _has_form(step: str, form: str) -> bool:
    head, bracket, number = step.partition("[")
    if form.endswith("}]"):
        return head == form.partition("[")[0] and number[:-1].isdecimal() and number[-1] == "]"
    return step == form or (form == "{name}" and not bracket)


def input_key(name: str) -> str | None:
    """Return the key of `[inputs]` that adds the input ``name``; None if ``name`` has no form of an input."""
    return next(
        (key for key, names in INPUTS_OF.items() if any(is_like(name, pattern) for pattern in names)), None
    )


def input_request(name: str) -> str | None:
    """Return the line of a scene file that adds the input ``name``; None if ``name`` has no form of an input.

    For example ``inputs.joint_torques = true`` for ``joint[2].torque``.
    """
    key = input_key(name)
    if key == "wall_motion":
        return f'inputs.wall_motion = ["{name.split(".")[1]}"]'
    return key and f"inputs.{key} = true"


SENSITIVITY = "sensitivity."
"""The text with which the name of the derivative of an output begins."""


def sensitivity_name(output: str, parameter: str) -> str:
    """Return the name of the derivative of an output by a parameter: ``sensitivity.<parameter>.<output>``."""
    return f"{SENSITIVITY}{parameter}.{output}"


VALUE_WITHOUT_DRIVE = {
    "joint[{n}].target_angle": "link[{n}].joint_rest_angle",
    "slider.target_position": "slider.rest_position",
    **{f"base.{axis}": f"initial.{axis}" for axis in AXES},
}
"""Input → the parameter that gives the input's value if nothing drives the input; {n}: a joint's number."""


def without_drive(name: str) -> str | None:
    """Return the parameter of the input ``name`` in VALUE_WITHOUT_DRIVE; None for any other name."""
    for template, parameter in VALUE_WITHOUT_DRIVE.items():
        if is_like(name, template):
            return parameter.format(n=re.sub("[^0-9]", "", name))
    return None


def value_at_start(values: Mapping[str, Any], name: str) -> float:
    """Return the value of ``name`` at the start of a run; ``values`` is name → value of a scene.

    If ``values`` lacks the name, it is that of an input that nothing drives: the result is then the value of
    the input's parameter in VALUE_WITHOUT_DRIVE, or 0 without one.
    """
    return float(values.get(name, values.get(without_drive(name) or "", 0.0)))


def input_hint(name: str, advice: str) -> str:
    """Return a hint for the input ``name``, which the user sets like a parameter.

    ``advice`` are the words for how to give the input.
    """
    hint = f"it is an input: give it over time {advice}"
    if start := start_hint(name):
        return f"{hint}; {start}"
    parameter = without_drive(name)
    return f"{hint}; without, it is {parameter}, which can be set" if parameter else hint


POSITION_PARTS, ANGLE_PARTS = ("x", "y", "vx", "vy"), ("angle", "angular_velocity")
START_NAMES = {
    **{
        f"{owner}.{part}": f"initial.{part} sets it"
        for owner in ("base", "point[0]")
        for part in POSITION_PARTS
    },
    "base.position": "initial.x and initial.y set it",
    "base.velocity": "initial.vx and initial.vy set it",
    **{f"point[{{n}}].{part}": f"initial.{part} and initial.angle[1] … set it" for part in "xy"},
    **{f"link[{{n}}].{part}": f"initial.{part}[{{n}}] sets it" for part in ANGLE_PARTS},
    "joint[{n}].angle": "initial.angle[{n}] sets the absolute angle of link {n}",
    "joint[{n}].position": "initial.angle[{n}] sets the absolute angle of link {n}",
    "joint[{n}].angular_velocity": "initial.angular_velocity[{n}] sets that of link {n}, absolute,",
    "joint[{n}].velocity": "initial.angular_velocity[{n}] sets that of link {n}, absolute,",
    "slider.position": "with the base at initial.x and initial.y it is 0",
    "slider.velocity": "initial.slider_velocity sets it",
}
"""Quantity of a motion → words for the parameters that set its start value; {n} stands for the number of a
point, link or joint."""


def start_hint(name: str) -> str | None:
    """Return a hint which parameters set the start of a quantity in START_NAMES; None for another name."""
    for template, hint in START_NAMES.items():
        if is_like(name, template):
            return f"{hint.format(n=re.sub('[^0-9]', '', name))} at the start"
    return None


JOINT_ANGLES = "initial.joint_angles"


def parameter_hint(name: str, links: int, signals: Collection[str]) -> str | None:
    """Return a hint what to do in place of setting ``name``, which is not a parameter of the scene.

    The result is None if no hint is known.

    Args:
        name: the name that the user typed.
        links: the number of links.
        signals: the names of the scene's signals.
    """
    owner, _, key = name.partition(".")
    has_number = key and any(_has_form(owner, form) for form in ("link[{n}]", "joint[{n}]"))
    if has_number and not 1 <= int(re.sub("[^0-9]", "", owner)) <= links:
        return f"{owner.partition('[')[0]}s count from 1 to {links}"
    if input_key(name):
        python_code = f'simulate(scene, inputs={{"{name}": 1.0}})'
        return input_hint(name, f"by a signal of the scene, by --inputs FILE, or in Python, {python_code}")
    if name.startswith(JOINT_ANGLES):
        return "set initial.angle[1] and so on: each is the sum of the joint angles up to it"
    start = start_hint(name)
    return f"it changes in the motion: {start}" if start else signal_hint(name, signals)


def signal_hint(name: str, signals: Collection[str]) -> str | None:
    """Return a hint how to make the signal that ``name``, of the form ``signal.<signal>.<key>``, needs.

    The result is None for a name of another form, and if ``signals`` has the signal.
    """
    table, _, key = name.partition(".")
    signal = key.partition(".")[0]
    if table not in ("signal", "signals") or not signal or signal in signals:
        return None
    return f"a signal is made in the scene file, in a table [signals.{signal}]: docs/drive.md tells how"


def _dotted_text(path: DataPath) -> str:
    numbers = {OWNER_AT: "[{n}]", LINK_AT: "[{of}]", ENTRY_AT: "[{n}]"}
    steps = (f"[{step + 1}]" if isinstance(step, int) else numbers.get(step, f".{step}") for step in path)
    return "".join(steps).removeprefix(".")
