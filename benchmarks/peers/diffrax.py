"""diffrax: Dormand and Prince's pair of order 8 compiled by XLA, with its own event detection, 64 bit.

The right-hand side holds the forces of all candidates at once, masked by what is active: one compiled
segment serves the whole run, which Python restarts at events.
"""

from __future__ import annotations

import os
from typing import Any

# one core, as all others; read when JAX is imported
os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1")

import diffrax
import jax
import numpy as np
import optimistix
from jax import numpy as jnp
from problems import Problem

from chain_impact.kernel.events.exclusion import RELATCH_RATIO
from peers import Contender, Outcome
from peers.model import CLEAR, Contacts, Model
from peers.symbolic import accelerations, clearances, push

jax.config.update("jax_enable_x64", True)
MOST_STEPS = 100_000
ROOT = 1e-13  # s or m, of its root finder


class Dopri8:
    """A compiled segment, from an event to the next."""

    def __init__(self, model: Model, tolerance: float, stop: float) -> None:
        self.model, self.tolerance, self.stop = model, tolerance, stop
        self.segment = jax.jit(self.solve)

    def gaps(self, y: Any) -> tuple[Any, Any]:
        """Clearances and their rates."""
        half = len(self.model.first) // 2
        found = clearances(self.model.chain, jnp, y[:half], y[half:])
        return jnp.stack([gap for gap, _ in found]), jnp.stack([rate for _, rate in found])

    def rate(self, _t: Any, y: Any, args: tuple[Any, Any]) -> Any:
        """f(t, y)."""
        chain, half, loads = self.model.chain, len(self.model.first) // 2, {}
        if self.model.candidates:
            active, v0 = args
            gap, gap_rate = self.gaps(y)
            touching = active & (gap < 0.0)
            depth = jnp.where(touching, -gap, 0.0)
            force = chain.stiffness * depth * jnp.sqrt(jnp.where(touching, depth, 1.0))
            force = force * jnp.maximum(0.0, 1.0 - chain.damping_factor * gap_rate / v0)
            for c in range(self.model.candidates):
                push(chain, loads, c, force[c])
        rates = accelerations(chain, jnp, y[:half], y[half:], loads)
        return jnp.concatenate([y[half:], jnp.stack(rates)])

    def least(self, t: Any, y: Any, args: tuple[Any, Any], **_: Any) -> Any:  # noqa: ARG002
        """The event function of model.py."""
        active, v0 = args
        gap, gap_rate = self.gaps(y)
        fast = jnp.where(active, RELATCH_RATIO * v0 + gap_rate, jnp.inf)
        return jnp.minimum(jnp.where(active, -gap, gap), fast).min() + CLEAR

    def solve(self, t: Any, y: Any, step: Any, active: Any, v0: Any) -> tuple[Any, ...]:
        """One segment: time, state, whether there was an event, steps."""
        event = None
        if self.model.candidates:
            event = diffrax.Event(self.least, optimistix.Bisection(rtol=0.0, atol=ROOT), direction=False)
        done = diffrax.diffeqsolve(
            diffrax.ODETerm(self.rate), diffrax.Dopri8(), t, self.stop, step, y, (active, v0), event=event,
            stepsize_controller=diffrax.PIDController(rtol=self.tolerance, atol=self.tolerance),
            max_steps=MOST_STEPS, throw=False, saveat=diffrax.SaveAt(t1=True),
        )  # fmt: skip
        met = done.result == diffrax.RESULTS.event_occurred
        good = met | (done.result == diffrax.RESULTS.successful)
        return done.ts[-1], done.ys[-1], met, good, done.stats["num_steps"], done.stats["num_accepted_steps"]

    def run(self) -> Outcome:
        """Once."""
        contacts, t, y, first = Contacts(self.model), 0.0, self.model.first, 1e-3
        tried, steps = 0, 0
        while True:
            found = self.segment(t, y, min(first, self.stop - t), contacts.active, contacts.v0)
            t, y, met, good, count, accepted = (np.asarray(value) for value in found)
            t, tried, steps = float(t), tried + int(count), steps + int(accepted)
            if not met or not good:
                break
            first = contacts.switch(t, y) or 1e-3
        return Outcome(y, contacts.onsets, steps, 13 * tried, "" if good else "gave up")

    outcome = run


def contenders(problem: Problem, tolerance: float, stop: float) -> dict[str, Contender]:
    """One."""
    return {"diffrax Dopri8": Dopri8(Model(problem.scene()), tolerance, stop)}
