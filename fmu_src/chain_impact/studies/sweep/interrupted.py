"""The file that keeps the finished runs of an interrupted sweep until the sweep is complete.

Only a sweep whose table is one file has this file; a sweep into a folder continues from the folder.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from chain_impact.files import written_atomically
from chain_impact.scene.errors import SceneError
from chain_impact.studies.sweep.computation import Span

SUFFIX = ".partial"


def partial_path(table: Path) -> Path:
    """Return the path of the file with a table's finished runs: the table's path, with SUFFIX at the end."""
    return table.with_name(table.name + SUFFIX)


def is_complete(table: Path) -> bool:
    """Return whether the file of a table exists, and is not the unfinished table of an interrupted sweep."""
    if not table.exists() or not partial_path(table).is_file():
        return table.exists()
    with np.load(partial_path(table)) as stored_data:
        return bool(stored_data.get("beside_complete_table", False))


def store_finished_runs(
    table: Path,
    head: Mapping[str, Any],
    rows: np.ndarray,
    finished_spans: Sequence[Span],
    *,
    is_complete_table: bool,
) -> None:
    """Write the finished runs of an interrupted sweep to the file ``partial_path`` beside the table.

    Args:
        table: the path of the table.
        head: the data that identify the sweep (``sweep_identity``).
        rows: the rows of all runs of the sweep; those of runs that have not finished have no meaning.
        finished_spans: the spans of the finished runs.
        is_complete_table: whether the file of the table is complete (``is_complete``).

    Raises:
        OSError: when the file cannot be written.
    """
    spans = np.array(finished_spans, np.int64)
    with written_atomically(partial_path(table)) as new_file, new_file.open("wb") as file:
        np.savez(file, head=json.dumps(head), rows=rows, done=spans, beside_complete_table=is_complete_table)


def restore_runs(table: Path, head: Mapping[str, Any], rows: np.ndarray) -> list[Span]:
    """Copy the finished runs, which ``store_finished_runs`` wrote, into ``rows``; return their spans.

    ``head`` has the data that identify the sweep. Without a file of ``store_finished_runs`` the list of spans
    is empty.

    Raises:
        SceneError: when the file is damaged, or belongs to another sweep.
        OSError: when the file cannot be read.
    """
    path, advice = partial_path(table), "remove it, or choose another name"
    if not path.is_file():
        return []
    try:
        with np.load(path) as stored_data:
            stored_head, stored_rows, finished_spans = (
                json.loads(str(stored_data["head"])),
                stored_data["rows"],
                stored_data["done"].tolist(),
            )
    except (ValueError, KeyError, EOFError, zipfile.BadZipFile):
        raise SceneError(f"{path} does not come from an interrupted sweep: {advice}") from None
    if different_names := [name for name in head if stored_head.get(name) != head[name]]:
        raise SceneError(f"{path} was left by a sweep that differs in its {different_names[0]}: {advice}")
    spans = [(first, end) for first, end in finished_spans]
    for first, end in spans:
        rows[first:end] = stored_rows[first:end]
    return spans
