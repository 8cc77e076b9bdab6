"""Labels next to places in a picture, at positions where they cover no line, mark or other label."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from chain_impact.pictures.style import FLAT, INK, SHADE, faint

CLOSE = 4.0  # [points] distance from a place to its label
# factors on this distance that are tried
FARTHER = (1.0, 1.2, 1.3, 1.4, 1.75, 2.1, 2.5)
# factors on this distance that are tried if a line connects label and place
FAR = (3.5, 4.5, 5.5, 6.5, 7.5, 9.0, 10.5)
# directions that are tried: parts of a turn away from the best direction of a label, a turn being PARTS
PARTS = 16
TURNS = (0, *(sign * part for part in range(1, PARTS // 2) for sign in (1, -1)), PARTS // 2)
COVERED = 0.6  # the largest part of such a line that may cover other things
PAD = 1.0  # [points] free border around a label
LEADER: dict[str, Any] = {"arrowstyle": "-", "linewidth": 0.5, "color": INK, "shrinkA": 1.0, "shrinkB": 3.0}
ABOVE = 6.0  # the layer of such a line and its label: above links and points
LEAST_RUN = 3  # the least number of successive numbers that are written as a range


class Label(NamedTuple):
    """A label for a place.

    Attributes:
        text: the text of the label.
        place: the place, in data coordinates.
        away: unit vector of the best direction from the place to the label.
        short: a short text if the full text has no room; "" for none.
    """

    text: str
    place: tuple[float, float]
    away: tuple[float, float] = (0.0, 1.0)
    short: str = ""


class Ink:
    """The pixels of a page that are drawn on, except areas of one colour on which labels may stand."""

    def __init__(self, page: Figure) -> None:
        """Draw the page, which also arranges its contents, and store its pixels."""
        own = page.canvas
        canvas: Any = FigureCanvasAgg(page)  # matplotlib has no type information for the canvas
        canvas.draw()
        page.set_canvas(own)
        grounds = [*FLAT, page.get_facecolor(), *(axes.get_facecolor() for axes in page.axes)]
        grounds += [faint(axes, SHADE) for axes in page.axes]
        colours = np.asarray(canvas.buffer_rgba())[::-1, :, :3].astype(int) @ [1 << 16, 1 << 8, 1]
        self._drawn = ~np.isin(colours, [_packed(ground) for ground in grounds])
        self._labels = np.zeros_like(self._drawn)

    def take(self, low: np.ndarray, high: np.ndarray, place: np.ndarray | None = None) -> bool:
        """Mark a box, given by two corners in pixels, as used if it is free; return whether it was free.

        A straight line from ``place`` to the box must pass no other label and little else; it is marked, too.
        """
        (x0, y0), (x1, y1) = np.floor(low).astype(int), np.ceil(high).astype(int)
        box = self._drawn[y0:y1, x0:x1]
        if box.any():
            return False
        if place is not None:
            middle = 0.5 * (low + high)
            count = 2 + int(np.abs(middle - place).max())
            line = tuple(np.linspace(place, middle, count).astype(int).T[::-1])
            if self._labels[line].any() or self._drawn[line].sum() > COVERED * count:
                return False
            self._drawn[line] = True
        box[:] = self._labels[y0:y1, x0:x1] = True
        return True


def place_labels(
    axes: Axes, labels: Sequence[Label], ink: Ink, *, lines: bool = False, **look: Any
) -> list[Label]:
    """Write labels, the most important first, where nothing else is drawn; return labels without room.

    Args:
        axes: the axes inside which the labels stay.
        labels: the labels to write.
        ink: the used pixels of the page; afterwards they include the labels.
        lines: whether a label may be far from its place, connected by a line.
        look: properties of the text, with matplotlib's names.
    """
    return [label for label in labels if not _place(axes, label, ink, look, FARTHER + FAR * lines)]


def _place(axes: Axes, label: Label, ink: Ink, look: dict[str, Any], steps: Sequence[float]) -> bool:
    """Write a label, or its short form, at the first free position; return whether there is one."""
    page = axes.get_figure(root=True)
    assert page is not None
    point, inside = page.dpi / 72.0, axes.get_window_extent()
    at = np.asarray(axes.transData.transform(label.place))
    style: dict[str, Any] = {
        "textcoords": "offset points",
        "ha": "center",
        "va": "center",
        "in_layout": False,
    }
    for words in filter(None, (label.text, label.short)):
        text = axes.annotate(words, label.place, (0.0, 0.0), **style, **look)
        half = 0.5 * np.asarray(text.get_window_extent().size)
        for step, direction in product(steps, _directions(label.away)):
            way = direction * (step * CLOSE * point + half)
            low, high = at + way - half - PAD * point, at + way + half + PAD * point
            is_inside = bool((low >= inside.min).all() and (high <= inside.max).all())
            led: dict[str, Any] = {"arrowprops": LEADER, "zorder": ABOVE} if step in FAR else {}
            if is_inside and ink.take(low, high, at if led else None):
                text.remove()
                axes.annotate(words, label.place, (way / point).tolist(), **led, **style, **look)
                return True
        text.remove()
    return False


def _directions(away: tuple[float, float]) -> Iterator[np.ndarray]:
    """Yield unit vectors in all directions, those nearest to ``away`` first."""
    best = math.atan2(away[1], away[0])
    for turn in TURNS:
        angle = best + 2.0 * math.pi / PARTS * turn
        yield np.array([math.cos(angle), math.sin(angle)])


def _packed(colour: Any) -> int:
    """Return a colour as one number, in the form of a pixel."""
    red, green, blue = (round(255.0 * float(part)) for part in to_rgb(colour))
    return (red << 16) + (green << 8) + blue


def listed(numbers: Iterable[int]) -> str:
    """Return whole numbers as text, in order, with successive numbers as a range: "3, 7–9"."""
    runs: list[list[int]] = []
    for one in sorted(set(numbers)):
        if runs and one == runs[-1][-1] + 1:
            runs[-1].append(one)
        else:
            runs.append([one])
    parts: list[str] = []
    for run in runs:
        parts += [f"{run[0]}–{run[-1]}"] if len(run) >= LEAST_RUN else map(str, run)
    return ", ".join(parts)
