"""The run of an FMU with fmpy, such that several threads may run FMUs at the same time.

The streams and the working folder of the process stay unchanged; fmpy alone would change them.
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
from chain_impact.scene.errors import SceneError
from chain_impact.simulation.errors import RunError
from chain_impact.system import HOST, PLATFORMS

# the number of the status fmi2Warning; messages up to this status are dropped, because they report no fault
WARNING = 1
# The name of the logger to which the slaves in Python (slave.py) write their errors.
SLAVE_LOGGER = "chain_impact.fmu"
# two lists of the errors that FMUs report while ``collect_messages`` lasts in the calling thread: `logged`
# has those sent by FMI's callback, `slave_messages` those of slaves in Python (of SLAVE_LOGGER)
_thread = threading.local()


def read_fmu(path: Path) -> Any:
    """Return the model description of an FMU, in fmpy's form.

    Raises:
        SceneError: when the file is not a complete and valid FMU.
        OSError: when the file cannot be read.
    """
    import fmpy  # imported here, because the import takes half a second

    try:
        for finding in archive_findings(path):
            raise SceneError(f"{path}: not a readable FMU: {finding}")
        return fmpy.read_model_description(str(path))
    except (OSError, SceneError):
        raise
    except Exception as error:  # zipfile, lxml and fmpy's own checks raise exceptions of many kinds
        reason = str(error).strip('"')
        raise SceneError(f"{path}: not a readable FMU: {reason}") from None


def run_with_fmpy(path: Path, description: Any, **options: Any) -> np.ndarray:
    """Simulate an FMU of FMI 2.0 or 3.0 with fmpy; return fmpy's rows of outputs over time.

    Args:
        path: the FMU.
        description: the model description of the FMU, from ``read_fmu``.
        options: the options of ``fmpy.simulate_fmu``.

    Raises:
        RunError: when the FMU has no binary for this machine, or fails; the message has the first reason that
            the FMU gave, or fmpy's if the FMU gave none.
    """
    import fmpy

    mode = description.coSimulation or description.modelExchange
    with zipfile.ZipFile(path) as fmu:
        names = fmu.namelist()
    _, missing_text = binary_of(mode.modelIdentifier, names, is_fmi_2=is_fmi_2(description.fmiVersion))
    if missing_text:
        raise RunError(f"{path}: {missing_text}")
    with collect_messages() as reasons:
        try:
            # unpacked here, so that the files are removed in any case: fmpy leaves its own files behind after
            # a failed call
            with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
                fmpy.extract(str(path), folder)
                instance = load_fmu(description, folder)
                instantiate(instance)
                kind = "CoSimulation" if description.coSimulation else "ModelExchange"
                rows: np.ndarray = fmpy.simulate_fmu(
                    folder, model_description=description, fmu_instance=instance, fmi_type=kind, **options
                )
                instance.freeInstance()
        except Exception as error:  # fmpy's exceptions have no common class
            # the first message has the reason; later ones may come from calls that fmpy makes after the
            # failed call
            reason = [*reasons(), str(error)][0]
            raise RunError(f"{path}: {reason}") from None
    return rows


@contextmanager
def collect_messages() -> Iterator[Callable[[], list[str]]]:
    """Context that collects the messages of FMUs that this thread runs.

    The context yields a function that returns the messages so far: the log messages of slaves in Python, then
    the errors that FMUs send by FMI's callback; warnings by this callback are left out.
    """
    _thread.slave_messages, _thread.logged = [], []
    try:
        yield lambda: [*_thread.slave_messages, *_thread.logged]
    finally:
        del _thread.slave_messages, _thread.logged


def _collect_error(*call: Any) -> None:
    """Collect an error that an FMU sends by FMI's callback, if ``collect_messages`` lasts in this thread."""
    # FMI 2.0 passes the name of the instance before these three arguments, FMI 3.0 does not
    status, _category, message = call[-3:]
    if status > WARNING and hasattr(_thread, "logged"):
        _thread.logged.append(message.decode(errors="replace"))


def _collect_record(record: logging.LogRecord) -> bool:
    """Collect a log message of a slave in Python, if this thread runs an FMU in ``collect_messages``.

    The result tells the logger whether to log the message: only if this thread runs no FMU.
    """
    messages = getattr(_thread, "slave_messages", None)
    if messages is not None:
        messages.append(record.getMessage())
    return messages is None


logging.getLogger(SLAVE_LOGGER).addFilter(_collect_record)


def load_fmu(description: Any, folder: str) -> Any:
    """Return fmpy's object for an unpacked FMU, whose library is loaded but not yet called."""
    from fmpy import fmi2, fmi3, platform

    _place_binaries(Path(folder, "binaries"), platform)
    modes = description.coSimulation or description.modelExchange
    instance_names = {
        "guid": description.guid,
        "modelIdentifier": modes.modelIdentifier,
        "unzipDirectory": folder,
    }
    is_stepped = modes is description.coSimulation
    if not is_fmi_2(description.fmiVersion):
        return keep_working_folder(fmi3.FMU3Slave if is_stepped else fmi3.FMU3Model)(**instance_names)
    return keep_working_folder(fmi2.FMU2Slave if is_stepped else fmi2.FMU2Model)(**instance_names)


def instantiate(fmu: Any) -> None:
    """Make the instance of a loaded FMU; messages of the FMU go to ``_collect_error``."""
    from fmpy import fmi2

    if isinstance(fmu, fmi2.FMU2Slave | fmi2.FMU2Model):
        with _CALLBACK_LOCK:
            callbacks = _callbacks()
        fmu.instantiate(callbacks=callbacks, loggingOn=True)
    else:
        fmu.instantiate(loggingOn=True, logMessage=_collect_error)


# Held while ``_callbacks`` is called, so that two threads do not make two sets of callbacks.
_CALLBACK_LOCK = threading.Lock()


@cache
def _callbacks() -> Any:
    """Return the callbacks for all FMUs of FMI 2.0.

    All FMUs share one set, because fmpy's library for messages knows only the logger of the set that was
    added last, and would send the messages of all FMUs to this logger.
    """
    from fmpy import fmi2

    callbacks = fmi2.fmi2CallbackFunctions()
    callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(_collect_error)
    callbacks.allocateMemory, callbacks.freeMemory = (
        getattr(fmi2.defaultCallbacks, name) for name in ("allocateMemory", "freeMemory")
    )
    # where fmpy's library for messages is missing, as on ARM, messages keep their format signs, such as %s,
    # and have no values in their place
    with suppress(Exception):
        from fmpy.logging import addLoggerProxy

        addLoggerProxy(ctypes.byref(callbacks))
    return callbacks


@cache
def keep_working_folder(kind: type) -> type:
    """Return a subclass of ``kind``, a class of fmpy's instances, that does not change the working folder.

    fmpy's constructor changes the working folder of the whole process to load the library, and does not
    restore it after an error. The returned class runs the same code with an ``os`` whose ``chdir`` does
    nothing. If the constructor does not change the folder, the class is returned as it is.
    """
    base = kind.__mro__[-2]  # the class from which all of fmpy's classes of instances inherit
    fmpys: Any = base.__init__  # type: ignore[misc]
    if "chdir" not in fmpys.__code__.co_names:
        return kind
    still_os = SimpleNamespace(**{**vars(os), "chdir": lambda _folder: None})
    load = FunctionType(fmpys.__code__, {**fmpys.__globals__, "os": still_os}, "__init__", fmpys.__defaults__)
    return type(kind.__name__, (kind, type("InPlace", (base,), {"__init__": load})), {})


def _place_binaries(binaries: Path, folder: str) -> None:
    """Copy this machine's binaries to the folder ``folder`` of ``binaries``, in which fmpy looks for them.

    Nothing is copied if ``folder`` has this machine's name in FMI 2.0, or if the machine is no known
    platform. On ARM the two differ, because fmpy looks for the binary of an FMI 2.0 FMU in the folder of
    x86-64. The machine's own folder has the name of FMI 2.0 or the name of FMI 3.0; both names are tried.
    """
    names = [HOST, PLATFORMS[HOST].fmi3] if HOST and folder != HOST else []
    for name in names:
        if (binaries / name).is_dir():
            shutil.copytree(binaries / name, binaries / folder, dirs_exist_ok=True)
