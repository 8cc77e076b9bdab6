"""One name for one thing: how the values of a scene are called, wherever a user meets them.

What is a parameter of the FMU has its name there: ``link[2].mass``, ``initial.angle[1]``, ``gravity.y``. All
else has its dotted key: ``simulation.stop_time``, ``contact.points``. Links count from 1, at the base.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from difflib import get_close_matches

Place = tuple[str | int, ...]
"""A path into nested tables and lists; lists count from 0."""
AXES = ("x", "y")
STOPS = ("joint_min", "joint_max")
"""The stops of a joint: keys of a link, and what they are called among the walls."""


def name_of(path: Place, walls: Sequence[object] = ()) -> str:
    """The name of the value at a path of the scene; ``walls`` are the names of the walls at any angle."""
    match path:
        case "gravity", int(j):
            name = f"gravity.{AXES[j]}"
        case "chain", "links", int(i), *rest:
            name = _dotted(("link", i, *rest))
        case "walls", int(w), "point", int(j) if isinstance(walls[w], str):
            name = f"wall.{walls[w]}.{AXES[j]}"
        case "walls", int(w), key, *rest if isinstance(walls[w], str) and key != "name":
            name = _dotted(("wall", str(walls[w]), key, *rest))
        case "contact", "wall", str(wall), str(key):
            name = f"wall.{wall}.{key}"
        case "stops", str(key) if key != "model":
            name = f"stop.{key}"
        case "initial", "position", int(j):
            name = f"initial.{AXES[j]}"
        case "initial", "velocity", int(j):
            name = f"initial.v{AXES[j]}"
        case "initial", "angles", int(i):
            name = f"initial.angle[{i + 1}]"
        case "initial", "angular_velocities", int(i):
            name = f"initial.angular_velocity[{i + 1}]"
        case _:
            name = _dotted(path)
    return name


def place_in_file(path: Place) -> str:
    """Where the value at a path is in the scene file: "mass in [[chain.links]]"."""
    *head, last = path
    if isinstance(last, int):
        return f"entry {last + 1} of {place_in_file(tuple(head))}"
    tables = [k for k, step in enumerate(head) if isinstance(step, int)]
    return f"{last} in [[{_dotted(tuple(head[: tables[0]]))}]]" if tables else _dotted(path)


_INPUT_NAMES = {
    "joint_torques": r"joint\[\d+\]\.torque",
    "joint_targets": r"joint\[\d+\]\.target_(angle|velocity)",
    "tip_force": r"tip\.force\.[xy]",
    "base_motion": r"base\.[va]?[xy]",
    "wall_motion": r"wall\.\w+\.(displacement|velocity|acceleration|belt_speed)",
}
"""Key of `[inputs]` → the names of the inputs that it makes."""


def input_key(name: str) -> str | None:
    """The key of `[inputs]` that makes the input of a name; None if it is not the name of one."""
    for key, names in _INPUT_NAMES.items():
        if re.fullmatch(names, name):
            return key
    return None


def input_asked(name: str) -> str | None:
    """What in a scene file makes the input of a name; None if it is not the name of one."""
    key = input_key(name)
    if key == "wall_motion":
        return f'inputs.wall_motion = ["{name.split(".")[1]}"]'
    return key and f"inputs.{key} = true"


SENSITIVITY = "sensitivity."
"""The names of derivatives begin so."""


def sensitivity_name(output: str, parameter: str) -> str:
    """The name of the derivative of an output with respect to a parameter."""
    return f"{SENSITIVITY}{parameter}.{output}"


JOINT_ANGLES = "initial.joint_angles"


def parameter_hint(name: str, links: int) -> str | None:
    """What to do about a name that is no parameter of a chain of some links, if it is known."""
    if input_key(name):
        return f'it is an input: give it over time in Python, simulate(scene, inputs={{"{name}": 1.0}})'
    if name.startswith(JOINT_ANGLES):
        return "set initial.angle[1] and so on: each is the sum of the joint angles up to it"
    link = re.match(r"link\[(\d+)\]\.", name)
    return f"links count from 1 to {links}" if link and not 1 <= int(link[1]) <= links else None


def absent_hint(name: str) -> str | None:
    """What to do about the name of a parameter that only the FMU of a scene with such a part has."""
    if re.fullmatch(r"(contact|wall\.\w+)\.(static_)?friction|link\[\d+\]\.joint_friction", name):
        return "it is a parameter where the scene has dry friction: give it a value there first"
    if re.fullmatch(r"link\[\d+\]\.joint_(armature|torque_limit)", name):
        return "it is a parameter where the scene has one: give it a value there first"
    if re.fullmatch(r"link\[\d+\]\.joint_rest_angle", name):
        return "with inputs.joint_targets the target angle takes its place, whose start value it is"
    return None


def nearest(name: str, names: Iterable[str], at_least: float = 0.6) -> str | None:
    """The name that is most like another, if one is alike by a ratio of 0 to 1."""
    return next(iter(get_close_matches(name, list(names), n=1, cutoff=at_least)), None)


def _dotted(path: Place) -> str:
    steps = (f"[{step + 1}]" if isinstance(step, int) else f".{step}" for step in path)
    return "".join(steps).removeprefix(".")
