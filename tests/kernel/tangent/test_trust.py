"""How far derivatives are trusted: up to an impact, which is named, or to a step, and why."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.kernel.tangent.trust import share_reason
from chain_impact.simulation.reasons import REASONS
from tests.problems import ball, flat_rod, rod

NAMES = ("contact.stiffness", "initial.vy")
# what the sentence of each reason says
WORDS = {
    1: "arrives so slowly",
    2: "contact.minimum_impact_speed",
    3: "several points arrive at one moment",
    4: "jumps where the point turns",
    5: "does not converge",
}
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


@pytest.mark.parametrize("law", ["newton_impact", "kelvin_voigt", "hertz"])
def test_impacts_at_one_moment(law):
    """A rod that falls flat."""
    exponent = 1.0 if law == "kelvin_voigt" else 1.5
    scene = flat_rod(model=law, exponent=exponent)
    result = simulate(scene, sensitivities=("initial.vy",))
    assert WORDS[3] in result.sensitivity_limits[0]
    assert np.isnan(result.sensitivity("point[0].y", "initial.vy")[-1])


HYSTERESIS = """
def hysteresis(penetration, rate, stiffness, restitution):
    force = stiffness * penetration**1.5
    return force if rate > 0.0 or restitution == 1.0 else force * restitution
"""


@pytest.mark.full("takes long")
@pytest.mark.parametrize(("restitution", "trusted"), [(0.7, False), (1.0, True)])
def test_a_law_whose_force_jumps(tmp_path, restitution, trusted):
    """Where the point turns, in the middle of its impact: before that there are derivatives."""
    file = tmp_path / "hysteresis.py"
    file.write_text(HYSTERESIS)
    scene = ball(0.01, 1.0, stiffness=1e6, restitution=restitution, stop_time=0.05).with_values(
        {"contact.law_file": str(file), "contact.model": "hysteresis", "simulation.step_size": 1e-4}
    )
    result = simulate(scene, sensitivities=NAMES)
    assert (result.sensitivity_limits == ()) == trusted
    slopes = result.sensitivity("point[0].vy", "contact.stiffness")
    (impact,) = result.impacts
    early = result.time < impact["onset"] + 0.2 * (impact["end"] - impact["onset"])
    assert np.isfinite(slopes[early]).all()
    assert np.isfinite(slopes[result.time > impact["end"]]).all() == trusted
    if not trusted:
        assert WORDS[4] in result.sensitivity_limits[0]


@pytest.mark.parametrize(
    ("own", "other", "expected"),
    [
        ((0, 0.0), (0, 0.0), (0, 0.0)),
        ((0, 0.0), (3, 0.5), (3, 0.5)),
        ((3, 0.5), (0, 0.0), (3, 0.5)),
        ((3, 0.5), (5, 0.2), (5, 0.2)),
        ((5, 0.2), (3, 0.5), (5, 0.2)),
    ],
)
def test_the_earliest_end_of_the_derivatives_holds_for_all(own, other, expected):
    first, second = (
        SimpleNamespace(trust=SimpleNamespace(reason=reason, time=time, point=point, wall=point))
        for point, (reason, time) in enumerate((own, other))
    )
    share_reason(first, second)
    assert (first.trust.reason, first.trust.time) == expected
    assert first.trust.point == first.trust.wall == (0 if expected == own else 1)
