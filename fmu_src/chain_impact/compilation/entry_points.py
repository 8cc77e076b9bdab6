"""The C functions of a kernel in numba's types; signatures.py has their signatures.

In a kernel that carries derivatives, these functions also advance the tangent instances, records of dual
numbers after the instance in memory: they call hooks, C functions that are linked to the kernel
(kernel/hooks.py, kernel/tangent/entry.py).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import float64, int32, int64, types

from chain_impact.compilation.functions import HOOK_SIGNATURES
from chain_impact.compilation.record_type import INSTANCE, matrix, vector
from chain_impact.compilation.signatures import SIGNATURES, Signature
from chain_impact.kernel import entry, hooks
from chain_impact.kernel.advance import advance_to_onset, event_update
from chain_impact.kernel.entry import is_sound
from chain_impact.kernel.events.contact_log import update_to_communication_point
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.tangent.duals import as_words
from chain_impact.kernel.tangent.entry import HOOKS

_HOOKS: dict[Any, Any] = HOOKS
_TYPES = {
    **{"int32": int32, "int64": int64, "double": float64, "record*": INSTANCE},
    **{"double*": types.CPointer(float64), "int64*": types.CPointer(int64)},
}
Entries = dict[str, tuple[Any, Callable[..., Any]]]
"""Name of a C function → (its signature in numba's types, the Python function that numba lowers)."""


def log_contacts(d):
    """Add the contacts that last at the communication point to the list of contacts, after the ended ones.

    Before this, the last step of the solver is ended at the communication point. Return 0.
    """
    update_to_communication_point(d)
    return 0


def record_words(d):
    """Return the number of words of 8 bytes of an instance and of the tangent instances after it."""
    return len(as_words(d)) + hooks.tangent_words(d)


def trajectory(d, times, count, spans, span_count, rows, columns, of_state):  # noqa: PLR0917
    """Advance to each of the times [s], and fill a row for each with the numbers of the record in ``spans``.

    Return the number of filled rows; kernel/entry.py describes the arguments.
    """
    wanted_spans, filled_rows = matrix(spans, span_count, 2), matrix(rows, count, columns)
    return entry.trajectory(d, as_words(d), vector(times, count), wanted_spans, filled_rows, of_state)


def run_each(  # noqa: PLR0917 - in C, arguments have no names
    d, indices, parameters, values, end_times, runs, output_indices, columns, rows, continuing
):
    """Run from the start once for each row of parameters, and fill a row of outputs at the end of each run.

    If ``continuing`` is 1, the run of the first row goes on from the present state. Return the number of runs
    that have ended, also by a fault; it is below ``runs`` after about a second of computing. kernel/entry.py
    describes the arguments.
    """
    return entry.run_each(
        d,
        as_words(d),
        vector(indices, parameters),
        matrix(values, runs, parameters),
        vector(end_times, runs),
        vector(output_indices, columns),
        matrix(rows, runs, columns),
        continuing,
    )


def hook_entries() -> Entries:
    """Return the C functions that replace those of kernel/hooks.py, and carry derivatives."""
    return {hook.__name__: (kind, _HOOKS[hook]) for hook, kind in HOOK_SIGNATURES.items()}


def entry_points() -> Entries:
    """Return the C functions of the kernel, in the order of SIGNATURES."""
    functions: dict[str, Callable[..., Any]] = {
        "initialize": initialize,
        "advance_to": entry.advance_to,
        "advance_awhile": entry.advance_awhile,
        "advance_to_onset": advance_to_onset,
        "event_update": event_update,
        "observe_now": entry.observe_now,
        "is_sound": is_sound,
        "log_contacts": log_contacts,
        # the C interface calls this function to check the size of a record that it reads from a file
        "record_words": record_words,
        "trajectory": trajectory,
        "run_each": run_each,
    }
    return {name: (_function_type(signature), functions[name]) for name, signature in SIGNATURES.items()}


def _function_type(signature: Signature) -> Any:
    """Return numba's type for a function with a signature."""
    return _TYPES[signature.result](*(_TYPES[kind] for kind in signature.arguments.values()))
