"""FMI 3.0: its functions one by one, event mode and arrays.

What it has in common with FMI 2.0 is tested with that.
"""

from collections import Counter
from ctypes import byref, c_bool, c_double, c_size_t, c_uint32, c_void_p

import numpy as np
import pytest

from chain_impact import CONTACT_LAWS, load_scene, simulate
from chain_impact.fmu.build import build_fmu
from tests.fmu.conftest import KINDS
from tests.fmu.interface3 import ERROR, NEVER, OK, PHASES, Component, Library, calls, each_call
from tests.fmu.standard import all_functions_of_fmi3
from tests.shared import once, shared_folder
from tests.stops import knee

# The functions before each test run in the clean process, with all that interface3.py has.


# --- instances (2.3.1) -----------------------------------------------------------------------------------


def not_instantiated(fmu):
    import shutil

    library = Library(fmu)
    folder = library.folder / "resources"
    odd = library.folder / "a b+#,([%ü 'x"
    shutil.copytree(folder, odd)
    reference = c_uint32(0)
    cases = {
        "no name": {"name": None},
        "blank name": {"name": b" \t"},
        "another token": {"token": b"{8c4e810f-3df3-4a00-8276-176fa3c9f9e0}"},
        "no token": {"token": None},
        "no folder": {"resources": None},
        "empty folder": {"resources": b""},
        "missing folder": {"resources": b"/not/there/"},
        "endless folder": {"resources": b"/" + b"x" * 100_000},
        "intermediate variables": {"intermediate": byref(reference), "intermediates": c_size_t(1)},
    }
    found = {}
    for case, changes in cases.items():
        for logging in (True, False):
            assert library.instantiate(logging=logging, **changes) is None
            found[f"{case}, logging {logging}"] = library.messages[:]
            library.messages.clear()
        assert library.instantiate(log=None, **changes) is None
    (library.folder / "resources" / "model.bin").write_bytes(b"x" * 200)
    assert library.instantiate() is None
    found["damaged"] = library.messages[:]
    library.messages.clear()
    kinds = {}
    for kind in ("ModelExchange", "ScheduledExecution"):
        arguments = (b"one", library.guid, str(odd).encode(), c_bool(False), c_bool(True), None, library.log)
        assert getattr(library.c, f"fmi3Instantiate{kind}")(*arguments, None, None, None) is None
        kinds[kind] = library.said()
    forms = [bool(library.instantiate(resources=form.encode())) for form in (str(odd), f"{odd}/")]
    return [found, library.categories, kinds, forms, library.c.fmi3GetVersion().decode()]


def test_what_cannot_be_instantiated_is_refused_in_one_sentence(fmi3, run3):
    found, categories, kinds, forms, version = run3(not_instantiated, fmi3["rod_drop"])
    expected = {
        "no name": "the instance has no name",
        "blank name": "the instance has no name",
        "another token": "instantiationToken {8c4e810f-3df3-4a00-8276-176fa3c9f9e0} is not that of this FMU",
        "no token": "the argument instantiationToken is a null pointer",
        "no folder": "the argument resourcePath is a null pointer",
        "empty folder": "resourcePath  is no path of a folder",
        "missing folder": "resourcePath /not/there/ has no file model.bin that can be read",
        "endless folder": "fmi3InstantiateCoSimulation: resourcePath /xxx",
        "intermediate variables": "no variable can be had or set during a step",
        "damaged": "has a file model.bin that is damaged",
    }
    assert {case.split(", logging")[0] for case in found} == expected.keys()
    for case, messages in found.items():
        ((status, category, text),) = messages
        assert status == ERROR
        assert category in categories
        assert expected[case.split(", logging")[0]] in text
    for kind, texts in kinds.items():
        assert texts == [f"fmi3Instantiate{kind}: this FMU is for co-simulation only"]
    assert forms == [True, True]
    assert version == "3.0"


# --- which call when (2.3, 4.2.1) ------------------------------------------------------------------------

ALWAYS = set(PHASES)
SETTING = ALWAYS - {"step failed", "terminated"}
ALLOWED = {
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
"""The state machine; all else can be called at any time: of types that no variable has, for nothing."""


def every_call(fmu, phases):
    return each_call(Library(fmu), Component, calls(), phases)


def test_the_state_machine(fmi3, run3):
    found = run3(every_call, fmi3["rod_drop"], PHASES)
    without_instance = 5  # three to make one, one to free it, one that tells the version
    assert len(found) == len(PHASES) * (len(all_functions_of_fmi3()) - without_instance)
    assert {f"fmi3{name}" for _, name, *_ in found} < set(all_functions_of_fmi3())
    for phase, name, status, messages, unchanged in found:
        allowed = phase in ALLOWED.get(name, ALWAYS)
        assert (status == OK) == allowed, (phase, name, messages)
        assert status in (OK, ERROR)
        assert len(messages) == (status != OK), (phase, name, messages)
        assert allowed or unchanged, (phase, name)


def null_pointers(fmu):
    """Every function without an instance; and with one in each mode, but without anything else."""
    library = Library(fmu)
    nobody, stepping, in_event = Component(library), Component(library).start(), Component(library)
    in_event.bring_to("event mode")
    nobody.free()
    nobody.address = c_void_p()
    some, nothing = c_size_t(3), [None] * 9
    pointers = {"SetDebugLogging": [c_bool(True), some, None]}
    pointers["EnterInitializationMode"] = [c_bool(False), c_double(), c_double(), c_bool(False), c_double()]
    pointers["DoStep"] = [c_double(0.0), c_double(0.1), c_bool(False), *nothing[:4]]
    skipped = ("Reset", "Terminate", "EnterEventMode", "EnterStepMode", "FreeFMUState")
    without, alone = {}, {}
    for name in calls():
        found = pointers.get(name, [None, some, None, some, None, some, None, some, None])
        if "FMUState" in name or name == "UpdateDiscreteStates":
            found = nothing
        without[name] = nobody.call(name, *found)
        if name not in skipped:
            library.said()
            instances = [in_event] if name == "UpdateDiscreteStates" else [stepping, in_event]
            alone[name] = [one.call(name, *found) for one in instances]
            alone[name].append(len(library.said()))
    library.c.fmi3FreeInstance(None)
    return [without, alone, stepping.step(0.0, 0.1)[0], stepping.call("FreeFMUState", None)]


def test_null_pointers_are_refused(fmi3, run3):
    without, alone, after, freed = run3(null_pointers, fmi3["rod_drop"])
    assert set(without.values()) == {ERROR}
    for name, (*statuses, messages) in alone.items():
        assert set(statuses) == {ERROR}, name
        assert messages == len(statuses), name
    assert after == freed == OK


def modes(fmu):
    """An importer that does not use event mode; and one that does not allow an early return."""
    library, found = Library(fmu), {}
    for event_mode, early_return in ((False, False), (False, True), (True, False)):
        one = Component(library, event_mode=event_mode, early_return=early_return).start()
        rows = [one.step(k * 0.0625, 0.0625) for k in range(16)]
        calls = []
        if not event_mode:
            calls = [one.call("EnterEventMode"), one.update()[0], one.call("EnterStepMode")]
        said, count = library.said()[:1], one.get("impact.count", kind="Int64")
        found[f"{event_mode}, {early_return}"] = [rows, calls, said, count]
    return found


def test_without_early_return_steps_are_plain(fmi3, run3):
    for case, (rows, statuses, texts, count) in run3(modes, fmi3["rod_drop"]).items():
        assert rows == [[OK, False, False, False, (k + 1) * 0.0625] for k in range(16)], case
        assert count[0] > 3
        if case.startswith("False"):
            assert statuses == [ERROR] * 3
            assert texts == [
                "fmi3EnterEventMode cannot be called: the instance was made with eventModeUsed = fmi3False"
            ]


# --- event mode ------------------------------------------------------------------------------------------


def stopping(fmu, size, stop):
    """Steps of one size, ended by events; in event mode nothing is changed. And the same without events."""
    library = Library(fmu)
    names = [n for n in library.references if library.shapes[n] and n not in ("impact.point", "impact.wall")]
    one, plain = Component(library).start(), Component(library, event_mode=False).start()
    time, events, equal = 0.0, [], True
    for k in range(1, round(stop / size) + 1):
        while time < k * size:
            status, needed, ended, early, reached = one.step(time, k * size - time)
            assert [status, ended, early] == [OK, False, needed and reached < k * size]
            assert needed or reached == k * size
            time = reached
            if needed:
                before = one.get("impact.count", kind="Int64")[0]
                assert one.call("EnterEventMode") == OK
                left = one.get("impact.count", kind="Int64")[0]
                assert one.update() == [OK, False, False, False, False, False, time]
                right = one.get("impact.count", kind="Int64")[0]
                assert before == left < right
                events.append([time, right - left, *one.get("impact.last_time", "time")])
                assert one.update()[0] == OK  # once more: nothing is left to do
                assert one.get("impact.count", kind="Int64")[0] == right
                assert one.call("EnterStepMode") == OK
        # such a difference is exact, and so is the sum, so that both stand at the same bits of a time
        assert plain.step((k - 1) * size, k * size - (k - 1) * size)[0] == OK
        equal = equal and one.get(*names) == plain.get(*names)
    return [events, equal]


@pytest.mark.parametrize("size", [1e-3, 1e-2, 0.1])
@pytest.mark.parametrize("model", ["four_link_box", "rod_drop"])
def test_every_impact_is_an_event_and_nothing_else_changes(fmi3, run3, model, size):
    events, equal = run3(stopping, fmi3[model], size, 2.0)
    expected = Counter(simulate(load_scene(model)).impacts["onset"].tolist())
    assert len(expected) > 10
    assert [[time, count] for time, count, *_ in events] == [list(item) for item in sorted(expected.items())]
    assert all(time == last == now for time, _, last, now in events)
    assert equal


def changed_at_impacts(fmu, law):
    """A rod that falls flat; at each impact another restitution, and the speeds before and after it."""
    library = Library(fmu)
    one = Component(library).start(**{"initial.angle[1]": 0.0, "contact.model": law, "initial.y": 0.5})
    time, found = 0.0, []
    for restitution in (0.9, 0.25, 0.6):
        _, needed, _, early, time = one.step(time, 5.0)
        assert needed
        assert early
        assert one.call("EnterEventMode") == OK
        assert one.set("contact.restitution", restitution) == OK
        left = one.get("point[0].vy", "point[1].vy")
        state = one.serialized()
        assert one.update()[0] == OK
        right = one.get("point[0].vy", "point[1].vy")
        after = one.serialized()
        assert one.restore(state) == OK  # in event mode, before the impact
        assert one.get("point[0].vy", "point[1].vy") == left
        assert one.update()[0] == OK
        assert one.get("point[0].vy", "point[1].vy") == right
        assert one.serialized() == after
        assert one.call("EnterStepMode") == OK
        found.append([restitution, left, right])
    return found


def test_parameters_set_at_an_impact_hold_for_it(fmi3, run3):
    law = CONTACT_LAWS["newton_impact"].number
    for restitution, left, right in run3(changed_at_impacts, fmi3["rod_drop"], law):
        assert left[0] < 0.0
        np.testing.assert_allclose(right, -restitution * np.array(left), rtol=1e-12)


@pytest.fixture(scope="module")
def stopped(tmp_path_factory):
    """The FMU of an arm whose knee has stops, and whose tip can touch a wall."""
    folder = shared_folder(tmp_path_factory, "stops") / "fmi3"
    (fmu,) = once(folder, lambda folder: build_fmu(knee(), folder, **KINDS["fmi3"])).glob("*.fmu")
    return str(fmu)


@pytest.mark.parametrize("size", [1e-3, 0.1])
def test_every_impact_at_a_stop_is_an_event(stopped, run3, size):
    events, equal = run3(stopping, stopped, size, 2.0)
    impacts = simulate(knee()).impacts
    assert set(impacts["wall"]) == {1, 4}
    assert [time for time, *_ in events] == sorted(impacts["onset"])
    assert all(count == 1 and time == last == now for time, count, last, now in events)
    assert equal


def changed_at_stops(fmu, law):
    """At the first impact of the knee another restitution of stops, and the rates before and after it."""
    library, found = Library(fmu), []
    rates = [f"link[{i}].angular_velocity" for i in (1, 2)]
    for restitution in (0.9, 0.25):
        one = Component(library).start(**{"contact.model": law})
        _, needed, _, early, time = one.step(0.0, 2.0)
        assert [needed, early, one.get("impact.count", kind="Int64")] == [True, True, [0]]
        assert [one.call("EnterEventMode"), one.set("stop.restitution", restitution)] == [OK, OK]
        left = one.get(*rates)
        assert one.update() == [OK, False, False, False, False, False, time]
        assert one.get("impact.count", "impact.last_point", kind="Int64") == [1, 2]
        found.append([restitution, left, one.get(*rates), one.get("impact.last_speed")[0]])
        assert [one.call("EnterStepMode"), one.step(time, 0.01)[0]] == [OK, OK]
    return found


def test_parameters_set_at_an_impact_of_a_stop_hold_for_it(stopped, run3):
    law = CONTACT_LAWS["newton_impact"].number
    for restitution, left, right, speed in run3(changed_at_stops, stopped, law):
        assert left[1] - left[0] == pytest.approx(-speed, rel=1e-12)
        assert right[1] - right[0] == pytest.approx(restitution * speed, rel=1e-12)


def torque_at_impact(fmu):
    """An input that is set in event mode, and one that is set in step mode just after it."""
    library, rows = Library(fmu), []
    for mode in ("event", "step"):
        one = Component(library).start()
        _, needed, _, _, time = one.step(0.0, 2.0)
        assert needed
        assert one.call("EnterEventMode") == OK
        if mode == "event":
            assert one.set("joint[1].torque", 2.0) == OK
        assert one.update()[0] == OK
        assert one.call("EnterStepMode") == OK
        if mode == "step":
            assert one.set("joint[1].torque", 2.0) == OK
        while time < 2.0:
            _, needed, _, _, time = one.step(time, 2.0 - time)
            if needed:
                assert [one.call("EnterEventMode"), one.update()[0], one.call("EnterStepMode")] == [OK] * 3
        rows.append(one.get("point.position", "energy.supplied"))
    return rows


def test_an_input_can_be_set_at_an_impact(fmi3, run3):
    at_event, after = run3(torque_at_impact, fmi3["pinned_arm"])
    assert abs(at_event[-1]) > 0.1
    np.testing.assert_allclose(at_event, after, rtol=0, atol=1e-7)


# --- variables (2.2.6.2) ---------------------------------------------------------------------------------


def arrays(fmu):
    """Each array and its elements; and what is refused."""
    library = Library(fmu)
    one = Component(library, early_return=False).start()
    one.step(0.0, 0.7)
    found = {}
    for name, shape in library.shapes.items():
        if shape:
            kind = "Int64" if name in ("impact.point", "impact.wall") else "Float64"
            found[name] = [shape, one.get(name, kind=kind)]
    first = library.references["point[0].x"]
    names = [name for name, reference in library.references.items() if reference >= first]
    scalars = {name: one.get(name)[0] for name in names if name.startswith(("point[", "link["))}
    library.said()
    wrong = [one.get("point.position", length=9), one.get("point.position", "time", length=12)]
    cells = (c_double * 10)()
    reference = c_uint32(library.references["point.position"])
    wrong.append(one.call("SetFloat64", byref(reference), c_size_t(1), cells, c_size_t(10)))
    wrong.append(one.set("time", 1.0))
    return [found, scalars, wrong, library.said(), one.get("time", "point.position")]


def test_arrays_have_the_values_of_their_elements(fmi3, run3):
    found, scalars, wrong, texts, both = run3(arrays, fmi3["four_link_box"])
    assert found["point.position"][0] == [5, 2]
    assert found["impact.time"][0] == [8]
    assert found["contact.force"][0] == [20]
    for name, short in (("position", ""), ("velocity", "v"), ("acceleration", "a")):
        elements = [scalars[f"point[{k}].{short}{axis}"] for k in range(5) for axis in "xy"]
        assert found[f"point.{name}"][1] == elements
    assert found["link.angle"][1] == [scalars[f"link[{i}].angle"] for i in range(1, 5)]
    assert both == [0.7, *found["point.position"][1]]
    assert wrong == [ERROR] * 4
    assert texts[0] == "fmi3GetFloat64: the variables have 10 values, and there are 9"
    assert texts[1] == "fmi3GetFloat64: the variables have 11 values, and there are 12"
    assert "time is the independent variable and cannot be set in step mode" in texts[3]


def large_integers(fmu):
    """A choice that only 64 bits can hold, and a # in a message."""
    library = Library(fmu)
    one = Component(library)
    found = [one.set("contact.model", 2**33 + 1), *library.said()]
    library.instantiate(resources=b"/a#1#%s/")
    return [*found, *library.said()]


def test_integers_have_64_bits_and_messages_escape_what_the_standard_says(fmi3, run3):
    status, text, path = run3(large_integers, fmi3["rod_drop"])
    assert status == ERROR
    assert "contact.model = 8589934593 must be one of 1 (hertz)" in text
    assert "resourcePath /a##1##%s/ has no file" in path
