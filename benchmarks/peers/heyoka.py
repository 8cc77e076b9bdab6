"""heyoka: Taylor series, with its own event detection, compiled by LLVM for a tolerance.

heyoka needs the model as expressions, so this module repeats the recursion of kernel/chain/elimination.py.
There is one integrator for each set of contacts that are active at once. A Taylor series cannot begin at an
onset, where δ^{3/2} has no second derivative. So for one nanosecond, in which the force is almost 0, the
integrator of the set without the new contact goes on.
"""

from __future__ import annotations

from typing import Any

import heyoka as hy
import numpy as np

from benchmarks.peers import Contender, MissingError, Outcome
from benchmarks.peers.on_kernel import OnKernel
from benchmarks.problems import Problem
from chain_impact.kernel.events.event_exclusion import RELATCH_RATIO
from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.scene.scene import Scene

SKIP = 1e-9  # [s] time after an onset in which the new contact has no force
MOST_LINKS = 10  # longer chains are left out, as the expressions grow with the square of the number of links
hy.set_logger_level_critical()


class Taylor(OnKernel):
    """The integrators of one scene."""

    def __init__(self, scene: Scene, stop: float) -> None:
        super().__init__(scene, stop)
        self.contact, self.given = scene.contact, self.instance.record["chain"]
        candidate = self.instance.record["candidate"]
        self.pairs = list(zip(candidate["point"].tolist(), candidate["wall"].tolist(), strict=True))
        self.integrators: dict[tuple[int, ...], Any] = {}

    def integrator(self) -> Any:
        """Return the integrator for the contacts that are active; it is compiled at its first use."""
        key = tuple(int(c) for c in np.flatnonzero(self.contacts["active"]))
        if key not in self.integrators:
            self.integrators[key] = self.compiled(key)
        return self.integrators[key]

    def compiled(self, active: tuple[int, ...]) -> Any:
        """Return the integrator for some active contacts; its parameters are the latched speeds."""
        count = range(len(self.given["length"]) + 2)
        q = hy.make_vars(*(f"q{i}" for i in count))
        v = hy.make_vars(*(f"v{i}" for i in count))
        law: Any = CONTACT_LAWS[self.contact.model]
        damping = law.damping_factor(self.contact.restitution)
        loads: dict[int, list[Any]] = {}
        events = []
        for c, (gap, rate) in enumerate(self.clearances(q, v)):
            if c not in active:
                events.append(gap)
                continue
            force = self.contact.stiffness * (-gap) ** self.contact.exponent
            force = force * (1.0 - damping * rate / hy.par[c])
            point, wall = self.pairs[c]
            load = loads.setdefault(point, [0.0, 0.0])
            load[wall // 2] = load[wall // 2] + (1.0 - 2.0 * (wall % 2)) * force
            events += [-gap, RELATCH_RATIO * hy.par[c] + rate]
        rates = self.accelerations(q, v, loads)
        system = [*zip(q, v, strict=True), *zip(v, rates, strict=True)]
        falling = [hy.t_event(event, direction=hy.event_direction.negative) for event in events]
        return hy.taylor_adaptive(system, [0.0] * len(system), tol=self.tolerance, t_events=falling)

    def links(self, q: Any) -> tuple[list[Any], list[Any]]:
        """Return the components along x, and those along y, of the vectors along the links [m]."""
        lengths = [float(length) for length in self.given["length"]]
        x = [length * hy.cos(q[2 + i]) for i, length in enumerate(lengths)]
        return x, [length * hy.sin(q[2 + i]) for i, length in enumerate(lengths)]

    def clearances(self, q: Any, v: Any) -> list[tuple[Any, Any]]:
        """Return clearance [m] and its rate [m/s] of each candidate."""
        lx, ly = self.links(q)
        place, speed = [(q[0], q[1])], [(v[0], v[1])]
        for i in range(len(lx)):
            place.append((place[i][0] + lx[i], place[i][1] + ly[i]))
            speed.append((speed[i][0] - v[2 + i] * ly[i], speed[i][1] + v[2 + i] * lx[i]))
        gaps = []
        for point, wall in self.pairs:
            side, axis = 1.0 - 2.0 * (wall % 2), wall // 2
            gaps.append(
                (side * (place[point][axis] - float(self.given["box_wall"][wall])), side * speed[point][axis])
            )
        return gaps

    def accelerations(self, q: Any, v: Any, loads: dict[int, list[Any]]) -> list[Any]:
        """Return q̈ by the recursion; ``loads``: point → force on the point along x and y [N]."""
        chain, (lx, ly) = self.given, self.links(q)
        n, (gx, gy) = len(lx), (float(value) for value in chain["gravity"])
        axx, axy, ayy = 0.0, 0.0, 0.0
        bias_x, bias_y = (-value for value in loads.get(n, (0.0, 0.0)))
        gains: list[tuple[Any, Any, Any]] = [(0.0, 0.0, 0.0)] * n
        for i in range(n - 1, -1, -1):
            m, centre, w2 = float(chain["mass"][i]), float(chain["center_of_mass"][i]), v[2 + i] * v[2 + i]
            ratio = centre / float(chain["length"][i])
            sx, sy = m * ratio * lx[i], m * ratio * ly[i]
            px, py = axy * lx[i] - axx * ly[i], ayy * lx[i] - axy * ly[i]
            dx = bias_x - w2 * (axx * lx[i] + axy * ly[i])
            dy = bias_y - w2 * (axy * lx[i] + ayy * ly[i])
            hx, hy_ = px - sy, py + sx
            inverse = 1.0 / (float(chain["inertia"][i]) + m * centre**2 + lx[i] * py - ly[i] * px)
            h0 = lx[i] * dy - ly[i] * dx + sy * gx - sx * gy
            kx, ky = hx * inverse, hy_ * inverse
            axx, axy, ayy = axx + m - hx * kx, axy - hx * ky, ayy + m - hy_ * ky
            bias_x, bias_y = dx - w2 * sx - m * gx - kx * h0, dy - w2 * sy - m * gy - ky * h0
            if i in loads:
                bias_x, bias_y = bias_x - loads[i][0], bias_y - loads[i][1]
            gains[i] = kx, ky, h0 * inverse
        determinant = axx * ayy - axy * axy
        ax, ay = (axy * bias_y - ayy * bias_x) / determinant, (axy * bias_x - axx * bias_y) / determinant
        out = [ax, ay]
        for i in range(n):
            a, w2 = -(gains[i][0] * ax + gains[i][1] * ay + gains[i][2]), v[2 + i] * v[2 + i]
            out.append(a)
            ax, ay = ax - (a * ly[i] + w2 * lx[i]), ay + a * lx[i] - w2 * ly[i]
        return out

    def run(self) -> tuple[int, str]:
        """Run once; return the number of steps, and why the run failed, or ""."""
        self.start()
        t, steps = 0.0, 0
        while t < self.stop:
            solver = self.integrator()
            solver.time, solver.state[:] = t, self.y
            if solver.with_events:
                solver.reset_cooldowns()
            solver.pars[:] = self.contacts["latched_speed"][: len(solver.pars)]
            outcome, _, _, count, *_ = solver.propagate_until(self.stop)
            t, steps = solver.time, steps + count
            if outcome == hy.taylor_outcome.time_limit:
                break
            if outcome in {hy.taylor_outcome.err_nf_state, hy.taylor_outcome.step_limit}:
                return steps, str(outcome)
            touched = self.contacts["active_count"]
            t, _ = self.switch(t, solver.state)
            if self.contacts["active_count"] > touched:
                solver.time, solver.state[:] = t, self.y
                solver.propagate_for(SKIP)
                t = solver.time
                self.y[:] = solver.state
        self.y[:] = solver.state
        return steps, ""

    def outcome(self) -> Outcome:
        """Run once more, and return the outcome, without the number of evaluations."""
        steps, failed = self.run()
        result = self.finished(steps, failed)
        result.rhs = None
        return result


def contenders(problem: Problem, tolerance: float, stop: float) -> dict[str, Contender]:
    """Return the contender of this module."""
    scene = problem.scene(tolerance)
    if len(scene.chain.links) > MOST_LINKS:
        raise MissingError(f"takes too long to compile beyond {MOST_LINKS} links")
    return {"heyoka": Taylor(scene, stop)}
