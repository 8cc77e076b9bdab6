"""fmpy as the importer of an FMU; the streams and the working folder of the process stay unchanged.

Several threads may run FMUs at the same time.
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
from chain_impact.fmu.versions import is_fmi_2
from chain_impact.scene.reading import SceneError
from chain_impact.simulation.record_scene import RunError
from chain_impact.system import HOST, PLATFORMS

# number of the status fmi2Warning; only messages with a larger status are kept, because they report faults
WARNING = 1
SLAVES = "chain_impact.fmu"
"""The name of the logger of slaves in Python; see slave.py."""
_here = threading.local()  # the messages and logs of the FMU that the calling thread runs


def read_fmu(path: Path) -> Any:
    """Return the model description of an FMU, in fmpy's form.

    Raises:
        SceneError: when the file is not an FMU.
    """
    import fmpy  # this import takes half a second

    try:
        for finding in archive_findings(path):
            raise SceneError(f"{path}: not a readable FMU: {finding}")
        return fmpy.read_model_description(str(path))
    except (OSError, SceneError):
        raise
    except Exception as error:  # zipfile, lxml and fmpy's own checks raise exceptions of many kinds
        reason = str(error).strip('"')
        raise SceneError(f"{path}: not a readable FMU: {reason}") from None


def simulated(path: Path, description: Any, **options: Any) -> np.ndarray:
    """Simulate an FMU of FMI 2.0 or 3.0 with fmpy; return the rows of outputs.

    Args:
        path: the FMU.
        description: the model description of the FMU, from ``read_fmu``.
        options: the options of ``fmpy.simulate_fmu``.

    Raises:
        RunError: when the FMU has no binary for this machine, or fails; the message has the first reason that
            the FMU gave.
    """
    import fmpy

    mode = description.coSimulation or description.modelExchange
    with zipfile.ZipFile(path) as fmu:
        names = fmu.namelist()
    _, missing = binary_of(mode.modelIdentifier, names, is_fmi_2=is_fmi_2(description.fmiVersion))
    if missing:
        raise RunError(f"{path}: {missing}")
    with listening() as reasons:
        try:
            # the unpacked files are removed here, because fmpy does not remove them when a call fails
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
            # the first message has the reason; later messages may be about calls that fmpy makes after the
            # failed call
            reason = [*reasons(), str(error)][0]
            raise RunError(f"{path}: {reason}") from None
    return rows


@contextmanager
def listening() -> Iterator[Callable[[], list[str]]]:
    """Collect the messages of the FMUs that this thread runs.

    The yielded function returns the messages in the order of time.
    """
    _here.said, _here.logged = [], []
    try:
        yield lambda: [*_here.said, *_here.logged]
    finally:
        del _here.said, _here.logged


def _log(*call: Any) -> None:
    """Collect a message that an FMU sends to its importer in the calling thread."""
    # the callback of FMI 2.0 has the instance's name before these three arguments, that of FMI 3.0 has no
    # name
    status, _category, message = call[-3:]
    if status > WARNING and hasattr(_here, "logged"):
        _here.logged.append(message.decode(errors="replace"))


def _heard(record: logging.LogRecord) -> bool:
    """Collect a log message of a slave in Python as an error, if this thread runs an FMU.

    Returns whether the message shall be logged: only if this thread runs no FMU.
    """
    said = getattr(_here, "said", None)
    if said is not None:
        said.append(record.getMessage())
    return said is None


logging.getLogger(SLAVES).addFilter(_heard)


def loaded(description: Any, folder: str) -> Any:
    """Return an unpacked FMU with its library loaded, before any call of the FMU."""
    from fmpy import fmi2, fmi3, platform

    _place_binaries(Path(folder, "binaries"), platform)
    modes = description.coSimulation or description.modelExchange
    named = {"guid": description.guid, "modelIdentifier": modes.modelIdentifier, "unzipDirectory": folder}
    stepped = modes is description.coSimulation
    if not is_fmi_2(description.fmiVersion):
        return _in_place(fmi3.FMU3Slave if stepped else fmi3.FMU3Model)(**named)
    return _in_place(fmi2.FMU2Slave if stepped else fmi2.FMU2Model)(**named)


def instantiate(fmu: Any) -> None:
    """Make the instance of a loaded FMU; the FMU's messages go to ``_log``."""
    from fmpy import fmi2

    if isinstance(fmu, fmi2.FMU2Slave | fmi2.FMU2Model):
        with _ALONE:
            callbacks = _callbacks()
        fmu.instantiate(callbacks=callbacks, loggingOn=True)
    else:
        fmu.instantiate(loggingOn=True, logMessage=_log)


_ALONE = threading.Lock()
"""A lock: two threads must not make the callbacks at the same time, because all FMUs share them."""


@cache
def _callbacks() -> Any:
    """Return the callbacks for FMUs of FMI 2.0.

    All FMUs share one set of callbacks: fmpy's logger library keeps only the last logger that it gets, and
    would send the messages of all FMUs there.
    """
    from fmpy import fmi2

    callbacks = fmi2.fmi2CallbackFunctions()
    callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(_log)
    callbacks.allocateMemory, callbacks.freeMemory = (
        getattr(fmi2.defaultCallbacks, name) for name in ("allocateMemory", "freeMemory")
    )
    with suppress(Exception):  # on ARM fmpy cannot write values into messages, so the messages have no values
        from fmpy.logging import addLoggerProxy

        addLoggerProxy(ctypes.byref(callbacks))
    return callbacks


@cache
def _in_place(kind: type) -> type:
    """Return a kind of fmpy's instances that loads its library without a change of the working folder.

    fmpy's constructor changes the working folder of the whole process, and does not restore it after an
    error. The returned class runs the same constructor with another ``os``, in which ``chdir`` does nothing.
    """
    base = kind.__mro__[-2]  # the common base class of all kinds of instances in fmpy
    fmpys: Any = base.__init__  # type: ignore[misc]
    still = SimpleNamespace(**{**vars(os), "chdir": lambda _folder: None})
    load = FunctionType(fmpys.__code__, {**fmpys.__globals__, "os": still}, "__init__", fmpys.__defaults__)
    return type(kind.__name__, (kind, type("InPlace", (base,), {"__init__": load})), {})


def _place_binaries(binaries: Path, folder: str) -> None:
    """Copy this machine's binaries to the folder where fmpy looks; on ARM this is the folder of x86-64."""
    names = [HOST, PLATFORMS[HOST].fmi3] if HOST and folder != HOST else []
    for name in names:
        if (binaries / name).is_dir():
            shutil.copytree(binaries / name, binaries / folder, dirs_exist_ok=True)
