"""numbalsoda (DOP853 in Fortran), driven by compiled code, on the kernel's own functions.

It finds events itself, to 1e-8 s; the rest is made up for in kernel_model.switch.
"""

from __future__ import annotations

import ctypes

import numpy as np
from numba import njit
from numbalsoda import solve_ivp
from problems import Problem

from peers import Contender, Outcome, kernel_model
from peers.ours import OnInstance


@njit
def run_dop853(rate, least, switch, address, y, found, stop, tolerance, grid):  # noqa: PLR0917
    """From y at 0 s to ``stop``; returns the number of steps, −1 on failure."""
    t, first, steps = 0.0, 0.0, 0
    clock = np.zeros(2)
    while t < stop:
        done = solve_ivp(
            rate, np.array([t, stop]), y, grid, "DOP853", 0 if len(found) == 0 else 1, least, address,
            min(first, stop - t), 0.0, tolerance, tolerance,
        )  # fmt: skip
        if not done.success:
            return -1
        steps += len(done.t) - 1
        if not done.event_found:
            y[:] = done.y[-1]
            return steps
        t = done.t_event
        y[:] = done.y_event
        clock[0], clock[1] = t, 1.0
        switch(address, clock.ctypes.data, y.ctypes.data, found.ctypes.data)
        t, first = clock[0], clock[1]
    return steps


class OnKernel(OnInstance):
    """A solver on the kernel's functions: state, pointers, and the way back to what can be observed."""

    def __init__(self, problem: Problem, tolerance: float, stop: float) -> None:
        scene = problem.scene(tolerance)
        super().__init__(scene, stop)
        self.tolerance = tolerance
        self.model = kernel_model.load(len(scene.chain.links))
        self.y = np.zeros(2 * len(scene.chain.links) + 4)
        self.found = np.zeros(2 * self.instance.record["candidates"], np.int32)
        self.rate, self.least = (
            ctypes.cast(f, ctypes.c_void_p).value for f in (self.model.peer_rate, self.model.peer_least)
        )

    def start(self) -> None:
        """Back to the start."""
        self.block[:] = self.fresh
        self.model.peer_start(self.address, self.y.ctypes.data)

    def finished(self, steps: int | None, failed: str) -> Outcome:
        """What came out."""
        rhs = self.instance.statistics["rhs_evaluations"]
        self.model.peer_stop(self.address, self.stop, self.y.ctypes.data)
        return Outcome(*self.observed(), steps, rhs, failed)


class Dop853(OnKernel):
    """``numbalsoda.solve_ivp``."""

    def run(self, *, keep_steps: bool = False) -> int:
        """Once; steps are kept to be counted, at some cost."""
        self.start()
        grid = np.array([] if keep_steps else [self.stop], np.float64)
        return run_dop853(
            self.rate, self.least, self.model.peer_switch, self.address, self.y, self.found, self.stop,
            self.tolerance, grid,
        )  # fmt: skip

    def outcome(self) -> Outcome:
        """Once more."""
        steps = self.run(keep_steps=True)
        return self.finished(steps, "gave up" if steps < 0 else "")


def contenders(problem: Problem, tolerance: float, stop: float) -> dict[str, Contender]:
    """One."""
    return {"numbalsoda DOP853": Dop853(problem, tolerance, stop)}
