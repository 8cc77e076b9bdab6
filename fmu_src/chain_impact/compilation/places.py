"""Where the cache lies, and what is said when nothing can be kept there."""

from __future__ import annotations

import errno
import functools
import hashlib
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import platformdirs

from chain_impact.compilation.errors import BuildError

READ_ONLY = (errno.EACCES, errno.EPERM, errno.EROFS)
LITTLE = 1_000_000  # bytes: a folder with less space is full
ADVICE = "free space there, or set CHAIN_IMPACT_CACHE to another folder"


def base_folder() -> Path:
    """Where all that is cached lies: ``CHAIN_IMPACT_CACHE``, or the user's cache folder.

    Raises:
        BuildError: when the user has no home.
    """
    given = os.environ.get("CHAIN_IMPACT_CACHE")
    try:
        return Path(given or platformdirs.user_cache_dir("chain-impact")).absolute()
    except RuntimeError as error:
        raise BuildError(f"no place to keep kernels: {error}; set CHAIN_IMPACT_CACHE to a folder") from None


def stand_in(base: Path) -> Path:
    """The temporary folder of this user that stands in for one that can only be read."""
    digest = hashlib.sha256(f"{os.getuid()} {base}".encode()).hexdigest()[:16]
    return Path(tempfile.gettempdir(), f"chain-impact-{digest}")


@functools.cache
def writable(base: Path) -> Path:
    """The folder, made if need be; or its stand-in where it can only be read.

    Raises:
        BuildError: when nothing can be kept in it for another reason.
    """
    with explained(base):
        try:
            base.mkdir(parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=base).close()
            return base
        except OSError as error:
            if error.errno not in READ_ONLY:
                raise
        folder = stand_in(base)
        folder.mkdir(mode=0o700, exist_ok=True)
        if (
            folder.is_symlink() or folder.stat().st_uid != os.getuid()
        ):  # kernels are run: they must be our own
            raise PermissionError(errno.EACCES, "belongs to another user", str(folder))
        return folder


@contextmanager
def explained(folder: Path) -> Iterator[None]:
    """Make one sentence of what the system says when something is kept in a folder.

    Raises:
        BuildError: with that sentence.
    """
    try:
        yield
    except OSError as error:
        where, why = error.filename or folder, error.strerror or error
        raise BuildError(f"nothing can be kept in {where} ({why}): {ADVICE}") from None
    except BuildError:
        if folder.is_dir() and shutil.disk_usage(folder).free < LITTLE:  # a compiler has other words for it
            raise BuildError(f"nothing can be kept in {folder} (it is full): {ADVICE}") from None
        raise
