"""Stiff springs at loose tolerances: errors bring no more than a fifth of what there was, or the run ends.

Nor do they take more than the tolerance tells.
"""

import numpy as np
import pytest

from chain_impact.kernel.status import OK
from chain_impact.scene.scene import SOLVER_METHODS
from chain_impact.simulation.instance import Instance
from tests.problems import build

FIFTH = 0.2
SECONDS = 4


def strained(count, stiffness, tolerance, base="free", bend=2.0):
    """Links of .5 m and 1 kg at random angles [rad], with springs that are slack in a straight line."""
    draw = np.random.default_rng(count)
    initial = {
        "position": [0.0, 0.0],
        "velocity": [0.0, 0.0],
        "angles": (bend * draw.normal(size=count)).tolist(),
        "angular_velocities": draw.uniform(-2.0, 2.0, count).tolist(),
    }
    links = [{"length": 0.5, "mass": 1.0, "joint_stiffness": stiffness}] * count
    return build(
        "Springs", links, initial, {}, {"points": []}, stop_time=SECONDS, base=base, tolerance=tolerance
    )


def changes(scene, method="auto"):
    """The most that the ledger has grown and fallen, in parts of its start, and the status."""
    instance = Instance(scene)
    instance.record["solver"]["method"] = 1 + SOLVER_METHODS.index(method)
    instance.initialize()
    instance.observe()
    output, seen = instance.record["output"], [0.0]
    start = float(output["total"])
    for second in range(1, SECONDS + 1):
        status = instance.advance(float(second))
        instance.observe()
        seen.append(float(output["total"] + output["dissipated"]) - start)
        if status != OK:
            break
    return max(seen) / start, -min(seen) / start, status


@pytest.mark.full("more cases", but=7)
@pytest.mark.parametrize("method", SOLVER_METHODS)
@pytest.mark.parametrize("tolerance", [1e-2, 5e-3, 1e-3])
@pytest.mark.parametrize("base", ["free", "pinned"])
def test_no_tolerance_makes_energy_from_nothing(base, tolerance, method):
    """It was 3 times the start's under auto, and 1e21 times under implicit."""
    share, _, status = changes(strained(5, 1e5, tolerance, base), method)
    assert status == OK
    assert share < FIFTH


@pytest.mark.parametrize("count", [2, 10])
@pytest.mark.parametrize("stiffness", [1e2, 1e6])
def test_nor_do_other_springs(count, stiffness):
    share, _, _ = changes(strained(count, stiffness, 1e-2))
    assert share < FIFTH


@pytest.mark.full("more cases", but=10)
@pytest.mark.parametrize("method", SOLVER_METHODS)
@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4, 1e-6])
@pytest.mark.parametrize(("bend", "most"), [(0.01, 17.0), (0.1, 10.0)])
def test_losses_follow_the_tolerance(bend, most, tolerance, method):
    """The springs swing a little, and fast. Without a bound it is up to 143 and 72 tolerances."""
    _, share, status = changes(strained(5, 1e5, tolerance, bend=bend), method)
    assert status == OK
    assert share < most * tolerance
