"""A pinned arm of two equal rods on a rigid floor: the two times at which its impacts accumulate.

It shares nothing with the kernel: explicit equations of motion in the two angles, scipy at 1e-13, the sums of
geometric series, and a quadrature for what one angle does alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad, solve_ivp

from chain_impact.scene.scene import Scene

Vector = NDArray[np.float64]
SHORT = 1e-6  # s, a flight so short that the next ones are e times as long each, within 1e-12 s in the sum


class Arm:
    """Two uniform rods of mass m and length l; the state is y = (θ₁, θ₂, θ̇₁, θ̇₂), angles from +x."""

    def __init__(self, scene: Scene) -> None:
        link = scene.chain.links[0]
        self.mass, self.length = link.mass, link.length
        self.gravity, self.restitution = -scene.gravity[1], scene.contact.restitution
        self.pin = scene.initial.position[1]
        self.start = np.array([*scene.initial.angles, *scene.initial.angular_velocities])

    def matrix(self, y: Vector) -> Vector:
        """Mass matrix: m l² (4/3, ½ cos(θ₁ − θ₂); ½ cos(θ₁ − θ₂), 1/3)."""
        coupled = math.cos(y[0] - y[1]) / 2
        return self.mass * self.length**2 * np.array([[4 / 3, coupled], [coupled, 1 / 3]])

    def rate(self, _time: float, y: Vector) -> Vector:
        """ẏ, of M θ̈ = −½ m l² sin(θ₁ − θ₂) (θ̇₂², −θ̇₁²) − m g l (3/2 cos θ₁, ½ cos θ₂)."""
        turn = -self.mass * self.length**2 / 2 * math.sin(y[0] - y[1])
        weight = self.mass * self.gravity * self.length
        force = [
            turn * y[3] ** 2 - 1.5 * weight * math.cos(y[0]),
            -turn * y[2] ** 2 - 0.5 * weight * math.cos(y[1]),
        ]
        return np.concatenate([y[2:], np.linalg.solve(self.matrix(y), force)])

    def height(self, y: Vector, point: int) -> float:
        """Height [m] of the elbow (1) or of the tip (2)."""
        return float(self.pin + self.length * np.sin(y[:point]).sum())

    def gradient(self, y: Vector, point: int) -> Vector:
        """Of that height: l (cos θ₁, 0) or l (cos θ₁, cos θ₂)."""
        return self.length * np.cos(y[:2]) * [1.0, point - 1.0]

    def speed(self, y: Vector, point: int) -> float:
        """Rate [m/s] of that height."""
        return float(self.gradient(y, point) @ y[2:])

    def reflected(self, y: Vector, point: int, restitution: float) -> Vector:
        """After an impact: θ̇⁺ = θ̇ − (1 + e) u M⁻¹J/(J M⁻¹J), u = J θ̇."""
        gradient = self.gradient(y, point)
        answer = np.linalg.solve(self.matrix(y), gradient)
        jump = (1 + restitution) * self.speed(y, point) / (gradient @ answer)
        return np.concatenate([y[:2], y[2:] - jump * answer])

    def falls_on(self, point: int) -> Callable[[float, Vector], float]:
        """The event that a point comes down to the floor."""

        def height(_time: float, y: Vector) -> float:
            return self.height(y, point)

        height.terminal = True  # type: ignore[attr-defined]
        height.direction = -1.0  # type: ignore[attr-defined]
        return height


def first_accumulation(arm: Arm) -> tuple[float, int, Vector]:
    """Time [s] at which the impacts of one point accumulate, that point, and the state there."""
    now, y, last = 0.0, arm.start, {1: -1.0, 2: -1.0}
    flight = 1.0
    while True:
        done = solve_ivp(
            arm.rate,
            (now, now + 1.0),
            y,
            method="DOP853",
            rtol=1e-13,
            atol=1e-15,
            # eight steps or more in each flight, so that none is overlooked
            max_step=min(1e-3, flight / 8),
            events=[arm.falls_on(1), arm.falls_on(2)],
        )
        now = float(done.t[-1])
        point = 1 if done.t_events[0].size else 2
        y = arm.reflected(done.y[:, -1], point, arm.restitution)
        flight, last[point] = now - last[point], now
        if flight < SHORT:
            # the flights to come: Σ flight eᵏ from k = 1
            rest = flight * arm.restitution / (1 - arm.restitution)
            # their impulses add up to what brings the point to rest
            return now + rest, point, arm.reflected(y + rest * arm.rate(now, y), point, 0.0)
        # how long the next one takes, if the point keeps its acceleration
        lift = (arm.speed(y + 1e-7 * arm.rate(now, y), point) - arm.speed(y, point)) / 1e-7
        flight = min(flight, 2 * arm.speed(y, point) / -lift) if lift < 0 else flight


def second_accumulation(arm: Arm, start: float, y: Vector) -> float:
    """Time [s] at which the tip rests, too, after the elbow rests on the floor from ``start``.

    Then θ₁ is fixed and rod 2 turns about the elbow: θ̇² + (3 g/l) sin θ is constant, with θ = 0 or π on the
    floor; θ̇⁺ = −e θ̇⁻ at an impact.
    """
    pull = 3 * arm.gravity / arm.length
    # mirrored, so that the rod stands on the side of θ = 0
    angle, rate = (y[1], y[3]) if math.cos(y[1]) > 0 else (math.pi - y[1], -y[3])

    def up(top: float, low: float) -> float:
        """Time [s] between an angle and the highest one: ∫ dθ/√(c (sin θ_top − sin θ)), θ = θ_top − s²."""

        def integrand(s: float) -> float:
            # sin a − sin b = 2 cos((a + b)/2) sin((a − b)/2)
            drop = 2 * math.cos(top - s * s / 2) * math.sin(s * s / 2)
            return 2 * s / math.sqrt(pull * drop) if s else 2 / math.sqrt(pull * math.cos(top))

        return float(quad(integrand, 0.0, math.sqrt(top - low), epsabs=1e-15, epsrel=1e-13)[0])

    def top_of(square: float) -> float:
        """The highest angle of a rod that leaves the floor with θ̇² = ``square``."""
        return math.asin(square / pull)

    square = rate**2 + pull * math.sin(angle)  # θ̇² on the floor
    top = top_of(square)
    now = start + up(top, 0.0) + math.copysign(up(top, angle), rate)
    while square > 1e-26:
        square *= arm.restitution**2
        now += 2 * up(top_of(square), 0.0)
    return now
