"""The floating-point registers of x86-64, set from Python as a host program may have set them."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.helpers.tools.zig import zig

USUAL, FLUSH, ROUNDING = 0x1F80, 0x8040, 0x2000
ROUNDINGS = [USUAL + way * ROUNDING for way in range(4)]
WITHOUT_TRAPS = [*ROUNDINGS, *(rounding | FLUSH for rounding in ROUNDINGS)]
# the traps of Fortran's -ffpe-trap=invalid,zero,overflow; a trap for inexact results would end Python itself
TRAPS = USUAL & ~(0x80 | 0x200 | 0x400)
_SOURCE = """unsigned registers(void) { return __builtin_ia32_stmxcsr(); }
void set_registers(unsigned value) { __builtin_ia32_ldmxcsr(value); }
"""


def make_library(folder: Path) -> Path:
    """Compile a library with the functions ``registers`` and ``set_registers``, and return its path."""
    source, library = folder / "registers.c", folder / "registers.so"
    source.write_text(_SOURCE)
    zig(folder, "-shared", "-fPIC", "-Wno-missing-prototypes", source, "-o", library)
    return library


@contextmanager
def registers(library: ctypes.CDLL, value: int) -> Iterator[None]:
    """Set the registers to a value within the context, and check at its end that only flags changed.

    After the context the registers have the value USUAL.
    """
    library.set_registers(value)
    try:
        yield
        now = library.registers() & ~0x3F
    finally:
        library.set_registers(USUAL)
    assert now == value
