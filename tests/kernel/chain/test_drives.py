"""Drives of joints and of a slider: coordinates, forces, powers, modes and loads, by hand."""

# Tests: kernel/chain/drives.py, kernel/chain/slider.py

import math

import numpy as np
import pytest

from chain_impact.kernel.chain import drives
from chain_impact.kernel.chain.kinematics import clear_joints, clear_vectors
from chain_impact.kernel.constraints.geometry import dot, row_of_drive
from chain_impact.scene.scene import scene_from_dict
from tests.kernel.chains import initialized

ANGLE = 0.3  # rad, of the line
LINE = np.array([math.cos(ANGLE), math.sin(ANGLE)])
DAMPING, STIFFNESS, REST, LIMIT, MOTOR = (0.5, 0.7), (3.0, 40.0), (0.2, -0.1), (9.0, 25.0), (1.5, 2.5)
POSITION, RATE = (0.6, 0.35), (-0.8, 1.2)  # rad and m; rad/s and m/s, of joint 1 and of the slider


@pytest.fixture(params=[False, True], ids=["passive", "limited"])
def cart(request):
    """Return a cart with a pole of 0.5 m, each with a drive, its state and whether the drives have limits."""
    limits = [{"joint_torque_limit": LIMIT[0]}, {"force_limit": LIMIT[1]}] if request.param else [{}, {}]
    pole = {"joint_damping": DAMPING[0], "joint_stiffness": STIFFNESS[0], "joint_rest_angle": REST[0]}
    line = {"damping": DAMPING[1], "stiffness": STIFFNESS[1], "rest_position": REST[1], "friction": 0.2}
    table = {
        "name": "Cart",
        "chain": {
            "base": "slider",
            "slider": {"angle": ANGLE, "mass": 2.0} | line | limits[1],
            "links": [{"length": 0.5, "mass": 0.5} | pole | limits[0]],
        },
        "contact": {"points": []},
        "inputs": {"slider_force": True, "joint_torques": True},
        "initial": {"position": [1.0, -2.0], "angles": [0.0]},
    }
    d = initialized(scene_from_dict(table, "cart"))
    d.inputs.motor[:] = MOTOR
    y = np.zeros(len(d.step.state))
    y[:2], y[2] = np.array([1.0, -2.0]) + POSITION[1] * LINE, POSITION[0]
    y[3:5], y[5] = RATE[1] * LINE, RATE[0]
    return d, y, request.param


@pytest.mark.parametrize("i", [0, 1], ids=["joint", "slider"])
def test_the_drive_of_a_joint_and_of_a_slider_act_along_their_coordinates(cart, i):
    d, y, limited = cart
    assert drives.drive_component(d, y, 3, i) == pytest.approx(RATE[i], rel=1e-14)
    assert drives.spring_stretch(d, y, i) == pytest.approx(POSITION[i] - REST[i], rel=1e-14)
    spring, damper = STIFFNESS[i] * (POSITION[i] - REST[i]), DAMPING[i] * RATE[i]
    force = MOTOR[i] - damper - spring
    assert drives.unlimited_force(d, y, i) == pytest.approx(force, rel=1e-13)
    powers = (force, 0.0, force * RATE[i])
    if not limited:
        powers = (MOTOR[i] - damper, damper * RATE[i], MOTOR[i] * RATE[i])
    assert drives.force_and_powers_of_drive(d, y, i) == pytest.approx(powers, rel=1e-13)
    d.drive.mode[i] = -1
    if limited:
        assert drives.force_and_powers_of_drive(d, y, i) == pytest.approx(
            (-LIMIT[i], 0.0, -LIMIT[i] * RATE[i]), rel=1e-13
        )


def test_the_margin_is_that_of_the_drive_nearest_to_its_end(cart):
    """The force of the slider counts times the length of the link."""
    d, y, limited = cart
    moments = [MOTOR[i] - DAMPING[i] * RATE[i] - STIFFNESS[i] * (POSITION[i] - REST[i]) for i in range(2)]
    margins = [LIMIT[0] - abs(moments[0]), 0.5 * (LIMIT[1] - abs(moments[1]))]
    assert drives.mode_margin(d, y) == pytest.approx(min(margins) if limited else math.inf, rel=1e-9)
    d.inputs.motor[1] = MOTOR[1] - 40.0
    past = 0.5 * (LIMIT[1] - abs(moments[1] - 40.0))
    assert drives.mode_margin(d, y) == pytest.approx(past if limited else math.inf, rel=1e-9)
    d.drive.mode[1] = -1
    least = min(margins[0], -past) if limited else math.inf
    assert drives.mode_margin(d, y) == pytest.approx(least, rel=1e-9)


@pytest.mark.parametrize("i", [0, 1], ids=["joint", "slider"])
def test_a_load_of_a_drive_does_its_work_along_the_row_of_the_drive(cart, i):
    d, y, _ = cart
    clear_vectors(d, d.scratch.applied_force)
    clear_joints(d.scratch.applied_force)
    drives.apply_drive_force(d, d.scratch.applied_force, i, 3.0)
    base = 3.0 * LINE if i == 1 else np.zeros(2)
    assert (d.scratch.applied_force.x[0], d.scratch.applied_force.y[0]) == pytest.approx(
        tuple(base), rel=1e-14
    )
    assert d.scratch.applied_force.joint[0] == (3.0 if i == 0 else 0.0)
    if i == 1:
        d.scratch.velocity.x[0], d.scratch.velocity.y[0] = y[3:5]
        assert dot(row_of_drive(d, i), d.scratch.velocity) == pytest.approx(RATE[1], rel=1e-14)
