"""Coefficients of dry friction from measured motion."""

# Tests: studies/fit/fit.py

import numpy as np

from chain_impact import fit, simulate
from tests.helpers.scenes.friction_derivative_scenes import puck

NOISE = 1e-4  # m


def test_the_friction_of_a_puck_that_slides_up_a_slope_and_back():
    """The interval of µ contains the true value, from a start at which the puck stops on the slope."""
    true_scene = puck(friction=0.2).scene
    result = simulate(true_scene, output_step=0.01)
    names = ("point[0].x", "point[0].y")
    noise = NOISE * np.random.default_rng(3).standard_normal((2, len(result.time) - 1))
    columns = {name: result[name][1:] + part for name, part in zip(names, noise, strict=True)}
    start = true_scene.with_values({"contact.friction": 0.5})
    fit_result = fit(
        start, {"time": result.time[1:]} | columns, ["contact.friction"], sigma=dict.fromkeys(names, NOISE)
    )
    low, high = fit_result.intervals["contact.friction"]
    assert fit_result.converged
    assert low < 0.2 < high
    assert high - low < 2e-3
    assert 0.8 < fit_result.reduced_chi_squared < 1.2
