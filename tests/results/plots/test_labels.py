"""Labels stand beside their places, and none meets another."""

import itertools

import pytest
from matplotlib.figure import Figure

from chain_impact.results.plots.pages import Label, place_labels, settle


@pytest.fixture
def axes():
    axes = Figure(figsize=(4.0, 3.0), layout="constrained").add_subplot()
    settle(axes.figure)
    return axes


def test_the_first_keeps_its_place_and_those_that_would_meet_it_are_left_out(axes):
    place_labels(axes, [Label(str(k), (0.5 + 0.01 * k, 0.5)) for k in range(9)], fontsize=7)
    shown = [text.get_text() for text in axes.texts]
    assert shown[0] == "0"
    assert 1 < len(shown) < 9
    for one, other in itertools.combinations([text.get_window_extent() for text in axes.texts], 2):
        assert not one.overlaps(other)


def test_a_label_keeps_inside(axes):
    place_labels(axes, [Label("wide label", (1.0, 0.5)), Label("high label", (0.5, 1.0))])
    assert len(axes.texts) == 0


def test_a_label_stands_on_the_side_it_is_meant_for(axes):
    place_labels(axes, [Label("left", (0.5, 0.2), (-1.0, 0.0)), Label("below", (0.5, 0.8), (0.0, -1.0))])
    left, below = (text.get_window_extent() for text in axes.texts)
    assert left.x1 < axes.transData.transform((0.5, 0.2))[0]
    assert below.y1 < axes.transData.transform((0.5, 0.8))[1]
