"""The headline of a picture, the conditions below it, and the texts at its foot."""

from __future__ import annotations

from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.text import Text
from matplotlib.transforms import Transform, blended_transform_factory

from chain_impact.pictures.drawing.colours import INK
from chain_impact.pictures.drawing.line_breaks import COMMA, break_lines
from chain_impact.pictures.drawing.style import is_narrow

# [inch] distance of the headline from the left and the upper edge of the figure
LEFT_MARGIN, TOP_MARGIN = 0.12, 0.08
# [inch] GAP: space below the headline, and below the conditions; LINE_GAP: space between two of the coloured
# lines below the headline
GAP, LINE_GAP = 0.09, 0.02
# conditions are left out if they and the headline together would be higher than this part of the figure
MOST_HEAD = 0.33
# The largest height of all texts at the foot, relative to the height of the figure. FREE_FOOT: if the
# contents determine the height of the figure; MOST_FOOT: otherwise.
MOST_FOOT, FREE_FOOT = 0.15, 0.25


def write_headline(figure: Figure, message: str, conditions: str = "", *lines: tuple[str, str]) -> None:
    """Write ``message`` above the picture and, in a smaller font below it, ``conditions``.

    ``lines`` are pairs of a text and its colour; they stand between message and conditions.
    All texts are broken at the edge of the figure. In a narrow figure the conditions stand at the foot.
    Without room for all of them, none is written (MOST_HEAD, ``write_foot``).
    """
    width, height = figure.get_size_inches()
    placement: dict[str, Any] = {"x": LEFT_MARGIN / width, "ha": "left", "in_layout": False}
    title = figure.suptitle(message, y=1.0 - TOP_MARGIN / height, va="top", **placement)
    break_lines(title, (width - 2.0 * LEFT_MARGIN) * figure.dpi, COMMA, 0)
    top = TOP_MARGIN + title.get_window_extent().height / figure.dpi + GAP
    for text, colour in lines:
        look: dict[str, Any] = {"fontsize": "small", "color": colour, "va": "top"}
        line = figure.text(
            s=fitted_lines(figure, text), y=1.0 - (top - 0.5 * GAP) / height, **placement, **look
        )
        top += line.get_window_extent().height / figure.dpi + LINE_GAP
    if conditions and is_narrow(figure):
        write_foot(figure, conditions)
    elif conditions:
        text_style: dict[str, Any] = {"fontsize": "small", "color": INK, "va": "top"}
        lines_below = figure.text(
            s=fitted_lines(figure, conditions), y=1.0 - top / height, **placement, **text_style
        )
        room = lines_below.get_window_extent().height / figure.dpi + GAP
        if top + room <= MOST_HEAD * height:
            top += room
        else:
            lines_below.remove()
    reserve_margins(figure, top / height, 0.0)


def fitted_lines(figure: Figure, text: str, more_lines: int = 1) -> str:
    """Return a text in lines that fit between the margins of a figure in a small font.

    ``more_lines`` is as in ``break_lines``.
    """
    probe = figure.text(0.0, 0.0, text, fontsize="small")
    break_lines(probe, (figure.get_figwidth() - 2.0 * LEFT_MARGIN) * figure.dpi, more_lines=more_lines)
    probe.remove()
    return str(probe.get_text())


def write_foot(figure: Figure, text: str, most_share: float | None = None) -> Text | None:
    """Write a text at the foot of a figure, above earlier texts there; return matplotlib's object for it.

    A text without room is left out, and None is returned. All texts at the foot together take at most the
    fraction ``most_share`` of the figure's height; by default FREE_FOOT if the contents of the figure
    determine this height, else MOST_FOOT.
    """
    if most_share is None:
        most_share = FREE_FOOT if getattr(figure, "free_height", False) else MOST_FOOT
    (width, height), foot_height = figure.get_size_inches(), foot_of(figure)
    text_style: dict[str, Any] = {"fontsize": "small", "color": INK, "va": "bottom", "in_layout": False}
    foot = figure.text(LEFT_MARGIN / width, foot_height + 0.5 * GAP / height, "", **text_style)
    for more_lines in (1, 0):
        foot.set_text(fitted_lines(figure, text, more_lines))
        room = (foot.get_window_extent().height / figure.dpi + GAP) / height
        if foot_height + room <= most_share:
            reserve_margins(figure, 0.0, foot_height + room)
            return foot
    foot.remove()
    return None


def foot_of(figure: Figure) -> float:
    """Return the height that is reserved for texts at the foot, relative to the height of the figure.

    The result is 0 if the figure's layout is not constrained.
    """
    return _layout_box(figure)[1]


def head_of(figure: Figure) -> float:
    """Return the height that is reserved for texts at the head, relative to the height of the figure.

    The result is 0 if the figure's layout is not constrained.
    """
    _, bottom, _, height = _layout_box(figure)
    return 1.0 - (bottom + height)


def _layout_box(figure: Figure) -> tuple[float, float, float, float]:
    """Return the box in which the axes of a figure are arranged: left, bottom, width, height.

    All are relative to the size of the figure. The box is the whole figure if its layout is not constrained.
    """
    engine = figure.get_layout_engine()
    if not isinstance(engine, ConstrainedLayoutEngine):
        return 0.0, 0.0, 1.0, 1.0
    left, bottom, width, height = engine.get()["rect"]
    return float(left), float(bottom), float(width), float(height)


def _set_layout_box(figure: Figure, box: tuple[float, float, float, float]) -> None:
    """Set the box of ``_layout_box``; nothing happens if the figure's layout is not constrained."""
    engine = figure.get_layout_engine()
    if isinstance(engine, ConstrainedLayoutEngine):
        engine.set(rect=box)


def reserve_margins(figure: Figure, top: float, bottom: float) -> None:
    """Keep at least the fractions ``top`` and ``bottom`` of a figure's height free above and below its axes.

    Nothing happens if the figure's layout is not constrained.
    """
    left, bottom_edge, width, height = _layout_box(figure)
    top_edge = min(bottom_edge + height, 1.0 - top)
    bottom_edge = max(bottom_edge, bottom)
    _set_layout_box(figure, (left, bottom_edge, width, top_edge - bottom_edge))


def start_at_headline(figure: Figure) -> None:
    """Let nothing beside the axes of a figure start farther left than the headline.

    Nothing happens if the figure's layout is not constrained.
    """
    left, bottom_edge, width, height = _layout_box(figure)
    shift = (LEFT_MARGIN - mpl.rcParams["figure.constrained_layout.w_pad"]) / figure.get_figwidth() - left
    _set_layout_box(figure, (left + shift, bottom_edge, width - shift, height))


def start_left(axes: Axes, text: Text, upward: Transform | None = None) -> None:
    """Let a text start at the left edge of its axes or, in a narrow figure, below the start of the headline.

    ``upward``: the transform of the text's vertical position; by default that of a title of the axes.
    """
    figure = axes.get_figure(root=True)
    assert figure is not None
    is_small = is_narrow(figure)
    offset: Any = axes.titleOffsetTrans  # type: ignore[attr-defined]  # matplotlib's type lacks it
    text.set_x(LEFT_MARGIN / figure.get_figwidth() if is_small else 0.0)
    horizontal = figure.transFigure if is_small else axes.transAxes
    text.set_transform(blended_transform_factory(horizontal, upward or axes.transAxes + offset))
