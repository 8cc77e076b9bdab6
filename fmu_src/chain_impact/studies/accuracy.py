"""An estimate of the errors of positions and onsets, from a second run at a tighter tolerance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from chain_impact.recording.impacts import common_count
from chain_impact.recording.recording import Recording
from chain_impact.scene.names import point_label

TIGHTER = 0.1
"""The tolerance of the second run, relative to the tolerance of the first run. With a larger ratio, the error
of the second run is not small compared with the error of the first run, and the difference of both is not an
estimate of the error."""


@dataclass(frozen=True)
class Differences:
    """The largest differences between two runs, up to their first different impact.

    Attributes:
        impacts: the number of compared impacts: those before the first different impact.
        onset: the largest difference of onsets [s]; 0 if no impacts are compared.
        position: the largest distance between the positions of a point in both runs at the same time [m].
        point: the name of the point with the largest distance.
        time: the time of the largest distance [s].
        end: the end of the comparison [s].
        parted: whether the comparison ends at the first different impact; if not, it ends with the runs.
    """

    impacts: int
    onset: float
    position: float
    point: str
    time: float
    end: float
    parted: bool


def differences(run: Recording, tighter: Recording) -> Differences:
    """Return the differences between a run and a run at a tighter tolerance, in rows and impacts.

    After the first different impact the runs are two different motions, whose difference does not measure an
    error.
    """
    rows = min(len(run.time), len(tighter.time))
    end, together = float(run.time[rows - 1]), run.time[:rows] == tighter.time[:rows]
    same = common_count(run.impacts, tighter.impacts)
    onsets = [side.impacts["onset"] for side in (run, tighter)]
    later = [float(times[same]) for times in onsets if len(times) > same]
    parted = bool(later) and min(later) <= end
    if parted:
        end = min(later)
    apart = np.linalg.norm(run.all_points[:rows] - tighter.all_points[:rows], axis=-1)
    # only rows at equal times, until the end of the comparison, are compared
    apart[~together | (run.time[:rows] > end)] = 0.0
    row, point = np.unravel_index(apart.argmax(), apart.shape)
    onset = np.abs(onsets[0][:same] - onsets[1][:same]).max(initial=0.0)
    return Differences(
        impacts=same,
        onset=float(onset),
        position=float(apart[row, point]),
        point=point_label(int(point), run.point_names),
        time=float(run.time[row]),
        end=end,
        parted=parted,
    )
