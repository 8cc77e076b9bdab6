"""The contact law of each candidate of a scene, and its chain, for the oracle of the random search."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

from chain_impact.scene.candidates import candidates
from chain_impact.scene.scene import Scene


@dataclass(frozen=True)
class Law:
    """The law of a candidate, of a stop in the angle of its joint; a rigid one has a stiffness of 0."""

    point: int
    wall: int
    stop: bool
    model: str
    stiffness: float
    exponent: float
    slowest: float  # m/s or rad/s
    unit: float  # m: 1, or the longest link, on which the errors of an angle in rad act


def laws(scene: Scene) -> list[Law]:
    """The law of each candidate."""
    contact, stops, found = scene.contact, scene.stops, []
    size = max(link.length for link in scene.chain.links)
    for point, wall in candidates(scene):
        name = scene.wall_names[wall]
        stop = name in ("joint_min", "joint_max") and bool(scene.chain.stops)
        model = (stops.model or contact.model) if stop else contact.model
        own = contact.wall.get(name)
        stiffness = stops.stiffness if stop else (own and own.stiffness) or contact.stiffness
        exponent, slowest = (
            (stops.exponent, stops.minimum_impact_speed)
            if stop
            else (contact.exponent, contact.minimum_impact_speed)
        )
        rigid = model == "newton_impact"
        unit = size if stop else 1.0
        found.append(Law(point, wall, stop, model, 0.0 if rigid else stiffness, exponent, slowest, unit))
    return found


def columns(every: list[Law], impacts: np.ndarray) -> SimpleNamespace:
    """The laws of contacts, as columns."""
    by_candidate = {(law.point, law.wall): law for law in every}
    rows = [by_candidate[int(row["point"]), int(row["wall"])] for row in impacts]
    names = ("stiffness", "exponent", "slowest", "unit", "stop")
    return SimpleNamespace(**{name: np.array([getattr(row, name) for row in rows]) for name in names})


@dataclass(frozen=True)
class Columns:
    """The links of a chain, as columns."""

    length: np.ndarray
    mass: np.ndarray
    ratio: np.ndarray
    inertia: np.ndarray

    @property
    def size(self) -> float:
        return float(self.length.max())

    @property
    def energy(self) -> float:
        """Σ m s²/s² [J], the scale of the norm."""
        return float(self.mass.sum()) * self.size**2


def chain_of(scene: Scene) -> Columns:
    """The links of a scene."""
    rows = [
        (link.length, link.mass, link.center_of_mass / link.length, link.inertia)
        for link in scene.chain.links
    ]
    return Columns(*np.transpose(rows))
