"""The C functions of a kernel.

    int32 initialize(instance*, double time)
    int32 advance(instance*, double time)
    int32 advance_awhile(instance*, double time)
    int32 observe(instance*)
    int32 sound(instance*)
    int32 follow(instance*)
    int64 trajectory(instance*, const double* times, int64 rows, output* out)
    int64 run_each(instance*, const instance* start, const int64* places, int64 parameters,
                   const double* values, const double* stops, int64 runs, const int64* looks, int64 columns,
                   double* rows, int32 going_on)

What they do, kernel/entry.py tells.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import float64, int32, int64, types

from chain_impact.compilation import functions  # noqa: F401 - so that numba takes the kernel's functions
from chain_impact.compilation.record_type import INSTANCE, matrix, vector, words
from chain_impact.kernel import entry
from chain_impact.kernel.events.contact_log import follow_to_now
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.soundness import sound

Entries = dict[str, tuple[Any, Callable[..., Any]]]
"""C functions: name → (signature, function)."""


def follow(d):
    """Follow the contacts up to the communication point."""
    follow_to_now(d)
    return 0


def trajectory(d, times, count, out):
    """Fill rows of outputs; return how many."""
    output = words(d.output)
    return entry.trajectory(d, vector(times, count), output, matrix(out, count, len(output)))


def run_each(  # noqa: PLR0917 - in C, arguments have no names
    d, start, places, parameters, values, stops, runs, looks, columns, rows, going_on
):
    """Run again and again with other parameters; return how many runs are done."""
    instance = words(d)
    return entry.run_each(
        d,
        instance,
        vector(start, len(instance)),
        vector(places, parameters),
        matrix(values, runs, parameters),
        vector(stops, runs),
        vector(looks, columns),
        matrix(rows, runs, entry.PEAKS + columns),
        going_on,
    )


def entry_points() -> Entries:
    """Those of the kernel."""
    reals, indices = types.CPointer(float64), types.CPointer(int64)
    runs = (INSTANCE, reals, indices, int64, reals, reals, int64, indices, int64, reals, int32)
    return {
        "initialize": (int32(INSTANCE, float64), initialize),
        "advance": (int32(INSTANCE, float64), entry.advance_to),
        "advance_awhile": (int32(INSTANCE, float64), entry.advance_awhile),
        "observe": (int32(INSTANCE), entry.observe_now),
        "sound": (int32(INSTANCE), sound),
        "follow": (int32(INSTANCE), follow),
        "trajectory": (int64(INSTANCE, reals, int64, reals), trajectory),
        "run_each": (int64(*runs), run_each),
    }
