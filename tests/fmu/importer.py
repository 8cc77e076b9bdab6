"""An importer as users have: fmpy, with variables by names. This module does not need the package."""

from __future__ import annotations

import shutil
from collections.abc import Iterable
from ctypes import byref
from typing import Any

import fmpy
from fmpy.fmi1 import FMICallException, calloc, free
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
)
from fmpy.logging import addLoggerProxy

MESSAGES: list[str] = []
REALS = ("Real", "Float64")


def _log(_environment: Any, _name: bytes, _status: int, _category: bytes, message: bytes) -> None:
    MESSAGES.append(message.decode())


# one callback object for all instances, because fmpy's message formatter calls the latest logger
CALLBACKS = fmi2CallbackFunctions()
CALLBACKS.logger = fmi2CallbackLoggerTYPE(_log)
CALLBACKS.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
CALLBACKS.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
addLoggerProxy(byref(CALLBACKS))


class Instance:
    """One instance of an FMU; ``fmu`` is fmpy's own object, ``time`` the communication point [s]."""

    def __init__(self, path: str, name: str = "instance", folder: str | None = None) -> None:
        """Unzip the FMU unless another instance's folder is given, and instantiate with logging on."""
        description = fmpy.read_model_description(path)
        # the scalar variables of FMI 3.0, which are equal to the variables of FMI 2.0
        self.variables = {v.name: v for v in description.modelVariables if not v.dimensions}
        self.outputs = [name for name, v in self.variables.items() if v.causality == "output"]
        self.folder = folder or fmpy.extract(path)
        arguments = {
            "guid": description.guid,
            "unzipDirectory": self.folder,
            "modelIdentifier": description.coSimulation.modelIdentifier,
            "instanceName": name,
        }
        if description.fmiVersion == "3.0":
            from as_fmi2 import slave

            self.fmu = slave(MESSAGES.append, **arguments)
        else:
            self.fmu = FMU2Slave(**arguments)
        self.fmu.instantiate(callbacks=CALLBACKS, loggingOn=True)
        self.time = 0.0

    def start(self, start_time: float = 0.0, stop_time: float | None = None, **values: float) -> Instance:
        """Set up, set variables, initialize, and return the instance."""
        self.fmu.setupExperiment(startTime=start_time, stopTime=stop_time)
        self.set(values)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        self.time = start_time
        return self

    def get(self, names: Iterable[str]) -> list[Any]:
        """Return the values of some variables, with one call for each type."""
        variables_to_read, values = [self.variables[name] for name in names], {}
        for get, of_type in ((self.fmu.getReal, True), (self.fmu.getInteger, False)):
            if references := [v.valueReference for v in variables_to_read if (v.type in REALS) == of_type]:
                values |= {
                    (of_type, vr): value for vr, value in zip(references, get(references), strict=True)
                }
        return [values[v.type in REALS, v.valueReference] for v in variables_to_read]

    def __getitem__(self, name: str) -> Any:
        """Return the value of a variable."""
        variable = self.variables[name]
        get = self.fmu.getReal if variable.type in REALS else self.fmu.getInteger
        return get([variable.valueReference])[0]

    def set(self, values: dict[str, float]) -> None:
        """Set variables."""
        for name, value in values.items():
            variable = self.variables[name]
            put = self.fmu.setReal if variable.type in REALS else self.fmu.setInteger
            put([variable.valueReference], [value])

    def step(self, time: float) -> None:
        """Advance to a time [s]."""
        self.fmu.doStep(currentCommunicationPoint=self.time, communicationStepSize=time - self.time)
        self.time = time

    def run(self, times: Iterable[float], names: Iterable[str] | None = None) -> list[list[Any]]:
        """Advance to each time [s] that is still ahead, and return a row of outputs for each time."""
        chosen_names, rows = list(self.outputs if names is None else names), []
        for time in times:
            if time > self.time:
                self.step(time)
            rows.append(self.get(chosen_names))
        return rows

    def close(self) -> None:
        """Free the instance and delete its unpacked folder."""
        self.fmu.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)


def refused(path: str, *calls: Any) -> str:
    """Return the log messages of the last call of an instance, one a line; "" if the call succeeds."""
    instance = Instance(path)
    try:
        for call in calls[:-1]:
            call(instance)
        MESSAGES.clear()
        try:
            calls[-1](instance)
        except FMICallException:
            return "\n".join(MESSAGES)
        return ""
    finally:
        instance.close()
