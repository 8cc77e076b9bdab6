"""The kernel for a web page: a WebAssembly module for any number of links, which imports nothing.

The module has the same code as a native library, without the C interface of FMUs. WebAssembly has no library
of mathematical functions, so the functions that the kernel calls are part of the module (mathematics/), and
give the same digits as the C library of Linux.
"""

from __future__ import annotations

import re
from importlib.resources import files
from pathlib import Path

from chain_impact.compilation import compilers
from chain_impact.compilation.errors import BuildError
from chain_impact.compilation.law_file import LawError
from chain_impact.compilation.sources import PACKAGE

MODULE, COMPILED = "kernel-any-browser.wasm", "kernel-any-browser.o"
EXPORTS = ("initialize", "advance_awhile", "observe", "follow", "trajectory", "run_each", "__heap_base")
MATHEMATICS = PACKAGE / "compilation" / "mathematics"
STACK = 1 << 20  # [byte] size of the stack; the kernel needs a few thousand
# WebAssembly with addresses of 32 bits, because zig has no headers for 64 bits. A vector holds two numbers,
# as on every x86 processor.
TARGET = ("-target", "wasm32-wasi", "-msimd128", "-nostdlib", "-nostartfiles", "-s", "-fvisibility=hidden")
# Roots and signs compile to instructions. Functions that musl calls hidden are private to the module.
FLAGS = (*compilers.FLAGS, "-fno-math-errno", '-Dhidden=__attribute__((visibility("hidden")))')
_MISSING = re.compile(r"undefined symbol: _?(?:numba_)?(\w+)")


def compile_kernel(module: str, compiled: Path) -> None:
    """Compile a lowered kernel for ``link``.

    Args:
        module: the kernel in LLVM's language, as lower.py writes it.
        compiled: the file to write; temporary files are in the same folder.

    Raises:
        BuildError: when the compiler fails.
    """
    kernel = compiled.with_name("kernel.ll")
    kernel.write_text(compilers.complete(module, compilers.GENERAL, compilers.NO_REGISTERS))
    compilers.run_zig(["cc", "-c", *TARGET, *FLAGS, "-o", str(compiled), str(kernel)], compiled)


def link(compiled: Path, output: Path, law: Path | None = None) -> None:
    """Make the WebAssembly module of a kernel.

    Args:
        compiled: the kernel, as ``compile_kernel`` writes it.
        output: the file to write; temporary files are in the same folder.
        law: a user's law in LLVM's language, if there is one.

    Raises:
        LawError: when the law calls a function that the module does not have.
        BuildError: when the compiler fails.
    """
    headers = files("ziglang") / "lib" / "libc" / "include"
    folders = [f"-isystem{headers / name}" for name in ("wasm-wasi-musl", "generic-musl")]
    folders += [f"-I{folder}" for folder in (MATHEMATICS, MATHEMATICS / "musl")]
    linker = ["-Wl,--no-entry", f"-Wl,-z,stack-size={STACK}", *(f"-Wl,--export={name}" for name in EXPORTS)]
    inputs = [compiled, *compilers.write_beside(output, law), *sorted(MATHEMATICS.rglob("*.c"))]
    arguments = ["cc", *TARGET, *FLAGS, *folders, "-o", str(output), *map(str, inputs), *linker]
    try:
        compilers.run_zig(arguments, output)
    except BuildError as error:
        missing = _MISSING.search(str(error))
        if law and missing:
            raise LawError(f"calls {missing[1]}, which a kernel in a browser does not have") from None
        raise
