"""The C functions of an FMU for FMI 3.0, called through ctypes as a tool in C does, without fmpy."""

from __future__ import annotations

import math
from collections.abc import Callable
from ctypes import CFUNCTYPE, byref, c_bool, c_char_p, c_double, c_int, c_int64, c_size_t, c_uint32, c_void_p
from typing import Any

# imported by the module name that the clean process knows
from interface import ERROR, OK, Binary, Instance, States, each_call, state_calls  # noqa: F401, for test_fmi3.py

PHASES = ("instantiated", "initialization mode", "event mode", "step mode", "step failed", "terminated")
LogMessage = CFUNCTYPE(None, c_void_p, c_int, c_char_p, c_char_p)
INTEGERS = (f"{u}Int{n}" for u in ("", "U") for n in (8, 16, 32, 64))
TYPES = ("Float32", "Float64", *INTEGERS, "Boolean", "String")


class Library(Binary):
    """An FMU with the functions of FMI 3.0."""

    def __init__(self, fmu: str) -> None:
        """Unzip the FMU and load its binary."""
        super().__init__(fmu)  # messages: status, category, text
        self.shapes = {node.get("name"): [int(size.get("start")) for size in node] for node in self.nodes}
        for kind in ("CoSimulation", "ModelExchange", "ScheduledExecution"):
            getattr(self.c, f"fmi3Instantiate{kind}").restype = c_void_p
        self.c.fmi3GetVersion.restype = c_char_p
        self.log = LogMessage(self._log)

    def _log(self, _environment: Any, status: int, category: bytes, text: bytes) -> None:
        self.messages.append((status, category.decode(), text.decode()))

    def instantiate(self, **changes: Any) -> int | None:
        """Call fmi3InstantiateCoSimulation; arguments can replace the usual ones."""
        defaults = {
            "name": b"one",
            "token": self.guid,
            "resources": f"{self.folder / 'resources'}/".encode(),
            "visible": False,
            "logging": True,
            "event_mode": True,
            "early_return": True,
            "intermediate": None,
            "intermediates": c_size_t(0),
            "environment": None,
            "log": self.log,
            "update": None,
        }
        arguments = ({**defaults, **changes}).values()
        return self.c.fmi3InstantiateCoSimulation(
            *(c_bool(a) if isinstance(a, bool) else a for a in arguments)
        )


class Component(Instance):
    """An instance of FMI 3.0; each function returns the status, or its output values."""

    STATES = States.of("FMUState", "Deserialize")

    def call(self, name: str, *arguments: Any) -> int:
        """Call a function of the standard."""
        return getattr(self.library.c, f"fmi3{name}")(self.address, *arguments)

    def enter(self, start: float = 0.0, stop: float | None = None) -> int:
        """Call fmi3EnterInitializationMode."""
        times = (c_double(start), c_bool(stop is not None), c_double(stop or 0.0))
        return self.call("EnterInitializationMode", c_bool(False), c_double(0.0), *times)

    def start(self, **values: float) -> Component:
        """Set values and bring a new instance to step mode, through event mode if it uses event mode."""
        for name, value in values.items():
            assert self.set(name, value) == OK
        assert self.enter() == OK
        assert self.call("ExitInitializationMode") == OK
        if self.call("EnterEventMode") == ERROR:  # an instance with event mode is already in event mode
            self.library.new_messages()
            if self.update()[0] == OK:
                assert self.call("EnterStepMode") == OK
        self.library.new_messages()
        return self

    def bring_to(self, phase: str) -> Component:
        """Bring a new instance to a phase of its life cycle."""
        if phase == "instantiated":
            return self
        if phase == "step failed":
            assert self.set("solver.work_limit", 20.0) == OK
        assert self.enter() == OK
        if phase == "initialization mode":
            return self
        assert self.call("ExitInitializationMode") == OK
        if phase == "event mode":
            return self
        assert self.call("EnterStepMode") == OK
        if phase == "step failed":
            assert self.step(0.0, 1.0)[0] == ERROR
        if phase == "terminated":
            assert self.call("Terminate") == OK
        self.library.new_messages()
        return self

    def step(self, time: float, size: float) -> list[Any]:
        """Call fmi3DoStep.

        Return status, eventHandlingNeeded, terminateSimulation, earlyReturn and last time.
        """
        places = (c_bool(), c_bool(), c_bool(), c_double())
        status = self.call("DoStep", c_double(time), c_double(size), c_bool(True), *map(byref, places))
        return [status, *(place.value for place in places)]

    def update(self) -> list[Any]:
        """Call fmi3UpdateDiscreteStates; return the status and the six values."""
        places = (*(c_bool(True) for _ in range(5)), c_double(-1.0))
        return [self.call("UpdateDiscreteStates", *map(byref, places)), *(place.value for place in places)]

    def set(self, name: str, value: float) -> int:
        """Set a Float64 or, if the value is an int, an Int64."""
        kind, cell = ("Int64", c_int64(value)) if isinstance(value, int) else ("Float64", c_double(value))
        reference = c_uint32(self.library.references[name])
        return self.call(f"Set{kind}", byref(reference), c_size_t(1), byref(cell), c_size_t(1))

    def get(self, *names: str, kind: str = "Float64", length: int | None = None) -> Any:
        """Return the values of variables, arrays included, as one list; the status of a refused call."""
        references = (c_uint32 * len(names))(*(self.library.references[name] for name in names))
        if length is None:
            length = sum(math.prod(self.library.shapes[name]) for name in names)
        values = ((c_double if kind == "Float64" else c_int64) * max(length, 1))()
        status = self.call(f"Get{kind}", references, c_size_t(len(names)), values, c_size_t(length))
        return list(values)[:length] if status == OK else status

    def free(self) -> None:
        """Call fmi3FreeInstance."""
        self.library.c.fmi3FreeInstance(self.address)


def calls() -> dict[str, Callable[[Component], int]]:
    """Return each function of an instance with valid arguments for the phases that permit the call."""
    none = c_size_t(0)

    def plain(name: str, *arguments: Any) -> Callable[[Component], int]:
        return lambda instance: instance.call(name, *arguments)

    def value(instance: Component, name: str, kind: str) -> int:
        result = instance.get(name, kind=kind)
        return OK if isinstance(result, list) else result

    functions: dict[str, Callable[[Component], int]] = {
        "SetDebugLogging": plain("SetDebugLogging", c_bool(True), none, None),
        "EnterInitializationMode": lambda instance: instance.enter(),
        "EnterEventMode": plain("EnterEventMode"),
        "EnterStepMode": plain("EnterStepMode"),
        "UpdateDiscreteStates": lambda instance: instance.update()[0],
        "DoStep": lambda instance: instance.step(0.0, 0.1)[0],
        **state_calls(Component.STATES),
    }
    for name in ("ExitInitializationMode", "Terminate", "Reset"):
        functions[name] = plain(name)
    for kind in (*TYPES, "Binary", "Clock"):
        for verb in ("Get", "Set"):
            functions[f"{verb}{kind}"] = plain(f"{verb}{kind}", None, none, None, none, none)
    functions["GetFloat64"] = lambda instance: value(instance, "point[0].y", "Float64")
    functions["GetInt64"] = lambda instance: value(instance, "impact.count", "Int64")
    functions["SetFloat64"] = lambda instance: instance.set("contact.stiffness", 1e7)
    functions["SetInt64"] = lambda instance: instance.set("contact.model", 1)
    for name in ("GetInterval", "SetInterval", "GetShift", "SetShift"):
        for form in ("Decimal", "Fraction"):
            functions[f"{name}{form}"] = plain(f"{name}{form}", None, none, None, None, None)
    functions["GetOutputDerivatives"] = plain("GetOutputDerivatives", None, none, None, None, none)
    for name in ("GetDirectionalDerivative", "GetAdjointDerivative"):
        functions[name] = plain(name, None, none, None, none, None, none, None, none)
    for name in NEVER:
        functions[name] = plain(name, *([None] * 6))
    return functions


NEVER = (
    *("EvaluateDiscreteStates", "EnterConfigurationMode", "ExitConfigurationMode"),
    *("GetNumberOfVariableDependencies", "GetVariableDependencies", "EnterContinuousTimeMode"),
    *("CompletedIntegratorStep", "SetTime", "SetContinuousStates", "GetContinuousStateDerivatives"),
    *("GetEventIndicators", "GetContinuousStates", "GetNominalsOfContinuousStates"),
    *("GetNumberOfEventIndicators", "GetNumberOfContinuousStates", "ActivateModelPartition"),
)
"""Functions that this FMU does not support, according to its model description."""
ALWAYS = set(PHASES)
SETTING = ALWAYS - {"step failed", "terminated"}
ALLOWED_PHASES = {
    "EnterInitializationMode": {"instantiated"},
    "ExitInitializationMode": {"initialization mode"},
    "EnterEventMode": {"step mode"},
    "EnterStepMode": {"event mode"},
    "UpdateDiscreteStates": {"event mode"},
    "DoStep": {"step mode"},
    "Terminate": {"event mode", "step mode", "step failed"},
    "GetFloat64": ALWAYS - {"instantiated"},
    "GetInt64": ALWAYS - {"instantiated"},
    "SetFloat64": SETTING,
    "SetInt64": SETTING,
    **{name: set() for name in NEVER},
}
"""Function → phases in which the standard allows a call.

All phases allow the other functions; the tests call those for types that no variable has, for no variables.
"""
