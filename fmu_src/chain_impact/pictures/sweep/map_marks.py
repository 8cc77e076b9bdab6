"""Marks in a map of a sweep: the scene's own values, and cells of runs without an impact; their names."""

# Tests: pictures/sweep/maps.py

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from matplotlib.path import Path
from matplotlib.patheffects import Normal, Stroke
from matplotlib.text import Annotation
from matplotlib.transforms import Bbox

from chain_impact.pictures.drawing.dark_ground import COLOURED_GROUND
from chain_impact.pictures.sweep.contours import Scale

SCENE_MARK: dict[str, Any] = {"marker": "P", "markersize": 7.0, "color": "white", "markeredgecolor": "black"}
SCENE_MARK |= {"markeredgewidth": 0.9, "linestyle": "", "clip_on": False, "zorder": 5.0, "label": "_"}
"""The mark of the scene's own values in a map, with matplotlib's names."""
HATCHED_STYLE: dict[str, Any] = {"facecolor": "white", "edgecolor": "0.6", "hatch": "////", "linewidth": 0.0}
"""The look of the cells of runs in which nothing touches that the map's quantity could measure."""
NARROW_MAP = 25.0 / 25.4  # [inch] in narrower maps, the value of a contour stands in one map only
SCENE_NAME = "scene"  # the name of the mark
# the places of the name in the order in which ``place_names`` tries them: its distance from the mark [points]
# to the right and up, and how it is aligned
NAME_POSITIONS = [
    ((0.0, 4.5), "center", "bottom"),
    ((0.0, -4.5), "center", "top"),
    ((6.0, 0.0), "left", "center"),
    ((-6.0, 0.0), "right", "center"),
    ((4.5, 4.0), "left", "bottom"),
    ((-4.5, 4.0), "right", "bottom"),
    ((4.5, -4.0), "left", "top"),
    ((-4.5, -4.0), "right", "top"),
]


def mark_scene(axes: Axes, own_values: Sequence[float | None], *, is_named: bool) -> None:
    """Draw a mark at the scene's values; if ``is_named``, with the word "scene", see ``place_names``."""
    axes.plot(*np.array(own_values, float)[:, None], **SCENE_MARK)
    if is_named:
        look: dict[str, Any] = {"color": "white", "fontsize": "small", "gid": COLOURED_GROUND}
        look["path_effects"] = [Stroke(linewidth=1.8, foreground="black"), Normal()]
        axes.annotate(
            SCENE_NAME, np.array(own_values, float).tolist(), (0.0, 0.0), textcoords="offset points", **look
        )


def place_names(figure: Figure) -> None:
    """Remove values of contours without room, and move each name of the scene's mark to a free side.

    The layout of the figure must be complete. A value has room if it is inside of its map and covers neither
    another contour nor another value; in maps narrower than NARROW_MAP, each value stands in one map only. A
    name stands inside of the map if it can, where it covers the fewest contours and values. In a map with
    contours, it is hidden if it covers one or reaches beyond the map: the conditions tell the mark.
    """
    numbered_texts = set[str]()
    for axes in figure.axes:
        parts = [part for part in axes.collections if isinstance(part, ContourSet)]
        # value of a contour, as in the map, and a line of this contour
        lines = [
            (f"{next(iter(part.levels)):g}", path.transformed(part.get_transform()))
            for part in parts
            for path in part.get_paths()
        ]
        if parts:
            _remove_crowded_values(axes, lines, numbered_texts)
        for name in axes.texts:
            if isinstance(name, Annotation) and name.get_text() == SCENE_NAME:
                values = [
                    text.get_window_extent() for text in axes.texts if text is not name and text.get_visible()
                ]
                placed_names = []
                for position in NAME_POSITIONS:
                    _put(name, position)
                    box = name.get_window_extent()
                    covered = [box.overlaps(value) for value in values]
                    covered += [line.intersects_bbox(box, filled=False) for _, line in lines]
                    placed_names.append((not _is_inside(axes, box), sum(covered)))
                _put(name, NAME_POSITIONS[placed_names.index(min(placed_names))])
                name.set_visible(not parts or min(placed_names) == (False, 0))


def _is_inside(axes: Axes, box: Bbox) -> bool:
    """Return whether a box lies within the axes, up to round-off."""
    return np.allclose(Bbox.union([axes.bbox, box]).size, axes.bbox.size)


def _remove_crowded_values(axes: Axes, lines: Sequence[tuple[str, Path]], numbered_texts: set[str]) -> None:
    """Hide the values of contours without room in a map; add the others to ``numbered_texts``.

    In a map narrower than NARROW_MAP, a value that ``numbered_texts`` already has is hidden, too.

    ``lines``: for each line of a contour, the value as in the map, and the line in pixels.
    """
    figure = axes.get_figure(root=True)
    assert figure is not None
    is_narrow_map = axes.bbox.width / figure.dpi < NARROW_MAP
    boxes = list[Bbox]()
    for text in axes.texts:
        if isinstance(text, Annotation):
            continue
        box, value = text.get_window_extent(), text.get_text()
        is_crowded = any(box.overlaps(other_box) for other_box in boxes)
        is_crowded |= any(
            line.intersects_bbox(box, filled=False) for line_value, line in lines if line_value != value
        )
        is_repeated = is_narrow_map and value in numbered_texts
        text.set_visible(_is_inside(axes, box) and not is_crowded and not is_repeated)
        if text.get_visible():
            boxes.append(box)
            numbered_texts.add(value)


def _put(name: Annotation, position: tuple[tuple[float, float], str, str]) -> None:
    """Put the name of a mark at one of NAME_POSITIONS."""
    name.xyann, ha, va = position
    name.set(ha=ha, va=va)


def hatch(axes: Axes, scales: tuple[Scale, Scale], cells: np.ndarray) -> None:
    """Hatch those cells of a map, shape (rows, columns), in whose runs nothing touches for its quantity."""
    (left, right), (low, high) = ((scale.edges[:-1], scale.edges[1:]) for scale in scales)
    corners = [
        [(left[k], low[row]), (right[k], low[row]), (right[k], high[row]), (left[k], high[row])]
        for row, k in np.argwhere(cells).tolist()
    ]
    if corners:
        axes.add_collection(PolyCollection(corners, **HATCHED_STYLE), autolim=False)
