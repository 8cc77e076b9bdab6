"""The times at which contacts end, and at which their forces are largest, for pictures."""

from __future__ import annotations

import numpy as np

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.recording.impact_course import HasRerun, ImpactCourse
from chain_impact.recording.impacts import lasts_to_end
from chain_impact.recording.recording import Recording

# the least time, relative to the run's duration, that is visible: a contact that does not last longer is no
# thick line, and the peak of its force is drawn at the onset
SEEN_CONTACT = 0.01
# the least force of a row that counts as the peak of a contact, relative to the peak force, which may lie
# between rows
ALMOST_PEAK = 0.98
# the time of the largest force is that of the first row with at least PEAK_SHARE × this force, so that
# round-off does not choose a time while the force is constant
PEAK_SHARE = 1.0 - 1e-4
# the same as PEAK_SHARE for the rows of an impact's course, which are close in time
EXACT_PEAK_SHARE = 1.0 - 1e-7
# a force is mostly constant if more than this share of its rows have at least PEAK_SHARE × the largest force
STEADY_SHARE = 0.5


def contact_ends(recording: Recording) -> np.ndarray:
    """Return the ends of the contacts of the recording's I impacts, shape (I,) [s].

    A contact that lasts to the end of the recording gets this end; any other unknown end becomes the onset.
    """
    impacts = recording.impacts
    ends = np.where(lasts_to_end(impacts), recording.time[-1], impacts["end"])
    return np.asarray(np.where(np.isnan(ends), impacts["onset"], ends))


def has_impulses(law: str) -> bool:
    """Return whether a contact law, by its id, acts by impulses; False for a user's law or an unknown law."""
    return law in CONTACT_LAWS and CONTACT_LAWS[law].rigid


def law_at(recording: Recording, *, is_stop: bool) -> str:
    """Return the contact law at stops of joints, or that at walls and stops of a slider; "" if unknown.

    Stops of joints without a known law of their own get the law at walls.
    """
    return (is_stop and recording.stop_law) or recording.parameters.get("contact.model", "")


def acts_by_impulses(recording: Recording) -> bool:
    """Return whether a law of impulses holds for any impact: forces in joints then lack these impulses."""
    return any(
        has_impulses(law_at(recording, is_stop=is_stop)) for is_stop in {*recording.is_at_joint_stop.tolist()}
    )


def impacts_at_peaks(recording: Recording) -> np.ndarray:
    """Return a copy of the table of impacts in which ``onset`` is the time of the largest force, if known.

    The onset stays

    - if the recording lacks the force,
    - under a law that acts by impulses,
    - if the contact has no row, or its largest force follows too soon to be visible (SEEN_CONTACT),
    - if no row has almost the peak force (ALMOST_PEAK), and
    - if the force is mostly constant (STEADY_SHARE).
    """
    impacts, time, least_duration = (
        recording.impacts.copy(),
        recording.time,
        SEEN_CONTACT * recording.duration,
    )
    forces, ends = recording.contact_forces, contact_ends(recording)
    for impact, end in zip(impacts, ends, strict=True):
        force = forces.get((int(impact["point"]), recording.wall_names[impact["wall"]]))
        first, last = np.searchsorted(time, [impact["onset"], end])
        law = law_at(recording, is_stop=recording.is_joint_stop(impact["wall"]))
        is_short = end - impact["onset"] <= least_duration or first == last
        if force is None or is_short or has_impulses(law):
            continue
        during = force[first:last]
        is_largest = during >= PEAK_SHARE * during.max()
        row = first + is_largest.argmax()
        if len(during) > 1 and is_largest.mean() > STEADY_SHARE:
            continue
        if force[row] >= ALMOST_PEAK * impact["peak_force"] and time[row] - impact["onset"] > least_duration:
            impact["onset"] = time[row]
    return impacts


def course_in_run(recording: Recording, row: int) -> ImpactCourse | None:
    """Return the course of the impact in row ``row`` of ``impacts``; None if the run cannot be repeated."""
    if isinstance(recording, HasRerun) and recording.rerun is not None:
        return recording.course_of_impact(row + 1)
    return None


def peak_time(recording: Recording, row: int) -> float:
    """Return the time [s] of the largest force in the impact in row ``row``, as ``impacts_at_peaks`` does.

    If that time is later than the onset, and the run can be repeated, the result is the first time at which
    the course of the impact has the largest force (EXACT_PEAK_SHARE), which may lie between rows.
    """
    time = float(impacts_at_peaks(recording)["onset"][row])
    course = course_in_run(recording, row) if time > recording.impacts["onset"][row] else None
    if course is None:
        return time
    return float(course.time[(course.force >= EXACT_PEAK_SHARE * course.force.max()).argmax()])
