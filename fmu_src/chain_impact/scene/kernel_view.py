"""Stand-ins for the kernel's record: objects with values of a scene under the names of the record's fields.

Functions of the kernel can read them like a record.
"""

from types import SimpleNamespace
from typing import Any

import numpy as np

MASSES = ("length", "center_of_mass", "center_of_mass_offset", "inertia")
"""The fields of links that ``loose_links`` in kernel/chain/inertia.py reads."""


def chain_view(chain: Any) -> SimpleNamespace:
    """Return the table ``chain`` of a scene as the argument of ``loose_links`` in kernel/chain/inertia.py."""
    columns = {name: [getattr(link, name) for link in chain.links] for name in MASSES}
    return SimpleNamespace(has_base_joint=chain.has_base_joint, **columns)


def signals_view(signals: np.ndarray, knots: np.ndarray) -> SimpleNamespace:
    """Return the parts ``signal`` and ``knot`` of a record as ``d`` for kernel/chain/signals.py."""
    parts = {"signal": signals, "knot": knots}
    views = {
        name: SimpleNamespace(**{field: part[field] for field in part.dtype.names or ()})
        for name, part in parts.items()
    }
    return SimpleNamespace(signals=1, **views)
