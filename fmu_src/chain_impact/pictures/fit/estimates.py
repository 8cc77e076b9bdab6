"""The panel of the estimates of a fit: how far each parameter came from its start, and how certain it is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from matplotlib.transforms import blended_transform_factory

from chain_impact.pictures.drawing.colours import GREY, INK, PALE_GREY, VERMILLION
from chain_impact.pictures.drawing.head_and_foot import LEFT_MARGIN, foot_of, reserve_margins
from chain_impact.pictures.drawing.legends import fit_legends, legend_above
from chain_impact.pictures.drawing.style import is_narrow
from chain_impact.pictures.fit.contents import FittedParameter
from chain_impact.text import number_text

MOST_ROWS_OF_ESTIMATES = 10  # the largest number of parameters with a row
# [inch] LINE_ROW, TWO_LINE_ROW: the height of a row with its texts beside or above its marks; SCALE_ROOM:
# that of the numbers and the name below the rows; KEYS: that of the legend and the space above the rows
LINE_ROW, TWO_LINE_ROW, SCALE_ROOM, KEYS = 0.2, 0.27, 0.41, 0.23
TEXT_GAP = 0.08  # [inch] the space between marks and texts beside them
# in a row with its texts above its marks: how far both are from the middle of the row, relative to its height
TEXTS_ABOVE, MARKS_BELOW = 0.17, 0.3
MOST_NUMBERS = 6  # the largest number of numbers at the axis
LEAST_DRAWN = 1e-6  # a smaller distance, relative to the value, is drawn as this
FEWEST_DECADES = 2  # the least number of decades of the axis, so that it has three numbers
START: dict[str, Any] = {"marker": "o", "markerfacecolor": "none", "color": INK, "markersize": 4.5}
END: dict[str, Any] = {"marker": "o", "color": VERMILLION, "markersize": 4.5}
"""The marks of a start and of the end of an interval, with matplotlib's names."""
RANGE: dict[str, Any] = {"linewidth": 1.0, "color": GREY, "zorder": 1.0}
AXIS_NAME = "distance from the estimate [% of it]"


def height_of_estimates(parameters: Sequence[FittedParameter], *, is_small: bool) -> float:
    """Return the height [inch] that the panel needs; ``is_small``: whether the figure is narrow."""
    row_height = TWO_LINE_ROW if is_small else LINE_ROW
    return KEYS + SCALE_ROOM + row_height * len(parameters[:MOST_ROWS_OF_ESTIMATES])


def reserve_estimates(figure: Figure, parameters: Sequence[FittedParameter]) -> float:
    """Keep room for the panel at the foot of a figure, above the texts there; return their height [inch]."""
    foot, height = foot_of(figure) * figure.get_figheight(), figure.get_figheight()
    needed_height = height_of_estimates(parameters, is_small=is_narrow(figure))
    reserve_margins(figure, 0.0, (foot + needed_height) / height)
    return foot


def draw_estimates(figure: Figure, parameters: Sequence[FittedParameter], foot: float) -> None:
    """Draw a row for each parameter: its start, the farther end of its 95 % interval, and its value as text.

    Both are drawn as distances from the estimate, relative to it, on a logarithmic axis: the start is as far
    as the estimate has moved, the end of the interval as far as the estimate is uncertain. A distance that is
    not known has no mark. In a wide figure the names stand at the left, start and value as text at the right;
    in a narrow one names and values stand above the marks. Parameters beyond MOST_ROWS_OF_ESTIMATES have no
    row. ``foot``: the result of ``reserve_estimates``.
    """
    is_small, rows = is_narrow(figure), list(parameters[:MOST_ROWS_OF_ESTIMATES])
    axes = figure.add_axes((0.3, 0.1, 0.3, 0.1))
    axes.set_in_layout(False)
    for row, parameter in enumerate(rows):
        _draw_marks(axes, row + (MARKS_BELOW if is_small else 0.0), parameter)
    axes.set(ylim=(len(rows) - 0.5, -0.5), yticks=[])
    axes.spines["left"].set_visible(False)
    axes.set_xscale("log")
    axes.set_xlim(*_decades(rows))
    axes.xaxis.set_major_locator(LogLocator(numticks=MOST_NUMBERS))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: number_text(100.0 * value)))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel(AXIS_NAME)
    width, height = figure.get_size_inches()
    left, right = _write_texts(figure, axes, rows, is_small=is_small)
    rows_height = (TWO_LINE_ROW if is_small else LINE_ROW) * len(rows)
    axes.set_position(
        (left / width, (foot + SCALE_ROOM) / height, (right - left) / width, rows_height / height)
    )
    legend_above(
        axes,
        [
            Line2D([], [], linestyle="", label="start of the search", **START),
            Line2D([], [], linestyle="", label="end of the 95 % interval", **END),
        ],
    )
    fit_legends(figure, [axes])


def _draw_marks(axes: Axes, middle: float, parameter: FittedParameter) -> None:
    """Draw start and end of the interval of a parameter at the height ``middle``, joined by a line."""
    axes.axhline(middle, color=PALE_GREY, linewidth=0.6, zorder=0)
    distances = (parameter.start_distance, parameter.interval_distance)
    start, end = (max(part, LEAST_DRAWN) if math.isfinite(part) else math.nan for part in distances)
    axes.plot([start, end], [middle, middle], **RANGE)
    axes.plot([start], [middle], linestyle="", clip_on=False, **START)
    axes.plot([end], [middle], linestyle="", clip_on=False, **END)


def _decades(rows: Sequence[FittedParameter]) -> tuple[float, float]:
    """Return the ends of the axis: powers of ten around all distances, FEWEST_DECADES apart or more."""
    distances = [part for row in rows for part in (row.start_distance, row.interval_distance)]
    known_distances = [max(part, LEAST_DRAWN) for part in distances if math.isfinite(part)] or [0.1]
    low = math.floor(math.log10(min(known_distances)))
    high = max(math.ceil(math.log10(max(known_distances))), low + FEWEST_DECADES)
    return 10.0**low, 10.0**high


def _write_texts(
    figure: Figure, axes: Axes, rows: Sequence[FittedParameter], *, is_small: bool
) -> tuple[float, float]:
    """Write names and values of parameters; return the left and the right end of the axes [inch]."""
    left, right = LEFT_MARGIN, figure.get_figwidth() - LEFT_MARGIN
    look: dict[str, Any] = {"fontsize": "small", "va": "center", "in_layout": False}
    names, values = list[Text](), list[Text]()
    for row, parameter in enumerate(rows):
        level = row - TEXTS_ABOVE if is_small else row
        value_text = parameter.value_text if is_small else f"{parameter.start_text} → {parameter.value_text}"
        place = blended_transform_factory(figure.dpi_scale_trans, axes.transData)
        names.append(axes.text(left, level, parameter.name, transform=place, ha="left", **look))
        values.append(axes.text(right, level, value_text, transform=place, ha="right", **look))
    if is_small:
        return left + TEXT_GAP, right - TEXT_GAP
    name_width, value_width = (
        max(text.get_window_extent().width for text in texts) / figure.dpi for texts in (names, values)
    )
    for text in values:
        text.set(x=right - value_width, ha="left")
    return left + name_width + TEXT_GAP, right - value_width - TEXT_GAP
