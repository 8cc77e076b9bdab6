"""An estimate of the error of positions and onsets: what a run and one at a tighter tolerance differ by."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from chain_impact.results.recording import Recording
from chain_impact.scene.names import point_label

TIGHTER = 0.1
"""The tolerance of the second run, as a part of the first run's. With a larger part, the error of the second
run is no longer small beside the error of the first, and their difference is no estimate."""


@dataclass(frozen=True)
class Differences:
    """The largest differences of two runs, as far as their impacts are the same ones in the same order.

    Attributes:
        impacts: how many impacts are compared.
        onset: difference of two onsets [s]; 0 without an impact.
        position: distance of a point's two positions at the same time [m].
        point: what this point is called.
        time: when it is [s].
        end: the end of the comparison [s].
        parted: whether the runs have other impacts from there on.
    """

    impacts: int
    onset: float
    position: float
    point: str
    time: float
    end: float
    parted: bool


def differences(run: Recording, tighter: Recording) -> Differences:
    """Compare a run with one at a tighter tolerance, row by row and impact by impact.

    Once the runs have other impacts, they are two motions, and their difference is no error.
    """
    rows = min(len(run.time), len(tighter.time))
    end, together = float(run.time[rows - 1]), run.time[:rows] == tighter.time[:rows]
    pairs = [[(one["point"], one["wall"]) for one in each.impacts] for each in (run, tighter)]
    same = next((k for k, (one, other) in enumerate(zip(*pairs, strict=False)) if one != other), None)
    same = min(map(len, pairs)) if same is None else same
    onsets = [each.impacts["onset"] for each in (run, tighter)]
    later = [float(each[same]) for each in onsets if len(each) > same]
    parted = bool(later) and min(later) <= end
    if parted:
        end = min(later)
    apart = np.linalg.norm(run.all_points[:rows] - tighter.all_points[:rows], axis=-1)
    apart[~together | (run.time[:rows] > end)] = 0.0  # a run that fails ends between two rows
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
