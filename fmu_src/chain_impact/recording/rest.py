"""The rests of a motion: the times in which no point and no wall moves noticeably."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from chain_impact.kernel.forces.friction import STICKS
from chain_impact.recording.recording import Recording

# the largest speed of a point that counts as at rest, relative to a reference speed: the extent of the
# largest path of a point, divided by the duration of the run
REST_SPEED = 0.02
FEWEST_ROWS = 3  # in a motion with fewer rows, no time between rows can show a rest
SHORTEST_REST = 0.05  # the shortest rest that counts, relative to the duration of the run


def rest_word(recording: Recording) -> str:
    """Return the word for the rest at the end: "held" if dry friction holds the chain, or "at rest"."""
    last = recording.stick_slip[np.isnan(recording.stick_slip["end"])]
    return "held" if (last["mode"] == STICKS).any() else "at rest"


def ends_at_rest(recording: Recording) -> bool:
    """Return whether the motion rests at the end."""
    found = rests(recording)
    return bool(found) and found[-1][1] == recording.time[-1]


def rests(recording: Recording) -> list[tuple[float, float]]:
    """Return start and end [s] of each time in which no point or wall moves noticeably and no impact begins.

    A rest shorter than SHORTEST_REST is left out.
    """
    time, places = recording.time, recording.all_points
    span, size = time[-1] - time[0], np.hypot(*np.ptp(places, axis=0).T).max()
    if len(time) < FEWEST_ROWS or not size > 0.0:
        return []
    ways = np.hypot(*np.moveaxis(np.diff(places, axis=0), -1, 0)).max(axis=1)
    for moved in recording.moved_walls.values():
        ways = np.maximum(ways, np.abs(np.diff(moved)))
    still = ways * span <= REST_SPEED * size * np.diff(time)
    hit = np.searchsorted(time, recording.impacts["onset"], side="right") - 1
    still[hit.clip(0, len(still) - 1)] = False
    edges = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(int), [0]])))
    found = [(float(time[low]), float(time[high])) for low, high in edges.reshape(-1, 2)]
    return [(low, high) for low, high in found if high - low >= SHORTEST_REST * span]


def rest_lines(recording: Recording) -> Iterator[str]:
    """Yield a line on the rest at the end: its start, and where the free ends are; nothing without a rest."""
    if len(recording.time) and recording.knows_points and ends_at_rest(recording):
        start, last = rests(recording)[-1][0], recording.points[-1]
        ends = {"tip": last[-1]} if recording.pinned else {"base": last[0], "tip": last[-1]}
        places = [f"{name} at ({_metres(x)}, {_metres(y)}) m" for name, (x, y) in ends.items()]
        yield f"rest     {rest_word(recording)} from {start:.4g} s on: {', '.join(places)}"


def _metres(length: float) -> str:
    """Return a length as text, accurate to a micrometre, without zeros at the end."""
    return np.format_float_positional(round(length, 6) + 0.0, trim="-")
