"""Figures of a given size for pictures, with a check that all panels have room and labels do not overlap."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from functools import partial
from itertools import combinations
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis, YAxis
from matplotlib.figure import Figure
from matplotlib.layout_engine import PlaceHolderLayoutEngine
from matplotlib.text import Text
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import Bbox

from chain_impact.pictures.drawing.headings import MAY_BE_LOW, has_heading, height_with_heading
from chain_impact.pictures.drawing.legends import fit_legends
from chain_impact.pictures.drawing.line_breaks import COMMA, break_lines
from chain_impact.pictures.drawing.row_names import lacking_for_rows
from chain_impact.pictures.drawing.shared_names import FRAME, framed_panels
from chain_impact.pictures.drawing.sizes import LEAST_SIZE, Size, figure_size
from chain_impact.pictures.drawing.style import (
    DPI,
    FULL_WIDTH,
    LEAST_TICKS,
    TWO_COLUMN_WIDTH,
    StyledFigure,
    adapt_to_dark_style,
    drawing_style,
    drawn_figure,
    save,
)

FIGURE_SIZE = (FULL_WIDTH, 5.4)  # [inch] the default width and height of a figure
PANEL_HEIGHT = 1.9  # [inch] the usual height of a panel over time, with its legend and numbers
LEAST_AXES_HEIGHT = 0.3  # [inch] the least height of axes with a label along y
# [inch] the least mean height of the axes with a label along y, if the user gives no height
USUAL_AXES_HEIGHT = 1.0
TALL = 7.75  # [inch] the largest wanted height of a figure: a printed page also has room for a caption
SLENDER = 1.6  # the largest wanted height of a figure, relative to its width
FLAT_AXES_HEIGHT = 0.7  # [inch] the least mean height of the axes if a figure would be higher than wanted
EDGE_MARGIN = 0.04  # [inch] the least distance of a label of an axis from the figure's left and right edge
SETTLINGS = 3  # how often, at most, a figure is arranged: a label or legend that is broken changes the layout
OVERLAP_TOLERANCE = 1.0  # [pixels] the largest distance by which texts may reach beyond the figure or overlap
# a number at an axis counts as between the ends of the axis if it is beyond an end by at most this part of
# the length of the axis
LIMIT_ROUND_OFF = 1e-9
# If a figure is too low, greater heights are tried: the height of the figure, rounded up to a multiple of
# HEIGHT_STEP [inch], plus 1, 2, … or MOST_HEIGHT_STEPS − 1 times HEIGHT_STEP.
HEIGHT_STEP, MOST_HEIGHT_STEPS = 0.25, 40
TICK_SPACE = 0.6  # the least space between two numbers of an axis, relative to their height
# the allowed distances between numbers on an axis x with few numbers, times any power of ten
COARSE_STEPS = (1, 2, 4, 5, 10)

# the label of an axis x is broken into lines if it is longer than LABEL_RATIO × the axis (``break_labels``)
LABEL_RATIO = 1.1
# A function that draws a picture on an empty figure.
DrawContents = Callable[[Figure], None]


class NoRoomError(ValueError):
    """Raised when a figure has no room for its contents.

    Attributes:
        least: a height [inches] that is enough for the refused width; None if no tried height is enough.
    """

    def __init__(self, width: float, height: float, requirement: str, enough: float | None = None) -> None:
        """Make the message from the refused size [inches] and the words ``requirement``; store ``enough``."""
        super().__init__(f"size = ({width:g}, {height:g}) must be {requirement}")
        self.least = enough


def draw_figure(
    draw_contents: DrawContents,
    path: str | os.PathLike[str] | None = None,
    size: Size | None = None,
    usual_size: tuple[float, float] = FIGURE_SIZE,
) -> Figure | None:
    """Draw a figure into a file, or return the figure.

    Args:
        draw_contents: function that draws the contents on an empty figure.
        path: the file to write; its suffix png, svg or pdf determines the format. With None, the figure is
            returned.
        size: width and height [inches]. The height None means the height that the contents need. If ``size``
            itself is None, the size is ``usual_size``, without a check whether the contents have room.
        usual_size: default width and height [inches]; for a height of None, ``fitting_figure`` starts
            from these.

    Raises:
        ValueError: when the given size is not possible, or has no room for the contents.
        OSError: when the file cannot be written.
    """
    inches, is_free = usual_size, False
    if size is not None:
        width, height = figure_size(size)
        if height is None:
            tried_figure = fitting_figure(draw_contents, width, usual_size)
            if path is not None:
                save(Path(path), lambda: tried_figure)
                return None
            inches, is_free = (width, float(tried_figure.get_figheight())), True
        else:
            inches, draw_contents = (width, height), partial(draw_or_refuse, draw_contents)
    if path is not None:
        save(Path(path), lambda: drawn_figure(draw_contents, inches))
        return None
    figure = StyledFigure(figsize=inches, free_height=is_free)
    draw_contents(figure)
    adapt_to_dark_style(figure)
    return figure


def check_alone(path: object, size: object) -> None:
    """Refuse a file and a size for a picture in axes that a user gives, because these axes determine both.

    Raises:
        ValueError: when ``path`` or ``size`` is not None.
    """
    if path is not None or size is not None:
        raise ValueError("ax: axes that are there have their size, and their figure writes the file")


def draw_or_refuse(draw_contents: DrawContents, figure: Figure) -> None:
    """Draw on a figure, or refuse a figure with too little room for its contents.

    The error names a sufficient height, or says that the figure must be wider.

    Raises:
        ValueError: when there is too little room.
    """
    lacking = lacking_height(draw_contents, figure)
    if lacking <= 0.0:
        return
    width, height = map(float, figure.get_size_inches())
    least_height = float(least_figure(draw_contents, width, height, lacking=lacking).get_figheight())
    raise NoRoomError(
        width, height, f"at least {least_height:g} high, or the picture must have fewer panels", least_height
    )


def fitting_figure(draw_contents: DrawContents, width: float, usual_size: tuple[float, float]) -> Figure:
    """Return a figure of a given width [inches] with the height that its contents need.

    The first height that is tried is that of ``usual_size`` (width and height [inches]); for a width between
    TWO_COLUMN_WIDTH and the usual width, a lower one; at most TALL, and SLENDER × ``width``. If the first
    height is too low for the contents, the result is that of ``least_figure``, which tries greater heights.
    If this figure is higher than the largest first height, the axes may be lower (FLAT_AXES_HEIGHT).

    Raises:
        ValueError: when no tried height is enough.
    """
    height = usual_size[1] * (1.0 if width < TWO_COLUMN_WIDTH else math.sqrt(min(1.0, width / usual_size[0])))
    most_height = max(LEAST_SIZE, min(TALL, SLENDER * width))
    height = min(max(LEAST_SIZE, height), most_height)
    with suppress(NoRoomError):
        return figure_at_least(draw_contents, width, height, USUAL_AXES_HEIGHT, most_height)
    return figure_at_least(draw_contents, width, most_height, FLAT_AXES_HEIGHT)


def figure_at_least(
    draw_contents: DrawContents, width: float, height: float, mean: float, most_height: float = math.inf
) -> Figure:
    """Return a figure with a width and a height [inches], or the higher one that its contents need.

    ``mean`` is as in ``lacking_height``, ``most_height`` as in ``least_figure``.

    Raises:
        NoRoomError: when no tried height is enough.
    """
    figure = StyledFigure(figsize=(width, height), dpi=DPI, free_height=True)
    lacking = lacking_height(draw_contents, figure, mean)
    if lacking <= 0.0:
        return figure
    return least_figure(
        draw_contents, width, height, mean, lacking, most_height=most_height, free_height=True
    )


def least_figure(
    draw_contents: DrawContents,
    width: float,
    height: float,
    mean: float = 0.0,
    lacking: float = math.inf,
    *,
    most_height: float = math.inf,
    free_height: bool = False,
) -> Figure:
    """Return the lowest figure with room for its contents; its height is found by bisection.

    ``height`` [inches] is too low. The possible heights are ``height``, rounded up to a multiple of
    HEIGHT_STEP, plus 1, 2, … or MOST_HEIGHT_STEPS − 1 times HEIGHT_STEP, up to ``most_height`` [inches].
    ``mean`` is as in ``lacking_height``. ``lacking`` is the result of ``lacking_height`` at ``height``, inf
    if unknown. ``free_height`` is as in ``StyledFigure``.

    Raises:
        NoRoomError: when no possible height is enough.
    """
    heights = HEIGHT_STEP * (math.ceil(height / HEIGHT_STEP) + np.arange(1, MOST_HEIGHT_STEPS))
    heights = heights[heights <= most_height]
    # all heights up to the index ``low`` are too low, and all from the index ``high`` on are enough
    low, high, found_figure = -1, len(heights), None
    while high - low > 1:
        # The next guess follows from the lack of height at the last guess, if this lack is known and not 0.
        # Else the next guess is the middle between ``low`` and ``high``; but the height ``most_height`` comes
        # first, because often no height up to it is enough.
        is_known = lacking != 0.0 and math.isfinite(lacking)
        middle = high - 1 if found_figure is None and math.isfinite(most_height) else (low + high) // 2
        guess = int(heights.searchsorted(height + lacking)) if is_known else middle
        k = min(max(guess, low + 1), high - 1)
        height = float(heights[k])
        figure = StyledFigure(figsize=(width, height), dpi=DPI, free_height=free_height)
        lacking = lacking_height(draw_contents, figure, mean)
        if lacking > 0.0:
            low = k
            continue
        high, found_figure = k, figure
        if -HEIGHT_STEP < lacking < 0.0:  # at the next lower height the figure would lack height
            break
    if found_figure is None:
        raise NoRoomError(width, height, "wider for the panels")
    return found_figure


@drawing_style()
def lacking_height(draw_contents: DrawContents, figure: Figure, mean: float = 0.0) -> float:
    """Draw on a figure; return the height [inches] that the figure lacks for its axes to be high enough.

    A result of at most 0 means that the figure has room. The result inf means that the lack is not known:
    there is no room for axes at all, or the axes are high enough, but texts are cut off or overlap.

    Axes count if they have a label along y, of their own or shared (``framed_panels``), or a heading
    (``headings.name_above``), except a FRAME, and axes whose title is MAY_BE_LOW. They are high enough if

    - each has at least LEAST_AXES_HEIGHT,
    - their mean height, with their headings, is at least ``mean`` [inches], and
    - ``mean`` is 0, or rows have room (``lacking_for_rows``).
    """
    with warnings.catch_warnings(), suppress(UserWarning):
        warnings.filterwarnings("error", "constrained_layout not applied")
        draw_contents(figure)
        if not isinstance(figure.get_layout_engine(), PlaceHolderLayoutEngine):
            figure.draw_without_rendering()
        framed = list(framed_panels(figure))
        named_axes = [
            axes for axes in figure.axes if axes.get_ylabel() or has_heading(axes) or axes in framed
        ]
        named_axes = [axes for axes in named_axes if axes.get_gid() != FRAME]
        named_axes = [axes for axes in named_axes if axes.title.get_gid() != MAY_BE_LOW]
        sides = np.array([height_with_heading(axes) / figure.dpi for axes in named_axes])
        lacking = (
            len(sides) * max(LEAST_AXES_HEIGHT - sides.min(), mean - sides.mean()) if len(sides) else 0.0
        )
        if mean:
            lacking = max(lacking, sum(map(lacking_for_rows, figure.axes)))
        if lacking > 0.0:
            return float(lacking)
        boxes = list(text_boxes(figure))
        whole_box = Bbox.union([figure.bbox, *boxes])
        is_within = (np.abs(whole_box.get_points() - figure.bbox.get_points()) <= OVERLAP_TOLERANCE).all()
        if is_within and not any(
            first.padded(-OVERLAP_TOLERANCE).overlaps(second_box)
            for first, second_box in combinations(boxes, 2)
        ):
            return float(lacking)
    return math.inf


def text_boxes(figure: Figure) -> Iterator[Bbox]:
    """Yield the rectangles [pixels] of a figure's texts, and of legends, headings and labels of axes.

    The numbers at axes count as labels.
    """
    texts, legends = list(figure.texts), [legend for axes in figure.axes if (legend := axes.get_legend())]
    yield from (legend.get_window_extent() for legend in legends)
    for axes in figure.axes:
        texts += [axes.xaxis.label, axes.yaxis.label, *([axes.title] if has_heading(axes) else [])]
        texts += [*numbers_in_view(axes.xaxis), *numbers_in_view(axes.yaxis)]
    yield from (text.get_window_extent() for text in texts if text.get_text())


def numbers_in_view(axis: Axis) -> list[Text]:
    """Return the numbers at an axis between its ends; matplotlib also keeps numbers beyond the ends."""
    axis_index = int(isinstance(axis, YAxis))
    low, high = sorted(axis.get_view_interval())
    slack = LIMIT_ROUND_OFF * (high - low)
    texts = filter(Text.get_text, axis.get_majorticklabels())
    return [text for text in texts if low - slack <= text.get_position()[axis_index] <= high + slack]


def settle(figure: Figure, scaled_axes: Axes | None = None) -> None:
    """Arrange a figure: break legends above axes into rows, and labels longer than their axes into lines.

    Numbers along x that would overlap are left out. The axes ``scaled_axes`` get equal scales along x and y
    after the layout.
    """
    engine = figure.get_layout_engine()
    fit_legends(figure)
    for _ in range(SETTLINGS):
        if scaled_axes is not None:
            scaled_axes.set_aspect("auto")
        if engine is not None:
            engine.execute(figure)
        if scaled_axes is not None:
            scaled_axes.set_aspect("equal")
            scaled_axes.apply_aspect()
        is_changed = break_labels(figure)
        if not (fit_legends(figure) or is_changed):
            return


def look_like_one(first_box: Bbox, second_box: Bbox) -> bool:
    """Return whether two successive numbers of an x axis overlap, or are so close that they read as one.

    ``first_box`` is the rectangle of the left number, ``second_box`` that of the right number, both in
    pixels.
    """
    return bool(first_box.x1 + TICK_SPACE * first_box.height > second_box.x0)


def break_labels(figure: Figure, wanted_axes: Sequence[Axes] | None = None) -> bool:
    """Break labels that are longer than their axes, and thin out overlapping numbers along x.

    Along x, a label may be LABEL_RATIO, but is also broken if it would reach beyond the figure's edges.
    ``wanted_axes``: the axes, by default all axes of the figure. Returns whether the text of a label has
    changed.
    """
    earlier_labels = labels_of(figure)
    for axes in figure.axes if wanted_axes is None else wanted_axes:
        panel_box = axes.get_window_extent()
        if has_heading(axes):
            axes.title.set_text(axes.title.get_text().replace("\n", " "))
            break_lines(axes.title, panel_box.width, COMMA)
        label = axes.yaxis.label
        for separator, broken in ((" [", "\n["), (".", ".\n")):
            text = label.get_text()
            if label.get_window_extent().height > panel_box.height and broken not in text:
                label.set_text(text.replace(separator, broken, 1))
        if label.get_window_extent().height > panel_box.height:
            label.set_fontsize("small")
        thin_ticks(axes)
        label, middle = axes.xaxis.label, 0.5 * (panel_box.x0 + panel_box.x1)
        # the label is centred on its axes, and must not reach beyond the figure's edges
        edge = EDGE_MARGIN * figure.dpi
        longest_label = min(
            LABEL_RATIO * panel_box.width, 2.0 * (middle - edge), 2.0 * (figure.bbox.x1 - edge - middle)
        )
        if label.get_window_extent().width > longest_label:
            label.set_text(label.get_text().replace("\n", " "))
            break_lines(label, longest_label, "; ")
    return labels_of(figure) != earlier_labels


def thin_ticks(axes: Axes) -> None:
    """Give axes fewer numbers along x if the numbers overlap; if still necessary, every second or so.

    The number nearest to 0 stays if two numbers have room beside each other; else both ends have numbers.

    Only axes with ticks from a MaxNLocator, as by default, are changed.
    """
    if not isinstance(axes.xaxis.get_major_locator(), MaxNLocator) or not numbers_meet(axes.xaxis):
        return
    axes.locator_params(axis="x", nbins=LEAST_TICKS, min_n_ticks=LEAST_TICKS, steps=COARSE_STEPS)
    if numbers_meet(axes.xaxis):
        texts = numbers_in_view(axes.xaxis)
        ticks, names = [float(text.get_position()[0]) for text in texts], [text.get_text() for text in texts]
        zero_index = int(np.abs(ticks).argmin())
        for step in range(2, len(ticks)):
            kept_names = [name * ((k - zero_index) % step == 0) for k, name in enumerate(names)]
            axes.set_xticks(ticks, kept_names)
            if sum(map(bool, kept_names)) > 1 and not numbers_meet(axes.xaxis):
                return
        axes.set_xticks(ticks, [names[0], *[""] * (len(names) - 2), names[-1]])


def numbers_meet(axis: Axis) -> bool:
    """Return whether two neighbouring numbers at an x axis overlap or nearly touch."""
    boxes = [text.get_window_extent() for text in numbers_in_view(axis)]
    return any(map(look_like_one, boxes, boxes[1:]))


def labels_of(figure: Figure) -> list[str]:
    """Return the labels of all horizontal and vertical axes of a figure, and the titles of the axes."""
    texts = (text for axes in figure.axes for text in (axes.xaxis.label, axes.yaxis.label, axes.title))
    return [text.get_text() for text in texts]
