"""Simulate a scene or an FMU, write the files asked for, and print a summary."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import RenderableType
from rich.table import Table

from chain_impact.cli.options import UsageError, check_folders, is_fmu, settings_of
from chain_impact.cli.progress import out, progress
from chain_impact.cli.screen import plain_lines, sensitivity_tables, summary
from chain_impact.results.recording import Recording
from chain_impact.runs import RunError, record_fmu, record_scene
from chain_impact.scene import load_scene

if TYPE_CHECKING:
    from chain_impact.results.plots.overview import Draw


def report(
    source: str,
    settings: Sequence[str],
    csv: Path | None,
    picture: Path | None,
    sensitivities: Sequence[str] = (),
) -> Recording:
    """Simulate, write the files asked for and print a summary; also of what came before a fault."""
    check_folders(csv, picture)
    fault = None
    try:
        recording = record(source, settings, sensitivities)
    except RunError as error:
        if error.recording is None:
            raise
        recording, fault = error.recording, error
    if csv:
        recording.save_csv(csv)
        out.print(f"results  {csv}", markup=False, soft_wrap=True)
    if picture:
        from chain_impact.results.plots import plot

        plot(recording, picture, picture_of(sensitivities))
        out.print(f"picture  {picture}", markup=False, soft_wrap=True)
    show(summary(recording))
    if sensitivities:
        show(sensitivity_tables(recording))
    if fault:
        raise fault
    return recording


def picture_of(sensitivities: Sequence[str]) -> Draw:
    """What is drawn of a recording: its derivatives if some are named, else its motion."""
    from chain_impact.results.plots import fill, fill_sensitivities

    return fill_sensitivities if sensitivities else fill


def record(source: str, settings: Sequence[str], sensitivities: Sequence[str] = ()) -> Recording:
    """Simulate a scene or an FMU with parameters set by ``NAME=VALUE``.

    If no ``sensitivities`` are named, they are those that the scene asks for.
    """
    values = settings_of(settings)
    if sensitivities and is_fmu(source):
        raise UsageError(f"--sensitivity: {source} is an FMU; must be a scene")
    with progress() as (notify, advance):
        if is_fmu(source):
            return record_fmu(Path(source), values, advance)
        return record_scene(load_scene(source), values, notify, advance, sensitivities or None)


def show(parts: Iterable[RenderableType]) -> None:
    """Print one after the other: on a terminal as wide as that is, elsewhere whole lines."""
    for part in parts:
        if isinstance(part, Table) and not out.is_terminal:
            for line in plain_lines(part):
                out.print(line, markup=False, soft_wrap=True)
        else:
            out.print(part, soft_wrap=not isinstance(part, Table))
