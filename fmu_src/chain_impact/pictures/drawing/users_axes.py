"""Drawing into axes that a user gives, in the colours of the user's style and within the user's figure."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from chain_impact.pictures.drawing.axis_labels import break_labels
from chain_impact.pictures.drawing.dark_ground import Ground, is_dark
from chain_impact.pictures.drawing.legends import fit_legends
from chain_impact.pictures.drawing.style import COLOURS, drawing_style

TIMES = 3  # number of passes that make axes smaller: a new size can change the space that texts need
# One pass makes axes smaller at most to this part of their width and height; if texts need more space, the
# axes keep their size in this pass.
LEAST_PART = 0.2
TEXT_SPACE = 3.0  # [points] the space between a text and the edge of the figure or the texts of other axes


@contextmanager
def draw_into(axes: Sequence[Axes]) -> Iterator[None]:
    """Let a ``with`` block draw into a user's axes in the user's style.

    If axes have a dark ground, the drawing in these axes gets colours for this ground.
    """
    grounds = {
        panel: Ground(panel.get_facecolor(), panel.xaxis.label.get_color())
        for panel in axes
        if is_dark(panel.get_facecolor())
    }
    earlier_artists = {panel: set(panel.findobj()) for panel in grounds}
    for panel in grounds:
        panel.set_facecolor("white")
    try:
        with drawing_style(COLOURS if grounds else {}):
            yield
    finally:
        for panel, ground in grounds.items():
            ground.suit(
                [panel.patch, *(set(panel.findobj()) - earlier_artists[panel]), panel.xaxis, panel.yaxis]
            )


def fit_into_figure(axes: Sequence[Axes]) -> None:
    """Break legends and labels of axes into lines; make axes whose texts lack room (``_room``) smaller.

    If the figure has a layout engine, the size of the axes stays, because the engine sets it.
    """
    for figure in {figure for panel in axes if (figure := panel.get_figure(root=True)) is not None}:
        own_panels = [panel for panel in axes if panel.get_figure(root=True) is figure]
        figure.draw_without_rendering()
        fit_legends(figure, own_panels)
        break_labels(figure, own_panels)
        if figure.get_layout_engine() is not None:
            figure.draw_without_rendering()
            fit_legends(figure, own_panels)
            continue
        for _ in range(TIMES):
            for panel in own_panels:
                _fit(panel, figure)
            fit_legends(figure, own_panels)


def _fit(axes: Axes, figure: Figure) -> None:
    """Make axes smaller if they or their texts extend beyond their room in a figure (``_room``)."""
    box, room = axes.get_tightbbox(), _room(axes, figure)
    if box is None:
        return
    (left, bottom), (right, top) = (
        axes.get_position(original=True).transformed(figure.transFigure).get_points()
    )
    width, height = LEAST_PART * (right - left), LEAST_PART * (top - bottom)
    left, bottom = left + max(0.0, room.x0 - box.x0), bottom + max(0.0, room.y0 - box.y0)
    right, top = right - max(0.0, box.x1 - room.x1), top - max(0.0, box.y1 - room.y1)
    if right - left >= width and top - bottom >= height:
        moved_box = Bbox([[left, bottom], [right, top]]).transformed(figure.transFigure.inverted())
        axes.set_position(moved_box, which="both")


def _room(axes: Axes, figure: Figure) -> Bbox:
    """Return the rectangle [pixels] that axes and their texts may take.

    The rectangle ends TEXT_SPACE before the edges of the figure, and before other axes and their texts that
    are beside, above or below.
    """
    own_box = axes.get_position(original=True)
    space = TEXT_SPACE * figure.dpi / 72.0
    (left, bottom), (right, top) = figure.bbox.padded(-space).get_points()
    for other_axes in figure.axes:
        other_box, texts = other_axes.get_position(original=True), other_axes.get_tightbbox()
        if other_axes is axes or texts is None:
            continue
        if other_box.x0 < own_box.x1 and own_box.x0 < other_box.x1:
            if other_box.y0 >= own_box.y1:
                top = min(top, texts.y0 - space)
            elif other_box.y1 <= own_box.y0:
                bottom = max(bottom, texts.y1 + space)
        elif other_box.y0 < own_box.y1 and own_box.y0 < other_box.y1:
            if other_box.x0 >= own_box.x1:
                right = min(right, texts.x0 - space)
            elif other_box.x1 <= own_box.x0:
                left = max(left, texts.x1 + space)
    return Bbox([[left, bottom], [right, top]])
