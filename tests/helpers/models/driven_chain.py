"""The textbook's chain with drives in its joints, in flight: an independent model of drives."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from chain_impact.scene.scene import Scene
from tests.helpers.models.textbook import Textbook


class DrivenChain(Textbook):
    """The chain of ``Textbook`` with I_a g gᵀ of each joint in M, g the gradient of its relative rotation.

    ``inputs`` are functions of time by the names of the FMU. The state is y = (q, q̇, supplied energy). Each
    phase between events has its own smooth equations: a drive is at its limit, in one direction, or below it.
    """

    def __init__(self, scene: Scene, inputs: Mapping[str, Callable[[float], float]] | None = None):
        super().__init__(scene)
        self.inputs = dict(inputs or {})
        armature = np.array([link.joint_armature for link in self.links])
        limits = [link.joint_torque_limit for link in self.links]
        self.limit = np.array([math.inf if limit is None else limit for limit in limits])
        self.exists = np.ones(self.n)
        if not self.free.start:
            self.exists[0] = armature[0] = 0.0
            self.limit[0] = math.inf
        gradient = np.eye(self.n) - np.eye(self.n, k=-1)
        self.inertia = self.inertia + gradient.T @ np.diag(armature) @ gradient
        self.drives = self.exists * (np.isfinite(self.limit) | scene.inputs.joint_targets)

    def given(self, name: str, otherwise: Any, time: float) -> np.ndarray:
        """Return the values of an input for all joints; ``otherwise`` for joints without this input."""
        functions = [self.inputs.get(f"joint[{i + 1}].{name}") for i in range(self.n)]
        values = np.array(otherwise * np.ones(self.n))
        return np.array([value if f is None else f(time) for f, value in zip(functions, values, strict=True)])

    def wanted(self, time: float, y: np.ndarray) -> np.ndarray:
        """Return the torques of motors, springs and dampers before their limits apply."""
        n = self.n
        bend, turn = np.diff(y[2 : n + 2], prepend=0), np.diff(y[n + 4 : 2 * n + 4], prepend=0)
        spring = self.stiffness * (self.given("target_angle", self.rest, time) - bend)
        damper = self.damping * (self.given("target_velocity", 0.0, time) - turn)
        return self.exists * (self.given("torque", 0.0, time) + spring + damper)

    def driven_rate(self, time: float, y: np.ndarray, modes: np.ndarray) -> np.ndarray:
        """Return the rate of the state in a phase, in which ``modes`` are constant.

        The mode of a joint is 0 if its torque is below its limit, else the sign of the torque at the limit.
        """
        n = self.n
        torque = np.where(modes == 0, self.wanted(time, y), modes * np.where(modes == 0, 0.0, self.limit))
        matrix, forces = self.assemble(y[2 : n + 2], y[n + 4 : 2 * n + 4])
        forces[2:] += torque
        forces[2:-1] -= torque[1:]
        rate = np.concatenate([y[n + 2 : 2 * n + 4], self.answer(matrix, forces)])
        turn = np.diff(y[n + 4 : 2 * n + 4], prepend=0)
        return np.append(rate, self.drives * torque @ turn)

    def reached(self, end: float) -> np.ndarray:
        """Return the state at a time [s], with the energy that the drives have supplied."""
        time, y, modes = 0.0, np.append(self.start, 0.0), np.zeros(self.n)
        wanted = self.wanted(0.0, y)
        modes = np.where(np.abs(wanted) > self.limit, np.sign(wanted), 0.0)
        while time < end:
            events = [_end_of(self, i, modes[i]) for i in range(self.n) if np.isfinite(self.limit[i])]
            joints = [i for i in range(self.n) if np.isfinite(self.limit[i])]
            step = solve_ivp(
                lambda t, z, modes=modes: self.driven_rate(t, z, modes),
                (time, end),
                y,
                "DOP853",
                rtol=1e-13,
                atol=1e-14,
                events=events,
            )
            time, y = step.t[-1], step.y[:, -1]
            if step.status == 1:
                ended = [i for i, event_times in zip(joints, step.t_events, strict=True) if len(event_times)]
                wanted, modes = self.wanted(time, y), modes.copy()
                for i in ended:
                    modes[i] = 0.0 if modes[i] else np.sign(wanted[i])
        return y


def _end_of(chain: DrivenChain, i: int, mode: float) -> Callable[[float, np.ndarray], float]:
    """Return a function that falls through zero where the mode of a drive ends."""

    def end(time: float, y: np.ndarray) -> float:
        torque, limit = chain.wanted(time, y)[i], chain.limit[i]
        return float(mode * torque - limit if mode else limit - abs(torque))

    end.terminal, end.direction = True, -1  # type: ignore[attr-defined]
    return end
