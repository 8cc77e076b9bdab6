"""The cache of compiled kernels: a folder for these sources and these compilers.

One process makes a file while others that need it wait. A file appears when it is whole.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import platformdirs
from filelock import FileLock

from chain_impact.compilation.sources import fingerprint

COMPILERS = {"llvmlite": "0.50.0", "numba": "0.68.1", "ziglang": "0.17.0"}
"""The compilers and their versions, which must agree; those of the extra in pyproject.toml."""
UNUSED = 30 * 24 * 3600.0  # s, after which a folder for other sources is removed
ZIG = "zig"  # in the cache, what the linker keeps for itself
_NAME = re.compile(r"[0-9a-f]{16}")  # of a folder for some sources and compilers


def base_folder() -> Path:
    """Where all that is cached lies: ``CHAIN_IMPACT_CACHE``, or the user's cache folder."""
    return Path(os.environ.get("CHAIN_IMPACT_CACHE") or platformdirs.user_cache_dir("chain-impact"))


def cache_folder() -> Path:
    """The folder for kernels of these sources and compilers."""
    digest = hashlib.sha256(fingerprint().encode())
    for name in COMPILERS:
        digest.update(f"\n{name} {_version(name)}".encode())
    return base_folder() / digest.hexdigest()[:16]


def _version(compiler: str) -> str:
    """The version that is installed, or that would be."""
    try:
        return version(compiler)
    except PackageNotFoundError:
        return COMPILERS[compiler]


def find(name: str) -> Path | None:
    """The file of that name in the cache folder, if it is there."""
    file = cache_folder() / name
    if not file.exists():
        return None
    os.utime(file.parent)  # it is in use
    return file


def made(name: str, make: Callable[[Path], None]) -> Path:
    """Return the file of that name in the cache folder; if it is not there, make it.

    Args:
        name: of the file.
        make: writes it to the path that it is given, in a folder for itself.
    """
    found = find(name)
    if found:
        return found
    folder = cache_folder()
    folder.mkdir(parents=True, exist_ok=True)
    # the system gives the lock back when a process is killed
    with FileLock(folder / f".{name}.lock"):
        if not find(name):
            with _scratch(folder, f".{name}-") as scratch:
                make(scratch / name)
                (scratch / name).replace(folder / name)
            _prune(folder)
    return folder / name


@contextmanager
def _scratch(folder: Path, prefix: str) -> Iterator[Path]:
    """A folder that is removed in the end; also those that were left behind under the same lock."""
    for left in folder.glob(prefix + "*"):
        shutil.rmtree(left, ignore_errors=True)
    with tempfile.TemporaryDirectory(prefix=prefix, dir=folder) as scratch:
        yield Path(scratch)


def _prune(present: Path) -> None:
    """Remove the folders for other sources that nobody has used for long."""
    for folder in present.parent.iterdir():
        old = _NAME.fullmatch(folder.name) and folder.stat().st_mtime < time.time() - UNUSED
        if old and folder != present:
            shutil.rmtree(folder, ignore_errors=True)


@dataclass(frozen=True)
class Entry:
    """A folder of the cache.

    Attributes:
        path: where it is.
        size: of all that is in it [bytes].
        used: when it was last used [s since 1970].
        files: the names of the files in it.
    """

    path: Path
    size: int
    used: float
    files: tuple[str, ...]


def entries() -> list[Entry]:
    """What is in the cache: the folders for some sources and compilers, and the linker's own."""
    base = base_folder()
    folders = sorted(base.iterdir()) if base.is_dir() else []
    return [_entry(path) for path in folders if path.is_dir() and _ours(path.name)]


def clear() -> int:
    """Remove all that is in the cache; return how many bytes that were."""
    found = entries()
    for entry in found:
        shutil.rmtree(entry.path)
    return sum(entry.size for entry in found)


def _ours(name: str) -> bool:
    return name == ZIG or _NAME.fullmatch(name) is not None


def _entry(path: Path) -> Entry:
    files = [file for file in path.rglob("*") if file.is_file()]
    shown = tuple(sorted(file.name for file in path.iterdir() if file.is_file() and file.name[0] != "."))
    return Entry(path, sum(file.stat().st_size for file in files), path.stat().st_mtime, shown)
