"""heyoka: Taylor series, with its own event detection, compiled by LLVM for a tolerance.

One integrator for each set of contacts that are active at once. A Taylor series cannot begin at an onset,
where δ^{3/2} has no derivatives: the first nanosecond, in which the force is nil, goes by the integrator
without it, and the steps grow from there.
"""

from __future__ import annotations

from typing import Any

import heyoka as hy
import numpy as np
from problems import Problem

from chain_impact.kernel.events.exclusion import RELATCH_RATIO
from peers import Contender, Outcome
from peers.model import Contacts, Model
from peers.symbolic import accelerations, clearances, push

SKIP = 1e-9  # s
hy.set_logger_level_critical()


class Taylor:
    """The integrators of one model at one tolerance."""

    def __init__(self, model: Model, tolerance: float, stop: float) -> None:
        self.model, self.tolerance, self.stop = model, tolerance, stop
        self.integrators: dict[tuple[int, ...], Any] = {}

    def integrator(self, active: np.ndarray) -> Any:
        """The one for a set of contacts; compiled when first asked for."""
        key = tuple(int(c) for c in np.flatnonzero(active))
        if key not in self.integrators:
            self.integrators[key] = self.compiled(key)
        return self.integrators[key]

    def compiled(self, active: tuple[int, ...]) -> Any:
        """Equations of motion and events; the latched speeds are its parameters."""
        chain = self.model.chain
        count = range(len(chain.length) + 2)
        q = hy.make_vars(*(f"q{i}" for i in count))
        v = hy.make_vars(*(f"v{i}" for i in count))
        gaps, loads, events = clearances(chain, hy, q, v), {}, []
        for c, (gap, rate) in enumerate(gaps):
            if c in active:
                elastic = chain.stiffness * (-gap) ** chain.exponent
                force = elastic * (1.0 - chain.damping_factor * rate / hy.par[c])
                push(chain, loads, c, force)
                events += [-gap, RELATCH_RATIO * hy.par[c] + rate]
            else:
                events.append(gap)
        rates = accelerations(chain, hy, q, v, loads)
        system = [*zip(q, v, strict=True), *zip(v, rates, strict=True)]
        falling = [hy.t_event(event, direction=hy.event_direction.negative) for event in events]
        return hy.taylor_adaptive(system, list(self.model.first), tol=self.tolerance, t_events=falling)

    def run(self) -> Outcome:
        """Once."""
        contacts, t, y = Contacts(self.model), 0.0, self.model.first
        steps, failed = 0, ""
        while t < self.stop:
            solver = self.integrator(contacts.active)
            solver.time, solver.state[:] = t, y
            if solver.with_events:
                solver.reset_cooldowns()
            solver.pars[: len(contacts.v0)] = contacts.v0[: len(solver.pars)]
            outcome, _, _, count, *_ = solver.propagate_until(self.stop)
            t, y, steps = solver.time, solver.state, steps + count
            if outcome == hy.taylor_outcome.time_limit:
                break
            if outcome in {hy.taylor_outcome.err_nf_state, hy.taylor_outcome.step_limit}:
                failed = str(outcome)
                break
            touched = contacts.active.sum()
            contacts.switch(t, y.copy(), propose=False)
            if contacts.active.sum() > touched:
                solver.propagate_for(SKIP)
                t = solver.time
            y = y.copy()
        return Outcome(y.copy(), contacts.onsets, steps, None, failed)

    outcome = run


def contenders(problem: Problem, tolerance: float, stop: float) -> dict[str, Contender]:
    """One."""
    return {"heyoka": Taylor(Model(problem.scene()), tolerance, stop)}
