"""Dry friction with dependent constraints: rest continues, with forces within all limits."""

import math

import numpy as np
import pytest

from chain_impact import SimulationError
from tests.helpers.campaigns.arches import KINDS, run

# scenes in which no distribution in proportion to the limits is within all limits
DEPENDENT = [
    *(("arch", seed) for seed in (1, 3, 5, 7, 11, 19, 23, 24, 25, 30, 32)),
    *(("slope", seed) for seed in (16, 28)),
    *(("floor", seed) for seed in (1, 3, 34)),
]


def wall_of(result):
    """Return the name of the wall that a chain lies on, and its direction t."""
    scene = result.scene
    if not scene.walls:
        return "y_min", np.array([1.0, 0.0])
    angle = scene.walls[0].angle
    return scene.walls[0].name, np.array([math.cos(angle), math.sin(angle)])


@pytest.mark.full("more cases", but=3)
@pytest.mark.parametrize(("kind", "seed"), DEPENDENT)
def test_rest_goes_on_by_forces_within_their_limits(kind, seed):
    """Each row fulfils Coulomb's limits, Newton's law along the wall, and the energy balance."""
    result = run(kind, seed, output_step=0.02)
    scene, (wall, along) = result.scene, wall_of(result)
    size, links = max(link.length for link in scene.chain.links), scene.chain.links
    largest = scene.contact.static_friction or scene.contact.friction
    friction, weight = np.zeros(len(result.time)), sum(link.mass for link in links) * 9.81
    for k in range(len(links) + 1):
        normal = result[f"contact[{k}].{wall}.force"]
        own = result[f"contact[{k}].{wall}.friction_force"]
        assert (np.abs(own) <= largest * normal + 1e-8 * weight).all()
        friction += own
    for i, link in ((i, link) for i, link in enumerate(links[1:], 2) if link.joint_friction > 0.0):
        moment = result[f"joint[{i}].friction_moment"]
        assert (np.abs(moment) <= link.joint_friction + 1e-8 * weight * size).all()
    # m a = friction + weight, along the wall
    needed = np.zeros(len(result.time))
    for i, link in enumerate(links):
        inner, outer = ([result[f"point[{k}].{a}"] for a in ("ax", "ay")] for k in (i, i + 1))
        ratio = link.center_of_mass / link.length if link.center_of_mass else 0.5
        center = np.array(inner) + ratio * (np.array(outer) - np.array(inner))
        needed += link.mass * (along @ center - along @ np.array([0.0, -9.81]))
    np.testing.assert_allclose(friction, needed, atol=1e-9 * weight)
    energy = result["energy.total"] + result["energy.dissipated"]
    if scene.inputs.joint_torques:
        energy = energy - result["energy.supplied"]
    np.testing.assert_allclose(energy, energy[0], rtol=1e-5)


@pytest.mark.full("takes long")
@pytest.mark.parametrize("kind", KINDS)
def test_no_random_chain_on_a_rough_floor_ends_early(kind):
    early = {}
    for seed in range(80):
        try:
            run(kind, seed, output_step=math.inf, output=[])
        except SimulationError as error:
            early[seed] = error.status
    assert not early
