"""Lower a part of a kernel to LLVM's intermediate language: lower.py FINGERPRINT FILE WHAT [LAW].

WHAT is `kernel`; `derivatives`, the hooks that carry derivatives along with a run; or `law`, a user's law in
the file LAW.

The program runs in a separate process, because it changes how numba compiles, and because numba reads the
target processor when it is imported.
"""

from __future__ import annotations

import sys
from pathlib import Path

from llvmlite import binding as llvm
from numba import cfunc

from chain_impact.compilation.collecting import Library, collect_only
from chain_impact.compilation.compilers import BAD_LAW, PORTABLE_CPU
from chain_impact.compilation.entry_points import Entries, entry_points, hook_entries
from chain_impact.compilation.functions import OPTIONS
from chain_impact.compilation.law import law_entry
from chain_impact.compilation.sources import fingerprint
from chain_impact.laws.law_file import LawError, read_law

TRIPLE = "x86_64-unknown-linux-gnu"  # the target that LLVM's passes in this process assume
# [words] size of the frame of ``main``. Python keeps the frames of calls in blocks of 16 kB. Each time that
# calls cross the end of a block, Python allocates or frees a block, which takes time. For a frame of this
# size Python makes one block, of the next larger power of two, which has room for the frames of all calls in
# numba.
FRAME = 2**20


def lowered(entries: Entries) -> str:
    """Return C functions, and all functions that they call, as one module that fixes no target or sizes."""
    libraries: dict[Library, None] = {}
    names = {}
    for name, (signature, function) in entries.items():
        callback = cfunc(signature, **OPTIONS)(function)
        libraries |= dict.fromkeys(callback._library.with_dependencies())
        names[callback.native_name] = name
    whole = _joined([module for library in libraries for module in library.modules])
    for symbol in (*whole.functions, *whole.global_variables):
        if symbol.name in names:
            symbol.name = names[symbol.name]
        if symbol.name in entries:
            symbol.linkage = llvm.Linkage.external
        elif not symbol.is_declaration:
            # the function is private to the library, and is removed after inlining
            symbol.linkage = llvm.Linkage.internal
    _simplify(whole)
    return "".join(f"{line}\n" for line in str(whole).splitlines() if not line.startswith("target "))


def _joined(modules: list[llvm.ModuleRef]) -> llvm.ModuleRef:
    """Return all modules joined to one module.

    The modules are joined in pairs, because the time to join two modules grows with the sizes of both.
    """
    while len(modules) > 1:
        for module, next_module in zip(modules[::2], modules[1::2], strict=False):
            module.link_in(next_module)
        modules = modules[::2]
    return modules[0]


def _simplify(whole: llvm.ModuleRef) -> None:
    """Remove variables in memory, and code without effect, once for all compilations of this module.

    Each compilation begins with the same passes, so kernels are as fast as without this step. Further
    passes, such as combining instructions, would make kernels up to 12 % slower, because such passes should
    come after inlining.
    """
    # all targets are initialized, because the machine may have another processor than the target
    llvm.initialize_all_targets()
    machine = llvm.Target.from_triple(TRIPLE).create_target_machine(cpu=PORTABLE_CPU)
    builder = llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options())
    passes = llvm.create_new_function_pass_manager()
    passes.add_sroa_pass()
    passes.add_dead_code_elimination_pass()
    passes.add_simplify_cfg_pass()
    for function in whole.functions:
        if not function.is_declaration:
            passes.run(function, builder)
    unused = llvm.create_new_module_pass_manager()
    unused.add_global_dead_code_eliminate_pass()
    unused.run(whole, builder)


def main() -> None:
    """Write the module for the part WHAT of a kernel to FILE."""
    expected, file, what, *given = sys.argv[1:]
    path = Path(file)
    collect_only(any_python=what == "law", guarded=what == "kernel")
    try:
        if what == "law":
            entries = law_entry(read_law(Path(given[0])))
        else:
            entries = entry_points() if what == "kernel" else hook_entries()
    except LawError as error:
        print(" ".join(str(error).split()), file=sys.stderr)
        sys.exit(BAD_LAW)
    text = lowered(entries)
    if fingerprint() != expected:
        sys.exit("the sources of the kernel have changed since the program began: run it again")
    path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main.__code__ = main.__code__.replace(co_stacksize=FRAME)
    main()
