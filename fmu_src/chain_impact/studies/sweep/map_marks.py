"""Marks in a map of a sweep: the scene's own values, and cells of runs without an impact."""

# Tests: studies/sweep/maps.py

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.patheffects import Normal, Stroke

from chain_impact.pictures.drawing.dark_ground import COLOURED_GROUND
from chain_impact.studies.sweep.contours import Scale

SCENE_MARK: dict[str, Any] = {"marker": "P", "markersize": 7.0, "color": "white", "markeredgecolor": "black"}
SCENE_MARK |= {"markeredgewidth": 0.9, "linestyle": "", "clip_on": False, "zorder": 5.0, "label": "_"}
"""The mark of the scene's own values in a map, with matplotlib's names."""
HATCHED: dict[str, Any] = {"facecolor": "white", "edgecolor": "0.6", "hatch": "////", "linewidth": 0.0}
"""The look of the cells of runs without an impact, with matplotlib's names."""
NAME_MARGIN = 0.12  # a mark in the outer part NAME_MARGIN of a map has its name beside the edge


def mark_scene(axes: Axes, own: Sequence[float | None], *, named: bool) -> None:
    """Draw a mark at the scene's values; if ``named``, with the word "scene" above, or below at the top."""
    axes.plot(*np.array(own, float)[:, None], **SCENE_MARK)
    if not named:
        return
    across, up = axes.transAxes.inverted().transform(axes.transData.transform(np.array(own, float)))
    ha = "left" if across < NAME_MARGIN else "right" if across > 1.0 - NAME_MARGIN else "center"
    look: dict[str, Any] = {"color": "white", "fontsize": "x-small", "gid": COLOURED_GROUND, "ha": ha}
    look["path_effects"] = [Stroke(linewidth=1.8, foreground="black"), Normal()]
    side = 1.0 if up < 1.0 - NAME_MARGIN else -1.0
    place: dict[str, Any] = {"textcoords": "offset points", "va": "bottom" if side > 0.0 else "top"}
    axes.annotate("scene", np.array(own, float).tolist(), (0.0, 4.5 * side), **place, **look)


def hatch(axes: Axes, scales: tuple[Scale, Scale], cells: np.ndarray) -> None:
    """Hatch the cells of a map, shape (rows, columns), whose runs have no impact."""
    (left, right), (low, high) = ((scale.edges[:-1], scale.edges[1:]) for scale in scales)
    corners = [
        [(left[k], low[row]), (right[k], low[row]), (right[k], high[row]), (left[k], high[row])]
        for row, k in np.argwhere(cells).tolist()
    ]
    if corners:
        axes.add_collection(PolyCollection(corners, **HATCHED), autolim=False)
