"""The code of the package that depends on the operating system or the processor.

Two other parts that depend on them run without this package and so cannot use this module: the slave of an
FMU (slave.py), and the C interface of native FMUs (compilation/c_interface/).
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
    """A system and a processor for which kernels can be compiled.

    Attributes:
        system: the system's name in Python, ``platform.system()``.
        machine: the processor's name in Python on this system, ``platform.machine()``.
        suffix: the suffix of the file of a shared library.
        fmi3: the platform's name in FMI 3.0 (2.5.1.4.1).
        target: the platform's name for zig, on Linux and macOS with the oldest version of the C library or of
            macOS that runs the code.
        cpu: zig's name of the oldest processor that runs the code. Code for this processor gives equal bits
            on all processors that run the code.
        tag: the platform's name in a wheel's file name, with the same oldest version, if any.
        has_pythonfmu: whether pythonfmu has a wrapper for the platform.
    """

    system: str
    machine: str
    suffix: str
    fmi3: str
    target: str
    cpu: str
    tag: str
    has_pythonfmu: bool = False


# zig's names of the oldest processors that run the code: nearly every x86-64 since 2009, and every 64-bit ARM
X86, ARM = "x86_64_v2", "generic"
PLATFORMS = {
    "linux64": Platform(
        system="Linux",
        machine="x86_64",
        suffix=".so",
        fmi3="x86_64-linux",
        target="x86_64-linux-gnu.2.17",
        cpu=X86,
        tag="manylinux_2_17_x86_64",
        has_pythonfmu=True,
    ),
    "win64": Platform(
        system=WINDOWS,
        machine="amd64",
        suffix=".dll",
        fmi3="x86_64-windows",
        target="x86_64-windows-gnu",
        cpu=X86,
        tag="win_amd64",
        has_pythonfmu=True,
    ),
    "darwin64": Platform(
        system="Darwin",
        machine="x86_64",
        suffix=".dylib",
        fmi3="x86_64-darwin",
        target="x86_64-macos.11.0",
        cpu=X86,
        tag="macosx_11_0_x86_64",
    ),
    "aarch64-linux": Platform(
        system="Linux",
        machine="aarch64",
        suffix=".so",
        fmi3="aarch64-linux",
        target="aarch64-linux-gnu.2.17",
        cpu=ARM,
        tag="manylinux_2_17_aarch64",
    ),
    "aarch64-darwin": Platform(
        system="Darwin",
        machine="arm64",
        suffix=".dylib",
        fmi3="aarch64-darwin",
        target="aarch64-macos.11.0",
        cpu=ARM,
        tag="macosx_11_0_arm64",
    ),
}
"""Name that users give → platform; the first three names are those of FMI 2.0, others those of FMI 3.0."""


def _host(system: str, machine: str, word: int) -> str:
    """Return the name in ``PLATFORMS`` of a system and a processor; "" if there is none.

    ``word`` is the size of an address [byte]; only 8 bytes are supported.
    """
    names = (name for name, host in PLATFORMS.items() if (host.system, host.machine) == (system, machine))
    return next(names, "") if word == struct.calcsize("q") else ""


def _machine() -> str:
    """Return the name of this machine's processor or, on Windows, of that for which this Python is built.

    On ARM, Windows can also run a Python that is built for x86-64, which needs libraries for x86-64.
    """
    return sysconfig.get_platform().partition("-")[2] if SYSTEM == WINDOWS else platform.machine()


HOST = _host(SYSTEM, _machine(), struct.calcsize("P"))
"""The name of the platform on which this Python runs; "" if kernels do not exist for it."""


def nowhere() -> str:
    """Return the sentence, with a remedy, for a platform on which kernels do not exist."""
    platforms = "Linux (x86-64, ARM), Windows (x86-64) and macOS, with a Python of 64 bits"
    return (
        f"chain-impact runs on {platforms}, not on {platform.platform()} ({sysconfig.get_platform()}): use "
        "such a machine, or a container or a virtual machine for one of them"
    )


def cores() -> int:
    """Return the number of cores that this process may use or, on systems other than Linux, of all cores."""
    # of the supported systems, only Linux has sched_getaffinity, which tells the cores that a process may use
    affinity = getattr(os, "sched_getaffinity", None)
    return len(affinity(0)) if affinity else os.cpu_count() or 1


# --- files -------------------------------------------------------------------------------------------------


def user_cache_folder() -> Path:
    """Return the user's folder for files that the program can make again, such as compiled kernels.

    Raises:
        RuntimeError: when the user has no home folder.
    """
    import platformdirs

    return Path(platformdirs.user_cache_dir("chain-impact", appauthor=False))


def included(in_package: str, in_repository: str) -> Path:
    """Return the path of a file or folder that a wheel of this package contains.

    The result is ``in_package``, relative to the package, if that exists; else, in an installation without a
    wheel, ``in_repository``, relative to the repository.
    """
    installed = Path(__file__).parent / in_package
    return installed if installed.exists() else Path(__file__).parents[2] / in_repository


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
        why = "in use: end the programs that simulate, and try again"
        raise PermissionError(0, why, error.filename) from None


# --- the console -------------------------------------------------------------------------------------------

LISTEN = 0.2  # [s] a program that waits checks for Ctrl-C at these intervals


def has_screen() -> bool:
    """Return whether the program can open a window.

    On Linux the result is True if the environment names a display server; on other systems it is True.
    """
    return SYSTEM != "Linux" or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def prepare_console() -> None:
    """Let the console print a question mark for a character that its encoding lacks, instead of failing.

    By default such a character ends the program with an error. Those bytes of a file name that are no text,
    which Python by default prints unchanged in the locale POSIX, become question marks, too.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper) and stream.errors in ("strict", "surrogateescape"):
            stream.reconfigure(errors="replace")


def quoted(word: str) -> str:
    """Return a word of a command in the form that the command line of this system reads as one word."""
    return subprocess.list2cmdline([word]) if SYSTEM == WINDOWS else shlex.quote(word)


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """Context that yields a path to write to; at the context's end, the file appears at ``path`` in one step.

    If the writing fails, ``path`` stays as it is. But if ``path`` is a link, a device or anything else that
    exists and is no plain file, the context yields ``path`` itself, and the file is written in place.
    """
    try:
        if path.is_symlink() or (path.exists() and not path.is_file()):
            # a device such as /dev/stdout cannot be replaced by a file
            yield path
            return
        with tempfile.TemporaryDirectory(prefix=f".{path.name}-", dir=path.parent) as scratch:
            fresh = Path(scratch, path.name)
            yield fresh
            fresh.replace(path)
    except OSError as error:
        if error.filename and f".{path.name}-" not in str(error.filename):
            raise
        # the error names the user's path instead of the temporary one; EIO replaces a missing number of the
        # error
        raise type(error)(error.errno or EIO, error.strerror or str(error), str(path)) from None
