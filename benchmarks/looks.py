"""The colours and marks of the contenders in charts; the style is the package's."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from chain_impact.pictures.drawing import style
from chain_impact.pictures.drawing.style import BLACK, BLUE, GREEN, PURPLE, VERMILLION

OURS, LIGHT_BLUE = VERMILLION, "#56b4e9"
STYLE = style.STYLE | {"axes.grid": True, "axes.titlesize": "medium"}
WIDTH = 190.0 / 25.4  # [inch] of a chart: that of a printed page, so that its text has the size of pictures
LOOKS = {
    "chain-impact": (OURS, "o", "-"),
    "chain-impact, FMU": (OURS, "s", "--"),
    "kernel alone": (OURS, ".", ":"),
    "SciPy DOP853": (BLUE, "s", "-"),
    "numbalsoda DOP853": (GREEN, "D", "-"),
    "CVODE Adams": (PURPLE, "v", "-"),
    "heyoka": (BLACK, "^", "-"),
}
"""Colour, mark and line of each contender."""


def look(name: str) -> dict[str, Any]:
    """Return the style of a contender's curve."""
    return strong(name == "chain-impact", *LOOKS[name])


def strong(ours: bool, colour: Any, marker: str, line: str = "-") -> dict[str, Any]:
    """Return the style of a curve; that of ``ours`` is bolder than the others, and drawn above them."""
    bold = {"linewidth": 2.4, "zorder": 3} if ours else {"linewidth": 1.2, "zorder": 2}
    return {"color": colour, "marker": marker, "linestyle": line, "markersize": 4.5, **bold}


def highest_first(panels: Iterable[Any]) -> list[Any]:
    """Return the labelled lines of panels with logarithmic vertical axes, one for each label, for a legend.

    The first is the line whose mean height in the panels is the largest.
    """
    found: dict[str, tuple[Any, list[float]]] = {}
    for axes in panels:
        low, high = np.log(axes.get_ylim())
        for line in axes.lines:
            values = np.log(np.asarray(line.get_ydata(), float))
            if np.isfinite(values).any() and not line.get_label().startswith("_"):
                heights = found.setdefault(line.get_label(), (line, []))[1]
                heights.append(float(np.nanmean((values - low) / (high - low))))
    return [line for line, heights in sorted(found.values(), key=lambda each: -np.mean(each[1]))]
