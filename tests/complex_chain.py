"""The chain in complex numbers: a value and, in its imaginary part, its derivative by a parameter.

A model of its own for ``tests.derivatives``, which shares nothing with the kernel: the mass matrix and the
forces of a chain after Lagrange, written down for all links at once, and the contact laws after
docs/contact_laws.md. Every array has the lane as its first axis: in lane i the i-th parameter has an
imaginary part. All lanes have the same real parts. Units are SI throughout.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np

from chain_impact.scene.candidates import candidates
from chain_impact.scene.scene import WALLS, Scene
from tests.complex_friction import DryFriction
from tests.complex_laws import Law
from tests.complex_place import Place, Touch, chained
from tests.complex_step import TINY, power


class ComplexChain:
    """The equations of a scene with some parameters perturbed, one in each lane.

    The state of a lane is q = (x₀, y₀, θ), q̇, time, dissipated and supplied energy, that dissipated by dry
    friction, the normal and the tangential impulse of each candidate, and z of each candidate: the root
    z = (δ/δ*)^(1/m) of its penetration, while it lasts. With dt/ds = τ Π z^(m−1) the motion is smooth in s,
    also where contacts begin and end, if m n and m p are whole.

    Args:
        scene: the chain, its walls and its law.
        parameters: their names in the FMU.
        inputs: constant values of inputs, by name.
    """

    def __init__(
        self, scene: Scene, parameters: Sequence[str], inputs: Mapping[str, float] | None = None
    ) -> None:
        self.scene, self.parameters = scene, list(parameters)
        self.base = {k: v for k, v in scene.values.items() if isinstance(v, float | int)} | dict(inputs or {})
        unknown = set(parameters) - set(self.base)
        assert not unknown, f"no parameters: {unknown}"
        self.lanes = max(1, len(self.parameters))
        # to be relative to a parameter's size makes the imaginary parts of all lanes alike
        self.sizes = np.array([abs(self.base[name]) or 1.0 for name in self.parameters])
        self.links = len(scene.chain.links)
        self.pinned = scene.chain.base == "pinned"
        self.recent: list[tuple[np.ndarray, Place]] = []
        self._places()
        self._bodies()
        self._walls()
        self._stops()
        self._laws()
        self.friction = DryFriction(self)

    def value(self, name: str, otherwise: float = 0.0) -> np.ndarray:
        """A parameter in each lane, shape (lanes,)."""
        value = np.full(self.lanes, self.base.get(name, otherwise), complex)
        for lane, parameter in enumerate(self.parameters):
            if parameter == name:
                value[lane] += 1j * TINY * self.sizes[lane]
        return value

    def values(self, form: str) -> np.ndarray:
        """A parameter of each link in each lane, shape (lanes, N)."""
        return np.stack([self.value(form.format(i + 1)) for i in range(self.links)], 1)

    def _places(self) -> None:
        """Where things are in the state."""
        n, count = self.links + 2, len(candidates(self.scene))
        self.q, self.v = slice(0, n), slice(n, 2 * n)
        self.time, self.dissipated, self.supplied = 2 * n, 2 * n + 1, 2 * n + 2
        self.rubbed, self.impulse = 2 * n + 3, 2 * n + 4
        self.tangential, self.root = self.impulse + count, self.impulse + 2 * count
        self.size = self.root + count

    def _bodies(self) -> None:
        """T = ½m|ẋ₀|² + Σ b_i ω_i (ẋ₀·e_i⊥) + ½Σ c_ij cos(θ_i−θ_j) ω_i ω_j, with each link's own inertia."""
        self.mass, self.length = self.values("link[{}].mass"), self.values("link[{}].length")
        self.centre, self.inertia = self.values("link[{}].center_of_mass"), self.values("link[{}].inertia")
        n = self.links
        # arm of link i that carries the mass k: its length, or up to its own centre of mass
        arm = np.zeros((self.lanes, n, n), complex)
        for k in range(n):
            arm[:, :k, k] = self.length[:, :k]
            arm[:, k, k] = self.centre[:, k]
        self.total = self.mass.sum(1)
        self.own = self.inertia[..., None] * np.eye(n)
        self.b = (arm * self.mass[:, None]).sum(2)
        self.c = np.einsum("lik,lk,ljk->lij", arm, self.mass, arm)
        self.damper, self.spring = (
            self.values("link[{}].joint_damping"),
            self.values("link[{}].joint_stiffness"),
        )
        self.rest, self.torque = self.values("link[{}].joint_rest_angle"), self.values("joint[{}].torque")
        if not self.pinned:
            self.damper[:, 0] = self.spring[:, 0] = self.torque[:, 0] = 0.0
        self.gravity = np.stack([self.value("gravity.x"), self.value("gravity.y")], 1)
        self.tip = np.stack([self.value("tip.force.x"), self.value("tip.force.y")], 1)

    def _walls(self) -> None:
        """Points and walls of all candidates; normals and offsets n·x of those that are at walls."""
        found = candidates(self.scene)
        self.points = np.array([point for point, _ in found], int)
        self.walls = np.array([wall for _, wall in found], int)
        self.at_walls = len(found) - len(self.scene.chain.stops)
        self.normal = np.zeros((self.lanes, self.at_walls, 2), complex)
        self.offset = np.zeros((self.lanes, self.at_walls), complex)
        for c, wall in enumerate(self.walls[: self.at_walls]):
            name = self.scene.wall_names[wall]
            if wall < len(WALLS):
                sign = 1.0 - 2.0 * (wall % 2)
                self.normal[:, c, wall // 2] = sign
                self.offset[:, c] = sign * self.value(f"box.{name}")
            else:
                angle = self.value(f"wall.{name}.angle")
                self.normal[:, c] = np.stack([-np.sin(angle), np.cos(angle)], 1)
                place = np.stack([self.value(f"wall.{name}.x"), self.value(f"wall.{name}.y")], 1)
                self.offset[:, c] = (self.normal[:, c] * place).sum(1)
        self.offset += self.value("contact.radius")[:, None]

    def _stops(self) -> None:
        """Joints i, sides and limits of the stops: the clearance is side · (θ_i − θ_{i−1} − limit)."""
        self.joints = self.points[self.at_walls :] - 1
        kinds = [self.scene.wall_names[wall] for wall in self.walls[self.at_walls :]]
        self.side = np.array([1.0 if kind == "joint_min" else -1.0 for kind in kinds])
        limits = [self.value(f"link[{i + 1}].{kind}") for i, kind in zip(self.joints, kinds, strict=True)]
        self.limit = np.array(limits, complex).reshape(len(limits), self.lanes).T

    def _laws(self) -> None:
        """The law of each candidate."""
        names = [self.scene.wall_names[wall] for wall in self.walls[: self.at_walls]]
        at_walls = {name: self._law("contact", self.scene.contact.model, f"wall.{name}") for name in names}
        self.laws = [at_walls[name] for name in names]
        if len(self.joints):
            self.laws += [self._law("stop", self.scene.stops.model or self.scene.contact.model)] * len(
                self.joints
            )

    def _law(self, table: str, model: str, material: str = "") -> Law:
        def value(key: str) -> np.ndarray:
            own = f"{material}.{key}"
            return self.value(own if own in self.base else f"{table}.{key}")

        keys = ("stiffness", "exponent", "restitution", "minimum_impact_speed")
        return Law(model, *(value(key) for key in keys))

    def start(self) -> np.ndarray:
        """The state at time 0, shape (lanes, size)."""
        y = np.zeros((self.lanes, self.size), complex)
        y[:, 0], y[:, 1] = self.value("initial.x"), self.value("initial.y")
        y[:, 2 : self.v.start] = self.values("initial.angle[{}]")
        y[:, self.v.start + 2 : self.v.stop] = self.values("initial.angular_velocity[{}]")
        if not self.pinned:
            y[:, self.v.start], y[:, self.v.start + 1] = self.value("initial.vx"), self.value("initial.vy")
        return y

    # --- motion ------------------------------------------------------------------------------------------

    def locate(self, y: np.ndarray) -> Place:
        """Where the chain is in a state, and how it moves. The last two are kept."""
        for state, place in self.recent:
            if state is y:
                return place
        place = Place(self, y)
        self.recent = [(y, place), *self.recent[:1]]
        return place

    def mass_matrix(self, place: Place) -> np.ndarray:
        along, n = place.along, self.links
        matrix = np.zeros((self.lanes, n + 2, n + 2), complex)
        matrix[:, 0, 0] = matrix[:, 1, 1] = self.total
        matrix[:, 2:, :2] = coupling = self.b[..., None] * place.across
        matrix[:, :2, 2:] = coupling.swapaxes(1, 2)
        matrix[:, 2:, 2:] = self.c * (along @ along.swapaxes(1, 2)) + self.own
        return matrix

    def answer(self, place: Place, forces: np.ndarray) -> np.ndarray:
        """M⁻¹ f of the coordinates that are free, for one f in each lane."""
        return self.answers(place, forces[..., None])[..., 0]

    def answers(self, place: Place, columns: np.ndarray) -> np.ndarray:
        """The same for the columns of a matrix in each lane."""
        first, result = 2 if self.pinned else 0, np.zeros_like(columns)
        result[:, first:] = np.linalg.solve(place.mass[:, first:, first:], columns[:, first:])
        return result

    def gradient(self, place: Place, c: int) -> np.ndarray:
        """J of the clearance of candidate c."""
        if c >= self.at_walls:
            joint, side = self.joints[c - self.at_walls], self.side[c - self.at_walls]
            result = np.zeros((self.lanes, self.links + 2), complex)
            result[:, 2 + joint] = side
            if joint:
                result[:, 1 + joint] = -side
            return result
        return self.pull(place, self.points[c], self.normal[:, c])

    def pull(self, place: Place, point: int, direction: np.ndarray) -> np.ndarray:
        """The generalized force of a unit force on one point."""
        result = np.zeros((self.lanes, self.links + 2), complex)
        result[:, :2] = direction
        across = (place.across[:, :point] * direction[:, None]).sum(2)
        result[:, 2 : 2 + point] = self.length[:, :point] * across
        return result

    def look(self, y: np.ndarray, touches: Sequence[Touch]) -> SimpleNamespace:
        """All that follows from a state: accelerations, forces, powers."""
        place = self.locate(y)
        pairs = [self.force(y, place, touch) for touch in touches]
        omega, along, across = place.omega, place.along, place.across
        if self.tip.any():
            forces = self.pull(place, self.links, self.tip)
        else:
            forces = np.zeros((self.lanes, self.links + 2), complex)
        normal = {touch.candidate: force for touch, (force, _) in zip(touches, pairs, strict=True)}
        for c, force in normal.items():
            forces += self.gradient(place, c) * force[:, None]
        friction = self.friction.slide(normal)
        for e, force in friction.items():
            forces += self.friction.row(place, e) * force[:, None]
        # Σ_j c_ij sin(θ_i−θ_j) ω_j² and −Σ b_i ω_i² e_i, to the other side
        square = (omega**2)[..., None]
        outward = self.c @ (square * along) + self.b[..., None] * self.gravity[:, None]
        forces[:, 2:] += (across * outward).sum(2)
        forces[:, :2] += (self.b[..., None] * square * along).sum(1)
        forces[:, :2] += self.total[:, None] * self.gravity
        bent, turned = self.relative(place.angle) - self.rest, self.relative(omega)
        moment = self.torque - self.damper * turned - self.spring * bent
        forces[:, 2:] += moment
        forces[:, 2:-1] -= moment[:, 1:]
        loss = (self.damper * turned**2).sum(1)
        for touch, (force, elastic) in zip(touches, pairs, strict=True):
            loss = loss - (force - elastic) * place.gap_rate[:, touch.candidate]
        rubbed = sum((-force * self.friction.speed(y, e) for e, force in friction.items()), 0.0 * loss)
        acceleration, held = self.friction.hold(place, self.answer(place, forces))
        supply = (self.torque * turned).sum(1)
        if self.tip.any():
            supply = supply + (self.tip * place.velocity[:, -1]).sum(1)
        return SimpleNamespace(
            place=place,
            acceleration=acceleration,
            pairs=pairs,
            normal=normal,
            friction=friction | held,
            rubbed=rubbed,
            loss=loss + rubbed,
            supply=supply,
            spring_energy=(0.5 * self.spring * bent**2).sum(1),
        )

    @staticmethod
    def relative(values: np.ndarray) -> np.ndarray:
        """What each link has more than the one before it."""
        result = values.copy()
        result[:, 1:] -= values[:, :-1]
        return result

    def point_accelerations(self, look: SimpleNamespace) -> np.ndarray:
        place = look.place
        turning = place.across * (self.length * look.acceleration[:, 2:])[..., None]
        inward = place.along * (self.length * place.omega**2)[..., None]
        return chained(look.acceleration[:, :2], turning - inward)

    def sinking(self, look: SimpleNamespace, c: int) -> np.ndarray:
        """δ̈ of candidate c."""
        if c < self.at_walls:
            point = self.point_accelerations(look)[:, self.points[c]]
            return -(self.normal[:, c] * point).sum(1)
        turning = self.relative(look.acceleration[:, 2:])[:, self.joints[c - self.at_walls]]
        return -self.side[c - self.at_walls] * turning

    def rate(self, y: np.ndarray, touches: Sequence[Touch]) -> np.ndarray:
        """dy/ds."""
        look = self.look(y, touches)
        result = np.zeros_like(y)
        tempo = self.tempo(y, touches)
        result[:, self.q], result[:, self.v] = y[:, self.v], look.acceleration
        result[:, self.time], result[:, self.dissipated], result[:, self.supplied] = (
            1.0,
            look.loss,
            look.supply,
        )
        result[:, self.rubbed] = look.rubbed
        for c, force in look.normal.items():
            result[:, self.impulse + c] = force
        for e, force in look.friction.items():
            if e < self.friction.first_joint:
                result[:, self.tangential + e] = force
        result *= tempo[:, None]
        for touch in touches:
            others = self.tempo(y, touches, without=touch)
            approach = -look.place.gap_rate[:, touch.candidate]
            result[:, self.root + touch.candidate] = approach / (touch.law.m * touch.scale) * others
        return result

    def tempo(self, y: np.ndarray, touches: Sequence[Touch], without: Touch | None = None) -> np.ndarray:
        """dt/ds = τ Π z^(m−1), τ = m δ*/v₀ of the first contact; 1 in flight."""
        if not touches:
            return np.ones(self.lanes, complex)
        first = touches[0]
        tempo = np.full(self.lanes, first.law.m * first.scale / first.speed[0].real, complex)
        for touch in touches:
            if touch is not without:
                tempo = tempo * y[:, self.root + touch.candidate] ** (touch.law.m - 1)
        return tempo

    # --- contacts ----------------------------------------------------------------------------------------

    def depth_power(self, y: np.ndarray, touch: Touch, exponent: Any) -> np.ndarray:
        """δ^exponent, from the root of the penetration."""
        exponent = exponent + np.zeros(self.lanes, complex)
        root = y[:, self.root + touch.candidate]
        return np.exp(exponent * math.log(touch.scale)) * power(root, touch.law.m * exponent)

    def damping(self, touch: Touch) -> np.ndarray:
        return touch.damping if touch.damped else 0.0 * touch.damping

    def force(self, y: np.ndarray, place: Place, touch: Touch) -> tuple[np.ndarray, np.ndarray]:
        """F = K δⁿ + d δᵖ δ̇, or 0 where it is cut off, and K δⁿ."""
        law = touch.law
        elastic = law.stiffness * self.depth_power(y, touch, law.exponent)
        if not touch.pushes:
            return 0.0 * elastic, elastic
        approach = -place.gap_rate[:, touch.candidate]
        damped = self.damping(touch) * self.depth_power(y, touch, law.rate_exponent) * approach
        return elastic + damped, elastic

    def push(self, y: np.ndarray, touch: Touch) -> np.ndarray:
        """F/δᵖ, whose sign tells whether the force is cut off."""
        law = touch.law
        spring = law.stiffness * self.depth_power(y, touch, law.exponent - law.rate_exponent)
        return spring - self.damping(touch) * self.locate(y).gap_rate[:, touch.candidate]

    def force_rate(self, y: np.ndarray, touches: Sequence[Touch], touch: Touch) -> np.ndarray:
        """Ḟ δ^(1−p), which is zero at a peak of the force and neither at onset nor end."""
        look, c, d = self.look(y, touches), touch.candidate, self.damping(touch)
        law = touch.law
        n, p = law.exponent, law.rate_exponent
        approach, sinking = -look.place.gap_rate[:, c], self.sinking(look, c)
        if not p.any():
            return law.stiffness * approach + d * sinking
        spring = n * law.stiffness * self.depth_power(y, touch, n - p)
        return (spring + p * d * approach) * approach + d * self.depth_power(y, touch, 1.0) * sinking

    def begin(self, y: np.ndarray, c: int) -> Touch:
        """The contact of candidate c whose clearance falls through zero in the state y."""
        place, law = self.locate(y), self.laws[c]
        gradient = self.gradient(place, c)
        mass = 1.0 / (gradient * self.answer(place, gradient)).sum(1)
        arrival = -place.gap_rate[:, c]
        speed = arrival if arrival[0].real > law.slowest[0].real else law.slowest
        n, k = law.exponent[0].real, law.stiffness[0].real
        # K δ*ⁿ⁺¹/(n+1) = ½ m v₀²
        scale = ((n + 1.0) * mass[0].real * speed[0].real ** 2 / (2.0 * k)) ** (1.0 / (n + 1.0))
        impulse = y[:, self.impulse + c].copy()
        touch = Touch(c, law, y[:, self.time].copy(), arrival, speed, mass, impulse, scale)
        touch.latch()
        y[:, self.root + c] = 0.0
        return touch

    def bounce(self, y: np.ndarray, c: int) -> tuple[np.ndarray, Touch]:
        """The state after a rigid impact of candidate c: q̇⁺ = q̇ − M⁻¹Jᵀ m (1+e) J q̇."""
        place, touch = self.locate(y), self.begin(y, c)
        assert touch.onset_speed[0].real > touch.law.slowest[0].real, "a contact comes to rest"
        impulse = touch.mass * (1.0 + touch.law.restitution) * touch.onset_speed
        after = y.copy()
        after[:, self.v] += self.answer(place, self.gradient(place, c)) * impulse[:, None]
        after[:, self.impulse + c] += impulse
        loss = 0.5 * touch.mass * (1.0 - touch.law.restitution**2) * touch.onset_speed**2
        after[:, self.dissipated] += loss
        return after, touch
