"""Bodies in pictures: outlines of links, points of links, discs at ends, and a sliding base with its line."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from matplotlib.patches import Circle, Polygon

from chain_impact.pictures.drawing.colours import INK
from chain_impact.recording.recording import Recording
from chain_impact.scene.display.outlines import placed_corners

FILL = 0.13  # the opacity of the area inside the outline of a body, from 0 to 1
SITE = 3.0  # [points] the size of the mark for a point of a link
CARRIAGE = 0.5  # the opacity of the area inside the outline of a carriage, from 0 to 1


def draw_bodies(axes: Axes, recording: Recording, row: int, colour: Any, *, linewidth: float) -> None:
    """Draw the bodies in one row of the recording: outlines and points of links, discs, and the carriage.

    A disc is drawn at an end of a link that can touch with a known radius > 0, if no link with an outline
    begins or ends there.
    """
    points, sites = recording.points[row], recording.sites[row]
    style = body_look(colour) | {"linewidth": linewidth, "zorder": 3.4}
    for link, corners in recording.outlines.items():
        axes.add_patch(Polygon(placed_corners(corners, points[link - 1], points[link]), **style))
    for end, radius in recording.touching_radii.items():
        if radius > 0.0 and end < len(points) and not {end, end + 1} & recording.outlines.keys():
            axes.add_patch(Circle(points[end], radius, **style))
    if len(sites):
        axes.plot(*sites.T, "o", color=colour, markersize=SITE, zorder=3.9)
    if recording.rail:
        corners = recording.rail.carriage(points[0])
        style = {"facecolor": (*to_rgb(colour), CARRIAGE), "edgecolor": colour, "linewidth": linewidth}
        axes.add_patch(Polygon(corners, **style, zorder=3.4))


def body_look(colour: Any) -> dict[str, Any]:
    """Return the properties of a body's outline, with matplotlib's names."""
    return {"facecolor": (*to_rgb(colour), FILL), "edgecolor": colour, "joinstyle": "round"}


def draw_rail(axes: Axes, recording: Recording) -> list[LineCollection]:
    """Draw the line of a slider with its stops, and return the drawn lines; [] without a slider."""
    if not recording.rail:
        return []
    lines = recording.rail.lines(recording.points[:, 0])
    label = "slider, stops" if recording.rail.stops else "slider"
    rail_lines = LineCollection(lines, colors=INK, linewidths=1.2, capstyle="round", zorder=2.5, label=label)
    axes.add_collection(rail_lines, autolim=False)
    return [rail_lines]
