"""The trace of the tip in a film: a smooth curve through the rows, with corners at impacts."""

from __future__ import annotations

import numpy as np

from chain_impact.recording.recording import Recording

PIECE = 0.004  # approximate length of the straight pieces of the curve, relative to the view's smaller side
MOST_TRACE_PARTS = 32  # the largest number of straight pieces between two rows


def trace_of(recording: Recording, size: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the path of the tip as times and positions of points on a smooth curve.

    The points include the position in each row. If two successive rows have positions farther apart than
    PIECE × ``size``, there are points of the curve between them, except across an impact
    (``_is_straightened``).

    Args:
        recording: the recording to show.
        size: the smaller side of the view [m].

    Returns:
        The times, shape (S,) [s], and the positions, shape (S, 2) [m].
    """
    time, tip = recording.time, recording.points[:, -1]
    speeds, steps = _speeds(recording), np.diff(time)
    piece_counts = np.hypot(*np.diff(tip, axis=0).T) / (PIECE * size)
    parts = np.where(_is_straightened(recording), 1, np.ceil(piece_counts).clip(1, MOST_TRACE_PARTS)).astype(
        int
    )
    row = np.repeat(np.arange(len(steps)), parts)
    s = ((np.arange(len(row)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[row])[:, None]
    h = steps[row, None]
    # p is the position by Hermite interpolation between a row, with the index 0, and the next row, with the
    # index 1, a time h later; s is the fraction of h, v₀ and v₁ are the velocities:
    # p = (1 − s)² ((1 + 2 s) p₀ + s h v₀) + s² ((3 − 2 s) p₁ − (1 − s) h v₁)
    start, end = tip[row], tip[row + 1]
    start_part = (1.0 - s) ** 2 * ((1.0 + 2.0 * s) * start + s * h * speeds[row])
    end_part = s**2 * ((3.0 - 2.0 * s) * end - (1.0 - s) * h * speeds[row + 1])
    times = time[row] + s[:, 0] * h[:, 0]
    return np.append(times, time[-1]), np.concatenate([start_part + end_part, tip[-1:]])


def _speeds(recording: Recording) -> np.ndarray:
    """Return the velocity of the tip in each row, shape (T, 2) [m/s].

    If the recording lacks a component of the velocity, both components follow from the positions: as the
    slope of the parabola through a row and its two neighbours or, in the first and the last row, as the slope
    of the line to the only neighbour.
    """
    if _has_velocity(recording):
        last = recording.points.shape[1] - 1
        return np.stack([recording.columns[f"point[{last}].v{axis}"] for axis in "xy"], axis=-1)
    slopes = [np.gradient(coordinate, recording.time) for coordinate in recording.points[:, -1].T]
    return np.stack(slopes, axis=-1)


def _has_velocity(recording: Recording) -> bool:
    """Return whether a recording has both components of the tip's velocity."""
    last = recording.points.shape[1] - 1
    return all(f"point[{last}].v{axis}" in recording.columns for axis in "xy")


def _is_straightened(recording: Recording) -> np.ndarray:
    """Return, for each pair of successive rows, whether an impact makes the path straight, shape (T − 1,).

    The path is straight between the two rows around an onset, because the velocity changes fast there. If the
    recording lacks a component of the tip's velocity, the velocities from positions are wrong in these two
    rows. The path is then also straight in the interval of rows before this one, and in the one after it.
    """
    impact_rows = np.searchsorted(recording.time, recording.impacts["onset"], side="right") - 1
    broken = np.zeros(len(recording.time) - 1, bool)
    for row_shift in (0,) if _has_velocity(recording) else (-1, 0, 1):
        rows = impact_rows + row_shift
        broken[rows[(rows >= 0) & (rows < len(broken))]] = True
    return broken
