"""A chain with contacts, Coulomb friction, stops and dry joints, by an assembled mass matrix.

It shares nothing with the kernel. Each place that rubs has a mode: it sticks, or slips with a sign s.

    slip:   F_t = −µ s F_n,  or the moment −M s of a joint
    stick:  F_t is what makes J_t q̈ + J̇_t q̇ = 0, with |F_t| ≤ µ_s F_n, or |moment| ≤ M

F_n depends on the state alone, so the equations of a mode are smooth. tests/coulomb.py integrates them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from chain_impact.scene.scene import Scene
from tests.coulomb_impact import Strike
from tests.places import Friction, Joint, Stop, Touch, stops, touches
from tests.textbook import Textbook

RANK = 1e-11  # of the largest eigenvalue: directions in which what sticks cannot be moved apart
LEAST_SHARE = 1e-9  # of the largest bound, for shares of redundant friction


@dataclass
class Modes:
    """What holds between two events.

    Attributes:
        latched: number of a contact that acts → v₀.
        cut: contacts among them whose force is cut off at 0, as their law would pull.
        slip: number of what rubs → sign of its slip, 0 if it sticks; of contacts only while they act.
        torques: of the joints [N·m].
        tip: force on the tip [N].
    """

    latched: dict[int, float] = field(default_factory=dict)
    cut: set[int] = field(default_factory=set)
    slip: dict[int, int] = field(default_factory=dict)
    torques: np.ndarray = field(default_factory=lambda: np.zeros(0))
    tip: np.ndarray = field(default_factory=lambda: np.zeros(2))


@dataclass(frozen=True)
class Forces:
    """Forces and accelerations at a state.

    Arrays of contacts have a row for each; arrays of what rubs for each that acts, in the order of
    ``Modes.slip``.

    Attributes:
        acceleration: q̈.
        gap, gap_rate: of the contacts.
        normal: F_n of the contacts.
        damped, rubbed, supplied: powers [W]: of dampers and walls, of friction, of the inputs.
        tangential: F_t, or moment, of what rubs.
        bound: the most with which it can stick.
        speed: v_t or ψ̇, its derivative ``rate``, and ``rows`` J_t.
        scale: the largest generalized force there is.
    """

    acceleration: np.ndarray
    gap: np.ndarray
    gap_rate: np.ndarray
    normal: np.ndarray
    damped: float
    rubbed: float
    supplied: float
    tangential: np.ndarray
    bound: np.ndarray
    speed: np.ndarray
    rate: np.ndarray
    rows: np.ndarray
    scale: float


class Geometry:
    """Gaps of contacts and velocities of what rubs, with their rows: ġ = J q̇ and v_t = J_t q̇.

    With the unit vector u_i along link i, and u⊥_i to its left, the point k is p₀ + Σ_{i≤k} ℓ_i u_i. Hence
    J = [n, ℓ_i n·u⊥_i], and as t is n turned to the right, J_t = [t, −ℓ_i n·u_i], J̇_t q̇ = −Σ ℓ_i ω_i² n·u⊥_i.
    """

    def __init__(self, book: Textbook, contacts: Sequence[Touch | Stop], rubs: Sequence[Touch | Joint]):
        self.n = n = book.n
        walls = [contact for contact in contacts if isinstance(contact, Touch)]
        self.normals = np.array([wall.normal for wall in walls]).reshape(-1, 2)
        self.tangents = self.normals[:, ::-1] * [1.0, -1.0]
        self.offsets = np.array([wall.offset for wall in walls])
        # of each point, the lengths of the links before it
        reach = np.tril(np.tile(book.length, (n + 1, 1)), -1)
        self.reach = reach[[wall.point for wall in walls]].reshape(-1, n)
        self.rubbing = [walls.index(rub) for rub in rubs if isinstance(rub, Touch)]
        sides = [contact for contact in contacts if isinstance(contact, Stop)]
        rows = [stop.side * self.joint_row(stop.point) for stop in sides]
        self.stop_rows = np.array(rows).reshape(-1, n + 2)
        self.limits = np.array([stop.side * stop.limit for stop in sides])
        dry = [self.joint_row(rub.point) for rub in rubs if isinstance(rub, Joint)]
        self.joint_rows = np.array(dry).reshape(-1, n + 2)

    def joint_row(self, joint: int) -> np.ndarray:
        """J with ψ = J q for a joint 1…N."""
        row = np.zeros(self.n + 2)
        row[joint + 1] = 1.0
        if joint > 1:
            row[joint] = -1.0
        return row

    def parts(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """ℓ_i n·u_i and ℓ_i n·u⊥_i of each point that touches a wall."""
        cos, sin = np.cos(q[2:]), np.sin(q[2:])
        x, y = self.normals[:, :1], self.normals[:, 1:]
        return self.reach * (x * cos + y * sin), self.reach * (y * cos - x * sin)

    def gaps(self, q: np.ndarray, parts: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """g and J."""
        along, across = parts
        gap = self.normals @ q[:2] + along.sum(axis=1) - self.offsets
        rows = np.concatenate([self.normals, across], axis=1)
        if not len(self.limits):
            return gap, rows
        return np.append(gap, self.stop_rows @ q - self.limits), np.concatenate([rows, self.stop_rows])

    def slips(self, v: np.ndarray, parts: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """J_t and J̇_t q̇."""
        along, across = parts
        rows = np.concatenate([self.tangents, -along], axis=1)[self.rubbing]
        bias = -(across @ v[2:] ** 2)[self.rubbing]
        if not len(self.joint_rows):
            return rows, bias
        return np.concatenate([rows, self.joint_rows]), np.append(bias, np.zeros(len(self.joint_rows)))


class Assembled:
    """The equations of a scene; a state is y = (q, q̇), more may follow it."""

    def __init__(self, scene: Scene, friction: Friction | None = None) -> None:
        friction = friction or Friction()
        self.scene, self.book, self.n = scene, Textbook(scene), len(scene.chain.links)
        walls = touches(scene, friction)
        self.contacts: list[Touch | Stop] = [*walls, *stops(scene)]
        # of a touch that rubs, the number of its contact
        self.contact_of = [c for c, touch in enumerate(walls) if touch.holding > 0.0]
        self.rubs: list[Touch | Joint] = [walls[c] for c in self.contact_of]
        self.rubs += [Joint(joint, moment, moment) for joint, moment in sorted(friction.joints.items())]
        self.damped = self.book.damping.any()
        self.geometry = Geometry(self.book, self.contacts, self.rubs)
        self.sliding, self.holding = (
            np.array([getattr(rub, name) for rub in self.rubs]) for name in ("sliding", "holding")
        )
        laws = [contact.law for contact in self.contacts]
        self.stiffness, self.exponent, self.damping = (
            np.array([getattr(law, name) for law in laws]) for name in ("stiffness", "exponent", "damping")
        )

    @property
    def start(self) -> np.ndarray:
        """(q, q̇) at time 0."""
        return self.book.start

    def split(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """q, q̇ and both together."""
        size = self.n + 2
        return y[:size], y[size : 2 * size], y[: 2 * size]

    def gaps(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The gaps of the contacts and their rates."""
        q, v, _ = self.split(y)
        gap, rows = self.geometry.gaps(q, self.geometry.parts(q))
        return gap, rows @ v

    def effective_mass(self, y: np.ndarray, c: int) -> float:
        """1/(J M⁻¹ Jᵀ) of a contact."""
        q, _, _ = self.split(y)
        row = self.geometry.gaps(q, self.geometry.parts(q))[1][c]
        return 1.0 / float(row @ self.book.answer(self.matrix(y), row))

    def strike(self, y: np.ndarray, r: int) -> Strike:
        """What arrives at a wall where the point of a rub is now."""
        q, v, _ = self.split(y)
        rub, c = self.rubs[r], self.contact_of[r]
        parts = self.geometry.parts(q)
        rows = np.array([self.geometry.gaps(q, parts)[1][c], self.geometry.slips(v, parts)[0][r]])
        w = rows @ self.book.answer(self.matrix(y), rows.T)
        approach, sliding = rows @ v * [-1.0, 1.0]
        return Strike(w[0, 0], w[0, 1], w[1, 1], approach, sliding, rub.sliding, rub.holding)

    def matrix(self, y: np.ndarray) -> np.ndarray:
        """M(q)."""
        return self.book.assemble(y[2 : self.n + 2], np.zeros(self.n))[0].copy()

    def forces(self, y: np.ndarray, modes: Modes) -> Forces:
        """All forces and accelerations at a state."""
        q, v, state = self.split(y)
        driven = modes.torques.any()
        matrix, right = self.book.balance(state, modes.torques if driven else None)
        right, supplied = right.copy(), 0.0
        if modes.tip.any():
            push = modes.tip @ self.book.jacobian(q[2:], self.n)
            right, supplied = right + push, float(push @ v)
        if driven:
            supplied += float(modes.torques @ np.diff(v[2:], prepend=0.0))
        parts = self.geometry.parts(q)
        gap, gap_rows = self.geometry.gaps(q, parts)
        gap_rate = gap_rows @ v
        normal, lost = self._normal(gap, gap_rate, modes)
        right += normal @ gap_rows
        rows, bias, slipping, holding = self._friction(v, parts, normal, modes)
        signs = np.array(list(modes.slip.values()))
        tangential, stuck = -signs * slipping, signs == 0
        held, pushed = rows[stuck], right + tangential @ rows
        answers = self.book.answer(matrix, np.concatenate([pushed[None], held]).T)
        acceleration, response = answers[:, 0], answers[:, 1:]
        if len(held):
            wanted = -(held @ acceleration + bias[stuck])
            tangential[stuck] = shared(held @ response, wanted, holding[stuck])
            acceleration = acceleration + response @ tangential[stuck]
        speed = rows @ v
        return Forces(
            acceleration=acceleration,
            gap=gap,
            gap_rate=gap_rate,
            normal=normal,
            damped=lost + (float(self.book.loss(state)) if self.damped else 0.0),
            rubbed=-float(tangential @ speed),
            supplied=supplied,
            tangential=tangential,
            bound=holding,
            speed=speed,
            rate=rows @ acceleration + bias,
            rows=rows,
            scale=float(np.abs(right).max()),
        )

    def _normal(self, gap: np.ndarray, gap_rate: np.ndarray, modes: Modes) -> tuple[np.ndarray, float]:
        """F_n = K δⁿ (1 + λ δ̇/v₀) of the contacts that act, or 0, and the power that damping takes [W]."""
        normal, lost = np.zeros(len(gap)), 0.0
        if modes.latched:
            acting = list(modes.latched)
            elastic = self.stiffness[acting] * np.maximum(0.0, -gap[acting]) ** self.exponent[acting]
            normal[acting] = elastic * self.shares(gap_rate, modes)
            normal[list(modes.cut)] = 0.0
            lost = -float((normal[acting] - elastic) @ gap_rate[acting])
        return normal, lost

    def shares(self, gap_rate: np.ndarray, modes: Modes) -> np.ndarray:
        """1 + λ δ̇/v₀ of the contacts that act; the force is cut off at 0 while it is negative."""
        acting, latched = list(modes.latched), np.array(list(modes.latched.values()))
        return 1.0 - self.damping[acting] * gap_rate[acting] / latched

    def _friction(
        self, v: np.ndarray, parts: tuple[np.ndarray, np.ndarray], normal: np.ndarray, modes: Modes
    ) -> tuple[np.ndarray, ...]:
        """J_t, J̇_t q̇, the friction of slip and the bound of stick, of all that rubs and acts."""
        if not modes.slip:
            return np.zeros((0, self.n + 2)), *np.zeros((3, 0))
        acting = list(modes.slip)
        rows, bias = self.geometry.slips(v, parts)
        pressed = np.append(normal[self.contact_of], np.ones(len(self.rubs) - len(self.contact_of)))[acting]
        return rows[acting], bias[acting], self.sliding[acting] * pressed, self.holding[acting] * pressed

    def energies(self, y: np.ndarray, modes: Modes) -> tuple[float, float, float]:
        """Kinetic, potential and elastic energy [J]."""
        q, v, _ = self.split(y)
        book, angles = self.book, q[2:]
        height = book.total_mass * q[:2]
        height = height + book.first_moment @ np.stack([np.cos(angles), np.sin(angles)], axis=1)
        bend = np.diff(angles, prepend=0.0) - book.rest
        elastic = 0.5 * float(book.stiffness @ bend**2)
        acting, power = list(modes.latched), self.exponent + 1.0
        depth = np.maximum(0.0, -self.gaps(y)[0])
        elastic += float((self.stiffness * depth**power / power)[acting].sum())
        return 0.5 * float(v @ self.matrix(y) @ v), -float(book.gravity @ height), elastic


def shared(w: np.ndarray, wanted: np.ndarray, bounds: np.ndarray) -> np.ndarray:
    """The forces λ with W λ = ``wanted``; redundant ones as far as may be in proportion to their bounds.

    That is the least Σ λ²/bound among all solutions. W is scaled to ones on its diagonal before its rank is
    judged.
    """
    if len(w) == 1:
        return wanted / w[0]
    scale = 1.0 / np.sqrt(np.diag(w))
    values, vectors = np.linalg.eigh(scale[:, None] * w * scale)
    regular = values > RANK * values[-1]
    basis = vectors[:, regular]
    force = scale * (basis @ ((basis.T @ (scale * wanted)) / values[regular]))
    if not regular.all() and bounds.max() > 0.0:
        weights = np.maximum(bounds, LEAST_SHARE * bounds.max()) ** -0.5
        free = scale[:, None] * vectors[:, ~regular]
        change = np.linalg.lstsq(weights[:, None] * free, -weights * force, rcond=None)[0]
        force = force + free @ change
    return force
