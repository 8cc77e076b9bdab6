"""What is kept of a sweep that is not finished, beside the file that its table will go to.

The file begins with one line of JSON, which says what sweep it is. Then come blocks, in the order in which
they were done: the number of the first run, how many runs, a checksum, and their rows as they are in memory.
A block that was not written to its end, as of a process that was killed, is cut off when the sweep goes on.
"""

from __future__ import annotations

import errno
import hashlib
import json
import struct
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

import numpy as np

from chain_impact.compilation.sources import fingerprint
from chain_impact.scene.reading import SceneError
from chain_impact.scene.scene import Scene, scene_to_dict
from chain_impact.studies.sweep.design import Design
from chain_impact.studies.sweep.job import Job
from chain_impact.studies.sweep.pieces import Span
from chain_impact.system import remove_lock

SUFFIX, LOCK = ".partial", ".lock"
FORMAT = 1  # of the file; raised when it changes
BLOCK = struct.Struct("<qqI")  # first run, how many, checksum


@dataclass
class Book:
    """What is kept of a sweep.

    Attributes:
        done: the runs that are done already.
    """

    done: list[Span] = field(default_factory=list)
    _file: IO[bytes] | None = None
    _empty: bool = True

    def keep(self, first: int, rows: np.ndarray) -> None:
        """Keep the rows of the runs from ``first`` on."""
        if self._file:
            content = rows.tobytes()
            _write(self._file, BLOCK.pack(first, len(rows), zlib.crc32(content)) + content)
            self._empty = False

    def remove(self, *, if_empty: bool = False) -> None:
        """Remove the file: the table is written, or there is nothing in it."""
        if self._file and (self._empty or not if_empty):
            self._file.close()
            Path(self._file.name).unlink(missing_ok=True)


def partial_path(table: Path) -> Path:
    """The file that keeps what is done until the table is whole."""
    return table.with_name(table.name + SUFFIX)


@contextmanager
def kept(table: Path | None, job: Job, design: Design, rows: np.ndarray) -> Iterator[Book]:
    """Keep what is done in a file beside the table; without a table, keep nothing.

    What an earlier call has left there is filled into ``rows``.

    Raises:
        SceneError: when another sweep has left it, or writes it now.
        OSError: when the file cannot be read or written.
    """
    if table is None:
        yield Book()
        return
    path, head = partial_path(table), _head(job, design)
    with _locked(table), _opened(path, head, rows) as book:
        yield book


@contextmanager
def _locked(table: Path) -> Iterator[None]:
    """Keep other sweeps from writing the same table meanwhile.

    Raises:
        SceneError: when one does.
        OSError: when nothing can be written beside the table.
    """
    if not table.parent.is_dir():  # the lock would make it
        raise FileNotFoundError(errno.ENOENT, f"there is no folder {table.parent}", str(table))
    from filelock import FileLock, Timeout

    lock = FileLock(table.with_name(table.name + SUFFIX + LOCK))
    try:
        lock.acquire(timeout=0)
    except Timeout:
        raise SceneError(
            f"{table} is being written by another sweep: wait until it has ended, or choose another file"
        ) from None
    except OSError as error:  # the user knows nothing of the lock
        raise type(error)(error.errno, error.strerror, str(table)) from None
    try:
        yield
    finally:
        remove_lock(lock)


@contextmanager
def _opened(path: Path, head: dict[str, Any], rows: np.ndarray) -> Iterator[Book]:
    """The book in a file, with what an earlier call has left there in ``rows``."""
    done: list[Span] = []
    if path.exists():
        with path.open("r+b") as file:
            _check_head(path, file.readline(), head)
            done = _read(file, rows)
            file.truncate()
    # unbuffered and at the end: a block is written at once
    with path.open("ab", buffering=0) as file:
        if not path.stat().st_size:
            try:
                _write(file, json.dumps(head).encode() + b"\n")
            except OSError:  # half a line is no sweep's
                file.close()
                path.unlink()
                raise
        book = Book(done, file, not done)
        try:
            yield book
        finally:
            book.remove(if_empty=True)


def _write(file: IO[bytes], content: bytes) -> None:
    """Write all of it; an error names the file."""
    try:
        while content:
            content = content[file.write(content) :]
    except OSError as error:
        raise type(error)(error.errno, error.strerror, file.name) from None


def _read(file: IO[bytes], rows: np.ndarray) -> list[Span]:
    """Fill in the rows of all whole blocks, and stop after them."""
    done: list[Span] = []
    while True:
        start = file.tell()
        head = file.read(BLOCK.size)
        if len(head) == BLOCK.size:
            first, count, checksum = BLOCK.unpack(head)
            inside = 0 <= first <= first + count <= len(rows)
            content = file.read(count * rows.itemsize) if inside else b""
            if inside and len(content) == count * rows.itemsize and zlib.crc32(content) == checksum:
                rows[first : first + count] = np.frombuffer(content, rows.dtype)
                done.append((first, first + count))
                continue
        file.seek(start)
        return done


def _head(job: Job, design: Design) -> dict[str, Any]:
    """What a sweep is known by: all that its rows follow from."""
    values = hashlib.sha256()
    for variation in design.variations:
        values.update(repr((variation.name, len(variation.values))).encode() + variation.values.tobytes())
    if design.samples is not None:
        values.update(repr(design.samples.shape).encode() + np.ascontiguousarray(design.samples).tobytes())
    return {
        "format": FORMAT,
        "kernel": fingerprint(),
        "scene": _scene_digest(job.scene),
        "varied values": values.hexdigest(),
        "outputs": list(job.outputs),
    }


def _scene_digest(scene: Scene) -> str:
    digest = hashlib.sha256(json.dumps(scene_to_dict(scene), sort_keys=True).encode())
    if scene.contact.law_file:
        digest.update(Path(scene.contact.law_file).read_bytes())
    return digest.hexdigest()


def _check_head(path: Path, line: bytes, head: dict[str, Any]) -> None:
    """Refuse the file of another sweep."""
    try:
        found = json.loads(line)
        differs = [name for name in head if found[name] != head[name]]
    except (ValueError, KeyError, TypeError):
        raise SceneError(
            f"{path} is not the partial table of a sweep: remove it, or choose another file for the table"
        ) from None
    if differs:
        raise SceneError(
            f"{path} was left by a sweep with another {differs[0]}: "
            "remove it, or choose another file for the table"
        )
