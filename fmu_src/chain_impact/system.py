"""The operating systems and processors on which the package runs, and those of this machine.

Only this module, ``files`` and ``console`` depend on the operating system or the processor. Two other parts
that depend on them run without this package and so cannot use these modules: the slave of an FMU (slave.py),
and the C interface of native FMUs (compilation/c_interface/).
"""

from __future__ import annotations

import os
import platform
import struct
import sys
import sysconfig
from typing import NamedTuple

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


def no_kernel_sentence() -> str:
    """Return the sentence, with a remedy, for a platform on which kernels do not exist."""
    platforms_text = "Linux (x86-64, ARM), Windows (x86-64) and macOS, with a Python of 64 bits"
    return (
        f"chain-impact runs on {platforms_text}, not on {platform.platform()} ({sysconfig.get_platform()}): "
        "use such a machine, or a container or a virtual machine for one of them"
    )


def cores() -> int:
    """Return the number of cores that this process may use or, on systems other than Linux, of all cores."""
    # of the supported systems, only Linux has sched_getaffinity, which tells the cores that a process may use
    affinity = getattr(os, "sched_getaffinity", None)
    return len(affinity(0)) if affinity else os.cpu_count() or 1
