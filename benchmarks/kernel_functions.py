"""The kernel's model as C functions for other code, compiled just as the kernel itself is.

What rest_model.py and peers/kernel_model.py have in common: start and stop of a solver whose state lacks the
end of the kernel's (energies, u, time), f(y), what an event does, and the way from such functions to a
library.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from unittest import mock

from chain_impact.kernel.jit import jit
from numba import carray, float64, int32, types

from chain_impact.export import aot, lower
from chain_impact.kernel.advance import apply_events
from chain_impact.kernel.equations import state_rate
from chain_impact.kernel.events import RELATCH, TOUCH
from chain_impact.kernel.initialize import initialize, still

Entries = dict[str, tuple[object, Callable]]
"""C functions: name → (signature, function)."""


@jit
def rate_at(d, y, out):
    """Set the first components of f(y)."""
    state_rate(d, y, d.work.stage[0])
    for j in range(len(y)):
        out[j] = d.work.stage[0, j]


@jit
def happen(d, time, y, found):
    """Let the events found take effect.

    Args:
        d: the instance.
        time: [s].
        y: state.
        found: for each candidate the sign of the change of its clearance, then of what its speed leaves to
            being latched anew; 0 without an event.
    """
    count = len(d.touch.active)
    d.step.end = time
    for j in range(len(y)):
        d.step.state_end[j] = y[j]
    for c in range(count):
        touched = found[c] > 0 if d.touch.active[c] else found[c] < 0
        d.touch.event[c] = TOUCH if touched else RELATCH if found[count + c] < 0 else 0
    apply_events(d)


def start_and_stop(prefix: str, instance: types.Record, left_out: int) -> Entries:
    """Initialize and set the state at 0 s; stand in a state at a time, to be observed.

    Args:
        prefix: of the names.
        instance: its record type.
        left_out: how many components at the end of the kernel's state the other one is without.
    """
    pointer, reals = types.CPointer(instance), types.CPointer(float64)

    def start(p, y):
        d = carray(p, (1,))[0]
        status = initialize(d, 0.0)
        for j in range(len(d.step.state) - left_out):
            y[j] = d.step.state[j]
        return status

    def stop(p, time, y):
        d = carray(p, (1,))[0]
        size = len(d.step.state) - left_out
        for j in range(len(d.step.state)):
            d.work.y[j] = y[j] if j < size else 0.0
        still(d, time, d.work.y)
        return 0

    return {
        f"{prefix}_start": (int32(pointer, reals), start),
        f"{prefix}_stop": (int32(pointer, float64, reals), stop),
    }


def zig(*arguments: object) -> None:
    """Run zig's C compiler for the oldest system that the kernel runs on."""
    target, _ = aot.ZIG_TARGETS[aot.HOST]
    compiler = [sys.executable, "-m", "ziglang", "cc", "-target", target, "-O2", "-Wno-everything"]
    subprocess.run([*compiler, *map(str, arguments)], check=True)


def link(library: Path, ir: Path, stubs: Path) -> None:
    """Make a library of nothing but the functions."""
    zig("-shared", "-s", "-o", library, ir, stubs, "-lm")


def built(
    kind: str,
    links: int,
    candidates: int,
    entry_points: Callable[[types.Record, types.Record], Entries],
    *,
    sources: tuple[Path, ...],
    linked: Callable[[Path, Path, Path], None] = link,
) -> Path:
    """The library of some functions, compiled if it is not cached.

    Args:
        kind: how the file's name begins.
        links: number of links.
        candidates: number of pairs of a contact point and a wall.
        entry_points: the functions for the record types of an instance and its output, as in kernel/entry.py.
        sources: the files that tell, besides this one and the kernel, what is in the library.
        linked: makes a library from the functions in LLVM's language and the stubs that these need.
    """
    parts = b"".join(source.read_bytes() for source in (Path(__file__), *sources))
    folder = aot.cache_folder()
    library = folder / f"{kind}-{links}-{candidates}-{hashlib.sha256(parts).hexdigest()[:12]}.so"
    if not library.exists():
        folder.mkdir(parents=True, exist_ok=True)
        ir, stubs = library.with_suffix(".ll"), library.with_name(f"{library.stem}-stubs.c")
        with mock.patch.object(lower, "entry_points", entry_points):
            ir.write_text(lower.lower(links, candidates))
        stubs.write_text("".join(map(aot.STUB.format, aot.PYTHON_SYMBOLS)))
        fresh = library.with_suffix(f".{os.getpid()}")
        linked(fresh, ir, stubs)
        fresh.replace(library)
    return library
