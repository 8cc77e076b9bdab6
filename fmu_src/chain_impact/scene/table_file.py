"""A table of numbers over time as it was given, measured or to be followed: a file, or columns in Python."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from chain_impact.extras import require
from chain_impact.scene.reading import SceneError, decimal_comma, shown
from chain_impact.scene.text_file import check_separator, likely_time, text_of

Source = str | Path | Mapping[str, Sequence[Any]]
"""A CSV or Parquet file, or name of a column → its cells. Tables of pandas and polars are taken as well."""
TIME = "time"
TOO_LONG = 1000.0  # of the run: a table that lasts longer is in another unit of time
EMPTY = ("", "nan", "NaN", "NAN", "None", "<NA>")


def is_table(source: Any) -> bool:
    """Whether this is one table, and no list of them."""
    return isinstance(source, str | Path) or hasattr(source, "items") or hasattr(source, "iter_columns")


@dataclass(frozen=True)
class Table:
    """Cells by row and column.

    Attributes:
        source: what an error calls the table.
        names: of the columns.
        rows: the cells of each row, text or numbers.
        lines: what an error calls each row, ``line 3`` of a file.
    """

    source: str
    names: tuple[str, ...]
    rows: list[list[Any]]
    lines: list[str]

    def where(self, row: int, name: str) -> str:
        """File, row and column, for an error."""
        return f"{self.source}: {self.lines[row]}: {name}"

    def cell(self, row: int, name: str) -> Any:
        """A cell without spaces around; None if it is empty or there is no such column."""
        if name not in self.names:
            return None
        value = self.rows[row][self.names.index(name)]
        value = value.strip() if isinstance(value, str) else value
        return None if str(value) in EMPTY else value

    def number(self, row: int, name: str) -> float:
        """A cell as a number, NaN if it is empty.

        Raises:
            SceneError: when it is something else, or not finite.
        """
        value = self.cell(row, name)
        if value is None:
            return math.nan
        try:
            found = float(value)
        except (TypeError, ValueError):
            found = math.inf
        if not math.isfinite(found):
            raise SceneError(
                f"{self.where(row, name)} = {shown(value)} must be a finite number, or empty if not measured"
                f"{decimal_comma(value)}"
            )
        return found


def read_table(source: Source) -> Table:
    """The table of a CSV file with a head line, of a Parquet file, or of columns.

    Raises:
        SceneError: when it is no such table.
        OSError: when the file cannot be read.
        MissingExtraError: for Parquet, when pyarrow is not there: the extra ``sweep``.
    """
    if not isinstance(source, str | Path):
        if hasattr(source, "iter_columns"):  # polars
            source = {one.name: one.to_list() for one in source.iter_columns()}
        columns = {str(name): list(cells) for name, cells in source.items()}
        lengths = {name: len(cells) for name, cells in columns.items()}
        if len(set(lengths.values())) > 1:
            told = ", ".join(f"{name} {length}" for name, length in lengths.items())
            raise SceneError(f"data: columns must have equally many rows, not {told}")
        rows = [list(row) for row in zip(*columns.values(), strict=True)]
        return _checked("data", tuple(columns), rows, [f"row {k}" for k in range(len(rows))])
    path = Path(source)
    if path.suffix == ".parquet":
        arrow, parquet = require("pyarrow", "sweep"), require("pyarrow.parquet", "sweep")
        try:
            whole = parquet.read_table(path)
        except arrow.ArrowInvalid as error:
            raise SceneError(f"{path}: not a Parquet table: {error}") from None
        cells = [column.to_pylist() for column in whole.columns]
        rows = [list(row) for row in zip(*cells, strict=True)]
        return _checked(str(path), tuple(whole.column_names), rows, [f"row {k}" for k in range(len(rows))])
    try:
        reader = csv.reader(io.StringIO(text_of(path), newline=""))
        head = next(reader, [])
        check_separator(",".join(head))
        names = tuple(name.strip() for name in head)
        numbered = [(f"line {reader.line_num}", row) for row in reader if any(map(str.strip, row))]
    except (ValueError, csv.Error) as error:
        raise SceneError(f"{path}: not a CSV table: {error}") from None
    return _checked(str(path), names, [row for _, row in numbered], [line for line, _ in numbered])


def samples_of(table: Table, stop: float) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """The times [s] of a table of inputs, shape (T,), and its other columns by their names, likewise.

    Args:
        table: with the column ``time``, and no cell empty.
        stop: end of the run [s].

    Raises:
        SceneError: when it is no such table.
    """
    if TIME not in table.names:
        hint = likely_time(table.names) or f"; it has {', '.join(table.names)}"
        raise SceneError(f"{table.source}: the column {TIME} is missing{hint}")
    columns = {name: _column(table, name) for name in table.names}
    times = columns.pop(TIME)
    for row in (np.flatnonzero(np.diff(times) <= 0.0) + 1).tolist():
        later = f"{times[row - 1]:g} [s], that of the row before"
        raise SceneError(f"{table.where(row, TIME)} = {times[row]:g} must be > {later}")
    if times[-1] - times[0] > TOO_LONG * stop:
        lasts = f"lasts {times[-1] - times[0]:g} s, and the run {stop:g} s"
        raise SceneError(f"{table.source}: {TIME} {lasts}: is it in seconds?")
    return times, columns


def _column(table: Table, name: str) -> np.ndarray:
    """A column without gaps."""
    for row in range(len(table.rows)):
        if table.cell(row, name) is None:
            raise SceneError(
                f"{table.where(row, name)} is empty: a table of inputs has a number in each cell"
            )
    return np.array([table.number(row, name) for row in range(len(table.rows))])


def _checked(source: str, names: tuple[str, ...], rows: list[list[Any]], lines: list[str]) -> Table:
    """The table, when it has a head, rows, and as many cells in each."""
    for k, name in enumerate(names):
        if not name or name in names[:k]:
            what = "has no name" if not name else f"{name} is there twice"
            raise SceneError(f"{source}: column {k + 1} of the head line {what}")
    if not names or not rows:
        raise SceneError(f"{source}: must be a table with a head line and at least one row")
    for line, row in zip(lines, rows, strict=True):
        if len(row) != len(names):
            raise SceneError(
                f"{source}: {line} has {len(row)} cell{'s' * (len(row) != 1)}, must have {len(names)} as the "
                "head line"
            )
    return Table(source, names, rows, lines)
