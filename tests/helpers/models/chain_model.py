"""The chain in complex numbers: a value and, as the imaginary part, its derivative by a parameter.

The model serves derivatives.py and shares no code with the kernel: the mass matrix and the forces of a chain
by Lagrange's equations for all links at once, the contact laws after docs/contact_laws.md, and Coulomb's law.
The first axis of every array is the lane: in lane i only the i-th parameter has an imaginary part. All lanes
have the same real parts. Units are SI throughout.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np

from chain_impact.kernel.constraints.geometry import WALLS
from chain_impact.scene.candidates import candidates_of as candidates
from chain_impact.scene.scene import Scene
from tests.helpers.models.chain_friction import DryFriction
from tests.helpers.models.chain_parts import PATHS, Path, Place, Touch, chained, relative
from tests.helpers.models.complex_laws import TINY, Law

Inputs = Mapping[str, Any]
"""Constant values of inputs, or their times and values; each value holds until the next time."""


class ChainModel:
    """The equations of a scene with some parameters perturbed, one in each lane.

    The state of a lane consists of q = (x₀, y₀, θ), q̇, time, dissipated and supplied energy, the energy
    dissipated by dry friction, the normal and the tangential impulse of each candidate, and z of each
    candidate: the root z = (δ/δ*)^(1/m) of its penetration during a contact. With dt/ds = τ Π z^(m−1) the
    motion is smooth in s, also where contacts begin and end, if m n and m p are whole.

    Args:
        scene: the chain, its walls and its law.
        parameters: the names of the parameters in the FMU.
        inputs: the inputs, by name.
    """

    place_type = Place

    def __init__(self, scene: Scene, parameters: Sequence[str] = (), inputs: Inputs | None = None) -> None:
        self.scene, self.parameters, self.inputs = scene, list(parameters), dict(inputs or {})
        self.base = {k: v for k, v in scene.values.items() if isinstance(v, float | int)}
        self._signals()
        self.base |= {k: v for k, v in self.inputs.items() if isinstance(v, float | int)}
        unknown = set(parameters) - set(self.base)
        assert not unknown, f"no parameters: {unknown}"
        self.lanes = max(1, len(self.parameters))
        # derivatives relative to the size of each parameter make the imaginary parts of all lanes similar in
        # size
        self.sizes = np.array([abs(self.base[name]) or 1.0 for name in self.parameters])
        self.links, self.pinned = len(scene.chain.links), scene.chain.base == "pinned"
        self.recent: list[tuple[np.ndarray, Place]] = []
        self._bodies()
        self._candidates()
        n, count = self.links + 2, len(self.points)
        self.q, self.v = slice(0, n), slice(n, 2 * n)
        self.time, self.dissipated, self.supplied, self.rubbed, self.impulse = range(2 * n, 2 * n + 5)
        self.tangential, self.root = self.impulse + count, self.impulse + 2 * count
        self.size = self.root + count
        self.friction = DryFriction(self)
        self.set_inputs(0.0)

    def _signals(self) -> None:
        """Set held inputs, the targets of joints that signals move, and the times at which inputs change.

        A smooth ramp or a sine, without parameters of its own, gives a joint's target and the target's rate.
        """
        self.paths: dict[int, Path] = {}
        for signal in self.scene.signals.values():
            for name in signal.input:
                if signal.form == "steps":
                    self.inputs[name] = (signal.times, signal.values)
                else:
                    assert name.endswith("target_angle"), name
                    self.paths[int(name[6]) - 1] = PATHS[signal.form](signal)
        switches = {t for given in self.inputs.values() if np.ndim(given) for t in given[0]}
        switches |= {t for path in self.paths.values() for t in path.switches}
        self.switches = sorted(switches - {0.0})

    def targets(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the angles that springs of joints pull to, and rates that dampers follow, (lanes, N)."""
        angles, rates = self.rest.copy(), self.target_rate.copy()
        for joint, path in self.paths.items():
            angles[:, joint], rates[:, joint] = path.at(time)
        return angles, rates

    def value(self, name: str, otherwise: float = 0.0) -> np.ndarray:
        """Return a parameter in each lane, shape (lanes,)."""
        value = np.full(self.lanes, self.base.get(name, otherwise), complex)
        for lane, parameter in enumerate(self.parameters):
            if parameter == name:
                value[lane] += 1j * TINY * self.sizes[lane]
        return value

    def values(self, form: str) -> np.ndarray:
        """Return a parameter of each link in each lane, shape (lanes, N)."""
        return np.stack([self.value(form.format(i + 1)) for i in range(self.links)], 1)

    def set_inputs(self, time: float) -> None:
        """Use the inputs that hold from a time [s] on."""
        for name, given in self.inputs.items():
            if not isinstance(given, float | int):
                self.base[name] = given[1][np.searchsorted(given[0], time, side="right") - 1]
        self.torque = self.values("joint[{}].torque")
        if not self.pinned:
            self.torque[:, 0] = 0.0
        self.tip = np.stack([self.value(f"tip.force.{axis}") for axis in "xy"], 1)
        self.target_rate = self.values("joint[{}].target_velocity")
        names = [
            (f"joint[{i}].target_angle", f"link[{i}].joint_rest_angle") for i in range(1, self.links + 1)
        ]
        self.rest = np.stack([self.value(name if name in self.base else own) for name, own in names], 1)

    def _bodies(self) -> None:
        """Set the terms of T = ½m|ẋ₀|² + Σ b_i ω_i (ẋ₀·e_i⊥) + ½Σ c_ij cos(θ_i−θ_j) ω_i ω_j + ½Σ I_i ω_i²."""
        mass, self.length = self.values("link[{}].mass"), self.values("link[{}].length")
        centre, n = self.values("link[{}].center_of_mass"), self.links
        # arm along link i to the mass k: the length of link i or, for k = i, the distance of the centre of
        # mass
        arm = np.zeros((self.lanes, n, n), complex)
        for k in range(n):
            arm[:, :k, k] = self.length[:, :k]
            arm[:, k, k] = centre[:, k]
        self.total, self.b = mass.sum(1), (arm * mass[:, None]).sum(2)
        self.own = self.values("link[{}].inertia")[..., None] * np.eye(n)
        self.c = np.einsum("lik,lk,ljk->lij", arm, mass, arm)
        self.damper, self.spring = (
            self.values(f"link[{{}}].joint_{name}") for name in ("damping", "stiffness")
        )
        if not self.pinned:
            self.damper[:, 0] = self.spring[:, 0] = 0.0
        self.gravity = np.stack([self.value("gravity.x"), self.value("gravity.y")], 1)

    def _candidates(self) -> None:
        """Set points, walls and laws of all candidates: at walls n and n·x, at stops sides and limits.

        The clearance of a stop is side · (θ_i − θ_{i−1} − limit).
        """
        found, names = candidates(self.scene), self.scene.wall_names
        self.points = np.array([point for point, _ in found], int)
        self.walls = np.array([wall for _, wall in found], int)
        self.at_walls = len(found) - len(self.scene.chain.stops)
        self.normal = np.zeros((self.lanes, self.at_walls, 2), complex)
        self.offset = np.zeros((self.lanes, self.at_walls), complex)
        for c, wall in enumerate(self.walls[: self.at_walls]):
            name = names[wall]
            if wall < len(WALLS):
                sign = 1.0 - 2.0 * (wall % 2)
                self.normal[:, c, wall // 2] = sign
                self.offset[:, c] = sign * self.value(f"box.{name}")
            else:
                angle = self.value(f"wall.{name}.angle")
                self.normal[:, c] = np.stack([-np.sin(angle), np.cos(angle)], 1)
                place = np.stack([self.value(f"wall.{name}.{axis}") for axis in "xy"], 1)
                self.offset[:, c] = (self.normal[:, c] * place).sum(1)
        self.offset += self.value("contact.radius")[:, None]
        self.joints = self.points[self.at_walls :] - 1
        kinds = [names[wall] for wall in self.walls[self.at_walls :]]
        self.side = np.array([1.0 if kind == "joint_min" else -1.0 for kind in kinds])
        limits = [self.value(f"link[{i + 1}].{kind}") for i, kind in zip(self.joints, kinds, strict=True)]
        self.limit = np.array(limits, complex).reshape(len(limits), self.lanes).T
        contact, stops = self.scene.contact.model, self.scene.stops.model
        at_walls = [names[wall] for wall in self.walls[: self.at_walls]]
        made = {name: self._law("contact", contact, f"wall.{name}") for name in set(at_walls)}
        self.laws = [made[name] for name in at_walls]
        if kinds:
            self.laws += [self._law("stop", stops or contact)] * len(kinds)

    def _law(self, table: str, model: str, material: str = "") -> Law:
        keys, own = ("stiffness", "exponent", "restitution", "minimum_impact_speed"), f"{material}."
        names = (own + key if own + key in self.base else f"{table}.{key}" for key in keys)
        return Law(model, *map(self.value, names))

    def start(self) -> np.ndarray:
        """Return the state at time 0, shape (lanes, size)."""
        y, first = np.zeros((self.lanes, self.size), complex), self.v.start
        y[:, 0], y[:, 1] = self.value("initial.x"), self.value("initial.y")
        y[:, 2:first] = self.values("initial.angle[{}]")
        y[:, first + 2 : self.v.stop] = self.values("initial.angular_velocity[{}]")
        if not self.pinned:
            y[:, first], y[:, first + 1] = self.value("initial.vx"), self.value("initial.vy")
        return y

    # --- motion ------------------------------------------------------------------------------------------

    def locate(self, y: np.ndarray) -> Place:
        """Return the place of the chain in a state, and its motion. The last two places are kept."""
        for state, place in self.recent:
            if state is y:
                return place
        place = self.place_type(self, y)
        self.recent = [(y, place), *self.recent[:1]]
        return place

    def answers(self, place: Place, columns: np.ndarray) -> np.ndarray:
        """Return M⁻¹ f for the free coordinates, for the columns f of a matrix in each lane."""
        first, result = 2 if self.pinned else 0, np.zeros_like(columns)
        result[:, first:] = np.linalg.solve(place.mass[:, first:, first:], columns[:, first:])
        return result

    def answer(self, place: Place, forces: np.ndarray) -> np.ndarray:
        """Return M⁻¹ f for the free coordinates, for one f in each lane."""
        return self.answers(place, forces[..., None])[..., 0]

    def gradient(self, place: Place, c: int) -> np.ndarray:
        """Return J of the clearance of candidate c."""
        if c >= self.at_walls:
            return self.side[c - self.at_walls] * self.joint_row(self.joints[c - self.at_walls])
        return self.pull(place, self.points[c], self.normal[:, c])

    def joint_row(self, joint: int) -> np.ndarray:
        """Return J of the angle of a joint, from 0."""
        result = np.zeros((self.lanes, self.links + 2), complex)
        result[:, 2 + joint] = 1.0
        if joint:
            result[:, 1 + joint] = -1.0
        return result

    def pull(self, place: Place, point: int, direction: np.ndarray) -> np.ndarray:
        """Return the generalized force of a unit force on one point."""
        result = np.zeros((self.lanes, self.links + 2), complex)
        result[:, :2] = direction
        across = (place.across[:, :point] * direction[:, None]).sum(2)
        result[:, 2 : 2 + point] = self.length[:, :point] * across
        return result

    def look(self, y: np.ndarray, touches: Sequence[Touch]) -> SimpleNamespace:
        """Return all quantities that follow from a state: accelerations, forces, powers."""
        place = self.locate(y)
        pairs = [self.force(y, place, touch) for touch in touches]
        omega, along, across, pushed = place.omega, place.along, place.across, self.tip.any()
        forces = np.zeros((self.lanes, self.links + 2), complex)
        if pushed:
            forces += self.pull(place, self.links, self.tip)
        normal = {touch.candidate: force for touch, (force, _) in zip(touches, pairs, strict=True)}
        for c, force in normal.items():
            forces += self.gradient(place, c) * force[:, None]
        friction = self.friction.slide(normal)
        for e, force in friction.items():
            forces += self.friction.row(place, e) * force[:, None]
        # the terms Σ_j c_ij sin(θ_i−θ_j) ω_j² and −Σ b_i ω_i² e_i, moved to the right side
        square = (omega**2)[..., None]
        outward = self.c @ (square * along) + self.b[..., None] * self.gravity[:, None]
        forces[:, 2:] += (across * outward).sum(2)
        forces[:, :2] += (self.b[..., None] * square * along).sum(1) + self.total[:, None] * self.gravity
        (rest, rate), turned = self.targets(y[:, self.time]), relative(omega)
        bent = relative(place.angle) - rest
        moment = self.torque - self.damper * (turned - rate) - self.spring * bent
        forces[:, 2:] += moment
        forces[:, 2:-1] -= moment[:, 1:]
        loss = (self.damper * turned**2).sum(1)
        for touch, (force, elastic) in zip(touches, pairs, strict=True):
            loss = loss - (force - elastic) * place.gap_rate[:, touch.candidate]
        rubbed = sum((-force * self.friction.speed(y, e) for e, force in friction.items()), 0.0 * loss)
        acceleration, held = self.friction.hold(place, self.answer(place, forces), normal)
        supply = (self.torque * turned).sum(1)
        if pushed:
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

    def point_accelerations(self, look: SimpleNamespace) -> np.ndarray:
        place = look.place
        turning = place.across * (self.length * look.acceleration[:, 2:])[..., None]
        inward = place.along * (self.length * place.omega**2)[..., None]
        return chained(look.acceleration[:, :2], turning - inward)

    def sinking(self, look: SimpleNamespace, c: int) -> np.ndarray:
        """Return δ̈ of candidate c."""
        if c < self.at_walls:
            point = self.point_accelerations(look)[:, self.points[c]]
            return -(self.normal[:, c] * point).sum(1)
        turning = relative(look.acceleration[:, 2:])[:, self.joints[c - self.at_walls]]
        return -self.side[c - self.at_walls] * turning

    def rate(self, y: np.ndarray, touches: Sequence[Touch]) -> np.ndarray:
        """Return dy/ds."""
        look, result, tempo = self.look(y, touches), np.zeros_like(y), self.tempo(y, touches)
        result[:, self.q], result[:, self.v] = y[:, self.v], look.acceleration
        result[:, self.time], result[:, self.dissipated] = 1.0, look.loss
        result[:, self.supplied], result[:, self.rubbed] = look.supply, look.rubbed
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
        """Return dt/ds = τ Π z^(m−1), with τ = m δ*/v₀ of the first contact; 1 in flight."""
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
        """Return δ^exponent, from the root of the penetration."""
        exponent = exponent + np.zeros(self.lanes, complex)
        root = y[:, self.root + touch.candidate]
        return np.exp(exponent * math.log(touch.scale)) * power(root, touch.law.m * exponent)

    def damping(self, touch: Touch) -> np.ndarray:
        return touch.damping if touch.damped else 0.0 * touch.damping

    def force(self, y: np.ndarray, place: Place, touch: Touch) -> tuple[np.ndarray, np.ndarray]:
        """Return F = K δⁿ + d δᵖ δ̇, or 0 where the force is cut off, and K δⁿ."""
        law = touch.law
        elastic = law.stiffness * self.depth_power(y, touch, law.exponent)
        if not touch.pushes:
            return 0.0 * elastic, elastic
        approach = -place.gap_rate[:, touch.candidate]
        damped = self.damping(touch) * self.depth_power(y, touch, law.rate_exponent) * approach
        return elastic + damped, elastic

    def push(self, y: np.ndarray, touch: Touch) -> np.ndarray:
        """Return F/δᵖ, whose sign says whether the force is cut off."""
        law = touch.law
        spring = law.stiffness * self.depth_power(y, touch, law.exponent - law.rate_exponent)
        return spring - self.damping(touch) * self.locate(y).gap_rate[:, touch.candidate]

    def force_rate(self, y: np.ndarray, touches: Sequence[Touch], touch: Touch) -> np.ndarray:
        """Return Ḟ δ^(1−p), which is zero at a peak of the force, but not at onset and end."""
        look, c, d = self.look(y, touches), touch.candidate, self.damping(touch)
        n, p, stiffness = touch.law.exponent, touch.law.rate_exponent, touch.law.stiffness
        approach, sinking = -look.place.gap_rate[:, c], self.sinking(look, c)
        if not p.any():
            return stiffness * approach + d * sinking
        spring = n * stiffness * self.depth_power(y, touch, n - p)
        return (spring + p * d * approach) * approach + d * self.depth_power(y, touch, 1.0) * sinking

    def begin(self, y: np.ndarray, c: int) -> Touch:
        """Return the contact of candidate c, whose clearance falls through zero in the state y."""
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
        """Return the state after a rigid impact of candidate c: q̇⁺ = q̇ − M⁻¹Jᵀ m (1+e) J q̇."""
        place, touch = self.locate(y), self.begin(y, c)
        assert touch.onset_speed[0].real > touch.law.slowest[0].real, "a contact comes to rest"
        impulse, e = touch.mass * (1.0 + touch.law.restitution) * touch.onset_speed, touch.law.restitution
        after = y.copy()
        after[:, self.v] += self.answer(place, self.gradient(place, c)) * impulse[:, None]
        after[:, self.impulse + c] += impulse
        after[:, self.dissipated] += 0.5 * touch.mass * (1.0 - e**2) * touch.onset_speed**2
        return after, touch


def power(base: np.ndarray, exponent: np.ndarray) -> np.ndarray:
    """Return base^exponent in each lane; for an exponent that is not whole, as if the base were positive."""
    if exponent[0].real == round(exponent[0].real) and not exponent.imag.any():
        return base ** round(exponent[0].real)
    none = base == 0.0
    positive = np.where(none, 1.0, np.where(base.real < 0.0, -base, base))
    return np.where(none, 0.0, np.exp(exponent * np.log(positive)))
