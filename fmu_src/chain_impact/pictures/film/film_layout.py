"""The layout of a film: the axes with the chain, the texts, and the room for charts."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

SIZE_WITH_CHARTS = (7.0, 3.9375)  # [inch] the least width and height of a figure with charts
# the axes with the chain: left, bottom, width and height, relative to the size of the figure
SCENE = (0.02, 0.09, 0.6, 0.79)
LEAST_WIDTH = 0.45  # the least width of the axes with the chain beside charts, relative to that of the figure
# positions of the texts: left edge and middle of the height, relative to the size of the figure
CLOCK = (0.69, 0.95)
RATE = (0.69, 0.895)
CAPTION = (0.69, 0.832)
# SCENE, CLOCK and RATE on a figure that has no room for charts.
SMALL_LAYOUT = (0.02, 0.09, 0.96, 0.69), (0.02, 0.84), (0.55, 0.84)


class FilmLayout(NamedTuple):
    """The positions of the parts of a film, relative to the size of its figure.

    Attributes:
        scene: the axes with the chain: left, bottom, width and height.
        clock, rate, caption: left edge and middle of the height of each text.
        wider: how much farther than usual the charts reach to the left.
    """

    scene: tuple[float, float, float, float]
    clock: tuple[float, float]
    rate: tuple[float, float]
    caption: tuple[float, float]
    wider: float


def layout_for(figure: Figure, view: np.ndarray, *, is_wide: bool, has_charts: bool) -> FilmLayout:
    """Return the layout of a figure for a ``view`` (``film_view``); ``is_wide``: whether charts have room.

    If the figure ``has_charts``, the axes with the chain are only as wide as the view is at their height, but
    at least LEAST_WIDTH, and the charts take the rest.
    """
    if not is_wide:
        return FilmLayout(*SMALL_LAYOUT, CAPTION, 0.0)
    inches, (width, height) = figure.get_size_inches(), np.ptp(view, axis=0)
    needed_width = SCENE[3] * inches[1] * width / height / inches[0] if has_charts else SCENE[2]
    free_width = SCENE[2] - float(np.clip(needed_width, LEAST_WIDTH, SCENE[2]))
    clock, rate, caption = ((position[0] - free_width, position[1]) for position in (CLOCK, RATE, CAPTION))
    return FilmLayout((*SCENE[:2], SCENE[2] - free_width, SCENE[3]), clock, rate, caption, free_width)
