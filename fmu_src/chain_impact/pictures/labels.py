"""Labels beside their places: searched for where they meet no line, mark or other label."""

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

CLOSE = 4.0  # points from the place to its label
FARTHER = (1.0, 1.75, 2.5)  # times as far a label may stand
FAR = (4.0, 5.5, 7.5)  # likewise, if a line leads to it
TURNS = (0, 1, -1, 2, -2, 3, -3, 4)  # eighths of a turn away from where a label stands best
PAD = 1.0  # points that stay free around a label
LEADER: dict[str, Any] = {"arrowstyle": "-", "linewidth": 0.5, "color": INK, "shrinkA": 1.0, "shrinkB": 3.0}
LEAST_RUN = 3  # numbers in a row that are told by the first and the last


class Label(NamedTuple):
    """A label at a place.

    Attributes:
        text: what it says.
        place: in data coordinates.
        away: unit vector of the direction from its place to the label that is best.
        short: what it says where the text has no room, if anything.
    """

    text: str
    place: tuple[float, float]
    away: tuple[float, float] = (0.0, 1.0)
    short: str = ""


class Ink:
    """Which pixels of a page are drawn on, but for the areas of one colour that are a ground for labels."""

    def __init__(self, page: Figure) -> None:
        """Draw the page, which arranges it, and look at it."""
        own = page.canvas
        canvas: Any = FigureCanvasAgg(page)  # matplotlib says nothing of its types
        canvas.draw()
        page.set_canvas(own)
        grounds = [*FLAT, page.get_facecolor(), *(axes.get_facecolor() for axes in page.axes)]
        grounds += [faint(axes, SHADE) for axes in page.axes]
        colours = np.asarray(canvas.buffer_rgba())[::-1, :, :3].astype(int) @ [1 << 16, 1 << 8, 1]
        self._drawn = ~np.isin(colours, [_packed(ground) for ground in grounds])

    def take(self, low: np.ndarray, high: np.ndarray) -> bool:
        """Take a box, from a corner to the other in pixels, if nothing is drawn there; return whether."""
        (x0, y0), (x1, y1) = np.floor(low).astype(int), np.ceil(high).astype(int)
        box = self._drawn[y0:y1, x0:x1]
        if box.any():
            return False
        box[:] = True
        return True


def place_labels(
    axes: Axes, labels: Sequence[Label], ink: Ink, *, lines: bool = False, **look: Any
) -> list[Label]:
    """Write the labels, the most important first, where nothing else is drawn; return those without room.

    Args:
        axes: the labels keep inside.
        labels: what to write.
        ink: of the page; it has the labels afterwards.
        lines: whether a label may be far from its place, with a line between.
        look: how text is drawn.
    """
    return [label for label in labels if not _place(axes, label, ink, look, FARTHER + FAR * lines)]


def _place(axes: Axes, label: Label, ink: Ink, look: dict[str, Any], steps: Sequence[float]) -> bool:
    """Write a label, or its short form, at the first place that is free; return whether there is one."""
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
            if is_inside and ink.take(low, high):
                text.remove()
                led: Any = LEADER if step in FAR else None
                axes.annotate(words, label.place, (way / point).tolist(), arrowprops=led, **style, **look)
                return True
        text.remove()
    return False


def _directions(away: tuple[float, float]) -> Iterator[np.ndarray]:
    """Yield unit vectors all around, those that are nearest to one first."""
    best = math.atan2(away[1], away[0])
    for turn in TURNS:
        angle = best + 0.25 * math.pi * turn
        yield np.array([math.cos(angle), math.sin(angle)])


def _packed(colour: Any) -> int:
    """Return a colour as one number, as a pixel has it."""
    red, green, blue = (round(255.0 * float(part)) for part in to_rgb(colour))
    return (red << 16) + (green << 8) + blue


def listed(numbers: Iterable[int]) -> str:
    """Tell whole numbers in order, those in a row by the first and the last: "3, 7–9"."""
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
