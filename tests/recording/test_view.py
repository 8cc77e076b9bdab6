"""The visible region of a motion."""

# Tests: recording/bodies.py, scene/half_planes.py

import numpy as np
import pytest

from chain_impact.recording.view import PIN_HEIGHT, WALL_DISTANCE, pin_lines, view_corners
from chain_impact.scene.display.outlines import Rail
from chain_impact.scene.half_planes import half_planes

SQUARE = np.array([[[0.0, 0.0], [2.0, 2.0]], [[0.0, 2.0], [2.0, 0.0]]])


@pytest.mark.parametrize("gap", [0.0, 0.1, 0.9 * 2.0 * WALL_DISTANCE])
def test_a_wall_that_is_near_is_in_view(gap):
    view, near_walls = view_corners(SQUARE, half_planes({"x_max": 2.0 + gap}, {}))
    assert len(near_walls) == 1
    assert view.tolist() == [[0.0, 0.0], [2.0 + gap, 2.0]]


@pytest.mark.parametrize("gap", [1.1 * 2.0 * WALL_DISTANCE, -2.1])
def test_a_wall_far_from_the_motion_is_not(gap):
    view, near_walls = view_corners(SQUARE, half_planes({"x_max": 2.0 + gap}, {}))
    assert near_walls == {}
    assert view.tolist() == [[0.0, 0.0], [2.0, 2.0]]


def test_the_radius_is_seen():
    view, _ = view_corners(SQUARE, {}, radius=0.5)
    assert view.tolist() == [[-0.5, -0.5], [2.5, 2.5]]


def test_a_wall_at_a_slant_is_seen_where_it_is_nearest():
    view, near_walls = view_corners(SQUARE, half_planes({}, {"ramp": (0.0, -0.2, -np.pi / 4)}))
    assert len(near_walls) == 1
    assert (view[0] < 0.0).all()
    assert abs(near_walls["ramp"].clearance(*view[0])) < 1e-12


def hanging(angles, side=-1.0):
    """Return a rod of 1 m at (1, 2), below it or above, shape (T, 2, 2)."""
    base = np.array([1.0, 2.0])
    return np.array([[base, base + np.array([np.sin(a), side * np.cos(a)])] for a in angles])


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_pinned_base_has_a_ground_mark_away_from_the_chain_and_in_view(side):
    points = hanging([-0.5, 0.0, 0.5], side)
    lines = np.concatenate(pin_lines(points))
    assert lines[0].tolist() == [1.0, 2.0]
    heights = -side * (lines[:, 1] - 2.0)
    assert heights.min() == 0.0
    assert heights.max() == pytest.approx(PIN_HEIGHT * 1.0)
    view, _ = view_corners(points, {}, is_pinned=True)
    assert (lines >= view[0]).all()
    assert (lines <= view[1]).all()


def test_the_ground_mark_of_a_base_that_moves_is_in_view_all_the_time():
    way = np.array([[[0.0, 0.0]], [[3.0, 1.0]], [[1.0, 4.0]]])
    points = hanging([-0.5, 0.0, 0.5]) + way
    view, _ = view_corners(points, {}, is_pinned=True)
    lines = np.concatenate([np.concatenate(pin_lines(points)) + place for place in way[:, 0]])
    assert (lines >= view[0]).all()
    assert (lines <= view[1]).all()


@pytest.mark.parametrize(("roof_gap", "is_whole"), [(1.9, True), (2.1, False)])
def test_a_closed_room_is_seen_whole_unless_it_is_far_larger(roof_gap, is_whole):
    walls = half_planes({"x_min": -0.1, "x_max": 2.1, "y_min": -0.1}, {"roof": (0.0, 2.0 + roof_gap, np.pi)})
    view, near_walls = view_corners(SQUARE, walls, room=1.0)
    assert len(near_walls) == (4 if is_whole else 3)
    np.testing.assert_allclose(view, [[-0.1, -0.1], [2.1, 2.0 + roof_gap if is_whole else 2.0]], atol=1e-12)


def test_a_room_that_is_open_on_a_side_is_not_closed():
    walls = half_planes({"x_min": -0.1, "x_max": 3.0, "y_min": -1.0}, {})
    view, near_walls = view_corners(SQUARE, walls, room=1.0)
    assert len(near_walls) == 1
    assert view.tolist() == [[-0.1, 0.0], [2.0, 2.0]]


def test_a_carriage_touches_the_drawn_stop_when_its_base_is_at_its_stop():
    rail = Rail.with_stops(np.array([0.3, -0.2]), 0.4, -0.5, 0.7, 2.0)
    bases = rail.origin + np.array([[-0.5], [0.7]]) * rail.direction
    line, *marks = rail.lines(bases)
    for base, end, mark, stop in zip(bases, line, marks, rail.stops.values(), strict=True):
        corners = rail.carriage(base)
        assert min(stop.clearance(*corner) for corner in corners) == pytest.approx(0.0, abs=1e-12)
        assert [stop.clearance(*place) for place in (end, *mark)] == pytest.approx([0.0] * 3, abs=1e-12)
