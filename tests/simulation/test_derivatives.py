"""Runs with derivatives: their requests, repeated runs, and a motion equal to the run without them."""

import math

import numpy as np
import pytest

from chain_impact import Chain, SceneError, SimulationError, UnknownNameError, load_scene, simulate
from chain_impact.recording.impacts import IMPACT_DTYPE
from chain_impact.simulation.derivatives import DIFFERENTIABLE_COLUMNS, DifferentiatedRun
from chain_impact.variables.prepared import PreparedScene
from chain_impact.variables.selection import differentiable_named
from tests.helpers.scenes.derivative_scenes import AT_STOPS, sprung_chain, struck_twice
from tests.helpers.scenes.problems import ball
from tests.helpers.scenes.stops import knee_scene
from tests.helpers.tools.differences import slope

CASE = struck_twice("hunt_crossley")
OUTPUTS = ("point[2].x", "energy.total")
TIMES = np.array([0.1, 0.2022, 0.3])


def names_of(scene, *patterns):
    return [variable.name for variable in differentiable_named(PreparedScene(scene), patterns)]


# --- names ------------------------------------------------------------------------------------------------


def test_a_pattern_stands_for_all_that_are_like_it():
    assert names_of(CASE.scene, "link[*].mass", "box.*") == [
        "link[1].mass",
        "link[2].mass",
        "box.x_min",
        "box.y_min",
    ]


def test_a_repeated_name_counts_once():
    assert names_of(CASE.scene, "link[1].mass", "link[*].mass") == ["link[1].mass", "link[2].mass"]


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("contact.stifness", "the nearest is contact.stiffness"),
        ("link[5].mass", "links count from 1 to 2"),
        ("contact.model", "it is a choice, or a setting of the solver"),
        ("contact.minimum_impact_speed", "it is a choice, or a setting of the solver"),
        ("solver.tolerance", "it is a choice, or a setting of the solver"),
        ("point[2].x", "it is an output"),
        ("contact.points", "change it in the scene file"),
        ("joint[2].torque", "set inputs.joint_torques = true"),
        ("*.wall", "`chain-impact info SCENE` lists the names"),
    ],
)
def test_a_name_without_derivatives(name, reason):
    with pytest.raises(UnknownNameError) as caught:
        simulate(CASE.scene, sensitivities=[name])
    assert str(caught.value).startswith(f"Case: {name} is not a parameter with derivatives; {reason}")


def test_derivatives_by_no_parameter_are_refused():
    with pytest.raises(SceneError, match="name at least one parameter"):
        DifferentiatedRun(CASE.scene, [], OUTPUTS)


def test_a_contact_that_lasts_at_a_stop_is_differentiated_as_an_angle():
    """Values known since the onset have the same derivatives as after the end of the contact."""
    names = ["link[1].length", "link[2].mass", "initial.angular_velocity[1]"]
    run, values = DifferentiatedRun(knee_scene(), names, ["energy.total"]), np.array([0.5, 1.0, 0.0])
    whole_run = run.run(values, np.array([0.5]))
    middle = 0.5 * (whole_run.impacts["onset"][0] + whole_run.impacts["end"][0])
    lasting = run.run(values, np.array([middle]))
    assert len(lasting.impacts) == 1
    for name in ("onset", "impact_speed", "effective_mass", "x", "y"):
        np.testing.assert_array_equal(lasting.impact_slopes[name][0], whole_run.impact_slopes[name][0], name)
        assert np.abs(whole_run.impact_slopes[name][0]).max() > 1e-3
    assert np.isnan(lasting.impact_slopes["end"][0]).all()


@pytest.mark.parametrize(
    ("model", "parameter"), [("ramp", "contact.radius"), ("pinned_arm", "link[2].length")]
)
def test_positions_of_impacts_have_the_derivatives_of_differences(model, parameter):
    scene = load_scene(model).with_values({"solver.tolerance": 1e-11})
    value = scene.values[parameter]
    result = simulate(scene, sensitivities=[parameter])
    for field in ("x", "y"):

        def changed(number, field=field):
            return simulate(scene.with_values({parameter: number})).impacts[field][:2]

        expected = slope(changed, value, 1e-5 * value)
        assert result.impact_sensitivity(field, parameter)[:2] == pytest.approx(expected, rel=1e-5, abs=1e-8)


def test_contacts_that_last_together_have_derivatives_of_their_own():
    """A rod lies on the floor, with two lasting contacts."""
    scene, names, values = load_scene("rod_drop"), ["contact.stiffness", "link[1].mass"], [1e8, 0.5]
    result = DifferentiatedRun(scene, names, ["energy.total"]).run(np.array(values), np.array([2.0]))
    last = np.flatnonzero(np.isnan(result.impacts["end"]))
    assert len(last) == 2
    for k, name in enumerate(names):

        def onsets(value, name=name):
            return simulate(scene.with_values({name: value}), 2.0, 2.0).impacts["onset"][last]

        slopes = result.impact_slopes["onset"][last, k]
        np.testing.assert_allclose(slopes, slope(onsets, values[k], 1e-6 * values[k]), rtol=1e-2)
        assert abs(slopes[0] - slopes[1]) > 0.1 * abs(slopes[0])


def test_there_is_a_row_for_each_time_also_for_equal_ones():
    name, start = "contact.restitution", CASE.scene.contact.restitution
    run = DifferentiatedRun(CASE.scene, [name], OUTPUTS)
    once, twice = (run.run(np.array([start]), np.array(times)) for times in ([0.0, 0.2], [0.0, 0.2, 0.2]))
    np.testing.assert_array_equal(twice.values, once.values[[0, 1, 1]])
    np.testing.assert_array_equal(twice.slopes, once.slopes[[0, 1, 1]])


# --- the same motion --------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", ["four_link_box", "pinned_arm", "ramp", "falling_arm", "elastic_floor"])
def test_the_motion_is_that_without_derivatives_bit_by_bit(model):
    plain = simulate(model)
    result = simulate(model, sensitivities=["contact.restitution", "link[1].mass"])
    assert result.outputs.tobytes() == plain.outputs.tobytes()
    assert result.impacts.tobytes() == plain.impacts.tobytes()
    assert result.statistics == plain.statistics


def test_a_result_without_has_none():
    result = simulate(CASE.scene)
    assert result.sensitivities is None
    assert result.sensitivity_limits == ()
    for ask in (result.sensitivity, result.impact_sensitivity):
        with pytest.raises(UnknownNameError, match=r"simulate\(scene, sensitivities=\[…\]\) makes them"):
            ask("point[2].x", "contact.stiffness")


def test_outputs_that_are_chosen_have_the_same_derivatives():
    name = "contact.restitution"
    full_result = simulate(CASE.scene, sensitivities=name)
    chosen_result = simulate(CASE.scene, output=OUTPUTS, sensitivities=name)
    for output in OUTPUTS:
        assert np.array_equal(chosen_result.sensitivity(output, name), full_result.sensitivity(output, name))
    with pytest.raises(UnknownNameError, match=r"point\[1\].x is not an output of this result"):
        chosen_result.sensitivity("point[1].x", name)
    with pytest.raises(UnknownNameError, match=r"without derivatives; impact_sensitivity\(…\)"):
        full_result.sensitivity("impact[1].peak_force", name)


def test_more_than_there_is_room_for_is_refused():
    with pytest.raises(SceneError, match="GB"):
        simulate("four_link_box", output_step=1e-5, sensitivities=["link[*].*", "initial.*"])


# --- again and again --------------------------------------------------------------------------------------


def test_a_run_again_is_that_of_a_new_one():
    names = ("contact.restitution", "link[2].mass", "initial.angle[1]", "gravity.y", "contact.stiffness")
    start = np.array([CASE.scene.values[name] for name in names])
    repeated_run = DifferentiatedRun(CASE.scene, names, OUTPUTS)
    for scale in (1.0, 1.07, 0.9, 1.0):
        result = repeated_run.run(scale * start, TIMES)
        scene = CASE.scene.with_values(dict(zip(names, scale * start, strict=True)))
        expected = DifferentiatedRun(scene, names, OUTPUTS).run(scale * start, TIMES)
        for name in ("values", "slopes", "impacts"):
            assert getattr(result, name).tobytes() == getattr(expected, name).tobytes()
        for name in DIFFERENTIABLE_COLUMNS:
            assert result.impact_slopes[name].tobytes() == expected.impact_slopes[name].tobytes()
        assert (result.status, result.limits) == (0, ())


@pytest.mark.parametrize("case", [sprung_chain(), AT_STOPS["stop, rigid wall"]], ids=["sprung", "stop"])
def test_a_run_again_takes_all_parameters(case):
    """Derivatives at the values of the scene would differ from those at the changed values."""
    repeated_run = DifferentiatedRun(case.scene, case.parameters, OUTPUTS, inputs=case.inputs)
    values = {name: case.value(name) for name in case.parameters}
    changed_values = {
        name: 1.001 * value or 1e-4 for name, value in values.items() if name not in case.inputs
    }
    point = np.array([*(values | changed_values).values()])
    result = repeated_run.run(point, TIMES)
    scene = case.scene.with_values(changed_values)
    expected = DifferentiatedRun(scene, case.parameters, OUTPUTS, inputs=case.inputs).run(point, TIMES)
    assert len(changed_values) > 30
    assert len(result.impacts) > 0
    for name in ("values", "slopes", "impacts"):
        assert getattr(result, name).tobytes() == getattr(expected, name).tobytes()


def test_derivatives_have_a_row_for_each_output_and_parameter():
    names = ("contact.restitution", "link[2].mass")
    values = np.array([CASE.scene.values[name] for name in names])
    result = DifferentiatedRun(CASE.scene, names, OUTPUTS).run(values, TIMES)
    assert result.values.shape == (3, 2)
    assert result.slopes.shape == (3, 2, 2)
    assert result.impacts.dtype == IMPACT_DTYPE
    assert {name: slopes.shape for name, slopes in result.impact_slopes.items()} == dict.fromkeys(
        DIFFERENTIABLE_COLUMNS, (len(result.impacts), 2)
    )


def test_a_start_that_is_refused_gives_no_rows():
    run = DifferentiatedRun(CASE.scene, ["link[1].mass"], OUTPUTS)
    good = run.run(np.array([1.0]), TIMES)
    bad = run.run(np.array([-1.0]), TIMES)
    assert bad.status != 0
    assert np.isnan(bad.values).all()
    assert np.isnan(bad.slopes).all()
    assert len(bad.impacts) == 0
    assert all(slopes.shape == (0, 1) for slopes in bad.impact_slopes.values())
    assert run.run(np.array([1.0]), TIMES).slopes.tobytes() == good.slopes.tobytes()


def test_a_fault_on_the_way_keeps_the_rows_before():
    scene = load_scene("four_link_box").with_values({"solver.work_limit": 1500})
    result = DifferentiatedRun(scene, ["contact.stiffness"], ["point[4].x"]).run(
        np.array([1e8]), np.linspace(0.0, 2.0, 41)
    )
    assert result.status != 0
    has_row = np.isfinite(result.values[:, 0])
    assert has_row[0]
    assert not has_row[-1]
    assert np.isnan(result.slopes[~has_row]).all()


def test_inputs():
    """A torque is switched on; the derivative by an added constant is compared with differences."""
    case = sprung_chain()
    name, output = "joint[2].torque", "link[3].angle"
    times = np.array([0.0, 0.05, 0.11, 0.2])

    def inputs(shift):
        return {name: (times, np.array([0.0, 1.0, -2.0, 0.5]) + shift)}

    result = simulate(case.scene, tolerance=1e-12, inputs=inputs(0.0), sensitivities=name)
    upper, lower = (simulate(case.scene, tolerance=1e-12, inputs=inputs(shift)) for shift in (1e-4, -1e-4))
    expected = (upper[output] - lower[output]) / 2e-4
    derivative = result.sensitivity(output, name)
    assert np.abs(expected).max() > 1e-2
    np.testing.assert_allclose(derivative, expected, atol=1e-5 * np.abs(expected).max())
    run = DifferentiatedRun(case.scene, [name], [output], inputs=inputs(0.0)).run(
        np.array([0.0]), result.time
    )
    np.testing.assert_allclose(run.slopes[:, 0, 0], derivative, atol=1e-6 * np.abs(expected).max())


SIGNALS = {
    "function": lambda t: 5.0 * math.sin(3.0 * t),
    "samples": ([0.0, 0.3, 0.9], [1.0, -4.0, 2.0]),
    "number": 1.0,
}


@pytest.mark.parametrize("times", [[0.4], [0.4, 0.5], [0.0, 0.4], [0.0]])
@pytest.mark.parametrize("signal", SIGNALS.values(), ids=SIGNALS)
def test_inputs_act_from_the_start_whenever_the_first_row_is(signal, times):
    output, inputs = "link[2].angle", {"joint[1].torque": signal}
    scene = load_scene("pinned_arm")
    run = DifferentiatedRun(scene, ["link[1].mass"], [output], inputs=inputs)
    result = run.run(np.array([scene.values["link[1].mass"]]), np.array(times))
    expected = simulate(scene, 0.5, 0.1, inputs=inputs, sensitivities=["link[1].mass"])
    rows = [round(10 * time) for time in times]
    assert result.values.shape == (len(times), 1)
    np.testing.assert_allclose(result.values[:, 0], expected[output][rows], rtol=0, atol=1e-8)
    slopes = expected.sensitivity(output, "link[1].mass")[rows]
    np.testing.assert_allclose(result.slopes[:, 0, 0], slopes, rtol=0, atol=1e-6)


# --- runs that fail ---------------------------------------------------------------------------------------


def as_far_as(limit):
    """Return the result up to where the work exceeds a limit, or to the end of the run."""
    scene = CASE.scene.with_values({"solver.work_limit": float(limit)})
    try:
        return simulate(scene, sensitivities=["initial.y"])
    except SimulationError as error:
        return error.result


def test_a_run_that_fails_has_right_derivatives_or_none():
    """The solver fails earlier or later, by its limit of work."""
    full_result = simulate(CASE.scene, sensitivities=["initial.y"])
    stopped_runs = 0
    for limit in range(60, 900, 21):
        partial_result = as_far_as(limit)
        stopped_runs += 0 < len(partial_result.impacts) < len(full_result.impacts)
        for name in ("onset", "end", "impact_speed", "separation_speed"):
            result = partial_result.impact_sensitivity(name, "initial.y")
            expected = full_result.impact_sensitivity(name, "initial.y")[: len(result)]
            assert (np.isnan(result) | np.isclose(result, expected, rtol=1e-6)).all()
    assert stopped_runs > 3


def test_after_a_fault_the_outputs_have_no_derivatives():
    scene = CASE.scene.with_values({"solver.work_limit": 300.0, "outputs.sensitivities": ["initial.y"]})
    chain = Chain(scene)
    with pytest.raises(SimulationError):
        chain.step_to(0.3)
    assert np.isnan(chain.get("sensitivity.initial.y.point[2].x"))


def test_a_start_that_fails_leaves_no_sentence_of_the_run_before():
    # the ball arrives at contact.minimum_impact_speed, where derivatives end
    scene = ball(1e-4, 1e-3, stiffness=1e6, stop_time=0.3)
    run = DifferentiatedRun(scene, ["contact.stiffness", "link[1].mass"], ["point[0].y"])
    times = np.array([0.3])
    assert run.run(np.array([1e6, 1.0]), times).limits
    failed = run.run(np.array([1e6, -1.0]), times)
    assert failed.status != 0
    assert failed.limits == ()
