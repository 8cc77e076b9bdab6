"""Sweeps and fits over the parameters of bodies and sliders."""

# Tests: studies/fit/fit.py, studies/sweep/sweep.py

import numpy as np
import pytest

from chain_impact import fit, simulate
from chain_impact.studies.sweep.sweep import sweep
from tests.helpers.scenes.bodies import body, cart

STOP = 0.5  # s


@pytest.mark.parametrize(
    ("scene", "name", "values"),
    [(body(), "link[1].point[1].y", (-0.15, -0.1, 0.05)), (cart(), "slider.mass", (0.5, 2.0, 8.0))],
)
def test_a_run_of_a_sweep_is_that_of_a_simulation(scene, name, values):
    scene = scene.with_values({"simulation.stop_time": STOP})
    runs = sweep(scene, {name: values}, outputs=["link[1].angle"])
    for value, angle, count in zip(values, runs["link[1].angle"], runs["impact.count"], strict=True):
        result = simulate(scene.with_values({name: value}))
        assert [angle, count] == [result["link[1].angle"][-1], len(result.impacts)]
    assert len(set(runs["link[1].angle"])) == len(values)


@pytest.mark.parametrize(
    ("scene", "name", "start", "outputs"),
    [
        (body(), "link[1].center_of_mass_offset", 0.01, ("link[1].angle", "point[1].y")),
        (cart(), "slider.damping", 1.0, ("slider.position", "link[1].angle")),
    ],
)
def test_a_fit_finds_the_value_that_made_the_data(scene, name, start, outputs):
    result = simulate(scene, stop_time=STOP, output_step=0.02)
    noise = 1e-5 * np.random.default_rng(1).standard_normal((len(outputs), len(result.time) - 1))
    columns = {output: result[output][1:] + part for output, part in zip(outputs, noise, strict=True)}
    fit_result = fit(
        scene.with_values({name: start}),
        {"time": result.time[1:]} | columns,
        [name],
        sigma=dict.fromkeys(outputs, 1e-5),
    )
    assert fit_result.converged
    assert abs(fit_result.values[name] - scene.values[name]) < 4.0 * fit_result.standard_errors[name] < 4e-3
