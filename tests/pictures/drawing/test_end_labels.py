"""Names at the right ends of lines stand apart, in the order of the lines."""

import itertools

import numpy as np
import pytest
from matplotlib.figure import Figure

from chain_impact.pictures.drawing.end_labels import spread, spread_out, write_end_labels


@pytest.mark.parametrize(
    ("places", "expected"),
    [
        ([0.0, 5.0, 9.0], [0.0, 5.0, 9.0]),
        ([4.9, 5.1], [4.5, 5.5]),
        ([0.0, 0.1, 5.0], [0.0, 1.0, 5.0]),
        ([8.0, 9.9, 10.0], [8.0, 9.0, 10.0]),
    ],
)
def test_places_are_moved_apart_as_little_as_possible(places, expected):
    np.testing.assert_allclose(spread_out(np.array(places), 1.0, 0.0, 10.0), expected)


def test_names_do_not_overlap_and_keep_the_order_of_their_lines():
    page = Figure((6.0, 3.0), dpi=100, layout="constrained")
    axes = page.subplots()
    ends = {"low": 0.0, "near": 0.49, "same": 0.5, "high": 1.0}
    for value in ends.values():
        axes.plot([0.0, 1.0], [0.5, value])
    labels = write_end_labels(axes, [(name, value, "black") for name, value in ends.items()])
    page.draw_without_rendering()
    spread(axes, labels)
    boxes = [label.text.get_window_extent() for label in labels]
    assert all(lower.y1 <= upper.y0 + 1.0 for lower, upper in itertools.pairwise(boxes))
    assert all(box.x0 > axes.bbox.x1 and box.x1 < page.bbox.x1 for box in boxes)
    assert write_end_labels(axes, [(str(k), 0.5, "black") for k in range(13)]) == []
