"""An estimate of a run's errors of positions and onsets, from a second run at a tighter tolerance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from chain_impact.recording.impacts import common_count
from chain_impact.recording.recording import Recording
from chain_impact.scene.texts.names import point_label

TOLERANCE_RATIO = 0.1
"""The solver's tolerance in the second run, divided by the solver's tolerance in the first run.

With a ratio closer to 1, the two runs would have errors of similar size, so their difference would not be an
estimate of the first run's error.
"""


@dataclass(frozen=True)
class Differences:
    """The largest differences between two runs, up to the first impact in which the runs differ.

    Attributes:
        impacts: the number of compared impacts: the impacts before the first impact in which the runs differ
            (``common_count``).
        onset: the largest difference between the onsets of a compared impact in the two runs [s]; 0 without
            a compared impact.
        position: the largest distance between the positions of a point in the two runs at the same time [m].
        point: the name of the point that has this largest distance.
        time: the time at which the point has this largest distance [s].
        end: the time up to which the runs are compared [s].
        parted: whether the runs differ in an impact that begins by the end of the shorter run. If so, ``end``
            is the onset of this impact, or the earlier one of two onsets; if not, the end of the shorter run.
    """

    impacts: int
    onset: float
    position: float
    point: str
    time: float
    end: float
    parted: bool


def differences(run: Recording, tighter_run: Recording) -> Differences:
    """Return the differences of two runs of the same scene, the second run at a tighter tolerance.

    The comparison ends at the first impact in which the runs differ: after this impact, the runs are two
    different motions, whose distance is not an error of the solver.
    """
    rows = min(len(run.time), len(tighter_run.time))
    end, has_same_times = float(run.time[rows - 1]), run.time[:rows] == tighter_run.time[:rows]
    same = common_count(run.impacts, tighter_run.impacts)
    onsets = [side.impacts["onset"] for side in (run, tighter_run)]
    later_onsets = [float(times[same]) for times in onsets if len(times) > same]
    is_parted = bool(later_onsets) and min(later_onsets) <= end
    if is_parted:
        end = min(later_onsets)
    distances = np.linalg.norm(run.all_points[:rows] - tighter_run.all_points[:rows], axis=-1)
    # a row counts only if it has the same time in both runs, and this time is not after ``end``
    distances[~has_same_times | (run.time[:rows] > end)] = 0.0
    row, point = np.unravel_index(distances.argmax(), distances.shape)
    onset = np.abs(onsets[0][:same] - onsets[1][:same]).max(initial=0.0)
    return Differences(
        impacts=same,
        onset=float(onset),
        position=float(distances[row, point]),
        point=point_label(int(point), run.point_names),
        time=float(run.time[row]),
        end=end,
        parted=is_parted,
    )
