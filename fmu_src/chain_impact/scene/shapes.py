"""Links that are boxes: their first four points are the corners, which follow from length and height.

A ``Scene`` has the corners among the points of its links. The scene's file and plain data do not have them,
so that a change of length or height moves the corners. The kernel, too, derives the corners from the
parameters.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from chain_impact.kernel.chain.inertia import corner_of_box
from chain_impact.scene.contents import AnyScene, SceneContents
from chain_impact.scene.errors import SceneError
from chain_impact.scene.keys.chain_tables import BOX_CORNERS, Site
from chain_impact.scene.texts.names import DataPath

_CORNER = object()
"""The mark that stands in plain data for a corner of a box, which follows from length and height."""


def with_shapes(scene: AnyScene) -> AnyScene:
    """Return the scene in which the points of each link that is a box begin with the box's four corners."""
    links = []
    for link in scene.chain.links:
        if link.height is None:
            links.append(link)
            continue
        positions = (corner_of_box(number, link.length, link.height) for number in range(1, BOX_CORNERS + 1))
        corners = (Site(x=x, y=y, radius=None) for x, y in positions)
        links.append(replace(link, points=(*corners, *link.points)))
    return replace(scene, chain=replace(scene.chain, links=tuple(links)))


def set_corners_apart(data: Any, *, are_given: bool = False) -> None:
    """Replace each corner of a box in ``data``, the plain data of a scene, by the mark ``_CORNER``.

    If ``are_given`` is true, the corners become given points instead: they stay, and the keys ``shape`` and
    ``height`` of each box are removed.
    """
    for link in data["chain"]["links"]:
        if "shape" not in link:
            continue
        if are_given:
            del link["shape"], link["height"]
        else:
            link["points"][:BOX_CORNERS] = [_CORNER] * BOX_CORNERS


def without_corners(data: Any) -> Any:
    """Remove the marks ``_CORNER`` from ``data``, the plain data of a scene, and return ``data``."""
    chain = data["chain"]
    links = chain.get("links") if isinstance(chain, Mapping) else None
    for link in links if isinstance(links, list) else ():
        if isinstance(link, dict) and isinstance(points := link.get("points"), list):
            link["points"] = [point for point in points if point is not _CORNER]
    return data


def scene_point_path(path: DataPath, data: Any) -> DataPath:
    """Return the path in the scene of the value that has ``path`` in ``data``, the scene's plain data.

    In the scene, the first points of a box are its corners, which the plain data do not have. So the index of
    any other point of a box is larger in the scene by BOX_CORNERS.
    """
    match path:
        case "chain", "links", int(i), "points", int(j), *following if "shape" in data["chain"]["links"][i]:
            return ("chain", "links", i, "points", j + BOX_CORNERS, *following)
    return path


def refuse_corner(scene: SceneContents, path: DataPath) -> None:
    """Refuse a path in the scene that leads to a corner of a box, because no corner can be changed alone.

    As in Python, an index below 0 counts from the end of a list.
    """
    links = scene.chain.links
    match path:
        case "chain", "links", int(i), "points", int(j), *_ if -len(links) <= i < len(links):
            link = links[i]
            k = j + len(link.points) if j < 0 else j
            if 0 <= k < link.corners:
                link_name = f"link[{i % len(links) + 1}]"
                sizes_text = f"{link_name}.length and {link_name}.height"
                remedy = "to move it alone, give points in place of the shape"
                reason = f"is a corner of a box, which follows from {sizes_text}: {remedy}"
                raise SceneError(f"{scene.name}: {link_name}.point[{k + 1}] {reason}")
