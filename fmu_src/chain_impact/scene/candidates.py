"""The candidates of a scene: the pairs of a point and a wall that can touch, and the stops in joints."""

from __future__ import annotations

import math
from itertools import product

from chain_impact.kernel.rows.geometry import WALLS
from chain_impact.scene.scene import Scene
from chain_impact.scene.tables import Site

PARALLEL = 1e-12  # the cosine between a slider's line and a wall's normal that counts as 0: round-off


def candidates(scene: Scene) -> list[tuple[int, int]]:
    """The pairs (point, index into ``scene.wall_names``) that can touch: listed points, existing walls.

    Then come the stops, as pairs (joint, index into ``scene.wall_names``); joints are numbered as links are.
    Those of a slider are at point 0.
    """
    pairs, names = point_wall_pairs(scene), scene.wall_names
    # its values are given where there are stops
    joints = [] if scene.stops.exponent is None else stop_pairs(scene)
    return [*pairs, *joints, *((0, names.index(stop)) for stop in scene.slider_stops)]


def places(scene: Scene) -> list[str]:
    """Return the words for all places at which a simulation can be refused.

    These are the candidates, the links, and the base at the wall of each pair of a point and a wall.
    """
    names, points = scene.wall_names, len(point_wall_pairs(scene))
    pairs = candidates(scene)
    touching = [f"{scene.point_label(point)} at the wall {names[wall]}" for point, wall in pairs[:points]]
    stops = [
        f"joint {joint} at its {names[wall]}" if joint else f"the slider at its {names[wall]}"
        for joint, wall in pairs[points:]
    ]
    links = [f"link[{i + 1}]" for i in range(len(scene.chain.links))]
    return [*touching, *stops, *links, *(f"the base at the wall {names[wall]}" for _, wall in pairs[:points])]


def stop_pairs(scene: Scene) -> list[tuple[int, int]]:
    """The stops, as pairs (joint, index into ``scene.wall_names``)."""
    names = scene.wall_names
    return [(joint, names.index(stop)) for joint, stop in scene.chain.stops]


def point_wall_pairs(scene: Scene) -> list[tuple[int, int]]:
    """The pairs of a point and a wall that can touch: listed joints and all points of links that can move."""
    walls = [w for w, name in enumerate(WALLS) if getattr(scene.box, name) is not None]
    walls += range(len(WALLS), len(WALLS) + len(scene.walls))
    pairs = product((*scene.contact.points, *movable_sites(scene)), walls)
    return [(point, wall) for point, wall in pairs if not keeps_distance(scene, point, wall)]


def keeps_distance(scene: Scene, point: int, wall: int) -> bool:
    """Whether a point slides along a line that is parallel to a wall, so that it never reaches it."""
    slider, sites = scene.chain.slider, scene.chain.sites
    behind = point - len(scene.chain.links) - 1
    at_base = point == 0 or (behind >= 0 and sites[behind][0] == 0 and is_at_joint(sites[behind][1]))
    if slider is None or not at_base:
        return False
    normal = list(scene.half_planes.values())[[*scene.half_planes].index(scene.wall_names[wall])].normal
    across = normal[0] * math.cos(slider.angle) + normal[1] * math.sin(slider.angle)
    return abs(across) < PARALLEL


def is_at_joint(site: Site) -> bool:
    """Whether a point of a link lies at the joint nearer to the base."""
    return site.x == site.y == 0.0


def movable_sites(scene: Scene) -> list[int]:
    """The numbers of the points of links that can move: all but those at a pinned base."""
    first, pinned = len(scene.chain.links) + 1, scene.chain.base == "pinned"
    sites = enumerate(scene.chain.sites, first)
    return [k for k, (link, site) in sites if not (pinned and link == 0 and is_at_joint(site))]
