"""numbalsoda (DOP853 in Fortran), driven by compiled code.

The solver locates events within 1e-8 s; kernel_model.switch corrects the remaining difference.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numba import njit
from numbalsoda import solve_ivp

from benchmarks.peers import Contender, Outcome
from benchmarks.peers.on_kernel import OnKernel
from benchmarks.problems import Problem


@njit
def run_segment(rate, event, address, y, changes, stop, tolerance, grid, clock):  # noqa: PLR0917
    """Integrate from y at clock[0] [s], with a first step clock[1] [s], to the next event or to ``stop``.

    On success ``y`` and clock[0] are then those of this end.

    Returns:
        Whether it succeeds, whether it ends with an event, and the states at the ends of the steps, or at the
        times of ``grid`` if it has any.
    """
    solution = solve_ivp(
        rate, np.array([clock[0], stop]), y, grid, "DOP853", 0 if len(changes) == 0 else 1, event, address,
        min(clock[1], stop - clock[0]), 0.0, tolerance, tolerance,
    )  # fmt: skip
    if solution.success:
        y[:] = solution.y_event if solution.event_found else solution.y[-1]
        clock[0] = solution.t_event if solution.event_found else stop
    return solution.success, solution.event_found, solution.y


@njit
def run_dop853(switch, rate, least_event, address, y, changes, stop, tolerance, grid):  # noqa: PLR0917
    """Integrate from y at 0 s to ``stop``; return the number of steps, −1 on failure."""
    clock, steps = np.zeros(2), 0
    while clock[0] < stop:
        succeeds, event, states = run_segment(
            rate, least_event, address, y, changes, stop, tolerance, grid, clock
        )
        if not succeeds:
            return -1
        steps += len(states) - 1
        if event:
            clock[1] = 1.0
            switch(address, clock.ctypes.data, y.ctypes.data, changes.ctypes.data)
    return steps


class Dop853(OnKernel):
    """The function ``numbalsoda.solve_ivp`` as a contender."""

    def run(self, *, keep_steps: bool = False) -> int:
        """Run once; return the number of steps, −1 on failure.

        The number is right only with ``keep_steps``, which costs time.
        """
        self.start()
        arguments = self.arguments([] if keep_steps else [self.stop])
        steps: int = run_dop853(self.model.plain_switch, *arguments)
        return steps

    def arguments(self, times: list[float]) -> tuple[Any, ...]:
        """Return the arguments of ``run_segment`` except the clock; ``times`` [s] becomes ``grid``."""
        state = self.address, self.y, self.found, self.stop, self.tolerance
        return self.rate, self.least, *state, np.array(times, np.float64)

    def watched(self, tick: Callable[[], None]) -> int:
        """Run once, look at all states, and call ``tick`` at each event; return the steps, −1 on failure."""
        self.start()
        arguments, clock, steps = self.arguments([]), np.zeros(2), 0
        while clock[0] < self.stop:
            succeeds, event, states = run_segment(*arguments, clock)
            if not succeeds:
                return -1
            steps += len(states) - 1
            self.look(states)
            tick()
            if event:
                clock[:] = self.switch(clock[0], self.y)
        return steps

    def outcome(self) -> Outcome:
        """Run once more, and return the outcome."""
        steps = self.run(keep_steps=True)
        return self.finished(steps, "gave up" if steps < 0 else "")


def contenders(problem: Problem, tolerance: float, stop: float) -> dict[str, Contender]:
    """Return the contender of this module."""
    return {"numbalsoda DOP853": Dop853(problem.scene(tolerance), stop)}
