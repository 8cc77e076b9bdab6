"""The geometry of a film's page."""

import numpy as np
import pytest

from chain_impact.results.animation.film_page import clipped

SQUARE = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])


def area(polygon):
    x, y = polygon.T
    return 0.5 * abs(x @ np.roll(y, 1) - y @ np.roll(x, 1))


@pytest.mark.parametrize(
    ("normal", "offset", "left"),
    [((0.0, 1.0), 0.5, 3.0), ((1.0, 0.0), -1.0, 4.0), ((1.0, 0.0), 3.0, 0.0), ((0.6, 0.8), 1.4, 2.0)],
)
def test_what_is_left_of_a_square(normal, offset, left):
    """A line through the middle of a square halves it."""
    polygon = clipped(SQUARE, np.array(normal), offset)
    assert (area(polygon) if len(polygon) else 0.0) == pytest.approx(left)
