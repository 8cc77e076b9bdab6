"""The kernel's model as C functions for other code, compiled just as the kernel itself is.

What rest_model.py and peers/kernel_model.py have in common: start and stop of a solver whose state lacks the
end of the kernel's (energies, u, time), f(y), what an event does, and the way from such functions to a
library.
"""

from __future__ import annotations

import hashlib
import subprocess
import sys
from pathlib import Path

from numba import float64, int32, types

from chain_impact.compilation import compilers, ready
from chain_impact.compilation.cache import made
from chain_impact.compilation.entry_points import Entries
from chain_impact.compilation.functions import compiled
from chain_impact.compilation.record_type import INSTANCE
from chain_impact.kernel.events.kinds import END, NONE, ONSET, RELATCH
from chain_impact.kernel.events.table import apply_events
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.integration.last_step import reset_step
from chain_impact.kernel.model.equations import state_rate

HERE = Path(__file__).parent
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


def digest(*sources: Path) -> str:
    """Hexadecimal digits that change with the content of the files."""
    return hashlib.sha256(b"".join(source.read_bytes() for source in sources)).hexdigest()[:12]


def built(module: str, links: int, *sources: Path) -> Path:
    """The library of the C functions of a module of this folder, compiled if it is not cached.

    Args:
        module: its name; its ``entry_points()`` are the functions, as in compilation/entry_points.py.
        links: number of links.
        sources: the files that tell, besides the module, this one and the kernel, what is in the library.
    """
    own, program = HERE.joinpath(*module.split(".")).with_suffix(".py"), HERE / "lower_functions.py"
    name, exact = f"{module}-{digest(Path(__file__), own, program, *sources)}", ready.exact(links)

    def lower(file: Path) -> None:
        subprocess.run([sys.executable, str(program), module, str(file)], check=True)

    def link(library: Path) -> None:
        functions = library.with_name("functions.ll")
        functions.write_text(compilers.complete(made(f"{name}.ll", lower).read_text(), exact, with_law=False))
        compilers.prepare_zig(compilers.HOST)
        # without the C interface of FMUs, which calls the kernel
        compilers._zig(compilers.HOST, library, functions)

    return made(f"{name}-{exact or 'any'}.so", link)
