"""The end of derivatives at the stop of a joint: the sentence names the joint, not a point at a wall."""

# Tests: simulation/derivative_limits.py

import pytest

from chain_impact import simulate
from tests.helpers.scenes.stops import knee_scene, simultaneous_impacts

GRAZES = {"stops.model": "hertz", "stop.minimum_impact_speed": 1e-9, "solver.tolerance": 1e-3}


def straight(spin, bend, **values):
    """Return an arm without gravity, almost straight, that spins while its knee moves into its lower stop."""
    initial = {"gravity.x": 0.0, "gravity.y": 0.0, "initial.angle[1]": -1.0, "initial.angle[2]": -1.0 + 1e-4}
    return knee_scene(
        **initial,
        **{"initial.angular_velocity[1]": spin, "initial.angular_velocity[2]": spin - bend},
        **values,
    )


@pytest.mark.parametrize(
    ("scene", "reason"),
    [
        (
            straight(0.0, 0.01, **{"stop.minimum_impact_speed": 0.01}),
            "is stop.minimum_impact_speed, which",
        ),
        (straight(1.0, 1e-4, **GRAZES), "reaches the stop so slowly that"),
        (
            simultaneous_impacts("zhang_sharf", "zhang_sharf", [-2.0, -2.5]),
            "several contacts begin at one moment, and",
        ),
    ],
    ids=["floor", "grazing", "together"],
)
def test_the_reason_is_told_in_words_of_the_joint(scene, reason):
    (limit,) = simulate(scene, sensitivities=["stop.stiffness"]).sensitivity_limits
    assert "the impact of joint 2 at joint_min: " in limit
    assert reason in limit
    assert "point" not in limit
    assert "contact.minimum_impact_speed" not in limit
