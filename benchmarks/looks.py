"""How the charts look: colours and marks of the contenders, names at curves; the style is the package's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.text import Text

from chain_impact.results.plots.labels import settle
from chain_impact.results.plots.style import (  # noqa: F401 - for the charts
    BLACK,
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PURPLE,
    SKY,
    STYLE,
    VERMILLION,
    headline,
    number,
)

OURS, LINE_NAME = VERMILLION, 8.0  # points, the size of a name at a curve
LINE = 1.25  # of the height of a name, between names one above the other
STYLE = STYLE | {"axes.grid": True}
PYTHON = ":"  # the line of who is driven from Python, whose marks are hollow
LOOKS = {
    "ours": (OURS, "o", "-"),
    "ours, simulate()": (OURS, "o", PYTHON),
    "numbalsoda DOP853": (BLUE, "s", "-"),
    "CVODE Adams": (PURPLE, "v", "-"),
    "CVODE BDF": (BLACK, "P", "-"),
    "heyoka": (ORANGE, "^", "-"),
    "scipy DOP853": (BLUE, "s", PYTHON),
    "scipy LSODA": (GREEN, "D", PYTHON),
    "NumPy, scipy DOP853": ("0.5", "h", PYTHON),
}
"""Colour, mark and line of each contender; the two of one method share a colour."""
QUIET = {"color": GREY, "linewidth": 0.8, "zorder": 1}


def look(name: str) -> dict[str, Any]:
    """How a contender is drawn."""
    hollow = {"markerfacecolor": "white"} if LOOKS[name][2] == PYTHON else {}
    return strong(name == "ours", *LOOKS[name]) | hollow


def strong(ours: bool, colour: Any, marker: str, line: str = "-") -> dict[str, Any]:
    """How a curve is drawn; ours is bolder than others, and above them."""
    bold = {"linewidth": 2.4, "zorder": 3} if ours else {"linewidth": 1.2, "zorder": 2}
    return {"color": colour, "marker": marker, "linestyle": line, "markersize": 4.5, **bold}


def label(name: str) -> str:
    """What a contender is called in a chart."""
    return name.replace("ours", "chain-impact") if name.startswith("ours") else name


def curve(axes: Any, points: Sequence[tuple], drawn: Mapping[str, Any], text: str) -> tuple:
    """Draw a curve; return where its name goes, for ``names_at_ends``."""
    axes.loglog(*zip(*points, strict=True), **drawn)
    return *max(points), text, drawn["color"]


def names_at_ends(page: Any, curves: Mapping[Any, Sequence[tuple[float, float, str, Any]]]) -> None:
    """Write the names of curves beside them, once all is drawn: axes → x, y, name and colour of each."""
    names = {axes: [_name(axes, *end) for end in ends] for axes, ends in curves.items()}
    settle(page)
    for axes, texts in names.items():
        _spread(axes, texts)


def _name(axes: Any, x: float, y: float, name: str, colour: Any) -> Any:
    """The name of a curve to the right of the axes, with a line to the curve."""
    line = {"arrowstyle": "-", "color": colour, "linewidth": 0.7, "shrinkA": 1.0, "shrinkB": 0.0}
    line["relpos"] = (0.0, 0.5)  # it ends left of its name, so it crosses no other
    style = {"color": colour, "va": "center", "arrowprops": line, "fontsize": LINE_NAME}
    return axes.annotate(name, (x, y), (1.03, 0.5), textcoords="axes fraction", **style)


def _spread(axes: Any, texts: Sequence[Any]) -> None:
    """Put the names at the height of their curves, or as far above as they do not overlap."""
    box, above = axes.get_window_extent(), -float("inf")
    for text in sorted(texts, key=lambda text: axes.transData.transform(text.xy)[1]):
        gap = LINE * Text.get_window_extent(text).height  # without the line to the curve
        above = max(axes.transData.transform(text.xy)[1], box.y0, above + gap)
        text.set_y((above - box.y0) / box.height)
