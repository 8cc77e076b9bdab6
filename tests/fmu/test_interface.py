"""The C interface of FMUs, held against the FMI standard 2.0.5: instances, and which call when.

Called through ctypes in a clean process, as a tool in C calls it: tests/fmu/interface.py. What the standard's
importers do not do, such as passing null pointers, is in here; test_fuzzer.py does it at random.
"""

from ctypes import c_char_p, c_size_t, c_void_p
from pathlib import Path

import numpy as np
import pytest

from chain_impact.compilation.compilers import INCLUDES, ZIG_TARGETS, interface_sources
from tests.fmu.interface import (
    CO_SIMULATION,
    DISCARD,
    DO_STEP_STATUS,
    ERROR,
    LAST_SUCCESSFUL_TIME,
    MODEL_EXCHANGE,
    OK,
    PENDING_STATUS,
    PHASES,
    TERMINATED_STATUS,
    Callbacks,
    Component,
    Library,
    calls,
    each_call,
)
from tests.fmu.standard import HEADERS, co_simulation_functions
from tests.fmu.zig import WARNINGS, zig

# --- 2.1.1 to 2.1.4: header files ------------------------------------------------------------------------


@pytest.mark.full("takes long")
@pytest.mark.parametrize("headers", [(), (HEADERS,)], ids=["own headers", "standard's headers"])
@pytest.mark.parametrize("platform", ZIG_TARGETS)
def test_it_compiles_without_a_warning(headers, platform, tmp_path):
    """With the standard's own headers, too: so each function has the type that the standard gives it."""
    target, _ = ZIG_TARGETS[platform]
    for source in interface_sources():
        options = ["-target", target, *WARNINGS, *(f"-I{folder}" for folder in (*headers, *INCLUDES))]
        zig(tmp_path, *options, "-c", source, "-o", tmp_path / f"{source.stem}.o")


# The functions before each test run in the clean process, with all that interface.py has.


def versions(fmu):
    c = Library(fmu).c
    return [c.fmi2GetTypesPlatform().decode(), c.fmi2GetVersion().decode()]


def test_platform_and_version(native, run):
    assert run(versions, native["rod_drop"]) == ["default", "2.0"]


# --- 2.1.5: instances ------------------------------------------------------------------------------------


def not_instantiated(fmu):
    import ctypes
    import shutil
    import tempfile

    library = Library(fmu)
    empty = tempfile.mkdtemp()
    broken = Path(tempfile.mkdtemp())
    shutil.copy(library.folder / "resources" / "model.bin", broken)
    content = (broken / "model.bin").read_bytes()
    refusals = {}

    def refusal(case, **changes):
        library.said()
        found = library.instantiate(**changes)
        refusals[case] = [found, library.messages[:], len(library.blocks)]

    def damaged(case, data):
        (broken / "model.bin").write_bytes(data)
        refusal(case, location=broken.as_uri().encode())

    def without(name):
        callbacks = Callbacks(*(getattr(library.callbacks, field) for field, _ in Callbacks._fields_[:3]))
        setattr(callbacks, name, dict(Callbacks._fields_)[name]())
        return ctypes.byref(callbacks)

    refusal("no name", name=None)
    refusal("empty name", name=b"")
    refusal("blank name", name=b" \t\n")
    refusal("model exchange", type=MODEL_EXCHANGE)
    refusal("another guid", guid=b"{8c4e810f-3df3-4a00-8276-176fa3c9f9e0}")
    refusal("no guid", guid=None)
    refusal("no folder", location=None)
    refusal("empty folder", location=b"")
    refusal("missing folder", location=b"file:///not/there/at%20all")
    refusal("folder without a table", location=Path(empty).as_uri().encode())
    refusal("cut-off escape", location=b"file:///tmp/%4")
    refusal("escaped zero", location=b"file:///tmp/%00")
    refusal("endless folder", location=b"file:///" + b"x" * 100_000)
    refusal("percent and hash", location=b"file:///a%25s%25n#r1#")
    refusal("no memory functions", callbacks=without("allocate"))
    refusal("no function to free", callbacks=without("free"))
    damaged("empty table", b"")
    damaged("table without an end", content[:-1])
    damaged("head only", content[:150])
    damaged("another file", b"x" * len(content))
    damaged("changed byte", content[:5000] + bytes([content[5000] ^ 1]) + content[5001:])
    damaged("huge size", content[:8] + b"\xff" * 8 + content[16:])
    for left in (0, 1):
        library.left = left
        refusal(f"memory for {left} blocks")
        library.left = -1
    silent = [library.instantiate(callbacks=None), library.instantiate(callbacks=without("logger"))]
    return [refusals, library.categories, silent]


def test_what_cannot_be_instantiated_is_refused_in_one_sentence(native, run):
    refusals, categories, silent = run(not_instantiated, native["rod_drop"])
    expected = {
        "no name": "the instance has no name",
        "empty name": "the instance has no name",
        "blank name": "the instance has no name",
        "model exchange": "this FMU is for co-simulation, not for model exchange",
        "another guid": "fmuGUID {8c4e810f-3df3-4a00-8276-176fa3c9f9e0} is not that of this FMU",
        "no guid": "the argument fmuGUID is a null pointer",
        "no folder": "the argument fmuResourceLocation is a null pointer",
        "empty folder": "fmuResourceLocation  is no URI of a folder",
        "missing folder": "has no file model.bin that can be read",
        "folder without a table": "has no file model.bin that can be read",
        "cut-off escape": "is no URI of a folder",
        "escaped zero": "is no URI of a folder",
        "endless folder": "fmuResourceLocation file:///xxx",
        "percent and hash": "file:///a%%25s%%25n##r1## has no file model.bin that can be read",
        "no memory functions": "the callbacks allocateMemory and freeMemory are needed",
        "no function to free": "the callbacks allocateMemory and freeMemory are needed",
        "empty table": "has a file model.bin that is damaged",
        "table without an end": "has a file model.bin that is damaged",
        "head only": "has a file model.bin that is damaged",
        "another file": "has a file model.bin that is damaged",
        "changed byte": "has a file model.bin that is damaged",
        "huge size": "has more in it than there is memory for",
        "memory for 0 blocks": "has more in it than there is memory for",
        "memory for 1 blocks": "no memory for an instance",
    }
    assert refusals.keys() == expected.keys()
    for case, (component, messages, blocks) in refusals.items():
        assert component is None, case
        (one,) = messages
        assert expected[case] in one[3], case
        assert one[1] == ERROR
        assert one[2] in categories
        assert blocks == 0, case
    assert silent == [None, None]


def accepted(fmu):
    library = Library(fmu)
    odd = {"empty name": {"name": b""}, "model exchange": {"type": MODEL_EXCHANGE}, "guid": {"guid": b"{0}"}}
    return {case: bool(library.instantiate(**changes)) for case, changes in odd.items()}


def test_the_limits_of_pythonfmu_when_an_instance_is_made(all_fmus, run):
    """Its wrapper does not look at these; what crashes it cannot be tested: no callbacks, odd folders."""
    for target, makes in (("pythonfmu", True), ("native", False)):
        found = run(accepted, all_fmus[target]["rod_drop"])
        assert found == dict.fromkeys(("empty name", "model exchange", "guid"), makes)


def locations(fmu):
    import tempfile

    folder = Path(tempfile.mkdtemp()) / "a b+#,([%ü 'x"
    library = Library(fmu, str(folder))
    path = str(folder / "resources")
    uri = library.location.decode()
    forms = {
        "file:///": uri,
        "file:/": uri.replace("file:///", "file:/"),
        "file://localhost/": uri.replace("file:///", "file://localhost/"),
        "with a slash at the end": uri + "/",
        "lower-case escapes": "".join(c.lower() if c in "ABCDEF" else c for c in uri),
        "a path": path.replace("%", "%25"),
    }
    return {name: bool(library.instantiate(location=form.encode())) for name, form in forms.items()}


def test_the_folder_of_the_resources_can_be_given_in_every_form(native, run):
    found = run(locations, native["rod_drop"])
    assert found == dict.fromkeys(found, True)
    assert len(found) == 6


def logging(fmu):
    from ctypes import c_size_t

    library = Library(fmu)

    def said(one, *settings):
        statuses = []
        for on, categories in settings:
            array = (c_char_p * len(categories))(*(c and c.encode() for c in categories))
            statuses.append(one.call("fmi2SetDebugLogging", on, c_size_t(len(categories)), array))
        before = library.said()
        one.step(0.0, 0.1)  # too early: an error
        return [statuses, before, len(library.said())]

    error, discard = "logStatusError", "logStatusDiscard"
    return {
        "on": said(Component(library)),
        "off": said(Component(library, logging=0)),
        "switched off": said(Component(library), (0, [])),
        "switched on": said(Component(library, logging=0), (1, [])),
        "this category": said(Component(library, logging=0), (1, [error])),
        "another category": said(Component(library), (1, [discard])),
        "all by name": said(Component(library, logging=0), (1, ["logAll"])),
        "all but one": said(Component(library), (0, [error])),
        "another one off": said(Component(library), (0, [discard])),
        "unknown": said(Component(library), (0, ["logEvents"])),
        "null": said(Component(library), (0, [None])),
    }


def test_only_what_is_wanted_is_logged(all_fmus, run):
    found = run(logging, all_fmus["native"]["rod_drop"])
    count = {case: after for case, (_, _, after) in found.items()}
    assert count == {
        "on": 1, "off": 0, "switched off": 0, "switched on": 1, "this category": 1, "another category": 0,
        "all by name": 1, "all but one": 0, "another one off": 1, "unknown": 1, "null": 1,
    }  # fmt: skip
    assert found["unknown"][:2] == [[ERROR], ["fmi2SetDebugLogging: there is no category logEvents"]]
    assert found["null"][:2] == [[ERROR], ["fmi2SetDebugLogging: there is no category NULL"]]
    # FMI 3.0 wants an error to be logged in any case
    found_3 = run(logging, all_fmus["fmi3"]["rod_drop"])
    assert {case: after for case, (_, _, after) in found_3.items()} == dict.fromkeys(found, 1)
    assert [found_3[case][:2] for case in found] == [found[case][:2] for case in found]


def null_pointers(fmu):
    """Every function without an instance; and with one, but without anything else."""
    library = Library(fmu)
    nobody, one = Component(library), Component(library).start()
    nobody.free()
    nobody.address = c_void_p()
    counts = (c_size_t(3), c_size_t(3))
    without, alone = {}, {}
    for name in calls():
        function = getattr(library.c, name)
        pointers = [None] * 6
        if "Status" in name:
            pointers = [0, None]
        elif name.startswith(
            ("fmi2GetReal", "fmi2GetI", "fmi2GetB", "fmi2GetSt", "fmi2SetReal", "fmi2SetI")
        ) or (name in ("fmi2SetBoolean", "fmi2SetString")):
            pointers = [None, counts[0], None, None]
        elif name == "fmi2GetDirectionalDerivative":
            pointers = [None, counts[0], None, counts[1], None, None]
        elif name == "fmi2SetDebugLogging":
            pointers = [1, counts[0], None]
        elif name in ("fmi2DoStep", "fmi2SetupExperiment"):
            continue
        without[name] = function(c_void_p(), *pointers)
        if name not in ("fmi2Reset", "fmi2Terminate"):
            library.said()
            alone[name] = [function(one.address, *pointers), len(library.said())]
    without["fmi2DoStep"], without["fmi2SetupExperiment"] = nobody.step(0.0, 1.0), nobody.setup()
    library.c.fmi2FreeInstance(None)
    return [without, alone, one.step(0.0, 0.1)]


def test_null_pointers_are_refused(native, run):
    without, alone, after = run(null_pointers, native["rod_drop"])
    assert set(without.values()) == {ERROR}
    assert len(without) == len(co_simulation_functions()) - 4
    ignored = {"fmi2FreeFMUstate"}  # 2.1.8
    assert {name: found for name, found in alone.items() if found != [ERROR, 1]} == {
        name: [OK, 0] for name in ignored
    }
    assert after == OK


# --- 4.2.4: which call when ------------------------------------------------------------------------------

ALWAYS = set(PHASES)
KINDS = ("", "Real", "Integer", "Boolean", "String")
STATES = ("Get", "Set", "Free", "DeSerialize", "Serialize")
ALLOWED = {
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
"""The table of section 4.2.4, without steps in progress; the rest is not supported: with no variables, a call
to it can be made at any time."""


LIMITS = {
    "fmi2Terminate": {"instantiated", "initialization mode", "terminated"},
    "fmi2GetReal": {"instantiated"},
    "fmi2GetInteger": {"instantiated"},
    "fmi2GetStatus": {"step complete", "terminated"},
    **{f"fmi2Get{kind}Status": {"instantiated", "initialization mode"} for kind in KINDS[1:]},
    "fmi2GetDirectionalDerivative": ALWAYS,
    "fmi2SetRealInputDerivatives": ALWAYS,
    "fmi2GetRealOutputDerivatives": ALWAYS,
}
"""Where pythonfmu's wrapper answers otherwise: it accepts what it should refuse, or refuses what it does not
support, though nothing is asked for. docs/fmu.md says so."""


def every_call(fmu, phases):
    library = Library(fmu)
    return [each_call(library, Component, calls(), phases), len(library.blocks)]


def test_the_table_of_allowed_calls(native, run):
    found, blocks = run(every_call, native["rod_drop"], PHASES)
    assert len(found) == len(PHASES) * (len(co_simulation_functions()) - 4)
    for phase, name, status, messages, unchanged in found:
        allowed = phase in ALLOWED.get(name, ALWAYS)
        assert (status != ERROR) == allowed, (phase, name, messages)
        assert len(messages) == (status != OK), (phase, name, messages)
        assert allowed or unchanged, (phase, name)
    assert blocks == 0


def test_the_table_of_allowed_calls_but_for_the_limits_of_pythonfmu(all_fmus, run):
    """A step that failed was fatal here, after which an instance may only be freed."""
    phases = [phase for phase in PHASES if phase != "step failed"]
    found, _ = run(every_call, all_fmus["pythonfmu"]["rod_drop"], phases)
    assert len(found) == len(phases) * (len(co_simulation_functions()) - 4)
    for phase, name, status, messages, _ in found:
        allowed = phase in ALLOWED.get(name, ALWAYS)
        assert ((status < ERROR) == allowed) != (phase in LIMITS.get(name, ())), (phase, name, status)
        assert bool(messages) == (status != OK), (phase, name, messages)


def initialization_before_setup(fmu):
    library = Library(fmu)
    one = Component(library)
    first = one.call("fmi2EnterInitializationMode")
    one.start().step(0.0, 0.5)
    one.call("fmi2Reset")
    return [first, one.call("fmi2EnterInitializationMode"), library.said()]


def test_the_experiment_is_set_up_before_initialization(native, run):
    text = "fmi2EnterInitializationMode cannot be called before fmi2SetupExperiment"
    assert run(initialization_before_setup, native["rod_drop"]) == [ERROR, ERROR, [text] * 2]


def test_the_constants_of_the_tests_are_those_of_the_standard():
    text = (HEADERS / "fmi2FunctionTypes.h").read_text(encoding="utf-8")
    order = [text.index(f"fmi2{name}") for name in ("OK,", "Warning,", "Discard,", "Error,", "Fatal,")]
    assert order == sorted(order)
    assert [OK, DISCARD, ERROR, MODEL_EXCHANGE, CO_SIMULATION] == [0, 2, 3, 0, 1]
    assert np.array_equal([DO_STEP_STATUS, PENDING_STATUS, LAST_SUCCESSFUL_TIME, TERMINATED_STATUS], range(4))
