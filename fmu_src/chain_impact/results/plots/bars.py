"""Bars to both sides of zero, one for each name."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from chain_impact.results.plots.style import BLUE, GREY, INK, VERMILLION, WIDE, headline, styled

WIDTH, AROUND, BAR = 7.0, 1.4, 0.25  # inches: the page, what is above and below the bars, and a bar
NUMBER, PART = 0.6, 0.45  # inches, a number beside a bar; of the page's width, about, the axes
THICK = 0.66  # of the distance of bars


def bars_size(count: int) -> tuple[float, float]:
    """Return the usual size of a page with so many bars [inches]."""
    return WIDTH, AROUND + BAR * max(count, 2)


@styled()
def fill_bars(
    page: Figure,
    *,
    title: str,
    conditions: str,
    names: Sequence[str],
    values: Sequence[float],
    told: Sequence[str],
    label: str,
) -> None:
    """Draw one bar for each name, the first on top, on an empty page.

    Args:
        page: to draw on.
        title: over the picture.
        conditions: below the title.
        names: of the bars.
        values: their lengths, to the left below 0.
        told: what stands at the end of each bar.
        label: of the axis.
    """
    headline(page, title, conditions)
    axes = page.subplots()
    rows = range(len(names))
    colours = [BLUE if value > 0.0 else VERMILLION for value in values]
    axes.barh(rows, values, THICK, color=colours)
    for row, value, text in zip(rows, values, told, strict=True):
        side = 1.0 if value > 0.0 else -1.0
        axes.annotate(
            text,
            (value, row),
            (4.0 * side, 0.0),
            textcoords="offset points",
            ha="left" if side > 0.0 else "right",
            va="center",
            fontsize="small",
        )
    axes.set_yticks(rows, names)
    axes.set_ylim(len(names) - 0.4, -0.6)
    axes.axvline(0.0, color=INK, linewidth=0.6)
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_visible(False)
    axes.set_xlabel(label)
    low, high = min([0.0, *values]), max([0.0, *values])
    room = (high - low or 1.0) * NUMBER / (PART * page.get_figwidth())
    axes.set_xlim(low - (room if low < 0.0 else 0.0), high + (room if high > 0.0 else 0.0))
    axes.xaxis.set_major_locator(MaxNLocator(6 if page.get_figwidth() >= WIDE else 3))
    if not names:
        axes.text(0.5, 0.5, "no effect", transform=axes.transAxes, ha="center", color=GREY)
