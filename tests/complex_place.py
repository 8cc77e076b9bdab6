"""What the chain in complex numbers has in a state: where it is and how fast, and its contacts."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from tests.complex_laws import Law

if TYPE_CHECKING:
    from tests.complex_chain import ComplexChain


class Place:
    """Directions, positions and velocities in a state, and clearances of the candidates and their rates."""

    def __init__(self, chain: ComplexChain, y: np.ndarray) -> None:
        self.chain, self.y = chain, y
        self.points = chain.points[: chain.at_walls]
        self.angle, self.omega = y[:, 2 : chain.v.start], y[:, chain.v.start + 2 : chain.v.stop]
        self.along = np.empty((*self.angle.shape, 2), complex)  # e_i …
        self.across = np.empty_like(self.along)  # … and e_i⊥
        self.along[..., 0] = self.across[..., 1] = np.cos(self.angle)
        self.along[..., 1] = np.sin(self.angle)
        self.across[..., 0] = -self.along[..., 1]
        self.rows: dict[int, np.ndarray] = {}  # J of the tangential motion of elements

    @cached_property
    def mass(self) -> np.ndarray:
        """The mass matrix, which everything that is asked of this state shares."""
        return self.chain.mass_matrix(self)

    @cached_property
    def position(self) -> np.ndarray:
        return chained(self.y[:, :2], self.along * self.chain.length[..., None])

    @cached_property
    def velocity(self) -> np.ndarray:
        base = self.y[:, self.chain.v.start : self.chain.v.start + 2]
        return chained(base, self.across * (self.chain.length * self.omega)[..., None])

    @cached_property
    def gap(self) -> np.ndarray:
        chain = self.chain
        at_walls = (chain.normal * self.position[:, self.points]).sum(2) - chain.offset
        return np.concatenate([at_walls, chain.side * (self._joints(self.angle) - chain.limit)], 1)

    @cached_property
    def gap_rate(self) -> np.ndarray:
        chain = self.chain
        at_walls = (chain.normal * self.velocity[:, self.points]).sum(2)
        return np.concatenate([at_walls, chain.side * self._joints(self.omega)], 1)

    def _joints(self, values: np.ndarray) -> np.ndarray:
        """What the link behind the joint of each stop has more than the one before it."""
        return self.chain.relative(values)[:, self.chain.joints]


def chained(base: np.ndarray, parts: np.ndarray) -> np.ndarray:
    """Base, and base and parts up to each link: of all points, shape (lanes, N+1, 2)."""
    result = np.empty((len(base), parts.shape[1] + 1, 2), complex)
    result[:, 0] = base
    np.cumsum(parts, 1, out=result[:, 1:])
    result[:, 1:] += base[:, None]
    return result


@dataclass
class Touch:
    """A contact that lasts: what is latched at its onset, and its largest force and penetration so far."""

    candidate: int
    law: Law
    onset: np.ndarray  # s
    onset_speed: np.ndarray  # m/s
    speed: np.ndarray  # m/s, v₀
    mass: np.ndarray  # kg
    impulse: np.ndarray  # N·s, of the candidate at the onset
    scale: float  # m, of the penetration: not a function of the parameters
    damping: np.ndarray = field(init=False)  # N·s/m^(p+1), d
    pushes: bool = True  # the force is not cut off
    damped: bool = True  # δ̇ > 0, or the law damps on the way back, too
    forces: list[np.ndarray] = field(default_factory=list)  # N, at each of its peaks
    depths: list[np.ndarray] = field(default_factory=list)  # m, likewise

    def latch(self) -> None:
        self.damping = self.law.damping(self.speed, self.mass)
