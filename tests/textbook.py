"""The chain once more, as a textbook has it: assembled mass matrix, no recursion, scipy, terminal events.

It shares nothing with the kernel: tests, the validation and the benchmarks compare with it. q = (x₀, y₀, θ).
With u_i the unit vector along link i, s_ji = ℓ_i for i < j and the centre-of-mass distance for i = j, the
centre of link j is at p₀ + Σ_i s_ji u_i. Hence, with B = Sᵀ diag(m) S and β = Sᵀ m, M q̈ = Q − h has
    M = [m_total 1, β_i u⊥_i; ·, B_ij cos(θ_i − θ_j) + I_i δ_ij],
    h = [−Σ β_i ω_i² u_i; Σ_j B_ij ω_j² sin(θ_i − θ_j)].
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
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


class Textbook:
    """The chain of a scene in flight, in any floating-point type ``real`` of NumPy; y = (q, q̇)."""

    def __init__(self, scene: Scene, real: type = np.float64, solve: Callable[..., Any] = np.linalg.solve):
        links = scene.chain.links
        self.scene, self.links, self.solve = scene, links, solve
        self.n = n = len(links)
        self.free = slice(2 if scene.chain.base == "pinned" else 0, None)
        names = ("length", "mass", "joint_stiffness", "joint_damping", "joint_rest_angle")
        self.length, mass, *joints = (np.array([getattr(one, name) for one in links], real) for name in names)
        self.stiffness, self.damping, self.rest = joints
        if not self.free.start:
            self.stiffness[0] = self.damping[0] = 0.0
        self.resisting = self.stiffness.any() or self.damping.any()
        arms = np.tril(np.tile(self.length, (n, 1)), -1)
        arms += np.diag(np.array([link.center_of_mass for link in links], real))
        self.coupling = arms.T @ (mass[:, None] * arms)
        self.first_moment = arms.T @ mass
        self.inertia = np.diag(np.array([link.inertia for link in links], real))
        self.total_mass = mass.sum()
        self.gravity = np.array(scene.gravity, real)
        self.matrix = np.zeros((n + 2, n + 2), real)
        self.matrix[0, 0] = self.matrix[1, 1] = self.total_mass
        self.right = np.zeros(n + 2, real)

    @property
    def start(self) -> np.ndarray:
        """The state at time 0."""
        first = self.scene.initial
        return np.array([*first.position, *first.angles, *first.velocity, *first.angular_velocities])

    def assemble(self, angle: np.ndarray, omega: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """M, shape (N+2, N+2), and Q − h of gravity alone, shape (N+2,), until the next call."""
        matrix, right = self.matrix, self.right
        cos, sin = np.cos(angle), np.sin(angle)
        normals = np.stack([-sin, cos])
        # cos(θ_i − θ_j) and sin(θ_i − θ_j) by the addition theorems
        matrix[2:, 2:] = self.coupling * (np.outer(cos, cos) + np.outer(sin, sin)) + self.inertia
        matrix[:2, 2:] = self.first_moment * normals
        matrix[2:, :2] = matrix[:2, 2:].T
        w2 = omega * omega
        right[:2] = self.total_mass * self.gravity
        right[0] += (self.first_moment * w2) @ cos
        right[1] += (self.first_moment * w2) @ sin
        right[2:] = self.first_moment * (self.gravity @ normals)
        right[2:] -= (self.coupling * (np.outer(sin, cos) - np.outer(cos, sin))) @ w2
        return matrix, right

    def jacobian(self, angle: np.ndarray, point: int) -> np.ndarray:
        """J with ṗ = J q̇ for a point 0…N, shape (2, N+2)."""
        jacobian = np.zeros((2, self.n + 2), self.length.dtype)
        jacobian[0, 0] = jacobian[1, 1] = 1
        before = np.asarray(angle)[:point]
        jacobian[:, 2 : 2 + point] = self.length[:point] * np.stack([-np.sin(before), np.cos(before)])
        return jacobian

    def rate(
        self, y: np.ndarray, loads: Iterable[tuple[int, int, Any]] = (), torques: Any = None
    ) -> np.ndarray:
        """(q̇, q̈) for loads (point, axis, force), and torques on the links from those before them."""
        matrix, right = self.balance(y, torques)
        for point, axis, force in loads:
            right += self.jacobian(y[2 : self.n + 2], point)[axis] * force
        return np.concatenate([y[self.n + 2 :], self.answer(matrix, right)])

    def balance(self, y: np.ndarray, torques: Any = None) -> tuple[np.ndarray, np.ndarray]:
        """M and Q − h of gravity, joints and torques, until the next call."""
        angle, omega = y[2 : self.n + 2], y[self.n + 4 :]
        matrix, right = self.assemble(angle, omega)
        if self.resisting or torques is not None:
            bend, turn = (np.diff(values, prepend=0) for values in (angle, omega))
            moment = (0 if torques is None else torques) - self.stiffness * (bend - self.rest)
            moment = moment - self.damping * turn
            right[2:] += moment
            right[2:-1] -= moment[1:]
        return matrix, right

    def answer(self, matrix: np.ndarray, forces: np.ndarray) -> np.ndarray:
        """M⁻¹ f, of a pinned base zero."""
        if not self.free.start:
            return self.solve(matrix, forces)
        free, answer = self.free, np.zeros_like(forces)
        answer[free] = self.solve(matrix[free, free], forces[free])
        return answer

    def loss(self, y: np.ndarray) -> Any:
        """The power that dampers of joints take [W]."""
        return self.damping @ np.diff(y[self.n + 4 :], prepend=0) ** 2

    def points(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Positions and velocities of the points 0…N, shape (N+1, 2)."""
        n = self.n
        angle, omega = y[2 : n + 2], y[n + 4 :]
        links = self.length[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        moves = omega[:, None] * np.stack([-links[:, 1], links[:, 0]], axis=1)
        position = np.concatenate([y[None, :2], y[:2] + np.cumsum(links, axis=0)])
        velocity = np.concatenate([y[None, n + 2 : n + 4], y[n + 2 : n + 4] + np.cumsum(moves, axis=0)])
        return position, velocity


class Chain(Textbook):
    """The same with its contacts in a set of (point, wall).

    Contacts are those of Zhang & Sharf's law, of Hertz's, or rigid (``newton_impact``).
    """

    def __init__(self, scene: Scene, inputs: Mapping[str, Any] | None = None) -> None:
        super().__init__(scene)
        inputs = inputs or {}
        # samples of the torques of all joints, which hold until the next
        torques = [inputs.get(f"joint[{i}].torque") for i in range(1, self.n + 1)]
        self.samples = torques[-1][0] if inputs else np.zeros(1)
        self.torques = np.transpose([[0.0] if torque is None else torque[1] for torque in torques])
        self.sample = 0
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

    def gap(self, y, candidate):
        """Clearance, its gradient and its rate."""
        point, _, at, normal = candidate
        gradient = normal @ self.jacobian(y[2 : self.n + 2], point)
        clearance = normal @ (self.points(y)[0][point] - at) - self.scene.contact.radius
        return clearance, gradient, gradient @ y[self.n + 2 :]

    def motion(self, _time, y):
        """(q̇, q̈) of the state (q, q̇), with the forces of the walls."""
        contact, loads = self.scene.contact, []
        for candidate, speed in self.active.items():
            gap, _, gap_rate = self.gap(y, candidate)
            depth, normal = max(0.0, -gap), candidate[3]
            elastic = contact.stiffness * depth**contact.exponent
            force = elastic * max(0.0, 1 - self.factor * gap_rate / speed)
            loads += [(candidate[0], axis, normal[axis] * force) for axis in (0, 1)]
        return self.rate(y, loads, self.torques[self.sample])

    def run(self, times):
        """The state at each of the times, and the onsets (time, point, wall, speed)."""
        y, states, onsets, now = self.start, np.zeros((len(times), 2 * self.n + 4)), [], 0.0
        while now < times[-1]:
            events = [self.event(candidate) for candidate in self.candidates]
            # a contact of usual stiffness lasts some milliseconds
            longest = 5e-5 if self.active and self.scene.contact.stiffness > 1e6 else 5e-3
            self.sample = np.searchsorted(self.samples, now, side="right") - 1
            changes = self.samples[self.sample + 1 :]
            done = solve_ivp(
                self.motion,
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
        _, gradient, speed = self.gap(y, candidate)
        matrix, _ = self.assemble(y[2 : self.n + 2], y[self.n + 4 :])
        answer = self.answer(matrix, gradient)
        jump = -(1 + self.scene.contact.restitution) * speed / (gradient @ answer) * answer
        return np.concatenate([y[: self.n + 2], y[self.n + 2 :] + jump])
