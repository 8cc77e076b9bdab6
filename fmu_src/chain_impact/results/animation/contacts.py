"""The contacts of a recording: when they were, how large their force was, and which are worth showing."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from chain_impact.results.animation.pacing import Span
from chain_impact.results.recording import Impact, Recording
from chain_impact.scene.names import STOPS

MOMENT = re.compile(r"joint\[(\d+)\]\.stop_moment")
FORCE = re.compile(r"contact\[(\d+)\]\.(\w+)\.force")
RESOLVED = 8  # rows in a contact from which the largest force among them is about the peak
AFTER_PEAK = 3.0  # of the time from onset to peak: an impact is over, whatever its law makes of its shape
SLOW_SPEED = 0.05  # of the fastest impact: slower ones are not shown slowly
SLOW_COUNT = 100  # impacts, the fastest ones, that are shown slowly


@dataclass(frozen=True, slots=True)
class Contact:
    """A contact of a point with a wall, or of a joint with a stop, as the rows of a recording show it.

    Attributes:
        point: 0…N.
        wall: its name.
        onset: [s].
        end: [s]; of one that lasts, the end of the recording; the onset, if it is unknown.
        impact_end: as ``end``, but when the chain stays at the wall, about the end of the impact before [s].
        speed: normal approach speed [m/s]; None for a contact whose impact is not listed.
        peak_force: the largest force [N], as the impact tells it, else in the rows; None where there is none:
            between rigid walls, or when the rows are too far apart.
        resolved: whether ``peak_force`` is the peak, not the largest of a few rows.
        arm: at a stop of a joint, see ``Impact``; None at a wall.
    """

    point: int
    wall: str
    onset: float
    end: float
    impact_end: float
    speed: float | None
    peak_force: float | None
    resolved: bool
    arm: float | None = None

    @property
    def end_speed(self) -> float | None:
        """See ``Impact``."""
        return None if self.speed is None else self.speed * (1.0 if self.arm is None else self.arm)


def stop_moments(recording: Recording) -> Iterator[tuple[int, str, np.ndarray]]:
    """Joint, stop and the size of its moment over time [N·m] of each stop."""
    for name, moment in recording.columns.items():
        if found := MOMENT.fullmatch(name):
            for stop, sign in zip(STOPS, (1.0, -1.0), strict=True):
                yield int(found[1]), stop, np.maximum(sign * moment, 0.0)


def wall_forces(recording: Recording) -> Iterator[tuple[int, str, np.ndarray]]:
    """Point, wall and force over time [N] of each point and wall that can touch."""
    for name, force in recording.columns.items():
        if found := FORCE.fullmatch(name):
            yield int(found[1]), found[2], force


def contacts(recording: Recording) -> list[Contact]:
    """All contacts in order of their onset: the listed impacts, and what else the forces show."""
    time, found = recording.time, []
    left = list(recording.impacts)
    pairs: list[tuple[int, str, np.ndarray, float | None]]
    pairs = [(*pair, None) for pair in wall_forces(recording)]
    pairs += [
        (joint, stop, moment, recording.stops[joint].length)
        for joint, stop, moment in stop_moments(recording)
        if joint in recording.stops
    ]
    for point, wall, force, arm in pairs:
        listed = [impact for impact in recording.impacts if (impact.point, impact.wall) == (point, wall)]
        for first, last in _runs(force > 0.0):
            before = time[max(first - 1, 0)]
            impact = next((i for i in listed if before <= i.time <= time[first]), None)
            if impact in left:
                left.remove(impact)
            onset = impact.time if impact else float(before)
            end = float(time[min(last + 1, len(time) - 1)])
            if impact and impact.end > onset:
                end = impact.end
            known = impact is not None and impact.peak_force > 0.0
            peak_time = float(time[first + np.argmax(force[first : last + 1])])
            found.append(
                Contact(
                    point,
                    wall,
                    onset=onset,
                    end=end,
                    impact_end=min(end, onset + AFTER_PEAK * (peak_time - onset)),
                    speed=impact.speed if impact else None,
                    peak_force=impact.peak_force
                    if impact and known
                    else float(force[first : last + 1].max()),
                    resolved=known or last - first + 1 >= RESOLVED,
                    arm=arm,
                )
            )
    for impact in left:  # between two rows, or of rigid walls
        end = max(impact.time, impact.end) if math.isfinite(impact.end) else impact.time
        peak = impact.peak_force if impact.peak_force > 0.0 else None
        found.append(
            Contact(
                impact.point,
                impact.wall,
                impact.time,
                end,
                end,
                impact.speed,
                peak,
                peak is not None,
                impact.arm,
            )
        )
    return sorted(found, key=lambda contact: contact.onset)


def _runs(mask: np.ndarray) -> Iterator[tuple[int, int]]:
    """First and last index of each run of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]])))
    for first, after in edges.reshape(-1, 2):
        yield int(first), int(after) - 1


def slow_spans(found: Sequence[tuple[Span, float]]) -> list[Span]:
    """Onset and end [s] of the contacts to be shown slowly, of those given with their impact speeds [m/s]."""
    fastest = sorted(found, key=lambda entry: -entry[1])[:SLOW_COUNT]
    return sorted(span for span, speed in fastest if speed >= SLOW_SPEED * fastest[0][1])


def impacts_from_forces(recording: Recording) -> list[Impact]:
    """The impacts at walls that the forces in a recording show, for one whose impacts are not listed.

    The onset is where the force began between two rows, by the penetration and its rate in the first row that
    has one. An impact that began and ended between two rows is missing.
    """
    impacts = []
    for point, wall, force in wall_forces(recording):
        depth, rate = (
            recording.columns.get(f"contact[{point}].{wall}.{name}", np.zeros_like(force))
            for name in ("penetration", "penetration_rate")
        )
        for first, _ in _runs(force > 0.0):
            if first == 0:
                continue  # it touched from the start
            onset = recording.time[first]
            if rate[first] > 0.0:
                onset = max(onset - depth[first] / rate[first], recording.time[first - 1])
            impacts.append(Impact(float(onset), point, wall, float(abs(rate[first]))))
    return sorted(impacts, key=lambda impact: impact.time)
