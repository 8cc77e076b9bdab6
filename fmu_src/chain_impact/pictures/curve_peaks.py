"""The largest values of curves: at the curves of forces, moments and impulses, and in the headline."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np

from chain_impact.pictures.drawing.axis_numbers import force_text
from chain_impact.pictures.drawing.labels import Label
from chain_impact.pictures.texts.headline import Peak, largest_peaks
from chain_impact.recording.curves import Curves
from chain_impact.recording.recording import Recording
from chain_impact.scene.texts.unit_text import unit_text

AMOUNT_WIDTH = 1.2  # [points] the width of the line of a force's amount
# The units of curves whose largest values are written → quantity.
MARKED_UNITS = {"N": "force", "N.m": "moment", "N.s": "impulse"}
# a number stands at the inner side of its curve if another curve is nearer at the outer side, and nearer than
# this, relative to the range of all curves in the panel
LABEL_DISTANCE = 0.15
# the largest value of a curve is that of an impact if the two differ by at most this, relative to the second
SAME_VALUE = 0.01


def drawn_peaks(recording: Recording, curves: Curves) -> list[Peak]:
    """Return those of ``largest_peaks`` whose force or moment has a curve."""
    labels = []
    for peak in largest_peaks(recording):
        output = output_of_contact(recording, recording.impacts[peak.row])
        if peak.name.startswith("peak") and output in curves.values:
            labels.append(peak)
    return labels


def output_of_contact(recording: Recording, impact: np.void) -> str:
    """Return the output with the force or moment of the contact in ``impact``, a row of ``impacts``."""
    point, wall = impact["point"], recording.wall_names[impact["wall"]]
    is_stop = recording.is_joint_stop(impact["wall"])
    return f"joint[{point}].stop_moment" if is_stop else f"contact[{point}].{wall}.force"


def peaks_of_contacts(recording: Recording) -> dict[str, list[float]]:
    """Return output → the peaks of all its impacts [N], [N·m], for normal forces and moments of stops."""
    found_peaks: dict[str, list[float]] = {}
    for impact in recording.impacts:
        found_peaks.setdefault(output_of_contact(recording, impact), []).append(float(impact["peak_force"]))
    return found_peaks


def largest_drawn(curves: Curves) -> str:
    """Return words for the largest |value| of all curves of forces: "contact[4].y_min.force reaches 7.48 kN".

    The result is "" without a ``largest_force``.
    """
    name, size = largest_force(curves)
    if not name:
        return ""
    unit = next(curves.units[output] for output in curves.values if output.startswith(name.strip("|")))
    return f"{name} reaches {force_text(float(size[largest_row(size)]), unit_text(unit))}"


def largest_force(curves: Curves) -> tuple[str, np.ndarray]:
    """Return the name and the |values| over time of the curve of a force with the largest |value|.

    If no force has a curve with a value other than 0, the result is the curve of a moment or else of an
    impulse. The components x and y of a force also count as one force: "|joint[1].force|". If no such curve
    has a value other than 0, the name is "" and the array empty.
    """
    for unit in MARKED_UNITS:
        names = [name for name in curves.values if curves.units.get(name) == unit]
        sizes = {name: np.abs(curves.values[name]) for name in names}
        sizes |= {f"|{owner}.force|": size for owner, size in amounts(curves, names).items()}
        peak_sizes = {
            name: size[row] for name, size in sizes.items() if (row := largest_row(size)) is not None
        }
        if peak_sizes:
            name = max(peak_sizes, key=lambda candidate: peak_sizes[candidate])
            return name, sizes[name]
    return "", np.zeros(0)


def extremes(
    time: np.ndarray,
    lines: Sequence[tuple[np.ndarray, dict[str, Any]]],
    unit: str,
    scale: float,
    known_peaks: Mapping[str, Sequence[float]] = MappingProxyType({}),
) -> list[Label]:
    """Return a label for each curve of a force, moment or impulse, at its value farthest from 0.

    The label of the largest |value| is first. A curve without a value other than 0 has no label; if ``unit``
    is not in MARKED_UNITS, there are no labels. A label stands at the side of its curve away from 0 or, if
    another curve is near there (LABEL_DISTANCE) and nearer than at the other side, at the other side, so that
    it does not read as the number of the other curve.

    Args:
        time: the times in the unit of the axis, shape (T,).
        lines: for each curve its values in ``unit``, shape (T,), and its properties with matplotlib's names.
        unit: the unit of all values.
        scale: the factor from values to the numbers of the axis.
        known_peaks: label of a curve → the peaks of impacts [``unit``]; a peak replaces the curve's largest
            value if it is the same but for the distance of rows (SAME_VALUE).
    """
    sized_labels = []
    label_distance = LABEL_DISTANCE * float(np.ptp(_finite_values(lines)))
    for k, (values, style) in enumerate(lines if unit in MARKED_UNITS else ()):
        if (row := largest_row(np.abs(values))) is not None:
            value = float(values[row])
            outwards = math.copysign(1.0, value)
            ways = outwards * np.array(
                [other_values[row] - value for n, (other_values, _) in enumerate(lines) if n != k]
            )
            outer = float(ways[ways >= 0.0].min(initial=math.inf))
            inner_distance = float(-ways[ways < 0.0].max(initial=-math.inf))
            if outer < min(label_distance, inner_distance):
                outwards = -outwards
            same_peaks = (
                peak
                for peak in known_peaks.get(style.get("label", ""), ())
                if abs(peak - abs(value)) <= SAME_VALUE * peak
            )
            size = max(same_peaks, default=abs(value))
            text = f"{'−' * (value < 0.0)}{force_text(size, unit_text(unit))}"
            look, position = {"color": style["color"]}, (float(time[row]), scale * value)
            sized_labels.append(
                (abs(value), Label(text, position, (0.0, outwards), look=look, is_on_side=True))
            )
    return [label for _, label in sorted(sized_labels, key=lambda entry: -entry[0])]


def _finite_values(lines: Sequence[tuple[np.ndarray, dict[str, Any]]]) -> np.ndarray:
    """Return all finite values of some curves and 0, in one array."""
    all_values = np.concatenate([np.zeros(1), *(values for values, _ in lines)])
    return np.asarray(all_values[np.isfinite(all_values)])


def largest_row(sizes: np.ndarray) -> int | None:
    """Return the row of the largest finite size, or None if no size is finite and above 0."""
    finite_sizes = np.where(np.isfinite(sizes), sizes, 0.0)
    return int(finite_sizes.argmax()) if finite_sizes.any() else None


def largest_vectors(curves: Curves) -> str:
    """Return words for the largest amounts of the forces whose components x and y both have a curve.

    For example "largest |force|: joint[1] 636 N and joint[2] 670 N at 0.75 ms"; "" without such a force. The
    times are those of the run [s] or, in a view of one impact, those after the onset [ms].
    """
    start, factor, unit = (0.0, 1.0, "s") if curves.onset is None else (curves.onset, 1e3, "ms")
    texts_at_time: dict[str, list[str]] = {}
    for owner, sizes in amounts(curves, [name for names in curves.panels for name in names]).items():
        if (row := largest_row(sizes)) is not None:
            time_text = f"{factor * (curves.time[row] - start):.3g} {unit}"
            texts_at_time.setdefault(time_text, []).append(f"{owner} {force_text(float(sizes[row]), 'N')}")
    parts = [f"{' and '.join(outputs)} at {time_text}" for time_text, outputs in texts_at_time.items()]
    return f"largest |force|: {', '.join(parts)}" if parts else ""


def amount_lines(
    curves: Curves, lines: Mapping[str, tuple[np.ndarray, dict[str, Any]]]
) -> dict[str, tuple[np.ndarray, dict[str, Any]]]:
    """Return a dotted line for each of ``amounts``: owner → values and properties with matplotlib's names.

    ``lines`` are the curves of the panel: output → values and properties.
    """
    return {
        owner: (
            sizes,
            {
                "color": lines[f"{owner}.force.x"][1]["color"],
                "linestyle": ":",
                "linewidth": AMOUNT_WIDTH,
                "label": f"|{owner}.force|",
            },
        )
        for owner, sizes in amounts(curves, list(lines)).items()
    }


def amounts(curves: Curves, names: Sequence[str]) -> dict[str, np.ndarray]:
    """Return the amounts of the forces with both components in ``names``: owner → amounts, shape (T,) [N]."""
    ends = (".force.x", ".force.y")
    pairs = {name.removesuffix(ends[0]): name for name in names if name.endswith(ends[0])}
    return {
        owner: np.hypot(curves.values[name], curves.values[owner + ends[1]])
        for owner, name in pairs.items()
        if owner + ends[1] in names
    }
