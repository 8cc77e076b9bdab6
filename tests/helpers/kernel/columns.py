"""Tables of a plain record: columns by their names, and rows by their numbers."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any


class Columns(SimpleNamespace):
    """The columns of a table; an index gives a row."""

    def __getitem__(self, row: int) -> dict[str, Any]:
        return {name: column[row] for name, column in vars(self).items()}

    def __setitem__(self, row: int, values: dict[str, Any]) -> None:
        for name, column in vars(self).items():
            column[row] = values[name]
