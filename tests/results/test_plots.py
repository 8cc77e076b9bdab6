"""Pictures: what of a recording is to be seen in them, and that nothing hides anything else."""

import itertools
import re

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.text import Annotation

from chain_impact import load_scene, simulate
from chain_impact.results.plots import SIZE, fill, plot
from chain_impact.results.recording import Impact, Recording, recording_of
from chain_impact.scene import model_names
from chain_impact.walls import half_planes
from tests.test_models import inputs_of

BEGINNINGS = {".png": b"\x89PNG\r\n\x1a\n", ".svg": b"<?xml", ".pdf": b"%PDF"}


@pytest.fixture(scope="module")
def recordings():
    """The recording of each model, driven as it is meant to be: name → recording."""
    return {name: recording_of(simulate(load_scene(name), inputs=inputs_of(name))) for name in model_names()}


def swing(impacts=(), walls=None, rows=50, slopes=None):
    """A rod of 1 m that turns about the origin by half a turn, from the right to the left through y > 0.

    The walls of the box and those at any angle as ``half_planes`` takes them.
    """
    time = np.linspace(0.0, 2.0, rows)
    angle = np.pi / 2 * time
    columns = {"point[0].x": 0 * time, "point[0].y": 0 * time}
    columns |= {"point[1].x": np.cos(angle), "point[1].y": np.sin(angle)}
    columns |= {f"energy.{name}": time for name in ("kinetic", "potential", "total", "dissipated")}
    return Recording("Swing", time, columns, list(impacts), half_planes(walls or {}, slopes or {}))


def drawn(recording):
    """The page with the recording, and its axes: motion, time, energy, impact speeds."""
    page = Figure(figsize=SIZE, layout="constrained")
    fill(page, recording)
    page.draw_without_rendering()
    return page, *page.axes


def labels(axes):
    return [text.get_text() for text in axes.texts if isinstance(text, Annotation)]


def wall_lines(axes):
    """The end points of the lines of the walls, (2, 2) each: they alone have no marker and no label."""
    lines = (line for line in axes.lines if line.get_marker() == "None")
    return [np.array(line.get_xydata()) for line in lines]


@pytest.mark.parametrize("suffix", BEGINNINGS)
def test_the_suffix_says_which_kind_of_file(tmp_path, suffix):
    path = tmp_path / f"swing{suffix}"
    plot(swing(), path)
    assert path.read_bytes().startswith(BEGINNINGS[suffix])
    assert list(tmp_path.iterdir()) == [path]


def test_a_picture_that_fails_leaves_the_old_one_alone(tmp_path, monkeypatch):
    def savefig(_, path, **__):
        path.write_text("half of it")
        raise MemoryError

    path = tmp_path / "swing.png"
    path.write_text("old")
    monkeypatch.setattr(Figure, "savefig", savefig)
    with pytest.raises(MemoryError):
        plot(swing(), path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_settings_of_matplotlib_are_left_alone(tmp_path):
    before = dict(mpl.rcParams)
    plot(swing(), tmp_path / "swing.png")
    assert dict(mpl.rcParams) == before


@pytest.mark.parametrize("model", model_names())
def test_the_motion_is_in_view_from_start_to_end(recordings, model):
    recording = recordings[model]
    _, motion, *_ = drawn(recording)
    (low, high) = np.transpose([motion.get_xlim(), motion.get_ylim()])
    assert np.all(recording.points > low)
    assert np.all(recording.points < high)
    frames = next(item for item in motion.collections if isinstance(item, LineCollection))
    for shown, row in ((0, 0), (-1, -1)):
        np.testing.assert_array_equal(frames.get_segments()[shown], recording.points[row])
        assert frames.get_array()[shown] == recording.time[row]
    assert motion.get_aspect() == 1.0


@pytest.mark.parametrize("model", model_names())
def test_every_wall_is_a_line_at_its_place(recordings, model):
    recording = recordings[model]
    _, motion, *_ = drawn(recording)
    ends = wall_lines(motion)
    assert len(ends) == len(recording.walls)
    for name, wall in recording.walls.items():
        gaps = [max(abs(wall.clearance(*end)) for end in line) for line in ends]
        assert min(gaps) < 1e-12, name


def test_walls_end_where_they_meet(recordings):
    _, motion, *_ = drawn(recordings["four_link_box"])
    corners = {tuple(end) for line in wall_lines(motion) for end in line}
    assert corners == {(0.0, 0.0), (3.0, 0.0), (0.0, 2.5), (3.0, 2.5)}
    # those of the ramp meet at the origin, and its top and its stop end where the picture does
    _, motion, *_ = drawn(recordings["ramp"])
    view = [
        (value, axis) for axis, ends in enumerate((motion.get_xlim(), motion.get_ylim())) for value in ends
    ]
    ends = np.concatenate(wall_lines(motion))
    met = np.abs(ends).max(axis=1) < 1e-12
    assert met.sum() == 2
    assert all(min(abs(end[axis] - value) for value, axis in view) < 1e-12 for end in ends[~met])


def test_the_room_is_white_and_all_beyond_it_grey():
    """Three walls, one of them at a slant, and a fourth that is hidden behind the others."""
    walls = {"y_min": -0.2, "x_max": 1.1}
    slopes = {"slope": (-0.9, 0.0, -1.0), "hidden": (-2.4, 0.0, -1.0)}
    recording = swing(walls=walls, slopes=slopes)
    _, motion, *_ = drawn(recording)
    assert len(wall_lines(motion)) == 3
    (room,) = motion.patches
    assert mpl.colors.to_hex(room.get_facecolor()) == "#ffffff"
    assert mpl.colors.to_hex(motion.get_facecolor()) != "#ffffff"
    outline, random = room.get_path(), np.random.default_rng(1)
    for place in random.uniform(
        (motion.get_xlim()[0], motion.get_ylim()[0]), (motion.get_xlim()[1], motion.get_ylim()[1]), (200, 2)
    ):
        inside = min(wall.clearance(*place) for wall in recording.walls.values()) > 0.0
        assert outline.contains_point(place) == inside


def test_a_wall_far_away_does_not_shrink_the_motion():
    _, motion, *_ = drawn(swing(walls={"x_max": 1e3, "y_min": -0.5}))
    assert len(wall_lines(motion)) == 1
    assert np.ptp(motion.get_xlim()) < 3.0
    assert motion.get_ylim()[0] < -0.5


def test_what_moves_beyond_a_wall_is_in_view():
    """Points that are not candidates pass through walls."""
    _, motion, *_ = drawn(swing(walls={"y_max": 0.4}))
    assert motion.get_ylim()[1] > 1.0
    np.testing.assert_allclose(wall_lines(motion)[0][:, 1], 0.4, rtol=0, atol=1e-12)


@pytest.mark.parametrize("angle", np.linspace(-3.0, 3.0, 7))
def test_a_wall_at_any_angle_is_seen_from_both_sides(angle):
    """A band beyond it is in view."""
    foot = np.array([0.0, 0.5]) + 1.2 * np.array([np.sin(angle), -np.cos(angle)])
    recording = swing(slopes={"slope": (*foot, angle)})
    _, motion, *_ = drawn(recording)
    (line,) = wall_lines(motion)
    view = [(x, y) for x in motion.get_xlim() for y in motion.get_ylim()]
    gaps = [recording.walls["slope"].clearance(*corner) for corner in view]
    assert np.ptp(line, axis=0).max() > 0.5
    assert min(gaps) < -0.1 < 0.1 < max(gaps)


def test_without_walls_nothing_is_grey():
    _, motion, *_ = drawn(swing())
    assert wall_lines(motion) == []
    assert mpl.colors.to_hex(motion.get_facecolor()) == "#ffffff"


def test_impacts_are_ringed_where_the_point_was_and_numbered():
    impacts = [Impact(0.5, 1, "x_max", 1.0), Impact(1.0, 1, "y_max", 2.0), Impact(1.5, 0, "y_min", 3.0)]
    s = np.sqrt(0.5)
    walls = {"x_max": s, "y_max": 1.1, "y_min": 0.0}  # of the second, a point with a radius of 0.1 m
    _, motion, _, _, speeds = drawn(swing(impacts, walls, rows=2001))
    rings = [line.get_xydata()[0] for line in motion.lines if line.get_markerfacecolor() == "none"]
    np.testing.assert_allclose(rings, [[s, s], [0.0, 1.1], [0.0, 0.0]], atol=1e-6)
    assert labels(motion) == ["1", "2", "3"]
    assert labels(speeds) == ["1", "2", "3"]


def test_impacts_at_one_place_share_a_ring_and_at_one_time_a_label():
    impacts = [Impact(time, 0, "y_min", 1.0) for time in (0.5, 0.51, 1.0, 1.5)]
    walls = {"y_min": 0.0, "y_max": 1.0}
    _, motion, _, _, speeds = drawn(swing([*impacts[:2], Impact(0.9, 1, "y_max", 1.0)], walls))
    assert labels(motion) == ["1, 2", "3"]
    assert labels(speeds) == ["1–2", "3"]
    _, motion, _, _, speeds = drawn(swing(impacts, walls))
    assert labels(motion) == ["1 … 4"]
    assert labels(speeds) == ["1–2", "3", "4"]


@pytest.mark.parametrize("model", model_names())
def test_every_impact_is_in_the_picture(recordings, model):
    recording = recordings[model]
    *_, energy, speeds = drawn(recording)
    stems = [path for item in speeds.collections for path in item.get_segments()]
    expected = sorted((impact.time, impact.speed) for impact in recording.impacts)
    assert sorted(tuple(stem[1]) for stem in stems) == expected
    assert len([line for line in energy.lines if len(line.get_xdata()) == 2]) == len(expected)
    ends = [int(number) for text in labels(speeds) for number in re.findall(r"\d+", text)]
    assert ends == sorted(ends)
    assert (ends[0], ends[-1]) == (1, len(expected))


@pytest.mark.parametrize("model", model_names())
def test_numbers_and_names_do_not_overlap(recordings, model):
    page, motion, clock, energy, speeds = drawn(recordings[model])
    motion_labels = [text.get_window_extent() for text in motion.texts]
    for one, other in itertools.combinations(motion_labels, 2):
        assert not one.overlaps(other)
    inside = motion.get_window_extent()
    for box in motion_labels:
        assert inside.x0 <= box.x0 <= box.x1 <= inside.x1
        assert inside.y0 <= box.y0 <= box.y1 <= inside.y1
    outside = [axes.get_legend().get_window_extent() for axes in (motion, energy, speeds)]
    outside += [axis.label.get_window_extent() for axes in page.axes for axis in (axes.xaxis, axes.yaxis)]
    panels = [axes.get_window_extent() for axes in (motion, clock, energy, speeds)]
    for box in outside:
        assert not any(box.overlaps(panel) for panel in panels)
        assert page.bbox.x0 <= box.x0 <= box.x1 <= page.bbox.x1
        assert page.bbox.y0 <= box.y0 <= box.y1 <= page.bbox.y1


@pytest.mark.parametrize("model", ["four_link_box", "pinned_arm", "ramp"])
def test_numbers_stand_outside_of_the_room(recordings, model):
    _, motion, *_ = drawn(recordings[model])
    to_data = motion.transData.inverted()
    walls = recordings[model].walls
    for text in motion.texts:
        (x0, y0), (x1, y1) = to_data.transform(text.get_window_extent().get_points())
        corners = [(x, y) for x in (x0, x1) for y in (y0, y1)]
        assert any(all(wall.clearance(*corner) < 0.0 for corner in corners) for wall in walls.values())
        rings = [line for line in motion.lines if line.get_markerfacecolor() == "none"]
        assert not any(ring.get_window_extent().overlaps(text.get_window_extent()) for ring in rings)


def test_all_that_is_measured_names_its_unit(recordings):
    _, motion, clock, energy, speeds = drawn(recordings["pinned_arm"])
    names = [motion.get_xlabel(), motion.get_ylabel(), clock.get_xlabel(), energy.get_ylabel()]
    assert [re.findall(r"\[(.*)\]", name) for name in names] == [["m"], ["m"], ["s"], ["J"]]
    assert speeds.get_ylabel() == "impact speed [m/s]"


def test_energy_from_inputs_is_drawn_if_there_is_any(recordings):
    _, _, _, energy, _ = drawn(recordings["pinned_arm"])
    assert "supplied" not in energy.get_legend_handles_labels()[1]
    recording = swing()
    recording.columns["energy.supplied"] = np.ones(50)
    _, _, _, energy, _ = drawn(recording)
    assert energy.get_legend_handles_labels()[1][-1] == "supplied"


def test_the_colours_of_the_motion_are_those_of_the_axis_of_time():
    _, motion, clock, _, _ = drawn(swing())
    frames, strip = motion.collections[0], clock.images[0]
    for time in (0.0, 0.7, 2.0):
        shade = strip.cmap(strip.norm(strip.get_array()[0, round(time / 2.0 * 255)]))
        np.testing.assert_allclose(frames.to_rgba(time), shade, atol=0.01)
    assert strip.get_extent() == [0.0, 2.0, 0, 1]


@pytest.mark.parametrize("rows", [1, 2])
def test_a_simulation_that_stopped_at_once_has_a_picture(tmp_path, rows):
    recording = swing(rows=2)
    columns = {name: column[:rows] for name, column in recording.columns.items()}
    plot(Recording("Stopped", recording.time[:rows], columns, [], {}), tmp_path / "stopped.png")
    assert (tmp_path / "stopped.png").stat().st_size > 0


def test_the_title_counts_impacts():
    for count, words in ((0, "0 impacts"), (1, "1 impact in"), (2, "2 impacts")):
        page, *_ = drawn(swing([Impact(1.0, 1, "y_max", 1.0)] * count, {"y_max": 1.0}))
        assert words in page.get_suptitle()
