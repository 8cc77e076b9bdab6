"""All code that depends on the operating system or the processor.

Two other parts also depend on system and processor, but cannot use this module because they run without this
package: the slave of an FMU (slave.py), and the C interface of native FMUs (compilation/c_interface/).
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
        system: Python's name of the system.
        machine: Python's name of the processor on this system.
        suffix: the suffix of a shared library's file.
        fmi3: FMI 3.0's name of the platform (2.5.1.4.1).
        target: zig's name of the platform, with the oldest version of the C library or of macOS.
        cpu: zig's name of the oldest processor that runs the code: all processors then give equal bits.
        tag: a wheel's name of the platform, with the same oldest version.
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


# the oldest processors that run the code: every x86 since 2009, and every 64-bit ARM
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
"""All platforms, by name: the first three names are from FMI 2.0, the others from FMI 3.0."""


def _host(system: str, machine: str, word: int) -> str:
    """Return the key in ``PLATFORMS`` of a system and a processor.

    Returns "" if there is none, or if addresses, of ``word`` bytes, are not of 64 bits.
    """
    names = (name for name, host in PLATFORMS.items() if (host.system, host.machine) == (system, machine))
    return next(names, "") if word == struct.calcsize("q") else ""


def _machine() -> str:
    """Return the processor for which this Python is made; on ARM, Windows may run a Python for x86-64."""
    return sysconfig.get_platform().partition("-")[2] if SYSTEM == WINDOWS else platform.machine()


HOST = _host(SYSTEM, _machine(), struct.calcsize("P"))
"""The name of the platform on which this Python runs; "" if no kernels exist for it."""


def nowhere() -> str:
    """Return the sentence, with a remedy, for a machine for which no kernels exist."""
    platforms = "Linux (x86-64, ARM), Windows (x86-64) and macOS, with a Python of 64 bits"
    return (
        f"chain-impact runs on {platforms}, not on {platform.platform()} ({sysconfig.get_platform()}): use "
        "such a machine, or a container or a virtual machine for one of them"
    )


def cores() -> int:
    """Return the number of cores that this process may use."""
    affinity = getattr(os, "sched_getaffinity", None)  # of the supported systems only Linux has this function
    return len(affinity(0)) if affinity else os.cpu_count() or 1


# --- files -------------------------------------------------------------------------------------------------


def cache_folder() -> Path:
    """Return the user's folder for files that the program can make again.

    Raises:
        RuntimeError: when the user has no home folder.
    """
    import platformdirs

    return Path(platformdirs.user_cache_dir("chain-impact", appauthor=False))


def included(in_package: str, in_repository: str) -> Path:
    """Return the path of a file or folder that a wheel has in the package, and the repository elsewhere."""
    installed = Path(__file__).parent / in_package
    return installed if installed.exists() else Path(__file__).parents[2] / in_repository


def others_can_write(status: os.stat_result) -> bool:
    """Return whether another user of this machine, except root, can put files into a folder.

    On many systems a group with the same number as the user contains only this user. On Windows, other users
    cannot write to the user's own folder.
    """
    if SYSTEM == WINDOWS:
        return False
    user, groups = os.getuid(), stat.S_IWGRP if status.st_gid not in (0, os.getuid()) else 0
    return status.st_uid not in (0, user) or bool(status.st_mode & (groups | stat.S_IWOTH))


def remove_lock(lock: Any) -> None:
    """Release a lock of filelock and remove its file.

    Windows does not remove an open file. On other systems the file is removed first, so that no other process
    takes the lock in between.
    """
    file = Path(lock.lock_file)
    if SYSTEM == WINDOWS:
        lock.release()
        with suppress(OSError):  # the removal fails if another process holds the lock at this moment
            file.unlink()
    else:
        file.unlink(missing_ok=True)
        lock.release()


@contextmanager
def removal() -> Iterator[None]:
    """Explain why files cannot be removed: Windows keeps a library that a program has loaded.

    On other systems such a file is removed, and the program still has the library until it ends.

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

LISTEN = 0.2  # [s] a program that waits looks for Ctrl-C at these intervals


def has_screen() -> bool:
    """Return whether the program can open a window.

    On Linux it can if the environment names a display server; on other systems it always can.
    """
    return SYSTEM != "Linux" or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def prepare_console() -> None:
    """Let the console print a question mark for a character that its encoding lacks, instead of an error.

    In the locale POSIX, standard output accepts bytes of file names, but any other character would end the
    program.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper) and stream.errors in ("strict", "surrogateescape"):
            stream.reconfigure(errors="replace")


def quoted(word: str) -> str:
    """Return a word of a command as the shell of this system needs it."""
    return subprocess.list2cmdline([word]) if SYSTEM == WINDOWS else shlex.quote(word)


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """Yield a path to write to; the written file appears at ``path`` when it is complete, or not at all.

    If ``path`` is a link, a device or another thing that is not a file, it is written to directly.
    """
    try:
        if path.is_symlink() or (path.exists() and not path.is_file()):
            # /dev/stdout and similar files cannot be replaced, so the caller writes to them directly
            yield path
            return
        with tempfile.TemporaryDirectory(prefix=f".{path.name}-", dir=path.parent) as scratch:
            fresh = Path(scratch, path.name)
            yield fresh
            fresh.replace(path)
    except OSError as error:
        if error.filename and f".{path.name}-" not in str(error.filename):
            raise
        # the new error names the user's path, not the scratch folder; EIO takes the place of a missing error
        # number
        raise type(error)(error.errno or EIO, error.strerror or str(error), str(path)) from None
