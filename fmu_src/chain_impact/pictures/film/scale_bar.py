"""A bar of a round length, below the moving chain of a film, which shows the scale of lengths."""

from __future__ import annotations

import math
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.transforms import blended_transform_factory

# [points] the size of the smallest texts of a film: 11 pixels in a film of 640 × 360
NUMBER_SIZE = 8.7
LONGEST_BAR = 1 / 6  # the largest length of the bar, relative to the width of the view
FACTORS = (5, 2, 1)  # a round length is one of these numbers times a power of ten
LENGTH_EXCESS = 1e-12  # a round length may exceed the largest allowed length by this part, as round-off
SMALL_LENGTH = 0.01  # [m] the number at a shorter bar is in millimetres


def round_length(most_length: float) -> float:
    """Return the largest round length that is at most ``most_length`` [m]."""
    power = 10.0 ** math.floor(math.log10(most_length))
    # the logarithm of a number just below a power of ten may be rounded up, so that ``power`` exceeds
    # ``most_length`` by round-off; LENGTH_EXCESS allows this
    return next(factor * power for factor in FACTORS if factor * power <= most_length * (1.0 + LENGTH_EXCESS))


def ruler_parts(axes: Axes, colour: str) -> tuple[Figure, Any, dict[str, Any]]:
    """Return what a ruler below axes needs: the figure, a transform for lines, and the look of texts.

    The transform takes x in the data coordinates of the axes, and y above the foot of the figure, relative to
    the height of the figure.
    """
    figure = axes.get_figure(root=True)
    assert figure is not None
    transform: Any = blended_transform_factory(axes.transData, figure.transFigure)
    look: dict[str, Any] = {"xycoords": transform, "textcoords": "offset points", "fontsize": NUMBER_SIZE}
    return figure, transform, look | {"color": colour, "va": "center", "annotation_clip": False}


def draw_scale_bar(axes: Axes, height: float, colour: str) -> list[Artist]:
    """Draw a bar of a round length, with this length as text, below axes; return the artists.

    The bar ends at the right edge of the axes. ``height`` is the height of the bar above the foot of the
    figure, relative to the height of the figure.
    """
    figure, transform, text_look = ruler_parts(axes, colour)
    left, right = axes.get_xlim()
    length = round_length(LONGEST_BAR * (right - left))
    text = f"{1000.0 * length:.3g} mm" if length < SMALL_LENGTH else f"{length:.3g} m"
    look: dict[str, Any] = {"color": colour, "linewidth": 0.8, "marker": "|", "markersize": 6.0}
    bar = Line2D([right - length, right], [height, height], transform=transform, **look)
    label = axes.annotate(text, (right - length, height), (-5.0, 0.0), ha="right", **text_look)
    return [figure.add_artist(bar), label]
