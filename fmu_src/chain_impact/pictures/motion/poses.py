"""Poses of the chain in the picture of a motion: a few strong ones, and faint ones in between."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from chain_impact.pictures.drawing.colours import INK
from chain_impact.pictures.motion.impact_rings import rows_by_speed
from chain_impact.pictures.motion.view import seen_size
from chain_impact.pictures.texts.headline import marked_peaks
from chain_impact.recording.recording import Recording

# the largest number of strong poses between start and end (``strong_rows``); more could not be told apart
MOST_STRONG_POSES = 5
# FAINT_POSES: the largest number of faint poses, from rows with equally spaced indices; POSE_OPACITY: their
# opacity
FAINT_POSES, POSE_OPACITY = 12, 0.15
FAINT_WIDTH = 1.6  # [points] the width of the lines of faint poses, wider than the paths of points
# The least distance between poses, relative to the size of the motion: FAINT_APART of faint poses,
# STRONG_APART of strong poses. Of the strong poses, the pose at the fastest impact is always drawn.
FAINT_APART, STRONG_APART = 0.03, 0.1
# RIM_WIDTH: [points] how much wider the chain at the start is drawn if the chain at the end covers it.
# COVERED_WITHIN: the chain at the end covers the chain at the start if the distance of each point's end from
# its start is smaller than this, relative to the size of the motion.
RIM_WIDTH, COVERED_WITHIN = 3.0, 0.02


def is_covered(recording: Recording) -> bool:
    """Return whether the chain at the end would cover the chain at the start (COVERED_WITHIN)."""
    ways = recording.points[-1] - recording.points[0]
    return bool(np.hypot(*ways.T).max() < COVERED_WITHIN * seen_size(recording))


def draw_chain(axes: Axes, points: np.ndarray, **look: Any) -> Line2D:
    """Draw the chain in one pose.

    Args:
        axes: the axes to draw into.
        points: positions of the points 0…N, shape (N+1, 2) [m].
        look: properties of the line, with matplotlib's names: color, linewidth, markersize, label, …

    Returns:
        The line; `set_data(*points.T)` moves the line to another pose.
    """
    style: dict[str, Any] = {"marker": "o", "markeredgecolor": "white", "markeredgewidth": 0.7, "zorder": 4}
    style |= {"solid_joinstyle": "round", "solid_capstyle": "round"}
    (line,) = axes.plot(*np.transpose(points), **(style | look))
    return line


def strong_rows(recording: Recording) -> list[int]:
    """Return the rows of the impacts at whose onsets strong poses are drawn, in the order of time.

    With more than MOST_STRONG_POSES impacts, this is only the impact with the largest force, moment or
    impulse (``marked_peaks``) or, if several impacts have the largest value, the fastest one. Otherwise the
    fastest impact is chosen in any case. A slower impact is chosen, the faster ones first, if the pose at its
    onset differs (``distinct_poses``, STRONG_APART) from those at start, at end, and at all impacts chosen
    before.
    """
    rows = rows_by_speed(recording).tolist()
    if len(rows) > MOST_STRONG_POSES:
        return [*(peak.row for peak in marked_peaks(recording)), rows[0]][:1]
    if not rows:
        return []
    first, *other_poses = (recording.pose_at(recording.impacts["onset"][row]) for row in rows)
    poses = np.array([first, recording.points[0], recording.points[-1], *other_poses])
    kept_rows = distinct_poses(poses, STRONG_APART * seen_size(recording), always_kept=3)
    return sorted([rows[0], *(rows[k - 2] for k in kept_rows[3:])])


def distinct_poses(poses: np.ndarray, least_distance: float, always_kept: int = 1) -> list[int]:
    """Return the indices of the poses to keep, each of which differs from all earlier poses that are kept.

    ``poses`` has the positions of the points in each pose, shape (P, N+1, 2) [m]. Two poses differ if the
    mean distance of their points is at least ``least_distance`` [m]. The first ``always_kept`` poses are kept
    in any case.
    """
    kept_rows: list[int] = []
    for k, pose in enumerate(poses):
        ways = np.hypot(*np.moveaxis(poses[kept_rows] - pose, -1, 0)).mean(axis=-1)
        if k < always_kept or ways.min() >= least_distance:
            kept_rows.append(k)
    return kept_rows


def draw_faint(axes: Axes, recording: Recording) -> None:
    """Draw the chain faintly in rows with equally spaced indices, without poses that look alike."""
    rows = np.unique(np.linspace(0, len(recording.time) - 1, FAINT_POSES).round().astype(int))
    poses = recording.points[rows]
    poses = poses[distinct_poses(poses, FAINT_APART * seen_size(recording))]
    look: dict[str, Any] = {"colors": INK, "linewidths": FAINT_WIDTH, "alpha": POSE_OPACITY}
    label = "chain between" if len(poses) > 1 else "_"
    axes.add_collection(LineCollection(list(poses), **look, label=label))
