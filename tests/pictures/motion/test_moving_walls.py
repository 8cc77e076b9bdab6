"""Moving walls and a moving base in the picture of a motion."""

import functools

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.colors import to_hex

from chain_impact import simulate
from chain_impact.pictures.motion.motion import colour_of_time
from chain_impact.pictures.motion.walls import SHORT_TIMES_COLOUR
from chain_impact.scene.scene import scene_from_dict
from tests.pictures.pictures import motion_of, page_of

START, SPEED = 0.45, 0.3  # m, m/s: the wall moves from right to left


@functools.cache
def ram(box=START, way=None):
    """Return the run of a double pendulum that swings away from a wall; ``way(t)`` moves the wall [m]."""
    scene = scene_from_dict(
        {
            "name": "Ram",
            "chain": {"base": "pinned", "links": [{"count": 2, "length": 0.4, "mass": 1.0}]},
            "box": {"x_max": box},
            "inputs": {"wall_motion": True},
            "initial": {"angles": ["-60 deg", "-60 deg"]},
            "simulation": {"stop_time": 1.0},
        },
        "ram",
    )
    return simulate(scene, inputs={"wall.x_max.displacement": way or (lambda t: SPEED * t)}, output_step=2e-3)


def upright_lines(axes, x):
    """Return the colours of upright lines at x [m] that are longer than 0.5 m."""
    colours = []
    for lines in axes.collections:
        for line, colour in zip(lines.get_segments(), lines.get_colors().repeat(99, axis=0), strict=False):
            if len(line) > 1 and np.abs(line[:, 0] - x).max() < 1e-9 and np.ptp(line[:, 1]) > 0.5:
                colours.append(to_hex(colour))
    return colours


@pytest.mark.parametrize("row", [0, -1])
def test_a_moving_wall_has_the_colours_of_start_and_end(row):
    recording = ram()
    motion = motion_of(recording)
    at = START - recording["wall.x_max.position"][row]
    assert to_hex(colour_of_time(recording)(recording.time[row])) in upright_lines(motion, at)
    low, high = motion.get_xlim()
    assert low < at < high


def test_the_legend_has_the_moving_wall():
    motion = motion_of(ram())
    assert [text.get_text() for text in motion.get_legend().get_texts()].count("moving wall") == 1


def test_the_wall_that_was_hit_is_there():
    recording = ram(way=lambda t: 0.2 * (1.0 - np.cos(3.0 * np.pi * t)))
    (onset,) = recording.impacts["onset"]
    motion = motion_of(recording)
    at = START - np.interp(onset, recording.time, recording["wall.x_max.position"])
    assert START - 0.4 < at < START
    assert to_hex(colour_of_time(recording)(onset)) in upright_lines(motion, at)


def test_the_chain_stands_in_what_is_free_at_its_time():
    """White is always free, and pale is free at times: no pose lies in the grey area."""
    recording = ram()
    motion = motion_of(recording)
    at_times, always = (
        next(patch for patch in motion.patches if to_hex(patch.get_facecolor()) == to_hex(colour))
        for colour in (SHORT_TIMES_COLOUR, "white")
    )
    assert at_times.get_xy()[:, 0].max() == pytest.approx(START)
    assert always.get_xy()[:, 0].max() == pytest.approx(START - SPEED)
    # this point lies beyond the final position of the wall
    assert recording.points[0, :, 0].max() > START - SPEED
    assert recording.points[..., 0].max() < START


def test_a_wall_has_a_trace_from_its_start_to_its_end():
    recording = ram()
    motion = motion_of(recording)
    traces = [
        pieces
        for lines in motion.collections
        if len(pieces := np.array([line for line in lines.get_segments() if len(line) == 2])) > 100
        and np.ptp(pieces[..., 1]) < 1e-9
    ]
    (trace,) = traces
    assert trace[0, 0, 0] == pytest.approx(START)
    assert trace[-1, 1, 0] == pytest.approx(START - SPEED)


@pytest.mark.full("takes long")
def test_a_wall_that_comes_from_far_is_in_view_where_it_starts():
    """The wall starts no farther away than the width of the motion; a resting wall there is not in view."""
    _, motion, *_ = page_of(ram(box=0.7, way=lambda t: 0.5 * t))
    assert motion.get_xlim()[1] > 0.7
    _, motion, *_ = page_of(ram(box=0.7, way=lambda t: 0.0 * t))
    assert motion.get_xlim()[1] < 0.7


def marks(axes):
    """Return line and colour of each ground mark: the line of a support has four corners."""
    return [
        (line, to_hex(colour))
        for lines in axes.collections
        for line, colour in zip(lines.get_segments(), lines.get_colors().repeat(99, axis=0), strict=False)
        if len(line) == 4
    ]


def test_a_base_that_moves_has_its_mark_at_the_start_and_at_the_end():
    scene = ram().scene.with_values({"inputs.base_motion": True, "inputs.wall_motion": False})
    way = {"base.x": lambda t: 0.3 * t, "base.y": lambda t: -0.1 * t}
    recording = simulate(scene, inputs=way, output_step=2e-3)
    assert recording.pinned
    motion = motion_of(recording)
    shade = colour_of_time(recording)
    places = {(*line[0].round(9).tolist(), colour) for line, colour in marks(motion)}
    assert (0.0, 0.0, to_hex(shade(0.0))) in places
    assert (0.3, -0.1, to_hex(shade(1.0))) in places
    assert len(places) > 5  # there are faint marks between
    view = mpl.transforms.Bbox(np.transpose([motion.get_xlim(), motion.get_ylim()]))
    assert all(view.contains(*corner) for line, _ in marks(motion) for corner in line)


def test_a_base_that_stays_within_its_mark_has_one_mark():
    scene = ram().scene.with_values({"inputs.base_motion": True, "inputs.wall_motion": False})
    recording = simulate(scene, inputs={"base.x": lambda t: 0.01 * np.sin(30.0 * t)}, output_step=2e-3)
    assert len({line[0].tobytes() for line, _ in marks(motion_of(recording))}) == 1


def test_a_free_base_that_rests_is_not_pinned():
    scene = ram().scene.with_values({"chain.base": "free", "inputs.wall_motion": False, "gravity": [0, 0]})
    recording = simulate(scene)
    assert not recording.pinned
    assert marks(page_of(recording)[1]) == []
