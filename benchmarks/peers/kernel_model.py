"""The kernel's own right-hand side and events as C functions, for solvers that take pointers to such.

Compiled by numba and linked just as the kernel is, on the same record; so these solvers evaluate the very
machine code that ours does. Their state is the kernel's without energies, u and time, which drive nothing.

    int32 peer_start(instance*, double* y)                        initialize; the state at 0 s
    void  peer_rate(double t, const double* y, double* rate, instance*)
    void  peer_least(double t, const double* y, double* value, instance*)
    int32 peer_switch(instance*, double* clock, double* y, int32* found)
    int32 peer_stop(instance*, double t, const double* y)         stand there, to be observed
"""

from __future__ import annotations

import ctypes
from functools import cache

import numpy as np
from functions_library import HERE, built
from kernel_functions import REALS, happen, rate_at, start_and_stop
from numba import float64, int32, types, void

from chain_impact.compilation.entry_points import Entries
from chain_impact.compilation.functions import compiled
from chain_impact.compilation.record_type import INSTANCE, vector
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.events.exclusion import RELATCH_RATIO
from chain_impact.kernel.model.equations import state_rate
from chain_impact.kernel.model.geometry import clearance
from peers.model import AT_ZERO, CLEAR, HOP

POLISH = 1e-7  # s, how far a solver's root may be corrected
LEFT_OUT = 4  # of the kernel's state


@compiled
def least_event(d, y):
    """The smallest of all event functions, and its rate where it is a clearance."""
    lowest, slope = np.inf, 0.0
    locate_points(d, y)
    for c in range(d.candidates):
        gap, gap_rate = clearance(d, c)
        sign = -1.0 if d.touch.active[c] else 1.0
        if sign * gap < lowest:
            lowest, slope = sign * gap, sign * gap_rate
        fast = RELATCH_RATIO * d.touch.impact_speed[c] + gap_rate
        if d.touch.active[c] and fast < lowest:
            lowest, slope = fast, 0.0
    return lowest + CLEAR, slope


def switch(d, clock, values, found):
    """Let the event at clock[0] [s] take effect, and propose a next step in clock[1] [s].

    A root finder with a coarse tolerance in time is helped: the last part to the root is gone by f(y).
    Returns the number of active contacts.
    """
    y = vector(values, len(d.step.state) - LEFT_OUT)
    value, slope = least_event(d, y)
    if slope < 0.0 and abs(value) < -slope * POLISH:
        dt = -value / slope
        state_rate(d, y, d.work.stage[0])
        for j in range(len(y)):
            y[j] += dt * d.work.stage[0, j]
        clock[0] += dt
    hop = np.inf
    locate_points(d, y)
    for c in range(d.candidates):
        gap, gap_rate = clearance(d, c)
        active = d.touch.active[c]
        sign = -1.0 if active else 1.0
        falls = sign * gap_rate < 0.0 and sign * gap <= -sign * gap_rate * AT_ZERO + 1e-15
        found[c] = (1 if active else -1) if falls else 0
        fast = active and -gap_rate >= RELATCH_RATIO * d.touch.impact_speed[c] * (1.0 - 1e-9)
        found[d.candidates + c] = -1 if fast and not falls else 0
        if falls:
            hop = min(hop, abs(gap_rate) * HOP / 9.81)
    d.step.next_size = clock[1]
    happen(d, clock[0], y, found)
    clock[1] = min(clock[1], hop) if d.touch.active_count == 0 else d.step.next_size
    return d.touch.active_count


def rate(_t, y, out, d):
    """f(y)."""
    d.statistics.rhs_evaluations += 1
    rate_at(d, vector(y, len(d.step.state) - LEFT_OUT), out)


def least(_t, y, out, d):
    """The least event function."""
    out[0], _ = least_event(d, vector(y, len(d.step.state) - LEFT_OUT))


def entry_points() -> Entries:
    """The C functions."""
    function = void(float64, REALS, REALS, INSTANCE)
    return start_and_stop("peer", LEFT_OUT) | {
        "peer_rate": (function, rate),
        "peer_least": (function, least),
        "peer_switch": (int32(INSTANCE, REALS, REALS, types.CPointer(int32)), switch),
    }


@cache
def load(links: int) -> ctypes.CDLL:
    """The library, compiled if it is not cached."""
    model = ctypes.CDLL(str(built("peers.kernel_model", links, HERE / "peers" / "model.py")))
    pointer = ctypes.c_void_p
    model.peer_start.argtypes = [pointer] * 2
    model.peer_rate.argtypes = model.peer_least.argtypes = [ctypes.c_double, *[pointer] * 3]
    model.peer_rate.restype = model.peer_least.restype = None
    model.peer_switch.argtypes = [pointer] * 4
    model.peer_stop.argtypes = [pointer, ctypes.c_double, pointer]
    return model
