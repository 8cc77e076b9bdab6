"""What a point and a wall do to each other over time, and the tables that follow where outputs have none."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from chain_impact.kernel.model.friction import NO_FRICTION, STICKS
from chain_impact.results.impacts import IMPACT_DTYPE
from chain_impact.results.stick_slip import CHANGE_DTYPE, JOINT, phases_of
from chain_impact.scene.names import STOPS


@dataclass(frozen=True, slots=True, eq=False)
class Touch:
    """What a point and a wall, or a joint and one of its stops, do to each other; or a joint's dry friction.

    Attributes:
        point: 0…N; of a joint its number, 1…N.
        wall: its name, of a stop joint_min or joint_max; "" of dry friction in a joint.
        force: of the wall on the point, shape (T,) [N], of a stop the size of its moment [N·m]; None
            in a joint.
        penetration: shape (T,) [m]; None where it is not known.
        rate: its rate, shape (T,) [m/s]; None where it is not known.
        friction: dry friction along t = (n_y, −n_x), shape (T,) [N], in a joint its moment [N·m]; None
            without.
        sticking: above 0 where it sticks, shape (T,); None without dry friction.
    """

    point: int
    wall: str
    force: np.ndarray | None
    penetration: np.ndarray | None = None
    rate: np.ndarray | None = None
    friction: np.ndarray | None = None
    sticking: np.ndarray | None = None

    @classmethod
    def of_stops(cls, joint: int, moment: np.ndarray) -> Iterator[Touch]:
        """Both stops of a joint, by their moment on its link, positive at joint_min, shape (T,) [N·m]."""
        for stop, sign in zip(STOPS, (1.0, -1.0), strict=True):
            yield cls(joint, stop, np.maximum(sign * moment, 0.0))

    @property
    def at_wall(self) -> bool:
        """Whether it is at a wall, not in a joint."""
        return self.wall not in ("", *STOPS)


def phases_from(time: np.ndarray, touches: Iterable[Touch], walls: Sequence[str]) -> np.ndarray:
    """The phases of dry friction that rows show, to within a communication step, see ``STICK_SLIP_DTYPE``."""
    changes: list[tuple[float, int, int, int]] = []
    for one in touches:
        if one.sticking is None or one.friction is None or one.wall not in ("", *walls):
            continue
        wall = walls.index(one.wall) if one.wall else JOINT
        sliding = np.where(one.friction == 0.0, NO_FRICTION, -np.sign(one.friction))
        mode = np.where(one.sticking > 0.0, STICKS, sliding).astype(int)
        starts = np.flatnonzero(np.append([True], np.diff(mode) != 0)[: len(mode)])
        changes.extend((float(time[row]), one.point, wall, int(mode[row])) for row in starts)
    return phases_of(np.array(changes, CHANGE_DTYPE))


def impacts_from(time: np.ndarray, touches: Iterable[Touch], walls: Sequence[str]) -> np.ndarray:
    """The impacts at walls that forces in rows show, where they are not listed, see ``IMPACT_DTYPE``.

    The onset is where the force began between two rows, by the penetration and its rate in the first row that
    has one; without these it is that row. An impact that began and ended between two rows is missing.
    """
    found = []
    for one in touches:
        if one.force is None or not one.at_wall:
            continue
        unknown = np.zeros_like(one.force)
        depths = unknown if one.penetration is None else one.penetration
        rates = unknown if one.rate is None else one.rate
        edges = np.flatnonzero(np.diff(np.concatenate([[False], one.force > 0.0, [False]])))
        for first, after in edges.reshape(-1, 2):
            if first == 0:
                continue  # it touched from the start
            row = np.zeros(1, IMPACT_DTYPE)
            for name in ("separation_speed", "effective_mass", "impulse"):
                row[name] = np.nan
            depth, speed, onset = depths[first], abs(rates[first]), time[first]
            row["onset"] = max(onset - depth / speed, time[first - 1]) if speed > 0.0 else onset
            row["end"] = time[after] if after < len(time) else np.nan
            row["point"], row["wall"], row["impact_speed"] = one.point, walls.index(one.wall), speed
            row["peak_force"] = one.force[first:after].max()
            row["max_penetration"] = depths[first:after].max()
            found.append(row)
    together = np.concatenate([np.zeros(0, IMPACT_DTYPE), *found])
    return np.sort(together, order=["onset", "point", "wall"])
