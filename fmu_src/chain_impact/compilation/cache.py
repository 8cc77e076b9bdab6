"""The cache of compiled kernels: a folder for these sources and these compilers.

One process makes a file while others that need it wait. A file appears when it is whole, with its checksum
beside it: what is cut or damaged later is made again. Where others can write, nothing is read (places.py).
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

UNUSED = 30 * 24 * 3600.0  # s, after which a folder for other sources is removed
LINKER = "chain-impact-zig-"  # and a version: the name of the folder that this linker keeps for itself
_OURS = re.compile(rf"[0-9a-f]{{16}}|{LINKER}.*")  # folders for some sources and compilers, and of linkers
PATIENCE = 1.0  # s, after which it is said that another process is waited for


def cache_folder() -> Path:
    """The folder for kernels of these sources and compilers."""
    return base_folder() / _present()


def _present() -> str:
    """The name of that folder."""
    return _digest(tuple(f"{name} {_version(name)}" for name in COMPILERS))


@functools.cache
def _digest(compilers: tuple[str, ...]) -> str:
    """16 hexadecimal digits for these sources and some compilers."""
    return hashlib.sha256("\n".join([fingerprint(), *compilers]).encode()).hexdigest()[:16]


def linker_folder() -> Path:
    """The folder that this version of the linker keeps for itself."""
    return writable(base_folder()) / f"{LINKER}{_version('ziglang')}"


@functools.cache
def _version(compiler: str) -> str:
    """The version that is installed, or that would be."""
    try:
        return version(compiler)
    except PackageNotFoundError:
        return COMPILERS[compiler]


def find(name: str) -> Path | None:
    """The file or folder of that name in the cache folder, if it is whole and nobody else can write there."""
    folder = cache_folder()
    if not trusted(folder.parent) or not _is_whole(folder / name):
        return None
    with suppress(OSError):  # somebody else's cache can be read
        os.utime(folder)  # it is in use
    return folder / name


def _is_whole(path: Path) -> bool:
    """Whether a folder, or a file as it was made, is there."""
    try:
        return path.is_dir() or _mark(path).read_bytes() == _checksum(path)
    except OSError:
        return False


def _mark(file: Path) -> Path:
    """The file with the checksum of another one."""
    return file.with_name(f".{file.name}.crc32")


def _checksum(file: Path) -> bytes:
    return b"%08x" % zlib.crc32(file.read_bytes())


def holds(file: Path) -> bool:
    """Whether a file is in the cache, and so may be removed from there."""
    return base_folder() in file.parents


def made(name: str, make: Callable[[Path], None]) -> Path:
    """Return the file or folder of that name in the cache folder; if it is not there, make it.

    Args:
        name: of the file or folder.
        make: writes it to the path that it is given, in a folder for itself.

    Raises:
        BuildError: when the cache is cleared meanwhile, or nothing can be kept in it.
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
    """Hold a lock, which the system gives back when a process is killed."""
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
    """A folder to make a file in, removed in the end; also those that were left behind under the same lock.

    Raises:
        BuildError: when somebody else has removed it meanwhile.
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
    """Remove the folders for other sources, or of other linkers, that nobody has used for long."""
    for folder in present.parent.iterdir():
        with suppress(FileNotFoundError):  # another process prunes, too
            old = folder.stat().st_mtime < time.time() - UNUSED
            if old and _OURS.fullmatch(folder.name) and folder not in (present, linker_folder()):
                shutil.rmtree(folder, ignore_errors=True)


@dataclass(frozen=True)
class Entry:
    """A folder of the cache.

    Attributes:
        path: where it is.
        size: of all that is in it [bytes].
        used: when it was last used [s since 1970].
        files: the names of the kernels and whatever else is finished in it; none of the linker's.
    """

    path: Path
    size: int
    used: float
    files: tuple[str, ...]


def entries() -> list[Entry]:
    """What is in the cache: folders for some sources and compilers, and the linker's own."""
    base = base_folder()
    folders = sorted(base.iterdir()) if trusted(base) else []
    return [_entry(path) for path in folders if path.is_dir() and _OURS.fullmatch(path.name)]


def clear() -> int:
    """Remove all that is in the cache; return how many bytes that were."""
    found = entries()
    for entry in found:
        with removal():
            shutil.rmtree(entry.path)
    return sum(entry.size for entry in found)


def _entry(path: Path) -> Entry:
    size = 0
    for file in path.rglob("*"):
        with suppress(FileNotFoundError):  # of a compiler at work
            size += file.lstat().st_size if not file.is_dir() else 0
    kernels = () if path.name.startswith(LINKER) else (p.name for p in path.iterdir() if p.name[0] != ".")
    return Entry(path, size, path.stat().st_mtime, tuple(sorted(kernels)))
