"""scipy's methods, see solve_ivp.py."""

from __future__ import annotations

from problems import Problem

from peers import Contender, Outcome
from peers.solve_ivp import Scipy

METHODS = ("DOP853", "RK45", "LSODA", "Radau", "BDF")


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
    """All five."""
    peer = Scipy(problem.scene())
    return {f"scipy {method}": Method(peer, method, tolerance, stop) for method in METHODS}
