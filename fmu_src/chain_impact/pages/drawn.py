"""The outputs over time that the pages draw besides the positions, each with its group and its name in it.

``recording/frames.js`` and the drawing find an output by its group and name. The page that simulates reads
the outputs from the record; the page of a recording reads them from its columns.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from chain_impact.scene.names import is_like
from chain_impact.variables.outputs import OUTPUTS

_NAMES = {kind.name for block in OUTPUTS for kind in block.kinds}
DRAWN: Mapping[str, tuple[str, str]] = {
    "contact[{n}].{name}.force": ("contacts", "force"),
    "contact[{n}].{name}.penetration": ("contacts", "penetration"),
    "contact[{n}].{name}.friction_force": ("contacts", "friction"),
    "contact[{n}].{name}.sticking": ("contacts", "sticking"),
    "joint[{n}].stop_moment": ("stops", "moment"),
    "joint[{n}].sticking": ("joints", "sticking"),
    "slider.sticking": ("joints", "sticking"),
    "joint[{n}].force.x": ("loads", "x"),
    "joint[{n}].force.y": ("loads", "y"),
    **{name: ("energies", name[len("energy.") :]) for name in sorted(_NAMES) if name.startswith("energy.")},
}
"""Output → the group of the quantity, and its name in the group; a slider is joint 0."""
GROUPS = tuple(dict.fromkeys(group for group, _ in DRAWN.values()))
"""The groups; an entry of a group has the quantities of one owner."""
OF_IMPACT = {
    "speed": "impact_speed",
    "rebound": "separation_speed",
    "peak": "peak_force",
    "jointForce": "joint_force",
    "depth": "max_penetration",
}
"""Quantity of an impact in the pages → its column in a list of impacts."""
NEEDED_QUANTITIES = {"contacts": {"force"}, "loads": {"x", "y"}}
"""Group → the quantities without which an entry cannot be drawn."""

if unknown := DRAWN.keys() - _NAMES:
    raise KeyError(f"no outputs: {', '.join(sorted(unknown))}")


def drawn_entries(columns: Mapping[str, np.ndarray]) -> dict[str, list[dict[str, Any]]]:
    """Return group → its entries, from the columns of a recording.

    An entry has the number ``n`` and the ``name`` of its owner (0 and "" if it has none), and its
    ``columns``: name of the quantity → values, shape (T,). Entries that cannot be drawn are left out.
    """
    groups: dict[str, dict[tuple[int, str], dict[str, np.ndarray]]] = {group: {} for group in GROUPS}
    for name, values in columns.items():
        template = next((template for template in DRAWN if is_like(name, template)), None)
        if template is not None:
            group, quantity = DRAWN[template]
            groups[group].setdefault(_owner(name, template), {})[quantity] = values
    return {
        group: [
            {"n": n, "name": name, "columns": columns}
            for (n, name), columns in entries.items()
            if columns.keys() >= NEEDED_QUANTITIES.get(group, set())
        ]
        for group, entries in groups.items()
    }


def _owner(name: str, template: str) -> tuple[int, str]:
    """Return the number and the name of the owner of an output, from the output's name."""
    number = re.search(r"\[(\d+)\]", name)
    words = dict(zip(template.split("."), name.split("."), strict=True))
    return int(number[1]) if number else 0, words.get("{name}", "")
