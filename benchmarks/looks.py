"""The colours and marks of the contenders in charts; the style is the package's."""

from __future__ import annotations

from collections import Counter
from collections.abc import Container, Iterable, Iterator, Sequence
from itertools import cycle, pairwise, product
from typing import Any

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.patheffects import withStroke
from matplotlib.transforms import Bbox

from chain_impact.pictures.drawing import style
from chain_impact.pictures.drawing.colours import BLACK, BLUE, GREEN, PURPLE, VERMILLION

OUR_COLOUR, LIGHT_BLUE = VERMILLION, "#56b4e9"
STYLE = style.STYLE | {"axes.grid": True, "axes.titlesize": "medium"}
WIDTH = 190.0 / 25.4  # [inch] of a chart: that of a printed page, so that its text has the size of pictures
# Names at curves: OFFSETS: distances from a point [points]; CLEAR: enough distance from other curves [inch];
# SAMPLES of a piece of a curve; DARKENED: brightness of a name, in its colour; SIDES: right, above
# OVERLAP: the least distance from a curve, which has markers, and from the edges of the panel [points]
OFFSETS, CLEAR, SAMPLES, DARKENED, OVERLAP = (4.5, 8.0, 12.0, 16.0), 0.2, 30, 0.8, 3.0
SIDES = ((0, 1), (0, -1), (1, 1), (-1, 1), (1, -1), (-1, -1), (1, 0), (-1, 0))
HALO = [withStroke(linewidth=3.0, foreground="white")]
"""The ground around the letters of a name, which interrupts the lines of the grid behind it."""
Place = tuple[Any, np.ndarray, np.ndarray, Bbox]
"""The place of a name: its axes, a point of its curve [pixels], shift [points] and rectangle [pixels]."""
LOOKS = {
    "chain-impact": (OUR_COLOUR, "o", "-"),
    "chain-impact, FMU": (OUR_COLOUR, "s", "--"),
    "kernel alone": (OUR_COLOUR, ".", ":"),
    "SciPy DOP853": (BLUE, "s", "-"),
    "numbalsoda DOP853": (GREEN, "D", "-"),
    "CVODE Adams": (PURPLE, "v", "-"),
    "heyoka": (BLACK, "^", "-"),
}
"""Colour, mark and line of each contender."""


def look(name: str) -> dict[str, Any]:
    """Return the style of a contender's curve."""
    return strong(name == "chain-impact", *LOOKS[name])


def strong(is_ours: bool, colour: Any, marker: str, line: str = "-") -> dict[str, Any]:
    """Return the style of a curve; our own is bolder than the others, and drawn above them."""
    bold = {"linewidth": 2.4, "zorder": 3} if is_ours else {"linewidth": 1.2, "zorder": 2}
    return {"color": colour, "marker": marker, "linestyle": line, "markersize": 4.5, **bold}


def name_curves(figure: Any, panels: Sequence[Any]) -> None:
    """Write the name of each labelled curve once, beside a point of the curve in one of the panels.

    Curves without a free place for their name (``free_places``) have a key below the panels. The figure
    must have all other texts before, and its layout must not change after that.
    """
    lines = {line.get_label(): line for axes in panels for line in axes.lines}
    names = {label for label in lines if not label.startswith("_")}
    figure.draw_without_rendering()
    while unnamed := sorted(names - free_places(panels, names).keys()):
        add_keys(figure, [lines[label] for label in unnamed])
        names -= {*unnamed}
        figure.draw_without_rendering()  # the keys need room, which moves the curves
    places = free_places(panels, names)
    figure.set_layout_engine("none")
    look: dict[str, Any] = {"xycoords": "figure pixels", "textcoords": "offset points"}
    look |= {"ha": "center", "va": "center", "fontsize": "small", "in_layout": False, "path_effects": HALO}
    for label, (axes, point, shift, _) in places.items():
        colour = tuple(DARKENED * np.array(to_rgb(lines[label].get_color())))
        axes.annotate(label, point, shift, color=colour, **look)


def add_keys(figure: Any, lines: Sequence[Any]) -> None:
    """Add keys of curves to the legend below the panels, or make this legend."""
    keys = [*lines]
    if figure.legends:
        (legend,) = figure.legends
        keys += [key for key in legend.legend_handles if key is not None]
        legend.remove()
    figure.legend(handles=keys, loc="outside lower center", ncols=len(keys))


def free_places(panels: Sequence[Any], names: Container[str]) -> dict[str, Place]:
    """Return a place for the name of each curve in ``names`` that has a free place beside it.

    A free place overlaps no text, bar or curve, and is nearer to its own curve than to others, by CLEAR or as
    much as possible at the least of the OFFSETS with a free place. Of equal places the first one is taken.
    """
    panel_curves = [[(line, samples(line)) for line in axes.lines] for axes in panels]
    boxes = [text.get_window_extent() for axes in panels for text in axes.texts]
    boxes += [bar for axes in panels for collection in axes.collections for bar in extents(collection)]
    panel_counts = Counter(line.get_label() for curves in panel_curves for line, _ in curves)
    name_places: dict[str, Place] = {}
    for label in sorted(panel_counts, key=lambda name: (panel_counts[name], -len(name))):
        for offset in OFFSETS if label in names else ():
            places = [
                (min(CLEAR * axes.figure.dpi, clearance(place[3], line, curves, boxes)), place)
                for axes, curves in zip(panels, panel_curves, strict=True)
                for line, points in curves
                if line.get_label() == label
                for place in places_beside(axes, line, points, offset)
            ]
            margin, place = max(places, key=lambda entry: entry[0], default=(0.0, None))
            if place is not None and margin > 0.0:
                name_places[label] = place
                boxes.append(place[3])
                break
    return name_places


def extents(collection: Any) -> list[Bbox]:
    """Return the rectangle of each line of a collection, such as bars of ranges [pixels]."""
    transform, half = collection.get_transform(), 0.5 * collection.axes.figure.dpi / 72.0
    widths = cycle(half * width for width in collection.get_linewidths())
    boxes = (transform.transform_path(path).get_extents() for path in collection.get_paths())
    return [box.padded(width) for box, width in zip(boxes, widths, strict=False)]


def samples(line: Any) -> np.ndarray:
    """Return points of a curve in small steps, shape (S, 2) [pixels]."""
    points = line.get_transform().transform(np.column_stack(line.get_data()))
    points = points[np.isfinite(points).all(axis=1)]
    steps = np.linspace(0.0, 1.0, SAMPLES)[:, np.newaxis]
    return np.concatenate(
        [points[:1], *(first + steps * (second - first) for first, second in pairwise(points))]
    )


def clearance(
    box: Bbox, own_line: Any, curves: Iterable[tuple[Any, np.ndarray]], boxes: Iterable[Bbox]
) -> float:
    """Return how much nearer a rectangle is to its own curve than to others [pixels].

    The result is −infinity if the rectangle overlaps a curve or one of the rectangles ``boxes``.
    """
    distances = {False: np.inf, True: np.inf}
    for line, points in curves:
        if len(points):
            gaps = np.maximum(np.maximum(box.min - points, points - box.max), 0.0)
            is_own = line is own_line
            distances[is_own] = min(distances[is_own], float(np.hypot(*gaps.T).min()))
    least_distance = OVERLAP * own_line.figure.dpi / 72.0
    if min(distances.values()) < least_distance or any(box.overlaps(other_box) for other_box in boxes):
        return -np.inf
    return distances[False] - distances[True]


def places_beside(axes: Any, line: Any, points: np.ndarray, offset: float) -> Iterator[Place]:
    """Yield places of a name at a distance ``offset`` [points] from points of its curve."""
    probe = axes.text(0.0, 0.0, line.get_label(), fontsize="small", in_layout=False)
    size, pixel = probe.get_window_extent().size, axes.figure.dpi / 72.0
    probe.remove()
    for point, side in product(points[:: SAMPLES // 6], np.array(SIDES)):
        shift = side * (offset * pixel + 0.5 * size)
        box = Bbox([point + shift - 0.5 * size, point + shift + 0.5 * size])
        edge = OVERLAP * pixel
        if (box.min >= axes.bbox.min + edge).all() and (box.max <= axes.bbox.max - edge).all():
            yield axes, point, shift / pixel, box
