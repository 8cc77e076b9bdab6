"""What is to be seen of a motion."""

import numpy as np
import pytest

from chain_impact.results.view import NEAR, seen
from chain_impact.walls import half_planes

SQUARE = np.array([[[0.0, 0.0], [2.0, 2.0]], [[0.0, 2.0], [2.0, 0.0]]])


@pytest.mark.parametrize("gap", [0.0, 0.1, 0.9 * 2.0 * NEAR])
def test_a_wall_that_is_near_is_in_view(gap):
    view, near = seen(SQUARE, half_planes({"x_max": 2.0 + gap}, {}))
    assert len(near) == 1
    assert view.tolist() == [[0.0, 0.0], [2.0 + gap, 2.0]]


@pytest.mark.parametrize("gap", [1.1 * 2.0 * NEAR, -2.1])
def test_a_wall_far_from_the_motion_is_not(gap):
    view, near = seen(SQUARE, half_planes({"x_max": 2.0 + gap}, {}))
    assert near == []
    assert view.tolist() == [[0.0, 0.0], [2.0, 2.0]]


def test_the_radius_is_seen():
    view, _ = seen(SQUARE, {}, radius=0.5)
    assert view.tolist() == [[-0.5, -0.5], [2.5, 2.5]]


def test_a_wall_at_a_slant_is_seen_where_it_is_nearest():
    view, near = seen(SQUARE, half_planes({}, {"ramp": (0.0, -0.2, -np.pi / 4)}))
    assert len(near) == 1
    assert (view[0] < 0.0).all()
    assert abs(near[0].clearance(*view[0])) < 1e-12
