"""How all pictures look: fonts, colours that the colour-blind can tell apart, the headline."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from chain_impact.results.recording import written_whole

BLACK, ORANGE, SKY, GREEN = "#000000", "#e69f00", "#56b4e9", "#009e73"
BLUE, VERMILLION, PURPLE, BROWN = "#0072b2", "#d55e00", "#cc79a7", "#7a4b2a"
PALETTE = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY)
"""For what is told apart by colour. Okabe and Ito, Color Universal Design (2008), without their yellow, which
is too pale on white, and without black."""
GREY, PALE, INK = "0.72", "0.9", "0.25"
"""Curves in the background; lines of a grid; text and outlines."""
# viridis without its end, which is too pale on white
TIME_COLOURS = LinearSegmentedColormap.from_list("time", mpl.colormaps["viridis"](np.linspace(0.0, 0.85, 64)))

STYLE: Any = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "grid.color": PALE,
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "legend.borderaxespad": 0.2,
    "savefig.facecolor": "white",
}
"""Settings of matplotlib for every picture, for `matplotlib.rc_context`."""
DPI = 160
LEFT, TOP = 0.12, 0.08  # inches from the left and the upper edge of the page to the headline
LINES = (0.3, 0.24)  # inches, the heights of its lines


def headline(page: Figure, message: str, conditions: str = "") -> None:
    """Write what the picture says over it, and below that, smaller, under which conditions."""
    width, height = page.get_size_inches()
    place: dict[str, Any] = {"x": LEFT / width, "ha": "left", "va": "top"}
    page.suptitle(message, y=1.0 - TOP / height, fontsize=12, fontweight="bold", **place, in_layout=False)
    page.text(
        s=conditions, y=1.0 - (TOP + LINES[0]) / height, fontsize=8.5, color=INK, **place, in_layout=False
    )
    top = TOP + LINES[0] + (LINES[1] if conditions else 0.0)
    engine = page.get_layout_engine()
    if isinstance(engine, ConstrainedLayoutEngine):
        engine.set(rect=(0.0, 0.0, 1.0, 1.0 - top / height))


def save(
    path: str | os.PathLike[str], fill: Callable[[Figure], None], size: tuple[float, float] | None = None
) -> None:
    """Draw what ``fill`` draws on an empty page into a file, whose suffix says which kind (png, svg, pdf).

    Raises:
        OSError: when the file cannot be written.
    """
    with written_whole(Path(path)) as fresh:
        page = Figure(figsize=size, dpi=DPI, layout="constrained")
        fill(page)
        page.savefig(fresh, dpi="figure")


def number(value: float, digits: int = 4) -> str:
    """A number with up to so many digits, without zeros that say nothing: 1e8, 2.145e10."""
    return re.sub(r"e\+?(-?)0*", r"e\1", f"{value:.{digits}g}")
