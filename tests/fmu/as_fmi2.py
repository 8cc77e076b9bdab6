"""An FMU for FMI 3.0 behind the functions of FMI 2.0, so that tests for FMI 2.0 run on both versions.

interface.py uses the C functions, importer.py fmpy's object. Names in messages are translated, too.
test_fmi3.py tests the features that only FMI 3.0 has.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from ctypes import CFUNCTYPE, c_bool, c_char_p, c_double, c_int, c_int64, c_size_t, c_void_p
from typing import Any
from urllib.parse import unquote, urlparse

RENAMED = {
    "GetReal": "GetFloat64",
    "SetReal": "SetFloat64",
    "GetInteger": "GetInt64",
    "SetInteger": "SetInt64",
    "DeSerializeFMUstate": "DeserializeFMUState",
}
LogMessage = CFUNCTYPE(None, c_void_p, c_int, c_char_p, c_char_p)


def renamed(name: str) -> str:
    """Return the name in FMI 3.0 of a function of FMI 2.0."""
    name = name.removeprefix("fmi2")
    return "fmi3" + RENAMED.get(name, name.replace("FMUstate", "FMUState"))


def given_back(text: str) -> str:
    """Return a message of FMI 3.0 with the terms of FMI 2.0."""
    words = {f"fmi2{name}:": f"fmi3{fmi3_word}:" for name, fmi3_word in RENAMED.items()}
    words |= {"fmi2SetupExperiment: start": "fmi3EnterInitializationMode: start"}
    words |= {"Real's": "Float64's", "Integer's": "Int64's", "FMUstate": "FMUState", "fmi2": "fmi3"}
    for fmi2_word, fmi3_word in words.items():
        text = text.replace(fmi3_word, fmi2_word)
    return text


class Functions:
    """The functions of a loaded library. ``log`` is called with the arguments of FMI 2.0."""

    def __init__(self, library: ctypes.CDLL, log: Callable[..., None]) -> None:
        self.library, self.log = library, log
        self.callbacks: dict[int | None, Any] = {}  # callback of the instance at each address
        self.experiments: dict[int | None, tuple[Any, ...]] = {}
        library.fmi3InstantiateCoSimulation.restype = c_void_p
        library.fmi3GetVersion.restype = c_char_p

    def __getattr__(self, name: str) -> Any:
        return getattr(self.library, renamed(name))

    def fmi2Instantiate(self, name: Any, _type: int, guid: Any, location: bytes, *rest: Any) -> int | None:
        def log(_environment: Any, status: int, category: bytes, text: bytes) -> None:
            self.log(None, name, status, category, given_back(text.decode()).encode())

        callback = LogMessage(log)
        path = unquote(urlparse(location.decode()).path).encode() + b"/"
        logging, none = rest[-1], c_void_p()
        flags = (c_bool(False), c_bool(logging), c_bool(False), c_bool(False))
        instance = self.library.fmi3InstantiateCoSimulation(
            name, guid, path, *flags, none, c_size_t(0), none, callback, none
        )
        self.callbacks[instance] = callback
        return instance

    def fmi2SetDebugLogging(self, instance: c_void_p, on: int, count: c_size_t, names: Any) -> int:
        return self.library.fmi3SetDebugLogging(instance, c_bool(on), count, names)

    def fmi2SetupExperiment(self, instance: c_void_p, *arguments: Any) -> int:
        """Store the arguments, which FMI 3.0 takes at the entry of initialization mode."""
        with_tolerance, tolerance, start, with_stop, stop = arguments
        self.experiments[instance.value] = (c_bool(with_tolerance), tolerance, start, c_bool(with_stop), stop)
        return 0

    def fmi2EnterInitializationMode(self, instance: c_void_p) -> int:
        return self.library.fmi3EnterInitializationMode(instance, *self.experiments[instance.value])

    def fmi2GetReal(self, instance: c_void_p, vr: Any, count: c_size_t, values: Any) -> int:
        return self.library.fmi3GetFloat64(instance, vr, count, values, count)

    def fmi2SetReal(self, instance: c_void_p, vr: Any, count: c_size_t, values: Any) -> int:
        return self.library.fmi3SetFloat64(instance, vr, count, values, count)

    def fmi2GetInteger(self, instance: c_void_p, vr: Any, _count: c_size_t, value: Any) -> int:
        long = c_int64(value._obj.value)
        status = self.library.fmi3GetInt64(instance, vr, c_size_t(1), ctypes.byref(long), c_size_t(1))
        value._obj.value = long.value
        return status

    def fmi2SetInteger(self, instance: c_void_p, vr: Any, _count: c_size_t, value: Any) -> int:
        long = c_int64(value._obj.value)
        return self.library.fmi3SetInt64(instance, vr, c_size_t(1), ctypes.byref(long), c_size_t(1))

    def fmi2DoStep(self, instance: c_void_p, time: c_double, size: c_double, _flag: int) -> int:
        event_needed, ended, early, last_time = c_bool(), c_bool(), c_bool(), c_double()
        places = map(ctypes.byref, (event_needed, ended, early, last_time))
        status = self.library.fmi3DoStep(instance, time, size, c_bool(True), *places)
        if status == 0:
            assert [event_needed.value, ended.value, early.value] == [False] * 3
            slack = 1e-9 * size.value + 1e-12 * abs(time.value)
            assert abs(last_time.value - (time.value + size.value)) <= slack
        return status


def slave(log: Callable[[str], None], **arguments: Any) -> Any:
    """Return fmpy's object for an FMU of FMI 3.0 with the methods of FMI 2.0."""
    from fmpy.fmi3 import FMU3Slave

    class Slave(FMU3Slave):
        def instantiate(self, loggingOn: bool = False, **_: Any) -> None:
            self.experiment: dict[str, Any] = {}

            def log_message(_environment: Any, _status: int, _category: bytes, text: bytes) -> None:
                log(given_back(text.decode()))

            super().instantiate(loggingOn=loggingOn, logMessage=log_message)

        def setupExperiment(self, **experiment: Any) -> None:
            self.experiment = experiment

        def enterInitializationMode(self) -> None:
            super().enterInitializationMode(**self.experiment)

        @property
        def fmi2FreeInstance(self) -> Any:
            return self.fmi3FreeInstance

        getReal, setReal = FMU3Slave.getFloat64, FMU3Slave.setFloat64
        getInteger, setInteger = FMU3Slave.getInt64, FMU3Slave.setInt64
        getFMUstate, setFMUstate = FMU3Slave.getFMUState, FMU3Slave.setFMUState
        freeFMUstate, serializeFMUstate = FMU3Slave.freeFMUState, FMU3Slave.serializeFMUState
        deSerializeFMUstate = FMU3Slave.deserializeFMUState

    return Slave(**arguments)
