"""The panel of the energies over time.

The twin in JavaScript is pages/browser/charts/energy_zero.js.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from chain_impact.pictures.drawing.colours import BLACK, BLUE, BROWN, GREEN, PURPLE, VIOLET
from chain_impact.pictures.drawing.dark_ground import OCHRE
from chain_impact.pictures.drawing.distinct_curves import MOST_GREY, SAME_CURVE, draw_band, plot_curves
from chain_impact.pictures.drawing.legends import legend_above
from chain_impact.pictures.over_time.time_axis import has_impact_key, show_all_time, tick_impacts
from chain_impact.recording.recording import Recording

# the zero of the potential energy is moved if the move makes the range of all energies (``range_of``) smaller
# than this part of the range with the usual zero
RANGE_SHARE = 0.8
# Name of an energy that is a part of another one → colour; ``friction`` is a part of ``dissipated``.
ENERGY_PARTS = {"friction": BROWN}
PART_LABEL = "{} loss"  # the label of an energy in ENERGY_PARTS; {}: the name of this energy
# Name of an energy → its colour in all pictures.
ENERGIES = {
    "kinetic": GREEN,
    "potential": OCHRE,
    "elastic": BLUE,
    "total": BLACK,
    "dissipated": VIOLET,
    **ENERGY_PARTS,
    "supplied": PURPLE,
}
# Name of an energy → its dashes in all pictures, by which readers distinguish energies without colours.
# Other energies have solid lines, from whose narrow peaks dashes would leave pieces.
ENERGY_DASHES: dict[str, Any] = {
    "potential": (0.0, (1.0, 0.8)),
    "dissipated": (0.0, (2.8, 1.0)),
    "friction": (0.0, (2.4, 0.9, 0.9, 0.9)),
    "supplied": (0.0, (6.0, 1.2, 1.2, 1.2)),
}
# Name of an energy → width of its line [points], where it differs from 1.
ENERGY_WIDTHS = {"total": 2.0, "kinetic": 1.3, "potential": 1.3, "elastic": 0.8}
# the elastic energy is drawn if its largest value exceeds this, relative to the range of 0 and all energies
VISIBLE_ELASTIC = 0.01
# An energy whose |values| are all less than this, relative to the largest |value| of any energy, looks like a
# line at 0; more than MOST_GREY of these energies are drawn as a band (``tiny_curves``).
TINY_ENERGY = 0.05


def draw_energy(axes: Axes, recording: Recording) -> None:
    """Draw the energies over time; small energies (``tiny_curves``) as a band.

    Marks at impacts are drawn if the legend has an entry for them (``add_impact_key``).
    """
    time, curves = recording.detailed_energies[0], energy_curves(recording)
    tiny_indices = tiny_curves(curves)
    plot_curves(axes, time, [curve for k, curve in enumerate(curves) if k not in tiny_indices])
    if tiny_indices:
        values = [curves[k][0] for k in tiny_indices]
        names_text = ", ".join(curves[k][1]["label"] for k in tiny_indices)
        draw_band(axes, time, values, f"{names_text}: ≤ {np.abs(values).max():.2g} J")
    axes.set_ylabel("energy [J]")
    if has_impact_key(axes):
        tick_impacts(axes, recording)
    show_all_time(axes, recording)
    legend_above(axes)


def energy_curves(recording: Recording) -> list[tuple[np.ndarray, dict[str, Any]]]:
    """Return a curve for each energy to draw: values, shape (T,), and properties with matplotlib's names.

    The values are those of ``recording.detailed_energies``, but ``without_gap`` may have added a number [J]
    to the potential and the total energy. If so, the labels of these two energies tell the number. The curve
    of the total energy is wide, and behind other curves. A small elastic energy (VISIBLE_ELASTIC) has no
    curve. Nor has a friction loss or a supplied energy that nearly equals the dissipated energy; the label of
    the dissipated energy names it.
    """
    shown_curves, offset = shown_energies(recording)
    if "elastic" in shown_curves and not shown_curves["elastic"].max() > VISIBLE_ELASTIC * range_of(
        shown_curves
    ):
        del shown_curves["elastic"]
    looks = {name: part_look(name, offset) for name in shown_curves}
    least_gap = SAME_CURVE * range_of(shown_curves)
    for name in ("supplied", *ENERGY_PARTS):
        if name in looks and np.abs(shown_curves[name] - shown_curves["dissipated"]).max() <= least_gap:
            looks["dissipated"]["label"] += f" = {looks.pop(name)['label']}"
    return [(shown_curves[name], look) for name, look in looks.items()]


def shown_energies(recording: Recording) -> tuple[dict[str, np.ndarray], float]:
    """Return the energies of a picture, and the number [J] added to the potential and total energies.

    The number is that of ``without_gap``. Elastic energy, supplied energy, and energies in ENERGY_PARTS are
    left out if they are always 0. Each energy has the shape (T,) [J].
    """
    time, energies = recording.detailed_energies
    known_energies = {name: energies.get(name, np.zeros(len(time))) for name in ENERGIES}
    rare = ("elastic", "supplied", *ENERGY_PARTS)
    return without_gap(
        {name: energy for name, energy in known_energies.items() if energy.any() or name not in rare}
    )


def tiny_curves(curves: Sequence[tuple[np.ndarray, dict[str, Any]]]) -> list[int]:
    """Return the indices of the curves of energies so small (TINY_ENERGY) that they look like a line at 0.

    If there are at most MOST_GREY such curves, the list is empty. Energies in ENERGY_PARTS do not count as
    small.
    """
    sizes = [float(np.abs(values).max(initial=0.0)) for values, _ in curves]
    parts = {PART_LABEL.format(name) for name in ENERGY_PARTS}
    is_part = [look["label"] in parts for _, look in curves]
    tiny_indices = [k for k, size in enumerate(sizes) if size < TINY_ENERGY * max(sizes) and not is_part[k]]
    return tiny_indices if len(tiny_indices) > MOST_GREY else []


def without_gap(energies: dict[str, np.ndarray]) -> tuple[dict[str, np.ndarray], float]:
    """Return energies for a picture, and the number [J] that is added to the potential and total energies.

    The zero of the potential energy is arbitrary, so the curve of this energy may lie far from other curves.
    If the gap would take much of the axis (RANGE_SHARE), the number moves the least potential energy near 0;
    the number has two significant digits. Otherwise the number is 0, and no energy changes.
    """
    potential = energies.get("potential", np.zeros(1))
    least_potential = float(potential.min())
    if least_potential == 0.0 or not math.isfinite(least_potential):
        return energies, 0.0
    step = 10.0 ** (math.floor(math.log10(abs(least_potential))) - 1)
    offset = math.ceil(round(-least_potential / step, 6)) * step
    shifted = {
        name: energy + offset if name in ("potential", "total") else energy
        for name, energy in energies.items()
    }
    return (shifted, offset) if range_of(shifted) < RANGE_SHARE * range_of(energies) else (energies, 0.0)


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
    label = name
    if offset and name in ("potential", "total"):
        label = f"{name} {offset_text(offset)}"
    return {
        "color": ENERGIES[name],
        "label": label,
        "linestyle": ENERGY_DASHES.get(name, "-"),
        "linewidth": ENERGY_WIDTHS.get(name, 1.0),
        "zorder": 2.0 - 0.1 * (name == "total"),
    }


def part_look(name: str, offset: float = 0.0) -> dict[str, Any]:
    """Return ``energy_look``, but with PART_LABEL for an energy in ENERGY_PARTS."""
    part = {"label": PART_LABEL.format(name)} if name in ENERGY_PARTS else {}
    return energy_look(name, offset) | part
