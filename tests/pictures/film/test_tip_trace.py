"""The trace of the tip in films is smooth, and on the path of the tip."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure

from chain_impact import load_scene, record_slowly, simulate
from chain_impact.pictures.film.film import Film
from chain_impact.pictures.film.tip_trace import trace_of


def turns(path):
    """Return the angles between one piece of a path and the next [rad]."""
    x, y = np.diff(path, axis=0).T
    return np.abs(np.diff(np.unwrap(np.arctan2(y, x))))


@pytest.fixture(scope="module")
def whirl():
    """Return a fast double pendulum, with few rows per turn, and the same motion with many rows."""
    scene = load_scene("pinned_arm").with_values(
        {"box.x_max": 9.0, "initial.angular_velocity[1]": 12.0, "simulation.stop_time": 1.0}
    )
    return [simulate(scene, output_step=step) for step in (1 / 60, 1e-4)]


@pytest.mark.parametrize("knows_velocities", [True, False])
def test_between_rows_the_trace_is_on_the_path(whirl, knows_velocities):
    coarse, fine = whirl
    stored = coarse.with_rows(np.arange(len(coarse.time)))
    if not knows_velocities:
        columns = {name: column for name, column in stored.columns.items() if ".v" not in name}
        stored = replace(stored, columns=columns)
    times, path = trace_of(stored, 1.0)
    expected = np.stack(
        [np.interp(times, fine.time, coordinates) for coordinates in fine.points[:, -1].T], axis=-1
    )
    straight = np.stack(
        [np.interp(times, coarse.time, coordinates) for coordinates in coarse.points[:, -1].T], axis=-1
    )
    deviation, straight_deviation = (np.hypot(*(points - expected).T).max() for points in (path, straight))
    assert deviation < straight_deviation / (20.0 if knows_velocities else 3.0)
    assert turns(path).max() < 0.5 * turns(coarse.points[:, -1]).max()
    np.testing.assert_array_equal(path[np.searchsorted(times, coarse.time)], coarse.points[:, -1])


def test_at_an_impact_the_trace_has_a_corner():
    recording = simulate("bouncing_ball", output_step=0.05)
    times, path = trace_of(recording, 1.0)
    onset = recording.impacts["onset"][0]
    row = np.searchsorted(recording.time, onset) - 1
    assert not ((times > recording.time[row]) & (times < recording.time[row + 1])).any()
    assert path[:, 1].min() >= recording.points[..., 1].min()


def test_one_component_of_the_velocity_is_as_good_as_none():
    recording = simulate("bouncing_ball", output_step=0.05)
    stored = recording.with_rows(np.arange(len(recording.time)))
    with_x, without_velocities = (
        replace(stored, columns={name: column for name, column in stored.columns.items() if end not in name})
        for end in (".vy", ".v")
    )
    np.testing.assert_array_equal(trace_of(with_x, 1.0)[1], trace_of(without_velocities, 1.0)[1])


def test_a_film_shows_it_up_to_the_present_tip():
    recording = record_slowly(load_scene("four_link_box").with_values({"simulation.stop_time": 0.6}))
    frames = np.linspace(0.0, 0.6, 13)
    film = Film(Figure((9.6, 5.4), dpi=100), recording, frames)
    for frame in (0, 5, 12):
        list(film.show(frame, 1.0))
        pieces = np.array(film.trace.get_segments())
        trace_points = np.append(pieces[:, 0], pieces[-1:, 1], axis=0)
        np.testing.assert_array_equal(trace_points[-1], film.points[frame, -1])
    assert len(trace_points) > 100  # the film has only 13 frames
    # smooth except at the two impacts
    assert (
        np.sort(turns(trace_points[np.append(True, np.hypot(*np.diff(trace_points, axis=0).T) > 1e-3)]))[-6]
        < 0.1
    )
