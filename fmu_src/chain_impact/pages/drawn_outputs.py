"""The outputs over time that pages draw besides the positions, each under a group and a name in it.

``recording/frames.js`` and the drawing find an output by its group and name. The page that simulates reads
the outputs from the record; the page of a recording reads them from its columns.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from chain_impact.recording.impacts import LOG_DTYPE
from chain_impact.scene.texts.names import grouped_by_owner
from chain_impact.variables.outputs import OUTPUTS

_QUANTITIES = {(kind.parts.owner, kind.parts.quantity) for block in OUTPUTS for kind in block.kinds}
DRAWN_COLUMNS: Mapping[tuple[str, str], tuple[str, str]] = {
    ("contact", "force"): ("contacts", "force"),
    ("contact", "penetration"): ("contacts", "penetration"),
    ("contact", "friction_force"): ("contacts", "friction"),
    ("contact", "sticking"): ("contacts", "sticking"),
    ("joint", "stop_moment"): ("stops", "moment"),
    ("joint", "sticking"): ("joints", "sticking"),
    ("slider", "sticking"): ("joints", "sticking"),
    ("joint", "force.x"): ("loads", "x"),
    ("joint", "force.y"): ("loads", "y"),
    **{(owner, name): ("energies", name) for owner, name in sorted(_QUANTITIES) if owner == "energy"},
}
"""Owner and quantity of an output → group of the quantity, and its name there; the group ``joints`` has the
slider as joint 0."""
GROUPS = tuple(dict.fromkeys(group for group, _ in DRAWN_COLUMNS.values()))
"""The names of the groups; an entry of a group has the quantities of one owner."""
IMPACT_QUANTITIES = tuple(name for name in LOG_DTYPE.names or () if LOG_DTYPE[name] == np.float64)
"""The columns of a list of impacts that are real numbers, which the impacts of pages have, too."""
NEEDED_QUANTITIES = {"contacts": {"force"}, "loads": {"x", "y"}}
"""Group → the quantities without which an entry cannot be drawn."""

if missing_outputs := DRAWN_COLUMNS.keys() - _QUANTITIES:
    raise KeyError(f"no outputs: {sorted(missing_outputs)}")


def drawn_entries(columns: Mapping[str, np.ndarray]) -> dict[str, list[dict[str, Any]]]:
    """Return name of a group → entries of the group, from ``columns``: output of a recording → values.

    An entry has the number ``n`` and the ``name`` of its owner (0 and "" if it has none), and its
    ``columns``: name of the quantity → values, shape (T,). Entries that cannot be drawn are left out.
    """
    groups: dict[str, dict[tuple[int, str], dict[str, np.ndarray]]] = {group: {} for group in GROUPS}
    for (owner, n, name), quantities in grouped_by_owner(columns).items():
        for quantity, values in quantities.items():
            if (owner, quantity) in DRAWN_COLUMNS:
                group, drawn_name = DRAWN_COLUMNS[owner, quantity]
                groups[group].setdefault((n, name), {})[drawn_name] = values
    return {
        group: [
            {"n": n, "name": name, "columns": columns}
            for (n, name), columns in entries.items()
            if columns.keys() >= NEEDED_QUANTITIES.get(group, set())
        ]
        for group, entries in groups.items()
    }
