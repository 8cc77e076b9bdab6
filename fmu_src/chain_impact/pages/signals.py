"""The tables among the signals of a scene, as data for the page."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from chain_impact.pages.encoding import base64_text
from chain_impact.scene.scene import Scene
from chain_impact.scene.signal_polynomials import table_polynomial
from chain_impact.scene.signals import signal_inputs_of


def signal_table_data(scene: Scene) -> dict[str, Any]:
    """Return name → data of ``_table``, ready for JSON, for the signals of a scene that are tables."""
    return {name: _table(scene, name) for name, signal in scene.signals.items() if signal.form == "table"}


def _table(scene: Scene, name: str) -> dict[str, Any]:
    """Return the table of signal ``name``: file name, interpolation, period and ``columns``.

    ``columns``: input that the table drives → its piecewise polynomial: number, start times and coefficients
    of the pieces, and the gain, the change of the input from one period to the next.
    """
    signal, columns = scene.signals[name], {}
    for signal_input in signal_inputs_of(scene):
        if signal_input.signal == name:
            times, powers, gain = table_polynomial(
                signal, signal_input.input, signal_input.order, scene.simulation.stop_time
            )
            columns[signal_input.input] = {
                "knots": len(times),
                "times": _number_text(times),
                "powers": [_number_text(column) for column in powers.T],
                "gain": gain,
            }
    return {
        "file": Path(signal.file or "").name,
        "interpolation": signal.interpolation,
        "period": signal.period,
        "columns": columns,
    }


def _number_text(numbers: np.ndarray) -> str:
    """Return the bytes of numbers in base64, so that the page computes with exactly the same numbers.

    Each number has 8 bytes, the least significant byte first.
    """
    return base64_text(numbers.astype("<f8").tobytes())
