"""An Euler–Bernoulli beam that hits with one end: the sum of its free modes, integrated by scipy.

The model shares no code with the kernel, and does not use a chain of rigid links.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from chain_impact import Result, simulate
from chain_impact.scene.scene import Scene, with_values

Vector = NDArray[np.float64]
MODES = 40


@dataclass(frozen=True)
class Bar:
    """A round steel bar that drops flat, and a support under one end with the force K δ^1.5."""

    length: float  # m
    thickness: float = 0.012  # m
    young: float = 2.1e11  # Pa
    density: float = 7850.0  # kg/m³
    stiffness: float = 1e9  # N/m^1.5
    speed: float = 0.5  # m/s

    @property
    def mass(self) -> float:
        """The mass [kg]."""
        return self.density * math.pi * self.thickness**2 / 4 * self.length

    @property
    def bending(self) -> float:
        """The bending stiffness E I [N·m²]."""
        return self.young * math.pi * self.thickness**4 / 64

    def frequencies(self) -> Vector:
        """Return the frequencies of the free beam [rad/s]: (x/L)² √(E I L/m) with cos x cosh x = 1."""
        guesses = (2 * np.arange(1, MODES + 1) + 1) * math.pi / 2
        # from the sixth frequency on the guess has an error below 2e-10 of its value
        roots = [
            brentq(lambda x: math.cos(x) - 1 / math.cosh(x), guess - 0.1, guess + 0.1, xtol=1e-14)
            for guess in guesses[:5]
        ]
        waves = np.array([*roots, *guesses[5:]])
        return (waves / self.length) ** 2 * math.sqrt(self.bending * self.length / self.mass)

    def impact(self, times: Vector) -> tuple[Vector, float]:
        """Return the force [N] at each of the times after the first touch, and the whole impulse [N·s].

        In modes whose mean square is 1, the struck end has the amplitude 1 and √3 in the two rigid modes, and
        2 in each bending mode: q̈ = −ω² q + φ F/m, and the end is at φ·q.
        """
        squares = np.concatenate([[0.0, 0.0], self.frequencies() ** 2])
        shape = np.concatenate([[1.0, math.sqrt(3.0)], np.full(MODES, 2.0)])
        count = len(shape)

        def force(y: Vector) -> Vector:
            return self.stiffness * np.maximum(0.0, -(shape @ y[:count])) ** 1.5

        def rate(_time: float, y: Vector) -> Vector:
            push = force(y)
            return np.concatenate([y[count:-1], shape * push / self.mass - squares * y[:count], [push]])

        start = np.zeros(2 * count + 1)
        start[count] = -self.speed
        solution = solve_ivp(
            rate, (0.0, times[-1]), start, "DOP853", times, rtol=1e-9, atol=1e-13, max_step=2e-5
        )
        return force(solution.y), float(solution.y[-1, -1])

    def restitution(self, impulse: float) -> float:
        """Return the restitution of the bar without vibration: 4 p/(m u) − 1 for the impulse p."""
        return 4 * impulse / (self.mass * self.speed) - 1

    def chain(self, scene: Scene, links: int, tolerance: float) -> Result:
        """Return the result of the bar as a chain of ``links`` links, with the settings of a scene."""
        part = self.length / links
        link = {"length": part, "mass": self.mass / links, "joint_stiffness": self.bending / part}
        changes = {
            ("chain", "links"): [link | {"count": links}],
            ("initial", "angles"): [0.0] * links,
            ("initial", "angular_velocities"): None,
        }
        return simulate(with_values(scene, changes), tolerance=tolerance)


def impulse(result: Result) -> float:
    """Return the impulse [N·s] of the support in a whole run."""
    return float(result["contact[0].y_min.impulse"][-1])
