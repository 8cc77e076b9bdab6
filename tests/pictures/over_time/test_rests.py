"""Phases of rest: pictures shade and name them, and shorten long phases with a note."""

# Tests: recording/rest.py

import dataclasses

import numpy as np
import pytest

from chain_impact import parse_scene, simulate
from chain_impact.pictures.over_time.rests import shown_time
from chain_impact.recording.recording import Recording
from chain_impact.recording.rest import rest_lines, rest_spans
from chain_impact.scene.scene import with_values
from tests.pictures.pictures import impact_row, page_of, swing


def paused(when, rows=401):
    """Return 10 s of a rod that rotates by half a turn in 1 s; it rests before, after, or halfway."""
    time = np.linspace(0.0, 10.0, rows)
    starts = {"before": (9.0, 9.5), "after": (0.0, 0.5), "between": (0.0, 9.5)}[when]
    angle = sum(np.pi * np.clip(time - start, 0.0, 0.5) for start in starts)
    columns = {name: values for name, values in swing(rows=rows).columns.items() if name[:5] != "point"}
    columns |= {"point[0].x": 0 * time, "point[0].y": 0 * time}
    columns |= {"point[1].x": np.cos(angle), "point[1].y": np.sin(angle), "link[1].angle": angle}
    return Recording("Paused", time, columns)


@pytest.mark.parametrize(
    ("when", "expected"),
    [("before", [(0.0, 9.0)]), ("after", [(1.0, 10.0)]), ("between", [(0.5, 9.5)])],
)
def test_a_rest_is_found(when, expected):
    np.testing.assert_allclose(rest_spans(paused(when)), expected, atol=0.03)


@pytest.mark.parametrize(
    ("when", "start", "end", "entry"),
    [
        ("before", 8.9, 10.0, "at rest, the run starts at 0 s"),
        ("after", 0.0, 1.25, "at rest, the run ends at 10 s"),
        ("between", 0.0, 10.0, "at rest"),
    ],
)
def test_an_axis_of_time_leaves_out_long_rests_at_its_ends(when, start, end, entry):
    recording = paused(when)
    np.testing.assert_allclose(shown_time(recording)[:2], (start, end), atol=0.05)
    _, motion, clock, energy = page_of(recording)
    for axes in (clock, energy):
        low, high = axes.get_xlim()
        assert low == pytest.approx(start, abs=0.2)
        assert high == pytest.approx(end, abs=0.2)
    assert clock.get_xlabel() == "time [s]"
    assert energy.get_legend().get_texts()[-1].get_text() == entry
    ends = "end, at rest" if when == "after" else "end"
    assert ends in [text.get_text() for text in motion.get_legend().get_texts()]


def test_an_impact_ends_a_rest():
    recording = paused("after")
    table = swing([impact_row(5.0, 1, "x_min", 1e-3)], {"x_min": -1.0}).impacts
    ends = [low for low, _ in rest_spans(dataclasses.replace(recording, impacts=table))]
    assert ends == pytest.approx([1.0, 5.025], abs=0.03)


def test_a_motion_without_rest_is_shown_to_its_end():
    assert shown_time(swing()) == (0.0, 2.0, [], "", "")


BRICK = """
name = "Brick"
[[chain.links]]
length = 0.24
mass = 3.0
shape = "box"
height = 0.11
[box]
y_min = 0.0
[contact]
friction = 0.5
stiffness = 1e8
restitution = 0.4
[initial]
position = [0.0, 0.6]
velocity = [2.0, 1.0]
angles = ["20 deg"]
angular_velocities = [-4.0]
"""


def test_a_brick_rests_on_an_edge_and_never_where_its_rocking_turns():
    """The brick rocks on a corner until 2.9 s; it turns back at 1.46 s, slower than 0.1 rad/s around then."""
    scene = parse_scene(BRICK, "brick.toml")
    for stop in (1.3, 1.45, 1.5, 1.55, 2.0):
        assert not rest_spans(simulate(with_values(scene, {"simulation.stop_time": stop})))
    result = simulate(with_values(scene, {"simulation.stop_time": 4.0}))
    [(start, end)] = rest_spans(result)
    assert (start, end) == (pytest.approx(result.impacts["onset"][-1], abs=0.1), 4.0)
    (line,) = rest_lines(result)
    assert " held " in line
    upright = result.points[-1, 1] - result.points[-1, 0]
    assert abs(upright[0]) < 1e-6


def turning(rows):
    """Return 1.05 s of a rod that moves by 0.9 m in 0.9 s; then, with 0.3 m/s², it turns back at 0.975 s."""
    time = np.linspace(0.0, 1.05, rows)
    x = np.where(time < 0.9, time, 0.9 - 0.15 * (time - 0.975) ** 2)
    columns = {"point[0].x": x, "point[1].x": x + 1.0, "point[0].y": 0.0 * x, "point[1].y": 0.0 * x}
    return Recording("Turning", time, columns)


@pytest.mark.parametrize("rows", [30, 101, 1001])
def test_the_place_where_a_motion_turns_back_is_no_rest(rows):
    assert rest_spans(turning(rows)) == []


RESTING = """
name = "Still"
gravity = {gravity}
[chain]
base = "pinned"
[[chain.links]]
length = 0.5
mass = 1.0
joint_damping = {damping}
[initial]
angles = ["{angle} deg"]
[simulation]
stop_time = {stop}
"""


@pytest.mark.parametrize(
    ("gravity", "damping", "angle", "stop", "start"),
    [
        ([0.0, -9.81], 0.1, -90, 2.0, 0.0),  # it hangs
        ([0.0, 0.0], 0.0, 20, 2.0, 0.0),  # without gravity
        # a swing that decays as exp(-t / 0.56 s): 11 of these times reduce it to 2e-5
        ([0.0, -9.81], 0.3, -60, 20.0, 6.0),
        ([0.0, -9.81], 30.0, -60, 3.0, None),  # it still creeps, by 5 % of its path in the last tenth
    ],
)
def test_a_pendulum_rests_if_it_neither_moves_nor_begins_to_move(gravity, damping, angle, stop, start):
    text = RESTING.format(gravity=gravity, damping=damping, angle=angle, stop=stop)
    spans = rest_spans(simulate(parse_scene(text, "still.toml")))
    expected = [] if start is None else [(pytest.approx(start, abs=0.8), stop)]
    assert spans == expected


def test_friction_stops_a_sliding_rod_when_coulomb_says_so():
    """A rod that does not turn slides for v / (µ g) seconds, and is held from then on."""
    text = """
name = "Slide"
gravity = [0.0, -9.81]
[[chain.links]]
length = 1.0
mass = 1.0
[box]
y_min = 0.0
[contact]
restitution = 0.1
friction = 0.5
[initial]
velocity = [2.0, 0.0]
angles = [0.0]
[simulation]
stop_time = 2.0
"""
    result = simulate(parse_scene(text, "slide.toml"))
    [(start, _)] = rest_spans(result)
    assert start == pytest.approx(2.0 / (0.5 * 9.81), abs=0.06)
    (line,) = rest_lines(result)
    assert f" held from {2.0 / (0.5 * 9.81):.4g} s on" in line
