"""The shapes that drawings show: outlines of links that have points besides their ends; a slider's rail."""

from __future__ import annotations

import math
from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass
from itertools import count, takewhile
from typing import Any

import numpy as np

from chain_impact.kernel.chain.inertia import corner_of_box
from chain_impact.scene.chain_tables import CORNERS
from chain_impact.scene.half_planes import HalfPlane
from chain_impact.scene.names import SLIDER_STOPS

CIRCLE_CORNERS = 24  # number of corners of the polygon that is drawn for each circle
# half the length of the mark of a slider's stop, and of the drawn carriage, relative to ``Rail.size``
STOP_MARK = 0.06
# length of the drawn line beyond the outermost positions of the base, on a side without a stop, relative to
# ``Rail.size``
FREE_END = 0.12
# [1] corners of the drawn carriage: coordinates along the slider's line and to its left, relative to
# ``Rail.half``
CARRIAGE = np.array([[-1.0, -0.5], [1.0, -0.5], [1.0, 0.5], [-1.0, 0.5]])
Disc = tuple[float, float, float]
"""A disc as three numbers [m]: its centre's coordinates along a link and to the link's left, and its
radius."""


def outline(discs: Iterable[Disc]) -> np.ndarray:
    """Return the corners of the convex hull of discs, anticlockwise, shape (C, 2) [m] (Andrew, 1979)."""
    turn = math.tau / CIRCLE_CORNERS
    rims = [
        (x + radius * math.cos(k * turn), y + radius * math.sin(k * turn))
        for x, y, radius in discs
        for k in range(CIRCLE_CORNERS if radius > 0.0 else 1)
    ]
    corners = sorted(set(rims))
    return np.array([*_half(corners), *_half(corners[::-1])] or corners)


def _half(corners: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return one half of a convex hull, from the first of the sorted corners to the last one.

    The last corner is left out, because the other half begins with it.
    """
    hull: list[tuple[float, float]] = []
    for x, y in corners:
        while len(hull) > 1:
            (ax, ay), (bx, by) = hull[-2:]
            if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0.0:
                break
            hull.pop()
        hull.append((x, y))
    return hull[:-1]


def discs_of_links(values: Mapping[str, Any]) -> dict[int, list[Disc]]:
    """Return number of a link → the discs of its points other than its ends, for each link with such points.

    The centres of the discs are in the link's axes. The discs have the order of the points' numbers, so the
    corners of a box come first.
    """
    discs_of: dict[int, list[Disc]] = {}
    for link in takewhile(lambda n: f"link[{n}].length" in values, count(1)):
        discs: list[Disc] = []
        if (height := values.get(f"link[{link}].height")) is not None:
            length = values[f"link[{link}].length"]
            corners = (corner_of_box(n, length, height) for n in range(1, CORNERS + 1))
            discs = [(x, y, values.get("contact.radius", 0.0)) for x, y in corners]
        names = (f"link[{link}].point[{n}]" for n in count(len(discs) + 1))
        for of in takewhile(lambda site: f"{site}.x" in values, names):
            x, y, radius = (float(values[f"{of}.{key}"]) for key in ("x", "y", "radius"))
            discs.append((x, y, radius))
        if discs:
            discs_of[link] = discs
    return discs_of


def outlines_from(values: Mapping[str, Any], touching: Container[int]) -> dict[int, np.ndarray]:
    """Return number of a link → its outline in the link's axes, shape (C, 2) [m], for each link with points.

    Args:
        values: name of a parameter → value.
        touching: the numbers of the points that can touch a wall; an end of a link has the radius
            ``contact.radius`` if it is one of these points, else 0.
    """
    radius, outlines = values.get("contact.radius", 0.0), {}
    for n, discs in discs_of_links(values).items():
        near, far = (radius if end in touching else 0.0 for end in (n - 1, n))
        outlines[n] = outline([(0.0, 0.0, near), (float(values[f"link[{n}].length"]), 0.0, far), *discs])
    return outlines


def placed(corners: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return the positions in space, shape (C, 2) [m], of corners that are given in the axes of a link.

    Args:
        corners: x along the link and y to its left, shape (C, 2) [m].
        start: the end of the link that is nearer to the base, shape (2,) [m].
        end: the other end, shape (2,) [m].
    """
    along = (end - start) / np.hypot(*(end - start))
    return np.asarray(start + corners @ [along, [-along[1], along[0]]])


def size_of_motion(points: np.ndarray) -> float:
    """Return the longer side [m] of the smallest upright rectangle around positions, shape (T, P, 2) [m]."""
    return float(np.ptp(points, axis=(0, 1)).max())


@dataclass(frozen=True, slots=True)
class Rail:
    """The line along which a base slides.

    Attributes:
        origin: the point of the line with the position 0, shape (2,) [m].
        angle: direction of the line, from +x [rad].
        low: the least position [m]; −∞ without a stop.
        high: the largest position [m]; ∞ without a stop.
        size: the longer side of the rectangle around the motion of all points [m]; the drawn carriage and
            marks of stops are in proportion to ``size``.
    """

    origin: np.ndarray
    angle: float
    low: float
    high: float
    size: float

    @classmethod
    def between(
        cls, origin: np.ndarray, angle: float, low: float | None, high: float | None, size: float
    ) -> Rail:
        """Return the line that ends at ``low`` and ``high`` [m], or has no stop where one of them is None."""
        ends = (-math.inf if low is None else low, math.inf if high is None else high)
        return cls(origin, angle, *ends, size)

    @property
    def direction(self) -> np.ndarray:
        """The unit vector along the line, shape (2,)."""
        return np.array([math.cos(self.angle), math.sin(self.angle)])

    @property
    def half(self) -> float:
        """Half the length of the carriage that is drawn [m]."""
        return STOP_MARK * self.size

    @property
    def stops(self) -> dict[str, HalfPlane]:
        """The half-plane of each existing stop, by the stop's name, in which the drawn carriage lies.

        ``low`` and ``high`` are the positions of the carriage's middle at which it meets the stops, so the
        edge of a half-plane is half a carriage beyond ``low`` or ``high``.
        """
        (x, y), start = self.direction, float(self.origin @ self.direction)
        low, high = start + self.low - self.half, start + self.high + self.half
        planes = (HalfPlane((x, y), low), HalfPlane((-x, -y), -high))
        stops = zip(SLIDER_STOPS, planes, strict=True)
        return {name: plane for name, plane in stops if math.isfinite(plane.offset)}

    def lines(self, bases: np.ndarray) -> list[np.ndarray]:
        """Return the line segments to draw: the slider's line, then a mark across it for each existing stop.

        Each segment is an array of its two ends, shape (2, 2) [m].

        Args:
            bases: the positions of the base, shape (T, 2) [m]; on a side without a stop, they tell how far
                the line is drawn.
        """
        along, across = self.direction, np.array([-math.sin(self.angle), math.cos(self.angle)])
        reached = (bases - self.origin) @ along
        free = FREE_END * self.size
        ends = [(self.low - self.half, reached.min() - free), (self.high + self.half, reached.max() + free)]
        positions = [self.origin + (stop if math.isfinite(stop) else free) * along for stop, free in ends]
        ticks = [
            end + self.half * np.array([-across, across])
            for end, (stop, _) in zip(positions, ends, strict=True)
            if math.isfinite(stop)
        ]
        return [np.array(positions), *ticks]

    def carriage(self, base: np.ndarray) -> np.ndarray:
        """Return the corners of the carriage for a position of the base, shape (4, 2) [m]."""
        along, across = self.direction, np.array([-math.sin(self.angle), math.cos(self.angle)])
        return np.asarray(base + self.half * CARRIAGE @ [along, across])


def rail_from(points: np.ndarray, positions: np.ndarray | None, values: Mapping[str, Any]) -> Rail | None:
    """Return the line of a slider; None if ``values`` has no ``slider.angle`` and ``positions`` is None.

    Then there is no slider, or nothing tells the direction of its line.

    Args:
        points: the positions of all points, of which the first is the base, shape (T, P, 2) [m].
        positions: the outputs ``slider.position``, shape (T,) [m]; None if they are not known.
        values: name of a parameter → value.
    """
    bases = points[:, 0]
    if "slider.angle" in values:
        angle = float(values["slider.angle"])
    # without slider.angle, two positions of the base tell the direction: from the least to the largest
    # ``slider.position``
    elif positions is not None:
        x, y = bases[positions.argmax()] - bases[positions.argmin()]
        angle = math.atan2(y, x)
    else:
        return None
    along = np.array([math.cos(angle), math.sin(angle)])
    first = 0.0 if positions is None else float(positions[0])
    stops = values.get("slider.min"), values.get("slider.max")
    return Rail.between(bases[0] - first * along, angle, *stops, size_of_motion(points))
