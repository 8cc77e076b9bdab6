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
    with np.load(partial_path(table)) as kept:
        return bool(kept.get("beside_complete_table", False))


def store_finished_runs(
    table: Path, head: Mapping[str, Any], rows: np.ndarray, done: Sequence[Span], *, complete: bool
) -> None:
    """Write the finished runs of an interrupted sweep to the file ``partial_path`` beside the table.

    Args:
        table: the path of the table.
        head: the data that identify the sweep (``sweep_identity``).
        rows: the rows of all runs of the sweep; those of runs that have not finished have no meaning.
        done: the spans of the finished runs.
        complete: whether the file of the table is complete (``is_complete``).

    Raises:
        OSError: when the file cannot be written.
    """
    spans = np.array(done, np.int64)
    with written_atomically(partial_path(table)) as fresh, fresh.open("wb") as file:
        np.savez(file, head=json.dumps(head), rows=rows, done=spans, beside_complete_table=complete)


def restore_runs(table: Path, head: Mapping[str, Any], rows: np.ndarray) -> list[Span]:
    """Copy the finished runs, which ``store_finished_runs`` wrote, into ``rows``; return their spans.

    ``head`` has the data that identify the sweep. Without a file of ``store_finished_runs`` the list of spans
    is empty.

    Raises:
        SceneError: when the file is damaged, or belongs to another sweep.
        OSError: when the file cannot be read.
    """
    path, wrong = partial_path(table), "remove it, or choose another name"
    if not path.is_file():
        return []
    try:
        with np.load(path) as kept:
            stored_head, old, done = json.loads(str(kept["head"])), kept["rows"], kept["done"].tolist()
    except (ValueError, KeyError, EOFError, zipfile.BadZipFile):
        raise SceneError(f"{path} does not come from an interrupted sweep: {wrong}") from None
    if differs := [name for name in head if stored_head.get(name) != head[name]]:
        raise SceneError(f"{path} was left by a sweep that differs in its {differs[0]}: {wrong}")
    spans = [(first, end) for first, end in done]
    for first, end in spans:
        rows[first:end] = old[first:end]
    return spans
