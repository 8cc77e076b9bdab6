"""The picture of a fit: a panel for each measured column, and one with the estimates of the parameters.

There are at most MOST_FIT_PANELS panels of columns.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from chain_impact.pictures.drawing.colours import PEAK_COLOUR
from chain_impact.pictures.drawing.figures import settle
from chain_impact.pictures.drawing.head_and_foot import write_headline
from chain_impact.pictures.drawing.line_breaks import SEPARATOR
from chain_impact.pictures.drawing.style import drawing_style, is_narrow
from chain_impact.pictures.fit.columns import USUAL_RESIDUAL, draw_column
from chain_impact.pictures.fit.contents import FitContents, FittedColumn
from chain_impact.pictures.fit.estimates import (
    MOST_ROWS_OF_ESTIMATES,
    draw_estimates,
    height_of_estimates,
    reserve_estimates,
)
from chain_impact.text import count_text

MOST_FIT_PANELS = 8  # the largest number of panels; further measured columns are not drawn
FIT_PANEL_WIDTH, FIT_PANEL_HEIGHT = 5.2, 2.6  # [inch] size of a panel
PANEL_PARTS = (5, 2)  # the relative heights of values and residuals
IMPACT_PARTS = (3, 2)  # those of a quantity of impacts in a narrow figure, which has few values
ROW_WIDTHS = [3, 3, 2]  # the relative widths of two panels over time and one of impacts in a row
SAME_TIMES = 1e-6  # the largest difference of the ends of time axes that share numbers, relative to the ends


def fit_size(contents: FitContents) -> tuple[float, float]:
    """Return the default width and height of the figure [inches]."""
    columns = contents.columns[:MOST_FIT_PANELS]
    width = (1.5 if len(columns) == 1 else 2.0) * FIT_PANEL_WIDTH
    rows = -(-len(columns) // len(_widths(columns)))
    estimates_height = height_of_estimates(contents.parameters, is_small=False)
    return width, 0.7 + rows * FIT_PANEL_HEIGHT + estimates_height


@drawing_style()
def draw_fit(figure: Figure, contents: FitContents) -> None:
    """Draw a panel for each of the first MOST_FIT_PANELS columns, the estimates, and the headline."""
    shown_columns, is_small = contents.columns[:MOST_FIT_PANELS], is_narrow(figure)
    notes = list(contents.notes)
    if len(shown_columns) < len(contents.columns):
        notes.append(f"{len(shown_columns)} of {len(contents.columns)} columns")
    if (rest := len(contents.parameters) - MOST_ROWS_OF_ESTIMATES) > 0:
        notes.append(count_text(rest, "more parameter"))
    marks_text = "bars and bands" if any(column.is_of_impacts for column in shown_columns) else "bands"
    notes += ["±: standard error", f"{marks_text}: ± {USUAL_RESIDUAL:g} σ"]
    if any(len(part.onsets) for column in shown_columns for part in column.series):
        notes.append("grey lines: impacts")
    lines = [(contents.warning, PEAK_COLOUR)] * bool(contents.warning)
    widths = [1] if is_small else _widths(shown_columns)
    columns, rows = len(widths), -(-len(shown_columns) // len(widths))
    parts = [
        part
        for column in shown_columns[::columns]
        for part in (IMPACT_PARTS if is_small and column.is_of_impacts else PANEL_PARTS)
    ]
    # one grid for all panels: then their axes stand exactly below each other
    grid = figure.add_gridspec(2 * rows, columns, width_ratios=widths, height_ratios=parts)
    for k, column in enumerate(shown_columns):
        row, place = divmod(k, columns)
        # the last panel is as wide as its row, but not a panel of impacts, which has few values
        is_alone = k == len(shown_columns) - 1 and not place and not column.is_of_impacts
        cells = [grid[2 * row + part, slice(None) if is_alone else place] for part in (0, 1)]
        values = figure.add_subplot(cells[0])
        residuals = figure.add_subplot(cells[1], sharex=values)
        draw_column(values, residuals, column, has_several=contents.has_several_sets)
    write_headline(figure, contents.title, SEPARATOR.join(notes), *lines)
    _share_times(figure, columns)
    figure.align_ylabels()
    foot = reserve_estimates(figure, contents.parameters)
    settle(figure)
    draw_estimates(figure, contents.parameters, foot)


def _share_times(figure: Figure, columns: int) -> None:
    """Remove the name of an axis if the panel below, as wide, has the same name and ends; numbers stay."""
    residuals = figure.axes[1::2]
    for k, axes in enumerate(residuals):
        neighbours = residuals[k + columns : k + columns + 1]
        looks = [(panel.get_xlabel(), panel.get_position().x1) for panel in (axes, *neighbours)]
        ends = [panel.get_xlim() for panel in (axes, *neighbours)]
        if neighbours and looks[0] == looks[1] and np.allclose(ends[0], ends[1], rtol=SAME_TIMES, atol=0.0):
            axes.set_xlabel("")


def _widths(columns: Sequence[FittedColumn]) -> list[int]:
    """Return the relative widths of the columns of a wide picture with panels for measured ``columns``.

    Two panels stand in a row; a third and last panel of impacts stands beside them, and is narrower.
    """
    if len(columns) == len(ROW_WIDTHS) and columns[-1].is_of_impacts:
        return ROW_WIDTHS
    return [1] * min(len(columns), 2)
