"""A table of measurements as it was given: a CSV file, or columns in Python."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from chain_impact.results.text import plural
from chain_impact.scene.reading import SceneError, decimal_comma, shown
from chain_impact.scene.text_file import check_separator, text_of

Source = str | Path | Mapping[str, Sequence[Any]]
"""A CSV file, or name of a column → its cells. A ``DataFrame`` of pandas is taken as well."""
EMPTY = ("", "nan", "NaN", "NAN", "None", "<NA>")


def is_table(source: Any) -> bool:
    """Whether this is one table, and no list of them."""
    return isinstance(source, str | Path) or hasattr(source, "items")


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
    """The table of a CSV file with a head line, or of columns.

    Raises:
        SceneError: when it is no such table.
        OSError: when the file cannot be read.
    """
    if not isinstance(source, str | Path):
        columns = {str(name): list(cells) for name, cells in source.items()}
        lengths = {name: len(cells) for name, cells in columns.items()}
        if len(set(lengths.values())) > 1:
            told = ", ".join(f"{name} {length}" for name, length in lengths.items())
            raise SceneError(f"data: columns must have equally many rows, not {told}")
        rows = [list(row) for row in zip(*columns.values(), strict=True)]
        return _checked("data", tuple(columns), rows, [f"row {k}" for k in range(len(rows))])
    path = Path(source)
    try:
        reader = csv.reader(io.StringIO(text_of(path), newline=""))
        head = next(reader, [])
        check_separator(",".join(head))
        names = tuple(name.strip() for name in head)
        numbered = [(f"line {reader.line_num}", row) for row in reader if any(map(str.strip, row))]
    except (ValueError, csv.Error) as error:
        raise SceneError(f"{path}: not a CSV table: {error}") from None
    return _checked(str(path), names, [row for _, row in numbered], [line for line, _ in numbered])


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
                f"{source}: {line} has {plural(len(row), 'cell')}, must have {len(names)} as the head line"
            )
    return Table(source, names, rows, lines)
