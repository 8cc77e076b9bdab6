"""Angles in degrees, in every place with values; hints for radians above a full turn."""

import math
import warnings

import numpy as np
import pytest

from chain_impact import (
    Chain,
    SceneError,
    SceneWarning,
    build_fmu,
    cli as command_line,
    parse_scene,
    record_fmu,
)
from chain_impact.scene.errors import value_text
from chain_impact.scene.scene import scene_from_dict, scene_to_dict
from chain_impact.scene.texts.angles import radians_hint, radians_of
from chain_impact.studies.fit.parameters import fitted_parameters
from chain_impact.studies.fit.scene_file import text_with_values
from chain_impact.study_data.sweep.variation import variations_of
from tests.helpers.tools.refusal import refusal

SCENE = """
name = "Arm"
[chain]
base = "pinned"
[[chain.links]]
length = 0.5
mass = 1.0
joint_stiffness = 2.0
joint_rest_angle = "-45 deg"  # at rest
[[chain.links]]
length = 0.5
mass = 1.0
[[walls]]
name = "ramp"
point = [0.0, -2.0]
angle = "10 deg"
[initial]
angles = ["-90 deg", 0.5]  # from +x
angular_velocities = [0.1, "30 deg/s"]
[simulation]
stop_time = 0.01
"""
VALUES = {
    "link[1].joint_rest_angle": -math.pi / 4,
    "wall.ramp.angle": math.pi / 18,
    "initial.angle[1]": -math.pi / 2,
    "initial.angle[2]": 0.5,
    "initial.angular_velocity[1]": 0.1,
    "initial.angular_velocity[2]": math.pi / 6,
}
ANGLE, RATE = "initial.angle[1]", "initial.angular_velocity[1]"


@pytest.fixture
def arm():
    return parse_scene(SCENE, "arm.toml")


# --- the text ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "degrees"),
    [("90 deg", 90.0), ("-45deg", -45.0), (" +1.5e1  deg ", 15.0), (".5 deg", 0.5), ("3. deg", 3.0)],
)
def test_degrees_are_radians(text, degrees):
    assert radians_of(text, "rad") == math.radians(degrees)
    assert radians_of(text.replace("deg", "deg/s"), "rad/s") == math.radians(degrees)


@pytest.mark.parametrize("value", ["90", "90 grad", "deg", "1_0 deg", "nan deg", "90 deg/s", 90, 1.5, None])
def test_other_values_do_not_change(value):
    assert radians_of(value, "rad") is value


def test_only_angles_and_rates_have_degrees():
    assert radians_of("90 deg", "rad/s") == "90 deg"
    assert radians_of("90 deg", "m") == radians_of("90 deg", "") == "90 deg"


# --- where values are given --------------------------------------------------------------------------------


def test_in_a_scene_file_and_in_a_dict(arm):
    assert {name: arm.values[name] for name in VALUES} == pytest.approx(VALUES, rel=1e-15)
    data = scene_to_dict(arm)
    data["initial"]["angles"][0] = "-90 deg"
    assert scene_from_dict(data, "arm") == arm


@pytest.mark.parametrize(("name", "value"), VALUES.items())
def test_angles_are_set_by_name_in_degrees(arm, name, value):
    unit = "deg/s" if "velocity" in name else "deg"
    text = f"{math.degrees(value) + 1.0!r} {unit}"
    assert arm.with_values({name: text}).values[name] == pytest.approx(value + math.pi / 180, rel=1e-14)


def test_in_a_list_by_name(arm):
    assert arm.with_values({"initial.angles": ["180 deg", 0]}).initial.angles == (math.pi, 0.0)


SIGNALS = """
[inputs]
joint_targets = true
tip_force = true
[signals.nod]
input = "joint[1].target_angle"
form = "sine"
amplitude = "30 deg"
mean = -0.5
frequency = 1.0
phase = "90 deg"
[signals.turn]
input = "joint[2].target_velocity"
form = "steps"
times = [0.0, 0.1]
values = [0.5, "-60 deg/s"]
"""


def test_in_signals_that_drive_angles():
    signals = parse_scene(SCENE + SIGNALS, "arm.toml").signals
    nod, turn = signals["nod"], signals["turn"]
    assert (nod.amplitude, nod.mean, nod.phase) == pytest.approx((math.pi / 6, -0.5, math.pi / 2), rel=1e-15)
    assert turn.values == pytest.approx((0.5, -math.pi / 3), rel=1e-15)


@pytest.mark.parametrize(
    ("input_name", "unit"),
    [("joint[1].target_velocity", "[rad/s]"), ("tip.force.x", "[N]"), ("joint[1]", "")],
)
def test_in_no_signal_that_drives_another_quantity(input_name, unit):
    text = SCENE + SIGNALS.replace("joint[1].target_angle", input_name)
    with pytest.raises(SceneError) as caught:
        parse_scene(text, "arm.toml")
    assert all(part in str(caught.value) for part in ("signals.nod.amplitude", "'30 deg'", unit))


def test_angles_of_a_stepped_chain_are_in_degrees(arm):
    chain = Chain(arm)
    chain.set({ANGLE: "-60 deg", RATE: "15 deg/s"})
    assert (chain.get("link[1].angle"), chain.get("link[1].angular_velocity")) == (-math.pi / 3, math.pi / 12)


def test_in_a_sweep(arm):
    for values in ("-90 deg:0 deg:3", "-90 deg,-45 deg,0 deg", ["-90 deg", "-45 deg", 0]):
        [variation] = variations_of(arm, {ANGLE: values})
        np.testing.assert_allclose(variation.values, [-math.pi / 2, -math.pi / 4, 0.0], rtol=1e-15)
    [interval] = variations_of(arm, {ANGLE: "-90 deg:0 deg"})
    assert interval.interval
    assert interval.values.tolist() == [-math.pi / 2, 0.0]


def test_in_the_bounds_of_a_fit(arm):
    [fitted] = fitted_parameters([arm], [ANGLE], [], {ANGLE: "-100 deg:-80 deg"})
    assert (fitted.low, fitted.high) == (math.radians(-100.0), math.radians(-80.0))


def test_angles_of_an_fmu_are_in_degrees(arm, tmp_path):
    recording = record_fmu(build_fmu(arm, tmp_path), {ANGLE: "-60 deg", RATE: "15 deg/s"})
    assert recording.parameters[ANGLE] == recording.columns["link[1].angle"][0] == -math.pi / 3
    assert recording.parameters[RATE] == math.pi / 12


def test_on_the_command_line(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.toml").write_text(SCENE)
    settings = "--set", f"{ANGLE}=-60 deg", "--set", 'initial.angular_velocities=["15 deg/s", 0]'
    assert command_line.main(["simulate", "arm.toml", *settings, "--csv", "arm.csv"]) == 0
    assert not capsys.readouterr().err
    head, row, *_ = (tmp_path / "arm.csv").read_text(encoding="utf-8").splitlines()
    first = dict(zip(head.split(","), map(float, row.split(",")), strict=True))
    assert (first["link[1].angle"], first["link[1].angular_velocity"]) == (-math.pi / 3, math.pi / 12)


def test_a_fitted_scene_file_keeps_degrees_that_do_not_change(arm):
    text = text_with_values(
        SCENE, arm.with_values({"initial.angle[2]": 0.75, "wall.ramp.angle": 0.25}), "arm.toml"
    )
    expected = SCENE.replace('["-90 deg", 0.5]  # from +x', '["-90 deg", 0.75] # from +x').replace(
        'angle = "10 deg"', "angle = 0.25"
    )
    assert text == expected


# --- refusals ----------------------------------------------------------------------------------------------


def test_texts_that_are_no_angle_are_refused_with_the_form(arm):
    requirement = 'must be a finite number [rad], or text in degrees as "90 deg"'
    for value in ("90 grad", "90 deg/s", "1e999 deg", True):
        assert refusal(arm.with_values, {ANGLE: value}) == f"Arm: {ANGLE} = {value_text(value)} {requirement}"
    requirement = 'must be a finite number [rad/s], or text in degrees as "90 deg/s"'
    assert refusal(Chain(arm).set, {RATE: "90 deg"}) == f"Arm: {RATE} = '90 deg' {requirement}"
    assert refusal(variations_of, arm, {RATE: ["90 deg"]}) == f"Arm: {RATE} = 90 deg {requirement}"


# --- hints -------------------------------------------------------------------------------------------------


def hints_of(make, *arguments):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        make(*arguments)
    assert all(issubclass(warning.category, SceneWarning) for warning in caught)
    return [str(warning.message) for warning in caught]


def test_radians_of_more_than_a_turn_are_pointed_at():
    hint = 'initial.angle[2] = 90 rad is 14.3 turns: if degrees are meant, write "90 deg"'
    assert radians_hint("initial.angle[2]", 90.0, "rad") == hint
    assert radians_hint("x", -2.0 * math.pi, "rad") is None
    assert radians_hint("x", 90.0, "rad/s") is None, "rates of many turns are usual"
    text = SCENE.replace('["-90 deg", 0.5]  # from +x', "[-1.5, 90]")
    assert hints_of(parse_scene, text, "arm.toml") == [f"arm.toml: {hint}"]


def test_only_the_joint_angle_that_the_file_gives_is_pointed_at():
    text = SCENE.replace('angles = ["-90 deg", 0.5]  # from +x', "joint_angles = [90, 0]")
    (hint,) = hints_of(parse_scene, text, "arm.toml")
    assert hint.startswith("arm.toml: initial.joint_angles[1] = 90 rad is 14.3 turns")


def test_a_change_is_pointed_at_once(arm):
    hint = 'Arm: link[1].joint_rest_angle = -45 rad is 7.16 turns: if degrees are meant, write "-45 deg"'
    name = "link[1].joint_rest_angle"
    assert hints_of(arm.with_values, {name: -45}) == [hint]
    with pytest.warns(SceneWarning):
        changed_scene = arm.with_values({name: -45})
    assert hints_of(changed_scene.with_values, {"gravity.y": -1.6}) == [], "it is known"


def test_an_error_of_the_start_has_the_hint(arm):
    message = refusal(arm.with_values, {"wall.ramp.angle": 10})
    assert message.startswith("Arm: initial: point ")
    hint = 'wall.ramp.angle = 10 rad is 1.59 turns: if degrees are meant, write "10 deg"'
    assert message.endswith(f"must be outside; {hint}")


@pytest.mark.parametrize("quiet", [False, True])
def test_the_command_line_shows_a_hint_in_a_line(tmp_path, monkeypatch, capsys, quiet):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.toml").write_text(SCENE)
    arguments = ["simulate", "arm.toml", "--set", "initial.angle[2]=90", *["-q"] * quiet]
    assert command_line.main(arguments) == 0
    hint = 'Arm: initial.angle[2] = 90 rad is 14.3 turns: if degrees are meant, write "90 deg"'
    assert capsys.readouterr().err == ("" if quiet else f"chain-impact: warning: {hint}\n")
