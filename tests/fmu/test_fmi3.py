"""FMI 3.0: its functions one by one, event mode and arrays.

The tests of FMI 2.0 cover all common features.
"""

# Tests: fmu/model_description.py, fmu/model_bin.py

from collections import Counter
from ctypes import byref, c_bool, c_double, c_size_t, c_uint32, c_void_p

import pytest

from chain_impact import CONTACT_LAWS, load_scene, simulate
from tests.fmu.clean import calling3
from tests.fmu.interface3 import ALLOWED_PHASES, ERROR, OK, PHASES, Component, Library, calls, each_call
from tests.helpers.scenes.stops import knee_scene

RIGID = CONTACT_LAWS["newton_impact"].number

# --- instances (2.3.1) -----------------------------------------------------------------------------------


@calling3("rod_drop")
def test_an_impossible_instance_is_refused_in_one_sentence(fmu):
    import shutil

    library = Library(fmu)
    odd = library.folder / "a b+#,([%ü 'x"
    shutil.copytree(library.folder / "resources", odd)

    def refused(sentence, **changes):
        for logging in (True, False):
            assert library.instantiate(logging=logging, **changes) is None
            ((status, category, text),) = library.messages
            assert (status, category in library.categories) == (ERROR, True)
            assert sentence in text
            library.new_messages()
        assert library.instantiate(log=None, **changes) is None

    for name in (None, b" \t"):
        refused("the instance has no name", name=name)
    token = "{8c4e810f-3df3-4a00-8276-176fa3c9f9e0}"
    refused(f"instantiationToken {token} differs from that of this FMU", token=token.encode())
    refused("the argument instantiationToken is a null pointer", token=None)
    refused("the argument resourcePath is a null pointer", resources=None)
    refused("resourcePath  is no path of a folder", resources=b"")
    refused("resourcePath /not/there/ has no file model.bin that can be read", resources=b"/not/there/")
    refused("fmi3InstantiateCoSimulation: resourcePath /xxx", resources=b"/" + b"x" * 100_000)
    refused("resourcePath /a##1##%s/ has no file", resources=b"/a#1#%s/")  # the standard escapes # as ##
    intermediates = {"intermediate": byref(c_uint32(0)), "intermediates": c_size_t(1)}
    refused("no variable can be had or set during a step", **intermediates)
    for kind in ("ModelExchange", "ScheduledExecution"):
        arguments = (b"one", library.guid, str(odd).encode(), c_bool(False), c_bool(True), None, library.log)
        assert getattr(library.c, f"fmi3Instantiate{kind}")(*arguments, None, None, None) is None
        assert library.new_messages() == [f"fmi3Instantiate{kind}: this FMU is for co-simulation only"]
    for form in (str(odd), f"{odd}/"):
        assert library.instantiate(resources=form.encode())
    (library.folder / "resources" / "model.bin").write_bytes(b"x" * 300)
    refused("has a file model.bin that is damaged")
    assert library.c.fmi3GetVersion() == b"3.0"


# --- which call when (2.3, 4.2.1) ------------------------------------------------------------------------


@calling3("rod_drop")
def test_the_state_machine(fmu):
    from standard import all_functions_of_fmi3

    functions = {f"fmi3{name}" for name in calls()}
    assert functions < set(all_functions_of_fmi3())
    # three functions that create an instance, the function that frees it, and the version are exempt
    assert len(functions) == len(all_functions_of_fmi3()) - 5
    for phase, name, status, messages, unchanged in each_call(Library(fmu), Component, calls(), PHASES):
        is_allowed = phase in ALLOWED_PHASES.get(name, PHASES)
        assert status == (OK if is_allowed else ERROR), (phase, name, messages)
        assert len(messages) == (status != OK), (phase, name, messages)
        assert is_allowed or unchanged, (phase, name)


@calling3("rod_drop")
def test_null_pointers_are_refused(fmu):
    """Call functions with a null instance, and with instances in step and event mode and null arguments."""
    library = Library(fmu)
    nobody, stepping = Component(library), Component(library).start()
    in_event = Component(library).bring_to("event mode")
    nobody.free()
    nobody.address = c_void_p()
    count, nulls = c_size_t(3), [None] * 9
    pointers = {"SetDebugLogging": [c_bool(True), count, None]}
    pointers["EnterInitializationMode"] = [c_bool(False), c_double(), c_double(), c_bool(False), c_double()]
    pointers["DoStep"] = [c_double(0.0), c_double(0.1), c_bool(False), *nulls[:4]]
    for name in calls():
        arguments = pointers.get(name, [None, count, None, count, None, count, None, count, None])
        if "FMUState" in name or name == "UpdateDiscreteStates":
            arguments = nulls
        assert nobody.call(name, *arguments) == ERROR, name
        if name not in ("Reset", "Terminate", "EnterEventMode", "EnterStepMode", "FreeFMUState"):
            for instance in [in_event] if name == "UpdateDiscreteStates" else [stepping, in_event]:
                library.new_messages()
                assert (instance.call(name, *arguments), len(library.new_messages())) == (ERROR, 1), name
    library.c.fmi3FreeInstance(None)
    assert stepping.step(0.0, 0.1)[0] == stepping.call("FreeFMUState", None) == OK


@calling3("rod_drop")
def test_without_early_return_steps_are_plain(fmu):
    """Cover importers without event mode, and importers that do not allow an early return."""
    library = Library(fmu)
    for event_mode, early_return in ((False, False), (False, True), (True, False)):
        instance = Component(library, event_mode=event_mode, early_return=early_return).start()
        for k in range(16):
            assert instance.step(k * 0.0625, 0.0625) == [OK, False, False, False, (k + 1) * 0.0625]
        assert instance.get("impact.count", kind="Int64")[0] > 3
        if not event_mode:
            assert [
                instance.call("EnterEventMode"),
                instance.update()[0],
                instance.call("EnterStepMode"),
            ] == [ERROR] * 3
            reason = "the instance was made with eventModeUsed = fmi3False"
            assert library.new_messages()[0] == f"fmi3EnterEventMode cannot be called: {reason}"


# --- event mode ------------------------------------------------------------------------------------------


def stopping(fmu, size, stop):
    """Run with steps of one size that end at events, and without events. Event mode changes nothing.

    Return the events: [time, number of impacts].
    """
    library, events = Library(fmu), []
    names = [n for n in library.references if library.shapes[n] and n not in ("impact.point", "impact.wall")]
    instance, plain = Component(library).start(), Component(library, event_mode=False).start()

    def count():
        return instance.get("impact.count", kind="Int64")[0]

    time = 0.0
    for k in range(1, round(stop / size) + 1):
        while time < k * size:
            status, event_needed, ended, early, end_time = instance.step(time, k * size - time)
            assert [status, ended, early] == [OK, False, event_needed and end_time < k * size]
            assert event_needed or end_time == k * size
            time = end_time
            if event_needed:
                count_before = count()
                assert instance.call("EnterEventMode") == OK
                count_in_event = count()
                assert instance.update() == [OK, False, False, False, False, False, time]
                count_after = count()
                assert count_before == count_in_event < count_after
                assert instance.get("impact.last_time", "time") == [time, time]
                events.append([time, count_after - count_in_event])
                assert instance.update()[0] == OK  # a second update has nothing to do
                assert count() == count_after
                assert instance.call("EnterStepMode") == OK
        # the difference and the sum are exact, so that both instances have bit-equal times
        assert plain.step((k - 1) * size, k * size - (k - 1) * size)[0] == OK
        assert instance.get(*names) == plain.get(*names)
    return events


@pytest.mark.parametrize(
    ("model", "size"),
    [(model, size) for model in ("four_link_box", "rod_drop", "knee") for size in (1e-3, 1e-2, 0.1)],
)
def test_every_impact_is_an_event_and_nothing_else_changes(fmi3, run3, model, size):
    events = run3(stopping, fmi3[model], size, 2.0)
    impacts = simulate(knee_scene() if model == "knee" else load_scene(model)).impacts
    assert events == [list(item) for item in sorted(Counter(impacts["onset"].tolist()).items())]
    assert len(events) > 10 or set(impacts["wall"]) == {1, 4}


@calling3("rod_drop")
def test_a_step_that_ends_at_an_impact_is_not_early(fmu):
    library = Library(fmu)
    *_, onset = Component(library).start().step(0.0, 2.0)
    assert onset < 1.0
    assert Component(library).start().step(0.0, onset) == [OK, True, False, False, onset]


@calling3("rod_drop")
def test_parameters_set_at_an_impact_hold_for_it(fmu, rigid):
    """A rod falls flat; at each impact the test sets another restitution, and compares the speeds."""
    instance, time = Component(Library(fmu)), 0.0
    instance.start(**{"initial.angle[1]": 0.0, "contact.model": rigid, "initial.y": 0.5})
    for restitution in (0.9, 0.25, 0.6):
        _, event_needed, _, early, time = instance.step(time, 5.0)
        assert [event_needed, early, instance.call("EnterEventMode")] == [True, True, OK]
        assert instance.set("contact.restitution", restitution) == OK
        speeds_before, state = instance.get("point[0].vy", "point[1].vy"), instance.serialized()
        assert instance.update()[0] == OK
        speeds_after, state_after = instance.get("point[0].vy", "point[1].vy"), instance.serialized()
        assert instance.restore(state) == OK  # restores event mode before the impact
        assert instance.get("point[0].vy", "point[1].vy") == speeds_before
        assert instance.update()[0] == OK
        assert instance.get("point[0].vy", "point[1].vy") == speeds_after
        assert instance.serialized() == state_after
        assert instance.call("EnterStepMode") == OK
        assert speeds_before[0] < 0.0
        for speed_before, speed_after in zip(speeds_before, speeds_after, strict=True):
            assert abs(speed_after + restitution * speed_before) < 1e-12 * abs(speed_after)


@pytest.fixture
def rigid():
    return RIGID


@calling3("pinned_arm")
def test_an_input_can_be_set_at_an_impact(fmu):
    """The input is set in event mode, and in step mode just after the impact."""
    rows = []
    for mode in ("event", "step"):
        instance = Component(Library(fmu)).start()
        _, event_needed, _, _, time = instance.step(0.0, 2.0)
        assert [event_needed, instance.call("EnterEventMode")] == [True, OK]
        if mode == "event":
            assert instance.set("joint[1].torque", 2.0) == OK
        assert [instance.update()[0], instance.call("EnterStepMode")] == [OK, OK]
        if mode == "step":
            assert instance.set("joint[1].torque", 2.0) == OK
        while time < 2.0:
            _, event_needed, _, _, time = instance.step(time, 2.0 - time)
            if event_needed:
                assert [
                    instance.call("EnterEventMode"),
                    instance.update()[0],
                    instance.call("EnterStepMode"),
                ] == [OK] * 3
        rows.append(instance.get("point.position", "energy.supplied"))
    assert abs(rows[0][-1]) > 0.1
    assert max(abs(a - b) for a, b in zip(*rows, strict=True)) < 1e-7


# --- variables (2.2.6.2) ---------------------------------------------------------------------------------


@calling3("four_link_box")
def test_arrays_have_the_values_of_their_elements(fmu):
    library = Library(fmu)
    instance = Component(library, early_return=False).start()
    instance.step(0.0, 0.7)

    def elements(pattern, numbers, axes=("",)):
        return [instance.get(pattern.format(k, axis))[0] for k in numbers for axis in axes]

    names = ("point.position", "impact.time", "contact.force")
    assert [library.shapes[name] for name in names] == [[5, 2], [8], [20]]
    for name, short in (("position", ""), ("velocity", "v"), ("acceleration", "a")):
        assert instance.get(f"point.{name}") == elements(f"point[{{}}].{short}{{}}", range(5), "xy")
    assert instance.get("link.angle") == elements("link[{}].angle", range(1, 5))
    assert instance.get("time", "point.position") == [0.7, *instance.get("point.position")]
    assert len(instance.get("impact.wall", kind="Int64")) == 8
    assert instance.get("point.position", length=9) == ERROR
    assert instance.get("point.position", "time", length=12) == ERROR
    reference = c_uint32(library.references["point.position"])
    assert (
        instance.call("SetFloat64", byref(reference), c_size_t(1), (c_double * 10)(), c_size_t(10)) == ERROR
    )
    assert instance.set("time", 1.0) == ERROR
    too_few, too_many, _, independent = library.new_messages()
    assert too_few == "fmi3GetFloat64: the variables have 10 values, but 9 are given"
    assert too_many == "fmi3GetFloat64: the variables have 11 values, but 12 are given"
    assert "time is the independent variable and cannot be set in step mode" in independent


@calling3("rod_drop")
def test_integers_have_64_bits(fmu):
    """Set an enumeration to a value that only 64 bits can hold."""
    instance = Component(Library(fmu))
    assert instance.set("contact.model", 2**33 + 1) == ERROR
    assert "contact.model = 8589934593 must be one of 1 (hertz)" in instance.library.new_messages()[0]


@calling3("pinned_arm")
def test_the_time_can_be_read_in_every_state(fmu):
    for phase in PHASES:
        (time,) = Component(Library(fmu)).bring_to(phase).get("time")
        assert time == 0.0 or phase in ("step mode", "step failed", "terminated")
    instance = Component(Library(fmu))
    instance.enter(start=2.5)
    assert instance.get("time") == [2.5]
