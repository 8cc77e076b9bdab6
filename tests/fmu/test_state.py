"""States of the FMU: saved, restored, as bytes and in another instance; in a clean process."""

import pytest

from tests.fmu.importer import MESSAGES, FMICallException, Instance, refused

# The functions before each test run in the clean process: they hold all that they use.


def saved(fmu, save_at, times):
    one, two, never = Instance(fmu).start(), Instance(fmu), Instance(fmu).start()
    one.step(save_at)
    state = one.fmu.getFMUstate()
    data = one.fmu.serializeFMUstate(state)

    def go_on(instance):
        instance.time = save_at
        first = instance.get(instance.outputs)
        return [first, *instance.run(times)]

    first = go_on(one)
    one.fmu.setFMUstate(state)
    second = go_on(one)
    one.fmu.freeFMUstate(state)
    # another instance, which is not even initialized
    copy = two.fmu.deSerializeFMUstate(data)
    two.fmu.setFMUstate(copy)
    third = go_on(two)
    two.fmu.freeFMUstate(copy)
    never.step(save_at)
    return [first, second, third, go_on(never), len(data)]


@pytest.mark.parametrize("save_at", [0.3, 0.5], ids=["in flight", "later"])
def test_a_saved_state_goes_on_to_the_last_bit(fmus, clean, save_at):
    times = [save_at + 0.01 * (i + 1) for i in range(50)] + [1.0]
    first, second, third, never, size = clean(saved, fmus["four_link_box"], save_at, times)
    assert first == second == third == never
    assert size > 1000


def in_contact(fmu):
    """Save in the middle of the first contact."""
    one = Instance(fmu).start()
    while not (force := one["contact[0].y_min.force"]):
        one.step(one.time + 1e-5)
    state = one.fmu.getFMUstate()
    start, times = one.time, [one.time + 1e-5 * (i + 1) for i in range(200)]
    first = one.run(times)
    one.fmu.setFMUstate(state)
    one.time = start
    return [force, first == one.run(times), one["impact.count"]]


def test_a_state_saved_in_contact_goes_on_to_the_last_bit(fmus, clean):
    force, equal, impacts = clean(in_contact, fmus["rod_drop"])
    assert force > 0.0
    assert equal
    assert impacts == 1


def saved_before_initialization(fmu):
    instance = Instance(fmu)
    instance.set({"initial.y": 0.75})
    state = instance.fmu.getFMUstate()
    instance.set({"initial.y": 1.0})
    instance.start()
    instance.step(0.1)
    instance.fmu.setFMUstate(state)
    restored = instance["initial.y"]
    instance.start()
    return [restored, instance["point[0].y"]]


def test_a_state_can_be_saved_before_initialization(fmus, clean):
    assert clean(saved_before_initialization, fmus["rod_drop"]) == [0.75, 0.75]


def damaged(fmu, other):
    one = Instance(fmu).start()
    data = one.fmu.serializeFMUstate(one.fmu.getFMUstate())

    def flipped(place):
        return data[:place] + bytes([data[place] ^ 1]) + data[place + 1 :]

    # in the envelope, in the head of what it holds, and here and there in the record
    places = [*range(0, 96, 4), *range(96, len(data), len(data) // 16), len(data) - 1]
    pieces = [
        *map(flipped, places),
        data[:-8],
        data + b"12345678",
        b"",
        b"nonsense",
        data[:24],
        bytes(len(data)),
    ]
    messages = [refused(fmu, lambda i, piece=piece: i.fmu.deSerializeFMUstate(piece)) for piece in pieces]
    stranger = refused(other, lambda i: i.fmu.setFMUstate(i.fmu.deSerializeFMUstate(data)))
    return [messages, stranger]


def absurd(fmu):
    """States with a valid checksum, in which one word of the record in turn is huge or negative."""
    import struct
    import zlib

    instance = Instance(fmu).start()
    instance.step(0.5)
    data = instance.fmu.serializeFMUstate(instance.fmu.getFMUstate())
    before, refusals = instance.get(instance.outputs), 0
    envelope, header = struct.Struct("<8sQQ"), 40 + 4 * 8
    magic, length, _ = envelope.unpack_from(data)

    def restore(content):
        state = instance.fmu.deSerializeFMUstate(
            envelope.pack(magic, length, zlib.crc32(content)) + bytes(content)
        )
        try:
            instance.fmu.setFMUstate(state)
            instance.time = 0.5
        finally:
            instance.fmu.freeFMUstate(state)

    for place in range(header, length - 7, 8 * 3):
        for number in (2**62, -5):
            content = bytearray(data[envelope.size :])
            struct.pack_into("<q", content, place, number)
            try:
                restore(content)
                instance.get(instance.outputs)
                instance.step(0.5001)
            except Exception:
                refusals += 1
            restore(data[envelope.size :])
    return [refusals, instance.get(instance.outputs) == before]


@pytest.mark.parametrize("model", ["rod_drop", "ramp"])
def test_absurd_states_with_a_valid_checksum_do_no_harm(fmus, clean, model):
    refusals, unharmed = clean(absurd, fmus[model])
    assert refusals > 5  # one word in three is looked at, and few of them are indices
    assert unharmed


def test_damaged_and_foreign_states_are_refused(fmus, clean):
    messages, stranger = clean(damaged, fmus["rod_drop"], fmus["pinned_arm"])
    assert len(messages) > 40
    assert all("the bytes are no state, or damaged" in message for message in messages)
    assert "the state is that of another FMU" in stranger


def refused_start(fmu):
    """Whether refused starts keep the bytes of the state: inside a wall, and with infinite energy."""
    found = []
    for values in ({"initial.y": -1.0}, {"initial.vx": 1e160}):
        instance = Instance(fmu)
        instance.fmu.setupExperiment(startTime=0.0)
        instance.set(values)
        instance.fmu.enterInitializationMode()

        def state(fmu=instance.fmu):
            return fmu.serializeFMUstate(fmu.getFMUstate())

        before = state()
        try:
            instance.fmu.exitInitializationMode()
        except FMICallException:
            found.append(before == state())
    return found, MESSAGES


def test_a_refused_start_leaves_the_state_as_it_was(fmus, clean):
    kept, said = clean(refused_start, fmus["rod_drop"])
    assert kept == [True, True]
    assert "a contact point starts beyond a wall" in said[0]
    assert "the state or its energy is no longer finite" in said[-1]
