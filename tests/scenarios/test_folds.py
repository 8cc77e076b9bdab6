"""Held chains that fold: where links lie on each other, the constraints of the walls become dependent."""

# Tests: kernel/constraints/impulses.py, kernel/ode/folds.py

import math

import numpy as np
import pytest
from scipy.integrate import quad

from chain_impact import simulate
from chain_impact.scene.scene import scene_from_dict, with_values
from chain_impact.simulation.instance import Instance
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
def test_links_that_fold_in_a_corner_strike_at_the_time_of_the_closed_form(angles):
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


STIFFNESS, REST_ANGLE = 0.1, -3.5  # N·m/rad and rad, of a spring that folds two links


def pair(turn, tolerance, stiffness):
    """Return two links whose tip slides on a rigid floor at the height of their base, turned by an angle."""
    spring = {"joint_stiffness": stiffness, "joint_rest_angle": REST_ANGLE} if stiffness else {}
    links = [{"length": LENGTH, "mass": MASS}, {"length": LENGTH, "mass": MASS, **spring}]
    table = {
        "name": "Fold",
        "gravity": [GRAVITY * math.sin(turn), -GRAVITY * math.cos(turn)],
        "chain": {"base": "pinned", "links": links},
        "walls": [{"name": "floor", "point": [0.0, 0.0], "angle": turn}],
        "contact": {"model": "newton_impact", "restitution": 0.0, "points": [2]},
        "initial": {"angles": [turn + 1.2, turn - 1.2], "angular_velocities": [3.0, -3.0]},
        "solver": {"tolerance": tolerance},
    }
    return scene_from_dict(table, "fold")


def pair_motion(angle, omega, stiffness):
    """Return the acceleration of the first link's angle [rad/s²] and the force of the floor [N].

    The second link has the opposite angle. Lagrange's equations for both angles contain the moment of the
    floor, force times LENGTH times the cosine, and the moment of the spring.
    """
    unit = MASS * LENGTH**2
    weight, moment = GRAVITY / LENGTH * math.cos(angle), stiffness * (REST_ANGLE + 2.0 * angle) / unit
    turning = math.sin(2.0 * angle) * omega**2
    acceleration = -(turning + weight + 2.0 * moment) / (5 / 3 - math.cos(2.0 * angle))
    held = (0.5 * math.cos(2.0 * angle) - 1 / 3) * acceleration - 0.5 * turning + 0.5 * weight - moment
    return acceleration, unit * held / (LENGTH * math.cos(angle))


def rows_before_fold(scene, turn, distances):
    """Return rows of outputs where the angles are at some distances [rad] from the fold."""
    run = simulate(scene, stop_time=0.3, output_step=1e-3)
    angle, omega = run["link[1].angle"] - turn, run["link[1].angular_velocity"]
    row = int(np.flatnonzero(angle < 0.5 * math.pi)[-1])
    fold = run.time[row] + (0.5 * math.pi - angle[row]) / omega[row]
    instance = Instance(scene)
    rows = np.zeros(len(distances), instance.record.dtype["output"])
    assert instance.trajectory(fold - np.asarray(distances) / omega[row], rows) == len(rows)
    return rows


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1.22e-6, 1e-7, 1e-8, 1e-10, 1.15e-10], ids=str)
@pytest.mark.parametrize("turn", [0.0, 0.3], ids=str)
def test_rows_near_a_fold_have_the_forces_of_the_closed_form(turn, tolerance):
    """Nearer than about 1e-2 rad, the error of the state over the mobility would be a part of the force."""
    for row in rows_before_fold(pair(turn, tolerance, 0.0), turn, 10.0 ** np.arange(-2.0, -9.1, -0.25)):
        acceleration, force = pair_motion(row["angle"][0] - turn, row["angular_velocity"][0], 0.0)
        assert row["force"][0] == pytest.approx(force, rel=2e-4)
        assert row["angular_acceleration"][0] == pytest.approx(acceleration, abs=1e-4)


def test_a_force_that_grows_without_bound_toward_a_fold_is_kept():
    for row in rows_before_fold(pair(0.3, 1e-10, STIFFNESS), 0.3, [1e-2, 3e-3, 1e-3, 3e-4]):
        angle = row["angle"][0] - 0.3
        _, force = pair_motion(angle, row["angular_velocity"][0], STIFFNESS)
        assert force > 0.01 / (0.5 * math.pi - angle)
        assert row["force"][0] == pytest.approx(force, rel=1e-4)
