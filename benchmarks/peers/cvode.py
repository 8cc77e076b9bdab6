"""CVODE from C with the kernel's own functions: the driver of rest.py, see rest_model.py and rest_cvode.c."""

from __future__ import annotations

import numpy as np
import rest_model
from problems import Problem

from peers import Contender, Outcome
from peers.ours import OnInstance


class Cvode(OnInstance):
    """One of its two families of formulas."""

    def __init__(self, problem: Problem, tolerance: float, stop: float, adams: int, careful: int) -> None:
        scene = problem.scene(tolerance)
        super().__init__(scene, stop)
        self.driver = rest_model.driver(len(scene.chain.links))
        self.settings = rest_model.Settings.of(self.instance.record, adams, careful)
        self.times, self.row = np.array([stop]), np.zeros(1, rest_model.COUNTS)

    def run(self) -> int:
        """Once; returns whether it came to the end."""
        self.block[:] = self.fresh
        return rest_model.solve(self.driver, self.address, self.settings, self.times, self.row)

    def outcome(self) -> Outcome:
        """Once more."""
        done, row = self.run(), self.row[0]
        failed = "" if done else f"CVODE's flag {row['flag']}"
        return Outcome(*self.observed(), int(row["steps"]), int(row["rhs"]), failed)


def contenders(problem: Problem, tolerance: float, stop: float, careful: int = 0) -> dict[str, Contender]:
    """Both; careful in sustained contact, see rest_model.py."""
    return {
        f"CVODE {name}": Cvode(problem, tolerance, stop, adams, careful)
        for name, adams in (("Adams", 1), ("BDF", 0))
    }
