"""A repeated run whose base or wall is held between communication points is the same motion."""

# Tests: simulation/held_motions.py

import numpy as np
import pytest

from chain_impact import SceneWarning, load_scene, record_slowly, simulate
from chain_impact.recording.equality import are_equal

MOTION = {
    "base.x": lambda t: 0.05 * np.sin(20.0 * t),
    "base.vx": lambda t: np.cos(20.0 * t),
    "base.ax": lambda t: -20.0 * np.sin(20.0 * t),
}


def held_run(names, run=simulate):
    scene = load_scene("pinned_arm").with_values(
        {"inputs.base_motion": True, "simulation.step_size": 0.05, "simulation.stop_time": 0.6}
    )
    return run(scene, inputs={name: MOTION[name] for name in names}, interpolation="hold")


@pytest.mark.filterwarnings(f"ignore::{SceneWarning.__module__}.{SceneWarning.__name__}")
@pytest.mark.parametrize("names", [[*MOTION], ["base.x"], ["base.vx"], ["base.ax"]], ids=" ".join)
def test_more_rows_leave_a_held_motion_as_it_is(names):
    result = held_run(names)
    times = np.union1d(result.time, np.linspace(0.0, 0.6, 100))
    dense = result.rerun.series(times)
    points = np.isin(times, result.time)
    for name, values in result.continuous_columns.items():
        np.testing.assert_array_equal(dense[name][points], values)
    # within a step, the base follows the cubic through the positions and velocities at its ends
    k = np.maximum(np.searchsorted(result.time, times) - 1, 0)
    step = result.time[k + 1] - result.time[k]
    x = (times - result.time[k]) / step
    s, v = result["point[0].x"], result["point[0].vx"]
    cubics = (
        (1 + 2 * x) * (1 - x) ** 2 * s[k]
        + x * (1 - x) ** 2 * step * v[k]
        + x**2 * (3 - 2 * x) * s[k + 1]
        + x**2 * (x - 1) * step * v[k + 1]
    )
    np.testing.assert_allclose(dense["point[0].x"], cubics, rtol=0, atol=1e-12)
    balance = dense["energy.total"] + dense["energy.dissipated"] - dense["energy.supplied"]
    np.testing.assert_allclose(balance, balance[0], rtol=0, atol=1e-6)


def test_dense_rows_of_a_held_motion_have_the_impacts_of_the_run():
    close, even = held_run(MOTION, record_slowly), held_run(MOTION)
    assert are_equal(close.impacts, even.impacts)
    assert close["energy.total"][-1] == even["energy.total"][-1]
    assert len(close.time) > 2 * len(even.time)


def test_a_repeated_run_may_end_between_or_after_communication_points():
    result = held_run(MOTION)
    x = result.rerun.series(np.linspace(0.0, 0.6, 100))["point[1].x"]
    np.testing.assert_array_equal(result.rerun.series(np.linspace(0.0, 0.6, 100)[:50])["point[1].x"], x[:50])
    assert len(result.rerun(np.array([0.6, np.nextafter(0.6, 1.0)]))) == 2


def test_an_impact_of_a_held_motion_has_its_course():
    result = held_run(MOTION)
    assert len(result.impacts)
    course = result.course_of_impact(1)
    assert course.force.max() == pytest.approx(result.impacts["peak_force"][0], rel=1e-3)
