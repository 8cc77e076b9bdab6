"""The rests in a motion: the times in which no point and no wall moves noticeably."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from chain_impact.kernel.record.constants import STICKS
from chain_impact.recording.recording import Recording

# [1] A point is at rest if two distances in the duration T of the run are at most this, relative to the size
# of the largest path of any point: v T at its speed v, and a T²/2 at its mean acceleration a. The size of a
# path is the diagonal of the rectangle around it.
REST_WAY = 0.02
# [1] the size of the largest path counts as at least this times the size of the chain, because smaller paths
# are no motion
SMALLEST_PATH = 1e-6
FEWEST_REST_ROWS = 3  # with fewer rows the accelerations are unknown, so no rest is found
SHORTEST_REST = 0.05  # [1] shortest rest that counts, relative to the duration of the run


def rest_word(recording: Recording) -> str:
    """Return the word for a time without motion: "held" if something sticks at the end, else "at rest"."""
    return "held" if len(_held_since(recording)) else "at rest"


def _held_since(recording: Recording) -> np.ndarray:
    """Return the start [s] of each phase of sticking that lasts to the end of the run."""
    phases = recording.stick_slip
    starts: np.ndarray = phases["start"][np.isnan(phases["end"]) & (phases["mode"] == STICKS)]
    return starts


def ends_at_rest(recording: Recording) -> bool:
    """Return whether the motion ends with a rest."""
    found_rests = rest_spans(recording)
    return bool(found_rests) and found_rests[-1][1] == recording.time[-1]


def rest_spans(recording: Recording) -> list[tuple[float, float]]:
    """Return start and end [s] of each rest: no point or wall moves noticeably, and no impact begins.

    Both speeds and mean accelerations must be small. So a chain that only turns back, as a pendulum at its
    highest position, is not at rest. A rest shorter than SHORTEST_REST × the run is left out. There is none
    if the positions of points are unknown, or with less than FEWEST_REST_ROWS rows.
    """
    if not recording.knows_points:
        return []
    time, positions = recording.time, recording.all_points
    span = time[-1] - time[0]
    if len(time) < FEWEST_REST_ROWS or not span > 0.0:
        return []
    size = max(_extent(positions, 0), SMALLEST_PATH * _extent(positions[0], 0))
    walls = [
        np.stack([wall_motion, 0.0 * wall_motion], axis=-1)[:, None]
        for wall_motion in recording.moved_walls.values()
    ]
    positions = np.concatenate([positions, *walls], axis=1)
    is_still = _largest_lengths(np.diff(positions, axis=0)) * span <= REST_WAY * size * np.diff(time)
    hit = np.searchsorted(time, recording.impacts["onset"], side="right") - 1
    is_still[hit.clip(0, len(is_still) - 1)] = False
    reach = max(1, int(len(time) * SHORTEST_REST / 2))
    for low, high in _runs(is_still):
        steady = _accelerations(time[low : high + 1], positions[low : high + 1], reach) * span**2
        is_still[low:high] = steady <= 2.0 * REST_WAY * size
    found_rests = [(float(time[low]), float(time[high])) for low, high in _runs(is_still)]
    return [(low, high) for low, high in found_rests if high - low >= SHORTEST_REST * span]


def _extent(positions: np.ndarray, axis: int) -> float:
    """Return the longest diagonal [m] of the rectangles around positions.

    Each rectangle contains the positions along ``axis`` of the array, whose last axis is x and y. In an array
    (T, P, 2), the axis 0 is the time, so that there is a rectangle around the path of each point.
    """
    return float(np.hypot(*np.ptp(positions, axis=axis).T).max())


def _largest_lengths(vectors: np.ndarray) -> np.ndarray:
    """Return the largest length of the vectors in each row, shape (T,).

    The vectors have the shape (T, P, 2).
    """
    lengths: np.ndarray = np.hypot(vectors[..., 0], vectors[..., 1]).max(axis=1)
    return lengths


def _runs(is_chosen: np.ndarray) -> list[tuple[int, int]]:
    """Return start and end of each series of True, as indices; the end is the index after the last True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], is_chosen.astype(int), [0]])))
    return [(int(low), int(high)) for low, high in edges.reshape(-1, 2)]


def _accelerations(time: np.ndarray, positions: np.ndarray, reach: int) -> np.ndarray:
    """Return, for each interval between rows, the largest mean acceleration of any point [m/s²].

    The mean is over ``reach`` rows before and after the interval, so that small and fast oscillations of a
    stiff contact do not count. If there are fewer rows, the mean is over fewer rows. If there is only one
    interval, the result is infinite, because the acceleration is unknown.
    """
    reach = min(reach, (len(time) - 1) // 2)
    if reach == 0:
        return np.full(len(time) - 1, np.inf)
    speeds = (positions[reach:] - positions[:-reach]) / (time[reach:] - time[:-reach])[:, None, None]
    changes = _largest_lengths(speeds[reach:] - speeds[:-reach]) / (time[2 * reach :] - time[: -2 * reach])
    nearby_changes: np.ndarray = 2.0 * changes[(np.arange(len(time) - 1) - reach).clip(0, len(changes) - 1)]
    return nearby_changes


def rest_lines(recording: Recording) -> Iterator[str]:
    """Yield a line on the rest, a time without motion, at the end of the run, or nothing without a rest.

    The line tells the start of the rest, the position of the tip and, unless the base is pinned, that of the
    base.
    """
    if len(recording.time) and recording.knows_points and ends_at_rest(recording):
        # dry friction may begin to hold the chain some milliseconds after the noticeable motion has ended:
        # the rest starts at the latest of these times
        start = max([rest_spans(recording)[-1][0], *_held_since(recording)])
        last = recording.points[-1]
        ends = {"tip": last[-1]} if recording.pinned else {"base": last[0], "tip": last[-1]}
        texts = [f"{name} at ({_metres(x)}, {_metres(y)}) m" for name, (x, y) in ends.items()]
        yield f"rest     {rest_word(recording)} from {start:.4g} s on: {', '.join(texts)}"


def _metres(length: float) -> str:
    """Return the number of a length [m] as text, rounded to a micrometre, without zeros at the end."""
    return np.format_float_positional(round(length, 6) + 0.0, trim="-")
