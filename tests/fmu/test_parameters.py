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

# Functions for ``clean``, and tests with importing(), run in the clean process with their own imports.


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
    fmu_columns = dict(zip(names, np.transpose(rows), strict=True))
    # the FMU and the scene use the same machine code
    for name, column in result.prepared_scene.series(result.outputs).items():
        np.testing.assert_array_equal(fmu_columns[name], column, err_msg=name)
    for name in ("steps", "rejected_steps", "rhs_evaluations", "implicit_steps", "status"):
        assert fmu_columns[f"solver.{name}"][-1] == result.statistics[name]
    last = result.impacts[-1]
    assert fmu_columns["impact.count"][-1] == len(result.impacts)
    last_impact = [fmu_columns[f"impact.last_{name}"][-1] for name in ("time", "point", "wall", "speed")]
    assert last_impact == [*last[["onset", "point"]], last["wall"] + 1, last["impact_speed"]]
    if model == "thrown":
        assert set(fmu_columns["joint[2].sticking"]) == {0, 1}
        assert fmu_columns["energy.friction"][-1] > 0.1


def tuned(fmu, at, values, stop, step):
    instance = Instance(fmu).start()
    instance.run([step * i for i in range(1, round(at / step) + 1)])
    instance.set(values)
    return [
        instance.outputs,
        instance.run([step * i for i in range(round(at / step) + 1, round(stop / step) + 1)]),
    ]


@pytest.mark.full("more cases", but=["pythonfmu-knee", "pythonfmu-thrown"])
@pytest.mark.parametrize("model", TUNED)
def test_tunable_parameters_can_be_set_between_steps(fmus, clean, model):
    (at, values), stop = TUNED[model], STOPS[model]
    names, rows = clean(tuned, fmus[model], at, values, stop, STEP)
    chain, unset_chain = Chain(scene_of(model)), Chain(scene_of(model))
    chain.step_to(at)
    chain.set(values)
    chain.step_to(stop)
    unset_chain.step_to(stop)
    fmu_columns = dict(zip(names, np.transpose(rows), strict=True))
    for name in fmu_columns.keys() - {name for name in fmu_columns if name.startswith("solver.")}:
        assert fmu_columns[name][-1] == chain.get(name), name
    tip = f"point[{len(chain.scene.chain.links)}].x"
    assert fmu_columns[tip][-1] != unset_chain.get(tip)


@importing("rod_drop")
def test_outputs_follow_parameters_in_initialization_mode(fmu, height):
    instance = Instance(fmu)
    instance.fmu.setupExperiment(startTime=0.0)
    instance.fmu.enterInitializationMode()
    names = ["point[0].y", "energy.potential", "impact.last_point", "solver.status"]
    values_before = instance.get(names)
    instance.set({"initial.y": 0.5})
    values_after = instance.get(names)
    instance.fmu.exitInitializationMode()
    assert values_before[0] == height
    assert values_after == instance.get(names)
    assert [values_after[0], *values_after[2:]] == [0.5, -1, 0]
    assert abs(values_after[1] - values_before[1] - 0.5 * 9.81 * (values_after[0] - height)) < 1e-12


@pytest.fixture
def height():
    return load_scene("rod_drop").initial.position[1]


# --- derived values follow the other parameters until they are set -----------------------------------------

DERIVED = ["link[1].center_of_mass", "link[1].inertia", "link[2].center_of_mass"]
DERIVED += ["stop.exponent", "stop.restitution"]


def values_of(scene):
    return [scene.values[name] for name in DERIVED]


def shown(fmu, changes, names, when):
    """Return values: all before any is set, of ``changes``, all after initialization, all after a reset."""
    instance = Instance(fmu)
    values = [instance.get(names)]
    instance.fmu.setupExperiment(startTime=0.0)
    if when == "before":
        instance.set(changes)
        if instance.get(changes) != list(changes.values()):
            raise AssertionError(instance.get(changes))
    instance.fmu.enterInitializationMode()
    if when == "in":
        instance.set(changes)
    values.append(instance.get(changes))
    instance.fmu.exitInitializationMode()
    values.append(instance.get(names))
    instance.fmu.terminate()
    instance.fmu.reset()
    values.append(instance.get(names))
    return values


@pytest.mark.full("more cases", but=4)
@pytest.mark.parametrize("when", ["before", "in"])
@pytest.mark.parametrize("changes", PARAMETER_CHANGES, ids=str)
def test_the_value_in_use_is_shown(fmus, clean, changes, when):
    start, set_values, in_use, after_reset = clean(shown, fmus["finger"], changes, DERIVED, when)
    assert start == after_reset == values_of(finger())
    assert set_values == list(changes.values())
    assert in_use == values_of(edited(FINGER, changes))


@importing("finger")
def test_a_derived_parameter_set_to_its_shown_value_keeps_it(fmu):
    instance, name = Instance(fmu), "link[1].inertia"
    inertia = instance[name]
    instance.set({name: inertia})
    assert instance.start(**{"link[1].length": 0.55})[name] == inertia


def test_a_recording_has_the_parameters_in_use(fmus):
    recording = record_fmu(fmus["finger"], {"link[1].length": 0.55, "simulation.stop_time": 0.01})
    assert [recording.parameters[name] for name in DERIVED] == values_of(
        edited(FINGER, {"link[1].length": 0.55})
    )
    assert "link[1].inertia" not in recording.columns
    recording = record_fmu(fmus["knee"], {"link[2].joint_max": 2.5})
    assert (recording.stops[2].low, recording.stops[2].high, recording.stops[2].length) == (0.0, 2.5, 0.5)
    first = recording.impacts[0]
    assert (first["point"], recording.wall_names[first["wall"]]) == (2, "joint_min")
    assert recording.linear_impact_speeds[0] == 0.5 * first["impact_speed"]


def test_the_description_tells_what_is_derived(fmus):
    descriptions = {v.name: v.description for v in read_model_description(fmus["finger"]).modelVariables}
    assert {name for name, text in descriptions.items() if text and "; unless set: " in text} == set(DERIVED)
    assert descriptions["link[1].inertia"].endswith("; unless set: mass * length^2 / 12")


@importing("four_link_box")
def test_counts_and_codes_are_those_of_the_time_whatever_is_read_first(fmu):
    codes = [*(f"impact[{k}].{key}" for k in (1, 2) for key in ("point", "wall")), "impact.count"]
    codes_first, reals_first = Instance(fmu).start(), Instance(fmu).start()
    for time in (0.3, 0.6, 0.9, 1.2):
        codes_first.step(time)
        reals_first.step(time)
        values = codes_first.get(codes)
        assert reals_first["energy.total"] == codes_first["energy.total"]
        assert values == reals_first.get(codes)
    assert codes_first["impact.count"] > 3


# --- communication points --------------------------------------------------------------------------------


@importing("four_link_box")
def test_steps_of_any_size_from_any_start(fmu):
    import random

    even, uneven = Instance(fmu).start(start_time=5.0), Instance(fmu).start(start_time=5.0)
    chance = random.Random(1)
    while uneven.time < 6.0:
        uneven.step(min(6.0, uneven.time + chance.choice([1e-6, 1e-3, 0.03, 0.2])))
    even.step(6.0)
    for even_value, uneven_value in zip(even.get(even.outputs), uneven.get(even.outputs), strict=True):
        assert abs(even_value - uneven_value) <= 1e-9 * (1.0 + abs(even_value))
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
    names = [output.variable.name for output in outputs if not output.dependencies]
    assert names
    instance_with_changes, plain_instance = Instance(fmu).start(), Instance(fmu).start()
    for k in range(1, 17):
        for instance in (instance_with_changes, plain_instance):
            instance.step(k * 0.0625)
        values = instance_with_changes.get(names)
        instance_with_changes.set({"tip.force.x": 3.0, parameter: 0.6})
        instance_with_changes.get(instance_with_changes.outputs)
        instance_with_changes.set({parameter: plain_instance[parameter]})
        assert instance_with_changes.get(names) == values
        instance_with_changes.set({"tip.force.x": 0.0})
        assert instance_with_changes.get(instance_with_changes.outputs) == plain_instance.get(
            plain_instance.outputs
        )
