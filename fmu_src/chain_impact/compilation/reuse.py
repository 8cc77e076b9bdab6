"""What a kernel that carries derivatives has in common with the plain one is lowered once.

In a lowered kernel, a function has as its name what numba has to know of it to call it:

    chain_impact.kernel.advance.error_of_end(instance, float64) -> float64

When the kernel with derivatives is lowered, functions with such a name are taken from the plain one. numba
looks for them where it has compiled functions on disk, a part of its dispatchers that is private to numba.
"""

from __future__ import annotations

import sys
from collections.abc import Container, Iterable
from types import FunctionType
from typing import Any

from llvmlite import binding as llvm
from numba import types
from numba.core import compiler, funcdesc, registry, sigutils, typing

from chain_impact.compilation.collecting import Library

_TUPLES = [types.UniTuple(types.float64, count) for count in range(2, 6)]
RESULTS = {str(kind): kind for kind in (types.none, types.boolean, types.int64, types.float64, *_TUPLES)}
"""Results of functions that can be taken. Others are rare."""
ARROW = " -> "

_lowered: list[tuple[FunctionType, Any]] = []  # functions, and numba's result for one signature
_taken: dict[str, tuple[str, Library]] = {}  # name up to the arrow → whole name, and where the code is


def take(plain: str) -> None:
    """Take what can be taken from the plain kernel, as lower.py writes it."""
    library = registry.cpu_target.target_context.codegen().create_library("plain kernel")
    library.modules.append(llvm.parse_assembly(plain))
    library.finalize()
    for symbol in library.modules[0].functions:
        head, arrow, _ = symbol.name.partition(ARROW)
        if arrow and not symbol.is_declaration:
            symbol.linkage = llvm.Linkage.weak_odr
            _taken[head] = symbol.name, library
        elif not symbol.is_declaration:
            # a function that is lowered now may have the same name
            symbol.linkage = llvm.Linkage.internal
            symbol.name = f"plain {symbol.name}"


def names(replaced: Container[Any]) -> dict[str, str]:
    """The names of functions that can be taken, for their symbols in what has been lowered.

    None of them calls a function that is ``replaced`` in a kernel with derivatives.
    """
    others = {result.library for function, result in _lowered if function in replaced}
    return {
        result.fndesc.mangled_name: _head(function, result.signature.args) + ARROW + returned
        for function, result in _lowered
        if (returned := str(result.signature.return_type)) in RESULTS
        # several functions that others return may have the same name
        and getattr(sys.modules.get(function.__module__), function.__qualname__, None) is function
        and others.isdisjoint(result.library.and_those_it_calls())
    }


def _head(function: FunctionType, arguments: Iterable[types.Type]) -> str:
    return f"{function.__module__}.{function.__qualname__}({', '.join(map(str, arguments))})"


class Overloads:
    """Stands for the files in which numba keeps a function that it has compiled for some types."""

    def __init__(self, function: FunctionType) -> None:
        self._function = function

    def load_overload(self, signature: Any, _context: Any) -> Any:
        """The function as it is in the plain kernel; None if it cannot be taken."""
        arguments, _ = sigutils.normalize_signature(signature)
        head = _head(self._function, arguments)
        if head not in _taken:
            return None
        name, library = _taken[head]
        result = RESULTS[name.removeprefix(head + ARROW)]
        return compiler.compile_result(
            entry_point=object().__reduce__,  # a function of its own to be known by; nobody calls it here
            fndesc=funcdesc.ExternalFunctionDescriptor(name, result, tuple(arguments)),
            library=library,
            objectmode=False,
            signature=typing.signature(result, *arguments),
        )

    def save_overload(self, _signature: Any, result: Any) -> None:
        """Keep in mind what has been lowered."""
        _lowered.append((self._function, result))
