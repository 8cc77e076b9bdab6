"""States of an FMU: saved, restored, and refused if damaged or foreign."""

# Tests: fmu/model_bin.py

import pytest

from tests.fmu.clean import importing
from tests.fmu.importer import MESSAGES, FMICallException, Instance, refused

# All tests here run in the clean process, by the decorator importing().


@pytest.mark.full("more cases", but=2)
@pytest.mark.parametrize(
    ("model", "save_at"),
    [
        *(("four_link_box", time) for time in (0.3, 0.5)),
        *(("thrown", time) for time in (0.25, 1.25)),  # sliding, sticking
        ("servo", 0.25),  # a torque at its limit
        ("rod_drop", "contact[0].y_min.force"),
        ("ramp", "contact[0].ramp.force"),
    ],
)
@importing()
def test_a_saved_state_goes_on_to_the_last_bit(fmu, save_at):
    """The state is restored in the same instance and in an uninitialized instance.

    Both continue like a run without saving.
    """
    first, second, never = Instance(fmu).start(), Instance(fmu), Instance(fmu).start()
    in_contact = isinstance(save_at, str)
    for instance in (first, never):
        while in_contact and not instance[save_at]:
            instance.step(instance.time + 2e-4)
        if not in_contact:
            instance.step(save_at)
    start, step = first.time, 1e-5 if in_contact else 0.01
    state = first.fmu.getFMUstate()
    data = first.fmu.serializeFMUstate(state)
    assert len(data) > 1000

    def go_on(instance):
        instance.time = start
        return [instance.get(instance.outputs), *instance.run([start + step * i for i in range(1, 51)])]

    outputs = go_on(first)
    first.fmu.setFMUstate(state)
    assert go_on(first) == outputs
    first.fmu.freeFMUstate(state)
    copy = second.fmu.deSerializeFMUstate(data)
    second.fmu.setFMUstate(copy)
    assert go_on(second) == go_on(never) == outputs


@importing("rod_drop")
def test_a_state_can_be_saved_before_initialization(fmu):
    instance = Instance(fmu)
    instance.set({"initial.y": 0.75})
    state = instance.fmu.getFMUstate()
    instance.set({"initial.y": 1.0})
    instance.start()
    instance.step(0.1)
    instance.fmu.setFMUstate(state)
    assert instance["initial.y"] == 0.75
    instance.start()
    assert instance["point[0].y"] == 0.75


@importing("rod_drop", "pinned_arm")
def test_damaged_and_foreign_states_are_refused(fmu, second_fmu):
    instance = Instance(fmu).start()
    data = instance.fmu.serializeFMUstate(instance.fmu.getFMUstate())
    # changes in the envelope, in the head of the content, and at places of the record
    places = [*range(0, 96, 4), *range(96, len(data), len(data) // 16), len(data) - 1]
    pieces = [data[:place] + bytes([data[place] ^ 1]) + data[place + 1 :] for place in places]
    pieces += [data[:-8], data + b"12345678", b"", b"nonsense", data[:24], bytes(len(data))]
    for piece in pieces:
        text = refused(fmu, lambda i, piece=piece: i.fmu.deSerializeFMUstate(piece))
        assert "the bytes are no state, or damaged" in text
    text = refused(second_fmu, lambda i: i.fmu.setFMUstate(i.fmu.deSerializeFMUstate(data)))
    assert "the state is that of another FMU" in text


@importing("rod_drop")
def test_a_state_of_other_sizes_is_refused_although_its_checksum_is_right(fmu):
    import zlib  # in the clean process a function has its own imports only

    instance = Instance(fmu).start()
    data = instance.fmu.serializeFMUstate(instance.fmu.getFMUstate())
    for word in range(11):  # the sizes at the start of the record
        changed_state = bytearray(data)
        changed_state[96 + 8 * word] += 1
        changed_state[16:24] = zlib.crc32(changed_state[24:]).to_bytes(8, "little")
        state = bytes(changed_state)
        text = refused(fmu, lambda i, state=state: i.fmu.setFMUstate(i.fmu.deSerializeFMUstate(state)))
        assert "the state is damaged" in text


@importing("rod_drop")
def test_a_refused_start_leaves_the_state_as_it_was(fmu):
    """The start is refused for a point inside a wall, and for infinite energy."""
    for values, reason in (
        ({"initial.y": -1.0}, "a contact point starts beyond a wall"),
        ({"initial.vx": 1e160}, "the state or its energy is not finite"),
    ):
        instance = Instance(fmu)
        instance.fmu.setupExperiment(startTime=0.0)
        instance.set(values)
        instance.fmu.enterInitializationMode()
        state = instance.fmu.serializeFMUstate(instance.fmu.getFMUstate())
        try:
            instance.fmu.exitInitializationMode()
        except FMICallException:
            assert state == instance.fmu.serializeFMUstate(instance.fmu.getFMUstate())
        else:
            raise AssertionError(values)
        assert reason in MESSAGES[-1]
