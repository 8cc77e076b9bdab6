"""Results as tables of pandas and datasets of xarray, and the list of impacts as a file."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from chain_impact.extras import require
from chain_impact.files import written_atomically
from chain_impact.recording.stick_slip import MODES, NO_WALL
from chain_impact.scene.candidates import point_wall_pairs
from chain_impact.scene.texts.names import AXES
from chain_impact.variables.impact_units import IMPACT_UNITS, STOP_UNITS
from chain_impact.variables.peaks import JOINT_FORCE
from chain_impact.variables.prepared import PreparedScene

ROWS_AT_ONCE = 10_000  # number of rows that ``save_columns`` converts to text at a time
SUFFIXES = (".csv", ".json", ".parquet")
"""The suffixes that a file with a list of impacts may have."""
_DIMENSIONS = {"point": ("point", "axis"), "link": ("link",), "contact": ("contact",)}
"""Kind of owner of an output → the dimensions, after the time, of an array in a dataset of xarray."""


def dataframe(prepared_scene: PreparedScene, time: np.ndarray, columns: Mapping[str, np.ndarray]) -> Any:
    """Return outputs as a table of pandas: the times [s] are its index, ``columns`` its columns.

    ``attrs["units"]`` of the table has the unit of each column.
    """
    pandas = require("pandas", "pandas")
    table = pandas.DataFrame(columns, index=pandas.Index(time, name="time"))
    units = {variable.name: variable.unit for variable in (*prepared_scene.inputs, *prepared_scene.outputs)}
    table.attrs["units"] = {name: units[name] for name in columns}
    return table


def impact_table(impacts: np.ndarray, walls: Sequence[str], *, has_stops: bool) -> Any:
    """Return impacts as a table of pandas, with rows from 1; the column ``wall`` has the names of the walls.

    ``attrs["units"]`` has the units of the columns. If ``has_stops``, because joints have stops,
    ``attrs["units_at_stops"]`` has the units of impacts at these stops, which have moments and angles.
    """
    pandas = require("pandas", "pandas")
    columns = {name: impacts[name] for name in impacts.dtype.names or () if name != "wall_name"}
    columns["wall"] = np.array(walls, dtype=object)[columns["wall"]]
    table = pandas.DataFrame(columns, index=pandas.RangeIndex(1, len(impacts) + 1, name="impact"))
    table.attrs["units"] = dict(IMPACT_UNITS)
    if has_stops:
        table.attrs["units_at_stops"] = dict(STOP_UNITS)
    return table


def stick_slip_table(phases: np.ndarray, walls: Sequence[str]) -> Any:
    """Return phases of dry friction as a table of pandas, with rows from 1.

    The table has names of walls ("" without one) and modes, and ``attrs["units"]`` has the units of times.
    """
    pandas = require("pandas", "pandas")
    columns: dict[str, Any] = {name: phases[name] for name in phases.dtype.names or ()}
    columns["wall"] = ["" if wall == NO_WALL else walls[wall] for wall in phases["wall"]]
    columns["mode"] = [MODES[mode] for mode in phases["mode"]]
    table = pandas.DataFrame(columns, index=pandas.RangeIndex(1, len(phases) + 1, name="phase"))
    table.attrs["units"] = {"start": "s", "end": "s"}
    return table


def dataset(prepared_scene: PreparedScene, time: np.ndarray, motion: Mapping[str, np.ndarray]) -> Any:
    """Return outputs as a dataset of xarray: a quantity of points, links or contacts is one array for all.

    Any other output has an array of its own. ``motion``: name → values, shape (T,), of outputs of the list
    ``prepared_scene.continuous_outputs``; other outputs are not in the dataset. In an array for all, the
    outputs that ``motion`` lacks are NaN.
    """
    xarray = require("xarray", "xarray")
    scene = prepared_scene.scene
    pairs = [(point, scene.wall_names[wall]) for point, wall in point_wall_pairs(scene)]
    pairs += [(0, stop) for stop in scene.slider_stops]
    contacts = [f"contact[{point}].{wall}" for point, wall in pairs]
    links, points = len(scene.chain.links), len(scene.start)
    sizes = {"point": points, "axis": len(AXES), "link": links, "contact": len(pairs)}
    data: dict[str, Any] = {}
    for variable in prepared_scene.continuous_outputs:
        if variable.name not in motion:
            continue
        owner, _, label = variable.kind.array.partition(".")
        dimensions, key = _DIMENSIONS.get(owner, ()), label or variable.name
        if key not in data:
            values = np.full((len(time), *(sizes[dimension] for dimension in dimensions)), np.nan)
            data[key] = (("time", *dimensions), values, {"units": variable.unit})
        index = variable.index[: len(dimensions)]
        # The index that a contact has in the record is not used: the record's contacts include stops of
        # joints, which the dimension "contact" lacks.
        if owner == "contact":
            index = (contacts.index(variable.name.rpartition(".")[0]),)
        data[key][1][(slice(None), *index)] = motion[variable.name]
    coordinates = {
        "time": ("time", time, {"units": "s"}),
        "point": np.arange(points),
        "axis": list(AXES),
        "link": np.arange(1, links + 1),
        "contact": contacts,
        "contact_point": ("contact", [point for point, _ in pairs]),
        "contact_wall": ("contact", [wall for _, wall in pairs]),
    }
    if names := scene.point_names:
        coordinates["point_name"] = ("point", [names.get(point, "") for point in range(points)])
    return xarray.Dataset(data, coordinates, {"scene": scene.name, "description": scene.description})


def impact_columns(impacts: np.ndarray, walls: Sequence[str]) -> dict[str, list[Any]]:
    """Return the list of impacts as columns, with the names of walls; an unknown value is None.

    The largest forces of a contact without duration, as at a rigid wall or stop, are None, too.
    """
    impacts = impacts.copy()
    for force in ("peak_force", JOINT_FORCE):
        impacts[force][impacts["end"] == impacts["onset"]] = np.nan
    columns = {name: impacts[name].tolist() for name in impacts.dtype.names or () if name != "wall_name"}
    columns["wall"] = [walls[wall] for wall in columns["wall"]]
    columns["joint"] = [joint or None for joint in columns["joint"]]  # 0 is no joint
    return {
        name: [None if isinstance(value, float) and math.isnan(value) else value for value in values]
        for name, values in columns.items()
    }


def save_columns(path: Path, columns: Mapping[str, np.ndarray]) -> None:
    """Write columns with equal numbers of rows as CSV, with all digits of the numbers.

    Raises:
        OSError: when the file cannot be written.
    """
    count = max(len(column) for column in columns.values())
    with written_atomically(path) as new_file, new_file.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        # converting all rows to lists at once would take four times the memory of the arrays
        for start in range(0, count, ROWS_AT_ONCE):
            values = (column[start : start + ROWS_AT_ONCE].tolist() for column in columns.values())
            writer.writerows(zip(*values, strict=True))


def save_impacts(path: Path, impacts: np.ndarray, walls: Sequence[str]) -> None:
    """Write a list of impacts to a file, with all digits of the numbers.

    CSV and Parquet have one impact in a row; JSON has an object for each impact.

    Raises:
        ValueError: when the file ends in none of the SUFFIXES.
        MissingExtraError: for Parquet, when pyarrow (the extra ``sweep``) is not installed.
        OSError: when the file cannot be written.
    """
    suffix, columns = path.suffix.lower(), impact_columns(impacts, walls)
    if suffix not in SUFFIXES:
        raise ValueError(f"{path}: the list of impacts must end in {', '.join(SUFFIXES)}")
    rows = zip(*columns.values(), strict=True)
    with written_atomically(path) as new_file:
        if suffix == ".parquet":
            arrow = require("pyarrow", "sweep")
            kinds = {"wall": arrow.string(), "point": arrow.int64(), "joint": arrow.int64()}
            schema = arrow.schema([(name, kinds.get(name, arrow.float64())) for name in columns])
            require("pyarrow.parquet", "sweep").write_table(arrow.table(columns, schema), new_file)
        elif suffix == ".json":
            records = [dict(zip(columns, row, strict=True)) for row in rows]
            new_file.write_text(json.dumps(records, indent=1) + "\n", encoding="utf-8")
        else:
            with new_file.open("w", newline="", encoding="utf-8") as file:
                writer = csv.writer(file)
                writer.writerow(columns)
                writer.writerows(rows)
