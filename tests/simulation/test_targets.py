"""Servos whose target changes while their damper pulls towards rest are warned of."""

import math
import warnings

import numpy as np
import pytest

from chain_impact import SceneWarning, load_scene, simulate
from chain_impact.scene.files.models import scene_file_path

TIMES = np.linspace(0.0, 0.05, 40)


def swing(time):
    return 0.2 * np.sin(3.0 * time)


def warnings_of(values, inputs, name="pinned_arm", **options):
    scene = load_scene(name).with_values({"inputs.joint_targets": True, **values})
    with warnings.catch_warnings(record=True) as caught_warnings:
        warnings.simplefilter("always", SceneWarning)
        simulate(scene, 0.05, inputs=inputs, **options)
    return [str(warning.message) for warning in caught_warnings]


DAMPED = {"link[2].joint_stiffness": 400.0, "link[2].joint_damping": 20.0}
ANGLE, RATE = "joint[2].target_angle", "joint[2].target_velocity"


@pytest.mark.parametrize(
    ("source", "options"),
    [
        (lambda t: float(swing(t)), {}),
        (lambda t: float(swing(t)), {"interpolation": "hold"}),
        ((TIMES, swing(TIMES)), {}),
        (([0.0, 0.05], [0.0, 0.1]), {"interpolation": "linear"}),
    ],
)
def test_a_target_that_moves_without_its_velocity_is_warned_of(source, options):
    (text,) = warnings_of(DAMPED, {ANGLE: source}, **options)
    assert ANGLE in text
    assert RATE in text


def test_a_target_of_the_slider_is_warned_of():
    inputs = {"slider.target_position": lambda t: 0.1 * math.sin(t)}
    (text,) = warnings_of({"chain.slider.stiffness": 10.0}, inputs, "cart_pole")
    assert "slider.target_velocity" in text


@pytest.mark.parametrize(
    ("values", "inputs"),
    [
        (DAMPED, {ANGLE: 0.3}),
        (DAMPED, {ANGLE: ([0.0, 0.02], [0.0, 0.1])}),
        (DAMPED, {ANGLE: (TIMES, swing(TIMES)), RATE: 0.0}),
        (DAMPED | {"link[2].joint_damping": 0.0}, {ANGLE: lambda t: float(swing(t))}),
        (DAMPED, {RATE: lambda t: float(swing(t))}),
    ],
)
def test_targets_at_rest_and_with_their_velocity_are_not_warned_of(values, inputs):
    assert warnings_of(values, inputs) == []


SIGNAL = """
[signals.rate]
input = "joint[2].target_velocity"
form = "sine"
amplitude = 0.6
frequency = 0.5
"""


def test_a_velocity_that_a_signal_gives_is_known(tmp_path):
    text = scene_file_path("pinned_arm").read_text().replace("joint_torques = true", "joint_targets = true")
    assert "joint_targets" in text
    (tmp_path / "servo.toml").write_text(text + SIGNAL)
    with warnings.catch_warnings():
        warnings.simplefilter("error", SceneWarning)
        simulate(load_scene(tmp_path / "servo.toml"), 0.05, inputs={ANGLE: lambda t: float(swing(t))})
