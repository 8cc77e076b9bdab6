"""The panel with the force of one impact over time, its peak, and the duration of the contact."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from chain_impact.pictures.drawing.axis_numbers import force_text, give_ticks, load_unit
from chain_impact.pictures.drawing.colours import INK, PEAK_COLOUR
from chain_impact.pictures.drawing.labels import Label, place_labels
from chain_impact.pictures.drawing.legends import legend_above
from chain_impact.pictures.drawing.style import COLUMN
from chain_impact.pictures.drawing.used_pixels import UsedPixels
from chain_impact.pictures.over_time.impacts import HEADROOM
from chain_impact.pictures.texts.headline import largest_peaks
from chain_impact.recording.contact_times import course_in_run
from chain_impact.recording.impacts import lasts_to_end
from chain_impact.recording.pacing import LEAST_SPEED, LONGEST_IMPACT
from chain_impact.recording.recording import Recording
from chain_impact.text import prefixed_unit
from chain_impact.variables.impact_units import unit_at

PEAK = 0.95  # a force counts as at its peak from PEAK × its largest value on
# a long contact is shown for at least PEAK_TIMES_SHOWN × the time from its onset until its force is at its
# peak
PEAK_TIMES_SHOWN = 4.0
# a contact is long if it lasts more than MUCH_LONGER × the time for which ``shown_contact`` shows a long one
MUCH_LONGER = 2.0
# If a run cannot be repeated, the force of a contact is drawn from the recording's rows within the contact,
# if there are at least LEAST_CONTACT_ROWS such rows.
LEAST_CONTACT_ROWS = 20
# An axis that is cut has two strokes: BREAK has their places, relative to the length of the axis, and SLASH
# the corners of a stroke.
BREAK, SLASH = (0.97, 0.985), [(-0.4, -1.0), (0.4, 1.0)]
BREAK_LOOK: dict[str, Any] = {"linestyle": "", "color": "black", "markersize": 8.0, "clip_on": False}
LOW_HEADROOM = 1.75  # HEADROOM in a figure with a width of COLUMN or less, whose panels are low
OPACITY = 0.15  # the opacity of the area below the curve, from 0 to 1


def shown_contact(impact: np.void, time: np.ndarray, force: np.ndarray) -> float:
    """Return the time after the onset [s] for which a contact is shown; 0 if ``time`` is empty.

    The time is the duration of the contact or, if the contact is long (MUCH_LONGER), the longer one of
    LONGEST_IMPACT × penetration / impact speed and PEAK_TIMES_SHOWN × the time from the onset until the force
    is at its peak (PEAK).

    ``impact`` is a row of ``impacts``; ``time`` [s] and ``force`` are those of the contact, shape (S,).
    """
    if not len(time):
        return 0.0
    duration = float(np.ptp(time))
    speed = max(impact["impact_speed"], LEAST_SPEED)
    peak = float(time[np.argmax(force >= PEAK * force.max())] - time[0])
    near_duration = max(
        LONGEST_IMPACT * np.nan_to_num(impact["max_penetration"]) / speed, PEAK_TIMES_SHOWN * peak
    )
    return near_duration if duration > MUCH_LONGER * near_duration else duration


def is_alone(recording: Recording) -> bool:
    """Return whether a recording has a single impact, and the force over time of this impact is known."""
    return len(recording.impacts) == 1 and course_of_hardest(recording) is not None


def course_of_hardest(recording: Recording) -> tuple[int, np.ndarray, np.ndarray] | None:
    """Return row, times [s] and forces of the hardest impact; times and forces have the shape (S,).

    The hardest impact is that with the largest force at a wall or at a stop of a slider or, without such a
    force, with the largest moment at a stop of a joint [N·m]. Times and forces come from a repeated run or,
    if the run cannot be repeated, from the recording's rows within the contact, if these are at least
    LEAST_CONTACT_ROWS. The result is None if no impact has a known peak force, or if the forces are not
    known.
    """
    hardest = next((peak for peak in largest_peaks(recording) if "impulse" not in peak.name), None)
    if hardest is None or not recording.impacts["peak_force"][hardest.row] > 0.0:
        return None
    row, impact = hardest.row, recording.impacts[hardest.row]
    if (course := course_in_run(recording, row)) is not None:
        return (row, course.time, course.force) if len(course.time) else None
    end = recording.time[-1] if lasts_to_end(impact) else impact["end"]
    is_inside = (recording.time >= impact["onset"]) & (recording.time <= end)
    pair = int(impact["point"]), recording.wall_names[impact["wall"]]
    force = recording.contact_forces.get(pair)
    if force is None or np.count_nonzero(is_inside) < LEAST_CONTACT_ROWS:
        return None
    return row, recording.time[is_inside], force[is_inside]


def draw_one_impact(axes: Axes, recording: Recording) -> None:
    """Draw the force, or moment at a stop of a joint, of the hardest impact over the time after the onset.

    The legend tells the duration of the contact, or that it lasts to the end. Two strokes on the horizontal
    axis tell that the axis ends before the contact. If ``course_of_hardest`` knows no force, a text says
    this.
    """
    hardest_course = course_of_hardest(recording)
    if hardest_course is None:
        axes.text(0.5, 0.5, "no force over time is known", transform=axes.transAxes, ha="center", color=INK)
        return
    row, time, force = hardest_course
    impact = recording.impacts[row]
    factor, unit = prefixed_unit(shown_contact(impact, time, force), "s")
    times, forces, force_unit = curve_of(recording, hardest_course)
    duration = float(impact["end"] - impact["onset"])
    duration_text = "lasts to the end" if lasts_to_end(impact) else f"lasts {force_text(duration, 's')}"
    name = f"impact {row + 1}, {duration_text}"
    axes.fill_between(times, forces, color=PEAK_COLOUR, alpha=OPACITY, linewidth=0.0, label=name)
    axes.plot(times, forces, color=PEAK_COLOUR, linewidth=1.4)
    shown_ends, figure = factor * shown_contact(impact, time, force), axes.get_figure(root=True)
    # the number of the peak must not stand on the area below the curve, also in a low panel
    is_low = figure is not None and figure.get_figwidth() <= COLUMN
    headroom = LOW_HEADROOM if is_low else HEADROOM
    axes.set(xlim=(-0.03 * shown_ends, 1.03 * shown_ends), ylim=(0.0, headroom * float(forces.max())))
    if shown_ends < times[-1]:
        axes.plot(BREAK, [0.0, 0.0], marker=SLASH, **BREAK_LOOK, transform=axes.transAxes)
    axes.set_xlabel(f"time after the onset [{unit}]")
    axes.set_ylabel(f"{'moment' if recording.is_joint_stop(impact['wall']) else 'force'} [{force_unit}]")
    give_ticks(axes)
    legend_above(axes)


def curve_of(
    recording: Recording, course: tuple[int, np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray, str]:
    """Return times after the onset and forces in the units of the axes, and the unit of the forces.

    ``course`` is a result of ``course_of_hardest``.
    """
    row, time, force = course
    impact = recording.impacts[row]
    factor, _ = prefixed_unit(shown_contact(impact, time, force), "s")
    scale, unit = load_unit(
        float(force.max()), unit_at("peak_force", is_stop=recording.is_joint_stop(impact["wall"]))
    )
    return factor * (time - impact["onset"]), scale * force, unit


def number_one_impact(axes: Axes, recording: Recording, used_pixels: UsedPixels) -> None:
    """Write the peak force or moment at the curve of ``draw_one_impact``."""
    if hardest_course := course_of_hardest(recording):
        times, forces, _ = curve_of(recording, hardest_course)
        top, peak = int(forces.argmax()), recording.impacts["peak_force"][hardest_course[0]]
        unit = unit_at(
            "peak_force", is_stop=recording.is_joint_stop(recording.impacts["wall"][hardest_course[0]])
        )
        position = float(times[top]), float(forces[top])
        label = Label(force_text(float(peak), unit), position, look={"color": PEAK_COLOUR})
        place_labels(axes, [label], used_pixels, lines=True, fontsize="small")
