"""Panels over time: the energies, dry friction, and the colours of time; lines at impacts in such panels."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.transforms import Bbox

from chain_impact.kernel.forces.friction import STICKS
from chain_impact.pictures.bands import MOST_GREY, fill_band, hides, plot_curves
from chain_impact.pictures.dark import OCHRE
from chain_impact.pictures.legends import legend_above
from chain_impact.pictures.message import time_unit
from chain_impact.pictures.names import short_names
from chain_impact.pictures.rest import shade_rests, shown_time
from chain_impact.pictures.style import (
    BLACK,
    BLUE,
    BROWN,
    GREEN,
    GREY,
    INK,
    LINE,
    PURPLE,
    TIME_COLOURS,
    VIOLET,
    faint,
    give_ticks,
    is_full,
    scale_numbers,
)
from chain_impact.recording.recording import Recording
from chain_impact.recording.stick_slip import element_label

# The curve of an energy is dashed if, in at least the part MOSTLY of all rows, it differs from an earlier
# curve by at most ALIKE, relative to the range of all curves. The curve of the total energy does not count.
ALIKE, MOSTLY = 0.03, 0.8
# the zero of the potential energy is moved if the range of all energies (``range_of``) is then smaller than
# this, relative to the range with the usual zero
CLOSER = 0.8
ENERGY_PARTS = {"friction": BROWN}
"""Name of an energy that is a part of another one → colour; ``friction`` is a part of ``dissipated``."""
PART_LABEL = "{} loss"  # the label of an energy in ENERGY_PARTS; {}: the name of this energy
ENERGIES = {
    "kinetic": GREEN,
    "potential": OCHRE,
    "elastic": BLUE,
    "total": BLACK,
    "dissipated": VIOLET,
    **ENERGY_PARTS,
    "supplied": PURPLE,
}
"""Name of an energy → its colour in all pictures."""
# the elastic energy is drawn if its largest value exceeds this, relative to the range of all energies
VISIBLE_ELASTIC = 0.01
# Energies whose |values| are all less than this, relative to the largest |value| of any energy, look like one
# line at 0; more than MOST_GREY such energies are drawn as a band.
TINY = 0.05
CLOCK_HEIGHT = 0.045  # [inch] the height of the bar with the colours of time
# the height of a bar that shows sticking, and of a name above its bars, relative to the distance of two rows
PHASE_HEIGHT, NAME_HEIGHT = 0.3, 0.48
MOST_ROWS = 8  # at most so many contacts, joints and sliders together have phases of dry friction drawn
# sliding that lasts at most this part of the run's duration is too short to be explained in a legend
SHORT = 0.002
TIME_MARGIN = 0.015  # the margin at both ends of an axis of time, relative to the shown time


def draw_clock(axes: Axes, recording: Recording) -> None:
    """Draw a bar with the colour of each time in the panel of the motion, above the label of the time."""
    shown = shown_time(recording)
    start, end = shown.start, max(shown.end, shown.start + 1e-9)
    axes.set_axes_locator(_slim)
    axes.imshow(np.linspace([0.0], [1.0], 256).T, TIME_COLOURS, aspect="auto", extent=(start, end, 0, 1))
    label_time(axes, recording, "the same colours as in the motion" if is_full(axes) else "")
    axes.set_yticks([])
    axes.spines[:].set_visible(False)
    axes.tick_params(bottom=False, labelbottom=False)  # the panel above already has the numbers of this axis
    give_ticks(axes)


def _slim(axes: Any, _: Any) -> Bbox:
    """Return the box of the axes of ``draw_clock``: upper edge and width stay, the height is CLOCK_HEIGHT."""
    figure, place = axes.get_figure(root=True), axes.get_position(original=True)
    assert figure is not None
    return Bbox([[place.x0, place.y1 - CLOCK_HEIGHT / figure.get_figheight()], [place.x1, place.y1]])


def label_time(axes: Axes, recording: Recording, note: str = "") -> None:
    """Give the x axis the label and the limits of the shown time.

    The label also has words on a rest that is shaded or cut off; without a rest, the label has the ``note``.
    """
    shown = shown_time(recording)
    margin = TIME_MARGIN * max(shown.end - shown.start, 1e-9)
    axes.set(
        xlabel="; ".join(filter(None, (name_time(axes, shown.end), shown.note or note))),
        xlim=(shown.start - margin, shown.end + margin),
    )


def name_time(axes: Axes, end: float) -> str:
    """Return the name of an x axis of time up to ``end`` [s], with the unit that the numbers get here."""
    factor, unit = time_unit(end)
    scale_numbers(axes.xaxis, factor)
    return f"time [{unit}]"


def draw_energy(axes: Axes, recording: Recording) -> None:
    """Draw the energies over time, with lines at impacts; small energies (``tiny_curves``) as a band."""
    mark_impacts(axes, recording)
    time, curves = recording.detailed_energies[0], energy_curves(recording)
    tiny = tiny_curves(curves)
    plot_curves(axes, time, [curve for k, curve in enumerate(curves) if k not in tiny])
    if tiny:
        values = [curves[k][0] for k in tiny]
        names = ", ".join(curves[k][1]["label"] for k in tiny)
        fill_band(axes, time, values, f"{names}: ≤ {np.abs(values).max():.2g} J")
    axes.set_ylabel("energy [J]")
    over_all_time(axes, recording)
    legend_above(axes)


def energy_curves(recording: Recording) -> list[tuple[np.ndarray, dict[str, Any]]]:
    """Return a curve for each energy to draw: values, shape (T,), and properties with matplotlib's names.

    The values are those of ``recording.detailed_energies``, but ``without_gap`` may have added a number [J]
    to the potential and the total energy. If so, the labels of these two energies tell the number. The curve
    of the total energy is wide and behind other curves. Another curve is dashed if it would hide an earlier
    curve, or if its energy is in ENERGY_PARTS.
    """
    shown, offset = shown_energies(recording)
    if "elastic" in shown and not shown["elastic"].max() > VISIBLE_ELASTIC * range_of(shown):
        del shown["elastic"]
    others = [name for name in shown if name != "total"]
    hidden = hides([shown[name] for name in others], ALIKE, MOSTLY)
    is_dashed = {name: name in ENERGY_PARTS or count > 0 for name, count in zip(others, hidden, strict=True)}
    return [
        (energy, part_look(name, offset) | {"linestyle": "--" if is_dashed.get(name) else "-"})
        for name, energy in shown.items()
    ]


def shown_energies(recording: Recording) -> tuple[dict[str, np.ndarray], float]:
    """Return the energies of a picture, and the number [J] added to the potential and total energies.

    The number is that of ``without_gap``. Elastic energy, supplied energy, and energies in ENERGY_PARTS are
    left out if they are always 0. Each energy has the shape (T,) [J].
    """
    time, energies = recording.detailed_energies
    known = {name: energies.get(name, np.zeros(len(time))) for name in ENERGIES}
    rare = ("elastic", "supplied", *ENERGY_PARTS)
    return without_gap({name: energy for name, energy in known.items() if energy.any() or name not in rare})


def tiny_curves(curves: Sequence[tuple[np.ndarray, dict[str, Any]]]) -> list[int]:
    """Return the indices of the energy curves that are so small (TINY) that they look like one line at 0.

    If there are at most MOST_GREY such curves, the list is empty. Energies in ENERGY_PARTS do not count as
    small.
    """
    sizes = [float(np.abs(values).max(initial=0.0)) for values, _ in curves]
    parts = {PART_LABEL.format(name) for name in ENERGY_PARTS}
    is_part = [look["label"] in parts for _, look in curves]
    tiny = [k for k, size in enumerate(sizes) if size < TINY * max(sizes) and not is_part[k]]
    return tiny if len(tiny) > MOST_GREY else []


def without_gap(energies: dict[str, np.ndarray]) -> tuple[dict[str, np.ndarray], float]:
    """Return energies for a picture, and the number [J] that is added to the potential and total energies.

    The zero of the potential energy is arbitrary, so the curve of this energy may lie far from other curves.
    If the gap would take much of the axis (CLOSER), the number moves the least potential energy near 0; the
    number has two significant digits. Otherwise the number is 0, and no energy changes.
    """
    potential = energies.get("potential", np.zeros(1))
    least = float(potential.min())
    if least == 0.0 or not math.isfinite(least):
        return energies, 0.0
    step = 10.0 ** (math.floor(math.log10(abs(least))) - 1)
    offset = math.ceil(round(-least / step, 6)) * step
    shifted = {
        name: energy + offset if name in ("potential", "total") else energy
        for name, energy in energies.items()
    }
    return (shifted, offset) if range_of(shifted) < CLOSER * range_of(energies) else (energies, 0.0)


def range_of(energies: dict[str, np.ndarray]) -> float:
    """Return the size [J] of the range that contains all energies and 0."""
    ends = (end(energy) for energy in energies.values() for end in (np.min, np.max))
    return float(np.ptp([0.0, *ends]))


def offset_text(offset: float) -> str:
    """Return the number ``offset`` [J], which is added to an energy, as text: "+ 22 J", "− 22 J"."""
    return f"{'+' if offset > 0.0 else '−'} {abs(offset):.10g} J"


def energy_look(name: str, offset: float = 0.0) -> dict[str, Any]:
    """Return the properties of the curve of the energy ``name``, with matplotlib's names.

    ``offset`` is the number [J] from ``without_gap``, which the labels of potential and total energy tell
    unless it is 0.
    """
    is_total, label = name == "total", name
    if offset and name in ("potential", "total"):
        label = f"{name} {offset_text(offset)}"
    return {
        "color": ENERGIES[name],
        "label": label,
        "linewidth": 1 + is_total,
        "zorder": 2.0 - 0.1 * is_total,
    }


def part_look(name: str, offset: float = 0.0) -> dict[str, Any]:
    """Return ``energy_look``, but with dashes and PART_LABEL for an energy in ENERGY_PARTS."""
    part = {"label": PART_LABEL.format(name), "linestyle": "--"} if name in ENERGY_PARTS else {}
    return energy_look(name, offset) | part


def over_all_time(axes: Axes, recording: Recording) -> None:
    """Shade the times in which nothing moves, and give ``axes`` enough numbers along x and y."""
    shade_rests(axes, shown_time(recording))
    give_ticks(axes)


def draw_stick_slip(axes: Axes, recording: Recording) -> None:
    """Draw phases of dry friction: a bar while a contact, joint or slider sticks, a line while it slides.

    Each contact, joint or slider has a row; only the first MOST_ROWS of ``rubbing_places`` are drawn.
    """
    phases, shown = recording.stick_slip, sorted(rubbing_places(recording)[:MOST_ROWS], reverse=True)
    for phase, length in zip(phases, phase_lengths(recording), strict=True):
        if (location := element_label(phase, recording.wall_names, recording.point_names)) in shown:
            row, sticks = shown.index(location), phase["mode"] == STICKS
            colour, height = (INK, PHASE_HEIGHT) if sticks else (GREY, 0.3 * PHASE_HEIGHT)
            axes.barh(row, length, height, left=phase["start"], color=colour)
    # a name stands above its bars, so that a long name takes no width from the panels
    rows = [row + NAME_HEIGHT for row in range(len(shown))]
    names = [short_names(recording, location) for location in shown]
    axes.set_yticks(rows, names, fontsize="small", ha="left", va="center")
    axes.set_ylim(-0.4, len(shown) - 0.25)
    axes.tick_params(axis="y", length=0, pad=-1.0)
    axes.spines["left"].set_visible(False)
    held = phases["mode"] == STICKS
    handles: list[Any] = [Patch(color=INK, label="sticks")] if held.any() else []
    # a contact slides for an instant before it sticks; phases that cannot be seen get no entry in the legend
    long = phase_lengths(recording) > SHORT * (recording.time[-1] - recording.time[0])
    if (long & ~held).any() or not handles:
        handles.append(Line2D([], [], color=GREY, linewidth=2.0, label="slides"))
    legend_above(axes, handles)
    shade_rests(axes, shown_time(recording))


def phase_lengths(recording: Recording) -> np.ndarray:
    """Return the duration of each phase of dry friction up to the end of the recording, shape (F,) [s]."""
    phases = recording.stick_slip
    ends = np.where(np.isnan(phases["end"]), recording.time[-1], phases["end"])
    return np.asarray(ends - phases["start"])


def rubbing_places(recording: Recording) -> list[str]:
    """Return words for each contact, joint or slider with phases of dry friction.

    The order is by the sum of the durations of all phases, of sticking and of sliding, the largest sum first.
    """
    total: dict[str, float] = {}
    for phase, length in zip(recording.stick_slip, phase_lengths(recording), strict=True):
        location = element_label(phase, recording.wall_names, recording.point_names)
        total[location] = total.get(location, 0.0) + float(length)
    return sorted(total, key=lambda location: -total[location])


def mark_impacts(axes: Axes, recording: Recording, start: float = 0.0, factor: float = 1.0) -> None:
    """Draw a vertical line at the onset of each impact.

    ``start`` is the time [s] at the position 0 of the axis; ``factor`` is the factor from seconds to the unit
    of the axis.
    """
    onsets = factor * (recording.impacts["onset"] - start)
    axes.vlines(
        onsets, 0.0, 1.0, faint(axes, LINE), linewidth=0.8, zorder=0, transform=axes.get_xaxis_transform()
    )


def impact_lines(recording: Recording, start: float, end: float, more: str = "") -> str:
    """Return words that explain the lines of ``mark_impacts`` between two times [s]; "" without such lines.

    The words end with ``more``.
    """
    onsets = recording.impacts["onset"]
    return f"grey: impacts{more}" if ((onsets >= start) & (onsets <= end)).any() else ""
