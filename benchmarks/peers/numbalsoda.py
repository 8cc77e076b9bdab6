"""numbalsoda (DOP853 in Fortran), driven by compiled code.

The solver locates events within 1e-8 s; kernel_model.switch corrects the remaining difference.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numbalsoda import solve_ivp

from benchmarks.peers import Contender, Outcome
from benchmarks.peers.on_kernel import OnKernel
from benchmarks.problems import Problem


@njit
def run_dop853(rate, least, switch, address, y, found, stop, tolerance, grid):  # noqa: PLR0917
    """Integrate from y at 0 s to ``stop``; return the number of steps, −1 on failure."""
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


class Dop853(OnKernel):
    """The function ``numbalsoda.solve_ivp`` as a contender."""

    def run(self, *, keep_steps: bool = False) -> int:
        """Run once; return the number of steps, −1 on failure.

        The number is right only with ``keep_steps``, which costs time.
        """
        self.start()
        grid = np.array([] if keep_steps else [self.stop], np.float64)
        steps: int = run_dop853(
            self.rate, self.least, self.model.plain_switch, self.address, self.y, self.found, self.stop,
            self.tolerance, grid,
        )  # fmt: skip
        return steps

    def outcome(self) -> Outcome:
        """Run once more, and return the outcome."""
        steps = self.run(keep_steps=True)
        return self.finished(steps, "gave up" if steps < 0 else "")


def contenders(problem: Problem, tolerance: float, stop: float) -> dict[str, Contender]:
    """Return the contender of this module."""
    return {"numbalsoda DOP853": Dop853(problem.scene(tolerance), stop)}
