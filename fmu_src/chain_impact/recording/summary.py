"""The summary of a run or of a recording in some lines, for Python, notebooks and the command line."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from chain_impact.kernel.record.constants import STICKS
from chain_impact.kernel.status import OK, STATUS_TEXT
from chain_impact.recording.impacts import lasts_to_end
from chain_impact.recording.joint_peaks import EXACT_PEAK, SAMPLED_PEAK, joint_peaks
from chain_impact.recording.joint_stops import is_scene_joint_stop
from chain_impact.recording.recording import Recording
from chain_impact.recording.rest import rest_lines
from chain_impact.recording.stick_slip import element_label
from chain_impact.scene.scene import Scene
from chain_impact.scene.texts.unit_text import stiffness_unit
from chain_impact.text import TextTable, count_text, names_text
from chain_impact.variables.impact_units import unit_at

# largest numbers of impacts in a list: LISTED_IMPACTS in notebooks and on the command line, LISTED_IN_SHORT
# in the text of a ``Result``
LISTED_IMPACTS, LISTED_IN_SHORT = 30, 10
NAMED_IMPACTS = 3  # largest number of impacts that the summary names for the time of a joint's largest force
MOST_LISTED_JOINTS = 8  # largest number of joints whose forces the summary lists
DEEP_PENETRATION = 0.5  # [1] ``BodySize.deep`` of a link, relative to its length
# largest number of contacts, joints and sliders that the summary names as sticking at the end
NAMED_STICKING = 3
VALUE_COLUMNS = ("speed", "duration", "peak force", "impulse")
COLUMN_UNITS, STOP_COLUMN_UNITS = (
    (
        unit_at("impact_speed", is_stop=stop),
        "ms",
        *(unit_at(name, is_stop=stop) for name in ("peak_force", "impulse")),
    )
    for stop in (False, True)
)
"""The units of VALUE_COLUMNS in the list of impacts: STOP_COLUMN_UNITS at stops of joints, COLUMN_UNITS at
walls and at stops of a slider."""
NO_NUMBER = "—"  # the text for a number that does not exist or is unknown
LASTING_TEXT = "lasts"  # the text in place of the duration of a contact that lasts to the end of the run
# A number that is at least FIVE_DIGITS and less than MILLION is rounded to four significant digits, and
# written as a whole number without an exponent.
FIVE_DIGITS, MILLION = 1e4, 1e6


def energy_lines(energies: Mapping[str, np.ndarray]) -> Iterator[str]:
    """Yield two lines, if the energies are known: the energies at start and end of the run; their balance.

    The balance checks the energy only; it does not bound errors of the motion. In free flight, positions may
    be wrong by the tolerance although the energy is constant up to round-off.
    """
    if not {"total", "dissipated"} <= energies.keys() or not len(energies["total"]):
        return
    total, dissipated = energies["total"], energies["dissipated"]
    supplied = energies.get("supplied", 0.0 * total)
    balance = total + dissipated - supplied
    sign = "-" if supplied[-1] < 0.0 else "+"
    supplied_text = f" {sign} {abs(supplied[-1]):.6g} J supplied" if supplied.any() else ""
    final_text = f"{total[-1]:.6g} J left + {dissipated[-1]:.6g} J dissipated"
    yield f"energy   {total[0]:.6g} J at the start{supplied_text} = {final_text}"
    energy_error = abs(balance - balance[0]).max()
    yield f"balance  off by at most {energy_error:.1e} J: an energy check, no bound on positions or times"


def summary_lines(
    result: Recording, outputs: int, facts: list[str], most_impacts: int
) -> Iterator[str | TextTable]:
    """Yield the summary of a run: lines, and the list of the first impacts.

    Args:
        result: the result of the run.
        outputs: the number of outputs of the result.
        facts: lines on energies, scene and solver, which come last.
        most_impacts: the largest number of impacts in the list.
    """
    yield _headline(result, outputs)
    yield from impact_list(result, most_impacts)
    yield from passed_wall_lines(result)
    yield from _friction_lines(result)
    yield from rest_lines(result)
    yield from load_lines(result)
    yield from facts


def impact_list(result: Recording, most_impacts: int) -> Iterator[str | TextTable]:
    """Yield the first ``most_impacts`` impacts as a table, and a line with the number of the others."""
    impacts = enumerate(result.impacts[:most_impacts], start=1)
    rows = [(str(number), *impact_cells(result, impact)) for number, impact in impacts]
    if rows:
        yield TextTable(("#", *impact_heads(result)), rows)
    if (omitted_count := len(result.impacts) - most_impacts) > 0:
        yield f"… and {count_text(omitted_count, 'more impact')}"


def passed_wall_lines(result: Recording) -> Iterator[str]:
    """Yield a line for each wall that points pass through without touching it."""
    yield from (f"note     {sentence}" for sentence in result.points_through_walls)


def _headline(result: Recording, outputs: int) -> str:
    end_text = f"{result.time[-1]:g}" if len(result.time) else "0"
    rows_text = f"{count_text(len(result.time), 'row')} of {count_text(outputs, 'output')}"
    return f"{result.name}  0 … {end_text} s, {count_text(len(result.impacts), 'impact')}, {rows_text}"


def impact_heads(result: Recording) -> tuple[str, ...]:
    """Return the heads of the columns of ``impact_cells``, with units.

    Impacts at stops of joints have other units. If the list has impacts with both kinds of units, or has the
    two columns of loads, the heads have several lines, so that a row fits into 80 characters.
    """
    is_at_stop = result.is_at_joint_stop
    has_walls, has_stops = not is_at_stop.all(), bool(is_at_stop.any())
    kinds = [COLUMN_UNITS] * has_walls + [STOP_COLUMN_UNITS] * has_stops
    units = [
        " or ".join(dict.fromkeys(column_units))
        for column_units in zip(*(kinds or [COLUMN_UNITS]), strict=True)
    ]
    value_heads = (f"{name}, {unit}" for name, unit in zip(VALUE_COLUMNS, units, strict=True))
    heads = ("time, s", "point", "wall", *value_heads)
    loads = ("joint force, N", "joint") if result.knows_joint_forces else ()
    if not loads and len(kinds) <= 1:
        return heads
    lines = (
        head.replace(", ", " ").replace(" ", "\n").replace("\nor\n", " or\n") for head in (*heads, *loads)
    )
    return tuple(line.replace("duration", "dura-\ntion") for line in lines)


def impact_cells(result: Recording, impact: np.void) -> tuple[str, ...]:
    """Return the texts for an impact: time, point, wall, speed, duration, peak force, impulse.

    If forces in joints are known, two more cells have the largest force in any joint, and this joint.
    """
    point = result.touching_part(impact).removeprefix("point ")
    speed_text, duration_text = f"{impact['impact_speed']:.4f}", _peak_text(1e3 * impact["duration"])
    duration_text = LASTING_TEXT if lasts_to_end(impact) else duration_text
    values = (
        speed_text,
        duration_text,
        _peak_text(impact["peak_force"]),
        four_digits_text(impact["impulse"]),
    )
    joint = (_peak_text(impact["joint_force"]), str(impact["joint"] or NO_NUMBER))
    loads = joint if result.knows_joint_forces else ()
    return (f"{impact['onset']:.6f}", point, result.wall_names[impact["wall"]], *values, *loads)


def _peak_text(value: float) -> str:
    """Return the text of a peak force or a duration; a dash if it is unknown or, as at a rigid wall, 0."""
    return four_digits_text(value) if value else NO_NUMBER


def four_digits_text(value: float) -> str:
    """Return a number rounded to four digits, from 1e-4 to a million without exponent; a dash for NaN."""
    if np.isnan(value):
        return NO_NUMBER
    text = f"{value:.4g}"
    return f"{float(text):.0f}" if FIVE_DIGITS <= abs(float(text)) < MILLION else text


def load_lines(result: Recording) -> Iterator[str]:
    """Yield lines with the largest force in each joint, if it is known between rows, in descending order.

    Each line has the time of the force, and the numbers of the impacts that last at this time; or only the
    time of a row, if the force is known to have occurred by this row. With more than MOST_LISTED_JOINTS such
    joints, the last line tells the number of the joints with smaller forces.
    """
    peaks = [peak for peak in joint_peaks(result) if peak.kind != SAMPLED_PEAK]
    for row, (joint, force, time, kind) in enumerate(peaks[:MOST_LISTED_JOINTS]):
        beginning = f"{'' if row else 'loads':8} at most {force:.6g} N in joint[{joint}]"
        if kind != EXACT_PEAK:
            yield f"{beginning}, by {time:g} s"
            continue
        onset = result.impacts["onset"]
        end = np.where(lasts_to_end(result.impacts), np.inf, result.impacts["end"])
        numbers = [str(n + 1) for n in ((onset <= time) & (time <= end) & (onset < end)).nonzero()[0]]
        during_text = (
            f", during impact{'s' * (len(numbers) > 1)} {names_text(numbers, NAMED_IMPACTS)}"
            if numbers
            else ""
        )
        yield f"{beginning}, at {time:.6f} s{during_text}"
    if len(peaks) > MOST_LISTED_JOINTS:
        yield f"{'':8} less in {count_text(len(peaks) - MOST_LISTED_JOINTS, 'more joint')}"


def _friction_lines(result: Recording) -> Iterator[str]:
    """Yield a line on the phases of dry friction, if any, and a line on what sticks at the end, if any."""
    phases = result.stick_slip
    if not len(phases):
        return
    sticking = int((phases["mode"] == STICKS).sum())
    yield f"friction {count_text(sticking, 'phase')} of sticking, {len(phases) - sticking} of sliding"
    last = phases[np.isnan(phases["end"]) & (phases["mode"] == STICKS)]
    elements = [
        f"{element_label(phase, result.wall_names, result.point_names)} since {phase['start']:.6f} s"
        for phase in last
    ]
    if elements:
        more_texts = [f"{len(elements) - NAMED_STICKING} more"] if len(elements) > NAMED_STICKING else []
        yield f"{'':9}sticks at the end: {', '.join([*elements[:NAMED_STICKING], *more_texts])}"


def solver_lines(counts: Mapping[str, int]) -> Iterator[str]:
    """Yield two lines: how many steps and evaluations the solver needed, and the status of the run."""
    steps_text = f"{counts['steps']} steps, of which {counts['implicit_steps']} implicit"
    yield f"solver   {steps_text}; {counts['rhs_evaluations']} evaluations of the equations of motion"
    status = counts["status"]
    yield f"status   {status}: {'done' if status == OK else STATUS_TEXT[status]}"


def penetration_hints(scene: Scene, impacts: np.ndarray) -> list[str]:
    """Return one sentence, in a list, if a penetration is larger than ``BodySize.deep`` of the smallest body.

    The sentence names the wall, or the stop of a slider, with the deepest penetration, which is too soft
    for the motion. Stops of joints do not count. If no penetration is so large, the list is empty.
    """
    walls = [number for number in range(len(scene.wall_names)) if not is_scene_joint_stop(scene, number)]
    depths = np.where(np.isin(impacts["wall"], walls), impacts["max_penetration"], 0.0)
    body = smallest_body(scene)
    if depths.max(initial=0.0) <= body.deep:
        return []
    wall = scene.wall_names[impacts["wall"][depths.argmax()]]
    material = scene.contact.wall.get(wall)
    given_stiffness = material.stiffness if material else None
    name, stiffness = (
        ("contact", scene.contact.stiffness) if given_stiffness is None else (f"wall.{wall}", given_stiffness)
    )
    unit = stiffness_unit("N/m", scene.contact.exponent)
    return [
        f"a point goes {depths.max():.3g} m beyond {wall}, and {body.name} is {body.size:g} m: "
        f"{name}.stiffness = {stiffness:g} [{unit}] is small for this motion"
    ]


class BodySize(NamedTuple):
    """A body of the scene.

    Attributes:
        name: words for the size.
        size: the size [m].
        deep: a larger penetration [m] is probably a mistake, because the stiffness is too small.
    """

    name: str
    size: float
    deep: float


def smallest_body(scene: Scene) -> BodySize:
    """Return the smallest body: the shortest link, or a ball with its radius as the size.

    A free chain of one link is a ball if its centre of mass is at an end, and only this end touches. The
    length of this link has no meaning. A ball without a radius counts as infinitely large, so that it is
    never the reason of a hint.
    """
    link = min(scene.chain.links, key=lambda item: item.length)
    ends = {0.0: 0, link.length: 1}
    centre = ends.get(link.center_of_mass) if link.center_of_mass_offset == 0.0 else None
    is_free_link = scene.chain.base == "free" and len(scene.chain.links) == 1
    if is_free_link and scene.touching_points == (centre,):
        radius = scene.contact.radius or np.inf
        return BodySize("the radius of the ball", radius, radius)  # a soft ball may go as deep as its radius
    return BodySize("the length of the shortest link", link.length, DEEP_PENETRATION * link.length)
