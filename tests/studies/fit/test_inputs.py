"""Fits with measured inputs: torques of motors, a moving base."""

# Tests: studies/fit/measurements.py, studies/fit/scene_file.py

import csv

import numpy as np
import pytest

from chain_impact import SceneError, fit, simulate
from chain_impact.cli import main
from chain_impact.scene.scene import scene_from_dict, scene_to_dict
from chain_impact.studies.fit.scene_file import write_scene

TIMES = np.linspace(0.0, 1.0, 41)
TORQUE = 2.0 * np.sin(9.0 * TIMES) + 1.0
FREE_NAMES = ["link[1].joint_damping", "link[1].inertia"]
TRUE = [0.2, 0.15]


def arm(damping=0.05, inertia=0.1, **tables):
    link = {"length": 0.6, "mass": 1.2, "joint_damping": damping, "inertia": inertia}
    data = {
        "name": "Arm",
        "chain": {"base": "pinned", "links": [link]},
        "inputs": {"joint_torques": True, "base_motion": True},
        "initial": {"angles": [-1.0]},
        "simulation": {"stop_time": 1.0},
    }
    return scene_from_dict(data | tables, "arm")


def measured(inputs, interpolation="follow", outputs=("link[1].angle",), **tables):
    """Return the columns of an exact measurement with inputs."""
    result = simulate(arm(*TRUE, **tables), inputs=inputs, interpolation=interpolation, output_step=0.025)
    return {"time": result.time, **{name: result[name] for name in outputs}}


def assert_true_values(fit_result):
    assert fit_result.converged
    np.testing.assert_allclose([fit_result.values[name] for name in FREE_NAMES], TRUE, rtol=1e-6)


@pytest.mark.parametrize("interpolation", ["follow", "hold", "linear"])
def test_a_torque_in_the_table_acts_on_the_model_as_simulate_lets_it(interpolation):
    signal = {"joint[1].torque": (TIMES, TORQUE)}
    table = measured(signal, interpolation) | {"joint[1].torque": TORQUE}
    fit_result = fit(arm(), table, FREE_NAMES, interpolation=interpolation)
    assert_true_values(fit_result)
    assert list(fit_result.columns) == ["link[1].angle"]
    fit_without_torque = fit(arm(), {name: table[name] for name in ("time", "link[1].angle")}, FREE_NAMES)
    assert abs(fit_without_torque.values[FREE_NAMES[0]] - TRUE[0]) > 0.01


def test_a_base_moves_between_its_measured_positions():
    x = 0.05 * np.sin(7.0 * TIMES)
    table = measured({"base.x": (TIMES, x)}) | {"base.x": x}
    assert_true_values(fit(arm(), table, FREE_NAMES))
    partial_table = table | {
        "link[1].angle": [angle if k % 3 else np.nan for k, angle in enumerate(table["link[1].angle"])]
    }
    assert_true_values(fit(arm(), partial_table, FREE_NAMES))


def test_inputs_in_a_table_of_their_own_have_their_own_times():
    times = np.linspace(0.0, 1.0, 97)
    torque = np.cos(8.0 * times)
    table = measured({"joint[1].torque": (times, torque)}, "linear")
    inputs = {"time": times, "joint[1].torque": torque}
    assert_true_values(fit(arm(), [[table, inputs]], FREE_NAMES, interpolation="linear"))
    fit_result = fit(arm(), [[inputs, table]], FREE_NAMES, columns=["link[*].angle"], interpolation="linear")
    assert_true_values(fit_result)


def test_times_of_impacts_with_a_torque_tell_the_damping():
    wall = {"box": {"y_min": -0.55}, "contact": {"points": [1]}}
    torque = {"joint[1].torque": (TIMES, -TORQUE)}
    result = simulate(arm(*TRUE, **wall), inputs=torque)
    assert len(result.impacts) > 1
    impacts = {"wall": ["y_min"] * len(result.impacts), "onset": result.impacts["onset"]}
    sigma = {"onset": 1e-6}
    inputs = {"time": TIMES, "joint[1].torque": -TORQUE}
    fit_result = fit(arm(inertia=TRUE[1], **wall), [[impacts, inputs]], FREE_NAMES[:1], sigma=sigma)
    assert fit_result.values[FREE_NAMES[0]] == pytest.approx(TRUE[0], rel=1e-6)


@pytest.mark.parametrize(
    ("table", "names", "message"),
    [
        (
            {"joint[1].torque": TORQUE},
            ["joint[1].torque"],
            "Arm: joint[1].torque is free, and is a column of data",
        ),
        (
            {"sigma(joint[1].torque)": TORQUE, "joint[1].torque": TORQUE},
            FREE_NAMES,
            "an input has no standard",
        ),
        (
            {"joint[2].torque": TORQUE},
            FREE_NAMES,
            "column joint[2].torque is not an output that changes over time, no input",
        ),
        (
            {"joint[1].torque": [*TORQUE[:-1], "high"]},
            FREE_NAMES,
            "row 40: joint[1].torque = 'high' must be a finite",
        ),
    ],
)
def test_inputs_that_cannot_be_are_refused(table, names, message):
    with pytest.raises(SceneError) as refused:
        fit(arm(), measured({}) | table, names)
    assert message in str(refused.value)


def test_inputs_without_times_are_refused():
    with pytest.raises(
        SceneError, match="column time is missing; it says to which of the inputs the values in"
    ):
        fit(arm(), [[measured({}), {"joint[1].torque": TORQUE}]], FREE_NAMES)


def test_an_input_is_in_one_table_only():
    inputs = {"time": TIMES, "joint[1].torque": TORQUE}
    with pytest.raises(SceneError, match=r"column joint\[1\]\.torque is also in data"):
        fit(arm(), [[measured({}) | inputs, inputs]], FREE_NAMES)


def test_the_command_line_has_the_interpolation(tmp_path, capsys):
    write_scene(arm(), tmp_path / "arm.toml")
    table = measured({"joint[1].torque": (TIMES, TORQUE)}, "linear") | {"joint[1].torque": TORQUE}
    with (tmp_path / "motion.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(table)
        writer.writerows(zip(*table.values(), strict=True))
    files = [str(tmp_path / "arm.toml"), str(tmp_path / "motion.csv")]
    assert main(["fit", *files, "--free", ",".join(FREE_NAMES), "--interpolation", "linear", "-q"]) == 0
    assert main(["fit", *files, "--free", ",".join(FREE_NAMES), "--interpolation", "linear"]) == 0
    fit_result = fit(arm(), table, FREE_NAMES, interpolation="linear")
    assert repr(fit_result).splitlines()[-3:] == capsys.readouterr().out.splitlines()[-3:]
    assert scene_to_dict(fit_result.scene)["chain"]["links"][0]["inertia"] == pytest.approx(TRUE[1], rel=1e-6)
