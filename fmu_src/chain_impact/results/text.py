"""Words for results."""

from __future__ import annotations

from collections.abc import Iterator, Sequence


def plural(count: int, what: str) -> str:
    """For example: 1 impact, 2 impacts."""
    return f"{count} {what}{'s' if count != 1 else ''}"


def what(number: int, at_stop: bool) -> str:
    """What touched: "point 2", of a stop "joint 2"."""
    return f"{'joint' if at_stop else 'point'} {number}"


def speed_unit(at_stop: bool) -> str:
    """The unit of a speed of an impact."""
    return "rad/s" if at_stop else "m/s"


def aligned(head: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """The lines of a table; its columns are as wide as they need to be."""
    widths = [max(map(len, column)) for column in zip(head, *rows, strict=True)]
    for row in (head, *rows):
        yield "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
