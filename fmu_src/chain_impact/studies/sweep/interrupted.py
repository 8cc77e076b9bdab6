"""The file with the finished runs of an interrupted sweep, which is kept until the sweep is complete."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from chain_impact.scene.reading import SceneError
from chain_impact.studies.sweep.computation import Span
from chain_impact.system import written_whole

SUFFIX = ".partial"


def partial_path(table: Path) -> Path:
    """Return the path of the file with the finished runs, in the folder of the table."""
    return table.with_name(table.name + SUFFIX)


def keep(table: Path, head: Mapping[str, Any], rows: np.ndarray, done: Sequence[Span]) -> None:
    """Write the rows of the finished runs, and the ``head`` that identifies the sweep.

    Raises:
        OSError: when the file cannot be written.
    """
    with written_whole(partial_path(table)) as fresh, fresh.open("wb") as file:
        np.savez(file, head=json.dumps(head), rows=rows, done=np.array(done, np.int64))


def take_up(table: Path, head: Mapping[str, Any], rows: np.ndarray) -> list[Span]:
    """Fill in the rows of an interrupted call of the same sweep; return the spans of these runs.

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
