"""States, steps and resets of FMUs against the FMI standard 2.0.5, as in test_interface.py."""

# Tests: fmu/model_bin.py

import ctypes
import math
import struct
import zlib
from ctypes import byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p

from tests.fmu.clean import calling
from tests.fmu.interface import (
    DISCARD,
    DO_STEP_STATUS,
    ERROR,
    LAST_SUCCESSFUL_TIME,
    OK,
    PENDING_STATUS,
    PHASES,
    TERMINATED_STATUS,
    Component,
    Library,
)

# --- 2.1.8: states ---------------------------------------------------------------------------------------


@calling("rod_drop")
def test_the_memory_of_states(fmu):
    library = Library(fmu)
    instance = Component(library).start()
    instance.step(0.0, 0.3)
    state, size = instance.state(), c_size_t()
    blocks, address = len(library.blocks), state.value
    instance.step(0.3, 0.3)
    assert instance.call("fmi2GetFMUstate", byref(state)) == OK
    assert (state.value, len(library.blocks)) == (address, blocks)
    instance.call("fmi2SerializedFMUstateSize", state, byref(size))
    buffer = ctypes.create_string_buffer(size.value + 8)
    assert instance.call("fmi2SerializeFMUstate", state, buffer, c_size_t(size.value - 1)) == ERROR
    assert buffer.raw == bytes(size.value + 8)
    assert instance.call("fmi2SerializeFMUstate", state, buffer, c_size_t(size.value + 8)) == OK
    for left in (blocks - 1, blocks - 1):  # the second time there is no state to free
        assert instance.call("fmi2FreeFMUstate", byref(state)) == OK
        assert (state.value, len(library.blocks)) == (None, left)
    no_state = ctypes.create_string_buffer(200)
    library.new_messages()

    def refused(name, *arguments, reason):
        assert instance.call(f"fmi2{name}FMUstate", *arguments) == ERROR
        assert library.new_messages() == [f"fmi2{name}FMUstate: {reason}"]

    refused("Set", no_state, reason="FMUstate is no state")
    refused("Get", byref(c_void_p(ctypes.addressof(no_state))), reason="FMUstate is no state")
    library.left = 0
    refused("Get", byref(c_void_p()), reason="no memory for a state")
    refused("DeSerialize", buffer.raw[: size.value], size, byref(c_void_p()), reason="no memory for a state")


@calling("rod_drop", kinds="fmus")
def test_no_byte_of_a_state_can_change(fmu):
    library = Library(fmu)
    instance, plain = Component(library).start(), Component(library).start()
    for component in (instance, plain):
        component.step(0.0, 0.5)
    data = instance.serialized()
    for place in (*range(128), *range(128, len(data), 101), len(data) - 1):
        flipped = data[:place] + bytes([data[place] ^ (1 << place % 8)]) + data[place + 1 :]
        assert instance.restore(flipped) == library.refusal
        assert len(library.new_messages()) == 1
    for component in (instance, plain):
        component.step(0.5, 0.5)
    assert instance.outputs() == plain.outputs()


@calling("rod_drop", kinds="fmus")
def test_no_state_leads_out_of_the_record(fmu):
    """States with a valid checksum have one word of their record huge, negative or 1000.

    A step follows where such a state is accepted.
    """
    instance = Component(Library(fmu)).start()
    instance.step(0.0, 0.5)
    data, outputs, refused = instance.serialized(), instance.outputs(), 0
    for place in range(96, len(data), 8):
        for number in (2**62, -5, 1000):
            content = data[24:place] + struct.pack("<q", number) + data[place + 8 :]
            status = instance.restore(data[:16] + struct.pack("<Q", zlib.crc32(content)) + content)
            refused += status == instance.library.refusal
            if status == OK:
                instance.step(0.5, 1e-4)
                energy = c_uint(instance.library.references["energy.total"])
                instance.call("fmi2GetReal", byref(energy), c_size_t(1), byref(c_double()))
    assert instance.restore(data) == OK
    assert refused > 50
    assert instance.outputs() == outputs


@calling("rod_drop", kinds="fmus")
def test_states_with_an_odd_head_are_refused(fmu):
    """The states have a valid checksum."""
    instance = Component(Library(fmu)).start(0.0, 5.0)
    instance.step(0.0, 0.5)
    data, head = instance.serialized(), struct.Struct("<40sqqdd")
    head_values = dict(
        zip(("guid", "phase", "flags", "time", "stop"), head.unpack_from(data, 24), strict=True)
    )

    def status(**changes):
        content = head.pack(*(head_values | changes).values()) + data[24 + head.size :]
        return instance.restore(data[:16] + struct.pack("<Q", zlib.crc32(content)) + content)

    cases = [{"phase": 9}, {"phase": -1}, {"flags": 0}, {"flags": 7}, {"time": math.nan}, {"stop": math.nan}]
    cases += [{"phase": 2, "flags": 2}, {"time": math.inf}, {"guid": b"x" * 40}]
    refusal = instance.library.refusal
    assert [status(**case) for case in cases] == [refusal] * len(cases)
    assert [status(), instance.step(0.5, 0.1)] == [OK, OK]
    second_instance = Component(instance.library)
    assert second_instance.restore(data) == OK
    # the stop time belongs to the state
    assert [second_instance.step(0.5, 4.75), second_instance.step(0.5, 4.5)] == [refusal, OK]


# --- 4.2.2 and 4.2.3: steps ------------------------------------------------------------------------------


@calling("rod_drop", kinds="fmus")
def test_clocks_may_differ_by_rounding_errors(fmu):
    """The times are sums of steps that are no binary fractions, up to a stop time."""
    library = Library(fmu)
    for size in (1e-3, 1e-2, 0.1, 0.3, 1.0 / 3.0):
        instance, time = Component(library).start(7.7, 7.7 + 30 * size), 7.7
        for _ in range(30):
            assert instance.step(time, size) == OK
            time += size
        assert instance.step(time, 1e-3 * size) == library.refusal


@calling("rod_drop", kinds="fmus")
def test_the_clock_of_an_importer_may_be_rounded(fmu):
    """The clock is rounded to 1 µs, also at a stop time between two multiples.

    Skipped and repeated steps are reported.
    """
    library, stop = Library(fmu), 0.1
    expected = Component(library).start(0.0, stop)
    assert expected.step(0.0, stop) == OK
    for size in (1e-2 / 3.0, 1e-3 / 3.0):
        instance = Component(library).start(0.0, stop)
        for k in range(round(stop / size)):
            assert instance.step(round(k * size, 6), size) == OK
        error = instance.real("point[1].y") - expected.real("point[1].y")
        assert abs(error) <= 1e-6 * abs(expected.real("point[1].vy"))
        for time_error in (size, -size, 0.1 * size):
            instance = Component(library).start()
            assert instance.step(0.0, size) == OK
            assert instance.step(size + time_error, size) == library.refusal


@calling("rod_drop", kinds="fmus")
def test_a_step_of_infinite_size_is_refused(fmu):
    library = Library(fmu)
    instance = Component(library).start()
    library.new_messages()
    assert instance.step(0.0, math.inf) == library.refusal
    (text,) = library.new_messages()
    assert "the step size inf s is not" in text


@calling("four_link_box")
def test_a_step_that_cannot_be_finished_is_discarded_and_can_be_taken_back(fmu):
    library = Library(fmu)
    instance = Component(library).start(**{"solver.work_limit": 800.0})
    instance.step(0.0, 0.125)
    state, cell, integer = instance.state(), c_double(), c_int()
    assert instance.step(0.125, 1.0) == DISCARD
    ((name, status, category, text),) = library.messages
    assert (name, status, category) == ("one", DISCARD, "logStatusDiscard")
    assert text.startswith("the simulation stopped at t = ")
    assert instance.call("fmi2GetRealStatus", LAST_SUCCESSFUL_TIME, byref(cell)) == OK
    assert 0.125 < cell.value < 1.125
    assert instance.call("fmi2GetBooleanStatus", TERMINATED_STATUS, byref(integer)) == OK
    assert integer.value == 0
    assert instance.call("fmi2GetStatus", DO_STEP_STATUS, byref(integer)) == OK
    assert integer.value == DISCARD
    assert instance.call("fmi2GetStringStatus", PENDING_STATUS, byref(c_char_p())) == DISCARD
    assert instance.integer("solver.status") == 9
    assert instance.call("fmi2SetFMUstate", state) == OK
    assert [
        instance.step(0.125, 0.125),
        instance.call("fmi2Terminate"),
        instance.integer("solver.status"),
    ] == [OK, OK, 0]


@calling("rod_drop", kinds="fmus")
def test_a_reset_instance_is_as_a_new_one_to_the_last_bit(fmu, target):
    """The instance is reset in each phase."""
    library, first = Library(fmu), None
    for phase in (None, *PHASES):
        instance, rows = Component(library), []
        if phase == "step failed" and target == "pythonfmu":
            continue
        if phase:
            instance.set_integer("contact.model", 3)
            instance.bring_to(phase)
            instance.call("fmi2Reset")
        start = instance.serialized()
        instance.start()
        for k in range(64):
            instance.step(k * 2.0**-6, 2.0**-6)
            rows += instance.outputs()
        run = [start, rows, instance.serialized()]
        first = first or run
        assert run == first, phase
