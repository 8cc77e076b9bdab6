"""The candidates of a scene: the pairs of a point and a wall that can touch, and the stops in joints."""

from __future__ import annotations

from itertools import product

from chain_impact.kernel.rows.geometry import WALLS
from chain_impact.scene.scene import Scene


def candidates(scene: Scene) -> list[tuple[int, int]]:
    """The pairs (point, index into ``scene.wall_names``) that can touch: listed points, existing walls.

    Then come the stops, as pairs (joint, index into ``scene.wall_names``); joints are numbered as links are.
    """
    pairs = point_wall_pairs(scene)
    # its values are given where there are stops
    return pairs if scene.stops.exponent is None else [*pairs, *stop_pairs(scene)]


def places(scene: Scene) -> list[str]:
    """What a simulation may be refused for, in words: each candidate, and then each link."""
    names, points = scene.wall_names, len(point_wall_pairs(scene))
    pairs = candidates(scene)
    touching = [f"point {point} at the wall {names[wall]}" for point, wall in pairs[:points]]
    stops = [f"joint {joint} at its {names[wall]}" for joint, wall in pairs[points:]]
    return [*touching, *stops, *(f"link[{i + 1}]" for i in range(len(scene.chain.links)))]


def stop_pairs(scene: Scene) -> list[tuple[int, int]]:
    """The stops, as pairs (joint, index into ``scene.wall_names``)."""
    names = scene.wall_names
    return [(joint, names.index(stop)) for joint, stop in scene.chain.stops]


def point_wall_pairs(scene: Scene) -> list[tuple[int, int]]:
    """The pairs of a point and a wall that can touch."""
    walls = [w for w, name in enumerate(WALLS) if getattr(scene.box, name) is not None]
    walls += range(len(WALLS), len(WALLS) + len(scene.walls))
    return list(product(scene.contact.points, walls))
