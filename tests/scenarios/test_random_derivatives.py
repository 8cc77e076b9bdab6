"""Derivatives in every row and of every impact, against differences of two sizes, in many scenes."""

import pytest

from tests.helpers.campaigns.random_derivatives import KINDS, check, compare
from tests.helpers.scenes.derivative_scenes import link, start, table

FEW, MANY = 2, 8
MASS = ["link[1].mass"]


def overlapping():
    """Return a rod that falls on a soft floor; a contact ends at each end while the other contact lasts."""
    return table(
        [link(0.3, 1.4)],
        box={"y_min": 0.0},
        contact={"model": "tsuji", "restitution": 0.45, "stiffness": 4e4},
        initial=start(position=[0.0, 1.0], velocity=[1.7, -0.3], angles=[0.26], spins=[2.6]),
        outputs={"loads": True},
        solver={"tolerance": 1e-10},
        simulation={"stop_time": 1.2, "step_size": 5e-4},
    )


def let_go():
    """Return two links that come to rest at a rigid stop by small impacts, and fall back from it at 0.9 s."""
    limits = {"min": -1.5, "max": 1.5}
    return table(
        [link(0.5, 1.6, damping=0.01, **limits), link(0.4, 0.3, damping=0.06, **limits)],
        base="pinned",
        contact={"model": "newton_impact", "restitution": 0.4},
        initial=start(angles=[-0.9, -0.6]),
        outputs={"loads": True},
        solver={"tolerance": 1e-10},
        simulation={"stop_time": 1.5, "step_size": 1e-3},
    )


def saturated():
    """Return a falling arm with three stiff servos, whose forces are largest at the limits of the drives."""
    joints = ((0.48, 0.66, 160.0, 68.0, 3.3), (0.47, 3.9, 1.7e4, 2.5, 65.0), (0.41, 0.23, 4.5e4, 39.0, 58.0))
    names = ("length", "mass", "joint_stiffness", "joint_damping", "joint_torque_limit")
    return table(
        [dict(zip(names, joint, strict=True)) | {"joint_armature": 0.01} for joint in joints],
        base="pinned",
        box={"y_min": -0.5},
        contact={"restitution": 0.3, "stiffness": 1e6},
        inputs={"joint_targets": True},
        initial=start(angles=[0.14, -0.1, -0.01]),
        outputs={"loads": True},
        solver={"tolerance": 1e-9},
        simulation={"stop_time": 0.2, "step_size": 1e-3},
    )


@pytest.mark.parametrize("scene", [overlapping, let_go, saturated])
def test_derivatives_of_chosen_scenes_equal_differences(scene):
    comparison = compare(scene(), {}, MASS)
    assert comparison.compared > 3000
    assert comparison.wrong[:3] == []


@pytest.mark.full("more cases", but=3)
@pytest.mark.parametrize("kind", KINDS)
def test_derivatives_of_random_scenes_equal_differences(kind):
    comparisons = [check(kind, seed) for seed in range(FEW)]
    assert sum(comparison.compared for comparison in comparisons) > 1000
    assert [comparison.wrong[:3] for comparison in comparisons] == [[]] * FEW


@pytest.mark.full("more scenes")
@pytest.mark.parametrize("kind", KINDS)
def test_more_random_scenes(kind):
    comparisons = {seed: check(kind, seed) for seed in range(FEW, FEW + MANY)}
    assert sum(comparison.rows for comparison in comparisons.values()) > 2_500
    assert {seed: comparison.wrong[:3] for seed, comparison in comparisons.items() if comparison.wrong} == {}
