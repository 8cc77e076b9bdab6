"""Refusals of an FMU, each in one sentence."""

# Tests: fmu/run.py

import pytest

from chain_impact import CONTACT_LAWS, cli, simulate
from tests.fmu.clean import importing
from tests.fmu.importer import MESSAGES, FMICallException, Instance, refused

RIGID = CONTACT_LAWS["newton_impact"].number

# Tests with importing() run in the clean process.


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
    repeated_initialization = "fmi2EnterInitializationMode cannot be called after initialization"
    # FMI 3.0 sets the experiment up on entering initialization mode
    repeated_setup = (
        repeated_initialization
        if target == "fmi3"
        else "fmi2SetupExperiment cannot be called after initialization"
    )
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
        ([start, start], repeated_setup),
        ([start, initialize], repeated_initialization),
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
        ([lambda i: i.fmu.setReal([law], [1.0])], "belongs to another type or to no variable"),
    ):
        assert text in refused(fmu, *calls)


@pytest.mark.full("more cases", but=3)
@pytest.mark.parametrize(
    ("model", "changes", "reason"),
    [
        ("rod_drop", {"initial.y": -1.0}, "beyond a wall, or a joint or slider beyond a stop: point 0"),
        ("rod_drop", {"contact.restitution": 0.0}, "not allow this restitution: point 0 at the wall y_min"),
        ("kneed_leg", {"initial.angle[3]": 3.0}, "joint 3 at its joint_max"),
        ("knee", {"link[2].joint_min": 9.0}, "is not below the upper stop (max): joint 2"),
        ("cart", {"slider.min": 0.3}, "is not below the upper stop (max): the slider"),
        ("cart", {"slider.mass": 0.0, "link[1].inertia": 0.0}, "or slider.mass, must be > 0: link[1]"),
        ("sliding_rod", {"wall.y_min.friction": 0.5, "wall.y_min.static_friction": 0.4}, "the wall y_min"),
        ("ramp", {"wall.stop.x": -2.5}, "a contact point starts beyond a wall"),
        ("thrown", {"contact.model": RIGID}, "newton_impact has no contact friction"),
    ],
)
@importing()
def test_a_start_that_is_refused_is_told_with_its_place_and_can_be_mended(fmu, changes, reason):
    import contextlib

    text = refused(fmu, lambda i: i.start(**changes))
    assert "the simulation cannot start: " in text
    assert reason in text
    instance, plain = Instance(fmu), Instance(fmu).start()
    with contextlib.suppress(FMICallException):
        instance.start(**changes)
    instance.fmu.reset()
    instance.start()
    for target in (instance, plain):
        target.step(0.25)
    assert instance.get(instance.outputs) == plain.get(plain.outputs)


@importing("rod_drop")
def test_a_law_that_cannot_go_on_is_told_with_the_time(fmu):
    def set_late(instance):
        instance.start()
        instance.step(0.2578125)
        instance.set({"contact.restitution": 0.0})

    message = refused(fmu, set_late, lambda i: i.step(0.5))
    assert "stopped at t = 0.2578125 s: the contact law does not allow this restitution" in message


@importing("sliding_rod")
def test_static_friction_below_that_of_sliding_is_refused_during_a_run(fmu):
    def later(instance):
        instance.start()
        instance.step(0.3)
        instance.set({"wall.y_min.static_friction": 0.01})
        instance.get(["energy.total"])
        instance.step(0.6)

    messages = refused(fmu, later)
    assert "the values that are set cannot take effect: static_friction is below friction" in messages
    assert "the simulation stopped at t = 0.3 s: static_friction is below friction" in messages
    assert messages.count("point 0 at the wall y_min") == 2


@importing("rod_drop")
def test_reading_an_output_says_that_what_was_set_cannot_act(fmu, contact):
    """The set value stops the solver; another value may still be set."""
    time, law, rigid = contact
    instance, energies = Instance(fmu).start(), []
    instance.step(time)
    for number in (law, rigid, law):
        instance.set({"contact.model": number})
        MESSAGES.clear()
        energies += [instance["energy.total"], instance["energy.total"]]
        for text in MESSAGES:
            assert (
                "the values that are set cannot take effect: contact.model can change to newton_impact only"
                in text
            )
        assert len(MESSAGES) == (2 if number == rigid else 0)
    assert max(abs(energy / energies[0] - 1.0) for energy in energies) < 1e-12
    instance.step(time + 0.01)
    assert instance["solver.status"] == 0


@pytest.fixture
def contact():
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
    for target in (instance, plain):
        target.step(1.0)
    assert instance.get(plain.outputs) == plain.get(plain.outputs)


def test_the_command_line_shows_why_a_native_fmu_cannot_start_or_go_on(native, capsys):
    """The command line shows the reason, and the results before the failure."""
    assert cli.main(["simulate", native["rod_drop"], "--set", "initial.y=-1"]) == 3
    assert "the simulation cannot start: a contact point starts beyond a wall" in capsys.readouterr().err
    assert cli.main(["simulate", native["four_link_box"], "--set", "solver.work_limit=2000"]) == 3
    output = capsys.readouterr()
    assert "a second of simulated time takes more evaluations than solver.work_limit allows" in output.err
    assert "FourLinkBox" in output.out
