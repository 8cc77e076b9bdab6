"""Bars to the left and to the right of zero, one bar for each name."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import ScaledTranslation

from chain_impact.pictures.drawing.axis_numbers import LEAST_TICKS, TICK_STEPS
from chain_impact.pictures.drawing.colours import DECREASE, GREY, INCREASE, INK, PALE_GREY, PEAK_COLOUR
from chain_impact.pictures.drawing.figures import settle
from chain_impact.pictures.drawing.head_and_foot import (
    LEFT_MARGIN,
    start_at_headline,
    start_left,
    write_headline,
)
from chain_impact.pictures.drawing.legends import legend_at_head
from chain_impact.pictures.drawing.line_breaks import SEPARATOR
from chain_impact.pictures.drawing.style import drawing_style, is_narrow

BARS_WIDTH = 7.0  # [inch] the width of the figure
BARS_MARGIN = 1.4  # [inch] the sum of the spaces above and below all bars
BLOCK_SPACE = 0.6  # [inch] the space between two blocks of bars
BAR_HEIGHT = 0.25  # [inch] the height for one bar
BAR_MARGIN = 0.03  # the space beyond the ends of an axis (``shared_ends``), relative to their distance
# [points] the space between the axes and the heading of the texts, and between the axes and a title above it
HEADING_SPACE, TITLE_SPACE = 3.0, 16.0
DOT = 24.0  # [square points] the size of a dot
DIAMOND: dict[str, Any] = {"marker": "D", "markersize": 4.0, "color": INK, "linestyle": ""}
DIAMOND |= {"markeredgecolor": "white", "markeredgewidth": 0.5, "clip_on": False, "zorder": 4.0}
"""The properties of the diamonds, see ``Bars.marks``, with matplotlib's names."""
RUN_LABEL = "change in a run (bar: to first order)"
PALE_BARS = 0.5  # the opacity of the bars of all blocks but the first, with which they cannot be compared
BAR_THICKNESS = 0.66  # the thickness of a bar, relative to the distance between bars
# ``axis_ends`` cuts off bars only if the longest bar extends more than CUT_RATIO times as far from 0 as what
# must be visible
CUT_RATIO = 4.0
ROOM_BESIDE = 1.5  # see ``axis_ends``; a number > 1, so that arrows of cut bars are visible beside the marks
CUT_BARS = "a bar with an arrow is longer than the axis"
CUT_MARKS = "a hollow arrow: a change in a run beyond the axis"
# blocks share an axis up to MOST_SHARED times the reach of the first block; longer bars are cut off,
# and arrows replace diamonds beyond the axis
MOST_SHARED = 2.0
ARROW_HEAD = 6.0  # [points] the size of the arrow at the end of a bar that is cut off


@dataclass(frozen=True)
class Bars:
    """A block of horizontal bars, the first one at the top; blocks with one label have one scale.

    Attributes:
        names: the name of each bar, at its left.
        values: the length of each bar with its sign; a bar with a negative value goes to the left.
        texts: the text of each bar, in a column at the right of the block.
        label: the label of the axis.
        heading: a text above the column of ``texts``.
        title: a text above the block.
        colours: the colour of each bar; without colours, the colour of a bar shows the sign of its value.
        marks: for each bar None or a second value, at which a diamond stands, or a hollow arrow if the value
            is beyond the axis; a value that is not finite has neither.
        hollow: for each bar whether it is hollow, because its second value refutes the first one.
        dots: whether a dot stands in place of each bar, for an axis that is not linear; without ``marks``.
    """

    names: Sequence[str]
    values: Sequence[float]
    texts: Sequence[str]
    label: str
    heading: str = ""
    title: str = ""
    colours: Sequence[str] = ()
    marks: Sequence[float | None] = ()
    hollow: Sequence[bool] = ()
    dots: bool = False

    @property
    def is_hollow(self) -> Sequence[bool]:
        """For each bar whether it is hollow; False for all bars if ``hollow`` is empty."""
        return self.hollow or [False] * len(self.values)

    @property
    def ends(self) -> tuple[float, float]:
        """The ends of the axis without margins (``axis_ends``)."""
        return axis_ends(self.values, self.marks, self.hollow)

    def cut_notes(self, ends: tuple[float, float]) -> set[str]:
        """Return the notes, of CUT_BARS and CUT_MARKS, on bars and marks beyond the ``ends`` of an axis."""
        pairs = ((CUT_BARS, self.values), (CUT_MARKS, self.marks))
        return {note for note, values in pairs if any(is_beyond(value, ends) for value in values)}


def is_beyond(value: float | None, ends: tuple[float, float]) -> bool:
    """Return whether a value is beyond the ends of an axis; False for None and a value that is not finite."""
    return value is not None and math.isfinite(value) and not ends[0] <= value <= ends[1]


def shared_ends(blocks: Sequence[Bars]) -> list[tuple[float, float]]:
    """Return the ends of the axis of each block; blocks with the same label have the same ends.

    These are at most MOST_SHARED times as far from 0 as the farther end of the first of these blocks, so that
    a long bar of another block leaves room for the bars of the first one.
    """
    ends = {}
    for label in {block.label for block in blocks}:
        lows, highs = zip(*(block.ends for block in blocks if block.label == label), strict=True)
        most_reach = MOST_SHARED * max(-lows[0], highs[0])
        ends[label] = max(min(lows), -most_reach), min(max(highs), most_reach)
    return [ends[block.label] for block in blocks]


def axis_ends(
    values: Sequence[float], marks: Sequence[float | None] = (), hollow_bars: Sequence[bool] = ()
) -> tuple[float, float]:
    """Return the ends of the axis for bars: the least and the largest of 0, all ``values`` and all ``marks``.

    None and values that are not finite do not count. If most bars are hollow, and all marks and all bars
    without a mark are much nearer to 0 than the longest bar (CUT_RATIO), but not all 0, bars are cut off at
    ROOM_BESIDE times the largest distance of these marks and bars from 0.
    """
    finite_values = [value for value in (*values, *marks) if value is not None and math.isfinite(value)]
    low, high = min([0.0, *finite_values]), max([0.0, *finite_values])
    marked_values = [
        value if mark is None else mark for value, mark in zip(values, marks or values, strict=True)
    ]
    reach = max((abs(value) for value in marked_values if math.isfinite(value)), default=0.0)
    if 2 * sum(hollow_bars) > len(values) and 0.0 < CUT_RATIO * reach < max(-low, high):
        return max(low, -ROOM_BESIDE * reach), min(high, ROOM_BESIDE * reach)
    return low, high


def bars_size(counts: Sequence[int]) -> tuple[float, float]:
    """Return the default size of a figure [inches] for the number of bars in each block.

    There is room for at least two bars.
    """
    return BARS_WIDTH, BARS_MARGIN + BLOCK_SPACE * max(len(counts) - 1, 0) + BAR_HEIGHT * max(sum(counts), 2)


@drawing_style()
def draw_bar_figure(
    figure: Figure, *, title: str, conditions_text: str, blocks: Sequence[Bars], warning: str = ""
) -> None:
    """Draw blocks of bars, one below the other, on an empty figure.

    Args:
        figure: the figure to draw on.
        title: the title of the picture.
        conditions_text: the text below the title.
        blocks: the blocks, each with at least one bar; without a block the picture says "no effect".
        warning: a text in PEAK_COLOUR between title and conditions; "" for none. Notes on bars and marks that
            are cut off (``Bars.cut_notes``) are added to the warning or, without one, to the conditions.
    """
    ends = shared_ends(blocks)
    notes = sorted({note for block, axis in zip(blocks, ends, strict=True) for note in block.cut_notes(axis)})
    if warning:
        warning = "; ".join([warning, *notes])
    else:
        conditions_text = "; ".join(filter(None, (conditions_text, *notes)))
    write_headline(
        figure,
        title,
        conditions_text.replace("; ", SEPARATOR),
        *([(warning, PEAK_COLOUR)] if warning else []),
    )
    if any(mark is not None and math.isfinite(mark) for block in blocks for mark in block.marks):
        legend_at_head(figure, [Line2D([], [], label=RUN_LABEL, **DIAMOND)])
    if not blocks:
        axes = figure.subplots()
        axes.set(xticks=[], yticks=[])
        axes.spines[:].set_visible(False)
        axes.text(0.5, 0.5, "no effect", transform=axes.transAxes, ha="center", color=INK)
        return
    heights = [len(block.names) for block in blocks]
    grid = figure.subplots(len(blocks), 1, height_ratios=heights, squeeze=False).ravel()
    titles = [
        draw_bars(axes, block, axis, is_small=is_narrow(figure), is_pale=axes is not grid[0])
        for axes, block, axis in zip(grid, blocks, ends, strict=True)
    ]
    for axes, block, lower_block in zip(grid, blocks, blocks[1:], strict=False):
        if block.label == lower_block.label:
            axes.set_xlabel("")
    start_at_headline(figure)
    settle(figure)
    _raise_titles(grid, titles)
    settle(figure)
    for axes, lower_axes in pairwise(grid):
        _draw_rule(figure, axes, lower_axes)


def _draw_rule(figure: Figure, upper_axes: Axes, lower_axes: Axes) -> None:
    """Draw a thin line between two blocks of bars, which cannot be compared."""
    upper_box, lower_box = upper_axes.get_tightbbox(), lower_axes.get_tightbbox()
    assert upper_box is not None
    assert lower_box is not None
    height = 0.5 * (upper_box.y0 + lower_box.y1) / figure.bbox.height
    margin = LEFT_MARGIN / figure.get_figwidth()
    figure.add_artist(Line2D([margin, 1.0 - margin], [height, height], color=GREY, linewidth=0.6))


def draw_row_lines(axes: Axes, rows: Sequence[int] | np.ndarray) -> None:
    """Draw a pale line over the whole width of axes at each of ``rows``."""
    axes.hlines(rows, 0.0, 1.0, PALE_GREY, linewidth=0.6, zorder=0, transform=axes.get_yaxis_transform())


def draw_bars(
    axes: Axes, block: Bars, ends: tuple[float, float], *, is_small: bool, is_pale: bool = False
) -> Text:
    """Draw a block of bars into axes, with the texts in a column at the right; return its title.

    ``ends``: the least and the largest value of the axis. ``is_small``: whether the figure is narrow, so that
    the names must be small, and the ticks few. ``is_pale``: whether the bars are pale; dots never are.
    """
    rows = range(len(block.names))
    colours = block.colours or [INCREASE if value > 0.0 else DECREASE for value in block.values]
    if block.dots:
        draw_row_lines(axes, rows)
        axes.scatter(block.values, rows, s=DOT, color=colours, zorder=3.0, clip_on=False)
    else:
        fills: list[Any] = [
            "none" if is_hollow else colour
            for is_hollow, colour in zip(block.is_hollow, colours, strict=True)
        ]
        opacity = PALE_BARS if is_pale else 1.0
        fills = [fill if fill == "none" else to_rgba(fill, opacity) for fill in fills]
        axes.barh(rows, block.values, BAR_THICKNESS, color=fills, edgecolor=colours)
        for row, (value, colour) in enumerate(zip(block.values, colours, strict=True)):
            if is_beyond(value, ends):
                _draw_arrow(axes, row, colour, to_right=value > 0.0)
        for row, mark in enumerate(block.marks):
            if mark is not None and is_beyond(mark, ends):
                _draw_arrow(axes, row, INK, to_right=mark > 0.0, is_hollow=True)
            elif mark is not None:
                axes.plot([mark], [row], **DIAMOND)
    offset_style: dict[str, Any] = {"textcoords": "offset points", "fontsize": "small"}
    for row, text in zip(rows, block.texts, strict=True):
        text_position: dict[str, Any] = {
            "xy": (1.0, row),
            "xycoords": axes.get_yaxis_transform(),
            "va": "center",
        }
        axes.annotate(text.replace("-", "−"), xytext=(4.0, 0.0), **text_position, **offset_style)
    title = axes.set_title(block.title, fontsize="small", color=INK, loc="left", wrap=True)
    if block.heading:
        axes.annotate(block.heading, (1.0, 1.0), (4.0, HEADING_SPACE), "axes fraction", **offset_style)
    start_left(axes, title)
    axes.set_yticks(rows, block.names, fontsize="small" if is_small else None)
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.axvline(0.0, color=INK, linewidth=0.6)
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_visible(False)
    axes.set_xlabel(block.label)
    axes.xaxis.set_major_locator(MaxNLocator(4 if is_small else 6, min_n_ticks=LEAST_TICKS, steps=TICK_STEPS))
    low, high = ends
    margin = BAR_MARGIN * (high - low)
    axes.set_xlim(low - margin * (low < 0.0), high + margin * (high > 0.0))
    if not block.dots:
        _draw_row_lines(axes, block.values)
    return title


def _draw_row_lines(axes: Axes, values: Sequence[float]) -> None:
    """Draw a thin line in each row, but not behind its bar, through which the line could be seen.

    ``values``: the length of each bar; the axes must have their ends.
    """
    left, right = axes.get_xlim()
    for row, value in enumerate(values):
        bar = sorted((0.0, value if math.isfinite(value) else 0.0))
        axes.hlines([row, row], [left, bar[1]], [bar[0], right], PALE_GREY, linewidth=0.6, zorder=0)


def _raise_titles(grid: Iterable[Axes], titles: Iterable[Text]) -> None:
    """Put the title of a block above the heading of its column if the title extends to this heading."""
    for axes, title in zip(grid, titles, strict=True):
        if title.get_window_extent().x1 > axes.bbox.x1:
            axes.set_title(title.get_text(), loc="left", fontsize="small", pad=TITLE_SPACE)
            start_left(axes, title)


def _draw_arrow(axes: Axes, row: int, colour: str, *, to_right: bool, is_hollow: bool = False) -> None:
    """Draw an arrow inside the right or the left edge of axes, in the row of a value beyond this edge."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    side = 1.0 if to_right else -1.0
    inward = ScaledTranslation(-0.5 * side * ARROW_HEAD / 72.0, 0.0, figure.dpi_scale_trans)
    look: dict[str, Any] = {"color": colour, "markersize": ARROW_HEAD, "markeredgewidth": 0.0}
    look |= {"markerfacecolor": "none", "markeredgewidth": 1.0, "zorder": 4.0} if is_hollow else {}
    transform = axes.get_yaxis_transform() + inward
    axes.plot([float(to_right)], [row], ">" if to_right else "<", transform=transform, **look)
