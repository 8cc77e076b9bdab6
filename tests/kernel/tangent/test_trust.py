"""How far derivatives are trusted: up to an impact, which is named, and why."""

import math

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.kernel.tangent.trust import REASONS
from tests.problems import ball, flat_rod, rod

NAMES = ("contact.stiffness", "initial.vy")
# what the sentence of each reason says
WORDS = {1: "arrives so slowly", 2: "contact.minimum_impact_speed", 3: "several points arrive at one moment"}
FLOOR = "contact.minimum_impact_speed"


def falling(speed):
    """A ball that arrives at the floor with a speed [m/s] close to this."""
    scene = ball(1e-7, speed, stiffness=1e6, stop_time=0.02)
    return scene.with_values({"solver.tolerance": 1e-10, "simulation.step_size": 1e-4})


def test_each_reason_has_a_sentence():
    assert {number: words in REASONS[number] for number, words in WORDS.items()} == dict.fromkeys(
        REASONS, True
    )


@pytest.mark.parametrize(("times_the_floor", "trusted"), [(0.8, False), (1.2, True)])
def test_the_floor_of_the_approach_speed(times_the_floor, trusted):
    """Below it the law takes another speed than that of the impact, above it the same."""
    floor = falling(1.0).values[FLOOR]
    result = simulate(falling(times_the_floor * floor), sensitivities=NAMES)
    assert len(result.impacts) >= 1
    assert (result.impacts["impact_speed"][0] > floor) == trusted
    (_, *limits), onset = ("", *result.sensitivity_limits), result.impacts["onset"][0]
    slopes = result.sensitivity("point[0].vy", "initial.vy")
    assert np.isfinite(slopes[result.time < onset]).all()
    if trusted:
        during = (result.time > onset) & ~(result.time > result.impacts["end"][0])
        assert np.isfinite(slopes[during]).all()
    else:
        assert np.isnan(slopes[result.time > onset]).all()
        (limit,) = limits
        assert WORDS[2] in limit
        assert f"t = {onset:.9g} s" in limit
        assert "the impact of point 0 at y_min" in limit
        assert np.isnan(result.impact_sensitivity("peak_force", "initial.vy")).all()


@pytest.mark.parametrize("depth", [1e-7, 1e-3])
def test_a_grazing_impact(depth):
    """A rod that turns about its centre and touches the floor with its end for a depth [m]."""
    scene = rod(0.5, 0.5 - math.sin(0.5) / 2 - depth, 0.0, -10.0, stiffness=1e5, stop_time=0.3)
    result = simulate(scene, tolerance=1e-6, sensitivities=("initial.y",))
    assert len(result.impacts) == 1
    limits = result.sensitivity_limits
    if depth == 1e-7:
        assert WORDS[1] in limits[0]
        after = result.time > result.impacts["onset"][0]
        assert np.isnan(result.sensitivity("point[0].y", "initial.y")[after]).all()
    else:
        assert limits == ()


@pytest.mark.parametrize(
    ("law", "trusted"), [("newton_impact", False), ("kelvin_voigt", False), ("hertz", True)]
)
def test_impacts_at_one_moment(law, trusted):
    """A rod that falls flat: forces that begin at zero do not depend on which end is first, others do."""
    exponent = 1.0 if law == "kelvin_voigt" else 1.5
    scene = flat_rod(model=law, exponent=exponent)
    result = simulate(scene, sensitivities=("initial.vy",))
    assert (result.sensitivity_limits == ()) == trusted
    if not trusted:
        assert WORDS[3] in result.sensitivity_limits[0]
        assert np.isnan(result.sensitivity("point[0].y", "initial.vy")[-1])
