"""A rate near a fold: the state it belongs to, the cost, and runs without a held point."""

import math

import numpy as np
import pytest

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.equations import rate_from_state
from chain_impact.kernel.ode import folds
from chain_impact.scene.scene import scene_from_dict
from tests.kernel.chains import initialized, mark_touching
from tests.kernel.steps import Motion, set_step

SIZE, SPEED = 0.02, 8.0  # s, of the step; rad/s
THETA = 0.501  # close to the fold


@pytest.fixture
def folding():
    """Return two links with both ends on the floor, in a step in whose middle they lie on each other."""
    links = [{"length": 0.5, "mass": 1.0}] * 2
    table = {
        "name": "Fold",
        "chain": {"base": "pinned", "links": links},
        "walls": [{"name": "floor", "point": [0.0, 0.0], "angle": 0.0}],
        "contact": {"model": "newton_impact", "points": [2]},
        "initial": {"angles": [0.5, -0.5]},
    }
    d = initialized(scene_from_dict(table, "fold"))
    parts = np.zeros((2, len(d.step.state)))
    parts[0, 2:4] = np.array([1.0, -1.0]) * (0.5 * math.pi - 0.5 * SIZE * SPEED)
    parts[1, 2:4] = parts[0, 6:8] = SPEED, -SPEED
    parts[0, -2], parts[1, -1] = 1.0, 1.0
    set_step(d, Motion(parts), SIZE)
    mark_touching(d, [0])
    return d


def test_the_rate_and_its_work_are_those_of_the_given_state(folding, monkeypatch):
    d, calls = folding, []

    def counted(*arguments):
        calls.append(arguments)
        rate_from_state(*arguments)

    monkeypatch.setattr(folds, "rate_from_state", counted)
    y, rate = np.zeros(len(d.step.state)), d.scratch.rate
    folds.interpolate_state(d.step, THETA, y)
    y[6:8] *= 1.001  # as a projection could leave the state
    given = y.copy()
    rate_from_state(d, y, rate)
    before = d.statistics.rhs_evaluations
    folds.correct_near_fold(d, THETA, y, rate)
    np.testing.assert_array_equal(y, given)
    np.testing.assert_array_equal(rate[2:4], y[6:8])
    assert len(calls) > 3
    assert d.statistics.rhs_evaluations - before == len(calls) + 1
    located = d.scratch.velocity.x.copy(), d.scratch.velocity.y.copy()
    locate_points(d, y)
    np.testing.assert_array_equal(located, (d.scratch.velocity.x, d.scratch.velocity.y))


def test_a_rate_without_held_points_stays(folding):
    d = folding
    rate_from_state(d, d.step.state_end, d.scratch.rate)
    d.constraints.near_fold = 1  # from an earlier problem
    mark_touching(d, [])
    d.scratch.rate[:] = 5.0
    folds.correct_near_fold(d, 0.5, d.step.state_end.copy(), d.scratch.rate)
    assert (d.scratch.rate == 5.0).all()
