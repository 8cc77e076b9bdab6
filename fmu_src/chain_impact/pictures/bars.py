"""Bars to the left and to the right of zero, one bar for each name."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from chain_impact.pictures.figures import settle
from chain_impact.pictures.style import BLUE, INK, LEAST_TICKS, VERMILLION, headline, is_narrow, styled

# [inch] the width of the figure, the space above and below the bars, and the height for one bar
WIDTH, AROUND, BAR = 7.0, 1.4, 0.25
NUMBER = 0.55  # [inch] the space for a number beside a bar
LEAST_BARS = 0.25  # the least width of all bars, relative to the axes
THICK = 0.66  # the thickness of a bar, relative to the distance between bars


def bars_size(count: int) -> tuple[float, float]:
    """Return the default size of a figure [inches] for a number of bars."""
    return WIDTH, AROUND + BAR * max(count, 2)


@styled()
def fill_bars(
    figure: Figure,
    *,
    title: str,
    conditions: str,
    names: Sequence[str],
    values: Sequence[float],
    end_texts: Sequence[str],
    label: str,
) -> None:
    """Draw one bar for each name, the first name at the top, on an empty figure.

    Args:
        figure: the figure to draw on.
        title: the title of the picture.
        conditions: the text below the title.
        names: the names of the bars.
        values: the lengths of the bars; negative bars go to the left.
        end_texts: the text at the end of each bar.
        label: the label of the axis.
    """
    headline(figure, title, conditions)
    axes = figure.subplots()
    rows = range(len(names))
    colours = [BLUE if value > 0.0 else VERMILLION for value in values]
    axes.barh(rows, values, THICK, color=colours)
    for row, value, text in zip(rows, values, end_texts, strict=True):
        side = 1.0 if value > 0.0 else -1.0
        axes.annotate(
            text.replace("-", "−"),
            (value, row),
            (4.0 * side, 0.0),
            textcoords="offset points",
            ha="left" if side > 0.0 else "right",
            va="center",
            fontsize="small",
        )
    axes.set_yticks(rows, names, fontsize="small" if is_narrow(figure) else None)
    axes.set_ylim(len(names) - 0.4, -0.6)
    axes.axvline(0.0, color=INK, linewidth=0.6)
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_visible(False)
    axes.set_xlabel(label)
    axes.xaxis.set_major_locator(MaxNLocator(4 if is_narrow(figure) else 6, min_n_ticks=LEAST_TICKS))
    low, high = min([0.0, *values]), max([0.0, *values])
    sides = np.array([low < 0.0, high > 0.0])
    settle(figure)
    # the numbers at both sides and the bars fill the width of the axes
    width = axes.get_window_extent().width / figure.dpi
    bars = max(width - NUMBER * sides.sum(), LEAST_BARS * width)
    room = (high - low or 1.0) * NUMBER / bars
    axes.set_xlim(low - room * sides[0], high + room * sides[1])
    if not names:
        axes.text(0.5, 0.5, "no effect", transform=axes.transAxes, ha="center", color=INK)
