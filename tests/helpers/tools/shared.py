"""Files that all workers of a test session share; the first worker that needs a file makes it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from filelock import FileLock


def shared_folder(factory: pytest.TempPathFactory, name: str) -> Path:
    """Return a folder with a name that is the same for all workers of this session."""
    own = factory.getbasetemp()
    # pytest-xdist puts the folders of its workers into a folder of the session
    session = own.parent if own.name.startswith("popen-") else own
    folder = session / "shared" / name
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def make_once(path: Path, make: Callable[[Path], object]) -> Path:
    """Return the file or folder at a path; ``make`` writes it if no worker has done so, while others wait."""
    with FileLock(f"{path}.lock"):
        if not path.exists():
            unfinished = path.with_name(f"{path.name}.unfinished")
            make(unfinished)
            unfinished.rename(path)
    return path
