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
from matplotlib.text import Annotation, Text
from matplotlib.transforms import Bbox

CLOSE, STEP = 6.0, 8.0  # points from the place to its label, and along it between trials
PAD = 2.5  # points that stay free around a label
RIGHT = 8.0  # points from the edge of the axes to the labels of curves
LINE = 1.25  # of the font's size, between labels one above the other


@dataclass(frozen=True)
class Label:
    """A label at a place.

    Attributes:
        text: what it says.
        place: in data coordinates.
        away: unit vector of the direction in which it stands from its place.
    """

    text: str
    place: tuple[float, float]
    away: tuple[float, float] = (0.0, 1.0)

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


def place_labels(axes: Axes, labels: Sequence[Label], obstacles: Sequence[Bbox] = (), **look: Any) -> None:
    """Write the labels, the most important first, where they meet no other label and no obstacle.

    A label without room inside the axes is left out. ``look`` is how text is drawn; ``obstacles`` are in
    pixels.
    """
    inside, taken, pixel = axes.get_window_extent(), list(obstacles), 72.0 / axes.figure.dpi
    for label in labels:
        style: dict[str, Any] = {"ha": "center", "va": "center", "textcoords": "offset points", **look}
        text = axes.annotate(label.text, label.place, (0.0, 0.0), in_layout=False, **style)
        box = text.get_window_extent()
        for offset in label.offsets(box.width * pixel, box.height * pixel):
            text.xyann = offset
            box = text.get_window_extent().padded(PAD / pixel)
            within = inside.x0 <= box.x0 <= box.x1 <= inside.x1 and inside.y0 <= box.y0 <= box.y1 <= inside.y1
            if within and not box.count_overlaps(taken):
                taken.append(text.get_window_extent())
                break
        else:
            text.remove()


def marker_boxes(axes: Axes, places: Sequence[tuple[float, float]], size: float) -> list[Bbox]:
    """The boxes, in pixels, of round markers of a size in points."""
    half = 0.5 * size * axes.figure.dpi / 72.0
    return [Bbox([at - half, at + half]) for at in axes.transData.transform(np.reshape(places, (-1, 2)))]


def stem_boxes(axes: Axes, tops: Sequence[tuple[float, float]]) -> list[Bbox]:
    """The boxes, in pixels, of upright lines from zero to their tops."""
    places = np.reshape(tops, (-1, 2))
    feet = axes.transData.transform(places * [1.0, 0.0])
    return [Bbox(ends) for ends in zip(feet, axes.transData.transform(places), strict=True)]


def label_curves(
    axes: Axes, curves: Sequence[tuple[float, float, str, Any]], **look: Any
) -> list[Annotation]:
    """Write the names of curves in their colours to the right of the axes, each with a line to its curve.

    ``curves`` are the x and y of the place that is named, the name and the colour. `spread_labels` moves the
    names apart once the layout is settled.
    """
    texts = []
    for x, y, name, colour in curves:
        line = {"arrowstyle": "-", "color": colour, "linewidth": 0.7, "shrinkA": 1.0, "shrinkB": 0.0}
        style: dict[str, Any] = {"color": colour, "va": "center", "arrowprops": line, **look}
        texts.append(axes.annotate(name, (x, y), (1.03, 0.5), textcoords="axes fraction", **style))
    return texts


def spread_labels(axes: Axes, texts: Sequence[Annotation]) -> None:
    """Put the names of curves as near to the height of their curves as they do not overlap."""
    if not texts:
        return
    box = axes.get_window_extent()
    heights = [axes.transData.transform(text.xy)[1] for text in texts]
    # without the lines to the curves
    gap = max(Text.get_window_extent(text).height for text in texts) * LINE
    for text, height in zip(texts, apart(heights, gap, box.y0, box.y1), strict=True):
        text.set_y((height - box.y0) / box.height)


def apart(wanted: Sequence[float], gap: float, low: float, high: float) -> np.ndarray:
    """The heights nearest to those wanted that keep a gap between each other, and inside low … high.

    The order stays. The sum of squared shifts is least: z = y − i gap has to rise, so neighbours that would
    fall are pooled at their mean (Ayer et al. 1955, Annals of Mathematical Statistics, 26, 641–647).
    """
    order = np.argsort(wanted, kind="stable")
    pools: list[list[float]] = []
    for i, y in enumerate(np.asarray(wanted, dtype=float)[order]):
        pools.append([y - i * gap])
        while len(pools) > 1 and np.mean(pools[-2]) > np.mean(pools[-1]):
            pools[-2:] = [pools[-2] + pools[-1]]
    level = np.concatenate([np.full(len(pool), np.mean(pool)) for pool in pools] or [np.zeros(0)])
    top = max(low, high - gap * (len(order) - 1))
    heights = np.empty(len(order))
    heights[order] = np.clip(level, low, top) + gap * np.arange(len(order))
    return heights
