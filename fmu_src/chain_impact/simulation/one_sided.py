"""The times of signals at the start of the run, with respect to which derivatives are one-sided."""

from __future__ import annotations

from typing import Any

import numpy as np

from chain_impact.kernel.chain.signals import signal_at
from chain_impact.scene.kernel_view import signals_view
from chain_impact.scene.signal_values import is_motion
from chain_impact.scene.signals import Driven

SAME = 1e-9
"""The difference, relative to the values, of two values that count as equal."""
# indices of the three results of ``signal_at``: value, rate and second derivative
VALUE, RATE, SECOND = range(3)


def bends_at_start(record: Any, driven: tuple[Driven, ...]) -> list[int]:
    """Return the knots at the time 0 where a signal bends so that the accelerations of the chain jump.

    If the knot comes later, the accelerations before the knot act in the run; if it comes earlier, they do
    not.

    Args:
        record: an initialized record.
        driven: the inputs that signals drive, in the order of the record.
    """
    d = signals_view(record["signal"].copy(), record["knot"].copy())
    found = []
    for j, each in enumerate(driven):
        d.signal.lap[j] = 0
        for k in range(d.signal.first[j] + 1, d.signal.last[j] + 1):
            if d.knot.time[k] == 0.0:
                before, after = _at_start(d, j, k - 1), _at_start(d, j, k)
                watched = _watched(each.input)
                if not np.allclose(before[watched], after[watched], rtol=SAME, atol=0.0):
                    found.append(k)
    return found


def _at_start(d: Any, j: int, segment: int) -> np.ndarray:
    d.signal.segment[j] = segment
    return np.array(signal_at(d, j, 0.0))


def _watched(name: str) -> list[int]:
    """Return which of an input's value, rate and second derivative change the chain's accelerations.

    A wall changes no acceleration, unless a point touches it.
    """
    if name.startswith("base."):
        return [SECOND]
    if is_motion(name):
        return []
    if name.startswith("wall."):
        return [RATE]  # the driven quantity is the distance that a belt has moved
    follows = name.endswith((".target_angle", ".target_position"))
    return [VALUE, RATE] if follows else [VALUE]
