"""The use of the FMU in a process with an importer and without this package, and its refusals there."""

import numpy as np
import pytest
from fmpy import read_model_description

from chain_impact import CONTACT_LAWS, Chain, cli, load_scene, simulate
from chain_impact.fmu.run import record_fmu
from tests.fmu.clean import importing
from tests.fmu.conftest import scene_of
from tests.fmu.importer import MESSAGES, FMICallException, Instance, refused
from tests.helpers.derived_scenes import FINGER, PARAMETER_CHANGES, edited, finger

STEP = 2.0**-7  # s; sums of this step are exact, so that all clocks are bit-equal
STOPS = {"knee": 2.0, "thrown": 1.5, "finger": 0.75, "servo": 1.0}  # s; 1 s for all others
RIGID = CONTACT_LAWS["newton_impact"].number

# The functions without assertions, and those for importing(), run in the clean process.


# --- parameters ------------------------------------------------------------------------------------------

TUNED = {
    "knee": (0.5, {"stop.restitution": 0.9, "stop.stiffness": 3e4, "wall.x_max.restitution": 0.75}),
    "thrown": (0.25, {"wall.y_min.friction": 0.05, "contact.restitution": 0.1}),
    "servo": (0.5, {"link[1].joint_stiffness": 40.0, "link[2].joint_damping": 0.0}),
}
"""Scene → time [s], after the first impact or during a sliding contact, and the values set then."""
CASES = [
    *(("finger", changes) for changes in PARAMETER_CHANGES),
    ("four_link_box", {"contact.model": "flores", "contact.restitution": 0.5}),
    ("four_link_box", {"contact.model": "newton_impact"}),
    ("four_link_box", {"contact.stiffness": 1e6}),
    ("four_link_box", {"initial.x": 1.25, "initial.angle[1]": 1.0}),
    ("four_link_box", {"initial.vy": 3.0, "initial.angular_velocity[4]": 5.0}),
    ("four_link_box", {"solver.tolerance": 1e-5}),
    ("four_link_box", {"gravity.y": -20.0, "box.x_max": 2.75, "link[2].mass": 3.0, "contact.exponent": 1.25}),
    ("ramp", {"wall.ramp.angle": -0.4, "wall.ramp.y": -0.3}),
    ("ramp", {"wall.stop.x": -0.2, "contact.radius": 0.02}),
    ("ramp", {"contact.model": "newton_impact", "wall.ramp.x": -0.1}),
    *((model, {}) for model in ("four_link_box", "ramp", "knee", "thrown")),
    ("knee", {"link[2].joint_min": 0.25, "stop.exponent": 2.0}),
    ("thrown", {"link[2].joint_friction": 0.5, "contact.static_friction": 0.6}),
    *((model, values) for model, (_, values) in TUNED.items()),
]


def trajectory(fmu, values, stop, step):
    instance = Instance(fmu).start(**values)
    times = [i * step for i in range(round(stop / step) + 1)]
    return [instance.outputs, instance.run(times)]


@pytest.mark.full("more cases", but=12)
@pytest.mark.parametrize(("model", "values"), CASES, ids=str)
def test_parameters_act_as_they_do_in_the_scene(fmus, clean, model, values):
    stop = STOPS.get(model, 1.0)
    scene = edited(FINGER, values) if model == "finger" else scene_of(model).with_values(values)
    result = simulate(scene, stop, STEP)
    laws = {name: CONTACT_LAWS[law].number for name, law in values.items() if name == "contact.model"}
    names, rows = clean(trajectory, fmus[model], values | laws, stop, STEP)
    found = dict(zip(names, np.transpose(rows), strict=True))
    # the FMU and the scene use the same machine code
    for name, column in result.prepared.series(result.outputs).items():
        np.testing.assert_array_equal(found[name], column, err_msg=name)
    for name in ("steps", "rejected_steps", "rhs_evaluations", "implicit_steps", "status"):
        assert found[f"solver.{name}"][-1] == result.statistics[name]
    last = result.impacts[-1]
    assert found["impact.count"][-1] == len(result.impacts)
    shown = [found[f"impact.last_{name}"][-1] for name in ("time", "point", "wall", "speed")]
    assert shown == [*last[["onset", "point"]], last["wall"] + 1, last["impact_speed"]]
    if model == "thrown":
        assert set(found["joint[2].sticking"]) == {0, 1}
        assert found["energy.friction"][-1] > 0.1


def tuned(fmu, at, values, stop, step):
    one = Instance(fmu).start()
    one.run([step * i for i in range(1, round(at / step) + 1)])
    one.set(values)
    return [one.outputs, one.run([step * i for i in range(round(at / step) + 1, round(stop / step) + 1)])]


@pytest.mark.parametrize("model", TUNED)
def test_what_is_tunable_can_be_set_between_steps(fmus, clean, model):
    (at, values), stop = TUNED[model], STOPS[model]
    names, rows = clean(tuned, fmus[model], at, values, stop, STEP)
    chain, never = Chain(scene_of(model)), Chain(scene_of(model))
    chain.step_to(at)
    chain.set(values)
    chain.step_to(stop)
    never.step_to(stop)
    found = dict(zip(names, np.transpose(rows), strict=True))
    for name in found.keys() - {name for name in found if name.startswith("solver.")}:
        assert found[name][-1] == chain.get(name), name
    assert found["point[2].x"][-1] != never.get("point[2].x")


@importing("rod_drop")
def test_outputs_follow_parameters_in_initialization_mode(fmu, height):
    instance = Instance(fmu)
    instance.fmu.setupExperiment(startTime=0.0)
    instance.fmu.enterInitializationMode()
    names = ["point[0].y", "energy.potential", "impact.last_point", "solver.status"]
    before = instance.get(names)
    instance.set({"initial.y": 0.5})
    after = instance.get(names)
    instance.fmu.exitInitializationMode()
    assert before[0] == height
    assert after == instance.get(names)
    assert [after[0], *after[2:]] == [0.5, -1, 0]
    assert abs(after[1] - before[1] - 0.5 * 9.81 * (after[0] - height)) < 1e-12


@pytest.fixture
def height():
    return load_scene("rod_drop").initial.position[1]


# --- what a scene derives follows the parameters until it is set -------------------------------------------

DERIVED = ["link[1].center_of_mass", "link[1].inertia", "link[2].center_of_mass"]
DERIVED += ["stop.exponent", "stop.restitution"]


def values_of(scene):
    return [scene.values[name] for name in DERIVED]


def shown(fmu, changes, names, when):
    """Return the parameters before any is set, after the changes, and after initialization."""
    one = Instance(fmu)
    told = [one.get(names)]
    one.fmu.setupExperiment(startTime=0.0)
    if when == "before":
        one.set(changes)
        if one.get(changes) != list(changes.values()):
            raise AssertionError(one.get(changes))
    one.fmu.enterInitializationMode()
    if when == "in":
        one.set(changes)
    told.append(one.get(changes))
    one.fmu.exitInitializationMode()
    told.append(one.get(names))
    one.fmu.terminate()
    one.fmu.reset()
    told.append(one.get(names))
    return told


@pytest.mark.full("more cases", but=12)
@pytest.mark.parametrize("when", ["before", "in"])
@pytest.mark.parametrize("changes", PARAMETER_CHANGES, ids=str)
def test_the_value_in_use_is_shown(fmus, clean, changes, when):
    start, given, in_use, again = clean(shown, fmus["finger"], changes, DERIVED, when)
    assert start == again == values_of(finger())
    assert given == list(changes.values())
    assert in_use == values_of(edited(FINGER, changes))


@importing("finger")
def test_a_parameter_that_is_set_to_the_value_it_shows_is_set(fmu):
    one, name = Instance(fmu), "link[1].inertia"
    before = one[name]
    one.set({name: before})
    assert one.start(**{"link[1].length": 0.55})[name] == before


def test_a_recording_has_the_parameters_in_use(fmus):
    found = record_fmu(fmus["finger"], {"link[1].length": 0.55, "simulation.stop_time": 0.01})
    assert [found.parameters[name] for name in DERIVED] == values_of(edited(FINGER, {"link[1].length": 0.55}))
    assert "link[1].inertia" not in found.columns
    found = record_fmu(fmus["knee"], {"link[2].joint_max": 2.5})
    assert (found.stops[2].low, found.stops[2].high, found.stops[2].length) == (0.0, 2.5, 0.5)
    first = found.impacts[0]
    assert (first["point"], found.wall_names[first["wall"]]) == (2, "joint_min")
    assert found.end_speeds[0] == 0.5 * first["impact_speed"]


def test_the_description_tells_what_is_derived(fmus):
    found = {v.name: v.description for v in read_model_description(fmus["finger"]).modelVariables}
    assert {name for name, text in found.items() if text and "; unless set: " in text} == set(DERIVED)
    assert found["link[1].inertia"].endswith("; unless set: mass * length^2 / 12")


@importing("four_link_box")
def test_counts_and_codes_are_those_of_the_time_whatever_is_read_first(fmu):
    codes = [*(f"impact[{k}].{what}" for k in (1, 2) for what in ("point", "wall")), "impact.count"]
    codes_first, reals_first = Instance(fmu).start(), Instance(fmu).start()
    for time in (0.3, 0.6, 0.9, 1.2):
        codes_first.step(time)
        reals_first.step(time)
        found = codes_first.get(codes)
        assert reals_first["energy.total"] == codes_first["energy.total"]
        assert found == reals_first.get(codes)
    assert codes_first["impact.count"] > 3


# --- communication points --------------------------------------------------------------------------------


@importing("four_link_box")
def test_steps_of_any_size_from_any_start(fmu):
    """Also test a start time that is not 0."""
    import random

    even, uneven = Instance(fmu).start(start_time=5.0), Instance(fmu).start(start_time=5.0)
    chance = random.Random(1)
    while uneven.time < 6.0:
        uneven.step(min(6.0, uneven.time + chance.choice([1e-6, 1e-3, 0.03, 0.2])))
    even.step(6.0)
    for one, other in zip(even.get(even.outputs), uneven.get(even.outputs), strict=True):
        assert abs(one - other) <= 1e-9 * (1.0 + abs(one))
    assert 5.0 < even["impact.last_time"] < 6.0


@pytest.mark.parametrize("model", ["pushed_leg", "pushed_rigid_arm"])
@importing()
def test_a_trial_moves_only_what_is_declared_and_leaves_no_trace(fmu):
    """An importer sets a value, reads outputs and resets the value.

    The run continues as without the trial.
    """
    import fmpy

    description = fmpy.read_model_description(fmu)
    parameter = next(v.name for v in description.modelVariables if v.name.endswith(".restitution"))
    outputs = [one for one in description.outputs if not one.variable.dimensions]
    # no input acts at once on these outputs
    held = [one.variable.name for one in outputs if not one.dependencies]
    assert held
    one, two = Instance(fmu).start(), Instance(fmu).start()
    for k in range(1, 17):
        for instance in (one, two):
            instance.step(k * 0.0625)
        before = one.get(held)
        one.set({"tip.force.x": 3.0, parameter: 0.6})
        one.get(one.outputs)
        one.set({parameter: two[parameter]})
        assert one.get(held) == before
        one.set({"tip.force.x": 0.0})
        assert one.get(one.outputs) == two.get(two.outputs)


# --- states ----------------------------------------------------------------------------------------------


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
    one, two, never = Instance(fmu).start(), Instance(fmu), Instance(fmu).start()
    in_contact = isinstance(save_at, str)
    for instance in (one, never):
        while in_contact and not instance[save_at]:
            instance.step(instance.time + 2e-4)
        if not in_contact:
            instance.step(save_at)
    start, step = one.time, 1e-5 if in_contact else 0.01
    state = one.fmu.getFMUstate()
    data = one.fmu.serializeFMUstate(state)
    assert len(data) > 1000

    def go_on(instance):
        instance.time = start
        return [instance.get(instance.outputs), *instance.run([start + step * i for i in range(1, 51)])]

    first = go_on(one)
    one.fmu.setFMUstate(state)
    assert go_on(one) == first
    one.fmu.freeFMUstate(state)
    copy = two.fmu.deSerializeFMUstate(data)
    two.fmu.setFMUstate(copy)
    assert go_on(two) == go_on(never) == first


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
def test_damaged_and_foreign_states_are_refused(fmu, other):
    one = Instance(fmu).start()
    data = one.fmu.serializeFMUstate(one.fmu.getFMUstate())
    # changes in the envelope, in the head of the content, and at places of the record
    places = [*range(0, 96, 4), *range(96, len(data), len(data) // 16), len(data) - 1]
    pieces = [data[:place] + bytes([data[place] ^ 1]) + data[place + 1 :] for place in places]
    pieces += [data[:-8], data + b"12345678", b"", b"nonsense", data[:24], bytes(len(data))]
    for piece in pieces:
        text = refused(fmu, lambda i, piece=piece: i.fmu.deSerializeFMUstate(piece))
        assert "the bytes are no state, or damaged" in text
    text = refused(other, lambda i: i.fmu.setFMUstate(i.fmu.deSerializeFMUstate(data)))
    assert "the state is that of another FMU" in text


@importing("rod_drop")
def test_a_state_of_other_sizes_is_refused_although_its_checksum_is_right(fmu):
    import zlib  # in the clean process a function has its own imports only

    one = Instance(fmu).start()
    data = one.fmu.serializeFMUstate(one.fmu.getFMUstate())
    for word in range(11):  # the sizes at the start of the record
        changed = bytearray(data)
        changed[96 + 8 * word] += 1
        changed[16:24] = zlib.crc32(changed[24:]).to_bytes(8, "little")
        state = bytes(changed)
        text = refused(fmu, lambda i, state=state: i.fmu.setFMUstate(i.fmu.deSerializeFMUstate(state)))
        assert "the state is damaged" in text


@importing("rod_drop")
def test_a_refused_start_leaves_the_state_as_it_was(fmu):
    """The start is refused for a point inside a wall, and for infinite energy."""
    for values, said in (
        ({"initial.y": -1.0}, "a contact point starts beyond a wall"),
        ({"initial.vx": 1e160}, "the state or its energy is no longer finite"),
    ):
        instance = Instance(fmu)
        instance.fmu.setupExperiment(startTime=0.0)
        instance.set(values)
        instance.fmu.enterInitializationMode()
        before = instance.fmu.serializeFMUstate(instance.fmu.getFMUstate())
        try:
            instance.fmu.exitInitializationMode()
        except FMICallException:
            assert before == instance.fmu.serializeFMUstate(instance.fmu.getFMUstate())
        else:
            raise AssertionError(values)
        assert said in MESSAGES[-1]


# --- refusals, each in one sentence ------------------------------------------------------------------------

RANGES = [
    ("contact.stiffness", 0.0, "contact.stiffness = 0.0 must be a finite number > 0 [N/m^exponent]"),
    ("contact.stiffness", float("inf"), "contact.stiffness = inf must be a finite number > 0"),
    ("contact.restitution", 1.5, "contact.restitution = 1.5 must be a finite number >= 0 and <= 1"),
    ("initial.x", float("nan"), "initial.x = nan must be a finite number [m]"),
    ("link[1].mass", -1.0, "link[1].mass = -1.0 must be a finite number > 0 [kg]"),
    ("solver.tolerance", 1e-20, "solver.tolerance = 1e-20 must be a finite number >= 1e-13"),
    ("contact.model", 99, "contact.model = 99 must be one of 1 (hertz), 2 (hunt_crossley)"),
    ("contact.model", 0, "contact.model = 0 must be one of 1 (hertz)"),
    ("solver.method", -1, "solver.method = -1 must be one of 1 (auto), 2 (explicit)"),
    ("energy.total", 1.0, "energy.total is an output and cannot be set before initialization"),
    ("impact.count", 1, "impact.count is an output and cannot be set before initialization"),
]


@importing("rod_drop")
def test_values_out_of_range_are_refused_by_name_value_and_range(fmu, ranges):
    for name, value, text in ranges:
        assert text in refused(fmu, lambda i, name=name, value=value: i.set({name: value}))


@pytest.fixture
def ranges():
    return RANGES


@importing("rod_drop")
def test_calls_out_of_order_are_refused(fmu, target):
    def start(instance):
        instance.start(stop_time=1.0)

    def step(time, size):
        return lambda i: i.fmu.doStep(currentCommunicationPoint=time, communicationStepSize=size)

    def enter(instance):
        instance.fmu.setupExperiment(startTime=0.0)
        instance.fmu.enterInitializationMode()

    def initialize(instance):
        instance.fmu.enterInitializationMode()

    def exit_it(instance):
        instance.fmu.exitInitializationMode()

    def end(instance):
        instance.fmu.terminate()

    def setting(name, value):
        return lambda i: i.set({name: value})

    law = Instance(fmu).variables["contact.model"].valueReference
    again = "fmi2EnterInitializationMode cannot be called after initialization"
    # FMI 3.0 sets the experiment up on entering initialization mode
    twice = again if target == "fmi3" else "fmi2SetupExperiment cannot be called after initialization"
    for calls, text in (
        ([step(0.0, 0.1)], "fmi2DoStep cannot be called before initialization"),
        ([enter, step(0.0, 0.1)], "fmi2DoStep cannot be called in initialization mode"),
        ([start, step(0.0, 0.0)], "fmi2DoStep: the step size 0.0 s is not > 0"),
        ([start, step(0.0, -0.1)], "fmi2DoStep: the step size -0.1 s is not > 0"),
        ([start, step(0.0, float("nan"))], "fmi2DoStep: the step size nan s is not > 0"),
        ([start, step(0.0, 0.1), step(0.2, 0.1)], "fmi2DoStep: the time 0.2 s is not the present 0.1 s"),
        ([start, step(float("nan"), 0.1)], "fmi2DoStep: the time nan s is not the present 0.0 s"),
        ([start, step(0.0, 1.1)], "fmi2DoStep: 1.1 s lies beyond the stop time 1.0 s"),
        ([start, end, step(0.0, 0.1)], "fmi2DoStep cannot be called after terminate"),
        ([start, start], twice),
        ([start, initialize], again),
        ([exit_it], "fmi2ExitInitializationMode cannot be called before initialization"),
        ([lambda i: i.start(2.0, 1.0)], "fmi2SetupExperiment: start time 2.0 s, stop time 1.0 s"),
        ([start, setting("box.y_min", -1.0)], "box.y_min is a fixed parameter and cannot be set after init"),
        (
            [start, end, setting("contact.stiffness", 1e6)],
            "a tunable parameter and cannot be set after term",
        ),
        ([lambda i: i.fmu.getReal([9999])], "fmi2GetReal: the value reference 9999 is no Real's"),
        ([lambda i: i.fmu.getReal([4294967295])], "fmi2GetReal: the value reference"),
        ([lambda i: i.fmu.getInteger([0])], "fmi2GetInteger: the value reference 0 is no Integer's"),
        ([lambda i: i.fmu.setReal([law], [1.0])], "is of another type or of nothing"),
    ):
        assert text in refused(fmu, *calls)


@pytest.mark.parametrize(
    ("model", "changes", "said"),
    [
        ("rod_drop", {"initial.y": -1.0}, "beyond a wall, or a joint beyond a stop: point 0"),
        ("rod_drop", {"contact.restitution": 0.0}, "not allow this restitution: point 0 at the wall y_min"),
        ("kneed_leg", {"initial.angle[3]": 3.0}, "joint 3 at its joint_max"),
        ("sliding_rod", {"wall.y_min.friction": 0.5, "wall.y_min.static_friction": 0.4}, "the wall y_min"),
        ("ramp", {"wall.stop.x": -2.5}, "a contact point starts beyond a wall"),
        ("thrown", {"contact.model": RIGID}, "newton_impact has no contact friction"),
    ],
)
@importing()
def test_a_start_that_is_refused_is_told_with_its_place_and_can_be_mended(fmu, changes, said):
    import contextlib

    text = refused(fmu, lambda one: one.start(**changes))
    assert "the simulation cannot start: " in text
    assert said in text
    instance, plain = Instance(fmu), Instance(fmu).start()
    with contextlib.suppress(FMICallException):
        instance.start(**changes)
    instance.fmu.reset()
    instance.start()
    for one in (instance, plain):
        one.step(0.25)
    assert instance.get(instance.outputs) == plain.get(plain.outputs)


@importing("rod_drop")
def test_a_law_that_cannot_go_on_is_told_with_the_time(fmu):
    def set_late(instance):
        instance.start()
        instance.step(0.2578125)
        instance.set({"contact.restitution": 0.0})

    said = refused(fmu, set_late, lambda i: i.step(0.5))
    assert "stopped at t = 0.2578125 s: the contact law does not allow this restitution" in said


@importing("sliding_rod")
def test_static_friction_below_that_of_sliding_is_refused_during_a_run(fmu):
    def later(one):
        one.start()
        one.step(0.3)
        one.set({"wall.y_min.static_friction": 0.01})
        one.get(["energy.total"])
        one.step(0.6)

    said = refused(fmu, later)
    assert "what has been set cannot act: static_friction is below friction" in said
    assert "the simulation stopped at t = 0.3 s: static_friction is below friction" in said
    assert said.count("point 0 at the wall y_min") == 2


@importing("rod_drop")
def test_reading_an_output_says_that_what_was_set_cannot_act(fmu, within):
    """The set value stops the solver; another value may still be set."""
    time, law, rigid = within
    one, seen = Instance(fmu).start(), []
    one.step(time)
    for number in (law, rigid, law):
        one.set({"contact.model": number})
        MESSAGES.clear()
        seen += [one["energy.total"], one["energy.total"]]
        for text in MESSAGES:
            assert "what has been set cannot act: contact.model can change to newton_impact only" in text
        assert len(MESSAGES) == (2 if number == rigid else 0)
    assert max(abs(energy / seen[0] - 1.0) for energy in seen) < 1e-12
    one.step(time + 0.01)
    assert one["solver.status"] == 0


@pytest.fixture
def within():
    """Return a time in the first contact of the rod, its contact law and the rigid law."""
    result = simulate("rod_drop")
    first, law = result.impacts[0], CONTACT_LAWS[result.scene.contact.model].number
    return [0.5 * float(first["onset"] + first["end"]), law, RIGID]


@importing("rod_drop")
def test_the_tolerance_is_the_parameter(fmu):
    instance, plain = Instance(fmu), Instance(fmu).start()
    MESSAGES.clear()
    instance.fmu.setupExperiment(tolerance=1e-4, startTime=0.0)
    instance.fmu.enterInitializationMode()
    assert MESSAGES == ["the importer's tolerance 0.0001 is not used: set the parameter solver.tolerance"]
    instance.fmu.exitInitializationMode()
    for one in (instance, plain):
        one.step(1.0)
    assert instance.get(plain.outputs) == plain.get(plain.outputs)


def test_why_a_native_fmu_cannot_start_or_go_on_is_seen_on_the_command_line(native, capsys):
    """The command line shows the reason, and the results before the failure."""
    assert cli.main(["simulate", native["rod_drop"], "--set", "initial.y=-1"]) == 3
    assert "the simulation cannot start: a contact point starts beyond a wall" in capsys.readouterr().err
    assert cli.main(["simulate", native["four_link_box"], "--set", "solver.work_limit=2000"]) == 3
    said = capsys.readouterr()
    assert "a second of simulated time takes more evaluations than solver.work_limit allows" in said.err
    assert "FourLinkBox" in said.out
