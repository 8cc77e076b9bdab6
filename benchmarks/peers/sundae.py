"""scikit-sundae: CVODE called from Python, with compiled functions and its own root finding."""

from __future__ import annotations

import numpy as np
from problems import Problem
from sksundae.cvode import CVODE

from peers import Contender, Outcome
from peers.model import Contacts, Model

MOST_STEPS = 1_000_000
EVENT = 2  # its status when an event has ended a step


class Sundae:
    """One of CVODE's two families of formulas."""

    def __init__(self, model: Model, method: str, tolerance: float, stop: float) -> None:
        self.model, self.method, self.tolerance, self.stop = model, method, tolerance, stop

    def run(self) -> Outcome:
        """Once."""
        model, contacts, t, y = self.model, Contacts(self.model), 0.0, self.model.first
        active, v0, law, compiled_rate, compiled_least = (
            contacts.active, contacts.v0, model.law, model.rate, model.least,
        )  # fmt: skip

        def rate(t: float, y: np.ndarray, out: np.ndarray) -> None:
            out[:] = compiled_rate(t, y, active, v0, law)

        def event(t: float, y: np.ndarray, out: np.ndarray) -> None:
            out[0] = compiled_least(t, y, active, v0, law)

        event.terminal, event.direction = [True], [-1]
        events = {"eventsfn": event, "num_events": 1} if model.candidates else {}
        solver = CVODE(
            rate,
            method=self.method,
            rtol=self.tolerance,
            atol=self.tolerance,
            max_num_steps=MOST_STEPS,
            **events,
        )
        rhs = 0
        while True:
            solver.init_step(t, y)
            done = solver.step(self.stop)
            t, y, rhs = float(done.t), done.y, rhs + done.nfev
            if done.status != EVENT:
                break
            contacts.switch(t, y, propose=False)
        return Outcome(y, contacts.onsets, None, rhs, "" if done.success else done.message)

    outcome = run


def contenders(problem: Problem, tolerance: float, stop: float) -> dict[str, Contender]:
    """Both."""
    model = Model(problem.scene())
    return {f"scikit-sundae {method}": Sundae(model, method, tolerance, stop) for method in ("Adams", "BDF")}
