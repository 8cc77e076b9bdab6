"""Stiff springs at loose tolerances: errors bring no more than a fifth of what there was, or the run ends."""

import numpy as np
import pytest

from chain_impact.kernel.status import OK
from chain_impact.scene.scene import SOLVER_METHODS
from chain_impact.simulation.instance import Instance
from tests.problems import build

FIFTH = 0.2
SECONDS = 4


def strained(count, stiffness, tolerance, base="free"):
    """Links of .5 m and 1 kg at any angles with springs between them that are slack when it is straight."""
    draw = np.random.default_rng(count)
    initial = {
        "position": [0.0, 0.0],
        "velocity": [0.0, 0.0],
        "angles": (2.0 * draw.normal(size=count)).tolist(),
        "angular_velocities": draw.uniform(-2.0, 2.0, count).tolist(),
    }
    links = [{"length": 0.5, "mass": 1.0, "joint_stiffness": stiffness}] * count
    return build(
        "Springs", links, initial, {}, {"points": []}, stop_time=SECONDS, base=base, tolerance=tolerance
    )


def gain(scene, method="auto"):
    """The most that the ledger has grown, in parts of its start, and the status."""
    instance = Instance(scene)
    instance.record["solver"]["method"] = 1 + SOLVER_METHODS.index(method)
    instance.initialize()
    instance.observe()
    output, most = instance.record["output"], 0.0
    start = float(output["total"])
    for second in range(1, SECONDS + 1):
        status = instance.advance(float(second))
        instance.observe()
        most = max(most, float(output["total"] + output["dissipated"]) - start)
        if status != OK:
            break
    return most / start, status


@pytest.mark.parametrize("method", SOLVER_METHODS)
@pytest.mark.parametrize("tolerance", [1e-2, 5e-3, 1e-3])
@pytest.mark.parametrize("base", ["free", "pinned"])
def test_no_tolerance_makes_energy_from_nothing(base, tolerance, method):
    """It was 3 times the start's under auto, and 1e21 times under implicit."""
    share, status = gain(strained(5, 1e5, tolerance, base), method)
    assert status == OK
    assert share < FIFTH


@pytest.mark.parametrize("count", [2, 10])
@pytest.mark.parametrize("stiffness", [1e2, 1e6])
def test_nor_do_other_springs(count, stiffness):
    share, _ = gain(strained(count, stiffness, 1e-2))
    assert share < FIFTH
