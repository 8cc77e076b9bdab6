"""Held chains that fold: where links lie on each other, the constraints of the walls become dependent."""

# Tests: kernel/rows/constraints.py

import math

import numpy as np
import pytest
from scipy.integrate import quad

from chain_impact import simulate
from chain_impact.scene.scene import with_values
from tests.helpers.scenes.problems import GRAVITY, default_scene

LENGTH, MASS = 0.5, 1.0  # m, kg; of all links
# rad, angles at the start of the default chain with which its last two links fold in a corner
FOLDING = [
    [0.3498634644026895, -0.47907713415390196, 0.8148317684257697, -0.1855208691670002],
    [0.33057537347613675, -0.503945995123724, 0.8249000832399442, -0.1650235509898999],
    [0.3177714982559856, -0.5366417144185155, 0.8091698808152825, -0.2096727124967495],
]


def duration(inertia, begin, speed):
    """Return the time [s] until two links, with both ends of the pair on the floor, lie on each other.

    Both links have the same angle from the vertical, ``begin`` [rad] at the start, and turn at the ``speed``
    [rad/s]. ``inertia`` [kg m²] of the whole chain is a function of this angle. The time follows from the
    energy.
    """

    def potential(angle):
        return MASS * GRAVITY * LENGTH * math.cos(angle)

    energy = 0.5 * inertia(begin) * speed**2 + potential(begin)

    def slowness(angle):
        return math.sqrt(0.5 * inertia(angle) / (energy - potential(angle)))

    return quad(slowness, 0.0, begin, epsabs=1e-13, epsrel=1e-13)[0]


def pair_inertia(angle):
    """Return the inertia [kg m²] of two links, of which one turns about its end on the floor."""
    turning = 1 / 3 + 1 / 12 + 2.25 * math.cos(angle) ** 2 + 0.25 * math.sin(angle) ** 2
    return MASS * LENGTH**2 * turning


@pytest.mark.parametrize("angles", FOLDING, ids=str)
def test_links_that_fold_in_a_corner_strike_the_wall_at_the_time_of_the_closed_form(angles):
    """Links 1 and 2 slide on the floor, point 4 rests in the corner, and point 2 moves toward it."""
    scene = default_scene(model="newton_impact", restitution=0.3)
    scene = with_values(scene, {("initial", "angles"): tuple(angles)})
    result = simulate(scene, stop_time=3.0)
    wall = scene.box.x_max
    impacts = result.impacts
    (struck,) = impacts[(impacts["point"] == 2) & (impacts["wall"] == 1) & (impacts["onset"] > 2.0)]
    row = np.searchsorted(result.time, struck["onset"] - 0.05)
    gap, speed = wall - result["point[2].x"][row], result["point[2].vx"][row]
    tilt = math.asin(0.5 * gap / LENGTH)
    rate = 0.5 * speed / (LENGTH * math.cos(tilt))

    def inertia(angle):
        return pair_inertia(angle) + 2 * MASS * (2 * LENGTH * math.cos(angle)) ** 2

    expected = result.time[row] + duration(inertia, tilt, rate)
    assert struck["onset"] == pytest.approx(expected, abs=2e-8)
