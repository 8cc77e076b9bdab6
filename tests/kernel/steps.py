"""Last steps with motions in closed form: polynomials in the variable of the step."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from chain_impact.kernel.chain.kinematics import accelerate_points, locate_points
from chain_impact.kernel.record.constants import DENSE_COEFFICIENTS, EXPLICIT, SOLVER_READER
from chain_impact.kernel.record.state import sundman_u_at, time_at
from tests.helpers.kernel.plain import Plain
from tests.kernel.chains import ANGLES, FAR, chain, mark_touching

# powers of θ and of 1 − θ in the dense output
POWERS = [(1, 0), (1, 1), (2, 1), (2, 2), (3, 2), (3, 3), (4, 3)]


def basis(theta: np.ndarray | float) -> np.ndarray:
    """Return the functions of the dense output at fractions of a step, shape (coefficients, …)."""
    return np.array([theta**p * (1.0 - theta) ** q for p, q in POWERS])


class Motion:
    """A motion y(s): coefficients of the powers of s, shape (degree + 1, len(y)), degree at most 7."""

    def __init__(self, coefficients: np.ndarray) -> None:
        self.coefficients = coefficients

    def at(self, s: float, derivative: int = 0) -> np.ndarray:
        """Return the state, or a derivative of the state."""
        parts = np.polynomial.polynomial.polyder(self.coefficients, derivative, axis=0)
        return np.polynomial.polynomial.polyval(s, parts)


def free_motion(rng: np.random.Generator, d: Plain, *, speed: float = 2.0, bend: float = 3.0) -> Motion:
    """Return a quadratic motion of the coordinates in time, with their rates and the time."""
    n, half = d.link_count, d.link_count + 2
    parts = np.zeros((3, len(d.step.state)))
    parts[0, :half] = rng.uniform(-2.0, 2.0, half)
    parts[1, :half] = rng.uniform(-speed, speed, half)
    parts[2, :half] = 0.5 * rng.uniform(-bend, bend, half)
    if d.chain.has_base_joint:
        parts[:, :2] = 0.0
    parts[0, half : 2 * half], parts[1, half : 2 * half] = parts[1, :half], 2.0 * parts[2, :half]
    parts[0, sundman_u_at(n)], parts[1, time_at(n)] = 1.0, 1.0
    return Motion(parts)


def set_step(d: Plain, motion: Motion, size: float, start: float = 0.0, regularized: int = -1) -> None:
    """Let the last step be the first ``size`` of the motion, with all stored quantities of a step.

    The points are located and accelerated at its end.
    """
    step, scratch = d.step, d.scratch
    nodes = np.linspace(0.1, 1.0, DENSE_COEFFICIENTS)
    values = np.array([motion.at(size * t) - motion.at(0.0) for t in nodes])
    step.dense[:] = np.linalg.solve(basis(nodes).T, values)
    step.state[:], step.state_end[:] = motion.at(0.0), motion.at(size)
    scratch.rate_start[:], scratch.rate_end[:] = motion.at(0.0, 1), motion.at(size, 1)
    step.start, step.time_origin, step.communication_point = start, start, start
    step.end = start + step.state_end[time_at(d.link_count)]
    step.size, step.end_fraction, step.regularized_candidate = size, 1.0, regularized
    step.last_method = step.method = EXPLICIT
    step.dense_for, step.rate_known, scratch.located_at_end = SOLVER_READER, 1, 1
    step.break_count += 1
    locate_points(d, step.state_end)
    accelerate_points(d, step.state_end, scratch.rate_end)


def points_of(d: Plain, y: np.ndarray) -> np.ndarray:
    """Return the points of a state, as complex numbers; for many states, shape (…, N+1)."""
    n = d.link_count
    ends = np.cumsum(d.chain.length * np.exp(1j * y[..., 2 : n + 2]), axis=-1)
    base = y[..., 0:1] + 1j * y[..., 1:2]
    return base + np.concatenate([np.zeros_like(base), ends], axis=-1)


def normals_of(d: Plain) -> np.ndarray:
    """Return the inward normals of the candidates of ``tests.kernel.chains.chain``, as complex numbers."""
    walls = [-1.0 + 0.0j, 1j, *(1j * np.exp(1j * angle) for angle in ANGLES)]
    kinds = sorted(set(d.candidate.wall.tolist()))
    return np.array([walls[kinds.index(wall)] for wall in d.candidate.wall])


def gaps_of(d: Plain, y: np.ndarray, candidates: Iterable[int] | None = None) -> np.ndarray:
    """Return the clearances of candidates for states, shape (…, count), for the offsets of their walls."""
    chosen = list(range(d.candidate_count)) if candidates is None else list(candidates)
    return along_normals(d, y, chosen) - d.candidate.offset[chosen] - d.contact_settings.radius


def along_normals(d: Plain, y: np.ndarray, candidates: list[int]) -> np.ndarray:
    """Return n·p of candidates for states, shape (…, count)."""
    places = points_of(d, y)[..., d.candidate.point[candidates]]
    return (places * normals_of(d)[candidates].conj()).real


def wall_at(d: Plain, c: int, y: np.ndarray, clearance: float) -> None:
    """Move the wall of candidate c so that its point has this clearance [m] in a state."""
    d.candidate.offset[c] = along_normals(d, y, [c])[0] - d.contact_settings.radius - clearance


def walls_away(d: Plain) -> None:
    """Put all walls far away."""
    d.candidate.offset[:] = -FAR


def translation(d: Plain, x: Iterable[float], y: Iterable[float]) -> Motion:
    """Return a motion of the chain without rotation: polynomials in time of its base, lowest power first."""
    n, half = d.link_count, d.link_count + 2
    parts = np.zeros((DENSE_COEFFICIENTS + 1, len(d.step.state)))
    for axis, powers in enumerate((list(x), list(y))):
        parts[: len(powers), axis] = powers
        parts[:-1, half + axis] = np.polynomial.polynomial.polyder(parts[:, axis])
    parts[0, 2:half] = np.linspace(0.2, 1.0, n)
    parts[0, sundman_u_at(n)], parts[1, time_at(n)] = 1.0, 1.0
    return Motion(parts)


def held_tip(size: float, force: Iterable[float]) -> tuple[Plain, int, Motion]:
    """Return a pinned link at rest whose tip a rigid wall holds against its torque.

    The force [N] is a polynomial of the fraction of the step, lowest power first; the step begins at 0 s.
    """
    _, d = chain(np.random.default_rng(2), 1, "pinned", inputs=True, model="newton_impact")
    motion = translation(d, [0.0], [0.0])
    walls_away(d)
    set_step(d, motion, size)
    c = next(c for c in range(d.candidate_count) if d.candidate.point[c] == 1)
    wall_at(d, c, motion.at(0.0), 0.0)
    mark_touching(d, [c])
    d.chain.gravity[:] = d.chain.gravity_magnitude = 0.0
    piece = d.inputs.piece
    piece.degree, piece.middle, piece.scale, piece.end = 3, 0.0, 1.0 / size, 10.0
    let_push(d, c, force)
    return d, c, motion


def let_push(d: Plain, c: int, force: Iterable[float]) -> None:
    """Set the torque of ``held_tip`` to one against which the wall pushes with this force."""
    angle = d.step.state[2]
    normal = np.array([d.candidate.normal_x[c], d.candidate.normal_y[c]])
    lever = d.chain.length[0] * np.array([-np.sin(angle), np.cos(angle)]) @ normal
    powers = d.inputs.piece.motor
    powers[:, 0] = 0.0
    for m, part in enumerate(force):
        # F · lever = −u
        powers[m, 0] = -part * lever
