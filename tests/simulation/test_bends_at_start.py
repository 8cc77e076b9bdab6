"""Signals that bend at the start of the run: derivatives by the time of the bend are for earlier times."""

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.scene.scene import parse_scene
from tests.helpers.scenes.signal_arm import ARM, HEIGHT, PUSH, TARGET, TORQUE

SINE = 'form = "sine"\namplitude = 0.3\nfrequency = 3.0\n'
RAMP = 'form = "ramp"\nfinal = 0.2\nduration = 0.2\n'
ACCELERATION_JUMPS = {
    "a target's speed jumps": (TARGET, SINE, "start"),
    "a target's ramp begins": (TARGET, RAMP + 'shape = "linear"', "start"),
    "a target's ramp ends": (TARGET, RAMP + 'shape = "linear"\nstart = -0.2', "duration"),
    "the acceleration of the base jumps": (HEIGHT, RAMP + 'shape = "trapezoid"', "start"),
    "the speed of the base bends": ("base.vy", SINE, "start"),
    "a step": (TORQUE, 'form = "steps"\ntimes = [-0.1, 0.0]\nvalues = [0.5, 0.0]', "time[2]"),
}
RESTING_LINK = """
name = "LinkOnTable"
gravity = [0.0, -9.81]
[chain]
base = "pinned"
[[chain.links]]
length = 0.5
mass = 0.4
[[walls]]
name = "table"
point = [0.0, -0.25]
angle = 0.0
[contact]
stiffness = 1e5
model = "newton_impact"
points = [1]
[inputs]
wall_motion = ["table"]
[initial]
angles = [-0.5235987755982988]
"""
SMOOTH = {
    "a torque": (TORQUE, SINE, "start"),
    "a force with a phase": (PUSH, SINE + "phase = 1.0", "start"),
    "a smooth ramp of the base": (HEIGHT, RAMP, "start"),
    "the first of the steps": (TORQUE, 'form = "steps"\ntimes = [0.0, 0.1]\nvalues = [0.5, 0.0]', "time[1]"),
}


def by_time(case):
    """Return the derivative of an angle by a time, one-sided differences to both sides, and sentences.

    The first three have shape (T,) [rad/s]: the derivative, then the differences for earlier and later times.
    The sentences are the limits of derivatives that name this time.
    """
    input_name, numbers, key = case
    scene, parameter = (
        parse_scene(f'{ARM}\n[signals.drive]\ninput = "{input_name}"\n{numbers}\n', "x"),
        f"signal.drive.{key}",
    )
    run = simulate(scene, 0.4, tolerance=1e-12, sensitivities=["link[1].mass", parameter])
    h, value, output = 1e-5, scene.values[parameter], "link[2].angle"

    def changed(shift):
        return simulate(scene.with_values({parameter: value + shift}), 0.4, tolerance=1e-12)[output]

    sides = [(4.0 * changed(k * h) - 3.0 * changed(0.0) - changed(2 * k * h)) / (2 * k * h) for k in (-1, 1)]
    sentences = [sentence for sentence in run.sensitivity_limits if parameter in sentence]
    return run.sensitivity(output, parameter), *sides, sentences


@pytest.mark.parametrize("name", ACCELERATION_JUMPS)
def test_where_a_signal_bends_the_derivative_is_for_an_earlier_time(name):
    result, earlier_slope, later_slope, sentences = by_time(ACCELERATION_JUMPS[name])
    np.testing.assert_allclose(result, earlier_slope, rtol=0.0, atol=1e-6)
    assert np.abs(later_slope - earlier_slope).max() > 1e-2
    assert len(sentences) == 1


@pytest.mark.parametrize("name", SMOOTH)
def test_where_a_signal_does_not_bend_the_derivative_is_for_both(name):
    result, earlier_slope, later_slope, sentences = by_time(SMOOTH[name])
    np.testing.assert_allclose(result, earlier_slope, rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(result, later_slope, rtol=0.0, atol=1e-6)
    assert sentences == []


@pytest.mark.parametrize("output", ["link[1].angle", "wall.table.acceleration"])
def test_a_wall_that_starts_to_move_makes_accelerations_jump(output):
    """The tip rests on the wall, so the link gets the wall's acceleration at once."""
    signal = f'input = "wall.table.velocity"\n{RAMP}shape = "linear"'
    scene = parse_scene(f"{RESTING_LINK}\n[signals.drive]\n{signal}\n", "x")
    parameter, step = "signal.drive.start", 1e-5
    run = simulate(scene, 0.1, sensitivities=[parameter])
    starts = [simulate(scene.with_values({parameter: start}), 0.1)[output] for start in (-step, 0.0)]
    expected = (starts[1] - starts[0]) / step
    np.testing.assert_allclose(run.sensitivity(output, parameter), expected, rtol=1e-3, atol=1e-4)
    assert [sentence for sentence in run.sensitivity_limits if parameter in sentence]
