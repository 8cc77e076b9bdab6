"""scipy's solve_ivp as an experienced user would use it: compiled functions, terminal events, first steps."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

from benchmarks.peers import Contender, Outcome
from benchmarks.peers.on_kernel import OnKernel
from benchmarks.problems import Problem
from chain_impact.scene.scene import Scene


@njit
def call(function, t, y, address, count):
    """Return the ``count`` numbers that a C function fills for a time and a state."""
    out, contiguous = np.empty(count), np.ascontiguousarray(y)  # columns of a matrix are not contiguous
    function(t, contiguous.ctypes.data, out.ctypes.data, address)
    return out


class Scipy(OnKernel):
    """solve_ivp on a scene, restarted at every event.

    Attributes:
        time: the time that the run has reached, at an event or at its end [s].
        steps: the number of steps so far.
        watch: whether to look at energy and depth after each step (``seen``).
        message: the message of an integrator that gave up; "" otherwise.
        tick: function that is called before each evaluation; it may stop the run. None for no such function.
    """

    def __init__(self, scene: Scene, stop: float, method: str, *, watch: bool = False) -> None:
        super().__init__(scene, stop)
        self.method, self.watch = method, watch
        self.tick: Callable[[], None] | None = None

    def derivative(self, t: float, y: np.ndarray) -> np.ndarray:
        """Return f(t, y)."""
        if self.tick is not None:
            self.tick()
        rate: np.ndarray = call(self.model.plain_rate, t, y, self.address, len(y))
        return rate

    def run(self) -> None:
        """Run to ``stop``."""

        def least(t: float, y: np.ndarray) -> float:
            return float(call(self.model.plain_least, t, y, self.address, 1)[0])

        event: Any = least
        event.terminal, event.direction = True, -1
        self.start()
        self.time, self.steps, self.message = 0.0, 0, ""
        first, flight = None, 1.0
        while self.time < self.stop:
            sol = solve_ivp(
                self.derivative, (self.time, self.stop), self.y, self.method, rtol=self.tolerance,
                atol=self.tolerance, events=event if len(self.found) else None, first_step=first,
            )  # fmt: skip
            self.steps += len(sol.t) - 1
            if self.watch:
                self.look(sol.y.T)
            self.time, self.y[:] = float(sol.t[-1]), sol.y[:, -1]
            if sol.status != 1:
                self.message = "" if sol.status == 0 else sol.message
                break
            if not self.contacts["active_count"] and len(sol.t) > 2:
                flight = sol.t[-2] - sol.t[-3]
            self.time, first = self.switch(self.time, self.y, flight)
            first = min(first, max(self.stop - self.time, 1e-15))

    def outcome(self) -> Outcome:
        """Run once more, and return the outcome."""
        try:
            self.run()
        except (ValueError, RuntimeError) as problem:  # errors of scipy's root finder
            return Outcome(self.y, failed=str(problem))
        return self.finished(self.steps, self.message)


def contenders(problem: Problem, tolerance: float, stop: float) -> dict[str, Contender]:
    """Return the method that needs the least time with impacts."""
    return {"SciPy DOP853": Scipy(problem.scene(tolerance), stop, "DOP853")}
