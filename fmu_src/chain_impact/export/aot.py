"""Compile the kernel ahead of time into a shared library that needs neither Python nor numba.

The library depends on the record's layout only: the number of links and of candidates, not on any value.
It is kept in the user's cache folder under a hash of all that went into it, so `simulate()` and the FMU of
a scene run the very same machine code.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from importlib.metadata import version
from pathlib import Path

import platformdirs

import chain_impact.kernel
from chain_impact.law_file import LawError, UserLaw, compiled_law, read_law

ZIG_TARGETS = {
    "linux64": ("x86_64-linux-gnu.2.17", ".so"),
    "win64": ("x86_64-windows-gnu", ".dll"),
}
"""FMI platform → zig target and file suffix; the platforms for which pythonfmu has a wrapper."""
HOST = "linux64"
PORTABLE_CPU = "x86-64-v2"  # every x86 processor since 2009
# numba's code refers to these on its error paths only, which the kernel never takes: it does not allocate
# and its error model is NumPy's
PYTHON_SYMBOLS = (
    *("NRT_Free", "NRT_MemInfo_call_dtor", "PyBytes_FromStringAndSize", "PyErr_Clear", "PyErr_SetNone"),
    *("PyErr_SetString", "PyErr_WriteUnraisable", "PyExc_RuntimeError", "PyExc_StopIteration"),
    *("PyExc_SystemError", "PyUnicode_FromString", "Py_DecRef", "numba_do_raise", "numba_gil_ensure"),
    *("numba_gil_release", "numba_runtime_build_excinfo_struct", "numba_unpickle"),
)
STUB = '__attribute__((visibility("hidden"))) void {}(void) {{}}\n'


class BuildError(RuntimeError):
    """The kernel could not be compiled; the message holds the compiler's own."""


def kernel_library(
    links: int,
    candidates: int,
    platform: str = HOST,
    notify: Callable[[str], None] = lambda _: None,
    law_file: str = "",
) -> Path:
    """Return the shared library for N ``links`` and C ``candidates``, compiling it if it is not cached.

    Args:
        links: number of links N.
        candidates: number of pairs of a contact point and a wall C.
        platform: ``linux64`` or ``win64``.
        notify: called with a sentence before work that takes seconds.
        law_file: the file of a user's law that the kernel shall have, if any.

    Raises:
        BuildError: when the user's law, numba or the linker fails.
    """
    target, suffix = ZIG_TARGETS[platform]
    folder = cache_folder()
    law = _law(law_file) if law_file else None
    kind = f"kernel-{links}-{candidates}"
    if law:
        kind += f"-{law.id}-{hashlib.sha256(law.source.encode()).hexdigest()[:16]}"
    library = folder / f"{kind}-{platform}{suffix}"
    if library.exists():
        return library
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder) as scratch:
        ir = folder / f"{kind}.ll"
        if not ir.exists():
            notify("compiling the kernel for this number of links and walls")
            fresh = Path(scratch, "kernel.ll")
            command = [sys.executable, "-m", "chain_impact.export.lower", str(links), str(candidates)]
            command.append(str(fresh))
            if law:
                _try_law(law, law_file)
                copy = Path(scratch, f"{law.id}.py")
                copy.write_text(law.source, encoding="utf-8")
                command.append(str(copy))
            # without the features of this machine, which numba takes unless told otherwise
            _run(command, NUMBA_CPU_NAME=PORTABLE_CPU, NUMBA_CPU_FEATURES="")
            fresh.replace(ir)
        notify(f"linking the kernel for {platform}")
        stubs, fresh = Path(scratch, "stubs.c"), Path(scratch, "kernel" + suffix)
        stubs.write_text("".join(map(STUB.format, PYTHON_SYMBOLS)))
        command = [sys.executable, "-m", "ziglang", "cc", "-target", target, "-O2", "-shared", "-s"]
        _run([*command, "-Wno-everything", "-o", str(fresh), str(ir), str(stubs), "-lm"])
        # at once or not at all: another process may be building the same
        fresh.replace(library)
    return library


def _law(file: str) -> UserLaw:
    try:
        return read_law(Path(file))
    except LawError as error:
        raise BuildError(f"{file} {error}") from None


def _try_law(law: UserLaw, file: str) -> None:
    """Refuse a law that does not compile, in one sentence."""
    try:
        compiled_law(law)
    except LawError as error:
        raise BuildError(f"{file} {error}") from None


def cache_folder() -> Path:
    """The folder for kernels of these sources, this numba and this linker."""
    base = os.environ.get("CHAIN_IMPACT_CACHE") or platformdirs.user_cache_dir("chain-impact")
    return Path(base) / _fingerprint()


@cache
def _fingerprint() -> str:
    digest = hashlib.sha256()
    for name in ("numba", "llvmlite", "ziglang", "numpy"):
        digest.update(f"{name} {version(name)}\n".encode())
    package = Path(chain_impact.kernel.__file__).parent
    here = Path(__file__)
    others = [package.parent / name for name in ("instance.py", "law_file.py")]
    sources = [*package.glob("*.py"), *others, here, here.with_name("lower.py")]
    for source in sorted(sources):
        digest.update(source.name.encode() + b"\0" + source.read_bytes())
    return digest.hexdigest()[:16]


def _run(command: list[str], **environment: str) -> None:
    done = subprocess.run(
        command, env={**os.environ, **environment}, capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise BuildError(f"could not compile the kernel: {' '.join(command[:4])} … said:\n{done.stderr}")
