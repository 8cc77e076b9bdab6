"""The pace of an animation: slow through impacts, real time elsewhere."""

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from chain_impact.recording.pacing import (
    FRAME_RATE,
    LEAST_DURATION,
    LONGEST_SLOW,
    SPEED_RAMP,
    frame_rate,
    frame_times,
    rates_over_time,
)
from chain_impact.studies.animate import record_slowly


def screen_time(times, per_second, start, end):
    """Return the time on the screen [s] between two simulated times."""
    frames = np.interp([start, end], times, np.arange(len(times)))
    return np.diff(frames)[0] / per_second


@pytest.mark.parametrize("duration", [2e-4, 1e-3, 2e-2])
@pytest.mark.parametrize("impact_time", [0.2, 0.6])
def test_an_impact_takes_its_time_on_the_screen(duration, impact_time):
    span = (0.7, 0.7 + duration)
    times, per_second = frame_times(0.0, 2.0, [span], impact_time)
    assert screen_time(times, per_second, *span) == pytest.approx(impact_time, rel=0.03)


def test_the_slowing_down_takes_the_logarithm_of_how_slow_it_is():
    """The logarithm follows from ∫ dt / (r + t/τ) from 0 to τ (1 − r) = −τ ln r."""
    duration, impact_time = 1e-3, 0.6
    times, per_second = frame_times(0.0, 2.0, [(0.7, 0.7 + duration)], impact_time)
    lowest_rate = duration / impact_time
    expected = -SPEED_RAMP * np.log(lowest_rate)
    assert screen_time(times, per_second, 0.7 - SPEED_RAMP * (1 - lowest_rate), 0.7) == pytest.approx(
        expected, rel=0.02
    )


def test_far_from_impacts_it_is_real_time():
    times, per_second = frame_times(0.0, 2.0, [(0.7, 0.701)])
    assert screen_time(times, per_second, 1.0, 2.0) == pytest.approx(1.0, rel=1e-3)
    assert per_second == pytest.approx(FRAME_RATE, rel=0.01)


@pytest.mark.parametrize(("spans", "impact_time"), [([], 0.6), ([(0.7, 0.701)], 0.0)])
def test_without_impacts_or_slow_motion_the_frames_are_even(spans, impact_time):
    times, per_second = frame_times(0.5, 2.0, spans, impact_time)
    np.testing.assert_allclose(np.diff(times), 1.0 / per_second)
    assert (times[0], times[-1]) == (0.5, 2.0)


def test_short_and_lasting_contacts_are_slowed_for_a_while():
    for span, slowed_duration in (((0.7, 0.7 + 1e-6), LEAST_DURATION), ((0.7, 1.9), LONGEST_SLOW)):
        times, per_second = frame_times(0.0, 2.0, [span])
        assert screen_time(times, per_second, 0.7, 0.7 + slowed_duration) == pytest.approx(0.6, rel=0.1)


def test_an_impact_without_a_duration_is_a_short_stop():
    """The stop with its two ramps takes about 0.1 s more than real time."""
    times, per_second = frame_times(0.0, 2.0, [(0.7, 0.7)])
    assert screen_time(times, per_second, 0.6, 0.8) - 0.2 == pytest.approx(0.11, abs=0.03)


def test_frames_increase_and_are_no_more_than_allowed():
    spans = [(0.1 * k, 0.1 * k + 1e-3) for k in range(1, 90)]
    times, per_second = frame_times(0.0, 10.0, spans, most_frames=500)
    assert len(times) == 500
    assert per_second < FRAME_RATE
    assert (np.diff(times) > 0.0).all()


def test_the_slower_rate_of_two_impacts_holds():
    time = np.array([0.5, 0.5005])
    assert (
        rates_over_time(time, [(0.5, 0.501), (0.49, 0.6)], 0.5) == rates_over_time(time, [(0.5, 0.501)], 0.5)
    ).all()


def test_a_sine_that_drives_an_input_has_sixteen_frames_in_a_period():
    scene = load_scene("shaken_pendulum").with_values({"simulation.stop_time": 0.2})
    assert frame_rate(simulate(scene)) == 16 * 40.0
    assert frame_rate(simulate(scene.with_values({"signal.shake.frequency_rate": -600.0}))) == 16 * 80.0
    late = {"signal.shake.start": 0.15, "signal.shake.rise": 0.01, "signal.shake.frequency_rate": 600.0}
    assert frame_rate(simulate(scene.with_values(late))) == pytest.approx(16 * 70.0), "from its start on"
    for unseen in ({"signal.shake.amplitude": 0.0}, {"signal.shake.start": 0.2, "signal.shake.rise": 0.01}):
        assert frame_rate(simulate(scene.with_values(unseen))) == FRAME_RATE
    assert frame_rate(simulate("simple_pendulum")) == FRAME_RATE
    recorded = record_slowly(scene)
    # the frames show the full amplitude, which 60 frames per second would miss
    assert np.ptp(recorded["point[0].y"]) == pytest.approx(0.02, rel=0.02)
    assert len(recorded.time) == 2 + 0.2 * 640
