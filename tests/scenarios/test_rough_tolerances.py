"""The cost of a tighter tolerance with sliding and sticking points: a few times the work in every scene.

Forces that depend on the number of iterations jump within a step. The error estimate includes the jump, which
no step size reduces, once the tolerance is below the jump.
"""

import math

import numpy as np
import pytest

from chain_impact.kernel.status import OK
from chain_impact.scene.scene import scene_from_dict
from chain_impact.simulation.instance import Instance

TOLERANCES = (1e-8, 1e-10, 1e-12)
DEARER = 5.0  # maximal ratio of evaluations for two decades of the tolerance
WORK = 1e6  # evaluations per second of simulated time, far above the needs of these scenes
LAWS = ("flores", "hunt_crossley", "lankarani_nikravesh", "kuwabara_kono", "tsuji")


def rough(seed, tolerance):
    """Return a chain of up to five links that is thrown, or laid, into a box with friction."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 6))
    base = "free" if rng.random() < 0.7 else "pinned"
    links = [{"length": rng.uniform(0.2, 0.6), "mass": rng.uniform(0.5, 2.0)} for _ in range(count)]
    angles = rng.uniform(-math.pi, math.pi, count)
    if rng.random() < 0.3:
        angles = np.array([rng.choice([0.0, math.pi]) for _ in range(count)])
    lengths = np.array([link["length"] for link in links])
    x, y = (np.append(0.0, np.cumsum(lengths * part)) for part in (np.cos(angles), np.sin(angles)))
    box = {"y_min": y.min() - rng.choice([0.0, rng.uniform(0.01, 0.5)])}
    if rng.random() < 0.5:
        box |= {"x_min": x.min() - rng.uniform(0.02, 0.5), "x_max": x.max() + rng.uniform(0.02, 0.5)}
    friction = 10.0 ** rng.uniform(-1.5, 0.3)
    contact = {
        "model": str(rng.choice(LAWS)),
        "restitution": rng.uniform(0.05, 0.9),
        "stiffness": 10.0 ** rng.uniform(5, 9),
        "friction": friction,
    }
    if rng.random() < 0.4:
        contact["static_friction"] = friction * rng.uniform(1.0, 1.6)
    velocity = [0.0, 0.0] if base == "pinned" else rng.uniform(-2, 2, 2).tolist()
    spins = rng.uniform(-6, 6, count).tolist()
    if rng.random() < 0.3:
        velocity, spins = [0.0, 0.0], [0.0] * count
    table = {
        "name": f"Rough{seed}",
        "gravity": [0.0, -9.81],
        "chain": {"base": base, "links": links},
        "box": box,
        "contact": contact,
        "initial": {"angles": angles.tolist(), "velocity": velocity, "angular_velocities": spins},
        "solver": {"tolerance": tolerance, "work_limit": WORK},
        "simulation": {"stop_time": 1.0},
    }
    return scene_from_dict(table, f"rough {seed}")


def evaluations(seed, tolerance):
    instance = Instance(rough(seed, tolerance))
    assert instance.advance(1.0) == OK
    return instance.statistics["rhs_evaluations"]


@pytest.mark.full("more cases", but=10)
@pytest.mark.parametrize("seed", [*range(48), 306, 590, 710, 715, 798, 799, 886, 1082])
def test_two_decades_of_the_tolerance_cost_a_few_times_as_much(seed):
    """In the scenes after the first 48 chains lie flat, and several points stick at once."""
    work = [evaluations(seed, tolerance) for tolerance in TOLERANCES]
    assert work[1] <= DEARER * work[0]
    assert work[2] <= DEARER * work[1]
