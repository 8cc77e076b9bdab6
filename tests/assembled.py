"""A chain with stops in its joints by an assembled mass matrix and SciPy, sharing nothing with the kernel.

For the law of Zhang and Sharf, M = K φⁿ (1 + λ φ̇/v₀), with v₀ fixed at the onset; from event to event at the
tolerance of round-off.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from chain_impact.scene.scene import Scene
from tests.reference import Textbook, exact_damping_factor

ACCURATE = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14, "max_step": 0.01}


@dataclass(frozen=True)
class Stop:
    """One side of a joint: its gap is side · (ψ − limit) with the joint's own angle ψ [rad]."""

    joint: int  # 1…N
    side: int
    limit: float


class Assembled:
    """A scene without walls, whose joints have stops."""

    def __init__(self, scene: Scene) -> None:
        self.scene, self.book, self.links = scene, Textbook(scene), len(scene.chain.links)
        self.stops = [
            Stop(i, side, limit)
            for i, link in enumerate(scene.chain.links, 1)
            for side, limit in ((1, link.joint_min), (-1, link.joint_max))
            if limit is not None
        ]
        self.factor = exact_damping_factor(scene.stops.restitution)
        self.free = slice(2 if scene.chain.base == "pinned" else 0, None)

    def run(self, stop_time: float) -> tuple[np.ndarray, list[tuple[float, Stop]]]:
        """The state (q, q̇) at a time [s], and the onsets: time [s] and stop."""
        start, touching, onsets, time = self.scene.initial, {}, [], 0.0
        speeds = [*start.velocity, *start.angular_velocities]
        y = np.array([*start.position, *start.angles, *speeds], float)
        while time < stop_time:
            events = [self._event(stop, stop in touching) for stop in self.stops]
            done = solve_ivp(
                lambda _, state: self._rate(state, touching), (time, stop_time), y, events=events, **ACCURATE
            )
            time, y = float(done.t[-1]), done.y[:, -1]
            for stop, found in zip(self.stops, done.t_events, strict=True):
                if len(found) and stop in touching:
                    del touching[stop]
                elif len(found):
                    speed = -self._gap(y, stop)[1]
                    touching[stop] = max(speed, self.scene.stops.minimum_impact_speed)
                    onsets.append((time, stop))
        return y, onsets

    def _gap(self, y: np.ndarray, stop: Stop) -> tuple[float, float]:
        """The gap of a stop and its rate [rad, rad/s]."""
        n, i = self.links, stop.joint - 1
        angle, rate = (y[at + i] - (y[at + i - 1] if i else 0.0) for at in (2, n + 4))
        return stop.side * (angle - stop.limit), stop.side * rate

    def _event(self, stop: Stop, touching: bool) -> Any:
        def passage(_: float, y: np.ndarray) -> float:
            return -self._gap(y, stop)[0] if touching else self._gap(y, stop)[0]

        passage.terminal, passage.direction = True, -1  # type: ignore[attr-defined]
        return passage

    def _rate(self, y: np.ndarray, touching: dict[Stop, float]) -> np.ndarray:
        n, stops = self.links, self.scene.stops
        matrix, forces = self.book.assemble(y[2 : n + 2], y[n + 4 :])
        for stop, first in touching.items():
            gap, rate = self._gap(y, stop)
            depth = max(0.0, -gap)
            law = stops.stiffness * depth**stops.exponent * (1.0 - self.factor * rate / first)
            moment = stop.side * max(0.0, law)
            forces[1 + stop.joint] += moment
            if stop.joint > 1:
                forces[stop.joint] -= moment
        result = np.concatenate([y[n + 2 :], np.zeros(n + 2)])
        result[n + 2 :][self.free] = np.linalg.solve(matrix[self.free, self.free], forces[self.free])
        return result
