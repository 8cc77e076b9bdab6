"""The C interface of both kinds of FMU, held against the FMI standard 2.0.5: variables and states."""

from ctypes import byref, c_double, c_size_t, c_uint, c_void_p

from tests.fmu.interface import (
    ERROR,
    FATAL,
    OK,
    PHASES,
    Component,
    Library,
)

# The functions before each test run in the clean process, with all that interface.py has.


# --- 2.1.7: variables ------------------------------------------------------------------------------------

SETTABLE = {
    "box.x_max": {"instantiated", "initialization mode"},
    "contact.restitution": {"instantiated", "initialization mode", "step complete"},
    "joint[1].torque": {"instantiated", "initialization mode", "step complete"},
    "energy.total": set(),
}


def setting(fmu, names, phases):
    library, found = Library(fmu), []
    for phase in phases:
        for name in names:
            one = Component(library).bring_to(phase)
            found.append([phase, name, one.set_real(name, 0.5)])
    return found


def test_what_can_be_set_when(fmus, target, run):
    """pythonfmu's FMU has only fatal errors, and so no phase after a step that failed."""
    refusal, phases = (ERROR, PHASES) if target != "pythonfmu" else (FATAL, set(PHASES) - {"step failed"})
    found = run(setting, fmus["pinned_arm"], list(SETTABLE), sorted(phases))
    assert len(found) == len(phases) * len(SETTABLE)
    for phase, name, status in found:
        assert status == (OK if phase in SETTABLE[name] else refusal), (phase, name)


def all_or_none(fmu):
    import math

    library = Library(fmu)
    one = Component(library).start()
    one.step(0.0, 0.1)
    before, results = one.serialized(), []
    names = ["contact.stiffness", "contact.restitution"]
    references = (c_uint * 3)(*(library.references[name] for name in names), 0)
    for second, third, count in ((2.0, 0.0, 2), (math.nan, 0.0, 2), (0.5, 1.0, 3)):
        values = (c_double * 3)(1e6, second, third)
        status = one.call("fmi2SetReal", references, c_size_t(count), values)
        results.append([status, len(library.said()), before == one.serialized()])
    return results


def test_of_several_values_all_are_set_or_none(strict, run):
    assert run(all_or_none, strict["rod_drop"]) == [[ERROR, 1, True]] * 3


def huge_count(fmu):
    """A count that has more bits than an fmi2Integer has: in a state, with a checksum that is right."""
    import struct
    import zlib

    one = Component(Library(fmu)).start()
    one.step(0.0, 0.5)
    data, steps = one.serialized(), one.integer("solver.steps")
    places = [at for at in range(96, len(data), 8) if data[at : at + 8] == struct.pack("<q", steps)]
    found = set()
    for at in places:
        content = data[24:at] + struct.pack("<q", 2**40) + data[at + 8 :]
        if one.restore(data[:16] + struct.pack("<Q", zlib.crc32(content)) + content) == OK:
            found.add(one.integer("solver.steps"))
    return sorted(found - {steps})


def test_a_count_that_is_too_large_is_the_largest_integer(native, run):
    assert run(huge_count, native["rod_drop"]) == [2**31 - 1]


# --- 2.1.8: states ---------------------------------------------------------------------------------------


def states(fmu):
    import ctypes
    from ctypes import c_size_t

    library = Library(fmu)
    one = Component(library).start()
    one.step(0.0, 0.3)
    state = one.state()
    blocks, address = len(library.blocks), state.value
    one.step(0.3, 0.3)
    reused = one.call("fmi2GetFMUstate", byref(state))
    same = [state.value == address, len(library.blocks) == blocks]
    size = c_size_t()
    one.call("fmi2SerializedFMUstateSize", state, byref(size))
    buffer = ctypes.create_string_buffer(size.value + 8)
    short = one.call("fmi2SerializeFMUstate", state, buffer, c_size_t(size.value - 1))
    untouched = buffer.raw == bytes(size.value + 8)
    longer = one.call("fmi2SerializeFMUstate", state, buffer, c_size_t(size.value + 8))
    freed = [one.call("fmi2FreeFMUstate", byref(state)), state.value, len(library.blocks) == blocks - 1]
    again = one.call("fmi2FreeFMUstate", byref(state))
    nothing = ctypes.create_string_buffer(200)
    library.said()
    wrong = [
        one.call("fmi2SetFMUstate", nothing),
        one.call("fmi2GetFMUstate", byref(c_void_p(ctypes.addressof(nothing)))),
    ]
    library.left = 0
    full = [one.call("fmi2GetFMUstate", byref(c_void_p()))]
    data = buffer.raw[: size.value]
    full.append(one.call("fmi2DeSerializeFMUstate", data, c_size_t(len(data)), byref(c_void_p())))
    return [reused, same, short, untouched, longer, freed, again, wrong, full, library.said()]


def test_the_memory_of_states(native, run):
    reused, same, short, untouched, longer, freed, again, wrong, full, said = run(states, native["rod_drop"])
    assert [reused, *same] == [OK, True, True]
    assert [short, untouched, longer] == [ERROR, True, OK]
    assert freed == [OK, None, True]
    assert again == OK
    assert wrong == full == [ERROR, ERROR]
    assert said == [
        "fmi2SetFMUstate: FMUstate is no state",
        "fmi2GetFMUstate: FMUstate is no state",
        "fmi2GetFMUstate: no memory for a state",
        "fmi2DeSerializeFMUstate: no memory for a state",
    ]


def redone(fmu):
    """Steps that are taken back, as by a master that controls its step: each from a state that it keeps."""
    library = Library(fmu)
    one, plain = Component(library).start(), Component(library).start()
    time, size, rows = 0.0, 2.0**-7, []
    state = one.state()
    for _ in range(100):
        one.call("fmi2GetFMUstate", byref(state))
        one.step(time, 3 * size)
        one.outputs()
        one.call("fmi2SetFMUstate", state)
        one.step(time, size)
        plain.step(time, size)
        time += size
        rows.append(one.outputs() == plain.outputs())
    return [all(rows), one.integer("impact.count"), len(library.blocks)]


def test_steps_can_be_taken_back(fmus, target, run):
    equal, impacts, blocks = run(redone, fmus["rod_drop"])
    assert equal
    assert impacts > 0
    if target == "native":
        assert blocks == 5  # a table and an instance for each, and one state


def every_byte(fmu):
    """A state, in which one bit of each byte in turn is another one; then the instance goes on."""
    library = Library(fmu)
    one, plain = Component(library).start(), Component(library).start()
    for component in (one, plain):
        component.step(0.0, 0.5)
    data, refused = one.serialized(), 0
    for place in range(len(data)):
        flipped = data[:place] + bytes([data[place] ^ (1 << place % 8)]) + data[place + 1 :]
        refused += one.restore(flipped) == ERROR
    for component in (one, plain):
        component.step(0.5, 0.5)
    return [refused == len(data), len(library.said()) == refused, one.outputs() == plain.outputs()]


def test_no_byte_of_a_state_can_change(strict, run):
    assert run(every_byte, strict["rod_drop"]) == [True, True, True]


def every_word(fmu):
    """States with a right checksum, one word of whose record is huge, negative or small; then a step."""
    import struct
    import zlib

    one = Component(Library(fmu)).start()
    one.step(0.0, 0.5)
    data, before, refused = one.serialized(), one.outputs(), 0
    for place in range(96, len(data), 8):
        for number in (2**62, -5, 1000):
            content = data[24:place] + struct.pack("<q", number) + data[place + 8 :]
            status = one.restore(data[:16] + struct.pack("<Q", zlib.crc32(content)) + content)
            refused += status == ERROR
            if status == OK:
                one.step(0.5, 1e-4)
                energy = c_uint(one.library.references["energy.total"])
                one.call("fmi2GetReal", byref(energy), c_size_t(1), byref(c_double()))
    assert one.restore(data) == OK
    return [refused, one.outputs() == before]


def test_no_state_leads_out_of_the_record(strict, run):
    refused, unharmed = run(every_word, strict["rod_drop"])
    assert refused > 50
    assert unharmed


def odd_states(fmu):
    """States whose head is not right, with a right checksum."""
    import struct
    import zlib

    library = Library(fmu)
    one = Component(library).start(0.0, 5.0)
    one.step(0.0, 0.5)
    data = one.serialized()
    head = struct.Struct("<40sqqdd")
    guid, phase, flags, time, stop = head.unpack_from(data, 24)

    def status(phase=phase, flags=flags, time=time, stop=stop, guid=guid):
        content = head.pack(guid, phase, flags, time, stop) + data[24 + head.size :]
        return one.restore(data[:16] + struct.pack("<Q", zlib.crc32(content)) + content)

    nan = float("nan")
    cases = [{"phase": 9}, {"phase": -1}, {"flags": 0}, {"flags": 7}, {"time": nan}, {"stop": nan}]
    cases += [{"phase": 2, "flags": 2}, {"time": float("inf")}, {"guid": b"x" * 40}]
    refused = [status(**case) for case in cases]
    library.said()
    return [refused, status(), one.step(0.5, 0.1)]


def test_states_with_an_odd_head_are_refused(strict, run):
    refused, right, after = run(odd_states, strict["rod_drop"])
    assert set(refused) == {ERROR}
    assert right == after == OK
