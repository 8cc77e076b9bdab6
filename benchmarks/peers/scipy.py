"""scipy's solve_ivp as an experienced user would use it: compiled functions, terminal events, first steps."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from problems import Problem
from scipy.integrate import solve_ivp

from peers import Contender, Outcome
from peers.model import Contacts, Model, energy_of

METHODS = ("DOP853", "LSODA")  # the best with impacts, and in flight
BEYOND = 1e-9  # m, a point this deep in a wall without a contact: an onset was missed


@dataclass
class Run:
    """What a run came to. Times in s, energies in J."""

    time: float
    state: np.ndarray
    onsets: list[tuple[int, float]] = field(default_factory=list)  # candidate, time
    steps: int = 0
    rhs: int = 0  # evaluations
    highest_energy: float = -math.inf
    deepest: float = 0.0  # m
    missed: bool = False  # a point was found beyond a wall without a contact
    message: str = ""  # of an integrator that gave up


class Scipy(Model):
    """solve_ivp on a scene, restarted at every onset and end."""

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
        contacts = Contacts(self)
        active, v0, law = contacts.active, contacts.v0, self.law
        compiled_rate, least = self.rate, self.least

        def derivative(t: float, y: np.ndarray) -> np.ndarray:
            if tick is not None:
                tick()
            return compiled_rate(t, y, active, v0, law)

        def event(t: float, y: np.ndarray) -> float:
            return least(t, y, active, v0, law)

        event.terminal, event.direction = True, -1
        result = Run(0.0, self.first.copy()) if result is None else result
        result.onsets = contacts.onsets
        step = flight_step = None
        while result.time < stop:
            sol = solve_ivp(
                derivative, (result.time, stop), result.state, method, rtol=tolerance, atol=tolerance,
                events=event if self.candidates else None,
                first_step=None if step is None else min(step, stop - result.time),
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
            step = contacts.switch(result.time, result.state, flight_step)
        return result

    def look(self, result: Run, states: np.ndarray, active: np.ndarray, v0: np.ndarray) -> None:
        """Note energy, depth and missed onsets at the ends of the steps of a segment."""
        for y in states.T:
            energy, deepest, outside = energy_of(self.chain, y, active, v0)
            result.highest_energy = max(result.highest_energy, energy)
            result.deepest = max(result.deepest, deepest)
            result.missed = result.missed or outside > BEYOND


class Method:
    """One of solve_ivp's methods."""

    def __init__(self, peer: Scipy, method: str, tolerance: float, stop: float) -> None:
        self.peer, self.settings = peer, (method, tolerance, stop)

    def run(self) -> None:
        """Once."""
        self.peer.run(*self.settings)

    def outcome(self) -> Outcome:
        """Once more."""
        try:
            run = self.peer.run(*self.settings)
        except (ValueError, RuntimeError) as problem:  # of scipy's root finder
            return Outcome(self.peer.first, failed=str(problem))
        return Outcome(run.state, run.onsets, run.steps, run.rhs, run.message)


def contenders(problem: Problem, tolerance: float, stop: float) -> dict[str, Contender]:
    """Both."""
    peer = Scipy(problem.scene())
    return {f"scipy {method}": Method(peer, method, tolerance, stop) for method in METHODS}
