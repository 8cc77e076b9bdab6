"""The words, units and changes of the curves of outputs: what a panel shows, and the axis that it needs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from chain_impact.pictures.curve_looks import shared_part
from chain_impact.pictures.curve_peaks import MARKED_UNITS
from chain_impact.pictures.drawing.axis_numbers import load_unit
from chain_impact.recording.curves import Curves
from chain_impact.scene.texts.names import AXES
from chain_impact.scene.texts.unit_text import unit_text
from chain_impact.text import LOAD_UNITS

# unit that only one quantity has → name of this quantity, for the label of a panel
QUANTITIES = {"N": "force", "N.m": "moment", "N.s": "impulse", "J": "energy", "W": "power", "rad": "angle"}
# The last part of a component's name → the word for its vector.
VECTORS = {
    f"{letter}{axis}": word
    for letter, word in (("", "position"), ("v", "velocity"), ("a", "acceleration"))
    for axis in AXES
}
PREFIX_BELOW = 0.1  # [m] if all |values| of a panel are smaller, the unit m has a prefix, as in mm
SMALLEST_VALUE = 1e-6
# LITTLE_CHANGE: see ``values_at_onset``; CLOSE_UNITS: units that have a prefix in a close view, as in
# mrad
LITTLE_CHANGE, CLOSE_UNITS = 0.1, ("m", "rad", "m/s", "rad/s")


def quantity_text(names: Sequence[str], unit: str) -> str:
    """Return words for what the curves of a panel show: "angular velocity", "position x", "total energy".

    The result is "" if the names of the outputs, and the unit, tell no common quantity.
    """
    part = shared_part(names)
    if part in VECTORS:
        return f"{VECTORS[part]} {part[-1]}"
    if all(name.startswith("energy.") for name in names):
        return f"{part} energy".lstrip()
    if len(names) == 1 and "[" not in names[0]:
        part = names[0]
    return part.replace("_", " ").replace(".", " ") or QUANTITIES.get(unit) or vector_of(names)


def legend_texts(names: Sequence[str]) -> dict[str, str]:
    """Return the texts of a legend for the outputs of a panel: output → its name without the quantity.

    The label of the axis tells the quantity (``quantity_text``). So the text is "link[1]" for
    link[1].angular_velocity if all outputs are angular velocities, and "kinetic" for energy.kinetic if all
    are energies. If an output has no number in brackets, or the outputs have several quantities, all keep
    their names.
    """
    if len(names) > 1 and all(name.startswith("energy.") for name in names):
        return {name: name.removeprefix("energy.") for name in names}
    part = shared_part(names)
    is_brief = bool(part) and all("[" in name for name in names)
    return {name: name.removesuffix(f".{part}") if is_brief else name for name in names}


def values_at_onset(curves: Curves, names: Sequence[str]) -> dict[str, float]:
    """Return output → value at the onset for a panel that shows changes since the onset; else {}.

    A panel of a close view shows changes if each of its values changes by less than LITTLE_CHANGE, relative
    to the largest |value|, but not if its unit is in MARKED_UNITS, or a value is not finite.
    """
    if curves.onset is None or curves.units[names[0]] in MARKED_UNITS:
        return {}
    values = np.array([curves.values[name] for name in names])
    largest_value = float(np.abs(values).max(initial=0.0))
    if not np.isfinite(values).all() or not np.ptp(values, axis=-1).max() < LITTLE_CHANGE * largest_value:
        return {}
    return {name: float(np.interp(curves.onset, curves.time, curves.values[name])) for name in names}


def change_text(start: float, unit: str) -> str:
    """Return the end of the label of a curve that shows the change from the value ``start``: " − 1.86 m".

    The result is " + 1.86 m" for −1.86 m, and "" for a value that counts as 0 (SMALLEST_VALUE).
    """
    if abs(start) < SMALLEST_VALUE:
        return ""
    return f" {'−' if start > 0.0 else '+'} {abs(start):.3g} {unit_text(unit)}".rstrip()


def vector_of(names: Sequence[str]) -> str:
    """Return "position" if all names end in x or y, "velocity" if in vx or vy, "acceleration" if in ax or ay.

    Otherwise the result is "".
    """
    vector_names = {VECTORS.get(name.rpartition(".")[2], "") for name in names}
    return vector_names.pop() if len(vector_names) == 1 else ""


def axis_unit(unit: str, curves: Sequence[np.ndarray], *, is_close: bool = False) -> tuple[float, str]:
    """Return the factor from ``unit`` to an axis's unit for some curves, and the axis's unit: kN for 5000 N.

    Only units of forces, moments, impulses, energies and powers (LOAD_UNITS) get a prefix (``load_unit``),
    and the unit m if all |values| are below PREFIX_BELOW; if ``is_close``, the axis is that of a close
    view, and each unit in CLOSE_UNITS gets a prefix by the rule for m.
    """
    largest_value = max((float(np.nanmax(np.abs(curve), initial=0.0)) for curve in curves), default=0.0)
    has_prefix = unit in LOAD_UNITS or (unit == "m" and largest_value < PREFIX_BELOW)
    has_prefix |= is_close and unit in CLOSE_UNITS and largest_value < PREFIX_BELOW
    return load_unit(largest_value, unit) if has_prefix else (1.0, unit)
