"""Parts of the chain in complex numbers (chain_model.py): driven inputs, a located chain, and a contact."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from chain_impact.scene.keys.signal_tables import Signal
from tests.helpers.models.complex_laws import Law

if TYPE_CHECKING:
    from tests.helpers.models.chain_model import ChainModel


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
