"""Signals that jump within the motion."""

# Tests: simulation/derivatives.py

import math

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.scene.scene import parse_scene, scene_from_dict

PRESSED = """
name = "Pressed"
gravity = [0.0, -9.81]
chain = { base = "pinned", links = [{ length = 0.5, mass = 1.0 }] }
walls = [{ name = "side", point = [0.3001, 0.0], angle = 1.5707963267948966 }]
contact = { model = "newton_impact", restitution = 0.0 }
inputs = { joint_torques = true, tip_force = true }
initial = { angles = [-0.9273] }
outputs = { loads = true }
simulation = { stop_time = 0.2, step_size = 0.01 }
[signals.push]
input = "INPUT"
form = "steps"
times = [0.0, 0.104]
values = [6.0, 9.0]
"""


# The arm rests on a rigid wall, whose force jumps with the input.
@pytest.mark.parametrize("input_name", ["joint[1].torque", "tip.force.x", "tip.force.y"])
def test_an_impulse_has_a_derivative_by_the_time_of_a_jump(input_name):
    scene, parameter = parse_scene(PRESSED.replace("INPUT", input_name), "x"), "signal.push.time[2]"
    run = simulate(scene, sensitivities=[parameter], tolerance=1e-12)
    earlier_run, later_run = (
        simulate(scene.with_values({parameter: 0.104 + h}), tolerance=1e-13) for h in (-1e-5, 1e-5)
    )
    jumps = []
    for output in ("contact[1].side.impulse", "joint[1].impulse.x", "joint[1].impulse.y"):
        slope = (later_run[output] - earlier_run[output]) / 2e-5
        np.testing.assert_allclose(run.sensitivity(output, parameter), slope, rtol=0.0, atol=1e-6)
        jumps.append(abs(slope[-1]))
    assert max(jumps) > 1.0


LIFTED = PRESSED.replace("joint_torques = true, tip_force = true", "base_motion = true, tip_force = true")


def lifted(first_acceleration, second_acceleration, rises=True):
    """Return the text of the arm's scene; its base accelerates upward, from 0.104 s on with the second value.

    The force in the joint ``rises`` while the arm falls, and falls while the arm swings up.
    """
    text = LIFTED.replace("INPUT", "base.ay").replace(
        "[6.0, 9.0]", f"[{first_acceleration}, {second_acceleration}]"
    )
    swings = "angles = [-1.5708], angular_velocities = [3.0]"
    return text if rises else text.replace("angles = [-0.9273]", swings)


def pressed_hard(model):
    """Return the text of the arm's scene: a torque presses the arm into a soft wall, and then is reversed."""
    text = PRESSED.replace("INPUT", "joint[1].torque").replace("[6.0, 9.0]", "[60.0, -20.0]")
    law = f'model = "{model}", exponent = 1.0, stiffness = 2000.0, restitution = 0.1'
    return text.replace('model = "newton_impact", restitution = 0.0', law).replace("0.104", "0.012")


PEAK_SLOPES = {
    "behind the jump": (lifted(0.0, 12.0, rises=False), -26.02494),
    "before the jump": (lifted(12.0, 0.0), 83.73723),
    "in a wall": (pressed_hard("kelvin_voigt"), -2560.5829),
}
"""Case → text of a scene, and the derivative of the joint's peak force by the time of the jump [N/s]."""


@pytest.mark.parametrize("name", PEAK_SLOPES)
def test_a_largest_force_has_a_derivative_by_the_time_of_a_jump(name):
    text, expected = PEAK_SLOPES[name]
    scene, parameter = parse_scene(text, "x"), "signal.push.time[2]"
    run, value = simulate(scene, sensitivities=[parameter], tolerance=1e-12), scene.values[parameter]
    result = run.sensitivity("joint[1].peak_force", parameter)
    assert result[-1] == pytest.approx(expected, rel=1e-6)
    for size in (1e-6, 5e-6):
        earlier_run, later_run = (
            simulate(scene.with_values({parameter: value + h}), tolerance=1e-12) for h in (-size, size)
        )
        slope = (later_run["joint[1].peak_force"] - earlier_run["joint[1].peak_force"]) / (2.0 * size)
        np.testing.assert_allclose(result, slope, rtol=1e-5, atol=1e-4)
        for quantity in ("peak_force", "joint_force"):
            slope = (later_run.impacts[quantity] - earlier_run.impacts[quantity]) / (2.0 * size)
            of_impacts = run.impact_sensitivity(quantity, parameter)
            np.testing.assert_allclose(of_impacts, slope, rtol=1e-5, atol=1e-4)


def jump_of(input_name, change, time=0.104, name="pull"):
    """Return the text of a signal with which an input jumps from 0 to ``change`` at a time."""
    shape = f'form = "steps"\ntimes = [0.0, {time}]\nvalues = [0.0, {change}]\n'
    return f'[signals.{name}]\ninput = "{input_name}"\n{shape}'


@pytest.mark.parametrize("text", [lifted(0.0, 12.0, rises=False), lifted(12.0, 0.0)])
def test_a_peak_at_two_simultaneous_jumps_has_no_derivative_by_either_time(text):
    scene = parse_scene(text + jump_of("tip.force.y", 1.0), "x")
    parameters = ["signal.push.time[2]", "signal.pull.time[2]", "link[1].mass"]
    run = simulate(scene, sensitivities=parameters)
    for time in parameters[:2]:
        assert np.isnan(run.sensitivity("joint[1].peak_force", time)[-1])
        assert np.isfinite(run.sensitivity("point[1].y", time)).all()
    assert np.isfinite(run.sensitivity("joint[1].peak_force", parameters[2])).all()


def test_a_peak_at_three_simultaneous_jumps_has_no_derivative_by_any_time():
    text = lifted(0.0, 12.0, rises=False)
    text += jump_of("tip.force.x", 1.0, name="along") + jump_of("tip.force.y", 1.0, name="up")
    parameters = ["signal.push.time[2]", "signal.along.time[2]", "signal.up.time[2]"]
    run = simulate(parse_scene(text, "x"), sensitivities=parameters)
    for parameter in parameters:
        assert np.isnan(run.sensitivity("joint[1].peak_force", parameter)[-1])
        assert np.isfinite(run.sensitivity("point[1].y", parameter)).all()


def struck(restitution):
    """Return the text of an arm that strikes a soft wall; two inputs jump while the force falls."""
    text = pressed_hard("kelvin_voigt").replace("[60.0, -20.0]", "[6.0, -6.0]").replace("0.012", "0.03")
    text = text.replace("restitution = 0.1", f"restitution = {restitution}")
    text = text.replace("[-0.9273]", "[-0.9273], angular_velocities = [2.0]")
    return text + jump_of("tip.force.x", -5.0, 0.03)


@pytest.mark.parametrize("restitution", [0.1, 0.8])  # the largest force is at the onset, or later
def test_jumps_after_a_walls_peak_keep_its_derivatives(restitution):
    scene, parameters = parse_scene(struck(restitution), "x"), ["signal.push.time[2]", "link[1].mass"]
    run, mass = simulate(scene, sensitivities=parameters, tolerance=1e-10), scene.values[parameters[1]]
    assert run.impacts["onset"][0] < 0.025
    assert not run.impacts["end"][0] < 0.03
    assert run.impact_sensitivity("peak_force", parameters[0])[0] == 0.0
    lighter, heavier = (
        simulate(scene.with_values({parameters[1]: mass + h}), tolerance=1e-12) for h in (-1e-5, 1e-5)
    )
    slope = (heavier.impacts["peak_force"][0] - lighter.impacts["peak_force"][0]) / 2e-5
    assert run.impact_sensitivity("peak_force", parameters[1])[0] == pytest.approx(slope, rel=1e-5)


def test_a_wall_peak_at_two_jumps_has_no_derivative_by_either_time():
    """The slopes on both sides differ: 6772 and 6426 N/s."""
    text = pressed_hard("kelvin_voigt") + jump_of("tip.force.x", -5.0, 0.012)
    parameters = ["signal.push.time[2]", "signal.pull.time[2]", "link[1].mass"]
    run = simulate(parse_scene(text, "x"), sensitivities=parameters)
    assert np.isnan(run.impact_sensitivity("peak_force", parameters[0])[0])
    assert np.isnan(run.impact_sensitivity("peak_force", parameters[1])[0])
    assert np.isfinite(run.impact_sensitivity("peak_force", parameters[2])[0])


def pushed(frequency):
    """Return a cart with dry friction of 1 N, under a force that is a sine with an amplitude of 1.05 N."""
    table = {
        "name": "Pushed",
        "chain": {
            "base": "slider",
            "slider": {"mass": 1.0, "friction": 1.0},
            "links": [{"length": 0.5, "mass": 0.1}],
        },
        "initial": {"angles": [-math.pi / 2]},
        "contact": {"points": []},
        "inputs": {"slider_force": True},
        "signals": {
            "push": {"input": "slider.force", "form": "sine", "amplitude": 1.05, "frequency": frequency}
        },
    }
    return scene_from_dict(table, "pushed")


@pytest.mark.parametrize("frequency", [1.0, 20.0, 50.0])
def test_slips_between_the_stages_of_a_long_step_are_found(frequency):
    run = simulate(pushed(frequency), 2.0)
    # the cart sticks at first, and slips and sticks again in each half of a period
    assert len(run.stick_slip) == 1 + 2 * 2 * 2.0 * frequency


@pytest.mark.parametrize("frequency", [20.0, 30.0])
def test_a_held_ball_that_is_pulled_briefly_leaves_the_floor_each_time(frequency):
    table = {
        "name": "Pulled",
        "gravity": [0.0, -9.81],
        "chain": {"links": [{"length": 0.1, "mass": 1.0, "center_of_mass": 0.0, "inertia": 0.004}]},
        "box": {"y_min": 0.0},
        "contact": {"model": "newton_impact", "restitution": 0.0, "points": [1]},
        "initial": {"position": [0.0, 0.1], "angles": [-math.pi / 2]},
        "inputs": {"tip_force": True},
        "signals": {
            "pull": {"input": "tip.force.y", "form": "sine", "amplitude": 10.0, "frequency": frequency}
        },
    }
    assert len(simulate(scene_from_dict(table, "pulled"), 1.0).impacts) == 1 + frequency
