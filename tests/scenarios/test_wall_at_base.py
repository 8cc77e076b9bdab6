"""A wall that reaches a pinned base, or the line of a slider, ends the run at that time."""

# Tests: kernel/events/base_at_wall.py

import math

import numpy as np
import pytest

from chain_impact.kernel.status import BASE_BEYOND_WALL
from chain_impact.scene.checks.checks import base_hints
from chain_impact.scene.scene import scene_from_dict
from chain_impact.simulation.errors import SimulationError
from chain_impact.simulation.simulate import simulate

MIDDLE, WIDTH = 1.003, 0.1  # s


def scene(method="auto"):
    return scene_from_dict(
        {
            "name": "Pass",
            "gravity": [0.0, -9.81],
            "chain": {"base": "pinned", "links": [{"length": 0.3, "mass": 1.0}]},
            "walls": [{"name": "w", "point": [0.0, 1.0], "normal": [0.0, -1.0]}],
            "contact": {"model": "newton_impact"},
            "inputs": {"wall_motion": ["w"]},
            "initial": {"angles": ["-80 deg"]},
            "solver": {"method": method},
            "simulation": {"stop_time": 2.0, "step_size": 0.01},
        },
        "pass",
    )


def moved(height):
    """Return functions of time: a wall comes down by a height [m], and goes up again."""

    def displacement(t):
        return height * math.exp(-(((t - MIDDLE) / WIDTH) ** 2))

    return {
        "wall.w.displacement": displacement,
        "wall.w.velocity": lambda t: -2.0 * (t - MIDDLE) / WIDTH**2 * displacement(t),
    }


@pytest.mark.parametrize("method", ["auto", "implicit"])
@pytest.mark.parametrize("above", [0.05, 1e-3, 1e-5])
def test_a_wall_meets_the_base_when_it_gets_there(above, method):
    """The time is 1.003 − .1 √ln(1 + a) s. Between the motion's rows a cubic has an error of about 1e-8 m."""
    with pytest.raises(SimulationError) as caught:
        simulate(scene(method), inputs=moved(1.0 + above))
    assert caught.value.status == BASE_BEYOND_WALL
    assert str(caught.value).endswith(": the base at the wall w")
    expected = MIDDLE - WIDTH * math.sqrt(math.log1p(above))
    speed = 2.0 * (MIDDLE - expected) / WIDTH**2
    assert caught.value.time == pytest.approx(expected, abs=1e-6 / speed)
    result = caught.value.result
    assert result.time[-1] <= caught.value.time < result.time[-1] + 0.0101


def test_a_wall_that_does_not_get_there_ends_nothing():
    result = simulate(scene(), inputs=moved(1.0 - 1e-5))
    assert result.time[-1] == 2.0
    assert np.isfinite(result.angles).all()


@pytest.mark.parametrize("angle", [0.0, 0.4])
@pytest.mark.parametrize("points", [[0, 1], [1]])
def test_a_wall_parallel_to_a_slider_meets_the_base(angle, points):
    """The wall is 0.1 m below the line, and rises by 0.5 sin 2πt, so the time is asin(0.2) / 2π."""
    normal = [-math.sin(angle), math.cos(angle)]
    slides = scene_from_dict(
        {
            "name": "Slider",
            "chain": {
                "base": "slider",
                "slider": {"angle": angle, "mass": 2.0},
                "links": [{"length": 0.3, "mass": 1.0}],
            },
            "walls": [{"name": "w", "point": [-0.1 * part for part in normal], "normal": normal}],
            "contact": {"model": "newton_impact", "points": points},
            "inputs": {"wall_motion": ["w"]},
            "initial": {"angles": [angle + 1.5]},
            "signals": {
                "s": {"input": "wall.w.displacement", "form": "sine", "amplitude": 0.5, "frequency": 1.0}
            },
        },
        "slider",
    )
    with pytest.raises(SimulationError) as caught:
        simulate(slides)
    assert caught.value.status == BASE_BEYOND_WALL
    assert str(caught.value).endswith(": the base at the wall w")
    assert caught.value.time == pytest.approx(math.asin(0.2) / (2.0 * math.pi), abs=1e-9)


def test_a_base_that_starts_beyond_a_wall_parallel_to_its_line_is_told():
    table = {
        "name": "Rail",
        "chain": {"base": "slider", "slider": {"mass": 2.0}, "links": [{"length": 0.3, "mass": 1.0}]},
        "walls": [{"name": "w", "point": [0.0, -0.1], "normal": [0.0, -1.0]}],
        "contact": {"points": [1]},
        "initial": {"angles": [-1.5]},
    }
    assert base_hints(scene_from_dict(table, "rail")) == []
    (hint,) = base_hints(scene_from_dict(table | {"inputs": {"wall_motion": ["w"]}}, "rail"))
    assert hint.startswith("initial: the base at (0, 0) m is 0.1 m beyond the wall w")
