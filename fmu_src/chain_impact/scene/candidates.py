"""The candidates of a scene: the pairs of a point and a wall that can touch."""

from __future__ import annotations

from chain_impact.kernel.model.geometry import WALLS
from chain_impact.scene.scene import Scene


def candidates(scene: Scene) -> list[tuple[int, int]]:
    """The pairs (point, index into ``scene.wall_names``) that can touch: listed points, existing walls."""
    there = scene.half_planes
    walls = [w for w, name in enumerate(scene.wall_names) if name in there]
    return [(point, wall) for point in scene.contact.points for wall in walls]


def candidate_count(scene: Scene) -> int:
    """How many candidates there are."""
    box = sum(getattr(scene.box, name) is not None for name in WALLS)
    return len(scene.contact.points) * (box + len(scene.walls))
