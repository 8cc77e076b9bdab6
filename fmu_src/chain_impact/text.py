"""Writes counts, names, numbers and tables of results as text."""

from __future__ import annotations

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from html import escape
from itertools import groupby, zip_longest
from typing import NamedTuple


def count_text(count: int, noun: str) -> str:
    """Return a count with its noun, for example 1 impact, 2 impacts, 3 boxes."""
    ending = "es" if noun.endswith(("sh", "ch", "x")) else "s"
    return f"{count} {noun}{ending if count != 1 else ''}"


def names_text(names: Sequence[str], shown_count: int) -> str:
    """Return the first ``shown_count`` names and, if there are others, their number: "a, b and 3 more"."""
    more_text = f" and {len(names) - shown_count} more" if len(names) > shown_count else ""
    return f"{', '.join(names[:shown_count])}{more_text}"


def number_text(value: float, digits: int = 4) -> str:
    """Return a number as text with at most ``digits`` significant digits: 0.5, 1e8, 2.145e10.

    A fraction has no zeros at its end, an exponent none at its start.
    """
    return re.sub(r"e\+?(-?)0*", r"e\1", f"{value:.{digits}g}")


def span_text(low: float, high: float) -> str:
    """Return two numbers with three significant digits each, as "0.750 to 1.12"; equal ones only once."""
    texts = (
        f"{end:#.3g}".rstrip(".") if abs(end) < LEAST_EXPONENT else number_text(end, 3) for end in (low, high)
    )
    return " to ".join(dict.fromkeys(texts))


LEAST_EXPONENT = 999.5  # from this size on, a number with three digits has an exponent
LEAST_WHOLE = 99.5  # from this size on, a number with two digits would have an exponent, as in 1e+02


def signed_text(value: float) -> str:
    """Return a number with its sign to two significant digits; as a whole number if |value| ≥ LEAST_WHOLE."""
    return f"{value:+#.2g}".rstrip(".") if abs(value) < LEAST_WHOLE else f"{value:+.0f}"


PREFIXES = {-12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T"}
"""Power of ten → prefix of a unit."""


LOAD_UNITS = ("N", "N.m", "N.s", "N.m.s", "J", "W")
"""Units of forces, moments, impulses, energies and powers.

Large and small values get a prefix, as in kN, so that they have few digits.
"""


def prefixed_unit(largest_value: float, unit: str) -> tuple[float, str]:
    """Return a factor and a unit with a prefix, such as 0.001 and kN: values times the factor have this unit.

    In this unit ``largest_value`` is at least 1 and below 1000, if a prefix for this exists.
    """
    power = 3 * math.floor(math.log10(largest_value) / 3.0) if 0.0 < largest_value < math.inf else 0
    power = min(max(power, min(PREFIXES)), max(PREFIXES))
    return 10.0**-power, f"{PREFIXES[power]}{unit}"


# the units that get a prefix for small and large values, as in mm
PREFIXED_UNITS = (*LOAD_UNITS, "m", "m/s", "m/s2", "s", "rad", "rad/s")


def readable_unit(largest_value: float, unit: str) -> tuple[float, str]:
    """Return ``prefixed_unit`` for a unit in PREFIXED_UNITS; any other unit stays, with the factor 1.

    ``largest_value`` is the largest |value| that is shown in the unit.
    """
    return prefixed_unit(largest_value, unit) if unit in PREFIXED_UNITS else (1.0, unit)


def aligned_lines(head: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """Yield the lines of a table with columns as narrow as possible.

    ``head`` has the head of each column; the lines of a head are separated by line breaks, and its last line
    is next to the rows. Each of the ``rows`` must have as many cells.
    """
    heads = list(zip_longest(*(name.split("\n")[::-1] for name in head), fillvalue=""))[::-1]
    widths = [max(map(len, column)) for column in zip(*heads, *rows, strict=True)]
    for row in (*heads, *rows):
        yield "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()


class TextTable(NamedTuple):
    """A table of texts: the heads of its columns, and its rows."""

    head: Sequence[str]
    rows: Sequence[Sequence[str]]


def as_text(parts: Iterable[str | TextTable]) -> str:
    """Return lines and tables as a text of several lines."""
    blocks = ([part] if isinstance(part, str) else aligned_lines(*part) for part in parts)
    return "\n".join(line for block in blocks for line in block)


def as_html(parts: Iterable[str | TextTable]) -> str:
    """Return lines and tables as HTML for a notebook; the first line is a title in bold letters."""
    title, *table_rows = parts
    blocks = [f"<b>{escape(str(title))}</b>"]
    for is_table, group in groupby(table_rows, lambda part: isinstance(part, TextTable)):
        for part in group if is_table else ["\n".join(map(str, group)).strip("\n")]:
            blocks.append(html_table(*part) if isinstance(part, TextTable) else f"<pre>{escape(part)}</pre>")
    return f"<div>{''.join(blocks)}</div>"


class PrintedResult(ABC):
    """An object whose text is lines and tables: plain text, and HTML in a notebook."""

    @abstractmethod
    def _lines_and_tables(self, *, in_notebook: bool) -> Iterable[str | TextTable]:
        """Return the lines and tables of the text; in a notebook there may be more."""

    def __repr__(self) -> str:
        """Return the object as text of several lines."""
        return as_text(self._lines_and_tables(in_notebook=False))

    def _repr_html_(self) -> str:
        """Return the object as HTML for a notebook."""
        return as_html(self._lines_and_tables(in_notebook=True))


def html_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table of texts as HTML; each row is one line of the HTML."""
    cells = [("th", head), *(("td", row) for row in rows)]
    lines = ("".join(f"<{tag}>{_html_lines(cell)}</{tag}>" for cell in row) for tag, row in cells)
    return "<table>" + "\n".join(f"<tr>{line}</tr>" for line in lines) + "</table>"


def _html_lines(text: str) -> str:
    return escape(text).replace("\n", "<br>")
