"""The largest force in each joint during a run, with its time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chain_impact.recording.recording import Recording


class JointPeak(NamedTuple):
    """The largest force in a joint.

    Attributes:
        joint: the number of the joint.
        force: the force [N].
        time: the time of the force [s], or of the first row by which the force has occurred.
        kind: how much is known: EXACT_PEAK, force and time also between rows; LARGEST_OF_ROWS, the force also
            between rows, and the time of a row; SAMPLED_PEAK, force and time of a row.
    """

    joint: int
    force: float
    time: float
    kind: str


EXACT_PEAK, LARGEST_OF_ROWS, SAMPLED_PEAK = "exact", "by row", "sampled"
# [1] forces count as equal if they differ by at most this, relative to the larger force
EQUAL_FORCES = 1e-9


def joint_peaks(recording: Recording) -> list[JointPeak]:
    """Return the largest force in each joint whose force is known, in descending order of the forces.

    Force and time are those of ``joint[i].peak_force`` and ``joint[i].peak_time``, or of a row without these.
    """
    found_peaks = []
    for (joint, _), values in recording.columns_of("joint").items() if len(recording.time) else ():
        if "peak_force" in values:
            peaks, times = values["peak_force"], values.get("peak_time")
            first = recording.time[(peaks >= (1.0 - EQUAL_FORCES) * peaks[-1]).argmax()]
            time, kind = (first, LARGEST_OF_ROWS) if times is None else (times[-1], EXACT_PEAK)
            found_peaks.append(JointPeak(joint, float(peaks[-1]), float(time), kind))
        elif joint in recording.joint_forces:
            sizes = np.hypot(*recording.joint_forces[joint].T)
            row = sizes.argmax()
            found_peaks.append(JointPeak(joint, float(sizes[row]), float(recording.time[row]), SAMPLED_PEAK))
    return sorted(found_peaks, key=lambda peak: -peak.force)
