"""The C functions of an FMU, called through ctypes as a tool in C does, without fmpy."""

from __future__ import annotations

import ctypes
import math  # noqa: F401, as struct and zlib, for the functions of tests
import struct  # noqa: F401
import tempfile
import zipfile
import zlib  # noqa: F401
from collections.abc import Callable, Iterable, Mapping
from ctypes import CFUNCTYPE, byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

OK, WARNING, DISCARD, ERROR, FATAL = range(5)
MODEL_EXCHANGE, CO_SIMULATION = range(2)
DO_STEP_STATUS, PENDING_STATUS, LAST_SUCCESSFUL_TIME, TERMINATED_STATUS = range(4)
MOST_MEMORY = 1 << 32  # bytes in a block
PHASES = ("instantiated", "initialization mode", "step complete", "step failed", "terminated")

Logger = CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p)
Allocate = CFUNCTYPE(c_void_p, c_size_t, c_size_t)
FreeMemory = CFUNCTYPE(None, c_void_p)
Finished = CFUNCTYPE(None, c_void_p, c_int)


class Callbacks(ctypes.Structure):
    """The structure fmi2CallbackFunctions."""

    _fields_ = (
        ("logger", Logger),
        ("allocate", Allocate),
        ("free", FreeMemory),
        ("finished", Finished),
        ("environment", c_void_p),
    )


def description(fmu: str) -> ElementTree.Element:
    """Return the model description."""
    with zipfile.ZipFile(fmu) as archive:
        return ElementTree.fromstring(archive.read("modelDescription.xml"))


def unpacked(fmu: str, folder: str | None = None) -> Path:
    """Return the folder of an unzipped FMU."""
    place = Path(folder or tempfile.mkdtemp())
    with zipfile.ZipFile(fmu) as archive:
        archive.extractall(place)
    return place


class Binary:
    """The binary of an FMU, its model description, and its log messages, whose last item is the text."""

    def __init__(self, fmu: str, folder: str | None = None, mode: int = ctypes.RTLD_LOCAL) -> None:
        """Unzip the FMU and load its binary."""
        self.messages: list[tuple[Any, ...]] = []
        self.folder = unpacked(fmu, folder)
        root = ElementTree.parse(self.folder / "modelDescription.xml").getroot()
        self.fmi3 = root.get("fmiVersion") == "3.0"
        self.guid = root.get("instantiationToken" if self.fmi3 else "guid").encode()
        self.categories = [category.get("name") for category in root.iter("Category")]
        self.nodes = list(root.find("ModelVariables"))
        self.references = {node.get("name"): int(node.get("valueReference")) for node in self.nodes}
        platform = "x86_64-linux" if self.fmi3 else "linux64"
        binary = self.folder / "binaries" / platform / f"{root.get('modelName')}.so"
        self.c: Any = ctypes.CDLL(str(binary), mode)
        # pythonfmu's wrapper reports every error as fatal
        self.refusal = FATAL if (self.folder / "resources" / "slavemodule.txt").exists() else ERROR

    def new_messages(self) -> list[str]:
        """Return the log texts since the last call of this function."""
        texts = [text for *_, text in self.messages]
        self.messages.clear()
        return texts


class Library(Binary):
    """An FMU with the functions of FMI 2.0, and callbacks that count memory blocks."""

    def __init__(self, fmu: str, folder: str | None = None, mode: int = ctypes.RTLD_LOCAL) -> None:
        """Unzip the FMU and load its binary."""
        super().__init__(fmu, folder, mode)  # messages: instance, status, category, text
        self.unfinished = ERROR if self.fmi3 else DISCARD  # status of an unfinished step
        outputs = [node for node in self.nodes if node.get("causality") == "output"]
        if self.fmi3:  # the scalar variables, which are equal to those of FMI 2.0
            from as_fmi2 import Functions

            self.reals = [n.get("name") for n in outputs if n.tag == "Float64" and len(n) == 0]
            self.c = Functions(self.c, self._log)
        else:
            self.reals = [n.get("name") for n in outputs if n[0].tag == "Real"]
            self.c.fmi2Instantiate.restype = c_void_p
            self.c.fmi2GetVersion.restype = self.c.fmi2GetTypesPlatform.restype = c_char_p
        self.blocks: dict[int, Any] = {}
        self.left = -1  # number of memory blocks that can still be allocated; unlimited if negative
        self.callbacks = Callbacks(Logger(self._log), Allocate(self._allocate), FreeMemory(self._free))

    @property
    def location(self) -> bytes:
        """The URI of the resources."""
        return (self.folder / "resources").as_uri().encode()

    def _log(self, _environment: Any, name: bytes, status: int, category: bytes, text: bytes) -> None:
        # pythonfmu's wrapper has no category for refusals
        self.messages.append((name.decode(), status, (category or b"").decode(), text.decode()))

    def _allocate(self, count: int, size: int) -> int | None:
        if self.left == 0 or count * size > MOST_MEMORY:
            return None
        self.left -= 1
        block = ctypes.create_string_buffer(count * size)
        self.blocks[ctypes.addressof(block)] = block
        return ctypes.addressof(block)

    def _free(self, address: int | None) -> None:
        if address is not None:
            del self.blocks[address]  # raises an error for a block that was not allocated here

    def instantiate(self, **changes: Any) -> int | None:
        """Call fmi2Instantiate; arguments can replace the usual ones."""
        defaults = {
            "name": b"one",
            "type": CO_SIMULATION,
            "guid": self.guid,
            "location": self.location,
            "callbacks": byref(self.callbacks),
            "visible": 0,
            "logging": 1,
        }
        values = list({**defaults, **changes}.values())
        return self.c.fmi2Instantiate(*values)


class States(NamedTuple):
    """Names of the functions that get, set, free and serialize states."""

    get: str
    set: str
    free: str
    size: str
    serialize: str
    deserialize: str

    @classmethod
    def of(cls, state: str, deserialize: str, prefix: str = "") -> States:
        """Return the names of the functions of a version of the standard."""
        verbs = ("Get{}", "Set{}", "Free{}", "Serialized{}Size", "Serialize{}", f"{deserialize}{{}}")
        return cls(*(prefix + verb.format(state) for verb in verbs))


class Instance:
    """An instance under either standard, whose subclasses define how its functions are called."""

    STATES: States

    def __init__(self, library: Any, **changes: Any) -> None:
        """Create the instance."""
        self.library = library
        self.address = c_void_p(library.instantiate(**changes))
        assert self.address.value, library.new_messages()

    def call(self, name: str, *arguments: Any) -> int:
        """Call a function of the standard."""
        raise NotImplementedError

    def state(self) -> c_void_p:
        """Return the present state, which the caller frees."""
        state = c_void_p()
        assert self.call(self.STATES.get, byref(state)) == OK
        return state

    def serialized(self) -> bytes:
        """Return the present state as bytes."""
        state, size = self.state(), c_size_t()
        assert self.call(self.STATES.size, state, byref(size)) == OK
        data = ctypes.create_string_buffer(size.value)
        assert self.call(self.STATES.serialize, state, data, size) == OK
        assert self.call(self.STATES.free, byref(state)) == OK
        return data.raw

    def restore(self, data: bytes) -> int:
        """Restore a state from bytes; return the status."""
        state = c_void_p()
        status = self.call(self.STATES.deserialize, data, c_size_t(len(data)), byref(state))
        if status == OK:
            status = self.call(self.STATES.set, state)
            assert self.call(self.STATES.free, byref(state)) == OK
        return status


def each_call(
    library: Any,
    make_instance: Callable[[Any], Any],
    calls: Mapping[str, Callable[[Any], int]],
    phases: Iterable[str],
) -> list[list[Any]]:
    """Call each function in each phase, on a new instance each time.

    Return rows: phase, function, its status, its messages, and whether it left the state unchanged.
    """
    rows = []
    for phase in phases:
        for name, call in calls.items():
            instance = make_instance(library).bring_to(phase)
            state = instance.serialized()
            library.new_messages()
            status = call(instance)
            messages = library.new_messages()
            rows.append([phase, name, status, messages, state == instance.serialized()])
            instance.free()
    return rows


def state_calls(names: States) -> dict[str, Callable[[Any], int]]:
    """Return the functions for states, with valid arguments for the phases that permit these calls."""
    size = c_size_t()

    def with_state(function: Callable[[Any, c_void_p], int]) -> Callable[[Any], int]:
        def call(instance: Any) -> int:
            state = instance.state()
            try:
                return function(instance, state)
            finally:
                instance.call(names.free, byref(state))

        return call

    def serialize(instance: Any, state: c_void_p) -> int:
        instance.call(names.size, state, byref(size))
        return instance.call(names.serialize, state, ctypes.create_string_buffer(size.value), size)

    return {
        names.get: with_state(lambda *_: OK),
        names.set: with_state(lambda instance, state: instance.call(names.set, state)),
        names.free: lambda instance: instance.call(names.free, byref(c_void_p())),
        names.size: with_state(lambda instance, state: instance.call(names.size, state, byref(size))),
        names.serialize: with_state(serialize),
        names.deserialize: lambda instance: instance.restore(instance.serialized()),
    }


class Component(Instance):
    """An instance of FMI 2.0; functions of the standard return the status, those that read also the value."""

    STATES = States.of("FMUstate", "DeSerialize", "fmi2")

    def call(self, name: str, *arguments: Any) -> int:
        """Call a function of the standard."""
        return getattr(self.library.c, name)(self.address, *arguments)

    def setup(self, start: float = 0.0, stop: float | None = None) -> int:
        """Call fmi2SetupExperiment."""
        rest = (c_double(start), int(stop is not None), c_double(stop or 0.0))
        return self.call("fmi2SetupExperiment", 0, c_double(0.0), *rest)

    def start(self, start: float = 0.0, stop: float | None = None, **values: float) -> Component:
        """Set up a new instance, set values and initialize, so that the first step can follow."""
        assert self.setup(start, stop) == OK
        for name, value in values.items():
            assert self.set_real(name, value) == OK
        assert self.call("fmi2EnterInitializationMode") == OK
        assert self.call("fmi2ExitInitializationMode") == OK
        return self

    def bring_to(self, phase: str) -> Component:
        """Bring a new instance to a phase of its life cycle."""
        assert self.setup() == OK
        if phase == "step failed":
            assert self.set_real("solver.work_limit", 20.0) == OK
        if phase != "instantiated":
            assert self.call("fmi2EnterInitializationMode") == OK
        if phase not in ("instantiated", "initialization mode"):
            assert self.call("fmi2ExitInitializationMode") == OK
            assert self.step(0.0, 1.0) == (self.library.unfinished if phase == "step failed" else OK)
        if phase == "terminated":
            assert self.call("fmi2Terminate") == OK
        self.library.new_messages()
        return self

    def step(self, time: float, size: float) -> int:
        """Call fmi2DoStep."""
        return self.call("fmi2DoStep", c_double(time), c_double(size), 1)

    def set_real(self, name: str, value: float) -> int:
        """Call fmi2SetReal for one variable."""
        reference, cell = c_uint(self.library.references[name]), c_double(value)
        return self.call("fmi2SetReal", byref(reference), c_size_t(1), byref(cell))

    def set_integer(self, name: str, value: int) -> int:
        """Call fmi2SetInteger for one variable."""
        reference, cell = c_uint(self.library.references[name]), c_int(value)
        return self.call("fmi2SetInteger", byref(reference), c_size_t(1), byref(cell))

    def real(self, name: str) -> float:
        """Return the value of a Real."""
        reference, cell = c_uint(self.library.references[name]), c_double(-99.0)
        assert self.call("fmi2GetReal", byref(reference), c_size_t(1), byref(cell)) == OK, (
            self.library.new_messages()
        )
        return cell.value

    def integer(self, name: str) -> int:
        """Return the value of an Integer."""
        reference, cell = c_uint(self.library.references[name]), c_int(-99)
        assert self.call("fmi2GetInteger", byref(reference), c_size_t(1), byref(cell)) == OK
        return cell.value

    def outputs(self) -> list[float]:
        """Return all Real outputs with one call."""
        names = self.library.reals
        references = (c_uint * len(names))(*(self.library.references[name] for name in names))
        values = (c_double * len(names))()
        assert self.call("fmi2GetReal", references, c_size_t(len(names)), values) == OK
        return list(values)

    def free(self) -> None:
        """Call fmi2FreeInstance."""
        self.library.c.fmi2FreeInstance(self.address)


def calls() -> dict[str, Callable[[Component], int]]:
    """Return each function of an instance with valid arguments."""
    cell, integer, text = c_double(), c_int(), c_char_p()
    reference, nil = c_uint(), c_size_t(0)

    def variable(function: str, name: str, value: Any) -> Callable[[Component], int]:
        def call(instance: Component) -> int:
            reference.value = instance.library.references[name]
            return instance.call(function, byref(reference), c_size_t(1), byref(value))

        return call

    def nothing(function: str, *rest: Any) -> Callable[[Component], int]:
        return lambda instance: instance.call(function, None, c_size_t(0), *rest)

    def status(function: str, kind: int, place: Any) -> Callable[[Component], int]:
        return lambda instance: instance.call(function, kind, byref(place))

    return {
        "fmi2SetDebugLogging": lambda instance: instance.call("fmi2SetDebugLogging", 1, c_size_t(0), None),
        "fmi2SetupExperiment": lambda instance: instance.setup(),
        "fmi2EnterInitializationMode": lambda instance: instance.call("fmi2EnterInitializationMode"),
        "fmi2ExitInitializationMode": lambda instance: instance.call("fmi2ExitInitializationMode"),
        "fmi2Terminate": lambda instance: instance.call("fmi2Terminate"),
        "fmi2Reset": lambda instance: instance.call("fmi2Reset"),
        "fmi2GetReal": variable("fmi2GetReal", "point[0].y", cell),
        "fmi2GetInteger": variable("fmi2GetInteger", "impact.count", integer),
        "fmi2GetBoolean": nothing("fmi2GetBoolean", None),
        "fmi2GetString": nothing("fmi2GetString", None),
        "fmi2SetReal": variable("fmi2SetReal", "contact.stiffness", c_double(1e7)),
        "fmi2SetInteger": variable("fmi2SetInteger", "contact.model", c_int(1)),
        "fmi2SetBoolean": nothing("fmi2SetBoolean", None),
        "fmi2SetString": nothing("fmi2SetString", None),
        **state_calls(Component.STATES),
        "fmi2GetDirectionalDerivative": nothing("fmi2GetDirectionalDerivative", None, nil, None, None),
        "fmi2SetRealInputDerivatives": nothing("fmi2SetRealInputDerivatives", None, None),
        "fmi2GetRealOutputDerivatives": nothing("fmi2GetRealOutputDerivatives", None, None),
        "fmi2DoStep": lambda instance: instance.step(1.0, 0.1),
        "fmi2CancelStep": lambda instance: instance.call("fmi2CancelStep"),
        "fmi2GetStatus": status("fmi2GetStatus", DO_STEP_STATUS, integer),
        "fmi2GetRealStatus": status("fmi2GetRealStatus", LAST_SUCCESSFUL_TIME, cell),
        "fmi2GetIntegerStatus": status("fmi2GetIntegerStatus", DO_STEP_STATUS, integer),
        "fmi2GetBooleanStatus": status("fmi2GetBooleanStatus", TERMINATED_STATUS, integer),
        "fmi2GetStringStatus": status("fmi2GetStringStatus", PENDING_STATUS, text),
    }


ALWAYS = set(PHASES)
KINDS = ("", "Real", "Integer", "Boolean", "String")
STATES = ("Get", "Set", "Free", "DeSerialize", "Serialize")
ALLOWED_PHASES = {
    **{f"fmi2{verb}FMUstate": ALWAYS for verb in STATES},
    "fmi2SerializedFMUstateSize": ALWAYS,
    "fmi2SetDebugLogging": ALWAYS,
    "fmi2Reset": ALWAYS,
    "fmi2SetupExperiment": {"instantiated"},
    "fmi2EnterInitializationMode": {"instantiated"},
    "fmi2ExitInitializationMode": {"initialization mode"},
    "fmi2Terminate": {"step complete", "step failed"},
    "fmi2GetReal": ALWAYS - {"instantiated"},
    "fmi2GetInteger": ALWAYS - {"instantiated"},
    "fmi2SetReal": {"instantiated", "initialization mode", "step complete"},
    "fmi2SetInteger": {"instantiated", "initialization mode", "step complete"},
    "fmi2DoStep": {"step complete"},
    "fmi2CancelStep": set(),
    **{f"fmi2Get{kind}Status": {"step complete", "step failed", "terminated"} for kind in KINDS},
}
"""Function → phases in which the standard allows a call (section 4.2.4), without steps in progress.

All phases allow the other functions, which the tests call for no variables.
"""
LIMITS = {
    "fmi2GetStatus": {"step complete", "terminated"},
    **{f"fmi2Get{kind}Status": {"instantiated", "initialization mode"} for kind in KINDS[1:]},
    "fmi2GetDirectionalDerivative": ALWAYS,
    "fmi2SetRealInputDerivatives": ALWAYS,
    "fmi2GetRealOutputDerivatives": ALWAYS,
}
"""Function → phases in which pythonfmu's wrapper accepts a forbidden call, or refuses one for no variables.

docs/fmi.md lists these calls.
"""
