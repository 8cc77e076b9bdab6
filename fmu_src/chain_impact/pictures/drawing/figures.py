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
from matplotlib.figure import Figure
from matplotlib.layout_engine import PlaceHolderLayoutEngine
from matplotlib.transforms import Bbox

from chain_impact.pictures.drawing.axis_labels import break_labels, numbers_in_view
from chain_impact.pictures.drawing.headings import MAY_BE_LOW, has_heading, height_with_heading
from chain_impact.pictures.drawing.legends import fit_legends
from chain_impact.pictures.drawing.picture_files import drawn_figure, save
from chain_impact.pictures.drawing.row_names import lacking_for_rows
from chain_impact.pictures.drawing.shared_names import FRAME, framed_panels
from chain_impact.pictures.drawing.sizes import LEAST_SIZE, Size, figure_size
from chain_impact.pictures.drawing.style import (
    DPI,
    FULL_WIDTH,
    TWO_COLUMN_WIDTH,
    StyledFigure,
    adapt_to_dark_style,
    drawing_style,
    type_for,
)

FIGURE_SIZE = (FULL_WIDTH, 5.4)  # [inch] the default width and height of a figure
PANEL_HEIGHT = 1.9  # [inch] the usual height of a panel over time, with its legend and numbers
LEAST_AXES_HEIGHT = 0.3  # [inch] the least height of axes with a label along y
# [inch] the least mean height of the axes with a label along y, if the user gives no height
USUAL_AXES_HEIGHT = 1.0
TALL = 7.75  # [inch] the largest wanted height of a figure: a printed page also has room for a caption
SLENDER = 1.6  # the largest wanted height of a figure, relative to its width
FLAT_AXES_HEIGHT = 0.7  # [inch] the least mean height of the axes if a figure would be higher than wanted
SETTLINGS = 3  # how often, at most, a figure is arranged: a label or legend that is broken changes the layout
OVERLAP_TOLERANCE = 1.0  # [pixels] the largest distance by which texts may reach beyond the figure or overlap
# If a figure is too low, greater heights are tried: the height of the figure, rounded up to a multiple of
# HEIGHT_STEP [inch], plus 1, 2, … or MOST_HEIGHT_STEPS − 1 times HEIGHT_STEP.
HEIGHT_STEP, MOST_HEIGHT_STEPS = 0.25, 40
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
    with type_for(usual_size[0] if size is None else figure_size(size)[0]):
        return _draw_in_type(draw_contents, path, size, usual_size)


def _draw_in_type(
    draw_contents: DrawContents,
    path: str | os.PathLike[str] | None,
    size: Size | None,
    usual_size: tuple[float, float],
) -> Figure | None:
    """Draw a figure as ``draw_figure`` does, with the settings of text in use."""
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
    if height < most_height:
        with suppress(NoRoomError):
            return figure_at_least(draw_contents, width, height, [USUAL_AXES_HEIGHT], most_height)
        return figure_at_least(draw_contents, width, most_height, [FLAT_AXES_HEIGHT])
    return figure_at_least(draw_contents, width, most_height, [USUAL_AXES_HEIGHT, FLAT_AXES_HEIGHT])


def figure_at_least(
    draw_contents: DrawContents,
    width: float,
    height: float,
    means: Sequence[float],
    most_height: float = math.inf,
) -> Figure:
    """Return a figure with a width and a height [inches], or the higher one that its contents need.

    One of ``means``, each as in ``lacking_height``, is enough at the given height, and the last one at a
    greater height. ``most_height`` is as in ``least_figure``.

    Raises:
        NoRoomError: when no tried height is enough.
    """
    figure = StyledFigure(figsize=(width, height), dpi=DPI, free_height=True)
    lacks = lacking_heights(draw_contents, figure, means)
    if min(lacks) <= 0.0:
        return figure
    return least_figure(
        draw_contents, width, height, means[-1], lacks[-1], most_height=most_height, free_height=True
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
    # After a known lack of height, the guesses go up from ``low`` by 1, 2, 4, … entries of ``heights`` while
    # texts still overlap. ``step`` is the next of these numbers; 0 before the first known lack.
    step = 0
    while high - low > 1:
        # The next guess follows from the lack of height at the last guess, if this lack is known and not 0.
        # Else the next guess is the middle between ``low`` and ``high``; but the height ``most_height`` comes
        # first, because often no height up to it is enough. After a known lack, only a little height lacks.
        if lacking != 0.0 and math.isfinite(lacking):
            guess, step = int(heights.searchsorted(height + lacking)), 1
        elif found_figure is not None:
            guess = (low + high) // 2
        elif math.isfinite(most_height):
            guess = high - 1
        elif step:
            guess, step = low + step, 2 * step
        else:
            guess = (low + high) // 2
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
    return lacking_heights(draw_contents, figure, [mean])[0]


@drawing_style()
def lacking_heights(draw_contents: DrawContents, figure: Figure, means: Sequence[float]) -> list[float]:
    """Draw on a figure once; return the result of ``lacking_height`` for each of several mean heights."""
    with warnings.catch_warnings(), suppress(UserWarning):
        warnings.filterwarnings("error", "constrained_layout not applied")
        draw_contents(figure)
        if not isinstance(figure.get_layout_engine(), PlaceHolderLayoutEngine):
            figure.draw_without_rendering()
        lacks = [lacking_for_axes(figure, mean) for mean in means]
        if min(lacks) > 0.0 or texts_have_room(figure):
            return lacks
        return [lacking if lacking > 0.0 else math.inf for lacking in lacks]
    return [math.inf for _ in means]


def lacking_for_axes(figure: Figure, mean: float) -> float:
    """Return the height [inches] that a drawn figure lacks for its axes, with ``mean`` of lacking_height."""
    framed = list(framed_panels(figure))
    named_axes = [axes for axes in figure.axes if axes.get_ylabel() or has_heading(axes) or axes in framed]
    named_axes = [axes for axes in named_axes if axes.get_gid() != FRAME]
    named_axes = [axes for axes in named_axes if axes.title.get_gid() != MAY_BE_LOW]
    sides = np.array([height_with_heading(axes) / figure.dpi for axes in named_axes])
    lacking = len(sides) * max(LEAST_AXES_HEIGHT - sides.min(), mean - sides.mean()) if len(sides) else 0.0
    if mean:
        lacking = max(lacking, sum(map(lacking_for_rows, figure.axes)))
    return float(lacking)


def texts_have_room(figure: Figure) -> bool:
    """Return whether none of the ``text_boxes`` of a drawn figure is cut off or overlaps another one."""
    boxes = list(text_boxes(figure))
    whole_box = Bbox.union([figure.bbox, *boxes])
    is_within = (np.abs(whole_box.get_points() - figure.bbox.get_points()) <= OVERLAP_TOLERANCE).all()
    return bool(is_within) and not any(
        first.padded(-OVERLAP_TOLERANCE).overlaps(second_box) for first, second_box in combinations(boxes, 2)
    )


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
