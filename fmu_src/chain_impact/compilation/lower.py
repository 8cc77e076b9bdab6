"""Lower a kernel, or a user's law, to LLVM's intermediate language: lower.py FINGERPRINT FILE WHAT [LAW].

WHAT is `kernel`, `derivatives`, a kernel that carries them beside the run, or `law`.

It is run in a process of its own, because it changes how numba compiles, and because numba reads the
processor to compile for when it is imported.
"""

from __future__ import annotations

import sys
from pathlib import Path

from llvmlite import binding as llvm
from numba import cfunc

from chain_impact.compilation.collecting import Library, collect_only
from chain_impact.compilation.compilers import BAD_LAW
from chain_impact.compilation.entry_points import Entries, entry_points
from chain_impact.compilation.functions import OPTIONS
from chain_impact.compilation.law import law_entry
from chain_impact.compilation.sources import fingerprint
from chain_impact.law_file import LawError, read_law


def lowered(entries: Entries) -> str:
    """Some C functions and all that they call as one module, free of a target and of sizes."""
    libraries: dict[Library, None] = {}
    names = {}
    for name, (signature, function) in entries.items():
        callback = cfunc(signature, **OPTIONS)(function)
        libraries |= dict.fromkeys(callback._library.and_those_it_calls())
        names[callback.native_name] = name
    whole = llvm.parse_assembly("")
    for library in libraries:
        for module in library.modules:
            whole.link_in(module)
    for symbol in (*whole.functions, *whole.global_variables):
        if symbol.name in names:
            symbol.name = names[symbol.name]
            symbol.linkage = llvm.Linkage.external
        elif not symbol.is_declaration:
            # private to the library, and gone once it is inlined
            symbol.linkage = llvm.Linkage.internal
    return "".join(f"{line}\n" for line in str(whole).splitlines() if not line.startswith("target "))


def main() -> None:
    """Write the module of WHAT, which may be the law in the file LAW, to FILE."""
    expected, file, what, *laws = sys.argv[1:]
    path = Path(file)
    collect_only()
    try:
        if what == "law":
            entries = law_entry(read_law(Path(laws[0])))
        else:
            entries = entry_points(derivatives=what == "derivatives")
    except LawError as error:
        print(" ".join(str(error).split()), file=sys.stderr)
        sys.exit(BAD_LAW)
    text = lowered(entries)
    if fingerprint() != expected:
        sys.exit("the sources of the kernel have changed since the program began: run it again")
    path.write_text(text)


if __name__ == "__main__":
    main()
