"""What the independent simulation with Coulomb friction gives, tests/coulomb.py."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Change:
    """An event.

    Attributes:
        time: [s].
        kind: "onset", "end", "again", "stick" or "slip".
        place: the point and the name of the wall, or of the stop; the joint and "joint".
        speed: at an onset the approach speed [m/s]; the sign of a slip.
    """

    time: float
    kind: str
    place: tuple[int, str]
    speed: float = 0.0


@dataclass
class Motion:
    """What a simulation gives, a row for each of the times asked for.

    Attributes:
        states: (q, q̇), shape (T, 2N+4).
        kinetic, potential, elastic: energies [J].
        damped, rubbed, supplied: since the start: taken by walls and dampers, by friction; given by inputs.
        normal_impulse, tangential_impulse: of each place that rubs or touches, its impulses since the start:
            (point, wall) → shape (T,) [N·s]; of a dry joint the tangential one, of its moment on link i.
        normal_force, friction_force: likewise [N].
        sticking: likewise, whether it acts and sticks.
        changes: the events, in their order.
    """

    times: np.ndarray
    states: np.ndarray
    kinetic: np.ndarray
    potential: np.ndarray
    elastic: np.ndarray
    damped: np.ndarray
    rubbed: np.ndarray
    supplied: np.ndarray
    normal_impulse: dict[tuple[int, str], np.ndarray] = field(default_factory=dict)
    tangential_impulse: dict[tuple[int, str], np.ndarray] = field(default_factory=dict)
    normal_force: dict[tuple[int, str], np.ndarray] = field(default_factory=dict)
    friction_force: dict[tuple[int, str], np.ndarray] = field(default_factory=dict)
    sticking: dict[tuple[int, str], np.ndarray] = field(default_factory=dict)
    changes: list[Change] = field(default_factory=list)

    @property
    def balance(self) -> np.ndarray:
        """What must be constant: all energies, and what was taken less what was given [J]."""
        stored = self.kinetic + self.potential + self.elastic
        return stored + self.damped + self.rubbed - self.supplied

    def when(self, kind: str, place: tuple[int, str] | None = None) -> list[float]:
        """The times of the events of a kind [s], of one place or of all."""
        return [one.time for one in self.changes if one.kind == kind and place in (None, one.place)]
