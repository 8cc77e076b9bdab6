"""A fault of pythonfmu 0.7.0, and how a process that has run its FMUs ends well.

The library of such an FMU releases its state when the process ends, and then a second time, in memory that
is free by then. Now and then that ends in an abort, after all is done. Released before, it is not released
again.
"""

from __future__ import annotations

import ctypes
from pathlib import Path
from typing import Any


def release(folder: Path, description: Any) -> None:
    """Release the state of pythonfmu, if the FMU in a folder is one of its, once its instances are freed.

    Args:
        folder: where the FMU is unpacked.
        description: its model description, as fmpy gives it.
    """
    import fmpy

    name = description.coSimulation.modelIdentifier + fmpy.sharedLibraryExtension
    try:
        library = ctypes.CDLL(str(folder / "binaries" / fmpy.platform / name))
    except OSError:  # there is none, or it is not for this machine
        return
    finalize = getattr(library, "finalizePythonInterpreter", None)
    if finalize is not None:
        finalize()
