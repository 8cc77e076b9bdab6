"""Scenes with dry friction in joints that have exact answers.

A joint with the angle ψ_i = θ_i − θ_{i−1} slides with the moment −M sign(ψ̇) on link i and +M sign(ψ̇) on link
i − 1, or sticks with a moment of at most M. Each builder returns a scene as its file has it, and what must
come of it. Units are SI.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mpmath

from tests.coulomb_problems import Pushed, Table, pushes
from tests.problems import GRAVITY, contact_table, scene_table

DIGITS = 30  # of quadratures


def _table(name: str, links: Sequence[dict[str, float]], initial: dict[str, Any], **more: Any) -> Table:
    """A scene without walls."""
    return scene_table(name, links, initial, {}, contact_table(points=[]), **more)


# --- one pinned link ---------------------------------------------------------------------------------------

LINK = {"length": 0.8, "mass": 1.5}
INERTIA = LINK["mass"] * LINK["length"] ** 2 / 3  # about the pin, kg·m²


@dataclass(frozen=True)
class Braked:
    """A link that turns ever slower: when it stops [s], and the angle that it has turned [rad]."""

    stop: float
    turned: float


def braked_link(speed: float, moment: float) -> tuple[Table, Braked]:
    """A pinned link without gravity: ω̇ = −M/I, so it stops at I ω/M, after I ω²/(2M)."""
    stop = INERTIA * abs(speed) / moment
    initial = {"angles": [0.0], "angular_velocities": [speed]}
    table = _table(
        "BrakedLink", [LINK | {"joint_friction": moment}], initial, base="pinned", stop_time=1.5 * stop
    )
    return table, Braked(stop, 0.5 * speed * stop)


def driven_link(moment: float, count: int = 6) -> tuple[Table, dict[str, Any], Pushed]:
    """A pinned link without gravity that a motor turns to and fro, against its dry joint; and the inputs."""
    times, values = pushes(1.4 * moment, count, 0.2)
    # the last torque is too weak to move it
    times, values = (*times, times[-1] + 0.3), (*values, 0.99 * moment)
    table = _table(
        "DrivenLink",
        [LINK | {"joint_friction": moment}],
        {"angles": [0.0]},
        base="pinned",
        stop_time=times[-1] + 0.2,
        inputs={"joint_torques": True},
    )
    inputs = {"joint[1].torque": (list(times), list(values))}
    return table, inputs, Pushed(INERTIA, moment, moment, times, values)


@dataclass(frozen=True)
class Swings:
    """A pendulum with a dry joint that is let go: where it turns back, and at last stops.

    Attributes:
        angles: from the horizontal, the start among them [rad].
        times: [s].
        dissipated: after each of the half swings [J].
    """

    angles: tuple[float, ...]
    times: tuple[float, ...]
    dissipated: tuple[float, ...]


def dry_pendulum(start: float, moment: float) -> tuple[Table, Swings]:
    """A link that is let go under gravity, at an angle [rad] from +x.

    Each half swing takes M |Δθ| of its energy: V(θ₁) + M |θ₁ − θ₀| = V(θ₀), V = m g c sin θ. It stops where
    |V′| ≤ M. A half swing lasts ∫ dθ/ω, with I ω²/2 = V(θ₀) − V(θ) − M |θ − θ₀|, which is regular in u for
    θ = (θ₀ + θ₁)/2 + (θ₁ − θ₀)/2 sin u.
    """
    weight = LINK["mass"] * GRAVITY * LINK["length"] / 2
    with mpmath.workdps(DIGITS):
        angle, time, lost = mpmath.mpf(start), mpmath.mpf(0), mpmath.mpf(0)
        rows = [(angle, time, lost)]
        while abs(weight * mpmath.cos(angle)) > moment:
            sign = -mpmath.sign(mpmath.cos(angle))

            def kinetic(theta: Any, first: Any = angle, sign: Any = sign) -> Any:
                return weight * (mpmath.sin(first) - mpmath.sin(theta)) - moment * sign * (theta - first)

            fastest = -mpmath.pi / 2 - sign * mpmath.asin(moment / weight)
            # up to the mirror image of the start, as far as it would swing without friction
            bracket = (fastest, -mpmath.pi - angle)
            last = mpmath.findroot(kinetic, bracket, solver="anderson", tol=1e-50)
            time += _duration(kinetic, angle, last)
            lost += moment * abs(last - angle)
            angle = last
            rows.append((angle, time, lost))
        angles, times, dissipated = (
            tuple(float(value) for value in column) for column in zip(*rows, strict=True)
        )
    table = _table(
        "DryPendulum",
        [LINK | {"joint_friction": moment}],
        {"angles": [start]},
        base="pinned",
        gravity=GRAVITY,
        stop_time=times[-1] + 0.5,
    )
    return table, Swings(angles, times, dissipated)


def _duration(kinetic: Any, first: Any, last: Any) -> Any:
    """How long the link takes from one turning point to the next [s]."""
    middle, half = (first + last) / 2, (last - first) / 2

    def slowness(u: Any) -> Any:
        speed = mpmath.sqrt(2 * kinetic(middle + half * mpmath.sin(u)) / INERTIA)
        return abs(half) * mpmath.cos(u) / speed

    # of the rules of mpmath this one has no nodes that are all but at the ends
    return mpmath.quad(slowness, [-mpmath.pi / 2, 0, mpmath.pi / 2], method="gauss-legendre")


# --- two links in free fall --------------------------------------------------------------------------------


@dataclass(frozen=True)
class Coupled:
    """Two flywheels on one dry axle: ω of each at a time, and when they turn as one [s]."""

    inertias: tuple[float, float]
    omegas: tuple[float, float]
    moment: float

    @property
    def stop(self) -> float:
        """|ω₂ − ω₁|/(M (1/I₁ + 1/I₂)) [s]."""
        return abs(self.omegas[1] - self.omegas[0]) / (self.moment * sum(1.0 / i for i in self.inertias))

    def speeds(self, time: float) -> tuple[float, float]:
        """ω₁ and ω₂ [rad/s]."""
        moment = math.copysign(self.moment, self.omegas[1] - self.omegas[0]) * min(time, self.stop)
        first, second = self.omegas
        return first + moment / self.inertias[0], second - moment / self.inertias[1]

    def turned(self, time: float) -> tuple[float, float]:
        """Angles since the start [rad]."""
        slowing = min(time, self.stop)
        pairs = zip(self.omegas, self.speeds(time), strict=True)
        first, second = (
            0.5 * (before + after) * slowing + after * (time - slowing) for before, after in pairs
        )
        return first, second


def flywheels(omegas: tuple[float, float], moment: float) -> tuple[Table, Coupled]:
    """Two links in free fall whose centres of mass are at their joint: ω₂ − ω₁ falls linearly.

    I₁ ω₁ + I₂ ω₂, the angular momentum, stays.
    """
    inertias = (0.05, 0.02)
    links = [
        {"length": 0.4, "mass": 1.0, "center_of_mass": 0.4, "inertia": inertias[0]},
        {"length": 0.3, "mass": 0.5, "center_of_mass": 0.0, "inertia": inertias[1], "joint_friction": moment},
    ]
    exact = Coupled(inertias, omegas, moment)
    # the joint is at rest, so the base is not
    initial = {"angles": [0.0, 1.0], "angular_velocities": omegas, "velocity": [0.0, -0.4 * omegas[0]]}
    table = _table("Flywheels", links, initial, gravity=GRAVITY, stop_time=2.0 * exact.stop)
    return table, exact


@dataclass(frozen=True)
class Folding:
    """A symmetric pair of links that folds: when it stops [s], and at which angle of its sides [rad]."""

    stop: float
    angle: float
    energy: float  # of the folding at the start, J


def folding_pair(start: float, speed: float, moment: float) -> tuple[Table, Folding]:
    """Two equal rods in free fall, as mirror images: θ₁ = φ, θ₂ = −φ, from φ̇ = ``speed`` [rad/s].

    Their centres move sideways by ℓ/2 cos φ from their common one, so T = A(φ) φ̇² with
    A = I + m ℓ²/4 sin²φ. The joint turns by 2φ and takes 2M |Δφ|: it stops after Δ = T₀/(2M), at φ_s. With
    |φ_s − φ| = Δ u² and T = 2M Δ u², dt = √(2 Δ A/M) du.
    """
    rod = {"length": 0.5, "mass": 0.8}
    inertia, lateral = rod["mass"] * rod["length"] ** 2 / 12, rod["mass"] * rod["length"] ** 2 / 4
    with mpmath.workdps(DIGITS):
        energy = (inertia + lateral * mpmath.sin(start) ** 2) * mpmath.mpf(speed) ** 2
        extent = energy / (2 * moment)
        last = start + mpmath.sign(speed) * extent

        def slowness(u: Any) -> Any:
            angle = last - mpmath.sign(speed) * extent * u * u
            return mpmath.sqrt(2 * extent * (inertia + lateral * mpmath.sin(angle) ** 2) / moment)

        stop = mpmath.quad(slowness, [0, 1])
    # the middle of the two falls from rest
    rise = rod["length"] * speed * math.cos(start) / 2
    initial = {
        "angles": [start, -start],
        "angular_velocities": [speed, -speed],
        "velocity": [rod["length"] * speed * math.sin(start), -rise],
    }
    table = _table(
        "FoldingPair",
        [rod, rod | {"joint_friction": moment}],
        initial,
        gravity=GRAVITY,
        stop_time=1.5 * float(stop),
    )
    return table, Folding(float(stop), float(last), float(energy))
