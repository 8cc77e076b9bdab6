"""The chain once more, as a textbook has it: assembled mass matrix, scipy, terminal events.

It shares nothing with the kernel: tests and the validation compare with it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from chain_impact.scene.scene import WALLS, Scene


def damping_factor(scene: Scene) -> float:
    """λ of a scene's law: 0 of Hertz's, that of Zhang & Sharf from λ(1+e) = ln[(1+λ)/(1−λe)]."""
    e = scene.contact.restitution
    if scene.contact.model != "zhang_sharf":
        assert scene.contact.model in ("hertz", "newton_impact")
        return 0.0
    return brentq(lambda x: x * (1 + e) - np.log((1 + x) / (1 - x * e)), 1e-6, (1 - 1e-15) / e, xtol=1e-15)


class Chain:
    """The chain in the coordinates q = (x₀, y₀, θ), its contacts in a set of (point, wall).

    Contacts are those of Zhang & Sharf's law, of Hertz's, or rigid (``newton_impact``).
    """

    def __init__(self, scene: Scene, inputs: Mapping[str, Any] | None = None) -> None:
        inputs = inputs or {}
        self.scene, self.links = scene, scene.chain.links
        # samples of the torques of all joints, which hold until the next
        torques = [inputs.get(f"joint[{i}].torque") for i in range(1, len(self.links) + 1)]
        self.samples = torques[-1][0] if inputs else np.zeros(1)
        self.torques = np.transpose([[0.0] if torque is None else torque[1] for torque in torques])
        self.count = len(self.links)
        self.free = slice(2 if scene.chain.base == "pinned" else 0, None)
        self.rigid = scene.contact.model == "newton_impact"
        self.factor = damping_factor(scene)
        # number, a point and the inward normal of each wall
        walls = []
        for w, name in enumerate(WALLS):
            axis, at = np.eye(2)[w // 2], getattr(scene.box, name)
            if at is not None:
                walls.append((w, tuple(at * axis), tuple((1 - 2 * (w % 2)) * axis)))
        for w, wall in enumerate(scene.walls, start=len(WALLS)):
            walls.append((w, wall.point, (-np.sin(wall.angle), np.cos(wall.angle))))
        self.candidates = [(k, *wall) for k in scene.contact.points for wall in walls]
        self.active = {}  # candidate → v0

    def place(self, y, link, part):
        """Jacobian of a point at a part of a link, and the acceleration at q̈ = 0."""
        jacobian, bias = np.zeros((2, 2 + self.count)), np.zeros(2)
        jacobian[:, :2] = np.eye(2)
        position = y[:2].copy()
        for j in range(link + 1):
            length = self.links[j].length * (part if j == link else 1.0)
            angle, omega = y[2 + j], y[self.count + 4 + j]
            along = length * np.array([np.cos(angle), np.sin(angle)])
            jacobian[:, 2 + j] = -along[1], along[0]
            bias -= omega**2 * along
            position += along
        return position, jacobian, bias

    def gap(self, y, candidate):
        """Clearance, its gradient and its rate."""
        point, _, at, normal = candidate
        position, jacobian, _ = self.place(y, point - 1, 1.0)
        gradient = normal @ jacobian
        clearance = normal @ (position - at) - self.scene.contact.radius
        return clearance, gradient, gradient @ y[self.count + 2 :]

    def dynamics(self, y):
        """Mass matrix, and the forces at q̈ = 0 without those of the walls."""
        n = self.count
        mass, force = np.zeros((n + 2, n + 2)), np.zeros(n + 2)
        for i, link in enumerate(self.links):
            _, jacobian, bias = self.place(y, i, link.center_of_mass / link.length)
            mass += link.mass * jacobian.T @ jacobian
            mass[2 + i, 2 + i] += link.inertia
            force += link.mass * jacobian.T @ (np.array(self.scene.gravity) - bias)
            if i > 0 or self.free.start:
                bend = y[2 + i] - (y[1 + i] if i else 0.0) - link.joint_rest_angle
                torque = link.joint_stiffness * bend
                torque += link.joint_damping * (y[n + 4 + i] - (y[n + 3 + i] if i else 0.0))
                torque -= self.torques[self.sample, i]
                force[2 + i] -= torque
                force[1 + i] += torque if i else 0.0
        return mass, force

    def rate(self, _time, y):
        """(q̇, q̈) of the state (q, q̇)."""
        n, contact = self.count, self.scene.contact
        mass, force = self.dynamics(y)
        for candidate, speed in self.active.items():
            gap, gradient, gap_rate = self.gap(y, candidate)
            depth = max(0.0, -gap)
            elastic = contact.stiffness * depth**contact.exponent
            force += gradient * elastic * max(0.0, 1 - self.factor * gap_rate / speed)
        acceleration = np.zeros(n + 2)
        acceleration[self.free] = np.linalg.solve(mass[self.free, self.free], force[self.free])
        return np.concatenate([y[n + 2 :], acceleration])

    def run(self, times):
        """The state at each of the times, and the onsets (time, point, wall, speed)."""
        initial = self.scene.initial
        y = np.array([*initial.position, *initial.angles, *initial.velocity, *initial.angular_velocities])
        states, onsets, now = np.zeros((len(times), len(y))), [], 0.0
        while now < times[-1]:
            events = [self.event(candidate) for candidate in self.candidates]
            # a contact of usual stiffness lasts some milliseconds
            longest = 5e-5 if self.active and self.scene.contact.stiffness > 1e6 else 5e-3
            self.sample = np.searchsorted(self.samples, now, side="right") - 1
            changes = self.samples[self.sample + 1 :]
            done = solve_ivp(
                self.rate,
                (now, min([times[-1], *changes[:1]])),
                y,
                method="DOP853",
                rtol=1e-12,
                atol=1e-13,
                max_step=longest,
                events=events,
                dense_output=True,
            )
            inside = (times >= now) & (times <= done.t[-1])
            if inside.any():
                states[inside] = done.sol(times[inside]).T
            now, y = done.t[-1], done.y[:, -1]
            for candidate, found in zip(self.candidates, done.t_events, strict=True):
                if found.size and candidate in self.active:
                    del self.active[candidate]
                elif found.size:
                    speed = -self.gap(y, candidate)[2]
                    onsets.append((now, *candidate[:2], speed))
                    if self.rigid:
                        y = self.reflected(y, candidate)
                    else:
                        self.active[candidate] = speed
        return states, onsets

    def event(self, candidate):
        def clearance(_time, y):
            return self.gap(y, candidate)[0]

        clearance.terminal = True
        clearance.direction = 1 if candidate in self.active else -1
        return clearance

    def reflected(self, y, candidate):
        """The state after an impact of Newton's law: q̇⁺ = q̇ − M⁻¹Jᵀ (1+e) u/(J M⁻¹Jᵀ), u = J q̇."""
        mass, _ = self.dynamics(y)
        _, gradient, speed = self.gap(y, candidate)
        answer = np.zeros(self.count + 2)
        answer[self.free] = np.linalg.solve(mass[self.free, self.free], gradient[self.free])
        jump = -(1 + self.scene.contact.restitution) * speed / (gradient @ answer) * answer
        return np.concatenate([y[: self.count + 2], y[self.count + 2 :] + jump])
