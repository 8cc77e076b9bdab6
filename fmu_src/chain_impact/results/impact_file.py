"""The list of impacts as a file, for other programs: CSV, JSON or Parquet."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from chain_impact.extras import require
from chain_impact.system import written_whole

SUFFIXES = (".csv", ".json", ".parquet")


def impact_columns(impacts: np.ndarray, walls: Sequence[str]) -> dict[str, list[Any]]:
    """The columns of ``IMPACT_DTYPE`` with the names of the walls; what is not known, or not yet, is None."""
    columns = {name: impacts[name].tolist() for name in impacts.dtype.names or () if name != "wall_name"}
    columns["wall"] = [walls[wall] for wall in columns["wall"]]
    return {
        name: [None if isinstance(one, float) and math.isnan(one) else one for one in values]
        for name, values in columns.items()
    }


def save_impacts(path: Path, impacts: np.ndarray, walls: Sequence[str]) -> None:
    """Write the list of impacts, one in a row, numbers in full precision.

    JSON has an object for each impact.

    Raises:
        ValueError: when the file ends in none of the SUFFIXES.
        MissingExtraError: for Parquet, when pyarrow is not there: the extra ``sweep``.
        OSError: when the file cannot be written.
    """
    suffix, columns = path.suffix.lower(), impact_columns(impacts, walls)
    if suffix not in SUFFIXES:
        raise ValueError(f"{path}: the list of impacts must end in {', '.join(SUFFIXES)}")
    rows = zip(*columns.values(), strict=True)
    with written_whole(path) as fresh:
        if suffix == ".parquet":
            arrow = require("pyarrow", "sweep")
            kinds = {"wall": arrow.string(), "point": arrow.int64(), "joint": arrow.int64()}
            schema = arrow.schema([(name, kinds.get(name, arrow.float64())) for name in columns])
            require("pyarrow.parquet", "sweep").write_table(arrow.table(columns, schema), fresh)
        elif suffix == ".json":
            records = [dict(zip(columns, row, strict=True)) for row in rows]
            fresh.write_text(json.dumps(records, indent=1) + "\n", encoding="utf-8")
        else:
            with fresh.open("w", newline="", encoding="utf-8") as file:
                writer = csv.writer(file)
                writer.writerow(columns)
                writer.writerows(rows)
