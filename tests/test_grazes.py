"""Grazes: a point that goes behind a wall by a little, or all but reaches it, for motions in closed form.

How far it gets is known, and so is by how much the run errs there: the same run without the wall tells. An
impact that goes deeper than that error has to be found, and a point that stays further away has none. Laws of
force leave out what is less than HARMLESS of a link length deep, a picometre.
"""

import math

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.kernel.model.geometry import HARMLESS
from chain_impact.scene import scene_from_dict, with_values

CASES = 500  # of each motion
ROUND_OFF = 2e-14  # m, of positions of some metres


def draw(random, motion):
    """A free rod in a box that it does not reach, when its tip is highest [s], and how high it is then [m].

    Its base is the highest point of neither motion.
    """
    length, speed = random.uniform(0.3, 2.0), random.uniform(1.0, 9.0)
    gravity = random.uniform(1.0, 20.0) if motion == "thrown" else 0.0
    if motion == "thrown":
        # it does not turn: the tip goes along a parabola
        angle, spin, velocity = random.uniform(0.2, 1.2), 0.0, [random.uniform(-3.0, 3.0), speed]
        top = speed / gravity
        height = length * math.sin(angle) + 0.5 * speed * top
    else:
        # it turns about its middle, which goes along a wall
        angle, spin = random.uniform(-1.4, 0.0), speed
        drift = random.uniform(-3.0, 3.0)
        middle = 0.5 * length * np.array([math.cos(angle), math.sin(angle)])
        velocity = [drift + spin * middle[1], -spin * middle[0]]
        top = (0.5 * math.pi - angle) / spin
        height = middle[1] + 0.5 * length
    table = {
        "name": "Graze",
        "gravity": [0.0, -gravity],
        "chain": {"links": [{"length": length, "mass": random.uniform(0.1, 3.0)}]},
        "initial": {
            "position": [0.0, 0.0],
            "velocity": velocity,
            "angles": [angle],
            "angular_velocities": [spin],
        },
        "box": {"y_max": 100.0},
        "contact": {"points": [1], "model": random.choice(["hertz", "newton_impact", "kuwabara_kono"])},
        "solver": {"tolerance": 10.0 ** random.uniform(-12.0, -3.0)},
        "simulation": {"stop_time": top},
    }
    return scene_from_dict(table, "graze"), top, height


@pytest.mark.parametrize("motion", ["thrown", "spinning"])
def test_every_graze_is_found_and_no_other(motion):
    random, clear = np.random.default_rng(len(motion)), 0
    for case in range(CASES):
        scene, top, height = draw(random, motion)
        free = simulate(scene, output_step=math.inf, output=["point[1].y"])
        error = abs(free["point[1].y"][-1] - height) + ROUND_OFF
        depth = random.choice([-1.0, 1.0]) * 10.0 ** random.uniform(-12.0, -3.0)
        walled = with_values(
            scene, {("box", "y_max"): height - depth, ("simulation", "stop_time"): 1.2 * top}
        )
        found = len(simulate(walled, output_step=math.inf, output=()).impacts)
        harmless = 0.0 if scene.contact.model == "newton_impact" else HARMLESS * scene.chain.links[0].length
        if abs(depth) > error + (harmless if depth > 0.0 else 0.0):
            clear += 1
            assert (found > 0) == (depth > 0.0), (case, depth, error, scene)
    assert clear > 0.5 * CASES
