"""Finds knots of signals at t = 0, the start of the run, where accelerations of chain or walls jump.

The derivatives of a motion with respect to the times of such knots are one-sided.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from chain_impact.kernel.chain.signals import signal_at
from chain_impact.scene.kernel_view import signals_view
from chain_impact.scene.signals import SignalInput
from chain_impact.scene.texts.input_table import determined_quantities, is_motion

SAME_DERIVATIVE = 1e-9
"""[1] two values count as equal if they differ by at most this, relative to their size"""
# indices of the results of ``signal_at``: value, first and second derivative over time
VALUE, RATE, SECOND = range(3)


def bends_at_start(record: Any, signal_inputs: tuple[SignalInput, ...]) -> list[int]:
    """Return the indices of knots (starts of polynomials) at t = 0 where a signal makes accelerations jump.

    If such a knot came later, the run would begin with the accelerations before the knot; if the knot came
    earlier, with those after it.

    Args:
        record: an initialized record.
        signal_inputs: the inputs that signals drive, in the order of the record.
    """
    d = signals_view(record["signal"].copy(), record["knot"].copy())
    bends = []
    for j, signal_input in enumerate(signal_inputs):
        d.signal.lap[j] = 0
        for k in range(d.signal.first_knot[j] + 1, d.signal.last_knot[j] + 1):
            if d.knot.time[k] == 0.0:
                lower_derivatives, derivatives = _start_derivatives(d, j, k - 1), _start_derivatives(d, j, k)
                watched = _watched_orders(signal_input.input)
                if not np.allclose(
                    lower_derivatives[watched], derivatives[watched], rtol=SAME_DERIVATIVE, atol=0.0
                ):
                    bends.append(k)
    return bends


def _start_derivatives(d: Any, j: int, segment: int) -> np.ndarray:
    d.signal.segment[j] = segment
    return np.array(signal_at(d, j, 0.0))


def _watched_orders(name: str) -> list[int]:
    """Return which of VALUE, RATE and SECOND of an input change accelerations at once.

    These are accelerations of the chain or of a wall: the acceleration of a moving wall is an output, and it
    is the acceleration of the points that rest on the wall.
    """
    if is_motion(name):
        return [SECOND]
    # the integral of a belt's speed, which has no name, changes nothing
    return [order for order, quantity in enumerate(determined_quantities(name)) if quantity]
