"""The table in the figure with derivatives: the change of each impact by a change of each parameter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, SymLogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import FixedFormatter, FixedLocator
from matplotlib.transforms import ScaledTranslation

from chain_impact.pictures.drawing.style import DECREASE, GREY, INCREASE, INK, OUTSIDE_COLOUR, is_narrow
from chain_impact.recording.recording import Recording
from chain_impact.recording.sensitivity import Sensitivities
from chain_impact.text import count_text, signed_text

# the opacity of the largest changes, from 0 to 1: so low that the text on it stays legible
MOST_OPACITY = 0.6
# the colours of changes, with the opacity 0 for no change, so that they suit a light and a dark ground; blank
# cells have a colour of their own
SIGNED_STOPS = (
    (0.0, (DECREASE, MOST_OPACITY)),
    (0.5, (DECREASE, 0.0)),
    (0.5, (INCREASE, 0.0)),
    (1.0, (INCREASE, MOST_OPACITY)),
)
SIGNED_COLOURS = LinearSegmentedColormap.from_list("signed", SIGNED_STOPS).with_extremes(bad=OUTSIDE_COLOUR)
# [%] |changes| below LEAST_CHANGE are written as 0; from MOST_CHANGE on, the colour stays
LEAST_CHANGE, MOST_CHANGE = 0.01, 100.0
# |changes| up to FAINT_CHANGE, relative to the largest one, have no colour; the colours of larger ones are
# logarithmic
FAINT_CHANGE = 0.01
# [inch] CELL_HEIGHT: the least height of a row, so that names and numbers in successive rows do not touch;
# SCALE_HEIGHT: that of the table beside a bar with numbers
CELL_HEIGHT, SCALE_HEIGHT = 0.17, 0.65
# [inch] the least width of a cell with a number, and the width of the names beside the cells
CELL_WIDTH, ROW_NAMES_WIDTH = 0.38, 1.7
# [inch] the distances of the word "impact" from the left and lower edges of the cells
WORD_DISTANCE = 3.5 / 72.0
MOST_TABLE_ROWS = 8  # the largest number of rows of the table
MOST_NUMBERED = 12  # the largest number of impacts that are numbered below the table


def draw_impact_changes(
    axes: Axes,
    recording: Recording,
    sensitivities: Sensitivities,
    looks: Sequence[dict[str, Any]],
    is_known: np.ndarray,
) -> float:
    """Draw the change of each impact's peak force [%] by a step of each parameter, as a table.

    The table has a column for each impact, and the rows ``shown_parameters``; the title tells how many
    parameters have no row. ``looks`` has the properties of each parameter's curves. If no change of a peak
    force is known, as in rigid impacts, the changes are those of the impulses.
    ``is_known``, shape (T, P): whether changes to first order can hold, for each row of the recording and
    each parameter. A cell is blank if its change is not known, or cannot hold at the impact's onset.

    Return the height that the table needs [inch].
    """
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    onsets = sensitivities.impacts["onset"]
    if not len(onsets):
        axes.set(xticks=[], yticks=[])
        axes.text(0.5, 0.5, "no impact", transform=axes.transAxes, ha="center", color=INK)
        return CELL_HEIGHT
    quantity = "peak_force"
    if not np.isfinite(sensitivities.relative(quantity)).any():
        quantity = "impulse"
    onset_rows = [recording.row_at(time) for time in onsets]
    every_change = 100.0 * np.where(is_known[onset_rows], sensitivities.relative(quantity), np.nan).T
    rows = shown_parameters(looks, every_change)
    changes = every_change[rows]
    sizes = np.abs(changes[np.isfinite(changes)])
    largest_size = sizes.max(initial=0.0)
    most_change = min(MOST_CHANGE, largest_size) or MOST_CHANGE
    norm = SymLogNorm(FAINT_CHANGE * most_change, linscale=0.1, vmin=-most_change, vmax=most_change)
    image = axes.imshow(np.ma.masked_invalid(changes), SIGNED_COLOURS, norm=norm, aspect="auto")
    figure = axes.get_figure(root=True)
    assert figure is not None
    has_texts = has_numbers(figure, len(onsets))
    if has_texts:
        for (row, column), change in np.ndenumerate(changes):
            if np.isfinite(change):
                look: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": "small"}
                axes.text(column, row, cell_text(change), color="black", **look)
    else:
        ticks = [part * most_change for part in (-1.0, -0.1, 0.0, 0.1, 1.0)]
        lowest, *other_texts, highest = map(cell_text, ticks)
        # changes beyond an end of the bar have the colour of this end
        ends = (f"≤{lowest}", f"≥{highest}") if largest_size > most_change else (lowest, highest)
        texts = FixedFormatter([ends[0], *other_texts, ends[1]])
        bar = figure.colorbar(image, ax=axes, ticks=FixedLocator(ticks), format=texts)
        bar.ax.minorticks_off()
    number_step = -(-len(onsets) // MOST_NUMBERED)
    axes.set_xticks(
        range(0, len(onsets), number_step), [str(k + 1) for k in range(0, len(onsets), number_step)]
    )
    axes.set_yticks(range(len(rows)), [list(sensitivities.parameters)[k] for k in rows], fontsize="small")
    for label, k in zip(axes.get_yticklabels(), rows, strict=True):
        label.set_color(looks[k]["color"] if looks[k]["color"] != GREY else INK)
    # the word stands beside the numbers, below the names of the rows
    axes.set_xlabel("impact", ha="right", va="top", fontsize="small")
    offset = ScaledTranslation(-WORD_DISTANCE, -WORD_DISTANCE, figure.dpi_scale_trans)
    axes.xaxis.set_label_coords(0.0, 0.0, transform=axes.transAxes + offset)
    title = f"change of {quantity_words(quantity, recording.is_at_joint_stop)} [%]"
    if left_out := len(looks) - len(rows):
        title += f"; {count_text(left_out, 'parameter')} without a row"
    axes.set_title(title, fontsize="medium", loc="left")
    return max(len(rows) * CELL_HEIGHT, 0.0 if has_texts else SCALE_HEIGHT)


def shown_parameters(looks: Sequence[dict[str, Any]], changes: np.ndarray) -> list[int]:
    """Return the indices of the parameters with rows in the table: those with coloured curves come first.

    Up to MOST_TABLE_ROWS in all, those with grey curves follow that have the largest |changes| of an impact.
    ``changes``: the change of each impact by each parameter, shape (P, I).
    """
    coloured = [k for k, look in enumerate(looks) if look["color"] != GREY]
    sizes = np.abs(np.nan_to_num(changes)).max(axis=1)
    other_parameters = sorted({*range(len(looks))} - {*coloured}, key=lambda k: -sizes[k])
    return coloured + other_parameters[: max(MOST_TABLE_ROWS - len(coloured), 0)]


def has_numbers(figure: Figure, impacts: int) -> bool:
    """Return whether the cells of a table with ``impacts`` columns in a figure have room for numbers."""
    column_count = 1 if is_narrow(figure) else 2
    return figure.get_figwidth() / column_count - ROW_NAMES_WIDTH >= CELL_WIDTH * impacts


def cell_text(change: float) -> str:
    """Return a change [%] as text with sign and two significant digits; "0" for |change| < LEAST_CHANGE."""
    return "0" if abs(change) < LEAST_CHANGE else signed_text(change).replace("-", "−")


def quantity_words(quantity: str, at_stops: np.ndarray) -> str:
    """Return the words for a quantity of impacts; a peak force at a joint's stop is a moment.

    ``at_stops``: whether each impact is at a joint's stop, shape (I,).
    """
    if quantity != "peak_force":
        return quantity
    return "peak moment" if at_stops.all() else "peak force or moment" if at_stops.any() else "peak force"
