"""Lower the kernel to LLVM's intermediate language. Run as a program, by `aot.py`, in its own process.

It runs apart because numba reads the processor to compile for when it is imported.
"""

from __future__ import annotations

import sys
from pathlib import Path

from llvmlite import binding as llvm
from numba import cfunc, from_dtype

from chain_impact.instance import instance_dtype, output_dtype
from chain_impact.kernel import user_law
from chain_impact.kernel.entry import entry_points
from chain_impact.law_file import compiled_law, read_law


def lower(links: int, candidates: int) -> str:
    """The entry points for N links and C candidates as one module of LLVM IR, free of a target."""
    records = from_dtype(instance_dtype(links, candidates)), from_dtype(output_dtype(links, candidates))
    whole = None
    for name, (signature, function) in entry_points(*records).items():
        module = llvm.parse_assembly(cfunc(signature)(function).inspect_llvm())
        for symbol in module.functions:
            if symbol.name.startswith("cfunc."):
                symbol.name = name
                symbol.linkage = llvm.Linkage.external
            elif not symbol.is_declaration:
                # what is not an entry point is private to it, and dropped by the linker once inlined
                symbol.linkage = llvm.Linkage.private
        for symbol in module.global_variables:
            if not symbol.is_declaration:
                symbol.linkage = llvm.Linkage.private
        if whole is None:
            whole = module
        else:
            whole.link_in(module)
    return "\n".join(line for line in str(whole).splitlines() if not line.startswith("target "))


def main() -> None:
    """Write the module: lower.py LINKS CANDIDATES FILE [LAW], with a user's law in the file LAW."""
    links, candidates, path, *laws = sys.argv[1:]
    for law in laws:
        user_law.install(compiled_law(read_law(Path(law))))
    Path(path).write_text(lower(int(links), int(candidates)))


if __name__ == "__main__":
    main()
