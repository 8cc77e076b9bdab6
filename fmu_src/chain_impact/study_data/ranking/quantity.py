"""The quantities of a run by which parameters can be ranked: value, derivatives, and words for the place."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from chain_impact.recording.impacts import FMU_NAMES, POSITION
from chain_impact.recording.recording import Recording
from chain_impact.recording.sensitivity import Sensitivities, slopes_of_impacts
from chain_impact.scene.errors import SceneError
from chain_impact.scene.texts.names import name_parts
from chain_impact.scene.texts.similar_names import nearest_hint
from chain_impact.text import count_text
from chain_impact.variables.impact_units import impact_units
from chain_impact.variables.peaks import JOINT_FORCE, PEAKS

DURATION = "duration"  # the duration of an impact [s], from its onset to its end
COLUMN_OF_FMU_NAME = {name: column for column, name in FMU_NAMES.items()}
"""Name of a quantity in the FMU's ``impact[j]`` → its column in ``Result.impacts``."""


class RankedQuantity(NamedTuple):
    """A quantity of a run.

    Attributes:
        value: the value, in the ``unit``.
        unit: the unit.
        location_text: words for the impact, the joint or the time of the value.
        slopes: the derivatives of the value with respect to the P parameters of the run, shape (P,).
        size: the size, in the ``unit``, to which a change is compared: a change that is tiny beside this size
            is round-off.
        value_in: a function that returns the value in another run of the scene; NaN for a value of an impact
            that the other run does not have.
    """

    value: float
    unit: str
    location_text: str
    slopes: np.ndarray
    size: float
    value_in: Callable[[Recording], float]


def quantity_named(recording: Recording, sensitivities: Sensitivities, name: str) -> RankedQuantity:
    """Return the quantity with a name, as in ``Result.ranking``.

    Raises:
        SceneError: when the quantity does not exist, or the run does not have the quantity.
    """
    if peak := PEAKS.get(name):
        return _largest_of_impacts(recording, sensitivities, name, peak.field, at_stops=peak.at_stops)
    if name == JOINT_FORCE:
        return _joint_force(recording, sensitivities)
    owner, number, _, quantity = name_parts(name)
    if owner == "impact" and "[" in name:
        return _impact_quantity(recording, sensitivities, number, COLUMN_OF_FMU_NAME.get(quantity, quantity))
    if name not in sensitivities.columns:
        quantities = (*PEAKS, JOINT_FORCE, *sensitivities.columns)
        of_peak = re.sub(r"\w*$", r"peak_\g<0>", name, count=1)
        hint = nearest_hint(name, quantities, f"must be an output, {', '.join((*PEAKS, JOINT_FORCE))}")
        hint = f"the nearest is {of_peak}" if of_peak in quantities else hint
        if output_hint := recording.output_hint(of_peak):
            hint = f"the nearest is {of_peak}, and {output_hint}"
        raise SceneError(
            f"{recording.name}: {name} is not a quantity that can be ranked; {hint}, or impact[n].…"
        )
    return _final_output(recording, sensitivities, name)


def _largest_of_impacts(
    recording: Recording, sensitivities: Sensitivities, name: str, field: str, *, at_stops: bool
) -> RankedQuantity:
    """Return the largest value of a column of impacts, with its derivatives.

    If ``at_stops``, only the impacts at stops of joints count, else only those at walls and at stops of a
    slider.

    Raises:
        SceneError: when no value is above 0.
    """
    values = _values_of(recording, field, at_stops=at_stops)
    if not np.nanmax(values, initial=0.0) > 0.0:
        surface_text = "a stop of a joint" if at_stops else "a wall"
        hits = np.flatnonzero(np.isfinite(values)) + 1
        impulses_text = f" but by impulses: rank impact[{hits[0]}].impulse" if len(hits) else ""
        raise SceneError(
            f"{recording.name}: {name} is 0: nothing presses against {surface_text}{impulses_text}"
        )
    impact_quantity = _impact_quantity(recording, sensitivities, int(np.nanargmax(values)) + 1, field)
    return impact_quantity._replace(value_in=partial(_largest_in, field=field, at_stops=at_stops))


def _values_of(recording: Recording, field: str, *, at_stops: bool) -> np.ndarray:
    """Return a column of the impacts; NaN for impacts that do not count.

    With ``at_stops`` the impacts at stops of joints count; otherwise all others do.
    """
    return np.where(recording.is_at_joint_stop == at_stops, recording.impacts[field], np.nan)


def _largest_in(recording: Recording, field: str, *, at_stops: bool) -> float:
    return float(np.nanmax(_values_of(recording, field, at_stops=at_stops), initial=0.0))


def _impact_quantity(
    recording: Recording, sensitivities: Sensitivities, number: int, field: str
) -> RankedQuantity:
    """Return the quantity ``field`` of the impact with a number, from 1, with its derivatives.

    Raises:
        SceneError: when there is no such impact, or the column ``field`` has no derivatives.
    """
    impacts, slopes = recording.impacts, sensitivities.impact_slopes
    if not 1 <= number <= len(impacts):
        impact_text = count_text(len(impacts), "impact")
        raise SceneError(
            f"{recording.name}: impact[{number}].{field} does not exist; the run has {impact_text}"
        )
    if field not in slopes and field != DURATION:
        fields_text = ", ".join((*slopes, DURATION))
        raise SceneError(
            f"{recording.name}: impact[{number}].{field} has no derivatives; must be {fields_text}"
        )
    impact = impacts[number - 1]
    value, slope = impact[field], slopes_of_impacts(sensitivities, field)
    units = impact_units(is_stop=recording.is_joint_stop(impact["wall"]))
    wall = recording.wall_names[impact["wall"]]
    location_text = (
        f"impact {number}, {recording.touching_part(impact)} at {wall}, t = {impact['onset']:.6g} s"
    )
    value_in_run = partial(_impact_in, number=number, field=field)
    # a coordinate on a wall through the origin is 0 up to round-off, so its size counts as at least the
    # length of the chain
    links = sensitivities.prepared_scene.scene.chain.links
    least_size = sum(link.length for link in links) if field in POSITION else 0.0
    size = max(abs(float(value)), least_size)
    return RankedQuantity(float(value), units[field], location_text, slope[number - 1], size, value_in_run)


def _impact_in(recording: Recording, number: int, field: str) -> float:
    return float(recording.impacts[field][number - 1]) if number <= len(recording.impacts) else math.nan


def _joint_force(recording: Recording, sensitivities: Sensitivities) -> RankedQuantity:
    """Return the largest force in any joint during the run, with its derivatives.

    Raises:
        SceneError: when the run has no output ``peak_force`` of a joint.
    """
    names = [name for name in sensitivities.columns if _is_joint_force(name)]
    if not names:
        prepared_scene = sensitivities.prepared_scene
        if prepared_scene.scene.outputs.loads and not any(
            _is_joint_force(output.name) for output in prepared_scene.outputs
        ):
            raise SceneError(f"{recording.name}: joint_force: the chain has no joint")
        raise SceneError(
            f"{recording.name}: joint_force needs the forces in joints: outputs.loads must be true, and "
            "output=…, if it is given, must have joint[*].peak_force"
        )
    name = max(names, key=lambda column: recording.columns[column][-1])
    location_text = f"joint[{name_parts(name).n}], the largest of the run"
    end_quantity = _final_output(recording, sensitivities, name)
    return end_quantity._replace(location_text=location_text, value_in=partial(_largest_end_in, names=names))


def _is_joint_force(name: str) -> bool:
    """Return whether an output is the largest force in a joint since the start."""
    parts = name_parts(name)
    return parts.owner == "joint" and parts.quantity == "peak_force"


def _final_output(recording: Recording, sensitivities: Sensitivities, name: str) -> RankedQuantity:
    """Return the value of an output at the end of the run, with its derivatives."""
    values = recording.columns[name]
    size = max(abs(float(values[-1])), float(np.ptp(values)))
    location_text = f"at the end, t = {recording.time[-1]:g} s"
    slopes = sensitivities.slopes[-1, sensitivities.columns[name]]
    value_in_run = partial(_largest_end_in, names=[name])
    return RankedQuantity(
        float(values[-1]), sensitivities.units[name], location_text, slopes, size, value_in_run
    )


def _largest_end_in(recording: Recording, names: Sequence[str]) -> float:
    return float(max(recording.columns[name][-1] for name in names))
