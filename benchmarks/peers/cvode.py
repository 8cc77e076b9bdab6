"""SUNDIALS' CVODE, called from C, with the kernel's own functions; it needs libsundials-dev and gcc.

cvode.c calls CVODE. ``cvode_roots`` and ``cvode_weights`` in kernel_model.py explain a careful CVODE.
"""

from __future__ import annotations

import ctypes
import subprocess
from functools import cache
from pathlib import Path

import numpy as np

from benchmarks.kernel_model import CVODE, built, digest
from benchmarks.peers import Contender, MissingError, Outcome
from benchmarks.peers.ours import OnInstance
from benchmarks.problems import Problem
from chain_impact.compilation.cache import get_or_make
from chain_impact.scene.scene import Scene

DRIVER = Path(__file__).with_suffix(".c")
SUNDIALS = ("cvode", "nvecserial", "sunlinsoldense", "sunmatrixdense", "sunnonlinsolfixedpoint")
BUDGET, OVER_BUDGET = 20.0, -100  # [s] largest CPU time of a run; the flag of a run that needs more
COUNTS = np.dtype(
    [(name, np.int64) for name in ("steps", "rejected", "rhs", "jacobians", "restarts", "flag")]
    + [("seconds", np.float64)]
)
"""The type of the structure of counts in cvode.c."""


class Settings(ctypes.Structure):
    """The structure Settings of cvode.c."""

    _fields_ = (
        *((name, ctypes.c_long) for name in ("states", "candidates", "adams", "careful")),
        ("budget", ctypes.c_double),
    )


class Cvode(OnInstance):
    """CVODE with Adams or BDF formulas; ``rows`` has the counts at each of the times."""

    def __init__(
        self, scene: Scene, times: np.ndarray, adams: int, careful: int, budget: float = BUDGET
    ) -> None:
        super().__init__(scene, float(times[-1]))
        self.driver, self.times, self.rows = (
            driver(len(scene.chain.links)),
            times,
            np.zeros(len(times), COUNTS),
        )
        record = self.instance.record
        states = len(record["step"]["state"]) - CVODE
        self.settings = Settings(states, int(record["candidate_count"]), adams, careful, budget)

    def run(self, extremes: np.ndarray | None = None) -> int:
        """Run once; return how many of the times are reached.

        Args:
            extremes: the highest energy [J], the largest penetration [m] and the largest depth without a
                contact [m] at the times replace smaller numbers in it.
        """
        self.block[:] = self.fresh
        times, rows = self.times.ctypes.data, self.rows.ctypes.data
        look = None if extremes is None else extremes.ctypes.data
        reached_count: int = self.driver.cvode_solve(
            self.address, ctypes.byref(self.settings), times, len(self.times), rows, look
        )
        self.rows[reached_count + 1 :] = self.rows[min(reached_count, len(self.rows) - 1)]
        return reached_count

    def outcome(self) -> Outcome:
        """Run once more, and return the outcome."""
        reached_count, row = self.run(), self.rows[-1]
        failed = "" if reached_count == len(self.times) else f"CVODE's flag {row['flag']}"
        return Outcome(*self.observed(), int(row["steps"]), int(row["rhs"]), failed)


@cache
def driver(links: int) -> ctypes.CDLL:
    """Return the library of cvode.c with the model for a number of links, compiled if it is not cached.

    Raises:
        MissingError: when there is no SUNDIALS to compile against.
    """
    model = built(links)
    name = f"cvode-{digest(DRIVER, Path(__file__))}-{model.name}"
    library = ctypes.CDLL(str(get_or_make(name, lambda file: link_driver(file, model))))
    library.cvode_solve.argtypes = [ctypes.c_void_p] * 3 + [ctypes.c_long] + [ctypes.c_void_p] * 2
    library.cvode_solve.restype = ctypes.c_long
    return library


def link_driver(library: Path, model: Path) -> None:
    """Compile the library of the driver by gcc; it loads the model's library."""
    gcc = ["gcc", "-O2", "-fPIC", "-shared", "-Wall", "-Wextra", "-Wl,--no-undefined", "-o", str(library)]
    libraries = [f"-lsundials_{name}" for name in SUNDIALS]
    process = subprocess.run(
        [*gcc, str(DRIVER), str(model), *libraries, "-lm"], capture_output=True, text=True, check=False
    )
    if "cvode/cvode.h" in process.stderr or "-lsundials" in process.stderr:
        raise MissingError("SUNDIALS is not installed: on Debian `apt-get install libsundials-dev`")
    if process.returncode != 0 or process.stderr:
        raise RuntimeError(process.stderr)


def contenders(problem: Problem, tolerance: float, stop: float) -> dict[str, Contender]:
    """Return CVODE with the formulas that need the least time with impacts."""
    return {"CVODE Adams": Cvode(problem.scene(tolerance), np.array([stop]), adams=1, careful=0)}
