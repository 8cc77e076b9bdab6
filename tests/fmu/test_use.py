"""The FMU at work, in a process that knows an importer and not this package."""

import itertools
import math
import sys

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from chain_impact import CONTACT_LAWS, load_scene, simulate
from chain_impact.scene import with_values
from chain_impact.variables import output_columns, parameter_paths
from tests.fmu.importer import MESSAGES, Instance, refused

STOP, STEP = 1.0, 2.0**-8  # s; sums of such a step are exact, so that all clocks agree to the last bit


# The functions before each test run in the clean process: they hold all that they use.


def process(fmu):
    import sys

    import fmpy

    fmpy.read_model_description(fmu)  # what fmpy itself imports late
    before = set(sys.modules)
    instance = Instance(fmu).start()
    instance.step(0.25)
    instance.get(instance.outputs)
    return [sorted(set(sys.modules) - before), instance["solver.steps"]]


def test_it_needs_the_standard_library_only(fmus, clean):
    modules, steps = clean(process, fmus["four_link_box"])
    assert steps > 0
    own = {name for name in modules if name.startswith("chain_impact")}
    assert len(own) == 1
    rest = {name.partition(".")[0] for name in modules} - own
    assert rest <= sys.stdlib_module_names | {"pythonfmu"}


def defaults(fmu):
    import fmpy

    rows = fmpy.simulate_fmu(fmu)
    return [rows["time"][-1], int(rows["impact.count"][-1]), float(rows["energy.total"][-1])]


def test_fmpy_simulates_the_default_experiment(fmus, clean):
    time, impacts, energy = clean(defaults, fmus["four_link_box"])
    result = simulate(load_scene("four_link_box"))
    assert (time, impacts) == (2.0, len(result.impacts))
    assert energy == pytest.approx(result.energy["total"][-1], rel=1e-12)


# --- parameters ------------------------------------------------------------------------------------------


def trajectory(fmu, values, stop, step):
    instance = Instance(fmu).start(**values)
    times = [i * step for i in range(round(stop / step) + 1)]
    return [instance.outputs, instance.run(times)]


@pytest.mark.parametrize(
    "values",
    [
        {},
        {"contact.model": CONTACT_LAWS["flores"].number, "contact.restitution": 0.5},
        {"contact.stiffness": 1e6},
        {"contact.restitution": 0.25},
        {"initial.x": 1.25, "initial.angle[1]": 1.0},
        {"initial.vy": 3.0, "initial.angular_velocity[4]": 5.0},
        {"solver.tolerance": 1e-5},
        {"gravity.y": -20.0, "box.x_max": 2.75, "link[2].mass": 3.0, "contact.exponent": 1.25},
    ],
    ids=lambda values: ", ".join(values) or "defaults",
)
def test_parameters_act_as_they_do_in_the_scene(fmus, clean, values):
    names, rows = clean(trajectory, fmus["four_link_box"], values, STOP, STEP)
    scene = load_scene("four_link_box")
    paths, laws = parameter_paths(scene), list(CONTACT_LAWS)
    changes = {
        paths[name]: laws[value - 1] if name == "contact.model" else value for name, value in values.items()
    }
    result = simulate(with_values(scene, changes), STOP, STEP)
    found = dict(zip(names, np.transpose(rows), strict=True))
    # the very same machine code
    for name, column in output_columns(result.scene, result.outputs).items():
        np.testing.assert_array_equal(found[name], column, err_msg=name)
    for name in ("steps", "rejected_steps", "rhs_evaluations", "implicit_steps", "status"):
        assert found[f"solver.{name}"][-1] == result.statistics[name]
    assert found["impact.count"][-1] == len(result.impacts) > 0
    last = result.impacts[-1]
    assert found["impact.last_time"][-1] == last["onset"]
    assert found["impact.last_point"][-1] == last["point"]
    assert found["impact.last_wall"][-1] == last["wall"] + 1
    assert found["impact.last_speed"][-1] == last["impact_speed"]


def in_initialization_mode(fmu):
    instance = Instance(fmu)
    instance.fmu.setupExperiment(startTime=0.0)
    instance.fmu.enterInitializationMode()
    names = ["point[0].y", "energy.potential", "impact.last_point", "solver.status"]
    before = instance.get(names)
    instance.set({"initial.y": 0.5})
    after = instance.get(names)
    instance.fmu.exitInitializationMode()
    return [before, after, instance.get(names)]


def test_outputs_follow_parameters_in_initialization_mode(fmus, clean):
    before, after, started = clean(in_initialization_mode, fmus["rod_drop"])
    assert before[0] == load_scene("rod_drop").initial.position[1]
    assert after == started
    assert after[0] == 0.5
    assert after[1] - before[1] == pytest.approx(0.5 * 9.81 * (after[0] - before[0]), abs=1e-12)
    assert after[2:] == [-1, 0]


def changing_restitution(fmu, change_at, value, times):
    instance = Instance(fmu).start()
    if change_at == 0.0:
        instance.set({"contact.restitution": value})
    rows = []
    for time in times:
        if instance.time < change_at <= time:
            instance.step(change_at)
            instance.set({"contact.restitution": value})
        if time > instance.time:
            instance.step(time)
        rows.append(instance.get(["point[0].y", "energy.dissipated", "impact.count"]))
    return rows


def test_a_tunable_parameter_acts_from_when_it_is_set(fmus, clean):
    times = np.linspace(0.0, 1.0, 51).tolist()
    elastic = clean(changing_restitution, fmus["rod_drop"], 0.0, 1.0, times)
    in_flight = clean(changing_restitution, fmus["rod_drop"], 0.1, 1.0, times)
    never = clean(changing_restitution, fmus["rod_drop"], 9.0, 1.0, times)
    np.testing.assert_allclose(in_flight, elastic, atol=1e-5)
    assert elastic[-1][1] == 0.0
    assert never[-1][1] > 0.1


# --- communication points --------------------------------------------------------------------------------


def impacts_at(fmu, step, every):
    instance = Instance(fmu).start()
    names = [f"impact.{name}" for name in ("count", "last_point", "last_wall", "last_time", "last_speed")]
    names += ["energy.total", "point[4].x", "solver.rhs_evaluations"]
    rows = []
    for i in range(round(2.0 / step)):
        instance.step((i + 1) * step)
        if (i + 1) % every == 0:
            rows.append(instance.get(names))
    return rows


def test_neither_result_nor_cost_depends_on_the_communication_step(fmus, clean):
    fine, middle, coarse = (
        np.array(clean(impacts_at, fmus["four_link_box"], step, round(0.01 / step)))
        for step in (1e-4, 1e-3, 1e-2)
    )
    for other in (fine, middle):
        np.testing.assert_array_equal(other[:, :3], coarse[:, :3])
        np.testing.assert_allclose(other[:, 3:7], coarse[:, 3:7], rtol=0, atol=1e-9)
        assert other[-1, 7] == pytest.approx(coarse[-1, 7], rel=0.05)
    assert coarse[-1, 0] > 10


def two_clocks(fmu):
    """Steps of all sizes, and a start that is not 0."""
    import random

    even, uneven = Instance(fmu).start(start_time=5.0), Instance(fmu).start(start_time=5.0)
    chance = random.Random(1)
    while uneven.time < 6.0:
        uneven.step(min(6.0, uneven.time + chance.choice([1e-6, 1e-3, 0.03, 0.2])))
    even.step(6.0)
    return [even.get(even.outputs), uneven.get(even.outputs), even["impact.last_time"]]


def test_steps_of_any_size_from_any_start(fmus, clean):
    even, uneven, last = clean(two_clocks, fmus["four_link_box"])
    np.testing.assert_allclose(even, uneven, rtol=1e-9, atol=1e-9)
    assert 5.0 < last < 6.0


# --- FMU state -------------------------------------------------------------------------------------------


def saved(fmu, save_at, stop):
    one, two, never = Instance(fmu).start(), Instance(fmu), Instance(fmu).start()
    one.step(save_at)
    state = one.fmu.getFMUstate()
    data = one.fmu.serializeFMUstate(state)

    def go_on(instance):
        instance.time = save_at
        first = instance.get(instance.outputs)
        return [first, *instance.run([save_at + 0.01 * (i + 1) for i in range(50)] + [stop])]

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
    first, second, third, never, size = clean(saved, fmus["four_link_box"], save_at, 1.0)
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
    middle = len(data) // 2
    flipped = data[:middle] + bytes([data[middle] ^ 1]) + data[middle + 1 :]
    pieces = [flipped, data[:-8], data + b"12345678", b"", b"nonsense", data[:24], bytes(len(data))]
    messages = [refused(fmu, lambda i, piece=piece: i.fmu.deSerializeFMUstate(piece)) for piece in pieces]
    stranger = refused(other, lambda i: i.fmu.setFMUstate(i.fmu.deSerializeFMUstate(data)))
    return [messages, stranger]


def test_damaged_and_foreign_states_are_refused(fmus, clean):
    messages, stranger = clean(damaged, fmus["rod_drop"], fmus["pinned_arm"])
    assert all("the bytes are no state, or damaged" in message for message in messages)
    assert "the state is that of another FMU" in stranger


# --- several in a process --------------------------------------------------------------------------------


def together(box, rod, other):
    times = [0.02 * (i + 1) for i in range(50)]
    cases = [(box, {}), (rod, {}), (rod, other)]
    alone = [Instance(path).start(**values).run(times) for path, values in cases]
    instances = [Instance(path).start(**values) for path, values in cases]
    mixed = [[], [], []]
    for time in times:
        for n in range(3):
            mixed[n] += instances[n].run([time])
    return [alone == mixed, mixed[1] == mixed[2]]


def test_instances_of_one_and_of_several_fmus_do_not_mix(fmus, clean):
    equal, same = clean(together, fmus["four_link_box"], fmus["rod_drop"], {"initial.y": 0.8})
    assert equal
    assert not same


def reset(fmu):
    instance = Instance(fmu)
    parameters = [name for name, v in instance.variables.items() if v.causality == "parameter"]
    fresh = instance.get(parameters)
    instance.start(**{"initial.y": 0.8, "contact.model": 3, "contact.stiffness": 1e5})
    instance.step(0.7)
    instance.fmu.reset()
    again = instance.get(parameters)
    instance.start()
    rows = instance.run([0.1 * (i + 1) for i in range(10)])
    return [fresh == again, rows == Instance(fmu).start().run([0.1 * (i + 1) for i in range(10)])]


def test_reset_restores_every_default(fmus, clean):
    assert clean(reset, fmus["rod_drop"]) == [True, True]


# --- inputs ----------------------------------------------------------------------------------------------


def driven(fmu, torques, period, steps, values):
    """Torques at joints 1 and 2, constant over each period, in some communication steps per period."""
    instance = Instance(fmu).start(**values)
    names = [*instance.outputs]
    rows = [instance.get(names)]
    for k, (first, second) in enumerate(torques):
        instance.set({"joint[1].torque": first, "joint[2].torque": second})
        for j in range(steps):
            instance.step((k + (j + 1) / steps) * period)
        rows.append(instance.get(names))
    return [names, rows]


TORQUES = [(2.0, 0.5), (-1.0, 0.5), (3.0, -1.0), (0.0, 0.0), (0.0, 0.0), (1.5, 0.25), (-4.0, 1.0), (0.5, 0.0)]
PERIOD = 0.0625  # s


def arm_rate(scene, torques, state):
    """Lagrange's equations of the two-link arm in absolute angles, with the work of the torques [J]."""
    (t1, t2, w1, w2, _work), (a, b) = state, scene.chain.links
    c, s = math.cos(t1 - t2), math.sin(t1 - t2)
    coupling = b.mass * a.length * b.center_of_mass
    inertia = np.array(
        [
            [a.inertia + a.mass * a.center_of_mass**2 + b.mass * a.length**2, coupling * c],
            [coupling * c, b.inertia + b.mass * b.center_of_mass**2],
        ]
    )
    g = -scene.gravity[1]
    elbow = torques[1] - b.joint_damping * (w2 - w1)
    moments = np.array(
        [
            torques[0] - a.joint_damping * w1 - elbow - coupling * s * w2**2
            - (a.mass * a.center_of_mass + b.mass * a.length) * g * math.cos(t1),
            elbow + coupling * s * w1**2 - b.mass * b.center_of_mass * g * math.cos(t2),
        ]
    )  # fmt: skip
    return [w1, w2, *np.linalg.solve(inertia, moments), torques[0] * w1 + torques[1] * (w2 - w1)]


def test_torques_do_what_the_equations_of_the_arm_say(fmus, clean):
    values = {"box.x_max": 10.0, "solver.tolerance": 1e-11}
    names, rows = clean(driven, fmus["pinned_arm"], TORQUES, PERIOD, 1, values)
    scene = load_scene("pinned_arm")
    state = np.array([*scene.initial.angles, *scene.initial.angular_velocities, 0.0])
    chosen = ["link[1].angle", "link[2].angle", "link[1].angular_velocity", "link[2].angular_velocity"]
    columns = [names.index(name) for name in [*chosen, "energy.supplied"]]
    for torques, row in zip(TORQUES, rows[1:], strict=True):
        solution = solve_ivp(
            lambda _t, y, torques=torques: arm_rate(scene, torques, y),
            (0.0, PERIOD),
            state,
            method="DOP853",
            rtol=1e-12,
            atol=1e-13,
        )
        state = solution.y[:, -1]
        np.testing.assert_allclose([row[column] for column in columns], state, rtol=0, atol=1e-9)


def test_inputs_do_not_depend_on_the_communication_step(fmus, clean):
    torques = list(itertools.islice(itertools.cycle(TORQUES), 24))  # into contact
    names, coarse = clean(driven, fmus["pinned_arm"], torques, PERIOD, 1, {})
    _, fine = clean(driven, fmus["pinned_arm"], torques, PERIOD, 64, {})
    assert coarse[-1][names.index("impact.count")] > 0
    np.testing.assert_array_equal(fine, coarse)


def steady(fmu):
    """Set the torque that is already set, at every step, and once; and a parameter to what it is."""
    often, once = Instance(fmu).start(), Instance(fmu).start()
    for instance in (often, once):
        instance.set({"joint[1].torque": 1.0})
    for i in range(500):
        often.set({"joint[1].torque": 1.0, "contact.stiffness": often["contact.stiffness"]})
        often.step((i + 1) * 2.0**-9)
    once.step(500 * 2.0**-9)
    return [often.get(often.outputs), once.get(once.outputs)]


def test_setting_what_is_already_set_changes_nothing(fmus, clean):
    often, once = clean(steady, fmus["pinned_arm"])
    assert often == once


def at_once(fmu):
    instance = Instance(fmu).start()
    instance.step(0.25)
    names = ["link[1].angle", "link[1].angular_acceleration"]
    before = instance.get(names)
    instance.set({"joint[1].torque": 5.0})
    return [before, instance.get(names)]


def test_an_input_acts_at_once_on_accelerations(fmus, clean):
    (angle, acceleration), (angle_after, acceleration_after) = clean(at_once, fmus["pinned_arm"])
    assert angle == angle_after
    assert acceleration_after > acceleration + 1.0


# --- refusals --------------------------------------------------------------------------------------------


def refused_values(fmu, settings):
    return [refused(fmu, lambda i, name=name, value=value: i.set({name: value})) for name, value in settings]


def test_values_out_of_range_are_refused_by_name_value_and_range(fmus, clean):
    expected = {
        ("contact.stiffness", 0.0): "contact.stiffness = 0.0 must be a finite number > 0 [N/m^exponent]",
        ("contact.stiffness", math.inf): "contact.stiffness = inf must be a finite number > 0",
        ("contact.restitution", 1.5): "contact.restitution = 1.5 must be a finite number >= 0 and <= 1",
        ("initial.x", math.nan): "initial.x = nan must be a finite number [m]",
        ("link[1].mass", -1.0): "link[1].mass = -1.0 must be a finite number > 0 [kg]",
        ("solver.tolerance", 1e-20): "solver.tolerance = 1e-20 must be a finite number >= 1e-13",
        ("contact.model", 99): "contact.model = 99 must be one of 1 (hertz), 2 (hunt_crossley)",
        ("contact.model", 0): "contact.model = 0 must be one of 1 (hertz)",
        ("solver.method", -1): "solver.method = -1 must be one of 1 (auto), 2 (explicit)",
        ("energy.total", 1.0): "energy.total is an output and cannot be set before initialization",
        ("impact.count", 1): "impact.count is an output and cannot be set before initialization",
    }
    for message, text in zip(
        clean(refused_values, fmus["rod_drop"], list(expected)), expected.values(), strict=True
    ):
        assert text in message


def refused_calls(fmu):
    def start(instance):
        instance.start(stop_time=1.0)

    def step(time, size):
        return lambda i: i.fmu.doStep(currentCommunicationPoint=time, communicationStepSize=size)

    return {
        "step before initialization": refused(fmu, step(0.0, 0.1)),
        "step in initialization mode": refused(
            fmu, lambda i: i.fmu.enterInitializationMode(), step(0.0, 0.1)
        ),
        "step of no size": refused(fmu, start, step(0.0, 0.0)),
        "step back": refused(fmu, start, step(0.0, -0.1)),
        "step of nan": refused(fmu, start, step(0.0, float("nan"))),
        "step from elsewhere": refused(fmu, start, step(0.0, 0.1), step(0.2, 0.1)),
        "step from nan": refused(fmu, start, step(float("nan"), 0.1)),
        "step past the stop time": refused(fmu, start, step(0.0, 1.1)),
        "step after terminate": refused(fmu, start, lambda i: i.fmu.terminate(), step(0.0, 0.1)),
        "set up twice": refused(fmu, start, start),
        "initialize twice": refused(fmu, start, lambda i: i.fmu.enterInitializationMode()),
        "leave what was not entered": refused(fmu, lambda i: i.fmu.exitInitializationMode()),
        "stop before the start": refused(fmu, lambda i: i.start(start_time=2.0, stop_time=1.0)),
        "fixed parameter": refused(fmu, start, lambda i: i.set({"box.y_min": -1.0})),
        "after terminate": refused(
            fmu, start, lambda i: i.fmu.terminate(), lambda i: i.set({"contact.stiffness": 1e6})
        ),
        "unknown reference": refused(fmu, lambda i: i.fmu.getReal([9999])),
        "huge reference": refused(fmu, lambda i: i.fmu.getReal([4294967295])),
        "real read as integer": refused(fmu, lambda i: i.fmu.getInteger([0])),
        "integer set as real": refused(
            fmu, lambda i: i.fmu.setReal([i.variables["contact.model"].valueReference], [1.0])
        ),
    }


def test_calls_out_of_order_are_refused(fmus, clean):
    expected = {
        "step before initialization": "fmi2DoStep cannot be called before initialization",
        "step in initialization mode": "fmi2DoStep cannot be called in initialization mode",
        "step of no size": "fmi2DoStep: the step size 0.0 s is not > 0",
        "step back": "fmi2DoStep: the step size -0.1 s is not > 0",
        "step of nan": "fmi2DoStep: the step size nan s is not > 0",
        "step from elsewhere": "fmi2DoStep: the time 0.2 s is not the present 0.1 s",
        "step from nan": "fmi2DoStep: the time nan s is not the present 0.0 s",
        "step past the stop time": "fmi2DoStep: 1.1 s lies beyond the stop time 1.0 s",
        "step after terminate": "fmi2DoStep cannot be called after terminate",
        "set up twice": "fmi2SetupExperiment cannot be called after initialization",
        "initialize twice": "fmi2EnterInitializationMode cannot be called after initialization",
        "leave what was not entered": "fmi2ExitInitializationMode cannot be called before initialization",
        "stop before the start": "fmi2SetupExperiment: start time 2.0 s, stop time 1.0 s",
        "fixed parameter": "box.y_min is a fixed parameter and cannot be set after initialization",
        "after terminate": "contact.stiffness is a tunable parameter and cannot be set after terminate",
        "unknown reference": "fmi2GetReal: the value reference 9999 is no Real's",
        "huge reference": "fmi2GetReal: the value reference",
        "real read as integer": "fmi2GetInteger: the value reference 0 is no Integer's",
        "integer set as real": "is of another type or of nothing",
    }
    messages = clean(refused_calls, fmus["rod_drop"])
    assert messages.keys() == expected.keys()
    for case, text in expected.items():
        assert text in messages[case], case


def faults(fmu):
    def restitution(instance):
        instance.start()
        instance.step(0.25)
        instance.set({"contact.restitution": 0.0})

    return [
        refused(fmu, lambda i: i.start(**{"initial.y": -1.0})),
        refused(fmu, lambda i: i.start(**{"contact.restitution": 0.0})),
        refused(fmu, restitution, lambda i: i.step(0.5)),
    ]


def test_a_fault_is_said_in_one_sentence(fmus, clean):
    inside, restitution, later = clean(faults, fmus["rod_drop"])
    assert "the simulation cannot start: a contact point starts beyond a wall" in inside
    assert "the simulation cannot start: the contact law does not allow this restitution" in restitution
    assert "stopped at t = 0.25 s: the contact law does not allow this restitution" in later


def after_faults(fmu):
    """Refuse often; then how many slaves are left, and how the references to their class have changed."""
    import gc
    import sys

    def references():
        slave = next(module for name, module in sys.modules.items() if name.startswith("chain_impact_"))
        slaves = [one for one in gc.get_objects() if isinstance(one, slave.ChainImpact)]
        return len(slaves), sys.getrefcount(slave.ChainImpact)

    calls = [
        lambda i: i.start(**{"initial.y": -1.0}),
        lambda i: i.set({"contact.model": 99}),
        lambda i: i.fmu.getReal([9999]),
        lambda i: i.fmu.getBoolean([0]),
        lambda i: i.fmu.deSerializeFMUstate(b"nonsense"),
    ]
    for call in calls:
        refused(fmu, call)
    before = references()
    for _ in range(20):
        for call in calls:
            refused(fmu, call)
    return [before, references()]


def test_an_instance_can_be_freed_after_a_fault(fmus, clean):
    before, after = clean(after_faults, fmus["rod_drop"])
    assert before == after
    assert after[0] == 0


def reset_after_a_fault(fmu):
    import contextlib

    import fmpy

    instance = Instance(fmu)
    with contextlib.suppress(fmpy.fmi1.FMICallException):
        instance.start(**{"initial.y": -1.0})
    instance.fmu.reset()
    instance.start()
    instance.step(0.25)
    plain = Instance(fmu).start()
    plain.step(0.25)
    return instance.get(instance.outputs) == plain.get(plain.outputs)


def test_an_instance_can_be_reset_after_a_fault(fmus, clean):
    assert clean(reset_after_a_fault, fmus["rod_drop"])


def without_a_log(fmu):
    import contextlib
    import io

    import fmpy

    said = io.StringIO()
    with contextlib.redirect_stderr(said):
        try:
            fmpy.simulate_fmu(fmu, start_values={"initial.y": -1.0})
        except fmpy.fmi1.FMICallException as error:
            return [str(error), said.getvalue()]
    return ["", said.getvalue()]


def test_a_fault_is_seen_where_the_importer_does_not_log(fmus, clean):
    error, said = clean(without_a_log, fmus["rod_drop"])
    assert "status 4 (fatal)" in error
    assert said == "RodDrop: the simulation cannot start: a contact point starts beyond a wall\n"


def escaped(fmu):
    """What the wrapper takes for a printf format."""
    import sys

    Instance(fmu)
    slave = next(module for name, module in sys.modules.items() if name.startswith("chain_impact_"))
    return repr(slave.SlaveError("100 % of #1"))


def test_percent_and_hash_are_escaped(fmus, clean):
    assert clean(escaped, fmus["rod_drop"]) == "100 %% of ##1"


def other_tolerance(fmu):
    instance = Instance(fmu)
    instance.fmu.setupExperiment(tolerance=1e-4, startTime=0.0)
    said = [*MESSAGES]
    instance.fmu.enterInitializationMode()
    instance.fmu.exitInitializationMode()
    instance.step(1.0)
    plain = Instance(fmu).start()
    plain.step(1.0)
    return [said, instance.get(plain.outputs) == plain.get(plain.outputs)]


def test_the_tolerance_is_the_parameter(fmus, clean):
    said, equal = clean(other_tolerance, fmus["rod_drop"])
    assert said == ["the importer's tolerance 0.0001 is not used: set the parameter solver.tolerance"]
    assert equal


def many(fmu):
    """Create, run and free instances; the growth of the process in MB between the 20th and the 120th."""
    import resource

    sizes = []
    for _ in range(120):
        instance = Instance(fmu).start()
        instance.step(0.1)
        instance.fmu.terminate()
        instance.close()
        sizes.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
    return sizes[-1] - sizes[19]


def test_instances_leave_little_behind(fmus, clean):
    assert clean(many, fmus["rod_drop"]) < 40  # the wrapper itself leaks, some 0.02 MB each
