"""The names of rows, such as those of bars: how high their axes must be for names that are easy to read."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator

ROW_PITCH = 1.5  # the least distance of two names of rows, relative to the size of the font
POINTS_IN_INCH = 72.0
FEWEST_NAMES = 2  # the least number of names that have a distance


def lacking_for_rows(axes: Axes) -> float:
    """Return the height [inches] that axes lack for names along y to be ROW_PITCH apart.

    The result is 0 for fewer than FEWEST_NAMES names, and for the numbers of an axis.
    """
    names, figure = (
        [label for label in axes.get_yticklabels() if label.get_text()],
        axes.get_figure(root=True),
    )
    if (
        figure is None
        or len(names) < FEWEST_NAMES
        or not isinstance(axes.yaxis.get_major_locator(), FixedLocator)
    ):
        return 0.0
    heights = axes.transData.transform([(0.0, label.get_position()[1]) for label in names])[:, 1]
    distance = float(np.abs(np.diff(heights)).min()) / figure.dpi
    pitch = ROW_PITCH * float(names[0].get_fontsize()) / POINTS_IN_INCH
    return max(0.0, float(axes.bbox.height) / figure.dpi * (pitch / distance - 1.0))
