"""Where the cache lies, and what is said when nothing can be kept there."""

from __future__ import annotations

import errno
import functools
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from chain_impact import system
from chain_impact.compilation.errors import BuildError

NO_PLACE = (
    *(errno.EACCES, errno.EPERM, errno.EROFS),
    *(errno.ENOENT, errno.ENOSPC, errno.EDQUOT, errno.ENOTDIR),
)
LITTLE = 1_000_000  # bytes: a folder with less space is full
OTHERS = "other users can write there"
ADVICE = "free space there, or set CHAIN_IMPACT_CACHE to another folder"


def base_folder() -> Path:
    """Where all that is cached lies: ``CHAIN_IMPACT_CACHE``, or the user's cache folder.

    Raises:
        BuildError: when the user has no home.
    """
    given = os.environ.get("CHAIN_IMPACT_CACHE")
    try:
        return (Path(given) if given else system.cache_folder()).absolute()
    except RuntimeError as error:
        raise BuildError(f"no place to keep kernels: {error}; set CHAIN_IMPACT_CACHE to a folder") from None


def trusted(base: Path) -> bool:
    """Whether the folder of the cache is there, and nobody else can put kernels into it: they are run."""
    try:
        return not system.others_can_write(base.stat())
    except OSError:
        return False


@functools.cache
def writable(base: Path) -> Path:
    """The folder, made if need be.

    Raises:
        BuildError: when nothing can be kept in it, or others can write there.
    """
    with explained(base):
        with suppress(FileExistsError):
            base.mkdir(mode=0o700, parents=True)
        tempfile.TemporaryFile(dir=base).close()
        if not trusted(base):
            raise PermissionError(errno.EACCES, OTHERS, str(base))
    return base


@contextmanager
def explained(folder: Path) -> Iterator[None]:
    """Make one sentence of what the system says when nothing can be kept in a folder.

    Raises:
        BuildError: with that sentence.
        OSError: of another kind, or of another place, as it is.
    """
    try:
        yield
    except OSError as error:
        if error.errno not in NO_PLACE or not _concerns(error.filename, folder):
            raise
        where, why = error.filename or folder, error.strerror or error
        raise BuildError(f"nothing can be kept in {where} ({why}): {ADVICE}") from None
    except BuildError:
        if folder.is_dir() and shutil.disk_usage(folder).free < LITTLE:  # a compiler has other words for it
            raise BuildError(f"nothing can be kept in {folder} (it is full): {ADVICE}") from None
        raise


def _concerns(named: Any, folder: Path) -> bool:
    """Whether an error that names a path, or none, is about a folder, what is in it, or where it lies."""
    if not isinstance(named, str | bytes | os.PathLike):  # of what is open already
        return True
    path = Path(os.fsdecode(named)).absolute()
    return path.is_relative_to(folder) or folder.is_relative_to(path)
