"""The folder of the cache of kernels, and errors that tell why nothing can be stored there."""

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

from chain_impact import files
from chain_impact.compilation.errors import BuildError

UNUSABLE_FOLDER = (
    *(errno.EACCES, errno.EPERM, errno.EROFS),
    *(errno.ENOENT, errno.ENOSPC, errno.EDQUOT, errno.ENOTDIR),
)
LITTLE_SPACE = 1_000_000  # [byte] with less free space than this, a disk counts as full
OTHERS_CAN_WRITE = "other users can write there"
ADVICE = "free space there, or set CHAIN_IMPACT_CACHE to another folder"


def base_folder() -> Path:
    """Return the folder of the whole cache: ``CHAIN_IMPACT_CACHE`` or, without it, the user's cache folder.

    Raises:
        BuildError: when ``CHAIN_IMPACT_CACHE`` is not set and the user has no home folder.
    """
    given_folder = os.environ.get("CHAIN_IMPACT_CACHE")
    try:
        return (Path(given_folder) if given_folder else files.user_cache_folder()).absolute()
    except RuntimeError as error:
        raise BuildError(
            f"no folder for compiled kernels: {error}; set CHAIN_IMPACT_CACHE to a folder"
        ) from None


def is_trusted(base: Path) -> bool:
    """Return whether the cache's folder ``base`` exists, and no other user except root can write to it.

    Another user could put a harmful kernel there. On Windows, only the existence is checked.
    """
    try:
        return not files.others_can_write(base.stat())
    except OSError:
        return False


@functools.cache
def make_folder(base: Path) -> Path:
    """Return the cache's folder ``base``, which is made if it does not exist.

    Raises:
        BuildError: when nothing can be stored in the folder, or other users can write there.
    """
    with explain_unwritable_folder(base):
        with suppress(FileExistsError):
            base.mkdir(mode=0o700, parents=True)
        tempfile.TemporaryFile(dir=base).close()
        if not is_trusted(base):
            raise PermissionError(errno.EACCES, OTHERS_CAN_WRITE, str(base))
    return base


@contextmanager
def explain_unwritable_folder(folder: Path) -> Iterator[None]:
    """Context manager in which an error that means that ``folder`` cannot be written becomes a BuildError.

    Such an error is an OSError, or the BuildError of a compiler while the disk is full.

    Raises:
        BuildError: with a message of one sentence, in place of such an error; or the compiler's own error,
            unchanged, if the disk is not full.
        OSError: unchanged, if the error has another cause or concerns another folder.
    """
    try:
        yield
    except OSError as error:
        if error.errno not in UNUSABLE_FOLDER or not _concerns(error.filename, folder):
            raise
        refused_path, cause = error.filename or folder, error.strerror or error
        raise BuildError(f"no kernel can be stored in {refused_path} ({cause}): {ADVICE}") from None
    except BuildError:
        # a compiler can fail because the disk is full, but its message does not always say so
        if folder.is_dir() and shutil.disk_usage(folder).free < LITTLE_SPACE:
            raise BuildError(f"no kernel can be stored in {folder} (the disk is full): {ADVICE}") from None
        raise


def _concerns(named_file: Any, folder: Path) -> bool:
    """Return whether an error of the operating system that names ``named_file`` concerns a folder.

    The result is True if ``named_file`` is no path, or the path of the folder, or a path inside or above it.
    """
    # an error may name no path, or the number of an open file; this file may be in the folder
    if not isinstance(named_file, str | bytes | os.PathLike):
        return True
    path = Path(os.fsdecode(named_file)).absolute()
    return path.is_relative_to(folder) or folder.is_relative_to(path)
