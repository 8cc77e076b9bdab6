"""Names that many panels share: each is written once, in the middle of a side of a grid of panels."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpecBase

FRAME = "frame"  # the matplotlib identifier (gid) of empty axes that carry the names around a grid of panels
TITLE_HEIGHT = 1.6  # the height that the titles of panels take, relative to the size of their font


def name_around(panels: Sequence[Axes], *, name_below: str, name_beside: str, name_above: str = "") -> None:
    """Write the name of the horizontal axes below a grid of panels, and of the vertical axes at its left.

    ``name_above``: what the titles of the panels tell; it stands above these titles. Only panels at the left
    edge keep numbers along y, and only those at the lower edge, or above an empty place, numbers along x.
    """
    figure, grid = panels[0].get_figure(root=True), grid_of(panels[0])
    assert figure is not None
    assert grid is not None
    for axes in panels:
        cell = axes.get_subplotspec()
        assert cell is not None
        axes.tick_params(which="both", labelleft=cell.is_first_col())
        axes.tick_params(which="both", labelbottom=int(cell.num1) + grid.ncols >= len(panels))
    look = {"frame_on": False, "xticks": [], "yticks": [], "gid": FRAME, "zorder": -1.0}
    frame = figure.add_subplot(grid[:, :], **look)
    frame.set(xlabel=name_below, ylabel=name_beside)
    if name_above:
        size = mpl.font_manager.FontProperties(size=mpl.rcParams["xtick.labelsize"]).get_size_in_points()
        pad = mpl.rcParams["axes.titlepad"] + TITLE_HEIGHT * size
        frame.set_title(name_above, fontsize=mpl.rcParams["axes.labelsize"], pad=pad)
    cells = [(axes, cell) for axes in panels if (cell := axes.get_subplotspec()) is not None]
    figure.align_xlabels([frame, *(axes for axes, cell in cells if cell.is_last_row())])
    figure.align_ylabels([frame, *(axes for axes, cell in cells if cell.is_first_col())])


def grid_of(axes: Axes) -> GridSpecBase | None:
    """Return the grid in which axes stand; None for axes without a grid."""
    cell = axes.get_subplotspec()
    return None if cell is None else cell.get_gridspec()


def framed_panels(figure: Figure) -> Iterator[Axes]:
    """Yield the panels that share names with others."""
    frames = [axes for axes in figure.axes if axes.get_gid() == FRAME]
    grids = [grid_of(frame) for frame in frames]
    yield from (axes for axes in figure.axes if grid_of(axes) in grids and axes not in frames)
