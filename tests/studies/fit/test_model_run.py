"""The run with the fitted values that a fit's picture shows."""

import numpy as np
import pytest

from chain_impact import fit, load_scene, simulate
from chain_impact.studies.fit.model_run import model_run

MOTION = {
    "base.x": lambda t: 0.05 * np.sin(20.0 * t),
    "base.vx": lambda t: np.cos(20.0 * t),
    "base.ax": lambda t: -20.0 * np.sin(20.0 * t),
}


@pytest.mark.parametrize("interpolation", ["follow", "hold"])
def test_the_curve_of_the_model_goes_through_the_values_of_the_fit(interpolation):
    """With ``hold``, a motion is held between the times of the data, so other times would change it."""
    scene = load_scene("pinned_arm").with_values(
        {"inputs.base_motion": True, "simulation.step_size": 0.05, "simulation.stop_time": 0.4}
    )
    times = simulate(scene).time
    inputs = {name: (times, motion(times)) for name, motion in MOTION.items()}
    heavier_scene = scene.with_values({"link[1].mass": 1.05})
    run = simulate(heavier_scene, inputs=inputs, interpolation=interpolation)
    columns = {name: values for name, (_, values) in inputs.items()}
    data = {"time": times, "point[2].x": run["point[2].x"] + 1e-4 * np.cos(77.0 * times), **columns}
    result = fit(scene, [data], ["link[1].mass"], interpolation=interpolation)
    curve = model_run(result, 0)
    values = np.interp(times, curve.time, curve["point[2].x"])
    (data_set,) = result.data
    np.testing.assert_allclose(values, data_set.value + result.residuals, rtol=0, atol=1e-5)
