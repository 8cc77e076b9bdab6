"""Bricks, feet, arms with offsets, carts and hoppers, against an independent model in the tests."""

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from chain_impact.scene.scene import Scene, scene_from_dict
from tests.helpers.models.body_model import motion
from tests.helpers.models.kept_answers import kept
from tests.helpers.scenes.bodies import body, cart
from tests.helpers.scenes.derivative_scenes import as_arrays, from_arrays

ARM = {
    "name": "Arm",
    "chain": {
        "base": "pinned",
        "links": [
            {"length": 0.4, "mass": 1.0, "center_of_mass": 0.25, "center_of_mass_offset": 0.06},
            {
                "length": 0.3,
                "mass": 0.6,
                "center_of_mass": -0.05,
                "center_of_mass_offset": -0.04,
                "joint_stiffness": 2.0,
                "joint_damping": 0.02,
                "points": [{"x": 0.32, "y": 0.05, "radius": 0.02}, {"x": 0.35, "y": -0.03}],
            },
        ],
    },
    "box": {"x_min": -0.6, "x_max": 0.65},
    "contact": {"stiffness": 1e6, "restitution": 0.6, "friction": 0.2, "points": [2]},
    "initial": {"angles": [0.3, 1.0], "angular_velocities": [1.0, -4.0]},
}


def hopper() -> Scene:
    # a straight fall would land without tangential speed, where the model cannot decide the direction of slip
    return load_scene("hopper").with_values({"initial.angular_velocities": [0.5, -0.8]})


# name → the scene, and the end [s]
CASES = {
    "arm": (lambda: scene_from_dict(ARM, "arm"), 0.8),
    "brick": (lambda: load_scene("thrown_brick"), 0.9),
    "cart": (cart, 0.6),
    "foot": (body, 0.5),
    "hopper": (hopper, 0.45),
}


@pytest.mark.parametrize("name", CASES)
def test_a_body_moves_as_an_independent_model_does(name):
    """Onsets agree within 1e-9 s, other data of impacts within 1e-7, and places at five times within 1e-8."""
    make, end = CASES[name]
    scene, times = make(), tuple(end / 5 * np.arange(1, 6))
    answer = kept(lambda: as_arrays(motion(scene, times)), "tests.helpers.models.body_model", scene, times)
    exact = from_arrays(answer)
    result = simulate(scene, end, output_step=end / 5, tolerance=1e-12)
    assert result.impacts["point"].tolist() == exact.points.tolist()
    assert result.impacts["wall"].tolist() == exact.walls.tolist()
    assert len(exact.points) > 0
    np.testing.assert_allclose(result.impacts["onset"], exact.impacts["onset"], rtol=0.0, atol=1e-9)
    for quantity in ("peak_force", "max_penetration", "impulse", "impact_speed", "separation_speed"):
        np.testing.assert_allclose(result.impacts[quantity], exact.impacts[quantity], rtol=1e-7)
    links = range(1, len(scene.chain.links) + 1)
    for output in (*(f"point[{k}].{axis}" for k in (0, *links) for axis in "xy"), "link[1].angle"):
        np.testing.assert_allclose(result[output][1:], exact.values[output], rtol=0.0, atol=1e-8)
