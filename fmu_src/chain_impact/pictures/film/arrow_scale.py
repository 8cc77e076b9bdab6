"""The lengths of the arrows of forces in a film, and the ruler that explains these lengths.

The weight of a link and the peak of an impact can differ by a factor of a thousand, and both must be visible:
the length is proportional to the cube root of the force, with a least length.
The twin in JavaScript is pages/browser/drawing/arrow_scale.js.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import FancyArrowPatch
from matplotlib.text import Text
from matplotlib.ticker import EngFormatter
from matplotlib.transforms import Bbox

from chain_impact.pictures.drawing.axis_numbers import force_text
from chain_impact.pictures.drawing.colours import LOAD
from chain_impact.pictures.film.scale_bar import NUMBER_SIZE, ruler_parts
from chain_impact.recording.view import DECADES, LONGEST_ARROW

FORCE = "#d9480f"  # the colour of wall forces in a film
TITLE_MIDDLE = 0.94  # the middle of the height of a film's title, relative to the height of the figure
SHORTEST_ARROW = 0.02  # the length of the shortest arrow, relative to the smaller side of the view
# FIRST_MARK: the least distance of a mark from the left end of the ruler; MARK_GAP: the least distance of two
# marks; both relative to the length of the ruler
FIRST_MARK, MARK_GAP = 0.1, 0.3
NUMBER_SPACE = 0.5  # the least space between two numbers of the ruler, relative to their height
SCALE_NAME = "arrow length ∝ ∛force"
WHOLE_HEAD = 14.0  # [points] an arrow that is shorter has a smaller head and a thinner line
RULER_TICK = 3.0  # [points] half of the length of a mark on the ruler


def arrow_between(axes: Axes, foot: np.ndarray, head: np.ndarray, colour: str) -> FancyArrowPatch:
    """Return the arrow of a force from ``foot`` to ``head`` [m]; a short arrow is thin, with a small head."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    length = float(np.hypot(*np.ptp(axes.transData.transform([foot, head]), axis=0))) * 72.0 / figure.dpi
    size = min(1.0, length / WHOLE_HEAD)
    style: dict[str, Any] = {"arrowstyle": "-|>", "mutation_scale": 11.0 * size, "shrinkA": 0, "shrinkB": 0}
    (x, y), (head_x, head_y) = foot.tolist(), head.tolist()
    return FancyArrowPatch((x, y), (head_x, head_y), color=colour, linewidth=2.2 * size, **style)


def draw_key(figure: Figure, title: Text, right: float) -> None:
    """Draw the legend of the arrows beside the title of a film, in one column if the title is long.

    ``right`` is the right end of the legend, relative to the width of the figure.
    """
    arrow: dict[str, Any] = {"marker": ">", "linewidth": 2.2, "markersize": 5}
    kinds = {"wall forces": FORCE, "joint forces": LOAD}
    handles = [Line2D([], [], color=colour, label=name, **arrow) for name, colour in kinds.items()]
    look: dict[str, Any] = {"loc": "center right", "bbox_to_anchor": (right, TITLE_MIDDLE)}
    look |= {"borderaxespad": 0.0, "fontsize": NUMBER_SIZE, "handlelength": 1.4, "labelspacing": 0.2}
    key = figure.legend(handles=handles, ncols=2, columnspacing=1.0, **look)
    box = title.get_window_extent()
    if key.get_window_extent().x0 < box.x1 + box.height:
        key.remove()
        figure.legend(handles=handles, **look)


class ArrowScale:
    """The function from forces [N] to lengths [m] of arrows, by the cube root of the force (``length``)."""

    def __init__(self, peak: float, side: float) -> None:
        """Store the largest force [N], and the smaller side of the view [m]."""
        self.peak, self.side = peak, side

    def length(self, force: float) -> float:
        """Return the length [m] of the arrow of a force [N], at least SHORTEST_ARROW × side of the view."""
        # the length is LONGEST_ARROW · side · ∛(F / F_max) for the force F
        return self.side * max(SHORTEST_ARROW, LONGEST_ARROW * math.cbrt(force / self.peak))

    def is_shown(self, force: float) -> bool:
        """Return whether the arrow of a force [N] is longer than the least length (SHORTEST_ARROW)."""
        return self.length(force) > SHORTEST_ARROW * self.side

    def marks(self) -> list[tuple[float, str]]:
        """Return the distance from the ruler's left end [m], and the text, of each mark from right to left.

        The first mark is the largest force, at the right end. The other marks are powers of ten [N]: the
        DECADES largest powers up to the largest force, in falling order. A power of ten is left out if its
        mark would be nearer to the left end than FIRST_MARK × the length of the ruler, or nearer to the mark
        at its right than MARK_GAP × this length.
        """
        highest, whole_length = math.floor(math.log10(self.peak)), LONGEST_ARROW * self.side
        marks, free_length = [(whole_length, force_text(self.peak, "N"))], whole_length
        for force in 10.0 ** (highest - np.arange(DECADES)):
            mark_length = self.length(float(force))
            if mark_length < FIRST_MARK * whole_length:
                break
            if mark_length <= free_length - MARK_GAP * whole_length:
                marks.append((mark_length, EngFormatter("N", places=0)(float(force))))
                free_length = mark_length
        return marks

    def draw(self, axes: Axes, y: float, colour: str) -> None:
        """Draw the ruler with its marks, from 0 on, and its name, from the left edge of axes on.

        A mark whose number would touch that of the largest force, of 0, or of a larger force is left out.
        ``y`` is the height of the ruler above the figure's lower edge, relative to the figure's height.
        """
        _, transform, text_look = ruler_parts(axes, colour)
        left, _ = axes.get_xlim()
        marks: dict[str, Any] = {"color": colour, "linewidth": 0.8, "markersize": 2.0 * RULER_TICK}
        marks |= {"transform": transform, "clip_on": False}
        end = left + LONGEST_ARROW * self.side
        axes.plot([left, end], [y, y], **marks)
        axes.annotate(SCALE_NAME, (end, y), (4.0, 0.0), ha="left", **text_look)
        (largest_mark, *other_marks), taken_boxes = self.marks(), list[Bbox]()
        for mark_offset, text in [largest_mark, (0.0, "0"), *other_marks]:
            text_below: dict[str, Any] = text_look | {"ha": "center", "va": "top"}
            label = axes.annotate(text, (left + mark_offset, y), (0.0, -RULER_TICK - 1.0), **text_below)
            box = label.get_window_extent()
            # in a small film, this number may touch another one
            if any(box.padded(NUMBER_SPACE * box.height).overlaps(other_box) for other_box in taken_boxes):
                label.remove()
                continue
            axes.plot([left + mark_offset], [y], "|", **marks)
            taken_boxes.append(box)
