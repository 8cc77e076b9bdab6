"""The kernel's model for C functions that other code calls.

What rest_model.py and peers/kernel_model.py have in common: start and stop of a solver whose state lacks the
end of the kernel's (energies, u, time), f(y), and what an event does.
"""

from __future__ import annotations

from numba import float64, int32, types

from chain_impact.compilation.entry_points import Entries
from chain_impact.compilation.functions import compiled
from chain_impact.compilation.record_type import INSTANCE
from chain_impact.kernel.events.marks import END, NONE, ONSET, RELATCH
from chain_impact.kernel.events.table import apply_events
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.integration.last_step import reset_step
from chain_impact.kernel.model.equations import state_rate

REALS = types.CPointer(float64)


@compiled
def rate_at(d, y, out):
    """Set the first components of f(y)."""
    state_rate(d, y, d.work.stage[0])
    for j in range(len(y)):
        out[j] = d.work.stage[0, j]


@compiled
def happen(d, time, y, found):
    """Let the events found take effect.

    Args:
        d: the instance.
        time: [s].
        y: state.
        found: for each candidate the sign of the change of its clearance, then of what its speed leaves to
            being latched anew; 0 without an event.
    """
    d.step.end = time
    for j in range(len(y)):
        d.step.state_end[j] = y[j]
    for c in range(d.candidates):
        kind = RELATCH if found[d.candidates + c] < 0 else NONE
        if d.touch.active[c] and found[c] > 0:
            kind = END
        elif not d.touch.active[c] and found[c] < 0:
            kind = ONSET
        d.touch.event[c] = kind
    apply_events(d)


def start_and_stop(prefix: str, left_out: int) -> Entries:
    """Initialize and set the state at 0 s; stand in a state at a time, to be observed.

    Args:
        prefix: of the names.
        left_out: how many components at the end of the kernel's state the other one is without.
    """

    def start(d, y):
        status = initialize(d, 0.0)
        for j in range(len(d.step.state) - left_out):
            y[j] = d.step.state[j]
        return status

    def stop(d, time, y):
        size = len(d.step.state) - left_out
        for j in range(len(d.step.state)):
            d.work.y[j] = y[j] if j < size else 0.0
        reset_step(d, time, d.work.y)
        return 0

    return {
        f"{prefix}_start": (int32(INSTANCE, REALS), start),
        f"{prefix}_stop": (int32(INSTANCE, float64, REALS), stop),
    }
