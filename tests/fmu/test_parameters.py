"""Parameters, derived values and communication points of an FMU in a process without this package."""

# Tests: fmu/run.py

import numpy as np
import pytest
from fmpy import read_model_description

from chain_impact import CONTACT_LAWS, Chain, load_scene, simulate
from chain_impact.fmu.run import record_fmu
from tests.fmu.clean import importing
from tests.fmu.importer import Instance
from tests.fmu.scenes import scene_of
from tests.helpers.scenes.derived_scenes import FINGER, PARAMETER_CHANGES, edited, finger

STEP = 2.0**-7  # s; sums of this step are exact, so that all clocks are bit-equal
STOPS = {"knee": 2.0, "thrown": 1.5, "finger": 0.75, "servo": 1.0, "led_cart": 1.0}  # s; 1 s for all others

# The functions without assertions, and those for importing(), run in the clean process.


# --- parameters ------------------------------------------------------------------------------------------

TUNED = {
    "knee": (0.5, {"stop.restitution": 0.9, "stop.stiffness": 3e4, "wall.x_max.restitution": 0.75}),
    "thrown": (0.25, {"wall.y_min.friction": 0.05, "contact.restitution": 0.1}),
    "servo": (0.5, {"link[1].joint_stiffness": 40.0, "link[2].joint_damping": 0.0}),
    "led_cart": (0.375, {"slider.stiffness": 9.0, "slider.damping": 0.1}),
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


@pytest.mark.full("more cases", but=4)
@pytest.mark.parametrize(("model", "values"), CASES, ids=str)
def test_parameters_act_as_they_do_in_the_scene(fmus, clean, model, values):
    stop = STOPS.get(model, 1.0)
    scene = edited(FINGER, values) if model == "finger" else scene_of(model).with_values(values)
    result = simulate(scene, stop, STEP)
    laws = {name: CONTACT_LAWS[law].number for name, law in values.items() if name == "contact.model"}
    names, rows = clean(trajectory, fmus[model], values | laws, stop, STEP)
    found = dict(zip(names, np.transpose(rows), strict=True))
    # the FMU and the scene use the same machine code
    for name, column in result.prepared_scene.series(result.outputs).items():
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


@pytest.mark.full("more cases", but=["pythonfmu-knee", "pythonfmu-thrown"])
@pytest.mark.parametrize("model", TUNED)
def test_tunable_parameters_can_be_set_between_steps(fmus, clean, model):
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
    tip = f"point[{len(chain.scene.chain.links)}].x"
    assert found[tip][-1] != never.get(tip)


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
    """Return the parameters before any is set, the changed ones, and all after initialization and a reset."""
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


@pytest.mark.full("more cases", but=4)
@pytest.mark.parametrize("when", ["before", "in"])
@pytest.mark.parametrize("changes", PARAMETER_CHANGES, ids=str)
def test_the_value_in_use_is_shown(fmus, clean, changes, when):
    start, given, in_use, again = clean(shown, fmus["finger"], changes, DERIVED, when)
    assert start == again == values_of(finger())
    assert given == list(changes.values())
    assert in_use == values_of(edited(FINGER, changes))


@importing("finger")
def test_a_derived_parameter_set_to_its_shown_value_keeps_it(fmu):
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
    assert found.linear_impact_speeds[0] == 0.5 * first["impact_speed"]


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
def test_a_value_that_is_reset_leaves_no_trace(fmu):
    """An importer sets a value, reads outputs and resets the value.

    The run continues as without the new value.
    """
    import fmpy

    description = fmpy.read_model_description(fmu)
    parameter = next(v.name for v in description.modelVariables if v.name.endswith(".restitution"))
    outputs = [output for output in description.outputs if not output.variable.dimensions]
    # no input acts at once on these outputs
    held = [output.variable.name for output in outputs if not output.dependencies]
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
