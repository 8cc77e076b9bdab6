"""The picture of the motion: its poses, its paths, and the numbers of the impacts."""

# Tests: pictures/motion/bodies.py, pictures/motion/impact_rings.py, pictures/motion/joint_forces.py
# Tests: pictures/motion/poses.py, pictures/motion/named_points.py, pictures/texts/point_names.py

import functools
import itertools
import re

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.path import Path
from matplotlib.quiver import Quiver
from matplotlib.text import Text

from chain_impact import load_scene, simulate
from chain_impact.pictures import draw_chain
from chain_impact.pictures.drawing import figures
from chain_impact.pictures.drawing.axis_numbers import force_text
from chain_impact.pictures.drawing.colours import LOAD, PEAK_COLOUR
from chain_impact.pictures.drawing.labels import MARK_LENGTH
from chain_impact.pictures.motion.impact_rings import RING_SIZE, rings, rows_by_speed
from chain_impact.pictures.motion.joint_forces import LOAD_SHIFT, draw_loads, part_in_view, shifted_foot
from chain_impact.pictures.motion.motion import small_reach
from chain_impact.pictures.motion.named_points import NAME, touching_points
from chain_impact.pictures.motion.poses import FAINT_POSES, MOST_STRONG_POSES, distinct_poses, strong_rows
from chain_impact.pictures.motion.view import view_of
from chain_impact.pictures.over_time.impacts import marks_of, rows_by_height
from chain_impact.pictures.overview import draw_overview, usual_overview_size
from chain_impact.pictures.texts.headline import largest_peaks, marked_peaks
from chain_impact.recording.joint_peaks import joint_peaks
from chain_impact.recording.joint_stops import range_lines
from chain_impact.recording.view import ball_of
from chain_impact.scene.display.outlines import size_of_motion
from tests.pictures.pictures import (
    boxes,
    crowd,
    impact_row,
    motion_of,
    page_of,
    page_of_width,
    panel_of,
    recorded,
    swing,
    texts,
)


def poses(axes):
    """Return the strongly drawn chains, as arrays (N + 1, 2) [m]."""
    return [np.array(line.get_xydata()) for line in axes.lines if line.get_zorder() == 4]


def ring_places(axes):
    rings = [
        line
        for line in axes.lines
        if line.get_markerfacecolor() == "none" and line.get_color() != PEAK_COLOUR
    ]
    return np.concatenate([line.get_xydata() for line in rings])


def cases(*models):
    """Return pairs of a model and the width of a page [mm]: one column, one and a half, or two."""
    return [*itertools.product(models, (84, 120, 190))]


@pytest.mark.full("takes long")
@pytest.mark.parametrize(("model", "width"), cases("thrown_brick", "hopper", "four_link_box", "whip"))
def test_points_that_touch_have_names_nearest_to_their_place_at_the_start(model, width):
    recording = recorded(model)
    motion = panel_of(page_of_width(model, width), "motion")
    places = motion.transData.transform(recording.all_points[0])
    names = [text for text in motion.texts if text.get_gid() == NAME]
    numbers = {name: number for number, name in recording.point_names.items()}
    assert names
    assert names[0].get_text() in numbers or names[0].get_text().startswith("point ")
    for name in names:
        text = name.get_text().removeprefix("point ")
        point, box = numbers.get(text) or int(text), name.get_window_extent()
        assert point in touching_points(recording)
        if name.arrow_patch is None:
            gaps = np.hypot(*(places - np.clip(places, box.min, box.max)).T)
            assert gaps[point] < gaps.min() + 0.1


def test_an_arrow_along_a_link_stands_beside_it():
    pose = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.5]])
    for force, foot in [((1.0, 0.1), [-0.01, 0.1]), ((1.0, -0.1), [-0.01, -0.1]), ((0.0, 1.0), [0.0, 0.0])]:
        np.testing.assert_allclose(shifted_foot(pose, 1, np.array(force), 0.1), foot, atol=1e-3)


@pytest.mark.full("more cases", but="four_link_box")
@pytest.mark.parametrize("model", ["four_link_box", "pinned_arm", "ramp", "hopper"])
def test_strong_poses_are_start_end_and_those_of_strong_impacts_apart(model):
    recording = recorded(model)
    motion = motion_of(recording)
    *at_impacts, start, end = poses(motion)
    np.testing.assert_array_equal(start, recording.points[0])
    np.testing.assert_array_equal(end, recording.points[-1])
    times = recording.impacts["onset"][strong_rows(recording)].tolist()
    assert 0 < len(at_impacts) == len(times) <= MOST_STRONG_POSES
    fastest = recording.impacts["onset"][rows_by_speed(recording)[0]]
    for time, pose in zip(times, at_impacts, strict=True):
        np.testing.assert_array_equal(pose, recording.pose_at(time))
        impact = recording.impacts[recording.impacts["onset"] == time][0]
        place = recording.all_points[recording.row_at(time)][impact["point"]]
        # the pose is that of the nearest row, so the point may be away from its wall by its motion in 1 ms
        gap = recording.wall_of(impact).clearance(*place) - recording.touching_radii[impact["point"]]
        assert abs(gap) < 1.1e-3 * impact["impact_speed"]
    if len(recording.impacts) > MOST_STRONG_POSES:
        assert times == [recording.impacts["onset"][marked_peaks(recording)[0].row]]
        return
    distinct, expected = [start, end], []
    for onset in recording.impacts["onset"][rows_by_speed(recording)]:
        pose = recording.pose_at(onset)
        gap = min(np.hypot(*(pose - distinct_pose).T).mean() for distinct_pose in distinct)
        if onset == fastest or gap >= 0.1 * size_of_motion(recording.all_points):
            distinct.append(pose)
            expected.append(onset)
    assert times == sorted(expected)


def test_poses_that_look_alike_are_left_out():
    places = np.array([0.0, 0.04, 0.1, 0.13, 0.25, 0.01])
    rods = np.stack([np.stack([places, places + 1.0], axis=1), np.zeros((6, 2))], axis=-1)
    assert distinct_poses(rods, 0.1) == [0, 2, 4]
    assert distinct_poses(rods, 0.1, always_kept=2) == [0, 1, 4]


def test_every_impact_has_a_strong_pose_if_there_are_few():
    recording = recorded("pinned_arm")
    assert strong_rows(recording) == list(range(len(recording.impacts)))


def test_poses_have_entries_in_the_legend_and_are_few():
    axes = motion_of(recorded("four_link_box"))
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert labels[:3] == ["chain between", "other points", "tip"]
    assert labels[3:] == ["at impact 1", "start", "end", "impacts", "peak force"]
    (faint_lines,) = (lines for lines in axes.collections if lines.get_label() == "chain between")
    assert 1 < len(faint_lines.get_segments()) <= FAINT_POSES


def test_a_pose_is_that_of_the_nearest_row_so_no_link_shrinks():
    recording = swing(rows=3)
    np.testing.assert_allclose(recording.pose_at(0.4), recording.points[0], atol=1e-15)


def test_paths_of_all_points_are_drawn_that_of_the_tip_strongest():
    recording = recorded("four_link_box")
    motion = motion_of(recording)
    _, point_paths, tip = motion.collections
    for point, path in enumerate(point_paths.get_segments()):
        np.testing.assert_array_equal(path, recording.points[:, point])
    ends = np.array(tip.get_segments())
    np.testing.assert_array_equal(ends[:, 1], recording.points[1:, -1])
    assert tip.get_linewidth()[0] > point_paths.get_linewidth()[0]
    assert point_paths.get_alpha() < 0.5


def test_the_line_along_a_dense_path_is_thin():
    """The path of a shaken pendulum's tip fills an area; a simple pendulum's tip repeats one arc."""
    widths = {}
    for model in ("shaken_pendulum", "simple_pendulum"):
        lines = motion_of(recorded(model)).collections
        (path,) = (lines for lines in lines if lines.get_label().startswith("tip"))
        (widths[model],) = path.get_linewidths()
    assert widths["shaken_pendulum"] < 0.6 * widths["simple_pendulum"]


def test_the_legend_tells_that_the_last_swing_covers_earlier_ones():
    """The pendulum swings from side to side in 1.8 s, and passes along one arc."""
    axes = motion_of(recorded("simple_pendulum"))
    assert "tip, last 1.8 s on top" in axes.get_legend_handles_labels()[1]


def test_a_motion_that_marks_hide_is_told_and_has_no_path():
    labels = motion_of(recorded("sphere_on_wall")).get_legend_handles_labels()[1]
    assert labels == ["start", "end", "peak force"]
    foot = " ".join(text.get_text() for text in page_of(recorded("sphere_on_wall"))[0].texts)
    assert "no point moves more than 2.05 mm along x or y" in foot.replace("\n", " ")


def test_points_of_a_body_count_in_what_moves():
    """The corners of the block move by 0.13 m, the ends of the link by much less."""
    recording = recorded("rocking_block")
    assert np.ptp(recording.all_points, axis=0).max() > 5.0 * np.ptp(recording.points, axis=0).max()
    assert small_reach(recording, view_of(recording).corners) == ""


def test_walls_that_are_not_reached_are_told_if_none_is_drawn():
    for height, has_note in ((1.3, False), (3.0, True)):  # the rod has a length of 1 m
        page = page_of(swing(walls={"y_max": height}))[0]
        assert any("not reached: y_max" in text.get_text() for text in page.texts) == has_note


def test_a_chain_is_a_line_that_can_be_moved():
    axes = Figure().add_subplot()
    line = draw_chain(axes, np.array([[0.0, 0.0], [1.0, 2.0]]), color="red", linewidth=5.0)
    assert line.get_color() == "red"
    assert line.get_linewidth() == 5.0
    assert axes.lines[0] is line
    line.set_data(*np.array([[0.0, 1.0], [3.0, 4.0]]).T)
    np.testing.assert_array_equal(line.get_xydata(), [[0.0, 1.0], [3.0, 4.0]])


def test_impacts_are_ringed_where_the_point_was_and_numbered():
    impacts = [
        impact_row(0.5, 1, "x_max", 3.0),
        impact_row(1.0, 1, "y_max", 2.0),
        impact_row(1.5, 0, "y_min", 1.0),
    ]
    s = np.sqrt(0.5)
    # the point is 0.1 m away from y_max, as if it had this radius: the ring is on the wall
    walls = {"x_max": s, "y_max": 1.1, "y_min": 0.0}
    motion = motion_of(swing(impacts, walls, rows=2001))
    np.testing.assert_allclose(ring_places(motion), [[s, s], [0.0, 1.1], [0.0, 0.0]], atol=1e-6)
    assert texts(motion) == ["#1", "#2", "#3"]


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("model", ["four_link_box", "arm_at_stop", "bouncing_ball"])
def test_the_impact_with_the_largest_force_is_marked_in_both_panels(model):
    recording = recorded(model)
    (peak,) = largest_peaks(recording)
    page = page_of(recording)[0]
    motion, speeds = (
        next(axes for axes in page.axes if axes.get_label() == name) for name in ("motion", "impacts")
    )
    (ring,) = (line for line in motion.lines if line.get_color() == PEAK_COLOUR)
    assert ring.get_label() == peak.name
    assert peak.name in [text.get_text() for text in motion.get_legend().get_texts()]
    spot = recording.impact_position(recording.impacts[peak.row])
    if model != "bouncing_ball":
        np.testing.assert_allclose(ring.get_xydata()[0], spot)
    (mark,) = (line for line in speeds.lines if line.get_color() == PEAK_COLOUR)
    assert mark.get_xdata() == [recording.impacts["onset"][peak.row]]
    (label,) = (text for text in speeds.texts if text.get_color() == PEAK_COLOUR)
    assert label.get_text().replace("\n", " ") == f"#{peak.row + 1}: {peak.value}"


@pytest.mark.full("takes long")
def test_impacts_at_one_place_share_a_ring():
    walls = {"y_min": 0.0, "y_max": 1.0}
    floor = [impact_row(time, 0, "y_min", time) for time in (0.5, 0.51, 1.0, 1.5)]
    motion = motion_of(swing([*floor[:2], impact_row(0.9, 1, "y_max", 9.0)], walls))
    assert [" ".join(text.split()) for text in texts(motion)] == ["#3", "#1, 2"]
    motion = motion_of(swing(floor, walls))
    assert texts(motion) == ["#1–4"]
    alternating = [
        row
        for k in range(4)
        for row in (impact_row(0.2 + k / 5, 0, "y_min", 1.0 + k), impact_row(0.3 + k / 5, 1, "y_max", 9.0))
    ]
    motion = motion_of(swing(alternating, walls))
    assert sorted(texts(motion)) == ["#1, 3, 5, 7", "#2", "#4", "#6", "#8"]
    many = [impact_row(0.2 + k / 10, k % 2, "y_max" if k % 2 else "y_min", 1.0 + (k == 4)) for k in range(14)]
    labels = [text.replace("\n", " ") for text in texts(motion_of(swing(many, walls)))]
    assert labels[0] in ("#1, 3 … 13", "#5 + 6 more")


@pytest.mark.full("takes long")
@pytest.mark.parametrize(("model", "width"), [("thrown_brick", 120), ("four_link_box", 84)])
def test_only_rings_that_overlap_are_one_ring(model, width):
    recording, page = recorded(model), page_of_width(model, width)
    motion = panel_of(page, "motion")
    spots = [recording.impact_position(impact) for impact in recording.impacts]
    pixels, drawn_pixels = map(motion.transData.transform, (spots, list(rings(motion, recording))))
    distances = np.hypot(*(pixels[:, None] - drawn_pixels).transpose(2, 0, 1)).min(axis=1)
    assert distances.max() < RING_SIZE * page.dpi / 72.0


def told_count(text):
    """Return the number of impacts in a label of a ring, such as "1, 3–5", "1, 3 … 9" or "2 + 14 more"."""
    first, *rest_texts = re.split(r" \+ ?", text)
    if rest_texts:
        return 1 + int(rest_texts[0].removesuffix(" more"))
    if "…" in first:
        low, step, high = map(int, re.split(", | … ", first))
        return 1 + (high - low) // (step - low)
    ends = [list(map(int, part.split("–"))) for part in first.split(", ")]
    return sum(end[-1] - end[0] + 1 for end in ends)


@pytest.mark.full("more cases", but="rod_drop")
@pytest.mark.parametrize("model", ["four_link_box", "rod_drop"])
def test_no_list_of_numbers_at_a_ring_is_silently_short(model):
    recording = recorded(model)
    motion = panel_of(page_of_width(model, 84), "motion")
    labels = [text.replace("\n", " ") for text in texts(motion)]
    lists = [text.removeprefix("#") for text in labels if text.startswith("#")]
    assert sum(map(told_count, lists)) == len(recording.impacts)


def test_the_largest_joint_force_is_told_first():
    arm = simulate(load_scene("pinned_arm").with_values({"outputs.loads": True}))
    motion = panel_of(arm.plot(size=(84 / 25.4, None)), "motion")
    labels = [text.get_text() for text in motion.texts if text.get_color() == LOAD]
    assert labels[0].endswith(force_text(joint_peaks(arm)[0].force, "N"))


@pytest.mark.full("more cases", but=3)
@pytest.mark.parametrize("model", ["four_link_box", "pinned_arm", "ramp", "crowd"])
def test_numbers_stand_off_the_rings(model):
    recording = crowd() if model == "crowd" else recorded(model)
    motion = motion_of(recording)
    rings = motion.transData.transform(ring_places(motion))
    for box in boxes(motion):
        assert not any(box.contains(*ring) for ring in rings)


def distance(segment, place):
    """Return the distance of a place from a line segment, given by its two ends."""
    start, way = segment[0], segment[1] - segment[0]
    part = np.clip((place - start) @ way / (way @ way), 0.0, 1.0)
    return np.hypot(*(start + part * way - place))


@pytest.mark.full("takes long")
@pytest.mark.parametrize(("model", "width"), cases("four_link_box", "hopper", "pinned_arm", "crowd"))
def test_no_leader_passes_another_ring_or_crosses_a_chain_at_start_or_end(model, width):
    if model == "crowd":
        recording, size = crowd(), usual_overview_size(crowd(), size=(width / 25.4, None))
        page = figures.draw_figure(functools.partial(draw_overview, recording=recording), usual_size=size)
    else:
        recording, page = recorded(model), page_of_width(model, width)
    page.draw_without_rendering()
    motion = panel_of(page, "motion")
    at, point = motion.transData.transform, page.dpi / 72.0
    chains = [at(recording.points[row]) for row in (0, -1)]
    places = at(list(rings(motion, recording)))
    for text in motion.texts:
        if text.arrow_patch is None:
            continue
        box, start = Text.get_window_extent(text), at(text.xy)
        leader = np.array([start, 0.5 * (box.min + box.max)])
        for place in places[np.hypot(*(places - start).T) > MARK_LENGTH * point]:
            assert distance(leader, place) > 0.5 * RING_SIZE * point, text.get_text()
        way = leader[1] - leader[0]
        free_part = np.array([leader[0] + way * MARK_LENGTH * point / np.hypot(*way), leader[1]])
        for chain in chains:
            assert not Path(chain).intersects_path(Path(free_part), filled=False), text.get_text()


def test_a_joints_largest_force_is_an_arrow_at_its_place():
    recording = simulate(load_scene("pinned_arm").with_values({"outputs.loads": True}))
    motion = motion_of(recording)
    (arrows,) = (collection for collection in motion.collections if isinstance(collection, Quiver))
    peaks = [recording[f"joint[{joint}].peak_force"][-1] for joint in (2, 1)]
    assert np.hypot(arrows.U, arrows.V) == pytest.approx(peaks)
    # an arrow along a link is beside the link
    shift = 1.01 * LOAD_SHIFT * max(np.ptp(motion.get_xlim()), np.ptp(motion.get_ylim()))
    assert np.hypot(*arrows.XY[1]) <= shift
    row = np.hypot(*recording.joint_forces[2].T).argmax()
    assert np.hypot(*(arrows.XY[0] - recording.points[row, 1])) <= shift
    assert arrows.V[0] / arrows.U[0] == pytest.approx(
        recording.joint_forces[2][row, 1] / recording.joint_forces[2][row, 0]
    )
    assert motion.get_legend().get_texts()[-1].get_text() == "joint forces\n≤ 670 N"


def test_arrows_of_joint_forces_are_shorter_if_one_would_leave_the_view():
    corners, ways = np.array([[0.0, -1.0], [2.0, 1.0]]), np.array([[0.5, 0.0], [0.0, -1.0]])
    assert part_in_view(np.array([[1.0, 0.0], [1.0, 0.5]]), ways, corners) == 1.0
    assert part_in_view(np.array([[1.0, 0.0], [1.0, -0.4]]), ways, corners) == pytest.approx(0.6)


def test_the_hardest_impact_is_numbered():
    for recording in (recorded("four_link_box"), crowd()):
        motion = motion_of(recording)
        number = str(rows_by_height(marks_of(recording)[1])[0] + 1)
        assert any(number in re.split("[#, ]", text) for text in texts(motion))


def test_the_sample_of_the_tip_in_the_legend_has_the_colours_of_its_path():
    axes = motion_of(recorded("four_link_box"))
    entries = dict(zip(axes.get_legend_handles_labels()[1], axes.get_legend().legend_handles, strict=True))
    path = next(lines for lines in axes.collections if lines.get_label() == "tip").get_colors()
    sample = entries["tip"].get_colors()
    np.testing.assert_array_equal(sample[[0, -1]], path[[0, -1]])
    assert len(sample) > 5


@pytest.mark.parametrize("model", ["ramp", "sphere_on_wall"])
def test_a_ball_is_drawn_as_its_centre_with_a_thin_line_and_its_path(model):
    recording = recorded(model)
    assert ball_of(recording) == 0
    motion = motion_of(recording)
    (end,) = (line for line in motion.lines if line.get_label().startswith("end"))
    assert end.get_markevery() == [0]
    assert end.get_linewidth() < 1.0
    paths = [lines for lines in motion.collections if lines.get_label().startswith("path")]
    if model == "sphere_on_wall":  # the mark of the centre covers its path
        assert not paths
    else:
        np.testing.assert_array_equal(paths[0].get_segments()[0][0], recording.points[0, 0])


@pytest.mark.parametrize("model", ["rod_drop", "pinned_arm", "thrown_brick", "cart_pole"])
def test_other_chains_are_no_balls(model):
    assert ball_of(recorded(model)) is None


def test_a_link_whose_centre_of_mass_is_beside_its_end_is_no_ball():
    scene = load_scene("bouncing_ball").with_values({"link[1].center_of_mass_offset": 0.03})
    assert ball_of(simulate(scene, stop_time=0.05)) is None


def test_arcs_of_stops_and_poses_of_joint_forces_have_their_times():
    leg = simulate("kneed_leg")
    axes = leg.plot(panels=["motion"]).axes[0]
    (arcs,) = (lines for lines in axes.collections if lines.get_label() == "stops")
    pose = leg.pose_at(leg.impacts["onset"][0])
    expected = list(range_lines(pose, leg.stops))
    assert all(np.allclose(*pair) for pair in zip(arcs.get_segments(), expected, strict=True))
    arm = simulate("carried_arm")
    page = arm.plot(panels=["motion"])
    axes = page.axes[0]
    largest_peak, *other_peaks = joint_peaks(arm)
    load_axes = Figure().subplots()
    draw_loads(load_axes, arm, view_of(arm))
    load_poses = [
        [line.get_xydata() for line in panel.lines if line.get_color() == LOAD and len(line.get_xdata()) > 1]
        for panel in (load_axes, axes)
    ]
    assert [xy.tolist() for xy in load_poses[0]] == [arm.pose_at(largest_peak.time).tolist()]
    assert load_poses[1] == [], "the pose at the impact is like that of the largest force"
    axes_text = " ".join(text.get_text() for text in axes.texts)
    assert all(f"joint {peak.joint}: {peak.force:.0f} N" in axes_text for peak in other_peaks)
    # the label of the largest force may lack the name of the joint beside which it stands
    assert f"{largest_peak.force:.0f} N" in axes_text
    head = " ".join(text.get_text() for text in page.texts)
    assert f"joint {largest_peak.joint} bears up to {largest_peak.force:.0f} N" in head
