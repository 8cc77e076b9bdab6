"""The imports that programs of the docs need, and their run in a process that has already imported these."""

import os
import runpy
import sys
import warnings
from importlib import import_module

for name in ("matplotlib.pyplot", "scipy.optimize", "chain_impact.cli", "chain_impact.pictures"):
    import_module(name)


def program(folder: str, *arguments: str) -> None:
    """Run ``python *arguments`` in a folder: a module after -m, or a file.

    Python's option ``-W`` of this process holds for a file, but not for a module.
    """
    os.chdir(folder)
    sys.path[0] = folder
    if arguments[0] == "-m":
        warnings.resetwarnings()
        sys.argv = list(arguments[1:])
        runpy.run_module(arguments[1], run_name="__main__", alter_sys=True)
    else:
        sys.argv = list(arguments)
        runpy.run_path(arguments[0], run_name="__main__")
