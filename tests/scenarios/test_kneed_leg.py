"""The knee strike of a walker: the stop, against the conservation of two angular momenta."""

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from tests.helpers.literature.walker import (
    BENT,
    LOCK,
    MASSES,
    PUBLISHED,
    SLOPE,
    STRAIGHT,
    UPRIGHT,
    Walker,
    equations,
)

MODEL = "kneed_leg"


def test_the_scene_has_the_masses_and_the_start_of_the_source():
    scene = load_scene(MODEL)
    first = scene.chain.links[0]
    standing, arms = MASSES[:3], -BENT[:3, 0]
    assert first.mass == pytest.approx(standing.sum(), abs=1e-15)
    assert first.mass * first.center_of_mass == pytest.approx(standing @ arms, abs=1e-15)
    about_the_foot = first.inertia + first.mass * first.center_of_mass**2
    assert about_the_foot == pytest.approx(standing @ arms**2, abs=1e-15)
    assert [(link.mass, link.center_of_mass) for link in scene.chain.links[1:]] == [
        (0.5, 0.325),
        (0.05, 0.125),
    ]
    q = np.array(scene.initial.angles) - UPRIGHT
    stance, rate, swinging = map(float, PUBLISHED)
    assert q == pytest.approx([stance, -0.2884, -0.2884], abs=1e-15)
    # both feet are on the slope, within the rounding of the published angles
    assert q[0] + q[1] == pytest.approx(-2 * SLOPE, abs=1.01e-4)
    assert scene.initial.angular_velocities == (rate, swinging, swinging)


def test_the_knee_then_leans_on_its_stop_as_a_locked_leg_does():
    """The moment of the stop equals the residual of the shank's equation in the locked leg's motion."""
    walker, result = Walker(load_scene(MODEL)), simulate(MODEL, tolerance=1e-12)
    late = result.time > walker.onset
    angles, rates = walker.angles(result.time)
    np.testing.assert_allclose(result.angles, angles, rtol=0, atol=1e-9)
    np.testing.assert_allclose(result.angular_velocities, rates, rtol=0, atol=1e-8)
    assert result.angles[late, 2] == pytest.approx(result.angles[late, 1], rel=0, abs=1e-12)
    moment = result["joint[3].stop_moment"]
    assert (moment[~late] == 0.0).all()
    assert (moment[late] < 0.0).all()
    for row in np.flatnonzero(late)[::50]:
        q, w = np.split(walker.locked.sol(result.time[row]), 2)
        turns = LOCK @ np.linalg.solve(*equations(STRAIGHT, q, w, walker.g))
        matrix, forces = equations(BENT, LOCK @ q, LOCK @ w, walker.g)
        assert moment[row] == pytest.approx((matrix @ turns - forces)[2], abs=1e-10)
