"""The stops of joints in results: units, ranges, and what pictures, tables and animations show of them."""

import cmath
import functools
import math

import numpy as np
import pytest
from matplotlib.figure import Figure

from chain_impact import simulate
from chain_impact.cli.screen import plain_lines, summary
from chain_impact.results.animation.contacts import contacts
from chain_impact.results.animation.frames import motion_of
from chain_impact.results.animation.page import data
from chain_impact.results.csv_file import read_csv
from chain_impact.results.joint_stops import (
    ARC,
    JointRange,
    range_lines,
    ranges_from,
    ranges_of,
    touching_place,
)
from chain_impact.results.plots.motion import rings, strongest
from chain_impact.results.plots.over_time import draw_impact_speeds, stop_scale
from chain_impact.results.plots.overview import SIZE, fill
from chain_impact.results.result import recording_of
from tests.stops import UP, knee


@functools.cache
def swung(up=False):
    return simulate(knee(**UP) if up else knee())


@functools.cache
def recorded(up=False):
    return recording_of(swung(up))


def test_ranges_are_those_of_the_scene():
    scene = knee(**{"link[1].joint_max": 3.0})
    expected = {1: JointRange(-math.inf, 3.0, 0.5), 2: JointRange(0.0, 2.0, 0.5)}
    assert ranges_of(scene) == expected
    values = {f"link[{i}].length": 0.5 for i in (1, 2)} | {"link[1].joint_max": 3.0}
    assert ranges_from(values | {"link[2].joint_min": 0.0, "link[2].joint_max": 2.0}) == expected
    assert ranges_from({"link[1].length": 1.0, "contact.radius": 0.0}) == {}


def test_an_arc_goes_from_stop_to_stop_or_a_right_angle_from_the_only_one():
    assert JointRange(-1.0, 2.0, 1.0).arc == (-1.0, 2.0)
    assert JointRange(-1.0, math.inf, 1.0).arc == (-1.0, -1.0 + math.pi / 2)
    assert JointRange(-math.inf, 2.0, 1.0).arc == (2.0 - math.pi / 2, 2.0)
    assert JointRange(-9.0, 9.0, 1.0).arc == (-9.0, -9.0 + math.tau)


def test_the_lines_of_a_range_begin_where_the_link_is_at_its_stop():
    points = np.array([[0.0, 0.0], [3.0, 4.0], [3.0, 6.0]])
    arc, *marks = range_lines(points, {2: JointRange(-0.5, 1.0, 2.0)})
    along = cmath.phase(3 + 4j)
    for place, angle in ((arc[0], -0.5), (arc[-1], 1.0), (marks[0].mean(0), -0.5), (marks[1].mean(0), 1.0)):
        assert complex(*place) == pytest.approx(3 + 4j + cmath.rect(2.0 * ARC, along + angle), abs=1e-14)
    first, _ = range_lines(points, {1: JointRange(-math.inf, 0.0, 5.0)})
    assert complex(*first[-1]) == pytest.approx(5.0 * ARC)  # a pinned base: from +x
    place, direction = touching_place(points, 2)
    assert (place.tolist(), direction.tolist()) == ([3.0, 4.0 + 2.0 * ARC], [0.0, 1.0])


def test_impacts_at_stops_have_an_arm_and_a_speed_that_can_be_compared():
    found = recorded()
    first, wall = found.impacts[0], next(hit for hit in found.impacts if hit.wall == "x_max")
    assert (first.point, first.wall, first.at_stop, first.arm) == (2, "joint_min", True, 0.5)
    assert first.end_speed == 0.5 * first.speed
    assert (wall.at_stop, wall.end_speed) == (False, wall.speed)
    speeds = [hit.end_speed for hit in strongest(found.impacts, 99)]
    assert speeds == sorted(speeds, reverse=True)
    knee_at = np.array(found.point_at(1, first.time))
    assert np.linalg.norm(np.array(found.spot(first)) - knee_at) == pytest.approx(0.5 * ARC, rel=1e-2)


def test_texts_name_the_joint_and_the_unit():
    first = f"impact at {swung().impacts['onset'][0]:.6f} s: joint 2 hits joint_min at "
    assert first in repr(swung())
    assert f"{swung().impacts['impact_speed'][0]:.4f} rad/s" in repr(swung())
    assert "<td>joint 2</td><td>joint_min</td>" in swung()._repr_html_()
    lines = [line for part in summary(recorded()) if not isinstance(part, str) for line in plain_lines(part)]
    assert any("joint 2" in line and "rad/s" in line for line in lines)
    assert any("x_max" in line and " m/s" in line for line in lines)


@pytest.mark.full("takes long")
def test_tables_tell_the_units_at_stops():
    table = swung().impact_table()
    assert table.attrs["units"]["peak_force"] == "N"
    assert table.attrs["units_at_stops"]["peak_force"] == "N.m"
    assert table.attrs["units_at_stops"]["onset"] == "s"
    held = swung().to_xarray()
    assert held["joint[2].stop_moment"].attrs["units"] == "N.m"
    assert held["joint[2].stop_moment"].values.tolist() == swung()["joint[2].stop_moment"].tolist()
    assert held["force"].dims == ("time", "contact")
    assert held["contact"].values.tolist() == ["contact[1].x_max", "contact[2].x_max"]


def test_a_table_of_all_outputs_is_the_same_recording(tmp_path):
    result, path = swung(), tmp_path / "knee.csv"
    stepwise = result.stepwise
    whole = recording_of(result)
    whole.columns.update(stepwise)
    whole.save_csv(path)
    scene = result.scene
    again = read_csv(path, scene.half_planes, scene.wall_names, ranges_of(scene))
    assert again.stops == whole.stops
    assert again.impacts == whole.impacts
    assert [hit.arm for hit in again.impacts] == [hit.arm for hit in whole.impacts]


@pytest.mark.parametrize(("up", "stop"), [(False, "joint_min"), (True, "joint_max")])
def test_the_contacts_of_an_animation_have_the_moments_of_stops(up, stop):
    result, recording = swung(up), recorded(up)
    found = contacts(recording)
    assert [(c.point, c.wall, c.onset) for c in found if c.speed is not None] == [
        (hit.point, hit.wall, hit.time) for hit in recording.impacts
    ]
    first = found[0]
    assert (first.point, first.wall, first.arm) == (2, stop, 0.5)
    assert first.peak_force == result.impacts["peak_force"][0]
    motion = motion_of(recording)
    sign = 1.0 if stop == "joint_min" else -1.0
    largest = max(sign * result["joint[2].stop_moment"])
    assert motion.moments[2, stop].max() == pytest.approx(largest, rel=0.05)
    assert motion.moments[2, stop].min() == 0.0
    assert (2, stop) not in motion.forces
    assert motion.touching == [2]


def test_the_page_has_the_ranges_and_tells_stops_from_walls():
    packed = data(motion_of(recorded()), 1.0)
    assert packed["stops"] == [{"joint": 2, "arc": (0.0, 2.0), "marks": [0.0, 2.0]}]
    at_stop = {contact["wall"]: contact["atStop"] for contact in packed["contacts"]}
    assert at_stop["joint_min"] is True
    assert at_stop["x_max"] is False
    walls = [c["peak"] for c in packed["contacts"] if not c["atStop"] and c["peak"] is not None]
    assert packed["peakForce"] == max(walls), "in newtons: moments have no arrows"


def test_the_picture_has_a_mark_for_each_stop_and_an_axis_of_their_own_for_their_speeds():
    page, recording = Figure(figsize=SIZE, layout="constrained"), recorded()
    fill(page, recording)
    names = {name for axes in page.axes for name in axes.get_legend_handles_labels()[1]}
    assert {"stops", "impacts", "joint 2", "point 2"} <= names
    assert {hit.wall for hits in rings(page.axes[0], recording).values() for hit in hits} >= {"joint_min"}
    axes = Figure().add_subplot()
    draw_impact_speeds(axes, recording)
    (right,) = axes.child_axes
    assert (axes.get_ylabel(), right.get_ylabel()) == ("impact speed [m/s]", "at stops [rad/s]")
    scale, heights = stop_scale(recording), {line.get_label(): max(line.get_ydata()) for line in axes.lines}
    fastest = max(hit.speed for hit in recording.impacts if hit.at_stop)
    assert heights["joint 2"] == pytest.approx(scale * fastest)
    assert heights["joint 2"] == pytest.approx(heights["point 2"]), "each kind fills its axis"


def test_with_impacts_at_stops_only_the_axis_is_theirs():
    recording = recorded()
    axes = Figure().add_subplot()
    at_stops = [hit for hit in recording.impacts if hit.at_stop]
    recording = type(recording)(**{**vars(recording), "impacts": at_stops})
    draw_impact_speeds(axes, recording)
    assert axes.get_ylabel() == "impact speed [rad/s]"
    assert not axes.child_axes
    assert stop_scale(recording) == 1.0
