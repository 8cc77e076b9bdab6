"""What an importer must not ask of the FMU, how that is refused, and what is left after it."""

import math

from tests.fmu.importer import MESSAGES, Instance, refused

# The functions before each test run in the clean process: they hold all that they use.


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
            fmu,
            lambda i: i.fmu.setupExperiment(startTime=0.0),
            lambda i: i.fmu.enterInitializationMode(),
            step(0.0, 0.1),
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


def test_calls_out_of_order_are_refused(fmus, target, clean):
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
    if target == "fmi3":  # which sets up as it enters initialization mode
        expected["set up twice"] = expected["initialize twice"]
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


def other_tolerance(fmu):
    instance = Instance(fmu)
    instance.fmu.setupExperiment(tolerance=1e-4, startTime=0.0)
    instance.fmu.enterInitializationMode()
    said = [*MESSAGES]
    instance.fmu.exitInitializationMode()
    instance.step(1.0)
    plain = Instance(fmu).start()
    plain.step(1.0)
    return [said, instance.get(plain.outputs) == plain.get(plain.outputs)]


def test_the_tolerance_is_the_parameter(fmus, clean):
    said, equal = clean(other_tolerance, fmus["rod_drop"])
    assert said == ["the importer's tolerance 0.0001 is not used: set the parameter solver.tolerance"]
    assert equal
