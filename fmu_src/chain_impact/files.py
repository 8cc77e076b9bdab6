"""Files and folders of the package and of the user, whose rights and locks depend on the system."""

from __future__ import annotations

import os
import stat
import tempfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from errno import EIO
from pathlib import Path
from typing import Any

from chain_impact.system import SYSTEM, WINDOWS


def user_cache_folder() -> Path:
    """Return the user's folder for files that the program can make again, such as compiled kernels.

    Raises:
        RuntimeError: when the user has no home folder.
    """
    import platformdirs

    return Path(platformdirs.user_cache_dir("chain-impact", appauthor=False))


def packaged_path(in_package: str, in_repository: str) -> Path:
    """Return the path of a file or folder that a wheel of this package contains.

    The result is ``in_package``, relative to the package, if that exists; else, in an installation without a
    wheel, ``in_repository``, relative to the repository.
    """
    installed = Path(__file__).parent / in_package
    return installed if installed.exists() else Path(__file__).parents[2] / in_repository


def with_checksum(start: bytes, content: bytes) -> bytes:
    """Return ``start``, the checksum (CRC-32) of ``content`` as 8 bytes, and ``content``."""
    return start + zlib.crc32(content).to_bytes(8, "little") + content


def others_can_write(status: os.stat_result) -> bool:
    """Return whether another user of this machine, except root, can write into a folder with a ``status``.

    The result is True if another user, except root, owns the folder, or if all users or the folder's group
    may write into the folder. The right of the group does not count if the group is that of root, or if the
    group's number equals the user's number: on many systems no other user belongs to such a group. On Windows
    the result is False, because a user's own folder is closed to others.
    """
    if SYSTEM == WINDOWS:
        return False
    user, groups = os.getuid(), stat.S_IWGRP if status.st_gid not in (0, os.getuid()) else 0
    return status.st_uid not in (0, user) or bool(status.st_mode & (groups | stat.S_IWOTH))


def remove_lock(lock: Any) -> None:
    """Release a lock of the package filelock, and remove the lock's file.

    The file is removed before the release, so that no other process takes the lock in between. On Windows
    the file is removed after the release, because Windows does not remove an open file.
    """
    file = Path(lock.lock_file)
    if SYSTEM == WINDOWS:
        lock.release()
        with suppress(OSError):  # the file stays if another process has taken the lock since the release
            file.unlink()
    else:
        file.unlink(missing_ok=True)
        lock.release()


@contextmanager
def removing_files() -> Iterator[None]:
    """Context for code that removes files; on Windows, an error says that a program uses one of the files.

    Windows refuses to remove a library that a program has loaded. On other systems the file is removed, and
    the program keeps its library until the program ends.

    Raises:
        PermissionError: when a file cannot be removed; on Windows with a remedy.
    """
    try:
        yield
    except PermissionError as error:
        if SYSTEM != WINDOWS:
            raise
        advice = "in use: end the programs that simulate, and try again"
        raise PermissionError(0, advice, error.filename) from None


@contextmanager
def written_atomically(path: Path) -> Iterator[Path]:
    """Context that yields a path to write to; at the context's end, the file appears at ``path`` in one step.

    If the writing fails, ``path`` stays as it is. But if ``path`` is a link, a device or anything else that
    exists and is no plain file, the context yields ``path`` itself, and the file is written in place.
    """
    try:
        if path.is_symlink() or (path.exists() and not path.is_file()):
            # a device such as /dev/stdout cannot be replaced by a file
            yield path
            return
        with tempfile.TemporaryDirectory(prefix=f".{path.name}-", dir=path.parent) as scratch_folder:
            new_file = Path(scratch_folder, path.name)
            yield new_file
            new_file.replace(path)
    except OSError as error:
        if error.filename and f".{path.name}-" not in str(error.filename):
            raise
        # the error names the user's path instead of the temporary one; EIO replaces a missing number of the
        # error
        raise type(error)(error.errno or EIO, error.strerror or str(error), str(path)) from None
