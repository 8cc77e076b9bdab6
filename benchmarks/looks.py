"""How the charts look: colours and marks of the contenders, names at curves; the style is the package's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from chain_impact.results.plots.labels import label_curves, settle, spread_labels
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
    names = {axes: label_curves(axes, ends, fontsize=LINE_NAME) for axes, ends in curves.items()}
    settle(page)
    for axes, texts in names.items():
        spread_labels(axes, texts)
