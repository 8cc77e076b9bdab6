"""The C functions of a module of this folder as a library, compiled just as the kernel is."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from pathlib import Path

from chain_impact.compilation import compilers, ready
from chain_impact.compilation.cache import linker_folder, made
from chain_impact.system import HOST

HERE = Path(__file__).parent
REGISTERS = compilers.INTERFACE / "common" / "registers.c"
PROGRAM, KERNEL_FUNCTIONS = HERE / "lower_functions.py", HERE / "kernel_functions.py"


def digest(*sources: Path) -> str:
    """Hexadecimal digits that change with the content of the files."""
    return hashlib.sha256(b"".join(source.read_bytes() for source in sources)).hexdigest()[:12]


def built(module: str, links: int, *sources: Path) -> Path:
    """The library of the C functions of a module of this folder, compiled if it is not cached.

    Args:
        module: its name; its ``entry_points()`` are the functions, as in compilation/entry_points.py.
        links: number of links.
        sources: the files that tell, besides the module, kernel_functions.py and the kernel, what is in the
            library.
    """
    own, exact = HERE.joinpath(*module.split(".")).with_suffix(".py"), ready.exact(links)
    name = f"{module}-{digest(Path(__file__), own, PROGRAM, KERNEL_FUNCTIONS, *sources)}"

    def make(library: Path) -> None:
        link(made(f"{name}.ll", lambda file: lower(module, file)).read_text(), exact, library)

    return made(f"{name}-{exact or 'any'}.so", make)


def lower(module: str, file: Path) -> None:
    """Write the C functions of a module to a file in LLVM's language."""
    subprocess.run([sys.executable, str(PROGRAM), module, str(file)], check=True)


def link(lowered: str, links: int | None, library: Path) -> None:
    """Make a library as that of the kernel, but without the C interface of FMUs, which calls the kernel.

    Args:
        lowered: C functions in LLVM's language.
        links: number of links; None for any.
        library: the file to write; others are put beside it.
    """
    functions = library.with_name("functions.o")
    compilers.compile_part(lowered, functions, HOST, compilers.KERNEL, links)
    compilers.prepare_zig(HOST)
    compilers._zig_library(HOST, library, functions, REGISTERS, *compilers.write_beside(library, None))


def zig(folder: Path, *arguments: object) -> None:
    """Compile other C code by zig, which keeps its scratch files in a folder.

    Without a target zig looks for the system's libc, which it does not find each time on a busy machine.
    """
    folders = {"ZIG_GLOBAL_CACHE_DIR": str(linker_folder()), "ZIG_LOCAL_CACHE_DIR": str(folder / "zig")}
    command = [sys.executable, "-m", "ziglang", "cc", "-O2", "-target", compilers.ZIG_TARGETS[HOST][0]]
    subprocess.run([*command, *map(str, arguments)], check=True, env={**os.environ, **folders})
