"""The headline of a recording's picture, and below it the text with the results and conditions of the run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from chain_impact.pictures.drawing.axis_numbers import force_text
from chain_impact.pictures.drawing.colours import INK, LOAD, PEAK_COLOUR
from chain_impact.pictures.drawing.distinct_curves import turning_rows
from chain_impact.pictures.drawing.head_and_foot import write_foot, write_headline
from chain_impact.pictures.drawing.line_breaks import SEPARATOR
from chain_impact.pictures.drawing.style import is_narrow
from chain_impact.pictures.texts.conditions import conditions
from chain_impact.pictures.texts.point_names import brief_hit, what_touches
from chain_impact.recording.contact_times import acts_by_impulses, has_impulses, law_at, peak_time
from chain_impact.recording.impact_texts import speed_unit
from chain_impact.recording.impacts import lasts_to_end
from chain_impact.recording.joint_peaks import LARGEST_OF_ROWS, joint_peaks
from chain_impact.recording.recording import Recording
from chain_impact.text import count_text, prefixed_unit
from chain_impact.variables.impact_units import unit_at

# a dissipated energy up to this, relative to the largest |total energy|, is round-off, and not a loss
NO_LOSS = 1e-12

# the value of an impact counts as equal to the largest value if it is smaller by at most this, relative to
# the largest value
SAME_PEAK = 1e-3
# the energy that is supplied or taken at the end is told only if it exceeds this, relative to the dissipated
# energy, or if it oscillates (MANY_TURNS)
LITTLE_SUPPLIED = 0.01
# An energy oscillates if it has more than MANY_TURNS ``turning_rows``, between which it changes at least by
# LARGE_TURN, relative to its range.
MANY_TURNS, LARGE_TURN = 12, 0.25
# words for the impulse of a contact, and for the part of this impulse without the time integral of the force
IMPULSE, HIT_IMPULSE = "impulse", "hit impulse"
MARKING = ("motion", "impact", "impacts")  # the panels of an overview that mark the impact with the peak
SHORT_TIME = 0.1  # [s] a time below this is written in a unit with a prefix, such as ms


def time_unit(span: float) -> tuple[float, str]:
    """Return the factor from seconds to the unit for a time span [s], and this unit: (1000, "ms") for 0.05 s.

    The unit is s for 0, and from SHORT_TIME on.
    """
    return prefixed_unit(span, "s") if 0.0 < span < SHORT_TIME else (1.0, "s")


class Peak(NamedTuple):
    """The peak force, peak moment or impulse of an impact.

    Attributes:
        name: the quantity in words: "peak force".
        value: the value of the quantity with its unit: "12.6 kN".
        row: the row of the impact in ``impacts``, from 0.
        equal_count: how many impacts have this value, if ``largest_peaks`` gives it (SAME_PEAK): ``row`` is
            then the first of these impacts. Otherwise 1.
    """

    name: str
    value: str
    row: int
    equal_count: int = 1

    @property
    def sentence(self) -> str:
        """A sentence with the value: "the peak force is 12.6 kN", "there are 30 equal impulses of 1 N·s"."""
        return f"the {self.name} is {self.value}" if self.equal_count == 1 else f"there are {self.text}"

    @property
    def text(self) -> str:
        """The quantity and its value: "peak force 12.6 kN", "30 equal impulses of 0.981 N·s"."""
        if self.equal_count == 1:
            return f"{self.name} {self.value}"
        quantity, *location = self.name.removeprefix("largest ").split(" at ")
        return f"{self.equal_count} equal {' at '.join([f'{quantity}s', *location])} of {self.value}"


def headline(recording: Recording, first: str | None = None) -> str:
    """Return the headline, a name and a sentence: "Box: the peak force is 12.6 kN".

    The sentence is ``first``; by default that of the first entry of ``largest_peaks``. If it is empty, the
    headline tells the number of impacts.
    """
    if first is None:
        first = next((peak.sentence for peak in largest_peaks(recording)), "")
    return f"{recording.name}: {first or event_sentence(recording)}"


def event_sentence(recording: Recording) -> str:
    """Return a sentence on the number of impacts: "14 impacts happen in 2 s", "nothing is hit in 2 s"."""
    if not has_contact(recording):
        return impact_count_text(recording).replace("no impacts", "nothing is hit")
    count = recording.impact_count
    verb = "happens" if count == 1 else "happen"
    return impact_count_text(recording).replace(" in ", f" {verb} in ")


def impact_count_text(recording: Recording) -> str:
    """Return words for the number of impacts and the duration of the run: "14 impacts in 2 s"."""
    count, span = recording.impact_count, recording.duration
    factor, unit = time_unit(span)
    return f"{count_text(count, 'impact') if count else 'no impacts'} in {factor * span:g} {unit}"


def energy_texts(recording: Recording) -> list[str]:
    """Return words for the energies that the run lost and got: "2.98 J dissipated", "10.5 J taken by drives".

    All energies are those at the end of the run. What is not known or round-off (NO_LOSS) is left out. Of a
    supplied energy that oscillates (MANY_TURNS), the range is told, however small the energy at the end is.
    Any other energy that drives and inputs supply or take is left out if it is at most LITTLE_SUPPLIED × the
    dissipated one.
    """
    lost_energy, supplied = (
        float(recording.energies.get(name, np.zeros(1))[-1]) for name in ("dissipated", "supplied")
    )
    least_loss = NO_LOSS * np.abs(recording.energies.get("total", np.zeros(1))).max()
    parts = [f"{lost_energy:.3g} J dissipated"] if lost_energy > least_loss else []
    course = recording.energies.get("supplied", np.zeros(1))
    low, high = float(course.min()), float(course.max())
    if high - low > least_loss and len(turning_rows(course, LARGE_TURN * (high - low))) > MANY_TURNS:
        ends_text = f"{low:.2g} and {high:.2g} J".replace("-", "−")
        return [*parts, f"supplied energy oscillates between {ends_text}"]
    if abs(supplied) > max(least_loss, LITTLE_SUPPLIED * lost_energy):
        parts.append(f"{abs(supplied):.3g} J {'supplied' if supplied > 0.0 else 'taken'} by drives")
    return parts


def hit_text(recording: Recording, impact: np.void) -> str:
    """Return words for an impact: "point 4 hits y_min"."""
    return f"{what_touches(recording, impact)} hits {recording.wall_names[impact['wall']]}"


def write_head(
    figure: Figure,
    recording: Recording,
    title: str,
    *first: str,
    told_peaks: Sequence[Peak] | None = None,
    lead: str | None = None,
    panels: Sequence[str] = (),
    notes: Sequence[str] = (),
) -> None:
    """Write the headline of a recording's picture and lines below it; conditions and ``notes`` at the foot.

    Without a ``title``, the headline is the result of ``headline`` with the words ``lead``. If the recording
    has no told impact, the words can be those of the largest force in a joint (``load_text``), if the panel
    of the motion shows this force.

    Two results can have a line of their own below the headline, in the colour of their mark in a panel. The
    first told impact has one if there is no ``title``, and if the figure is narrow or a panel marks the
    impact. The largest force in a joint has one if the figure is narrow or the panel of the motion shows this
    force. All other results stand before the conditions.

    Args:
        figure: the figure, which has its panels.
        recording: the recording.
        title: the headline; "" for the usual one.
        first: texts that stand before the results.
        told_peaks: the impacts to tell; by default those of ``largest_peaks``, and the largest force in a
            joint.
        lead: the words of the headline; by default those of the first told impact.
        panels: the names of the panels of an overview.
        notes: texts at the foot, which are written even if the conditions have no room there.
    """
    short, load = is_narrow(figure), load_text(recording) if told_peaks is None else ""
    told_peaks = largest_peaks(recording) if told_peaks is None else told_peaks
    lead = next((peak.sentence for peak in told_peaks), "") if lead is None else lead
    if not (lead or title or told_peaks) and load and "motion" in panels and recording.joint_forces:
        lead, load = load_text(recording, digits=3).replace(" in the run, ", " "), ""
    valued = [bool(title) or lead != peak.sentence for peak in told_peaks]
    hits = [peak_impact_text(recording, *pair) for pair in zip(told_peaks, valued, strict=True)]
    lines: list[tuple[str, str]] = []
    is_marked = bool(told_peaks) and told_peaks[0].equal_count == 1 and not {*panels}.isdisjoint(MARKING)
    if told_peaks and not title and (short or is_marked):
        first_text = hits.pop(0).removeprefix(f"{told_peaks[0].name} in ")  # the title tells the peak
        lines.append((first_text, PEAK_COLOUR if is_marked else INK))
    is_load_shown = "motion" in panels and bool(recording.joint_forces)
    if load and (short or is_load_shown):
        lines.append((load, LOAD if is_load_shown else INK))
        load = ""
    results = [*first, *hits, load]
    if not title:
        results += [*([impact_count_text(recording)] if lead else []), *energy_texts(recording)]
    condition_texts = conditions(recording, *results, touches=has_contact(recording), short=short)
    write_headline(figure, title or headline(recording, lead), "", *lines)
    if not write_foot(figure, SEPARATOR.join(filter(None, [condition_texts, *notes]))) and any(notes):
        write_foot(figure, SEPARATOR.join(filter(None, notes)))


def largest_peaks(recording: Recording) -> list[Peak]:
    """Return the largest peak force at walls, and the largest peak moment at stops of joints, if known.

    Stops of a slider count as walls. Where ``impact_values`` gives impulses, the largest impulse replaces the
    largest force or moment. The list has at most two entries, walls first.
    """
    found_peaks = []
    for is_stop in (False, True):
        name, unit, values = impact_values(recording, is_stop=is_stop)
        top = float(values.max(initial=0.0))
        if top > 0.0:
            if name in (IMPULSE, HIT_IMPULSE):
                order = "largest " if np.count_nonzero(values) > 1 else ""
                name = f"{order}{name}{' at a stop' if is_stop else ''}"
            rows = np.flatnonzero(values >= (1.0 - SAME_PEAK) * top)
            found_peaks.append(Peak(name, force_text(top, unit), int(rows[0]), len(rows)))
    return found_peaks


def marked_peaks(recording: Recording) -> list[Peak]:
    """Return those of ``largest_peaks`` that only one impact reaches: only these impacts have PEAK_COLOUR."""
    return [peak for peak in largest_peaks(recording) if peak.equal_count == 1]


def peak_of(recording: Recording, row: int) -> list[Peak]:
    """Return a list with the ``Peak`` of the impact in a row; [] if the peak is 0 or not known."""
    name, unit, values = impact_values(recording, is_stop=bool(recording.is_at_joint_stop[row]))
    return [Peak(name, force_text(float(values[row]), unit), row)] if values[row] > 0.0 else []


def hardness_text(recording: Recording, row: int) -> str:
    """Return words for how hard the impact in a row is: "peak force 12.6 kN, with 2.92 m/s".

    Without a known peak, the words have only the impact speed.
    """
    speed_note = f"with {speed_text(recording, row)}"
    return ", ".join([*(f"{peak.name} {peak.value}" for peak in peak_of(recording, row)), speed_note])


def speed_text(recording: Recording, row: int) -> str:
    """Return the impact speed of the impact in a row, with its unit: "2.92 m/s"."""
    impact = recording.impacts[row]
    return f"{impact['impact_speed']:.3g} {speed_unit(recording.is_joint_stop(impact['wall']))}"


def impact_values(recording: Recording, *, is_stop: bool) -> tuple[str, str, np.ndarray]:
    """Return how hard impacts are: quantity, unit, values, shape (I,).

    If ``is_stop``, the values are those of the impacts at stops of joints, else those of all other impacts:
    at walls and at stops of a slider. The quantity is "peak force", "peak moment", IMPULSE or HIT_IMPULSE. A
    value that is unknown, or that of an impact that does not belong to ``is_stop``, is 0.

    All values are impulses at rigid walls, and if any of these impacts has an impulse but no known
    force, as in a recording without the law. The impulse of a contact that lasts to the end of the run counts
    as 0, because this impulse also contains the shocks of other impacts. But if no contact with an impulse
    ends before, the values are hit impulses (``impulses_of_hits``).
    """
    impacts = recording.impacts
    is_own = recording.is_at_joint_stop == is_stop
    forces, impulses = (np.nan_to_num(impacts[name]) * is_own for name in ("peak_force", "impulse"))
    # a rod that lies on a rigid wall after its bounces has a force, too, but this force says nothing on the
    # bounces
    is_rigid = has_impulses(law_at(recording, is_stop=is_stop))
    if is_rigid or ((forces == 0.0) & (impulses > 0.0)).any():
        totals = impulses * ~lasts_to_end(impacts)
        name, values = (
            (IMPULSE, totals) if totals.any() else (HIT_IMPULSE, impulses_of_hits(recording) * is_own)
        )
        return name, unit_at("impulse", is_stop=is_stop), values
    return f"peak {'moment' if is_stop else 'force'}", unit_at("peak_force", is_stop=is_stop), forces


def impulses_of_hits(recording: Recording) -> np.ndarray:
    """Return the hit impulse of each impact under a law that acts by impulses, shape (I,).

    If the contact ends during the run, this is the impulse of the contact. If the contact lasts to the end of
    the run, the time integral of the contact's force is subtracted, because it grows with the duration of the
    run; the result is then 0 if this force is not known. An unknown impulse counts as 0.
    """
    impacts, time, impulses = recording.impacts, recording.time, np.nan_to_num(recording.impacts["impulse"])
    forces = recording.contact_forces
    for row in np.flatnonzero(lasts_to_end(impacts)):
        onset, wall = impacts["onset"][row], recording.wall_names[impacts["wall"][row]]
        force, first = forces.get((int(impacts["point"][row]), wall)), np.searchsorted(time, onset)
        if force is None or first == len(time):
            impulses[row] = 0.0
            continue
        held_forces = np.append(force[first], force[first:])
        impulses[row] = max(0.0, impulses[row] - np.trapezoid(held_forces, np.append(onset, time[first:])))
    return np.asarray(impulses)


def peak_impact_text(recording: Recording, peak: Peak, has_values: bool) -> str:
    """Return words for the impact of a peak.

    For example "peak force in impact 1: point 4 hits y_min at 0.5 s with 2 m/s". If several impacts have the
    value of the peak, the words tell the first of these impacts. ``has_values``: whether to tell the value.
    """
    if peak.equal_count > 1:
        beginning = f"{peak.text}, the first in " if has_values else "the first in "
        return f"{beginning}{impact_text(recording, peak.row)}"
    return f"{peak.name}{f' {peak.value}' if has_values else ''} in {impact_text(recording, peak.row)}"


def impact_text(recording: Recording, row: int) -> str:
    """Return words for the impact in a row: "impact 1: ball hits y_min at 0.5 s with 2 m/s, peak at 0.7 s".

    The time of the peak is told if it is later than the onset (``peak_time``).
    """
    impact, peak = recording.impacts[row], peak_time(recording, row)
    factor, unit = time_unit(recording.duration)
    onset_text = f"{factor * impact['onset']:.4g} {unit}"
    peak_text = f", peak at {factor * peak:.4g} {unit}" if peak > impact["onset"] else ""
    speed = speed_text(recording, row)
    return f"impact {row + 1}: {brief_hit(recording, impact)} at {onset_text} with {speed}{peak_text}"


def load_text(recording: Recording, digits: int = 5) -> str:
    """Return words for the largest force in a joint: "joint 2 bears up to 621 N in the run, at 0.4977 s".

    If the recording does not have the forces, they come from a repeated run. The result is "" if no joint
    bears a force, or if the forces remain unknown. The time has ``digits`` significant digits; "by" replaces
    "at" before the time of a row. If impacts act by impulses, "without impulses" replaces "in the run".
    """
    known_peaks = joint_peaks(recording)
    if not known_peaks and (
        loaded_run := recording.row_of_other_run({"outputs.loads": True}, float(recording.time[-1]))
    ):
        known_peaks = joint_peaks(loaded_run)
    largest_name = next(iter(known_peaks), None)
    if largest_name is None or not largest_name.force > 0.0:
        return ""
    factor, unit = time_unit(recording.duration)
    time_text = f"{factor * largest_name.time:.{digits}g} {unit}"
    span_text = "without impulses" if acts_by_impulses(recording) else "in the run"
    return (
        f"joint {largest_name.joint} bears up to {force_text(largest_name.force, 'N')} {span_text}, "
        f"{'by' if largest_name.kind == LARGEST_OF_ROWS else 'at'} {time_text}"
    )


def has_contact(recording: Recording) -> bool:
    """Return whether something touches a wall or a stop during the run."""
    forces = (interaction.force for interaction in recording.interactions)
    return recording.impact_count > 0 or any(force is not None and np.any(force) for force in forces)
