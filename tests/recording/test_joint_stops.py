"""Joint stops in results: units, ranges, and their display in pictures, texts and tables."""

import cmath
import functools
import math

import numpy as np
import pytest
from matplotlib.figure import Figure
from rich.table import Table

from chain_impact import load_scene, simulate
from chain_impact.cli.screen import plain_lines, summary
from chain_impact.pictures.drawing.figures import FIGURE_SIZE
from chain_impact.pictures.motion.impact_rings import rings, rows_by_speed
from chain_impact.pictures.over_time.impacts import draw_impacts, stop_scale
from chain_impact.pictures.overview import draw_overview
from chain_impact.recording.csv_file import read_csv
from chain_impact.recording.impacts import IMPACT_DTYPE
from chain_impact.recording.interactions import JOINT_STOP
from chain_impact.recording.joint_stops import (
    RANGE_RADIUS,
    JointRange,
    range_lines,
    ranges_of,
    stop_mark,
)
from chain_impact.results.result import Result
from tests.helpers.scenes.stops import UP, knee_scene


@functools.cache
def swung(is_up=False):
    return simulate(knee_scene(**UP) if is_up else knee_scene())


def test_ranges_are_those_of_the_scene():
    scene = knee_scene(**{"link[1].joint_max": 3.0})
    expected = {1: JointRange(-math.inf, 3.0, 0.5), 2: JointRange(0.0, 2.0, 0.5)}
    assert ranges_of(scene.values) == expected
    values = {f"link[{i}].length": 0.5 for i in (1, 2)} | {"link[1].joint_max": 3.0}
    assert ranges_of(values | {"link[2].joint_min": 0.0, "link[2].joint_max": 2.0}) == expected
    assert ranges_of({"link[1].length": 1.0, "contact.radius": 0.0}) == {}


def test_an_arc_goes_from_stop_to_stop_or_a_right_angle_from_the_only_one():
    assert JointRange(-1.0, 2.0, 1.0).arc == (-1.0, 2.0)
    assert JointRange(-1.0, math.inf, 1.0).arc == (-1.0, -1.0 + math.pi / 2)
    assert JointRange(-math.inf, 2.0, 1.0).arc == (2.0 - math.pi / 2, 2.0)
    assert JointRange(-9.0, 9.0, 1.0).arc == (-9.0, -9.0 + math.tau)


def test_the_lines_of_a_range_begin_where_the_link_is_at_its_stop():
    points = np.array([[0.0, 0.0], [3.0, 4.0], [3.0, 6.0]])
    arc, *marks = range_lines(points, {2: JointRange(-0.5, 1.0, 2.0)})
    link_angle = cmath.phase(3 + 4j)
    for place, angle in ((arc[0], -0.5), (arc[-1], 1.0), (marks[0].mean(0), -0.5), (marks[1].mean(0), 1.0)):
        assert complex(*place) == pytest.approx(
            3 + 4j + cmath.rect(2.0 * RANGE_RADIUS, link_angle + angle), abs=1e-14
        )
    first, _ = range_lines(points, {1: JointRange(-math.inf, 0.0, 5.0)})
    # the angle of a link at a pinned base is measured from +x
    assert complex(*first[-1]) == pytest.approx(5.0 * RANGE_RADIUS)
    place, direction = stop_mark(points, 2)
    assert (place.tolist(), direction.tolist()) == ([3.0, 4.0 + 2.0 * RANGE_RADIUS], [0.0, 1.0])


def test_the_speeds_of_impacts_at_stops_can_be_compared_with_others():
    result = swung()
    at_stop, impacts = result.is_at_joint_stop, result.impacts
    assert (impacts["point"][0], result.wall_names[impacts["wall"][0]], at_stop[0]) == (2, "joint_min", True)
    assert at_stop.any()
    assert not at_stop.all()
    np.testing.assert_array_equal(
        result.linear_impact_speeds, impacts["impact_speed"] * np.where(at_stop, 0.5, 1.0)
    )
    speeds = result.linear_impact_speeds[rows_by_speed(result)].tolist()
    assert speeds == sorted(speeds, reverse=True)
    knee_at = result.point_at(1, impacts["onset"][0])
    # the ring is at the joint
    np.testing.assert_allclose(result.impact_position(impacts[0]), knee_at, atol=0.01)


def test_texts_name_the_joint_and_the_unit():
    first = [f"{swung().impacts['onset'][0]:.6f}", "joint", "2", "joint_min"]
    row = next(line for line in repr(swung()).splitlines() if line.startswith("1 "))
    assert row.split()[1:5] == first
    assert f"{swung().impacts['impact_speed'][0]:.4f} " in repr(swung())
    assert "<td>joint 2</td><td>joint_min</td>" in swung()._repr_html_()
    lines = [line for part in summary(swung()) if isinstance(part, Table) for line in plain_lines(part)]
    assert any("joint 2" in line and "joint_min" in line for line in lines)
    assert [line for line in lines if " m/s or " in line]
    assert [line for line in lines if " rad/s " in line]


def test_rows_of_impacts_with_loads_fit_into_80_columns():
    result = simulate(load_scene("arm_at_stop").with_values({"outputs.loads": True}))
    (table,) = [part for part in summary(result) if isinstance(part, Table)]
    lines = list(plain_lines(table))
    assert max(map(len, lines)) <= 80
    heads = lines[: len(lines) - len(result.impacts)]
    assert "rad/s" in " ".join(heads)
    assert "m/s " not in " ".join(heads).replace("rad/s", "")


@pytest.mark.full("takes long")
def test_tables_tell_the_units_at_stops():
    table = swung().impact_table()
    assert table.attrs["units"]["peak_force"] == "N"
    assert table.attrs["units_at_stops"]["peak_force"] == "N.m"
    assert table.attrs["units_at_stops"]["onset"] == "s"
    dataset = swung().to_xarray()
    assert dataset["joint[2].stop_moment"].attrs["units"] == "N.m"
    assert dataset["joint[2].stop_moment"].values.tolist() == swung()["joint[2].stop_moment"].tolist()
    assert dataset["force"].dims == ("time", "contact")
    assert dataset["contact"].values.tolist() == ["contact[1].x_max", "contact[2].x_max"]


def test_a_table_of_all_outputs_is_the_same_recording(tmp_path):
    result, path = swung(), tmp_path / "knee.csv"
    result.save_csv(path)
    recording = read_csv(path, result.scene)
    assert recording.stops == result.stops
    for name in set(IMPACT_DTYPE.names) - {"effective_mass", "x", "y"}:
        np.testing.assert_array_equal(recording.impacts[name], result.impacts[name])


@pytest.mark.parametrize(("is_up", "stop"), [(False, "joint_min"), (True, "joint_max")])
def test_touches_have_the_moments_of_stops(is_up, stop):
    result = swung(is_up)
    moments = {
        interaction.wall: interaction.force
        for interaction in result.interactions
        if interaction.kind == JOINT_STOP
    }
    sign = 1.0 if stop == "joint_min" else -1.0
    np.testing.assert_array_equal(moments[stop], np.maximum(sign * result["joint[2].stop_moment"], 0.0))
    assert moments[stop].max() > 0.0
    assert moments.keys() == {"joint_min", "joint_max"}


def test_impacts_at_stops_have_marks_and_their_own_axis():
    page, recording = Figure(figsize=FIGURE_SIZE, layout="constrained"), swung()
    draw_overview(page, recording)
    names = {name for axes in page.axes for name in axes.get_legend_handles_labels()[1]}
    assert {"stops", "impacts", "joint 2", "point 2"} <= names
    rows_of_rings = rings(page.axes[0], recording).values()
    assert recording.is_at_joint_stop[[hit for hits in rows_of_rings for hit in hits]].any()
    axes = Figure().add_subplot()
    draw_impacts(axes, recording)
    (right_axis,) = axes.child_axes
    assert (axes.get_ylabel(), right_axis.get_ylabel()) == ("peak force [kN]", "at stops [N·m]")
    scale, heights = stop_scale(recording), {line.get_label(): max(line.get_ydata()) for line in axes.lines}
    hardest = recording.impacts["peak_force"][recording.is_at_joint_stop].max()
    assert heights["joint 2"] == pytest.approx(scale * hardest)
    assert heights["joint 2"] == pytest.approx(heights["point 2"]), "each kind fills its axis"


def test_with_impacts_at_stops_only_the_axis_is_theirs():
    recording = swung()
    axes = Figure().add_subplot()
    recording = Result(
        recording.prepared_scene,
        recording.time,
        recording.outputs,
        recording.impacts[recording.is_at_joint_stop],
        statistics=recording.statistics,
    )
    draw_impacts(axes, recording)
    assert axes.get_ylabel() == "peak moment [N·m]"
    assert not axes.child_axes
    assert stop_scale(recording) == 1.0
