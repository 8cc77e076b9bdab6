"""What points and walls do to each other over time, and the phases of sticking and sliding that follow."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from chain_impact.kernel.forces.friction import NO_FRICTION, STICKS
from chain_impact.scene.names import SLIDER_STOPS, STOPS, point_label

CHANGE_DTYPE = np.dtype([("time", np.float64), ("point", np.int64), ("wall", np.int64), ("mode", np.int64)])
"""One change of mode, as the kernel logs it: from this time [s] on the mode is 0, sticks; ±1, slides along
±t; or 2, no friction. Point and wall as in ``STICK_SLIP_DTYPE``."""
STICK_SLIP_DTYPE = np.dtype(
    [
        ("point", np.int64),
        ("wall", np.int64),
        ("start", np.float64),
        ("end", np.float64),
        ("mode", np.int64),
    ]
)
"""One phase of dry friction: point 0…N; wall as index into ``scene.wall_names``; start and end [s], the end
NaN of a phase that lasts to the end of the simulation; mode 0 while it sticks, 1 or −1 while it slides along
t or −t, with t = (n_y, −n_x) of the wall's normal n. Of a joint the wall is −1, the point is the number of
the joint, 1…N, and with mode 1 its angle grows."""
NO_PHASES = np.zeros(0, STICK_SLIP_DTYPE)
"""The phases where nothing rubs."""
NO_PHASES.flags.writeable = False
MODES = {0: "stick", 1: "slip +", -1: "slip -"}
"""The modes in words."""
JOINT = -1
"""The wall of a joint."""


def phases_of(changes: np.ndarray) -> np.ndarray:
    """Return the phases in a log of changes, in order of their start, see ``STICK_SLIP_DTYPE``."""
    found: list[tuple[int, int, float, float, int]] = []
    order = np.argsort(changes["time"], kind="stable")
    for place in np.unique(changes[["point", "wall"]]):
        of_place = changes[order][changes[order][["point", "wall"]] == place]
        found.extend(_phases(of_place))
    return np.sort(np.array(found, STICK_SLIP_DTYPE), order=["start", "point", "wall"])


def _phases(changes: np.ndarray) -> Iterator[tuple[int, int, float, float, int]]:
    """Yield the phases in the changes of one contact or joint, those of no length left out."""
    lasting = np.append(np.diff(changes["time"]) > 0.0, True)
    changes = changes[lasting]  # of several changes at one time, the last one
    changes = changes[np.append(True, np.diff(changes["mode"]) != 0)]
    ends = np.append(changes["time"][1:], np.nan)
    for change, end in zip(changes, ends, strict=True):
        if change["mode"] != NO_FRICTION:
            yield int(change["point"]), int(change["wall"]), float(change["time"]), end, int(change["mode"])


def place_of(phase: np.void, walls: Sequence[str], names: Mapping[int, str]) -> str:
    """What sticks or slides: "point 2 at y_min", "point 5 (heel) at y_min", "joint 3", "the slider".

    Args:
        phase: of dry friction.
        walls: the names of all walls, by their numbers.
        names: those of the points that have one.
    """
    if phase["wall"] == JOINT:
        return f"joint {phase['point']}" if phase["point"] > 0 else "the slider"
    return f"{point_label(phase['point'], names)} at {walls[phase['wall']]}"


def phase_cells(phase: np.void, walls: Sequence[str], names: Mapping[int, str]) -> tuple[str, str, str, str]:
    """Return a phase in words: start, end, where (see ``place_of``), and mode."""
    end = "" if np.isnan(phase["end"]) else f"{phase['end']:.6f}"
    return f"{phase['start']:.6f}", end, place_of(phase, walls, names), MODES[int(phase["mode"])]


@dataclass(frozen=True, slots=True, eq=False)
class Touch:
    """What a point and a wall, or a joint and one of its stops, do to each other; or a joint's dry friction.

    Attributes:
        point: its number; of a joint its number, 1…N; of a slider 0.
        wall: its name, of a stop joint_min, joint_max, slider_min or slider_max; "" of dry friction in a
            joint or on a slider.
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
        """Whether it is at a wall, not in a joint or on a slider."""
        return self.wall not in ("", *STOPS, *SLIDER_STOPS)


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
