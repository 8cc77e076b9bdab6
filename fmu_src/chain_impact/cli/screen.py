"""What the command line prints of a simulation and of a comparison."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from datetime import datetime
from pathlib import Path

from rich.console import RenderableType
from rich.markup import escape
from rich.table import Table

from chain_impact.compilation.cache import LINKER, Entry
from chain_impact.results.recording import Recording
from chain_impact.results.summary import energy_lines, plural
from chain_impact.studies.compare import Comparison, LawRun, advice

NOTHING = "–"


def summary(recording: Recording) -> Iterator[RenderableType]:
    """Impacts and energy balance."""
    table = Table("#", "time, s", "point", "wall", "speed, m/s", box=None, header_style="bold")
    for number, impact in enumerate(recording.impacts, start=1):
        table.add_row(
            str(number), f"{impact.time:.6f}", str(impact.point), impact.wall, f"{impact.speed:.4f}"
        )
    count, listed = recording.impact_count, len(recording.impacts)
    impacts = plural(count, "impact")
    if listed < count:
        impacts += f", {listed} listed: an FMU tells only the last one in a communication step"
    yield f"\n[bold]{escape(recording.name)}[/]  0 … {recording.time[-1]:g} s, {impacts}"
    yield table
    yield from energy_lines(recording.columns)


def law_table(comparison: Comparison) -> Iterator[str]:
    """The laws side by side, and which to take."""
    scene, impact = comparison.scene, comparison.first_impact
    contact = scene.contact
    yield (
        f"\n[bold]{escape(scene.name)}[/]  e = {contact.restitution:g}, n = {contact.exponent:g}, "
        f"K = {contact.stiffness:.4g}; first impact at {impact['onset']:.6g} s with "
        f"{impact['effective_mass']:.4g} kg at {impact['impact_speed']:.4g} m/s"
    )
    head = ("law", "e′", "peak, kN", "depth, mm", "time, ms", "lost, J", "impacts", "differs at", "steps", "")
    rows = [head, *(_row(run) for run in comparison.runs)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        first, *others = (cell.rjust(width) for cell, width in zip(row[:-1], widths, strict=False))
        line = escape("  ".join([first.strip().ljust(widths[0]), *others, row[-1]]).rstrip())
        yield f"[bold]{line}[/]" if row is head else line
    yield "e′ … lost: of the first impact. differs at: the first impact elsewhere than with " + (
        f"{comparison.reference}, and its time, s"
    )
    for number, line in enumerate(advice(comparison)):
        yield escape(f"{'' if number else 'advice':9}{line}")


def _row(run: LawRun) -> tuple[str, ...]:
    differs = NOTHING if run.divergence is None else f"{run.divergence}, {run.divergence_time:.4f}"
    return (
        run.law,
        _number(run.restitution, ".4f"),
        _number(1e-3 * run.peak_force, "#.4g"),
        _number(1e3 * run.max_penetration, "#.4g"),
        _number(1e3 * run.duration, "#.4g"),
        _number(run.energy_lost, "#.4g"),
        str(run.impacts) if run.result else NOTHING,
        differs,
        str(run.steps) if run.result else NOTHING,
        run.note,
    )


def _number(value: float, form: str) -> str:
    return NOTHING if math.isnan(value) else "∞" if math.isinf(value) else format(value, form)


def cache_report(ready: Sequence[Path], entries: Sequence[Entry], present: Path) -> Iterator[str]:
    """What there is of compiled kernels: ready ones, and the folders of the cache, of which one is in use."""
    yield "ready    " + (f"{len(ready)} kernels in {ready[0].parent}" if ready else NOTHING)
    yield f"cache    {present.parent}, {sum(entry.size for entry in entries) / 1e6:.1f} MB"
    for entry in entries:
        what = "of the linker" if entry.path.name.startswith(LINKER) else ", ".join(entry.files)
        used = datetime.fromtimestamp(entry.used).strftime("%Y-%m-%d")
        mark = " (in use)" if entry.path == present else ""
        yield f"  {entry.path.name}  {entry.size / 1e6:5.1f} MB  last used {used}{mark}: {what}"
