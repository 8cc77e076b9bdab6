"""The C interface of FMUs against the FMI standard 2.0.5, section by section.

The tests call it through ctypes in a clean process, as a tool in C does (tests/fmu/interface.py). They
include calls that common importers do not make, such as null pointers. test_interface_states.py has states
and steps, and test_fuzzer.py makes random calls.
"""

# Tests: compilation/signatures.py, fmu/model_bin.py

import ctypes
import math
import struct
import tempfile
import zlib
from ctypes import byref, c_char_p, c_double, c_size_t, c_uint, c_void_p
from pathlib import Path

import pytest

from chain_impact.compilation.compilers import INCLUDES, interface_sources
from chain_impact.system import HOST, PLATFORMS
from tests.fmu.clean import calling
from tests.fmu.interface import (
    ALLOWED_PHASES,
    CO_SIMULATION,
    DISCARD,
    DO_STEP_STATUS,
    ERROR,
    LAST_SUCCESSFUL_TIME,
    LIMITS,
    MODEL_EXCHANGE,
    OK,
    PENDING_STATUS,
    PHASES,
    TERMINATED_STATUS,
    WARNING,
    Callbacks,
    Component,
    Library,
    calls,
    each_call,
)
from tests.fmu.standard import HEADERS
from tests.helpers.tools.zig import WARNINGS, zig

# --- 2.1.1 to 2.1.4: header files ------------------------------------------------------------------------


@pytest.mark.full("takes long")
@pytest.mark.parametrize(
    "platform", ["linux64", "win64", "aarch64-linux", "aarch64-darwin", "standard's headers"]
)
def test_the_interface_compiles_without_a_warning(platform, tmp_path):
    """The standard's own headers are included, so that each function has the type of the standard."""
    target = PLATFORMS.get(platform, PLATFORMS[HOST]).target
    headers = INCLUDES if platform in PLATFORMS else (HEADERS, *INCLUDES)
    options = ["-target", target, *WARNINGS, *(f"-I{folder}" for folder in headers)]
    for source in interface_sources():
        zig(tmp_path, *options, "-c", source, "-o", tmp_path / f"{source.stem}.o")


@calling("rod_drop")
def test_the_version_and_the_constants_are_those_of_the_standard(fmu):
    from standard import HEADERS

    c = Library(fmu).c
    assert [c.fmi2GetTypesPlatform(), c.fmi2GetVersion()] == [b"default", b"2.0"]
    text = (HEADERS / "fmi2FunctionTypes.h").read_text(encoding="utf-8")
    order = [text.index(f"fmi2{name}") for name in ("OK,", "Warning,", "Discard,", "Error,", "Fatal,")]
    assert order == sorted(order)
    assert [OK, DISCARD, ERROR, MODEL_EXCHANGE, CO_SIMULATION] == [0, 2, 3, 0, 1]
    assert [DO_STEP_STATUS, PENDING_STATUS, LAST_SUCCESSFUL_TIME, TERMINATED_STATUS] == [0, 1, 2, 3]


# --- 2.1.5: instances ------------------------------------------------------------------------------------


@calling("rod_drop")
def test_an_impossible_instance_is_refused_in_one_sentence(fmu):
    library, broken = Library(fmu), Path(tempfile.mkdtemp())
    content = (library.folder / "resources" / "model.bin").read_bytes()

    def refused(sentence, *tables, left=-1, **changes):
        for table in tables:
            (broken / "model.bin").write_bytes(table)
            changes["location"] = broken.as_uri().encode()
        library.left = left
        assert library.instantiate(**changes) is None, sentence
        ((_, status, category, text),) = library.messages
        assert sentence in text
        assert (status, category in library.categories, library.blocks) == (ERROR, True, {}), sentence
        library.new_messages()

    def without(name):
        callbacks = Callbacks(*(getattr(library.callbacks, field) for field, _ in Callbacks._fields_[:3]))
        setattr(callbacks, name, dict(Callbacks._fields_)[name]())
        return byref(callbacks)

    for name in (None, b"", b" \t\n"):
        refused("the instance has no name", name=name)
    refused("this FMU is for co-simulation, not for model exchange", type=MODEL_EXCHANGE)
    guid = "{8c4e810f-3df3-4a00-8276-176fa3c9f9e0}"
    refused(f"fmuGUID {guid} differs from that of this FMU", guid=guid.encode())
    refused("the argument fmuGUID is a null pointer", guid=None)
    refused("the argument fmuResourceLocation is a null pointer", location=None)
    refused("fmuResourceLocation  is no URI of a folder", location=b"")
    for folder in ("file:///not/there/at%20all", Path(tempfile.mkdtemp()).as_uri()):
        refused("has no file model.bin that can be read", location=folder.encode())
    refused("is no URI of a folder", location=b"file:///tmp/%4")  # a cut-off escape
    refused("is no URI of a folder", location=b"file:///tmp/%00")
    refused("fmuResourceLocation file:///xxx", location=b"file:///" + b"x" * 100_000)
    refused("file:///a%%25s%%25n##r1## has no file model.bin", location=b"file:///a%25s%25n#r1#")
    for name in ("allocate", "free"):
        refused("the callbacks allocateMemory and freeMemory are needed", callbacks=without(name))
    changed_table = content[:5000] + bytes([content[5000] ^ 1]) + content[5001:]
    for table in (b"", content[:-1], content[:150], b"x" * len(content), changed_table):
        refused("has a file model.bin that is damaged", table)
    refused("needs more memory than there is", content[:8] + b"\xff" * 8 + content[16:])
    refused("needs more memory than there is", left=0)
    refused("no memory for an instance", left=1)
    library.left = -1
    assert library.instantiate(callbacks=None) is None
    assert library.instantiate(callbacks=without("logger")) is None


@calling("rod_drop")
def test_the_folder_of_the_resources_can_be_given_in_every_form(fmu):
    folder = Path(tempfile.mkdtemp()) / "a b+#,([%ü 'x"
    library = Library(fmu, str(folder))
    uri = library.location.decode()
    assert uri.startswith("file:///")
    lower_case = "".join(c.lower() if c in "ABCDEF" else c for c in uri)
    path = str(folder / "resources").replace("%", "%25")
    for form in (uri, uri[:5] + uri[7:], f"file://localhost{uri[7:]}", f"{uri}/", lower_case, path):
        assert library.instantiate(location=form.encode()), form


@calling("rod_drop", kinds="strict")
def test_only_what_is_wanted_is_logged(fmu):
    """Without debug logging only refusals are logged; in FMI 3.0 every error is logged."""
    library, error, discard = Library(fmu), "logStatusError", "logStatusDiscard"
    for logging, setting, is_logged in (
        (1, None, True), (0, None, True), (1, (0, []), False), (0, (1, []), True), (0, (1, [error]), True),
        (1, (1, [discard]), False), (0, (1, ["logAll"]), True), (1, (0, [error]), False),
        (1, (0, [discard]), True), (1, (0, ["logEvents"]), True), (1, (0, [None]), True),
    ):  # fmt: skip
        instance, expected = Component(library, logging=logging), []
        if setting:
            on, names = setting
            array = (c_char_p * len(names))(*(name and name.encode() for name in names))
            status = instance.call("fmi2SetDebugLogging", on, c_size_t(len(names)), array)
            is_unknown = names in (["logEvents"], [None])
            expected = (
                [f"fmi2SetDebugLogging: there is no category {names[0] or 'NULL'}"] if is_unknown else []
            )
            assert status == (ERROR if is_unknown else OK)
        assert library.new_messages() == expected
        instance.step(0.0, 0.1)  # before initialization: an error
        assert len(library.new_messages()) == int(is_logged or library.fmi3), setting


@calling("rod_drop")
def test_null_pointers_are_refused(fmu):
    """Call every function with a null instance, and with an instance and null arguments."""
    from standard import co_simulation_functions

    library = Library(fmu)
    nobody, instance = Component(library), Component(library).start()
    nobody.free()
    nobody.address = c_void_p()
    assert len(calls()) == len(co_simulation_functions()) - 4
    count = c_size_t(3)
    special = {"fmi2SetDebugLogging": [1, count, None]}
    special["fmi2GetDirectionalDerivative"] = [None, count, None, count, None, None]
    for name in calls().keys() - {"fmi2DoStep", "fmi2SetupExperiment"}:
        arguments = (
            [0, None] if "Status" in name else [None] * 6 if "FMU" in name else [None, count, None, None]
        )
        pointers = special.get(name, arguments)
        function = getattr(library.c, name)
        assert function(c_void_p(), *pointers) == ERROR, name
        if name not in ("fmi2Reset", "fmi2Terminate"):
            library.new_messages()
            result = function(instance.address, *pointers), len(library.new_messages())
            assert result == ((OK, 0) if name == "fmi2FreeFMUstate" else (ERROR, 1)), name  # 2.1.8
    assert [nobody.step(0.0, 1.0), nobody.setup()] == [ERROR, ERROR]
    library.c.fmi2FreeInstance(None)
    assert instance.step(0.0, 0.1) == OK


# --- 4.2.4: which call when ------------------------------------------------------------------------------


@calling("rod_drop")
def test_the_table_of_allowed_calls(fmu):
    library = Library(fmu)
    for phase, name, status, messages, unchanged in each_call(library, Component, calls(), PHASES):
        is_allowed = phase in ALLOWED_PHASES.get(name, PHASES)
        assert (status != ERROR) == is_allowed, (phase, name, messages)
        assert len(messages) == (status != OK), (phase, name, messages)
        assert is_allowed or unchanged, (phase, name)
    assert library.blocks == {}


@calling("rod_drop", kinds="pythonfmu")
def test_the_table_of_allowed_calls_but_for_the_limits_of_pythonfmu(fmu):
    """A failed step is fatal in pythonfmu's FMU; afterwards its instance may only be freed."""
    phases = [phase for phase in PHASES if phase != "step failed"]
    for phase, name, status, messages, unchanged in each_call(Library(fmu), Component, calls(), phases):
        is_allowed = phase in ALLOWED_PHASES.get(name, PHASES)
        assert ((status < ERROR) == is_allowed) != (phase in LIMITS.get(name, ())), (phase, name, status)
        assert bool(messages) == (status != OK), (phase, name, messages)
        assert is_allowed or unchanged, (phase, name)


@calling("rod_drop", kinds="fmi2")
def test_the_experiment_is_set_up_before_initialization(fmu):
    library = Library(fmu)
    instance = Component(library)
    for _ in range(2):
        assert instance.call("fmi2EnterInitializationMode") == library.refusal
        (text,) = library.new_messages()
        assert text.endswith("fmi2EnterInitializationMode cannot be called before fmi2SetupExperiment")
        instance.start().step(0.0, 0.5)
        instance.call("fmi2Reset")


# --- 2.1.7: variables ------------------------------------------------------------------------------------


@calling("rod_drop")
def test_a_value_reference_behind_the_last_variable_is_refused(fmu):
    """The table declares one variable too few, so that the data behind its end look like a variable."""
    library, value = Library(fmu), c_double(0.5)
    file = library.folder / "resources" / "model.bin"
    content = file.read_bytes()
    last = struct.unpack_from("<q", content, 64)[0] - 1
    content = content[:64] + struct.pack("<q", last) + content[72:]
    file.write_bytes(content[:16] + zlib.crc32(content[24:]).to_bytes(8, "little") + content[24:])
    instance = Component(library).start()
    for element in ("Real", "Integer"):
        assert instance.call(f"fmi2Get{element}", byref(c_uint(last)), c_size_t(1), byref(value)) == ERROR
        assert f"the value reference {last} is no " in library.new_messages()[-1]


@calling("pinned_arm", kinds="fmus")
def test_each_state_of_an_instance_lets_its_variables_be_set(fmu, target):
    """pythonfmu's FMU has only fatal errors, so the phase after a failed step does not exist."""
    phases_before, tunable = ("instantiated", "initialization mode"), "step complete"
    when = {"box.x_max": phases_before, "energy.total": ()}
    when |= dict.fromkeys(("contact.restitution", "joint[1].torque"), (*phases_before, tunable))
    phases = [phase for phase in PHASES if target != "pythonfmu" or phase != "step failed"]
    library = Library(fmu)
    for phase in phases:
        for name, settable in when.items():
            status = Component(library).bring_to(phase).set_real(name, 0.5)
            assert status == (OK if phase in settable else library.refusal), (phase, name)


@calling("rod_drop", kinds="fmus")
def test_several_values_are_set_together_or_not_at_all(fmu):
    library = Library(fmu)
    instance = Component(library).start()
    instance.step(0.0, 0.1)
    state = instance.serialized()
    names = ["contact.stiffness", "contact.restitution"]
    references = (c_uint * 3)(*(library.references[name] for name in names), 0)
    for second, third, count in ((2.0, 0.0, 2), (math.nan, 0.0, 2), (0.5, 1.0, 3)):
        values = (c_double * 3)(1e6, second, third)
        assert instance.call("fmi2SetReal", references, c_size_t(count), values) == library.refusal
        assert len(library.new_messages()) == 1
        assert state == instance.serialized()


@calling("sliding_rod", kinds="strict")
def test_outputs_come_with_a_warning_where_what_was_set_cannot_act(fmu):
    """The static friction is below the kinetic friction."""
    instance = Component(Library(fmu)).start()
    instance.step(0.0, 0.3)
    assert instance.set_real("wall.y_min.static_friction", 0.01) == OK
    reference = c_uint(instance.library.references["energy.total"])
    assert instance.call("fmi2GetReal", byref(reference), c_size_t(1), byref(c_double())) == WARNING


@calling("rod_drop", kinds="fmi2")
def test_a_count_that_is_too_large_is_the_largest_integer(fmu):
    """A state with a valid checksum holds a count that exceeds an fmi2Integer."""
    instance = Component(Library(fmu)).start()
    instance.step(0.0, 0.5)
    data, steps, counts = instance.serialized(), instance.integer("solver.steps"), set()
    for at in range(96, len(data), 8):
        if data[at : at + 8] == struct.pack("<q", steps):
            content = data[24:at] + struct.pack("<q", 2**40) + data[at + 8 :]
            if instance.restore(data[:16] + struct.pack("<Q", zlib.crc32(content)) + content) == OK:
                counts.add(instance.integer("solver.steps"))
    assert counts - {steps} == {2**31 - 1}


# --- several instances -----------------------------------------------------------------------------------


@calling("four_link_box", "rod_drop", kinds="strict")
def test_fmus_do_not_mix_where_symbols_are_global(fmu, second_fmu):

    def run(library):
        instance = Component(library).start()
        instance.step(0.0, 0.5)
        return instance.outputs()

    shared = [run(Library(path, mode=ctypes.RTLD_GLOBAL)) for path in (fmu, second_fmu)]
    assert shared == [run(Library(path)) for path in (fmu, second_fmu)]
    assert len(shared[0]) != len(shared[1])


def fates_of_tables(fmu):
    """Return the results of ``fates``, which the clean process has from broken_tables.py."""
    return fates(fmu)  # noqa: F821


@pytest.mark.full("takes long")
def test_no_number_in_the_table_does_harm(native, clean):
    """With a valid checksum, a wrong number is refused, or harmless."""
    exit_codes, sizes = clean(fates_of_tables, native["rod_drop"], module="broken_tables")
    assert exit_codes.pop("none") == 0
    assert not {name: code for name, code in exit_codes.items() if code not in (0, 1)}
    assert all(code == 1 for name, code in exit_codes.items() if name.startswith(tuple(sizes)))
    assert sum(exit_codes.values()) > len(exit_codes) // 4
