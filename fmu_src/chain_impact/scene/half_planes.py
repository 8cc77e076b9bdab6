"""Walls as half-planes, for checks and pictures.

The kernel computes its own half-planes in constraints/geometry.py.
The twin in JavaScript is pages/browser/scene/geometry.js.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from chain_impact.kernel.constraints.geometry import BOX_NORMALS
from chain_impact.kernel.record.constants import WALLS


@dataclass(frozen=True, slots=True)
class HalfPlane:
    """The free side of a wall: all positions p with n·p ≥ offset.

    Attributes:
        normal: n, the unit vector at right angles to the wall, into the free side.
        offset: n·p for positions p on the wall [m]: the distance of the wall from the origin, negative if the
            origin is on the free side.
    """

    normal: tuple[float, float]
    offset: float

    def clearance(self, x: float, y: float) -> float:
        """Return the distance [m] of the position (x, y) from the wall; negative beyond the wall."""
        return self.normal[0] * x + self.normal[1] * y - self.offset


def half_planes(
    box: Mapping[str, float], slopes: Mapping[str, tuple[float, float, float]]
) -> dict[str, HalfPlane]:
    """Return the half-plane on the free side of each wall, by name and in the order of the walls' numbers.

    Args:
        box: the existing walls of the box: name → position [m].
        slopes: the walls at any angle: name → x [m] and y [m] of a point on the wall, and the wall's angle
            [rad].
    """
    planes = {}
    for name, (nx, ny) in zip(WALLS, BOX_NORMALS, strict=True):
        if name in box:
            planes[name] = HalfPlane((nx, ny), (nx + ny) * box[name])
    for name, (x, y, angle) in slopes.items():
        nx, ny = -math.sin(angle), math.cos(angle)
        planes[name] = HalfPlane((nx, ny), nx * x + ny * y)
    return planes


def direction(normal: tuple[float, float]) -> float:
    """Return the angle [rad] from +x of a wall's direction, which has the wall's free side at its left.

    ``normal`` is a vector of any length > 0 into the free side. The angle is from −π to π.
    """
    # adding 0.0 turns the angle −0 into 0, so that it is written without a sign
    return math.atan2(-normal[0], normal[1]) + 0.0
