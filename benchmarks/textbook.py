"""The equations of motion as an engineer assembles them: M(q) q̈ = Q − h, in NumPy, with no recursion.

q = (x₀, y₀, θ). With u_i the unit vector along link i, s_ji = ℓ_i for i < j and the centre-of-mass distance
for i = j, the centre of link j is at p₀ + Σ_i s_ji u_i. Hence, with B = Sᵀ diag(m) S and β = Sᵀ m,
    M = [m_total 1, β_i u⊥_i; ·, B_ij cos(θ_i − θ_j) + I_i δ_ij],
    h = [−Σ β_i ω_i² u_i; Σ_j B_ij ω_j² sin(θ_i − θ_j)].
It works in any NumPy precision.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from chain_impact.scene.scene import Scene


class Textbook:
    """The chain of a scene with a free base, in the floating-point type ``real``."""

    def __init__(self, scene: Scene, real: type = np.float64, solve: Callable[..., Any] = np.linalg.solve):
        links = scene.chain.links
        self.n = n = len(links)
        self.solve = solve
        self.length = np.array([link.length for link in links], real)
        mass = np.array([link.mass for link in links], real)
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

    def rate(self, y: np.ndarray, loads: list[tuple[int, int, Any]] = ()) -> np.ndarray:
        """f(y) for y = (q, q̇) and loads (point, axis, force)."""
        n, matrix, right = self.n, self.matrix, self.right
        angle, omega = y[2 : n + 2], y[n + 4 :]
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
        for point, axis, force in loads:
            right[axis] += force
            right[2 : 2 + point] += self.length[:point] * normals[axis, :point] * force
        return np.concatenate([y[n + 2 :], self.solve(matrix, right)])

    def points(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Positions and velocities of the points 0…N, shape (N+1, 2)."""
        n = self.n
        angle, omega = y[2 : n + 2], y[n + 4 :]
        links = self.length[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        moves = omega[:, None] * np.stack([-links[:, 1], links[:, 0]], axis=1)
        position = np.concatenate([y[None, :2], y[:2] + np.cumsum(links, axis=0)])
        velocity = np.concatenate([y[None, n + 2 : n + 4], y[n + 2 : n + 4] + np.cumsum(moves, axis=0)])
        return position, velocity
