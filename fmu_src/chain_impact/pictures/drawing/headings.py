"""Headings of axes: the name of what axes show, above them in place of a label beside them."""

from __future__ import annotations

from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes

# the matplotlib identifier (gid) of headings whose height counts for the height of their axes
HEIGHT_COUNTS = "height counts"
# the gid of headings whose axes may be lower than other axes, as those of residuals below their values
MAY_BE_LOW = "may be low"


def name_above(axes: Axes, name: str, **look: Any) -> None:
    """Write the name of what axes show as a heading above the axes, at their left edge.

    There a long name has room; ``break_labels`` breaks it into lines that are as long as the axes are wide.
    ``look``: keywords of matplotlib's ``set_title``; by default the font has the size of labels.
    """
    look = {"fontsize": mpl.rcParams["axes.labelsize"]} | look
    axes.set_title(name, x=0.0, ha="left", ma="left", **look)


def has_heading(axes: Axes) -> bool:
    """Return whether axes have a heading from ``name_above``."""
    return bool(axes.get_title()) and axes.title.get_horizontalalignment() == "left"


def height_with_heading(axes: Axes) -> float:
    """Return the height [pixels] of axes, up to the top of the heading if this has HEIGHT_COUNTS."""
    top = axes.title.get_window_extent().y1 if axes.title.get_gid() == HEIGHT_COUNTS else axes.bbox.y1
    return float(top - axes.bbox.y0)
