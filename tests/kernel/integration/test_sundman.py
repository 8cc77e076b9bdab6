"""Steps in a contact's own variable: their order where the force is not smooth in time, and time in them."""

import math

import numpy as np
import pytest

from chain_impact.kernel.advance import begin_step
from chain_impact.kernel.events.marks import ONSET
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.integration.dense import fraction, interpolate
from chain_impact.kernel.integration.last_step import OUTPUTS, accept, ensure_dense
from chain_impact.kernel.integration.methods import attempt
from chain_impact.simulation.instance import Instance
from chain_impact.variables.model import Model
from tests.plain import Plain
from tests.problems import ball

SPEED, STIFFNESS = 2.0, 1e8
VELOCITY, ROOT, TIME = 4, -2, -1  # in the state of one link


def at_onset():
    """A ball of 1 kg that touches the floor at this moment, with a law without loss."""
    block = Model(ball(0.0, SPEED, stiffness=STIFFNESS, restitution=1.0)).new_instance()
    d = Plain(block[0])
    assert initialize(d, 0.0) == 0
    d["touch"]["event"][0] = ONSET
    assert begin_step(d) == 1
    assert d["step"]["regularized"] == 0
    return block


def time_scale(d):
    return float(d["touch"]["depth_scale"][0]) / SPEED


def energy(d, y):
    """½ m v² + K δ^(5/2)/(5/2), with δ from u."""
    depth = float(d["touch"]["depth_scale"][0]) * y[ROOT] ** 2
    return 0.5 * y[VELOCITY] ** 2 + STIFFNESS * depth**2.5 / 2.5


def test_a_step_from_the_onset_keeps_the_order_of_the_method():
    """In time the force begins as its power 3/2, and a step errs by its power 5/2, whatever the method."""
    start, sizes, errors = at_onset(), np.array([0.5, 0.6, 0.7, 0.8]), []
    for size in sizes:
        d = Plain(start.copy()[0])
        attempt(d, size * time_scale(d))
        errors.append(abs(energy(d, d["trial"]["state"]) - energy(d, d["step"]["state_end"])))
    assert min(errors) > 1e-13  # else it is round-off that is measured
    assert np.polyfit(np.log(sizes), np.log(errors), 1)[0] > 8.0


def test_time_is_found_in_a_step_that_runs_in_another_variable():
    d, y = Plain(at_onset()[0]), np.zeros(10)
    h = 0.8 * time_scale(d)
    attempt(d, h)
    accept(d)
    ensure_dense(d, OUTPUTS)
    step = d["step"]
    lasts = step["end"] - step["start"]
    assert lasts < 0.3 * h  # u rises from 0 to 0.7, and p = u/(1 + u²)
    for part in (0.0, 1e-9, 1e-3, 0.1, 0.5, 0.9, 1.0):
        theta = fraction(d, step["start"] + part * lasts)
        assert 0.0 <= theta <= 1.0
        interpolate(step, theta, y)
        assert y[TIME] == pytest.approx(part * lasts, abs=1e-14 * lasts)
        # from the onset u goes as √t: it is far from uniform in time
        assert theta == pytest.approx(math.sqrt(part), rel=0.1)
        # and the state is that of this time
        assert energy(d, y) == pytest.approx(energy(d, step["state"]), rel=1e-6)


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-8])
def test_the_last_moments_of_a_contact_are_seen(tolerance):
    """The last step goes beyond the end, where u < 0 and time runs back: a moment shows up twice in it."""
    scene = ball(1e-3, SPEED, stiffness=STIFFNESS, tolerance=tolerance)
    whole = Instance(scene)
    whole.advance(4e-3)
    (impact,) = whole.collect()
    again, left = Instance(scene), np.array([1e-6, 1e-7, 1e-8, 1e-9, 1e-10])
    outputs = np.zeros(len(left), again.record["output"].dtype)
    assert again.trajectory(impact["end"] - left, outputs) == len(left)
    np.testing.assert_allclose(outputs["penetration"][:, 0], impact["separation_speed"] * left, 0.02, 1e-9)


@pytest.mark.parametrize(("tolerance", "most"), [(1e-4, 120), (1e-8, 230), (1e-12, 520)])
def test_an_impact_takes_few_evaluations(tolerance, most):
    """In time it takes 1.6 times as many at equal error."""
    instance = Instance(ball(1e-3, SPEED, stiffness=STIFFNESS, tolerance=tolerance))
    instance.advance(4.9e-4)
    before = int(instance.statistics["rhs_evaluations"])
    instance.advance(4e-3)
    (impact,) = instance.collect()
    assert impact["separation_speed"] == pytest.approx(0.7 * SPEED, rel=10 * tolerance)
    assert int(instance.statistics["rhs_evaluations"]) - before <= most
