"""Text files from other programs: their encoding, decimal mark and separator."""

from __future__ import annotations

import csv
import io
import itertools
import re
from collections.abc import Iterable
from pathlib import Path

from chain_impact.scene.texts.similar_names import name_with_one_typo

UTF_16 = (b"\xff\xfe", b"\xfe\xff")  # the byte order marks with which a file in UTF-16 can begin
ZIP = b"PK\x03\x04"  # first bytes of a ZIP file, such as an FMU or a spreadsheet
COMMA = re.compile(r"=\s*([+-]?\d+),(\d+)")  # a value with a decimal comma in a line of TOML
SEPARATORS = ";", "\t"  # the characters that can separate the cells of a table in place of commas
DECIMALS = re.compile(r"[+-]?\d*([.,])\d+(?:[eE][+-]?\d+)?")  # a number with a decimal mark


def text_of(path: Path) -> str:
    """Return the text of a file in UTF-8, with or without a byte order mark.

    Raises:
        ValueError: when the file is not text in UTF-8, such as a ZIP file; the message has the reason.
        OSError: when the file cannot be read.
    """
    content = path.read_bytes()
    if content.startswith(ZIP):
        raise ValueError("it is a ZIP file, such as an FMU or an Excel workbook; must be text in UTF-8")
    if content.startswith(UTF_16) or b"\0" in content:
        raise ValueError("it is in UTF-16, or no text; must be text in UTF-8")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        fault = f"line {line} has the byte 0x{content[error.start]:02x}, which is no UTF-8"
        raise ValueError(f"{fault}; must be text in UTF-8") from None


def comma_in(text: str, fault: str) -> str:
    """Return a hint for a decimal comma in the line of a TOML ``text`` that the message ``fault`` names.

    ``fault`` is the message of the parser. The result is "" if the line has no decimal comma, or if ``fault``
    names no line.
    """
    line = re.search(r"at line (\d+)", fault)
    lines = text.splitlines()
    match = COMMA.search(lines[int(line[1]) - 1]) if line and int(line[1]) <= len(lines) else None
    return f"; a number has a decimal point: {match[1]}.{match[2]}" if match else ""


def likely_time(names: Iterable[str]) -> str:
    """Return a hint with the column among ``names`` that is probably meant as ``time``; "" without one."""
    name = time_like(names)
    return f"; the column {name} may be meant: call it time, in seconds" if name else ""


def time_like(names: Iterable[str]) -> str | None:
    """Return the first of ``names`` that is a word of TIMES, such as ``Time (s)``; None without one.

    If no name is such a word, the result is the first name that is ``time`` with one typo, such as ``tme``. A
    unit in brackets must be one of UNITS_OF_TIME.
    """
    similar_name = None
    for name in names:
        word, _, unit = name.strip().strip('"').lower().replace("[", "(").partition("(")
        word = word.strip(" _")
        if unit.rstrip(") ]") not in UNITS_OF_TIME:
            continue
        if word in TIMES:
            return name
        similar_name = similar_name or (name_with_one_typo(word, ("time",)) and name)
    return similar_name


# words for a time, and units that may follow them, in the names of columns, all in lower case
TIMES = ("t", "time", "times", "timestamp", "zeit", "temps", "tiempo", "time_s", "t_s", "sec", "s", "seconds")
UNITS_OF_TIME = ("", "s", "sec", "seconds", "ms", "us", "µs", "min")


def comma_separated_text(text: str) -> str:
    """Return the text of a CSV table with commas between the cells and decimal points in the numbers.

    A table of one column, or with semicolons or tabs between the cells, may have decimal commas, and is
    rewritten. Any other text is returned unchanged.

    Raises:
        ValueError: when the numbers of such a table have decimal points and decimal commas, or when such a
            table is not valid CSV.
    """
    # in the head line, a separator inside quotes does not separate cells, nor does a tab beside a comma
    head = re.sub(r"\s*,\s*", ",", re.sub(r'"[^"]*"', "", text.partition("\n")[0]))
    lone_separator = SEPARATORS[0] if head.strip() and "," not in head else None  # table of one column
    mark = next(
        (mark for mark in SEPARATORS if mark in head and head.count(mark) >= head.count(",")), lone_separator
    )
    if mark is None:
        return text
    try:
        names, *rows = csv.reader(io.StringIO(text, newline=""), delimiter=mark)
    except csv.Error as error:
        raise ValueError(str(error)) from None
    cells = [[cell.strip() for cell in row] for row in rows]
    marks = {mark_match[1] for cell in itertools.chain(*cells) if (mark_match := DECIMALS.fullmatch(cell))}
    if len(marks) > 1:
        raise ValueError("its numbers have decimal points and decimal commas; must have one of them")
    rewritten = io.StringIO()
    written_cells = [
        [cell.replace(",", ".") if DECIMALS.fullmatch(cell) else cell for cell in row] if any(row) else []
        for row in cells
    ]
    csv.writer(rewritten, lineterminator="\n").writerows([names, *written_cells])
    return rewritten.getvalue()
