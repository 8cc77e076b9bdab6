"""The walls, their free sides, and the visible region."""

# Tests: pictures/motion/view.py

import matplotlib as mpl
import numpy as np
import pytest

from chain_impact.scene.texts.names import SLIDER_STOPS, STOPS
from tests.pictures.pictures import PLANAR, motion_of, page_of, page_of_width, panel_of, recorded, swing


def wall_lines(axes):
    """Return the end points of the walls' lines, (2, 2) each: lines without a marker, but with points."""
    lines = (line for line in axes.lines if line.get_marker() == "None" and len(line.get_xdata()))
    return [np.array(line.get_xydata()) for line in lines]


@pytest.mark.full("more cases", but=["arm_at_stop", "carried_arm"])
@pytest.mark.parametrize("model", PLANAR)
def test_the_motion_is_in_view_from_start_to_end_and_fills_it(model):
    recording = recorded(model)
    _, motion, *_ = page_of(recording)
    (low, high) = np.transpose([motion.get_xlim(), motion.get_ylim()])
    assert np.all(recording.points > low)
    assert np.all(recording.points < high)
    assert motion.get_aspect() == ("auto" if model == "steel_bar" else 1.0)
    ends = [recording.all_points]
    for point, radius in recording.touching_radii.items():
        ends += [recording.all_points[:, [point]] + side * radius for side in (-1.0, 1.0)]
    spans = np.ptp(np.concatenate(ends, axis=1), axis=(0, 1))
    axis = int(np.argmax(spans))
    assert spans[axis] > 0.7 * (high - low)[axis]


@pytest.mark.full("more cases", but=["arm_at_stop", "carried_arm"])
@pytest.mark.parametrize("model", PLANAR)
def test_every_wall_near_the_motion_is_a_line_at_its_place(model):
    recording = recorded(model)
    motion = motion_of(recording)
    ends = wall_lines(motion)
    # test_moving_walls.py tests moving walls; the stops of a slider are the ends of its line
    left_out = {*STOPS, *SLIDER_STOPS, *recording.moved_walls}
    hit = {recording.wall_names[wall] for wall in recording.impacts["wall"]} - left_out
    assert len(hit) <= len(ends) <= len(recording.walls)
    for name in hit:
        displacement = recording.columns.get(f"wall.{name}.position", np.zeros(1))[-1]
        gaps = [
            max(abs(recording.walls[name].clearance(*end) - displacement) for end in line) for line in ends
        ]
        assert min(gaps) < 1e-12, name


def test_walls_end_where_they_meet():
    _, motion, *_ = page_of(recorded("four_link_box"))
    corners = {tuple((end + 0.0).round(12) + 0.0) for line in wall_lines(motion) for end in line}
    assert (3.0, 0.0) in corners  # the floor and the right wall; the other walls are far from the motion
    assert len(corners) == 3
    # the ramp's walls meet at the origin; its top and its stop end at the border of the picture
    motion = motion_of(recorded("ramp"))
    view = [
        (value, axis) for axis, ends in enumerate((motion.get_xlim(), motion.get_ylim())) for value in ends
    ]
    ends = np.concatenate(wall_lines(motion))
    is_at_corner = np.abs(ends).max(axis=1) < 1e-12
    assert is_at_corner.sum() == 2
    assert all(min(abs(end[axis] - value) for value, axis in view) < 1e-12 for end in ends[~is_at_corner])


def test_the_room_is_white_and_all_beyond_it_grey():
    """Three walls, one of them inclined, and a fourth wall hidden behind the others."""
    walls = {"y_min": -0.2, "x_max": 1.1}
    slopes = {"slope": (-0.9, 0.0, -1.0), "hidden": (-2.4, 0.0, -1.0)}
    recording = swing(walls=walls, slopes=slopes)
    motion = motion_of(recording)
    assert len(wall_lines(motion)) == 3
    (room,) = motion.patches
    assert mpl.colors.to_hex(room.get_facecolor()) == "#ffffff"
    assert mpl.colors.to_hex(motion.get_facecolor()) != "#ffffff"
    outline, random = room.get_path(), np.random.default_rng(1)
    for place in random.uniform(
        (motion.get_xlim()[0], motion.get_ylim()[0]), (motion.get_xlim()[1], motion.get_ylim()[1]), (200, 2)
    ):
        is_free = min(wall.clearance(*place) for wall in recording.walls.values()) > 0.0
        assert outline.contains_point(place) == is_free


def test_points_that_move_beyond_a_wall_are_in_view():
    """Points that are not candidates pass through walls."""
    motion = motion_of(swing(walls={"y_max": 0.4}))
    assert motion.get_ylim()[1] > 1.0
    np.testing.assert_allclose(wall_lines(motion)[0][:, 1], 0.4, rtol=0, atol=1e-12)


@pytest.mark.full("takes long")
@pytest.mark.parametrize("angle", np.linspace(-3.0, 3.0, 7))
def test_a_wall_at_any_angle_is_seen_from_both_sides(angle):
    """A strip behind the wall is in view."""
    foot = np.array([0.0, 0.5]) + 0.8 * np.array([np.sin(angle), -np.cos(angle)])
    recording = swing(slopes={"slope": (*foot, angle)})
    motion = motion_of(recording)
    (line,) = wall_lines(motion)
    view = [(x, y) for x in motion.get_xlim() for y in motion.get_ylim()]
    gaps = [recording.walls["slope"].clearance(*corner) for corner in view]
    assert np.ptp(line, axis=0).max() > 0.5
    assert min(gaps) < -0.1 < 0.1 < max(gaps)


def test_a_pinned_base_stands_on_ground_in_view_and_a_free_one_does_not():
    def marks(model):
        motion = motion_of(recorded(model))
        mark_collections = [lines for lines in motion.collections if lines.get_zorder() == 3]
        return motion, [line for lines in mark_collections for line in lines.get_segments()]

    assert marks("four_link_box")[1] == []
    motion, lines = marks("pinned_arm")
    places = np.concatenate(lines)
    assert places[0].tolist() == [0.0, 0.0]
    assert (places[:, 1] >= 0.0).all()  # the arm hangs
    assert places[:, 1].max() < motion.get_ylim()[1]


@pytest.mark.parametrize("model", ["sphere_on_wall", "ramp"])
def test_a_disc_at_a_point_is_in_view_as_a_whole(model):
    recording = recorded(model)
    motion = motion_of(recording)
    ((point, radius),) = recording.touching_radii.items()
    places, (low, high) = recording.all_points[:, point], np.transpose([motion.get_xlim(), motion.get_ylim()])
    assert (places - radius > low).all()
    assert (places + radius < high).all()


def test_a_flat_motion_has_the_height_of_its_axes():
    """With equal scales, the bar that moves by 4 mm, and is 400 mm long, would be a line."""
    recording = recorded("steel_bar")
    motion = motion_of(recording)
    reach = np.ptp(recording.points[..., 1])
    assert 0.5 * np.ptp(motion.get_ylim()) < reach < np.ptp(motion.get_ylim())
    box = motion.get_window_extent()
    zoom = box.height / np.ptp(motion.get_ylim()) / (box.width / np.ptp(motion.get_xlim()))
    factor = float(motion.get_ylabel().partition("enlarged ")[2].removesuffix(" times"))
    assert factor == pytest.approx(zoom, rel=0.1)
    (low, high), ticks = motion.get_ylim(), motion.yaxis.get_major_ticks()
    labels = [(tick.get_loc(), tick.label1.get_text().replace("−", "-")) for tick in ticks]
    assert "[mm]" in motion.get_ylabel()
    assert all(float(text) == pytest.approx(1e3 * at) for at, text in labels if low <= at <= high)


@pytest.mark.full("takes long")
@pytest.mark.parametrize("model", ["clattering_rod", "double_pendulum_wall"])
def test_no_large_part_of_the_axes_is_empty(model):
    recording = recorded(model)
    for page in (page_of(recording)[0], page_of_width(model, 84)):
        motion = panel_of(page, "motion")
        places = recording.all_points.reshape(-1, 2)
        for axis, limits in enumerate((motion.get_xlim(), motion.get_ylim())):
            reach = places[:, axis]
            empty = max(reach.min() - limits[0], limits[1] - reach.max())
            assert empty < 0.3 * np.ptp(limits)


@pytest.mark.full("takes long")
@pytest.mark.parametrize("model", ["pinned_arm", "whip", "rod_drop"])
def test_the_view_of_a_narrow_picture_is_not_much_wider_than_the_motion(model):
    page = page_of_width(model, 120)
    motion = panel_of(page, "motion")
    places = recorded(model).points[..., 0]
    low, high = motion.get_xlim()
    margins = [places.min() - low, high - places.max()]
    assert min(margins) > 0.0
    assert max(margins) < 0.26 * (high - low)
    page.draw_without_rendering()
    assert motion.get_window_extent().height > 0.3 * page.bbox.height
