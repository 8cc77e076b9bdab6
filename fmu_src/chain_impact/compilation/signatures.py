"""The table of the signatures of a kernel's C functions.

numba's types (entry_points.py), the declarations for ctypes, and those for the C interface of FMUs follow
from the table. kernel/entry.py, kernel/advance.py and entry_points.py describe the functions.
"""

from __future__ import annotations

import ctypes
import re
import textwrap
from typing import Any, NamedTuple

_TABLE = """
int32 initialize(record* d, double time)
int32 advance_to(record* d, double time)
int32 advance_awhile(record* d, double time)
int32 advance_to_onset(record* d, double time)
int32 event_update(record* d)
int32 observe_now(record* d)
int32 is_sound(record* d)
int32 log_contacts(record* d)
int64 record_words(record* d)
int64 trajectory(record* d, double* times, int64 count, int64* spans, int64 span_count, double* rows,
                 int64 columns, int32 of_state)
int64 run_each(record* d, int64* indices, int64 parameters, double* values, double* end_times, int64 runs,
               int64* output_indices, int64 columns, double* rows, int32 continuing)
"""


class Signature(NamedTuple):
    """The type of the result of a C function, and its arguments: name → type, in the words of _TABLE."""

    result: str
    arguments: dict[str, str]


def _signature(result: str, arguments: str) -> Signature:
    pairs = (argument.split() for argument in arguments.split(","))
    return Signature(result, {name: kind for kind, name in pairs})


SIGNATURES = {
    name: _signature(result, arguments)
    for result, name, arguments in re.findall(r"(\w+) (\w+)\((.*?)\)", _TABLE, re.DOTALL)
}
"""Name of each C function of a kernel → its signature."""
HEADER_WIDTH = 110  # largest number of characters of a line in the C header
_TYPES_OF_CTYPES = {"int32": ctypes.c_int32, "int64": ctypes.c_int64, "double": ctypes.c_double}
_TYPES_OF_C = {"int32": "int32_t ", "int64": "int64_t ", "double": "double "}
_TYPES_OF_C |= {"record*": "Word *", "double*": "double *", "int64*": "int64_t *"}


def declare(library: Any) -> None:
    """Declare the functions of a library that ctypes has loaded; callers give an address for a pointer."""
    for name, (result, arguments) in SIGNATURES.items():
        function = getattr(library, name)
        function.restype = _TYPES_OF_CTYPES[result]
        function.argtypes = [_TYPES_OF_CTYPES.get(kind, ctypes.c_void_p) for kind in arguments.values()]


def declarations() -> str:
    """Return the C declarations of a kernel's functions; ``Word`` is the C type of a number in a record."""
    lines = []
    for name, (result, arguments) in SIGNATURES.items():
        parameters_code = ", ".join(f"{_TYPES_OF_C[kind]}{argument}" for argument, kind in arguments.items())
        line = f"extern {_TYPES_OF_C[result]}{name}({parameters_code});"
        lines += textwrap.wrap(line, HEADER_WIDTH, subsequent_indent="    ")
    return "\n".join(lines)
