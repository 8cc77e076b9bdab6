"""Contacts and dry friction over time, and the phases of sticking and sliding."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from chain_impact.kernel.record.constants import NO_FRICTION, STICKS
from chain_impact.scene.words.names import STOPS, point_label

CHANGE_DTYPE = np.dtype([("time", np.float64), ("point", np.int64), ("wall", np.int64), ("mode", np.int64)])
"""A change of the mode of dry friction, as the kernel logs it. The columns are: the time [s] from which on
the new mode holds; point and wall as in ``STICK_SLIP_DTYPE``; and the new mode. The mode is 0 for sticking, 1
or −1 for sliding along t or −t, and 2 if no friction acts."""
STICK_SLIP_DTYPE = np.dtype(
    [
        ("point", np.int64),
        ("wall", np.int64),
        ("start", np.float64),
        ("end", np.float64),
        ("mode", np.int64),
    ]
)
"""One phase of dry friction, in which the mode stays the same. The columns are: the number of the point; the
index of the wall in ``scene.wall_names``; start and end [s]; and the mode. If the phase lasts to the end of
the simulation, its end is NaN. The mode is 0 for sticking, 1 for sliding along t, and −1 for sliding along
−t, with the tangent t = (n_y, −n_x) for the wall's normal n.

For a joint, the wall is −1, and the point is the number of the joint, 1…N. For a slider, the wall is −1, and
the point is 0. In mode 1 the angle of the joint, or the position of the slider, grows."""
NO_PHASES = np.zeros(0, STICK_SLIP_DTYPE)
"""A table of phases without rows, as for a run without dry friction."""
NO_PHASES.flags.writeable = False
MODES = {0: "stick", 1: "slip +", -1: "slip -"}
"""Mode → words for the mode."""
NO_WALL = -1
"""The number of the wall in a phase of dry friction in a joint or on a slider."""


def phases_of(changes: np.ndarray) -> np.ndarray:
    """Return the table of phases that follow from a log of changes of mode, in the order of their starts."""
    phases: list[tuple[int, int, float, float, int]] = []
    order = np.argsort(changes["time"], kind="stable")
    for contact in np.unique(changes[["point", "wall"]]):
        of_element = changes[order][changes[order][["point", "wall"]] == contact]
        phases.extend(_phases(of_element))
    return np.sort(np.array(phases, STICK_SLIP_DTYPE), order=["start", "point", "wall"])


def _phases(changes: np.ndarray) -> Iterator[tuple[int, int, float, float, int]]:
    """Yield the phases that follow from the changes of one contact, joint or slider.

    No phase has the duration 0. Times in which no friction acts are not phases.
    """
    lasting = np.append(np.diff(changes["time"]) > 0.0, True)
    changes = changes[lasting]  # of several changes at the same time, only the last one counts
    changes = changes[np.append(True, np.diff(changes["mode"]) != 0)]
    ends = np.append(changes["time"][1:], np.nan)
    for change, end in zip(changes, ends, strict=True):
        if change["mode"] != NO_FRICTION:
            yield int(change["point"]), int(change["wall"]), float(change["time"]), end, int(change["mode"])


def element_label(phase: np.void, walls: Sequence[str], names: Mapping[int, str]) -> str:
    """Return the words for the place of a phase: "point 5 (heel) at y_min", "joint 3" or "the slider".

    Args:
        phase: the phase of dry friction.
        walls: the names of all walls, by their numbers.
        names: the names of points, by their numbers.
    """
    if phase["wall"] == NO_WALL:
        return f"joint {phase['point']}" if phase["point"] > 0 else "the slider"
    return f"{point_label(phase['point'], names)} at {walls[phase['wall']]}"


def phase_cells(phase: np.void, walls: Sequence[str], names: Mapping[int, str]) -> tuple[str, str, str, str]:
    """Return a phase of dry friction as texts: start and end [s], its place (``element_label``), its mode.

    The mode is one of the words in MODES. The end is "" if the phase lasts to the end of the run.
    """
    end = "" if np.isnan(phase["end"]) else f"{phase['end']:.6f}"
    return f"{phase['start']:.6f}", end, element_label(phase, walls, names), MODES[int(phase["mode"])]


WALL, SLIDER_STOP, JOINT_STOP, FRICTION = "wall", "stop of a slider", "stop of a joint", "friction"
"""The kinds of ``Interaction``; FRICTION is dry friction in a joint or on a slider."""


@dataclass(frozen=True, slots=True, eq=False)
class Interaction:
    """A contact with a wall or with a stop of a joint or slider; or dry friction in a joint or on a slider.

    Attributes:
        point: the number of the point; for a joint the number of the joint, 1…N; for a slider 0.
        wall: the name of the wall; for a stop joint_min, joint_max, slider_min or slider_max; "" for dry
            friction in a joint or on a slider.
        force: the normal force of the wall, shape (T,) [N]; for a stop of a joint the absolute value of
            its moment [N·m]; None for dry friction in a joint or on a slider.
        penetration: the penetration, shape (T,) [m]; None if unknown, as always at a stop of a joint.
        rate: the rate of penetration, shape (T,) [m/s]; None if unknown, as always at a stop of a joint.
        friction: the force of dry friction on the point, shape (T,) [N]; it is positive along t = (n_y,
            −n_x), for the wall's normal n. For a joint it is the moment of dry friction [N·m], for a slider
            the force of dry friction on the carriage [N]; both are positive where they push the angle or the
            position to larger values. None without dry friction.
        sticking: shape (T,); above 0 in the rows in which the contact, joint or slider sticks, else 0. None
            without dry friction.
        kind: WALL, SLIDER_STOP, JOINT_STOP or FRICTION; ``wall`` does not tell it, because a wall may have
            the name of a stop if the chain has no such stop.
    """

    point: int
    wall: str
    force: np.ndarray | None
    penetration: np.ndarray | None = None
    rate: np.ndarray | None = None
    friction: np.ndarray | None = None
    sticking: np.ndarray | None = None
    kind: str = WALL

    @classmethod
    def contacts_of_stops(cls, joint: int, moment: np.ndarray) -> Iterator[Interaction]:
        """Yield the contact of a joint's link with joint_min and the contact with joint_max.

        ``moment`` is the output that both share: the moment of the stops on the link, shape (T,) [N·m]. It is
        positive while the link touches joint_min, and negative while the link touches joint_max.
        """
        for stop, sign in zip(STOPS, (1.0, -1.0), strict=True):
            yield cls(joint, stop, np.maximum(sign * moment, 0.0), kind=JOINT_STOP)


def phases_from(time: np.ndarray, interactions: Iterable[Interaction], walls: Sequence[str]) -> np.ndarray:
    """Return the table of phases of dry friction from values in rows, see ``STICK_SLIP_DTYPE``.

    The start and the end of a phase are times of rows, so each is late by at most the time between two rows.
    """
    changes: list[tuple[float, int, int, int]] = []
    for interaction in interactions:
        if (
            interaction.sticking is None
            or interaction.friction is None
            or interaction.wall not in ("", *walls)
        ):
            continue
        wall = walls.index(interaction.wall) if interaction.wall else NO_WALL
        sliding = np.where(interaction.friction == 0.0, NO_FRICTION, -np.sign(interaction.friction))
        mode = np.where(interaction.sticking > 0.0, STICKS, sliding).astype(int)
        starts = np.flatnonzero(np.append([True], np.diff(mode) != 0)[: len(mode)])
        changes.extend((float(time[row]), interaction.point, wall, int(mode[row])) for row in starts)
    return phases_of(np.array(changes, CHANGE_DTYPE))
