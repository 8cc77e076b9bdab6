"""Lowers a part of a kernel to LLVM's intermediate language: lower.py FINGERPRINT FILE WHAT [LAW].

The result is written to FILE. WHAT is `kernel`; or `derivatives`, the hooks (kernel/hooks.py) that carry
derivatives along with a run; or `law`, a user's law in the file LAW. FINGERPRINT is that of the sources at
the caller's start; if the sources have changed since, the program writes nothing and fails.

The program runs in a process of its own, because it changes how numba compiles, and because numba reads the
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
from chain_impact.user_laws.law_file import LawError, read_law

# the target for which LLVM's passes run in this process; their result does not depend on it
TRIPLE = "x86_64-unknown-linux-gnu"
# [words] size of the stack frame of ``main``. Python keeps frames in blocks of 16 kB, and allocates or frees
# a block whenever calls cross the end of a block, which takes time. For a frame of this size, Python
# allocates one block with room for the frames of all calls in numba.
FRAME = 2**20


def lowered_code(entries: Entries) -> str:
    """Return the LLVM code of C functions and of all functions that they call.

    The code names no target processor, and declares the functions that return sizes, but does not define
    them.
    """
    libraries: dict[Library, None] = {}
    names = {}
    for name, (signature, function) in entries.items():
        callback = cfunc(signature, **OPTIONS)(function)
        libraries |= dict.fromkeys(callback._library.with_dependencies())
        names[callback.native_name] = name
    joined_module = _join_modules([module for library in libraries for module in library.modules])
    for symbol in (*joined_module.functions, *joined_module.global_variables):
        if symbol.name in names:
            symbol.name = names[symbol.name]
        if symbol.name in entries:
            symbol.linkage = llvm.Linkage.external
        elif not symbol.is_declaration:
            # no other library sees the function; LLVM removes it if all calls of it are inlined
            symbol.linkage = llvm.Linkage.internal
    _simplify(joined_module)
    return "".join(f"{line}\n" for line in str(joined_module).splitlines() if not line.startswith("target "))


def _join_modules(modules: list[llvm.ModuleRef]) -> llvm.ModuleRef:
    """Return all modules joined to one.

    The modules are joined in pairs, because the time to join two modules grows with the size of both.
    """
    while len(modules) > 1:
        for module, next_module in zip(modules[::2], modules[1::2], strict=False):
            module.link_in(next_module)
        modules = modules[::2]
    return modules[0]


def _simplify(module: llvm.ModuleRef) -> None:
    """Keep variables in registers, and remove code without effect, so that no compilation has to do this.

    Without this step, each compilation would begin with the same passes, so this step does not change the
    speed of kernels. Further passes, such as combining instructions, would make kernels up to 12 % slower,
    because such passes should come after inlining.
    """
    # all targets, because this machine's processor may differ from that of the target TRIPLE
    llvm.initialize_all_targets()
    machine = llvm.Target.from_triple(TRIPLE).create_target_machine(cpu=PORTABLE_CPU)
    builder = llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options())
    passes = llvm.create_new_function_pass_manager()
    passes.add_sroa_pass()
    passes.add_dead_code_elimination_pass()
    passes.add_simplify_cfg_pass()
    for function in module.functions:
        if not function.is_declaration:
            passes.run(function, builder)
    unused = llvm.create_new_module_pass_manager()
    unused.add_global_dead_code_eliminate_pass()
    unused.run(module, builder)


def main() -> None:
    """Write the part WHAT of a kernel in LLVM's language to FILE, as the head of this module tells."""
    fingerprint_at_start, file, part, *law_files = sys.argv[1:]
    path = Path(file)
    collect_only(any_python=part == "law", guarded=part == "kernel")
    try:
        if part == "law":
            entries = law_entry(read_law(Path(law_files[0])))
        else:
            entries = entry_points() if part == "kernel" else hook_entries()
    except LawError as error:
        print(" ".join(str(error).split()), file=sys.stderr)
        sys.exit(BAD_LAW)
    text = lowered_code(entries)
    if fingerprint() != fingerprint_at_start:
        sys.exit("the sources of the kernel have changed since the program began: run it again")
    path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main.__code__ = main.__code__.replace(co_stacksize=FRAME)
    main()
