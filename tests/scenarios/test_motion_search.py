"""Random scenes with a moving base and walls: no contact is missed, and the energy balance closes."""

import math

import numpy as np
import pytest

from chain_impact import SimulationError, simulate
from chain_impact.kernel.status import (
    BASE_BEYOND_WALL,
    EVENT_STORM,
    FORCES_NOT_FOUND,
    NO_ROOM,
    STEP_TOO_SMALL,
    TOO_MUCH_WORK,
)
from tests.helpers.campaigns.random_parts import Draw, upright

SQUEEZED = (NO_ROOM, STEP_TOO_SMALL, EVENT_STORM, FORCES_NOT_FOUND)
"""The statuses with which a run may end whose closing walls leave no room for the chain."""
NORMALS = {"x_min": (1.0, 0.0), "x_max": (-1.0, 0.0), "y_min": (0.0, 1.0), "y_max": (0.0, -1.0)}


def moving(seed):
    """Return the scene of a seed with a base and walls that move, and its inputs."""
    scene, draw = upright(seed, (1, 4)), Draw(seed, 77)
    changes = {"inputs.wall_motion": True, "inputs.base_motion": scene.chain.base == "pinned"}
    changes |= {"inputs.joint_torques": False, "inputs.tip_force": False}
    if scene.contact.model != "newton_impact" and draw.chance(0.3):
        changes["contact.friction"] = 0.4
    scene = scene.with_values(changes)
    size, stop = max(link.length for link in scene.chain.links), scene.simulation.stop_time

    def swinging(start):
        amplitude, rate = size * draw.power(1e-3, 0.3), draw.power(1.0, 60.0) / stop
        return lambda t: start + amplitude * (1.0 - math.cos(rate * t))

    inputs = {}
    if scene.inputs.base_motion:
        inputs = {f"base.{axis}": swinging(scene.initial.position[j]) for j, axis in enumerate("xy")}
    for wall in scene.moving_walls:
        if draw.chance(0.6):
            inputs[f"wall.{wall}.displacement"] = swinging(0.0)
        if draw.chance(0.4):
            inputs[f"wall.{wall}.belt_speed"] = size * draw.power(0.01, 3.0)
    return scene, inputs


def check(seed):
    """Simulate the scene of a seed, and check its energy balance and its walls.

    Return the status with which the run ends: 0, or the reason of an early end.
    """
    scene, inputs = moving(seed)
    status = 0
    try:
        result = simulate(scene, inputs=inputs)
    except SimulationError as error:
        result, status = error.result, error.status
    if result is None:
        return status
    links, tolerance = scene.chain.links, scene.solver.tolerance
    size, mass = max(link.length for link in links), sum(link.mass for link in links)
    balance = result["energy.total"] + result["energy.dissipated"] - result["energy.supplied"]
    scale = mass * size**2 + sum(
        np.abs(result[f"energy.{name}"]).max() for name in ("kinetic", "potential", "supplied", "dissipated")
    )
    # in a forced implicit step the interpolant is less accurate than the end of the step
    factor = 300.0 if scene.solver.method != "implicit" else 1e4
    assert np.ptp(balance) < factor * tolerance * scale, seed
    for wall in scene.moving_walls:
        nx, ny = NORMALS[wall]
        moved = inputs.get(f"wall.{wall}.displacement", lambda _: 0.0)
        offset = (nx + ny) * getattr(scene.box, wall) + np.array([moved(t) for t in result.time])
        for point in scene.contact.points:
            place = nx * result[f"point[{point}].x"] + ny * result[f"point[{point}].y"]
            depth = offset + scene.contact.radius - place
            beyond = (depth - result[f"contact[{point}].{wall}.penetration"]).max()
            assert beyond < size * (1e-9 + 100.0 * tolerance * len(links)), (seed, wall, point)
    return status


@pytest.mark.parametrize("seed", range(16))
def test_no_contact_is_missed_and_the_energy_balance_is_kept(seed):
    check(seed)


@pytest.mark.full("takes long")
@pytest.mark.parametrize("first", range(0, 800, 100))
def test_most_runs_end_as_they_should(first):
    statuses = [check(seed) for seed in range(first, first + 100)]
    assert set(statuses) <= {0, BASE_BEYOND_WALL, TOO_MUCH_WORK, *SQUEEZED}
    assert sum(status in SQUEEZED for status in statuses) <= 5
