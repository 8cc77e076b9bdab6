"""The kernel's right-hand side many times in a row, compiled just as the kernel is.

rhs.py and run_share.py time it as the C function ``int32 loop_rates(instance*, int64 calls)``.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache

from functions_library import built
from numba import int32, int64

from chain_impact.compilation.entry_points import Entries
from chain_impact.compilation.record_type import INSTANCE
from chain_impact.kernel.model.equations import state_rate


def rates(d, calls):
    """Right-hand sides in a row, from the start of a step; the last one is left in ``work.stage[1]``."""
    y, rate = d.work.y, d.work.stage[1]
    for j in range(len(y)):
        y[j] = d.step.state[j]
    for _ in range(calls):
        state_rate(d, y, rate)
        # each depends on the last one, as the stages of a step do
        for j in range(len(y)):
            y[j] += 1e-30 * rate[j]
    return 0


def entry_points() -> Entries:
    """The C function."""
    return {"loop_rates": (int32(INSTANCE, int64), rates)}


@cache
def kernel_rates(links: int) -> Callable[[int, int], int]:
    """``loop_rates`` for a number of links, compiled if it is not cached; it takes the instance's address."""
    function = ctypes.CDLL(str(built("rhs_loop", links))).loop_rates
    function.argtypes = [ctypes.c_void_p, ctypes.c_int64]
    return function
