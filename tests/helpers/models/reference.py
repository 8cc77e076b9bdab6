"""Independent answers: closed forms, quadrature and plain algebra that share no code with the kernel.

Units are SI throughout. The chain's coordinates are q = (x₀, y₀, θ_1…θ_N): the base point and the absolute
link angles.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import mpmath
import numpy as np
from scipy.integrate import solve_ivp

from chain_impact.scene.scene import Scene
from tests.helpers.models.textbook import Textbook

# --- the exact impact of a point mass -----------------------------------------------------------------


@dataclass(frozen=True)
class PointImpact:
    """The impact of a point mass on a wall, without gravity.

    Attributes:
        max_penetration: [m].
        peak_force: [N].
        duration: [s].
        separation_speed: [m/s].
        dissipated: [J].
    """

    max_penetration: float
    peak_force: float
    duration: float
    separation_speed: float
    dissipated: float


def realised_restitution(damping_factor: float) -> float:
    """Return the restitution e′ of F = K δⁿ (1 + λ δ̇/v₀), which depends on λ only.

    λ(1 + e′) = ln[(1+λ)/(1−λe′)], hence e′ = [1 + W₀(−(1+λ) e^{−(1+λ)})]/λ with Lambert's W.
    """
    with mpmath.workdps(50):
        return float(_restitution(mpmath.mpf(damping_factor))) if damping_factor else 1.0


@cache
def exact_damping_factor(restitution: float) -> float:
    """Return the λ whose realised restitution, by Lambert's W in 50 digits, is the given restitution."""
    if restitution == 1.0:
        return 0.0
    with mpmath.workdps(50):
        e = mpmath.mpf(restitution)
        # e′(λ) falls from 1, and λe′ < 1; for small 1 − e, λ = (3/2)(1 − e) + …
        bracket = (1 - e, 1 / e)
        return float(
            mpmath.findroot(lambda lam: _restitution(lam) - e, bracket, solver="anderson", tol=1e-80)
        )


def _restitution(lam: Any) -> Any:
    return (1 + mpmath.lambertw(-(1 + lam) * mpmath.exp(-(1 + lam))).real) / lam


def point_impact(mass: float, speed: float, stiffness: float, exponent: float, damping: float) -> PointImpact:
    """Return the exact impact of a mass m [kg] at a speed v [m/s] under F = K δⁿ (1 + λ δ̇/v).

    With u = δ̇/v from 1 down to −e′ as the variable, m v u du = −K δⁿ (1 + λu) dδ/v gives
      K δⁿ⁺¹/((n+1) m v²) = G(u) = ∫_u¹ s/(1+λs) ds = [λ(1−u) − ln((1+λ)/(1+λu))]/λ²,
      T = ∫ m v/F du over [−e′, 1], and F = K δⁿ (1+λu) has its peak where dF/du = 0.
    For λ = 0 the duration is T = 2 (δ_max/v) √π Γ(1+p)/Γ(½+p), p = 1/(n+1) (Hertz 1881 for n = 3/2).

    Depths are ∝ (m v²/K)^p with p = 1/(n+1), forces ∝ K (m v²/K)^(np), durations ∝ depth over speed.
    """
    deepest, largest, lasting, rebound_speed, lost = _unit_impact(exponent, damping)
    with mpmath.workdps(50):
        m, v, k = (mpmath.mpf(value) for value in (mass, speed, stiffness))
        depth = (m * v**2 / k) ** (1 / (mpmath.mpf(exponent) + 1))
        return PointImpact(
            max_penetration=float(depth * deepest),
            peak_force=float(m * v**2 / depth * largest),
            duration=float(depth / v * lasting),
            separation_speed=float(v * rebound_speed),
            dissipated=float(m * v**2 * lost),
        )


@cache
def _unit_impact(exponent: float, damping: float) -> tuple[Any, ...]:
    """Return depth, force, duration, separation speed and loss of an impact with m = v = K = 1."""
    with mpmath.workdps(50):
        n, lam = mpmath.mpf(exponent), mpmath.mpf(damping)
        p = 1 / (n + 1)
        if lam == 0:
            deepest = ((n + 1) / 2) ** p
            duration = 2 * deepest * mpmath.sqrt(mpmath.pi) * mpmath.gamma(1 + p) / mpmath.gamma(p + 0.5)
            return deepest, deepest**n, duration, 1, 0
        e = _restitution(lam)

        # G from either end, u = 1 − t and u = −e′ + r, so that no digits cancel at the ends
        def falling(t: Any) -> tuple[Any, Any]:
            return 1 - t, (lam * t + mpmath.log1p(-lam * t / (1 + lam))) / lam**2

        def rising(r: Any) -> tuple[Any, Any]:
            return r - e, (mpmath.log1p(lam * r / (1 - lam * e)) - lam * r) / lam**2

        def depth(g: Any) -> Any:
            return ((n + 1) * g) ** p

        def force(u: Any, g: Any) -> Any:
            return depth(g) ** n * (1 + lam * u)

        duration = mpmath.quad(lambda t: 1 / force(*falling(t)), [0, 1])
        duration += mpmath.quad(lambda r: 1 / force(*rising(r)), [0, e])
        # dF/du = 0: n G′(1+λu) + (n+1) λ G = 0 with G′ = −u/(1+λu); the peak is before the largest depth
        top = mpmath.findroot(
            lambda t: (n + 1) * lam * falling(t)[1] - n * falling(t)[0], (1e-9, 1), solver="anderson"
        )
        return depth(falling(mpmath.mpf(1))[1]), force(*falling(top)), duration, e, (1 - e**2) / 2


@dataclass(frozen=True)
class Rebound:
    """An impact with mass, stiffness and speed 1: restitution, largest depth and force."""

    restitution: float
    depth: float
    force: float


def rebound(n: float, p: float, damping: float, approach_only: bool = False) -> Rebound:
    """Return the impact δ̈ = −F, F = max(0, δⁿ + f δᵖ δ̇), for whole 4n and 4p, integrated at 1e-13.

    In z = δ^¼ and s with dt = 4z³ ds the impact is smooth: dz/ds = δ̇, dδ̇/ds = −4z³F. The impact ends where
    F/δᵖ is zero.
    """

    def force(z: Any, w: Any) -> Any:
        return z ** (4 * n) + damping * z ** (4 * p) * (np.maximum(w, 0.0) if approach_only else w)

    def rate(_: float, y: np.ndarray) -> list[float]:
        return [y[1], -4 * y[0] ** 3 * force(*y)]

    def turned(_: float, y: np.ndarray) -> float:
        return y[1]

    def ended(_: float, y: np.ndarray) -> float:
        return y[0] if approach_only or damping == 0.0 else y[0] ** (4 * (n - p)) + damping * y[1]

    turned.terminal, turned.direction = True, -1  # type: ignore[attr-defined]
    ended.terminal, ended.direction = True, -1  # type: ignore[attr-defined]
    accurate = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-15, "dense_output": True}
    going = solve_ivp(rate, (0.0, 1e4), [0.0, 1.0], events=turned, **accurate)
    turn = going.y_events[0][0]
    back = solve_ivp(rate, (0.0, 1e4), [turn[0], 0.0], events=ended, **accurate)
    peak = max(force(*path.sol(np.linspace(0.0, path.t[-1], 20001))).max() for path in (going, back))
    return Rebound(-back.y_events[0][0, 1], turn[0] ** 4, peak)


# --- textbook dynamics: assembled M(q) and h(q, q̇), without a recursion
# ------------------------------------------


def point_jacobian(scene: Scene, angles: Sequence[float], point: int) -> np.ndarray:
    """Return J with ṗ_k = J q̇ for the point k, shape (2, N+2)."""
    return Textbook(scene).jacobian(np.asarray(angles), point)


def centre_jacobian(scene: Scene, angles: Sequence[float], i: int) -> np.ndarray:
    """Return J with ṗ_C = J q̇ for the centre of mass of link i (from 0), shape (2, N+2)."""
    jacobian = point_jacobian(scene, angles, i)
    arm = scene.chain.links[i].center_of_mass
    jacobian[:, 2 + i] = arm * np.array([-np.sin(angles[i]), np.cos(angles[i])])
    return jacobian


def mass_matrix(scene: Scene, angles: Sequence[float]) -> np.ndarray:
    """Return M(q), shape (N+2, N+2)."""
    return Textbook(scene).assemble(np.asarray(angles), np.zeros(len(angles)))[0]


def generalized_force(
    scene: Scene, angles: np.ndarray, omega: np.ndarray, loads: np.ndarray, moments: np.ndarray
) -> np.ndarray:
    """Return Q − c(q, q̇), the right side of M q̈ = Q − c, shape (N+2,).

    Args:
        scene: the chain and gravity.
        angles: θ [rad].
        omega: ω [rad/s].
        loads: force on each point 0…N, shape (N+1, 2) [N].
        moments: net moment on each link [N·m].
    """
    book = Textbook(scene)
    _, total = book.assemble(angles, omega)
    total[2:] += moments
    return total + sum(book.jacobian(angles, k).T @ load for k, load in enumerate(loads))


def random_impedances(rng: np.random.Generator, count: int, largest: float) -> np.ndarray:
    """Return symmetric, positive semidefinite impedances of points [kg], shape (count, 2, 2).

    Each is zero with probability ½.
    """
    parts = rng.uniform(-1.0, 1.0, (count, 2, 2)) * (rng.random((count, 1, 1)) < 0.5)
    return largest * parts @ parts.transpose(0, 2, 1)


def set_impedances(record: Any, impedances: np.ndarray) -> None:
    """Put impedances, shape (N+1, 2, 2), into a record with ``xx, xy, yy``; entries of joints stay."""
    points = len(impedances)
    record["xx"][:points], record["yy"][:points] = impedances[:, 0, 0], impedances[:, 1, 1]
    record["xy"][:points] = impedances[:, 0, 1]


def set_vectors(record: Any, vectors: Any) -> None:
    """Put vectors of the points, shape (N+1, 2), into a record with ``x, y``."""
    record["x"][: len(vectors)], record["y"][: len(vectors)] = np.transpose(vectors)


def clearance_gradient(scene: Scene, angles: Sequence[float], point: int, wall: str) -> np.ndarray:
    """Return ∇g of a point's clearance to a wall, shape (N+2,)."""
    return np.array(scene.half_planes[wall].normal) @ point_jacobian(scene, angles, point)


def newton_impact(
    scene: Scene, angles: Sequence[float], velocity: np.ndarray, contact: tuple[int, str], restitution: float
) -> tuple[np.ndarray, float]:
    """Return velocities q̇⁺ after Newton's impact of a (point, wall), and the effective mass [kg].

    q̇⁺ = q̇⁻ − M⁻¹ Jᵀ m_eff (1+e) J q̇⁻,  m_eff = 1/(J M⁻¹ Jᵀ): the rigid limit of all the force laws.
    """
    gradient = clearance_gradient(scene, angles, *contact)
    response = np.linalg.solve(mass_matrix(scene, angles), gradient)
    effective = 1.0 / (gradient @ response)
    return velocity - response * effective * (1 + restitution) * (gradient @ velocity), effective


def complementary_impulses(w: np.ndarray, start: np.ndarray, aim: np.ndarray) -> np.ndarray:
    """Return p ≥ 0 with u = start + W p ≥ aim and p·(u − aim) = 0, by trying every set of contacts."""
    count = len(start)
    for pressed in itertools.product([False, True], repeat=count):
        rows, p = np.flatnonzero(pressed), np.zeros(count)
        if len(rows):
            p[rows] = np.linalg.solve(w[np.ix_(rows, rows)], (aim - start)[rows])
        if (p > -1e-12).all() and (start + w @ p - aim > -1e-12).all():
            return p
    raise ValueError("no solution")


def moreau_impact(
    scene: Scene,
    angles: Sequence[float],
    velocity: np.ndarray,
    contacts: Sequence[tuple[int, str]],
    restitution: float,
) -> np.ndarray:
    """Return velocities q̇⁺ after (points, walls) are hit at once: u⁺ = u⁻ + W p, 0 ≤ p ⟂ u⁺ + e u⁻ ≥ 0."""
    gradient = np.array([clearance_gradient(scene, angles, *contact) for contact in contacts])
    response = np.linalg.solve(mass_matrix(scene, angles), gradient.T)
    before = gradient @ velocity
    impulses = complementary_impulses(gradient @ response, before, -restitution * before)
    return velocity + response @ impulses


# --- quantities from outputs
# --------------------------------------------------------------------------------------


def momenta(result):
    """Return momentum, (T, 2), and angular momentum about the centre of mass, (T,), from the outputs."""
    links = result.scene.chain.links
    place, velocity, spin = 0.0, 0.0, 0.0
    mass = np.array([link.mass for link in links])
    centres, speeds = [], []
    for i, link in enumerate(links):
        part = link.center_of_mass / link.length
        for name, rows in (("point_position", centres), ("point_velocity", speeds)):
            points = result.outputs[name]
            rows.append(points[:, i] + part * (points[:, i + 1] - points[:, i]))
        spin = spin + link.inertia * result.angular_velocities[:, i]
    place = np.average(centres, axis=0, weights=mass)
    velocity = np.average(speeds, axis=0, weights=mass)
    for m, centre, speed in zip(mass, centres, speeds, strict=True):
        arm, motion = centre - place, speed - velocity
        spin = spin + m * (arm[:, 0] * motion[:, 1] - arm[:, 1] * motion[:, 0])
    return mass.sum() * velocity, spin


def balance(result):
    """Return the range of the energy balance over the motion, relative to its energy.

    That is the largest kinetic energy, or the range of the potential energy if that is larger.
    """
    energy = result.energy
    ledger = energy["total"] + energy["dissipated"] - energy["supplied"]
    return np.ptp(ledger) / max(energy["kinetic"].max(), np.ptp(energy["potential"]))
