"""The table in the figure with derivatives: the change of each impact by a change of each parameter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, ListedColormap, Normalize, SymLogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import FixedFormatter, FixedLocator
from matplotlib.transforms import ScaledTranslation, blended_transform_factory

from chain_impact.pictures.drawing.colours import DECREASE, GREY, INCREASE, INK, OUTSIDE_COLOUR
from chain_impact.pictures.drawing.dark_ground import lightened_colour, luminance
from chain_impact.pictures.drawing.head_and_foot import LEFT_MARGIN, start_left
from chain_impact.pictures.drawing.line_breaks import break_lines
from chain_impact.pictures.drawing.style import is_narrow
from chain_impact.pictures.first_order import FirstOrderChanges
from chain_impact.recording.sensitivity import RELATIVE_STEP, Sensitivities
from chain_impact.text import count_text, signed_text

# the opacity of the largest changes, from 0 to 1: so low that the text on it stays legible
MOST_OPACITY = 0.7
# an increase as light as a decrease, so that equal changes to both sides look equally large on any ground
LIGHT_INCREASE = lightened_colour(INCREASE, luminance(DECREASE))
# the colours of changes, with the opacity 0 for no change, so that they suit a light and a dark ground; blank
# cells have a colour of their own
SIGNED_STOPS = (
    (0.0, (DECREASE, MOST_OPACITY)),
    (0.5, (DECREASE, 0.0)),
    (0.5, (LIGHT_INCREASE, 0.0)),
    (1.0, (LIGHT_INCREASE, MOST_OPACITY)),
)
SIGNED_COLOURS = LinearSegmentedColormap.from_list("signed", SIGNED_STOPS).with_extremes(bad=OUTSIDE_COLOUR)
NO_COLOURS = ListedColormap(["none"]).with_extremes(bad=OUTSIDE_COLOUR)
# [%] |changes| below LEAST_CHANGE are written as 0; the colours end at a power of ten up to MOST_CHANGE, and
# larger changes have the colour of this end
LEAST_CHANGE, MOST_CHANGE = 0.01, 10.0
# the strength of a colour is linear up to the end of the colours divided by LOG_RANGE, and logarithmic from
# there on; LINEAR_PART: the length of the linear part, relative to that of a decade
LOG_RANGE, LINEAR_PART = 100.0, 0.1
GRID: dict[str, Any] = {"color": "0.85", "linewidth": 0.4, "zorder": 2.0}
"""The lines between cells, with matplotlib's names: a change of 0 has the colour of the ground."""
# [inch] CELL_HEIGHT: the least height of a row, so that names and numbers in successive rows do not touch;
# SCALE_HEIGHT: that of the table beside a bar with numbers
CELL_HEIGHT, SCALE_HEIGHT = 0.17, 0.65
# [inch] the least width of a cell with a number, and the width of the names beside the cells
CELL_WIDTH, ROW_NAMES_WIDTH = 0.38, 1.7
# [inch] the distances of the word "impact" from the left and lower edges of the cells
WORD_DISTANCE = 3.5 / 72.0
FIRST_EDGE = -0.5  # the left edge of the cells; the cell of the first impact has its middle at 0
MOST_NAMES = 0.7  # the largest width of the names of rows, relative to that of the table's axes
TABLE_PART = 0.45  # the width of the table in a wide figure, relative to that of the figure
MOST_TABLE_ROWS = 8  # the largest number of rows of the table
# LONGEST_ROW_NAME: the largest number of characters of a name with its step in one line; if a name is longer,
# the steps stand in second lines, and these rows have the height TWO_LINES, relative to a row of one line
LONGEST_ROW_NAME, TWO_LINES = 28, 1.8
ADDED_HEADING = "added to the value 0, not comparable:"
# the largest number of impacts that are numbered below the table: in a wide and in a narrow figure
MOST_NUMBERED, FEW_NUMBERED = 12, 6


class RowBlock(NamedTuple):
    """Rows of the table with changes that can be compared with each other.

    Attributes:
        parameters: the indices of the parameters.
        names: the text beside each row.
        top: the upper edge of the first row; the unit is the height of a row of the first block.
        height: the height of each row.
    """

    parameters: list[int]
    names: list[str]
    top: float = 0.0
    height: float = 1.0

    @property
    def end(self) -> float:
        """The lower edge of the last row."""
        return self.top + self.height * len(self.parameters)

    @property
    def middles(self) -> list[float]:
        """The middle of each row."""
        return [self.top + self.height * (k + 0.5) for k in range(len(self.parameters))]


def draw_impact_changes(axes: Axes, first_order: FirstOrderChanges, looks: Sequence[dict[str, Any]]) -> float:
    """Draw the change of each impact's peak force [%] by a step of each parameter, as a table.

    The table has a column for each impact, and the rows of ``blocks_of``; the title tells how many parameters
    have no row. ``looks`` has the properties of each parameter's curves. If no change of a peak force is
    known, as in rigid impacts, the changes are those of the impulses. A cell is blank if its change is not
    known, or cannot hold at the impact's onset.

    The strength of a colour is that of ``colour_norm``. In the second block, cells with numbers have no
    colour, which would compare them with the first block.

    Return the height that the table needs [inch].
    """
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    recording, sensitivities = first_order.recording, first_order.sensitivities
    onsets = sensitivities.impacts["onset"]
    if not len(onsets):
        axes.set(xticks=[], yticks=[])
        axes.text(0.5, 0.5, "no impact", transform=axes.transAxes, ha="center", color=INK)
        return CELL_HEIGHT
    quantity = "peak_force"
    if not np.isfinite(sensitivities.relative(quantity)).any():
        quantity = "impulse"
    onset_rows = [recording.row_at(time) for time in onsets]
    changes = 100.0 * np.where(first_order.is_known[onset_rows], sensitivities.relative(quantity), np.nan).T
    blocks = blocks_of(sensitivities, looks, changes)
    largest_size = max(float(np.abs(np.nan_to_num(changes[block.parameters])).max()) for block in blocks)
    scale_end = float(np.abs(np.nan_to_num(changes[blocks[0].parameters])).max()) or largest_size
    norm = colour_norm(scale_end)
    figure = axes.get_figure(root=True)
    assert figure is not None
    has_texts = has_numbers(figure, len(onsets))
    images = [
        _draw_block(axes, block, changes[block.parameters], norm, has_texts=has_texts) for block in blocks
    ]
    axes.set_ylim(blocks[-1].end, 0.0)
    if not has_texts:
        _add_bar(figure, axes, images[0], largest_size)
    if len(blocks) > 1:
        heading: dict[str, Any] = {"va": "center", "color": INK, "fontsize": "small", "in_layout": False}
        start_left(
            axes,
            axes.text(0.0, 0.5 * (blocks[0].end + blocks[1].top), ADDED_HEADING, **heading),
            axes.transData,
        )
    _name_rows_and_columns(axes, blocks, looks, len(onsets))
    rows = [k for block in blocks for k in block.parameters]
    title = f"change of {impact_quantity_text(quantity, recording.is_at_joint_stop)} [%]"
    if sensitivities.parameters[list(sensitivities.parameters)[rows[0]]]:
        title += f" by + {100.0 * RELATIVE_STEP:g} %"
    if left_out := len(looks) - len(rows):
        title += f"; {count_text(left_out, 'parameter')} without a row"
    text = axes.set_title(title, fontsize="medium", loc="left")
    # beside a panel, the table takes half of the figure at most
    room = figure.get_figwidth() if is_narrow(figure) else TABLE_PART * figure.get_figwidth()
    break_lines(text, (room - 2.0 * LEFT_MARGIN) * figure.dpi, "; ")
    start_left(axes, text)
    return max(blocks[-1].end * CELL_HEIGHT, 0.0 if has_texts else SCALE_HEIGHT)


def _name_rows_and_columns(
    axes: Axes, blocks: Sequence[RowBlock], looks: Sequence[dict[str, Any]], impact_count: int
) -> None:
    """Write the names of the rows, in the colours of the curves, and the numbers of the impacts below."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    number_step = -(-impact_count // (FEW_NUMBERED if is_narrow(figure) else MOST_NUMBERED))
    impact_indices = range(0, impact_count, number_step)
    axes.set_xticks(impact_indices, [str(k + 1) for k in impact_indices])
    names = [name for block in blocks for name in block.names]
    axes.set_yticks([middle for block in blocks for middle in block.middles], names, fontsize="small")
    rows = [k for block in blocks for k in block.parameters]
    for label, k in zip(axes.get_yticklabels(), rows, strict=True):
        label.set_color(looks[k]["color"] if looks[k]["color"] != GREY else INK)
    # the word stands beside the numbers, below the names of the rows
    axes.set_xlabel("impact", ha="right", va="top", fontsize="small")
    offset = ScaledTranslation(-WORD_DISTANCE, -WORD_DISTANCE, figure.dpi_scale_trans)
    edge = blended_transform_factory(axes.transData, axes.transAxes)
    axes.xaxis.set_label_coords(FIRST_EDGE, 0.0, transform=edge + offset)
    name_rows_inside(axes)


def name_rows_inside(axes: Axes) -> None:
    """Put the names of the rows between the left edge of the table's axes and the cells.

    So the names do not shift the panels above the table. In a narrow figure that is arranged, the names start
    below the start of the headline.
    """
    figure, names = axes.get_figure(root=True), axes.get_yticklabels()
    assert figure is not None
    if not axes.images or not any(name.get_text() for name in names):
        return
    box, pixel = axes.get_window_extent(), 72.0 / figure.dpi
    width = max(name.get_window_extent().width for name in names)
    start = min(box.x0, LEFT_MARGIN * figure.dpi) if is_narrow(figure) else box.x0
    inset = min(start - box.x0 + width, MOST_NAMES * box.width)
    axes.tick_params(axis="y", pad=-pixel * inset)
    part = (inset + WORD_DISTANCE * figure.dpi) / box.width
    last_edge = axes.images[0].get_extent()[1]
    axes.set_xlim((FIRST_EDGE - part * last_edge) / (1.0 - part), last_edge)


def colour_norm(largest_change: float) -> Normalize:
    """Return the scale of the colours for |changes| [%] up to a largest one: logarithmic to both sides of 0.

    One large change leaves small changes visible so. The scale ends at a power of ten, at most MOST_CHANGE.
    """
    power = np.ceil(np.log10(largest_change)) if largest_change > 0.0 else np.inf
    end = float(min(MOST_CHANGE, 10.0**power))
    return SymLogNorm(end / LOG_RANGE, LINEAR_PART, -end, end)


def has_blank_cells(axes: Axes) -> bool:
    """Return whether the table in some axes has cells without a known change."""
    arrays = [image.get_array() for image in axes.images]
    return any(bool(np.ma.getmaskarray(array).any()) for array in arrays if array is not None)


def _draw_block(axes: Axes, block: RowBlock, changes: np.ndarray, norm: Normalize, *, has_texts: bool) -> Any:
    """Draw a block of rows with their ``changes``; return matplotlib's image of the colours."""
    is_coloured = not (block.top and has_texts)
    extent = (FIRST_EDGE, changes.shape[1] - 0.5, block.end, block.top)
    colours = SIGNED_COLOURS if is_coloured else NO_COLOURS
    image = axes.imshow(np.ma.masked_invalid(changes), colours, norm=norm, aspect="auto", extent=extent)
    axes.vlines(np.arange(changes.shape[1] + 1) + FIRST_EDGE, block.top, block.end, **GRID)
    rows = block.top + block.height * np.arange(len(changes) + 1)
    axes.hlines(rows, FIRST_EDGE, changes.shape[1] + FIRST_EDGE, **GRID)
    for (row, column), change in np.ndenumerate(changes):
        if has_texts and np.isfinite(change):
            look: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": "small"}
            axes.text(column, block.middles[row], cell_text(change), color="black", **look)
    return image


def _add_bar(figure: Figure, axes: Axes, image: Any, largest_size: float) -> None:
    """Add a bar that explains the colours; ``largest_size`` is the largest |change| of all rows."""
    end = float(image.norm.vmax)
    ticks = [-end, -end / 10.0, 0.0, end / 10.0, end]
    texts = FixedFormatter([f"{tick:+g}".replace("-", "−") if tick else "0" for tick in ticks])
    # changes beyond an end of the bar have the colour of this end
    extend = "both" if largest_size > end else "neither"
    bar = figure.colorbar(image, ax=axes, ticks=FixedLocator(ticks), format=texts, extend=extend)
    bar.ax.minorticks_off()
    bar.ax.tick_params(labelsize="small")


def blocks_of(
    sensitivities: Sensitivities, looks: Sequence[dict[str, Any]], changes: np.ndarray
) -> list[RowBlock]:
    """Return the rows of the table: parameters changed by 1 %, and below them parameters that are 0.

    A block without parameters is left out. In each block, the parameters with coloured curves come first, and
    then those with the largest |changes| of an impact. There are at most MOST_TABLE_ROWS rows, of which the
    parameters that are 0 get a quarter, or more if the others are few.
    ``changes``: the change of each impact by each parameter, shape (P, I).
    """
    names, sizes = list(sensitivities.parameters), np.abs(np.nan_to_num(changes)).max(axis=1)
    order = sorted(range(len(names)), key=lambda k: (looks[k]["color"] == GREY, -sizes[k]))
    coloured = [k for k, look in enumerate(looks) if look["color"] != GREY]
    order = coloured + order[len(coloured) :]
    of_value, added = (
        [k for k in order if bool(sensitivities.parameters[names[k]]) == is_value]
        for is_value in (True, False)
    )
    added = added[: max(MOST_TABLE_ROWS - len(of_value), MOST_TABLE_ROWS // 4)]
    of_value = of_value[: MOST_TABLE_ROWS - len(added)]
    blocks = [RowBlock(of_value, [names[k] for k in of_value])] if of_value else []
    if added:
        texts = [f"{names[k]} + {sensitivities.step_text(names[k])}" for k in added]
        is_long = max(map(len, texts)) > LONGEST_ROW_NAME
        texts = [text.replace(" + ", "\n+ ") if is_long else text for text in texts]
        top = len(of_value) + 1.0 if of_value else 0.0
        blocks.append(RowBlock(added, texts, top, TWO_LINES if is_long else 1.0))
    return blocks


def has_numbers(figure: Figure, impacts: int) -> bool:
    """Return whether the cells of a table with ``impacts`` columns in a figure have room for numbers."""
    column_count = 1 if is_narrow(figure) else 2
    return figure.get_figwidth() / column_count - ROW_NAMES_WIDTH >= CELL_WIDTH * impacts


def cell_text(change: float) -> str:
    """Return a change [%] as text with sign and two significant digits; "0" for |change| < LEAST_CHANGE.

    A |change| above MOST_CHANGE, which first order cannot tell, is only bounded: "> +10", "< −10".
    """
    if abs(change) > MOST_CHANGE:
        return f"> +{MOST_CHANGE:g}" if change > 0.0 else f"< −{MOST_CHANGE:g}"
    return "0" if abs(change) < LEAST_CHANGE else signed_text(change).replace("-", "−")


def impact_quantity_text(quantity: str, at_stops: np.ndarray) -> str:
    """Return the words for a quantity of impacts; a peak force at a joint's stop is a moment.

    ``at_stops``: whether each impact is at a joint's stop, shape (I,).
    """
    if quantity != "peak_force":
        return quantity
    return "peak moment" if at_stops.all() else "peak force or moment" if at_stops.any() else "peak force"
