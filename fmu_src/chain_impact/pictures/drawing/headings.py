"""Headings of axes: the name of what axes show, above them in place of a label beside them."""

from __future__ import annotations

import matplotlib as mpl
from matplotlib.axes import Axes

# the matplotlib identifier (gid) of headings whose height counts for the height of their axes
HEIGHT_COUNTS = "height counts"


def name_above(axes: Axes, name: str) -> None:
    """Write the name of what axes show as a heading above the axes, at their left edge.

    There a long name has room; ``break_labels`` breaks it into lines that are as long as the axes are wide.
    """
    axes.set_title(name, x=0.0, ha="left", ma="left", fontsize=mpl.rcParams["axes.labelsize"])


def has_heading(axes: Axes) -> bool:
    """Return whether axes have a heading from ``name_above``."""
    return bool(axes.get_title()) and axes.title.get_horizontalalignment() == "left"


def height_with_heading(axes: Axes) -> float:
    """Return the height [pixels] from the lower edge of axes to the top of a heading with HEIGHT_COUNTS."""
    top = axes.title.get_window_extent().y1 if axes.title.get_gid() == HEIGHT_COUNTS else axes.bbox.y1
    return float(top - axes.bbox.y0)
