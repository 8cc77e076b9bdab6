"""`chain-impact info`: what a scene or an FMU holds."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

from rich.markup import escape

from chain_impact.cli.options import Verbs, add_scene, is_fmu
from chain_impact.cli.progress import out
from chain_impact.runs import read_fmu
from chain_impact.scene import load_scene, scene_to_dict


def add(verbs: Verbs) -> None:
    """Add the verb to the grammar."""
    info = verbs.add_parser("info", help="say what a scene or an FMU holds")
    add_scene(info, "scene or FMU")
    info.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Say what a scene or an FMU holds."""
    facts: list[tuple[str, object]] = []
    if is_fmu(options.source):
        from fmpy import supported_platforms

        held = read_fmu(Path(options.source))
        name, description, variables = held.modelName, held.description or "", held.modelVariables
        facts += [("FMI version", held.fmiVersion), ("made by", held.generationTool), ("guid", held.guid)]
        facts += [("platforms", ", ".join(supported_platforms(options.source)))]
        if held.defaultExperiment:
            facts += [(key, getattr(held.defaultExperiment, key)) for key in ("stopTime", "stepSize")]
        facts += [(v.name, v.start) for v in variables if v.causality == "parameter"]
    else:
        from chain_impact.variables import fmu_variables

        scene = load_scene(options.source)
        name, description, variables = scene.name, scene.description, fmu_variables(scene)
        facts += [pair for pair in _flatten(scene_to_dict(scene)) if pair[0] not in {"name", "description"}]
    out.print(f"[bold]{escape(name)}[/]  {escape(description)}", soft_wrap=True)
    for key, value in facts:
        out.print(f"  {key} = {value}", markup=False, soft_wrap=True)
    out.print("\n[bold]Variables of the FMU[/]")
    rows = [(v.name, v.causality, v.variability, v.unit or "", v.description or "") for v in variables]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        cells = (cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        out.print(f"  {'  '.join(cells).rstrip()}", markup=False, soft_wrap=True)
    return 0


def _flatten(table: dict[str, object], prefix: str = "") -> Iterator[tuple[str, object]]:
    for key, value in table.items():
        if isinstance(value, dict):
            yield from _flatten(value, f"{prefix}{key}.")
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            for i, entry in enumerate(value, start=1):
                yield from _flatten(entry, f"{prefix}{key}[{i}].")
        else:
            yield prefix + key, value
