"""fmpy as the importer of an FMU, which changes neither the streams nor the working folder of the process.

Several threads may run FMUs at once.
"""

from __future__ import annotations

import ctypes
import logging
import os
import shutil
import tempfile
import threading
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from types import FunctionType, SimpleNamespace
from typing import Any

import numpy as np

from chain_impact.fmu.findings import archive_findings
from chain_impact.fmu.platforms import binary_of
from chain_impact.scene.reading import SceneError
from chain_impact.simulation.record_scene import RunError
from chain_impact.system import HOST, PLATFORMS

WARNING = 1  # fmi2Warning; what is worse comes after it
SLAVES = "chain_impact.fmu"
"""The name of the logger of slaves in Python, see slave.py."""
_here = threading.local()  # what the FMU that this thread runs has said, and what it has logged


def read_fmu(path: Path) -> Any:
    """The model description of an FMU, as fmpy gives it.

    Raises:
        SceneError: when the file is no FMU.
    """
    import fmpy  # takes half a second

    try:
        for finding in archive_findings(path):
            raise SceneError(f"{path}: not a readable FMU: {finding}")
        return fmpy.read_model_description(str(path))
    except (OSError, SceneError):
        raise
    except Exception as error:  # whatever zipfile, lxml and fmpy's own checks raise
        reason = str(error).strip('"')
        raise SceneError(f"{path}: not a readable FMU: {reason}") from None


def simulated(path: Path, description: Any, **options: Any) -> np.ndarray:
    """Simulate an FMU for FMI 2.0 or 3.0 with fmpy; return its rows.

    Args:
        path: the FMU.
        description: its model description, as ``read_fmu`` gives it.
        options: those of ``fmpy.simulate_fmu``.

    Raises:
        RunError: when it has no binary for this machine, or fails, with the first reason that the FMU gave.
    """
    import fmpy

    mode = description.coSimulation or description.modelExchange
    with zipfile.ZipFile(path) as fmu:
        names = fmu.namelist()
    _, missing = binary_of(mode.modelIdentifier, names, second=description.fmiVersion == "2.0")
    if missing:
        raise RunError(f"{path}: {missing}")
    with listening() as reasons:
        try:
            # fmpy leaves what it has unpacked when a call fails
            with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
                fmpy.extract(str(path), folder)
                instance = loaded(description, folder)
                instantiate(instance)
                kind = "CoSimulation" if description.coSimulation else "ModelExchange"
                rows: np.ndarray = fmpy.simulate_fmu(
                    folder, model_description=description, fmu_instance=instance, fmi_type=kind, **options
                )
                instance.freeInstance()
        except Exception as error:  # fmpy's exceptions have no common class
            # the first that is said: after it, an importer may go on to the next refusal
            reason = [*reasons(), str(error)][0]
            raise RunError(f"{path}: {reason}") from None
    return rows


@contextmanager
def listening() -> Iterator[Callable[[], list[str]]]:
    """Take what the FMUs say that this thread runs; yields a function that returns it, the first first."""
    _here.said, _here.logged = [], []
    try:
        yield lambda: [*_here.said, *_here.logged]
    finally:
        del _here.said, _here.logged


def _log(*call: Any) -> None:
    """Take what an FMU says to its importer, in the thread that calls it."""
    status, _category, message = call[-3:]  # before them FMI 2.0 has a name that FMI 3.0 does not have
    if status > WARNING and hasattr(_here, "logged"):
        _here.logged.append(message.decode(errors="replace"))


def _heard(record: logging.LogRecord) -> bool:
    """Take what a slave says where this thread runs it: it becomes an error. All else is logged."""
    said = getattr(_here, "said", None)
    if said is not None:
        said.append(record.getMessage())
    return said is None


logging.getLogger(SLAVES).addFilter(_heard)


def loaded(description: Any, folder: str) -> Any:
    """An unpacked FMU with its library loaded; nothing of it but what the library does by itself has run."""
    from fmpy import fmi2, fmi3, platform

    _place_binaries(Path(folder, "binaries"), platform)
    modes = description.coSimulation or description.modelExchange
    named = {"guid": description.guid, "modelIdentifier": modes.modelIdentifier, "unzipDirectory": folder}
    stepped = modes is description.coSimulation
    if description.fmiVersion != "2.0":
        return _in_place(fmi3.FMU3Slave if stepped else fmi3.FMU3Model)(**named)
    return _in_place(fmi2.FMU2Slave if stepped else fmi2.FMU2Model)(**named)


def instantiate(fmu: Any) -> None:
    """Make the instance of a loaded FMU, which says all to ``_log``."""
    from fmpy import fmi2

    if isinstance(fmu, fmi2.FMU2Slave | fmi2.FMU2Model):
        with _ALONE:
            callbacks = _callbacks()
        fmu.instantiate(callbacks=callbacks, loggingOn=True)
    else:
        fmu.instantiate(loggingOn=True, logMessage=_log)


_ALONE = threading.Lock()
"""So that several threads that run their first FMU at once make the callbacks once."""


@cache
def _callbacks() -> Any:
    """What FMUs for FMI 2.0 call: the same for all, as fmpy's library keeps the logger of the last one."""
    from fmpy import fmi2

    callbacks = fmi2.fmi2CallbackFunctions()
    callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(_log)
    callbacks.allocateMemory, callbacks.freeMemory = (
        getattr(fmi2.defaultCallbacks, name) for name in ("allocateMemory", "freeMemory")
    )
    with suppress(Exception):  # fmpy has no such library for ARM; without it, values stay out of messages
        from fmpy.logging import addLoggerProxy

        addLoggerProxy(ctypes.byref(callbacks))
    return callbacks


@cache
def _in_place(kind: type) -> type:
    """A kind of fmpy's instances that loads its library without a change of the working folder.

    fmpy's constructor changes that of the whole process meanwhile, and for good where it fails. So it is
    given a module ``os`` in which that does nothing.
    """
    base = kind.__mro__[-2]  # of all of fmpy's kinds
    fmpys: Any = base.__init__  # type: ignore[misc]
    still = SimpleNamespace(**{**vars(os), "chdir": lambda _folder: None})
    load = FunctionType(fmpys.__code__, {**fmpys.__globals__, "os": still}, "__init__", fmpys.__defaults__)
    return type(kind.__name__, (kind, type("InPlace", (base,), {"__init__": load})), {})


def _place_binaries(binaries: Path, folder: str) -> None:
    """Put this machine's binaries where fmpy looks: on ARM it looks for those of x86-64, too."""
    names = [HOST, PLATFORMS[HOST].fmi3] if HOST and folder != HOST else []
    for name in names:
        if (binaries / name).is_dir():
            shutil.copytree(binaries / name, binaries / folder, dirs_exist_ok=True)
