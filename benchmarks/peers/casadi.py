"""CasADi's Runge–Kutta pair 5(4), generated as C, with its own zero crossings; its CVODES in flight.

Transitions change states only, so the latched speed of each candidate is one (0: not in contact), and
the right-hand side holds the forces of all candidates at once.
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from functions_library import zig
from problems import Problem

from chain_impact.compilation.cache import made
from peers import Contender, Outcome
from peers.model import CLEAR, Model
from peers.symbolic import accelerations, clearances, push

CPU = "-mcpu=x86_64_v2"  # as the kernel
LEAST = 1e-24  # m, of a depth: the derivative of √δ is asked for
EVENT_TOLERANCE = 1e-12
MOST_EVENTS = 64
SLOTS = 16  # onsets that are kept
MOST_STEPS = 1_000_000


class Casadi:
    """An integrator over the whole run, transitions and all."""

    def __init__(self, model: Model, plugin: str, tolerance: float, stop: float) -> None:
        self.model, self.plugin = model, plugin
        self.settings = tolerance, stop
        self.start = np.concatenate([model.first, np.zeros(model.candidates + 2 * SLOTS + 1)])
        integrator = self.integrator(0)
        self.function = compiled(integrator) if plugin == "erk" else integrator
        self.size = integrator.size1_in("x0")

    def integrator(self, slots: int) -> Any:
        """One with places for the times of onsets in its state."""
        tolerance, stop = self.settings
        dae, options = self.equations(slots)
        options |= {"reltol": tolerance, "abstol": tolerance, "max_num_steps": MOST_STEPS}
        return ca.integrator("F", self.plugin, dae, 0.0, stop, options)

    def equations(self, slots: int) -> tuple[dict[str, Any], dict[str, Any]]:
        """The DAE dictionary, and the options for its transitions."""
        chain, half, count = self.model.chain, len(self.model.first) // 2, self.model.candidates
        extra = count + (2 * slots + 1 if slots else 0)
        x, t = ca.SX.sym("x", 2 * half + extra), ca.SX.sym("t")
        q, v, v0 = (
            [x[j] for j in range(a, b)]
            for a, b in ((0, half), (half, 2 * half), (2 * half, 2 * half + count))
        )
        gaps, loads = clearances(chain, ca, q, v), {}
        for c, (gap, rate) in enumerate(gaps):
            depth = ca.fmax(LEAST, -gap)
            force = chain.stiffness * depth * ca.sqrt(depth)
            force *= ca.fmax(0.0, 1.0 - chain.damping_factor * rate / ca.if_else(v0[c] > 0.0, v0[c], 1.0))
            push(chain, loads, c, ca.if_else(v0[c] > 0.0, force, 0.0))
        rates = accelerations(chain, ca, q, v, loads)
        dae = {"x": x, "t": t, "ode": ca.vertcat(*v, *rates, *[0.0] * extra)}
        if count == 0:
            return dae, {}
        falling = [ca.if_else(v0[c] > 0.0, -gap, gap) for c, (gap, _) in enumerate(gaps)]
        dae["zero"] = ca.vertcat(*falling) + CLEAR
        index, floor = ca.SX.sym("index"), self.model.scene.contact.minimum_impact_speed
        new = [
            ca.if_else(index == c, ca.if_else(v0[c] > 0.0, 0.0, ca.fmax(-gaps[c][1], floor)), v0[c])
            for c in range(count)
        ]
        if slots:
            began = sum(new[c] > v0[c] for c in range(count))
            log = [x[j] for j in range(2 * half + count, x.numel())]
            here = [began * (log[0] == k) for k in range(slots)]
            times = [ca.if_else(here[k], t, log[1 + k]) for k in range(slots)]
            whose = [ca.if_else(here[k], index, log[1 + slots + k]) for k in range(slots)]
            new += [log[0] + began, *times, *whose]
        empty = ca.SX.sym("empty", 0)
        # the order of casadi.event_in()
        transition = ca.Function(
            "transition", [index, t, x, empty, empty, empty], [ca.vertcat(*q, *v, *new), empty],
            ca.event_in(), ca.event_out(),
        )  # fmt: skip
        return dae, {"transition": transition, "max_events": MOST_EVENTS, "event_tol": EVENT_TOLERANCE}

    def run(self) -> np.ndarray:
        """Once."""
        return self.function(x0=self.start[: self.size])["xf"]

    def outcome(self) -> Outcome:
        """Once more, and again with the log of onsets and the counts, which the timed one does without."""
        first = self.model.first
        try:
            end = np.array(self.run()).ravel()
            logging = self.integrator(SLOTS)
            log = np.array(logging(x0=self.start[: logging.size1_in("x0")])["xf"]).ravel()
        except RuntimeError as problem:
            return Outcome(first, failed=str(problem).splitlines()[-1])
        log = log[len(first) + self.model.candidates :]
        count = min(int(log[0]), SLOTS) if self.model.candidates else 0
        onsets = [(int(log[1 + SLOTS + k]), float(log[1 + k])) for k in range(count)]
        stats = logging.stats()
        steps, rhs = (stats.get(a, stats.get(b)) for a, b in (("n_steps", "nsteps"), ("n_rhs", "nfevals")))
        return Outcome(end[: len(first)], onsets, steps, rhs)


def compiled(function: Any) -> Any:
    """A CasADi function by way of its C code."""
    generator = ca.CodeGenerator("peer.c")
    generator.add(function)
    source = generator.dump()
    digest = hashlib.sha256(source.encode()).hexdigest()[:16]

    def make(library: Path) -> None:
        path = library.with_suffix(".c")
        path.write_text(source)
        zig(library.parent, CPU, "-shared", "-fPIC", "-Wno-everything", "-o", library, path, "-lm")

    return ca.external(function.name(), str(made(f"casadi-{digest}.so", make)))


def contenders(problem: Problem, tolerance: float, stop: float) -> dict[str, Contender]:
    """Both in flight; its CVODES fails at the first event: "trouble interpolating"."""
    model = Model(problem.scene())
    plugins = ("erk",) if model.candidates else ("erk", "cvodes")
    return {f"CasADi {plugin}": Casadi(model, plugin, tolerance, stop) for plugin in plugins}
