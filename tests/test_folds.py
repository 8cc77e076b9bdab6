"""Rigid walls where two touching points all but coincide: no pull, no energy taken beyond Newton's law."""

import math

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.scene.scene import with_values
from tests.folds import LENGTH, faults, fold, inelastic_loss
from tests.problems import GRAVITY, build


def nearly_folded(angle, spin, **contact):
    """Two links from floor to floor, the second at an angle, turning: its tip arrives very slowly."""
    initial = {
        "position": [0.0, 0.0],
        "velocity": [0.0, 0.0],
        "angles": [math.pi / 2, angle],
        "angular_velocities": [0.0, spin],
    }
    links = [{"length": LENGTH, "mass": 1.0}] * 2
    table = {"model": "newton_impact", "restitution": 0.0, "points": [0, 2]} | contact
    return build(
        "Fold", links, initial, {"y_min": 0.0}, table, gravity=GRAVITY, stop_time=1e-3, tolerance=1e-8
    )


def test_a_slow_arrival_in_a_fold_takes_no_energy_and_no_wall_pulls():
    """The arrival brings 1e-13 J; to stop both points, by impulses of either sign, would take 0.05 J."""
    result = simulate(nearly_folded(-1.5707956778838323, -1.7403405797311131))
    assert (result.impacts["impulse"] >= 0.0).all()
    assert result.impacts["impulse"].max() < 0.1
    assert np.diff(result.outputs["impulse"], axis=0).min() > -1e-6
    assert result.outputs["dissipated"][-1] < 1e-10
    assert result.angular_velocities[-1, 1] == pytest.approx(-1.740, abs=1e-3)


def test_walls_with_a_force_law_keep_the_same_speed():
    scene = nearly_folded(-1.5707956778838323, -1.7403405797311131)
    soft = {("contact", "model"): "hertz", ("contact", "stiffness"): 1e10}
    result = simulate(with_values(scene, soft))
    assert result.angular_velocities[-1, 1] == pytest.approx(-1.740, abs=1e-3)


def test_the_motion_after_an_impact_is_continuous_as_the_fold_closes():
    speeds = []
    for offset in np.logspace(-3, -9, 13):
        result = simulate(nearly_folded(-math.pi / 2 + offset, -1.74))
        speeds.append(result.angular_velocities[-1, 1])
        assert result.outputs["dissipated"][-1] < 4.0 * offset**2 + 1e-10
    np.testing.assert_allclose(speeds, -1.74, atol=0.02)


# a pull at the impact, a loss, a correction of places that lifts the chain, a passage between two holds
FOUND = [22, 24, 30, 53, 1445, 2215, 2827, 6792, 12742, 16909]


@pytest.mark.parametrize("seed", FOUND)
def test_a_fold_that_had_faults_has_none(seed):
    assert not faults(fold(seed))


@pytest.mark.full("takes long")
def test_random_folds_keep_newtons_law():
    found = {seed: kinds for seed in range(1000) if (kinds := faults(fold(seed)))}
    assert not found


def test_the_bound_of_a_loss_is_that_of_the_arrivals():
    w = np.array([[2.0, 1.0], [1.0, 2.0]])
    u = np.array([-1.0, -1.0])
    assert inelastic_loss(w, u) == pytest.approx(0.5 * u @ np.linalg.solve(w, u))
    # the impulse on the first lifts the second
    assert inelastic_loss(w, np.array([-1.0, 0.0])) == pytest.approx(0.25)
    assert inelastic_loss(w, np.array([1.0, 1.0])) == 0.0
