"""Drawing into axes that a user gives, in the colours of the user's style and within the user's figure."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from chain_impact.pictures.drawing.dark_ground import Ground, is_dark
from chain_impact.pictures.drawing.figures import break_labels
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
    before = {panel: set(panel.findobj()) for panel in grounds}
    for panel in grounds:
        panel.set_facecolor("white")
    try:
        with drawing_style(COLOURS if grounds else {}):
            yield
    finally:
        for panel, ground in grounds.items():
            ground.suit([panel.patch, *(set(panel.findobj()) - before[panel]), panel.xaxis, panel.yaxis])


def fit_into_figure(axes: Sequence[Axes]) -> None:
    """Break legends and labels of axes into lines; make axes whose texts lack room (``_room``) smaller.

    If the figure has a layout engine, the size of the axes stays, because the engine sets it.
    """
    for figure in {figure for panel in axes if (figure := panel.get_figure(root=True)) is not None}:
        own = [panel for panel in axes if panel.get_figure(root=True) is figure]
        figure.draw_without_rendering()
        fit_legends(figure, own)
        break_labels(figure, own)
        if figure.get_layout_engine() is not None:
            figure.draw_without_rendering()
            fit_legends(figure, own)
            continue
        for _ in range(TIMES):
            for panel in own:
                _fit(panel, figure)
            fit_legends(figure, own)


def _fit(axes: Axes, figure: Figure) -> None:
    """Make axes smaller if they or their texts extend beyond their room in a figure (``_room``)."""
    box, room = axes.get_tightbbox(), _room(axes, figure)
    if box is None:
        return
    (left, low), (right, high) = axes.get_position(original=True).transformed(figure.transFigure).get_points()
    width, height = LEAST_PART * (right - left), LEAST_PART * (high - low)
    left, low = left + max(0.0, room.x0 - box.x0), low + max(0.0, room.y0 - box.y0)
    right, high = right - max(0.0, box.x1 - room.x1), high - max(0.0, box.y1 - room.y1)
    if right - left >= width and high - low >= height:
        moved = Bbox([[left, low], [right, high]]).transformed(figure.transFigure.inverted())
        axes.set_position(moved, which="both")


def _room(axes: Axes, figure: Figure) -> Bbox:
    """Return the rectangle [pixels] that axes and their texts may take.

    The rectangle ends TEXT_SPACE before the edges of the figure, and before other axes and their texts that
    are beside, above or below.
    """
    own = axes.get_position(original=True)
    space = TEXT_SPACE * figure.dpi / 72.0
    (left, low), (right, high) = figure.bbox.padded(-space).get_points()
    for other in figure.axes:
        beside, texts = other.get_position(original=True), other.get_tightbbox()
        if other is axes or texts is None:
            continue
        if beside.x0 < own.x1 and own.x0 < beside.x1:
            if beside.y0 >= own.y1:
                high = min(high, texts.y0 - space)
            elif beside.y1 <= own.y0:
                low = max(low, texts.y1 + space)
        elif beside.y0 < own.y1 and own.y0 < beside.y1:
            if beside.x0 >= own.x1:
                right = min(right, texts.x0 - space)
            elif beside.x1 <= own.x0:
                left = max(left, texts.x1 + space)
    return Bbox([[left, low], [right, high]])
