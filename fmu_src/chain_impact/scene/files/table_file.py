"""A table of numbers over time that the user gives: a file, or columns in Python."""

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
from chain_impact.scene.errors import SceneError, value_text
from chain_impact.scene.files.text_file import comma_separated_text, likely_time, text_of
from chain_impact.scene.reading import decimal_comma

TableSource = str | Path | Mapping[str, Sequence[Any] | np.ndarray]
"""A CSV or Parquet file, a data frame of pandas or polars, or a mapping: name of a column → cells."""
TIME = "time"
# [1] if the duration of a table, divided by that of the run, is above TOO_LONG, the times of the table cannot
# be in seconds; times in milliseconds make this ratio about 1000
TOO_LONG = 990.0
# Rows seem to be missing in a step of time that is longer than LONG_STEP times the median step. This holds
# for a regular table only: it has at least ROWS steps, and at least half of the steps differ from the median
# step by at most EQUAL_STEPS times the median step.
LONG_STEP = 10.0
ROWS = 10
EQUAL_STEPS = 0.01
EMPTY_TEXTS = ("", "nan", "NaN", "NAN", "None", "<NA>")  # the texts that count as an empty cell


def is_table(source: Any) -> bool:
    """Return whether the source is one table: a file, columns by name, or a data frame."""
    return isinstance(source, str | Path) or hasattr(source, "items") or hasattr(source, "iter_columns")


@dataclass(frozen=True)
class Table:
    """A table as cells by row and column.

    Attributes:
        source: the name of the table in errors.
        names: the names of the columns.
        rows: the cells of each row, text or numbers.
        lines: the name of each row in errors, for example ``line 3`` of a file.
    """

    source: str
    names: tuple[str, ...]
    rows: list[list[Any]]
    lines: list[str]

    def cell_name(self, row: int, name: str) -> str:
        """Return the words for a cell in errors: "data.csv: line 3: time"; ``row`` is a row's index."""
        return f"{self.source}: {self.lines[row]}: {name}"

    def cell(self, row: int, name: str) -> Any:
        """Return a cell of the column ``name``; text without the spaces around it.

        The result is None if the table lacks the column, or if the text of the cell is one of EMPTY_TEXTS.
        """
        if name not in self.names:
            return None
        value = self.rows[row][self.names.index(name)]
        value = value.strip() if isinstance(value, str) else value
        return None if str(value) in EMPTY_TEXTS else value

    def number(self, row: int, name: str, alternative: str = ", or empty if not measured") -> float:
        """Return a cell as a number; NaN if the cell is empty, or if the table lacks the column.

        Args:
            row: the index of the row.
            name: the name of the column.
            alternative: the end of the error: ", or …", which tells what a cell may be other than a number.

        Raises:
            SceneError: when the cell is neither empty nor a finite number.
        """
        value = self.cell(row, name)
        if value is None:
            return math.nan
        try:
            number = float(value)
        except (TypeError, ValueError):
            number = math.inf
        if not math.isfinite(number):
            raise SceneError(
                f"{self.cell_name(row, name)} = {value_text(value)} must be a finite number{alternative}"
                f"{decimal_comma(value)}"
            )
        return number


def read_table(source: TableSource) -> Table:
    """Return the table of a CSV file with a head line, of a Parquet file, or of columns in Python.

    The cells of a CSV file are texts.

    Raises:
        SceneError: when the source is not a table with at least one row, different names of columns, and as
            many cells as names in each row.
        OSError: when the file cannot be read.
        MissingExtraError: for Parquet, when pyarrow (the extra ``sweep``) is not installed.
    """
    if not isinstance(source, str | Path):
        if hasattr(source, "iter_columns"):  # the source is a table of polars
            source = {series.name: series.to_list() for series in source.iter_columns()}
        if not hasattr(source, "items"):
            raise SceneError(f"data: {value_text(source)} must be a file, a data frame, or columns by name")
        columns = {str(name): list(cells) for name, cells in source.items()}
        lengths = {name: len(cells) for name, cells in columns.items()}
        if len(set(lengths.values())) > 1:
            counts_text = ", ".join(f"{name} {length}" for name, length in lengths.items())
            raise SceneError(f"data: columns must have equally many rows, not {counts_text}")
        rows = [list(row) for row in zip(*columns.values(), strict=True)]
        return _checked_table("data", tuple(columns), rows, [f"row {k}" for k in range(len(rows))])
    path = Path(source)
    if path.suffix == ".toml":
        raise SceneError(f"{path}: it is a scene, must be a table of data, in CSV or Parquet")
    if path.suffix == ".parquet":
        arrow, parquet = require("pyarrow", "sweep"), require("pyarrow.parquet", "sweep")
        try:
            whole_table = parquet.read_table(path)
        except arrow.ArrowInvalid as error:
            raise SceneError(f"{path}: not a Parquet table: {error}") from None
        cells = [column.to_pylist() for column in whole_table.columns]
        rows = [list(row) for row in zip(*cells, strict=True)]
        return _checked_table(
            str(path), tuple(whole_table.column_names), rows, [f"row {k}" for k in range(len(rows))]
        )
    try:
        text = comma_separated_text(text_of(path))
        reader = csv.reader(io.StringIO(text, newline=""))
        names = tuple(name.strip() for name in next(reader, []))
        numbered_rows = [(f"line {reader.line_num}", row) for row in reader if any(map(str.strip, row))]
    except (ValueError, csv.Error) as error:
        raise SceneError(f"{path}: not a CSV table: {error}") from None
    return _checked_table(
        str(path), names, [row for _, row in numbered_rows], [line for line, _ in numbered_rows]
    )


def samples_of(table: Table, stop_time: float) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return the times [s] of a table of inputs, and name → values of each other column, all of shape (T,).

    Args:
        table: a table with the column ``time`` and without empty cells. Its times increase, but two
            successive rows may have the same time, at which the inputs jump.
        stop_time: end of the run, which begins at 0 [s].

    Raises:
        SceneError: when ``table`` is not such a table, has only the column ``time``, or lasts far longer than
            the run.
    """
    if TIME not in table.names:
        hint = likely_time(table.names) or f"; it has {', '.join(table.names)}"
        raise SceneError(f"{table.source}: the column {TIME} is missing{hint}")
    if table.names == (TIME,):
        raise SceneError(f"{table.source}: has only the column {TIME}; must have one for each input")
    columns = {name: _column(table, name) for name in table.names}
    times = columns.pop(TIME)
    if (row := first_early(times)) is not None:
        order_text = (
            f"{times[row - 1]:g} [s], the value of the row before; only two rows may be equal, for a jump"
        )
        raise SceneError(f"{table.cell_name(row, TIME)} = {times[row]:g} must be > {order_text}")
    if times[-1] - times[0] > TOO_LONG * stop_time:
        duration_text = f"lasts {times[-1] - times[0]:g} s, and the run {stop_time:g} s"
        raise SceneError(f"{table.source}: {TIME} {duration_text}: is it in seconds?")
    return times, columns


def first_early(times: np.ndarray) -> int | None:
    """Return the index of the first time below the preceding one, or third of three equal ones; else None."""
    steps = np.diff(times)
    is_early = steps < 0.0
    is_early[1:] |= (steps[1:] == 0.0) & (steps[:-1] == 0.0)
    return int(is_early.argmax()) + 1 if is_early.any() else None


def jumps_of(times: np.ndarray | Sequence[float]) -> np.ndarray:
    """Return the indices of the times that are equal to the next one."""
    return np.flatnonzero(np.diff(times) == 0.0)


def gap_hints(times: np.ndarray | Sequence[float]) -> list[str]:
    """Return a list with a question on the longest step of time of a table, if rows seem to be missing in it.

    The list is empty if no row seems to be missing, or if the table is not regular: see LONG_STEP. ``times``
    are the times of the rows [s].
    """
    steps = np.diff(times)
    if len(steps) < ROWS:
        return []
    usual_step, k = float(np.median(steps)), int(steps.argmax())
    is_regular = np.median(np.abs(steps - usual_step)) <= EQUAL_STEPS * usual_step
    if not is_regular or steps[k] <= LONG_STEP * usual_step:
        return []
    return [
        f"no row between {TIME} = {times[k]:g} and {times[k + 1]:g} s, while other rows are "
        f"{usual_step:.3g} s apart: are rows missing?"
    ]


def _column(table: Table, name: str) -> np.ndarray:
    """Return a column of a table of inputs as numbers, shape (T,); refuse a cell without a finite number."""
    for row in range(len(table.rows)):
        if table.cell(row, name) is None:
            raise SceneError(
                f"{table.cell_name(row, name)} is empty: a table of inputs has a number in each cell"
            )
    return np.array([table.number(row, name, alternative="") for row in range(len(table.rows))])


def _checked_table(source: str, names: tuple[str, ...], rows: list[list[Any]], lines: list[str]) -> Table:
    """Return the ``Table`` with these attributes; refuse a table that is not complete.

    A complete table has at least one row, columns that each have a name of their own, and in each row as many
    cells as names.
    """
    for k, name in enumerate(names):
        if not name or name in names[:k]:
            fault = "has no name" if not name else f"has the name {name} again"
            raise SceneError(f"{source}: column {k + 1} of the head line {fault}")
    if not names or not rows:
        raise SceneError(f"{source}: must be a table with a head line and at least one row")
    for line, row in zip(lines, rows, strict=True):
        if len(row) != len(names):
            raise SceneError(
                f"{source}: {line} has {len(row)} cell{'s' * (len(row) != 1)}, must have {len(names)} as the "
                "head line"
            )
    return Table(source, names, rows, lines)
