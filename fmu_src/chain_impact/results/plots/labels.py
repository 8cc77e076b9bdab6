"""Labels that do not overlap: one that would meet another, which is more important, is left out.

They are placed on a page whose layout is settled, by the boxes that the renderer measures.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, pairwise
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis, YAxis
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import Bbox

from chain_impact.results.plots.style import styled

CLOSE = 5.0  # points from the place to its label
PAD = 2.5  # points that stay free around a label
FEWER = (4, 3, 2, 1)  # steps between ticks, at most, where numbers would overlap
LONGER = 1.1  # of the height of axes, a label in one line
PASSES = 2  # after which the layout stays as it is
ROUND_OFF = 1e-9  # of an axis
NEARLY = 1.0  # pixels, by which texts may seem to be beyond the page, or on one another
LEAST_SIDE = 0.3  # inches, the height of axes with a label
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

    Where axes are small, their labels are broken before the unit, and they have fewer ticks.
    """
    page.draw_without_rendering()
    for axes in page.axes:
        label, room = axes.yaxis.label, axes.get_window_extent().height
        if label.get_window_extent().height > LONGER * room:
            label.set_text(label.get_text().replace(" [", "\n["))
        for axis in (axes.xaxis, axes.yaxis):
            spread_ticks(axis)
    for _ in range(PASSES):
        page.draw_without_rendering()
    page.set_layout_engine("none")


def spread_ticks(axis: Axis) -> None:
    """Take so few ticks that their numbers do not overlap."""
    for most in FEWER:
        boxes = tick_boxes(axis)
        overlap = any(one.overlaps(other) for one, other in pairwise(boxes))
        if not overlap or not isinstance(axis.get_major_locator(), MaxNLocator):
            return
        axis.set_major_locator(MaxNLocator(most, min_n_ticks=1))


def tick_boxes(axis: Axis) -> list[Bbox]:
    """What the texts at the ticks in view cover, in pixels."""
    low, high = sorted(axis.get_view_interval())
    slack, along = ROUND_OFF * (high - low), isinstance(axis, YAxis)
    texts = (text for text in axis.get_majorticklabels() if text.get_text())
    return [
        text.get_window_extent()
        for text in texts
        if low - slack <= text.get_position()[along] <= high + slack
    ]


@styled()
def has_room(page: Figure) -> bool:
    """Whether all texts around the axes of a settled page are on it, and none is on another."""
    page.draw_without_rendering()
    texts, boxes = list[Any](page.texts), list[Bbox]()
    for axes in page.axes:
        texts += [axes.xaxis.label, axes.yaxis.label]
        texts += legend.get_texts() if (legend := axes.get_legend()) else []
        boxes += [*tick_boxes(axes.xaxis), *tick_boxes(axes.yaxis)]
        if axes.get_ylabel() and axes.get_window_extent().height < LEAST_SIDE * page.dpi:
            return False
    boxes += [text.get_window_extent() for text in texts if text.get_text()]
    around = Bbox.union([page.bbox, *boxes])
    if around.width > page.bbox.width + NEARLY or around.height > page.bbox.height + NEARLY:
        return False
    return not any(one.padded(-NEARLY).overlaps(other) for one, other in combinations(boxes, 2))


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
