"""The tables and lines that the command line prints on a run, a comparison of laws, or an FMU's variables."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import fields
from io import StringIO
from textwrap import wrap
from typing import Any

import numpy as np
from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from chain_impact.cli.printing import out, plain_console, say
from chain_impact.kernel.record.constants import STICKS
from chain_impact.recording.bodies import sites_of_links
from chain_impact.recording.impacts import cut_sentence
from chain_impact.recording.recording import Recording
from chain_impact.recording.rest import rest_lines
from chain_impact.recording.stick_slip import phase_cells
from chain_impact.recording.summary import (
    LISTED_IMPACTS,
    energy_lines,
    impact_list,
    load_lines,
    passed_wall_lines,
)
from chain_impact.results.result import Result
from chain_impact.scene.keys.tables import Box
from chain_impact.scene.texts.unit_text import unit_text
from chain_impact.studies.compare.compare import Comparison
from chain_impact.studies.compare.text import (
    advice,
    comparison_heading,
    format_number,
    law_table as compared,
    legend,
)
from chain_impact.text import TextTable, count_text

# matches the separators in the description of a variable such as solver.status, before each number with a
# meaning: ": " and "; " in "status: 0 running; 1 ended"
CODES = re.compile(r": (?=0 [^,]*;)|; (?=\d+ )")
PHASES = 8  # the table of dry friction has the first PHASES phases; a line counts further phases
CHANGE_COLUMNS = {
    "impact_speed": "speed",
    "separation_speed": "rebound",
    "peak_force": "peak",
    "max_penetration": "depth",
    "duration": "duration",
    "impulse": "impulse",
}
"""Quantity of an impact → the word in the head of a table, over the changes of this quantity in percent."""
SIDES = {side.name: side.metadata["description"] for side in fields(Box)}
"""Name of a wall of the box → words for its place."""


def borderless_table(head: Sequence[str], numbers: Sequence[str] = ()) -> Table:
    """Return a table without rows and borders, whose columns have the heads ``head``.

    ``numbers`` are the heads of the columns that are aligned to the right.
    """
    table = Table(box=None, header_style="bold")
    for name in head:
        table.add_column(name, justify="right" if name in numbers else "left", no_wrap=name == head[0])
    return table


def show(parts: Iterable[RenderableType]) -> None:
    """Print lines and tables one after the other.

    On a terminal, a table is fitted to the width of the terminal. Elsewhere, such as in a file, it has the
    width that its cells need.
    """
    for part in parts:
        if isinstance(part, Table) and not out.is_terminal:
            for line in plain_lines(part):
                say(line)
        else:
            out.print(part, soft_wrap=not isinstance(part, Table))


def plain_lines(table: Table) -> Iterator[str]:
    """Yield the lines of a table in the width that its cells need, without colours."""
    wide_console = plain_console(file=StringIO(), width=10_000, color_system=None)
    with wide_console.capture() as captured:
        wide_console.print(table)
    yield from (line.rstrip() for line in captured.get().splitlines())


def headline_lines(bold_text: str, other_text: str = "") -> Text:
    """Return an empty line, and a line with the text ``bold_text`` in bold, then ``other_text``."""
    return Text.assemble("\n", (bold_text, "bold"), other_text)


def variable_lines(variables: Iterable[Any], width: int) -> Iterator[str]:
    """Yield the lines of a table with the variables of an FMU, with ``width`` characters in a line.

    A description that does not fit beside the other columns stands in the next lines, indented. If a
    description tells the meanings of numbers (CODES), each number is in a line of its own.
    """
    contents = [
        (v.name, v.causality, v.variability, unit_text(v.unit), v.description or "") for v in variables
    ]
    rows = [("name", "causality", "variability", "unit", "meaning"), *contents]
    widths = [max(map(len, column)) for column in list(zip(*rows, strict=True))[:-1]]
    for *cells, description in rows:
        meaning, *codes = CODES.split(description)
        cells_text = "  ".join(f"{cell:{room}}" for cell, room in zip(cells, widths, strict=True))
        if len(cells_text) + 2 + len(meaning) <= width:
            yield f"{cells_text}  {meaning}".rstrip()
        else:
            yield cells_text.rstrip()
            yield from indented_lines(meaning, width, 4)
        for code in codes:
            yield from indented_lines(code, width, 6, hanging=3)


def indented_lines(text: str, width: int, indent: int, hanging: int = 0) -> list[str]:
    """Return the lines into which a text is broken, indented by ``indent`` characters.

    Lines after the first one are indented by ``hanging`` characters more. A line has at most ``width``
    characters with its indentation, unless a single word is longer.
    """
    start, later_indent = " " * indent, " " * (indent + hanging)
    return wrap(text, width, initial_indent=start, subsequent_indent=later_indent, break_long_words=False)


def summary(recording: Recording) -> Iterator[RenderableType]:
    """Yield lines and tables of the summary of a run: impacts, dry friction, rest, loads, energies."""
    count, listed_count = recording.impact_count, len(recording.impacts)
    impacts = count_text(count, "impact")
    if listed_count < count:
        impacts += f", {listed_count} listed: an FMU shows only the latest in a communication step"
    yield headline_lines(recording.name, f"  0 … {recording.time[-1]:g} s, {impacts}")
    for part in with_screen_tables(impact_list(recording, LISTED_IMPACTS)):
        yield f"{part}; --impacts FILE writes all" if isinstance(part, str) else part
    yield from impact_table_notes(recording)
    yield from passed_wall_lines(recording)
    yield from stick_slip_parts(recording)
    yield from rest_lines(recording)
    yield from load_lines(recording)
    yield from energy_lines(recording.energies)


def with_screen_tables(parts: Iterable[str | TextTable]) -> Iterator[RenderableType]:
    """Yield ``parts``, with each table of texts replaced by a table for the screen."""
    for part in parts:
        if isinstance(part, str):
            yield part
            continue
        table = borderless_table(part.head)
        for row in part.rows:
            table.add_row(*row)
        yield table


def impact_table_notes(recording: Recording) -> Iterator[str]:
    """Yield lines that explain the numbers of points and the names of walls in the table of impacts.

    If the peak force of some impacts, but not of all, is unknown, as in the recording of an FMU, a further
    line tells the number of these impacts.
    """
    hits = [row for row in recording.impacts if recording.touching_part(row).startswith("point")]
    hit = {recording.wall_names[row["wall"]] for row in hits}
    if hit:
        last, has_points = recording.link_count, max(row["point"] for row in hits) > recording.link_count
        ends_text = "0 is the first end of the chain, 1 the end of its first link, and so on"
        if last == 1:
            ends_text = "0 is the first end of the link, 1 its other end"
        elif has_points:
            ends_text += f" to {last}"
        yield f"point    {ends_text}" + (f"; {site_numbers(recording)}" if has_points else "")
    sides = [f"{wall} is the {side}" for wall, side in SIDES.items() if wall in hit]
    for name, wall in recording.walls.items():
        if name in hit and name not in SIDES:
            x, y = wall.normal
            sides.append(f"{name} has the angle {math.degrees(math.atan2(0.0 - x, y)):.4g} deg")
    if sides:
        yield f"wall     {', '.join(sides)}"
    is_cut = np.isnan(recording.impacts["peak_force"])
    if is_cut.any() and not is_cut.all():
        yield f"note     {cut_sentence(int(is_cut.sum()))}"


def site_numbers(recording: Recording) -> str:
    """Return words for the numbers of the sites, the points of links other than the ends: "2–5 on link 1".

    If the recording does not tell the links of these points, the words are "from 2 on the points of links".
    """
    first, parts = recording.link_count + 1, []
    for link, count in sites_of_links(recording.parameters).items():
        last = first + count - 1
        parts.append(f"{first}–{last} on link {link}" if last > first else f"{first} on link {link}")
        first = last + 1
    return ", ".join(parts) or f"from {first} on the points of links"


def stick_slip_parts(recording: Recording) -> Iterator[RenderableType]:
    """Yield a table of the first phases of sticking and sliding, and explanations.

    Nothing is yielded if the recording has no phases.
    """
    phases = recording.stick_slip
    if not len(phases):
        return
    table = borderless_table(("start, s", "end, s", "dry friction", "mode"), ("start, s", "end, s"))
    for phase in phases[:PHASES]:
        table.add_row(*phase_cells(phase, recording.wall_names, recording.point_names))
    yield table
    if len(phases) > PHASES:
        more_phases, sticking = phases[PHASES:], int((phases[PHASES:]["mode"] == STICKS).sum())
        remedy = "; Result.stick_slip in Python has all" if isinstance(recording, Result) else ""
        yield (
            f"and {count_text(len(more_phases), 'more phase')} of dry friction, {sticking} of sticking, "
            f"the last from {more_phases['start'][-1]:.6f} s on{remedy}"
        )
    if (phases["mode"] != STICKS).any():
        yield "mode     slip + along +x at a floor, or with a positive rate in a joint; slip - the other way"


def sensitivity_tables(recording: Recording) -> Iterator[RenderableType]:
    """Yield for each parameter or input with derivatives a heading and a table with the changes of impacts.

    The heading has a small change of the parameter, such as 1 %. The table has the changes of the impacts by
    this change, to first order: of the onset in ms, of other quantities in percent. In a run without impacts,
    a text replaces each table. After all tables, sentences tell of derivatives that do not exist, are
    one-sided or inexact. Nothing is yielded if the run has no derivatives.
    """
    sensitivities = recording.sensitivities
    if not sensitivities:
        return
    columns = [
        1e3 * sensitivities.impact_changes("onset"),
        *(100.0 * sensitivities.relative(name) for name in CHANGE_COLUMNS),
    ]
    head = ("#", "onset, ms", *(f"{word}, %" for word in CHANGE_COLUMNS.values()))
    for k, parameter in enumerate(sensitivities.parameters):
        change_text = f"{parameter} + {sensitivities.step_text(parameter)}"
        yield headline_lines(f"Change of the impacts for {change_text}")
        table = borderless_table(head, head[1:])
        for row in range(len(sensitivities.impacts)):
            cells = (column[row, k] for column in columns)
            table.add_row(str(row + 1), *(format_number(cell, "+.3g") if cell else "0" for cell in cells))
        yield table if len(sensitivities.impacts) else "no impact"
    for limit in sensitivities.limits:
        yield f"limit    {limit}"


def law_table_parts(comparison: Comparison) -> Iterator[RenderableType]:
    """Yield a heading, the table of a comparison of laws, the legend of the table, and advice on the laws."""
    yield f"\n{comparison_heading(comparison)}"
    laws = compared(comparison)
    table = borderless_table(laws.head, laws.head[1:-1])
    for row in laws.rows:
        table.add_row(*row)
    yield table
    yield legend(comparison)
    yield f"advice   {advice(comparison)}"
