"""All that differs by the operating system and by the processor.

Two more places cannot use it, because they run without this package: the slave of an FMU (slave.py), and the
C interface of native FMUs (compilation/c_interface/).
"""

from __future__ import annotations

import io
import os
import platform
import shlex
import stat
import struct
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from errno import EIO
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

T = TypeVar("T")
WINDOWS = "Windows"
SYSTEM = {"win32": WINDOWS, "darwin": "Darwin", "linux": "Linux"}.get(sys.platform, sys.platform)


class Platform(NamedTuple):
    """A system and a processor that kernels are made for.

    Attributes:
        system: what Python calls the system.
        machine: what Python calls the processor there.
        suffix: of the file of a shared library.
        fmi3: what FMI 3.0 calls the platform (2.5.1.4.1).
    """

    system: str
    machine: str
    suffix: str
    fmi3: str


PLATFORMS = {
    "linux64": Platform("Linux", "x86_64", ".so", "x86_64-linux"),
    "win64": Platform(WINDOWS, "amd64", ".dll", "x86_64-windows"),
    "darwin64": Platform("Darwin", "x86_64", ".dylib", "x86_64-darwin"),
    "aarch64-linux": Platform("Linux", "aarch64", ".so", "aarch64-linux"),
    "aarch64-darwin": Platform("Darwin", "arm64", ".dylib", "aarch64-darwin"),
}
"""Of all platforms. FMI 2.0 names the first three, FMI 3.0 the others."""


def _host(system: str, machine: str, word: int) -> str:
    """The platform of a Python whose addresses have so many bytes; empty if there are no kernels for it."""
    found = (name for name, one in PLATFORMS.items() if (one.system, one.machine) == (system, machine))
    return next(found, "") if word == struct.calcsize("q") else ""


def _machine() -> str:
    """Return the processor that this Python is made for: Windows on ARM runs one for x86-64, too."""
    return sysconfig.get_platform().partition("-")[2] if SYSTEM == WINDOWS else platform.machine()


HOST = _host(SYSTEM, _machine(), struct.calcsize("P"))
"""The platform that this Python runs on; empty if there are no kernels for it."""


def nowhere() -> str:
    """What is said where no kernel runs, and what to do instead."""
    known = "Linux (x86-64, ARM), Windows (x86-64) and macOS, with a Python of 64 bits"
    return (
        f"chain-impact runs on {known}, not on {platform.platform()} ({sysconfig.get_platform()}): use such "
        "a machine, or a container or a virtual machine for one of them"
    )


def cores() -> int:
    """Return how many cores this process may use."""
    affinity = getattr(os, "sched_getaffinity", None)  # Linux has it
    return len(affinity(0)) if affinity else os.cpu_count() or 1


# --- files -------------------------------------------------------------------------------------------------


def cache_folder() -> Path:
    """Return the user's folder for what can be made again.

    Raises:
        RuntimeError: when the user has no home.
    """
    import platformdirs

    return Path(platformdirs.user_cache_dir("chain-impact", appauthor=False))


def others_can_write(found: os.stat_result) -> bool:
    """Return whether a user of this machine other than this one and root can put files into a folder.

    A group of the same number as the user's is that of this user alone, as many systems make it. In Windows,
    what is in the user's own folder is closed to the others.
    """
    if SYSTEM == WINDOWS:
        return False
    user, groups = os.getuid(), stat.S_IWGRP if found.st_gid not in (0, os.getuid()) else 0
    return found.st_uid not in (0, user) or bool(found.st_mode & (groups | stat.S_IWOTH))


def remove_lock(lock: Any) -> None:
    """Release a lock (filelock's) and remove its file.

    Windows removes no file that is open. Elsewhere the file goes first, so that nobody takes it in between.
    """
    file = Path(lock.lock_file)
    if SYSTEM == WINDOWS:
        lock.release()
        with suppress(OSError):  # somebody else holds it by now
            file.unlink()
    else:
        file.unlink(missing_ok=True)
        lock.release()


@contextmanager
def removal() -> Iterator[None]:
    """Say why kernels cannot be removed: Windows keeps each library that a program has loaded.

    Elsewhere a loaded library stays until its program ends. No kernel is ever replaced by another one, as
    the folder's name tells the sources, and the file's name all else.

    Raises:
        PermissionError: with what to do.
    """
    try:
        yield
    except PermissionError as error:
        if SYSTEM != WINDOWS:
            raise
        why = "in use: end the programs that simulate, and try again"
        raise PermissionError(0, why, error.filename) from None


# --- the console -------------------------------------------------------------------------------------------

LISTEN = 0.2  # s


def has_screen() -> bool:
    """Return whether a window can be opened: on Linux a server of windows is named in the environment."""
    return SYSTEM != "Linux" or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def prepare_console() -> None:
    """Let what an encoding does not have be printed as a question mark, where it would end the program.

    In the locale POSIX, standard output lets bytes of file names through, and other signs end the program.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper) and stream.errors in ("strict", "surrogateescape"):
            stream.reconfigure(errors="replace")


def quoted(word: str) -> str:
    """Return a word of a command as the shell of this system takes it."""
    return subprocess.list2cmdline([word]) if SYSTEM == WINDOWS else shlex.quote(word)


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """Yield a path to write to; what is written there appears at ``path`` when it is whole, or not at all."""
    try:
        if path.is_symlink() or (path.exists() and not path.is_file()):
            yield path  # /dev/stdout and its like cannot be replaced
            return
        with tempfile.TemporaryDirectory(prefix=f".{path.name}-", dir=path.parent) as scratch:
            fresh = Path(scratch, path.name)
            yield fresh
            fresh.replace(path)
    except OSError as error:
        if error.filename and f".{path.name}-" not in str(error.filename):
            raise
        # the user knows nothing of the scratch folder, and some libraries give no number
        raise type(error)(error.errno or EIO, error.strerror or str(error), str(path)) from None
