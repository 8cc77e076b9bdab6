"""CVODE from C with the kernel's own functions: the driver of rest.py, see rest_model.py and rest_cvode.c."""

from __future__ import annotations

import ctypes

import numpy as np
import rest_model
from problems import Problem
from rest import COUNTS, Settings

from peers import Contender, MissingError, Outcome
from peers.ours import OnInstance

BUDGET = 20.0  # s of CPU time


class Cvode(OnInstance):
    """One of its two families of formulas."""

    def __init__(self, problem: Problem, tolerance: float, stop: float, adams: int, careful: int) -> None:
        scene = problem.scene(tolerance)
        super().__init__(scene, stop)
        record = self.instance.record
        states = len(record["step"]["state"]) - rest_model.LEFT_OUT
        candidates = int(record["candidates"])
        self.driver = rest_model.driver(len(scene.chain.links))
        self.settings = Settings(states, candidates, adams, careful, BUDGET)
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
