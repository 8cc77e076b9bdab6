"""The cache of compiled kernels: a folder for each state of the sources and compilers.

While one process makes a file, other processes that need the file wait. A file gets its name only when it is
complete, and its checksum is stored: if the file is cut or damaged later, it is made again. Nothing is read
from a folder to which other users can write (folders.py).
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
from chain_impact.compilation.folders import base_folder, explain_unwritable_folder, is_trusted, make_folder
from chain_impact.compilation.sources import COMPILERS, fingerprint
from chain_impact.files import removing_files
from chain_impact.progress import log

# [s] time without use after which a folder for other sources or compilers, or of another version of the
# linker, is removed
UNUSED_TIME = 30 * 24 * 3600.0
# the beginning of the name of the folder for the linker's own cache; the version of the linker follows
LINKER = "chain-impact-zig-"
# matches the names of the cache's folders for any state of sources and compilers, and any linker version
_OUR_NAMES = re.compile(rf"[0-9a-f]{{16}}|{LINKER}.*")
UNREPORTED_WAIT = 1.0  # [s] a process that waits longer for another one, which makes a kernel, logs a message


def present_kernel_folder() -> Path:
    """Return the cache's folder for kernels of the present sources and compilers."""
    return base_folder() / _present_name()


def _present_name() -> str:
    """Return the name of the cache's folder for the present sources and compilers."""
    return _digest(tuple(f"{name} {_compiler_version(name)}" for name in COMPILERS))


@functools.cache
def _digest(compilers: tuple[str, ...]) -> str:
    """Return 16 hexadecimal digits that identify the present sources and the given compilers."""
    return hashlib.sha256("\n".join([fingerprint(), *compilers]).encode()).hexdigest()[:16]


def linker_folder() -> Path:
    """Return the folder for the linker's own cache, with the version of the linker in its name.

    Raises:
        BuildError: when nothing can be stored in the cache.
    """
    return make_folder(base_folder()) / f"{LINKER}{_compiler_version('ziglang')}"


@functools.cache
def _compiler_version(compiler: str) -> str:
    """Return the version of a compiler: the installed one or, if it is not installed, the required one."""
    try:
        return version(compiler)
    except PackageNotFoundError:
        return COMPILERS[compiler]


def find(name: str) -> Path | None:
    """Return the path of the complete file or folder ``name`` of the cache; None if the cache has none.

    The result is None, too, if other users can write to the cache, because they could have changed the file.
    """
    folder = present_kernel_folder()
    if not is_trusted(folder.parent) or not _is_intact(folder / name):
        return None
    with suppress(OSError):  # a cache that root owns can be read, but its folder cannot be marked as used
        os.utime(folder)  # this marks the folder as used now, so that ``_prune`` keeps it
    return folder / name


def _is_intact(path: Path) -> bool:
    """Return whether ``path`` is a folder, or a file with the checksum that the mark of the file holds."""
    try:
        return path.is_dir() or _checksum_file(path).read_bytes() == _checksum(path)
    except OSError:
        return False


def _checksum_file(file: Path) -> Path:
    """Return the path of the mark of a file: another file in the same folder, with the file's checksum."""
    return file.with_name(f".{file.name}.crc32")


def _checksum(file: Path) -> bytes:
    return b"%08x" % zlib.crc32(file.read_bytes())


def is_in_cache(file: Path) -> bool:
    """Return whether a file is in the folder of the cache, so that ``clear`` may remove it."""
    return base_folder() in file.parents


def get_or_make(name: str, make: Callable[[Path], None]) -> Path:
    """Return the path of the file or folder ``name`` of the cache; make it if the cache has none.

    Args:
        name: the name of the file or folder.
        make: function that writes the file or folder to a given path in a temporary folder.

    Raises:
        BuildError: when another process clears the cache while the file is made, when the cache's folder
            cannot be written, or when other users can write to this folder.
    """
    existing = find(name)
    if existing:
        return existing
    base = make_folder(base_folder())
    folder = base / _present_name()
    with explain_unwritable_folder(base):
        folder.mkdir(parents=True, exist_ok=True)
        with _hold_lock(folder / f".{name}.lock"):
            if not find(name):
                with _temporary_folder(folder, name) as scratch:
                    make(scratch / name)
                    if not (scratch / name).is_dir():
                        _checksum_file(folder / name).write_bytes(_checksum(scratch / name))
                    (scratch / name).replace(folder / name)
                _prune(folder)
    return folder / name


@contextmanager
def _hold_lock(path: Path) -> Iterator[None]:
    """Context manager that holds the lock file ``path``, after waiting for other processes that hold it.

    The operating system releases the lock if the process is killed. A process that waits longer than
    UNREPORTED_WAIT logs a message and waits on.
    """
    from filelock import FileLock, Timeout

    lock = FileLock(path)
    try:
        lock.acquire(timeout=UNREPORTED_WAIT)
    except Timeout:
        log.debug("waiting for another process that compiles the kernel")
        lock.acquire()
    try:
        yield
    finally:
        lock.release()


@contextmanager
def _temporary_folder(folder: Path, name: str) -> Iterator[Path]:
    """Context manager that yields a temporary folder in ``folder`` for making ``name``, and then removes it.

    Temporary folders for the same name, which killed processes have left, are removed first.

    Raises:
        BuildError: when another process removes the temporary folder during the ``with`` block.
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
    """Remove the folders of the cache that have not been used for the time UNUSED_TIME.

    The folder ``present`` and the folder of the installed version of the linker stay.
    """
    for folder in present.parent.iterdir():
        with suppress(FileNotFoundError):  # another process may remove old folders at the same time
            is_old = folder.stat().st_mtime < time.time() - UNUSED_TIME
            if is_old and _OUR_NAMES.fullmatch(folder.name) and folder not in (present, linker_folder()):
                shutil.rmtree(folder, ignore_errors=True)


@dataclass(frozen=True)
class Entry:
    """A folder of the cache, for users who look at or clear the cache.

    Attributes:
        path: the folder.
        size: the size of all files in the folder [byte].
        used: the time of the last use [s since 1970].
        files: the sorted names of the finished files; empty for a folder of a linker.
    """

    path: Path
    size: int
    used: float
    files: tuple[str, ...]


def entries() -> list[Entry]:
    """Return the folders of the cache, sorted by their names.

    There is a folder for each state of the sources and compilers, and one for each version of the linker. The
    list is empty if there is no cache, or if other users can write to the cache.
    """
    base = base_folder()
    folders = sorted(base.iterdir()) if is_trusted(base) else []
    return [_read_entry(path) for path in folders if path.is_dir() and _OUR_NAMES.fullmatch(path.name)]


def clear() -> int:
    """Remove all folders that ``entries`` returns; return the number of removed bytes."""
    removed = entries()
    for entry in removed:
        with removing_files():
            shutil.rmtree(entry.path)
    return sum(entry.size for entry in removed)


def _read_entry(path: Path) -> Entry:
    size = 0
    for file in path.rglob("*"):
        with suppress(FileNotFoundError):  # a running compiler may remove its file at the same time
            size += file.lstat().st_size if not file.is_dir() else 0
    kernels = () if path.name.startswith(LINKER) else (p.name for p in path.iterdir() if p.name[0] != ".")
    return Entry(path, size, path.stat().st_mtime, tuple(sorted(kernels)))
