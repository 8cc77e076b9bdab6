"""Lower the C functions of a module of this folder to LLVM's language: ``lower_functions.py MODULE FILE``.

It is run in a process of its own, because it changes how numba compiles.
"""

from __future__ import annotations

# common.py adds the folder to Python's path from which some of these modules import tests.textbook.
import common  # isort: skip  # noqa: F401

import sys
from importlib import import_module
from pathlib import Path

from chain_impact.compilation.collecting import collect_only
from chain_impact.compilation.lower import lowered


def main() -> None:
    """Write what the module's ``entry_points()`` are and call to the file."""
    name, file = sys.argv[1:]
    module = import_module(name)
    collect_only(any_python=False, guarded=True)
    Path(file).write_text(lowered(module.entry_points()), encoding="utf-8")


if __name__ == "__main__":
    main()
