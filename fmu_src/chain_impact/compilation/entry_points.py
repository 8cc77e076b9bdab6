"""The C functions of a kernel.

    int32 initialize(instance*, double time)
    int32 advance(instance*, double time)
    int32 advance_awhile(instance*, double time)
    int32 advance_to_onset(instance*, double time)
    int32 event_update(instance*)
    int32 observe(instance*)
    int32 sound(instance*)
    int32 follow(instance*)
    int64 record_words(instance*)
    int64 trajectory(instance*, const double* times, int64 count, const int64* spans, int64 span_count,
                     double* rows, int64 columns, int32 of_state)
    int64 run_each(instance*, const int64* places, int64 parameters, const double* values,
                   const double* stops, int64 runs, const int64* output_indices, int64 columns,
                   double* rows, int32 continuing)

kernel/entry.py and kernel/advance.py describe these functions. In a kernel that carries derivatives, the
functions also advance the tangent instances, records of dual numbers that follow the instance in memory: the
kernel calls the hooks, which are C functions, too, and are linked to the kernel (kernel/hooks.py,
kernel/tangent/entry.py).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import float64, int32, int64, types

from chain_impact.compilation.functions import HOOK_SIGNATURES
from chain_impact.compilation.record_type import INSTANCE, matrix, vector
from chain_impact.kernel import entry, hooks
from chain_impact.kernel.advance import advance_to_onset, event_update
from chain_impact.kernel.entry import sound
from chain_impact.kernel.events.contact_log import update_to_output_time
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.tangent.duals import words
from chain_impact.kernel.tangent.entry import HOOKS

_HOOKS: dict[Any, Any] = HOOKS
Entries = dict[str, tuple[Any, Callable[..., Any]]]
"""C functions: name → (signature, function)."""


def follow(d):
    """Update the contacts to the communication point, and write the active contacts to the log.

    In the log, the active contacts follow the finished contacts.
    """
    update_to_output_time(d)
    return 0


def record_words(d):
    """Return the number of words of 8 bytes in the record of an instance and in the data after the record."""
    return len(words(d)) + hooks.words_behind(d)


def trajectory(d, times, count, spans, span_count, rows, columns, of_state):  # noqa: PLR0917
    """Fill rows with numbers of the record, and return the number of filled rows."""
    wanted, filled = matrix(spans, span_count, 2), matrix(rows, count, columns)
    return entry.trajectory(d, words(d), vector(times, count), wanted, filled, of_state)


def run_each(  # noqa: PLR0917 - in C, arguments have no names
    d, places, parameters, values, stops, runs, output_indices, columns, rows, continuing
):
    """Run repeatedly with different parameters, and return the number of finished runs."""
    return entry.run_each(
        d,
        words(d),
        vector(places, parameters),
        matrix(values, runs, parameters),
        vector(stops, runs),
        vector(output_indices, columns),
        matrix(rows, runs, columns),
        continuing,
    )


def hook_entries() -> Entries:
    """Return the hooks that carry derivatives, as C functions."""
    return {hook.__name__: (kind, _HOOKS[hook]) for hook, kind in HOOK_SIGNATURES.items()}


def entry_points() -> Entries:
    """Return the C functions of the kernel."""
    reals, indices = types.CPointer(float64), types.CPointer(int64)
    runs = (INSTANCE, indices, int64, reals, reals, int64, indices, int64, reals, int32)
    return {
        "initialize": (int32(INSTANCE, float64), initialize),
        "advance": (int32(INSTANCE, float64), entry.advance_to),
        "advance_awhile": (int32(INSTANCE, float64), entry.advance_awhile),
        "advance_to_onset": (int32(INSTANCE, float64), advance_to_onset),
        "event_update": (int32(INSTANCE), event_update),
        "observe": (int32(INSTANCE), entry.observe_now),
        "sound": (int32(INSTANCE), sound),
        "follow": (int32(INSTANCE), follow),
        "trajectory": (int64(INSTANCE, reals, int64, indices, int64, reals, int64, int32), trajectory),
        "run_each": (int64(*runs), run_each),
        # the C interface calls this function to check the size of a record that it reads from a file
        "record_words": (int64(INSTANCE), record_words),
    }
