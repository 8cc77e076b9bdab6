"""The phases of sticking and sliding by dry friction."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from chain_impact.kernel.record.constants import NO_FRICTION, STICKS
from chain_impact.recording.interactions import Interaction
from chain_impact.scene.texts.names import point_label

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
    is_lasting = np.append(np.diff(changes["time"]) > 0.0, True)
    changes = changes[is_lasting]  # of several changes at the same time, only the last one counts
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
    end_text = "" if np.isnan(phase["end"]) else f"{phase['end']:.6f}"
    return f"{phase['start']:.6f}", end_text, element_label(phase, walls, names), MODES[int(phase["mode"])]


def phases_from(time: np.ndarray, interactions: Iterable[Interaction], walls: Sequence[str]) -> np.ndarray:
    """Return the table of phases of dry friction from values in rows, see ``STICK_SLIP_DTYPE``.

    The start and the end of a phase are times of rows, so each is late by at most the time between two rows.
    Contacts at walls that ``walls`` lacks have no phases.
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
        sliding_modes = np.where(interaction.friction == 0.0, NO_FRICTION, -np.sign(interaction.friction))
        mode = np.where(interaction.sticking > 0.0, STICKS, sliding_modes).astype(int)
        starts = np.flatnonzero(np.append([True], np.diff(mode) != 0)[: len(mode)])
        changes.extend((float(time[row]), interaction.point, wall, int(mode[row])) for row in starts)
    return phases_of(np.array(changes, CHANGE_DTYPE))
