"""An independent model of the chain in the form of a textbook: an assembled mass matrix and no recursion.

It shares no code with the kernel: tests and benchmarks compare the kernel with it. q = (x₀, y₀, θ).
With u_i the unit vector along link i, s_ji = ℓ_i for i < j and the centre-of-mass distance for i = j, the
centre of link j is at p₀ + Σ_i s_ji u_i. Hence, with B = Sᵀ diag(m) S and β = Sᵀ m, M q̈ = Q − h has
    M = [m_total 1, β_i u⊥_i; ·, B_ij cos(θ_i − θ_j) + I_i δ_ij],
    h = [−Σ β_i ω_i² u_i; Σ_j B_ij ω_j² sin(θ_i − θ_j)].

A centre of mass e_j to the left of the line adds e_j u⊥_j to its place. With E = diag(e), ε = m e and
K = Sᵀ diag(m) E − E diag(m) S this adds
    m_j e_j² δ_ij + K_ij sin(θ_i − θ_j) to M_ij, −ε_i u_i beside β_i u⊥_i,
    [−Σ ε_i ω_i² u⊥_i; −Σ_j K_ij ω_j² cos(θ_i − θ_j)] to h.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from chain_impact.scene.scene import Scene


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
        beside = np.array([link.center_of_mass_offset for link in links], real)
        self.inertia = np.diag(np.array([link.inertia for link in links], real) + mass * beside**2)
        self.moment_beside = mass * beside
        self.coupling_beside = arms.T * self.moment_beside - self.moment_beside[:, None] * arms
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
        """Return M, shape (N+2, N+2), and Q − h of gravity alone, (N+2,).

        Both are valid until the next call.
        """
        matrix, right = self.matrix, self.right
        cos, sin = np.cos(angle), np.sin(angle)
        normals = np.stack([-sin, cos])
        # cos(θ_i − θ_j) and sin(θ_i − θ_j), by the addition theorems
        matrix[2:, 2:] = self.coupling * (np.outer(cos, cos) + np.outer(sin, sin)) + self.inertia
        matrix[:2, 2:] = self.first_moment * normals
        matrix[2:, :2] = matrix[:2, 2:].T
        w2 = omega * omega
        right[:2] = self.total_mass * self.gravity
        right[0] += (self.first_moment * w2) @ cos
        right[1] += (self.first_moment * w2) @ sin
        right[2:] = self.first_moment * (self.gravity @ normals)
        right[2:] -= (self.coupling * (np.outer(sin, cos) - np.outer(cos, sin))) @ w2
        if self.moment_beside.any():
            along = np.stack([cos, sin])
            matrix[2:, 2:] += self.coupling_beside * (np.outer(sin, cos) - np.outer(cos, sin))
            matrix[:2, 2:] -= self.moment_beside * along
            matrix[2:, :2] = matrix[:2, 2:].T
            right[:2] += normals @ (self.moment_beside * w2)
            right[2:] -= self.moment_beside * (self.gravity @ along)
            right[2:] += (self.coupling_beside * (np.outer(cos, cos) + np.outer(sin, sin))) @ w2
        return matrix, right

    def jacobian(self, angle: np.ndarray, point: int) -> np.ndarray:
        """Return J with ṗ = J q̇ for a point 0…N, shape (2, N+2)."""
        jacobian = np.zeros((2, self.n + 2), self.length.dtype)
        jacobian[0, 0] = jacobian[1, 1] = 1
        before = np.asarray(angle)[:point]
        jacobian[:, 2 : 2 + point] = self.length[:point] * np.stack([-np.sin(before), np.cos(before)])
        return jacobian

    def rate(
        self, y: np.ndarray, loads: Iterable[tuple[int, int, Any]] = (), torques: Any = None
    ) -> np.ndarray:
        """Return (q̇, q̈) for loads (point, axis, force) and torques on links from the preceding links."""
        matrix, right = self.balance(y, torques)
        for point, axis, force in loads:
            right += self.jacobian(y[2 : self.n + 2], point)[axis] * force
        return np.concatenate([y[self.n + 2 :], self.answer(matrix, right)])

    def balance(self, y: np.ndarray, torques: Any = None) -> tuple[np.ndarray, np.ndarray]:
        """Return M and Q − h of gravity, joints and torques, valid until the next call."""
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
        """Return M⁻¹ f; for a pinned base the first two entries, of the base, are 0."""
        if not self.free.start:
            return self.solve(matrix, forces)
        free, answer = self.free, np.zeros_like(forces)
        answer[free] = self.solve(matrix[free, free], forces[free])
        return answer

    def loss(self, y: np.ndarray) -> Any:
        """Return the power [W] that dampers of joints dissipate."""
        return self.damping @ np.diff(y[self.n + 4 :], prepend=0) ** 2

    def points(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return positions and velocities of the points 0…N, shape (N+1, 2)."""
        n = self.n
        angle, omega = y[2 : n + 2], y[n + 4 :]
        links = self.length[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        moves = omega[:, None] * np.stack([-links[:, 1], links[:, 0]], axis=1)
        position = np.concatenate([y[None, :2], y[:2] + np.cumsum(links, axis=0)])
        velocity = np.concatenate([y[None, n + 2 : n + 4], y[n + 2 : n + 4] + np.cumsum(moves, axis=0)])
        return position, velocity
