"""Makes numba only lower functions: translate each function to LLVM's language once, and do no more.

Unchanged, numba would also optimise each function, link all called functions to it, optimise the result and
make machine code. For a kernel of hundreds of functions this takes a minute, and nothing uses the results:
zig's compiler optimises all functions in one pass over one module. No option of numba leaves these steps out,
so this module replaces private parts of numba: the libraries that hold the code of functions, and the calls
between functions. A function returns an error code where Python would raise an exception: numba would write
an exception with the path of a source file into the code, and the code would differ between machines.
"""

from __future__ import annotations

import gc
from collections.abc import Callable, Container, Iterator
from functools import partialmethod
from typing import Any

from llvmlite import binding as llvm, ir
from numba import types

from chain_impact.compilation.numba_parts import (
    arrayobj,
    base,
    callconv,
    cgutils,
    codegen,
    compiler_machinery,
    cpu,
)

IDLE = frozenset(
    {"inline_closure_likes", "inline_inlinables", "inline_overloads", "nopython_rewrites", "with_lifting"}
)
"""Names of numba's passes that are left out for the kernel. These passes look for features that the kernel
does not use: closures, expressions of whole arrays, functions that numba inlines, ``with``. The passes would
take a tenth of the time of lowering, and without them the lowered kernel has the same bytes."""

USUAL_REGISTERS, PUT_BACK = "usual_registers", "put_registers_back"
"""The C functions (registers.c) that a guarded function of the kernel calls first and last."""
WORD = ir.IntType(64)


class Library(codegen.JITCodeLibrary):
    """Replaces numba's library for the code of a function; the code is neither optimised nor compiled."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.modules: list[llvm.ModuleRef] = []

    def add_ir_module(self, module: ir.Module) -> None:
        """Add a module of code, and make the public functions in it weak (``weak_odr``).

        When modules are joined, LLVM keeps weak functions even if no module calls them yet.
        """
        for symbol in module.functions:
            if not symbol.is_declaration and symbol.linkage in ("", "external", "common"):
                symbol.linkage = "weak_odr"
        self.modules.append(llvm.parse_assembly(cgutils.normalize_ir_text(str(module))))

    def finalize(self) -> None:
        """Mark the library as complete.

        numba's own method would also add the code of called functions; ``with_dependencies`` finds the
        libraries of these functions later.
        """
        self._raise_if_finalized()
        self._finalized = True

    def get_pointer_to_function(self, _name: str) -> int:
        """Return 0 in place of a function's address: in this process no function is compiled or called."""
        self._ensure_finalized()
        return 0

    def with_dependencies(self) -> Iterator[Library]:
        """Yield this library and all libraries that it calls, directly or indirectly, each once."""
        visited: dict[Library, None] = {}
        waiting = [self]
        while waiting:
            library = waiting.pop()
            if library not in visited:
                library._ensure_finalized()
                visited[library] = None
                waiting.extend(library._linking_libraries)
        return iter(visited)


class Convention(callconv.MinimalCallConv):
    """How lowered functions call each other: a function stores its result at an address, and returns a code.

    The code is 0, or the code of an error where Python would raise an exception.
    """

    def decorate_function(self, fn: Any, args: Any, fe_argtypes: Any, noalias: bool = False) -> None:
        """Tell LLVM two facts about the pointer to the result, the first argument, for better code.

        No other pointer points to the result, and the function keeps no copy of the pointer.
        """
        super().decorate_function(fn, args, fe_argtypes, noalias)
        for attribute in ("captures(none)", "noalias"):
            fn.args[0].add_attribute(attribute)

    def return_user_exc(self, builder: ir.IRBuilder, *_: Any, **__: Any) -> None:
        """Make a function return the same error code for every exception, without numba's data on it."""
        self._return_errcode_raw(builder, callconv.RETCODE_USEREXC)


def collect_only(*, any_python: bool, guarded: bool) -> None:
    """Make numba, in this process, only lower functions to LLVM's language.

    Args:
        any_python: whether the functions may use all of Python that numba supports, as a user's law may; if
            False, they may use only the features that the kernel uses.
        guarded: whether the C functions set the floating-point registers (registers.c); this is not needed
            for functions that only the kernel calls.
    """
    codegen.JITCPUCodegen._library_class = Library
    codegen.JITCPUCodegen.set_env = _do_nothing
    cpu.CPUContext.call_conv = property(Convention)
    cpu.CPUContext.create_cfunc_wrapper = partialmethod(_entry_point, guarded=guarded)
    base.BaseContext.get_abi_sizeof = _compute_once(
        base.BaseContext.get_abi_sizeof, lambda _, kind: str(kind)
    )
    types.Function.get_call_type = _compute_once(  # type: ignore[method-assign]
        types.Function.get_call_type,
        lambda function, _, kinds, keywords: (function, kinds, *keywords.items()),
    )
    compiler_machinery.PassManager._runPass = _runs_passes(frozenset() if any_python else IDLE)
    if not any_python:
        arrayobj.fix_integer_index = _plain_index
    gc.disable()  # in a compiler that ends soon, garbage collection takes more time than it saves


def _plain_index(context: Any, builder: Any, kind: Any, index: Any, _size: Any) -> Any:
    """Return ``index`` as an integer of the machine, in place of numba's code for negative indices.

    The kernel has no negative indices, which in Python count from the end of an array.
    """
    return context.cast(builder, index, kind, types.intp)


def _entry_point(context: Any, library: Library, description: Any, *_: Any, guarded: bool, **__: Any) -> None:
    """Make the C function that calls a lowered function, and returns its result, or 0 after an error code.

    A ``guarded`` C function computes with the usual settings of the floating-point registers, and then
    restores the settings of the caller.
    """
    module = context.create_module("entry point")
    result, arguments = description.restype, description.argtypes
    lowered_function = ir.Function(
        module, context.call_conv.get_function_type(result, arguments), description.llvm_func_name
    )
    kind = ir.FunctionType(
        context.get_value_type(result), [context.get_value_type(argument) for argument in arguments]
    )
    entry = ir.Function(module, kind, description.llvm_cfunc_wrapper_name)
    builder = ir.IRBuilder(entry.append_basic_block("entry"))
    caller_settings = builder.call(_declare_external(module, WORD, USUAL_REGISTERS), ()) if guarded else None
    _, value = context.call_conv.call_function(builder, lowered_function, result, arguments, entry.args)
    if caller_settings:
        builder.call(_declare_external(module, ir.VoidType(), PUT_BACK, WORD), [caller_settings])
        # The calls of the lowered function and of the functions for the registers must not be inlined: LLVM
        # could then move arithmetic before the registers are set, or after they are restored.
        for call in builder.block.instructions:
            if isinstance(call, ir.CallInstr):
                call.attributes.add("noinline")
    builder.ret(value)
    library.add_ir_module(module)


def _declare_external(module: ir.Module, result: ir.Type, name: str, *arguments: ir.Type) -> ir.Function:
    return ir.Function(module, ir.FunctionType(result, arguments), name)


def _runs_passes(leave_out: Container[str]) -> Callable[..., None]:
    """Return a function that runs one pass of numba, unless the name of the pass is in ``leave_out``.

    Unlike numba's own function, it neither measures times nor repeats the analysis of the compiled function.
    """

    def run(manager: Any, _index: int, step: Any, state: Any) -> None:
        if step.name() not in leave_out:
            step.analysis = manager._analysis
            step.run_pass(state)

    return run


def _compute_once(method: Callable[..., Any], key: Callable[..., Any]) -> Callable[..., Any]:
    """Return a method that computes each result of ``method`` once, because numba asks thousands of times.

    ``key`` is a function of the arguments; calls with equal keys have the same result.
    """
    results: dict[Any, Any] = {}

    def remembered(*arguments: Any) -> Any:
        result_key = key(*arguments)
        if result_key not in results:
            results[result_key] = method(*arguments)
        return results[result_key]

    return remembered


def _do_nothing(*_: Any) -> None:
    """Do nothing, in place of numba's method ``set_env``, which stores a Python object for compiled code.

    Only code that runs in this process would need the object.
    """
