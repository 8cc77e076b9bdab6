"""The parts shared by peers that integrate the kernel's own functions, see kernel_model.py."""

from __future__ import annotations

import ctypes

import numpy as np

from benchmarks import kernel_model
from benchmarks.peers import Outcome
from benchmarks.peers.ours import OnInstance
from chain_impact.scene.scene import Scene


class OnKernel(OnInstance):
    """A contender with state, pointers and event handling, whose results the kernel observes."""

    def __init__(self, scene: Scene, stop: float) -> None:
        super().__init__(scene, stop)
        self.tolerance, self.contacts = scene.solver.tolerance, self.instance.record["contacts"]
        self.model = kernel_model.load(len(scene.chain.links))
        self.y = np.zeros(2 * len(scene.chain.links) + 4)
        self.found = np.zeros(2 * self.instance.record["candidate_count"], np.int32)
        self.clock = np.zeros(2)  # time and proposed step [s]
        self.rate, self.least = (
            ctypes.cast(f, ctypes.c_void_p).value for f in (self.model.plain_rate, self.model.plain_least)
        )
        # highest energy [J], largest penetration [m] and largest depth without a contact [m] of the run
        self.seen = np.zeros(3)

    def start(self) -> None:
        """Reset to the start."""
        self.block[:] = self.fresh
        self.seen[:] = -np.inf, 0.0, 0.0
        self.model.plain_start(self.address, self.y.ctypes.data)

    def look(self, states: np.ndarray) -> None:
        """Let the values of states, one in each row, replace smaller numbers in ``seen``."""
        for y in np.ascontiguousarray(states):
            self.model.plain_look(y.ctypes.data, self.seen.ctypes.data, self.address)

    def switch(self, time: float, y: np.ndarray, flight: float = 1.0) -> tuple[float, float]:
        """Let the event near a time take effect; return its exact time [s], and a first step [s] from there.

        Args:
            time: the time at which the solver found the event [s].
            y: the state at this time.
            flight: the largest first step [s] of a flight.
        """
        self.y[:], self.clock[:] = y, (time, flight)
        self.model.plain_switch(
            self.address, self.clock.ctypes.data, self.y.ctypes.data, self.found.ctypes.data
        )
        return float(self.clock[0]), float(self.clock[1])

    def finished(self, steps: int | None, failed: str = "") -> Outcome:
        """Return the outcome of a run that has come to its end, or has ``failed``."""
        rhs = int(self.instance.statistics["rhs_evaluations"])
        self.model.plain_stop(self.address, self.stop, self.y.ctypes.data)
        return Outcome(*self.observed(), steps, rhs, failed)
