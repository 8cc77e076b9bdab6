"""The cache of compiled kernels: a folder for each state of the sources and compilers.

One process makes a file while other processes that need it wait. A file appears only when it is complete,
with its checksum beside it: a file that is cut or damaged later is made again. Nothing is read from a folder
that other users can write to (places.py).
"""

from __future__ import annotations

import functools
import hashlib
import os
import re
import shutil
import tempfile
import time
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from chain_impact.compilation.errors import BuildError
from chain_impact.compilation.places import base_folder, explained, trusted, writable
from chain_impact.compilation.sources import COMPILERS, fingerprint
from chain_impact.progress import log
from chain_impact.system import removal

UNUSED = 30 * 24 * 3600.0  # [s] age after which an unused folder for other sources is removed
LINKER = "chain-impact-zig-"  # first part of the name of the linker's own folder; its version follows
# names of folders for some sources and compilers, and of linkers' own folders
_OURS = re.compile(rf"[0-9a-f]{{16}}|{LINKER}.*")
PATIENCE = 1.0  # [s] waiting time after which the user is told that another process makes the kernel


def cache_folder() -> Path:
    """Return the folder for kernels of the present sources and compilers."""
    return base_folder() / _present()


def _present() -> str:
    """Return the name of the folder for the present sources and compilers."""
    return _digest(tuple(f"{name} {_version(name)}" for name in COMPILERS))


@functools.cache
def _digest(compilers: tuple[str, ...]) -> str:
    """Return 16 hexadecimal digits that identify the present sources and some compilers."""
    return hashlib.sha256("\n".join([fingerprint(), *compilers]).encode()).hexdigest()[:16]


def linker_folder() -> Path:
    """Return the folder that this version of the linker keeps for itself."""
    return writable(base_folder()) / f"{LINKER}{_version('ziglang')}"


@functools.cache
def _version(compiler: str) -> str:
    """Return the installed version of a compiler, or the version that would be installed."""
    try:
        return version(compiler)
    except PackageNotFoundError:
        return COMPILERS[compiler]


def find(name: str) -> Path | None:
    """Return a file or folder in the cache folder, if it is complete and no other user can write there."""
    folder = cache_folder()
    if not trusted(folder.parent) or not _is_whole(folder / name):
        return None
    with suppress(OSError):  # another user's cache can be read, but not marked as used
        os.utime(folder)  # marks the folder as used
    return folder / name


def _is_whole(path: Path) -> bool:
    """Return whether a folder exists, or a file exists with the bytes that it was made with."""
    try:
        return path.is_dir() or _mark(path).read_bytes() == _checksum(path)
    except OSError:
        return False


def _mark(file: Path) -> Path:
    """Return the path of the file with another file's checksum."""
    return file.with_name(f".{file.name}.crc32")


def _checksum(file: Path) -> bytes:
    return b"%08x" % zlib.crc32(file.read_bytes())


def holds(file: Path) -> bool:
    """Return whether a file is in the cache, from where it may be removed."""
    return base_folder() in file.parents


def made(name: str, make: Callable[[Path], None]) -> Path:
    """Return the file or folder with a name in the cache folder, and make it if it does not exist.

    Args:
        name: the name of the file or folder.
        make: writes the file or folder to a given path, in a temporary folder of its own.

    Raises:
        BuildError: when another process clears the cache meanwhile, or when nothing can be kept there.
    """
    found = find(name)
    if found:
        return found
    base = writable(base_folder())
    folder = base / _present()
    with explained(base):
        folder.mkdir(parents=True, exist_ok=True)
        with _locked(folder / f".{name}.lock"):
            if not find(name):
                with _scratch(folder, name) as scratch:
                    make(scratch / name)
                    if not (scratch / name).is_dir():
                        _mark(folder / name).write_bytes(_checksum(scratch / name))
                    (scratch / name).replace(folder / name)
                _prune(folder)
    return folder / name


@contextmanager
def _locked(path: Path) -> Iterator[None]:
    """Hold a lock, which the system releases when the process is killed."""
    from filelock import FileLock, Timeout

    lock = FileLock(path)
    try:
        lock.acquire(timeout=PATIENCE)
    except Timeout:
        log.debug("waiting for another process that compiles the kernel")
        lock.acquire()
    try:
        yield
    finally:
        lock.release()


@contextmanager
def _scratch(folder: Path, name: str) -> Iterator[Path]:
    """Give a temporary folder to make a file in.

    The folder is removed at the end, as are folders that killed processes have left under the same lock.

    Raises:
        BuildError: when another process has removed the folder meanwhile.
    """
    prefix = f".{name}-"
    for left in folder.glob(prefix + "*"):
        shutil.rmtree(left, ignore_errors=True)
    with tempfile.TemporaryDirectory(prefix=prefix, dir=folder) as scratch:
        try:
            yield Path(scratch)
        except FileNotFoundError:
            if Path(scratch).is_dir():
                raise
            raise BuildError(f"{folder} was removed while {name} was made there: try again") from None


def _prune(present: Path) -> None:
    """Remove the folders for other sources or of other linkers that have not been used for long."""
    for folder in present.parent.iterdir():
        with suppress(FileNotFoundError):  # another process removes old folders as well
            old = folder.stat().st_mtime < time.time() - UNUSED
            if old and _OURS.fullmatch(folder.name) and folder not in (present, linker_folder()):
                shutil.rmtree(folder, ignore_errors=True)


@dataclass(frozen=True)
class Entry:
    """A folder of the cache.

    Attributes:
        path: the folder.
        size: the size of all files in the folder [bytes].
        used: the time of the last use [s since 1970].
        files: the names of the finished files, without the linker's own.
    """

    path: Path
    size: int
    used: float
    files: tuple[str, ...]


def entries() -> list[Entry]:
    """Return the folders of the cache: those for some sources and compilers, and the linkers' own."""
    base = base_folder()
    folders = sorted(base.iterdir()) if trusted(base) else []
    return [_entry(path) for path in folders if path.is_dir() and _OURS.fullmatch(path.name)]


def clear() -> int:
    """Remove everything in the cache; return the number of bytes."""
    found = entries()
    for entry in found:
        with removal():
            shutil.rmtree(entry.path)
    return sum(entry.size for entry in found)


def _entry(path: Path) -> Entry:
    size = 0
    for file in path.rglob("*"):
        with suppress(FileNotFoundError):  # a compiler at work may remove its file
            size += file.lstat().st_size if not file.is_dir() else 0
    kernels = () if path.name.startswith(LINKER) else (p.name for p in path.iterdir() if p.name[0] != ".")
    return Entry(path, size, path.stat().st_mtime, tuple(sorted(kernels)))
