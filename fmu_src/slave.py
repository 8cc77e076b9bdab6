"""The slave: what pythonfmu's wrapper calls in the importing process, with the compiled kernel behind it.

One file that needs nothing but Python's standard library, 3.8 or later, and knows names and status but no
physics. The instance of the simulation is one block of memory that the kernel works on, laid out by
chain_impact/kernel/record/; every variable is one 8-byte word of it. ``model.json`` says which word and
what may be set when, and a checksum of ``instance.bin``, the block with the start values.
chain_impact/fmu/build.py writes both.

Errors: to a pythonfmu slave only OK, Discard and, by raising, Fatal are open. Importers take Discard for a
step that was too long: fmpy ends without a word and returns the results up to there. So whatever goes wrong
raises a SlaveError, whose sentence goes to the importer's log and to Python's, which writes it to stderr.
"""

from __future__ import annotations

import atexit
import ctypes
import gc
import json
import logging
import math
import os
import struct
import sys
import zlib
from pathlib import Path
from typing import Any, ClassVar
from xml.etree import ElementTree

from pythonfmu import Fmi2Slave
from pythonfmu.enums import Fmi2Status

# bytes at the start of the block: numbers of links, candidates, elements, loads, channels, dual instances
SIZES = 48
PAUSED = -2  # of the kernel's functions: there is more to do, see chain_impact/kernel/status.py
INSTANTIATED, INITIALIZING, STEPPING, TERMINATED = range(4)
PHASES = ("before initialization", "in initialization mode", "after initialization", "after terminate")
SETTABLE_UNTIL = {"fixed": INITIALIZING, "tunable": STEPPING, "input": STEPPING, "output": -1}
# by how much the importer's clock may differ: a part of the step, and the round-off of adding steps up
TIME_TOLERANCE, ROUND_OFF = 1e-9, 1e-12
STATE = struct.Struct("<40sqqdd")  # guid, phase, initialized, time [s], stop time [s]; then the block
ENVELOPE = struct.Struct("<8sQQ")  # magic, length and CRC of a state; then the state
MAGIC = b"chainimp"


class SlaveError(Exception):
    """A call to one of the slaves that cannot be answered, in one sentence."""

    def __init__(self, text: str, *slaves: ChainImpact) -> None:
        super().__init__(text)
        # pythonfmu 0.7.0 drops its references at an exception and, when the importer frees the instance, once
        # more: with these the importer lives on, and so does the slave until then
        for slave in slaves:
            for kept in (slave, type(slave), slave.log_queue):
                ctypes.pythonapi.Py_IncRef(ctypes.py_object(kept))
        # fmpy's log is off by default: its user would learn no more than "status 4 (fatal)". Python writes
        # what is logged to stderr, unless the process does something else with it.
        logging.getLogger("chain_impact.fmu").error("%s: %s", ChainImpact.model["name"], text)

    def __repr__(self) -> str:
        # what the wrapper logs: a printf format in which, by FMI's rules, # begins the number of a variable
        return str(self).replace("%", "%%").replace("#", "##")


def _release(wrapper: Path) -> None:
    """Release the state of pythonfmu 0.7.0's library, which it does by itself when that is unloaded.

    At the end of a process it would do so twice, the second time in freed memory; what is released is not
    released again. Python ends before its libraries do.
    """
    try:
        library = ctypes.CDLL(str(wrapper), mode=os.RTLD_NOLOAD)
    except OSError:  # it has been unloaded
        return
    library.finalizePythonInterpreter()


class ChainImpact(Fmi2Slave):  # type: ignore[misc]
    """One instance of the FMU."""

    # common to all instances in a process: the name of this module holds a hash of the FMU's content
    model: ClassVar[dict[str, Any]] = {}
    start = b""
    kernel: ctypes.CDLL | None = None
    wrappers: ClassVar[set[Path]] = set()  # the libraries of pythonfmu that have made instances

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        cls, resources = type(self), Path(self.resources)
        if not cls.model:
            cls.model = json.loads((resources / "model.json").read_text(encoding="utf-8"))
            cls.start = (resources / "instance.bin").read_bytes()
        if zlib.crc32(cls.start) != cls.model["start_checksum"]:
            raise SlaveError("the FMU's file resources/instance.bin is damaged", self)
        wrapper = resources.parent / "binaries" / "linux64" / f"{cls.model['name']}.so"
        if sys.platform == "linux" and wrapper not in cls.wrappers:
            cls.wrappers.add(wrapper)
            atexit.register(_release, wrapper)
        self.modelName, self.guid, self.words = cls.model["name"], cls.model["guid"], cls.model["words"]
        # value reference → name, type, word, kind, low, high, allowed, second word to which a set value goes
        self.table = cls.model["variables"]
        self.real_words = {vr: row[2] for vr, row in enumerate(self.table) if row[1] == "real"}
        self.integer_words = {vr: row[2] for vr, row in enumerate(self.table) if row[1] == "integer"}
        # of outputs, and of what follows from a parameter
        self.worked_out = {
            vr
            for vr, (_, _, word, kind, *_, set_word) in enumerate(self.table)
            if kind == "output" or word != set_word
        }
        self.block = bytearray(cls.start)
        self.reals, self.integers = memoryview(self.block).cast("d"), memoryview(self.block).cast("q")
        self.address = ctypes.addressof(ctypes.c_char.from_buffer(self.block))
        self.phase, self.initialized, self.warned = INSTANTIATED, False, False
        # the reals with the outputs of the present time, None if neither block has them
        self.observed: Any = None
        self.time, self.stop_time = 0.0, math.inf

    def to_xml(self, model_options: Any = None) -> ElementTree.Element:  # noqa: ARG002
        """Return the complete modelDescription: pythonfmu's own has neither units, types nor unknowns.

        chain_impact/fmu/model_description.py has written it, options included.
        """
        return ElementTree.parse(Path(self.resources, "description.xml")).getroot()

    # --- the life of an instance; reset makes a new one ---

    def setup_experiment(
        self, start_time: float, stop_time: float | None = None, tolerance: float | None = None
    ) -> None:
        """Take the start and stop time [s]; the tolerance that counts is the parameter solver.tolerance."""
        self._require(INSTANTIATED, "fmi2SetupExperiment")
        if not math.isfinite(start_time) or (stop_time is not None and not stop_time >= start_time):
            raise SlaveError(f"fmi2SetupExperiment: start time {start_time} s, stop time {stop_time} s", self)
        if tolerance not in (None, self.reals[self.words["tolerance"]]):
            self.log(f"the importer's tolerance {tolerance} is not used: set the parameter solver.tolerance")
        self.time, self.stop_time = start_time, math.inf if stop_time is None else stop_time
        self.initialized = False

    def enter_initialization_mode(self) -> None:
        """Let outputs be read, and go on taking parameters."""
        self._require(INSTANTIATED, "fmi2EnterInitializationMode")
        self.phase = INITIALIZING

    def exit_initialization_mode(self) -> None:
        """Start from the parameters and initial values that are set now."""
        self._require(INITIALIZING, "fmi2ExitInitializationMode")
        self._initialize()
        self.phase = STEPPING

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Advance from the present communication point by a step, both in s."""
        self._require(STEPPING, "fmi2DoStep")
        if not 0.0 < step_size < math.inf:
            raise SlaveError(f"fmi2DoStep: the step size {step_size} s is not > 0", self)
        slack = TIME_TOLERANCE * step_size + ROUND_OFF * abs(self.time)
        if not abs(current_time - self.time) <= slack:
            raise SlaveError(
                f"fmi2DoStep: the time {current_time!r} s is not the present {self.time!r} s", self
            )
        time = max(self.time, current_time + step_size)
        if time > self.stop_time + slack:
            raise SlaveError(f"fmi2DoStep: {time!r} s lies beyond the stop time {self.stop_time!r} s", self)
        self.observed = None
        status = PAUSED
        while status == PAUSED:  # in between, Python looks after signals, such as that of Ctrl-C
            status = self._kernel().advance_awhile(self.address, time)
        if status:
            reached = self.reals[self.words["time"]]
            text = f"the simulation stopped at t = {reached:.9g} s: {self._text(status, self.reals)}"
            raise SlaveError(text, self)
        self.time = time
        self._warn()
        return True

    def _warn(self) -> None:
        """Say once whose positions and velocities contradict each other, if any do."""
        word = self.words.get("contradiction")
        if word is None or self.warned or not (channel := self.integers[word]):
            return
        position = self.words["position"] + channel - 1
        name = next((row[0] for row in self.table if row[3] == "input" and row[2] == position), "a motion")
        distance, lasted, velocity = self.reals[word + 1 : word + 4]
        self.warned = True
        text = f"{name} has been moved by {distance:.9g} m in {lasted:.9g} s, which contradicts its velocity "
        self.log(f"{text}of {velocity:.9g} m/s: give both", Fmi2Status.warning)

    def terminate(self) -> None:
        """Take no more steps; outputs can still be read."""
        self.phase = TERMINATED

    # --- variables ---

    def get_real(self, vrs: list[int]) -> list[float]:
        """Return reals; the kernel works outputs out when they are first read after a change."""
        seen, words = self.reals, self.real_words
        if not self.worked_out.isdisjoint(vrs):
            seen = self.observed or self._observe()
        try:
            return [seen[words[vr]] for vr in vrs]
        except KeyError as error:
            raise SlaveError(f"fmi2GetReal: the value reference {error} is no Real's", self) from None

    def get_integer(self, vrs: list[int]) -> list[int]:
        """Return integers and enumerations; outputs, which come last, are worked out as reals are."""
        integers, words = self.integers, self.integer_words
        if max(vrs, default=0) >= self.model["first_output"]:
            integers = (self.observed or self._observe()).cast("B").cast("q")
        try:
            return [integers[words[vr]] for vr in vrs]
        except KeyError as error:
            raise SlaveError(f"fmi2GetInteger: the value reference {error} is no Integer's", self) from None

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        """Set reals."""
        self._set("fmi2SetReal", self.real_words, self.reals, vrs, values)

    def set_integer(self, vrs: list[int], values: list[int]) -> None:
        """Set integers and enumerations."""
        self._set("fmi2SetInteger", self.integer_words, self.integers, vrs, values)

    def _no_variables(self, vrs: list[int], values: Any = None) -> list[Any]:  # noqa: ARG002
        if vrs:
            raise SlaveError("there are no variables of type Boolean or String", self)
        return []

    get_boolean = get_string = set_boolean = set_string = _no_variables

    def _set(self, call: str, words: dict[int, int], memory: Any, vrs: list[int], values: list[Any]) -> None:
        changed = False
        for vr, value in zip(vrs, values):  # noqa: B905, not in Python 3.8
            if vr not in words:
                raise SlaveError(f"{call}: the value reference {vr} is of another type or of nothing", self)
            name, _, word, kind, low, high, allowed, set_word = self.table[vr]
            if self.phase > SETTABLE_UNTIL[kind]:
                what = {"input": "an input", "output": "an output"}.get(kind, f"a {kind} parameter")
                raise SlaveError(f"{call}: {name} is {what} and cannot be set {PHASES[self.phase]}", self)
            if not low <= value <= high:  # false for NaN, too
                raise SlaveError(f"{call}: {name} = {value!r} must be {allowed}", self)
            if memory[set_word] != value:
                memory[word] = memory[set_word] = value
                changed = True
        if changed:
            self.observed = None
            if self.phase == STEPPING:
                self.integers[self.words["changed"]] = 1  # the solver starts anew from this point in time
            else:
                self.initialized = False

    # --- FMU state: the whole block and the slave's own few numbers ---

    def _get_fmu_state(self) -> bytes:
        return (
            STATE.pack(self.guid.encode(), self.phase, self.initialized, self.time, self.stop_time)
            + self.block
        )

    def _set_fmu_state(self, state: bytes) -> None:
        guid, phase, initialized, time, stop_time = STATE.unpack_from(state)
        if guid.rstrip(b"\0") != self.guid.encode() or len(state) != STATE.size + len(self.block):
            raise SlaveError("fmi2SetFMUstate: the state is that of another FMU", self)
        block = bytearray(state[STATE.size :])
        address = ctypes.addressof(ctypes.c_char.from_buffer(block))
        if block[:SIZES] != self.block[:SIZES] or not self._kernel().sound(address):
            raise SlaveError("fmi2SetFMUstate: the state is damaged", self)
        self.block[:] = block
        self.phase, self.initialized, self.observed = phase, bool(initialized), None
        self.time, self.stop_time = time, stop_time

    @staticmethod
    def _fmu_state_to_bytes(state: bytes) -> bytes:
        return ENVELOPE.pack(MAGIC, len(state), zlib.crc32(state)) + state

    @staticmethod
    def _fmu_state_from_bytes(data: bytes) -> bytes:
        envelope, state = data[: ENVELOPE.size], data[ENVELOPE.size :]
        if len(state) < STATE.size or envelope != ENVELOPE.pack(MAGIC, len(state), zlib.crc32(state)):
            # this function is not told which instance was called
            slaves = [slave for slave in gc.get_objects() if isinstance(slave, ChainImpact)]
            raise SlaveError("fmi2DeSerializeFMUstate: the bytes are no state, or damaged", *slaves)
        return state

    # --- inside ---

    def _require(self, phase: int, call: str) -> None:
        if self.phase != phase:
            raise SlaveError(f"{call} cannot be called {PHASES[self.phase]}", self)

    def _kernel(self) -> ctypes.CDLL:
        cls = type(self)
        if cls.kernel is None:
            name = "kernel-win64.dll" if sys.platform == "win32" else "kernel-linux64.so"
            cls.kernel = ctypes.CDLL(str(Path(self.resources, name)))
            cls.kernel.initialize.argtypes = [ctypes.c_void_p, ctypes.c_double]
            cls.kernel.advance_awhile.argtypes = [ctypes.c_void_p, ctypes.c_double]
            cls.kernel.observe.argtypes = cls.kernel.sound.argtypes = [ctypes.c_void_p]
        return cls.kernel

    def _initialize(self) -> None:
        """Work the start out from the parameters, unless that is done and none has changed since."""
        if not self.initialized:
            before = bytes(self.block)
            status = self._kernel().initialize(self.address, self.time)
            if status:
                text = self._text(status, self.reals)
                self.block[:] = before
                raise SlaveError(f"the simulation cannot start: {text}", self)
            self.initialized, self.observed = True, None

    def _observe(self) -> Any:
        """Return the reals with the outputs of the present time.

        What has been set since the last step is tried in a copy, as the run does not depend on what is read.
        If the kernel cannot go on with it, the outputs are those before it: other values may still be set.
        """
        self._initialize()
        reals, address, tried = self.reals, self.address, self.integers[self.words["changed"]]
        if tried:
            block = bytearray(self.block)
            reals, address = memoryview(block).cast("d"), ctypes.addressof(ctypes.c_char.from_buffer(block))
        status = self._kernel().observe(address)
        if status and tried and self.phase == STEPPING:
            text = f"fmi2GetReal: what has been set cannot act: {self._text(status, reals)}"
            self.log(text, Fmi2Status.warning)
        elif not status:
            self.observed = reals
        return reals

    def _text(self, status: int, reals: Any) -> str:
        """The sentence of a status, with the place of its reason, if that is known."""
        place = reals.cast("B").cast("q")[self.words["place"]]  # from 1
        text = self.model["statuses"].get(str(status), "unknown status")  # of a damaged state
        return f"{text}: {self.model['places'][place - 1]}" if place else str(text)
