"""The kernel's model as C functions for another solver, compiled just as the kernel itself is.

What CVODE in rest_cvode.c is given is the very right-hand side, latching, release and re-latch of the kernel,
on the same record. Its state vector is the kernel's without the energy supplied by inputs, which is zero.

    int32 rest_start(instance*, double* y)              initialize; the state at 0 s
    int32 rest_rate(instance*, const double* y, double* rate)
    int32 rest_roots(instance*, int32 careful, const double* y, double* value)
    int32 rest_happen(instance*, double time, const double* y, const int32* found)
    int32 rest_weights(instance*, int32 careful, const double* y, double* weight)
    int32 rest_stop(instance*, double time, const double* y)    stand there, to be observed
"""

from __future__ import annotations

import ctypes
import subprocess
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from functions_library import HERE, built, digest
from kernel_functions import REALS, happen, rate_at, start_and_stop
from numba import float64, int32, types
from peers import MissingError

from chain_impact.compilation.cache import made
from chain_impact.compilation.entry_points import Entries
from chain_impact.compilation.functions import compiled
from chain_impact.compilation.record_type import INSTANCE, vector
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.events.exclusion import RELATCH_RATIO
from chain_impact.kernel.model.geometry import clearance

DRIVER = HERE / "rest_cvode.c"
LEFT_OUT = 3  # of the kernel's state
SUNDIALS = ("cvode", "nvecserial", "sunlinsoldense", "sunmatrixdense", "sunnonlinsolfixedpoint")
BUDGET = 20.0  # s of CPU time for a run
POSITION_ERROR = 1e-2  # of the static penetration: what the position may err by while in contact …
MARGIN = 5e-2  # … and how far above the wall a contact ends


COUNTS = np.dtype(
    [(name, np.int64) for name in ("steps", "rejected", "rhs", "jacobians", "restarts", "flag")]
    + [("seconds", np.float64)]
)
"""See rest_cvode.c."""


class Settings(ctypes.Structure):
    """See rest_cvode.c."""

    _fields_ = (
        *((name, ctypes.c_long) for name in ("states", "candidates", "adams", "careful")),
        ("budget", ctypes.c_double),
    )

    @classmethod
    def of(cls, record: Any, adams: int, careful: int) -> Settings:
        """Those for an instance."""
        states = len(record["step"]["state"]) - LEFT_OUT
        return cls(states, int(record["candidates"]), adams, careful, BUDGET)


@compiled
def static_depth(d):
    """Penetration [m] under the weight of one link."""
    weight = abs(d.model.gravity[1]) * d.model.mass[0]
    return (weight / d.law.stiffness[0]) ** (1.0 / d.law.exponent[0])


def rate(d, y, out):
    """f(y)."""
    rate_at(d, vector(y, len(d.step.state) - LEFT_OUT), out)
    return 0


def happens(d, time, y, found):
    """Let the events found take effect."""
    happen(d, time, vector(y, len(d.step.state) - LEFT_OUT), found)
    return 0


def roots(d, careful, y, value):
    """For each candidate its clearance, and how far an active one is from being latched anew.

    CVODE's solution jumps by a part of its tolerance when it starts anew. So a point that leaves slowly is
    seen to arrive and leave again, up to a million times over, unless the contact ends a margin above the
    wall. There is no force up there.
    """
    margin = MARGIN * static_depth(d) if careful else 0.0
    locate_points(d, vector(y, len(d.step.state) - LEFT_OUT))
    for c in range(d.candidates):
        gap, gap_rate = clearance(d, c)
        active = d.touch.active[c]
        value[c] = gap - margin if active else gap
        # δ̇ = −ġ
        value[d.candidates + c] = RELATCH_RATIO * d.touch.impact_speed[c] + gap_rate if active else 1.0
    return 0


def weights(d, careful, y, weight):
    """One over the error allowed in each component.

    As users have it: tolerance × (|y| + scale), the scale that of the kernel. Careful: positions without the
    relative part, and while a contact is active no more than a part of the static penetration.
    """
    n = d.links
    tolerance = d.solver.tolerance
    position = tolerance * d.model.size
    if careful and d.touch.active_count > 0:
        position = min(position, POSITION_ERROR * static_depth(d))
    for j in range(2 * n + 5):
        if j < n + 2:
            allowed = position if j < 2 else position / d.model.size
            if not careful:
                allowed += tolerance * abs(y[j])
        else:
            scale = d.model.size if j < n + 4 else 1.0 if j < 2 * n + 4 else d.model.energy
            allowed = tolerance * (scale + abs(y[j]))
        weight[j] = 1.0 / allowed
    return 0


def entry_points() -> Entries:
    """The C functions."""
    return start_and_stop("rest", LEFT_OUT) | {
        "rest_rate": (int32(INSTANCE, REALS, REALS), rate),
        "rest_roots": (int32(INSTANCE, int32, REALS, REALS), roots),
        "rest_happen": (int32(INSTANCE, float64, REALS, types.CPointer(int32)), happens),
        "rest_weights": (int32(INSTANCE, int32, REALS, REALS), weights),
    }


def link_driver(library: Path, model: Path) -> None:
    """Make the library of the driver, which loads that of the model: by gcc, as SUNDIALS was compiled."""
    gcc = ["gcc", "-O2", "-fPIC", "-shared", "-Wall", "-Wextra", "-Wl,--no-undefined", "-o", str(library)]
    libraries = [f"-lsundials_{name}" for name in SUNDIALS]
    done = subprocess.run(
        [*gcc, str(DRIVER), str(model), *libraries, "-lm"], capture_output=True, text=True, check=False
    )
    if "cvode/cvode.h" in done.stderr or "-lsundials" in done.stderr:
        raise MissingError("SUNDIALS is not installed: on Debian `apt-get install libsundials-dev`")
    if done.returncode != 0 or done.stderr:
        raise RuntimeError(done.stderr)


def solve(driver: ctypes.CDLL, address: int, settings: Settings, times: np.ndarray, rows: np.ndarray) -> int:
    """Run CVODE on an instance; fill the ``COUNTS`` at each time [s], and return how many are reached."""
    pointers = ctypes.byref(settings), times.ctypes.data, len(times), rows.ctypes.data
    return driver.rest_solve(address, *pointers)


@cache
def driver(links: int) -> ctypes.CDLL:
    """The library of rest_cvode.c, with the model for so many links, compiled if it is not cached.

    Raises:
        MissingError: when there is no SUNDIALS to compile against.
    """
    model = built("rest_model", links)
    name = f"rest_cvode-{digest(DRIVER, Path(__file__))}-{model.name}"
    library = ctypes.CDLL(str(made(name, lambda file: link_driver(file, model))))
    library.rest_solve.argtypes = [ctypes.c_void_p] * 3 + [ctypes.c_long, ctypes.c_void_p]
    library.rest_solve.restype = ctypes.c_long
    return library
