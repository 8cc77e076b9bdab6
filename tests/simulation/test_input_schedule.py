"""Inputs of ``simulate`` over time: against the equations of motion, against each other, and refusals."""

# Tests: simulation/given_inputs.py, simulation/motions.py, simulation/input_values.py

import math
import warnings

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from chain_impact import SceneWarning, UnknownNameError, load_scene, simulate
from chain_impact.scene.scene import SceneError, scene_from_dict, scene_to_dict, with_values
from tests.simulation.driven_arm import ELBOW, SHOULDER, STOP, arm, motion, push, reference_motion, wave


def no_force(_time):
    return (0.0, 0.0)


# --- against the equations of motion -----------------------------------------------------------------------


def test_samples_that_are_held_act_as_steps_of_torque():
    """The inputs are samples between the rows of the result, and a number: exact with any output step."""
    times, values = np.array([0.0, 0.0371, 0.2, 0.3333]), np.array([1.0, -2.0, 4.0, 0.5])
    signals = {SHOULDER: (times, values), ELBOW: 0.7}
    scene = arm()
    coarse, fine = (simulate(scene, output_step=step, inputs=signals) for step in (0.1, 0.01))

    def torques(time):
        return values[np.searchsorted(times, time, side="right") - 1], 0.7

    expected = reference_motion(scene, torques, no_force, fine.time, breaks=times[1:])
    np.testing.assert_allclose(motion(fine), expected, rtol=0, atol=1e-9)
    assert coarse.time.tolist() == [0.0, 0.1, 0.2, 0.1 * 3, 0.4]
    np.testing.assert_allclose(motion(coarse), motion(fine)[::10], rtol=0, atol=1e-12)


def test_a_function_is_held_between_communication_points():
    scene = arm(tip_force=True)
    result = simulate(
        scene, output_step=0.02, inputs={ELBOW: wave, "tip.force.x": push}, interpolation="hold"
    )

    def last(time):
        return math.floor(time / 0.02) * 0.02

    expected = reference_motion(
        scene,
        lambda time: (0.0, wave(last(time))),
        lambda time: (push(last(time)), 0.0),
        result.time,
        breaks=result.time[1:-1],
    )
    np.testing.assert_allclose(motion(result), expected, rtol=0, atol=1e-9)


@pytest.mark.full("takes long")
def test_lines_are_followed_to_second_order_and_steps_to_first():
    scene = arm(tip_force=True)
    signals = {SHOULDER: wave, "tip.force.y": push}
    expected = reference_motion(
        scene, lambda time: (wave(time), 0.0), lambda time: (0.0, push(time)), np.array([0.0, STOP])
    )[-1]

    def error(step, interpolation):
        result = simulate(scene, output_step=step, inputs=signals, interpolation=interpolation)
        return np.abs(motion(result)[-1] - expected).max()

    for interpolation, order in (("hold", 1), ("linear", 2)):
        fine, coarse = error(0.005, interpolation), error(0.01, interpolation)
        assert coarse / fine == pytest.approx(2.0**order, rel=0.05)
    assert error(1e-4, "linear") < 1e-6
    assert error(1e-4, "hold") > 1e-4


def test_samples_of_a_line_are_those_of_a_function():
    scene = arm()
    times = np.arange(41) * 0.01
    samples = (times, [wave(time) for time in times])
    by_samples = simulate(scene, output_step=0.01, inputs={SHOULDER: samples}, interpolation="linear")
    by_function = simulate(scene, output_step=0.01, inputs={SHOULDER: wave}, interpolation="linear")
    np.testing.assert_allclose(motion(by_samples), motion(by_function), rtol=0, atol=1e-13)


def test_energy_supplied_is_the_work_of_the_torques():
    """dW/dt = Σ u_i (ω_i − ω_{i−1}), summed over rows with a constant torque in between."""
    result = simulate(arm(), output_step=1e-3, inputs={SHOULDER: wave}, interpolation="hold")
    angle = result.angles[:, 0]
    work = sum(wave(t) * turn for t, turn in zip(result.time, np.diff(angle), strict=False))
    assert result.energy["supplied"][-1] == pytest.approx(work, abs=1e-12)
    balance = result.energy["total"] + result.energy["dissipated"] - result.energy["supplied"]
    np.testing.assert_allclose(balance, balance[0], rtol=0, atol=1e-9)


# --- against each other ------------------------------------------------------------------------------------


def test_inputs_of_zero_change_nothing():
    scene = load_scene("pinned_arm")
    plain, zero = simulate(scene), simulate(scene, inputs={SHOULDER: 0.0, ELBOW: lambda _: 0})
    assert plain.outputs.tobytes() == zero.outputs.tobytes()
    assert plain.impacts.tobytes() == zero.impacts.tobytes()
    assert plain.statistics == zero.statistics


def test_a_constant_costs_no_restarts():
    """The constant is given in several forms; the first sample also acts before its time."""
    scene = load_scene("pinned_arm")
    expected = simulate(scene, inputs={SHOULDER: 1.5})
    assert expected.statistics["steps"] < 200
    for signal in (
        lambda _: 1.5,
        ([0.5, 0.7], [1.5, 1.5]),
        (np.array([1]), np.array([1.5])),
        np.float32(1.5),
    ):
        result = simulate(scene, inputs={SHOULDER: signal})
        assert result.outputs.tobytes() == expected.outputs.tobytes()
        assert result.statistics == expected.statistics


def test_samples_at_communication_points_but_for_round_off_add_none():
    """0.1 · 3 differs from 0.3 in floating point, but both count as one time."""
    calls = []
    times = np.arange(401) / 1000
    assert (times != np.arange(401) * 1e-3).any()
    inputs = {SHOULDER: (times, times), ELBOW: lambda time: calls.append(time) or 0.0}
    result = simulate(arm(), output_step=1e-3, inputs=inputs, interpolation="hold")
    assert calls == result.time.tolist()
    assert len(calls) == 401


def test_a_rows_forces_are_those_before_an_input_changes():
    torque = ([0.0, 0.2], [0.0, 50.0])
    result, without_torque = (simulate(arm(), 0.3, 0.1, inputs=inputs) for inputs in ({SHOULDER: torque}, {}))
    acceleration = result.outputs["angular_acceleration"][:, 0]
    expected = without_torque.outputs["angular_acceleration"][:, 0]
    np.testing.assert_allclose(acceleration[:3], expected[:3], rtol=0, atol=1e-7)
    assert abs(acceleration[3] - expected[3]) > 10.0


# --- columns of the result ---------------------------------------------------------------------------------


@pytest.mark.parametrize("interpolation", ["follow", "hold", "linear", "spline"])
def test_given_inputs_are_columns_of_the_result(interpolation, tmp_path):
    """A row at a jump has the value before it, as the output of the same signal in the scene."""
    times, values = [0.0, 0.2, 0.25], [1.0, -2.0, 4.0]
    inputs = {SHOULDER: (times, values), ELBOW: lambda time: 3.0 * time}
    (tmp_path / "torque.csv").write_text(f"time,{SHOULDER}\n0,1\n0.2,-2\n0.25,4\n")
    joined = "hold" if interpolation == "follow" else interpolation
    file = str(tmp_path / "torque.csv")
    table = {"input": [SHOULDER], "form": "table", "file": file, "interpolation": joined}
    result = simulate(arm(), 0.4, 0.1, inputs=inputs, interpolation=interpolation)
    run_of_signal = simulate(with_values(arm(), {("signals", "push"): table}), 0.4, 0.1)
    np.testing.assert_allclose(result[SHOULDER], run_of_signal[SHOULDER], rtol=0, atol=1e-12)
    called = np.array([0.0, 0.0, 0.1, 0.25, 0.3]) if interpolation == "hold" else result.time
    np.testing.assert_allclose(result[ELBOW], 3.0 * called, rtol=0, atol=1e-12)
    assert result.names[-2:] == (SHOULDER, ELBOW)
    chosen_result = simulate(arm(), 0.4, 0.1, inputs=inputs, output=["*.torque", "energy.total"])
    assert chosen_result.names == ("energy.total", SHOULDER, ELBOW)
    curves = chosen_result.curves([SHOULDER])
    assert (max(np.diff(curves.time)), curves.units) == (pytest.approx(0.1), {SHOULDER: "N.m"})
    chosen_result.plot(tmp_path / "torques.svg", curves=["*.torque"])


@pytest.mark.parametrize("interpolation", ["hold", "linear", "spline"])
def test_two_rows_of_equal_time_are_a_jump(interpolation, tmp_path):
    """A torque that jumps at 0.2037 s gives the exact motion, as samples and as the table of a signal."""
    times = np.append(np.linspace(0.0, 0.2037, 22), [0.2037, 0.4])
    values = np.append(3.0 * np.sin(20.0 * times[:22]), [0.5, 0.5])
    file = tmp_path / "torque.csv"
    rows = zip(times.tolist(), values.tolist(), strict=True)
    file.write_text(f"time,{SHOULDER}\n" + "".join(f"{time!r},{value!r}\n" for time, value in rows))
    curves = {
        "hold": lambda time: values[max(int(np.searchsorted(times[:22], time, side="right")) - 1, 0)],
        "linear": lambda time: float(np.interp(time, times[:22], values[:22])),
        "spline": CubicSpline(times[:22], values[:22]),
    }

    def torque(time):
        return (float(curves[interpolation](time)) if time < 0.2037 else 0.5), 0.0

    result = simulate(arm(), 0.4, 0.005, inputs={SHOULDER: (times, values)}, interpolation=interpolation)
    expected = reference_motion(arm(), torque, no_force, result.time, breaks=np.unique(times)[1:-1])
    np.testing.assert_allclose(motion(result), expected, rtol=0, atol=1e-9)
    table = {"input": [SHOULDER], "form": "table", "file": str(file), "interpolation": interpolation}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SceneWarning)  # the last row is far from the others
        run_of_signal = simulate(with_values(arm(), {("signals", "sine"): table}), 0.4, 0.005)
    np.testing.assert_allclose(motion(run_of_signal), expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("times", "values"),
    [([0.0, 0.5, 0.5, 0.6], [0.0, 10.0, 20.0, 20.0]), ([-0.5, -0.2, -0.2, 1.0], [0.0, 1.0, 2.0, 14.0])],
)
def test_a_jump_outside_of_the_run_changes_no_line_within_it(times, values):
    result = simulate(arm(), 0.4, 0.1, inputs={SHOULDER: (times, values)}, interpolation="linear")
    expected = np.interp(result.time, times, values)
    np.testing.assert_allclose(result[SHOULDER], expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("scene", "inputs", "interpolation", "missing_name"),
    [
        ({"inputs.joint_targets": True}, "joint[1].target_angle", "follow", "joint[1].target_velocity"),
        ({"inputs.base_motion": True}, "base.y", "hold", "base.vy"),
    ],
)
def test_an_input_that_is_not_given_is_no_column_that_can_be_chosen(
    scene, inputs, interpolation, missing_name
):
    with pytest.raises(UnknownNameError, match="is not an output"):
        simulate(
            with_values(arm(), scene),
            0.1,
            inputs={inputs: 0.0},
            interpolation=interpolation,
            output=missing_name,
        )


def test_positions_and_velocities_of_a_base_do_not_jump(tmp_path):
    base = with_values(arm(), {"inputs.base_motion": True})
    samples = [0.0, 0.2, 0.2, 0.4], [0.0, 0.0, 1.0, 1.0]
    (tmp_path / "base.csv").write_text("time,base.vy\n0,0\n0.2,0\n0.2,1\n0.4,1\n")
    for name in ("base.y", "base.vy"):
        with pytest.raises(SceneError, match=rf"{name}: two samples at t = 0.2 s make it jump"):
            simulate(base, inputs={name: samples})
    table = {"input": ["base.vy"], "form": "table", "file": str(tmp_path / "base.csv")}
    with pytest.raises(SceneError, match=r"two rows at 0.2 s make base.vy jump"):
        with_values(base, {("signals", "shake"): table})
    result = simulate(base, 0.4, 0.1, inputs={"base.ay": samples}, interpolation="linear")
    assert result["base.vy"][-1] == pytest.approx(0.2)


def test_a_given_motion_has_columns_of_its_derivatives():
    base = with_values(arm(), {"inputs.base_motion": True})
    result = simulate(base, 0.4, 0.01, inputs={"base.vy": lambda time: math.sin(5.0 * time)})
    exact_motion = [(1.0 - np.cos(5.0 * result.time)) / 5.0, np.sin(5.0 * result.time)]
    exact_motion.append(5.0 * np.cos(5.0 * result.time))
    for name, values in zip(("base.y", "base.vy", "base.ay"), exact_motion, strict=True):
        np.testing.assert_allclose(result[name], values, rtol=0, atol=1e-9)
    row_of_heavy_link = result.row_of_other_run({"link[1].mass": 2.0}, 0.2)
    assert row_of_heavy_link["base.vy"] == pytest.approx(math.sin(1.0))


# --- refused -----------------------------------------------------------------------------------------------


def scolding(_time):
    raise RuntimeError("no torque today")


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        (
            {"motor": 1.0},
            r"^PinnedArm: 'motor' is not an input of this scene; it has joint\[1\].torque, "
            r"joint\[2\].torque, and \[inputs\] joint_torques, joint_targets, slider_force, tip_force, "
            r"base_motion and wall_motion in the scene make",
        ),
        ({"joint[3].torque": 1.0}, r"'joint\[3\].torque' is not .*; the nearest is joint\[2\].torque$"),
        ({"tip.force.x": 1.0}, "'tip.force.x' is not an input of this scene"),
        ({7: 1.0}, "7 is not an input of this scene"),
        (
            {ELBOW: ([0.0, 0.1], [1.0])},
            r"^PinnedArm: joint\[2\].torque: times and values .* not \(2,\) and \(1,\)",
        ),
        ({ELBOW: ([], [])}, r"T > 0, not \(0,\) and \(0,\)$"),
        ({ELBOW: (0.0, 1.0)}, r"T > 0, not \(\) and \(\)$"),
        ({ELBOW: ([0.0, 0.1], [1.0, "2"])}, r"not \(2,\) and no numbers$"),
        ({ELBOW: ([[0.0], [0.1, 0.2]], [1.0, 2.0])}, r"not no numbers and \(2,\)$"),
        ({ELBOW: ([0.0, 0.2, 0.1], [1.0, 2.0, 3.0])}, r"times\[2\] = 0.1 must be > times\[1\] = 0.2 \[s\]; "),
        ({ELBOW: ([0.2] * 3, [1.0, 2.0, 3.0])}, r"only two times may be equal, for a jump$"),
        ({ELBOW: ([0.0, np.nan], [1.0, 2.0])}, r"times\[1\] = nan must be a finite number$"),
        ({ELBOW: ([0.0, 0.1], [1.0, np.inf])}, r"values\[1\] = inf must be a finite number$"),
        (
            {ELBOW: math.nan},
            r"^PinnedArm: joint\[2\].torque = nan must be a finite number, a function of the",
        ),
        ({ELBOW: "1.0"}, "= '1.0' must be a finite number"),
        ({ELBOW: [1.0, 2.0, 3.0]}, r"= \[1.0, 2.0, 3.0\] must be"),
        ({ELBOW: None}, "= None must be"),
        ({ELBOW: 1j}, "= 1j must be"),
        ({ELBOW: scolding}, r"function raised RuntimeError at t = 0 s: no torque today$"),
        (
            {ELBOW: lambda time: None if time > 0.1 else 0.0},
            "function returned None at t = 0.101 s, not a finite",
        ),
        ({ELBOW: lambda time: "1"}, "returned '1' at t = 0 s"),
        ({ELBOW: lambda time: math.nan}, "returned nan at t = 0 s"),
        ({ELBOW: lambda time: [1.0]}, r"returned \[1.0\] at t = 0 s"),
        ({ELBOW: lambda: 1.0}, "function raised TypeError at t = 0 s"),
    ],
)
def test_values_that_are_no_input_are_refused_in_one_sentence(inputs, message):
    with pytest.raises(SceneError, match=message) as caught:
        simulate(load_scene("pinned_arm"), inputs=inputs)
    assert "\n" not in str(caught.value)


def test_a_scene_without_inputs_says_how_to_have_some():
    message = (
        r"^FourLinkBox: 'joint\[2\].torque' is not an input of this scene; set inputs.joint_torques = true"
    )
    with pytest.raises(SceneError, match=message):
        simulate(load_scene("four_link_box"), inputs={ELBOW: 1.0})


def test_an_interpolation_is_one_of_those_there_are():
    with pytest.raises(SceneError, match="interpolation = 'cubic' must be follow, hold, linear or spline"):
        simulate(load_scene("pinned_arm"), inputs={ELBOW: 1.0}, interpolation="cubic")


def test_a_wrong_name_is_refused_with_some_of_many_inputs():
    scene = with_values(load_scene("pinned_arm"), {("inputs", "tip_force"): True})
    links = [{"length": 0.1, "mass": 0.1}] * 30
    table = scene_to_dict(scene) | {"chain": {"base": "pinned", "links": links}}
    table |= {"box": {}, "initial": {"angles": [0.0] * 30}}
    message = r"it has joint\[1\].torque, (.*, ){5}…, tip.force.y, and"
    with pytest.raises(SceneError, match=message):
        simulate(scene_from_dict(table, "test"), inputs={"motor": 1.0})
