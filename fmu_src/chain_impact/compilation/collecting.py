"""numba's front end alone: every function is lowered once, and not optimised.

When numba compiles a function it optimises it, links all that it calls to it, optimises the whole and makes
machine code of that. For a kernel of 350 functions that call one another this takes a minute, and none of it
is used here: zig's compiler optimises all functions, in one pass over one module. numba has no public way to
leave these steps out. So this file, and no other, replaces a private part of numba: the libraries in which it
keeps the code of functions.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from typing import Any

from llvmlite import binding as llvm
from numba.core import codegen


class Library(codegen.JITCodeLibrary):
    """The code of a function as numba writes it, neither optimised nor turned into machine code."""

    def _optimize_functions(self, module: llvm.ModuleRef) -> None:
        module.data_layout = self._codegen._data_layout

    def finalize(self) -> None:
        """Leave all as it is: who calls the function finds its library among its own."""
        self._raise_if_finalized()
        self._finalized = True

    def get_pointer_to_function(self, _name: str) -> int:
        """None: the function is never called here."""
        self._ensure_finalized()
        return 0

    @property
    def module(self) -> llvm.ModuleRef:
        """The code."""
        return self._final_module

    def and_those_it_calls(self) -> Iterator[Library]:
        """This library and all that it needs, each once."""
        found: dict[Library, None] = {}
        waiting = [self]
        while waiting:
            library = waiting.pop()
            if library not in found:
                library._ensure_finalized()
                found[library] = None
                waiting.extend(library._linking_libraries)
        return iter(found)


def collect_only() -> None:
    """Make numba, in this process, lower functions and do nothing else."""
    codegen.JITCPUCodegen._library_class = Library
    codegen.JITCPUCodegen.set_env = _nothing
    gc.disable()  # the garbage of a compiler that ends soon


def _nothing(*_: Any) -> None:
    """The address of a Python object, for functions that are called here."""
