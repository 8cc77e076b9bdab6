"""Labels that do not overlap: one that would meet another, which is more important, is left out.

They are placed on a page whose layout is settled, by the boxes that the renderer measures.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

CLOSE = 5.0  # points from the place to its label
PAD = 2.5  # points that stay free around a label
LONGER = 1.1  # of the height of axes, a label in one line
SLANTED = 0.4  # of a direction along an axis, from which a label stands on that side of its place


class Label(NamedTuple):
    """A label at a place.

    Attributes:
        text: what it says.
        place: in data coordinates.
        away: unit vector of the direction from its place to the label.
        short: what it says where the text has no room, if anything.
    """

    text: str
    place: tuple[float, float]
    away: tuple[float, float] = (0.0, 1.0)
    short: str = ""


def settle(page: Figure) -> None:
    """Arrange the page once and keep it so: what is placed by pixels from here on stays where it is.

    Where axes are low, their labels are broken before the unit.
    """
    page.draw_without_rendering()
    for axes in page.axes:
        label = axes.yaxis.label
        if label.get_window_extent().height > LONGER * axes.get_window_extent().height:
            label.set_text(label.get_text().replace(" [", "\n["))
    page.draw_without_rendering()
    page.set_layout_engine("none")


def place_labels(axes: Axes, labels: Sequence[Label], **look: Any) -> None:
    """Write the labels, the most important first, where they meet no other label and have room in the axes.

    ``look`` is how text is drawn.
    """
    inside, taken = axes.get_window_extent(), list[Bbox]()
    for label in labels:
        ax, ay = label.away
        style: dict[str, Any] = {"textcoords": "offset points", "in_layout": False}
        style["ha"] = "center" if abs(ax) < SLANTED else "left" if ax > 0.0 else "right"
        style["va"] = "center" if abs(ay) < SLANTED else "bottom" if ay > 0.0 else "top"
        for words in filter(None, (label.text, label.short)):
            text = axes.annotate(words, label.place, (CLOSE * ax, CLOSE * ay), **style, **look)
            box = text.get_window_extent().padded(PAD * axes.figure.dpi / 72.0)
            whole = np.array_equal(Bbox.union([box, inside]).get_points(), inside.get_points())
            if whole and not box.count_overlaps(taken):
                taken.append(box)
                break
            text.remove()
