"""numbalsoda (LSODA in C++, DOP853 in Fortran), driven by compiled code, on the kernel's own functions.

DOP853 finds events itself, to 1e-8 s; the rest is made up for in kernel_model.switch. LSODA has no events:
it is asked for a grid of times, and the first sign change on it is narrowed down by further, shorter calls.
"""

from __future__ import annotations

import ctypes

import numpy as np
from numba import njit
from numbalsoda import lsoda, solve_ivp
from problems import Problem

from peers import Contender, Outcome, kernel_model
from peers.ours import OnInstance

MOST_STEPS = 1_000_000
FLIGHT_WINDOW, FLIGHT_GRID = 0.1, 25  # s of flight in one call of LSODA, and points of its grid
CONTACT_GRID = 12  # … for one expected duration of a contact
PER_STEP = 10  # expected duration of a contact, in first steps
NARROWINGS = 20


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


@njit
def value_at(least, address, y):
    """The least event function."""
    out = np.empty(1)
    least(0.0, y.ctypes.data, out.ctypes.data, address)
    return out[0]


@njit
def narrow(rate, least, data, address, y, low, high, tolerance):  # noqa: PLR0917
    """Bring y at ``low`` [s] to the root before ``high``; returns its time. Illinois' rule."""
    a, va = low, value_at(least, address, y)
    z, success = lsoda(rate, y, np.array([low, high]), data, tolerance, tolerance, MOST_STEPS)
    b, vb = high, value_at(least, address, z[1])
    side = 0
    for _ in range(NARROWINGS):
        if b - a < 1e-12:
            break
        t = (a * vb - b * va) / (vb - va)
        if not a < t < b:
            t = 0.5 * (a + b)
        z, success = lsoda(rate, y, np.array([low, t]), data, tolerance, tolerance, MOST_STEPS)
        value = value_at(least, address, z[1])
        b_is_it = value <= 0.0
        if b_is_it:
            b, vb = t, value
            if side == -1:
                va *= 0.5
            side = -1
        else:
            a, va = t, value
            if side == 1:
                vb *= 0.5
            side = 1
        if abs(value) < 1e-9 or not success:
            b = t
            break
    y[:] = z[1]
    return b


@njit
def run_lsoda(rate, least, switch, data, y, found, stop, tolerance):  # noqa: PLR0917
    """From y at 0 s to ``stop``; returns 0, or −1 on failure."""
    address = data.ctypes.data
    t, window, points = 0.0, FLIGHT_WINDOW, FLIGHT_GRID
    clock = np.zeros(2)
    if len(found) == 0:
        window, points = stop, 1
    while t < stop:
        grid = np.linspace(t, min(t + window, stop), points + 1)
        z, success = lsoda(rate, y, grid, data, tolerance, tolerance, MOST_STEPS)
        if not success:
            return -1
        hit = -1
        if len(found) > 0:
            for k in range(1, points + 1):
                if value_at(least, address, z[k]) <= 0.0:
                    hit = k
                    break
        if hit < 0:
            t = grid[-1]
            y[:] = z[-1]
            continue
        y[:] = z[hit - 1]
        clock[0] = narrow(rate, least, data, address, y, grid[hit - 1], grid[hit], tolerance)
        clock[1] = 1.0
        touching = switch(address, clock.ctypes.data, y.ctypes.data, found.ctypes.data)
        t = clock[0]
        if touching > 0:
            window, points = clock[1] * PER_STEP * 1.5, CONTACT_GRID
        else:
            window, points = FLIGHT_WINDOW, FLIGHT_GRID
    return 0


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


class Lsoda(OnKernel):
    """``numbalsoda.lsoda``."""

    def run(self) -> int:
        """Once."""
        self.start()
        return run_lsoda(
            self.rate,
            self.model.peer_least,
            self.model.peer_switch,
            self.block,
            self.y,
            self.found,
            self.stop,
            self.tolerance,
        )

    def outcome(self) -> Outcome:
        """Once more; it does not tell its steps."""
        return self.finished(None, "gave up" if self.run() < 0 else "")


def contenders(problem: Problem, tolerance: float, stop: float) -> dict[str, Contender]:
    """Both."""
    return {
        "numbalsoda DOP853": Dop853(problem, tolerance, stop),
        "numbalsoda LSODA": Lsoda(problem, tolerance, stop),
    }
