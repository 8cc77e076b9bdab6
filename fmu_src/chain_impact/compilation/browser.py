"""The kernel for a web page: a WebAssembly module for any number of links.

The module has the part of a native library that pages call. It imports nothing except, with a user's law, the
functions of the browser's ``Math`` that the law calls.
"""

from __future__ import annotations

import re
from pathlib import Path

from chain_impact.compilation import compilers
from chain_impact.compilation.errors import BuildError
from chain_impact.user_laws.law_syntax import LawError

# the names of two files in the cache: the module, and the compiled kernel from which it is linked
MODULE, COMPILED = "kernel-any-browser.wasm", "kernel-any-browser.o"
EXPORTS = ("initialize", "log_contacts", "trajectory", "__heap_base")
"""Names in the WebAssembly module that pages use, besides the memory (pages/browser/solver/kernel.js)."""
STACK = 1 << 20  # [byte] size of the module's stack, of which the kernel uses a few thousand bytes
# The target is WebAssembly with addresses of 32 bits, because zig has no headers for addresses of 64 bits.
# With -msimd128 a vector holds two doubles, as in the code for x86 processors.
TARGET = ("-target", "wasm32-wasi", "-msimd128", "-nostdlib", "-nostartfiles", "-s", "-fvisibility=hidden")
UNARY_FUNCTIONS = (
    "acos",
    "acosh",
    "asin",
    "asinh",
    "atan",
    "atanh",
    "cbrt",
    "cosh",
    "log10",
    "log2",
    "sinh",
    "tan",
    "tanh",
)
IMPORTED = {
    **dict.fromkeys(UNARY_FUNCTIONS, "double x"),
    **dict.fromkeys(("atan2", "fmod", "hypot"), "double x, double y"),
}
"""The functions of the browser's ``Math`` that a user's law can call → their arguments. The page gives these
functions to the module (pages/browser/solver/kernel.js)."""
_MISSING_SYMBOL = re.compile(r"undefined symbol: _?(?:numba_)?(\w+)")


def compile_kernel(module: str, compiled: Path) -> None:
    """Compile the lowered kernel to an object file for ``link``.

    Args:
        module: the text of the kernel in LLVM's language, as lower.py writes it.
        compiled: the object file to write; temporary files are in the same folder.

    Raises:
        BuildError: when the compiler fails.
    """
    kernel = compiled.with_name("kernel.ll")
    kernel.write_text(compilers.add_prelude(module, compilers.AnyLinks.GENERAL, compilers.NO_REGISTERS))
    compilers.run_zig(["cc", "-c", *TARGET, *compilers.C_FLAGS, "-o", str(compiled), str(kernel)], compiled)


def link(compiled: Path, output: Path, law: Path | None = None) -> None:
    """Link the compiled kernel, with a user's law if there is one, to a WebAssembly module.

    Args:
        compiled: the object file that ``compile_kernel`` has written.
        output: the module to write; temporary files are in the same folder.
        law: the file with a user's law in LLVM's language; None for no law.

    Raises:
        LawError: when the law calls a function that neither the module nor IMPORTED has.
        BuildError: when the compiler fails.
    """
    linker = ["-Wl,--no-entry", f"-Wl,-z,stack-size={STACK}", *(f"-Wl,--export={name}" for name in EXPORTS)]
    inputs = [compiled, *compilers.write_stubs(output, law), *([_write_imports(output)] if law else [])]
    arguments = ["cc", *TARGET, *compilers.C_FLAGS, "-o", str(output), *map(str, inputs), *linker]
    try:
        compilers.run_zig(arguments, output)
    except BuildError as error:
        missing_symbol = _MISSING_SYMBOL.search(str(error))
        if law and missing_symbol:
            raise LawError(f"calls {missing_symbol[1]}, which a kernel in a browser does not have") from None
        raise


def _write_imports(output: Path) -> Path:
    """Write a C file with a function for each of IMPORTED, which calls that of the browser's ``Math``.

    The linker keeps only the functions that the law calls. The file, whose path is returned, is in the folder
    of ``output``.
    """
    text = ""
    for name, arguments in IMPORTED.items():
        text += (
            f'__attribute__((import_module("Math"), import_name("{name}"))) double its_{name}({arguments});\n'
        )
        text += f"double {name}({arguments}) {{ return its_{name}({arguments.replace('double ', '')}); }}\n"
    imports = output.with_name("imports.c")
    imports.write_text(text)
    return imports
