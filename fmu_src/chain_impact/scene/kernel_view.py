"""Objects that functions of the kernel can read like a record: their attributes stand for the fields."""

from types import SimpleNamespace
from typing import Any

import numpy as np

MASSES = ("length", "center_of_mass", "center_of_mass_offset", "inertia")
"""The fields of links that ``find_loose_links`` in kernel/chain/inertia.py reads."""


def chain_view(chain: Any) -> SimpleNamespace:
    """Return the argument of ``find_loose_links`` (kernel/chain/inertia.py) for a table ``chain``."""
    columns = {name: [getattr(link, name) for link in chain.links] for name in MASSES}
    return SimpleNamespace(has_base_joint=chain.has_base_joint, **columns)


def signals_view(signals: np.ndarray, knots: np.ndarray) -> SimpleNamespace:
    """Return the argument ``d`` of the functions in kernel/chain/signals.py for a single signal.

    ``signals`` and ``knots`` are the parts ``signal`` and ``knot`` of a record.
    """
    parts = {"signal": signals, "knot": knots}
    views = {
        name: SimpleNamespace(**{field: part[field] for field in part.dtype.names or ()})
        for name, part in parts.items()
    }
    return SimpleNamespace(signal_count=1, **views)
