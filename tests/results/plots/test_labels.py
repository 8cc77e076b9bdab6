"""Labels get the first free place."""

import itertools

import numpy as np
import pytest
from matplotlib.figure import Figure

from chain_impact.results.plots.labels import (
    Label,
    marker_boxes,
    place_labels,
    settle,
    stem_boxes,
)

NOTHING = np.zeros((0, 4))  # obstacles


@pytest.fixture
def axes():
    axes = Figure(figsize=(4.0, 3.0), layout="constrained").add_subplot()
    settle(axes.figure)
    return axes


def test_the_first_keeps_its_place_and_one_without_room_is_left_out(axes):
    labels = [Label(str(k), (0.5, 0.5)) for k in range(9)]
    place_labels(axes, labels, NOTHING, fontsize=7)
    shown = [text.get_text() for text in axes.texts]
    assert shown[0] == "0"
    assert 1 < len(shown) < 9
    assert axes.texts[0].xyann[0] == 0.0  # right above its place
    for one, other in itertools.combinations([text.get_window_extent() for text in axes.texts], 2):
        assert not one.overlaps(other)


def test_a_label_keeps_off_obstacles_and_inside(axes):
    place_labels(
        axes,
        [Label("wide label", (1.0, 0.5)), Label("x", (0.5, 0.5))],
        marker_boxes(axes, [(0.5, 0.5)], 90.0),
    )
    assert len(axes.texts) == 0


def test_a_label_is_short_where_the_whole_has_no_room(axes):
    place_labels(axes, [Label("much too wide for the axes " * 3, (0.5, 0.5), short="7")], NOTHING)
    assert [text.get_text() for text in axes.texts] == ["7"]


def test_a_label_stands_on_the_side_it_is_meant_for(axes):
    place_labels(
        axes, [Label("left", (0.5, 0.2), (-1.0, 0.0)), Label("below", (0.5, 0.8), (0.0, -1.0))], NOTHING
    )
    left, below = (text.get_window_extent() for text in axes.texts)
    assert left.x1 < axes.transData.transform((0.5, 0.2))[0]
    assert below.y1 < axes.transData.transform((0.5, 0.8))[1]


def test_a_marker_is_as_large_as_it_is_drawn(axes):
    (box,) = marker_boxes(axes, [(0.5, 0.5)], 72.0)
    np.testing.assert_allclose(box[2:] - box[:2], axes.figure.dpi)
    np.testing.assert_allclose(0.5 * (box[2:] + box[:2]), axes.transData.transform((0.5, 0.5)))


def test_a_stem_stands_between_zero_and_its_top(axes):
    axes.set_ylim(-1.0, 1.0)
    (box,) = stem_boxes(axes, [(0.5, 0.8)])
    np.testing.assert_allclose(
        axes.transData.inverted().transform(box.reshape(2, 2)), [[0.5, 0.0], [0.5, 0.8]], atol=1e-12
    )
    place_labels(axes, [Label("x", (0.5, 0.4))], box[None], fontsize=7)
    (text,) = axes.texts
    assert text.xyann[0] != 0.0  # beside the stem
