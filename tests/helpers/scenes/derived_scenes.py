"""A scene with given and derived values, changes of its values, and the same changes of its file."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from typing import Any

from chain_impact.scene.scene import Scene, parse_scene, scene_from_dict
from chain_impact.scene.texts.names import name_of

FINGER = """
name = "Finger"

[chain]
base = "pinned"

[[chain.links]]
length = 0.5
mass = 0.5
joint_max = 0.4

[[chain.links]]
length = 0.3
mass = 0.25
inertia = 0.004
joint_min = 0.7
joint_max = 0.9

[[chain.links]]
length = 0.2
mass = 0.1
center_of_mass = 0.12
inertia = 1e-3

[box]
y_min = -0.8

[contact]
stiffness = 1e6
friction = 0.2

[initial]
angles = [0.2, 1.0, 0.6]

[simulation]
stop_time = 0.9
step_size = 0.002
"""
"""Links with both values of their shape, one value or none derived, and stops whose law is derived."""

PARAMETER_CHANGES = (
    {"link[1].length": 0.55},
    {"link[2].length": 0.35, "link[1].mass": 0.8, "link[3].mass": 0.2},
    {"contact.restitution": 0.45},
    {"contact.exponent": 1.25},
    # the value that the scene derives from the link's own length
    {"link[1].length": 0.55, "link[1].center_of_mass": 0.25},
    {"link[1].length": 0.55, "link[1].inertia": 0.02, "contact.restitution": 0.4, "stop.restitution": 0.9},
)
"""Changes that are also possible in an FMU."""


def finger() -> Scene:
    """Return the scene of FINGER."""
    return parse_scene(FINGER, "finger.toml")


def edited(text: str, changes: Mapping[str, Any]) -> Scene:
    """Return the scene of a file in which some keys have new values, or are removed if the value is None."""
    data = tomllib.loads(text)
    for name, value in changes.items():
        table, key = _place(data, name)
        if isinstance(key, int):
            table[key] = value
        elif value is None:
            table.pop(key, None)
        else:
            table[key] = value
    return scene_from_dict(data, data["name"])


def _place(data: dict[str, Any], name: str) -> tuple[Any, Any]:
    """Return the table that contains a key, and the last part of the key."""
    for i, link in enumerate(data["chain"]["links"]):
        for key in ("length", "mass", "center_of_mass", "inertia", "joint_min", "joint_max"):
            if name == name_of(("chain", "links", i, key)):
                return link, key
    if name.startswith("initial.angular_velocity["):
        rates = data["initial"].setdefault("angular_velocities", [0.0] * len(data["chain"]["links"]))
        return rates, int(name.partition("[")[2].rstrip("]")) - 1
    table, key = name.replace("stop.", "stops.").split(".")
    return data.setdefault(table, {}), key
