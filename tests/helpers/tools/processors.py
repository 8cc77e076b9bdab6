"""Marks of tests that need a processor, and the command that runs programs of another one."""

import platform
import shutil
from pathlib import Path

import pytest

ON_X86 = pytest.mark.skipif(
    platform.machine() not in {"x86_64", "AMD64"}, reason="these are the registers of x86-64"
)
_ARM_LIBRARIES = Path("/usr/aarch64-linux-gnu")  # Debian's libc6-arm64-cross
QEMU = ("qemu-aarch64", "-L", str(_ARM_LIBRARIES))
"""The beginning of a command that runs a program of 64-bit ARM."""
ON_ARM = pytest.mark.skipif(
    not (shutil.which(QEMU[0]) and _ARM_LIBRARIES.is_dir()),
    reason="needs Debian's qemu-user and libc6-arm64-cross",
)
