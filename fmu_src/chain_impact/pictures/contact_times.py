"""When contacts end and when their forces are largest, as far as a picture shows it."""

from __future__ import annotations

from typing import Any

import numpy as np

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.recording.course import Course
from chain_impact.recording.impacts import lasts
from chain_impact.recording.recording import Recording

# the least time within a contact, relative to the run's duration, that is seen: a shorter contact is no thick
# line, and the peak of its force stands at its onset
SEEN_CONTACT = 0.01
# the least force of a row that counts as the peak of a contact, relative to the peak force, which includes
# times between rows
ALMOST_PEAK = 0.98
# the time of the largest force is that of the first row with at least this part of it, so that round-off
# chooses no time of a constant force
FIRST = 1.0 - 1e-4
FIRST_EXACT = 1.0 - 1e-7  # the same as FIRST for the rows of an impact's course, which are close in time


def contact_ends(recording: Recording) -> np.ndarray:
    """Return the ends of the contacts of the recording's I impacts, shape (I,) [s].

    A contact that has not ended gets the end of the recording; an unknown end is replaced by the onset.
    """
    impacts = recording.impacts
    ends = np.where(lasts(impacts), recording.time[-1], impacts["end"])
    return np.asarray(np.where(np.isnan(ends), impacts["onset"], ends))


def has_impulses(law: str) -> bool:
    """Return whether a contact law acts by impulses; False for a law of a user and an unknown law."""
    return law in CONTACT_LAWS and CONTACT_LAWS[law].impulsive


def impacts_at_peaks(recording: Recording) -> np.ndarray:
    """Return the table of impacts with the time of the largest force as ``onset``, where the rows tell it.

    The onset stays if the force is largest so soon after it that this is not seen (SEEN_CONTACT), if no row
    has the peak force, and under a law that acts by impulses.
    """
    impacts, time, least = recording.impacts.copy(), recording.time, SEEN_CONTACT * np.ptp(recording.time)
    law = recording.parameters.get("contact.model", "")
    forces = {(touch.point, touch.wall): touch.force for touch in recording.touches}
    ends = contact_ends(recording)
    for impact, end in zip(impacts, ends, strict=True):
        force = forces.get((int(impact["point"]), recording.wall_names[impact["wall"]]))
        first, last = np.searchsorted(time, [impact["onset"], end])
        of_impact = (recording.is_stop(impact["wall"]) and recording.stop_law) or law
        is_short = end - impact["onset"] <= least or first == last
        if force is None or is_short or has_impulses(of_impact):
            continue
        during = force[first:last]
        row = first + (during >= FIRST * during.max()).argmax()
        if force[row] >= ALMOST_PEAK * impact["peak_force"] and time[row] - impact["onset"] > least:
            impact["onset"] = time[row]
    return impacts


def course_in_run(recording: Recording, row: int) -> Course | None:
    """Return the course of the impact in a row of ``impacts``; None if the run cannot be repeated."""
    result: Any = recording
    return result.course_of_impact(row + 1) if getattr(recording, "rerun", None) is not None else None


def peak_time(recording: Recording, row: int) -> float:
    """Return the time [s] of the largest force in one impact, as ``impacts_at_peaks``; ``row`` is its row.

    If the run can be repeated, a time later than the onset does not depend on the rows of the recording.
    """
    time = float(impacts_at_peaks(recording)["onset"][row])
    course = course_in_run(recording, row) if time > recording.impacts["onset"][row] else None
    if course is None:
        return time
    return float(course.time[(course.force >= FIRST_EXACT * course.force.max()).argmax()])
