"""One step of the point-foot walker with knees of Hsu Chen 2007, from its point masses and its phases.

The model shares no code with the kernel, and its masses are those of the source, not those of the scene. The
angles q are measured from the vertical: of the stance leg from its foot up, of thigh and shank from the hip
down. The mass k is at Σ_j a_kj (sin q_j, −cos q_j) from the foot. Before the knee strike q has three angles,
afterwards two, because thigh and shank are one rigid leg. The knee strike conserves two angular momenta: of
all masses about the standing foot, and of the swinging leg about the hip. The heel strike conserves the same
two angular momenta, with the other foot.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from chain_impact import load_scene
from chain_impact.scene.scene import Scene
from tests.helpers.literature.figures import Figure, Problem, problem, run

HIP, THIGH, SHANK = 0.5, 0.5, 0.05  # kg
A1, B1, A2, B2 = 0.375, 0.125, 0.175, 0.325  # lengths [m] from the foot up: shank A1 + B1, thigh A2 + B2
LS, LT = A1 + B1, A2 + B2
LEG = LS + LT
SLOPE = 0.0504  # rad
# q₁, its rate, and the rate of q₂ = q₃ after each heel strike, at which a step begins [rad, rad/s]
PUBLISHED = ("0.1877", "-1.1014", "-0.0399")

MASSES = np.array([SHANK, THIGH, HIP, THIGH, SHANK])
# indices of masses: all, of the standing leg, of the swinging leg
ALL, STANDING, SWINGING = [0, 1, 2, 3, 4], [0, 1], [3, 4]
BENT = np.array([[-A1, 0, 0], [-LS - A2, 0, 0], [-LEG, 0, 0], [-LEG, B2, 0], [-LEG, LT, B1]])
LOCK = np.array([[1, 0], [0, 1], [0, 1]])  # matrix: two angles → three angles
STRAIGHT = BENT @ LOCK
UPRIGHT = np.array([np.pi / 2, -np.pi / 2, -np.pi / 2])  # q = 0 in the angles of the scene


def equations(
    arms: np.ndarray, q: np.ndarray, w: np.ndarray, gravity: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return H and the right side of H q̈ = −h − G."""
    coupling, differences = (arms.T * MASSES) @ arms, np.subtract.outer(q, q)
    forces = -(coupling * np.sin(differences)) @ w**2 - gravity * (MASSES @ arms) * np.sin(q)
    return coupling * np.cos(differences), forces


def motion(arms: np.ndarray, gravity: float) -> Callable[[float, np.ndarray], np.ndarray]:
    """Return a function for (q̇, q̈) of (q, q̇)."""

    def rate(_time: float, y: np.ndarray) -> np.ndarray:
        q, w = np.split(y, 2)
        return np.concatenate([w, np.linalg.solve(*equations(arms, q, w, gravity))])

    return rate


def momenta(arms: np.ndarray, q: np.ndarray, masses: list[int], about: np.ndarray) -> np.ndarray:
    """Return the row that, times q̇, gives the angular momentum of some masses about a point."""
    places = arms @ np.transpose([np.sin(q), -np.cos(q)]) - about
    moves = arms[:, :, None] * np.transpose([np.cos(q), np.sin(q)])
    crossed = places[:, None, 0] * moves[..., 1] - places[:, None, 1] * moves[..., 0]
    return MASSES[masses] @ crossed[masses]


def knee_strike(q: np.ndarray, w: np.ndarray) -> np.ndarray:
    """Return the rates of stance leg and swinging leg after the knee strike from the three rates before."""
    straight = q[:2]
    hip = LEG * np.array([-np.sin(q[0]), np.cos(q[0])])
    kept = [(ALL, np.zeros(2)), (SWINGING, hip)]
    before = np.array([momenta(BENT, q, *masses_and_point) for masses_and_point in kept])
    after = np.array([momenta(STRAIGHT, straight, *masses_and_point) for masses_and_point in kept])
    return np.linalg.solve(after, before @ w)


def heel_strike(q: np.ndarray, w: np.ndarray) -> np.ndarray:
    """Return the state (q₁, q₂, q̇₁, q̇₂) of the next step, in which the two straight legs change places."""
    hip = LEG * np.array([-np.sin(q[0]), np.cos(q[0])])
    foot = hip + LEG * np.array([np.sin(q[1]), -np.cos(q[1])])
    before = np.array([momenta(STRAIGHT, q, ALL, foot), momenta(STRAIGHT, q, STANDING, hip)])
    swapped = q[::-1]
    after = np.array(
        [momenta(STRAIGHT, swapped, ALL, np.zeros(2)), momenta(STRAIGHT, swapped, SWINGING, hip - foot)]
    )
    return np.concatenate([swapped, np.linalg.solve(after, before @ w)])


def energy(arms: np.ndarray, q: np.ndarray, w: np.ndarray) -> float:
    """Return the kinetic energy [J]."""
    matrix, _ = equations(arms, q, w, 0.0)
    return float(0.5 * w @ matrix @ w)


def followed(
    arms: np.ndarray,
    gravity: float,
    begin: float,
    start: np.ndarray,
    event: Callable[..., float] | None = None,
) -> Any:
    """Return the solution of a phase, for 1 s or until a terminal event."""
    return solve_ivp(
        motion(arms, gravity),
        (begin, begin + 1.0),
        start,
        method="DOP853",
        rtol=1e-13,
        atol=1e-14,
        max_step=5e-3,
        events=event,
        dense_output=True,
    )


def straightens() -> Callable[..., float]:
    """Return the event that ends a phase when the knee becomes straight."""

    def bend(_time: float, y: np.ndarray) -> float:
        return float(y[1] - y[2])

    bend.terminal, bend.direction = True, -1  # type: ignore[attr-defined]
    return bend


class Walker:
    """The motion of the walker from the start of a scene."""

    def __init__(self, scene: Scene) -> None:
        self.g = -scene.gravity[1]
        first = np.concatenate([np.array(scene.initial.angles) - UPRIGHT, scene.initial.angular_velocities])
        self.swing = followed(BENT, self.g, 0.0, first, straightens())
        self.onset, self.before = self.swing.t[-1], self.swing.y[:, -1]
        self.after = knee_strike(self.before[:3], self.before[3:])
        begin = np.concatenate([self.before[:2], self.after])
        self.locked = followed(STRAIGHT, self.g, self.onset, begin)

    def angles(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the angles [rad] of the scene's three links at each of the times, and their rates."""
        late = (times > self.onset)[:, None]
        bent, straight = (self.swing.sol(times).T, self.locked.sol(times).T)
        angles, rates = (
            np.where(late, straight[:, 2 * k : 2 * k + 2] @ LOCK.T, bent[:, 3 * k : 3 * k + 3])
            for k in (0, 1)
        )
        return angles + UPRIGHT, rates

    def lost(self) -> float:
        """Return the energy [J] that the knee strike dissipates."""
        left = energy(STRAIGHT, self.before[:2], self.after)
        return energy(BENT, self.before[:3], self.before[3:]) - left

    def lands(self) -> float:
        """Return the time [s] at which the swinging foot lands on the slope."""

        def height(time: float) -> float:
            q = self.locked.sol(time)[:2]
            foot = LEG * np.array([np.sin(q[1]) - np.sin(q[0]), np.cos(q[0]) - np.cos(q[1])])
            return float(foot @ [np.sin(SLOPE), np.cos(SLOPE)])

        return float(brentq(height, self.onset, 0.7, xtol=1e-15))


def kneed_leg(tolerance: float) -> Problem:
    """Return figures for the knee strike, and for the state after the whole step, which the gait repeats."""
    model = "kneed_leg"
    result, walker = run(model, tolerance), Walker(load_scene(model))
    onset = result.impacts["onset"][0]
    struck = run(model, tolerance, stop_time=float(np.nextafter(onset, 1.0)))
    figures = [
        Figure("knee strike: time [s]", None, walker.onset, onset, 1e-11),
        Figure(
            "knee strike: angular velocity of the leg after it [rad/s]",
            None,
            walker.after[1],
            struck.angular_velocities[-1, 1],
            1e-10,
        ),
        Figure("knee strike: energy lost [J]", None, walker.lost(), struck["energy.dissipated"][-1], 1e-12),
    ]
    landing = walker.lands()
    exact = heel_strike(*np.split(walker.locked.sol(landing), 2))
    last = run(model, tolerance, stop_time=landing)
    ours = heel_strike((last.angles[-1] - UPRIGHT)[:2], last.angular_velocities[-1, :2])
    quantities = ("angle of the stance leg [rad]", "its rate [rad/s]", "rate of the swinging leg [rad/s]")
    figures += [
        Figure(f"after the step: {quantity}", stored, exact[row], ours[row], 1e-10, 0.02, inaccurate=True)
        for quantity, stored, row in zip(quantities, PUBLISHED, (0, 2, 3), strict=True)
    ]
    return problem(model, result, figures)
