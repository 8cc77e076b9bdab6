"""Peak values of contacts at loose tolerances: a step may begin before a peak and end with the contact."""

import numpy as np
import pytest

from chain_impact.simulation.instance import Instance
from tests.problems import GRAVITY, build

STIFFNESS = 1e8


@pytest.mark.parametrize("tolerance", [3e-3, 1e-3])
@pytest.mark.parametrize("seed", range(30))
def test_the_largest_force_of_an_elastic_contact_is_that_at_its_largest_depth(seed, tolerance):
    """F = K δ^(3/2)."""
    random = np.random.default_rng(seed)
    initial = {
        "position": [0.0, 0.01],
        "velocity": [0.0, -(10 ** random.uniform(-1, 1))],
        "angles": [random.choice([0.0, 1e-3, 0.3])],
        "angular_velocities": [random.uniform(-3, 3)],
    }
    link, contact = {"length": 0.5, "mass": 1.0}, {"model": "hertz", "stiffness": STIFFNESS}
    scene = build("Rod", [link], initial, {"y_min": 0.0}, contact, gravity=GRAVITY, tolerance=tolerance)
    instance = Instance(scene)
    instance.advance(0.3)
    found = instance.collect()
    assert len(found) > 1
    expected = STIFFNESS * found["max_penetration"] ** 1.5
    np.testing.assert_allclose(found["peak_force"], expected, rtol=5e-3)
