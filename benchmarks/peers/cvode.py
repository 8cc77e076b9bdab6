"""CVODE from C with the kernel's own functions: the driver of rest.py, see rest_model.py and rest_cvode.c."""

from __future__ import annotations

import ctypes
from functools import cache

import numpy as np
import rest_model
from problems import Problem
from rest import COUNTS, Settings

from peers import Contender, MissingError, Outcome
from peers.ours import OnInstance

BUDGET = 20.0  # s of CPU time


@cache
def driver(links: int, candidates: int) -> ctypes.CDLL:
    """The compiled driver."""
    library = ctypes.CDLL(str(rest_model.driver_library(links, candidates)))
    library.rest_solve.argtypes = [ctypes.c_void_p] * 3 + [ctypes.c_long, ctypes.c_void_p]
    library.rest_solve.restype = ctypes.c_long
    return library


class Cvode(OnInstance):
    """One of its two families of formulas."""

    def __init__(self, problem: Problem, tolerance: float, stop: float, adams: int, careful: int) -> None:
        scene = problem.scene(tolerance)
        super().__init__(scene, stop)
        record = self.instance.record
        candidates = len(record["touch"]["active"])
        self.driver = driver(len(scene.chain.links), candidates)
        self.settings = Settings(len(record["step"]["state"]) - 1, candidates, adams, careful, BUDGET)
        self.times, self.row = np.array([stop]), np.zeros(1, COUNTS)

    def run(self) -> int:
        """Once; returns whether it came to the end."""
        self.block[:] = self.fresh
        pointers = ctypes.byref(self.settings), self.times.ctypes.data, 1, self.row.ctypes.data
        return self.driver.rest_solve(self.address, *pointers)

    def outcome(self) -> Outcome:
        """Once more."""
        done, row = self.run(), self.row[0]
        failed = "" if done else f"CVODE's flag {row['flag']}"
        return Outcome(*self.observed(), int(row["steps"]), int(row["rhs"]), failed)


def contenders(problem: Problem, tolerance: float, stop: float, careful: int = 0) -> dict[str, Contender]:
    """Both; careful in sustained contact, see rest_model.py."""
    try:
        return {
            f"CVODE {name}": Cvode(problem, tolerance, stop, adams, careful)
            for name, adams in (("Adams", 1), ("BDF", 0))
        }
    except rest_model.NoSundialsError as error:
        raise MissingError(str(error)) from error
