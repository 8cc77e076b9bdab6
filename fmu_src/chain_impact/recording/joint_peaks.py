"""The largest force in each joint during a run, with its time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chain_impact.recording.recording import Recording


class JointPeak(NamedTuple):
    """The largest force in a joint: the joint's number, the force [N] and its time [s]."""

    joint: int
    force: float
    time: float


def joint_peaks(recording: Recording) -> list[JointPeak]:
    """Return the largest force in each joint whose force is known, in descending order of the forces.

    Force and time are the last values of ``joint[i].peak_force`` and ``joint[i].peak_time``, which include
    the times between rows. If one of them is unknown, both come from the rows of ``joint[i].force``.
    """
    found = []
    for (joint, _), values in recording.columns_of("joint").items():
        if values.keys() >= {"peak_force", "peak_time"} and len(recording.time):
            found.append(JointPeak(joint, float(values["peak_force"][-1]), float(values["peak_time"][-1])))
        elif joint in recording.loads and len(recording.time):
            sizes = np.hypot(*recording.loads[joint].T)
            found.append(JointPeak(joint, float(sizes.max()), float(recording.time[sizes.argmax()])))
    return sorted(found, key=lambda peak: -peak.force)
