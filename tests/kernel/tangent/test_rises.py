"""Derivatives by the rise of a sine that has none: closed forms, and motions without a derivative."""

import math

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.scene.scene import parse_scene
from tests.helpers.scenes.signal_arm import ARM, HEIGHT, PUSH, TABLE, TARGET, TORQUE

RISE = "signal.drive.rise"
# a rod turns about joint 1 without gravity
ROD = """
name = "Rod"
gravity = [0.0, 0.0]
chain = { base = "pinned", links = [{ length = 0.6, mass = 2.5 }] }
inputs = { joint_torques = true, base_motion = true, wall_motion = ["side"] }
initial = { angles = [0.5] }
walls = [{ name = "side", point = [2.0, 0.0], angle = 1.5707963267948966 }]
simulation = { stop_time = 0.5, step_size = 0.05 }
"""
INERTIA = 2.5 * 0.6**2 / 3.0
AMPLITUDE, PHASE = 0.4, 1.0
LACK = 0.5 * AMPLITUDE * math.sin(PHASE)


def shaken(input_name, scene=ROD, phase=PHASE, start=0.0):
    """Return a scene with a sine without a rise that drives one input."""
    numbers = f"amplitude = {AMPLITUDE}\nfrequency = 3.0\nphase = {phase}\nstart = {start}"
    return parse_scene(f'{scene}\n[signals.drive]\ninput = "{input_name}"\nform = "sine"\n{numbers}\n', "x")


def by_rise(scene, *outputs):
    """Return the derivatives of some outputs by the rise, and the result with the sentences on them."""
    run = simulate(scene, tolerance=1e-11, sensitivities=[RISE, "signal.drive.amplitude"])
    assert np.isfinite(run.sensitivity(outputs[0], "signal.drive.amplitude")).all()
    return [run.sensitivity(name, RISE) for name in outputs], run


def test_a_torque_lacks_half_of_its_jump_during_the_rise():
    (angle, speed), run = by_rise(shaken("joint[1].torque"), "link[1].angle", "link[1].angular_velocity")
    np.testing.assert_allclose(angle, -LACK / INERTIA * run.time, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(speed[1:], -LACK / INERTIA, rtol=1e-9)
    assert speed[0] == 0.0
    assert run.sensitivity_limits == ()


@pytest.mark.parametrize(
    ("input_name", "speed", "place"),
    [
        ("base.ax", "base.vx", "base.x"),
        ("wall.side.acceleration", "wall.side.velocity", "wall.side.displacement"),
        ("wall.side.velocity", None, "wall.side.displacement"),
        ("wall.side.belt_speed", None, "wall.side.belt_position"),
    ],
)
def test_an_integrated_sine_lacks_half_of_its_jump_during_the_rise(input_name, speed, place):
    (places,), run = by_rise(shaken(input_name), place)
    lost = -LACK * run.time if speed else np.full(len(run.time), -LACK)
    np.testing.assert_allclose(places[1:], lost[1:], rtol=1e-12)
    if speed:
        np.testing.assert_allclose(run.sensitivity(speed, RISE)[1:], -LACK, rtol=1e-12)


@pytest.mark.parametrize("input_name", [TORQUE, PUSH, "joint[1].target_velocity", "base.ay"])
def test_the_derivative_is_that_of_a_one_sided_difference(input_name):
    scene, output = shaken(input_name, ARM), "link[2].angle"
    (derivative,), _ = by_rise(scene, output)
    h = 1e-5
    none, less, more = (
        simulate(scene.with_values({RISE: k * h}), tolerance=1e-12)[output] for k in (0, 1, 2)
    )
    expected = (4.0 * less - 3.0 * none - more) / (2.0 * h)
    np.testing.assert_allclose(derivative, expected, rtol=0.0, atol=1e-6)
    assert np.abs(derivative).max() > 1e-2


@pytest.mark.parametrize(
    ("input_name", "phase", "start"),
    [
        (TORQUE, PHASE, 0.1),  # the value before the start depends on whether there is a rise
        (HEIGHT, 0.0, 0.0),  # the base begins with a speed
        (HEIGHT, math.pi / 2.0, 0.0),
        ("base.vy", PHASE, 0.0),
        (TARGET, PHASE, 0.0),  # the damper of the servo strikes
        (TABLE, -math.pi / 2.0, 0.0),  # the table would meet point 2 on its way
    ],
)
def test_a_motion_that_jumps_with_the_rise_has_no_derivative(input_name, phase, start):
    arm = ARM.replace("point = [0.0, -0.75]", "point = [0.0, -0.6]") if input_name == TABLE else ARM
    (angle, energy), run = by_rise(shaken(input_name, arm, phase, start), "link[2].angle", "energy.total")
    assert np.isnan(angle).all()
    assert np.isnan(energy).all()
    assert np.isnan(run.impact_sensitivity("onset", RISE)).all()
    assert any(RISE in sentence for sentence in run.sensitivity_limits)


@pytest.mark.parametrize(
    ("input_name", "phase", "start"),
    [
        (TORQUE, 0.0, 0.1),
        (TARGET, 0.0, 0.0),
        ("base.vy", math.pi, 0.0),
        (TABLE, math.pi / 2.0, 0.0),
        (TORQUE, PHASE, -0.1),
    ],
)
def test_without_a_jump_in_the_run_the_derivative_is_zero(input_name, phase, start):
    low = ARM.replace("point = [0.0, -0.75]", "point = [0.0, -1.1]")
    (derivative,), run = by_rise(shaken(input_name, low, phase, start), "link[2].angle")
    assert (derivative == 0.0).all()
    assert not any(RISE in sentence for sentence in run.sensitivity_limits)


@pytest.mark.parametrize("key", ["joint_friction = 0.1", "joint_torque_limit = 5.0"])
def test_a_jump_that_may_change_friction_or_a_limit_has_no_derivative(key):
    scene = shaken(TORQUE, ARM.replace("joint_damping = 0.1", f"joint_damping = 0.1\n{key}"))
    run = simulate(scene, sensitivities=[RISE])
    assert np.isnan(run.sensitivity("link[2].angle", RISE)).all()
