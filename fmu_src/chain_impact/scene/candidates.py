"""The candidates of a scene: the pairs of a point and a wall that can touch."""

from __future__ import annotations

from chain_impact.kernel.model.geometry import WALLS
from chain_impact.scene.scene import Scene


def candidates(scene: Scene) -> list[tuple[int, int]]:
    """The pairs (point, index into ``scene.wall_names``) that can touch: listed points, existing walls."""
    walls = [w for w, name in enumerate(WALLS) if getattr(scene.box, name) is not None]
    walls += range(len(WALLS), len(WALLS) + len(scene.walls))
    return [(point, wall) for point in scene.contact.points for wall in walls]
