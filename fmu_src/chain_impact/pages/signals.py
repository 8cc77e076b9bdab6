"""Data about signals for the page: the keys of each form, and the tables of the page's scene."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from chain_impact.pages.encoding import encoded
from chain_impact.scene.scene import Scene
from chain_impact.scene.signal import FORMS, SHAPES
from chain_impact.scene.signal_values import KNOTS, NUMBERS, table_of
from chain_impact.scene.signals import OTHER, REQUIRED, driven_by


def kit_of_signals(scene: Scene) -> dict[str, Any]:
    """Return all data about signals that the page needs; JSON can hold them."""
    return {
        "forms": FORMS,
        "shapes": SHAPES,
        "numbers": NUMBERS,
        "required": REQUIRED,
        "other": OTHER,
        "knots": KNOTS,
        "tables": {
            name: _table(scene, name) for name, signal in scene.signals.items() if signal.form == "table"
        },
    }


def _table(scene: Scene, name: str) -> dict[str, Any]:
    """Return a table: the name of its file, and the polynomials of each input that the table drives."""
    signal, columns = scene.signals[name], {}
    for driven in driven_by(scene):
        if driven.signal == name:
            times, powers, gain = table_of(signal, driven.input, driven.order, scene.simulation.stop_time)
            columns[driven.input] = {
                "knots": len(times),
                "times": _packed(times),
                "powers": [_packed(column) for column in powers.T],
                "gain": gain,
            }
    return {
        "file": Path(signal.file or "").name,
        "interpolation": signal.interpolation,
        "period": signal.period,
        "columns": columns,
    }


def _packed(numbers: np.ndarray) -> str:
    """Return numbers as text, with all their bits, so that the page computes with the same numbers."""
    return encoded(numbers.astype("<f8").tobytes())
