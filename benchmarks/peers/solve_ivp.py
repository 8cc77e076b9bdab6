"""scipy's solve_ivp on the compiled plain_chain.py.

It gets what an experienced user would give it: compiled right-hand side and event function, terminal
events with a restart at each, the speed latched as in the kernel, and a first step that fits
the contact or the hop.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache

import numpy as np
from numba import njit
from plain_chain import Chain, clearance, jit, locate, mechanical_energy, new_work, plain_chain, rate, start
from scipy.integrate import solve_ivp
from textbook import Textbook

from chain_impact.kernel.events import RELATCH_RATIO
from chain_impact.scene import Scene

AT_ZERO = 1e-12  # s, how far from zero in time a candidate is that has an event
# m, by which an event comes late: a contact that has just begun or ended is then clear of zero, as scipy
# needs a change of sign between the ends of a step
CLEAR = 1e-13
BEYOND = 1e-9  # m, a point this deep in a wall without a contact: an onset was missed
FIRST_STEP = 0.09  # of expected depth / impact speed, as in kernel/advance.py
HOP = 0.2  # first step of a flight, in parts of separation speed / g: a low hop must not be stepped over


@dataclass
class Run:
    """What a run came to. Times in s, energies in J."""

    time: float
    state: np.ndarray
    onsets: list[tuple[int, float]] = field(default_factory=list)  # candidate, time
    ends: list[tuple[int, float]] = field(default_factory=list)
    steps: int = 0
    rhs: int = 0  # evaluations
    highest_energy: float = -math.inf
    deepest: float = 0.0  # m
    missed: bool = False  # a point was found beyond a wall without a contact
    message: str = ""  # of an integrator that gave up


@cache
def compiled(geometry: tuple, exponent: float) -> tuple[Callable, Callable, Callable]:
    """f(t, y, active, v0, law), the least of all event functions, and clearances with their rates.

    Args:
        geometry: what in a Chain is no property of the contact, as (shape, type, bytes) of each array.
        exponent: of the contact law.

    The arrays become constants of the compiled code; ``law`` holds stiffness and damping factor.
    """
    gravity, length, mass, ratio, joint_inertia, wall, point, side = (
        np.frombuffer(data, kind).reshape(shape) for shape, kind, data in geometry
    )
    points = len(length) + 1

    @njit(error_model="numpy")
    def chain_of(law):
        return Chain(gravity, length, mass, ratio, joint_inertia, wall, point, side, law[0], exponent, law[1])

    @njit(error_model="numpy")
    def derivative(t, y, active, v0, law):  # noqa: ARG001
        out = np.empty(len(y))
        rate(chain_of(law), new_work(points), y, active, v0, out)
        return out

    @njit(error_model="numpy")
    def least(t, y, active, v0, law):  # noqa: ARG001
        chain, work = chain_of(law), new_work(points)
        locate(chain, work, y)
        lowest = np.inf
        for c in range(len(active)):
            gap, speed = clearance(chain, work, c)
            lowest = min(lowest, -gap if active[c] else gap)
            if active[c]:
                lowest = min(lowest, RELATCH_RATIO * v0[c] + speed)
        return lowest + CLEAR

    @njit(error_model="numpy")
    def everything(y, active, law):
        chain, work = chain_of(law), new_work(points)
        locate(chain, work, y)
        found = np.empty((len(active), 2))
        for c in range(len(active)):
            gap, speed = clearance(chain, work, c)
            sign = -1.0 if active[c] else 1.0
            found[c, 0], found[c, 1] = sign * gap, sign * speed
        return found

    return derivative, least, everything


class Scipy:
    """solve_ivp on a scene, restarted at every onset and end."""

    def __init__(self, scene: Scene) -> None:
        """Compile; from then on a run compiles nothing."""
        self.scene, self.chain, self.first = scene, plain_chain(scene), start(scene)
        geometry = tuple((array.shape, array.dtype.str, array.tobytes()) for array in self.chain[:8])
        self.rate, self.least, self.everything = compiled(geometry, self.chain.exponent)
        self.law = np.array([self.chain.stiffness, self.chain.damping_factor])
        self.book = Textbook(scene)

    def first_step(self, y: np.ndarray, c: int, speed: float) -> float:
        """A part of the expected duration of a contact [s], from its effective mass."""
        n, chain = len(self.chain.length), self.chain
        point, wall = chain.candidate_point[c], chain.candidate_wall[c]
        self.book.rate(y)
        gradient = np.zeros(n + 2)
        gradient[wall // 2] = 1.0
        turn = -np.sin(y[2 : 2 + point]) if wall < 2 else np.cos(y[2 : 2 + point])
        gradient[2 : 2 + point] = chain.length[:point] * turn
        mass = 1.0 / (gradient @ np.linalg.solve(self.book.matrix, gradient))
        energy, n1 = 0.5 * mass * speed**2, chain.exponent + 1.0
        return FIRST_STEP * (energy * n1 / chain.stiffness) ** (1.0 / n1) / speed

    def run(
        self,
        method: str,
        tolerance: float,
        stop: float,
        *,
        watch: bool = False,
        tick: Callable[[], None] | None = None,
        result: Run | None = None,
    ) -> Run:
        """Integrate to ``stop`` [s].

        Args:
            method: one of solve_ivp's.
            tolerance: relative, and absolute in m, rad, m/s, rad/s.
            stop: [s].
            watch: look at energy, depth and missed onsets after each step.
            tick: called at each right-hand side, to stop a run that takes too long.
            result: what it has come to when an exception stops it, up to the last event.
        """
        count = len(self.chain.candidate_point)
        active, v0 = np.zeros(count, np.bool_), np.ones(count)
        floor = self.scene.contact.minimum_impact_speed
        compiled_rate, least, law = self.rate, self.least, self.law

        def derivative(t: float, y: np.ndarray) -> np.ndarray:
            if tick is not None:
                tick()
            return compiled_rate(t, y, active, v0, law)

        def event(t: float, y: np.ndarray) -> float:
            return least(t, y, active, v0, law)

        event.terminal, event.direction = True, -1
        result = Run(0.0, self.first.copy()) if result is None else result
        step = flight_step = None
        while result.time < stop:
            sol = solve_ivp(
                derivative, (result.time, stop), result.state, method, rtol=tolerance, atol=tolerance,
                events=event, first_step=None if step is None else min(step, stop - result.time),
            )  # fmt: skip
            result.steps += len(sol.t) - 1
            result.rhs += sol.nfev
            result.time, result.state = float(sol.t[-1]), sol.y[:, -1]
            if watch:
                self.look(result, sol.y, active, v0)
            if sol.status != 1:
                result.message = "" if sol.status == 0 else sol.message
                break
            if not active.any() and len(sol.t) > 2:
                flight_step = sol.t[-2] - sol.t[-3]
            step, hop = None, math.inf
            for c, (value, speed) in enumerate(self.everything(result.state, active, law)):
                if active[c] and speed >= RELATCH_RATIO * v0[c] * (1.0 - 1e-9):
                    v0[c] *= RELATCH_RATIO
                if speed < 0.0 and value <= -speed * AT_ZERO + 1e-15:
                    (result.ends if active[c] else result.onsets).append((c, result.time))
                    active[c] = not active[c]
                    hop = min(hop, -speed * HOP / 9.81)
                    if active[c]:
                        # the force rises as δⁿ, unseen at onset
                        v0[c] = max(-speed, floor)
                        step = self.first_step(result.state, c, v0[c])
            if not active.any():
                step = hop if flight_step is None else min(hop, flight_step)
        return result

    def look(self, result: Run, states: np.ndarray, active: np.ndarray, v0: np.ndarray) -> None:
        """Note energy, depth and missed onsets at the ends of the steps of a segment."""
        for y in states.T:
            energy, deepest, outside = energy_of(self.chain, y, active, v0)
            result.highest_energy = max(result.highest_energy, energy)
            result.deepest = max(result.deepest, deepest)
            result.missed = result.missed or outside > BEYOND


@jit
def energy_of(chain, y, active, v0):
    """Total energy [J], deepest penetration [m], and depth of points not in contact [m]."""
    work, out = new_work(len(chain.length) + 1), np.empty(len(y))
    stored = rate(chain, work, y, active, v0, out)
    locate(chain, work, y)
    deepest, outside = 0.0, 0.0
    for c in range(len(active)):
        gap, _ = clearance(chain, work, c)
        deepest = max(deepest, -gap)
        if not active[c]:
            outside = max(outside, -gap)
    return stored + mechanical_energy(chain, work, y), deepest, outside
