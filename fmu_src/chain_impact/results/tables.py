"""Results as tables of pandas and datasets of xarray."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from chain_impact.extras import require
from chain_impact.results.stick_slip import JOINT, MODES
from chain_impact.scene.candidates import point_wall_pairs
from chain_impact.scene.names import AXES
from chain_impact.variables.outputs import LABELS, OWNERS

if TYPE_CHECKING:
    from chain_impact.results.result import Result

IMPACT_UNITS = {
    "onset": "s",
    "end": "s",
    "impact_speed": "m/s",
    "separation_speed": "m/s",
    "peak_force": "N",
    "max_penetration": "m",
    "effective_mass": "kg",
    "impulse": "N.s",
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


def dataframe(result: Result) -> Any:
    """See ``Result.to_dataframe``."""
    pandas = require("pandas", "pandas")
    table = pandas.DataFrame(result.columns, index=pandas.Index(result.time, name="time"))
    units = {variable.name: variable.unit for variable in result.model.outputs}
    table.attrs["units"] = {name: units[name] for name in result.names}
    return table


def impact_table(result: Result) -> Any:
    """See ``Result.impact_table``."""
    pandas = require("pandas", "pandas")
    walls = np.array(result.scene.wall_names, dtype=object)
    columns = {name: result.impacts[name] for name in result.impacts.dtype.names or ()}
    columns["wall"] = walls[columns["wall"]]
    index = pandas.RangeIndex(1, len(result.impacts) + 1, name="impact")
    table = pandas.DataFrame(columns, index=index)
    table.attrs["units"] = dict(IMPACT_UNITS)
    if result.scene.chain.stops:
        table.attrs["units_at_stops"] = IMPACT_UNITS | STOP_UNITS
    return table


def stick_slip_table(result: Result) -> Any:
    """See ``Result.stick_slip_table``."""
    pandas = require("pandas", "pandas")
    phases, walls = result.stick_slip, result.scene.wall_names
    columns: dict[str, Any] = {name: phases[name] for name in phases.dtype.names or ()}
    columns["wall"] = ["" if wall == JOINT else walls[wall] for wall in phases["wall"]]
    columns["mode"] = [MODES[mode] for mode in phases["mode"]]
    table = pandas.DataFrame(columns, index=pandas.RangeIndex(1, len(phases) + 1, name="phase"))
    table.attrs["units"] = {"start": "s", "end": "s"}
    return table


def dataset(result: Result) -> Any:
    """See ``Result.to_xarray``."""
    xarray = require("xarray", "xarray")
    scene, model = result.scene, result.model
    pairs = [(point, scene.wall_names[wall]) for point, wall in point_wall_pairs(scene)]
    points = len(scene.chain.links) + 1
    sizes = {"point": points, "axis": len(AXES), "link": points - 1, "contact": len(pairs)}
    data: dict[str, Any] = {}
    for variable in model.motion:
        if variable.name not in result.motion:
            continue
        # joints without a stop or dry friction have no such values
        of_joint = variable.name.startswith("joint[")
        dimensions = () if of_joint else _DIMENSIONS.get(variable.field, ())
        key = LABELS[variable.field] if dimensions else variable.name
        if key not in data:
            values = np.full((len(result.time), *(sizes[one] for one in dimensions)), np.nan)
            data[key] = (("time", *dimensions), values, {"units": variable.unit})
        data[key][1][(slice(None), *variable.index[: len(dimensions)])] = result.motion[variable.name]
    coordinates = {
        "time": ("time", result.time, {"units": "s"}),
        "point": np.arange(points),
        "axis": list(AXES),
        "link": np.arange(1, points),
        "contact": [f"contact[{point}].{wall}" for point, wall in pairs],
        "contact_point": ("contact", [point for point, _ in pairs]),
        "contact_wall": ("contact", [wall for _, wall in pairs]),
    }
    return xarray.Dataset(data, coordinates, {"scene": scene.name, "description": scene.description})
