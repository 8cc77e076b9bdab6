"""The independent model for bodies: offsets of centres of mass, points of links, and sliders.

A point of a link is x e + y e⊥, with e along the link and e⊥ to its left; both vectors turn with the link. So
the kinetic energy has the form of chain_model.py with twice as many directions, e and e⊥ of each link, with
the same ω. A sliding base moves only along u: all equations are projected on the columns of P, of which the
first is u, and the others are the angles.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from types import SimpleNamespace
from typing import Any

import numpy as np

from chain_impact.scene.scene import Scene
from chain_impact.scene.texts.names import SLIDER_STOPS
from tests.helpers.models.chain_friction import DryFriction
from tests.helpers.models.chain_model import ChainModel, Inputs
from tests.helpers.models.chain_parts import Place, Touch, chained, relative
from tests.helpers.models.derivatives import Derivatives, _Run


def motion(scene: Scene, times: Sequence[float], tolerance: float = 1e-13) -> Derivatives:
    """Return outputs of a scene at some times, and all contacts up to the last time."""
    return _Run(BodyModel(scene), tolerance).to(times)


class BodyPlace(Place):
    """The place of a chain with the points of links, which come after the ends of links."""

    chain: BodyModel

    @cached_property
    def directions(self) -> tuple[np.ndarray, np.ndarray]:
        """The vectors e and e⊥ of all links, and both turned by a right angle, shape (lanes, 2N, 2)."""
        return (
            np.concatenate([self.along, self.across], 1),
            np.concatenate([self.across, -self.along], 1),
        )

    @cached_property
    def mass(self) -> np.ndarray:
        chain, n = self.chain, self.chain.links
        matrix = np.zeros((chain.lanes, n + 2, n + 2), complex)
        ways, turned = self.directions
        matrix[:, 0, 0] = matrix[:, 1, 1] = chain.total
        coupling = chain.folded(chain.moments[..., None] * turned)
        matrix[:, 2:, :2], matrix[:, :2, 2:] = coupling, coupling.swapaxes(1, 2)
        products = chain.products * (ways @ ways.swapaxes(1, 2))
        matrix[:, 2:, 2:] = chain.folded(chain.folded(products).swapaxes(1, 2)) + chain.own
        return matrix

    def with_points(self, ends: np.ndarray, ways: np.ndarray) -> np.ndarray:
        """Return vectors of the links' ends, then of their points, from vectors of ends and of e and e⊥."""
        chain, n = self.chain, self.chain.links
        own, place = chain.site_links, chain.site_places[..., None]
        sites = ends[:, own] + place[:, :, 0] * ways[:, own] + place[:, :, 1] * ways[:, n + own]
        return np.concatenate([ends, sites], 1)

    @cached_property
    def position(self) -> np.ndarray:
        return self.with_points(super().position, self.directions[0])

    @cached_property
    def velocity(self) -> np.ndarray:
        both = np.concatenate([self.omega, self.omega], 1)[..., None]
        return self.with_points(super().velocity, both * self.directions[1])


class BodyModel(ChainModel):
    """The equations of a scene with bodies; stops in joints together with stops of a slider are refused.

    ``motion`` supports neither the energy of drives nor moving walls.
    """

    place_type = BodyPlace

    def __init__(self, scene: Scene, parameters: Sequence[str] = (), inputs: Inputs | None = None) -> None:
        super().__init__(scene, parameters, inputs)
        self.friction = BodyFriction(self)

    def _bodies(self) -> None:
        self.pinned = self.scene.chain.base != "free"  # whether joint 1 exists
        super()._bodies()
        n, mass = self.links, self.values("link[{}].mass")
        offset, centre = (self.values(f"link[{{}}].center_of_mass{end}") for end in ("_offset", ""))
        # arm, along e and e⊥ of link i, to the mass k
        arm = np.zeros((self.lanes, 2 * n, n), complex)
        for k in range(n):
            arm[:, :k, k] = self.length[:, :k]
            arm[:, k, k], arm[:, n + k, k] = centre[:, k], offset[:, k]
        self.moments = (arm * mass[:, None]).sum(2)
        self.products = np.einsum("lik,lk,ljk->lij", arm, mass, arm)
        sites = self.scene.chain.sites
        self.site_links = np.array([link for link, _ in sites], int)
        names, numbers = [], dict.fromkeys(range(n), 0)
        for link, _ in sites:
            numbers[link] += 1
            names.append(f"link[{link + 1}].point[{numbers[link]}]")
        of_sites = [
            [self.value(f"{name}.{key}", getattr(site, key)) for key in ("x", "y", "radius")]
            for name, (_, site) in zip(names, sites, strict=True)
        ]
        values = np.array(of_sites, complex).reshape(len(sites), 3, self.lanes).transpose(2, 0, 1)
        self.site_places, self.site_radii = values[..., :2], values[..., 2]
        self._slider()
        gear, turn = self.values("link[{}].joint_armature"), np.eye(n) - np.eye(n, k=-1)
        gear[:, 0] *= self.pinned
        self.own = self.own + turn.T @ (gear[:, None] * np.eye(n)) @ turn

    def _slider(self) -> None:
        """Set P (``ways``), and for a slider u (``line``), its origin, and its mass in ``total``."""
        n, slider = self.links, self.scene.chain.slider
        free = [0, 1, *range(2, n + 2)] if self.scene.chain.base == "free" else range(2, n + 2)
        self.ways = np.tile(np.eye(n + 2, dtype=complex)[:, list(free)], (self.lanes, 1, 1))
        self.line = None
        if slider is None:
            return
        angle = self.value("slider.angle")
        self.line = np.stack([np.cos(angle), np.sin(angle)], 1)
        column = np.zeros((self.lanes, n + 2, 1), complex)
        column[:, :2, 0] = self.line
        self.ways = np.concatenate([column, self.ways], 2)
        self.total = self.total + self.value("slider.mass")
        self.origin = np.stack([self.value("initial.x"), self.value("initial.y")], 1)

    def folded(self, columns: np.ndarray) -> np.ndarray:
        """Return the sums of the entries for e and e⊥ of each link."""
        return columns[:, : self.links] + columns[:, self.links :]

    def _candidates(self) -> None:
        super()._candidates()
        assert not (self.scene.chain.stops and self.scene.slider_stops), "both kinds of stops"
        radius = self.value("contact.radius")
        for c, (point, wall) in enumerate(zip(self.points, self.walls, strict=True)):
            name = self.scene.wall_names[wall]
            if c < self.at_walls and point > self.links:
                self.offset[:, c] += self.site_radii[:, point - self.links - 1] - radius
            if name in self.scene.slider_stops:
                sign = 1.0 if name == SLIDER_STOPS[0] else -1.0
                limit = self.value(f"slider.{name.removeprefix('slider_')}")
                self.normal[:, c] = sign * self.line
                self.offset[:, c] = sign * ((self.line * self.origin).sum(1) + limit)

    def start(self) -> np.ndarray:
        y = super().start()
        if self.line is not None:
            first = self.v.start
            y[:, first : first + 2] = self.line * self.value("initial.slider_velocity")[:, None]
        return y

    def answers(self, place: Place, columns: np.ndarray) -> np.ndarray:
        back = self.ways.swapaxes(1, 2)
        return self.ways @ np.linalg.solve(back @ place.mass @ self.ways, back @ columns)

    def pull(self, place: Place, point: int, direction: np.ndarray) -> np.ndarray:
        if point <= self.links:
            return super().pull(place, point, direction)
        s = point - self.links - 1
        link, (x, y) = self.site_links[s], self.site_places[:, s].T
        result = super().pull(place, link, direction)
        # the moment r⊥·F of a force at r = x e + y e⊥
        result[:, 2 + link] = x * (place.across[:, link] * direction).sum(1)
        result[:, 2 + link] -= y * (place.along[:, link] * direction).sum(1)
        return result

    def look(self, y: np.ndarray, touches: Sequence[Touch]) -> SimpleNamespace:
        place = self.locate(y)
        pairs = [self.force(y, place, touch) for touch in touches]
        omega, (ways, turned_ways) = place.omega, place.directions
        forces = np.zeros((self.lanes, self.links + 2), complex)
        normal = {touch.candidate: force for touch, (force, _) in zip(touches, pairs, strict=True)}
        for c, force in normal.items():
            forces += self.gradient(place, c) * force[:, None]
        friction = self.friction.slide(normal)
        for e, force in friction.items():
            forces += self.friction.row(place, e) * force[:, None]
        square = np.concatenate([omega, omega], 1)[..., None] ** 2
        outward = self.products @ (square * ways) + self.moments[..., None] * self.gravity[:, None]
        forces[:, 2:] += self.folded((turned_ways * outward).sum(2))
        forces[:, :2] += (self.moments[..., None] * square * ways).sum(1)
        forces[:, :2] += self.total[:, None] * self.gravity
        (rest, rate), turned = self.targets(y[:, self.time]), relative(omega)
        bent = relative(place.angle) - rest
        wanted = self.torque - self.damper * (turned - rate) - self.spring * bent
        moment = limited(wanted, [link.joint_torque_limit for link in self.scene.chain.links])
        forces[:, 2:] += moment
        forces[:, 2:-1] -= moment[:, 1:]
        loss = (self.damper * turned**2).sum(1)
        if self.line is not None:
            parts = y[:, :2] - self.origin, y[:, self.v][:, :2]
            away, speed = ((self.line * part).sum(1) for part in parts)
            target = "slider.target_position" in self.base
            at = "target_position" if target else "rest_position"
            names = (f"slider.{key}" for key in ("damping", "stiffness", at, "force", "target_velocity"))
            damper, spring, rest, force, rate = map(self.value, names)
            push = limited(
                force - damper * (speed - rate) - spring * (away - rest),
                self.scene.chain.slider.force_limit,
            )
            forces[:, :2] += self.line * push[:, None]
            loss = loss + damper * speed**2
        for touch, (force, elastic) in zip(touches, pairs, strict=True):
            loss = loss - (force - elastic) * place.gap_rate[:, touch.candidate]
        rubbed = sum((-force * self.friction.speed(y, e) for e, force in friction.items()), 0.0 * loss)
        acceleration, held = self.friction.hold(place, self.answer(place, forces), normal)
        return SimpleNamespace(
            place=place,
            acceleration=acceleration,
            pairs=pairs,
            normal=normal,
            friction=friction | held,
            rubbed=rubbed,
            loss=loss + rubbed,
            supply=(self.torque * turned).sum(1),
            spring_energy=(0.5 * self.spring * bent**2).sum(1),
        )

    def point_accelerations(self, look: SimpleNamespace) -> np.ndarray:
        return self.accelerations(look.place, look.acceleration)

    def accelerations(self, place: Place, acceleration: np.ndarray) -> np.ndarray:
        """Return the accelerations of all points for q̈."""
        assert isinstance(place, BodyPlace)
        alpha, square = (
            np.concatenate([one, one], 1)[..., None] for one in (acceleration[:, 2:], place.omega**2)
        )
        ways, turned = place.directions
        moves = alpha * turned - square * ways
        ends = chained(acceleration[:, :2], self.length[..., None] * moves[:, : self.links])
        return place.with_points(ends, moves)


def limited(wanted: np.ndarray, limits: Any) -> np.ndarray:
    """Return forces or moments of drives, limited where they exceed their limits; None: no limit."""
    limit = np.array(limits, float)  # None becomes NaN, with which every comparison is false
    return np.where(np.abs(wanted.real) > limit, np.sign(wanted.real) * limit, wanted)


class BodyFriction(DryFriction):
    """Dry friction, also at points of links; the friction of a slider comes after the friction of joints."""

    chain: BodyModel

    def __init__(self, chain: BodyModel) -> None:
        super().__init__(chain)
        slider = chain.scene.chain.slider
        for c in range(chain.at_walls):
            if chain.scene.wall_names[chain.walls[c]] in SLIDER_STOPS:
                self.sliding.pop(c, None)
        if slider is not None and slider.friction > 0.0:
            e = self.first_joint + chain.links
            self.sliding[e] = self.static[e] = chain.value("slider.friction")

    def row(self, place: Place, e: int) -> np.ndarray:
        if e != self.first_joint + self.chain.links:
            return super().row(place, e)
        result = np.zeros((self.chain.lanes, self.chain.links + 2), complex)
        result[:, :2] = self.chain.line
        return result

    def acceleration(self, place: Place, acceleration: np.ndarray, e: int) -> np.ndarray:
        if e >= self.first_joint:
            return (self.row(place, e) * acceleration).sum(1)
        moves = self.chain.accelerations(place, acceleration)
        return (self.tangent(e) * moves[:, self.chain.points[e]]).sum(1)
