"""A small SVG drawing of a scene for a notebook: the chain at its start, and the walls."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from chain_impact.scene.contents import SceneContents
from chain_impact.scene.display.outlines import outlines_from, placed_corners, rail_from

LONGER_SIDE = 240  # number of pixels of the longer side of the drawing
# both divided by the longer side of the rectangle around all points, or by contact.radius if this is larger:
# SCENE_MARGIN is the width of the free border inside the drawing; a wall is drawn if its distance from the
# point nearest to it is at most DRAWN_WITHIN
SCENE_MARGIN, DRAWN_WITHIN = 0.15, 1.0
# lengths divided by the longer side of the drawing
LINK_WIDTH = 0.012  # the width of links
THIN_WIDTH = 0.004  # the width of other lines
POINT_RADIUS = 0.02  # the radius of points


def scene_svg(scene: SceneContents, values: Mapping[str, Any]) -> str:
    """Return the text of an SVG element: a scene at its start, in the page's text colour.

    The drawing shows the chain, the outlines of links that have additional points, the rail and the carriage
    of a slider, and the near walls.

    ``values``: name of a value of the scene → value (``Scene.values``).
    """
    positions = np.array([point[:2] for point in scene.start.values()])
    points = positions[: len(scene.chain.links) + 1]
    size = max(np.ptp(positions, axis=0).max(), scene.contact.radius, 1e-6)
    rail = rail_from(positions[None], None, values)
    lines = rail.lines(points[:1]) if rail else []
    outlines = outlines_from(values, scene.contact.points)
    bodies = [placed_corners(corners, points[n - 1], points[n]) for n, corners in outlines.items()]
    bodies += [rail.carriage(points[0])] if rail else []
    nearest_points = [
        (wall, positions - np.outer(positions @ wall.normal - wall.offset, wall.normal))
        for wall in scene.walls_at_start.values()
    ]
    near_walls = [
        (wall, feet)
        for wall, feet in nearest_points
        if np.hypot(*(positions - feet).T).min() <= DRAWN_WITHIN * size
    ]
    shown_points = np.concatenate([positions, *bodies, *(feet for _, feet in near_walls)])
    low, high = shown_points.min(axis=0) - SCENE_MARGIN * size, shown_points.max(axis=0) + SCENE_MARGIN * size
    width, height = high - low
    reach, scale = width + height, LONGER_SIDE / max(width, height)
    line, dot = (f"{part * max(width, height):.6g}" for part in (LINK_WIDTH, POINT_RADIUS))
    parts = []
    for wall, feet in near_walls:
        normal, foot = np.array(wall.normal), feet[0]
        half_line = reach * np.array([normal[1], -normal[0]])
        corners = [
            foot - half_line,
            foot + half_line,
            foot + half_line - reach * normal,
            foot - half_line - reach * normal,
        ]
        parts.append(f'<polygon points="{_points_text(corners)}" fill="currentColor" fill-opacity="0.2"/>')
    look_text = f'fill="none" stroke="currentColor" stroke-width="{line}"'
    thin_text = f'stroke="currentColor" stroke-width="{THIN_WIDTH * max(width, height):.6g}"'
    parts += [f'<polyline points="{_points_text(polyline)}" fill="none" {thin_text}/>' for polyline in lines]
    parts += [f'<polygon points="{_points_text(body)}" fill-opacity="0.2" {thin_text}/>' for body in bodies]
    parts.append(f'<polyline points="{_points_text(points)}" {look_text}/>')
    parts += [f'<circle cx="{x:.6g}" cy="{-y:.6g}" r="{dot}"/>' for x, y in positions]
    view_text = f"{low[0]:.6g} {-high[1]:.6g} {width:.6g} {height:.6g}"
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{view_text}" width="{scale * width:.0f}" '
        f'height="{scale * height:.0f}" fill="currentColor" stroke-linejoin="round">{"".join(parts)}</svg>'
    )


def _points_text(points: np.ndarray | list[np.ndarray]) -> str:
    """Return points, shape (C, 2) [m], as the text "x,−y x,−y …" for SVG, whose y axis points downward."""
    return " ".join(f"{x:.6g},{-y:.6g}" for x, y in points)
