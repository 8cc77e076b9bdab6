"""The colours and marks of the contenders in charts; the style is the package's."""

from __future__ import annotations

from typing import Any

from chain_impact.pictures import style
from chain_impact.pictures.style import BLACK, BLUE, GREEN, PURPLE, VERMILLION

OURS = VERMILLION
STYLE = style.STYLE | {"axes.grid": True}
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
    """Return the style of a curve; ours is bolder than the others, and above them."""
    bold = {"linewidth": 2.4, "zorder": 3} if ours else {"linewidth": 1.2, "zorder": 2}
    return {"color": colour, "marker": marker, "linestyle": line, "markersize": 4.5, **bold}
