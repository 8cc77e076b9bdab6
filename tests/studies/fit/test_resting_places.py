"""A fit of the coefficient of friction to the final positions of thrown chains only."""

# Tests: studies/fit/fit.py

import numpy as np
import pytest

from chain_impact import fit, simulate
from tests.helpers.scenes.derivative_scenes import link, start, table

TRUE, NOISE = 0.42, 1e-3  # –, m
THROWS = [0.8, 1.3, 1.8, 2.3]  # m/s
PLACES = ("point[0].x", "point[2].x")


def thrown(friction):
    """Return two links that are thrown on a rough floor, slide, and rest after 3 s at the latest."""
    return table(
        [link(0.3, 0.5), link(0.25, 0.4, damping=0.02)],
        box={"y_min": 0.0},
        contact={"stiffness": 2e4, "restitution": 0.3, "friction": friction},
        initial=start(position=[0.0, 0.1], angles=[0.3, -0.2], velocity=[1.5, -0.5], spins=[1.0, -1.0]),
        solver={"tolerance": 1e-9},
        simulation={"stop_time": 3.0, "step_size": 0.05},
    )


@pytest.mark.parametrize("guess", [0.3, 0.6])
def test_friction_is_found_from_places_at_rest(guess):
    rng, measured = np.random.default_rng(5), []
    for speed in THROWS:
        result = simulate(thrown(TRUE).with_values({"initial.vx": speed}))
        assert abs(result["point[0].vx"][-1]) < 1e-8
        places = {name: [result[name][-1] + NOISE * rng.standard_normal()] for name in PLACES}
        measured.append({"time": [3.0]} | places)
    fit_result = fit(
        thrown(guess),
        measured,
        ["contact.friction"],
        set_each={"initial.vx": THROWS},
        sigma=dict.fromkeys(PLACES, NOISE),
    )
    low, high = fit_result.intervals["contact.friction"]
    assert fit_result.converged
    assert low < TRUE < high
    assert high - low < 1e-2
