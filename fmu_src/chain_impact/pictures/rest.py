"""The rests of a motion, and the time that a picture shows."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes

from chain_impact.kernel.forces.friction import STICKS
from chain_impact.pictures.style import SHADE, faint
from chain_impact.recording.recording import Recording

# the speed of a point at rest: in the whole time, it moves the point by this part of the longest path
SLOW = 0.02
LEAST = 0.05  # the shortest rest that is shown, relative to the duration of the run
MUCH = 0.7  # rests at the start and the end are left out if they take at least this part of the time
BEFORE, AFTER = 0.1, 0.25  # the shown rest before and after the motion, relative to the time with motion


class Shown(NamedTuple):
    """The time that a picture shows.

    Attributes:
        start: the start of the axis [s].
        end: the end of the axis [s].
        rests: start and end [s] of each rest.
        told: words on the rest for the label of the axis; "" without a rest.
    """

    start: float
    end: float
    rests: list[tuple[float, float]]
    told: str


def shown_time(recording: Recording) -> Shown:
    """Return the time that a picture shows, without most of a long rest at the start or the end."""
    found = rests(recording)
    first, last = (float(recording.time[row]) for row in (0, -1))
    start, end = first, last
    before = found[0][1] - first if found and found[0][0] == first else 0.0
    after = last - found[-1][0] if found and found[-1][1] == last else 0.0
    moving = last - first - before - after
    if moving > 0.0 and before + after >= MUCH * (last - first):
        start, end = max(first, first + before - BEFORE * moving), min(last, last - after + AFTER * moving)
    words = f"shaded: {rest_word(recording)}" if found else ""
    if start > first:
        words += f", from {first:g} s"
    if end < last:
        words += f", until {last:g} s"
    return Shown(start, end, found, words)


def rest_word(recording: Recording) -> str:
    """Return the word for the rest at the end: "held" if dry friction holds the chain, or "at rest"."""
    last = recording.stick_slip[np.isnan(recording.stick_slip["end"])]
    return "held" if (last["mode"] == STICKS).any() else "at rest"


def ends_at_rest(recording: Recording) -> bool:
    """Return whether the motion rests at the end."""
    found = rests(recording)
    return bool(found) and found[-1][1] == recording.time[-1]


def rests(recording: Recording) -> list[tuple[float, float]]:
    """Return start and end [s] of each time in which no point moves noticeably, and no impact happens."""
    time, places = recording.time, recording.all_points
    span, size = time[-1] - time[0], np.hypot(*np.ptp(places, axis=0).T).max()
    if len(time) < 3 or not size > 0.0:  # noqa: PLR2004 - no motion between rows
        return []
    ways = np.hypot(*np.moveaxis(np.diff(places, axis=0), -1, 0)).max(axis=1)
    for moved in recording.moved_walls.values():
        ways = np.maximum(ways, np.abs(np.diff(moved)))
    still = ways * span <= SLOW * size * np.diff(time)
    hit = np.searchsorted(time, recording.impacts["onset"], side="right") - 1
    still[hit.clip(0, len(still) - 1)] = False
    edges = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(int), [0]])))
    found = [(float(time[low]), float(time[high])) for low, high in edges.reshape(-1, 2)]
    return [(low, high) for low, high in found if high - low >= LEAST * span]


def shade_rests(axes: Axes, shown: Shown) -> None:
    """Shade the rests on an axis of time."""
    for low, high in shown.rests:
        axes.axvspan(low, high, color=faint(axes, SHADE), linewidth=0.0, zorder=-1)
