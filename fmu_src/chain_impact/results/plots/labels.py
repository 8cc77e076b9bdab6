"""Labels that do not overlap: each gets the first of several places that is free, or is left out.

They are placed on a page whose layout is settled, by the boxes that the renderer measures.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Annotation

CLOSE, STEP = 6.0, 8.0  # points from the place to its label, and along it between trials
PAD = 2.5  # points that stay free around a label


@dataclass(frozen=True)
class Label:
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

    def offsets(self, width: float, height: float) -> Iterator[tuple[float, float]]:
        """Where the middle of a text of this size can be, in points from its place, the best first."""
        ax, ay = self.away
        out = CLOSE + 0.5 * (abs(ax) * width + abs(ay) * height)
        for side in (0.0, STEP, -STEP):
            yield out * ax - side * ay, out * ay + side * ax


def settle(page: Figure) -> None:
    """Arrange the page once and keep it so: what is placed by pixels from here on stays where it is."""
    page.draw_without_rendering()
    page.set_layout_engine("none")


def place_labels(axes: Axes, labels: Sequence[Label], obstacles: np.ndarray, **look: Any) -> None:
    """Write the labels, the most important first, where they meet no other label and no obstacle.

    A label without room inside the axes is left out. ``obstacles`` are boxes as `marker_boxes` gives them,
    ``look`` is how text is drawn.
    """
    style: dict[str, Any] = {"ha": "center", "va": "center", "textcoords": "offset points", **look}
    taken = obstacles
    for label in labels:
        for words in filter(None, (label.text, label.short)):
            text = axes.annotate(words, label.place, (0.0, 0.0), in_layout=False, **style)
            if find_room(axes, text, label, taken):
                taken = np.vstack([taken, text.get_window_extent().extents])
                break
            text.remove()


def find_room(axes: Axes, text: Annotation, label: Label, taken: np.ndarray) -> bool:
    """Move a text to the first of its label's places that is free and inside the axes, if there is one."""
    inside, size, pixel = axes.get_window_extent().extents, text.get_window_extent(), 72.0 / axes.figure.dpi
    for offset in label.offsets(size.width * pixel, size.height * pixel):
        text.xyann = offset
        x0, y0, x1, y1 = text.get_window_extent().padded(PAD / pixel).extents
        within = inside[0] <= x0 and inside[1] <= y0 and x1 <= inside[2] and y1 <= inside[3]
        meets = (taken[:, 0] < x1) & (taken[:, 1] < y1) & (taken[:, 2] > x0) & (taken[:, 3] > y0)
        if within and not meets.any():
            return True
    return False


def marker_boxes(axes: Axes, places: Sequence[tuple[float, float]], size: float) -> np.ndarray:
    """The boxes of round markers of a size in points: x and y of two corners in pixels, shape (n, 4)."""
    half, middles = 0.5 * size * axes.figure.dpi / 72.0, axes.transData.transform(np.reshape(places, (-1, 2)))
    return np.hstack([middles - half, middles + half])


def stem_boxes(axes: Axes, tops: Sequence[tuple[float, float]]) -> np.ndarray:
    """The boxes of upright lines from zero to their tops, as those of markers."""
    places = np.reshape(tops, (-1, 2))
    return np.hstack([axes.transData.transform(ends) for ends in (places * [1.0, 0.0], places)])
