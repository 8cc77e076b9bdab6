"""Labels get the first free place, and curves' names stay apart."""

import itertools

import numpy as np
import pytest
from hypothesis import given, strategies as st
from matplotlib.figure import Figure
from matplotlib.text import Text

from chain_impact.results.plots.labels import (
    Label,
    apart,
    label_curves,
    marker_boxes,
    place_labels,
    settle,
    spread_labels,
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


def test_names_of_curves_stay_apart_and_in_order(axes):
    curves = [(1.0, y, f"curve {k}", "black") for k, y in enumerate((0.5, 0.5, 0.52, 0.9))]
    names = label_curves(axes, curves, fontsize=9)
    spread_labels(axes, names)
    axes.figure.draw_without_rendering()
    boxes = [Text.get_window_extent(name) for name in names]  # without the lines
    for one, other in itertools.combinations(boxes, 2):
        assert not one.overlaps(other)
    heights = [box.y0 for box in boxes]
    assert heights == sorted(heights)
    assert all(box.x0 > axes.get_window_extent().x1 for box in boxes)


def test_lines_to_names_of_curves_cross_no_other_name(axes):
    names = label_curves(
        axes, [(1.0, 0.9 + 0.001 * k, f"a long name {k}", "black") for k in range(6)], fontsize=9
    )
    spread_labels(axes, names)
    axes.figure.draw_without_rendering()
    boxes = [Text.get_window_extent(name) for name in names]
    for name, box in itertools.product(names, boxes):
        path = name.arrow_patch.get_path().transformed(name.arrow_patch.get_transform())
        assert not path.intersects_bbox(box.padded(-1.0), filled=False)


@given(st.lists(st.floats(-5.0, 15.0), max_size=8), st.floats(0.01, 1.0))
def test_heights_keep_their_gap_their_order_and_the_bounds(wanted, gap):
    heights = apart(wanted, gap, 0.0, 10.0)
    assert len(heights) == len(wanted)
    ordered = heights[np.argsort(wanted, kind="stable")]
    assert np.all(np.diff(ordered) >= gap * (1 - 1e-9))
    assert np.all((heights > -1e-9) & (heights < 10.0 + 1e-9))


@given(st.lists(st.floats(2.0, 8.0), min_size=2, max_size=5))
def test_heights_shift_as_little_as_they_can(wanted):
    """Against a search of scipy for the least sum of squares under the same gaps."""
    from scipy.optimize import minimize

    wanted, gap = np.sort(wanted), 0.5
    found = apart(wanted, gap, -100.0, 100.0)
    gaps = {"type": "ineq", "fun": lambda y: np.diff(y) - gap}
    begin = wanted.mean() + gap * np.arange(len(wanted))
    best = minimize(lambda y: ((y - wanted) ** 2).sum(), begin, constraints=gaps, tol=1e-12)
    assert ((found - wanted) ** 2).sum() <= best.fun + 1e-6
