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
    one = Component(library).start()
    one.step(0.0, 0.3)
    state, size = one.state(), c_size_t()
    blocks, address = len(library.blocks), state.value
    one.step(0.3, 0.3)
    assert one.call("fmi2GetFMUstate", byref(state)) == OK
    assert (state.value, len(library.blocks)) == (address, blocks)
    one.call("fmi2SerializedFMUstateSize", state, byref(size))
    buffer = ctypes.create_string_buffer(size.value + 8)
    assert one.call("fmi2SerializeFMUstate", state, buffer, c_size_t(size.value - 1)) == ERROR
    assert buffer.raw == bytes(size.value + 8)
    assert one.call("fmi2SerializeFMUstate", state, buffer, c_size_t(size.value + 8)) == OK
    for left in (blocks - 1, blocks - 1):  # the second time there is no state to free
        assert one.call("fmi2FreeFMUstate", byref(state)) == OK
        assert (state.value, len(library.blocks)) == (None, left)
    nothing = ctypes.create_string_buffer(200)
    library.said()

    def refused(name, *arguments, why):
        assert one.call(f"fmi2{name}FMUstate", *arguments) == ERROR
        assert library.said() == [f"fmi2{name}FMUstate: {why}"]

    refused("Set", nothing, why="FMUstate is no state")
    refused("Get", byref(c_void_p(ctypes.addressof(nothing))), why="FMUstate is no state")
    library.left = 0
    refused("Get", byref(c_void_p()), why="no memory for a state")
    refused("DeSerialize", buffer.raw[: size.value], size, byref(c_void_p()), why="no memory for a state")


@calling("rod_drop", kinds="fmus")
def test_no_byte_of_a_state_can_change(fmu):
    library = Library(fmu)
    one, plain = Component(library).start(), Component(library).start()
    for component in (one, plain):
        component.step(0.0, 0.5)
    data = one.serialized()
    for place in (*range(128), *range(128, len(data), 101), len(data) - 1):
        flipped = data[:place] + bytes([data[place] ^ (1 << place % 8)]) + data[place + 1 :]
        assert one.restore(flipped) == library.refusal
        assert len(library.said()) == 1
    for component in (one, plain):
        component.step(0.5, 0.5)
    assert one.outputs() == plain.outputs()


@calling("rod_drop", kinds="fmus")
def test_no_state_leads_out_of_the_record(fmu):
    """States with a valid checksum have one word of their record huge, negative or 1000.

    A step follows where such a state is accepted.
    """
    one = Component(Library(fmu)).start()
    one.step(0.0, 0.5)
    data, before, refused = one.serialized(), one.outputs(), 0
    for place in range(96, len(data), 8):
        for number in (2**62, -5, 1000):
            content = data[24:place] + struct.pack("<q", number) + data[place + 8 :]
            status = one.restore(data[:16] + struct.pack("<Q", zlib.crc32(content)) + content)
            refused += status == one.library.refusal
            if status == OK:
                one.step(0.5, 1e-4)
                energy = c_uint(one.library.references["energy.total"])
                one.call("fmi2GetReal", byref(energy), c_size_t(1), byref(c_double()))
    assert one.restore(data) == OK
    assert refused > 50
    assert one.outputs() == before


@calling("rod_drop", kinds="fmus")
def test_states_with_an_odd_head_are_refused(fmu):
    """The states have a valid checksum."""
    one = Component(Library(fmu)).start(0.0, 5.0)
    one.step(0.0, 0.5)
    data, head = one.serialized(), struct.Struct("<40sqqdd")
    right = dict(zip(("guid", "phase", "flags", "time", "stop"), head.unpack_from(data, 24), strict=True))

    def status(**changes):
        content = head.pack(*(right | changes).values()) + data[24 + head.size :]
        return one.restore(data[:16] + struct.pack("<Q", zlib.crc32(content)) + content)

    cases = [{"phase": 9}, {"phase": -1}, {"flags": 0}, {"flags": 7}, {"time": math.nan}, {"stop": math.nan}]
    cases += [{"phase": 2, "flags": 2}, {"time": math.inf}, {"guid": b"x" * 40}]
    refusal = one.library.refusal
    assert [status(**case) for case in cases] == [refusal] * len(cases)
    assert [status(), one.step(0.5, 0.1)] == [OK, OK]
    other = Component(one.library)
    assert other.restore(data) == OK
    # the stop time belongs to the state
    assert [other.step(0.5, 4.75), other.step(0.5, 4.5)] == [refusal, OK]


# --- 4.2.2 and 4.2.3: steps ------------------------------------------------------------------------------


@calling("rod_drop", kinds="fmus")
def test_clocks_may_differ_by_rounding_errors(fmu):
    """The times are sums of steps that are no binary fractions, up to a stop time."""
    library = Library(fmu)
    for size in (1e-3, 1e-2, 0.1, 0.3, 1.0 / 3.0):
        one, time = Component(library).start(7.7, 7.7 + 30 * size), 7.7
        for _ in range(30):
            assert one.step(time, size) == OK
            time += size
        assert one.step(time, 1e-3 * size) == library.refusal


@calling("rod_drop", kinds="fmus")
def test_the_clock_of_an_importer_may_be_rounded(fmu):
    """The clock is rounded to 1 µs, also at a stop time between two multiples.

    Skipped and repeated steps are reported.
    """
    library, stop = Library(fmu), 0.1
    exact = Component(library).start(0.0, stop)
    assert exact.step(0.0, stop) == OK
    for size in (1e-2 / 3.0, 1e-3 / 3.0):
        one = Component(library).start(0.0, stop)
        for k in range(round(stop / size)):
            assert one.step(round(k * size, 6), size) == OK
        error = one.real("point[1].y") - exact.real("point[1].y")
        assert abs(error) <= 1e-6 * abs(exact.real("point[1].vy"))
        for wrong in (size, -size, 0.1 * size):
            one = Component(library).start()
            assert one.step(0.0, size) == OK
            assert one.step(size + wrong, size) == library.refusal


@calling("rod_drop", kinds="fmus")
def test_a_step_of_infinite_size_is_refused(fmu):
    library = Library(fmu)
    one = Component(library).start()
    library.said()
    assert one.step(0.0, math.inf) == library.refusal
    (text,) = library.said()
    assert "the step size inf s is not" in text


@calling("four_link_box")
def test_a_step_that_cannot_be_finished_is_discarded_and_can_be_taken_back(fmu):
    library = Library(fmu)
    one = Component(library).start(**{"solver.work_limit": 800.0})
    one.step(0.0, 0.125)
    state, cell, whole = one.state(), c_double(), c_int()
    assert one.step(0.125, 1.0) == DISCARD
    ((name, status, category, text),) = library.messages
    assert (name, status, category) == ("one", DISCARD, "logStatusDiscard")
    assert text.startswith("the simulation stopped at t = ")
    assert one.call("fmi2GetRealStatus", LAST_SUCCESSFUL_TIME, byref(cell)) == OK
    assert 0.125 < cell.value < 1.125
    assert one.call("fmi2GetBooleanStatus", TERMINATED_STATUS, byref(whole)) == OK
    assert whole.value == 0
    assert one.call("fmi2GetStatus", DO_STEP_STATUS, byref(whole)) == OK
    assert whole.value == DISCARD
    assert one.call("fmi2GetStringStatus", PENDING_STATUS, byref(c_char_p())) == DISCARD
    assert one.integer("solver.status") == 9
    assert one.call("fmi2SetFMUstate", state) == OK
    assert [one.step(0.125, 0.125), one.call("fmi2Terminate"), one.integer("solver.status")] == [OK, OK, 0]


@calling("rod_drop", kinds="fmus")
def test_a_reset_instance_is_as_a_new_one_to_the_last_bit(fmu, target):
    """The instance is reset in each phase."""
    library, first = Library(fmu), None
    for phase in (None, *PHASES):
        one, rows = Component(library), []
        if phase == "step failed" and target == "pythonfmu":
            continue
        if phase:
            one.set_integer("contact.model", 3)
            one.bring_to(phase)
            one.call("fmi2Reset")
        start = one.serialized()
        one.start()
        for k in range(64):
            one.step(k * 2.0**-6, 2.0**-6)
            rows += one.outputs()
        run = [start, rows, one.serialized()]
        first = first or run
        assert run == first, phase
