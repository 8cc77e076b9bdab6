"""The slave of an FMU: pythonfmu's wrapper calls the slave in the importer's process.

The slave needs only Python 3.8, its standard library and pythonfmu's modules, which the FMU contains. The
slave calls the kernel, the same library as in native FMUs. The kernel knows the state of each instance, and
checks each call. If the kernel refuses a call, the slave raises SlaveError, which is fatal for the instance.
FMI would also allow the slave to discard a step, but fmpy ends the run without a message after this.
"""

from __future__ import annotations

import atexit
import ctypes
import gc
import logging
import os
import threading
from array import array
from contextlib import suppress
from ctypes import byref, c_char_p, c_double, c_int, c_size_t, c_void_p
from functools import partialmethod
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from pythonfmu.fmi2slave import Fmi2Slave, Fmi2Status

# values of fmi2Status: WARNING, the worst status of a call that succeeds; PENDING, the status of a call
# that has to be repeated until it is complete
WARNING, PENDING = 1, 5
# in each thread, the kernel's messages that wait to be passed on: pairs of status and text (printf's format)
SAID = threading.local()
# the libraries of pythonfmu that have made instances of this FMU; ``_release`` needs them
WRAPPERS: set[Path] = set()
# the folder of this module; each FMU is unpacked to its own folder, and its module has its own name
RESOURCES = Path(__file__).absolute().parent
NAME, GUID = (RESOURCES / "slavemodule.txt").read_text(encoding="utf-8").split()[1:]
# the kernel compares the GUID that importers see, in modelDescription.xml, with its own; pythonfmu's wrapper
# does not pass this GUID on. Without this file, the GUID of slavemodule.txt stays.
with suppress(OSError):
    GUID = ElementTree.parse(RESOURCES.parent / "modelDescription.xml").getroot().attrib["guid"]
KERNEL = ctypes.CDLL(str(RESOURCES / f"kernel-{'win64.dll' if os.name == 'nt' else 'linux64.so'}"))
KERNEL.fmi2Instantiate.restype = KERNEL.another_fmi2_instance.restype = c_void_p
_log = ctypes.CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p)(
    lambda *said: vars(SAID).setdefault("messages", []).append((said[2], said[4].decode(errors="replace")))
)


class SlaveError(Exception):
    """Raised when the kernel refuses a call, or Ctrl-C ends a call.

    The text of the error is ``reason`` or, by default, the kernel's last message.
    """

    def __init__(self, *slaves: ChainImpact, reason: str = "") -> None:
        super().__init__(reason or vars(SAID).pop("messages")[-1][1])
        # pythonfmu 0.7.0 twice gives up its references to a slave, the slave's class and its log_queue: at an
        # exception of the slave, and when the importer frees the slave. One more reference to each of these
        # objects keeps Python from freeing the object too early.
        for kept in [kept for slave in slaves for kept in (slave, type(slave), slave.log_queue)]:
            ctypes.pythonapi.Py_IncRef(ctypes.py_object(kept))
        # Python logs this text to stderr, because fmpy itself shows only "status 4 (fatal)" by default
        text = str(self).replace("%%", "%").replace("##", "#")
        logging.getLogger("chain_impact.fmu").error("%s: %s", NAME, text)

    __repr__ = Exception.__str__  # the text, with % as %%: the wrapper logs the repr as a format of printf


_functions = (_log, ctypes.pythonapi.PyMem_RawCalloc, ctypes.pythonapi.PyMem_RawFree)
_callbacks = (c_void_p * 5)(*(ctypes.cast(function, c_void_p).value for function in _functions))
_given = (b"first", 1, GUID.encode(), RESOURCES.as_uri().encode(), _callbacks, 0, 1)
# the first instance reads the table of the scene; all later instances share this table
FIRST = c_void_p(KERNEL.fmi2Instantiate(*_given))
if not FIRST:
    raise SlaveError


@atexit.register
def _release() -> None:
    """At the end of the process, let pythonfmu 0.7.0 release its data while its library is still loaded.

    Otherwise pythonfmu would release these data later, in memory that is no longer valid.
    """
    for wrapper in WRAPPERS:
        # Windows has no RTLD_NOLOAD (AttributeError); OSError means that the library is no longer loaded
        with suppress(AttributeError, OSError):
            ctypes.CDLL(str(wrapper), mode=os.RTLD_NOLOAD).finalizePythonInterpreter()


class State(c_void_p):
    """A saved state of an instance; the kernel keeps the state as long as this object exists."""

    def __del__(self) -> None:
        KERNEL.fmi2FreeFMUstate(FIRST, byref(self))


def _access(function: str, code: str = "") -> Any:
    """Return a method that gets or sets the values of variables of one type by a function of the kernel.

    ``code`` is the code of the type in Python's module ``array``; "" for a type that no variable of the FMU
    has.
    """
    getattr(KERNEL, function).argtypes = (c_void_p, c_void_p, c_size_t, c_void_p)
    zero = array(code or "i", [0])

    def access(self: ChainImpact, vrs: list[int], values: list[Any] | None = None) -> list[Any]:
        references, numbers = array("i", vrs), array(code, values) if code and values else zero * len(vrs)
        self._call(function, references.buffer_info()[0], len(vrs), numbers.buffer_info()[0])
        return numbers.tolist()

    return access


class ChainImpact(Fmi2Slave):  # type: ignore[misc]
    """One instance of the FMU; a reset of the FMU makes a new instance."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        WRAPPERS.add(Path(self.resources).parent / "binaries" / "linux64" / f"{NAME}.so")
        self.component = c_void_p(KERNEL.another_fmi2_instance(FIRST, self.instance_name.encode()))
        if not self.component:
            raise SlaveError  # no slave as argument, because pythonfmu's wrapper has no references to it yet

    def __del__(self) -> None:
        KERNEL.fmi2FreeInstance(self.component)

    def _call(self, function: str, *arguments: Any) -> None:
        """Call a function of the kernel; if the call succeeds, pass the kernel's messages to the importer."""
        call, status = getattr(KERNEL, function), PENDING
        try:
            while status == PENDING:  # between two calls Python handles signals, such as that of Ctrl-C
                status = call(self.component, *arguments)
        except KeyboardInterrupt:
            raise SlaveError(self, reason=f"{function}: interrupted") from None
        if status > WARNING:
            raise SlaveError(self)
        for level, text in vars(SAID).pop("messages", ()):
            self.log(text, Fmi2Status(level))

    def setup_experiment(self, start: float, stop: float | None, tolerance: float | None) -> None:
        """Set the start and stop time [s]; the kernel does not use the tolerance."""
        given = (tolerance is not None, c_double(tolerance or 0.0), c_double(start))
        self._call("fmi2SetupExperiment", *given, stop is not None, c_double(stop or 0.0))

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Advance from the communication point ``current_time`` by ``step_size``, both in seconds."""
        self._call("fmi2DoStep", c_double(current_time), c_double(step_size), 0)
        return True

    enter_initialization_mode = partialmethod(_call, "fmi2EnterInitializationMode")
    exit_initialization_mode = partialmethod(_call, "fmi2ExitInitializationMode")
    terminate = partialmethod(_call, "fmi2Terminate")
    get_real, set_real = _access("fmi2GetReal", "d"), _access("fmi2SetReal", "d")
    get_integer, set_integer = _access("fmi2GetInteger", "i"), _access("fmi2SetInteger", "i")
    get_boolean, set_boolean = _access("fmi2GetBoolean"), _access("fmi2SetBoolean")
    get_string, set_string = _access("fmi2GetString"), _access("fmi2SetString")
    _set_fmu_state = partialmethod(_call, "fmi2SetFMUstate")

    def _get_fmu_state(self) -> State:
        self._call("fmi2GetFMUstate", byref(state := State()))
        return state

    @staticmethod
    def _fmu_state_to_bytes(state: State) -> bytes:
        KERNEL.fmi2SerializedFMUstateSize(FIRST, state, byref(size := c_size_t()))
        KERNEL.fmi2SerializeFMUstate(FIRST, state, data := ctypes.create_string_buffer(size.value), size)
        return data.raw

    @staticmethod
    # static, because pythonfmu calls it without an instance
    def _fmu_state_from_bytes(data: bytes) -> State:
        if KERNEL.fmi2DeSerializeFMUstate(FIRST, data, c_size_t(len(data)), byref(state := State())):
            raise SlaveError(*(one for one in gc.get_objects() if isinstance(one, ChainImpact)))
        return state
