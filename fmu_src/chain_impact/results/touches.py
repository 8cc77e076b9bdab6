"""What a point and a wall do to each other over time, and the phases of dry friction that follow."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from chain_impact.kernel.forces.friction import NO_FRICTION, STICKS
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
