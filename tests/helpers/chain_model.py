"""The chain in complex numbers: a value and, as the imaginary part, its derivative by a parameter.

The model serves ``tests.helpers.derivatives`` and shares no code with the kernel: the mass matrix and the
forces of a chain by Lagrange's equations for all links at once, the contact laws after docs/contact_laws.md,
and Coulomb's law. The first axis of every array is the lane: in lane i only the i-th parameter has an
imaginary part. All lanes have the same real parts. Units are SI throughout.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from types import SimpleNamespace
from typing import Any

import numpy as np

from chain_impact.kernel.rows.geometry import WALLS
from chain_impact.scene.candidates import candidates
from chain_impact.scene.scene import Scene
from chain_impact.scene.signal import Signal
from tests.helpers.complex_laws import TINY, Law

REST = 1e-9  # [m/s or rad/s] the largest speed that counts as rest when modes are decided
# the largest error of a consistent mode, over a limit of friction or the largest acceleration
ROUND_OFF = 1e-9
DEPENDENT = 1e8  # the least condition number of constraints that count as dependent
Inputs = Mapping[str, Any]
"""Constant values of inputs, or their times and values; each value holds until the next time."""


class Ramp:
    """The smooth ramp 10 x³ − 15 x⁴ + 6 x⁵ of a signal, with its rate."""

    def __init__(self, signal: Signal) -> None:
        assert signal.shape == "smooth"
        self.signal = signal
        self.switches = signal.start, signal.start + signal.duration

    def at(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        own = self.signal
        x = (time - own.start) / own.duration
        x = np.where(x.real <= 0.0, 0.0, np.where(x.real >= 1.0, 1.0, x))
        height = own.final - own.initial
        value = own.initial + height * np.polyval([6.0, -15.0, 10.0, 0.0, 0.0, 0.0], x)
        return value, height / own.duration * 30.0 * x**2 * (1.0 - x) ** 2


class Sine:
    """A sine of constant frequency and amplitude, from time 0, with its rate."""

    switches = ()

    def __init__(self, signal: Signal) -> None:
        assert not any((signal.start, signal.rise, signal.frequency_rate))
        self.signal, self.rate = signal, 2.0 * math.pi * signal.frequency

    def at(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        own, phase = self.signal, self.signal.phase + self.rate * time
        return own.mean + own.amplitude * np.sin(phase), own.amplitude * self.rate * np.cos(phase)


Path = Ramp | Sine
PATHS: dict[str, type[Path]] = {"ramp": Ramp, "sine": Sine}


class Place:
    """The geometry of a state: directions, positions, velocities, candidates' clearances and rates."""

    def __init__(self, chain: ChainModel, y: np.ndarray) -> None:
        self.chain, self.y = chain, y
        self.angle, self.omega = y[:, 2 : chain.v.start], y[:, chain.v.start + 2 : chain.v.stop]
        cos, sin = np.cos(self.angle), np.sin(self.angle)
        self.along, self.across = np.stack([cos, sin], -1), np.stack([-sin, cos], -1)
        self.rows: dict[int, np.ndarray] = {}  # J of the tangential motion of elements

    @cached_property
    def mass(self) -> np.ndarray:
        chain, matrix = self.chain, np.zeros((self.chain.lanes, *[self.chain.links + 2] * 2), complex)
        matrix[:, 0, 0] = matrix[:, 1, 1] = chain.total
        matrix[:, 2:, :2] = coupling = chain.b[..., None] * self.across
        matrix[:, :2, 2:] = coupling.swapaxes(1, 2)
        matrix[:, 2:, 2:] = chain.c * (self.along @ self.along.swapaxes(1, 2)) + chain.own
        return matrix

    @cached_property
    def position(self) -> np.ndarray:
        return chained(self.y[:, :2], self.along * self.chain.length[..., None])

    @cached_property
    def velocity(self) -> np.ndarray:
        base = self.y[:, self.chain.v.start : self.chain.v.start + 2]
        return chained(base, self.across * (self.chain.length * self.omega)[..., None])

    @cached_property
    def gap(self) -> np.ndarray:
        chain, at = self.chain, self.position[:, self.chain.points[: self.chain.at_walls]]
        joints = relative(self.angle)[:, chain.joints] - chain.limit
        return np.concatenate([(chain.normal * at).sum(2) - chain.offset, chain.side * joints], 1)

    @cached_property
    def gap_rate(self) -> np.ndarray:
        chain, moves = self.chain, self.velocity[:, self.chain.points[: self.chain.at_walls]]
        joints = relative(self.omega)[:, chain.joints]
        return np.concatenate([(chain.normal * moves).sum(2), chain.side * joints], 1)


def chained(base: np.ndarray, parts: np.ndarray) -> np.ndarray:
    """Return the sums of base and parts up to each link, for all points, shape (lanes, N+1, 2)."""
    return np.cumsum(np.concatenate([base[:, None], parts], 1), 1)


def relative(values: np.ndarray) -> np.ndarray:
    """Return for each link its value minus the value of the link before it."""
    return np.diff(values, axis=1, prepend=0.0)


@dataclass
class Touch:
    """A contact that lasts: the values latched at its onset, and its largest force and penetration so far."""

    candidate: int
    law: Law
    onset: np.ndarray  # s
    onset_speed: np.ndarray  # m/s
    speed: np.ndarray  # m/s, v₀
    mass: np.ndarray  # kg
    impulse: np.ndarray  # N·s, impulse of the candidate at the onset
    scale: float  # m, scale of the penetration; not a function of the parameters
    damping: np.ndarray = field(init=False)  # N·s/m^(p+1), d
    pushes: bool = True  # whether the force is not cut off
    damped: bool = True  # whether δ̇ > 0, or the law also damps during restitution
    forces: list[np.ndarray] = field(default_factory=list)  # N, force at each of its peaks
    depths: list[np.ndarray] = field(default_factory=list)  # m, each peak of the penetration

    def latch(self) -> None:
        self.damping = self.law.damping(self.speed, self.mass)


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


class DryFriction:
    """Coulomb's law: the sign of sliding is latched, sticking elements are constraints.

    An element is a candidate at a wall, with a force along t = (n_y, −n_x) during a contact, or a joint, with
    a moment; joints come after the candidates. An element that slides with the sign s has the force −s µ F_n.
    A sticking element has no acceleration along t, which is a constraint.

    Attributes:
        sliding, static: friction of each element in each lane: a coefficient, or a moment [N·m].
        modes: mode of each element that acts now: 0 sticks, ±1 slides along ±t.
    """

    def __init__(self, chain: ChainModel) -> None:
        self.chain, self.first_joint = chain, len(chain.points)
        self.sliding: dict[int, np.ndarray] = {}
        self.static: dict[int, np.ndarray] = {}
        self.modes: dict[int, int] = {}
        for c in range(chain.at_walls):
            sliding, static = self._coefficients(chain.scene.wall_names[chain.walls[c]])
            if static[0].real > 0.0:
                self.sliding[c], self.static[c] = sliding, static
        moments = chain.values("link[{}].joint_friction")
        for i in range(0 if chain.pinned else 1, chain.links):
            if moments[0, i].real > 0.0:
                self.sliding[self.first_joint + i] = self.static[self.first_joint + i] = moments[:, i]

    def _coefficients(self, wall: str) -> tuple[np.ndarray, np.ndarray]:
        """Return µ and µ_s of a wall: its own coefficients, or those of all walls."""
        chain, own = self.chain, f"wall.{wall}."
        sliding, static = chain.value("contact.friction"), chain.value("contact.static_friction")
        if f"{own}friction" in chain.base:
            sliding, static = chain.value(f"{own}friction"), 0.0 * static
        if f"{own}static_friction" in chain.base:
            static = chain.value(f"{own}static_friction")
        return sliding, static if static[0].real > sliding[0].real else sliding

    def row(self, place: Place, e: int) -> np.ndarray:
        """Return J of the tangential motion of element e; for a joint, J of its angle."""
        if e not in place.rows:
            joint, chain = e - self.first_joint, self.chain
            if joint >= 0:
                place.rows[e] = chain.joint_row(joint)
            else:
                place.rows[e] = chain.pull(place, chain.points[e], self.tangent(e))
        return place.rows[e]

    def tangent(self, c: int) -> np.ndarray:
        return self.chain.normal[:, c, ::-1] * [1.0, -1.0]

    def speed(self, y: np.ndarray, e: int) -> np.ndarray:
        return (self.row(self.chain.locate(y), e) * y[:, self.chain.v]).sum(1)

    def acceleration(self, place: Place, acceleration: np.ndarray, e: int) -> np.ndarray:
        """Return the acceleration of element e along t, J q̈ + J̇ q̇, for q̈."""
        along = (self.row(place, e) * acceleration).sum(1)
        if e >= self.first_joint:
            return along
        inward = -(place.along * (self.chain.length * place.omega**2)[..., None])
        return along + (self.tangent(e) * inward[:, : self.chain.points[e]].sum(1)).sum(1)

    def slide(self, normal: Mapping[int, np.ndarray]) -> dict[int, np.ndarray]:
        """Return the forces of sliding elements, for the normal forces of the candidates."""
        return {e: -s * self.sliding[e] * normal.get(e, 1.0) for e, s in self.modes.items() if s}

    def bound(self, normal: Mapping[int, np.ndarray], e: int) -> np.ndarray:
        """Return the largest force with which element e sticks."""
        return self.static[e] * normal.get(e, 1.0)

    def hold(
        self, place: Place, free: np.ndarray, normal: Mapping[int, np.ndarray]
    ) -> tuple[np.ndarray, dict[int, np.ndarray]]:
        """Return accelerations with sticking elements, and the forces of these elements.

        ``free`` holds the accelerations without these forces.

        ``without`` holds the accelerations without these elements.
        """
        stuck = [e for e, s in self.modes.items() if s == 0]
        if not stuck:
            return free, {}
        asked = np.stack([-self.acceleration(place, free, e) for e in stuck], 1)
        bounds = np.array([self.bound(normal, e)[0].real + 1e-300 for e in stuck])
        change, forces = self.respond(place, stuck, asked, bounds)
        return free + change, dict(zip(stuck, forces.T, strict=True))

    def respond(
        self, place: Place, stuck: Sequence[int], asked: np.ndarray, bounds: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the motion M⁻¹Jᵀλ that gives elements the motion ``asked``, and λ.

        In a model without parameters, dependent constraints get the forces with the least Σ λ²/bound.
        """
        rows = np.stack([self.row(place, e) for e in stuck], 1)
        moved = self.chain.answers(place, rows.swapaxes(1, 2)).swapaxes(1, 2)
        matrix = rows @ np.swapaxes(moved, 1, 2)
        if len(stuck) > 1 and np.linalg.cond(matrix[0].real) > DEPENDENT:
            assert not self.chain.parameters, "dependent constraints have no derivatives"
            share = np.sqrt(np.maximum(bounds / bounds.max(), 1e-9))
            inverse = np.linalg.pinv(matrix[0].real * share, 1.0 / DEPENDENT)
            forces = ((share[:, None] * inverse) @ asked[..., None])[..., 0]
        else:
            forces = np.linalg.solve(matrix, asked[..., None])[..., 0]
        return (moved * forces[..., None]).sum(1), forces

    # --- modes -------------------------------------------------------------------------------------------

    def begin(self, y: np.ndarray, touches: Sequence[Touch]) -> None:
        """Decide the modes of joints at the start."""
        self.modes = {e: 1 for e in self.sliding if e >= self.first_joint}
        self.decide(y, touches, list(self.modes))

    def touch(self, y: np.ndarray, c: int) -> None:
        """Begin the friction of candidate c, which begins to touch."""
        if c in self.sliding:
            speed = self.speed(y, c)[0].real
            self.modes[c] = 0 if abs(speed) < REST else int(np.sign(speed))

    def decide(
        self, y: np.ndarray, touches: Sequence[Touch], resting: Sequence[int] = (), slides: int | None = None
    ) -> None:
        """Decide the modes of sticking and ``resting`` elements, and stop sticking elements, in the state y.

        Of all consistent sets of modes, the function chooses one with the fewest sliding elements.

        Args:
            y: the state, which is changed.
            touches: the contacts that last.
            resting: elements that may stick from now on; an element with a speed does not stick.
            slides: the element that has reached the limit of static friction.
        """
        if not (undecided := [e for e, s in self.modes.items() if s == 0 or e in resting]):
            return
        options = []
        for e in undecided:
            speed = self.speed(y, e)[0].real
            if e == slides:
                options.append([-int(np.sign(self.chain.look(y, touches).friction[e][0].real))])
            else:
                options.append([int(np.sign(speed))] if abs(speed) > REST else [0, 1, -1])
        for choice in sorted(itertools.product(*options), key=np.count_nonzero):
            self.modes.update(zip(undecided, choice, strict=True))
            if self.consistent(y, touches, [e for e, one in zip(undecided, options, strict=True) if one[1:]]):
                break
        else:
            raise AssertionError("no modes of dry friction are consistent")
        self.stop(y)

    def consistent(self, y: np.ndarray, touches: Sequence[Touch], elements: Sequence[int]) -> bool:
        look = self.chain.look(y, touches)
        for e in elements:
            if s := self.modes[e]:
                along = self.acceleration(look.place, look.acceleration, e)[0].real
                if s * along < -ROUND_OFF * np.abs(look.acceleration[0]).max():
                    return False
            elif abs(look.friction[e][0].real) > (1.0 + ROUND_OFF) * self.bound(look.normal, e)[0].real:
                return False
        return True

    def stop(self, y: np.ndarray) -> None:
        """Remove the speeds of sticking elements, which are round-off, and their derivatives."""
        stuck = [e for e, s in self.modes.items() if s == 0]
        if stuck:
            asked = np.stack([-self.speed(y, e) for e in stuck], 1)
            y[:, self.chain.v] += self.respond(self.chain.locate(y), stuck, asked, np.ones(len(stuck)))[0]
            self.chain.recent = []  # the stored places would contain the old speeds

    def halting(self, y: np.ndarray, found: int) -> list[int]:
        """Return the elements that stop sliding together with the element found: all without speed now."""
        return [e for e, s in self.modes.items() if s and (e == found or abs(self.speed(y, e)[0]) < REST)]
