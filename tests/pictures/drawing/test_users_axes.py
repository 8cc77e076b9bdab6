"""Axes of a user's figure: what is drawn into them stays within the figure, and leaves neighbours alone."""

from itertools import combinations

import numpy as np
import pytest
from matplotlib.figure import Figure

from tests.pictures.pictures import recorded

FORCES = "contact[*].x_*.force"


@pytest.mark.full("more cases", but=3)
@pytest.mark.parametrize(
    ("shape", "size", "options"),
    [
        ((1, 1), (6.4, 4.8), {"panels": "friction"}),
        ((1, 1), (4.0, 3.0), {"curves": FORCES}),
        ((2, 1), (6.4, 4.8), {"curves": ["energy.*", FORCES]}),
        ((1, 3), (9.0, 3.0), {"panels": ["motion", "energy", "impacts"]}),
    ],
)
def test_a_picture_in_given_axes_is_whole_and_covers_no_neighbour(shape, size, options):
    page = Figure(size)
    axes = page.subplots(*shape)
    recorded("sliding_rod" if "friction" in options.values() else "four_link_box").plot(**options, ax=axes)
    page.draw_without_rendering()
    boxes = [panel.get_tightbbox() for panel in np.ravel(axes)]
    for box in boxes:
        assert box.x0 >= 0.0
        assert box.y0 >= 0.0
        assert box.x1 <= page.bbox.x1
        assert box.y1 <= page.bbox.y1
    assert not any(first.overlaps(second) for first, second in combinations(boxes, 2))


def test_axes_with_room_stay_where_they_are():
    page = Figure((8.0, 6.0))
    axes = page.add_axes((0.3, 0.3, 0.5, 0.4))
    recorded("rod_drop").plot(kind="energy", ax=axes)
    assert np.ravel(axes.get_position()) == pytest.approx([0.3, 0.3, 0.8, 0.7])
