"""Results as tables of pandas and datasets of xarray."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from chain_impact.extras import require
from chain_impact.results.impacts import LOG_DTYPE
from chain_impact.results.stick_slip import JOINT, MODES
from chain_impact.scene.candidates import point_wall_pairs
from chain_impact.scene.names import AXES
from chain_impact.variables.model import Model
from chain_impact.variables.outputs import LABELS, OWNERS

IMPACT_UNITS = {
    "onset": "s",
    "end": "s",
    "impact_speed": "m/s",
    "separation_speed": "m/s",
    "peak_force": "N",
    "max_penetration": "m",
    "effective_mass": "kg",
    "impulse": "N.s",
    "joint_force": "N",
}
STOP_UNITS = {
    "impact_speed": "rad/s",
    "separation_speed": "rad/s",
    "peak_force": "N.m",
    "max_penetration": "rad",
    "effective_mass": "kg.m2",
    "impulse": "N.m.s",
}
"""What is in another unit, of an impact at a stop."""
_DIMENSIONS = {field: ("point", "axis") if owner == "point" else (owner,) for field, owner in OWNERS.items()}


def dataframe(model: Model, time: np.ndarray, columns: Mapping[str, np.ndarray]) -> Any:
    """See ``Result.to_dataframe``."""
    pandas = require("pandas", "pandas")
    table = pandas.DataFrame(columns, index=pandas.Index(time, name="time"))
    units = {variable.name: variable.unit for variable in model.outputs}
    table.attrs["units"] = {name: units[name] for name in columns}
    return table


def impact_table(impacts: np.ndarray, walls: Sequence[str], *, stops: bool) -> Any:
    """See ``Result.impact_table``; ``stops`` tells whether joints have stops."""
    pandas = require("pandas", "pandas")
    columns = {name: impacts[name] for name in LOG_DTYPE.names or ()}
    columns["wall"] = np.array(walls, dtype=object)[columns["wall"]]
    table = pandas.DataFrame(columns, index=pandas.RangeIndex(1, len(impacts) + 1, name="impact"))
    table.attrs["units"] = dict(IMPACT_UNITS)
    if stops:
        table.attrs["units_at_stops"] = IMPACT_UNITS | STOP_UNITS
    return table


def stick_slip_table(phases: np.ndarray, walls: Sequence[str]) -> Any:
    """See ``Result.stick_slip_table``."""
    pandas = require("pandas", "pandas")
    columns: dict[str, Any] = {name: phases[name] for name in phases.dtype.names or ()}
    columns["wall"] = ["" if wall == JOINT else walls[wall] for wall in phases["wall"]]
    columns["mode"] = [MODES[mode] for mode in phases["mode"]]
    table = pandas.DataFrame(columns, index=pandas.RangeIndex(1, len(phases) + 1, name="phase"))
    table.attrs["units"] = {"start": "s", "end": "s"}
    return table


def dataset(model: Model, time: np.ndarray, motion: Mapping[str, np.ndarray]) -> Any:
    """See ``Result.to_xarray``; ``motion`` are the outputs that change all the time."""
    xarray = require("xarray", "xarray")
    scene = model.scene
    pairs = [(point, scene.wall_names[wall]) for point, wall in point_wall_pairs(scene)]
    points = len(scene.chain.links) + 1
    sizes = {"point": points, "axis": len(AXES), "link": points - 1, "contact": len(pairs)}
    data: dict[str, Any] = {}
    for variable in model.motion:
        if variable.name not in motion:
            continue
        # joints without a stop or dry friction have no such values
        of_joint = variable.name.startswith("joint[")
        dimensions = () if of_joint else _DIMENSIONS.get(variable.field, ())
        key = LABELS[variable.field] if dimensions else variable.name
        if key not in data:
            values = np.full((len(time), *(sizes[one] for one in dimensions)), np.nan)
            data[key] = (("time", *dimensions), values, {"units": variable.unit})
        data[key][1][(slice(None), *variable.index[: len(dimensions)])] = motion[variable.name]
    coordinates = {
        "time": ("time", time, {"units": "s"}),
        "point": np.arange(points),
        "axis": list(AXES),
        "link": np.arange(1, points),
        "contact": [f"contact[{point}].{wall}" for point, wall in pairs],
        "contact_point": ("contact", [point for point, _ in pairs]),
        "contact_wall": ("contact", [wall for _, wall in pairs]),
    }
    return xarray.Dataset(data, coordinates, {"scene": scene.name, "description": scene.description})
